"""What a mechanism's joints, gears, drivers, contacts, springs and loads are to the kernels: kinds, places on particles, functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels.topology import (
    ANGLE,
    BEARING,
    BUSHING,
    GEAR,
    LINE,
    REVOLUTE,
    ROUND,
    SLIDER,
    SLOT,
    TRAVEL,
    WELD,
)
from ..kinematics.drives import constraint_drivers, kinematic_drivers, spinless
from ..kinematics.forces import actions, driven_body, kind_of_spring, unit
from ..kinematics.initial import Motion
from ..model.drivers import ConstantSpeed
from ..model.functions import motion_function
from ..model.joints import ClearanceRevolute, ClearanceSlider, Contact, ExternalContact, IdealRevolute, Joint, Slider, Weld
from ..model.mechanism import Mechanism, idealised
from ..model.springs import Bushing, Spring
from .numbering import Numbering, Place

FACING = (1.0, 0.0)


@dataclass(frozen=True)
class Ideal:
    """An ideal joint, gear or prescribed travel: kind, its two places, direction of a guide in the bearing's frame, ratio and function."""

    name: str
    kind: int
    bearing: Place
    journal: Place
    direction: tuple[float, float] = FACING
    ratio: float = 1.0
    function: int = -1


@dataclass(frozen=True)
class Touch:
    """One contact: the joint it belongs to, kind, places, and where it is a line the direction into its material, in the bearing's frame.

    ``size`` is the distance of the centres where they begin to touch; ``arms`` those of friction on bearing and journal (m).
    """

    name: str
    joint: Contact
    kind: int
    bearing: Place
    journal: Place
    size: float
    arms: tuple[float, float]
    line: tuple[float, float] = FACING


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
            direction = unit(joint.direction) if isinstance(joint, Slider) else FACING
            kind = kind_of_joint(joint)
            if points & {side[0] for side in joint.sides}:  # there is no angle to keep
                kind = {WELD: REVOLUTE, SLIDER: SLOT}.get(kind, kind)
            found.append(Ideal(joint.name, kind, bearing, journal, direction))
    for gear in mechanism.gears.values():
        ends = [(numbering.particle(body), (0.0, 0.0)) for body in (gear.first, gear.second)]
        found.append(Ideal(gear.name, GEAR, ends[0], ends[1], ratio=gear.ratio))
    for name, driver in constraint_drivers(mechanism).items():
        function = numbering.function(motion_function(driver, 0.0))
        if driver.slider:
            joint = idealised(mechanism.joints[driver.slider])
            bearing, journal = (numbering.place(side) for side in joint.sides)
            found.append(Ideal(name, TRAVEL, bearing, journal, unit(joint.direction), function=function))  # type: ignore[attr-defined]
        elif driver.point:
            body, _, pin = driver.point.partition(".")
            found.append(Ideal(name, TRAVEL, (0, (0.0, 0.0)), numbering.place((body, pin)), unit(driver.direction), function=function))
        else:
            ends = [(numbering.particle(body), (0.0, 0.0)) for body in (driver.against, driven_body(name, driver))]
            found.append(Ideal(name, ANGLE, ends[0], ends[1], function=function))
    return found


def kind_of_joint(joint: Joint) -> int:
    """Its constraints."""
    if isinstance(joint, Slider):
        return SLOT if joint.turning else SLIDER
    if isinstance(joint, Weld):
        return WELD
    if isinstance(joint, IdealRevolute):
        return REVOLUTE
    raise TypeError(f"joint {joint.name!r}: {type(joint).__name__} is no ideal joint")


def contacts(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Touch]:
    """Every place where journal and bearing can touch: one for a round joint, four for a block in a guide."""
    found = []
    for name, joint in mechanism.contacts.items():
        bearing, journal = (numbering.place(side) for side in joint.sides)
        if isinstance(joint, ClearanceSlider):
            found += corners(joint, bearing, journal, motion)
        elif isinstance(joint, ExternalContact):
            r = joint.journal_radius
            if joint.bearing_radius is None:
                x, y = unit(joint.direction)
                found.append(Touch(name, joint, LINE, bearing, journal, -r, (0.0, r), (y, -x)))
            else:
                found.append(Touch(name, joint, ROUND, bearing, journal, joint.bearing_radius + r, (-joint.bearing_radius, r)))
        else:
            found.append(in_bearing(joint, bearing, journal))  # type: ignore[arg-type]
    return found


def in_bearing(joint: ClearanceRevolute, bearing: Place, journal: Place) -> Touch:
    """A journal in its bearing."""
    c, big = joint.clearance, joint.bearing_radius
    return Touch(joint.name, joint, BEARING, bearing, journal, c, (big, big - c))


def corners(joint: ClearanceSlider, bearing: Place, journal: Place, motion: Motion) -> list[Touch]:
    """The four corners of a block, rear and front, at the wall to the left of the guide's direction and at that to its right."""
    x, y = unit(joint.direction)
    angles = [0.0 if side[0] == "ground" else float(motion.of(side[0])[0][2]) for side in joint.sides]
    c, s = np.cos(angles[0] - angles[1]), np.sin(angles[0] - angles[1])
    ax, ay = float(c * x - s * y), float(s * x + c * y)  # the guide in the frame of the block's body
    r, found = joint.corner_radius, []
    half, rise = 0.5 * joint.length - r, 0.5 * joint.height
    for number, (along, side) in enumerate(((-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)), start=1):
        p, q = along * half, side * (rise - r)
        at = (journal[1][0] + p * ax - q * ay, journal[1][1] + p * ay + q * ax)
        wall = rise + joint.clearance
        found.append(Touch(f"{joint.name}.{number}", joint, LINE, bearing, (journal[0], at), wall - r, (wall, r), (-side * y, side * x)))
    return found


def spring_places(numbering: Numbering, spring: Any) -> tuple[Place, Place]:
    """Pins of a spring or bushing, or the particles that stand for two bodies."""
    if isinstance(spring, (Spring, Bushing)):
        first, second = (numbering.place((body, pin)) for body, _, pin in (end.partition(".") for end in (spring.first, spring.second)))
        return first, second
    return (numbering.particle(spring.first), (0.0, 0.0)), (numbering.particle(spring.second), (0.0, 0.0))


@dataclass(frozen=True)
class Parts:
    """All of them; springs as (noun, kind, first, second), ``driven`` the functions of driven angles, -1 at constant speed."""

    ideals: list[Ideal]
    touches: list[Touch]
    springs: list[tuple[Any, int, Place, Place]]
    driven: tuple[int, ...]
    loads: list[Load]


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
    armed |= {j.bearing[0] for j in ideals if j.kind in (SLIDER, SLOT, TRAVEL)} | {t.bearing[0] for t in touches if t.kind == LINE}
    armed |= {s[2][0] for s in springs if s[1] == BUSHING} | {load.place[0] for load in applied if load.follow}
    armed |= {numbering.bodies[name].particles[0] for name in numbering.driven} | {numbering.held(name) for name in numbering.driven}
    return tuple(sorted(armed - {0}))


def driven_function(mechanism: Mechanism, numbering: Numbering, motion: Motion, name: str) -> int:
    """Function of a driven body's angle; -1 at constant speed."""
    driver = kinematic_drivers(mechanism)[name]
    if isinstance(driver, ConstantSpeed):
        return -1
    return numbering.function(motion_function(driver, motion.datum.angle.get(name, mechanism.bodies[name].angle)))


def loads(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Load]:
    """Loads at pins, and torques or forces of drivers with their opposites."""
    found = []
    for action in actions(mechanism, motion.datum):
        kind, first, second = action.argument
        function = numbering.function(action.function, (kind, numbering.particle(first), numbering.particle(second)))
        for body, pin, (fx, fy, moment) in action.ends:
            place = numbering.place((body, pin)) if pin else (numbering.particle(body), (0.0, 0.0))
            found.append(Load(place, function, (fx, fy), moment, action.follow))
    return found
