"""The ideal revolute joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..drawing.strokes import JointView, Mark, Stroke, standing
from ..rows import Coincide, Row
from .joint import Joint


@dataclass(frozen=True, kw_only=True)
class IdealRevolute(Joint):
    """Bearing and journal share one motion; the reaction follows (Eq. 16, generalised)."""

    kind: ClassVar[str] = "ideal"
    builders: ClassVar[dict[str, tuple[tuple[str, ...], ...]]] = {"revolute": ()}

    def rows(self) -> tuple[Row, ...]:
        """Two pins in one place."""
        return (Coincide(),)

    def strokes(self, view: JointView) -> list[Stroke]:
        """A ring, and the ground under it."""
        return [*standing(view), Mark(view.bearing, "ring", sign="ideal joint")]
