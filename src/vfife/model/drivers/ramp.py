"""A smooth ramp to a speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class Ramp(Driver):
    """From rest to ``speed`` (rad/s, m/s) within ``duration`` (s): the speed is a fifth-order step, 10 s^3 - 15 s^4 + 6 s^5, then constant."""

    kind: ClassVar[str] = "ramp"

    speed: float
    duration: float
