"""What all drivers share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from ..polynomials import Polynomials

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Driver:
    """What is driven: the angle of ``body``, the travel of the joint ``slider``, or the pin ``point`` along ``direction`` (fixed in space).

    The angle (rad) counts from the body's start angle; a body turns about its one ideal revolute to the ground, or, with ``against``, relative
    to another body. Travel and path (m) count from the start.
    """

    body: str = ""
    slider: str = ""
    point: str = ""
    direction: Point = (1.0, 0.0)
    against: str = "ground"

    kind: ClassVar[str] = ""  # the word in a model file; a class that has one of its own is a kind
    prescribes: ClassVar[bool] = True  # a motion; else a torque or a force
    revolves: ClassVar[bool] = False  # may turn a body round and round
    registry: ClassVar[dict[str, type[Driver]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Registers a kind."""
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("kind"):
            cls.registry[cls.kind] = cls

    def motion(self, offset: float = 0.0) -> Polynomials:
        """What it prescribes over time (rad or m), ``offset`` added. TypeError where it prescribes no motion."""
        raise TypeError(f"{type(self).__name__} prescribes no motion")

    def effort(self) -> Polynomials:
        """Its torque (N m) or force (N). TypeError where it prescribes a motion."""
        raise TypeError(f"{type(self).__name__} is no torque and no force")

    @property
    def over(self) -> Literal["time", "speed", "angle"]:
        """What its effort depends on: time (s), the speed of the body (rad/s), or its angle from the start (rad)."""
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
        return "m" if self.slider or self.point else "rad"

    @property
    def words(self) -> str:
        """What it does, in a few words."""
        return self.kind
