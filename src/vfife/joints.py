"""Joints: the ideal revolute and the revolute with clearance. Each has a bearing side and a journal side, written ``body.pin``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from .laws import Ambrosio, ContactLaw, FrictionLaw, LankaraniNikravesh, Material, Pair

FrictionMoment = Literal["mid-overlap", "surface", "off"]


@dataclass(frozen=True, kw_only=True)
class Joint:
    """Two pins in one place: ``bearing`` and ``journal`` are ``body.pin`` or ``ground.point``."""

    name: str
    bearing: str
    journal: str

    @property
    def sides(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """(body, pin) of the bearing and of the journal."""
        bearing, journal = self.bearing.partition("."), self.journal.partition(".")
        return (bearing[0], bearing[2]), (journal[0], journal[2])


@dataclass(frozen=True, kw_only=True)
class IdealRevolute(Joint):
    """Bearing and journal share one motion; the reaction follows (Eq. 16, generalised)."""


@dataclass(frozen=True, kw_only=True)
class ClearanceRevolute(Joint):
    """Bearing and journal collide: free flight, impact and continuous contact (Eq. 18-25).

    ``clearance`` c = R_B - R_J, ``bearing_radius`` R_B and ``axial_length`` in m. ``friction_moment``: friction acts at the surfaces, with arms
    R_J - delta/2 and R_B + delta/2 (``mid-overlap``), R_J and R_B (``surface``), or at the particles alone (``off``, as the paper seems to do; the
    sliding velocity then leaves the turning of the surfaces out). ``impact_speed_floor`` (m/s) bounds the impact speed from below; a first contact
    that lands deeper than ``landing_depth`` (m, default c/20) is counted, and shortens an automatic step.
    """

    clearance: float
    bearing_radius: float
    axial_length: float = 0.02
    contact: ContactLaw = field(default_factory=LankaraniNikravesh)
    friction: FrictionLaw = field(default_factory=Ambrosio)
    friction_moment: FrictionMoment = "mid-overlap"
    impact_speed_floor: float = 1e-3
    landing_depth: float | None = None
    bearing_material: Material | None = None
    journal_material: Material | None = None

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        return self.landing_depth if self.landing_depth is not None else self.clearance / 20.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """The two surfaces, with the bodies' materials where the joint names none."""
        return Pair(self.bearing_radius, self.clearance, self.axial_length, self.bearing_material or bearing, self.journal_material or journal)
