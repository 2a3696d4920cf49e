"""The driver with a smooth step from rest to rest."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ...numerics.scalar import integer_power
from ...schema import quantity
from ..geometry.polynomials import Polynomials
from .driver import Driver

STEEPEST = 1.875  # largest rate of the step 10 s^3 - 15 s^4 + 6 s^5, at its middle


@dataclass(frozen=True, kw_only=True)
class StepTo(Driver):
    """A smooth step from 0 to ``travel`` (rad or m) between ``begin`` and ``begin + duration`` (s) by 10 s^3
    - 15 s^4 + 6 s^5, at rest before and after.
    """

    kind = "step"
    builder = "step_to"
    sample: ClassVar[dict[str, Any]] = {"travel": 0.5, "duration": 0.1}

    lead = "travel"

    travel: float = quantity(
        "rad",
        "angle turned from rest to rest within the duration",
        linear=quantity("m", "travel from rest to rest within the duration"),
    )
    duration: float = quantity("s", "time that the travel takes", above=0.0)
    begin: float = quantity("s", "when the travel begins; 0 if left out", 0.0)

    def motion(self, offset: float = 0.0) -> Polynomials:
        """Return the motion over time (rad or m), plus ``offset``."""
        r, t = self.travel, self.duration
        step = (
            offset,
            0.0,
            0.0,
            10.0 * r / integer_power(t, 3),
            -15.0 * r / integer_power(t, 4),
            6.0 * r / integer_power(t, 5),
        )
        return Polynomials((self.begin - t, self.begin, self.begin + t), ((offset,), step, (offset + r,)))

    @property
    def largest_speed(self) -> float:
        """Speed (rad/s or m/s) in the middle of the step."""
        return STEEPEST * abs(self.travel) / self.duration

    @property
    def words(self) -> str:
        """Description for readers."""
        return (
            f"smooth step by {self.travel:.6g} {self.unit} from {self.begin:.6g} to"
            f" {self.begin + self.duration:.6g} s"
        )
