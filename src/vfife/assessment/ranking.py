"""Partial rank correlation of a measure with each of several numbers, from cases that vary all of them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.dense import dot, least_squares, times

Array = NDArray[np.float64]
NORMAL_95 = 1.959963984540054  # of a normal distribution 95 % lie within so many standard deviations
RANK_VARIANCE = 1.06  # variance of Fisher's z of a rank correlation over that of a linear one (Fieller, 1957)
LARGEST = 1.0 - 1e-12  # correlation, of which Fisher's z is finite
LEAST_CASES = 20  # beyond the number of columns


class Rank(NamedTuple):
    """Partial rank correlation, -1 to 1, with the limits of its 95 % confidence interval."""

    value: float
    low: float
    high: float

    @property
    def visible(self) -> bool:
        """Whether the interval excludes zero."""
        return self.low > 0.0 or self.high < 0.0


def partial_ranks(points: Array, values: Array) -> list[Rank | None]:
    """Return the partial rank correlation of ``values``, shape (cases,), with each column of ``points``,
    shape (cases, columns): the correlation of ranks from which the linear effect of all other columns is
    removed.

    Cases with values that are not finite are left out. The interval is Fisher's, with the variance of rank
    correlations. None for a column that does not vary, and for too few cases.
    """
    finite = np.isfinite(values)
    rows, ranks_of_values = points[finite], ranks(values[finite])
    count, columns = rows.shape
    if count < LEAST_CASES + columns or np.ptp(ranks_of_values) == 0.0:
        return [None] * columns
    ranked = np.stack([ranks(column) for column in rows.T], axis=1)
    width = NORMAL_95 * math.sqrt(RANK_VARIANCE / (count - 3 - (columns - 1)))
    result: list[Rank | None] = []
    for k in range(columns):
        remaining = np.column_stack([np.ones(count), np.delete(ranked, k, axis=1)])
        left, right = (
            side - times(remaining, least_squares(remaining, side))
            for side in (ranked[:, k], ranks_of_values)
        )
        squares = dot(left, left)
        scale = math.sqrt(squares * dot(right, right))
        if squares < 1e-9 * count**3 or scale == 0.0:
            result.append(None)
            continue
        value = max(-LARGEST, min(LARGEST, dot(left, right) / scale))
        z = math.atanh(value)
        result.append(Rank(value, math.tanh(z - width), math.tanh(z + width)))
    return result


def ranks(values: Array) -> Array:
    """Return the ranks of values from 0, equal values with their mean rank."""
    _, places, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    return (last - 0.5 * (counts + 1))[places.reshape(-1)]
