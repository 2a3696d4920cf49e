"""What follows from a contact law's elastic force: tangent stiffness and stored energy."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..fields.members import Alone, Differing, anyone, both, each_of, members, number, of_members, select, several, sqrt
from ..numerics.elementwise import interpolate
from .law import ContactLaw

Array = NDArray[np.float64]

BISECTIONS = 60  # of depths that differ by a factor of two


def tangent(law: ContactLaw, slots: tuple[Any, ...], force: Any) -> tuple[Any, Any]:
    """Penetration (m) at which a contact law carries ``force`` (N) at rest, and its tangent stiffness (N/m) there."""
    kind: Any = type(law)  # a class has a hash, whatever its instances have
    if not several(*slots, force):
        return _tangent(kind, tuple(slots), force)
    try:
        with np.errstate(all="ignore"):
            found: tuple[Any, Any] = _bisected(of_members(kind.force), tuple(slots), force)
            return found
    except (Alone, Differing):  # a law that chooses its way by the depth
        pairs = each_of(lambda *one: _tangent(kind, tuple(one[:-1]), one[-1]), *slots, force)
        return members([one[0] for one in pairs]), members([one[1] for one in pairs])


@lru_cache(maxsize=4096)
def _tangent(law: type[ContactLaw], slots: tuple[float, ...], load: float) -> tuple[float, float]:
    """The same, of what decides it: the law's static function and its parameters. A static analysis asks for thousands, so numbers are plain."""
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
    return high, (float(force(1.001 * high, 0.0, slots)[0]) - float(force(0.999 * high, 0.0, slots)[0])) / (0.002 * high)


def _bisected(force: Callable[..., Any], slots: tuple[Any, ...], load: Any) -> tuple[Any, Any]:
    """The same of members, to the bit."""

    def elastic(depth: Any) -> Any:
        return number(force(depth, 0.0, slots)[0])

    low: Any = 1e-15
    high: Any = 1e-9
    while anyone(more := both(elastic(high) < load, high < 1.0)):
        low, high = select(more, high, low), select(more, 2.0 * high, high)
    for _ in range(BISECTIONS):
        middle = sqrt(low * high)
        less = elastic(middle) < load
        low, high = select(less, middle, low), select(less, high, middle)
    return high, (elastic(1.001 * high) - elastic(0.999 * high)) / (0.002 * high)


def elastic_energy(law: ContactLaw, depth: Array, slots: tuple[float, ...]) -> Array:
    """Elastic energy (J) at penetrations (m): the law's own, or its elastic force summed up where it has none."""
    try:
        return np.asarray(law.elastic_energy(depth, slots), dtype=float)
    except NotImplementedError:
        grid = np.linspace(0.0, max(float(depth.max()), 1e-12), 2001)
        force = np.array([law.force(float(d), 0.0, slots)[0] for d in grid])
        steps = 0.5 * (force[1:] + force[:-1]) * np.diff(grid)
        return np.asarray(interpolate(depth, grid, np.concatenate([[0.0], np.cumsum(steps)])), dtype=float)
