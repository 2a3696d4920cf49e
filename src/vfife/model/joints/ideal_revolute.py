"""The ideal revolute joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..rows import Coincide, Row
from .joint import Joint


@dataclass(frozen=True, kw_only=True)
class IdealRevolute(Joint):
    """Bearing and journal share one motion; the reaction follows (Eq. 16, generalised)."""

    kind: ClassVar[str] = "ideal"

    def rows(self) -> tuple[Row, ...]:
        """Two pins in one place."""
        return (Coincide(),)
