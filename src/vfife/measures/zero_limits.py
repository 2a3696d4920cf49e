"""Quantities that are about zero on the scale of a mechanism, whose digits are rounding."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..solvers.record import Record
from ..solvers.scales import NEGLIGIBLE, scales
from .energy import zero_mean_limits
from .values import Measured


def zero_limits(record: Record, largest: Mapping[str, float]) -> dict[str, float]:
    """Return the measures that are about zero, with the limits (unit of the measure) below which they are
    called that; ``largest``: their largest magnitudes at all step sizes.

    The limit is the share NEGLIGIBLE of the scale of their kind; what is zero at all steps is exact. Mean
    torque and power of a driver are small beside its largest torque where it drives against inertia, so they
    are about zero only if that is, or beside it (:func:`~vfife.measures.energy.zero_mean_limits`).
    """
    scale = scales(record.assembly)
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
