"""Natural frequencies and shapes of a mechanism about its start, and of its elastic links by themselves, with
their errors by the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..assembly.linearised import Linearised, elements_of, linearised
from ..errors import AssemblyError, VfifeError
from ..model.bodies import Link
from ..model.lumping import is_elastic, mesh
from ..model.mechanism import Mechanism
from ..options import with_faults
from ..solvers.refinement import DOUBLE, FOURFOLD, HALF, meshed, refinable
from .mode_errors import ModeShapes, frequency_of, measured_squares, missing
from .values import Measured

Array = NDArray[np.float64]
MOST_COORDINATES = 6000  # coordinates: beyond, matrices that are not sparse take minutes and gigabytes
# Coordinates of a mesh with more elements, which is solved for the error: a second of computing.
MOST_REPEATED = 600
# Vibrations of other meshes among which those of the same shape are looked for.
SPARE_FACTOR, SPARE = 2, 10
# A w^2 of zero as it is computed, over the largest one: rounding, and with springs the error of differences.
ZERO_SQUARE = 1e-13, 1e-11


@dataclass(frozen=True)
class Mode:
    """A natural vibration: ``frequency`` (Hz), 0 of a motion that nothing holds, and w^2 (1/s^2), below 0
    where the start is unstable. Both have the range of their error by the mesh, ``low`` to ``high``, unless
    ``estimated`` is False (:class:`~vfife.measures.values.Measured`).

    ``shape`` (particles, 3) is the displacement (m, m, rad) of each particle, the ground first, its largest
    way being 1 m (or turn 1 rad where nothing else moves). ``energy`` (1) is the share of each body in the
    kinetic energy, by name.
    """

    frequency: Measured
    square: Measured
    shape: Array
    energy: dict[str, float]

    @property
    def leading(self) -> tuple[str, float]:
        """The body that moves most, and its share of the kinetic energy."""
        return max(self.energy.items(), key=lambda item: item[1])


@dataclass(frozen=True)
class Modes:
    """The lowest of a mechanism in the order of w^2, out of ``count`` that it has.

    ``unbalanced`` is the share of weight and springs that nothing carries at the start: 0 in equilibrium.
    ``links`` are the frequencies (Hz) of each elastic link alone, pinned at both ends; ``position``
    (particles, 3) is where the particles are. ``missing`` is the number of vibrations that appear below the
    last one with twice the elements, and that these elements cannot show; None where that is unknown.
    """

    modes: tuple[Mode, ...]
    count: int
    unbalanced: float
    links: dict[str, tuple[Measured, ...]]
    position: Array
    missing: int | None = None

    @property
    def frequencies(self) -> tuple[Measured, ...]:
        """Natural frequencies (Hz), each with its range."""
        return tuple(mode.frequency for mode in self.modes)


@with_faults()
def modes(mechanism: Mechanism, count: int = 10, *, released: bool = False) -> Modes:
    """Return the ``count`` lowest natural vibrations of a mechanism about its start, at rest, without
    damping, with their errors by the mesh.

    Joints with clearance count as ideal and external contacts as open, loads are left out; drivers hold what
    they drive, or are ``released``. Under weight and springs, what bends has bent. Eigenvalues of M q'' + K q
    = 0 in the motions that leave joints closed: see :mod:`vfife.assembly.linearised`. The same with twice and
    four times the elements gives the ranges; where that takes too long, or a link is one element by
    definition, they are not estimated. Raises AssemblyError
    where the mechanism cannot be closed or is too large.
    """
    if coordinates(mechanism) > MOST_COORDINATES:
        raise AssemblyError(
            f"{coordinates(mechanism)} coordinates are too many for natural frequencies, of which"
            f" {MOST_COORDINATES} are taken; take fewer elements"
        )
    linear = linearised(mechanism, released)
    squares, vectors, rounding = _lowest(mechanism, linear, count)
    base = _shapes(linear, squares, vectors)
    meshes = _on_other_meshes(mechanism, released, SPARE_FACTOR * len(squares) + SPARE)
    exact = not any(is_elastic(body) for body in mechanism.bodies.values())
    measured = measured_squares(base, meshes, exact, rounding)
    result = [_mode(linear, square, vectors[:, k]) for k, square in enumerate(measured)]
    alone = {
        name: link_frequencies(body)
        for name, body in mechanism.bodies.items()
        if isinstance(body, Link) and body.element_count
    }
    unseen = missing(base, meshes[DOUBLE]) if DOUBLE in meshes else 0 if exact else None
    size = linear.motions.shape[1]
    return Modes(tuple(result), size, linear.unbalanced, alone, linear.position, unseen)


def coordinates(mechanism: Mechanism) -> int:
    """Return the number of coordinates (x, y, theta) of all particles."""
    return 3 * sum(len(mesh(body).mass) if is_elastic(body) else 1 for body in mechanism.bodies.values())


def _lowest(mechanism: Mechanism, linear: Linearised, count: int) -> tuple[Array, Array, float]:
    """Return the lowest w^2 (1/s^2) [k], zero where it is rounding; the vectors of mass-weighted coordinates
    [moving, k]; and the size of rounding.
    """
    from scipy.linalg import eigh

    stiffness = linear.motions.T @ linear.stiffness @ linear.motions
    size, number = len(stiffness), min(count, len(stiffness))
    if not number:
        return np.zeros(0), np.zeros((len(linear.moving), 0)), 0.0
    largest = float(eigh(stiffness, eigvals_only=True, subset_by_index=[size - 1, size - 1])[0])
    squares, vectors = eigh(stiffness, subset_by_index=[0, number - 1])
    smallest = ZERO_SQUARE[bool(mechanism.springs)] * abs(largest)
    return np.where(np.abs(squares) < smallest, 0.0, squares), linear.motions @ vectors, smallest


def _shapes(linear: Linearised, squares: Array, vectors: Array) -> ModeShapes:
    """Return the vibrations of a mechanism for comparison with those on another mesh."""
    shapes = np.zeros((linear.mass.size, len(squares)))
    shapes[linear.moving] = vectors / np.sqrt(linear.mass.reshape(-1)[linear.moving])[:, None]
    mass, count = linear.mass.reshape(-1, 3), linear.mass.size // 3
    place, body = np.zeros((count, 2)), np.zeros(count, dtype=np.intp)
    for number, (name, entry) in enumerate(linear.numbering.bodies.items(), start=1):
        particles = list(entry.particles)
        body[particles] = number
        if name in linear.numbering.meshes:
            place[particles] = linear.numbering.meshes[name].position
    return ModeShapes(squares, shapes.reshape(count, 3, -1), mass, place, body)


def _on_other_meshes(mechanism: Mechanism, released: bool, count: int) -> dict[float, ModeShapes]:
    """Return the ``count`` lowest vibrations with twice and four times the elements, by share of the
    elements; with half of them if four times are many. Meshes that cannot be assembled are left out.
    """
    result: dict[float, ModeShapes] = {}
    if not refinable(mechanism):
        return result
    size = coordinates(mechanism)
    second = FOURFOLD if FOURFOLD * size <= MOST_REPEATED else HALF
    for share in (DOUBLE, second) if DOUBLE * size <= MOST_REPEATED else ():
        changed = meshed(mechanism, share)
        if changed is None:
            continue
        try:
            linear = linearised(changed, released)
        except (VfifeError, ValueError):
            continue
        result[share] = _shapes(linear, *_lowest(changed, linear, count)[:2])
    return result


def _mode(linear: Linearised, square: Measured, weighted: Array) -> Mode:
    """Return a mode from its vector in mass-weighted coordinates."""
    shape = np.zeros(linear.mass.shape)
    shape[linear.moving] = weighted / np.sqrt(linear.mass[linear.moving])
    energy = np.zeros(linear.mass.shape)
    energy[linear.moving] = weighted**2
    ways = shape.reshape(-1, 3)
    way = float(np.hypot(ways[:, 0], ways[:, 1]).max())
    ways = ways / (way if way > 1e-12 * np.abs(ways).max() else np.abs(ways[:, 2]).max())
    shares = {
        name: float(energy.reshape(-1, 3)[list(body.particles)].sum())
        for name, body in linear.numbering.bodies.items()
    }
    return Mode(frequency_of(square), square, ways, shares)


def link_frequencies(link: Link, count: int = 3) -> tuple[Measured, ...]:
    """Return the lowest natural frequencies (Hz) of an elastic link by itself, straight or bent, pinned at
    its start, and at its end free along its chord, each with its range by the mesh.

    That of a slender straight one tends to (k pi)^2/(2 pi) sqrt(E I/(mu l^4)) with its elements, mu being
    mass over length. That of a link of two particles, which is one element by definition, is not estimated.
    """
    base, largest = _link_shapes(link, count)
    meshes = {
        share: _link_shapes(replace(link, elements=int(share * link.elements)), SPARE_FACTOR * count + SPARE)[
            0
        ]
        for share in (DOUBLE, FOURFOLD)
        if link.model != "two-particle" and 3.0 * share * link.elements <= MOST_REPEATED
    }
    squares = measured_squares(base, meshes, False, ZERO_SQUARE[0] * largest)
    return tuple(frequency_of(square) for square in squares)


def _link_shapes(link: Link, count: int) -> tuple[ModeShapes, float]:
    """Return the lowest vibrations of a link by itself, pinned, and its largest w^2 (1/s^2)."""
    from scipy.linalg import eigh

    part = mesh(link)
    nodes = len(part.mass)
    position = np.column_stack([part.position, np.zeros(nodes)])
    force, stiffness = np.zeros(3 * nodes), np.zeros((3 * nodes, 3 * nodes))
    for element in elements_of(part, 0):
        element.put(position, force, stiffness)
    mass = np.column_stack([part.mass, part.mass, part.inertia]).reshape(-1)
    mass[[0, 1, 3 * nodes - 2]] = 0.0
    idle = [3 * p + 2 for p in range(nodes) if not stiffness[3 * p + 2].any()]
    moving = np.setdiff1d(np.flatnonzero(mass > 0.0), idle)
    squares, vectors = eigh(stiffness[np.ix_(moving, moving)], np.diag(mass[moving]))
    shapes = np.zeros((3 * nodes, len(squares[:count])))
    shapes[moving] = vectors[:, :count]
    body = np.zeros(nodes, dtype=np.intp)
    result = ModeShapes(
        squares[:count], shapes.reshape(nodes, 3, -1), mass.reshape(-1, 3), part.position, body
    )
    return result, float(squares[-1])


__all__ = ["Mode", "Modes", "link_frequencies", "modes"]
