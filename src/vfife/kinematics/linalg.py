"""Linear algebra of constraints that may depend on one another: least steps, motions nearest a wish, and self-stresses.

G [r, c] is dense (one singular value decomposition) up to 90 columns, and sparse beyond: factors of G G^T + epsilon, refined.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Matrix = Any  # a dense array, or a sparse one of SciPy

RANK_TOLERANCE = 1e-7  # a dead centre is only met to the root of round-off, so it must be judged this loosely
DENSE = 90  # columns: beyond some 30 bodies sparse factors are faster
EPSILON = 1e-12  # of the largest pivot: well under the squares of singular values that count, well over their round-off
SOFT = 1e-9  # the same where the solution is refined: self-stress from round-off stays under 1e-7 of the reactions
REFINEMENTS = 30


def matrix(values: list[float], rows: list[int], columns: list[int], shape: tuple[int, int]) -> Matrix:
    """G from its entries, which may repeat."""
    if shape[1] <= DENSE:
        dense = np.zeros(shape)
        np.add.at(dense, (rows, columns), values)
        return dense
    from scipy.sparse import csr_array

    return csr_array((values, (rows, columns)), shape=shape)


def weighted(weight: Array, jacobian: Matrix) -> Matrix:
    """diag(weight) G."""
    if isinstance(jacobian, np.ndarray):
        return weight[:, None] * jacobian
    from scipy.sparse import diags_array

    return (diags_array(weight) @ jacobian).tocsr()


def damped_step(jacobian: Matrix, error: Array) -> Callable[[float], Array]:
    """The function damping -> (G^T G + damping)^-1 G^T error, of least norm; directions that no row sees are left alone."""
    if isinstance(jacobian, np.ndarray):
        left, size, right = np.linalg.svd(jacobian, full_matrices=False)
        kept = size > RANK_TOLERANCE
        size, part, rows = size[kept], left[:, kept].T @ error, right[kept].T
        return lambda damping: np.asarray(rows @ (size / (size**2 + damping) * part))
    squared = jacobian @ jacobian.T
    return lambda damping: np.asarray(jacobian.T @ _factors(squared, max(damping, EPSILON))(error))


def constrained(jacobian: Matrix, wanted: Array, mass: Array, free: Array) -> tuple[Array, Array]:
    """The motion x [c] with G x = wanted and the least (x - free)^T M (x - free), and its multipliers [r]: M (x - free) = G^T lambda.

    Where rows depend on one another lambda is the solution of least norm, and x fits ``wanted`` as well as can be.
    """
    if isinstance(jacobian, np.ndarray):
        left, size, right = np.linalg.svd(jacobian)
        rank = int(np.sum(size > RANK_TOLERANCE))
        inverse, null = right[:rank].T @ (left[:, :rank] / size[:rank]).T, right[rank:].T
        motion = inverse @ wanted
        motion = motion + null @ np.linalg.solve(null.T @ (mass[:, None] * null), null.T @ (mass * (free - motion)))
        return motion, inverse.T @ (mass * (motion - free))
    from scipy.sparse import diags_array

    squared = (jacobian @ diags_array(1.0 / mass) @ jacobian.T).tocsc()
    left_over = wanted - jacobian @ free
    solve, multiplier = _factors(squared, SOFT * float(squared.diagonal().max(initial=1e-300))), np.zeros(len(wanted))
    finest = 1e-15 * max(np.abs(wanted).max(initial=0.0), np.abs(free).max(initial=0.0))
    for _ in range(REFINEMENTS):
        missing = left_over - squared @ multiplier
        if np.abs(missing).max(initial=0.0) <= finest:
            break
        multiplier += solve(missing)
    return free + (jacobian.T @ multiplier) / mass, multiplier


def shared_out(jacobian: Matrix, mobility: Array, multiplier: Array) -> Array:
    """Multipliers [r] that load the bodies alike, of least norm, each weighed by its row's own diagonal of G M^-1 G^T, as a step weighs reactions.

    ``mobility`` [c]: the diagonal of M^-1, 0 for what is driven. Multipliers that nothing leaves open stay as they are.
    """
    stress = self_stress(jacobian)
    if not stress.shape[1]:
        return multiplier
    squares = jacobian**2 if isinstance(jacobian, np.ndarray) else jacobian.multiply(jacobian)
    weight = np.asarray(squares @ mobility).ravel()
    norm = stress.T @ (weight[:, None] * stress)
    return np.asarray(multiplier - stress @ np.linalg.lstsq(norm, stress.T @ (weight * multiplier), rcond=None)[0])


def self_stress(jacobian: Matrix) -> Array:
    """Orthonormal multipliers [r, k] that load nothing, G^T N = 0: one for each row that depends on the others."""
    count = jacobian.shape[0]
    if count == 0:
        return np.zeros((0, 0))
    if isinstance(jacobian, np.ndarray):
        left, size, _ = np.linalg.svd(jacobian)
        return np.asarray(left[:, int(np.sum(size > RANK_TOLERANCE)) :])
    solve = _factors(jacobian @ jacobian.T, EPSILON)
    columns = 8
    while 4 * columns < count:  # inverse iteration with as many vectors as it takes to see one that is no self-stress
        basis = np.cos(np.arange(1, count + 1)[:, None] * np.arange(1, columns + 1) ** 2)
        for _ in range(4):
            basis = np.linalg.qr(solve(basis))[0]
        _, size, turn = np.linalg.svd(jacobian.T @ basis, full_matrices=False)
        if size[0] > RANK_TOLERANCE:
            return np.asarray(basis @ turn[size <= RANK_TOLERANCE].T)
        columns *= 4
    return self_stress(jacobian.toarray())


def dependent_rows(jacobian: Matrix) -> list[int]:
    """Rows that follow from those before them, found part by part where G falls apart into loops that share no body."""
    if isinstance(jacobian, np.ndarray):
        return _ends(self_stress(jacobian))
    from scipy.sparse.csgraph import connected_components

    parts, part_of = connected_components(jacobian @ jacobian.T, directed=False)
    found: list[int] = []
    for part in range(parts):
        rows = np.flatnonzero(part_of == part)
        here = jacobian[rows]
        columns = np.unique(here.indices)
        here = here[:, columns]
        found += rows[_ends(self_stress(here.toarray() if len(columns) <= DENSE else here))].tolist()
    return sorted(found)


def _ends(stress: Array) -> list[int]:
    """The rows at which self-stresses [r, k] end."""
    found: list[int] = []
    left = stress.copy()
    for row in range(len(left) - 1, -1, -1):
        size = float(np.linalg.norm(left[row]))
        if size > 1e-6:
            found.append(row)
            along = left[row] / size
            left = left - np.outer(left @ along, along)
            if len(found) == stress.shape[1]:
                break
    return found[::-1]


def _factors(squared: Matrix, added: float) -> Callable[[Array], Array]:
    from scipy.sparse import eye_array
    from scipy.sparse.linalg import splu

    lower = splu(
        (squared + added * eye_array(squared.shape[0])).tocsc(),
        permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True},
    )  # fmt: skip
    return lambda right: np.asarray(lower.solve(right))
