"""The ideal revolute joint."""

from dataclasses import dataclass

from ..drawing.strokes import JointView, Mark, Stroke, ground_symbol
from ..rows import Coincide, Row
from .joint import Joint


@dataclass(frozen=True, kw_only=True)
class IdealRevolute(Joint):
    """An ideal revolute joint: bearing and journal move together, and the reaction follows (Eq. 16,
    generalised).
    """

    kind = "ideal"
    builder = "revolute"

    def rows(self) -> tuple[Row, ...]:
        """Return the row of two coinciding pins."""
        return (Coincide(),)

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return a ring, and the ground symbol."""
        return [*ground_symbol(view), Mark(view.bearing, "ring", sign="ideal joint")]
