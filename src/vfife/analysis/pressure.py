"""How hard the surfaces of a joint with play press on each other: Hertz' line contact, and the load that a plain bearing is chosen by."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..laws import Pair
from ..model.surfaces import surfaces
from ..solvers.record import Record
from .losses import of_window
from .motion import times
from .sliding import sliding_speed

Array = NDArray[np.float64]
CONFORMAL = 0.3  # half-width over journal radius: beyond, a half-space is no picture of the surfaces (Johnson 1985, Section 5.3)


def line_pressure(pair: Pair, force: Array) -> tuple[Array, Array]:
    """Largest pressure (Pa) and half-width (m) of two cylinders pressed together over their axial length by a force (N) of any shape.

    a = sqrt(4 F R/(pi L E*)) and p_0 = 2 F/(pi a L), R = R_B R_J/(R_B -+ R_J), minus for a journal in its bearing: Hertz' line contact; Johnson,
    Contact Mechanics (1985), Eq. 4.43 and 4.45. No contact is wider than its journal: a is R_J at the most, where p_0 becomes 4 F/(pi d L), that of
    a snug pin whose pressure goes with the cosine. From a = 0.3 R_J (``CONFORMAL``) on Hertz' half-spaces are a coarse picture, and p_0 is too low.
    """
    per_length, radius = np.maximum(force, 0.0) / pair.axial_length, pair.relative_radius
    pressure = np.sqrt(per_length * pair.composite_modulus / (math.pi * radius))
    half = np.sqrt(4.0 * per_length * radius / (math.pi * pair.composite_modulus))
    journal = pair.journal_radius
    return np.maximum(pressure, 2.0 * per_length / (math.pi * journal)), np.minimum(half, journal)


def mean_pressure(pair: Pair, force: Array) -> Array:
    """Load on a bearing (Pa): F/(2 R_J L), over the projected area of the journal; beside another round or on a line F/(2 a L), over the contact.

    The first is the p of the p v of plain bearings (ISO 4379, makers' tables).
    """
    half = np.maximum(line_pressure(pair, force)[1], 1e-300) if pair.external else pair.journal_radius
    return np.asarray(np.maximum(force, 0.0) / (2.0 * half * pair.axial_length), dtype=float)


def pairs(record: Record) -> list[Pair]:
    """The surfaces of each contact; a corner of a block in a guide is a round on a line."""
    mechanism = record.assembly.mechanism
    return [surfaces(mechanism, mechanism.contacts[name]) for name in record.assembly.contact_joints]


def pressures(record: Record) -> tuple[Array, Array, Array]:
    """Largest pressure (Pa), half-width (m) and load on the bearing (Pa) of each contact at the outputs, shape (outputs, contacts) each."""
    force = record.block("contact_normal_force")
    found = np.zeros((3, *force.shape))
    for k, pair in enumerate(pairs(record)):
        found[0, :, k], found[1, :, k] = line_pressure(pair, force[:, k])
        found[2, :, k] = mean_pressure(pair, force[:, k])
    return found[0], found[1], found[2]


def load_times_speed(record: Record) -> Array:
    """p v (W/m^2) of each contact at the outputs: load on the bearing times size of the sliding velocity, shape (outputs, contacts)."""
    return np.asarray(pressures(record)[2] * np.abs(sliding_speed(record)), dtype=float)


def largest(record: Record, window: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Largest pressure (Pa) and half-width (m) of each contact over a window, shape (contacts,) each.

    From the extremes of its force between outputs, friction counted with it: with a coefficient of 0.1 a pressure 0.25 % too high.
    """
    force = np.sqrt(record.block("contact_force_squared_max")[window].max(axis=0))
    found = [line_pressure(pair, one) for pair, one in zip(pairs(record), force, strict=True)]
    return np.array([float(p) for p, _ in found]), np.array([float(a) for _, a in found])


def largest_pressures(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<contact>.contact_pressure.max`` (Pa), ``.contact_half_width.max`` (m), extremes between outputs with them, and
    ``.pressure_velocity.max`` and ``.mean`` (W/m^2), at the outputs; the mean is that over time, the time apart with it.
    """
    found: dict[str, float] = {}
    if not record.assembly.contacts:
        return found
    pressure, width = largest(record, window)
    for k, name in enumerate(record.assembly.contacts):
        found |= {f"{name}.contact_pressure.max": float(pressure[k]), f"{name}.contact_half_width.max": float(width[k])}
    if not record.keeps("particle_u"):
        return found
    part, inside = of_window(record, window)
    product, time = load_times_speed(part), times(part)
    for k, name in enumerate(record.assembly.contacts):
        found[f"{name}.pressure_velocity.max"] = float(product[inside, k].max())
        if len(time) > 1:
            found[f"{name}.pressure_velocity.mean"] = float(np.trapezoid(product[:, k], time) / (time[-1] - time[0]))
    return found
