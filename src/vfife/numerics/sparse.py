"""Sparse matrices and their products in a fixed order, and solutions of the symmetric ones that follow from
them.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import lru_cache
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .routine import call

Array = NDArray[np.float64]
Places = NDArray[np.intp]


class Sparse:
    """A matrix (r, c) given by its entries, sorted by rows and within a row by columns; entries of the same
    place are summed in the order in which they are given.
    """

    def __init__(self, values: Any, rows: Any, columns: Any, shape: tuple[int, int]) -> None:
        at = np.asarray(rows, dtype=np.intp) * shape[1] + np.asarray(columns, dtype=np.intp)
        places, index = np.unique(at, return_inverse=True)
        self.shape = shape
        self.values: Array = np.zeros(len(places))
        np.add.at(self.values, index.reshape(-1), np.asarray(values, dtype=np.float64))
        self.rows, self.columns = np.divmod(places, shape[1])

    @classmethod
    def like(cls, pattern: Sparse, values: Array) -> Sparse:
        """Return a matrix with these values in the places of the entries of ``pattern``."""
        result = copy(pattern)
        result.values = values
        return result

    def times(self, vector: Array) -> Array:
        """Matrix times vector."""
        return np.asarray(
            np.bincount(self.rows, self.values * vector[self.columns], minlength=self.shape[0]),
            dtype=np.float64,
        )

    def transposed_times(self, vector: Array) -> Array:
        """Its transpose times a vector."""
        return np.asarray(
            np.bincount(self.columns, self.values * vector[self.rows], minlength=self.shape[1]),
            dtype=np.float64,
        )

    def weighted(self, weight: Array) -> Sparse:
        """diag(weight) A."""
        return Sparse.like(self, weight[self.rows] * self.values)

    def squared(self, weight: Array | None = None) -> Sparse:
        """Return A diag(weight) A^T; the weights are one unless given.

        Every entry of a column of A meets every entry of the same column: all these pairs are listed at once,
        and :class:`Sparse` sums those that fall on one place, always in the same order.
        """
        order = np.lexsort((self.rows, self.columns))
        column, row, value = self.columns[order], self.rows[order], self.values[order]
        counts = np.bincount(column, minlength=self.shape[1])
        begins = np.concatenate([[0], np.cumsum(counts)[:-1]])
        partners = counts[column]  # number of entries in the column of each entry
        first = np.repeat(np.arange(len(row)), partners)
        second = (
            np.arange(len(first))
            - np.repeat(np.cumsum(partners) - partners, partners)
            + begins[column[first]]
        )
        scaled = value if weight is None else value * weight[column]
        return Sparse(scaled[first] * value[second], row[first], row[second], (self.shape[0], self.shape[0]))

    def part(self, rows: Places) -> Sparse:
        """Return the matrix of some rows, given in rising order, and of the columns in which they have
        entries.
        """
        chosen = np.isin(self.rows, rows)
        columns = np.unique(self.columns[chosen])
        places = np.searchsorted(rows, self.rows[chosen]), np.searchsorted(columns, self.columns[chosen])
        return Sparse(self.values[chosen], *places, (len(rows), len(columns)))

    def toarray(self) -> Array:
        """As a dense matrix."""
        result = np.zeros(self.shape)
        result[self.rows, self.columns] = self.values
        return result

    def diagonal(self) -> Array:
        """Return the entries of the diagonal."""
        result, on_diagonal = np.zeros(min(self.shape)), self.rows == self.columns
        result[self.rows[on_diagonal]] = self.values[on_diagonal]
        return result

    def solver(self, added: float) -> Callable[[Array], Array]:
        """Return a function that solves (A + added I) x = b for a symmetric A without negative eigenvalues
        and a positive ``added``; b is (n,) or (n, columns).

        Factors L D L^T of the whole matrix, once; rows are ordered so that entries lie near the diagonal and
        the factors stay sparse. No pivoting is needed, as the matrix is positive definite.
        """
        size = self.shape[0]
        order, place, first, start = _skyline(size, self.rows.tobytes(), self.columns.tobytes())
        factors = np.zeros(int(start[-1]) + 1 if size else 0)
        i, j = place[self.rows], place[self.columns]
        lower = j <= i
        factors[start[i[lower]].astype(np.intp) - i[lower] + j[lower]] = self.values[lower]
        factors[start.astype(np.intp)] += added
        call("factorise", factors, start, first, size, 0.5 * added)

        def solution(right: Array) -> Array:
            if right.ndim > 1:
                return np.stack([solution(column) for column in right.T], axis=1)
            x = right[order]
            call("substitute_back", factors, start, first, x, size)
            result = np.empty(size)
            result[order] = x
            return result

        return solution

    def components(self) -> list[Places]:
        """Return the rows, in rising order, of each connected part of a symmetric matrix."""
        neighbours = _neighbours(self.shape[0], self.rows, self.columns)
        met: set[int] = set()
        result = []
        for node in range(self.shape[0]):
            if node not in met:
                part = list(chain.from_iterable(_levels(neighbours, node)))
                met |= set(part)
                result.append(np.array(sorted(part), dtype=np.intp))
        return result


def _neighbours(size: int, rows: Places, columns: Places) -> list[list[int]]:
    """Return for each row of a symmetric pattern the other rows that it has entries with, in rising order."""
    result: list[list[int]] = [[] for _ in range(size)]
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        if row != column:
            result[row].append(column)
    return result


def _levels(neighbours: list[list[int]], node: int) -> list[list[int]]:
    """Return the nodes by their distance from ``node``: level 0 is the node, level 1 its neighbours, and so
    on.

    Within a level nodes are in the order of their predecessors, and those of one predecessor by rising
    number of neighbours, as Cuthill and McKee ask.
    """
    met, levels = {node}, [[node]]
    while True:
        following = []
        for parent in levels[-1]:
            fresh = sorted(
                (neighbour for neighbour in neighbours[parent] if neighbour not in met),
                key=lambda neighbour: (len(neighbours[neighbour]), neighbour),
            )
            met.update(fresh)
            following += fresh
        if not following:
            return levels
        levels.append(following)


@lru_cache(maxsize=8)
def _skyline(size: int, rows: bytes, columns: bytes) -> tuple[Places, Places, Array, Array]:
    """Return an order of the rows in which entries lie near the diagonal, the place of each row in it, the
    first column of each row, and the places of the diagonal entries.

    Reverse order of Cuthill and McKee (1969): by levels from a node at one end of the graph. Such a node is
    searched by going to the last level from any node, and again from there, until the number of levels no
    longer grows: many levels are narrow ones, and the width of a level bounds the distance from the diagonal.
    """
    own_rows, own_columns = np.frombuffer(rows, dtype=np.intp), np.frombuffer(columns, dtype=np.intp)
    neighbours = _neighbours(size, own_rows, own_columns)
    met: set[int] = set()
    order: list[int] = []
    for node in sorted(range(size), key=lambda row: (len(neighbours[row]), row)):
        if node in met:
            continue
        levels = _levels(neighbours, node)
        while True:
            end = min(levels[-1], key=lambda row: (len(neighbours[row]), row))
            deeper = _levels(neighbours, end)
            if len(deeper) <= len(levels):
                break
            levels = deeper
        part = list(chain.from_iterable(deeper))
        met.update(part)
        order += part
    # The reverse order has the same distances from the diagonal, but rows begin later: less fills in.
    turned = np.array(order[::-1], dtype=np.intp)
    place = np.empty(size, dtype=np.intp)
    place[turned] = np.arange(size)
    first = np.arange(size)
    np.minimum.at(first, place[own_rows], place[own_columns])
    start = np.cumsum(np.arange(size) - first + 1) - 1
    return turned, place, first.astype(np.float64), start.astype(np.float64)
