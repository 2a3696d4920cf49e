"""The mechanism: what a user builds. It holds nouns and plain numbers in SI units, and no arrays."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import ClassVar, Literal, TypeVar, Unpack

from ..fields import PLACE, SCALAR, Choice, Each, Entries, Inner, Many, Measure, Names, Text, Whole, described, quantity
from .bodies import Body, Frame, Link, Member, Point, PointMass, RigidBody
from .drivers import ConstantSpeed, Driver
from .joints import ClearanceRevolute, ClearanceSlider, Contact, Distance, ExternalContact, Gear, IdealRevolute, Joint, Slider, Weld
from .loads import Load
from .options import (
    ClearanceSliderOptions,
    ContactOptions,
    DistanceOptions,
    ExternalContactOptions,
    FrameOptions,
    LinkOptions,
    PointMassOptions,
    RigidBodyOptions,
    SliderOptions,
)
from .springs import AnySpring, Bushing, ForceElement, Spring, Stop, TorsionalSpring

StartMode = Literal["consistent", "rough"]
Triple = tuple[float, float, float]
STATIC = ("static",)
MOST_COMPANIONS = 7  # with the run itself they fill the widest vector register
Journals = Literal["centred", "seated"]
AnyBody = TypeVar("AnyBody", bound=Body)
AnyJoint = TypeVar("AnyJoint", bound=Joint)
OneSpring = TypeVar("OneSpring", Spring, TorsionalSpring, Stop, Bushing)


@dataclass(frozen=True)
class StartSettings:
    """How a run starts.

    ``consistent``: closed positions, velocities and accelerations of the ideal mechanism, elastic links already carrying the forces that go
    with them. ``rough``: positions and velocities only, links unstressed. Journals are ``centred`` in their bearings, or ``seated`` where
    the ideal reaction presses them.
    """

    mode: StartMode = described(
        Choice(("consistent", "rough")),
        "consistent: ideal velocities and accelerations, links loaded to match; rough: not loaded",
        "consistent",
    )
    journals: Journals = described(
        Choice(("centred", "seated")), "journals centred in their bearings, or seated where the ideal reaction presses them", "centred"
    )


Start = StartSettings  # as it was called before


@dataclass(frozen=True)
class Settings:
    """Defaults of a run: length in crank ``turns`` or ``duration`` (s), step (s or "auto"), outputs per turn (or per run without a crank).

    ``settle``: the run ends as soon as turns repeat within that share of their largest values, after ``turns`` at the latest.
    ``companions`` are runs beside it whose steps are displaced: their range tells how far a run with contact can be trusted, and an automatic
    step is halved until the largest values of a turn agree within ``tolerance``.

    A static ``analysis`` finds equilibrium under each of the ``load_factors``, which take the place of time in loads and drivers: unbalanced force
    at most ``residual`` of the largest force, and kinetic energy at most ``kinetic_energy`` of the largest met, in so many ``iterations``.
    """

    selected_by: ClassVar[str] = "analysis"  # the field that says which others are of use

    turns: float | None = quantity("1", "length of the run in turns of the crank", None, above=0.0)
    duration: float | None = quantity("s", "length of the run in time, instead of turns", None, above=0.0)
    settle: float | None = quantity(
        "1", "distance, as a share of the largest values, within which turns repeat: the run ends where they do, after turns at the latest",
        None, above=0.0, high=1.0,
    )  # fmt: skip
    step: float | Literal["auto"] = described(
        Measure("s", above=0.0, words=("auto",)), 'time step, or "auto" for the largest that is stable and accurate', "auto"
    )
    outputs: int = described(Whole(1, 100_000_000), "outputs per turn; per run without a crank", 720)
    parts: int = described(
        Whole(1, 64), "smaller steps in which a step is taken again when something begins, ends or changes in it; 1: as it is, as in the paper", 8
    )
    companions: int | Literal["auto"] = described(
        Whole(0, MOST_COMPANIONS, words=("auto",)), 'runs with displaced steps beside it, or "auto" for as many as cost nothing; 0 for none', "auto"
    )
    tolerance: float = quantity("1", "range over the companions at which an automatic step is fine enough", 0.005, above=0.0, high=1.0)
    energy_limit: float = quantity(
        "1", "share of the largest energy by which the ledger may be open; a run in which it is more is stopped", 0.1, above=0.0
    )
    damping: float = quantity("1/s", "mass-proportional damping", 0.0, low=0.0)
    path_unit: int = described(Whole(1, 1_000_000), "steps in a path unit of the elements", 1)
    analysis: Literal["dynamic", "static"] = described(
        Choice(("dynamic", "static")), "dynamic: motion over time; static: equilibrium under each of the load factors", "dynamic"
    )
    load_factors: tuple[float, ...] = described(
        Many(SCALAR), "of a static analysis: they take the place of time in loads and drivers", (1.0,), only=STATIC
    )
    residual: float = quantity(
        "1", "of a static analysis: largest unbalanced force, as a share of the largest force", 1e-6, above=0.0, high=0.1, only=STATIC
    )
    kinetic_energy: float = quantity(
        "1", "of a static analysis: largest kinetic energy left, as a share of the largest met", 1e-10, above=0.0, high=0.1, only=STATIC
    )
    iterations: int = described(Whole(1, 1_000_000_000), "of a static analysis: most iterations for a load factor", 1_000_000, only=STATIC)


@dataclass
class Mechanism:
    """Bodies, joints, drivers and loads by name; all numbers in SI units.

    >>> m = Mechanism("pendulum", gravity=(0.0, -9.81))
    >>> m.point("pivot", 0.0, 0.0)
    >>> _ = m.link("rod", length=1.0, mass=1.0)
    >>> _ = m.revolute("A", "ground.pivot", "rod.start")
    """

    name: str = described(Text(), "name of the model", "mechanism")
    note: str = described(Text(), "what a reader should know", "")
    gravity: tuple[float, float] = described(Each((Measure("m/s^2"), Measure("m/s^2"))), "acceleration of gravity", (0.0, 0.0))
    points: dict[str, tuple[float, float]] = described(Names(PLACE), "points of the ground", factory=dict, key="ground")
    bodies: dict[str, Body] = described(Entries(Body), "bodies by name", factory=dict, key="body")
    joints: dict[str, Joint] = described(Entries(Joint), "joints by name", factory=dict, key="joint")
    drivers: dict[str, Driver] = described(
        Entries(Driver), "drivers by name, which is that of the body unless body, slider or point is given", factory=dict, key="driver"
    )
    loads: dict[str, Load] = described(Entries(Load), "loads by name", factory=dict, key="load")
    gears: dict[str, Gear] = described(Entries(Gear), "gears and belts by name", factory=dict, key="gear")
    springs: dict[str, AnySpring] = described(Entries(ForceElement), "springs, dampers, stops and bushings by name", factory=dict, key="spring")
    start: StartSettings = described(Inner(StartSettings), "how a run starts", factory=StartSettings)
    settings: Settings = described(Inner(Settings), "defaults of a run", factory=Settings, key="run")
    source: str | None = field(default=None, compare=False)

    def point(self, name: str, x: float, y: float) -> None:
        """A point of the ground (m)."""
        if name in self.points:
            raise ValueError(f"there is a point called {name!r} already")
        self.points[name] = (float(x), float(y))

    def link(self, name: str, *, length: float, **options: Unpack[LinkOptions]) -> Link:
        """Adds a link; ``model`` = "rigid", "elastic" or "two-particle", the rest as in :class:`~vfife.model.bodies.Link`."""
        return self._add_body(Link(name=name, length=length, **options))

    def rigid_body(self, name: str, *, mass: float, inertia: float, **options: Unpack[RigidBodyOptions]) -> RigidBody:
        """Adds a rigid body with any number of pins; see :class:`~vfife.model.bodies.RigidBody`."""
        return self._add_body(RigidBody(name=name, mass=mass, inertia=inertia, **options))

    def point_mass(self, name: str, *, mass: float, **options: Unpack[PointMassOptions]) -> PointMass:
        """Adds a particle; see :class:`~vfife.model.bodies.PointMass`."""
        return self._add_body(PointMass(name=name, mass=mass, **options))

    def frame(self, name: str, *, nodes: dict[str, Point], members: tuple[Member, ...], **options: Unpack[FrameOptions]) -> Frame:
        """Adds a frame of welded elastic members; see :class:`~vfife.model.bodies.Frame`."""
        return self._add_body(Frame(name=name, nodes=nodes, members=members, **options))

    def revolute(self, name: str, bearing: str, journal: str) -> IdealRevolute:
        """Adds an ideal revolute joint between two pins, each ``body.pin`` or ``ground.point``."""
        return self._add_joint(IdealRevolute(name=name, bearing=bearing, journal=journal))

    def clearance(
        self, name: str, bearing: str, journal: str, *, clearance: float, bearing_radius: float, **options: Unpack[ContactOptions]
    ) -> ClearanceRevolute:
        """Adds a revolute joint with clearance; options as in :class:`~vfife.model.joints.ClearanceRevolute`."""
        return self._add_joint(
            ClearanceRevolute(name=name, bearing=bearing, journal=journal, clearance=clearance, bearing_radius=bearing_radius, **options)
        )

    def slider(self, name: str, bearing: str, journal: str, **options: Unpack[SliderOptions]) -> Slider:
        """Adds an ideal slider: the journal's pin moves along a guide through the bearing's; see :class:`~vfife.model.joints.Slider`."""
        return self._add_joint(Slider(name=name, bearing=bearing, journal=journal, **options))

    def clearance_slider(
        self, name: str, bearing: str, journal: str, *, clearance: float, length: float, height: float, **options: Unpack[ClearanceSliderOptions]
    ) -> ClearanceSlider:
        """Adds a block with play in a guide; see :class:`~vfife.model.joints.ClearanceSlider`."""
        return self._add_joint(
            ClearanceSlider(name=name, bearing=bearing, journal=journal, clearance=clearance, length=length, height=height, **options)
        )

    def weld(self, name: str, bearing: str, journal: str) -> Weld:
        """Joins two bodies rigidly at a pin of each; with the ground it is a clamp."""
        return self._add_joint(Weld(name=name, bearing=bearing, journal=journal))

    def distance(self, name: str, bearing: str, journal: str, *, length: float, **options: Unpack[DistanceOptions]) -> Distance:
        """Adds a rigid link without mass between two pins; see :class:`~vfife.model.joints.Distance`."""
        return self._add_joint(Distance(name=name, bearing=bearing, journal=journal, length=length, **options))

    def external_contact(
        self, name: str, bearing: str, journal: str, *, journal_radius: float, **options: Unpack[ExternalContactOptions]
    ) -> ExternalContact:
        """Adds a contact between a round pin and a line or another round; see :class:`~vfife.model.joints.ExternalContact`."""
        return self._add_joint(ExternalContact(name=name, bearing=bearing, journal=journal, journal_radius=journal_radius, **options))

    def gear(self, name: str, first: str, second: str, *, ratio: float, carrier: str | None = None) -> Gear:
        """Couples the angles of two bodies; see :class:`~vfife.model.joints.Gear`."""
        if name in self.gears:
            raise ValueError(f"there is a gear called {name!r} already")
        self.gears[name] = Gear(name=name, first=first, second=second, ratio=ratio, carrier=carrier)
        return self.gears[name]

    def spring(
        self, name: str, first: str, second: str, *, stiffness: float = 0.0, damping: float = 0.0, free_length: float | None = None
    ) -> Spring:
        """Adds a spring and damper between two pins; see :class:`~vfife.model.springs.Spring`."""
        spring = Spring(name=name, first=first, second=second, stiffness=stiffness, damping=damping, free_length=free_length)
        return self._add_spring(spring)

    def torsional_spring(
        self, name: str, first: str, second: str, *, stiffness: float = 0.0, damping: float = 0.0, free_angle: float | None = None
    ) -> TorsionalSpring:
        """Adds a torsional spring and damper between two bodies; see :class:`~vfife.model.springs.TorsionalSpring`."""
        spring = TorsionalSpring(name=name, first=first, second=second, stiffness=stiffness, damping=damping, free_angle=free_angle)
        return self._add_spring(spring)

    def stop(self, name: str, first: str, second: str, *, low: float, high: float, stiffness: float, damping: float = 0.0) -> Stop:
        """Adds a rotational stop between two bodies; see :class:`~vfife.model.springs.Stop`."""
        return self._add_spring(Stop(name=name, first=first, second=second, low=low, high=high, stiffness=stiffness, damping=damping))

    def bushing(self, name: str, first: str, second: str, *, stiffness: Triple, damping: Triple = (0.0, 0.0, 0.0)) -> Bushing:
        """Adds an elastic bearing between two pins; see :class:`~vfife.model.springs.Bushing`."""
        return self._add_spring(Bushing(name=name, first=first, second=second, stiffness=stiffness, damping=damping))

    def drive(self, body: str, *, speed: float) -> ConstantSpeed:
        """Turns a body at constant speed (rad/s) about its ideal joint to the ground; other drivers go to :attr:`drivers`."""
        if body in self.drivers:
            raise ValueError(f"there is a driver called {body!r} already")
        driver = ConstantSpeed(body=body, speed=speed)
        self.drivers[body] = driver
        return driver

    def _add_body(self, body: AnyBody) -> AnyBody:
        if body.name in self.bodies or body.name == "ground":
            raise ValueError(f"there is a body called {body.name!r} already")
        self.bodies[body.name] = body
        return body

    def _add_joint(self, joint: AnyJoint) -> AnyJoint:
        if joint.name in self.joints:
            raise ValueError(f"there is a joint called {joint.name!r} already")
        self.joints[joint.name] = joint
        return joint

    def _add_spring(self, spring: OneSpring) -> OneSpring:
        if spring.name in self.springs:
            raise ValueError(f"there is a spring called {spring.name!r} already")
        self.springs[spring.name] = spring
        return spring

    @property
    def clearances(self) -> dict[str, ClearanceRevolute]:
        """The revolute joints with clearance; :attr:`contacts` are all joints with play."""
        return {name: joint for name, joint in self.joints.items() if isinstance(joint, ClearanceRevolute)}

    @property
    def contacts(self) -> dict[str, Contact]:
        """All joints with play: revolutes and sliders with clearance, external contacts."""
        return {name: joint for name, joint in self.joints.items() if isinstance(joint, Contact)}

    def ideal(self) -> Mechanism:
        """The reference that clearance runs are compared with: every joint ideal, every link rigid with its lumped masses."""
        from .lumping import rigidified

        return dataclasses.replace(
            self,
            name=f"{self.name}, ideal",
            bodies={name: rigidified(body) for name, body in self.bodies.items()},
            joints={name: ideal for name, joint in self.joints.items() if (ideal := joint.ideal()) is not None},
            settings=dataclasses.replace(self.settings, step="auto", damping=0.0),
            start=StartSettings(),
        )
