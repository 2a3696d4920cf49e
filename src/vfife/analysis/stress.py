"""Stress in the outermost fibres of elements, where the section's extreme fibre is known, and where along a link it is largest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model.bodies import Body, Frame, Link, Section
from ..model.lumping import mesh
from ..solvers.record import Record
from .losses import of_window

Array = NDArray[np.float64]


def sections(body: Body) -> list[Section | None]:
    """Section of each element of a body, in their order."""
    if isinstance(body, Frame):
        return [section for member in body.members for section in [member.section or body.section] * member.elements]
    return [body.section] * body.element_count if isinstance(body, Link) else []


def known(record: Record) -> bool:
    """Whether any element's extreme fibre is known."""
    bodies = record.assembly.mechanism.bodies
    return any(section is not None and section.extreme_fibre is not None for body in bodies.values() for section in sections(body))


def fibres(record: Record) -> tuple[Array, Array]:
    """Largest tension and largest compression (Pa, tension positive) in the outermost fibres at both ends of each element, (outputs, elements, 2).

    N/A + |m| e/I and N/A - |m| e/I with the moment m at that end: between its ends an element's moment is linear, so the extremes are there. NaN
    where the extreme fibre e is not given.
    """
    found = [section for body in record.assembly.mechanism.bodies.values() for section in sections(body)]
    area, modulus = np.full(len(found), np.nan), np.full(len(found), np.nan)
    for k, section in enumerate(found):
        if section is not None and section.extreme_fibre is not None:
            area[k], modulus[k] = section.area, section.second_moment / section.extreme_fibre
    axial = record.block("frame_axial_force") / area
    bent = np.stack([np.abs(record.block(f"frame_moment_{end}")) / modulus for end in (1, 2)], axis=2)
    return axial[..., None] + bent, axial[..., None] - bent


def stress(record: Record) -> Array:
    """Largest stress |N|/A + max(|m_1|, |m_2|) e/I (Pa) in each element, NaN where the extreme fibre e is not given; (outputs, elements)."""
    tension, compression = fibres(record)
    return np.asarray(np.maximum(np.abs(tension), np.abs(compression)).max(axis=2), dtype=float)


def along(record: Record) -> Array:
    """Place (m) of both ends of each element, along its link from the start, or along its member of a frame, shape (elements, 2)."""
    found: list[tuple[float, float]] = []
    for name, where in record.assembly.bodies.items():
        if not where.elements:
            continue
        body = record.assembly.mechanism.bodies[name]
        lengths = mesh(body).length
        pieces = [member.elements for member in body.members] if isinstance(body, Frame) else [len(lengths)]
        for piece in np.split(lengths, np.cumsum(pieces)[:-1]):
            ends = np.concatenate([[0.0], np.cumsum(piece)])
            found += zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)
    return np.array(found).reshape(-1, 2)


def extremes(record: Record, name: str) -> tuple[Array, Array]:
    """Largest tension and largest compression (Pa, both positive, 0 where there is none) anywhere in an elastic body, shape (outputs,) each."""
    own = list(record.assembly.bodies[name].elements)
    tension, compression = (one[:, own] for one in fibres(record))
    if np.isnan(tension).all():
        return np.full(len(tension), np.nan), np.full(len(tension), np.nan)
    return np.maximum(np.nanmax(tension, axis=(1, 2)), 0.0), np.maximum(-np.nanmin(compression, axis=(1, 2)), 0.0)


def largest_stresses(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<body>.tension.max`` and ``<body>.compression.max`` (Pa) at the outputs, and ``<body>.stress.place`` (m): where the larger of both is
    along the link from its start, or along its member of a frame.
    """
    found: dict[str, float] = {}
    if not record.keeps("frame_axial_force") or not known(record):
        return found
    part, inside = of_window(record, window)
    tension, compression = (one[inside] for one in fibres(part))
    places = along(record)
    for name, where in record.assembly.bodies.items():
        own = list(where.elements)
        if not own or np.isnan(tension[:, own]).all():
            continue
        found |= {
            f"{name}.{kind}.max": float(one[inside].max()) for kind, one in zip(("tension", "compression"), extremes(part, name), strict=True)
        }
        sizes = np.nan_to_num(np.maximum(np.abs(tension[:, own]), np.abs(compression[:, own])).max(axis=0), nan=-1.0)
        found[f"{name}.stress.place"] = float(places[own][np.unravel_index(int(sizes.argmax()), sizes.shape)])
    return found
