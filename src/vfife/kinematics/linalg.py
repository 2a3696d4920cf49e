"""Linear algebra of constraints that may depend on one another: least steps, motions nearest a wish, and
self-stresses.

G [r, c] is dense (one singular value decomposition) up to 90 columns, and sparse beyond: factors of G G^T +
epsilon, refined. All of it has the same bits on every machine (:mod:`vfife.numerics`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numerics import dense, products
from ..numerics.sparse import Sparse

Array = NDArray[np.float64]
Matrix = Any  # a dense array, or a Sparse one

RANK_TOLERANCE = 1e-7  # a dead centre is only met to the root of round-off, so it must be judged this loosely
DENSE = 90  # columns: beyond some 30 bodies sparse factors are faster
# of the largest pivot: well under the squares of singular values that count, well over their round-off
EPSILON = 1e-12
# the same where the solution is refined: self-stress from round-off stays under 1e-7 of the reactions
SOFT = 1e-9
REFINEMENTS = 30


def matrix(values: list[Any], rows: list[int], columns: list[int], shape: tuple[int, ...]) -> Matrix:
    """G from its entries, which may repeat."""
    if shape[1] <= DENSE:
        dense = np.zeros(shape)
        np.add.at(dense, (rows, columns), values)
        return dense
    return Sparse(values, rows, columns, (shape[0], shape[1]))


def times(matrix: Matrix, vector: Array) -> Any:
    """A matrix times a vector."""
    return matrix.times(vector) if isinstance(matrix, Sparse) else products.times(matrix, vector)


def weighted(weight: Array, jacobian: Matrix) -> Matrix:
    """diag(weight) G."""
    if isinstance(jacobian, np.ndarray):
        return np.asanyarray(weight[:, None] * jacobian)
    return jacobian.weighted(weight)


def decomposed(jacobian: Array) -> tuple[Array, Array, Array]:
    """The whole singular value decomposition of a dense G; not to be written to.

    Velocities, accelerations, reactions and mobility are asked for at one position, so the last few are kept.
    """
    return _decomposed(jacobian.shape, jacobian.tobytes())


@lru_cache(maxsize=4)
def _decomposed(shape: tuple[int, int], entries: bytes) -> tuple[Array, Array, Array]:
    left, size, right = dense.svd(np.frombuffer(entries).reshape(shape))
    for one in (left, size, right):
        one.setflags(write=False)
    return left, size, right


class DampedStep:
    """(damping) -> (G^T G + damping)^-1 G^T error, of least norm; directions that no row sees are left alone."""

    def __init__(self, jacobian: Matrix, error: Array) -> None:
        self.error, self.squared = error, None
        if not isinstance(jacobian, np.ndarray):
            self.jacobian, self.squared = jacobian, jacobian.squared()
            return
        left, size, right = dense.svd(jacobian, full=False)
        rank = int((size > RANK_TOLERANCE).sum())
        self.size, self.part, self.columns = size[:rank], times(left.T[:rank], error), right[:rank].T

    def __call__(self, damping: float) -> Array:
        if self.squared is not None:
            found: Array = self.jacobian.transposed_times(
                self.squared.solver(max(damping, EPSILON))(self.error)
            )
            return found
        return np.asarray(times(self.columns, self.size / (self.size * self.size + damping) * self.part))


def constrained(jacobian: Matrix, wanted: Array, mass: Array, free: Array) -> tuple[Array, Array]:
    """The motion x [c] with G x = wanted and the least (x - free)^T M (x - free), and its multipliers [r]: M
    (x - free) = G^T lambda.

    Where rows depend on one another, lambda is the solution of least norm, and x fits ``wanted`` as well as
    can be.
    """
    if isinstance(jacobian, np.ndarray):
        left, size, right = decomposed(jacobian)
        rank = int(np.sum(size > RANK_TOLERANCE))
        across, along = left[:, :rank].T, right[:rank]
        motion = times(along.T, times(across, wanted) / size[:rank])
        null = right[rank:].T
        if null.shape[1]:
            pull = times(null.T, mass * (free - motion))
            motion = motion + times(null, dense.solve(products.product(null.T, mass[:, None] * null), pull))
        return motion, times(across.T, times(along, mass * (motion - free)) / size[:rank])
    squared = jacobian.squared(1.0 / mass)
    left_over = wanted - times(jacobian, free)
    solve, multiplier = (
        squared.solver(SOFT * float(squared.diagonal().max(initial=1e-300))),
        np.zeros(len(wanted)),
    )
    finest = 1e-15 * max(np.abs(wanted).max(initial=0.0), np.abs(free).max(initial=0.0))
    for _ in range(REFINEMENTS):
        missing = left_over - times(squared, multiplier)
        if np.abs(missing).max(initial=0.0) <= finest:
            break
        multiplier += solve(missing)
    return free + jacobian.transposed_times(multiplier) / mass, multiplier


def shared_out(jacobian: Matrix, mobility: Array, multiplier: Array) -> Array:
    """Multipliers [r] that load the bodies alike, of least norm, each weighed by its row's own diagonal of G
    M^-1 G^T, as a step weighs reactions.

    ``mobility`` [c]: the diagonal of M^-1, 0 for what is driven. Multipliers that nothing leaves open stay as
    they are.
    """
    stress = self_stress(jacobian)
    if not stress.shape[1]:
        return multiplier
    squares = (
        jacobian * jacobian
        if isinstance(jacobian, np.ndarray)
        else Sparse.like(jacobian, jacobian.values * jacobian.values)
    )
    weight = times(squares, mobility)
    square = products.product(stress.T, weight[:, None] * stress)
    return np.asarray(
        multiplier - times(stress, dense.least_squares(square, times(stress.T, weight * multiplier)))
    )


def self_stress(jacobian: Matrix) -> Array:
    """Orthonormal multipliers [r, k] that load nothing, G^T N = 0: one for each row that depends on the
    others.
    """
    count = jacobian.shape[0]
    if count == 0:
        return np.zeros((0, 0))
    if isinstance(jacobian, np.ndarray):
        left, size, _ = decomposed(jacobian)
        return np.asarray(left[:, int(np.sum(size > RANK_TOLERANCE)) :])
    solve = jacobian.squared().solver(EPSILON)
    columns = 8
    while (
        4 * columns < count
    ):  # inverse iteration with as many vectors as it takes to see one that is no self-stress
        basis = _scattered(count, columns)
        for _ in range(4):
            basis = dense.qr(solve(basis))[0]
        seen = np.stack([jacobian.transposed_times(one) for one in basis.T], axis=1)
        _, size, turn = dense.svd(seen, full=False)
        if size[0] > RANK_TOLERANCE:
            return np.asarray(products.product(basis, turn[size <= RANK_TOLERANCE].T))
        columns *= 4
    return self_stress(jacobian.toarray())


def _scattered(count: int, columns: int) -> Array:
    """Numbers (count, columns) between -1/2 and 1/2 without a pattern: multiples of the golden section less
    whole numbers, in integers.
    """
    places = np.arange(1, count + 1, dtype=np.uint64)[:, None] * np.square(
        np.arange(1, columns + 1, dtype=np.uint64)
    )
    return (places * np.uint64(2654435769) % np.uint64(2**32)).astype(np.float64) / 2.0**32 - 0.5


def dependent_rows(jacobian: Matrix) -> list[int]:
    """Rows that follow from those before them, found part by part where G falls apart into loops that share
    no body.
    """
    if isinstance(jacobian, np.ndarray):
        return _ends(self_stress(jacobian))
    found: list[int] = []
    for rows in jacobian.squared().components():
        here = jacobian.part(rows)
        found += rows[_ends(self_stress(here.toarray() if here.shape[1] <= DENSE else here))].tolist()
    return sorted(found)


def _ends(stress: Array) -> list[int]:
    """The rows at which self-stresses [r, k] end."""
    found: list[int] = []
    left = stress.copy()
    for row in range(len(left) - 1, -1, -1):
        size = products.norm(left[row])
        if size > 1e-6:
            found.append(row)
            along = left[row] / size
            left = left - np.outer(times(left, along), along)
            if len(found) == stress.shape[1]:
                break
    return found[::-1]
