"""Wear of joints with clearance: volumes lost by bearing and journal, and depth around the joint.

A surface with the coefficient k loses V = k W, with W the sum of normal force times sliding distance (Archard
1953), which the step accumulates together with its direction. Over the angle phi around a joint of length L
the depth of a surface of radius R is h = k/(R L) dW/dphi.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.topology import BEARING
from ..laws.materials import coefficient
from ..model.surfaces import surfaces
from ..numerics.elementwise import atan2, hypot, interpolate, sin
from ..solvers.record import Record
from .turns import Window, of_turn

Array = NDArray[np.float64]
SIDES = ("bearing", "journal")
PLACES = 360  # around a joint, at which depths are known
WIDTH = 2.0 * np.pi / PLACES  # of one of them


class Rubbing(NamedTuple):
    """Sliding of a contact in each interval between outputs: ``work`` (N m), its direction around bearing or
    journal (rad), and the half-width ``spread`` (rad) of the arc with half of it; shape (intervals,) each.
    """

    work: Array
    angle: Array
    spread: Array


def wear_contacts(record: Record) -> dict[str, int]:
    """Return the indices of the contacts with wear, by name."""
    return {record.assembly.contacts[k]: k for k in record.assembly.topology.wears}


def work(record: Record) -> Array:
    """Return normal force times sliding distance (N m) of each contact with wear since the start, shape
    (outputs, contacts).
    """
    return record.block("wear_work")


def coefficients(record: Record, contact: int) -> tuple[float, float]:
    """Return k (1/Pa) of bearing and journal of a contact."""
    mechanism = record.assembly.mechanism
    joint = mechanism.contacts[record.assembly.contact_joints[contact]]
    pair = surfaces(mechanism, joint)
    coefficients_of_sides = (coefficient(getattr(joint.wear, side), getattr(pair, side)) for side in SIDES)
    first, second = (0.0 if factor is None else factor for factor in coefficients_of_sides)
    return first, second


def rubbing(record: Record, contact: int, side: str) -> Rubbing:
    """Return the sliding of one side of a contact between outputs, in the frame of its body in the middle of
    each interval.

    Parts of an interval lie on an arc whose mean direction has the length sin(a)/a, with a its half angle;
    the summed directions give that length.
    """
    place = record.assembly.topology.wears.index(contact)
    done, x, y = (np.diff(record.block(f"wear_{name}")[:, place]) for name in ("work", "x", "y"))
    particle = getattr(record.assembly.topology, f"contact_{side}")[contact]
    turned = record.block("particle_theta")[:, particle]
    angle = atan2(y, x) - 0.5 * (turned[1:] + turned[:-1])
    length = np.divide(hypot(x, y), done, out=np.ones_like(done), where=done > 0.0)
    return Rubbing(done, np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi, half_arc(length))


def half_arc(length: Array) -> Array:
    """Return a with sin(a)/a = ``length``, from 0 at 1 to pi at 0."""
    arcs = np.linspace(np.pi, 0.0, 2001)
    share = np.divide(sin(arcs), arcs, out=np.ones_like(arcs), where=arcs > 0.0)
    return np.asarray(interpolate(np.clip(length, 0.0, 1.0), share, arcs), dtype=float)


def work_around(part: Rubbing) -> Array:
    """Return the work (N m) at each of ``PLACES`` around the joint, from -pi on; their sum is that of the
    intervals, to rounding.
    """
    work_at, wide = np.zeros(PLACES), np.maximum(part.spread, 0.5 * WIDTH)
    rubs = np.flatnonzero(part.work > 0.0)
    reach = np.ceil(wide[rubs] / WIDTH).astype(int) + 1
    part_of_two, exponent = np.frexp(np.maximum(reach, 1))
    for spread in np.unique(
        1 << (exponent - (part_of_two == 0.5)).astype(int)
    ):  # intervals of like spreads together
        narrow = rubs[(reach <= spread) & (reach > spread // 2)]
        middle = np.floor((part.angle[narrow] + np.pi) / WIDTH).astype(int)[:, None]
        edges = (middle + np.arange(-spread, spread + 2)) * WIDTH - np.pi
        share_below = np.clip(
            (edges - (part.angle - wide)[narrow, None]) / (2.0 * wide[narrow, None]), 0.0, 1.0
        )
        places = (middle + np.arange(-spread, spread + 1)) % PLACES
        work_at += np.bincount(
            places.reshape(-1),
            (part.work[narrow, None] * (share_below[:, 1:] - share_below[:, :-1])).reshape(-1),
            PLACES,
        )
    return work_at


def depths(record: Record, contact: int) -> tuple[Array, Array]:
    """Return the depth (m) that bearing and journal of a contact lose over a record, at ``PLACES`` around
    each, in the frame of its body.
    """
    depths = []
    for side, k, area in zip(SIDES, coefficients(record, contact), areas(record, contact), strict=True):
        depths.append(k / area * work_around(rubbing(record, contact, side)))
    return depths[0], depths[1]


def areas(record: Record, contact: int) -> tuple[float, float]:
    """Return the area (m^2) of each of the ``PLACES`` on bearing and journal."""
    joint = record.assembly.mechanism.contacts[record.assembly.contact_joints[contact]]
    touching = joint.touchings(0.0)[0]
    bearing, journal = (abs(radius) * joint.axial_length * 2.0 * np.pi / PLACES for radius in touching.arms)
    return bearing, journal


def is_round(record: Record, contact: int) -> bool:
    """Return whether a contact is that of a journal in its bearing, which wears around its circumference."""
    return record.assembly.topology.contact_kind[contact] == BEARING


def wear_volumes(record: Record, window: Window) -> dict[str, float]:
    """Return ``<joint>.bearing_wear.total``, ``.journal_wear.total`` (m^3): k W over the window, summed over
    the joint's contacts.
    """
    values: dict[str, float] = {}
    done = work(of_turn(record, window))
    for place, contact in enumerate(record.assembly.topology.wears):
        joint = record.assembly.contact_joints[contact]
        for side, k in zip(SIDES, coefficients(record, contact), strict=True):
            name = f"{joint}.{side}_wear.total"
            values[name] = values.get(name, 0.0) + k * float(done[-1, place] - done[0, place])
    return values


def wear_depths(record: Record, window: Window) -> dict[str, float]:
    """Return ``<joint>.bearing_wear_depth.max``, ``.journal_wear_depth.max`` (m): the largest depth lost
    around the joint over the window.
    """
    part, values = of_turn(record, window), dict[str, float]()
    for name, contact in wear_contacts(record).items():
        if is_round(record, contact):
            for side, depth in zip(SIDES, depths(part, contact), strict=True):
                values[f"{name}.{side}_wear_depth.max"] = float(depth.max())
    return values
