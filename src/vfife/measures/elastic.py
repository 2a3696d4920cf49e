"""Deflection and elongation of elastic links and frames, and stresses in their outermost fibres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels import frame
from ..model.bodies import Body, Frame, Link, Section
from ..model.lumping import mesh
from ..numerics.elementwise import hypot, sincos
from ..solvers.record import Record
from .turns import Window, of_window

Array = NDArray[np.float64]


def elastic_links(record: Record) -> list[str]:
    """Return the names of links with elements."""
    bodies = record.assembly.mechanism.bodies
    return [
        name
        for name, body in record.assembly.bodies.items()
        if body.elements and isinstance(bodies[name], Link)
    ]


def chord_deflection(record: Record, name: str) -> Array:
    """Return the deflection (m) of a link's nodes, and of the middles of its elements, across the line
    through its ends, positive to the left of the way from start to end, shape (outputs, 2 elements + 1); of a
    bent link, against its own shape.

    The middle of an element is l/8 (theta_1 - theta_2) off the line through its nodes, the cubic of its end
    rotations.
    """
    body, parts = record.assembly.bodies[name], mesh(record.assembly.mechanism.bodies[name])
    nodes, elements = list(body.particles), list(body.elements)
    x, y = (record.block(f"particle_{axis}")[:, nodes] for axis in "xy")
    dx, dy = x - x[:, :1], y - y[:, :1]
    length = hypot(dx[:, -1], dy[:, -1])
    c, s = (dx[:, -1] / length)[:, None], (dy[:, -1] / length)[:, None]
    across = c * dy - s * dx - parts.position[:, 1]
    bending = parts.bending
    m1, m2 = (record.block(f"frame_moment_{end}")[:, elements] for end in (1, 2))
    first, second = frame.end_rotations(m1, m2, 1.0 / parts.length, bending)
    deflection = np.empty((len(x), 2 * len(elements) + 1))
    deflection[:, ::2] = across
    deflection[:, 1::2] = 0.5 * (across[:, 1:] + across[:, :-1]) + 0.125 * parts.length * (first - second)
    return deflection


def largest_deflection(record: Record, name: str) -> Array:
    """Return the deflection (m) that is largest in size along the link at each output, with its sign, shape
    (outputs,).
    """
    deflections = chord_deflection(record, name)
    return np.asarray(
        deflections[np.arange(len(deflections)), np.abs(deflections).argmax(axis=1)], dtype=float
    )


def elongation(record: Record, name: str) -> Array:
    """Return the distance of the ends less that without forces (m), shape (outputs,)."""
    link = record.assembly.mechanism.bodies[name]
    first, last = record.assembly.bodies[name].particles[0], record.assembly.bodies[name].particles[-1]
    dx, dy = (
        record.block(f"particle_{axis}")[:, last] - record.block(f"particle_{axis}")[:, first]
        for axis in "xy"
    )
    return np.asarray(hypot(dx, dy) - float(getattr(link, "length", 0.0)), dtype=float)


def end_deflection(record: Record, name: str) -> Array:
    """Return the deflection (m) of the end across the direction that the link has at its start, positive to
    the left: that of a clamped beam, (outputs,).
    """
    first, last = record.assembly.bodies[name].particles[0], record.assembly.bodies[name].particles[-1]
    dx, dy = (
        record.block(f"particle_{axis}")[:, last] - record.block(f"particle_{axis}")[:, first]
        for axis in "xy"
    )
    angle = record.block("particle_theta")[:, first]
    s, c = sincos(angle)
    return np.asarray(c * dy - s * dx, dtype=float)


def largest_deflections(record: Record, window: Window) -> dict[str, float]:
    """Return ``<link>.deflection.max`` (m): the largest size of :func:`chord_deflection` at the outputs."""
    part, inside = of_window(record, window)
    return {
        f"{name}.deflection.max": float(np.abs(largest_deflection(part, name))[inside].max())
        for name in elastic_links(record)
    }


def sections(body: Body) -> list[Section | None]:
    """Return the section of each element of a body, in their order."""
    if isinstance(body, Frame):
        return [
            section
            for member in body.members
            for section in [member.section or body.section] * member.elements
        ]
    return [body.section] * body.element_count if isinstance(body, Link) else []


def has_stresses(record: Record) -> bool:
    """Return whether the extreme fibre of any element is known."""
    bodies = record.assembly.mechanism.bodies
    return any(
        section is not None and section.extreme_fibre is not None
        for body in bodies.values()
        for section in sections(body)
    )


def fibres(record: Record) -> tuple[Array, Array]:
    """Return the largest tension and largest compression (Pa, tension positive) in the outermost fibres at
    both ends of each element, (outputs, elements, 2).

    N/A + |m| e/I and N/A - |m| e/I with the moment m at that end: between its ends an element's moment is
    linear, so the extremes are there. NaN where the extreme fibre e is not given.
    """
    element_sections = [
        section for body in record.assembly.mechanism.bodies.values() for section in sections(body)
    ]
    area, modulus = np.full(len(element_sections), np.nan), np.full(len(element_sections), np.nan)
    for k, section in enumerate(element_sections):
        if section is not None and section.extreme_fibre is not None:
            area[k], modulus[k] = section.area, section.second_moment / section.extreme_fibre
    axial = record.block("frame_axial_force") / area
    bent = np.stack([np.abs(record.block(f"frame_moment_{end}")) / modulus for end in (1, 2)], axis=2)
    return axial[..., None] + bent, axial[..., None] - bent


def stress(record: Record) -> Array:
    """Return the largest stress |N|/A + max(|m_1|, |m_2|) e/I (Pa) in each element, NaN where the extreme
    fibre e is not given; (outputs, elements).
    """
    tension, compression = fibres(record)
    return np.asarray(np.maximum(np.abs(tension), np.abs(compression)).max(axis=2), dtype=float)


def element_places(record: Record) -> Array:
    """Place (m) of both ends of each element, along its link from the start, or along its member of a frame,
    shape (elements, 2).
    """
    pairs: list[tuple[float, float]] = []
    for name, rows in record.assembly.bodies.items():
        if not rows.elements:
            continue
        body = record.assembly.mechanism.bodies[name]
        lengths = mesh(body).length
        pieces = [member.elements for member in body.members] if isinstance(body, Frame) else [len(lengths)]
        for piece in np.split(lengths, np.cumsum(pieces)[:-1]):
            ends = np.concatenate([[0.0], np.cumsum(piece)])
            pairs += zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)
    return np.array(pairs).reshape(-1, 2)


def extremes(record: Record, name: str) -> tuple[Array, Array]:
    """Return the largest tension and largest compression (Pa, both positive, 0 where there is none) anywhere
    in an elastic body, shape (outputs,) each.
    """
    elements = list(record.assembly.bodies[name].elements)
    tension, compression = (stresses[:, elements] for stresses in fibres(record))
    if np.isnan(tension).all():
        return np.full(len(tension), np.nan), np.full(len(tension), np.nan)
    return np.maximum(np.nanmax(tension, axis=(1, 2)), 0.0), np.maximum(
        -np.nanmin(compression, axis=(1, 2)), 0.0
    )


def largest_stresses(record: Record, window: Window) -> dict[str, float]:
    """Return ``<body>.tension.max``, ``<body>.compression.max`` (Pa): largest stresses N/A +- |m| e/I at the
    outputs.

    ``<body>.stress.place`` (m) is where the larger of both is, along the link from its start, or along its
    frame member.
    """
    extreme: dict[str, float] = {}
    if not has_stresses(record):
        return extreme
    part, inside = of_window(record, window)
    tension, compression = (end[inside] for end in fibres(part))
    places = element_places(record)
    for name, body in record.assembly.bodies.items():
        elements = list(body.elements)
        if not elements or np.isnan(tension[:, elements]).all():
            continue
        for kind, values in zip(("tension", "compression"), extremes(part, name), strict=True):
            extreme[f"{name}.{kind}.max"] = float(values[inside].max())
        sizes = np.nan_to_num(
            np.maximum(np.abs(tension[:, elements]), np.abs(compression[:, elements])).max(axis=0), nan=-1.0
        )
        extreme[f"{name}.stress.place"] = float(
            places[elements][np.unravel_index(int(sizes.argmax()), sizes.shape)]
        )
    return extreme
