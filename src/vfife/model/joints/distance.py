"""The massless link: two pins that stay a distance apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...numerics.scalar import cos, sin
from ...schema import quantity
from ..drawing.strokes import Curve, JointView, Label, Mark, Stroke
from ..rows import FixedDistance, Row
from .joint import Joint, Point


@dataclass(frozen=True, kw_only=True)
class Distance(Joint):
    """A rigid link without mass from the bearing's pin to the journal's: they stay ``length`` (m) apart, and
    both bodies turn freely.

    ``angle`` (rad) is that of the link in the frame of the bearing's body, roughly, where no position of the
    other body says where it starts.
    """

    kind: ClassVar[str] = "distance"
    sample: ClassVar[dict[str, Any]] = {"length": 0.3}

    length: float = quantity(
        "m", "distance of the two pins: the length of a rigid link without mass", above=0.0
    )
    angle: float = quantity(
        "rad", "rough angle of the link at the start, in the frame of the bearing's body", 0.0
    )

    def rows(self) -> tuple[Row, ...]:
        """Two pins a distance apart."""
        return (FixedDistance(self.length),)

    @property
    def first_place(self) -> Point:
        """At the end of the link."""
        return self.length * cos(self.angle), self.length * sin(self.angle)

    @property
    def words(self) -> str:
        """What it is, in a few words."""
        return "massless link"

    def strokes(self, view: JointView) -> list[Stroke]:
        """A thin line between two rings."""
        line = Curve([view.bearing, view.journal], "grey", 1.6, 3.0, sign="massless link")
        return [line, Mark(view.bearing, "ring"), Mark(view.journal, "ring")]

    def label(self, view: JointView) -> Label:
        """In the middle of the link."""
        return Label(0.5 * (view.bearing + view.journal))
