"""Products of dense matrices and vectors over leading dimensions; sums run in the order of their terms."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .library import call

Array = NDArray[np.float64]
# Entries of a matrix up to which NumPy's running sum along rows is quicker than a call of compiled code; the
# order of the sum is the same.
SMALL = 1500


def flat(values: Any) -> Array:
    """Numbers one after the other in memory, without a copy where they lie so."""
    return np.ascontiguousarray(values, dtype=np.float64).reshape(-1)


def stacked(values: Array, lead: tuple[int, ...], own: int) -> Array:
    """Matrices or vectors, whose last ``own`` dimensions are theirs, one behind the other: one, or one for
    each of the leading dimensions.
    """
    deep = values.ndim > own
    if deep and values.shape[:-own] != lead:
        values = np.broadcast_to(values, (*lead, *values.shape[-own:]))
    return np.ascontiguousarray(values).reshape(math.prod(lead) if deep else 1, *values.shape[-own:])


def product(first: Any, second: Any) -> Any:
    """Matrix times matrix, (..., r, k) and (..., k, c); leading dimensions are broadcast."""
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if a.shape[-1] != b.shape[-2]:
        raise ValueError(f"matrices of shapes {a.shape} and {b.shape} have no product")
    lead = a.shape[:-2] if a.shape[:-2] == b.shape[:-2] else np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    result = np.empty((math.prod(lead), a.shape[-2], b.shape[-1]))
    call("multiply", stacked(a, lead, 2), stacked(b, lead, 2), result)
    return result.reshape(*lead, *result.shape[1:])


def times(matrix: Any, vector: Any) -> Any:
    """Matrix times vector, (..., r, c) and (..., c); leading dimensions are broadcast."""
    a, x = np.asarray(matrix, dtype=np.float64), np.asarray(vector, dtype=np.float64)
    if x.shape[-1] != a.shape[-1]:
        raise ValueError(f"a matrix of shape {a.shape} and a vector of shape {x.shape} have no product")
    if a.size <= SMALL:
        return _sums(a * x[..., None, :])
    lead = a.shape[:-2] if a.shape[:-2] == x.shape[:-1] else np.broadcast_shapes(a.shape[:-2], x.shape[:-1])
    result = np.empty((math.prod(lead), a.shape[-2]))
    call("multiply_vectors", stacked(a, lead, 2), stacked(x, lead, 1), result)
    return result.reshape(*lead, a.shape[-2])


def _sums(terms: Array) -> Array:
    """Sums along the last axis, each in the order of its terms, of which np.sum makes no promise."""
    return np.cumsum(terms, axis=-1)[..., -1] + 0.0 if terms.shape[-1] else np.zeros(terms.shape[:-1])


def dot(first: Any, second: Any) -> Any:
    """Sum of products along the last axis, (..., n) each; a number of two vectors."""
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if a.shape[-1] != b.shape[-1]:
        raise ValueError(f"vectors of shapes {a.shape} and {b.shape} have no product")
    result = _sums(a * b)
    return result if result.ndim else float(result)


def norm(vector: Any, axis: int | None = None) -> Any:
    """Length of a vector, or along an axis; of all entries of an array where no axis is named.

    Squares must not overflow.
    """
    if axis is None:
        own = flat(vector)
        return math.sqrt(dot(own, own))
    own = np.moveaxis(np.asanyarray(vector), axis, -1)
    result = np.sqrt(dot(own, own))
    return result if np.ndim(result) else float(result)
