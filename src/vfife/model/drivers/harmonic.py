"""The driver with harmonic motion."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from ...schema import quantity
from ..geometry.polynomials import Polynomials, sine
from .driver import Driver

MOTION = "of amplitude [sin(2 pi frequency t + phase) - sin(phase)]"


@dataclass(frozen=True, kw_only=True)
class Harmonic(Driver):
    """A harmonic motion: amplitude [sin(2 pi frequency t + phase) - sin(phase)]; rad or m, Hz, rad."""

    kind = "harmonic"
    sample: ClassVar[dict[str, Any]] = {"amplitude": 0.2, "frequency": 3.0}

    lead = "amplitude"

    amplitude: float = quantity("rad", MOTION, linear=quantity("m", MOTION))
    frequency: float = quantity("1/s", "frequency of the amplitude", above=0.0)
    phase: float = quantity("rad", "phase of the amplitude; 0 if left out", 0.0)

    def motion(self, offset: float = 0.0) -> Polynomials:
        """Return the motion over time (rad or m), plus ``offset``."""
        return sine(self.amplitude, self.frequency, self.phase, offset)

    @property
    def largest_speed(self) -> float:
        """Speed (rad/s or m/s) at mid-stroke."""
        return 2.0 * math.pi * self.frequency * abs(self.amplitude)

    @property
    def words(self) -> str:
        """Description for readers."""
        return f"harmonic, {self.amplitude:.6g} {self.unit} at {self.frequency:.6g} Hz"
