"""The revolute joint with clearance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import quantity
from ...laws import Material, Pair
from .contact import Contact


@dataclass(frozen=True, kw_only=True)
class ClearanceRevolute(Contact):
    """Bearing and journal collide: free flight, impact and continuous contact (Eq. 18-25).

    ``clearance`` c = R_B - R_J, ``bearing_radius`` R_B and ``axial_length`` in m. ``friction_moment``: friction acts at the surfaces, with arms
    R_J - delta/2 and R_B + delta/2 (``mid-overlap``), R_J and R_B (``surface``), or at the particles alone (``off``, as the paper seems to do; the
    sliding velocity then leaves the turning of the surfaces out). ``landing_depth`` is c/20 unless given.
    """

    kind: ClassVar[str] = "clearance"

    clearance: float = quantity("m", "bearing radius less journal radius", above=0.0)
    bearing_radius: float = quantity("m", "radius of the bearing", above=0.0)

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        return self.landing_depth if self.landing_depth is not None else self.clearance / 20.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """The two surfaces, with the bodies' materials where the joint names none."""
        return Pair(self.bearing_radius, self.clearance, self.axial_length, self.bearing_material or bearing, self.journal_material or journal)
