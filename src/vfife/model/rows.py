"""What joints, gears and drivers hold: rows of constraints between two bodies, bearing and journal. They are data; others solve for them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..numerics.scalar import hypot
from .path import Path

Point = tuple[float, float]


@dataclass(frozen=True)
class Coincide:
    """Two pins in one place: two rows."""

    def mirrored(self) -> Coincide:
        """The row with y turned round."""
        return self


@dataclass(frozen=True)
class Guided:
    """The journal's pin seen from a guide through the bearing's pin along ``direction``, in the frame of the bearing's body."""

    direction: Point

    def mirrored(self) -> Any:
        """The row with y turned round."""
        return type(self)((self.direction[0], -self.direction[1]))

    def unit(self) -> Point:
        """The direction with length 1. ValueError where it has none."""
        size = hypot(*self.direction)
        if not 0.0 < size < math.inf:
            x, y = (round(float(value), 6) for value in self.direction)
            raise ValueError(f"the direction [{x}, {y}] has no length; give two numbers (x, y) that are not both zero")
        return self.direction[0] / size, self.direction[1] / size


@dataclass(frozen=True)
class Across(Guided):
    """The pin does not leave the guide: one row."""


@dataclass(frozen=True)
class Along(Guided):
    """Its place along the guide (m) is what it was, or what is prescribed: one row."""


@dataclass(frozen=True)
class OnPath:
    """The journal's pin does not leave a path in the frame of the bearing's body, which counts from the bearing's pin: one row."""

    path: Path

    def mirrored(self) -> OnPath:
        """The row with y turned round."""
        return OnPath(self.path.mirrored())


@dataclass(frozen=True)
class Apart:
    """Two pins stay a ``length`` (m) apart: one row."""

    length: float

    def mirrored(self) -> Apart:
        """The row with y turned round."""
        return self


@dataclass(frozen=True)
class Turn:
    """The journal's body turns by ``ratio`` times the angle of the bearing's body, beside what it was or what is prescribed: one row."""

    ratio: float = 1.0

    def mirrored(self) -> Turn:
        """The row with every angle turned round."""
        return self


Row = Coincide | Across | Along | OnPath | Apart | Turn
Place = Coincide | Across | Along | OnPath | Apart


def turn_row(rows: tuple[Row, ...]) -> Turn | None:
    """The row that holds the turn of a body, if there is one."""
    return next((row for row in rows if isinstance(row, Turn)), None)


def place_row(rows: tuple[Row, ...]) -> Place | None:
    """The row that holds a place, if there is one."""
    return next((row for row in rows if not isinstance(row, Turn)), None)


def loosened(rows: tuple[Row, ...]) -> tuple[Row, ...]:
    """The rows without that of the turn."""
    return tuple(row for row in rows if not isinstance(row, Turn))
