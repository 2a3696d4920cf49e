"""Tangent stiffness and stored energy of a contact law, from its elastic force."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import interpolate
from .law import ContactLaw

Array = NDArray[np.float64]

BISECTIONS = 60  # of an interval of depths with a ratio of two: to the last bit


def tangent(law: ContactLaw, slots: tuple[float, ...], force: float) -> tuple[float, float]:
    """Return the penetration (m) at which a contact law carries ``force`` (N) at rest, and its tangent
    stiffness (N/m) there.
    """
    kind: Any = type(law)
    return _tangent(kind, tuple(slots), force)  # a class has a hash, whatever its instances have


@lru_cache(maxsize=4096)
def _tangent(law: type[ContactLaw], slots: tuple[float, ...], load: float) -> tuple[float, float]:
    """Return the same from the law's class and its parameters, which decide it.

    The depth is searched by doubling, then by bisection on a logarithmic scale, because laws cover many
    orders of magnitude. A static analysis calls this thousands of times, so it uses plain numbers.
    """
    force = law.force
    low, high = 1e-15, 1e-9
    while force(high, 0.0, slots)[0] < load and high < 1.0:
        low, high = high, 2.0 * high
    for _ in range(BISECTIONS):
        middle = math.sqrt(low * high)
        if force(middle, 0.0, slots)[0] < load:
            low = middle
        else:
            high = middle
    return high, (float(force(1.001 * high, 0.0, slots)[0]) - float(force(0.999 * high, 0.0, slots)[0])) / (
        0.002 * high
    )


def elastic_energy(law: ContactLaw, depth: Array, slots: tuple[float, ...]) -> Array:
    """Return the elastic energy (J) at penetrations (m): the law's own formula, or the integral of its
    elastic force by the trapezoidal rule.
    """
    try:
        return np.asarray(law.elastic_energy(depth, slots), dtype=float)
    except NotImplementedError:
        grid = np.linspace(0.0, max(float(depth.max()), 1e-12), 2001)
        force = np.array([law.force(float(d), 0.0, slots)[0] for d in grid])
        steps = 0.5 * (force[1:] + force[:-1]) * np.diff(grid)
        return np.asarray(interpolate(depth, grid, np.concatenate([[0.0], np.cumsum(steps)])), dtype=float)
