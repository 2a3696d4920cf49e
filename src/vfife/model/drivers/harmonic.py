"""Harmonic motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class Harmonic(Driver):
    """amplitude [sin(2 pi frequency t + phase) - sin(phase)]; rad or m, Hz, rad."""

    kind: ClassVar[str] = "harmonic"

    amplitude: float
    frequency: float
    phase: float = 0.0
