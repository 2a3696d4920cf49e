"""The block with play in a straight guide."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ...fields import Direction, described, quantity
from ...laws import Material, Pair
from .contact import Contact
from .joint import Point


@dataclass(frozen=True, kw_only=True)
class ClearanceSlider(Contact):
    """A block with play in a straight guide: its four corners meet the two walls.

    The guide's middle line runs through the bearing's pin along ``direction`` (in the frame of the bearing's body); the journal's pin is the
    middle of the block. ``clearance`` (m) is the gap on each side of the centred block, ``length`` and ``height`` (m) are those of the block
    along and across the guide, whose walls are ``height + 2 clearance`` apart. ``corner_radius`` (m) rounds the corners for the contact law.
    The block lies along the guide at the start; ``landing_depth`` is c/20 unless given.
    """

    kind: ClassVar[str] = "clearance-slider"

    clearance: float = quantity("m", "gap on each side of the centred block", above=0.0)
    length: float = quantity("m", "length of the block, along the guide", above=0.0)
    height: float = quantity("m", "height of the block, across the guide", above=0.0)
    direction: Point = described(Direction(), "direction of the guide in the frame of the bearing's body", (1.0, 0.0))
    corner_radius: float = quantity("m", "radius of the block's corners", 1e-3, above=0.0)

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        return self.landing_depth if self.landing_depth is not None else self.clearance / 20.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """A rounded corner on a straight wall."""
        materials = (self.bearing_material or bearing, self.journal_material or journal)
        return Pair(math.inf, self.clearance, self.axial_length, *materials, opposite_radius=self.corner_radius)
