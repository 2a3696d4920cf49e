"""The driver with a smooth run-up."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ...numerics.scalar import integer_power
from ...schema import quantity
from ..geometry.polynomials import Polynomials
from .driver import Driver

ROUNDING = 1e-9  # of a turn


@dataclass(frozen=True, kw_only=True)
class Ramp(Driver):
    """A smooth run-up from rest to ``speed`` (rad/s or m/s) within ``duration`` (s): the speed follows the
    fifth-order step 10 s^3 - 15 s^4 + 6 s^5 and is constant afterwards.
    """

    kind = "ramp"
    sample: ClassVar[dict[str, Any]] = {"speed": 5.0, "duration": 0.1}
    revolves = True
    has_turns = True
    lead = "speed"

    speed: float = quantity("rad/s", "angular velocity", linear=quantity("m/s", "velocity"))
    duration: float = quantity("s", "time of a smooth ramp from rest to the speed", above=0.0, key="ramp")

    def motion(self, offset: float = 0.0) -> Polynomials:
        """Return the motion (rad or m): w T (5/2 s^4 - 3 s^5 + s^6) with s = t/T, then speed w, plus
        ``offset``.
        """
        w, t = self.speed, self.duration
        rising = (
            offset,
            0.0,
            0.0,
            0.0,
            2.5 * w / integer_power(t, 3),
            -3.0 * w / integer_power(t, 4),
            w / integer_power(t, 5),
        )
        return Polynomials((0.0, t), (rising, (offset + 0.5 * w * t, w)))

    def crank_turns(self, turn: float, begin: float, duration: float) -> float | None:
        """Return the turns (1) that the body makes within a ``duration`` (s) from the time ``begin`` (s) on,
        its ``turn`` at the speed taking so long (s); None if the run-up is over.
        """
        motion = self.motion()
        revolutions = abs(motion(begin + duration)[0] - motion(begin)[0]) / (self.largest_speed * turn)
        return None if abs(revolutions - duration / turn) <= ROUNDING else revolutions

    @property
    def largest_speed(self) -> float:
        """Final speed (rad/s or m/s), unsigned."""
        return abs(self.speed)

    @property
    def words(self) -> str:
        """Description for readers."""
        speed = f"{self.speed:.6g} {self.unit}/s{self.in_rpm(self.speed)}"
        return f"smooth ramp to {speed} within {self.duration:.6g} s"
