"""Linear algebra of constraints that may be linearly dependent: steps of least norm, motions nearest to a
wish, and self-stresses.

G [r, c] is dense, with one singular value decomposition, up to 90 columns. Beyond, it is sparse, with factors
of G G^T + epsilon that are refined iteratively: a decomposition grows with the third power of the size. All
of it has the same bits on every machine (:mod:`vfife.numerics`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numerics import dense
from ..numerics.sparse import Sparse

Array = NDArray[np.float64]
Matrix = Any  # a dense array, or a Sparse one

# Singular values below this count as zero: a dead centre is reached only to the square root of round-off.
RANK_TOLERANCE = 1e-7
DENSE = 90  # columns: beyond some 30 bodies sparse factors are faster
# Share of the largest pivot that is added: far below the squares of singular values that count, far above
# their round-off.
EPSILON = 1e-12
# The same for solutions that are refined: self-stress by round-off stays below 1e-7 of the reactions.
SOFT = 1e-9
REFINEMENTS = 30


def matrix(values: Any, rows: Any, columns: Any, shape: tuple[int, int]) -> Matrix:
    """Return G, dense or sparse, from its entries; entries of one place are added."""
    if shape[1] <= DENSE:
        dense = np.zeros(shape)
        np.add.at(dense, (rows, columns), values)
        return dense
    return Sparse(values, rows, columns, (shape[0], shape[1]))


def times(matrix: Matrix, vector: Array) -> Any:
    """Return a matrix times a vector."""
    return matrix.times(vector) if isinstance(matrix, Sparse) else dense.times(matrix, vector)


def decomposed(jacobian: Array) -> tuple[Array, Array, Array]:
    """Return the full singular value decomposition of a dense G, read-only.

    Velocities, accelerations, reactions and mobility need it at the same position, so the last few are
    cached.
    """
    if jacobian.ndim == 3 and len(jacobian) == 1:
        left, size, right = decomposed(jacobian[0])
        return left[None], size[None], right[None]
    return _decomposed(jacobian.shape, jacobian.tobytes())


def independent(jacobian: Matrix) -> NDArray[np.bool_]:
    """Return whether the rows of dense matrices (cases, r, c) are linearly independent; False for sparse
    ones, where it is not known.
    """
    if not isinstance(jacobian, np.ndarray):
        return np.zeros(len(jacobian), dtype=bool)
    return np.asarray((decomposed(jacobian)[1] > RANK_TOLERANCE).sum(axis=-1) == jacobian.shape[-2])


@lru_cache(maxsize=4)
def _decomposed(shape: tuple[int, ...], entries: bytes) -> tuple[Array, Array, Array]:
    left, size, right = dense.svd(np.frombuffer(entries).reshape(shape))
    for factor in (left, size, right):
        factor.setflags(write=False)
    return left, size, right


class DampedStep:
    """The function (damping) -> (G^T G + damping)^-1 G^T error of each case, of least norm; directions
    without a row are not moved.

    The decomposition is kept while the damping changes, so that a refused step costs no new one. ``size`` and
    ``part`` [cases, k] and ``columns`` [cases, 3(n-1), k] belong to the singular values, the smallest of
    which are left out by a size of 0. Large systems have one case, ``sparse``, with its square and error.
    """

    def __init__(
        self, size: Array, part: Array, columns: Array, sparse: tuple[Sparse, Any, Array] | None = None
    ) -> None:
        self.size, self.part, self.columns, self.sparse = size, part, columns, sparse

    @classmethod
    def empty(cls, jacobian: Any) -> DampedStep:
        """Return the object for such matrices, before any of them is decomposed."""
        count, *shape = jacobian.shape
        rank, columns = (min(shape), shape[1]) if shape else (0, 0)
        return cls(np.zeros((count, rank)), np.zeros((count, rank)), np.zeros((count, columns, rank)))

    @classmethod
    def of(cls, weight: Array, jacobian: Any, error: Array) -> DampedStep:
        """Return the object for matrices [cases, r, 3(n-1)] with weighted rows, or for an array of one sparse
        matrix.
        """
        if jacobian.dtype == object:
            sparse, empty = jacobian[0].weighted(weight), np.zeros((1, 0))
            return cls(empty, empty, empty[:, None][:, :0], (sparse, sparse.squared(), weight * error[0]))
        left, size, right = dense.svd(weight[:, None] * jacobian, full=False)
        part = times(turned(left), weight * error)
        return cls(np.where(size > RANK_TOLERANCE, size, 0.0), part, turned(right).copy())

    def select(self, chosen: NDArray[np.bool_]) -> DampedStep:
        """Return the object for some of the cases."""
        return DampedStep(self.size[chosen], self.part[chosen], self.columns[chosen], self.sparse)

    def update(self, chosen: NDArray[np.bool_], weight: Array, jacobian: Any, error: Array) -> None:
        """Replace matrices and errors of some of the cases."""
        if chosen.any():
            new = DampedStep.of(weight, jacobian[chosen], error[chosen])
            for name in ("size", "part", "columns"):
                getattr(self, name)[chosen] = getattr(new, name)
            self.sparse = new.sparse

    def __call__(self, damping: Array) -> Array:
        """Return the step of each case for its ``damping`` (cases,), shape (cases, unknowns)."""
        if self.sparse is not None:
            jacobian, squared, error = self.sparse
            return np.asarray(
                jacobian.transposed_times(squared.solver(max(float(damping[0]), EPSILON))(error))
            )[None]
        counts = self.size > 0.0
        square = np.where(counts, self.size * self.size + damping[:, None], 1.0)
        return np.asarray(times(self.columns, np.where(counts, self.size / square * self.part, 0.0)))


def constrained(jacobian: Matrix, target: Array, mass: Array, free: Array) -> tuple[Array, Array]:
    """Return the motion x [c] with G x = target and the least (x - free)^T M (x - free), and its multipliers
    [r], M (x - free) = G^T lambda.

    If rows are linearly dependent, lambda is the solution of least norm, and x satisfies ``target`` as well
    as possible. Any number of cases (cases, ...) with dense matrices is solved at once, those of one rank
    together.
    """
    if isinstance(jacobian, np.ndarray):
        left, size, right = decomposed(jacobian)
        ranks = np.sum(size > RANK_TOLERANCE, axis=-1)
        if ranks.ndim and (ranks != ranks[0]).any():
            motion, multiplier = np.empty_like(free), np.empty_like(target)
            for rank in np.unique(ranks):
                members = ranks == rank
                motion[members], multiplier[members] = constrained(
                    jacobian[members], target[members], mass[members], free[members]
                )
            return motion, multiplier
        rank = int(ranks.flat[0])
        column_space, row_space = turned(left[..., :rank]), right[..., :rank, :]
        motion = times(turned(row_space), times(column_space, target) / size[..., :rank])
        null = turned(right[..., rank:, :])
        if null.shape[-1]:
            pull = times(turned(null), mass * (free - motion))
            motion = motion + times(
                null, dense.solve(dense.product(turned(null), mass[..., None] * null), pull)
            )
        return motion, times(
            turned(column_space), times(row_space, mass * (motion - free)) / size[..., :rank]
        )
    squared = jacobian.squared(1.0 / mass)
    left_over = target - times(jacobian, free)
    solve, multiplier = (
        squared.solver(SOFT * float(squared.diagonal().max(initial=1e-300))),
        np.zeros(len(target)),
    )
    finest = 1e-15 * max(np.abs(target).max(initial=0.0), np.abs(free).max(initial=0.0))
    for _ in range(REFINEMENTS):
        missing = left_over - times(squared, multiplier)
        if np.abs(missing).max(initial=0.0) <= finest:
            break
        multiplier += solve(missing)
    return free + jacobian.transposed_times(multiplier) / mass, multiplier


def turned(matrix: Array) -> Array:
    """Return the transposes of matrices."""
    return np.swapaxes(matrix, -1, -2)


def shared_out(jacobian: Matrix, mobility: Array, multiplier: Array) -> Array:
    """Return the multipliers [r] with the same effect on the bodies that have least norm, each weighted by
    its row's own diagonal of G M^-1 G^T, as in a step.

    ``mobility`` [c] is the diagonal of M^-1, 0 for driven bodies. Multipliers that are determined uniquely do
    not change.
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
    square = dense.product(stress.T, weight[:, None] * stress)
    return np.asarray(
        multiplier - times(stress, dense.least_squares(square, times(stress.T, weight * multiplier)))
    )


def self_stress(jacobian: Matrix) -> Array:
    """Return orthonormal multipliers [r, k] without an effect on the bodies, G^T N = 0: the self-stresses,
    one for each row that depends on others.
    """
    count = jacobian.shape[0]
    if count == 0:
        return np.zeros((0, 0))
    if isinstance(jacobian, np.ndarray):
        left, size, _ = decomposed(jacobian)
        return np.asarray(left[:, int(np.sum(size > RANK_TOLERANCE)) :])
    solve = jacobian.squared().solver(EPSILON)
    columns = 8
    # Inverse iteration with more and more vectors, until one of them is no self-stress: then all are found.
    while 4 * columns < count:
        basis = _scattered(count, columns)
        for _ in range(4):
            basis = dense.qr(solve(basis))[0]
        image = np.stack([jacobian.transposed_times(multiplier) for multiplier in basis.T], axis=1)
        _, size, turn = dense.svd(image, full=False)
        if size[0] > RANK_TOLERANCE:
            return np.asarray(dense.product(basis, turn[size <= RANK_TOLERANCE].T))
        columns *= 4
    return self_stress(jacobian.toarray())


def _scattered(count: int, columns: int) -> Array:
    """Return numbers (count, columns) between -1/2 and 1/2 without a pattern, the same on every machine:
    fractional parts of multiples of the golden section, in integers.
    """
    places = np.arange(1, count + 1, dtype=np.uint64)[:, None] * np.square(
        np.arange(1, columns + 1, dtype=np.uint64)
    )
    return (places * np.uint64(2654435769) % np.uint64(2**32)).astype(np.float64) / 2.0**32 - 0.5


def dependent_rows(jacobian: Matrix) -> list[int]:
    """Return the rows that are linear combinations of rows before them; a sparse G is examined in parts that
    share no body.
    """
    if isinstance(jacobian, np.ndarray):
        return _ends(self_stress(jacobian))
    result: list[int] = []
    for rows in jacobian.squared().components():
        component = jacobian.part(rows)
        result += rows[
            _ends(self_stress(component.toarray() if component.shape[1] <= DENSE else component))
        ].tolist()
    return sorted(result)


def _ends(stress: Array) -> list[int]:
    """Return the last rows of self-stresses [r, k], one for each: these depend on the rows before them."""
    result: list[int] = []
    left = stress.copy()
    for row in range(len(left) - 1, -1, -1):
        size = dense.norm(left[row])
        if size > 1e-6:
            result.append(row)
            direction = left[row] / size
            left = left - np.outer(times(left, direction), direction)
            if len(result) == stress.shape[1]:
                break
    return result[::-1]
