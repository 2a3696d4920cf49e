"""A round pin beside a line or another round."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ...fields import Direction, described, quantity
from ...laws import Material, Pair
from .contact import Contact
from .joint import Point


@dataclass(frozen=True, kw_only=True)
class ExternalContact(Contact):
    """A round pin of ``journal_radius`` (m) beside a straight line or another round of ``bearing_radius`` (m).

    Without ``bearing_radius`` the bearing is a line through its pin along ``direction`` (in the frame of its body), its material on the right;
    the journal stays on the left. ``landing_depth`` is journal_radius/1000 unless given.
    """

    kind: ClassVar[str] = "contact"

    journal_radius: float = quantity("m", "radius of the round at the journal", above=0.0)
    bearing_radius: float | None = quantity("m", "radius of the round at the bearing; a straight line if left out", None, above=0.0)
    direction: Point = described(Direction(), "direction of the line in the frame of the bearing's body; the journal is on its left", (1.0, 0.0))

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        return self.landing_depth if self.landing_depth is not None else self.journal_radius / 1000.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """A round on a line or beside another round."""
        materials = (self.bearing_material or bearing, self.journal_material or journal)
        radius = math.inf if self.bearing_radius is None else self.bearing_radius
        return Pair(radius, 0.0, self.axial_length, *materials, opposite_radius=self.journal_radius)
