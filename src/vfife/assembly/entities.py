"""What bodies, joints, gears, drivers, contacts, springs and loads are to the kernels: particles, kinds,
places on particles, functions.
"""

from __future__ import annotations

import itertools
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from ..errors import VfifeError
from ..kernels import topology
from ..kinematics.batch import Shared
from ..kinematics.drives import constraint_drivers, guide_of, kinematic_drivers, pivot_of, spinless
from ..kinematics.forces import actions, driven_body, kind_of_spring
from ..kinematics.initial import Motion
from ..kinematics.pins import local_point
from ..kinematics.rows import PLACE_KINDS
from ..model.functions import carrier_of, motion_function
from ..model.geometry.path import Path
from ..model.geometry.polynomials import Polynomials
from ..model.joints import Contact, Joint
from ..model.lumping import Mesh, is_elastic, mesh, rigid_properties
from ..model.mechanism import Mechanism
from ..model.rows import (
    AlongGuide,
    FixedDistance,
    Guided,
    OnPath,
    Row,
    Touching,
    Turn,
    loosened,
    place_row,
    turn_row,
)
from ..model.springs import AnySpring
from .assembled import BodyMap

STRAINS = {"current": topology.CURRENT, "reference": topology.REFERENCE}
Side = tuple[str, str]
Place = tuple[int, tuple[float, float]]


class Numbering:
    """Particles, elements and functions in their order; particle 0 is the ground. ``shared``: results for
    mechanisms with the same objects.
    """

    def __init__(self, mechanism: Mechanism, shared: Shared | None = None) -> None:
        self.mechanism = mechanism
        self.bodies: dict[str, BodyMap] = {}
        self.meshes: dict[str, Mesh] = {}
        self.free: list[int] = []
        self.driven: list[str] = []
        self.elements: list[tuple[int, int]] = []
        self.releases: list[int] = []
        self.strains: list[int] = []
        self.functions: list[Polynomials] = []
        self.arguments: list[tuple[int, int, int]] = []
        self.travels: dict[int, tuple[float, ...]] = {}
        self.count = 1
        self.drivers = kinematic_drivers(mechanism)
        self.pivots = {name: pivot_of(mechanism, name) for name in self.drivers}
        self.spinless = spinless(mechanism)
        self.shared = shared or Shared()
        for row, name in enumerate(mechanism.bodies):
            self._body(name, row, name in self.drivers)

    def alike(self, mechanism: Mechanism) -> Numbering:
        """Return the numbering of a mechanism of the same structure, which has its own numbers and functions
        and shares everything else.
        """
        result = copy(self)
        result.mechanism, result.functions, result.arguments, result.travels = mechanism, [], [], {}
        result.drivers = {name: mechanism.drivers[key] for name, key in self.driver_names.items()}
        changed = {
            name: body for name, body in mechanism.bodies.items() if body is not self.mechanism.bodies[name]
        }
        if changed:
            result.bodies, result.meshes = dict(self.bodies), dict(self.meshes)
        for name, body in changed.items():
            if name in self.meshes:
                result.meshes[name] = mesh(body)
            mass, center, inertia = rigid_properties(body)
            pivot = self._pivot(name)
            result.bodies[name] = changed_map = copy(self.bodies[name])
            vars(changed_map).update(
                mass=mass, inertia=inertia, center=center, pins=dict(body.points),
                reference=center if pivot is None else local_point(mechanism, pivot),
            )  # fmt: skip
        return result

    @cached_property
    def driver_names(self) -> dict[str, str]:
        """Names of the drivers that turn bodies, by body."""
        names = {id(driver): name for name, driver in self.mechanism.drivers.items()}
        return {body: names[id(driver)] for body, driver in self.drivers.items()}

    def _pivot(self, name: str) -> Side | None:
        """Return the pivot's side on a driven body; None for a body that is not driven."""
        return (
            next((side for side in self.pivots[name].sides if side[0] == name), None)
            if name in self.drivers
            else None
        )

    def _body(self, name: str, row: int, driven: bool) -> None:
        body = self.mechanism.bodies[name]
        mass, center, inertia = rigid_properties(body)
        pivot = self._pivot(name)
        nodes = dict.fromkeys(body.points, 0)
        count = 1
        if is_elastic(body):
            self.meshes[name] = mesh(body)
            nodes, count = self.meshes[name].pins, len(self.meshes[name].mass)
        particles = tuple(range(self.count, self.count + count))
        self.count += count
        driven_particle = None
        if pivot is not None:
            driven_particle = particles[nodes.get(pivot[1], 0)]
            self.driven.append(name)
        self.free += particles if driven_particle is None else [p for p in particles if p != driven_particle]
        first = len(self.elements)
        if name in self.meshes:
            pairs = self.meshes[name].nodes + particles[0]
            self.elements += zip(pairs[:, 0].tolist(), pairs[:, 1].tolist(), strict=True)
            self.releases += self.meshes[name].release
            self.strains += [STRAINS[self.meshes[name].strain]] * len(pairs)
        reference = center if pivot is None else local_point(self.mechanism, pivot)
        self.bodies[name] = BodyMap(
            name, body.model, particles, tuple(range(first, len(self.elements))), row,
            len(self.driven) - 1 if driven else None, reference, mass, inertia, center, dict(body.points),
            {pin: particles[k] for pin, k in nodes.items()},
        )  # fmt: skip

    def place(self, side: Side) -> Place:
        """Particle that carries a pin, and the pin's place in the particle's frame (m)."""
        local_point(self.mechanism, side)
        return place_of(self.mechanism.points if side[0] == "ground" else self.bodies[side[0]], side)

    def ideal(self, joint: Joint) -> Ideal:
        """Return a joint without clearance, one object for all mechanisms that have it and its bodies."""

        def make() -> Ideal:
            bearing, journal = map(self.place, joint.sides)
            return Ideal(joint.name, self.shared(_restraint, joint, self.spinless), bearing, journal)

        owners = [self.mechanism.points if body == "ground" else self.bodies[body] for body, _ in joint.sides]
        return self.shared.recall("ideal", (joint, *owners, self.spinless), make)

    def particle(self, body: str) -> int:
        """Particle that stands for a body where its angle is meant: its one or first; 0 for the ground."""
        return 0 if body == "ground" else self.bodies[body].particles[0]

    def driven_particle(self, name: str) -> int:
        """Particle of a driven body whose rotation is prescribed."""
        pivot = next(side for side in self.pivots[name].sides if side[0] == name)
        return self.bodies[name].nodes.get(pivot[1], self.bodies[name].particles[0])

    def function(self, polynomials: Polynomials, argument: tuple[int, int, int] = (0, 0, 0)) -> int:
        """Index of a function of time, or of the angle or speed between two particles."""
        self.functions.append(polynomials)
        self.arguments.append(argument)
        return len(self.functions) - 1


def place_of(owner: Any, side: Side) -> Place:
    """Return the place of a pin of a body (a BodyMap), or of a point of the ground (points by name)."""
    if side[0] == "ground":
        return 0, owner[side[1]]
    if owner.elements:
        if side[1] not in owner.nodes:
            pins = ", ".join(owner.nodes)
            raise VfifeError(
                f"pin {side[0]}.{side[1]}: this {owner.model} body has pins at {pins} only; make it"
                " rigid, or split it there"
            )
        return owner.nodes[side[1]], (0.0, 0.0)
    point = owner.pins[side[1]]
    return owner.particles[0], (point[0] - owner.reference[0], point[1] - owner.reference[1])


def armed(place: Place) -> bool:
    """Return whether a place is off the centre of a moving particle."""
    return place[0] > 0 and place[1] != (0.0, 0.0)


GEOMETRIES = {
    "bearing": topology.BEARING,
    "round": topology.ROUND,
    "line": topology.LINE,
    "slot": topology.SLOT,
}


class Restraint(NamedTuple):
    """What the ``rows`` of an ideal joint hold: its ``place`` and ``turn``, as the kernels call them, the
    turns of the journal's body for one of the bearing's (``ratio``), the ``direction`` of a guide in the
    bearing's frame, the ``length`` of a massless link (m), else 0, and the ``path`` that it keeps to.
    """

    rows: tuple[Row, ...]
    place: int
    turn: int
    ratio: float
    direction: tuple[float, float]
    length: float
    path: Path | None

    @classmethod
    def by(cls, rows: tuple[Row, ...], drive: bool = False) -> Restraint:
        """Return what rows hold; ``drive``: whether a function of time gives their motion."""
        place, turn = place_row(rows), turn_row(rows)
        kind, ratio = PLACE_KINDS[type(place)], 1.0 if turn is None else turn.ratio
        # A gear's ratio is data, also at 1.
        geared = ratio != 1.0 or (kind == topology.UNPLACED and not drive)
        return cls(
            rows,
            kind,
            topology.FREE if turn is None else topology.GEARED if geared else topology.LOCKED,
            ratio,
            place.unit() if isinstance(place, Guided) else (1.0, 0.0),
            place.length if isinstance(place, FixedDistance) else 0.0,
            place.path if isinstance(place, OnPath) else None,
        )


@dataclass(frozen=True)
class Ideal:
    """An ideal joint, gear or prescribed motion: what its rows hold, its two places, the function of a
    prescribed motion, the carrier of gears.
    """

    name: str
    restraint: Restraint
    bearing: Place
    journal: Place
    function: int = -1
    carrier: int = 0

    @cached_property
    def structure(self) -> tuple[Any, ...]:
        """All of it that the topology depends on."""
        restraint, (bearing, _), (journal, _) = self.restraint, self.bearing, self.journal
        pieces = None if restraint.path is None else len(restraint.path.pieces)
        particles = bearing, armed(self.bearing), journal, armed(self.journal), self.carrier
        return (*particles, restraint.place, restraint.turn, self.function, pieces)

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """Places of bearing and journal (m), direction of a guide, ratio, and length (m)."""
        return (
            *self.bearing[1],
            *self.journal[1],
            *self.restraint.direction,
            self.restraint.ratio,
            self.restraint.length,
        )


class Touch(NamedTuple):
    """One contact: its name, the joint it belongs to, its two places, and what its noun says of it."""

    name: str
    joint: Contact
    bearing: Place
    journal: Place
    touching: Touching

    @property
    def structure(self) -> tuple[Any, ...]:
        """All of it that the topology depends on, except its laws."""
        path = self.touching.path
        pieces = None if path is None else len(path.pieces)
        particles = self.bearing[0], armed(self.bearing), self.journal[0], armed(self.journal)
        wear = self.joint.wear is not None, self.harmonics
        return (*particles, self.touching.geometry, pieces, *wear, len(self.joint.contact.knots()))

    @property
    def harmonics(self) -> tuple[int, int]:
        """How many harmonics the worn profiles of its bearing and its journal have."""
        return (0, 0) if self.joint.wear is None else self.joint.wear.harmonics

    @property
    def kind(self) -> int:
        """Its geometry, as the kernels call it."""
        return GEOMETRIES[self.touching.geometry]


class Load(NamedTuple):
    """A force and a moment per unit of a function, at a place of a particle."""

    place: Place
    function: int
    force: tuple[float, float]
    moment: float
    follow: bool = False


def ideal_joints(mechanism: Mechanism, numbering: Numbering) -> list[Ideal]:
    """Joints without clearance that are no pivots of driven bodies, then gears, then drivers of anything else
    than a body on its pivot.
    """
    pivots = {joint.name for joint in numbering.pivots.values()}
    result = []
    for joint in mechanism.joints.values():
        if joint.name not in pivots and not isinstance(joint, Contact):
            result.append(numbering.ideal(joint))
    for gear in mechanism.gears.values():
        ends = [(numbering.particle(body), (0.0, 0.0)) for body in (gear.first, gear.second)]
        carrier = numbering.particle(carrier_of(mechanism, gear))
        result.append(Ideal(gear.name, Restraint.by(gear.rows()), ends[0], ends[1], carrier=carrier))
    for name, driver in constraint_drivers(mechanism).items():
        function = numbering.function(motion_function(driver, 0.0, mechanism.clock))
        rows: tuple[Row, ...] = (AlongGuide(driver.direction),)
        if driver.slider and (guided := guide_of(mechanism, driver.slider)):
            rows = (AlongGuide(guided[1].direction),)
            ends = [numbering.place(side) for side in guided[0].sides]
        elif driver.point:
            body, _, pin = driver.point.partition(".")
            ends = [(0, (0.0, 0.0)), numbering.place((body, pin))]
        else:
            rows = (Turn(),)
            bodies = driver.against, driven_body(name, driver)
            ends = [(numbering.particle(body), (0.0, 0.0)) for body in bodies]
        result.append(Ideal(name, Restraint.by(rows, drive=True), ends[0], ends[1], function))
    return result


def _restraint(joint: Joint, spinless: frozenset[str]) -> Restraint:
    """Return what a joint without clearance holds; a particle without inertia has no angle to keep."""
    idle = any(owner in spinless for owner, _ in joint.sides)
    return Restraint.by(loosened(joint.rows()) if idle else joint.rows())


def contacts(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Touch]:
    """Every place where journal and bearing can touch; where a joint has several they are numbered,
    ``joint.1`` and on.
    """
    result = []
    angles = {**dict(zip(motion.names, motion.position[:, 2].tolist(), strict=True)), "ground": 0.0}
    for name, joint in mechanism.contacts.items():
        bearing, journal = map(numbering.place, joint.sides)
        (first, _), (second, _) = joint.sides
        result += touches_of(name, joint, bearing, journal, angles[first] - angles[second])
    return result


def touches_of(name: str, joint: Contact, bearing: Place, journal: Place, turned: float) -> list[Touch]:
    """Return the contacts of a joint between two places; ``turned`` (rad) is the angle of the bearing's body
    less that of the journal's body, at the start.
    """
    all_of_them = joint.touchings(turned)
    result = []
    for k, touching in enumerate(all_of_them, start=1):
        at = (journal[0], (journal[1][0] + touching.offset[0], journal[1][1] + touching.offset[1]))
        result.append(Touch(f"{name}.{k}" if len(all_of_them) > 1 else name, joint, bearing, at, touching))
    return result


def spring_places(numbering: Numbering, spring: AnySpring) -> tuple[Place, Place]:
    """Pins of a spring or bushing, or the particles that stand for two bodies."""
    if spring.between_pins:
        first, second = (
            numbering.place((body, pin))
            for body, _, pin in (end.partition(".") for end in (spring.first, spring.second))
        )
        return first, second
    return (numbering.particle(spring.first), (0.0, 0.0)), (numbering.particle(spring.second), (0.0, 0.0))


@dataclass(frozen=True)
class Parts:
    """All of them; springs as (noun, kind, first, second), ``driven`` the functions of driven angles, -1 at
    constant speed.
    """

    ideals: list[Ideal]
    touches: list[Touch]
    springs: list[tuple[AnySpring, int, Place, Place]]
    driven: tuple[int, ...]
    loads: list[Load]

    @property
    def structure(self) -> tuple[Any, ...]:
        """All of it that the topology depends on, except laws."""
        springs = [
            (kind, first[0], armed(first), second[0], armed(second))
            for _, kind, first, second in self.springs
        ]
        loads = [(load.place[0], armed(load.place), load.function, load.follow) for load in self.loads]
        parts = (joint.structure for joint in self.ideals), (touch.structure for touch in self.touches)
        return (*map(tuple, parts), tuple(springs), self.driven, tuple(loads))

    @property
    def paths(self) -> list[Path]:
        """The paths of ideal joints, then those of contacts."""
        paths = (
            *(joint.restraint.path for joint in self.ideals),
            *(touch.touching.path for touch in self.touches),
        )
        return [path for path in paths if path is not None]

    def numbered(self) -> tuple[int, ...]:
        """Index of the path of each ideal joint, then of each contact; -1 for none."""
        count = itertools.count()
        paths = (
            *(joint.restraint.path for joint in self.ideals),
            *(touch.touching.path for touch in self.touches),
        )
        return tuple(-1 if path is None else next(count) for path in paths)


def parts_of(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> Parts:
    """Return the entities of a mechanism, in the order of the model."""
    return Parts(
        ideal_joints(mechanism, numbering),
        contacts(mechanism, numbering, motion),
        [
            (spring, kind_of_spring(spring), *spring_places(numbering, spring))
            for spring in mechanism.springs.values()
        ],
        tuple(driven_function(mechanism, numbering, motion, name) for name in numbering.driven),
        loads(mechanism, numbering, motion),
    )


def turning(numbering: Numbering, parts: Parts) -> tuple[int, ...]:
    """Particles whose direction is needed: those with arms, driven ones, those that carry a guide, a wall or
    a following load.
    """
    ideals, touches, springs, applied = parts.ideals, parts.touches, parts.springs, parts.loads
    places = [place for joint in ideals for place in (joint.bearing, joint.journal)]
    places += [place for touch in touches for place in (touch.bearing, touch.journal)]
    places += [place for spring in springs for place in spring[2:4]] + [load.place for load in applied]
    turned = {place[0] for place in places if armed(place)}
    turned |= {
        j.bearing[0]
        for j in ideals
        if j.restraint.place in (topology.ACROSS_LINE, topology.ALONG_LINE, topology.ON_PATH)
    } | {t.bearing[0] for t in touches if t.kind in (topology.LINE, topology.SLOT)}
    turned |= {
        place[0]
        for t in touches
        for place, count in zip((t.bearing, t.journal), t.harmonics, strict=True)
        if count
    }
    turned |= {s[2][0] for s in springs if s[1] == topology.BUSHING} | {
        load.place[0] for load in applied if load.follow
    }
    turned |= {numbering.bodies[name].particles[0] for name in numbering.driven} | {
        numbering.driven_particle(name) for name in numbering.driven
    }
    return tuple(sorted(turned - {0}))


def driven_function(mechanism: Mechanism, numbering: Numbering, motion: Motion, name: str) -> int:
    """Return the index of the function of a driven body's angle; -1 at constant speed."""
    driver = numbering.drivers[name]
    if driver.steady_speed is not None:
        return -1
    start = motion.datum.angle.get(name, mechanism.bodies[name].angle)
    return numbering.function(motion_function(driver, start, mechanism.clock))


def loads(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Load]:
    """Return the loads at pins, and the torques or forces of drivers with their reactions."""
    result = []
    for action in actions(mechanism, numbering.shared):
        kind, *bodies = action.argument
        guide = action.guide
        first, second = (
            ((numbering.particle(body), (0.0, 0.0)) for body in bodies)
            if guide is None
            else (numbering.place(side) for side in zip(bodies, guide.pins, strict=True))
        )
        function = numbering.function(action.function, (kind, first[0], second[0]))
        if guide is not None:
            numbering.travels[function] = (*first[1], *second[1], *guide.direction, guide.gap)
        for body, pin, (fx, fy, moment) in action.ends:
            place = numbering.place((body, pin)) if pin else (numbering.particle(body), (0.0, 0.0))
            result.append(Load(place, function, (fx, fy), moment, action.follow))
    return result
