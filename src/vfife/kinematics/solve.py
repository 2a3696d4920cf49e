"""Position, velocity, acceleration and reaction analysis of planar rigid bodies with ideal joints and
prescribed motions.

A body's motion is (x, y, theta) of its centre of mass, in m and rad. Inside this module every coordinate is a
length, (x, y, l theta) with l the reach of the body, so that one tolerance applies to translations and
rotations.

Positions are closed iteratively (:mod:`~vfife.kinematics.descent`). Velocities and accelerations are linear:
of all motions that satisfy the constraints, the one nearest to the free motion in the metric of the masses is
taken (Gauss' principle), and its multipliers are the reactions. Redundant constraints are permitted; what
cannot be satisfied becomes an error that names the joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError, VfifeError
from ..numerics.dense import norm
from ..numerics.elementwise import cos
from .descent import LARGEST_TURN, Closure, closing_joint, descend, parted
from .linalg import DENSE, RANK_TOLERANCE, constrained, independent, shared_out, times
from .rows import ConstraintRows
from .system import RigidSystem, checked, flat, metrics, of_bodies, rows_of

Array = NDArray[np.float64]

CLOSED = 1e-12  # largest open distance of a closed loop, as a share of the extent of the bodies


def close(system: RigidSystem, guess: Array, named: bool = True) -> Closure:
    """Return the closed position nearest to a guess [n, 3] (m, m, rad; row 0 is ignored).

    Damped Newton steps dq = -G^+ phi, of minimum norm in (x, y, l theta) and of at most 0.1 rad, with a
    damping that vanishes with phi^2: redundant joints and free motions are both permitted. A driven body ends
    at its drive's angle. Raises AssemblyError if joints stay open, with their names and gaps, and VfifeError
    for a bad guess. Finding the names takes as long as finding that the position does not close; it is left
    out if not ``named``.
    """
    [result] = close_all([system], [checked(system, guess, "guess")], named)
    if isinstance(result, VfifeError):
        raise result
    return result


def close_all(
    systems: Sequence[RigidSystem], guesses: Sequence[Array], named: bool = True
) -> list[Closure | VfifeError]:
    """Return the closed positions of systems of one structure, or the errors of those that stay open, as in
    :func:`close`.
    """
    # A driven angle is closed within half a turn of its guess, so that no body turns further than it must.
    starts = np.array(guesses, dtype=float)
    starts[:, 0] = 0.0
    sound = np.flatnonzero(np.isfinite(starts).all(axis=(1, 2)))
    for k, drive in enumerate(systems[0].drives):
        if drive.turns:
            off = np.array([system.drives[k].aim for system in systems]) - (
                starts[:, drive.body_b, 2] - starts[:, drive.body_a, 2]
            )
            starts[:, drive.body_b, 2] += 2.0 * np.pi * np.round(off / (2.0 * np.pi))
    result: list[Closure | VfifeError] = [
        VfifeError("the approximate start of a body is too large for a number: check units")
    ] * len(systems)
    finite = [systems[k] for k in sound.tolist()]
    closures = descend(finite, starts[sound]) if finite else []
    for k, closure, closed in zip(sound.tolist(), closures, _are_closed(finite, closures), strict=True):
        result[k] = closure if closed else _stays_open(systems[k], starts[k], closure, named)
    return result


def _stays_open(system: RigidSystem, start: Array, closure: Closure, named: bool) -> AssemblyError:
    if not named:
        return AssemblyError("joints stay open")
    # A guess between two branches stays open as well: a slightly turned one decides which it is.
    nudged = start.copy()
    nudged[1:, 2] += 0.5 * LARGEST_TURN * cos(np.arange(1, len(start)))
    return _open_joints(system, closure, _are_closed([system], descend([system], nudged[None]))[0])


class ClosedSystems(NamedTuple):
    """Systems of one structure at closed ``positions`` [cases, n, 3], where their velocities and
    accelerations are linear: their rows, the entries and the matrices G of these, and their metrics.
    """

    systems: Sequence[RigidSystem]
    positions: Array
    rows: ConstraintRows
    entries: Array
    matrices: Any  # [cases, r, 3(n-1)], or a list of sparse ones
    lengths: Array
    mass: Array

    @classmethod
    def of(cls, systems: Sequence[RigidSystem], positions: Array) -> ClosedSystems:
        """Return the systems at these positions."""
        rows = rows_of(systems)
        entries = rows.at(positions)[1]
        small = rows.columns <= DENSE
        matrices = rows.dense(entries) if small else [rows.matrix(values) for values in entries]
        return cls(systems, positions, rows, entries, matrices, *metrics(systems))


class Velocities(NamedTuple):
    """Velocities [cases, n, 3] (m/s, m/s, rad/s), and the fault of each case without one, else None."""

    velocity: Array
    faults: list[AssemblyError | None]


def velocities(closed: ClosedSystems, wish: Array) -> Velocities:
    """Solve G v = rate.

    The result is the v with the least (v - v0)^T M (v - v0), where v0 is the ``wish`` [cases, n, 3]. There is
    none at a driven dead centre.
    """
    nearest = _nearest(closed, closed.rows.rate(), flat(wish) * closed.lengths)
    return Velocities(
        of_bodies(nearest.motion / closed.lengths), _faults(closed.systems, nearest, "velocity")
    )


def with_rates(
    closed: ClosedSystems, nearest: Velocities, rates: Sequence[Mapping[int, float]]
) -> Velocities:
    """Return the velocities with the given ``rates`` (rad/s) of each case by row, as far as joints and drives
    permit.

    A torque impulse on each of these bodies turns it as given and moves the others as joints have it: of all
    motions with these rates, the one nearest to the wish. Of rates that contradict each other the first
    holds. A case without rates keeps its bits.
    """
    velocity = nearest.velocity.copy()
    for k, targets in enumerate(rates):
        if not targets or nearest.faults[k] is not None:
            continue
        # Alone, as in a batch, so that other cases do not change its bits.
        system = ClosedSystems.of([closed.systems[k]], closed.positions[k : k + 1])
        answers: list[tuple[int, Array]] = []
        for row, rate in targets.items():
            impulse = np.zeros_like(velocity[k : k + 1])
            impulse[0, row, 2] = 1.0
            turning = _nearest(system, np.zeros_like(system.rows.rate()), flat(impulse) * system.lengths)
            answer = of_bodies(turning.motion / system.lengths)[0]
            for earlier, former in answers:  # so that the rates before it stay
                answer = answer - former * (answer[earlier, 2] / former[earlier, 2])
            if answer[row, 2] > RANK_TOLERANCE:
                answers.append((row, answer))
                velocity[k] += answer * ((rate - velocity[k, row, 2]) / answer[row, 2])
    return nearest._replace(velocity=velocity)


class Accelerations(NamedTuple):
    """Accelerations [cases, n, 3] (m/s2, rad/s2), reactions of joints [cases, j, 3] (N, N, N m) and of drives
    [cases, d] (N m; N for a travel).

    ``independent`` [cases]: whether no row of G depends on others. ``faults``: that of each case without an
    acceleration, else None.
    """

    acceleration: Array
    reaction: Array
    driving: Array
    independent: NDArray[np.bool_]
    faults: list[AssemblyError | None]


def accelerations(closed: ClosedSystems, velocity: Array, force: Array) -> Accelerations:
    """Solve M a = F + G^T lambda with G a = gamma, at velocities [cases, n, 3].

    ``force`` [cases, n, 3] is (N, N, N m) at the centres of mass. A reaction (fx, fy, m) is the force of
    body_a on body_b at body_b's point and the moment on body_b; body_a has the opposite of both at the same
    place in space (of a gear's moment, -ratio times it). If joints are redundant, lambda is the solution of
    least norm, each row weighted by its own diagonal of G M^-1 G^T, without the bodies that drives turn
    against the ground: the same distribution of reactions as in a step. There is no acceleration at a dead
    centre, or for a velocity that opens the joints.
    """
    systems, rows, lengths, mass = closed.systems, closed.rows, closed.lengths, closed.mass
    nearest = _nearest(closed, rows.gamma(closed.positions, velocity), flat(force) / lengths / mass)
    first = systems[0]
    driven = {drive.body_b for drive in first.drives if drive.turns and drive.body_a == 0}
    free = np.repeat([body not in driven for body in range(1, len(first.names))], 3)
    alone, multiplier = independent(closed.matrices), nearest.multiplier
    for k in np.flatnonzero(~alone).tolist():
        multiplier[k] = shared_out(closed.matrices[k], free / mass[k], multiplier[k])
    driving = multiplier[:, first.joint_rows :] * np.array([system.drive_lengths for system in systems])
    reaction = reactions(first, rows, closed.entries, multiplier)
    acceleration = of_bodies(nearest.motion / lengths)
    return Accelerations(acceleration, reaction, driving, alone, _faults(systems, nearest, "acceleration"))


class Nearest(NamedTuple):
    """The motions nearest to the free ones [cases, c], and their multipliers and the remaining errors of the
    rows, [cases, r] each.
    """

    motion: Array
    multiplier: Array
    missing: Array


def _nearest(closed: ClosedSystems, target: Array, free: Array) -> Nearest:
    """Return the motions with G motion = ``target`` that are nearest to the ``free`` ones."""
    matrices = closed.matrices
    if isinstance(matrices, np.ndarray):
        motion, multiplier = constrained(matrices, target, closed.mass, free)
        return Nearest(motion, multiplier, times(matrices, motion) - target)
    results = map(constrained, matrices, target, closed.mass, free)
    motion, multiplier = map(np.array, zip(*results, strict=True))
    missing = np.array(list(map(times, matrices, motion))) - target
    return Nearest(motion, multiplier, missing)


def reactions(system: RigidSystem, rows: ConstraintRows, entries: Array, multiplier: Array) -> Array:
    """Return the force (N) of each joint on its body b at its point, and the moment (N m) on it [cases, j,
    3]; body a has the opposite at the same place.
    """
    result, directions = np.zeros((len(entries), len(system.joints), 3)), rows.directions(entries)
    for k, joint in enumerate(system.joints):
        multipliers = multiplier[:, system.rows(k)]
        for row in range(joint.lengths):
            result[:, k, :2] += directions[k][:, row] * multipliers[:, row, None]
        if joint.turn is not None:
            result[:, k, 2] = rows.lengths[:, k] * multipliers[:, -1]
    return result


def _are_closed(systems: Sequence[RigidSystem], closures: Sequence[Closure]) -> list[bool]:
    """Return whether positions are closed to round-off."""
    if not systems:
        return []
    reach = np.array([system.reach for system in systems])[:, 1:].max(axis=-1, initial=0.0)
    places = np.abs(np.array([closure.position[:, :2] for closure in closures])).max(axis=(1, 2))
    residuals = np.array([closure.residual for closure in closures])
    closed: list[bool] = (residuals <= CLOSED * np.maximum(reach, places)).tolist()
    return closed


def _open_joints(system: RigidSystem, closure: Closure, between_branches: bool) -> AssemblyError:
    """Return the error that names the open joints of a position, their gaps and the likely cause."""
    distances = system.constraint_rows.at(closure.position)[0]
    phi, alone = _put_down(system, closure)
    gaps = [norm(phi[system.rows(k)]) for k in range(len(system.joints))]
    largest = max(gaps, default=0.0)
    gap_of = {joint.name: gap for joint, gap in zip(system.joints, gaps, strict=True) if gap > 1e-3 * largest}
    listed = ", ".join(_gap(system, k, phi) for k, joint in enumerate(system.joints) if joint.name in gap_of)
    loop = [
        system.joints[k].name
        for k in range(len(system.joints))
        if np.abs(distances[system.rows(k)]).max() > 1e-3 * np.abs(distances).max()
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
    extent = (
        f"with {', '.join(name for name in loop if name not in gap_of)} closed"
        if alone
        else f"{1e3 * sum(gap_of.values()):.4g} mm together"
    )
    message = f"joints stay open, {listed} ({extent}); {cause}"
    return AssemblyError(message, tuple(gap_of), tuple(gap_of.values()))


def _put_down(system: RigidSystem, closure: Closure) -> tuple[Array, bool]:
    """Return phi of an open position with the gap moved to the joint that closes the loop, and whether only
    that joint is open then.
    """
    phi = system.constraint_rows.at(closure.position)[0]
    rows = np.abs(phi)
    joint = closing_joint(system, rows / rows.max()) if len(rows) <= DENSE else None
    if joint is None:
        return phi, False
    position, gap, _ = parted(system, joint, system.aims, closure.position)
    alone = system.constraint_rows.at(position)[0]
    remaining = np.delete(np.abs(alone), np.arange(system.starts[joint], system.starts[joint + 1]))
    return (alone, True) if remaining.max(initial=0.0) <= 1e-3 * gap else (phi, False)


def _gap(system: RigidSystem, k: int, phi: Array) -> str:
    """Return a joint and its gap as text: mm, and rad if angles do not fit."""
    joint, open_rows = system.joints[k], phi[system.rows(k)]
    distance, askew = norm(open_rows[: joint.lengths]), norm(open_rows[joint.lengths :])
    parts = [f"{1e3 * distance:.4g} mm"] if distance > 1e-3 * askew else []
    parts += [f"{askew / system.lengths[k]:.4g} rad"] if askew > 1e-3 * distance else []
    return f"{joint.name} by {' and '.join(parts)}"


def _faults(systems: Sequence[RigidSystem], nearest: Nearest, quantity: str) -> list[AssemblyError | None]:
    """Return the error of each case whose G motion differs from its target by more than round-off, else
    None.
    """
    largest = np.maximum(
        np.abs(nearest.motion).max(axis=-1, initial=0.0), np.abs(nearest.missing).max(axis=-1, initial=0.0)
    )
    missed = np.abs(nearest.missing) > RANK_TOLERANCE * largest[:, None]
    return [
        _fault(system, rows, quantity) if rows.any() else None
        for system, rows in zip(systems, missed, strict=True)
    ]


def _fault(system: RigidSystem, missed: NDArray[np.bool_], quantity: str) -> AssemblyError:
    joints = [joint.name for k, joint in enumerate(system.joints) if missed[system.rows(k)].any()]
    named = joints + [system.drive_name(drive) for drive in system.drives]
    cause = "the position is a dead centre, the drives disagree, or the velocity given parts the joints; "
    cause += "start at another angle, or remove one of the drives or joints named"
    return AssemblyError(f"no {quantity} satisfies {', '.join(named)}: {cause}", joints)
