"""Whether a descent has come to where a mechanism stays open: the bottom of |phi|^2, found by Newton's method with all second derivatives.

Damped Newton steps on phi know slopes alone. Where a mechanism cannot close, its links are in line at the bottom, so slopes vanish there and steps
go to and fro across it: hundreds until they are round-off. A bottom is known by its second derivatives, which are differences of slopes here.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..numerics import dense
from ..numerics.products import times

Array = NDArray[np.float64]
Slopes = Callable[[Array], tuple[float, Array]]  # a place -> what is to be least, and its derivatives

NEWTON = 12
APART = 1e-6  # of the extent, of places whose slopes make a second derivative
THERE = 1e-9  # of the extent: a step that is none
ROUND = 1e-8  # of the largest curvature: less is rounding, or a free motion
LEVEL = 1e-6  # of the root of what is left: a slope that is none
FAR = 0.2  # of the extent: further away it is another bottom
MOST = 0.5  # of what is there now is left at the bottom, or more: else the way down has not come to an end


def bottom(slopes: Slopes, extent: float, count: int) -> Array | None:
    """How far the bottom lies from here, [count], where it is one: curved upwards, near, and no more than half as deep again; None where not."""
    here, (now, slope) = np.zeros(count), slopes(np.zeros(count))
    left = now
    for _ in range(NEWTON):
        curvature = np.column_stack([slopes(here + change)[1] - slope for change in APART * extent * np.eye(count)]) / (APART * extent)
        size, along = dense.eigh(0.5 * (curvature + curvature.T))
        if size[0] < -ROUND * size[-1]:
            return None
        curved = size > ROUND * size[-1]
        step = -times(along[:, curved] / size[curved], times(along[:, curved].T, slope))
        here = here + step
        left, slope = slopes(here)
        if left < MOST * now or np.abs(here).max() > FAR * extent:
            return None
        if np.abs(step).max() <= THERE * extent:
            return here if left <= now and np.abs(slope).max() <= LEVEL * math.sqrt(left) else None
    return None
