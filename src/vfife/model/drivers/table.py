"""The driver with a motion through tabulated values."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...schema import FreeList, Measure, described
from ..geometry.polynomials import Polynomials, spline
from .driver import Driver

LOOKS = 1000  # times at which the speed of a table is evaluated


@dataclass(frozen=True, kw_only=True)
class AngleTable(Driver):
    """A motion through tabulated angles (rad) or travels (m) at given times (s), interpolated by a cubic
    spline; the last piece continues beyond the table.
    """

    kind = "table"
    builder = "motion"
    sample: ClassVar[dict[str, Any]] = {"times": (0.0, 0.1, 0.3), "values": (0.0, 0.2, 0.1)}
    revolves = True
    lead = "values"

    times: tuple[float, ...] = described(FreeList(Measure("s")), "times of the values of a table, ascending")
    values: tuple[float, ...] = described(
        FreeList(Measure("rad")),
        "angles from the start angle: at the times, or of the torques",
        key="angles",
        linear=described(
            FreeList(Measure("m")), "travels from the start: at the times, or of the forces", key="travels"
        ),
    )

    def motion(self, offset: float = 0.0) -> Polynomials:
        """Return the motion over time (rad or m), plus ``offset``."""
        return spline(self.times, self.values, offset)

    @property
    def largest_speed(self) -> float:
        """Largest speed (rad/s or m/s) at 1000 equally spaced times of the table."""
        function = self.motion()
        return max(abs(function(time)[1]) for time in np.linspace(self.times[0], self.times[-1], LOOKS))

    @property
    def end(self) -> float:
        """Time (s) of the last value."""
        return self.times[-1]

    @property
    def words(self) -> str:
        """Description for readers."""
        return (
            f"table of {len(self.times)} {'travels' if self.unit == 'm' else 'angles'} up to"
            f" {self.times[-1]:.6g} s"
        )
