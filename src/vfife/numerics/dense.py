"""Linear algebra of small dense matrices (..., rows, columns), with the same bits on every machine and in
every batch.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .library import call
from .products import flat, product, times

Array = NDArray[np.float64]
EPS = 2.0**-52
NONE = np.zeros(0)


def _shape(matrix: Any) -> tuple[Array, tuple[int, ...], int, int, int]:
    """A matrix as an array, its leading dimensions and how many matrices these are, rows and columns."""
    own = np.asarray(matrix, dtype=np.float64)
    rows, columns = own.shape[-2:]
    return own, own.shape[:-2], math.prod(own.shape[:-2]), rows, columns


def _square(matrix: Any) -> tuple[Array, tuple[int, ...], int, int]:
    own, lead, count, rows, columns = _shape(matrix)
    if rows != columns:
        raise np.linalg.LinAlgError(
            f"a square matrix is needed, not one of {rows} rows and {columns} columns"
        )
    return own, lead, count, rows


def _finite(sizes: Array) -> None:
    if np.isnan(sizes).any():
        raise np.linalg.LinAlgError("a matrix has entries that are not finite")


def solve(matrix: Any, right: Any) -> Any:
    """x of A x = b by elimination with partial pivoting, for b (..., n) or (..., n, columns); LinAlgError
    where a column has no pivot.

    A right side with one dimension less than the matrix is a vector.
    """
    own, lead, count, size = _square(matrix)
    b = np.asarray(right, dtype=np.float64)
    vector = b.ndim == own.ndim - 1
    b = b[..., None] if vector else b
    found = np.array(np.broadcast_to(b, (*lead, size, b.shape[-1])), order="C")
    signs = np.empty(count)
    call(
        "eliminate", np.array(own, order="C").reshape(-1), found.reshape(-1), signs, count, size, b.shape[-1]
    )
    if not (signs != 0.0).all():
        raise np.linalg.LinAlgError("Singular matrix")
    found = found[..., 0] if vector else found
    return found


class Solved(NamedTuple):
    """x of A x = b, and the determinants of A; where one is 0, x is not solved."""

    x: Array
    determinant: Array


def solve_with_determinant(matrix: Array, right: Array) -> Solved:
    """x (..., n, columns) of A x = b by elimination with partial pivoting, and the determinant of each A."""
    own, lead, count, size = _square(matrix)
    triangle, found, signs = (
        np.array(own, order="C"),
        np.array(right, dtype=np.float64, order="C"),
        np.empty(count),
    )
    call("eliminate", triangle.reshape(-1), found.reshape(-1), signs, count, size, found.shape[-1])
    diagonal = np.diagonal(triangle, axis1=-2, axis2=-1)
    return Solved(found, signs.reshape(lead) * np.abs(np.multiply.reduce(diagonal, axis=-1)))


def determinant_sign(matrix: Any) -> Any:
    """Sign of the determinant of each matrix: -1, 0 or 1."""
    own, lead, count, size = _square(matrix)
    signs = np.empty(count)
    call("eliminate", np.array(own, order="C").reshape(-1), NONE, signs, count, size, 0)
    return signs.reshape(lead) if lead else float(signs[0])


def inverse(matrix: Any) -> Any:
    """Inverse of each matrix; LinAlgError where there is none."""
    own, _, _, size = _square(matrix)
    return solve(own, np.broadcast_to(np.eye(size), own.shape))


def svd(matrix: Any, full: bool = True) -> tuple[Any, Any, Any]:
    """left (..., r, r), size (..., k) in falling order, right (..., c, c) with A = left size right; k columns
    and rows where not ``full``.
    """
    own, lead, count, rows, columns = _shape(matrix)
    k = min(rows, columns)
    wide, deep = (rows, columns) if full else (k, k)
    left, size, right = np.empty((*lead, rows, wide)), np.empty((*lead, k)), np.empty((*lead, deep, columns))
    call(
        "decompose",
        flat(own),
        left.reshape(-1),
        size.reshape(-1),
        right.reshape(-1),
        _room(rows, columns),
        count,
        rows,
        columns,
        2 if full else 1,
    )
    _finite(size)
    return left, size, right


def singular_values(matrix: Any) -> Any:
    """Singular values (..., k) in falling order."""
    own, lead, count, rows, columns = _shape(matrix)
    size = np.empty((*lead, min(rows, columns)))
    call("decompose", flat(own), NONE, size.reshape(-1), NONE, _room(rows, columns), count, rows, columns, 0)
    _finite(size)
    return size


def _room(rows: int, columns: int) -> Array:
    """Room that a decomposition works in."""
    n, length = min(rows, columns), max(rows, columns)
    return np.empty(n * length + 2 * n * n + 5 * n + length)


def eigh(matrix: Any) -> tuple[Any, Any]:
    """Eigenvalues (..., n) in rising order and vectors (..., n, n) as columns of symmetric matrices, whose
    lower triangle is read.
    """
    own, lead, count, size = _square(matrix)
    values, vectors = np.empty((*lead, size)), np.empty((*lead, size, size))
    call(
        "diagonalise",
        flat(own),
        values.reshape(-1),
        vectors.reshape(-1),
        np.empty(size * size + 2 * size),
        count,
        size,
    )
    _finite(values)
    return values, vectors


def eigenvalue_sizes(matrix: Any) -> Any:
    """Absolute values (..., n) of the eigenvalues of general real matrices, in no order."""
    own, lead, count, size = _square(matrix)
    real, imaginary = np.empty((*lead, size)), np.empty((*lead, size))
    call(
        "eigenvalues", flat(own), real.reshape(-1), imaginary.reshape(-1), np.empty(size * size), count, size
    )
    _finite(real)
    return np.sqrt(real * real + imaginary * imaginary)


def qr(matrix: Any, full: bool = False) -> tuple[Any, Any]:
    """Q (..., r, k) with orthonormal columns and an upper triangle R (..., k, c); k is the lesser of r and c,
    or r where ``full``.
    """
    own, lead, count, rows, columns = _shape(matrix)
    k = rows if full else min(rows, columns)
    q, r = np.empty((*lead, rows, k)), np.empty((*lead, k, columns))
    room = np.empty(columns * rows + 3 * columns + rows)
    call("factors", flat(own), q.reshape(-1), r.reshape(-1), room, count, rows, columns, int(full))
    return q, r


def least_squares(matrix: Any, right: Any, tolerance: float | None = None) -> Any:
    """x (c,) of least norm with the least |A x - b|; singular values up to ``tolerance`` of the largest count as zero (as in np.linalg.lstsq)."""
    left, size, rows = svd(matrix, full=False)
    least = (EPS * max(np.shape(matrix)[-2:]) if tolerance is None else tolerance) * float(
        size.max(initial=0.0)
    )
    rank = int((size > least).sum())
    return times(rows[:rank].T, times(left[:, :rank].T, right) / size[:rank])


def pinv(matrix: Any, tolerance: float = 1e-15) -> Any:
    """Pseudoinverse (..., c, r) of each matrix; singular values up to ``tolerance`` of its largest count as
    zero.
    """
    left, size, rows = svd(matrix, full=False)
    least = tolerance * size.max(axis=-1, keepdims=True, initial=0.0)
    with np.errstate(divide="ignore"):
        over = np.where(size > least, 1.0 / size, 0.0)
    return product(np.swapaxes(rows, -1, -2), over[..., None] * np.swapaxes(left, -1, -2))
