"""Quantities that are about zero on the scale of a mechanism, whose digits are rounding."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..assembly.assembled import Assembly
from ..solvers.record import Record
from ..solvers.scales import NEGLIGIBLE, Scales, scales
from .energy import zero_mean_limits
from .motion import at_rest
from .values import Measured

# Of the size of a mechanism: gaps that rounding of positions leaves in a joint, 8 u (rounding.py), as they
# show in runs with a quarter of the step.
GAP = 16.0 * 8.0 * 2.0**-53


def zero_limits(record: Record, largest: Mapping[str, float]) -> dict[str, float]:
    """Return the measures that are about zero, with the limits (unit of the measure) below which they are
    called that; ``largest``: their largest magnitudes at all step sizes.

    The limit is the share NEGLIGIBLE of the scale of their kind; what is zero at all steps is exact. Mean
    torque and power of a driver are small beside its largest torque where it drives against inertia, so they
    are about zero only if that is, or beside it (:func:`~vfife.measures.energy.zero_mean_limits`).
    """
    scale = scales_of_run(record)
    limits = {name: NEGLIGIBLE * scale.of(name) for name in largest}
    limits = {name: limit for name, limit in limits.items() if 0.0 < largest[name] <= limit}
    for name in [name for name in limits if name.endswith(".torque.max")]:
        body, torque = name.removesuffix(".torque.max"), limits[name]
        means = {
            f"{body}.torque.mean": torque,
            f"{body}.torque.rms": torque,
            f"{body}.energy_fluctuation": 2.0 * math.pi * torque,
            f"{body}.power.mean": torque * scale.speed / scale.length,
        }
        limits |= {mean: limit for mean, limit in means.items() if largest.get(mean, math.inf) <= limit}
    limits |= {name: limit for name, limit in zero_mean_limits(largest).items() if name not in limits}
    for joint, contacts in contacts_of(record).items():  # knocks of no speed lose no energy
        name, limit = f"{joint}.impact_power.mean", NEGLIGIBLE * scale.force * scale.speed
        speeds = [f"{contact}.approach_speed.max" for contact in contacts]
        if all(speed in limits for speed in speeds) and 0.0 < largest.get(name, 0.0) <= limit:
            limits[name] = limit
    return limits


def scales_of_run(record: Record) -> Scales:
    """Return the scales of a mechanism; where its model gives no force, with that of its run.

    Wheels on shafts through their centres of mass and masses on springs have neither loads nor weights nor
    m r w^2: the force that counts is the largest of their springs, or that which takes the kinetic energy of
    the start on the extent of the mechanism. Where nothing moves, forces are those that close gaps of the
    size of rounding in one step.
    """
    assembly = record.assembly
    scale = scales(assembly)
    if scale.force > 0.0 or record.static:
        return scale
    force = max(_spring_force(record, scale.length), _starting_force(assembly, scale.length))
    if at_rest(record):
        mass, step = sum(body.mass for body in assembly.bodies.values()), assembly.choice.step
        force = max(force, GAP * mass * scale.length / (step * step) / NEGLIGIBLE)
    return scales(assembly, force)


def _spring_force(record: Record, size: float) -> float:
    """Return the largest force (N) of the springs in a run, of torsional ones as a couple on ``size`` (m)."""
    if not record.assembly.springs or not record.keeps("spring_force_squared_max"):
        return 0.0
    largest = np.sqrt(record.block("spring_force_squared_max").max(axis=0))
    springs = record.assembly.mechanism.springs
    arms = [1.0 if springs[name].between_pins else size for name in record.assembly.springs]
    return float((largest / np.array(arms)).max(initial=0.0))


def _starting_force(assembly: Assembly, size: float) -> float:
    """Return the largest m v^2/l or I w^2/l (N) of a particle at the start; l is the extent ``size`` (m)."""
    state, layout = assembly.state, assembly.layout
    u, v, w = (state[layout[f"particle_{rate}"]] for rate in "uvw")
    forces = [0.0]
    for squares, inverse in ((u * u + v * v, "inverse_mass"), (w * w, "inverse_inertia")):
        inverses = state[layout[f"particle_{inverse}"]]
        moves = inverses > 0.0
        forces.append(float((squares[moves] / inverses[moves]).max(initial=0.0)) / size)
    return max(forces)


def contacts_of(record: Record) -> dict[str, list[str]]:
    """Return the contacts of each joint with clearance."""
    contacts: dict[str, list[str]] = {}
    for contact, joint in zip(record.assembly.contacts, record.assembly.contact_joints, strict=True):
        contacts.setdefault(joint, []).append(contact)
    return contacts


def about_zero(record: Record, measures: Mapping[str, Measured]) -> dict[str, float]:
    """Return the measures of a run that are about zero at all step sizes, with their :func:`zero_limits`."""
    if record.static:
        return {}
    return zero_limits(
        record, {name: max(abs(value.low), abs(value.high)) for name, value in measures.items()}
    )
