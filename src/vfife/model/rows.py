"""What a joint holds, as rows of constraints, and where its surfaces touch, as data that kinematics and steps
read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

from ..numerics import elementwise
from ..numerics.scalar import hypot
from .geometry.path import Path

Point = tuple[float, float]


@dataclass(frozen=True)
class Coincide:
    """Two pins in one place: two rows."""

    def mirrored(self) -> Coincide:
        """The row with y turned round."""
        return self


@dataclass(frozen=True)
class Guided:
    """The journal's pin seen from a guide through the bearing's pin along ``direction``, in the frame of the
    bearing's body.
    """

    direction: Point

    def mirrored(self) -> Any:
        """The row with y turned round."""
        return type(self)((self.direction[0], -self.direction[1]))

    def unit(self) -> Point:
        """The direction with length 1. ValueError where it has none."""
        size = hypot(*self.direction)
        if not 0.0 < size < math.inf:
            x, y = (round(float(value), 6) for value in self.direction)
            raise ValueError(
                f"the direction [{x}, {y}] has no length; give two numbers (x, y) that are not both zero"
            )
        return self.direction[0] / size, self.direction[1] / size


@dataclass(frozen=True)
class Across(Guided):
    """The pin does not leave the guide: one row."""


@dataclass(frozen=True)
class Along(Guided):
    """Its place along the guide (m) is what it was, or what is prescribed: one row."""


@dataclass(frozen=True)
class OnPath:
    """The journal's pin does not leave a path in the frame of the bearing's body, which counts from the
    bearing's pin: one row.
    """

    path: Path

    def mirrored(self) -> OnPath:
        """The row with y turned round."""
        return OnPath(self.path.mirrored())


@dataclass(frozen=True)
class FixedDistance:
    """Two pins stay a ``length`` (m) apart: one row."""

    length: float

    def mirrored(self) -> FixedDistance:
        """The row with y turned round."""
        return self


@dataclass(frozen=True)
class Turn:
    """The journal's body turns by ``ratio`` times the angle of the bearing's body, beside what it was or what
    is prescribed: one row.
    """

    ratio: float = 1.0

    def mirrored(self) -> Turn:
        """The row with every angle turned round."""
        return self


Row = Coincide | Across | Along | OnPath | FixedDistance | Turn
Place = Coincide | Across | Along | OnPath | FixedDistance


def turn_row(rows: tuple[Row, ...]) -> Turn | None:
    """The row that holds the turn of a body, if there is one."""
    return next((row for row in rows if isinstance(row, Turn)), None)


def place_row(rows: tuple[Row, ...]) -> Place | None:
    """The row that holds a place, if there is one."""
    return next((row for row in rows if not isinstance(row, Turn)), None)


def loosened(rows: tuple[Row, ...]) -> tuple[Row, ...]:
    """The rows without that of the turn."""
    return tuple(row for row in rows if not isinstance(row, Turn))


Geometry = Literal["bearing", "round", "line", "slot"]
CENTRED = {"bearing": 0.0, "round": -1.0, "line": 1.0, "slot": 1.0}


@dataclass(frozen=True)
class Touching:
    """A round of the journal's body in a bearing, beside another round, on a line, or in a slot along a path.

    ``size`` (m) is the distance from the bearing's pin, from the line through it or from the path at which
    the surfaces begin to touch; ``arms`` (m) are those of friction on bearing and journal from there.
    ``offset`` is the round's centre seen from the journal's pin, in the journal's frame. ``normal`` points
    into the material of a line, and ``path`` counts from the bearing's pin, both in the bearing's frame.
    """

    geometry: Geometry
    size: float
    arms: tuple[float, float]
    offset: Point = (0.0, 0.0)
    normal: Point = (1.0, 0.0)
    path: Path | None = None

    @property
    def centred(self) -> tuple[float, float]:
        """Arms with which friction makes no couple: at the centres, which are in one place in a bearing;
        outside, both at the journal's.
        """
        return CENTRED[self.geometry] * self.size, 0.0

    def depth(self, x: Any, y: Any) -> Any:
        """Penetration (m) with the round's centre at (x, y), seen from the bearing's pin in the bearing's
        frame; negative where they are apart.
        """
        if self.path is not None:
            return abs(self.path.distance(x, y)) - self.size
        if self.geometry == "line":
            return self.normal[0] * x + self.normal[1] * y - self.size
        beyond = elementwise.hypot(x, y) - self.size
        return -beyond if self.geometry == "round" else beyond
