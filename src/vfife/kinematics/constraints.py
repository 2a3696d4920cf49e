"""Constraints between planar rigid bodies: pins, guides, welds, gears and prescribed motions, each with phi, its derivatives and its reaction.

A body's motion is (x, y, theta) of its centre of mass; body 0 is the ground.  Points and axes are in a body's own axes, points in m from its centre
of mass (for the ground: from the origin).  Rows that are angles are multiplied by a length L, 1/L^2 = 1/l_b^2 + (ratio/l_a)^2 with l the reaches of
the two bodies (none for the ground), so that a row of G in (x, y, l theta) has unit length.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
MIRROR = np.array([1.0, -1.0])


@dataclass(frozen=True)
class Rows:
    """phi [r] (m), blocks of G for bodies a and b [r, 3] (1 or m), and gamma [r] (m/s2): what G a must be, without a drive's own acceleration."""

    phi: Sequence[float]
    a: Sequence[Sequence[float]]
    b: Sequence[Sequence[float]]
    gamma: Sequence[float]


class Constraint:
    """Two bodies, and the rows that tie them."""

    name: str
    body_a: int
    body_b: int
    point_a: ArrayLike
    point_b: ArrayLike
    count: ClassVar[int] = 1
    turned: ClassVar[tuple[str, ...]] = ("offset",)

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.count

    @property
    def lengths(self) -> int:
        """Rows that are distances; those after them are angles."""
        return min(2, self.size)

    @property
    def ratio(self) -> float:
        """By how much the angle of body a is multiplied in a row of angles."""
        return 1.0

    def rows(self, p: Array, v: Array, length: float) -> Rows:
        """phi, G and gamma at position p and velocity v, both [n, 3]; rows of angles times ``length`` (m)."""
        raise NotImplementedError

    def reaction(self, p: Array, multiplier: Array, length: float) -> tuple[float, float, float]:
        """Force (N) on body b at its point, and moment (N m) on it; body a has the opposite at the same place."""
        raise NotImplementedError

    def mirrored(self) -> Any:
        """The constraint with y and every angle turned round."""
        changed: dict[str, Any] = {}
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if field.name in ("point_a", "point_b", "axis_a"):
                changed[field.name] = np.asarray(value) * MIRROR
            elif field.name in self.turned:
                changed[field.name] = -value
        return dataclasses.replace(self, **changed)  # type: ignore[type-var]


def turned(p: Array, body: int, point: ArrayLike) -> tuple[float, float]:
    """A vector of a body's axes in space."""
    c, s = float(np.cos(p[body, 2])), float(np.sin(p[body, 2]))
    x, y = np.asarray(point, dtype=float).tolist()
    return c * x - s * y, s * x + c * y


@dataclass(frozen=True, eq=False)
class Pin(Constraint):
    """Ideal revolute joint: point_a (2,) of body_a lies on point_b (2,) of body_b.

    phi = (r + A s)_b - (r + A s)_a and gamma = (w^2 A s)_b - (w^2 A s)_a.
    """

    name: str
    body_a: int
    point_a: ArrayLike
    body_b: int
    point_b: ArrayLike
    count = 2

    def rows(self, p: Array, v: Array, length: float) -> Rows:
        a, b = self.body_a, self.body_b
        (ax, ay), (bx, by) = turned(p, a, self.point_a), turned(p, b, self.point_b)
        wa, wb = v[a, 2] ** 2, v[b, 2] ** 2
        return Rows(
            (p[b, 0] + bx - p[a, 0] - ax, p[b, 1] + by - p[a, 1] - ay),
            ((-1.0, 0.0, ay), (0.0, -1.0, -ax)),
            ((1.0, 0.0, -by), (0.0, 1.0, bx)),
            (wb * bx - wa * ax, wb * by - wa * ay),
        )

    def reaction(self, p: Array, multiplier: Array, length: float) -> tuple[float, float, float]:
        return float(multiplier[0]), float(multiplier[1]), 0.0


@dataclass(frozen=True, eq=False)
class Weld(Pin):
    """Rigid joint: a pin whose bodies also keep theta_b - theta_a = offset (rad)."""

    offset: float = 0.0
    count = 3

    def rows(self, p: Array, v: Array, length: float) -> Rows:
        return _with_angle(super().rows(p, v, length), p, self, length)

    def reaction(self, p: Array, multiplier: Array, length: float) -> tuple[float, float, float]:
        return float(multiplier[0]), float(multiplier[1]), length * float(multiplier[2])


def _with_angle(rows: Rows, p: Array, joint: Any, length: float) -> Rows:
    """The rows, and one that keeps the relative angle."""
    phi = length * (p[joint.body_b, 2] - p[joint.body_a, 2] - joint.offset)
    return Rows((*rows.phi, phi), (*rows.a, (0.0, 0.0, -length)), (*rows.b, (0.0, 0.0, length)), (*rows.gamma, 0.0))


@dataclass(frozen=True, eq=False)
class Guided(Constraint):
    """A point of body b seen from a guide of body a: through point_a, along the unit vector t, n the normal on its left."""

    name: str
    body_a: int
    point_a: ArrayLike
    axis_a: ArrayLike
    body_b: int
    point_b: ArrayLike

    def __post_init__(self) -> None:
        object.__setattr__(self, "axis_a", unit(self.axis_a, self.name))

    def row(self, p: Array, v: Array, across: bool) -> Rows:
        """phi = e . d, d = (r + A s)_b - (r + A s)_a, with e = n ``across`` the guide and e = t along it; both turn with body a.

        With g = e turned by a right angle, phi' = w_a g . d + e . d' and gamma = e . (w_b^2 A s_b - w_a^2 A s_a + w_a^2 d) - 2 w_a g . d'.
        """
        a, b = self.body_a, self.body_b
        (ax, ay), (bx, by), (ex, ey) = turned(p, a, self.point_a), turned(p, b, self.point_b), turned(p, a, self.axis_a)
        if across:
            ex, ey = -ey, ex
        gx, gy = -ey, ex
        wa, wb = v[a, 2], v[b, 2]
        dx, dy = p[b, 0] + bx - p[a, 0] - ax, p[b, 1] + by - p[a, 1] - ay
        ux, uy = v[b, 0] - wb * by - v[a, 0] + wa * ay, v[b, 1] + wb * bx - v[a, 1] - wa * ax
        turning = gx * (dx + ax) + gy * (dy + ay)
        gamma = ex * (wb**2 * bx + wa**2 * (dx - ax)) + ey * (wb**2 * by + wa**2 * (dy - ay)) - 2.0 * wa * (gx * ux + gy * uy)
        return Rows((ex * dx + ey * dy,), ((-ex, -ey, turning),), ((ex, ey, -gx * bx - gy * by),), (gamma,))

    @property
    def lengths(self) -> int:
        return 1


def unit(axis: ArrayLike, name: str) -> Array:
    """A direction of length 1; ValueError where it has none."""
    vector = np.asarray(axis, dtype=float)
    size = float(np.hypot(*vector)) if vector.shape == (2,) else 0.0
    if not 0.0 < size < np.inf:
        raise ValueError(f"{name}: the direction {np.round(vector, 6).tolist()} has no length; give two numbers (x, y) that are not both zero")
    return vector / size


@dataclass(frozen=True, eq=False)
class Slide(Guided):
    """Guide: point_b of body_b lies on the line through point_a along axis_a (2,) of body_a.

    Unless ``turning``, theta_b - theta_a = offset (rad) too.
    """

    turning: bool = False
    offset: float = 0.0

    @property
    def size(self) -> int:
        return 1 if self.turning else 2

    def rows(self, p: Array, v: Array, length: float) -> Rows:
        line = self.row(p, v, across=True)
        return line if self.turning else _with_angle(line, p, self, length)

    def reaction(self, p: Array, multiplier: Array, length: float) -> tuple[float, float, float]:
        tx, ty = turned(p, self.body_a, self.axis_a)
        moment = 0.0 if self.turning else length * float(multiplier[1])
        return -ty * float(multiplier[0]), tx * float(multiplier[0]), moment


@dataclass(frozen=True, eq=False)
class Gear(Constraint):
    """theta_b - ratio theta_a = offset (rad).  Its moment m acts on body b, and -ratio m on body a."""

    name: str
    body_a: int
    body_b: int
    ratio: float = 1.0
    offset: float = 0.0

    @property
    def lengths(self) -> int:
        return 0

    def rows(self, p: Array, v: Array, length: float) -> Rows:
        phi = length * (p[self.body_b, 2] - self.ratio * p[self.body_a, 2] - self.offset)
        return Rows((phi,), ((0.0, 0.0, -self.ratio * length),), ((0.0, 0.0, length),), (0.0,))

    def reaction(self, p: Array, multiplier: Array, length: float) -> tuple[float, float, float]:
        return 0.0, 0.0, length * float(multiplier[0])


@dataclass(frozen=True, eq=False)
class Drive(Constraint):
    """Prescribed angle (rad), its rate (rad/s) and acceleration (rad/s2) of a body, relative to body ``against``, at the instant."""

    body: int
    angle: float
    speed: float = 0.0
    acceleration: float = 0.0
    against: int = 0
    name: str = ""
    turned = ("angle", "speed", "acceleration")

    @property
    def body_a(self) -> int:  # type: ignore[override]
        """The body it is driven against."""
        return self.against

    @property
    def body_b(self) -> int:  # type: ignore[override]
        """The driven body."""
        return self.body

    @property
    def value(self) -> float:
        """What is prescribed."""
        return self.angle

    @property
    def lengths(self) -> int:
        return 0

    def rows(self, p: Array, v: Array, length: float) -> Rows:
        phi = length * (p[self.body_b, 2] - p[self.body_a, 2] - self.angle)
        return Rows((phi,), ((0.0, 0.0, -length),), ((0.0, 0.0, length),), (0.0,))


@dataclass(frozen=True, eq=False)
class Travel(Guided):
    """Prescribed place `value` (m), its rate and acceleration (m/s, m/s2) of point_b of body_b along the guide of body_a.

    With body_a the ground it is the path of a point along a fixed direction.
    """

    value: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    turned = ()

    def rows(self, p: Array, v: Array, length: float) -> Rows:
        line = self.row(p, v, across=False)
        return dataclasses.replace(line, phi=(line.phi[0] - self.value,))

    def place(self, p: Array) -> float:
        """Where point_b is along the guide (m) at position p [n, 3]."""
        return float(self.row(p, np.zeros_like(p), across=False).phi[0])


AnyJoint = Pin | Slide | Weld | Gear
AnyDrive = Drive | Travel
