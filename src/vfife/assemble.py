"""Mechanism -> arrays: numbering, lumped masses, start positions and velocities. With ``fill`` the one module that knows nouns and kernels."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .assembly import Assembly
from .drivers import ConstantSpeed, Torque
from .drives import constraint_drivers, standing
from .fill import Filler
from .functions import Polynomials, constant, motion_function, spline, torque_function
from .joints import ClearanceSlider, Contact, ExternalContact, IdealRevolute, Joint, Slider, Weld
from .kernels.arrays import (
    ANGLE,
    BEARING,
    BUSHING,
    GEAR,
    LINE,
    LINEAR,
    REVOLUTE,
    ROUND,
    SLIDER,
    SLOT,
    SPEED,
    STOP,
    TORSIONAL,
    TRAVEL,
    TURNED,
    WELD,
    Layout,
    Topology,
)
from .laws import ContactLaw, FrictionLaw, Law
from .loading import check
from .mechanism import Mechanism
from .numbering import Numbering, Place
from .prestress import prestress, wanted
from .springs import Bushing, Spring, Stop
from .stability import choose_step, static_choice
from .start import Motion, cautions, ideal_motion, seated

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


def forms(base: type[Law], used: Iterable[Law]) -> tuple[type[Law], ...]:
    """What the data-driven loop can tell apart: the forms of the common laws, so that one compilation serves most models, and of those in use.

    Laws that differ in their parameters only are of one form. The order does not depend on that of the joints.
    """
    common = {law.form() for law in base.registry.values() if law.common}
    more = {type(law).form() for law in used} - common
    return tuple(sorted(common, key=_spelled)) + tuple(sorted(more, key=_spelled))


def _spelled(form: type[Law]) -> str:
    return f"{form.__module__}.{form.__qualname__}"


def assemble(
    mechanism: Mechanism,
    step: float | str | None = None,
    *,
    expected: Mapping[str, float] | None = None,
    beside: Mechanism | None = None,
    **run: Any,
) -> Assembly:
    """Numbers the mechanism and fills its arrays.

    ``step``: s, or "auto"; None takes the mechanism's setting. ``expected``: largest force (N) each joint is expected to carry, for the stable
    step. ``beside``: a mechanism whose laws the loop can do as well, so that both share one compilation. ``run``: ``turns``, ``duration``,
    ``outputs``, ``force_step`` override the settings. Raises ValueError (AssemblyError where links cannot reach, StepError where the step is too
    large) with a sentence that names what is wrong.
    """
    static = mechanism.settings.analysis == "static"
    if static:
        check(mechanism)
    numbering = Numbering(mechanism)
    seats = seated(mechanism)
    motion = ideal_motion(standing(mechanism) if static else mechanism, seats=seats)
    ideals = ideal_joints(mechanism, numbering)
    touches = contacts(mechanism, numbering, motion)
    springs = [(spring, kind_of_spring(spring), *spring_places(numbering, spring)) for spring in mechanism.springs.values()]
    driven = [driven_function(mechanism, numbering, name) for name in numbering.driven]
    applied = loads(mechanism, numbering, motion)
    lawful = [*mechanism.contacts.values(), *(beside.contacts.values() if beside else ())]
    laws = [forms(ContactLaw, [joint.contact for joint in lawful]), forms(FrictionLaw, [joint.friction for joint in lawful])]
    starts, tables = tables_of(numbering.functions)
    topology = Topology(
        particles=numbering.count,
        free=tuple(numbering.free),
        trig=turning(numbering, ideals, touches, springs, applied),
        element_nodes=tuple(numbering.elements),
        element_release=tuple(numbering.releases),
        clearance_bearing=tuple(t.bearing[0] for t in touches),
        clearance_journal=tuple(t.journal[0] for t in touches),
        clearance_kind=tuple(t.kind for t in touches),
        clearance_contact=tuple(laws[0].index(t.joint.contact.form()) for t in touches),
        clearance_friction=tuple(laws[1].index(t.joint.friction.form()) for t in touches),
        ideal_bearing=tuple(j.bearing[0] for j in ideals),
        ideal_journal=tuple(j.journal[0] for j in ideals),
        ideal_kind=tuple(j.kind for j in ideals),
        ideal_function=tuple(j.function for j in ideals),
        spring_first=tuple(s[2][0] for s in springs),
        spring_second=tuple(s[3][0] for s in springs),
        spring_kind=tuple(s[1] for s in springs),
        driven=tuple(numbering.held(name) for name in numbering.driven),
        driven_function=tuple(driven),
        load_particle=tuple(load.place[0] for load in applied),
        load_function=tuple(load.function for load in applied),
        load_follow=tuple(load.follow for load in applied),
        body_nodes=tuple((b.particles[0], b.particles[-1]) for b in numbering.bodies.values()),
        function_start=starts,
        function_argument=tuple(numbering.arguments),
        path_unit=mechanism.settings.path_unit,
        damped=mechanism.settings.damping > 0.0 or static,
        weightless=not any(mechanism.gravity),
        contact_laws=laws[0],
        friction_laws=laws[1],
    )
    filler = Filler(mechanism, numbering, Layout(topology), motion, prestress(mechanism, seats) if wanted(mechanism) else None)
    filler.bodies()
    filler.ideals(ideals, tables)
    filler.touches(touches)
    filler.springs(springs)
    filler.drivers_and_loads(applied)
    filler.seat(touches, seats)
    owners = [name for name, body in numbering.bodies.items() for _ in body.elements]
    names = tuple(t.name for t in touches)
    if static:
        choice = static_choice(mechanism)
    else:
        choice = choose_step(mechanism, filler.layout, filler.state, topology, touches, step, expected, owners, **run)
    filler.put("step", choice.step)
    filler.put("damping", mechanism.settings.damping)
    pivots = tuple(joint.name for joint in numbering.pivots.values())
    return Assembly(
        mechanism, topology, filler.layout, filler.state, tables, numbering.bodies, names, tuple(j.name for j in ideals),
        pivots, choice, tuple(mechanism.springs), tuple(t.joint.name for t in touches), motion.mobility, cautions(mechanism),
    )  # fmt: skip


def ideal_joints(mechanism: Mechanism, numbering: Numbering) -> list[Ideal]:
    """Joints without play that are no pivots of driven bodies, then gears, then drivers of anything else than a body on its pivot."""
    pivots = {joint.name for joint in numbering.pivots.values()}
    found = []
    for joint in mechanism.joints.values():
        if joint.name not in pivots and not isinstance(joint, Contact):
            bearing, journal = (numbering.place(side) for side in joint.sides)
            direction = unit(joint.direction) if isinstance(joint, Slider) else FACING
            found.append(Ideal(joint.name, kind_of_joint(joint), bearing, journal, direction))
    for gear in mechanism.gears.values():
        ends = [(numbering.particle(body), (0.0, 0.0)) for body in (gear.first, gear.second)]
        found.append(Ideal(gear.name, GEAR, ends[0], ends[1], ratio=gear.ratio))
    for name, driver in constraint_drivers(mechanism).items():
        function = numbering.function(motion_function(driver, 0.0))
        if driver.slider:
            joint = mechanism.joints[driver.slider]
            bearing, journal = (numbering.place(side) for side in joint.sides)
            found.append(Ideal(name, TRAVEL, bearing, journal, unit(joint.direction), function=function))  # type: ignore[attr-defined]
        elif driver.point:
            body, _, pin = driver.point.partition(".")
            found.append(Ideal(name, TRAVEL, (0, (0.0, 0.0)), numbering.place((body, pin)), unit(driver.direction), function=function))
        else:
            ends = [(numbering.particle(body), (0.0, 0.0)) for body in (driver.against, driver.body or name)]
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


def unit(direction: tuple[float, float]) -> tuple[float, float]:
    """The direction with length 1."""
    size = float(np.hypot(*direction))
    if not size > 0.0:
        raise ValueError(f"a direction of {direction} has no length: give two numbers that are not both zero")
    return direction[0] / size, direction[1] / size


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
            c, big = joint.clearance, joint.bearing_radius  # type: ignore[attr-defined]
            found.append(Touch(name, joint, BEARING, bearing, journal, c, (big, big - c)))
    return found


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


def kind_of_spring(spring: Any) -> int:
    """Its axes."""
    kinds = {Spring: LINEAR, Stop: STOP, Bushing: BUSHING}
    return kinds.get(type(spring), TORSIONAL)


def spring_places(numbering: Numbering, spring: Any) -> tuple[Place, Place]:
    """Pins of a spring or bushing, or the particles that stand for two bodies."""
    if isinstance(spring, (Spring, Bushing)):
        first, second = (numbering.place((body, pin)) for body, _, pin in (end.partition(".") for end in (spring.first, spring.second)))
        return first, second
    return (numbering.particle(spring.first), (0.0, 0.0)), (numbering.particle(spring.second), (0.0, 0.0))


def turning(numbering: Numbering, ideals: list[Ideal], touches: list[Touch], springs: list[Any], applied: list[Load]) -> tuple[int, ...]:
    """Particles whose direction is needed: those with arms, driven ones, those that carry a guide, a wall or a following load."""
    places = [place for joint in ideals for place in (joint.bearing, joint.journal)]
    places += [place for touch in touches for place in (touch.bearing, touch.journal)]
    places += [place for spring in springs for place in spring[2:4]] + [load.place for load in applied]
    armed = {p for p, at in places if p and at != (0.0, 0.0)}
    armed |= {j.bearing[0] for j in ideals if j.kind in (SLIDER, SLOT, TRAVEL)} | {t.bearing[0] for t in touches if t.kind == LINE}
    armed |= {s[2][0] for s in springs if s[1] == BUSHING} | {load.place[0] for load in applied if load.follow}
    armed |= {numbering.bodies[name].particles[0] for name in numbering.driven} | {numbering.held(name) for name in numbering.driven}
    return tuple(sorted(armed - {0}))


def driven_function(mechanism: Mechanism, numbering: Numbering, name: str) -> int:
    """Function of a driven body's angle; -1 at constant speed."""
    driver = mechanism.drivers[name]
    if isinstance(driver, ConstantSpeed):
        return -1
    return numbering.function(motion_function(driver, mechanism.bodies[name].angle))


def loads(mechanism: Mechanism, numbering: Numbering, motion: Motion) -> list[Load]:
    """Loads at pins, and torques or forces of drivers with their opposites."""
    found = []
    for load in mechanism.loads.values():
        body, _, pin = load.at.partition(".")
        function = constant(1.0) if load.times is None or load.factors is None else spline(load.times, load.factors)
        found.append(Load(numbering.place((body, pin)), numbering.function(function), load.force, load.moment, load.follow))
    for name, driver in mechanism.drivers.items():
        if not isinstance(driver, Torque):
            continue
        body = driver.body or name
        torque = torque_of(driver, body, numbering, motion)
        if driver.point:
            owner, _, pin = driver.point.partition(".")
            found.append(Load(numbering.place((owner, pin)), torque, unit(driver.direction), 0.0))
            continue
        found.append(Load((numbering.particle(body), (0.0, 0.0)), torque, (0.0, 0.0), 1.0))
        if driver.against != "ground":
            found.append(Load((numbering.particle(driver.against), (0.0, 0.0)), torque, (0.0, 0.0), -1.0))
    return found


def torque_of(driver: Torque, body: str, numbering: Numbering, motion: Motion) -> int:
    """Index of a torque's function of time, of the body's speed, or of its angle from the start."""
    function = torque_function(driver)
    if driver.speeds is None and driver.angles is None:
        return numbering.function(function)
    if driver.point:
        raise ValueError(f"the force on {driver.point!r} cannot be a table over speeds or angles, which a body has; give it times, or use a spring")
    pair = (numbering.particle(driver.against), numbering.particle(body))
    if driver.speeds is not None:
        return numbering.function(function, (SPEED, *pair))
    begin = motion.datum.angle.get(body, 0.0) - motion.datum.angle.get(driver.against, 0.0)
    shifted = dataclasses.replace(function, starts=tuple(start + begin for start in function.starts))
    return numbering.function(shifted, (TURNED, *pair))


def tables_of(functions: list[Polynomials]) -> tuple[tuple[int, ...], NDArray[np.float64]]:
    """Start of each function's table, and all of them in one array."""
    starts, parts, at = [], [np.zeros(1)], 1
    for function in functions:
        table = function.table()
        starts.append(at)
        parts.append(table)
        at += len(table)
    return tuple(starts), np.concatenate(parts)
