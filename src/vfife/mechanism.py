"""The mechanism: what a user builds. It holds nouns and plain numbers in SI units, and no arrays."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

from .bodies import Body, Link, PointMass, RigidBody
from .drivers import ConstantSpeed, Driver
from .joints import ClearanceRevolute, IdealRevolute, Joint
from .loads import PointForce

StartMode = Literal["consistent", "rough"]
Journals = Literal["centred", "seated"]
AnyBody = TypeVar("AnyBody", bound=Body)
AnyJoint = TypeVar("AnyJoint", bound=Joint)


@dataclass(frozen=True)
class Start:
    """How a run starts.

    ``consistent``: closed positions, velocities and accelerations of the ideal mechanism, elastic links already carrying the forces that go
    with them. ``rough``: positions and velocities only, links unstressed. Journals are ``centred`` in their bearings, or ``seated`` where
    the ideal reaction presses them.
    """

    mode: StartMode = "consistent"
    journals: Journals = "centred"


@dataclass(frozen=True)
class Settings:
    """Defaults of a run: length in crank ``turns`` or ``duration`` (s), step (s or "auto"), outputs per turn (or per run without a crank)."""

    turns: float | None = None
    duration: float | None = None
    step: float | Literal["auto"] = "auto"
    outputs: int = 720
    damping: float = 0.0
    path_unit: int = 1


@dataclass
class Mechanism:
    """Bodies, joints, drivers and loads by name; all numbers in SI units.

    >>> m = Mechanism("pendulum", gravity=(0.0, -9.81))
    >>> m.point("pivot", 0.0, 0.0)
    >>> _ = m.link("rod", length=1.0, mass=1.0)
    >>> _ = m.revolute("A", "ground.pivot", "rod.start")
    """

    name: str = "mechanism"
    note: str = ""
    gravity: tuple[float, float] = (0.0, 0.0)
    points: dict[str, tuple[float, float]] = field(default_factory=dict)
    bodies: dict[str, Body] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    drivers: dict[str, Driver] = field(default_factory=dict)
    loads: dict[str, PointForce] = field(default_factory=dict)
    start: Start = field(default_factory=Start)
    settings: Settings = field(default_factory=Settings)
    source: str | None = field(default=None, compare=False)

    def point(self, name: str, x: float, y: float) -> None:
        """A point of the ground (m)."""
        self.points[name] = (float(x), float(y))

    def link(self, name: str, *, length: float, **options: Any) -> Link:
        """Adds a link; ``model`` = "rigid", "elastic" or "two-particle", the rest as in :class:`~vfife.bodies.Link`."""
        if "model" in options:
            options["link_model"] = options.pop("model")
        return self._add_body(Link(name=name, length=length, **options))

    def rigid_body(self, name: str, *, mass: float, inertia: float, **options: Any) -> RigidBody:
        """Adds a rigid body with any number of pins; see :class:`~vfife.bodies.RigidBody`."""
        return self._add_body(RigidBody(name=name, mass=mass, inertia=inertia, **options))

    def point_mass(self, name: str, *, mass: float, **options: Any) -> PointMass:
        """Adds a particle; see :class:`~vfife.bodies.PointMass`."""
        return self._add_body(PointMass(name=name, mass=mass, **options))

    def revolute(self, name: str, bearing: str, journal: str) -> IdealRevolute:
        """Adds an ideal revolute joint between two pins, each ``body.pin`` or ``ground.point``."""
        return self._add_joint(IdealRevolute(name=name, bearing=bearing, journal=journal))

    def clearance(self, name: str, bearing: str, journal: str, **options: Any) -> ClearanceRevolute:
        """Adds a revolute joint with clearance; options as in :class:`~vfife.joints.ClearanceRevolute`."""
        return self._add_joint(ClearanceRevolute(name=name, bearing=bearing, journal=journal, **options))

    def drive(self, body: str, *, speed: float) -> ConstantSpeed:
        """Turns a body at constant speed (rad/s) about its ideal joint to the ground; other drivers go to :attr:`drivers`."""
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

    @property
    def clearances(self) -> dict[str, ClearanceRevolute]:
        """The joints with clearance."""
        return {name: joint for name, joint in self.joints.items() if isinstance(joint, ClearanceRevolute)}

    def ideal(self) -> Mechanism:
        """The reference that clearance runs are compared with: every joint ideal, every link rigid with its lumped masses."""
        from .lumping import rigidified

        return dataclasses.replace(
            self,
            name=f"{self.name}, ideal",
            bodies={name: rigidified(body) for name, body in self.bodies.items()},
            joints={name: IdealRevolute(name=name, bearing=joint.bearing, journal=joint.journal) for name, joint in self.joints.items()},
            settings=dataclasses.replace(self.settings, step="auto", damping=0.0),
            start=Start(),
        )
