"""How fast the surfaces of a joint with play slide on each other, and how far in all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import sincos
from ..solvers.record import Record
from .forces import eccentricity, normals
from .losses import of_window, per_joint
from .motion import velocities

Array = NDArray[np.float64]


def arms(record: Record, stepped: bool = False) -> tuple[Array, Array]:
    """Distances (m) of the surfaces of bearing and journal from their pins along the contact's normal, shape (outputs, contacts) each.

    Radii, and half the overlap; where friction acts without a moment (``friction_moment`` off, films) the surfaces slide all the same.
    ``stepped``: the arms of friction instead, as the step has them.
    """
    mechanism, assembly = record.assembly.mechanism, record.assembly
    if stepped:
        change = record.parameter("contact_arm_overlap") * record.block("contact_penetration")
        return record.parameter("contact_arm_bearing") + change, record.parameter("contact_arm_journal") - change
    depth = np.maximum(record.block("contact_penetration"), 0.0) * 0.5
    own = [one.arms for name in dict.fromkeys(assembly.contact_joints) for one in mechanism.contacts[name].touchings(0.0)]
    bearing, journal = np.array(own).reshape(-1, 2).T
    return bearing + depth, journal - depth


def places(record: Record, stepped: bool = False) -> tuple[Array, Array]:
    """Vectors (m) from the pins of bearing and journal to the place of contact (where friction acts in the step if ``stepped``).

    Global axes, shape (outputs, contacts, 2) each.
    """
    n, away = normals(record), eccentricity(record)
    on_bearing, on_journal = arms(record, stepped)
    t = np.stack([-n[..., 1], n[..., 0]], axis=2)
    along = (away * t).sum(axis=2)
    beyond = np.zeros_like(along)
    slots = [k for k, path in enumerate(record.assembly.contact_paths) if path is not None]
    if slots:  # the middle of a slot lies beside the bearing's pin
        middle = (away * n).sum(axis=2) - (record.block("contact_penetration") + record.parameter("contact_size"))
        beyond[:, slots] = middle[:, slots]
    return (on_bearing + beyond)[..., None] * n + along[..., None] * t, on_journal[..., None] * n


def sliding_speed(record: Record) -> Array:
    """Velocity (m/s) of the journal's surface on the bearing's at the place of contact, along t = n turned anticlockwise, (outputs, contacts).

    n is that of the normal force (:func:`~vfife.analysis.forces.normals`). With friction F_T along t, friction takes the power -F_T v. It is 0
    where the surfaces are apart and no film is between them.
    """
    topology, moving = record.assembly.topology, velocities(record)
    if not record.assembly.contacts:
        return np.zeros((len(record.steps), 0))
    n = normals(record)
    t = np.stack([-n[..., 1], n[..., 0]], axis=2)
    total = np.zeros_like(t)
    for sign, side, reach in zip((-1.0, 1.0), ("bearing", "journal"), places(record), strict=True):
        body = list(getattr(topology, f"contact_{side}"))
        angle = record.block("particle_theta")[:, body]
        x, y = (record.parameter(f"contact_{side}_{axis}") for axis in "xy")
        s, c = sincos(angle)
        rx, ry, w = c * x - s * y + reach[..., 0], s * x + c * y + reach[..., 1], moving["w"][:, body]
        total += sign * np.stack([moving["u"][:, body] - w * ry, moving["v"][:, body] + w * rx], axis=2)
    contacts = record.assembly.mechanism.contacts
    film = np.array([contacts[name].contact.film for name in record.assembly.contact_joints])
    return np.where(film | (record.block("contact_penetration") > 0.0), (total * t).sum(axis=2), 0.0)


def contact_time(record: Record) -> Array:
    """Time (s) in contact within the interval up to each output, counted step by step in the run, shape (outputs, contacts)."""
    return np.diff(record.block("contact_duration"), axis=0, prepend=0.0)


def largest_sliding(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<contact>.sliding_velocity.max`` (m/s), the largest size at an output, and ``<joint>.sliding_distance.total`` (m) over the window.

    The distance is the sum of the sizes at the outputs times the time in contact before them.
    """
    found: dict[str, float] = {}
    if not record.assembly.contacts or not record.keeps("particle_u"):
        return found
    part, inside = of_window(record, window)
    speed = np.abs(sliding_speed(part))
    for k, name in enumerate(record.assembly.contacts):
        found[f"{name}.sliding_velocity.max"] = float(speed[inside, k].max())
    way = speed[1:] * np.diff(part.block("contact_duration"), axis=0)
    return found | {f"{name}.sliding_distance.total": float(one) for name, one in per_joint(record, way.sum(axis=0)).items()}
