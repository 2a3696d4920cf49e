"""The massless link, which keeps two pins at a distance."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ...numerics.scalar import cos, sin
from ...schema import quantity
from ..drawing.strokes import Curve, JointView, Label, Mark, Stroke
from ..rows import FixedDistance, Row
from .joint import Joint, Point


@dataclass(frozen=True, kw_only=True)
class Distance(Joint):
    """A rigid massless link from the bearing's pin to the journal's: the pins stay ``length`` (m) apart, and
    both bodies turn freely.

    ``angle`` (rad) is the approximate start angle of the link in the frame of the bearing's body, used if
    nothing else determines where the other body starts.
    """

    kind = "distance"
    words = "massless link"
    sample: ClassVar[dict[str, Any]] = {"length": 0.3}

    length: float = quantity(
        "m", "distance of the two pins: the length of a rigid link without mass", above=0.0
    )
    angle: float = quantity(
        "rad", "approximate angle of the link at the start, in the frame of the bearing's body", 0.0
    )

    def rows(self) -> tuple[Row, ...]:
        """Return the row of a fixed distance."""
        return (FixedDistance(self.length),)

    @property
    def first_place(self) -> Point:
        """First guess of the journal's pin (m): the end of the link."""
        return self.length * cos(self.angle), self.length * sin(self.angle)

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return a thin line between two rings."""
        line = Curve([view.bearing, view.journal], "grey", 1.6, 3.0, sign="massless link")
        return [line, Mark(view.bearing, "ring"), Mark(view.journal, "ring")]

    def label(self, view: JointView) -> Label:
        """Return the middle of the link."""
        return Label(0.5 * (view.bearing + view.journal))
