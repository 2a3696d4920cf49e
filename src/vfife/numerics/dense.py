"""Linear algebra of small dense matrices (..., rows, columns), with the same bits on every machine and in
every batch.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .routine import call

Array = NDArray[np.float64]
# Entries of a matrix up to which NumPy's running sum along rows is quicker than a call of compiled code; the
# order of the sum is the same.
SMALL = 1500


def flat(values: Any) -> Array:
    """Numbers one after the other in memory, without a copy where they lie so."""
    return np.ascontiguousarray(values, dtype=np.float64).reshape(-1)


def stacked(values: Array, lead: tuple[int, ...], dimensions: int) -> Array:
    """Return matrices (``dimensions`` 2) or vectors (1) one behind the other: a single one, or one for each
    place of the leading dimensions ``lead``.
    """
    deep = values.ndim > dimensions
    if deep and values.shape[:-dimensions] != lead:
        values = np.broadcast_to(values, (*lead, *values.shape[-dimensions:]))
    return np.ascontiguousarray(values).reshape(math.prod(lead) if deep else 1, *values.shape[-dimensions:])


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
    """Sum along the last axis in the order of the terms; np.sum guarantees no order."""
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
        entries = flat(vector)
        return math.sqrt(dot(entries, entries))
    vectors = np.moveaxis(np.asanyarray(vector), axis, -1)
    result = np.sqrt(dot(vectors, vectors))
    return result if np.ndim(result) else float(result)


EPS = 2.0**-52


class Stack(NamedTuple):
    """Matrices (count, rows, columns), one behind the other, and the leading dimensions that they had."""

    matrices: Array
    lead: tuple[int, ...]

    def shaped(self, *results: Array) -> tuple[Any, ...]:
        """Results (count, ...), one for each matrix, with the leading dimensions; LinAlgError where one is
        not a number.
        """
        if any(np.isnan(result).any() for result in results):
            raise np.linalg.LinAlgError("a matrix has entries that are not finite")
        return tuple(result.reshape(*self.lead, *result.shape[1:]) for result in results)


def _stack(matrix: Any, square: bool = False) -> Stack:
    """Copy matrices, so that a routine may change them. Raises LinAlgError for non-square ones if
    ``square``.
    """
    copied = np.array(matrix, dtype=np.float64, order="C")
    rows, columns = copied.shape[-2:]
    if square and rows != columns:
        raise np.linalg.LinAlgError(
            f"a square matrix is needed, not one of {rows} rows and {columns} columns"
        )
    return Stack(copied.reshape(math.prod(copied.shape[:-2]), rows, columns), copied.shape[:-2])


def solve(matrix: Any, right: Any) -> Any:
    """Return x of A x = b by elimination with partial pivoting, for b (..., n) or (..., n, columns).

    A right side with one dimension less than the matrix is a vector. Raise LinAlgError where a column has no
    pivot.
    """
    matrices, lead = _stack(matrix, square=True)
    b = np.asarray(right, dtype=np.float64)
    vector = b.ndim == len(lead) + 1
    b = b[..., None] if vector else b
    x, signs = np.array(np.broadcast_to(b, (*lead, *b.shape[-2:])), order="C"), np.empty(len(matrices))
    call("eliminate", matrices, x.reshape(len(matrices), *x.shape[-2:]), signs)
    if not (signs != 0.0).all():
        raise np.linalg.LinAlgError("Singular matrix")
    return x[..., 0] if vector else x


class Solved(NamedTuple):
    """x of A x = b, and the determinants of A; where one is 0, x is not solved."""

    x: Array
    determinant: Array


def solve_with_determinant(matrix: Array, right: Array) -> Solved:
    """x (..., n, columns) of A x = b by elimination with partial pivoting, and the determinant of each A."""
    matrices, lead = _stack(matrix, square=True)
    x, signs = np.array(right, dtype=np.float64, order="C"), np.empty(len(matrices))
    call("eliminate", matrices, x.reshape(len(matrices), *x.shape[-2:]), signs)
    diagonal = np.diagonal(matrices, axis1=-2, axis2=-1)
    return Solved(x, (signs * np.abs(np.multiply.reduce(diagonal, axis=-1))).reshape(lead))


def determinant_sign(matrix: Any) -> Any:
    """Sign of the determinant of each matrix: -1, 0 or 1."""
    matrices, lead = _stack(matrix, square=True)
    signs = np.empty(len(matrices))
    call("eliminate", matrices, np.empty((*matrices.shape[:2], 0)), signs)
    return signs.reshape(lead) if lead else float(signs[0])


def inverse(matrix: Any) -> Any:
    """Inverse of each matrix; LinAlgError where there is none."""
    return solve(matrix, np.broadcast_to(np.eye(np.shape(matrix)[-1]), np.shape(matrix)))


class Svd(NamedTuple):
    """A = left diag(size) right: left (..., r, k), size (..., k) in falling order, right (..., k, c)."""

    left: Any
    size: Any
    right: Any


def svd(matrix: Any, full: bool = True) -> Svd:
    """Singular values and vectors of each matrix; left (..., r, r) and right (..., c, c) where ``full``."""
    stack = _stack(matrix)
    count, rows, columns = stack.matrices.shape
    k = min(rows, columns)
    left, right = (
        np.empty((count, rows, rows if full else k)),
        np.empty((count, columns if full else k, columns)),
    )
    return Svd(*stack.shaped(*_decomposed(stack.matrices, left, right, 2 if full else 1)))


def singular_values(matrix: Any) -> Any:
    """Singular values (..., k) in falling order."""
    stack, empty = _stack(matrix), np.empty((0, 0, 0))
    return stack.shaped(*_decomposed(stack.matrices, empty, empty, 0))[1]


def _decomposed(matrices: Array, left: Array, right: Array, vectors: int) -> tuple[Array, ...]:
    """Return left, size and right as the routine ``decompose`` wrote them."""
    count, rows, columns = matrices.shape
    n, length = min(rows, columns), max(rows, columns)
    size, workspace = np.empty((count, n)), np.empty(n * length + 2 * n * n + 5 * n + length)
    call("decompose", matrices, left, size, right, workspace, vectors)
    return left, size, right


def eigh(matrix: Any) -> tuple[Any, Any]:
    """Eigenvalues (..., n) in rising order and vectors (..., n, n) as columns of symmetric matrices.

    They are the singular values of A + s I, where the shift s, the largest sum of a row, leaves no eigenvalue
    below zero. The error of a value is some roundings of s, as that of every method that turns a matrix as a
    whole.
    """
    (matrices, lead), size = _stack(matrix, square=True), np.shape(matrix)[-1]
    shift = np.abs(matrices).sum(axis=-1).max(axis=-1, initial=0.0)
    matrices[:, range(size), range(size)] += shift[:, None]
    left, sizes, _ = svd(matrices)
    return (sizes - shift[:, None])[:, ::-1].reshape(*lead, size), left[..., ::-1].reshape(*lead, size, size)


def eigenvalue_sizes(matrix: Any) -> Any:
    """Absolute values (..., n) of the eigenvalues of general real matrices, in no order."""
    stack = _stack(matrix, square=True)
    real, imaginary = np.empty(stack.matrices.shape[:2]), np.empty(stack.matrices.shape[:2])
    call("eigenvalues", stack.matrices, real, imaginary, np.empty(stack.matrices.shape[1:]))
    return stack.shaped(np.sqrt(real * real + imaginary * imaginary))[0]


def qr(matrix: Any, full: bool = False) -> tuple[Any, Any]:
    """Q (..., r, k) with orthonormal columns and an upper triangle R (..., k, c); k is the lesser of r and c,
    or r where ``full``.
    """
    stack = _stack(matrix)
    count, rows, columns = stack.matrices.shape
    k = rows if full else min(rows, columns)
    q, r = np.empty((count, rows, k)), np.empty((count, k, columns))
    call("factors", stack.matrices, q, r, np.empty(columns * rows + 3 * columns + rows))
    return q.reshape(*stack.lead, rows, k), r.reshape(*stack.lead, k, columns)


def least_squares(matrix: Any, right: Any, tolerance: float | None = None) -> Any:
    """Return the x (c,) of least norm among those with the least |A x - b|.

    Singular values up to ``tolerance`` times the largest count as zero, as in np.linalg.lstsq. Normal
    equations would be cheaper, but square the condition number of A.
    """
    left, size, rows = svd(matrix, full=False)
    threshold = (EPS * max(np.shape(matrix)[-2:]) if tolerance is None else tolerance) * float(
        size.max(initial=0.0)
    )
    rank = int((size > threshold).sum())
    return times(rows[:rank].T, times(left[:, :rank].T, right) / size[:rank])


def pinv(matrix: Any, tolerance: float = 1e-15) -> Any:
    """Return the pseudoinverse (..., c, r) of each matrix; singular values up to ``tolerance`` times its
    largest count as zero.
    """
    left, size, rows = svd(matrix, full=False)
    threshold = tolerance * size.max(axis=-1, keepdims=True, initial=0.0)
    with np.errstate(divide="ignore"):
        reciprocal = np.where(size > threshold, 1.0 / size, 0.0)
    return product(np.swapaxes(rows, -1, -2), reciprocal[..., None] * np.swapaxes(left, -1, -2))
