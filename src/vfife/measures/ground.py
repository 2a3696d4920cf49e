"""What a mechanism does to the ground that carries it: shaking force and shaking moment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels.topology import GEARED
from ..kinematics.forces import driven_body
from ..numerics.elementwise import hypot
from ..solvers.record import Record
from .contacts import of_window, places
from .forces import contact_force
from .motion import seen

Array = NDArray[np.float64]


def ground_load(record: Record) -> Array:
    """Force (N, N) of the mechanism on the ground, and its moment (N m) about the ground's origin, global
    axes, shape (outputs, 3).

    The sum of all that acts on the ground: joints, with play and without, pivots and torques of drivers,
    gears on fixed carriers, springs, and loads whose opposite the ground takes, as the head of a cylinder
    does. Other loads and weight act on bodies from outside; so what is told is them less the rate of change
    of momentum: F = sum (F_ext - m a), the shaking force of a mechanism without loads and weight being -sum m
    a.
    """
    total = np.zeros((len(record.steps), 3))
    for part in (_ideals, _contacts, _springs, _drivers, _motors, _loads):
        total += part(record)
    return total


def _at(force: Array, place: Array, moment: Array | float = 0.0) -> Array:
    """A force at a place and a moment, as force and moment about the origin, (outputs, 3)."""
    return np.column_stack([force, place[:, 0] * force[:, 1] - place[:, 1] * force[:, 0] + moment])


def _ideals(record: Record) -> Array:
    """Joints without play, gears, and drivers that hold no pivot; on the bearing the opposite acts in the
    same place, -ratio times the moment.
    """
    t, total = record.assembly.topology, np.zeros((len(record.steps), 3))
    if not t.joint_bearing:
        return total
    place, ratios = seen(record, "joint", "journal"), record.parameter("joint_ratio")
    fx, fy, moment = (record.block(f"joint_{name}") for name in ("fx", "fy", "moment"))
    ends = zip(t.joint_bearing, t.joint_journal, t.carriers, strict=True)
    for k, ((bearing, journal, carrier), (_, turn)) in enumerate(zip(ends, t.held, strict=True)):
        force, ratio = np.column_stack([fx[:, k], fy[:, k]]), float(ratios[k]) if turn == GEARED else 1.0
        if bearing == 0:
            total += _at(-force, place[:, k], -ratio * moment[:, k])
        if journal == 0:
            total += _at(force, place[:, k], moment[:, k])
        if carrier == 0:
            total[:, 2] += (ratio - 1.0) * moment[:, k]
    return total


def _contacts(record: Record) -> Array:
    t, total = record.assembly.topology, np.zeros((len(record.steps), 3))
    if not t.contact_bearing:
        return total
    force = contact_force(record)
    for sign, side, reach in zip(
        (-1.0, 1.0), ("bearing", "journal"), places(record, stepped=True), strict=True
    ):
        where = seen(record, "contact", side) + reach
        for k, body in enumerate(getattr(t, f"contact_{side}")):
            if body == 0:
                total += _at(sign * force[:, k], where[:, k])
    return total


def _springs(record: Record) -> Array:
    t, total = record.assembly.topology, np.zeros((len(record.steps), 3))
    if not t.spring_first:
        return total
    where = seen(record, "spring", "second")
    fx, fy, moment = (record.block(f"spring_{name}") for name in ("fx", "fy", "moment"))
    for k, ends in enumerate(zip(t.spring_first, t.spring_second, strict=True)):
        for sign, body in zip((-1.0, 1.0), ends, strict=True):
            if body == 0:
                total += _at(sign * np.column_stack([fx[:, k], fy[:, k]]), where[:, k], sign * moment[:, k])
    return total


def _drivers(record: Record) -> Array:
    """Pivots of driven bodies, and the torques that turn them against the ground."""
    total = np.zeros((len(record.steps), 3))
    for k, p in enumerate(record.assembly.topology.driven):
        force = -np.column_stack([record.block(f"driven_f{axis}")[:, k] for axis in "xy"])
        place = np.column_stack([record.block(f"particle_{axis}")[:, p] for axis in "xy"])
        total += _at(force, place, -record.block("driven_torque")[:, k])
    return total


def _motors(record: Record) -> Array:
    """Torques against the ground, whose housings stand on it."""
    mechanism, total = record.assembly.mechanism, np.zeros((len(record.steps), 3))
    at = sum(len(load.pushes(mechanism.joints)) for load in mechanism.loads.values())
    for name, driver in mechanism.drivers.items():
        if driver.moves:
            continue
        if driven_body(name, driver) and driver.against == "ground":
            value = record.block("function_value")[:, record.assembly.topology.load_function[at]]
            total[:, 2] -= value * float(record.parameter("load_m")[at])
        at += 2 if driven_body(name, driver) and driver.against != "ground" else 1
    return total


def _loads(record: Record) -> Array:
    """Loads on the ground itself."""
    t, total = record.assembly.topology, np.zeros((len(record.steps), 3))
    for k, body in enumerate(t.load_particle):
        if body == 0:
            x, y, fx, fy, moment = (
                float(record.parameter(f"load_{name}")[k]) for name in ("x", "y", "fx", "fy", "m")
            )
            value = record.block("function_value")[:, t.load_function[k]]
            total += value[:, None] * np.array([fx, fy, x * fy - y * fx + moment])
    return total


def largest_shaking(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``ground.shaking_force.max`` (N) and ``ground.shaking_moment.max`` (N m, about the ground's origin),
    largest sizes at the outputs.
    """
    if not record.keeps("particle_x"):
        return {}
    part, inside = of_window(record, window)
    load = ground_load(part)[inside]
    return {
        "ground.shaking_force.max": float(hypot(load[:, 0], load[:, 1]).max()),
        "ground.shaking_moment.max": float(np.abs(load[:, 2]).max()),
    }
