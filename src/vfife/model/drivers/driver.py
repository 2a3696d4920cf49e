"""What all drivers share."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

from ...fields import Direction, Text, described, key_of

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Driver:
    """What is driven: the angle of ``body``, the travel of the joint ``slider``, or the pin ``point`` along ``direction`` (fixed in space).

    The angle (rad) counts from the body's start angle; a body turns about its one ideal revolute to the ground, or, with ``against``, relative
    to another body. Travel and path (m) count from the start.
    """

    body: str = described(Text("body"), "the body; the name of the table if left out", "")
    slider: str = described(Text("joint"), 'a joint of kind "slider"', "")
    point: str = described(Text("pin"), 'the pin, "body.pin"', "")
    direction: Point = described(Direction(), "direction, fixed in space", (1.0, 0.0))
    against: str = described(Text("body"), "body against which the angle counts, or on which the opposite torque acts", "ground")

    kind: ClassVar[str] = ""  # the word in a model file; a class that has one of its own is a kind
    lead: ClassVar[str] = ""  # the field whose key in a file tells the kind
    moves: ClassVar[bool] = True  # whether it prescribes a motion
    drives: ClassVar[tuple[str, ...]] = ("body", "slider", "point")  # what it can act on
    registry: ClassVar[dict[str, type[Driver]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Registers a kind."""
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("kind"):
            cls.registry[cls.kind] = cls

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
        return next((key_of(field, along) for field in dataclasses.fields(cls) if field.name == cls.lead), cls.lead)

    @property
    def along(self) -> bool:
        """Whether it acts along a line, in m or N, not about an axis, in rad or N m."""
        return bool(self.slider or self.point)
