"""Constraints between planar rigid bodies: what joints, gears and drivers hold, each with phi, its
derivatives and its reaction.

A body's motion is (x, y, theta) of its centre of mass; body 0 is the ground.  Points and directions are in a
body's own axes, points in m from its centre of mass (for the ground: from the origin).  What a row measures,
which way it pulls and on which lever is the text of the step,
:mod:`vfife.kernels.constraint`, run as plain Python; gamma comes from the same text, run on numbers that
carry their derivatives in time. Rows that are angles are multiplied by a length L, 1/L^2 = 1/l_b^2 +
(ratio/l_a)^2 with l the reaches of the two bodies (none for the ground), so that a row of G in (x, y, l
theta) has unit length.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import VfifeError
from ..kernels import constraint, geometry
from ..kernels.topology import ACROSS, ALONG, APART, ON_PATH
from ..model.rows import Across, Along, Apart, Coincide, Guided, OnPath, Place, Row, Turn, place_row, turn_row
from ..numerics.elementwise import sincos

Array = NDArray[np.float64]


class Taylor:
    """value + rate t + second t^2/2; comparisons are those of the values."""

    __array_ufunc__ = None  # so that arrays leave what they do with it to it
    __slots__ = ("rate", "second", "value")

    def __init__(self, value: float, rate: float = 0.0, second: float = 0.0) -> None:
        self.value, self.rate, self.second = value, rate, second

    def __add__(self, other: Any) -> Taylor:
        o = other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(self.value + o.value, self.rate + o.rate, self.second + o.second)

    __radd__ = __add__

    def __neg__(self) -> Taylor:
        return Taylor(-self.value, -self.rate, -self.second)

    def __sub__(self, other: Any) -> Taylor:
        o = other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(self.value - o.value, self.rate - o.rate, self.second - o.second)

    def __rsub__(self, other: Any) -> Taylor:
        return taylor(other) + -self

    def __mul__(self, other: Any) -> Taylor:
        a, b = self, other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(
            a.value * b.value,
            a.rate * b.value + a.value * b.rate,
            a.second * b.value + 2.0 * a.rate * b.rate + a.value * b.second,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Taylor:
        b = taylor(other)
        value = self.value / b.value
        rate = (self.rate - value * b.rate) / b.value
        return Taylor(value, rate, (self.second - 2.0 * rate * b.rate - value * b.second) / b.value)

    def __rtruediv__(self, other: Any) -> Taylor:
        return taylor(other) / self

    def __abs__(self) -> Taylor:
        return self if self.value >= 0.0 else -self

    def __lt__(self, other: Any) -> bool:
        return self.value < taylor(other).value

    def __le__(self, other: Any) -> bool:
        return self.value <= taylor(other).value

    def __gt__(self, other: Any) -> bool:
        return self.value > taylor(other).value

    def __ge__(self, other: Any) -> bool:
        return self.value >= taylor(other).value


def taylor(number: Any) -> Taylor:
    """A plain number as one that does not change."""
    return number if isinstance(number, Taylor) else Taylor(number)


def sqrt(number: Any) -> Any:
    """Square root of a plain number, of an array of them, or of one with derivatives."""
    if not isinstance(number, Taylor):
        return np.sqrt(number) if hasattr(number, "shape") else math.sqrt(number)
    value = math.sqrt(number.value)
    half = 0.5 / value
    rate = half * number.rate
    return Taylor(value, rate, half * (number.second - 2.0 * rate * rate))


def lifted(*modules: ModuleType) -> Any:
    """The functions of kernels with a square root that takes derivatives along; they call one another."""
    space: dict[str, Any] = {}
    for module in modules:
        space |= vars(module)
    functions: dict[str, Callable[..., Any]] = {}
    for name, value in list(space.items()):
        if isinstance(value, FunctionType):
            functions[name] = FunctionType(value.__code__, space, name, value.__defaults__)
    space |= {**functions, "math": SimpleNamespace(sqrt=sqrt)}
    return SimpleNamespace(**functions)


SOMEWHERE = 1e-9  # of the length of a massless link whose pins a first guess puts in one place
KERNEL = lifted(geometry, constraint)  # arm, lever, guide_row and relative_turn, as the step has them


STILL, AT_REST = (
    [(0.0, 0.0, 0.0)] * 2,
    [0.0] * 2,
)  # what two pins in one place have of a third body, and at rest


class Rows(NamedTuple):
    """phi [r] (m), blocks of G for bodies a, b and c [r, 3] (1 or m), and gamma [r] (m/s2): what G a must be,
    but for a drive's acceleration.
    """

    phi: Sequence[float]
    a: Sequence[Sequence[float]]
    b: Sequence[Sequence[float]]
    c: Sequence[Sequence[float]]
    gamma: Sequence[float]


@dataclass(frozen=True, eq=False)
class Constraint:
    """Two bodies, a point of each, and the rows that tie them: a place, a turn or both.

    ``body_c`` carries the gears of a row of the turn, the ground if nothing else. ``aim`` is what the row of
    the turn (rad) or along a guide (m) keeps. A drive prescribes it at the instant, with its ``speed`` and
    ``acceleration``.
    """

    name: str
    body_a: int
    body_b: int
    held: tuple[Row, ...]
    point_a: ArrayLike = (0.0, 0.0)
    point_b: ArrayLike = (0.0, 0.0)
    aim: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    driven: bool = False
    body_c: int = 0

    def __post_init__(self) -> None:
        place = self.place
        if isinstance(place, Guided):
            try:
                place.unit()
            except ValueError as error:
                raise VfifeError(f"{self.name}: {error}") from None

    @cached_property
    def place(self) -> Place | None:
        """The row that holds a place, if there is one."""
        return place_row(self.held)

    @cached_property
    def turn(self) -> Turn | None:
        """The row that holds the turn, if there is one."""
        return turn_row(self.held)

    @property
    def geometry(self) -> tuple[Any, ...]:
        """All of it by which positions are closed, to be compared."""
        ends = self.name, self.body_a, self.body_b, self.body_c, *self.point_a, *self.point_b  # type: ignore[misc]
        return (*ends, self.held, self.aim, self.driven)

    @property
    def content(self) -> tuple[Any, ...]:
        """All that it says, to be compared."""
        return (*self.geometry, self.speed, self.acceleration)

    @property
    def turns(self) -> bool:
        """Whether it holds nothing but a turn."""
        return self.place is None

    @cached_property
    def pinned(self) -> bool:
        """Whether it holds two pins in one place, and no turn."""
        return self.held == (Coincide(),)

    @property
    def lengths(self) -> int:
        """Rows that are distances; those after them are angles."""
        return 0 if self.place is None else 2 if isinstance(self.place, Coincide) else 1

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.lengths + (self.turn is not None)

    @property
    def ratio(self) -> float:
        """By how much the angle of body a is multiplied in a row of angles."""
        return 1.0 if self.turn is None else self.turn.ratio

    def rows(self, p: Any, v: Any, length: float, facing: Sequence[Any] = ()) -> Rows:
        """phi, G and gamma (zero without ``v``) at position p and velocity v, both [n, 3], arrays or lists;
        rows of angles times ``length`` (m).

        ``facing``: cosine and sine of each body's angle, where they are known.
        """
        a, b = _numbers(p, self.body_a), _numbers(p, self.body_b)
        face_a, face_b = (
            facing[k] if facing and facing[k] else _facing(at)
            for k, at in ((self.body_a, a), (self.body_b, b))
        )
        (ax, ay), (bx, by) = self._arms(face_a, face_b)
        if v is None and self.pinned:
            return Rows(
                [(b[0] + bx) - (a[0] + ax), (b[1] + by) - (a[1] + ay)],
                _pins(ax, ay, -1.0),
                _pins(bx, by, 1.0),
                STILL,
                AT_REST,
            )
        phi, seen = self._places((ax, ay), (bx, by), a, b, face_a)
        foot = (ax, ay) if isinstance(self.place, Coincide) else (bx + b[0] - a[0], by + b[1] - a[1])
        on_a = [(-nx, -ny, -KERNEL.lever(*foot, nx, ny)) for nx, ny in seen]
        on_b = [(nx, ny, KERNEL.lever(bx, by, nx, ny)) for nx, ny in seen]
        gamma = [0.0] * len(phi)
        if v is not None and phi:
            gamma = self._gamma(a, b, _numbers(v, self.body_a), _numbers(v, self.body_b), (face_a, face_b))
        if isinstance(self.place, Along):
            phi = [phi[0] - self.aim]
        if isinstance(self.place, Apart):
            phi = [phi[0] - self.place.length]
        if self.turn is not None:
            phi = [
                *phi,
                length
                * (KERNEL.relative_turn(a[2], b[2], self.ratio, _numbers(p, self.body_c)[2]) - self.aim),
            ]
            on_a, on_b = [*on_a, (0.0, 0.0, -length * self.ratio)], [*on_b, (0.0, 0.0, length)]
            gamma = [*gamma, 0.0]
        on_c = [(0.0, 0.0, 0.0)] * len(seen) + [(0.0, 0.0, -length * (1.0 - self.ratio))] * (
            self.turn is not None
        )
        return Rows(phi, on_a, on_b, on_c, gamma)

    def _gamma(
        self, a: list[float], b: list[float], va: list[float], vb: list[float], facing: tuple[Any, Any]
    ) -> list[float]:
        """- dG/dt v: the second derivatives of phi with all accelerations zero, turned round."""
        moving = [[Taylor(x, u) for x, u in zip(at, speed, strict=True)] for at, speed in ((a, va), (b, vb))]
        faces = []
        for (c, s), speed in zip(facing, (va, vb), strict=True):
            w = speed[2]
            faces.append((Taylor(c, -s * w, -c * w * w), Taylor(s, c * w, -s * w * w)))
        phi, _ = self._places(*self._arms(*faces), moving[0], moving[1], faces[0])
        return [-one.second for one in phi]

    def _arms(self, face_a: Any, face_b: Any) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        (ax, ay), (bx, by) = self._points
        return KERNEL.arm(*face_a, ax, ay), KERNEL.arm(*face_b, bx, by)

    @cached_property
    def _points(self) -> tuple[list[Any], list[Any]]:
        points: tuple[Any, Any] = (self.point_a, self.point_b)
        (ax, ay), (bx, by) = points
        return [float(ax), float(ay)], [float(bx), float(by)]

    @cached_property
    def _guide(self) -> tuple[constraint.Guide, list[float]]:
        """The row of the place as the step has it, and the numbers of a path's pieces."""
        if isinstance(self.place, OnPath):
            numbers = self.place.path.numbers()
            return constraint.Guide(ON_PATH, 0, len(numbers), 1.0, 0.0), [
                value for piece in numbers for value in piece
            ]
        dx, dy = self.place.unit() if isinstance(self.place, Guided) else (1.0, 0.0)
        kind = APART if isinstance(self.place, Apart) else ACROSS if isinstance(self.place, Across) else ALONG
        return constraint.Guide(kind, 0, 0, dx, dy), []

    def _places(
        self, arm_a: Any, arm_b: Any, a: Any, b: Any, face: Any
    ) -> tuple[list[Any], list[tuple[Any, Any]]]:
        """What the rows of a place measure, and their directions in space; of floats, or of numbers with
        derivatives.
        """
        if self.place is None:
            return [], []
        ex, ey = (b[0] + arm_b[0]) - (a[0] + arm_a[0]), (b[1] + arm_b[1]) - (a[1] + arm_a[1])
        if isinstance(self.place, Coincide):
            return [ex, ey], [(1.0, 0.0), (0.0, 1.0)]
        guide, pieces = self._guide
        if guide.place == APART and ex == 0.0 and ey == 0.0:
            ex = SOMEWHERE * self.place.length  # type: ignore[union-attr]  # pins in one place: any direction leads apart
        measured, nx, ny = KERNEL.guide_row(pieces, guide, *face, ex, ey)
        return [measured], [(nx, ny)]

    def reaction(self, p: Array, multiplier: Array, length: float) -> tuple[float, float, float]:
        """Force (N) on body b at its point, and moment (N m) on it; body a has the opposite at the same
        place.
        """
        rows = self.rows(p, None, length).b[: self.lengths]
        values = multiplier.tolist()
        fx, fy = (
            float(sum(row[axis] * value for row, value in zip(rows, values, strict=False))) for axis in (0, 1)
        )
        return fx, fy, 0.0 if self.turn is None else length * values[-1]

    def at(self, p: Array) -> float:
        """Where the point of body b is along the guide (m) at position p [n, 3]."""
        return float(dataclasses.replace(self, aim=0.0).rows(p, None, 1.0).phi[0])

    def mirrored(self) -> Constraint:
        """The constraint with y and every angle turned round."""
        sign = -1.0 if self.turn is not None else 1.0
        return dataclasses.replace(
            self,
            held=tuple(row.mirrored() for row in self.held),
            point_a=(self._points[0][0], -self._points[0][1]),
            point_b=(self._points[1][0], -self._points[1][1]),
            aim=sign * self.aim,
            speed=sign * self.speed,
            acceleration=sign * self.acceleration,
        )


def _pins(x: Any, y: Any, sign: float) -> list[tuple[Any, Any, Any]]:
    """Blocks of G for a body whose pin, at (x, y) from its centre of mass, is held along both axes."""
    return [
        (sign, 0.0, sign * KERNEL.lever(x, y, 1.0, 0.0)),
        (0.0, sign, sign * KERNEL.lever(x, y, 0.0, 1.0)),
    ]


def _facing(at: list[float]) -> tuple[float, float]:
    """Cosine and sine of a body's angle."""
    s, c = sincos(at[2])
    return c, s


def directions(p: Any, body: int) -> tuple[Any, Any]:
    """Cosine and sine of a body's angle at position p."""
    return _facing(_numbers(p, body))


def _numbers(p: Any, body: int) -> list[Any]:
    """The three coordinates of a body."""
    return p[body] if isinstance(p, list) else p[body].tolist()  # type: ignore[no-any-return]
