"""The weld."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..drawing.strokes import JointSeen, Label, Mark, Stroke, Surface, left_of
from ..rows import Coincide, Row, Turn
from .joint import Joint


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """Two pins in one place, and the relative angle of their bodies kept as it is in the closed start."""

    kind: ClassVar[str] = "weld"

    def rows(self) -> tuple[Row, ...]:
        """Two pins in one place and no turning."""
        return Coincide(), Turn()

    def strokes(self, seen: JointSeen) -> list[Stroke]:
        """A filled square; with the ground, a clamp in a wall."""
        found: list[Stroke] = [Mark(seen.bearing, "square", sign="weld")]
        if any(seen.ground):
            away = seen.leaving()
            across = 0.045 * seen.size * left_of(away)
            found.append(Surface(seen.bearing - across, seen.bearing + across, -away, 0.03 * seen.size))
        return found

    def label(self, seen: JointSeen) -> Label:
        """Beside it."""
        return Label(seen.journal)
