"""Pattern search: the least of a function from its values alone, where it has no derivatives that can be
trusted.

All points at one distance along each axis are evaluated, both ways; the best of them is the next centre, and
where none is better the distance is halved (compass search: Kolda, Lewis and Torczon, SIAM Review 45, 2003,
pp. 385-482).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rank: TypeAlias = tuple[float, float]  # by how much limits are exceeded, and the value: less is better, limits first

FIRST_DISTANCE = 0.05  # of the way between the bounds of an axis
LAST_DISTANCE = 1e-3  # noise of a measure with contact hides less than this


def pattern_search(start: Array, rank: Callable[[Sequence[Array]], Sequence[Rank]]) -> Array:
    """Return the best point that was found, from ``start`` on, in the unit cube.

    ``rank`` evaluates points side by side; what it raises ends the search.
    """
    centre = np.clip(start, 0.0, 1.0)
    (best,) = rank([centre])
    distance = FIRST_DISTANCE
    while distance >= LAST_DISTANCE:
        points = _around(centre, distance)
        ranks = rank(points)
        least = min(range(len(points)), key=lambda k: ranks[k], default=None)
        if least is not None and ranks[least] < best:
            centre, best = points[least], ranks[least]
        else:
            distance *= 0.5
    return centre


def _around(centre: Array, distance: float) -> list[Array]:
    """Points at a distance along each axis, both ways, that lie within the bounds and are not the centre."""
    found = []
    for axis in range(len(centre)):
        for sign in (1.0, -1.0):
            point = centre.copy()
            point[axis] = min(max(point[axis] + sign * distance, 0.0), 1.0)
            if point[axis] != centre[axis]:
                found.append(point)
    return found
