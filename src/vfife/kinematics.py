"""Position, velocity, acceleration and reaction analysis of planar rigid bodies joined by ideal pins.

A body's motion is (x, y, theta) of its centre of mass, in m and rad.  Inside this module every coordinate is a
length, (x, y, l theta) with l the body's own reach, so that one tolerance judges translations and turns alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

RANK_TOLERANCE = 1e-7  # a dead centre is only met to the root of round-off, so it must be judged this loosely
CLOSED = 1e-12  # largest open distance of a closed loop, in parts of the extent of the bodies
LARGEST_TURN = 0.1  # rad a body may turn in one step: longer steps can jump to the other branch
DRIVE_WEIGHT = 30.0  # a loop that cannot close must show its gap at the pins, not as a false driven angle
STEPS = 400


class AssemblyError(ValueError):
    """No position or motion satisfies the pins and drives.

    `joints` are the names of the pins that fail; `gaps` are their open distances in m (empty for a motion).
    """

    def __init__(self, message: str, joints: Sequence[str] = (), gaps: Sequence[float] = ()) -> None:
        super().__init__(message)
        self.joints = tuple(joints)
        self.gaps = tuple(gaps)


@dataclass(frozen=True, eq=False)
class Pin:
    """Ideal revolute joint: point_a (2,) of body_a lies on point_b (2,) of body_b.

    Points are in m, in the body's own axes, from its centre of mass (for the ground, body 0: from the origin).
    """

    name: str
    body_a: int
    point_a: ArrayLike
    body_b: int
    point_b: ArrayLike


@dataclass(frozen=True)
class Drive:
    """Prescribed angle (rad), angular velocity (rad/s) and angular acceleration (rad/s2) of a body at the instant."""

    body: int
    angle: float
    speed: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True, eq=False)
class RigidSystem:
    """Rigid bodies, their pins and their drives; body 0 is the ground, at the origin with angle 0.

    mass [n] in kg and inertia [n] about the centre of mass in kg m2; entry 0 is ignored.  `reach` [n] in m is the
    larger of the radius of gyration and the farthest pin of each body.  Raises ValueError on inconsistent input.
    """

    names: tuple[str, ...]
    mass: Array
    inertia: Array
    joints: Sequence[Pin]
    drives: Sequence[Drive] = ()
    reach: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        n = len(self.names)
        mass, inertia = np.asarray(self.mass, dtype=float), np.asarray(self.inertia, dtype=float)
        if mass.shape != (n,) or inertia.shape != (n,):
            raise ValueError(f"mass and inertia must have one entry for each of the {n} bodies")
        if not all(0.0 < value < np.inf for value in (*mass[1:], *inertia[1:])):
            raise ValueError("mass and inertia of every moving body must be finite and greater than zero")
        reach = np.ones(n)
        reach[1:] = np.sqrt(inertia[1:] / mass[1:])
        for pin in self.joints:
            bodies, points = (pin.body_a, pin.body_b), np.asarray([pin.point_a, pin.point_b], dtype=float)
            fits = len({*bodies} & {*range(n)}) == 2 and points.shape == (2, 2) and np.isfinite(points).all()
            if not fits:
                raise ValueError(f"joint {pin.name} must join a point (x, y) each of two different bodies out of {n}")
            for body, point in zip(bodies, points, strict=True):
                reach[body] = max(reach[body], float(np.hypot(*point)))
        driven = [drive.body for drive in self.drives]
        if any(not 0 < body < n for body in driven) or len(set(driven)) < len(driven):
            raise ValueError("each drive must turn a moving body of its own")
        if not np.isfinite([(drive.angle, drive.speed, drive.acceleration) for drive in self.drives]).all():
            raise ValueError("angle, speed and acceleration of every drive must be finite")
        for name, value in (("mass", mass), ("inertia", inertia), ("reach", reach)):
            object.__setattr__(self, name, value)


@dataclass(frozen=True, eq=False)
class Closure:
    """A closed position [n,3] (m, m, rad), its largest open distance `residual` (m) and the steps it took."""

    position: Array
    residual: float
    iterations: int


@dataclass(frozen=True)
class Mobility:
    """Degrees of freedom with the drives released (`free`) and locked, and the pins' redundant constraints.

    `redundant_joints` names the pins whose rows depend on those of the pins before them.
    """

    free: int
    after_drives: int
    redundant: int
    redundant_joints: tuple[str, ...]


def close(system: RigidSystem, guess: Array) -> Closure:
    """Return the closed position nearest the guess [n,3] (m, m, rad; row 0 is ignored).

    Damped Newton steps dq = -G^+ phi, of minimum norm in (x, y, l theta) and of at most 0.1 rad, whose damping
    vanishes with phi^2: redundant pins and free motions are both allowed.  A driven body ends at its drive's angle.
    Raises AssemblyError when pins stay open, naming them and their gaps, and ValueError on a bad guess.
    """
    start = _motion(system, guess, "guess")
    for drive in system.drives:
        start[drive.body, 2] += 2.0 * np.pi * np.round((drive.angle - start[drive.body, 2]) / (2.0 * np.pi))
    closure = _descend(system, start)
    if not _is_closed(system, closure):
        nudged = start.copy()
        nudged[1:, 2] += 0.5 * LARGEST_TURN * np.cos(np.arange(1, len(start)))
        raise _open_joints(system, closure, _is_closed(system, _descend(system, nudged)))
    return closure


def velocities(system: RigidSystem, position: Array, guess_velocity: Array | None = None) -> Array:
    """Return the velocity [n,3] (m/s, m/s, rad/s) that satisfies pins and drives at a closed position [n,3].

    G v = rate; of all such v the one with the least (v - v0)^T M (v - v0), v0 the guess [n,3] (default: rest).
    Raises AssemblyError when no velocity exists (a driven dead centre), ValueError on bad shapes.
    """
    position = _motion(system, position, "position")
    before = _motion(system, np.zeros_like(position) if guess_velocity is None else guess_velocity, "guess_velocity")
    _, jacobian, rate, _ = _rows(system, position, before)
    lengths, mass = _metric(system)
    inverse, null = _split(jacobian)
    motion = inverse @ rate
    root = np.sqrt(mass)
    change = root * (before[1:].ravel() * lengths - motion)
    motion = motion + null @ np.linalg.lstsq(root[:, None] * null, change, rcond=None)[0]
    _demand(system, jacobian @ motion - rate, motion, "velocity")
    return np.vstack([np.zeros(3), (motion / lengths).reshape(-1, 3)])


def accelerations(system: RigidSystem, position: Array, velocity: Array, force: Array) -> tuple[Array, Array, Array]:
    """Return acceleration [n,3] (m/s2, rad/s2), pin reactions [j,2] (N) and drive torques [d] (N m).

    M a = F + G^T lambda with G a = gamma; force [n,3] is (N, N, N m) at the centres of mass.  A reaction is the
    force of body_a on body_b; where pins are redundant, lambda is the solution of minimum norm.
    Raises AssemblyError when no acceleration exists (a dead centre, or a velocity that parts the pins), ValueError
    on bad shapes.
    """
    position, velocity = _motion(system, position, "position"), _motion(system, velocity, "velocity")
    _, jacobian, _, gamma = _rows(system, position, velocity)
    lengths, mass = _metric(system)
    load = _motion(system, force, "force")[1:].ravel() / lengths
    inverse, null = _split(jacobian)
    motion = inverse @ gamma
    motion = motion + null @ np.linalg.solve(null.T @ (mass[:, None] * null), null.T @ (load - mass * motion))
    _demand(system, jacobian @ motion - gamma, motion, "acceleration")
    multiplier = inverse.T @ (mass * motion - load)
    pins, driven = 2 * len(system.joints), [drive.body for drive in system.drives]
    acceleration = np.vstack([np.zeros(3), (motion / lengths).reshape(-1, 3)])
    return acceleration, multiplier[:pins].reshape(-1, 2), multiplier[pins:] * system.reach[driven]


def mobility(system: RigidSystem, position: Array) -> Mobility:
    """Count the instantaneous freedoms and redundant constraints at a closed position [n,3] (m, m, rad).

    free = 3(n-1) - rank(G of the pins); after_drives takes the drives' rows in; redundant = 2j - rank(G of the pins).
    Raises ValueError on bad shapes.
    """
    position = _motion(system, position, "position")
    jacobian = _rows(system, position, np.zeros_like(position))[1]
    (count, columns), pins = jacobian.shape, 2 * len(system.joints)
    ranks = {rows: int(np.linalg.matrix_rank(jacobian[:rows], RANK_TOLERANCE)) for rows in (*range(0, pins, 2), pins, count)}
    dependent = tuple(pin.name for k, pin in enumerate(system.joints) if ranks[2 * k + 2] - ranks[2 * k] < 2)
    return Mobility(columns - ranks[pins], columns - ranks[count], pins - ranks[pins], dependent)


def _rows(system: RigidSystem, position: Array, velocity: Array) -> tuple[Array, Array, Array, Array]:
    """Return phi [r] (m), G [r, 3(n-1)], the wanted G v [r] (m/s) and gamma = G a [r] (m/s2).

    Two rows a pin, phi = (r + A s)_b - (r + A s)_a and gamma = (w^2 A s)_b - (w^2 A s)_a, then one a drive,
    phi = l (theta - angle) and gamma = l times its acceleration.
    """
    pins = 2 * len(system.joints)
    count = pins + len(system.drives)
    phi, rate, gamma = np.zeros(count), np.zeros(count), np.zeros(count)
    jacobian = np.zeros((count, 3 * len(system.names)))
    for row, pin in zip(range(0, pins, 2), system.joints, strict=True):
        for sign, body, point in ((-1.0, pin.body_a, pin.point_a), (1.0, pin.body_b, pin.point_b)):
            c, s = np.cos(position[body, 2]), np.sin(position[body, 2])
            arm = np.array([[c, -s], [s, c]]) @ np.asarray(point, dtype=float)
            phi[row : row + 2] += sign * (position[body, :2] + arm)
            gamma[row : row + 2] += sign * velocity[body, 2] ** 2 * arm
            jacobian[row, 3 * body] = jacobian[row + 1, 3 * body + 1] = sign
            jacobian[row : row + 2, 3 * body + 2] = sign * np.array([-arm[1], arm[0]]) / system.reach[body]
    for row, drive in enumerate(system.drives, start=pins):
        length = system.reach[drive.body]
        phi[row] = length * (position[drive.body, 2] - drive.angle)
        jacobian[row, 3 * drive.body + 2] = 1.0
        rate[row], gamma[row] = length * drive.speed, length * drive.acceleration
    return phi, jacobian[:, 3:], rate, gamma


def _metric(system: RigidSystem) -> tuple[Array, Array]:
    """Return (1, 1, l) and (m, m, I / l^2) of each moving body [3(n-1)]."""
    reach, mass, inertia = system.reach[1:], system.mass[1:], system.inertia[1:]
    one = np.ones_like(reach)
    return np.column_stack([one, one, reach]).ravel(), np.column_stack([mass, mass, inertia / reach**2]).ravel()


def _split(jacobian: Array) -> tuple[Array, Array]:
    """Return the pseudo-inverse [c,r] and an orthonormal null space [c, c - rank] of the Jacobian [r,c]."""
    left, size, right = np.linalg.svd(jacobian)
    rank = int(np.sum(size > RANK_TOLERANCE))
    return right[:rank].T @ (left[:, :rank] / size[:rank]).T, right[rank:].T


def _descend(system: RigidSystem, position: Array) -> Closure:
    """Reduce |phi| from a position [n,3] until it is round-off or falls no more; the result may still be open."""
    lengths, scale = _metric(system)[0], system.reach[1:].max(initial=0.0)
    finest = np.finfo(float).eps * scale
    pins, driven = 2 * len(system.joints), [drive.body for drive in system.drives]
    weight = np.repeat([1.0, DRIVE_WEIGHT], [pins, len(driven)])
    limit = np.concatenate([np.full(pins, np.inf), LARGEST_TURN * system.reach[driven]])
    (phi, jacobian, _, _), damping, taken = _rows(system, position, position), 0.1, 0
    while taken < STEPS:
        error = np.clip(phi, -limit, limit)  # the drives advance no faster than the pins can follow
        if np.abs(error).max(initial=0.0) <= finest:
            break
        floor = damping * (error @ error) / scale**2
        step = _step(weight[:, None] * jacobian, weight * error, lengths, floor)
        if np.abs(step * lengths).max() <= finest:
            break
        taken += 1
        trial = position.copy()
        trial[1:] += step.reshape(-1, 3)
        tried = _rows(system, trial, trial)
        if np.linalg.norm(weight * (tried[0] - phi + error)) < np.linalg.norm(weight * error):
            position, (phi, jacobian, _, _), damping = trial, tried, max(damping / 4.0, 1e-6)
        else:
            damping *= 8.0
    return Closure(position, float(np.abs(phi).max(initial=0.0)), taken)


def _step(jacobian: Array, error: Array, lengths: Array, damping: float) -> Array:
    """Return -(G^T G + damping)^-1 G^T error as a step in (x, y, theta), its turns limited.

    A step somewhat too long is shortened, for that keeps its pins together; one far too long comes from a dead
    centre nearby, and is damped until the other directions get their part.
    """
    left, size, right = np.linalg.svd(jacobian, full_matrices=False)
    kept = size > RANK_TOLERANCE
    size, part = size[kept], left[:, kept].T @ error
    while True:
        step: Array = -(right[kept].T @ (size / (size**2 + damping) * part)) / lengths
        excess = np.abs(step[2::3]).max() / LARGEST_TURN
        if excess < 10.0:
            break
        damping *= 4.0
    step /= max(1.0, excess)
    return step


def _is_closed(system: RigidSystem, closure: Closure) -> bool:
    extent = max(system.reach[1:].max(initial=0.0), np.abs(closure.position[:, :2]).max())
    return bool(closure.residual <= CLOSED * extent)


def _open_joints(system: RigidSystem, closure: Closure, between_branches: bool) -> AssemblyError:
    """Return the error that names the open pins of a position, their gaps and the likely cause."""
    phi = _rows(system, closure.position, closure.position)[0][: 2 * len(system.joints)]
    gaps = np.hypot(phi[::2], phi[1::2]).tolist()
    gap_of = {pin.name: gap for pin, gap in zip(system.joints, gaps, strict=True) if gap > 1e-3 * max(gaps)}
    listed = ", ".join(f"{name} by {1e3 * gap:.4g} mm" for name, gap in gap_of.items())
    cause = f"the links joined by {', '.join(gap_of)} cannot reach one another: check their lengths and end points"
    if between_branches:
        cause = "a slightly turned guess does close, so the guess lies between two branches: draw it to one side"
    elif system.drives:
        cause += f", and the driven angle of {', '.join(system.names[drive.body] for drive in system.drives)}"
    message = f"joints stay open, {listed} ({1e3 * sum(gap_of.values()):.4g} mm together); {cause}"
    return AssemblyError(message, tuple(gap_of), tuple(gap_of.values()))


def _demand(system: RigidSystem, missing: Array, motion: Array, quantity: str) -> None:
    """Raise AssemblyError where G motion misses its wanted value by more than round-off."""
    missed = np.abs(missing) > RANK_TOLERANCE * max(np.abs(motion).max(initial=0.0), np.abs(missing).max(initial=0.0))
    if missed.any():
        joints = [pin.name for k, pin in enumerate(system.joints) if missed[2 * k : 2 * k + 2].any()]
        named = joints + [f"the drive of {system.names[drive.body]}" for drive in system.drives]
        cause = "the position is a dead centre, the drives disagree, or the velocity given parts the joints"
        raise AssemblyError(f"no {quantity} satisfies {', '.join(named)}: {cause}", joints)


def _motion(system: RigidSystem, value: Array, name: str) -> Array:
    """Return a copy [n,3] of an input with the ground's row at zero; raise ValueError on a bad shape or value."""
    motion = np.array(value, dtype=float)
    if motion.shape != (len(system.names), 3) or not np.isfinite(motion[1:]).all():
        raise ValueError(f"{name} must be finite and have shape ({len(system.names)}, 3), not {motion.shape}")
    motion[0] = 0.0
    return motion
