"""What a mechanism's joints, gears, drivers, contacts, springs and loads are to the kernels: kinds, places on particles, functions."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from ..kernels.topology import (
    ACROSS,
    ALONG,
    APART,
    BEARING,
    BUSHING,
    FREE,
    GEARED,
    KEPT,
    LINE,
    NOWHERE,
    ON_PATH,
    PINNED,
    ROUND,
    SLOT,
)
from ..kinematics.drives import constraint_drivers, guide_of, kinematic_drivers, spinless
from ..kinematics.forces import actions, driven_body, kind_of_spring
from ..kinematics.initial import Motion
from ..model.functions import carrier_of, motion_function
from ..model.joints import Contact
from ..model.mechanism import Mechanism
from ..model.path import Path
from ..model.rows import Across, Along, Apart, Coincide, Guided, OnPath, Row, Touching, Turn, loosened, place_row, turn_row
from ..model.springs import AnySpring
from .numbering import Numbering, Place

PLACES = {type(None): NOWHERE, Coincide: PINNED, Across: ACROSS, Along: ALONG, OnPath: ON_PATH, Apart: APART}
GEOMETRIES = {"bearing": BEARING, "round": ROUND, "line": LINE, "slot": SLOT}


@dataclass(frozen=True)
class Ideal:
    """An ideal joint, gear or prescribed motion: the rows it holds, its two places, the function of a prescribed motion, the carrier of gears."""

    name: str
    rows: tuple[Row, ...]
    bearing: Place
    journal: Place
    function: int = -1
    carrier: int = 0

    @property
    def place(self) -> int:
        """What place it holds, as the kernels call it."""
        return PLACES[type(place_row(self.rows))]

    @property
    def turn(self) -> int:
        """Whether it holds a turn, and of which ratio."""
        row = turn_row(self.rows)
        if row is None:
            return FREE
        return GEARED if row.ratio != 1.0 or (self.place == NOWHERE and self.function < 0) else KEPT  # a gear's ratio is data, also at 1

    @property
    def ratio(self) -> float:
        """Turns of the journal's body for one of the bearing's."""
        return 1.0 if (row := turn_row(self.rows)) is None else row.ratio

    @property
    def direction(self) -> tuple[float, float]:
        """Direction of a guide, in the bearing's frame."""
        row = place_row(self.rows)
        return row.unit() if isinstance(row, Guided) else (1.0, 0.0)

    @property
    def length(self) -> float:
        """Length of a massless link (m), else 0."""
        row = place_row(self.rows)
        return row.length if isinstance(row, Apart) else 0.0

    @property
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
    """Joints without play that are no pivots of driven bodies, then gears, then drivers of anything else than a body on its pivot."""
    pivots = {joint.name for joint in numbering.pivots.values()}
    points, found = spinless(mechanism), []
    for joint in mechanism.joints.values():
        if joint.name not in pivots and not isinstance(joint, Contact):
            bearing, journal = (numbering.place(side) for side in joint.sides)
            idle = points & {side[0] for side in joint.sides}  # there is no angle to keep
            found.append(Ideal(joint.name, loosened(joint.rows()) if idle else joint.rows(), bearing, journal))
    for gear in mechanism.gears.values():
        ends = [(numbering.particle(body), (0.0, 0.0)) for body in (gear.first, gear.second)]
        found.append(Ideal(gear.name, gear.rows(), ends[0], ends[1], carrier=numbering.particle(carrier_of(mechanism, gear))))
    for name, driver in constraint_drivers(mechanism).items():
        function = numbering.function(motion_function(driver, 0.0, mechanism.clock))
        if driver.slider and (guided := guide_of(mechanism, driver.slider)):
            bearing, journal = (numbering.place(side) for side in guided[0].sides)
            found.append(Ideal(name, (Along(guided[1].direction),), bearing, journal, function))
        elif driver.point:
            body, _, pin = driver.point.partition(".")
            found.append(Ideal(name, (Along(driver.direction),), (0, (0.0, 0.0)), numbering.place((body, pin)), function))
        else:
            ends = [(numbering.particle(body), (0.0, 0.0)) for body in (driver.against, driven_body(name, driver))]
            found.append(Ideal(name, (Turn(),), ends[0], ends[1], function))
    return found


def contacts(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Touch]:
    """Every place where journal and bearing can touch; where a joint has several they are numbered, ``joint.1`` and on."""
    found = []
    for name, joint in mechanism.contacts.items():
        bearing, journal = (numbering.place(side) for side in joint.sides)
        angles = [0.0 if side[0] == "ground" else float(motion.of(side[0])[0][2]) for side in joint.sides]
        found += touches_of(name, joint, bearing, journal, angles[0] - angles[1])
    return found


def touches_of(name: str, joint: Contact, bearing: Place, journal: Place, turned: float) -> list[Touch]:
    """The contacts of a joint at two places; ``turned`` (rad) is the angle of the bearing's body less that of the journal's, at the start."""
    all_of_them = joint.touchings(turned)
    found = []
    for k, one in enumerate(all_of_them, start=1):
        at = (journal[0], (journal[1][0] + one.offset[0], journal[1][1] + one.offset[1]))
        found.append(Touch(f"{name}.{k}" if len(all_of_them) > 1 else name, joint, bearing, at, one))
    return found


def spring_places(numbering: Numbering, spring: AnySpring) -> tuple[Place, Place]:
    """Pins of a spring or bushing, or the particles that stand for two bodies."""
    if spring.between_pins:
        first, second = (numbering.place((body, pin)) for body, _, pin in (end.partition(".") for end in (spring.first, spring.second)))
        return first, second
    return (numbering.particle(spring.first), (0.0, 0.0)), (numbering.particle(spring.second), (0.0, 0.0))


@dataclass(frozen=True)
class Parts:
    """All of them; springs as (noun, kind, first, second), ``driven`` the functions of driven angles, -1 at constant speed."""

    ideals: list[Ideal]
    touches: list[Touch]
    springs: list[tuple[AnySpring, int, Place, Place]]
    driven: tuple[int, ...]
    loads: list[Load]

    @property
    def paths(self) -> list[Path]:
        """The paths of ideal joints, then those of contacts."""
        kept = (*(joint.path for joint in self.ideals), *(touch.touching.path for touch in self.touches))
        return [path for path in kept if path is not None]

    def numbered(self) -> tuple[int, ...]:
        """Index of the path of each ideal joint, then of each contact; -1 for none."""
        count = itertools.count()
        kept = (*(joint.path for joint in self.ideals), *(touch.touching.path for touch in self.touches))
        return tuple(-1 if path is None else next(count) for path in kept)


def parts_of(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> Parts:
    """The parts of a mechanism, in its order."""
    return Parts(
        ideal_joints(mechanism, numbering),
        contacts(mechanism, numbering, motion),
        [(spring, kind_of_spring(spring), *spring_places(numbering, spring)) for spring in mechanism.springs.values()],
        tuple(driven_function(mechanism, numbering, motion, name) for name in numbering.driven),
        loads(mechanism, numbering, motion),
    )


def turning(numbering: Numbering, parts: Parts) -> tuple[int, ...]:
    """Particles whose direction is needed: those with arms, driven ones, those that carry a guide, a wall or a following load."""
    ideals, touches, springs, applied = parts.ideals, parts.touches, parts.springs, parts.loads
    places = [place for joint in ideals for place in (joint.bearing, joint.journal)]
    places += [place for touch in touches for place in (touch.bearing, touch.journal)]
    places += [place for spring in springs for place in spring[2:4]] + [load.place for load in applied]
    armed = {p for p, at in places if p and at != (0.0, 0.0)}
    armed |= {j.bearing[0] for j in ideals if j.place in (ACROSS, ALONG, ON_PATH)} | {t.bearing[0] for t in touches if t.kind in (LINE, SLOT)}
    armed |= {place[0] for t in touches for place, count in zip((t.bearing, t.journal), t.harmonics, strict=True) if count}
    armed |= {s[2][0] for s in springs if s[1] == BUSHING} | {load.place[0] for load in applied if load.follow}
    armed |= {numbering.bodies[name].particles[0] for name in numbering.driven} | {numbering.held(name) for name in numbering.driven}
    return tuple(sorted(armed - {0}))


def driven_function(mechanism: Mechanism, numbering: Numbering, motion: Motion, name: str) -> int:
    """Function of a driven body's angle; -1 at constant speed."""
    driver = kinematic_drivers(mechanism)[name]
    if driver.steady_speed is not None:
        return -1
    start = motion.datum.angle.get(name, mechanism.bodies[name].angle)
    return numbering.function(motion_function(driver, start, mechanism.clock))


def loads(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Load]:
    """Loads at pins, and torques or forces of drivers with their opposites."""
    found = []
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
            found.append(Load(place, function, (fx, fy), moment, action.follow))
    return found
