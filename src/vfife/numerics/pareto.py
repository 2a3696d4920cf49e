"""Pareto front of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def front(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the Pareto front of points, shape (points, measures): those that no other point equals or beats
    in all measures and beats in one.
    """
    # In lexicographic order a point can only be dominated by an earlier one, so each is compared with the
    # front found so far.
    order = np.lexsort(values.T[::-1])
    best = np.zeros(len(values), dtype=bool)
    beaten_by = np.empty((0, values.shape[1]))
    for k in order:
        if not ((beaten_by <= values[k]).all(axis=1) & (beaten_by < values[k]).any(axis=1)).any():
            best[k] = True
            beaten_by = np.vstack([beaten_by, values[k]])
    return best
