"""Natural frequencies and shapes of a mechanism about its start, and of its elastic links by themselves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly.linearised import Linearised, elements_of, linearised
from ..errors import AssemblyError
from ..model.bodies import Link
from ..model.lumping import is_elastic, mesh
from ..model.mechanism import Mechanism

Array = NDArray[np.float64]
MOST_COORDINATES = 6000  # coordinates: beyond, matrices that are not sparse take minutes and gigabytes
# A w^2 of zero as it is computed, over the largest one: rounding, and with springs the error of differences.
ZERO_SQUARE = 1e-13, 1e-11


@dataclass(frozen=True)
class Mode:
    """A natural vibration: ``frequency`` (Hz), 0 of a motion that nothing holds, and w^2 (1/s^2), below 0
    where the start is unstable.

    ``shape`` (particles, 3) is the displacement (m, m, rad) of each particle, the ground first, its largest
    way being 1 m (or turn 1 rad where nothing else moves). ``energy`` (1) is the share of each body in the
    kinetic energy, by name.
    """

    frequency: float
    square: float
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
    (particles, 3) is where the particles are.
    """

    modes: tuple[Mode, ...]
    count: int
    unbalanced: float
    links: dict[str, tuple[float, ...]]
    position: Array

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Natural frequencies (Hz)."""
        return tuple(mode.frequency for mode in self.modes)


def modes(mechanism: Mechanism, count: int = 10, *, released: bool = False) -> Modes:
    """Return the ``count`` lowest natural vibrations of a mechanism about its start, at rest, without
    damping.

    Joints with clearance count as ideal and external contacts as open, loads are left out; drivers hold what
    they drive, or are ``released``. Under weight and springs, what bends has bent. Eigenvalues of M q'' + K q
    = 0 in the motions that leave joints closed: see :mod:`vfife.assembly.linearised`. Raises AssemblyError
    where the mechanism cannot be closed or is too large.
    """
    from scipy.linalg import eigh

    particles = 3 * sum(len(mesh(body).mass) if is_elastic(body) else 1 for body in mechanism.bodies.values())
    if particles > MOST_COORDINATES:
        raise AssemblyError(
            f"{particles} coordinates are too many for natural frequencies, of which"
            f" {MOST_COORDINATES} are taken; take fewer elements"
        )
    linear = linearised(mechanism, released)
    reduced_stiffness = linear.motions.T @ linear.stiffness @ linear.motions
    size, number = len(reduced_stiffness), min(count, len(reduced_stiffness))
    lowest: list[Mode] = []
    if number:
        largest = float(eigh(reduced_stiffness, eigvals_only=True, subset_by_index=[size - 1, size - 1])[0])
        squares, vectors = eigh(reduced_stiffness, subset_by_index=[0, number - 1])
        smallest = ZERO_SQUARE[bool(mechanism.springs)] * abs(largest)
        lowest = [
            _mode(linear, 0.0 if abs(square) < smallest else float(square), linear.motions @ vectors[:, k])
            for k, square in enumerate(squares)
        ]
    alone = {
        name: link_frequencies(body)
        for name, body in mechanism.bodies.items()
        if isinstance(body, Link) and body.element_count
    }
    return Modes(tuple(lowest), size, linear.unbalanced, alone, linear.position)


def _mode(linear: Linearised, square: float, weighted: Array) -> Mode:
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
    return Mode(math.sqrt(max(square, 0.0)) / (2.0 * math.pi), square, ways, shares)


def link_frequencies(link: Link, count: int = 3) -> tuple[float, ...]:
    """Return the lowest natural frequencies (Hz) of an elastic link by itself, straight or bent, pinned at
    its start, and at its end free along its chord.

    That of a slender straight one tends to (k pi)^2/(2 pi) sqrt(E I/(mu l^4)) with its elements, mu being
    mass over length.
    """
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
    squares = eigh(stiffness[np.ix_(moving, moving)], np.diag(mass[moving]), eigvals_only=True)
    return tuple(math.sqrt(max(float(square), 0.0)) / (2.0 * math.pi) for square in squares[:count])


__all__ = ["Mode", "Modes", "link_frequencies", "modes"]
