"""The weld."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..rows import Coincide, Row, Turn
from .joint import Joint


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """Two pins in one place, and the relative angle of their bodies kept as it is in the closed start."""

    kind: ClassVar[str] = "weld"

    def rows(self) -> tuple[Row, ...]:
        """Two pins in one place and no turning."""
        return Coincide(), Turn()
