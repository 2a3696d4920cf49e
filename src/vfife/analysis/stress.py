"""Stress in the outermost fibres of elements, where the section's extreme fibre is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model.bodies import Body, Frame, Link, Section
from ..solvers.record import Record

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


def stress(record: Record) -> Array:
    """Largest stress |N|/A + max(|m_1|, |m_2|) e/I (Pa) in each element, NaN where the extreme fibre e is not given; (outputs, elements)."""
    found = [section for body in record.assembly.mechanism.bodies.values() for section in sections(body)]
    area, modulus = np.full(len(found), np.nan), np.full(len(found), np.nan)
    for k, section in enumerate(found):
        if section is not None and section.extreme_fibre is not None:
            area[k], modulus[k] = section.area, section.second_moment / section.extreme_fibre
    axial, first, second = (np.abs(record.block(f"frame_{name}")) for name in ("axial_force", "moment_1", "moment_2"))
    return np.asarray(axial / area + np.maximum(first, second) / modulus, dtype=float)
