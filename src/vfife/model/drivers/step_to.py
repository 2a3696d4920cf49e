"""A smooth step from rest to rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import quantity
from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class StepTo(Driver):
    """From 0 to ``travel`` (rad, m) between ``begin`` and ``begin + duration`` (s), by the step 10 s^3 - 15 s^4 + 6 s^5; at rest else."""

    kind: ClassVar[str] = "step"

    lead: ClassVar[str] = "travel"

    travel: float = quantity(
        "rad", "angle turned from rest to rest within the duration", along=quantity("m", "way from rest to rest within the duration")
    )
    duration: float = quantity("s", "time that the travel takes", above=0.0)
    begin: float = quantity("s", "when the travel begins; 0 if left out", 0.0)
