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


def matrix(values: Any, rows: Any, columns: Any, shape: tuple[int, int]) -> Matrix:
    """G from its entries, which may repeat."""
    if shape[1] <= DENSE:
        dense = np.zeros(shape)
        np.add.at(dense, (rows, columns), values)
        return dense
    return Sparse(values, rows, columns, (shape[0], shape[1]))


def times(matrix: Matrix, vector: Array) -> Any:
    """A matrix times a vector."""
    return matrix.times(vector) if isinstance(matrix, Sparse) else products.times(matrix, vector)


def decomposed(jacobian: Array) -> tuple[Array, Array, Array]:
    """The whole singular value decomposition of a dense G; not to be written to.

    Velocities, accelerations, reactions and mobility are asked for at one position, so the last few are kept.
    """
    if jacobian.ndim == 3 and len(jacobian) == 1:
        left, size, right = decomposed(jacobian[0])
        return left[None], size[None], right[None]
    return _decomposed(jacobian.shape, jacobian.tobytes())


def independent(jacobian: Matrix) -> NDArray[np.bool_]:
    """Whether no row of dense matrices (cases, r, c) depends on others; nothing is said of sparse ones."""
    if not isinstance(jacobian, np.ndarray):
        return np.zeros(len(jacobian), dtype=bool)
    return np.asarray((decomposed(jacobian)[1] > RANK_TOLERANCE).sum(axis=-1) == jacobian.shape[-2])


@lru_cache(maxsize=4)
def _decomposed(shape: tuple[int, ...], entries: bytes) -> tuple[Array, Array, Array]:
    left, size, right = dense.svd(np.frombuffer(entries).reshape(shape))
    for one in (left, size, right):
        one.setflags(write=False)
    return left, size, right


class DampedStep:
    """(damping) -> (G^T G + damping)^-1 G^T error of each case, of least norm; directions that no row sees
    are left alone.

    ``size`` and ``part`` [cases, k] and ``columns`` [cases, 3(n-1), k] are those of singular values, the
    smallest left out by a size of 0. Of large systems there is one case, ``sparse``, with its square and
    error.
    """

    def __init__(
        self, size: Array, part: Array, columns: Array, sparse: tuple[Sparse, Any, Array] | None = None
    ) -> None:
        self.size, self.part, self.columns, self.sparse = size, part, columns, sparse

    @classmethod
    def empty(cls, jacobian: Any) -> DampedStep:
        """Of such matrices, before any of them is decomposed."""
        count, *shape = jacobian.shape
        least, columns = (min(shape), shape[1]) if shape else (0, 0)
        return cls(np.zeros((count, least)), np.zeros((count, least)), np.zeros((count, columns, least)))

    @classmethod
    def of(cls, weight: Array, jacobian: Any, error: Array) -> DampedStep:
        """Of matrices [cases, r, 3(n-1)], their rows weighted; or of an array of one sparse matrix."""
        if jacobian.dtype == object:
            one, none = jacobian[0].weighted(weight), np.zeros((1, 0))
            return cls(none, none, none[:, None][:, :0], (one, one.squared(), weight * error[0]))
        left, size, right = dense.svd(weight[:, None] * jacobian, full=False)
        part = times(turned(left), weight * error)
        return cls(np.where(size > RANK_TOLERANCE, size, 0.0), part, turned(right).copy())

    def select(self, which: NDArray[np.bool_]) -> DampedStep:
        """Some of the cases."""
        return DampedStep(self.size[which], self.part[which], self.columns[which], self.sparse)

    def update(self, which: NDArray[np.bool_], weight: Array, jacobian: Any, error: Array) -> None:
        """Some of the cases have other matrices and errors."""
        if which.any():
            new = DampedStep.of(weight, jacobian[which], error[which])
            self.size[which], self.part[which], self.columns[which], self.sparse = (
                new.size,
                new.part,
                new.columns,
                new.sparse,
            )

    def __call__(self, damping: Array) -> Array:
        if self.sparse is not None:
            jacobian, squared, error = self.sparse
            return np.asarray(
                jacobian.transposed_times(squared.solver(max(float(damping[0]), EPSILON))(error))
            )[None]
        counts = self.size > 0.0
        square = np.where(counts, self.size * self.size + damping[:, None], 1.0)
        return np.asarray(times(self.columns, np.where(counts, self.size / square * self.part, 0.0)))


def constrained(jacobian: Matrix, target: Array, mass: Array, free: Array) -> tuple[Array, Array]:
    """The motion x [c] with G x = wanted and the least (x - free)^T M (x - free), and its multipliers [r]: M
    (x - free) = G^T lambda.

    Where rows depend on one another, lambda is the solution of least norm, and x fits ``wanted`` as well as
    can be. Of dense matrices any number of cases (cases, ...) is solved at once, those of one rank together.
    """
    if isinstance(jacobian, np.ndarray):
        left, size, right = decomposed(jacobian)
        ranks = np.sum(size > RANK_TOLERANCE, axis=-1)
        if ranks.ndim and (ranks != ranks[0]).any():
            motion, multiplier = np.empty_like(free), np.empty_like(target)
            for rank in np.unique(ranks):
                own = ranks == rank
                motion[own], multiplier[own] = constrained(jacobian[own], target[own], mass[own], free[own])
            return motion, multiplier
        rank = int(ranks.flat[0])
        across, along = turned(left[..., :rank]), right[..., :rank, :]
        motion = times(turned(along), times(across, target) / size[..., :rank])
        null = turned(right[..., rank:, :])
        if null.shape[-1]:
            pull = times(turned(null), mass * (free - motion))
            motion = motion + times(
                null, dense.solve(products.product(turned(null), mass[..., None] * null), pull)
            )
        return motion, times(turned(across), times(along, mass * (motion - free)) / size[..., :rank])
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
    """The transposes of matrices."""
    return np.swapaxes(matrix, -1, -2)


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
        image = np.stack([jacobian.transposed_times(one) for one in basis.T], axis=1)
        _, size, turn = dense.svd(image, full=False)
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
    result: list[int] = []
    for rows in jacobian.squared().components():
        here = jacobian.part(rows)
        result += rows[_ends(self_stress(here.toarray() if here.shape[1] <= DENSE else here))].tolist()
    return sorted(result)


def _ends(stress: Array) -> list[int]:
    """The rows at which self-stresses [r, k] end."""
    result: list[int] = []
    left = stress.copy()
    for row in range(len(left) - 1, -1, -1):
        size = products.norm(left[row])
        if size > 1e-6:
            result.append(row)
            along = left[row] / size
            left = left - np.outer(times(left, along), along)
            if len(result) == stress.shape[1]:
                break
    return result[::-1]
