"""Mass properties of bodies: exact for rigid ones, lumped at particles for elastic ones (Eq. 2 of the VFIFE
paper, corrected).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import hypot
from .bodies import Body, Frame, Link, Point, PointMass, RigidBody, Section, Strain

Array = NDArray[np.float64]
_MESH, _WEIGHED = "_mesh", "_weighed"
THIN = 1e-6  # inertia given to a body without its own, over its mass times the square of its largest radius
ROUNDING = 1e-14  # inertia that is a rounding error of a sum over masses, in the same unit
RELEASES = {"none": 0, "start": 1, "end": 2, "both": 3}


class MassProperties(NamedTuple):
    """Mass (kg), centre of mass (m, body's frame) and inertia about it (kg m^2) of a body."""

    mass: float
    center: Point
    inertia: float


@dataclass(frozen=True, eq=False)
class Mesh:
    """An elastic body as particles and frame elements, in its own frame.

    Particles: ``position`` (n, 2) m, ``mass`` (n,) kg, ``inertia`` (n,) kg m^2, ``pins`` (index by name).
    Elements: ``nodes`` (k, 2), ``release`` flags, axial stiffness ``axial`` = E A (N) and bending stiffness
    ``bending`` = E I (N m^2), shape (k,). ``strain`` is the reference length of the stiffness.
    """

    position: Array
    mass: Array
    inertia: Array
    pins: dict[str, int]
    nodes: NDArray[np.intp]
    release: tuple[int, ...]
    axial: Array
    bending: Array
    strain: Strain

    @property
    def length(self) -> Array:
        """Lengths of the elements without forces (m), shape (k,)."""
        return np.asarray(
            _sizes(self.position[self.nodes[:, 1]] - self.position[self.nodes[:, 0]]), dtype=float
        )


def _sizes(sides: Array) -> Array:
    """Return the lengths of vectors (n, 2)."""
    return np.asarray(hypot(sides[:, 0], sides[:, 1]), dtype=float)


def is_elastic(body: Body) -> bool:
    """Return whether a body is made of particles and elements."""
    return isinstance(body, Frame) or (isinstance(body, Link) and body.element_count > 0)


def mesh(body: Body) -> Mesh:
    """Return the particles and elements of a link or frame, as arrays that are read-only.

    The mesh is computed once and stored with the body, because bodies are immutable; that of a frame is
    recomputed after its nodes or masses were changed in place. Raises TypeError for other bodies.
    """
    if not isinstance(body, Frame | Link):
        raise TypeError(f"{type(body).__name__} {body.name!r} has no elements")
    sources = (dict(body.nodes), dict(body.masses)) if isinstance(body, Frame) else ()
    cached = vars(body).get(_MESH)
    if cached is None or cached[0] != sources:
        parts = _frame(body) if isinstance(body, Frame) else _link(body)
        for values in (parts.position, parts.mass, parts.inertia, parts.nodes, parts.axial, parts.bending):
            values.setflags(write=False)
        cached = vars(body)[_MESH] = sources, parts  # past the frozen dataclass, whose equality ignores it
    result: Mesh = cached[1]
    return result


def _link(link: Link) -> Mesh:
    """Lump a link by Eq. 2: half of each element's mass at its two ends, I = sum of half masses times r^2.

    The paper prints I = sum 1/2 m_i r^2 with r "of the cross section at the node"; r is the radius of
    gyration of the section, r^2 = I_section/A. Attached masses are added at the ends.
    """
    section, position = section_of(link), _along(link)
    k = len(position) - 1
    nodes = np.column_stack([np.arange(k), np.arange(1, k + 1)])
    length = _sizes(np.diff(position, axis=0))
    mass = _halves(link.own_mass * (length / length.sum() if link.via else np.full(k, 1.0 / k)), nodes, k + 1)
    inertia = mass * (section.second_moment / section.area)
    mass[0] += link.start_mass
    mass[-1] += link.end_mass
    inertia[0] += link.start_inertia
    inertia[-1] += link.end_inertia
    release = [0] * k
    release[0] |= RELEASES[link.release] & 1
    release[-1] |= RELEASES[link.release] & 2
    modulus = link.material.youngs_modulus * link.stiffness_factor
    unit = np.ones(k)
    return Mesh(
        position, mass, inertia, {"start": 0, "end": k}, nodes, tuple(release),
        modulus * section.area * unit, modulus * section.second_moment * unit, link.strain,
    )  # fmt: skip


def _along(link: Link) -> Array:
    """Return the particles of a link, shape (k + 1, 2): equally spaced on a straight one, distributed over
    the pieces of a bent one by length.
    """
    k = link.element_count
    if not link.via:
        return np.column_stack([np.linspace(0.0, link.length, k + 1), np.zeros(k + 1)])
    corners = np.array(link.corners)
    length = _sizes(np.diff(corners, axis=0))
    if k < len(length):
        raise ValueError(
            f"link {link.name!r} has {len(length)} pieces and {k} elements: give it an element for each piece"
            " at least"
        )
    share = np.ones(len(length), dtype=int)
    while share.sum() < k:
        share[np.argmax(length / share)] += 1
    pieces = [
        a + np.outer(np.arange(1, n + 1) / n, b - a)
        for a, b, n in zip(corners, corners[1:], share, strict=False)
    ]
    return np.vstack([corners[:1], *pieces])


def _halves(mass: Array, nodes: NDArray[np.intp], count: int) -> Array:
    """Return half of each element's mass at its two particles, summed element by element, shape (count,)."""
    total = np.zeros(count)
    np.add.at(total, nodes[:, 0], 0.5 * mass)
    np.add.at(total, nodes[:, 1], 0.5 * mass)
    return total


def _frame(frame: Frame) -> Mesh:
    """Lump a frame. Particles are numbered in the order in which the members use them, so that neighbours are
    close in memory.
    """
    index: dict[str, int] = {}
    position: list[Point] = []
    nodes: list[tuple[int, int]] = []
    rows: list[tuple[float, float, float, float]] = []
    spans = np.array([frame.nodes[member.end] for member in frame.members]).reshape(-1, 2) - np.array(
        [frame.nodes[member.start] for member in frame.members]
    ).reshape(-1, 2)
    for member, size in zip(frame.members, _sizes(spans).tolist(), strict=True):
        section = member.section or frame.section
        if section is None:
            raise ValueError(
                f"frame {frame.name!r}: member {member.start}-{member.end} needs a section, or the frame one"
                " for all"
            )
        material = member.material or frame.material
        a, b = frame.nodes[member.start], frame.nodes[member.end]
        k = member.elements
        mass = material.density * section.area * size if member.mass is None else member.mass
        stiffness = material.youngs_modulus * section.area, material.youngs_modulus * section.second_moment
        row = (mass / k, section.second_moment / section.area, *stiffness)
        chain = []
        for j in range(k + 1):
            name = member.start if j == 0 else member.end if j == k else None
            if name is None or name not in index:
                position.append(
                    (a[0] + (b[0] - a[0]) * j / k, a[1] + (b[1] - a[1]) * j / k)
                    if 0 < j < k
                    else frame.nodes[str(name)]
                )
                if name is not None:
                    index[name] = len(position) - 1
            chain.append(len(position) - 1 if name is None else index[name])
        nodes += zip(chain, chain[1:], strict=False)
        rows += [row] * k
    loose = [name for name in frame.nodes if name not in index]
    if loose:
        raise ValueError(
            f"frame {frame.name!r}: no member holds node {', '.join(loose)}; join it to the others or"
            " remove it"
        )
    pairs, table = np.array(nodes, dtype=np.intp).reshape(-1, 2), np.array(rows).reshape(-1, 4)
    lumps = _halves(table[:, 0], pairs, len(position))
    inertia = _halves(table[:, 0] * table[:, 1], pairs, len(position))
    for name, extra in frame.masses.items():
        lumps[index[name]] += extra
    return Mesh(
        np.array(position),
        lumps,
        inertia,
        index,
        pairs,
        (0,) * len(pairs),
        table[:, 2],
        table[:, 3],
        frame.strain,
    )


def section_of(link: Link) -> Section:
    """Return the section of an elastic link. Raises ValueError if it has none."""
    if link.section is None:
        raise ValueError(
            f"link {link.name!r} is {link.model} and needs a section (area and second moment of area)"
        )
    return link.section


def rigid_properties(body: Body) -> MassProperties:
    """Return the mass properties of a body as if it were rigid.

    A single mass on a rigid arm has no inertia of its own; it is given ``THIN`` m r^2, r being the distance
    of the farthest point. Raises ValueError without mass, or with neither inertia nor arm. The result is
    stored with the body, because each of its pins asks for it, and is recomputed after pins or masses were
    changed in place.
    """
    cached, sources = vars(body).get(_WEIGHED), _sources_of(body)
    if cached is None or cached[0] != sources:
        cached = vars(body)[_WEIGHED] = tuple(map(dict, sources)), _weighed(body)
    result: MassProperties = cached[1]
    return result


def _sources_of(body: Body) -> tuple[Mapping[str, Any], ...]:
    """Return what may be changed in place and changes the mass properties."""
    if isinstance(body, Frame):
        return body.nodes, body.masses
    return (body.pins, body.masses) if isinstance(body, (RigidBody, Link)) else ()


def _weighed(body: Body) -> MassProperties:
    """Compute mass, centre and inertia with attached masses."""
    mass, center, inertia = _own_properties(body)
    attached = body.masses if isinstance(body, RigidBody | Link) and not is_elastic(body) else {}
    if attached:
        at = np.array([center, *(body.points[pin] for pin in attached)], dtype=float)
        mass, center, inertia = _sum_of_masses(
            at, np.array([mass, *attached.values()]), np.array([inertia, *(0.0 for _ in attached)])
        )
    if not mass > 0.0:
        raise ValueError(
            f"body {body.name!r} has no mass: give it a mass, or masses at its pins, or join the others by"
            " a distance"
        )
    if isinstance(body, PointMass) or is_elastic(body):
        return MassProperties(mass, center, inertia)
    reach = max(float(hypot(x - center[0], y - center[1])) for x, y in body.points.values())
    if inertia > ROUNDING * mass * (reach * reach):
        return MassProperties(mass, center, inertia)
    if not reach > 0.0:
        raise ValueError(
            f"body {body.name!r} has neither inertia nor a pin away from its mass: give it an inertia, or"
            " make it a particle"
        )
    return MassProperties(mass, center, THIN * mass * (reach * reach))


def _own_properties(body: Body) -> MassProperties:
    """Compute the mass properties without attached point masses."""
    if isinstance(body, PointMass):
        return MassProperties(body.mass, (0.0, 0.0), body.inertia)
    if isinstance(body, RigidBody):
        return MassProperties(body.mass, body.center, body.inertia)
    if is_elastic(body):
        parts = mesh(body)
        turning = (
            parts.inertia if not (isinstance(body, Link) and body.release == "both") else 0.0 * parts.inertia
        )
        return _sum_of_masses(parts.position, parts.mass, turning)
    if not isinstance(body, Link):
        raise TypeError(f"{type(body).__name__} is no body")
    if body.via and (body.inertia is None or body.center_at is None):
        return _rigid_polyline(body)
    center = 0.5 * body.length if body.center_at is None else body.center_at
    inertia = body.own_mass * (body.length * body.length) / 12.0 if body.inertia is None else body.inertia
    mass, start, end, length = body.own_mass, body.start_mass, body.end_mass, body.length
    total = float(mass + start + end)
    x = (mass * center + end * length) / total if total > 0.0 else center
    rise = mass * ((center - x) * (center - x)) + start * (x * x) + end * ((length - x) * (length - x))
    return MassProperties(total, (x, 0.0), inertia + body.start_inertia + body.end_inertia + rise)


def _rigid_polyline(link: Link) -> MassProperties:
    """Compute the mass properties of a bent rigid link, each piece a uniform rod with its share of
    the mass.
    """
    corners = np.array(link.corners)
    length = _sizes(np.diff(corners, axis=0))
    mass = link.own_mass * length / length.sum()
    at = np.vstack([0.5 * (corners[1:] + corners[:-1]), corners[[0, -1]]])
    return _sum_of_masses(
        at,
        np.array([*mass, link.start_mass, link.end_mass]),
        np.array([*mass * (length * length) / 12.0, link.start_inertia, link.end_inertia]),
    )


def _sum_of_masses(at: Array, mass: Array, inertia: Array) -> MassProperties:
    """Return mass, centre and inertia of masses at places ``at``, shape (n, 2)."""
    total = float(mass.sum())
    if not total > 0.0:
        return MassProperties(0.0, (float(at[0, 0]), float(at[0, 1])), float(inertia.sum()))
    center = (mass[:, None] * at).sum(axis=0) / total
    away = at - center
    distances_squared = (away * away).sum(axis=1)
    return MassProperties(
        total, (float(center[0]), float(center[1])), float(inertia.sum() + (mass * distances_squared).sum())
    )


def rigidified(body: Body) -> Body:
    """Return a rigid body with the same (lumped) mass, centre and inertia."""
    if not is_elastic(body):
        return body
    mass, center, inertia = rigid_properties(body)
    if isinstance(body, Link) and not body.via:
        return dataclasses.replace(
            body, model="rigid", mass=mass, inertia=inertia, center_at=center[0], start_mass=0.0,
            end_mass=0.0, start_inertia=0.0, end_inertia=0.0, release="none",
        )  # fmt: skip
    return RigidBody(
        name=body.name, angle=body.angle, position=body.position, velocity=body.velocity,
        material=body.material, mass=mass, inertia=inertia, center=center, pins=dict(body.points),
    )  # fmt: skip
