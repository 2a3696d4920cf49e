"""Constraint rows of joints and their contact surfaces, as data for kinematics and steps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from ..numerics import elementwise
from ..numerics.scalar import hypot
from .geometry.path import Path

Point = tuple[float, float]


@dataclass(frozen=True)
class Coincide:
    """Two pins coincide: two rows."""

    def mirrored(self) -> Coincide:
        """Return the row with y reversed."""
        return self


@dataclass(frozen=True)
class Guided:
    """Base of rows of a guide through the bearing's pin along ``direction``, in the frame of the bearing's
    body.
    """

    direction: Point

    def mirrored(self) -> Any:
        """Return the row with y reversed."""
        return type(self)((self.direction[0], -self.direction[1]))

    def unit(self) -> Point:
        """Return the direction with length 1. Raises ValueError for a direction of length 0."""
        size = hypot(*self.direction)
        if not 0.0 < size < math.inf:
            x, y = (round(float(value), 6) for value in self.direction)
            raise ValueError(
                f"the direction [{x}, {y}] has no length; give two numbers (x, y) that are not both zero"
            )
        return self.direction[0] / size, self.direction[1] / size


@dataclass(frozen=True)
class AcrossGuide(Guided):
    """The journal's pin stays on the guide: one row."""


@dataclass(frozen=True)
class AlongGuide(Guided):
    """The journal's position along the guide (m) keeps its start value or follows a driver: one row."""


@dataclass(frozen=True)
class OnPath:
    """The journal's pin stays on a path, given from the bearing's pin in the frame of the bearing's body: one
    row.
    """

    path: Path

    def mirrored(self) -> OnPath:
        """Return the row with y reversed."""
        return OnPath(self.path.mirrored())


@dataclass(frozen=True)
class FixedDistance:
    """Two pins keep a distance ``length`` (m): one row."""

    length: float

    def mirrored(self) -> FixedDistance:
        """Return the row with y reversed."""
        return self


@dataclass(frozen=True)
class Turn:
    """The journal's body turns by ``ratio`` times the angle of the bearing's body, plus the start angle or
    that of a driver: one row.
    """

    ratio: float = 1.0

    def mirrored(self) -> Turn:
        """Return the row with all angles reversed."""
        return self


Row = Coincide | AcrossGuide | AlongGuide | OnPath | FixedDistance | Turn
Place = Coincide | AcrossGuide | AlongGuide | OnPath | FixedDistance


def turn_row(rows: tuple[Row, ...]) -> Turn | None:
    """Return the row that constrains the relative angle, or None."""
    for row in rows:
        if isinstance(row, Turn):
            return row
    return None


def place_row(rows: tuple[Row, ...]) -> Place | None:
    """Return the row that constrains the position, or None."""
    for row in rows:
        if not isinstance(row, Turn):
            return row
    return None


def loosened(rows: tuple[Row, ...]) -> tuple[Row, ...]:
    """Return the rows without the one that constrains the relative angle."""
    return tuple(row for row in rows if not isinstance(row, Turn))


Geometry = Literal["bearing", "round", "line", "slot"]
CENTRED = {"bearing": 0.0, "round": -1.0, "line": 1.0, "slot": 1.0}


class Touching(NamedTuple):
    """A contact of a round of the journal's body: in a bearing, beside another round, on a line, or in a slot
    along a path.

    ``size`` (m) is the distance from the bearing's pin, line or path at which contact begins; ``arms`` (m)
    are the arms of friction on bearing and journal at that distance. ``offset`` is the round's centre from
    the journal's pin, in the journal's frame. ``normal`` points into the material of a line; ``path`` starts
    at the bearing's pin; both are in the bearing's frame.
    """

    geometry: Geometry
    size: float
    arms: tuple[float, float]
    offset: Point = (0.0, 0.0)
    normal: Point = (1.0, 0.0)
    path: Path | None = None

    @property
    def centred(self) -> tuple[float, float]:
        """Arms (m) with which friction exerts no couple: both at the bearing's pin inside a bearing, both at
        the journal's pin outside.
        """
        return CENTRED[self.geometry] * self.size, 0.0

    def depth(self, x: Any, y: Any) -> Any:
        """Return the penetration (m) for the round's centre at (x, y), from the bearing's pin in the
        bearing's frame; negative without contact.
        """
        if self.path is not None:
            return abs(self.path.distance(x, y)) - self.size
        if self.geometry == "line":
            return self.normal[0] * x + self.normal[1] * y - self.size
        excess = elementwise.hypot(x, y) - self.size
        return -excess if self.geometry == "round" else excess
