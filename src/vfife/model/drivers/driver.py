"""What all drivers share."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar, Literal

from ...schema import Direction, Text, described, key_of
from ..geometry.polynomials import Polynomials
from ..kind import Kind

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Driver(Kind):
    """What is driven: the angle of ``body``, the travel of the joint ``slider``, or the pin ``point`` along
    ``direction`` (fixed in space).

    The angle (rad) counts from the body's start angle; a body turns about its one ideal revolute to the
    ground, or, with ``against``, relative to another body. Travel and path (m) count from the start.
    """

    body: str = described(Text("body"), "the body; the name of the table if left out", "")
    slider: str = described(Text("joint"), 'a joint of kind "slider"', "")
    point: str = described(Text("pin"), 'the pin, "body.pin"', "")
    direction: Point = described(Direction(), "direction, fixed in space", (1.0, 0.0))
    against: str = described(
        Text("body"), "body against which the angle counts, or on which the opposite torque acts", "ground"
    )

    lead: ClassVar[str] = ""  # the field whose key in a file tells the kind
    moves: ClassVar[bool] = True  # whether it prescribes a motion; else a torque or a force
    drives: ClassVar[tuple[str, ...]] = ("body", "slider", "point")  # what it can act on
    tabled: ClassVar[bool] = True  # a model file may have its table in a CSV file beside it
    revolves: ClassVar[bool] = False  # may turn a body round and round
    registry: ClassVar[dict[str, type[Driver]]] = {}

    @property
    def target(self) -> str:
        """What is driven: "body", "slider" or "point"."""
        return "slider" if self.slider else "point" if self.point else "body"

    @property
    def lead_key(self) -> str:
        """What a file calls that which tells the kind."""
        return self.lead_keys(self.along)

    @classmethod
    def lead_keys(cls, along: bool) -> str:
        """The same, about an axis or along a line."""
        return next(
            (key_of(field, along) for field in dataclasses.fields(cls) if field.name == cls.lead), cls.lead
        )

    @property
    def along(self) -> bool:
        """Whether it acts along a line, in m or N, not about an axis, in rad or N m."""
        return bool(self.slider or self.point)

    def motion(self, offset: float = 0.0) -> Polynomials:
        """What it prescribes over time (rad or m), ``offset`` added. TypeError where it is no motion."""
        raise TypeError(f"{type(self).__name__} prescribes no motion")

    def effort(self) -> Polynomials:
        """Its torque (N m) or force (N). TypeError where it prescribes a motion."""
        raise TypeError(f"{type(self).__name__} is no torque and no force")

    @property
    def over(self) -> Literal["time", "speed", "angle"]:
        """What its effort depends on: time (s), the speed of the body (rad/s), or its angle from the start
        (rad).
        """
        return "time"

    @property
    def steady(self) -> bool:
        """Whether its effort does not depend on time."""
        return True

    @property
    def largest_speed(self) -> float:
        """Largest speed (rad/s or m/s) that it asks for."""
        return 0.0

    @property
    def steady_speed(self) -> float | None:
        """Its speed (rad/s or m/s) if that never changes, else None."""
        return None

    @property
    def unit(self) -> str:
        """Unit of what it prescribes."""
        return "m" if self.along else "rad"

    @property
    def words(self) -> str:
        """What it does, in a few words."""
        return self.kind
