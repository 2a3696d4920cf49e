"""Rods whose given mass is not that of their section: a slip of a unit, or a section that stands for the stiffness alone."""

from __future__ import annotations

from collections.abc import Iterator

from ..numerics.scalar import distance
from .bodies import Frame, Link
from .mechanism import Mechanism

APART = 0.1  # of the section's mass, by which a given one may differ without a remark


def contradictions(mechanism: Mechanism) -> tuple[str, ...]:
    """A sentence on each rod whose mass is given and differs by more than a tenth from density times area times length."""
    return tuple(
        f"{name}: its mass is given as {given:.4g} kg, its section and density make {made:.4g} kg; the given one counts for inertia, the section "
        "for stiffness and stress. Leave the mass out, or check units and section."
        for name, given, made in _weighed(mechanism)
        if abs(given - made) > APART * made
    )


def _weighed(mechanism: Mechanism) -> Iterator[tuple[str, float, float]]:
    """Name, given mass (kg) and that of the section, of all rods that have both."""
    for name, body in mechanism.bodies.items():
        if isinstance(body, Link) and body.mass is not None and body.section is not None:
            yield f"Link {name}", body.mass, body.material.density * body.section.area * body.path_length
        if not isinstance(body, Frame):
            continue
        for member in body.members:
            section, material = member.section or body.section, member.material or body.material
            if member.mass is not None and section is not None:
                length = distance(body.nodes[member.start], body.nodes[member.end])
                yield f"Member {member.start}-{member.end} of {name}", member.mass, material.density * section.area * length
