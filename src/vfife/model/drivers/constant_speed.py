"""The driver with constant speed."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ...schema import quantity
from ..geometry.polynomials import Polynomials
from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class ConstantSpeed(Driver):
    """A drive with constant speed: speed t; rad/s or m/s."""

    kind = "constant-speed"
    builders: ClassVar[dict[str, tuple[tuple[str, ...], ...]]] = {
        "drive": (("slider", "point", "direction", "against"), ("body",))
    }
    sample: ClassVar[dict[str, Any]] = {"speed": 5.0}
    revolves = True
    has_turns = True
    lead = "speed"

    speed: float = quantity("rad/s", "angular velocity", linear=quantity("m/s", "velocity"))

    def motion(self, offset: float = 0.0) -> Polynomials:
        """Return the motion over time (rad or m), plus ``offset``."""
        return Polynomials((0.0,), ((offset, self.speed),))

    @property
    def largest_speed(self) -> float:
        """The speed (rad/s or m/s), unsigned."""
        return abs(self.speed)

    @property
    def steady_speed(self) -> float | None:
        """The speed (rad/s or m/s)."""
        return self.speed

    @property
    def words(self) -> str:
        """Description for readers."""
        return f"constant speed {self.speed:.6g} {self.unit}/s{self.in_rpm(self.speed)}"
