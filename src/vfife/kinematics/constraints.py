"""Constraints between planar rigid bodies: what joints, gears and drivers hold.

A body's motion is (x, y, theta) of its centre of mass; body 0 is the ground.  Points and directions are in a
body's own axes, points in m from its centre of mass (for the ground: from the origin).
:mod:`vfife.kinematics.rows` evaluates them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..errors import VfifeError
from ..model.rows import (
    AlongGuide,
    Coincide,
    FixedDistance,
    Guided,
    OnPath,
    Place,
    Row,
    Turn,
    place_row,
    turn_row,
)


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
    rows: tuple[Row, ...]
    point_a: Sequence[float] = (0.0, 0.0)
    point_b: Sequence[float] = (0.0, 0.0)
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
        return place_row(self.rows)

    @cached_property
    def turn(self) -> Turn | None:
        """The row that holds the turn, if there is one."""
        return turn_row(self.rows)

    @property
    def geometry(self) -> tuple[Any, ...]:
        """All of it by which positions are closed, to be compared."""
        ends = self.name, self.body_a, self.body_b, self.body_c, *self.point_a, *self.point_b
        return (*ends, self.rows, self.aim, self.driven)

    @property
    def content(self) -> tuple[Any, ...]:
        """All that it says, to be compared."""
        return (*self.geometry, self.speed, self.acceleration)

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """Points of bodies a and b, direction of a guide, what its place and its turn keep, ratio, speed and
        acceleration.
        """
        place = self.place
        direction = place.unit() if isinstance(place, Guided) else (1.0, 0.0)
        keeps = (
            self.aim
            if isinstance(place, AlongGuide)
            else place.length
            if isinstance(place, FixedDistance)
            else 0.0
        )
        return (
            *self.point_a,
            *self.point_b,
            *direction,
            keeps,
            self.aim,
            self.ratio,
            self.speed,
            self.acceleration,
        )

    @cached_property
    def pieces(self) -> tuple[list[float], int]:
        """Numbers and count of the pieces of a path."""
        numbers = self.place.path.numbers() if isinstance(self.place, OnPath) else []
        return [value for piece in numbers for value in piece], len(numbers)

    @property
    def turns(self) -> bool:
        """Whether it holds nothing but a turn."""
        return self.place is None

    @cached_property
    def pinned(self) -> bool:
        """Whether it holds two pins in one place, and no turn."""
        return self.rows == (Coincide(),)

    @property
    def lengths(self) -> int:
        """Number of rows that are lengths: those of its place."""
        return 0 if self.place is None else 2 if isinstance(self.place, Coincide) else 1

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.lengths + (self.turn is not None)

    @property
    def ratio(self) -> float:
        """By how much the angle of body a is multiplied in a row of angles."""
        return 1.0 if self.turn is None else self.turn.ratio

    def moved(
        self, point_a: Sequence[float], point_b: Sequence[float] | None = None, aim: float | None = None
    ) -> Constraint:
        """Return the constraint with other points (m) and another value that its turn keeps (rad); None keeps
        its own.

        What depends on its rows alone is shared with it, and not checked again.
        """
        result = object.__new__(Constraint)
        point_b, aim = self.point_b if point_b is None else point_b, self.aim if aim is None else aim
        vars(result).update(vars(self), point_a=point_a, point_b=point_b, aim=aim)
        vars(result).pop("numbers", None)
        return result

    def mirrored(self) -> Constraint:
        """Reflect the constraint about the x axis: y and every angle change sign."""
        sign = -1.0 if self.turn is not None else 1.0
        (ax, ay), (bx, by) = self.point_a, self.point_b
        return dataclasses.replace(
            self,
            rows=tuple(row.mirrored() for row in self.rows),
            point_a=(ax, -ay),
            point_b=(bx, -by),
            aim=sign * self.aim,
            speed=sign * self.speed,
            acceleration=sign * self.acceleration,
        )
