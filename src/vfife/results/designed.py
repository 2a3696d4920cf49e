"""Channels that a designer reads off: losses, sliding, pressure, guides, loads on the ground, stress and deflection of elastic links."""

from __future__ import annotations

import numpy as np

from ..analysis import contacts, elastic, guides
from ..analysis.contacts import contact_angle, lost, mean_power, sliding_speed
from ..analysis.ground import ground_load
from ..analysis.wear import SIDES, coefficients, work
from ..numerics.elementwise import hypot
from ..solvers.record import Record
from .channel import GLOBAL, Channel


def wear_channels(record: Record) -> dict[str, Channel]:
    """Energies, powers, sliding, pressure and places of contact of joints with play."""
    pressures, slide = contacts.pressures(record), sliding_speed(record)
    named = {
        "friction_energy": (lost(record, "friction"), "J", "energy lost in friction since the start"),
        "impact_energy": (lost(record, "impact"), "J", "energy lost in normal damping since the start"),
        "friction_power": (mean_power(record, "friction"), "W", "power lost in friction, mean since the last output"),
        "impact_power": (mean_power(record, "impact"), "W", "power lost in normal damping, mean since the last output"),
        "sliding_velocity": (slide, "m/s", "velocity of the journal's surface on the bearing's, along the normal turned anticlockwise; 0 apart"),
        "contact_pressure": (pressures[0], "Pa", "largest pressure of Hertz' line contact, 0 apart"),
        "contact_half_width": (pressures[1], "m", "half-width of Hertz' line contact"),
        "bearing_pressure": (pressures[2], "Pa", "normal force over diameter and length of the journal; beside a round or a line over the contact"),
        "pressure_velocity": (pressures[2] * np.abs(slide), "W/m^2", "p v: bearing pressure times size of the sliding velocity"),
    }
    found = {name: Channel(values, "clearance", unit, meaning) for name, (values, unit, meaning) in named.items()}
    for side, name in (("bearing", "contact_angle"), ("journal", "journal_contact_angle")):
        said = f"angle of the place of contact, or of what is nearest to it, seen from the {side}'s pin"
        found[name] = Channel(contact_angle(record, side), "clearance", "rad", said, side)
    return found | (worn_channels(record) if record.assembly.topology.wears else {})


def worn_channels(record: Record) -> dict[str, Channel]:
    """Volumes that the surfaces of joints with play have lost, by Archard's law."""
    wears, found = record.assembly.topology.wears, {}
    for k, side in enumerate(SIDES):
        volume = np.zeros((len(record.steps), len(record.assembly.contacts)))
        volume[:, list(wears)] = work(record) * np.array([coefficients(record, contact)[k] for contact in wears])
        found[f"{side}_wear"] = Channel(volume, "clearance", "m^3", f"volume that the {side} has lost since the start")
    return found


def slider_channels(record: Record) -> dict[str, Channel]:
    """Position, velocity and acceleration of sliders along their guides."""
    moved = [np.column_stack(one) for one in zip(*(guides.slider_motion(record, name) for name in guides.sliders(record)), strict=True)]
    said = (("position", "m"), ("velocity", "m/s"), ("acceleration", "m/s^2"))
    return {
        f"slider_{name}": Channel(values, "slider", unit, f"{name} of the journal's pin along its guide", "guide")
        for (name, unit), values in zip(said, moved, strict=True)
    }


def ground_channels(record: Record) -> dict[str, Channel]:
    """What the mechanism does to the ground."""
    load, said = ground_load(record), "force of the mechanism on the ground"
    return {
        "ground_shaking_force": Channel(hypot(load[:, 0], load[:, 1]), None, "N", f"size of the {said}"),
        "ground_shaking_force_x": Channel(load[:, 0], None, "N", said, GLOBAL),
        "ground_shaking_force_y": Channel(load[:, 1], None, "N", said, GLOBAL),
        "ground_shaking_moment": Channel(load[:, 2], None, "N m", "moment of the mechanism on the ground about the ground's origin", GLOBAL),
    }


def stress_channels(record: Record) -> dict[str, Channel]:
    """Stresses of elements whose extreme fibre is known."""
    tension, compression = elastic.fibres(record)
    said = "stress in the outermost fibres, tension positive"
    return {
        "element_stress": Channel(elastic.stress(record), "element", "Pa", "largest size of stress in the outermost fibres"),
        "element_stress_max": Channel(tension.max(axis=2), "element", "Pa", f"largest {said}", "link"),
        "element_stress_min": Channel(compression.min(axis=2), "element", "Pa", f"smallest {said}", "link"),
    }


def elastic_channels(record: Record) -> dict[str, Channel]:
    """Largest stresses of elastic bodies; how links bend and stretch, no number for frames."""
    bodies, links = [name for name, where in record.assembly.bodies.items() if where.elements], elastic.elastic_links(record)
    none = np.full(len(record.steps), np.nan)
    of = {
        "deflection": (elastic.largest_off_the_chord, "largest deflection along the link from the line through its ends", "chord"),
        "end_deflection": (elastic.off_the_start, "deflection of the end from the direction at the start", "start"),
        "elongation": (elastic.elongation, "distance of the ends less that without forces", "link"),
    }
    found = {
        f"elastic_{name}": Channel(np.column_stack([one(record, link) if link in links else none for link in bodies]), "elastic", "m", said, frame)
        for name, (one, said, frame) in of.items()
    }
    if elastic.known(record):
        every = [elastic.extremes(record, name) for name in bodies]
        for k, kind in enumerate(("tension", "compression")):
            values = np.column_stack([one[k] for one in every])
            found[f"elastic_{kind}"] = Channel(values, "elastic", "Pa", f"largest {kind} in the outermost fibres of the body", "link")
    return found
