"""Harmonic motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import quantity
from .driver import Driver

MOTION = "of amplitude [sin(2 pi frequency t + phase) - sin(phase)]"


@dataclass(frozen=True, kw_only=True)
class Harmonic(Driver):
    """amplitude [sin(2 pi frequency t + phase) - sin(phase)]; rad or m, Hz, rad."""

    kind: ClassVar[str] = "harmonic"

    lead: ClassVar[str] = "amplitude"

    amplitude: float = quantity("rad", MOTION, along=quantity("m", MOTION))
    frequency: float = quantity("1/s", "frequency of the amplitude", above=0.0)
    phase: float = quantity("rad", "phase of the amplitude; 0 if left out", 0.0)
