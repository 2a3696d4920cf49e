"""Mechanism -> arrays: numbering, lumped masses, start positions and velocities. The one module that knows nouns and kernels."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .assembly import Assembly, BodyMap
from .bodies import Link
from .drivers import ConstantSpeed, Torque
from .functions import Polynomials, angle_function, constant, spline
from .joints import ClearanceRevolute
from .kernels.arrays import Layout, Topology
from .laws import ContactLaw, FrictionLaw
from .lumping import lumped, rigid_properties, section_of
from .mechanism import Mechanism
from .prestress import Start as Prestress
from .prestress import prestress, wanted
from .stability import choose_step
from .start import Motion, Seat, ideal_motion, kinematic_drivers, local_point, pivot_of, seated, surfaces

RELEASES = {"none": 0, "start": 1, "end": 2, "both": 3}


class Numbering:
    """Particles, elements and joints in their order, gathered while the mechanism is walked through."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.bodies: dict[str, BodyMap] = {}
        self.free: list[int] = []
        self.driven: list[str] = []
        self.elements: list[tuple[int, int]] = []
        self.releases: list[int] = []
        self.functions: list[Polynomials] = []
        self.count = 1
        drivers = kinematic_drivers(mechanism)
        self.pivots = {name: pivot_of(mechanism, name) for name in drivers}
        for row, name in enumerate(mechanism.bodies):
            self._body(name, row, name in drivers)

    def _body(self, name: str, row: int, driven: bool) -> None:
        body = self.mechanism.bodies[name]
        mass, center, inertia = rigid_properties(body)
        pivot = next((side for side in self.pivots[name].sides if side[0] == name), None) if driven else None
        elements = body.element_count if isinstance(body, Link) else 0
        particles = tuple(range(self.count, self.count + elements + 1))
        self.count += elements + 1
        held = None
        if pivot is not None:
            held = {"start": particles[0], "end": particles[-1]}.get(pivot[1], particles[0]) if elements else particles[0]
            self.driven.append(name)
        self.free += [p for p in particles if p != held]
        first = len(self.elements)
        if isinstance(body, Link) and elements:
            self.elements += list(zip(particles[:-1], particles[1:], strict=True))
            self.releases += _releases(body.release, elements)
        reference = center if pivot is None else local_point(self.mechanism, pivot)
        self.bodies[name] = BodyMap(
            name, body.model, particles, tuple(range(first, len(self.elements))), row,
            len(self.driven) - 1 if driven else None, reference, mass, inertia, center, dict(body.pins),
        )  # fmt: skip

    def place(self, side: tuple[str, str]) -> tuple[int, tuple[float, float]]:
        """Particle that carries a pin, and the pin's place in the particle's frame (m)."""
        point = local_point(self.mechanism, side)
        if side[0] == "ground":
            return 0, point
        where = self.bodies[side[0]]
        if where.elements:
            if side[1] not in ("start", "end"):
                raise ValueError(f"pin {side[0]}.{side[1]}: an {where.model} link has pins at its start and end only; make it rigid or split it")
            return (where.particles[0] if side[1] == "start" else where.particles[-1]), (0.0, 0.0)
        return where.particles[0], (point[0] - where.reference[0], point[1] - where.reference[1])

    def function(self, polynomials: Polynomials) -> int:
        """Index of a function of time."""
        self.functions.append(polynomials)
        return len(self.functions) - 1


def _releases(release: str, elements: int) -> list[int]:
    codes = [0] * elements
    codes[0] |= RELEASES[release] & 1
    codes[-1] |= RELEASES[release] & 2
    return codes


def registered(base: type, used: list[type]) -> tuple[type, ...]:
    """All built-in laws, so that one compiled loop serves all models, then the user's own ones that this model uses."""
    built_in = [law for law in base.registry.values() if law.__module__.startswith("vfife.")]  # type: ignore[attr-defined]
    return tuple(sorted(built_in, key=lambda law: law.name)) + tuple(dict.fromkeys(law for law in used if law not in built_in))


def assemble(mechanism: Mechanism, step: float | str | None = None, *, expected: Mapping[str, float] | None = None, **run: Any) -> Assembly:
    """Numbers the mechanism and fills its arrays.

    ``step``: s, or "auto"; None takes the mechanism's setting. ``expected``: largest force (N) each joint is expected to carry, for the stable
    step. ``run``: ``turns``, ``duration``, ``outputs``, ``force_step`` override the settings. Raises ValueError (AssemblyError where links cannot
    reach, StepError where the step is too large) with a sentence that names what is wrong.
    """
    numbering = Numbering(mechanism)
    seats = seated(mechanism)
    motion = ideal_motion(mechanism, seats=seats)
    clearances = mechanism.clearances
    pivots = [joint.name for joint in numbering.pivots.values()]
    ideals = [joint for joint in mechanism.joints.values() if joint.name not in pivots and joint.name not in clearances]
    contacts = registered(ContactLaw, [type(j.contact) for j in clearances.values()])
    frictions = registered(FrictionLaw, [type(j.friction) for j in clearances.values()])
    ends = {joint.name: [numbering.place(side) for side in joint.sides] for joint in mechanism.joints.values()}
    loads = _loads(mechanism, numbering)
    driven = [_driven_function(mechanism, numbering, name) for name in numbering.driven]
    armed = {p for joint in ends.values() for p, at in joint if p and at != (0.0, 0.0)}
    armed |= {entry[0] for entry in loads if entry[2] != (0.0, 0.0)} | {numbering.bodies[name].particles[0] for name in numbering.driven}
    starts, tables = _tables(numbering.functions)
    topology = Topology(
        particles=numbering.count,
        free=tuple(numbering.free),
        trig=tuple(sorted(armed)),
        element_nodes=tuple(numbering.elements),
        element_release=tuple(numbering.releases),
        clearance_bearing=tuple(ends[name][0][0] for name in clearances),
        clearance_journal=tuple(ends[name][1][0] for name in clearances),
        clearance_contact=tuple(contacts.index(type(j.contact)) for j in clearances.values()),
        clearance_friction=tuple(frictions.index(type(j.friction)) for j in clearances.values()),
        ideal_bearing=tuple(ends[j.name][0][0] for j in ideals),
        ideal_journal=tuple(ends[j.name][1][0] for j in ideals),
        driven=tuple(_held(numbering, name) for name in numbering.driven),
        driven_function=tuple(driven),
        load_particle=tuple(entry[0] for entry in loads),
        load_function=tuple(entry[1] for entry in loads),
        body_nodes=tuple((b.particles[0], b.particles[-1]) for b in numbering.bodies.values()),
        function_start=starts,
        path_unit=mechanism.settings.path_unit,
        damped=mechanism.settings.damping > 0.0,
        weightless=not any(mechanism.gravity),
        contact_laws=contacts,
        friction_laws=frictions,
    )
    filler = Filler(mechanism, numbering, Layout(topology), motion, prestress(mechanism, seats) if wanted(mechanism) else None)
    filler.bodies()
    filler.joints(ends, [j.name for j in ideals])
    filler.drivers_and_loads(loads)
    filler.seat(seats)
    owners = [name for name, body in numbering.bodies.items() for _ in body.elements]
    choice = choose_step(mechanism, filler.layout, filler.state, topology, tuple(clearances), step, expected, owners, **run)
    filler.put("step", choice.step)
    filler.put("damping", mechanism.settings.damping)
    return Assembly(
        mechanism, topology, filler.layout, filler.state, tables, numbering.bodies, tuple(clearances), tuple(j.name for j in ideals),
        tuple(pivots), choice, motion.mobility,
    )  # fmt: skip


def _held(numbering: Numbering, name: str) -> int:
    body = numbering.bodies[name]
    return next(p for p in body.particles if p not in set(numbering.free))


def _driven_function(mechanism: Mechanism, numbering: Numbering, name: str) -> int:
    driver = mechanism.drivers[name]
    if isinstance(driver, ConstantSpeed):
        return -1
    return numbering.function(angle_function(driver, mechanism.bodies[name].angle))


def _loads(mechanism: Mechanism, numbering: Numbering) -> list[tuple[int, int, tuple[float, float], tuple[float, float, float]]]:
    """Loads and torques: particle, function, point of attack, and force and moment per unit of the function."""
    entries = []
    for load in mechanism.loads.values():
        body, _, pin = load.at.partition(".")
        particle, at = numbering.place((body, pin))
        function = constant(1.0) if load.times is None or load.factors is None else spline(load.times, load.factors)
        entries.append((particle, numbering.function(function), at, (*load.force, load.moment)))
    for name, driver in mechanism.drivers.items():
        if isinstance(driver, Torque):
            values = (driver.torque,) if isinstance(driver.torque, (int, float)) else driver.torque
            function = constant(values[0]) if driver.times is None else spline(driver.times, values)
            entries.append((numbering.bodies[name].particles[0], numbering.function(function), (0.0, 0.0), (0.0, 0.0, 1.0)))
    return entries


def _tables(functions: list[Polynomials]) -> tuple[tuple[int, ...], NDArray[np.float64]]:
    starts, parts, at = [], [np.zeros(1)], 1
    for function in functions:
        table = function.table()
        starts.append(at)
        parts.append(table)
        at += len(table)
    return tuple(starts), np.concatenate(parts)


class Filler:
    """Writes parameters and start values into S."""

    def __init__(self, mechanism: Mechanism, numbering: Numbering, layout: Layout, motion: Motion, stressed: Prestress | None) -> None:
        self.mechanism, self.numbering, self.layout, self.motion, self.stressed = mechanism, numbering, layout, motion, stressed
        self.state = np.zeros(layout.rows)
        self.free = frozenset(numbering.free)

    def put(self, name: str, value: Any, index: int | None = None) -> None:
        """Sets a block, or one entry of it."""
        if index is None:
            self.state[self.layout[name]] = value
        else:
            self.state[self.layout.row(name, index)] = value

    def bodies(self) -> None:
        """Masses, loads, positions and velocities of particles; stiffness and reference of elements."""
        for name, where in self.numbering.bodies.items():
            body = self.mechanism.bodies[name]
            if isinstance(body, Link) and where.elements:
                self._elastic(body, where)
            else:
                self._rigid(where)

    def _particle(self, p: int, mass: float, inertia: float, motion: tuple[Any, Any]) -> None:
        position, velocity = motion
        for axis, value in zip(("x", "y", "theta"), position, strict=True):
            self.put(f"particle_{axis}", value, p)
        if p not in self.free:
            self.put("particle_w", velocity[2], p)
            self.put("particle_load_x", mass * self.mechanism.gravity[0], p)
            self.put("particle_load_y", mass * self.mechanism.gravity[1], p)
            return
        for axis, value in zip("uvw", velocity, strict=True):
            self.put(f"particle_{axis}", value, p)
        self.put("particle_inverse_mass", 1.0 / mass, p)
        self.put("particle_inverse_inertia", 1.0 / inertia if inertia > 0.0 else 0.0, p)
        self.put("particle_load_x", mass * self.mechanism.gravity[0], p)
        self.put("particle_load_y", mass * self.mechanism.gravity[1], p)

    def _rigid(self, where: BodyMap) -> None:
        position, velocity, _ = self.motion.of(where.name)
        if self.stressed is not None:
            position, velocity = self.stressed.position[where.name][0], self.stressed.velocity[where.name][0]
        at, moving = carried(position, velocity, where.reference[0] - where.center[0], where.reference[1] - where.center[1])
        self._particle(where.particles[0], where.mass, where.inertia, (at, moving))

    def _elastic(self, link: Link, where: BodyMap) -> None:
        position, velocity, _ = self.motion.of(where.name)
        lumps, section = lumped(link), section_of(link)
        if self.stressed is None:
            there, moving = np.transpose([carried(position, velocity, x - where.center[0], 0.0) for x in lumps.position], (1, 0, 2))
        else:
            there, moving = self.stressed.position[where.name], self.stressed.velocity[where.name]
        particles = slice(where.particles[0], where.particles[-1] + 1)
        free = np.array([p in self.free for p in where.particles])
        for axis, name in enumerate(("x", "y", "theta")):
            self.span(f"particle_{name}", particles, there[:, axis])
        for axis, name in enumerate("uvw"):
            self.span(f"particle_{name}", particles, np.where(free | (name == "w"), moving[:, axis], 0.0))
        inertia = np.where(lumps.inertia > 0.0, lumps.inertia, np.inf)
        self.span("particle_inverse_mass", particles, np.where(free, 1.0 / lumps.mass, 0.0))
        self.span("particle_inverse_inertia", particles, np.where(free, 1.0 / inertia, 0.0))
        for axis, name in enumerate("xy"):
            self.span(f"particle_load_{name}", particles, lumps.mass * self.mechanism.gravity[axis])
        chord = np.diff(there[:, :2], axis=0)
        length = np.hypot(chord[:, 0], chord[:, 1])
        elements = slice(where.elements[0], where.elements[-1] + 1)
        stiffness = link.material.youngs_modulus * link.stiffness_factor
        values = {
            "reference_length": length, "reference_inverse_length": 1.0 / length,
            "reference_cosine": chord[:, 0] / length, "reference_sine": chord[:, 1] / length,
            "reference_theta_1": there[:-1, 2], "reference_theta_2": there[1:, 2],
            "element_axial_stiffness": stiffness * section.area, "element_bending_stiffness": stiffness * section.second_moment,
        }  # fmt: skip
        if self.stressed is not None:
            shape = self.stressed.shapes[where.name]
            for kind in ("element", "reference"):
                values |= {f"{kind}_axial_force": shape.axial, f"{kind}_moment_1": shape.moment_1, f"{kind}_moment_2": shape.moment_2}
        for block, value in values.items():
            self.span(block, elements, value)

    def span(self, name: str, entries: slice, value: Any) -> None:
        """Sets several entries of a block."""
        where = self.layout[name]
        self.state[where.start + entries.start * where.step : where.start + entries.stop * where.step : where.step] = value

    def joints(self, ends: Mapping[str, list[tuple[int, tuple[float, float]]]], ideals: list[str]) -> None:
        """Pins, clearances and laws."""
        for index, name in enumerate(ideals):
            self._pins("ideal", index, ends[name])
        for index, (name, joint) in enumerate(self.mechanism.clearances.items()):
            self._pins("clearance", index, ends[name])
            self._clearance(joint, index)

    def _pins(self, kind: str, index: int, ends: list[tuple[int, tuple[float, float]]]) -> None:
        for side, (_, at) in zip(("bearing", "journal"), ends, strict=True):
            for axis, value in zip("xy", at, strict=True):
                self.put(f"{kind}_{side}_{axis}", value, index)

    def _clearance(self, joint: ClearanceRevolute, index: int) -> None:
        for row, values in clearance_rows(self.mechanism, self.layout, joint, index):
            self.state[row : row + len(values)] = values

    def seat(self, seats: Mapping[str, Seat]) -> None:
        """Contact under way in joints whose journals start where the ideal reaction presses them."""
        for index, (name, joint) in enumerate(self.mechanism.clearances.items()):
            if name in seats:
                self.put("clearance_slowness", 1.0 / joint.impact_speed_floor, index)
                self.put("clearance_normal_force", seats[name].force, index)
                self.put("clearance_penetration", seats[name].depth, index)

    def drivers_and_loads(self, loads: list[tuple[int, int, tuple[float, float], tuple[float, float, float]]]) -> None:
        """Parameters of drivers and of loads over time."""
        for index, name in enumerate(self.numbering.driven):
            where, driver = self.numbering.bodies[name], self.mechanism.drivers[name]
            rx, ry = where.center[0] - where.reference[0], where.center[1] - where.reference[1]
            mass, inertia = where.mass, where.inertia + where.mass * (rx * rx + ry * ry)
            if where.elements:
                lumps = lumped(self.mechanism.bodies[name])  # type: ignore[arg-type]
                held = where.particles.index(self.numbering.bodies[name].particles[0])
                mass, inertia, rx, ry = float(lumps.mass[held]), float(lumps.inertia[held]), 0.0, 0.0
            self.put("driven_angle", self.mechanism.bodies[name].angle, index)
            self.put("driven_speed", driver.speed if isinstance(driver, ConstantSpeed) else 0.0, index)
            self.put("driven_inertia", inertia, index)
            self.put("driven_moment_x", mass * rx, index)
            self.put("driven_moment_y", mass * ry, index)
            self.put("driven_weight_x", self.mechanism.gravity[0], index)
            self.put("driven_weight_y", self.mechanism.gravity[1], index)
        for index, (_, _, at, (fx, fy, moment)) in enumerate(loads):
            for block, value in zip(("load_x", "load_y", "load_fx", "load_fy", "load_m"), (*at, fx, fy, moment), strict=True):
                self.put(block, value, index)


def clearance_rows(mechanism: Mechanism, layout: Layout, joint: ClearanceRevolute, index: int) -> list[tuple[int, tuple[float, ...]]]:
    """First row and values of every number of a clearance joint that its noun decides: sizes, arms of friction, laws."""
    arms = 0.0 if joint.friction_moment == "off" else 1.0
    pair = surfaces(mechanism, joint)
    numbers = {
        "clearance_size": (joint.clearance,),
        "clearance_arm_bearing": (arms * joint.bearing_radius,),
        "clearance_arm_journal": (arms * (joint.bearing_radius - joint.clearance),),
        "clearance_arm_overlap": (0.5 if joint.friction_moment == "mid-overlap" else 0.0,),
        "clearance_floor": (joint.impact_speed_floor,),
        "clearance_landing": (joint.landing,),
        "clearance_contact": joint.contact.parameters(pair),
        "clearance_friction_slots": joint.friction.parameters(pair),
    }
    return [(layout.row(block, index), values) for block, values in numbers.items()]


def refitted(assembly: Assembly, joints: Mapping[str, ClearanceRevolute]) -> Assembly:
    """The assembly with other numbers in its clearance joints, their law kinds the same: what ``assemble`` gives with the same step, sooner.

    ``joints``: all of the mechanism's clearance joints. Raises ValueError where something else would change too: the kinds of the laws, or
    the start, which depends on clearances where journals are seated.
    """
    mechanism = assembly.mechanism
    if tuple(joints) != assembly.clearances or mechanism.start.journals == "seated":
        raise ValueError("only the clearance joints of a mechanism whose journals start centred can be refitted, and all of them at once")
    state, topology = assembly.state.copy(), assembly.topology
    for index, (name, joint) in enumerate(joints.items()):
        kinds = topology.contact_laws[topology.clearance_contact[index]], topology.friction_laws[topology.clearance_friction[index]]
        if kinds != (type(joint.contact), type(joint.friction)) or joint.sides != mechanism.joints[name].sides:
            raise ValueError(f"joint {name!r} has laws or sides of another kind than the assembled one; assemble the mechanism anew")
        for row, values in clearance_rows(mechanism, assembly.layout, joint, index):
            state[row : row + len(values)] = values
    fitted = dataclasses.replace(mechanism, joints={**mechanism.joints, **joints})
    return dataclasses.replace(assembly, mechanism=fitted, state=state)


def carried(position: Any, velocity: Any, x: float, y: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Position and velocity of the point (x, y) (m) of a rigid body, seen from its centre of mass in its frame."""
    c, s = math.cos(position[2]), math.sin(position[2])
    rx, ry, w = c * x - s * y, s * x + c * y, velocity[2]
    return (position[0] + rx, position[1] + ry, position[2]), (velocity[0] - w * ry, velocity[1] + w * rx, w)
