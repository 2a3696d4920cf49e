"""The welded joint."""

from dataclasses import dataclass

from ..drawing.strokes import JointView, Label, Mark, Stroke, Surface, left_of
from ..rows import Coincide, Row, Turn
from .joint import Joint


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """A weld: two coinciding pins whose bodies keep their relative start angle."""

    kind = "weld"

    def rows(self) -> tuple[Row, ...]:
        """Return the rows of two coinciding pins and a constant relative angle."""
        return Coincide(), Turn()

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return a filled square and, for a weld to the ground, a clamp in a wall."""
        strokes: list[Stroke] = [Mark(view.bearing, "square", sign="weld")]
        if any(view.ground):
            away = view.leaving()
            across = 0.045 * view.size * left_of(away)
            strokes.append(Surface(view.bearing - across, view.bearing + across, -away, 0.03 * view.size))
        return strokes

    def label(self, view: JointView) -> Label:
        """Return a place beside the weld."""
        return Label(view.journal)
