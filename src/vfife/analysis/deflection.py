"""How elastic links bend and stretch: seen from the line through their ends, and from the direction of their start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels import frame
from ..model.bodies import Link
from ..model.lumping import mesh
from ..numerics.elementwise import hypot, sincos
from ..solvers.record import Record
from .losses import of_window

Array = NDArray[np.float64]


def elastic_links(record: Record) -> list[str]:
    """Links that are made of elements."""
    bodies = record.assembly.mechanism.bodies
    return [name for name, where in record.assembly.bodies.items() if where.elements and isinstance(bodies[name], Link)]


def off_the_chord(record: Record, name: str) -> Array:
    """Deflection (m) of a link's nodes, and of the middles of its elements, across the line through its ends, positive to the left of the way from
    start to end, shape (outputs, 2 elements + 1); of a bent link, against its own shape.

    The middle of an element is l/8 (theta_1 - theta_2) off the line through its nodes, the cubic of its end rotations.
    """
    where, parts = record.assembly.bodies[name], mesh(record.assembly.mechanism.bodies[name])
    nodes, own = list(where.particles), list(where.elements)
    x, y = (record.block(f"particle_{axis}")[:, nodes] for axis in "xy")
    dx, dy = x - x[:, :1], y - y[:, :1]
    length = hypot(dx[:, -1], dy[:, -1])
    c, s = (dx[:, -1] / length)[:, None], (dy[:, -1] / length)[:, None]
    across = c * dy - s * dx - parts.position[:, 1]
    bending = parts.bending
    m1, m2 = (record.block(f"frame_moment_{end}")[:, own] for end in (1, 2))
    first, second = frame.end_rotations(m1, m2, 1.0 / parts.length, bending)
    found = np.empty((len(x), 2 * len(own) + 1))
    found[:, ::2] = across
    found[:, 1::2] = 0.5 * (across[:, 1:] + across[:, :-1]) + 0.125 * parts.length * (first - second)
    return found


def largest_off_the_chord(record: Record, name: str) -> Array:
    """The deflection (m) that is largest in size along the link at each output, with its sign, shape (outputs,)."""
    every = off_the_chord(record, name)
    return np.asarray(every[np.arange(len(every)), np.abs(every).argmax(axis=1)], dtype=float)


def elongation(record: Record, name: str) -> Array:
    """Distance of the ends less that without forces (m), shape (outputs,)."""
    link = record.assembly.mechanism.bodies[name]
    first, last = record.assembly.bodies[name].particles[0], record.assembly.bodies[name].particles[-1]
    dx, dy = (record.block(f"particle_{axis}")[:, last] - record.block(f"particle_{axis}")[:, first] for axis in "xy")
    return np.asarray(hypot(dx, dy) - float(getattr(link, "length", 0.0)), dtype=float)


def off_the_start(record: Record, name: str) -> Array:
    """Deflection (m) of the end across the direction that the link has at its start, positive to the left: that of a clamped beam, (outputs,)."""
    first, last = record.assembly.bodies[name].particles[0], record.assembly.bodies[name].particles[-1]
    dx, dy = (record.block(f"particle_{axis}")[:, last] - record.block(f"particle_{axis}")[:, first] for axis in "xy")
    angle = record.block("particle_theta")[:, first]
    s, c = sincos(angle)
    return np.asarray(c * dy - s * dx, dtype=float)


def largest_deflections(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<link>.deflection.max`` (m), the largest size across the line through the link's ends, at the outputs."""
    names = elastic_links(record)
    if not names or not record.keeps("frame_moment_1") or not record.keeps("particle_x"):
        return {}
    part, inside = of_window(record, window)
    return {f"{name}.deflection.max": float(np.abs(largest_off_the_chord(part, name))[inside].max()) for name in names}
