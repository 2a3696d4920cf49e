"""A smooth step from rest to rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class StepTo(Driver):
    """From 0 to ``travel`` (rad, m) between ``begin`` and ``begin + duration`` (s), by the step 10 s^3 - 15 s^4 + 6 s^5; at rest else."""

    kind: ClassVar[str] = "step"

    travel: float
    duration: float
    begin: float = 0.0
