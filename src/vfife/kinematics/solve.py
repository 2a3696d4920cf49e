"""Position, velocity, acceleration and reaction analysis of planar rigid bodies with ideal joints and
prescribed motions.

A body's motion is (x, y, theta) of its centre of mass, in m and rad.  Inside this module every coordinate is
a length, (x, y, l theta) with l the body's own reach, so that one tolerance judges translations and turns
alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..numerics import dense
from ..numerics.elementwise import cos
from ..numerics.products import dot, norm
from .gathered import Gathered, closing_joint, parted
from .linalg import DENSE, RANK_TOLERANCE, DampedStep, Matrix, constrained, shared_out, times, weighted
from .system import RigidSystem, checked, equations, metric

Array = NDArray[np.float64]

Slopes = Callable[[Array], tuple[float, Array]]  # a place -> what is to be least, and its derivatives

NEWTON = 12
APART = 1e-6  # of the extent, of places whose slopes make a second derivative
THERE = 1e-9  # of the extent: a step that is none
ROUND = 1e-8  # of the largest curvature: less is rounding, or a free motion
LEVEL = 1e-6  # of the root of what is left: a slope that is none
FAR = 0.2  # of the extent: further away it is another bottom
MOST = 0.5  # of what is there now is left at the bottom, or more: else the way down has not come to an end


def bottom(slopes: Slopes, extent: float, count: int) -> Array | None:
    """How far the bottom lies from here, [count], where it is one: curved upwards, near, and no more than
    half as deep again; None where not.
    """
    here, (now, slope) = np.zeros(count), slopes(np.zeros(count))
    left = now
    for _ in range(NEWTON):
        curvature = np.column_stack(
            [slopes(here + change)[1] - slope for change in APART * extent * np.eye(count)]
        ) / (APART * extent)
        size, along = dense.eigh(0.5 * (curvature + curvature.T))
        if size[0] < -ROUND * size[-1]:
            return None
        curved = size > ROUND * size[-1]
        step = -times(along[:, curved] / size[curved], times(along[:, curved].T, slope))
        here = here + step
        left, slope = slopes(here)
        if left < MOST * now or np.abs(here).max() > FAR * extent:
            return None
        if np.abs(step).max() <= THERE * extent:
            return here if left <= now and np.abs(slope).max() <= LEVEL * math.sqrt(left) else None
    return None


LARGEST_TURN = 0.1  # rad a body may turn in one step: longer steps can jump to the other branch
DRIVE_WEIGHT = 30.0  # a loop that cannot close must show its gap at the joints, not as a false driven angle
STEPS = 400
LOOKS = (12, 20, 30, 45, 70, 100, 150, 200, 300)  # steps after which it is looked whether this is the bottom
OPEN, SLOW = 1e-6, 0.5  # of the extent: a gap; of |phi|^2 at the look before: less is a good way down


@dataclass(frozen=True, eq=False)
class Closure:
    """A closed position [n,3] (m, m, rad), its largest open distance `residual` (m) and the steps it took."""

    position: Array
    residual: float
    iterations: int


def opened(system: RigidSystem, position: Array) -> tuple[Array, Matrix]:
    """phi and G at a position."""
    rows = equations(system, position)
    return rows.phi, rows.jacobian


def descend(system: RigidSystem, start: Array) -> Closure:
    """Reduce |phi| from a position [n,3] until it is round-off or falls no more; the result may still be open."""
    return _Descent(system, start).run()


class _Descent:
    """A position on its way, its damping, and the position that the last step was refused for."""

    def __init__(self, system: RigidSystem, start: Array) -> None:
        self.system, self.position, self.lengths = system, np.array(start), metric(system)[0]
        reach, joints = system.reach, system.held
        self.scale = reach[1:].max(initial=0.0)
        self.finest = np.finfo(float).eps * self.scale
        self.weight = np.repeat([1.0, DRIVE_WEIGHT], [joints, len(system.drives)])
        pace = [LARGEST_TURN * (reach[d.body_b] if d.turns else self.scale) for d in system.drives]
        self.limit = np.concatenate([np.full(joints, np.inf), pace])
        self.phi, self.jacobian = opened(system, self.position)
        self.damping, self.taken, self.going, self.seen = 0.1, 0, True, np.inf
        self.refused: Array | None = None
        self.look()

    def run(self) -> Closure:
        """Steps until the end."""
        while self.going:
            self.step()
            self.look_down()
        return Closure(self.position, float(np.abs(self.phi).max(initial=0.0)), self.taken)

    def look_down(self) -> None:
        """Ends at the bottom, where that is near and open: steps would only go to and fro across it."""
        if not self.going or self.taken not in LOOKS:
            return
        phi, before = self.phi, self.seen
        self.seen = dot(self.weight * self.weight, phi * phi)
        hindered = (np.abs(phi) > self.limit).any()
        if (
            hindered
            or not isinstance(self.jacobian, np.ndarray)
            or np.abs(phi).max() <= OPEN * self.scale
            or self.seen < SLOW * before
        ):
            return
        start, square = self.position, self.weight * self.weight

        def moved(change: Array) -> Array:
            there: Array = start.copy()
            there[1:] += (change / self.lengths).reshape(-1, 3)
            return there

        def slopes(change: Array) -> tuple[float, Array]:
            phi, jacobian = opened(self.system, moved(change))
            return dot(square, phi * phi), times(jacobian.T, 2.0 * (square * phi))

        found = bottom(slopes, float(self.scale), len(self.lengths))
        if found is not None:
            self.position = moved(found)
            self.phi, self.jacobian = opened(self.system, self.position)
            self.going = False

    def look(self) -> None:
        """What follows from phi: the error of this step, whose drives advance no faster than the joints can
        follow, and the least step.
        """
        self.error = np.clip(self.phi, -self.limit, self.limit)
        weighed = self.weight * self.error
        self.square, self.merit = dot(self.error, self.error), math.sqrt(dot(weighed, weighed))
        self.closed = np.abs(self.error).max(initial=0.0) <= self.finest
        self.least: DampedStep | None = None

    def step(self) -> None:
        """One more step, unless it is closed."""
        if self.closed:
            self.going = False
            return
        if self.least is None:
            self.least = DampedStep(weighted(self.weight, self.jacobian), self.weight * self.error)
        step = self.limited(self.least, self.damping * self.square / (self.scale * self.scale))
        if np.abs(step * self.lengths).max() <= self.finest:
            self.going = False
            return
        self.taken += 1
        trial = self.position.copy()
        trial[1:] += step.reshape(-1, 3)
        if (
            self.refused is not None and (trial == self.refused).all()
        ):  # near round-off the damping grows for long before a position feels it
            self.damping *= 8.0
        else:
            self.take(trial)
        self.going = self.taken < STEPS

    def take(self, trial: Array) -> None:
        """Goes there where it is better."""
        phi, jacobian = opened(self.system, trial)
        left = self.weight * (phi - self.phi + self.error)
        if math.sqrt(dot(left, left)) < self.merit:
            self.position, self.phi, self.jacobian = trial, phi, jacobian
            self.damping, self.refused = max(self.damping / 4.0, 1e-6), None
            self.look()
        else:
            self.damping *= 8.0
            self.refused = trial

    def limited(self, least: DampedStep, damping: float) -> Array:
        """-(G^T G + damping)^-1 G^T error as a step in (x, y, theta), its turns limited.

        A step somewhat too long is shortened, for that keeps its joints together; one far too long comes from
        a dead centre nearby, and is damped until the other directions get their part.
        """
        while True:
            step: Array = -least(damping) / self.lengths
            excess = float(np.abs(step[2::3]).max()) / LARGEST_TURN
            if excess < 10.0:
                return step / max(1.0, excess)
            damping = max(4.0 * damping, RANK_TOLERANCE * RANK_TOLERANCE)


CLOSED = 1e-12  # largest open distance of a closed loop, in parts of the extent of the bodies


def close(system: RigidSystem, guess: Array, named: bool = True) -> Closure:
    """Return the closed position nearest the guess [n,3] (m, m, rad; row 0 is ignored).

    Damped Newton steps dq = -G^+ phi, of minimum norm in (x, y, l theta) and of at most 0.1 rad, whose
    damping vanishes with phi^2: redundant joints and free motions are both allowed.  A driven body ends at
    its drive's angle. Raises AssemblyError when joints stay open, naming them and their gaps, and ValueError
    on a bad guess. To find the names takes as long again as to find that it does not close: whoever does not
    read them has them not ``named``.
    """
    start = checked(system, guess, "guess")
    for drive in system.drives:
        if drive.turns:
            off = drive.aim - (start[drive.body_b, 2] - start[drive.body_a, 2])
            start[drive.body_b, 2] += 2.0 * np.pi * np.round(off / (2.0 * np.pi))
    closure = descend(system, start)
    if not _is_closed(system, closure):
        if not named:
            raise AssemblyError("joints stay open")
        nudged = start.copy()
        nudged[1:, 2] += 0.5 * LARGEST_TURN * cos(np.arange(1, len(start)))
        raise _open_joints(system, closure, _is_closed(system, descend(system, nudged)))
    return closure


def velocities(system: RigidSystem, position: Array, guess_velocity: Array | None = None) -> Array:
    """Return the velocity [n,3] (m/s, m/s, rad/s) that satisfies joints and drives at a closed position
    [n,3].

    G v = rate; of all such v the one with the least (v - v0)^T M (v - v0), v0 the guess [n,3] (default:
    rest). Raises AssemblyError when no velocity exists (a driven dead centre), VfifeError on bad shapes.
    """
    position = checked(system, position, "position")
    before = checked(
        system, np.zeros_like(position) if guess_velocity is None else guess_velocity, "guess_velocity"
    )
    rows = equations(system, position)
    lengths, mass = metric(system)
    motion = constrained(rows.jacobian, rows.rate, mass, flat(before) * lengths)[0]
    _demand(system, times(rows.jacobian, motion) - rows.rate, motion, "velocity")
    return of_bodies(motion / lengths)


def accelerations(
    system: RigidSystem, position: Array, velocity: Array, force: Array
) -> tuple[Array, Array, Array]:
    """Return acceleration [n,3] (m/s2, rad/s2), joint reactions [j,3] (N, N, N m) and drive reactions [d] (N
    m; N for a travel).

    M a = F + G^T lambda with G a = gamma; force [n,3] is (N, N, N m) at the centres of mass.  A reaction (fx,
    fy, m) is the force of body_a on body_b at body_b's point and the moment on body_b; body_a has the
    opposite of both at the same place in space (of a gear's moment, -ratio times it).  Where joints are
    redundant, lambda is the solution of least norm, each row weighed by its own diagonal of G M^-1 G^T,
    without the bodies that drives turn against the ground: as a step shares reactions. Raises AssemblyError
    when no acceleration exists (a dead centre, or a velocity that parts the joints), VfifeError on bad
    shapes.
    """
    position, velocity = checked(system, position, "position"), checked(system, velocity, "velocity")
    rows = equations(system, position, velocity)
    lengths, mass = metric(system)
    load = flat(checked(system, force, "force")) / lengths
    motion, multiplier = constrained(rows.jacobian, rows.gamma, mass, load / mass)
    _demand(system, times(rows.jacobian, motion) - rows.gamma, motion, "acceleration")
    driven = [one.body_b for one in system.drives if one.turns and one.body_a == 0]
    free = np.repeat(~np.isin(np.arange(1, len(system.names)), driven), 3)
    multiplier = shared_out(rows.jacobian, free / mass, multiplier)
    reaction = [
        one.reaction(position, multiplier[system.rows(k)], system.lengths[k])
        for k, one in enumerate(system.joints)
    ]
    driving = [
        system.lengths[k] if one.turns else 1.0
        for k, one in enumerate(system.drives, start=len(system.joints))
    ]
    reactions = np.array(reaction, dtype=float).reshape(-1, 3)
    return of_bodies(motion / lengths), reactions, multiplier[system.held :] * np.array(driving, dtype=float)


def flat(motion: Array) -> Array:
    """Motions of the moving bodies one after the other."""
    return motion[1:].reshape(-1)


def of_bodies(motion: Array) -> Array:
    """Such motions body by body, the ground at rest before them."""
    return np.concatenate([np.zeros((1, 3)), motion.reshape(-1, 3)])


def _is_closed(system: RigidSystem, closure: Closure) -> bool:
    """Whether it is closed to round-off."""
    extent = max(system.reach[1:].max(initial=0.0), np.abs(closure.position[:, :2]).max())
    return bool(closure.residual <= CLOSED * extent)


def _open_joints(system: RigidSystem, closure: Closure, between_branches: bool) -> AssemblyError:
    """Return the error that names the open joints of a position, their gaps and the likely cause."""
    before = opened(system, closure.position)[0]
    phi, alone = _put_down(system, closure)
    gaps = [norm(phi[system.rows(k)]) for k in range(len(system.joints))]
    largest = max(gaps, default=0.0)
    gap_of = {joint.name: gap for joint, gap in zip(system.joints, gaps, strict=True) if gap > 1e-3 * largest}
    listed = ", ".join(_gap(system, k, phi) for k, joint in enumerate(system.joints) if joint.name in gap_of)
    loop = [
        system.joints[k].name
        for k in range(len(system.joints))
        if np.abs(before[system.rows(k)]).max() > 1e-3 * np.abs(before).max()
    ]
    cause = (
        f"the links joined by {', '.join(loop)} cannot reach one another: check their lengths and end points"
    )
    if any(not joint.pinned for joint in system.joints if joint.name in loop):
        cause += ", the directions of guides and the angles of welded, guided and geared bodies"
    angles = [system.names[drive.body_b] for drive in system.drives if drive.turns]
    places = [drive.name for drive in system.drives if not drive.turns]
    if between_branches:
        cause = (
            "a slightly turned guess does close, so the guess lies between two branches: draw it to one side"
        )
    else:
        cause += f", and the driven angle of {', '.join(angles)}" if angles else ""
        cause += f", and the driven travel of {', '.join(places)}" if places else ""
    together = (
        f"with {', '.join(name for name in loop if name not in gap_of)} closed"
        if alone
        else f"{1e3 * sum(gap_of.values()):.4g} mm together"
    )
    message = f"joints stay open, {listed} ({together}); {cause}"
    return AssemblyError(message, tuple(gap_of), tuple(gap_of.values()))


def _put_down(system: RigidSystem, closure: Closure) -> tuple[Array, bool]:
    """phi of an open position, the gap put down to the joint that closes the loop; and whether that one alone
    is open then.
    """
    phi = opened(system, closure.position)[0]
    rows = np.abs(phi)
    joint = closing_joint(system, rows / rows.max()) if len(rows) <= DENSE else None
    if joint is None:
        return phi, False
    gathered = Gathered(system)
    position, gap, _ = parted(
        gathered, joint, np.array([drive.aim for drive in system.drives]), closure.position
    )
    alone = opened(system, position)[0]
    others = np.delete(np.abs(alone), np.arange(system.starts[joint], system.starts[joint + 1]))
    return (alone, True) if others.max(initial=0.0) <= 1e-3 * gap else (phi, False)


def _gap(system: RigidSystem, k: int, phi: Array) -> str:
    """A joint and by how much it is open: mm, and rad where angles do not fit."""
    joint, open_rows = system.joints[k], phi[system.rows(k)]
    apart, askew = norm(open_rows[: joint.lengths]), norm(open_rows[joint.lengths :])
    parts = [f"{1e3 * apart:.4g} mm"] if apart > 1e-3 * askew else []
    parts += [f"{askew / system.lengths[k]:.4g} rad"] if askew > 1e-3 * apart else []
    return f"{joint.name} by {' and '.join(parts)}"


def _demand(system: RigidSystem, missing: Array, motion: Array, quantity: str) -> None:
    """Raise AssemblyError where G motion misses its wanted value by more than round-off."""
    largest = max(np.abs(motion).max(initial=0.0), np.abs(missing).max(initial=0.0))
    missed = np.abs(missing) > RANK_TOLERANCE * largest
    if missed.any():
        joints = [joint.name for k, joint in enumerate(system.joints) if missed[system.rows(k)].any()]
        named = joints + [system.drive_name(drive) for drive in system.drives]
        cause = "the position is a dead centre, the drives disagree, or the velocity given parts the joints; "
        cause += "start at another angle, or remove one of the drives or joints named"
        raise AssemblyError(f"no {quantity} satisfies {', '.join(named)}: {cause}", joints)
