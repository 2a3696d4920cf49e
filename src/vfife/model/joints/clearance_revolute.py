"""The revolute joint with clearance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...laws import Material, Pair
from ..touching import Touching
from .contact import Contact
from .ideal_revolute import IdealRevolute


@dataclass(frozen=True, kw_only=True)
class ClearanceRevolute(Contact):
    """Bearing and journal collide: free flight, impact and continuous contact (Eq. 18-25).

    ``clearance`` c = R_B - R_J, ``bearing_radius`` R_B and ``axial_length`` in m. ``friction_moment``: friction acts at the surfaces, with arms
    R_J - delta/2 and R_B + delta/2 (``mid-overlap``), R_J and R_B (``surface``), or at the particles alone (``off``, as the paper seems to do; the
    sliding velocity then leaves the turning of the surfaces out). ``landing_depth`` is c/20 unless given.
    """

    kind: ClassVar[str] = "clearance"
    sizes: ClassVar[tuple[str, ...]] = ("clearance", "bearing_radius")

    clearance: float
    bearing_radius: float

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        return self.landing_depth if self.landing_depth is not None else self.clearance / 20.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """The two surfaces, with the bodies' materials where the joint names none."""
        return Pair(self.bearing_radius, self.clearance, self.axial_length, self.bearing_material or bearing, self.journal_material or journal)

    def touchings(self, turned: float) -> tuple[Touching, ...]:
        """A journal in its bearing."""
        return (Touching("bearing", self.clearance, (self.bearing_radius, self.bearing_radius - self.clearance)),)

    def ideal(self) -> IdealRevolute:
        """The joint without play."""
        return IdealRevolute(name=self.name, bearing=self.bearing, journal=self.journal)

    @property
    def reach(self) -> float:
        """Depth (m) that no contact has in a sound run."""
        return self.bearing_radius

    @property
    def deepest_start(self) -> tuple[float, str]:
        """Half the bearing's radius."""
        return 0.5 * self.bearing_radius, f"half the bearing's radius of {self.bearing_radius:g} m"
