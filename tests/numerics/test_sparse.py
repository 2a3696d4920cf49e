"""Sparse matrices against dense ones, and their solutions against what they have to satisfy."""

from __future__ import annotations

import numpy as np
import pytest

from vfife.numerics.routines import linear
from vfife.numerics.sparse import Sparse


def chain(count: int, closed: bool) -> tuple[Sparse, np.ndarray]:
    """Rows of a chain of bodies, each with entries at two neighbours; entries of one place
    come in two parts.
    """
    rng = np.random.default_rng(count)
    rows, columns, values = [], [], []
    for row in range(2 * count):
        for body in (row // 2, (row // 2 + 1) % count if closed else min(row // 2 + 1, count - 1)):
            for axis in range(3):
                rows.append(row)
                columns.append(3 * body + axis)
                values.append(rng.normal())
    sparse = Sparse(values, rows, columns, (2 * count, 3 * count))
    dense = np.zeros((2 * count, 3 * count))
    np.add.at(dense, (rows, columns), values)
    return sparse, dense


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("count", [2, 5, 40])
def test_products(count: int, closed: bool) -> None:
    sparse, dense = chain(count, closed)
    rng = np.random.default_rng(1)
    x, y, weight = rng.normal(size=3 * count), rng.normal(size=2 * count), rng.uniform(1.0, 2.0, 3 * count)
    assert (sparse.toarray() == dense).all()
    assert np.allclose(sparse.times(x), dense @ x, rtol=0, atol=1e-13) and np.allclose(
        sparse.transposed_times(y), dense.T @ y, rtol=0, atol=1e-13
    )
    assert np.allclose(sparse.squared().toarray(), dense @ dense.T, rtol=0, atol=1e-13)
    assert np.allclose(sparse.squared(weight).toarray(), dense * weight @ dense.T, rtol=0, atol=1e-13)
    assert np.allclose(sparse.weighted(y).toarray(), y[:, None] * dense, rtol=0, atol=0)
    assert np.allclose(sparse.squared().diagonal(), np.diag(dense @ dense.T), rtol=0, atol=1e-13)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("count", [2, 5, 40])
def test_solutions(count: int, closed: bool) -> None:
    sparse, dense = chain(count, closed)
    right = np.random.default_rng(2).normal(size=(2 * count, 3))
    found = sparse.squared().solver(1e-3)(right)
    assert np.abs((dense @ dense.T + 1e-3 * np.eye(2 * count)) @ found - right).max() < 1e-9
    assert (found[:, 1] == sparse.squared().solver(1e-3)(right[:, 1])).all()


def test_a_singular_matrix_has_positive_pivots() -> None:
    """Rows that depend on one another leave pivots of rounding alone: what was added stands for them."""
    _, dense = chain(6, False)
    twice = np.vstack([dense, dense])
    rows, columns = np.nonzero(twice)
    sparse = Sparse(twice[rows, columns], rows, columns, twice.shape)
    right = dense @ np.ones(18)
    found = sparse.squared().solver(1e-12)(np.concatenate([right, right]))
    assert np.abs(twice @ sparse.transposed_times(found) - np.concatenate([right, right])).max() < 1e-4


def test_parts_that_share_nothing() -> None:
    first, _ = chain(3, False)
    rows = np.concatenate([first.rows, first.rows + 6])
    both = Sparse(
        np.tile(first.values, 2), rows, np.concatenate([first.columns, first.columns + 9]), (12, 18)
    )
    parts = both.squared().components()
    assert [part.tolist() for part in parts] == [list(range(6)), list(range(6, 12))]
    assert (both.part(parts[1]).toarray() == first.toarray()).all()


def test_a_pivot_of_rounding_is_taken_as_the_least() -> None:
    factors = [1.0, 1.0, 1.0 - 2.0**-53]  # the triangle of two rows that are one
    linear.factorise(factors, [0.0, 2.0], [0.0, 0.0], 2, 0.25)
    assert factors == [1.0, 1.0, 0.25]
