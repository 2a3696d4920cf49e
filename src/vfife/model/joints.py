"""Joints: revolute, slider, weld and contacts, ideal or with clearance. Each has a bearing side and a journal side, written ``body.pin``."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from ..laws import Ambrosio, ContactLaw, FrictionLaw, LankaraniNikravesh, Material, Pair

FrictionMoment = Literal["mid-overlap", "surface", "off"]
Point = tuple[float, float]


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
class Slider(Joint):
    """The journal's pin moves along a straight guide through the bearing's pin.

    ``direction`` is that of the guide, in the frame of the bearing's body. The two bodies keep their relative angle (that of the closed start)
    unless ``turning``: then the journal is a pin in a slot.
    """

    direction: Point = (1.0, 0.0)
    turning: bool = False


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """Two pins in one place, and the relative angle of their bodies kept as it is in the closed start."""


@dataclass(frozen=True, kw_only=True)
class Gear:
    """Gears or a belt between two bodies: ``second`` turns by ``ratio`` times the angle by which ``first`` turns.

    The ratio is negative for external gears (- teeth of the first over teeth of the second) and positive for belts and internal gears.
    """

    name: str
    first: str
    second: str
    ratio: float


@dataclass(frozen=True, kw_only=True)
class Contact(Joint):
    """What all contacts with play share: surfaces, laws, and when a first contact counts as deep.

    ``impact_speed_floor`` (m/s) bounds the impact speed from below; a first contact that lands deeper than ``landing_depth`` (m) is counted, and
    shortens an automatic step. Friction acts in the middle of the overlap, at both surfaces, or, with ``friction_moment`` off, at the journal's
    centre (of a block, at those of its corners), so that it does not turn the round.
    """

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
        raise NotImplementedError

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """The two surfaces, with the bodies' materials where the joint names none."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class ClearanceRevolute(Contact):
    """Bearing and journal collide: free flight, impact and continuous contact (Eq. 18-25).

    ``clearance`` c = R_B - R_J, ``bearing_radius`` R_B and ``axial_length`` in m. ``friction_moment``: friction acts at the surfaces, with arms
    R_J - delta/2 and R_B + delta/2 (``mid-overlap``), R_J and R_B (``surface``), or at the particles alone (``off``, as the paper seems to do; the
    sliding velocity then leaves the turning of the surfaces out). ``landing_depth`` is c/20 unless given.
    """

    clearance: float
    bearing_radius: float

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        return self.landing_depth if self.landing_depth is not None else self.clearance / 20.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """The two surfaces, with the bodies' materials where the joint names none."""
        return Pair(self.bearing_radius, self.clearance, self.axial_length, self.bearing_material or bearing, self.journal_material or journal)


@dataclass(frozen=True, kw_only=True)
class ClearanceSlider(Contact):
    """A block with play in a straight guide: its four corners meet the two walls.

    The guide's middle line runs through the bearing's pin along ``direction`` (in the frame of the bearing's body); the journal's pin is the
    middle of the block. ``clearance`` (m) is the gap on each side of the centred block, ``length`` and ``height`` (m) are those of the block
    along and across the guide, whose walls are ``height + 2 clearance`` apart. ``corner_radius`` (m) rounds the corners for the contact law.
    The block lies along the guide at the start; ``landing_depth`` is c/20 unless given.
    """

    clearance: float
    length: float
    height: float
    direction: Point = (1.0, 0.0)
    corner_radius: float = 1e-3

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        return self.landing_depth if self.landing_depth is not None else self.clearance / 20.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """A rounded corner on a straight wall."""
        materials = (self.bearing_material or bearing, self.journal_material or journal)
        return Pair(math.inf, self.clearance, self.axial_length, *materials, opposite_radius=self.corner_radius)


@dataclass(frozen=True, kw_only=True)
class ExternalContact(Contact):
    """A round pin of ``journal_radius`` (m) beside a straight line or another round of ``bearing_radius`` (m).

    Without ``bearing_radius`` the bearing is a line through its pin along ``direction`` (in the frame of its body), its material on the right;
    the journal stays on the left. ``landing_depth`` is journal_radius/1000 unless given.
    """

    journal_radius: float
    bearing_radius: float | None = None
    direction: Point = (1.0, 0.0)

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        return self.landing_depth if self.landing_depth is not None else self.journal_radius / 1000.0

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """A round on a line or beside another round."""
        materials = (self.bearing_material or bearing, self.journal_material or journal)
        radius = math.inf if self.bearing_radius is None else self.bearing_radius
        return Pair(radius, 0.0, self.axial_length, *materials, opposite_radius=self.journal_radius)
