"""Rigid bodies, their joints and prescribed motions, and the equations of these constraints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..numerics.elementwise import hypot
from .constraints import Constraint
from .linalg import Matrix
from .rows import ConstraintRows

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RigidSystem:
    """Rigid bodies, their joints and their drives; body 0 is the ground, at the origin with angle 0.

    ``mass`` [n] (kg) and ``inertia`` [n] about the centre of mass (kg m2); entry 0 is ignored. Raises
    VfifeError for inconsistent input.
    """

    names: tuple[str, ...]
    mass: Array
    inertia: Array
    joints: Sequence[Constraint]
    drives: Sequence[Constraint] = ()

    @classmethod
    def batch(
        cls,
        names: tuple[str, ...],
        weights: Array,
        joints: Sequence[Sequence[Constraint]],
        drives: Sequence[Sequence[Constraint]],
    ) -> list[RigidSystem]:
        """Return systems of one structure, with masses (kg) and inertias (kg m²) ``weights`` [2, cases, n]
        and the constraints of each case. Raises VfifeError for inconsistent input.
        """
        first = cls(names, weights[0, 0], weights[1, 0], joints[0], drives[0])
        result, examined = [first], {id(constraint) for constraint in first.constraints}
        sound = np.all((weights > 0.0) & (weights < np.inf), axis=(0, 2)).tolist()
        for k in range(1, len(joints)):
            constraints = (*joints[k], *drives[k])
            # Structure and constraints that are shared with the first system are checked there.
            if sound[k] and all(id(tie) in examined or _finite(*tie.numbers) for tie in constraints):
                system = object.__new__(cls)
                vars(system).update(
                    names=names, mass=weights[0, k], inertia=weights[1, k], joints=joints[k],
                    drives=drives[k], constraints=constraints, starts=first.starts, structure=first.structure,
                )  # fmt: skip
                result.append(system)
            else:
                result.append(cls(names, weights[0, k], weights[1, k], joints[k], drives[k]))
        return result

    def __post_init__(self) -> None:
        n = len(self.names)
        for constraint in self.constraints:
            _check(constraint, n)
        if np.shape(self.mass) != (n,) or np.shape(self.inertia) != (n,):
            raise VfifeError(f"mass and inertia must have one entry for each of the {n} bodies")
        moving = np.array([self.mass[1:], self.inertia[1:]], dtype=float)
        if not ((moving > 0.0) & (moving < np.inf)).all():
            raise VfifeError("mass and inertia of every moving body must be finite and greater than zero")
        turned = [(drive.body_a, drive.body_b) for drive in self.drives if drive.turns]
        if len(set(turned)) < len(turned):
            raise VfifeError("each drive must turn a moving body of its own")

    @cached_property
    def sizes(self) -> Sizes:
        """Lengths that make distances of positions and turns comparable."""
        return sizes_of([self])[0]

    @property
    def reach(self) -> Array:
        """Size l (m) of each body [n]: the larger of its radius of gyration and the distance of its farthest
        joint; at least 1 for the ground.
        """
        return self.sizes.reach

    @property
    def lengths(self) -> Array:
        """Factor (m) of the row of angles of each constraint, which gives it unit length; 1 without such a
        row.
        """
        return self.sizes.lengths

    @property
    def metric(self) -> tuple[Array, Array]:
        """(1, 1, l) and (m, m, I / l^2) of each moving body, [3(n-1)] each; read-only."""
        return self.sizes.lever, self.sizes.mass

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """First row of each constraint, and the number of rows."""
        return (0, *accumulate(constraint.size for constraint in self.constraints))

    @cached_property
    def constraint_rows(self) -> ConstraintRows:
        """The constraint rows of this system."""
        return ConstraintRows([self.constraints], self.lengths, self.reach, single=True)

    @cached_property
    def rows_as_batch(self) -> ConstraintRows:
        """The constraint rows of this system as a batch of one."""
        return self.constraint_rows.select(None)

    @cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """Joints, then drives: the order of the rows."""
        return (*self.joints, *self.drives)

    @cached_property
    def structure(self) -> tuple[Any, ...]:
        """All of the system except numbers and names: systems of equal structure are solved as a batch."""
        ties = tuple(
            (
                constraint.body_a,
                constraint.body_b,
                constraint.body_c,
                tuple(map(type, constraint.rows)),
                constraint.driven,
            )
            for constraint in self.constraints
        )
        return len(self.names), len(self.joints), ties

    @property
    def joint_rows(self) -> int:
        """Number of rows of the joints; those of the drives come after them."""
        return self.starts[len(self.joints)]

    def rows(self, k: int) -> slice:
        """Return the rows of the k-th constraint."""
        return slice(self.starts[k], self.starts[k + 1])

    def dense_rows(self, position: Array, aims: Array) -> tuple[Array, Array]:
        """Return phi (..., r) and G (..., r, 3(n-1)) at positions (..., n, 3), with the drives at ``aims``
        (..., d) (rad, m).
        """
        rows = self.constraint_rows
        phi, entries = rows.at(position, rows.aimed(len(self.joints), aims))
        return phi, rows.dense(entries)

    @property
    def aims(self) -> Array:
        """InputFunction values of the drives [d] (rad, m)."""
        return np.array([drive.aim for drive in self.drives])

    @cached_property
    def drive_lengths(self) -> Array:
        """Factors of the rows of drives [d]: a length (m) for angles, else 1."""
        return np.array(
            [
                self.lengths[k] if drive.turns else 1.0
                for k, drive in enumerate(self.drives, start=len(self.joints))
            ],
            dtype=float,
        )

    def drive_name(self, drive: Constraint) -> str:
        """Return the name of a drive for messages."""
        return f"the drive of {self.names[drive.body_b] if drive.turns else drive.name}"


def _check(constraint: Constraint, n: int) -> None:
    """Raise VfifeError for a constraint with impossible bodies or numbers."""
    two = len({constraint.body_a, constraint.body_b} & {*range(n)}) == 2
    if constraint.driven and constraint.turns:
        if not two or constraint.body_b == 0:
            raise VfifeError("each drive must turn a moving body of its own")
        if not _finite(constraint.aim, constraint.speed, constraint.acceleration):
            raise VfifeError("angle, speed and acceleration of every drive must be finite")
        return
    if constraint.turns:
        if not two or not _finite(constraint.ratio, constraint.aim) or constraint.ratio == 0.0:
            raise VfifeError(
                f"gear {constraint.name} must couple two different bodies out of {n} by a finite ratio other"
                f" than zero, not {constraint.ratio:g}"
            )
        return
    if (
        not two
        or len(constraint.point_a) != 2
        or len(constraint.point_b) != 2
        or not _finite(*constraint.point_a, *constraint.point_b)
    ):
        raise VfifeError(
            f"joint {constraint.name} must join a point (x, y) each of two different bodies out of {n}"
        )
    if not _finite(constraint.aim, constraint.speed, constraint.acceleration):
        raise VfifeError(f"{constraint.name}: place, speed, acceleration and relative angle must be finite")


def _finite(*values: float) -> bool:
    """Return whether all numbers are finite."""
    return all(map(math.isfinite, values))


class Sizes(NamedTuple):
    """Properties ``reach`` [n] and ``lengths`` [constraints] of a system, and its metric: ``lever`` and
    ``mass``, [3(n-1)] each.
    """

    reach: Array
    lengths: Array
    lever: Array
    mass: Array


def sizes_of(systems: Sequence[RigidSystem]) -> list[Sizes]:
    """Return the sizes of systems of one structure."""
    mass, inertia = (
        np.array([getattr(system, kind) for system in systems], dtype=float) for kind in ("mass", "inertia")
    )
    reach, ties = np.ones_like(mass), systems[0].constraints
    reach[:, 1:] = np.sqrt(inertia[:, 1:] / mass[:, 1:])
    numbers = np.array(
        [[constraint.numbers for constraint in system.constraints] for system in systems], dtype=float
    )
    numbers = numbers.reshape(len(systems), len(ties), 11)
    bodies = np.array(
        [(constraint.body_a, constraint.body_b, constraint.body_c) for constraint in ties], dtype=np.intp
    ).reshape(-1, 3)
    arms = hypot(numbers[..., [0, 2]], numbers[..., [1, 3]])
    np.maximum.at(reach.T, bodies[:, :2], np.moveaxis(arms, 0, -1))
    lengths = np.ones((len(systems), len(ties)))
    turning = [k for k, constraint in enumerate(ties) if constraint.turn is not None]
    if turning:
        turned, ratio = bodies[turning], numbers[:, turning, 8]
        weights = np.stack([ratio, np.ones_like(ratio), 1.0 - ratio], axis=-1)
        a, b, c = np.moveaxis(np.where(turned == 0, 0.0, weights / reach[:, turned]), -1, 0)
        lengths[:, turning] = 1.0 / hypot(hypot(a, b), c)
    l, m, unit = reach[:, 1:], mass[:, 1:], np.ones_like(reach[:, 1:])
    lever, mass = (
        np.stack(parts, axis=-1).reshape(len(systems), -1)
        for parts in ((unit, unit, l), (m, m, inertia[:, 1:] / (l * l)))
    )
    return list(map(Sizes, reach, lengths, lever, mass))


@dataclass(frozen=True)
class Equations:
    """phi [r] (m), G [r, 3(n-1)], the required G v [r] (m/s) and gamma = G a [r] (m/s2)."""

    phi: Array
    jacobian: Matrix
    rate: Array
    gamma: Array


def equations(system: RigidSystem, position: Array, velocity: Array | None = None) -> Equations:
    """Return the equations of all joints, then of the drives, at a position and velocity [n, 3]; without a
    velocity gamma is that of the drives alone.
    """
    rows = system.constraint_rows
    phi, entries = rows.at(position)
    gamma = rows.accelerated() if velocity is None else rows.gamma(position, velocity)
    return Equations(phi, rows.matrix(entries), rows.rate(), gamma)


def rows_of(systems: Sequence[RigidSystem]) -> ConstraintRows:
    """Return the constraint rows of systems of one structure as a batch."""
    if len(systems) == 1:
        return systems[0].rows_as_batch
    # Positions, velocities and turns need the rows of the same systems one after the other.
    constraints = [system.constraints for system in systems]
    result: ConstraintRows | None = vars(systems[0]).get("rows_of_all")
    if result is not None and [*map(id, result.cases)] == [*map(id, constraints)]:
        return result
    if any("sizes" not in vars(system) for system in systems):
        for system, sizes in zip(systems, sizes_of(systems), strict=True):
            vars(system)["sizes"] = sizes
    lengths, reach = (np.array([getattr(s, size) for s in systems]) for size in ("lengths", "reach"))
    result = vars(systems[0])["rows_of_all"] = ConstraintRows(constraints, lengths, reach)
    return result


def metrics(systems: Sequence[RigidSystem]) -> tuple[Array, Array]:
    """Return the metrics of systems of one structure, [cases, 3(n-1)] each."""
    lengths, mass = zip(*(system.metric for system in systems), strict=True)
    return np.array(lengths), np.array(mass)


def flat(motion: Array) -> Array:
    """Return motions (..., n, 3) as vectors of the moving bodies, (..., 3(n-1))."""
    return motion[..., 1:, :].reshape(*motion.shape[:-2], -1)


def of_bodies(motion: Array) -> Array:
    """Return vectors (..., 3(n-1)) as motions body by body (..., n, 3), with the ground at rest."""
    lead = motion.shape[:-1]
    return np.concatenate([np.zeros((*lead, 1, 3)), motion.reshape(*lead, -1, 3)], axis=-2)


def alike(systems: Sequence[RigidSystem]) -> list[list[int]]:
    """Return groups of systems of one structure, by their indices."""
    result: dict[tuple[Any, ...], list[int]] = {}
    groups: dict[int, list[int]] = {}  # by the identity of structures, which takes long to compare
    for k, system in enumerate(systems):
        key = id(system.structure)
        if key not in groups:
            groups[key] = result.setdefault(system.structure, [])
        groups[key].append(k)
    return list(result.values())


def checked(system: RigidSystem, value: Array, name: str) -> Array:
    """Return a copy [n, 3] of an input with the ground's row at zero. Raises VfifeError for a bad shape or
    value.
    """
    motion = np.array(value, dtype=float)
    if motion.shape != (len(system.names), 3) or not np.isfinite(motion[1:]).all():
        raise VfifeError(f"{name} must be finite and have shape ({len(system.names)}, 3), not {motion.shape}")
    motion[0] = 0.0
    return motion


def mirrored(system: RigidSystem) -> RigidSystem:
    """Return the mirror image of a system, with the signs of y and of every angle changed."""
    joints, drives = (
        tuple(joint.mirrored() for joint in system.joints),
        tuple(drive.mirrored() for drive in system.drives),
    )
    return RigidSystem(system.names, system.mass, system.inertia, joints, drives)
