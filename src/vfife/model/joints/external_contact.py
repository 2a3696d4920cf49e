"""A round pin that touches a line or another round from outside."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from ...errors import Fault
from ...laws import Material, Pair
from ...numerics.scalar import atan2
from ...schema import Direction, described, quantity
from ..drawing.strokes import Curve, Extent, JointView, Label, Stroke, Surface, left_of, ring
from ..rows import AcrossGuide, Touching
from .contact import Contact
from .joint import Point


@dataclass(frozen=True, kw_only=True)
class ExternalContact(Contact):
    """A contact of a round of ``journal_radius`` (m) with a straight line, or with a round of
    ``bearing_radius`` (m).

    Without ``bearing_radius`` the bearing is a line through its pin along ``direction`` (in the frame of its
    body) with its material on the right; the journal is on the left. ``landing_depth`` defaults to
    journal_radius/1000.
    """

    kind = "contact"
    builder = "external_contact"
    sample: ClassVar[dict[str, Any]] = {"journal_radius": 0.05}
    sizes = ("bearing_radius", "journal_radius")
    extent = ("journal_radius", "the radius")

    journal_radius: float = quantity("m", "radius of the round at the journal", above=0.0)
    bearing_radius: float | None = quantity(
        "m", "radius of the round at the bearing; a straight line if left out", None, above=0.0
    )
    direction: Point = described(
        Direction(),
        "direction of the line in the frame of the bearing's body; the journal is on its left",
        (1.0, 0.0),
    )

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for a round with a direction."""
        yield from super().conflicts()
        if self.bearing_radius is not None and self.direction not in (None, (1.0, 0.0)):
            yield Fault(
                ("direction",),
                "a round has no direction",
                remedy="remove it, or remove bearing_radius for a straight line",
            )

    @property
    def usual_landing(self) -> float:
        """Default of ``landing_depth`` (m): journal_radius/1000."""
        return self.journal_radius / 1000.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """Return the surfaces: a round on a line, or two rounds."""
        materials = (self.bearing_material or bearing, self.journal_material or journal)
        radius = math.inf if self.bearing_radius is None else self.bearing_radius
        return Pair(radius, 0.0, self.axial_length, *materials, opposite_radius=self.journal_radius)

    def touchings(self, turned: float) -> tuple[Touching, ...]:
        """Return the contact of the round with a line or with another round."""
        r = self.journal_radius
        if self.bearing_radius is not None:
            return (Touching("round", self.bearing_radius + r, (-self.bearing_radius, r)),)
        x, y = AcrossGuide(self.direction).unit()
        return (Touching("line", -r, (0.0, r), normal=(y, -x)),)

    def ideal(self) -> None:
        """Return None: bodies that may separate are not joined."""
        return None

    @property
    def words(self) -> str:
        """Name of the joint for readers."""
        return "contact with a line" if self.bearing_radius is None else "contact of rounds"

    @property
    def deepest_start(self) -> tuple[float, str]:
        """Half the smaller radius (m), and its description."""
        radius = (
            self.journal_radius
            if self.bearing_radius is None
            else min(self.journal_radius, self.bearing_radius)
        )
        return 0.5 * radius, f"half the radius of {radius:g} m"

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return a round on a line, hatched if it belongs to the ground, or two rounds."""
        journal = ring(
            view.journal, view.factor * self.journal_radius, colour="journal", width=1.6, sign="contact"
        )
        if self.bearing_radius is not None:
            return [
                journal,
                ring(view.bearing, view.factor * self.bearing_radius, colour="bearing", width=1.6),
            ]
        direction, reach = (
            view.unit_vector(self.direction),
            view.way(atan2(self.direction[1], self.direction[0])),
        )
        overhang = max(0.05 * view.size, 1.5 * view.factor * self.journal_radius)
        ends = [
            view.bearing + (reach[0] - overhang) * direction,
            view.bearing + (reach[1] + overhang) * direction,
        ]
        if view.ground[0]:
            return [journal, Surface(ends[0], ends[1], -left_of(direction), 0.03 * view.size)]
        return [journal, Curve(ends, "bearing", 3.0, 3.5)]

    def label(self, view: JointView) -> Label:
        """Return a place beside the round."""
        return Label(view.journal)

    @property
    def drawn(self) -> Extent:
        """Extent of the rounds around their pins; of a line, only the part that the journal reaches."""
        return Extent((), self.bearing_radius, self.journal_radius)
