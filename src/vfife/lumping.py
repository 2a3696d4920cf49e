"""Mass of bodies: exact for rigid ones, lumped at particles for elastic links (Eq. 2 of the VFIFE paper, corrected)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .bodies import Body, Link, Point, PointMass, RigidBody, Section


@dataclass(frozen=True)
class Lumps:
    """Particles of a link: position along it (m), mass (kg) and rotary inertia (kg m^2), each of shape (k + 1,)."""

    position: NDArray[np.float64]
    mass: NDArray[np.float64]
    inertia: NDArray[np.float64]


def lumped(link: Link) -> Lumps:
    """Eq. 2: half of each element's mass at its ends, I = sum of half masses times the section's radius of gyration squared.

    The print has I = sum 1/2 m_i r^2 with r "of the cross section at the node"; r^2 = I_section/A. Attached masses are added at the ends.
    """
    k = link.element_count
    share = np.full(k, link.own_mass / k)
    mass = np.zeros(k + 1)
    mass[:-1] += 0.5 * share
    mass[1:] += 0.5 * share
    section = section_of(link)
    inertia = mass * (section.second_moment / section.area)
    mass[0] += link.start_mass
    mass[-1] += link.end_mass
    return Lumps(np.linspace(0.0, link.length, k + 1), mass, inertia)


def section_of(link: Link) -> Section:
    """Section of an elastic link; a sentence if it has none."""
    if link.section is None:
        raise ValueError(f"link {link.name!r} is {link.model} and needs a section (area and second moment of area)")
    return link.section


def rigid_properties(body: Body) -> tuple[float, Point, float]:
    """Mass (kg), centre of mass (m, body's frame) and inertia about it (kg m^2), as the body is calculated if it were rigid."""
    if isinstance(body, PointMass):
        return body.mass, (0.0, 0.0), body.inertia
    if isinstance(body, RigidBody):
        return body.mass, body.center, body.inertia
    if not isinstance(body, Link):
        raise TypeError(f"{type(body).__name__} is no body")
    if body.element_count:
        lumps = lumped(body)
        return _together(lumps.position, lumps.mass, lumps.inertia if body.release != "both" else 0.0 * lumps.inertia)
    center = 0.5 * body.length if body.center_at is None else body.center_at
    inertia = body.own_mass * body.length**2 / 12.0 if body.inertia is None else body.inertia
    ends = np.array([center, 0.0, body.length])
    return _together(ends, np.array([body.own_mass, body.start_mass, body.end_mass]), np.array([inertia, 0.0, 0.0]))


def _together(at: NDArray[np.float64], mass: NDArray[np.float64], inertia: NDArray[np.float64]) -> tuple[float, Point, float]:
    total = float(mass.sum())
    center = float(mass @ at) / total
    return total, (center, 0.0), float(inertia.sum() + mass @ (at - center) ** 2)


def rigidified(body: Body) -> Body:
    """The body as a rigid one with the same (lumped) mass, centre and inertia."""
    if isinstance(body, Link) and body.element_count:
        mass, center, inertia = rigid_properties(body)
        return dataclasses.replace(
            body, link_model="rigid", mass=mass, inertia=inertia, center_at=center[0], start_mass=0.0, end_mass=0.0, release="none"
        )
    return body
