"""A smooth ramp to a speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import quantity
from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class Ramp(Driver):
    """From rest to ``speed`` (rad/s, m/s) within ``duration`` (s): the speed is a fifth-order step, 10 s^3 - 15 s^4 + 6 s^5, then constant."""

    kind: ClassVar[str] = "ramp"

    lead: ClassVar[str] = "speed"

    speed: float = quantity("rad/s", "angular velocity", along=quantity("m/s", "velocity"))
    duration: float = quantity("s", "time of a smooth ramp from rest to the speed", above=0.0, key="ramp")
