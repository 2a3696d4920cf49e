"""Rigid bodies, the joints that tie them and the motions prescribed to them, and the equations that these
make.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..numerics.elementwise import hypot
from .constraints import Constraint, directions
from .linalg import DENSE, Matrix, matrix

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RigidSystem:
    """Rigid bodies, their joints and their drives; body 0 is the ground, at the origin with angle 0.

    mass [n] in kg and inertia [n] about the centre of mass in kg m2; entry 0 is ignored.  `reach` [n] in m is
    the larger of the radius of gyration and the farthest point of a joint of each body.  Raises VfifeError on
    inconsistent input.
    """

    names: tuple[str, ...]
    mass: Array
    inertia: Array
    joints: Sequence[Constraint]
    drives: Sequence[Constraint] = ()
    reach: Array = field(init=False, repr=False)
    starts: tuple[int, ...] = field(init=False, repr=False)
    lengths: tuple[float, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        n = len(self.names)
        for one in self.constraints:
            _check(one, n)
        mass, inertia = np.array(self.mass, dtype=float), np.array(self.inertia, dtype=float)
        if mass.shape != (n,) or inertia.shape != (n,):
            raise VfifeError(f"mass and inertia must have one entry for each of the {n} bodies")
        moving = np.stack([mass[1:], inertia[1:]])
        if not ((moving > 0.0) & (moving < np.inf)).all():
            raise VfifeError("mass and inertia of every moving body must be finite and greater than zero")
        reach = np.ones(n)
        reach[1:] = np.sqrt(inertia[1:] / mass[1:])
        sides = [
            side
            for one in self.constraints
            for side in ((one.body_a, one.point_a), (one.body_b, one.point_b))
        ]
        np.maximum.at(
            reach,
            [body for body, _ in sides],
            hypot(*np.array([at for _, at in sides], dtype=float).reshape(-1, 2).T),
        )
        turned = [(drive.body_a, drive.body_b) for drive in self.drives if drive.turns]
        if len(set(turned)) < len(turned):
            raise VfifeError("each drive must turn a moving body of its own")
        starts = np.cumsum([0, *(one.size for one in self.constraints)])
        lengths = tuple(_length(one, reach) for one in self.constraints)
        for name, value in (
            ("mass", mass),
            ("inertia", inertia),
            ("reach", reach),
            ("starts", tuple(map(int, starts))),
            ("lengths", lengths),
        ):
            object.__setattr__(self, name, value)

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """Joints, then drives: the order of the rows."""
        return (*self.joints, *self.drives)

    @property
    def held(self) -> int:
        """Number of rows of the joints; those of the drives come after them."""
        return self.starts[len(self.joints)]

    def rows(self, k: int) -> slice:
        """Rows of the k-th constraint."""
        return slice(self.starts[k], self.starts[k + 1])

    @cached_property
    def _places(self) -> tuple[list[int], list[int]]:
        """Rows and columns of the entries of G, constraint by constraint, row by row, body by body."""
        rows: list[int] = []
        columns: list[int] = []
        for one, first in zip(self.constraints, self.starts, strict=False):
            for row in range(first, first + one.size):
                for body in (one.body_a, one.body_b, one.body_c):
                    if body:
                        rows += (row,) * 3
                        columns += range(3 * body - 3, 3 * body)
        return rows, columns

    @cached_property
    def _flat(self) -> NDArray[np.intp]:
        """Places of these entries in G as one line."""
        rows, columns = (np.array(one, dtype=np.intp) for one in self._places)
        return rows * (3 * len(self.names) - 3) + columns

    def jacobian(self, values: list[float]) -> Matrix:
        """G from its entries, those of one place summed up in their order."""
        shape = self.starts[-1], 3 * len(self.names) - 3
        if shape[1] > DENSE:
            return matrix(values, *self._places, shape)
        return np.bincount(self._flat, values, minlength=shape[0] * shape[1]).reshape(shape)

    @cached_property
    def metric(self) -> tuple[Array, Array]:
        """(1, 1, l) and (m, m, I / l^2) of each moving body [3(n-1)]; not to be written to."""
        reach, mass, inertia = self.reach[1:], self.mass[1:], self.inertia[1:]
        one, turning = np.ones_like(reach), inertia / (reach * reach)
        return np.stack([one, one, reach], axis=-1).reshape(-1), np.stack(
            [mass, mass, turning], axis=-1
        ).reshape(-1)

    def drive_name(self, drive: Constraint) -> str:
        """A drive in messages."""
        return f"the drive of {self.names[drive.body_b] if drive.turns else drive.name}"


def _check(one: Constraint, n: int) -> None:
    """VfifeError where a constraint names bodies or numbers that make no sense."""
    two = len({one.body_a, one.body_b} & {*range(n)}) == 2
    if one.driven and one.turns:
        if not two or one.body_b == 0:
            raise VfifeError("each drive must turn a moving body of its own")
        if not _finite(one.aim, one.speed, one.acceleration):
            raise VfifeError("angle, speed and acceleration of every drive must be finite")
        return
    if one.turns:
        if not two or not _finite(one.ratio, one.aim) or one.ratio == 0.0:
            raise VfifeError(
                f"gear {one.name} must couple two different bodies out of {n} by a finite ratio other than"
                f" zero, not {one.ratio:g}"
            )
        return
    if not two or len(one.point_a) != 2 or len(one.point_b) != 2 or not _finite(*one.point_a, *one.point_b):  # type: ignore
        raise VfifeError(f"joint {one.name} must join a point (x, y) each of two different bodies out of {n}")
    if not _finite(one.aim, one.speed, one.acceleration):
        raise VfifeError(f"{one.name}: place, speed, acceleration and relative angle must be finite")


def _finite(*values: float) -> bool:
    """Whether numbers are finite."""
    return all(map(math.isfinite, values))


def _length(one: Constraint, reach: Array) -> float:
    """What multiplies a row of angles, so that it has unit length (m)."""
    a = 0.0 if one.body_a == 0 else one.ratio / reach[one.body_a]
    b = 0.0 if one.body_b == 0 else 1.0 / reach[one.body_b]
    c = 0.0 if one.body_c == 0 else (1.0 - one.ratio) / reach[one.body_c]
    return float(1.0 / hypot(hypot(a, b), c))


@dataclass(frozen=True)
class Equations:
    """phi [r] (m), G [r, 3(n-1)], the wanted G v [r] (m/s) and gamma = G a [r] (m/s2)."""

    phi: Array
    jacobian: Matrix
    rate: Array
    gamma: Array


def equations(system: RigidSystem, position: Array, velocity: Array | None = None) -> Equations:
    """The rows of all joints, then those of the drives, at a position and velocity [n, 3]; without a velocity
    gamma is that of the drives alone.
    """
    bodies, speeds = position.tolist(), None if velocity is None else velocity.tolist()
    facing = [directions(bodies, body) for body in range(len(bodies))]
    phi: list[float] = []
    rate: list[float] = []
    gamma: list[float] = []
    values: list[float] = []
    reach = system.reach.tolist()
    for one, length in zip(system.constraints, system.lengths, strict=True):
        found = one.rows(bodies, speeds, length, facing)
        phi += found.phi
        gamma += found.gamma
        rate += [0.0] * len(found.phi)
        sides = [
            (body, blocks)
            for body, blocks in ((one.body_a, found.a), (one.body_b, found.b), (one.body_c, found.c))
            if body
        ]
        for k in range(len(found.phi)):
            for body, blocks in sides:
                x, y, turn = blocks[k]
                values += (x, y, turn / reach[body])
        if one.driven:
            scale = length if one.turns else 1.0
            rate[-1] = scale * one.speed
            gamma[-1] += scale * one.acceleration
    return Equations(
        np.array(phi, dtype=float),
        system.jacobian(values),
        np.array(rate, dtype=float),
        np.array(gamma, dtype=float),
    )


def metric(system: RigidSystem) -> tuple[Array, Array]:
    """(1, 1, l) and (m, m, I / l^2) of each moving body [3(n-1)]."""
    return system.metric


def checked(system: RigidSystem, value: Array, name: str) -> Array:
    """A copy [n,3] of an input with the ground's row at zero; ValueError on a bad shape or value."""
    motion = np.array(value, dtype=float)
    if motion.shape != (len(system.names), 3) or not np.isfinite(motion[1:]).all():
        raise VfifeError(f"{name} must be finite and have shape ({len(system.names)}, 3), not {motion.shape}")
    motion[0] = 0.0
    return motion


def mirrored(system: RigidSystem) -> RigidSystem:
    """The system with y and every angle turned round."""
    joints, drives = (
        tuple(one.mirrored() for one in system.joints),
        tuple(one.mirrored() for one in system.drives),
    )
    return RigidSystem(system.names, system.mass, system.inertia, joints, drives)
