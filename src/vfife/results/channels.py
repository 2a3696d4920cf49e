"""Channels of a result: name, dimensions, unit, meaning and frame of every series, and its values from a
record.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.blocks import BY_NAME
from ..measures import contacts, elastic, forces, motion
from ..measures.contacts import contact_angle, mean_power, sliding_speed, spent_energy
from ..measures.energy import Ledger, actuators, quantity_of
from ..measures.forces import ground_load
from ..measures.statics import displacement
from ..measures.wear import SIDES, coefficients, work
from ..numerics.elementwise import hypot
from ..solvers.record import Record


@dataclass(frozen=True)
class Channel:
    """A series: ``values`` of shape (outputs,) or (outputs, entities), its dimension, unit and meaning.

    ``frame``: axes of a position, direction or component (one of ``FRAMES``); "" for scalars.
    """

    values: NDArray[Any] = field(repr=False)
    entity: str | None
    unit: str
    meaning: str
    frame: str = ""

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return ("time",) if self.entity is None else ("time", self.entity)

    @property
    def attributes(self) -> dict[str, str]:
        """Unit, meaning and frame, as attributes of a dataset."""
        return {"units": self.unit, "long_name": self.meaning} | (
            {"frame": FRAMES[self.frame]} if self.frame else {}
        )


GLOBAL = "global axes"
FRAMES = {
    GLOBAL: "the axes of the ground",
    "bearing": "the axes of the body that carries the bearing; of a link from its start to its end",
    "journal": "the axes of the body that carries the journal",
    "guide": "along the guide, which the bearing's body carries, from the bearing's pin",
    "chord": "across the line from a link's start to its end, positive to its left",
    "start": "across the direction of a link at its start, positive to its left",
    "link": "along the axis of the link: tension positive",
}

# Channel = block of the record, per entity: unit and meaning are those of the block.
RECORDED: Mapping[str, tuple[tuple[str, str], ...]] = {
    "particle": tuple(
        (f"particle_{axis}",) * 2 for axis in ("x", "y", "theta", "u", "v", "w", "ax", "ay", "aw")
    ),
    "body": (
        ("body_angular_acceleration", "body_alpha"),
        ("body_angular_acceleration_max", "body_alpha_max"),
    ),
    "clearance": (
        ("penetration", "contact_penetration"),
        ("penetration_max", "contact_penetration_max"),
        ("normal_force", "contact_normal_force"),
        ("friction_force", "contact_friction_force"),
        ("impacts", "contact_onsets"),
        ("grazing", "contact_grazing"),
    ),
    "element": tuple(
        (f"element_{name}", f"frame_{name}") for name in ("axial_force", "moment_1", "moment_2")
    ),
    "spring": (
        ("spring_force_x", "spring_fx"),
        ("spring_force_y", "spring_fy"),
        ("spring_moment", "spring_moment"),
    ),
    "driver": (
        ("driver_torque", "driven_torque"),
        ("driver_torque_max", "driven_torque_max"),
        ("driver_power", "driven_power"),
    ),
}

ENERGIES: Mapping[str, tuple[str, str]] = {
    "kinetic_energy": ("kinetic", "kinetic energy of all bodies"),
    "strain_energy": ("strain", "strain energy of elastic links"),
    "contact_energy": ("contact", "elastic energy of the contacts"),
    "contact_loss": ("contact_loss", "energy lost in normal damping of the contacts"),
    "friction_loss": ("friction_loss", "energy lost in friction"),
    "damping_loss": ("damping_loss", "energy lost in mass-proportional damping"),
    "spring_energy": ("spring", "elastic energy of springs, stops and bushings"),
    "spring_loss": ("spring_loss", "energy lost in their dampers"),
    "external_work": ("external", "work of weight and loads, and of torques and forces of drivers"),
    "driver_work": ("driver", "work of the drivers that prescribe a motion"),
}

# Frame of recorded blocks that are components or angles.
FRAME_OF = dict.fromkeys(
    (*(f"particle_{axis}" for axis in ("x", "y", "theta", "ax", "ay", "aw")), "spring_fx", "spring_fy"),
    GLOBAL,
) | {f"frame_{name}": "link" for name in ("axial_force", "moment_1", "moment_2")}

# What means nothing in equilibrium.
MOVING = frozenset(
    (
        *(f"particle_{name}" for name in ("u", "v", "w", "ax", "ay", "aw")),
        "body_angular_velocity", "body_angular_acceleration", "body_angular_acceleration_max",
        "impacts", "grazing", "mode", "penetration_max", "joint_force_max", "driver_torque_max",
        "friction_energy", "impact_energy", "friction_power", "impact_power", "sliding_velocity",
        "pressure_velocity",
        "bearing_wear", "journal_wear",
        "slider_velocity", "slider_acceleration", "driver_power", "actuator_power", "actuator_force_max",
        "actuator_torque_max",
    )
)  # fmt: skip


def entities(record: Record) -> dict[str, list[str]]:
    """Return the names along each dimension, without empty dimensions."""
    assembly = record.assembly
    names = {
        "joint": list(forces.joint_rows(record)),
        "clearance": list(assembly.contacts),
        "body": list(assembly.bodies),
        "spring": list(assembly.springs),
        "driver": [body.name for body in sorted(_driven(record), key=lambda body: int(body.driven or 0))],
        "actuator": list(actuators(record)),
        "slider": motion.sliders(record),
        "elastic": [name for name, body in assembly.bodies.items() if body.elements],
        "element": motion.element_names(record),
        "particle": motion.particle_names(record),
    }
    return {entity: owners for entity, owners in names.items() if owners}


def _driven(record: Record) -> list[Any]:
    return [body for body in record.assembly.bodies.values() if body.driven is not None]


Group = Callable[[], dict[str, Channel]]


def channel_groups(record: Record, ledger: Callable[[], Ledger]) -> dict[str, Group]:
    """Return functions that compute the channels of a record in groups, by the name of the group.

    A reader of a few series computes the groups that they are in: all channels of a turn take forty times as
    long as its joint forces. A channel that two groups have is that of the first. ``ledger`` returns the
    energy ledger of the record.
    """
    present, groups = entities(record), dict[str, Group]()
    for entity, parts in ENTITY_CHANNELS.items():
        if entity in present:
            groups |= {f"{entity} {k}": partial(compute, record) for k, compute in enumerate(parts)}
            groups[f"{entity} blocks"] = partial(recorded, record, entity)
    groups["ground"] = partial(ground_channels, record)
    groups["energy"] = lambda: (_equilibria if record.static else _energies)(record, ledger())
    return groups


def channels(record: Record, ledger: Ledger) -> dict[str, Channel]:
    """Return all channels of a record, by name."""
    values: dict[str, Channel] = {}
    for compute in channel_groups(record, lambda: ledger).values():
        values |= {name: channel for name, channel in compute().items() if name not in values}
    if record.static:
        return {name: channel for name, channel in values.items() if name not in MOVING}
    return values


def recorded(record: Record, entity: str) -> dict[str, Channel]:
    """Return the channels of a dimension that are recorded blocks of the state."""
    return {name: _recorded(record, entity, block) for name, block in RECORDED.get(entity, ())}


def _energies(record: Record, ledger: Ledger) -> dict[str, Channel]:
    """Return the terms of the energy ledger and what it leaves open."""
    values = {
        name: Channel(ledger.terms[term], None, "J", meaning) for name, (term, meaning) in ENERGIES.items()
    }
    values["energy_residual"] = Channel(
        ledger.residual, None, "J", "stored + lost - supplied - stored at the start"
    )
    return values


def _equilibria(record: Record, ledger: Ledger) -> dict[str, Channel]:
    """Return displacement, stored energies, and convergence of each equilibrium."""
    stored = ("strain_energy", "contact_energy", "spring_energy")
    values = {name: Channel(ledger.terms[ENERGIES[name][0]], None, "J", ENERGIES[name][1]) for name in stored}
    values["displacement"] = Channel(
        displacement(record), None, "m", "largest way of a particle from its start"
    )
    for name in ("iterations", "unbalanced"):
        values[name] = Channel(record.block(name)[:, 0], None, BY_NAME[name].unit, BY_NAME[name].meaning)
    return values


def _recorded(record: Record, entity: str, name: str) -> Channel:
    block, values = BY_NAME[name], record.block(name)
    if entity == "particle":
        values = values[:, 1:]  # particle 0 is the ground
    elif entity == "body":
        values = values[:, [body.row for body in record.assembly.bodies.values()]]
    return Channel(
        values, entity, block.unit, block.meaning.replace(" at step n", ""), FRAME_OF.get(name, "")
    )


def _particles(record: Record) -> dict[str, Channel]:
    """Return velocities at the times of outputs; the record has them half a step later."""
    return {
        f"particle_{axis}": Channel(
            values[:, 1:], "particle", BY_NAME[f"particle_{axis}"].unit, meaning, GLOBAL
        )
        for (axis, values), meaning in zip(
            motion.velocities(record).items(), 2 * ["velocity"] + ["angular velocity"], strict=True
        )
    }


def _bodies(record: Record) -> dict[str, Channel]:
    moved = motion.body_motion(record)
    of = {
        "x": ("m", "centre of mass"),
        "y": ("m", "centre of mass"),
        "angle": ("rad", "angle of a rigid body or of an elastic link's chord"),
        "angular_velocity": ("rad/s", "its rate"),
    }
    return {f"body_{name}": Channel(moved[name], "body", *text, GLOBAL) for name, text in of.items()}


def _joints(record: Record) -> dict[str, Channel]:
    force = forces.joint_force(record)
    return {
        "joint_force": Channel(
            hypot(force[..., 0], force[..., 1]), "joint", "N", "size of the joint's force"
        ),
        "joint_force_x": Channel(force[..., 0], "joint", "N", "force on the journal", GLOBAL),
        "joint_force_y": Channel(force[..., 1], "joint", "N", "force on the journal", GLOBAL),
        "joint_moment": Channel(forces.joint_moment(record), "joint", "N m", "moment on the journal's body"),
        "joint_force_max": Channel(
            forces.joint_force_max(record), "joint", "N", "largest joint force since the last output"
        ),
    }


def _clearances(record: Record) -> dict[str, Channel]:
    away = forces.eccentricity(record)
    modes = "0 free flight, 1 a contact began since the last output, 2 continuous contact"
    return {
        "eccentricity_x": Channel(
            away[..., 0], "clearance", "m", "journal centre seen from the bearing centre", GLOBAL
        ),
        "eccentricity_y": Channel(
            away[..., 1], "clearance", "m", "journal centre seen from the bearing centre", GLOBAL
        ),
        "mode": Channel(forces.modes(record), "clearance", "1", modes),
    }


def _elements(record: Record) -> dict[str, Channel]:
    return stress_channels(record) if elastic.has_stresses(record) else {}


def wear_channels(record: Record) -> dict[str, Channel]:
    """Return energies, powers, sliding, pressure and places of contact of joints with clearance."""
    reaches = forces.places(record) if record.assembly.contacts else None
    pressures, slide = contacts.pressures(record), sliding_speed(record, reaches)
    load = pressures.bearing
    named = {
        "friction_energy": (spent_energy(record, "friction"), "J", "energy lost in friction since the start"),
        "impact_energy": (
            spent_energy(record, "impact"),
            "J",
            "energy lost in normal damping since the start",
        ),
        "friction_power": (
            mean_power(record, "friction"),
            "W",
            "power lost in friction, mean since the last output",
        ),
        "impact_power": (
            mean_power(record, "impact"),
            "W",
            "power lost in normal damping, mean since the last output",
        ),
        "sliding_velocity": (
            slide,
            "m/s",
            (
                "velocity of the journal's surface on the bearing's, along the normal turned anticlockwise; 0"
                " apart"
            ),
        ),
        "contact_pressure": (pressures.pressure, "Pa", "largest pressure of Hertz' line contact, 0 apart"),
        "contact_half_width": (pressures.half_width, "m", "half-width of Hertz' line contact"),
        "bearing_pressure": (
            load,
            "Pa",
            "normal force over diameter and length of the journal; beside a round or a line over the contact",
        ),
        "pressure_velocity": (
            load * np.abs(slide),
            "W/m^2",
            "p v: bearing pressure times size of the sliding velocity",
        ),
    }
    values = {
        name: Channel(values, "clearance", unit, meaning) for name, (values, unit, meaning) in named.items()
    }
    for side, name in (("bearing", "contact_angle"), ("journal", "journal_contact_angle")):
        meaning = f"angle of the place of contact, or of what is nearest to it, seen from the {side}'s pin"
        values[name] = Channel(contact_angle(record, side, reaches), "clearance", "rad", meaning, side)
    return values | (wear_volume_channels(record) if record.assembly.topology.wears else {})


def wear_volume_channels(record: Record) -> dict[str, Channel]:
    """Return the volumes that the surfaces of joints with clearance have lost, by Archard's law."""
    wears, values = record.assembly.topology.wears, {}
    for k, side in enumerate(SIDES):
        volume = np.zeros((len(record.steps), len(record.assembly.contacts)))
        volume[:, list(wears)] = work(record) * np.array(
            [coefficients(record, contact)[k] for contact in wears]
        )
        values[f"{side}_wear"] = Channel(
            volume, "clearance", "m^3", f"volume that the {side} has lost since the start"
        )
    return values


def actuator_channels(record: Record) -> dict[str, Channel]:
    """Return forces, torques and powers of the drivers of sliders, points and bodies against others; NaN is
    the force of one that turns, and the torque of one that moves along a line.
    """
    linear, values = np.array(list(actuators(record).values())), dict[str, Channel]()
    for of_line in sorted(set(linear.tolist()), reverse=True):
        (name, unit), fits = quantity_of(of_line), linear == of_line
        words = "force along its line" if of_line else "torque"
        for ending, meaning in (("", f"{words} of the driver"), ("_max", f"largest {words} of the driver")):
            numbers = np.where(fits, record.block(f"actuator_force{ending}"), np.nan)
            text = f"{meaning} since the last output" if ending else meaning
            values[f"{name}{ending}"] = Channel(numbers, "actuator", unit, text)
    power = record.block("actuator_power")
    return values | {"actuator_power": Channel(power, "actuator", "W", "power of the driver")}


def slider_channels(record: Record) -> dict[str, Channel]:
    """Return position, velocity and acceleration of sliders along their guides."""
    moved = [
        np.column_stack(components)
        for components in zip(
            *(motion.slider_motion(record, name) for name in motion.sliders(record)), strict=True
        )
    ]
    units = (("position", "m"), ("velocity", "m/s"), ("acceleration", "m/s^2"))
    return {
        f"slider_{name}": Channel(
            values, "slider", unit, f"{name} of the journal's pin along its guide", "guide"
        )
        for (name, unit), values in zip(units, moved, strict=True)
    }


def ground_channels(record: Record) -> dict[str, Channel]:
    """Return the forces and moments of the mechanism on the ground."""
    load, meaning = ground_load(record), "force of the mechanism on the ground"
    return {
        "ground_shaking_force": Channel(hypot(load[:, 0], load[:, 1]), None, "N", f"size of the {meaning}"),
        "ground_shaking_force_x": Channel(load[:, 0], None, "N", meaning, GLOBAL),
        "ground_shaking_force_y": Channel(load[:, 1], None, "N", meaning, GLOBAL),
        "ground_shaking_moment": Channel(
            load[:, 2], None, "N m", "moment of the mechanism on the ground about the ground's origin", GLOBAL
        ),
    }


def stress_channels(record: Record) -> dict[str, Channel]:
    """Return the stresses of elements whose extreme fibre is known."""
    tension, compression = elastic.fibres(record)
    meaning = "stress in the outermost fibres, tension positive"
    return {
        "element_stress": Channel(
            elastic.stress(record), "element", "Pa", "largest size of stress in the outermost fibres"
        ),
        "element_stress_max": Channel(tension.max(axis=2), "element", "Pa", f"largest {meaning}", "link"),
        "element_stress_min": Channel(
            compression.min(axis=2), "element", "Pa", f"smallest {meaning}", "link"
        ),
    }


def elastic_channels(record: Record) -> dict[str, Channel]:
    """Return the largest stresses of elastic bodies, and deflection and elongation of links; NaN
    for frames.
    """
    bodies, links = (
        [name for name, body in record.assembly.bodies.items() if body.elements],
        elastic.elastic_links(record),
    )
    missing = np.full(len(record.steps), np.nan)
    of = {
        "deflection": (
            elastic.largest_deflection,
            "largest deflection along the link from the line through its ends",
            "chord",
        ),
        "end_deflection": (
            elastic.end_deflection,
            "deflection of the end from the direction at the start",
            "start",
        ),
        "elongation": (elastic.elongation, "distance of the ends less that without forces", "link"),
    }
    by_name = {
        f"elastic_{name}": Channel(
            np.column_stack([values(record, link) if link in links else missing for link in bodies]),
            "elastic",
            "m",
            meaning,
            frame,
        )
        for name, (values, meaning, frame) in of.items()
    }
    if elastic.has_stresses(record):
        extremes_by_body = [elastic.extremes(record, name) for name in bodies]
        for k, kind in enumerate(("tension", "compression")):
            values = np.column_stack([extremes[k] for extremes in extremes_by_body])
            by_name[f"elastic_{kind}"] = Channel(
                values, "elastic", "Pa", f"largest {kind} in the outermost fibres of the body", "link"
            )
    return by_name


# Channels of a dimension beside its recorded blocks, in groups that cost about the same.
ENTITY_CHANNELS: Mapping[str, tuple[Callable[[Record], dict[str, Channel]], ...]] = {
    "body": (_bodies,),
    "joint": (_joints,),
    "clearance": (_clearances, wear_channels),
    "spring": (),
    "driver": (),
    "actuator": (actuator_channels,),
    "particle": (_particles,),
    "element": (_elements,),
    "slider": (slider_channels,),
    "elastic": (elastic_channels,),
}
