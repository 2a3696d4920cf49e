"""The ideal slider, and the pin in a straight slot."""

from dataclasses import dataclass

from ...schema import Direction, Switch, described
from ..drawing.strokes import BLOCK, Block, JointView, Label, Mark, Stroke, rails, side_label
from ..rows import AcrossGuide, Row, Turn
from .joint import Joint, Point


@dataclass(frozen=True, kw_only=True)
class Slider(Joint):
    """A slider: the journal's pin moves along a straight guide through the bearing's pin.

    ``direction`` is that of the guide, in the frame of the bearing's body. The two bodies keep their relative
    start angle unless ``turning`` is true; then the journal is a pin in a slot.
    """

    kind = "slider"

    direction: Point = described(
        Direction(), "direction of the guide in the frame of the bearing's body", (1.0, 0.0)
    )
    turning: bool = described(
        Switch(), "true: a pin in a slot, free to turn; false: the bodies keep their relative angle", False
    )

    def rows(self) -> tuple[Row, ...]:
        """Return the row of a pin on a line and, unless the pin may turn, that of a constant
        relative angle.
        """
        return (AcrossGuide(self.direction),) if self.turning else (AcrossGuide(self.direction), Turn())

    @property
    def words(self) -> str:
        """Name of the joint for readers."""
        return "pin in a slot" if self.turning else "slider"

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return the rails, and the block or the pin between them."""
        length, height = (share * view.size * (0.6 if self.turning else 1.0) for share in BLOCK)
        guide = rails(view, self.direction, length, 0.5 * height)
        if self.turning:
            return [*guide, Mark(view.journal, "pin", "journal", "pin in a slot")]
        return [
            *guide,
            Block(view.journal, view.unit_vector(self.direction), length, height, sign="ideal slider"),
        ]

    def label(self, view: JointView) -> Label:
        """Return a place beside the guide."""
        return side_label(view, self.direction, 0.5 * BLOCK[1] * view.size)
