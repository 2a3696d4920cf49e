"""What bodies, joints, gears, drivers, contacts, springs and loads are to the kernels: particles, kinds,
places on particles, functions.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

from ..errors import VfifeError
from ..kernels import topology
from ..kinematics.drives import constraint_drivers, guide_of, kinematic_drivers, pivot_of, spinless
from ..kinematics.forces import actions, driven_body, kind_of_spring
from ..kinematics.initial import Motion
from ..kinematics.pins import local_point
from ..kinematics.rows import PLACE_KINDS
from ..model.functions import carrier_of, motion_function
from ..model.geometry.path import Path
from ..model.geometry.polynomials import Polynomials
from ..model.joints import Contact
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
    """Particles, elements and functions in their order; particle 0 is the ground."""

    def __init__(self, mechanism: Mechanism) -> None:
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
        drivers = kinematic_drivers(mechanism)
        self.pivots = {name: pivot_of(mechanism, name) for name in drivers}
        for row, name in enumerate(mechanism.bodies):
            self._body(name, row, name in drivers)

    def _body(self, name: str, row: int, driven: bool) -> None:
        body = self.mechanism.bodies[name]
        mass, center, inertia = rigid_properties(body)
        pivot = next((side for side in self.pivots[name].sides if side[0] == name), None) if driven else None
        nodes = dict.fromkeys(body.points, 0)
        count = 1
        if is_elastic(body):
            self.meshes[name] = mesh(body)
            nodes, count = self.meshes[name].pins, len(self.meshes[name].mass)
        particles = tuple(range(self.count, self.count + count))
        self.count += count
        held = None
        if pivot is not None:
            held = particles[nodes.get(pivot[1], 0)]
            self.driven.append(name)
        self.free += particles if held is None else [p for p in particles if p != held]
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
        point = local_point(self.mechanism, side)
        if side[0] == "ground":
            return 0, point
        where = self.bodies[side[0]]
        if where.elements:
            if side[1] not in where.nodes:
                pins = ", ".join(where.nodes)
                raise VfifeError(
                    f"pin {side[0]}.{side[1]}: this {where.model} body has pins at {pins} only; make it"
                    " rigid, or split it there"
                )
            return where.nodes[side[1]], (0.0, 0.0)
        return where.particles[0], (point[0] - where.reference[0], point[1] - where.reference[1])

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


GEOMETRIES = {
    "bearing": topology.BEARING,
    "round": topology.ROUND,
    "line": topology.LINE,
    "slot": topology.SLOT,
}


@dataclass(frozen=True)
class Ideal:
    """An ideal joint, gear or prescribed motion: the rows it holds, its two places, the function of a
    prescribed motion, the carrier of gears.
    """

    name: str
    rows: tuple[Row, ...]
    bearing: Place
    journal: Place
    function: int = -1
    carrier: int = 0

    @cached_property
    def place(self) -> int:
        """What place it holds, as the kernels call it."""
        return PLACE_KINDS[type(place_row(self.rows))]

    @cached_property
    def turn(self) -> int:
        """Whether it holds a turn, and of which ratio."""
        row = turn_row(self.rows)
        if row is None:
            return topology.FREE
        return (
            topology.GEARED
            if row.ratio != 1.0 or (self.place == topology.UNPLACED and self.function < 0)
            else topology.LOCKED
        )  # a gear's ratio is data, also at 1

    @cached_property
    def ratio(self) -> float:
        """Turns of the journal's body for one of the bearing's."""
        return 1.0 if (row := turn_row(self.rows)) is None else row.ratio

    @cached_property
    def direction(self) -> tuple[float, float]:
        """Direction of a guide, in the bearing's frame."""
        row = place_row(self.rows)
        return row.unit() if isinstance(row, Guided) else (1.0, 0.0)

    @cached_property
    def length(self) -> float:
        """Length of a massless link (m), else 0."""
        row = place_row(self.rows)
        return row.length if isinstance(row, FixedDistance) else 0.0

    @cached_property
    def path(self) -> Path | None:
        """The path that it keeps to."""
        row = place_row(self.rows)
        return row.path if isinstance(row, OnPath) else None


@dataclass(frozen=True)
class Touch:
    """One contact: its name, the joint it belongs to, its two places, and what its noun says of it."""

    name: str
    joint: Contact
    bearing: Place
    journal: Place
    touching: Touching

    @property
    def harmonics(self) -> tuple[int, int]:
        """How many harmonics the worn profiles of its bearing and its journal have."""
        return (0, 0) if self.joint.wear is None else self.joint.wear.harmonics

    @property
    def kind(self) -> int:
        """Its geometry, as the kernels call it."""
        return GEOMETRIES[self.touching.geometry]


@dataclass(frozen=True)
class Load:
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
    points, result = spinless(mechanism), []
    for joint in mechanism.joints.values():
        if joint.name not in pivots and not isinstance(joint, Contact):
            bearing, journal = (numbering.place(side) for side in joint.sides)
            idle = points & {side[0] for side in joint.sides}  # there is no angle to keep
            result.append(
                Ideal(joint.name, loosened(joint.rows()) if idle else joint.rows(), bearing, journal)
            )
    for gear in mechanism.gears.values():
        ends = [(numbering.particle(body), (0.0, 0.0)) for body in (gear.first, gear.second)]
        result.append(
            Ideal(
                gear.name,
                gear.rows(),
                ends[0],
                ends[1],
                carrier=numbering.particle(carrier_of(mechanism, gear)),
            )
        )
    for name, driver in constraint_drivers(mechanism).items():
        function = numbering.function(motion_function(driver, 0.0, mechanism.clock))
        if driver.slider and (guided := guide_of(mechanism, driver.slider)):
            bearing, journal = (numbering.place(side) for side in guided[0].sides)
            result.append(Ideal(name, (AlongGuide(guided[1].direction),), bearing, journal, function))
        elif driver.point:
            body, _, pin = driver.point.partition(".")
            result.append(
                Ideal(
                    name,
                    (AlongGuide(driver.direction),),
                    (0, (0.0, 0.0)),
                    numbering.place((body, pin)),
                    function,
                )
            )
        else:
            ends = [
                (numbering.particle(body), (0.0, 0.0)) for body in (driver.against, driven_body(name, driver))
            ]
            result.append(Ideal(name, (Turn(),), ends[0], ends[1], function))
    return result


def contacts(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Touch]:
    """Every place where journal and bearing can touch; where a joint has several they are numbered,
    ``joint.1`` and on.
    """
    result = []
    for name, joint in mechanism.contacts.items():
        bearing, journal = (numbering.place(side) for side in joint.sides)
        angles = [0.0 if side[0] == "ground" else float(motion.of(side[0])[0][2]) for side in joint.sides]
        result += touches_of(name, joint, bearing, journal, angles[0] - angles[1])
    return result


def touches_of(name: str, joint: Contact, bearing: Place, journal: Place, turned: float) -> list[Touch]:
    """Return the contacts of a joint between two places; ``turned`` (rad) is the angle of the bearing's body
    less that of the journal's body, at the start.
    """
    all_of_them = joint.touchings(turned)
    result = []
    for k, one in enumerate(all_of_them, start=1):
        at = (journal[0], (journal[1][0] + one.offset[0], journal[1][1] + one.offset[1]))
        result.append(Touch(f"{name}.{k}" if len(all_of_them) > 1 else name, joint, bearing, at, one))
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
    def paths(self) -> list[Path]:
        """The paths of ideal joints, then those of contacts."""
        paths = (*(joint.path for joint in self.ideals), *(touch.touching.path for touch in self.touches))
        return [path for path in paths if path is not None]

    def numbered(self) -> tuple[int, ...]:
        """Index of the path of each ideal joint, then of each contact; -1 for none."""
        count = itertools.count()
        paths = (*(joint.path for joint in self.ideals), *(touch.touching.path for touch in self.touches))
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
    armed = {p for p, at in places if p and at != (0.0, 0.0)}
    armed |= {
        j.bearing[0]
        for j in ideals
        if j.place in (topology.ACROSS_LINE, topology.ALONG_LINE, topology.ON_PATH)
    } | {t.bearing[0] for t in touches if t.kind in (topology.LINE, topology.SLOT)}
    armed |= {
        place[0]
        for t in touches
        for place, count in zip((t.bearing, t.journal), t.harmonics, strict=True)
        if count
    }
    armed |= {s[2][0] for s in springs if s[1] == topology.BUSHING} | {
        load.place[0] for load in applied if load.follow
    }
    armed |= {numbering.bodies[name].particles[0] for name in numbering.driven} | {
        numbering.driven_particle(name) for name in numbering.driven
    }
    return tuple(sorted(armed - {0}))


def driven_function(mechanism: Mechanism, numbering: Numbering, motion: Motion, name: str) -> int:
    """Return the index of the function of a driven body's angle; -1 at constant speed."""
    driver = kinematic_drivers(mechanism)[name]
    if driver.steady_speed is not None:
        return -1
    start = motion.datum.angle.get(name, mechanism.bodies[name].angle)
    return numbering.function(motion_function(driver, start, mechanism.clock))


def loads(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Load]:
    """Return the loads at pins, and the torques or forces of drivers with their reactions."""
    result = []
    for action in actions(mechanism, motion.datum):
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
