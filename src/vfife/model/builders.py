"""The builders of a mechanism, one for each kind of noun. Their signatures say what they take; :func:`~vfife.model.adders.adds` does the rest.

Quantities are numbers in SI units or texts with a unit, "100 mm". Laws and materials are objects or go by their names, laws and sections also
as tables of a model file: ``contact={"law": "hertz-...", ...}``, ``section={"round": "20 mm"}``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ..errors import Fault, ModelError, place, shown
from ..fields import PLACE
from ..laws import ContactLaw, FrictionLaw, Material
from .adders import adds
from .bodies import Frame, Link, LinkModel, Member, PointMass, Release, RigidBody, Section, Strain
from .given import Given, Place, Quantity, Table
from .joints import (
    ClearanceCurvedSlot,
    ClearanceRevolute,
    ClearanceSlider,
    CurvedSlot,
    Distance,
    ExternalContact,
    FrictionMoment,
    Gear,
    IdealRevolute,
    Slider,
    Weld,
)
from .loadbuilders import LoadBuilders
from .springs import Bushing, Spring, Stop, TorsionalSpring
from .wear import Wear

NONE: Mapping[str, Any] = MappingProxyType({})


class Builders(LoadBuilders):
    """What adds nouns to a mechanism."""

    if TYPE_CHECKING:
        name: str
        points: dict[str, tuple[float, float]]

    def point(self, name: str, x: Quantity, y: Quantity) -> None:
        """Adds a point of the ground (m). Raises ModelError where its place is none, or there is one of this name."""
        reading, at = Given(), ("ground", str(name))
        found = PLACE.read((x, y), at, reading)
        faults = reading.faults
        if not name or "." in str(name):
            faults.append(Fault(place(("ground", "")), f"the name {shown(name)} cannot be part of a path", remedy="choose a name without dots"))
        elif name in self.points:
            faults.append(Fault(place(at), f"there is a point called {shown(name)} already", remedy="choose another name"))
        if faults:
            raise ModelError(faults, str(self.name) or "mechanism")
        self.points[name] = found

    # ---------------------------------------------------------------------------------------------------------- bodies

    @adds("body", Link)
    def link(
        self, name: str, *, length: Quantity, mass: Quantity | None = None, model: LinkModel = "rigid", angle: Quantity = 0.0,
        position: Place | None = None, velocity: Place = (0.0, 0.0, 0.0), material: Material | str = "steel",
        inertia: Quantity | None = None, center_at: Quantity | None = None, elements: int = 4, section: Section | Table | None = None,
        release: Release = "none", stiffness_factor: float = 1.0, strain: Strain = "reference", start_mass: Quantity = 0.0,
        end_mass: Quantity = 0.0, start_inertia: Quantity = 0.0, end_inertia: Quantity = 0.0, via: Sequence[Place] = (),
        pins: Mapping[str, Place] = NONE, masses: Mapping[str, Quantity] = NONE,
    ) -> Link:  # fmt: skip
        """Adds a link from ``start`` to ``end``, rigid, elastic or of two particles; see :class:`~vfife.model.bodies.Link`."""
        raise NotImplementedError

    @adds("body", RigidBody)
    def rigid_body(
        self, name: str, *, mass: Quantity, inertia: Quantity, center: Place = (0.0, 0.0), pins: Mapping[str, Place] = NONE,
        masses: Mapping[str, Quantity] = NONE, angle: Quantity = 0.0, position: Place | None = None, velocity: Place = (0.0, 0.0, 0.0),
        material: Material | str = "steel",
    ) -> RigidBody:  # fmt: skip
        """Adds a rigid body with any number of pins; see :class:`~vfife.model.bodies.RigidBody`."""
        raise NotImplementedError

    @adds("body", PointMass)
    def point_mass(
        self, name: str, *, mass: Quantity, inertia: Quantity = 0.0, angle: Quantity = 0.0, position: Place | None = None,
        velocity: Place = (0.0, 0.0, 0.0), material: Material | str = "steel",
    ) -> PointMass:  # fmt: skip
        """Adds a particle with one pin, ``center``; see :class:`~vfife.model.bodies.PointMass`."""
        raise NotImplementedError

    @adds("body", Frame)
    def frame(
        self, name: str, *, nodes: Mapping[str, Place], members: Sequence[Member | Table], section: Section | Table | None = None,
        masses: Mapping[str, Quantity] = NONE, strain: Strain = "reference", angle: Quantity = 0.0, position: Place | None = None,
        velocity: Place = (0.0, 0.0, 0.0), material: Material | str = "steel",
    ) -> Frame:  # fmt: skip
        """Adds a frame of welded elastic members; see :class:`~vfife.model.bodies.Frame`."""
        raise NotImplementedError

    # ---------------------------------------------------------------------------------------------------------- joints

    @adds("joint", IdealRevolute)
    def revolute(self, name: str, bearing: str, journal: str) -> IdealRevolute:
        """Adds an ideal revolute joint between two pins, each ``body.pin`` or ``ground.point``."""
        raise NotImplementedError

    @adds("joint", ClearanceRevolute)
    def clearance(
        self, name: str, bearing: str, journal: str, *, clearance: Quantity, bearing_radius: Quantity, axial_length: Quantity = 0.02,
        contact: ContactLaw | str | Table = "lankarani-nikravesh", friction: FrictionLaw | str | Table = "ambrosio",
        friction_moment: FrictionMoment = "mid-overlap", impact_speed_floor: Quantity = 1e-3, landing_depth: Quantity | None = None,
        bearing_material: Material | str | None = None, journal_material: Material | str | None = None, wear: Wear | Table | None = None,
    ) -> ClearanceRevolute:  # fmt: skip
        """Adds a revolute joint with play: bearing and journal collide; see :class:`~vfife.model.joints.ClearanceRevolute`."""
        raise NotImplementedError

    @adds("joint", Slider)
    def slider(self, name: str, bearing: str, journal: str, *, direction: Place = (1.0, 0.0), turning: bool = False) -> Slider:
        """Adds an ideal slider: the journal's pin moves along a guide through the bearing's; see :class:`~vfife.model.joints.Slider`."""
        raise NotImplementedError

    @adds("joint", ClearanceSlider)
    def clearance_slider(
        self, name: str, bearing: str, journal: str, *, clearance: Quantity, length: Quantity, height: Quantity,
        direction: Place = (1.0, 0.0), corner_radius: Quantity = 1e-3, axial_length: Quantity = 0.02,
        contact: ContactLaw | str | Table = "lankarani-nikravesh", friction: FrictionLaw | str | Table = "ambrosio",
        friction_moment: FrictionMoment = "mid-overlap", impact_speed_floor: Quantity = 1e-3, landing_depth: Quantity | None = None,
        bearing_material: Material | str | None = None, journal_material: Material | str | None = None, wear: Wear | Table | None = None,
    ) -> ClearanceSlider:  # fmt: skip
        """Adds a block with play in a guide; see :class:`~vfife.model.joints.ClearanceSlider`."""
        raise NotImplementedError

    @adds("joint", CurvedSlot)
    def curved_slot(
        self, name: str, bearing: str, journal: str, *, centre: Place = (0.0, 0.0), radius: Quantity | None = None,
        points: Sequence[Place] = (), fillet: Quantity = 0.0,
    ) -> CurvedSlot:  # fmt: skip
        """Adds a pin in a curved slot: a circle, or a polyline with rounded corners; see :class:`~vfife.model.joints.CurvedSlot`."""
        raise NotImplementedError

    @adds("joint", ClearanceCurvedSlot)
    def clearance_curved_slot(
        self, name: str, bearing: str, journal: str, *, clearance: Quantity, journal_radius: Quantity, centre: Place = (0.0, 0.0),
        radius: Quantity | None = None, points: Sequence[Place] = (), fillet: Quantity = 0.0, axial_length: Quantity = 0.02,
        contact: ContactLaw | str | Table = "lankarani-nikravesh", friction: FrictionLaw | str | Table = "ambrosio",
        friction_moment: FrictionMoment = "mid-overlap", impact_speed_floor: Quantity = 1e-3, landing_depth: Quantity | None = None,
        bearing_material: Material | str | None = None, journal_material: Material | str | None = None, wear: Wear | Table | None = None,
    ) -> ClearanceCurvedSlot:  # fmt: skip
        """Adds a round pin with play in a curved slot; see :class:`~vfife.model.joints.ClearanceCurvedSlot`."""
        raise NotImplementedError

    @adds("joint", Weld)
    def weld(self, name: str, bearing: str, journal: str) -> Weld:
        """Joins two bodies rigidly at a pin of each; with the ground it is a clamp."""
        raise NotImplementedError

    @adds("joint", Distance)
    def distance(self, name: str, bearing: str, journal: str, *, length: Quantity, angle: Quantity = 0.0) -> Distance:
        """Adds a rigid link without mass between two pins; see :class:`~vfife.model.joints.Distance`."""
        raise NotImplementedError

    @adds("joint", ExternalContact)
    def external_contact(
        self, name: str, bearing: str, journal: str, *, journal_radius: Quantity, bearing_radius: Quantity | None = None,
        direction: Place = (1.0, 0.0), axial_length: Quantity = 0.02, contact: ContactLaw | str | Table = "lankarani-nikravesh",
        friction: FrictionLaw | str | Table = "ambrosio", friction_moment: FrictionMoment = "mid-overlap",
        impact_speed_floor: Quantity = 1e-3, landing_depth: Quantity | None = None, bearing_material: Material | str | None = None,
        journal_material: Material | str | None = None, wear: Wear | Table | None = None,
    ) -> ExternalContact:  # fmt: skip
        """Adds a contact between a round pin and a line or another round; see :class:`~vfife.model.joints.ExternalContact`."""
        raise NotImplementedError

    # ------------------------------------------------------------------------------------------------ gears and springs

    @adds("gear", Gear)
    def gear(self, name: str, first: str, second: str, *, ratio: float, carrier: str | None = None) -> Gear:
        """Couples the angles of two bodies; see :class:`~vfife.model.joints.Gear`."""
        raise NotImplementedError

    @adds("spring", Spring)
    def spring(
        self, name: str, first: str, second: str, *, stiffness: Quantity = 0.0, damping: Quantity = 0.0, free_length: Quantity | None = None
    ) -> Spring:
        """Adds a spring and damper between two pins; see :class:`~vfife.model.springs.Spring`."""
        raise NotImplementedError

    @adds("spring", TorsionalSpring)
    def torsional_spring(
        self, name: str, first: str, second: str, *, stiffness: Quantity = 0.0, damping: Quantity = 0.0, free_angle: Quantity | None = None
    ) -> TorsionalSpring:
        """Adds a torsional spring and damper between two bodies; see :class:`~vfife.model.springs.TorsionalSpring`."""
        raise NotImplementedError

    @adds("spring", Stop)
    def stop(
        self, name: str, first: str, second: str, *, low: Quantity, high: Quantity, stiffness: Quantity, damping: Quantity = 0.0
    ) -> Stop:  # fmt: skip
        """Adds a rotational stop between two bodies; see :class:`~vfife.model.springs.Stop`."""
        raise NotImplementedError

    @adds("spring", Bushing)
    def bushing(self, name: str, first: str, second: str, *, stiffness: Place, damping: Place = (0.0, 0.0, 0.0)) -> Bushing:
        """Adds an elastic bearing between two pins; see :class:`~vfife.model.springs.Bushing`."""
        raise NotImplementedError
