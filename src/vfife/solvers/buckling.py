"""Stability of an equilibrium: the sign of its tangent stiffness, from differences of accelerations.

A relaxation comes to rest where forces balance, and a symmetric structure has no reason to leave a straight
path that is no longer stable. Here each free coordinate is displaced in a simulation of its own, along
motions that leave ideal joints closed. The accelerations of one iteration then give the tangent stiffness as
it acts there, with joints, contacts, springs and loads that turn. With coordinates times the square root of
their fictitious mass it is symmetric under loads that have a potential, and its sign is that for any masses.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..compiler.runtime.runner import Runner
from ..numerics.dense import inverse, norm, product, qr

if TYPE_CHECKING:
    from .relaxation import Relaxation

Array = NDArray[np.float64]

MOST_COORDINATES = 600  # more take a second and longer for each load factor
LANES = 256  # simulations side by side, so few that they take little memory
# Accelerations (sizes of the mechanism an iteration, or rad) that show which motions joints permit: their
# squares cancel in pairs of opposite sign, and their cubes are below rounding.
PUSH = 1e-6
# Displacements (sizes, or rad) of single coordinates and of smooth shapes. Rounding of positions is a share
# of 1e-9 of the first; the second bend no element sharply and may be larger.
SINGLE, SMOOTH = 1e-7, 1e-5
# Displacement at contacts as a share of the smallest depth, so that none opens and tangents hardly change.
DEPTH = 0.003
# Softest shapes in which the stiffness is taken again, and inverse iterations that lead to them. A buckling
# shape of n elements has 1/n^4 of the largest stiffness, which differences of single coordinates hardly show.
SHAPES, INVERSE_ITERATIONS = 6, 40
# Error of an eigenvalue over the norms of what measures it: the antisymmetric part, which loads with a
# potential do not have, and the change with twice the displacement.
MARGIN = 4.0
LEAST_ERROR = 1e-14  # rounding of sums, where no difference shows any
# Error from which on it is no rounding: loads that follow the structure, contacts that open. Masses are such
# that the largest stiffness is about 1.
UNKNOWN = 2e-5


def unstable(relaxation: Relaxation) -> bool | None:
    """Return whether the equilibrium at which a ``relaxation`` rests is unstable; None where that is not
    examined: too many coordinates, or loads without a potential. A stiffness of zero, within its error,
    counts as stable. The relaxation is left as it is.
    """
    count = len(relaxation.inverse)
    if count > MOST_COORDINATES:
        return None
    if not count:
        return False
    identity = np.diag(np.ones(count))
    motions = _permitted(relaxation)
    single, smooth = _displacements(relaxation)
    stiffness, error = _stiffness(relaxation, motions, identity, single)
    if not error <= UNKNOWN:
        return None
    tangent = stiffness + identity - 0.5 * (motions + motions.T)  # what joints hold has the stiffness 1
    if not positive(tangent + error * identity):
        return True
    flexible, shapes = inverse(tangent + 2.0 * error * identity), identity[:, :: -(-count // SHAPES)] + PUSH
    for _ in range(INVERSE_ITERATIONS):
        shapes = qr(product(flexible, shapes))[0]
    shapes = product(motions, shapes)
    soft, error = _stiffness(relaxation, shapes, shapes, smooth)
    return not positive(soft + error * np.diag(np.ones(len(soft))))


def _displacements(relaxation: Relaxation) -> tuple[float, float]:
    """Return the displacements (sizes, or rad) of single coordinates and of smooth shapes."""
    depth = relaxation.state[relaxation.layout["contact_penetration"]]
    if not (depth > 0.0).any():
        return SINGLE, SMOOTH
    length = DEPTH * float(depth[depth > 0.0].min()) / relaxation.size
    return min(SINGLE, length), min(SINGLE, length)


def _permitted(relaxation: Relaxation) -> Array:
    """Return the projector on the motions that joints permit, from the accelerations that loads cause."""
    root = np.sqrt(relaxation.state[relaxation.inverse])
    push = PUSH * relaxation.scale / root
    projector: Array = _response(relaxation, relaxation.loads, np.diag(push / root)) / root[:, None] / push
    return projector


def _stiffness(relaxation: Relaxation, shapes: Array, rows: Array, size: float) -> tuple[Array, float]:
    """Return the symmetric stiffness in ``shapes`` as ``rows`` (columns both) take it up, by displacements of
    ``size``, and the error of its eigenvalues.
    """
    root = np.sqrt(relaxation.state[relaxation.inverse])[:, None]
    moved = shapes * root
    amount = size / np.maximum((np.abs(moved) / relaxation.scale[:, None]).max(axis=0), np.finfo(float).tiny)
    simple, double = (
        product(rows.T, -_response(relaxation, relaxation.places, moved * part) / root / part)
        for part in (amount, 2.0 * amount)
    )
    odd = norm((0.5 * (simple - simple.T)).reshape(-1)) + norm((simple - double).reshape(-1))
    return 0.5 * (simple + simple.T), MARGIN * float(odd) + LEAST_ERROR


def positive(matrix: Array) -> bool:
    """Return whether a symmetric matrix is positive definite: all pivots of Gauss's elimination are."""
    rest = matrix.copy()
    for k in range(len(rest)):
        if not rest[k, k] > 0.0:
            return False
        rows = np.flatnonzero(rest[k + 1 :, k]) + k + 1
        column = rest[rows, k]
        rest[np.ix_(rows, rows)] -= column[:, None] * (column / rest[k, k])
    return True


def _response(relaxation: Relaxation, rows: NDArray[np.intp], changes: Array) -> Array:
    """Return half the difference of accelerations for the ``changes`` of ``rows`` (a column for each
    simulation) and for their opposite, shape (coordinates, simulations).
    """
    columns = [changes[:, k : k + LANES] for k in range(0, changes.shape[1], LANES)]
    pairs = [
        _accelerations(relaxation, rows, part) - _accelerations(relaxation, rows, -part) for part in columns
    ]
    return np.concatenate([0.5 * pair for pair in pairs], axis=1)


def _accelerations(relaxation: Relaxation, rows: NDArray[np.intp], changes: Array) -> Array:
    lanes, runner = changes.shape[1], relaxation.runner
    states = np.repeat(relaxation.state[:, None], lanes, axis=1)
    states[relaxation.speeds] = 0.0
    states[relaxation.layout["damping"]] = 0.0
    states[rows] += changes
    functions = np.repeat(runner.functions[None, :], lanes, axis=0)
    trial = Runner(
        relaxation.assembly.topology,
        states,
        functions,
        runner.loop,
        relaxation.pushes.astype(np.uint32),
        parts=1,
    )
    trial.done = runner.done
    trial.advance(1, 1)
    pushes: Array = trial.states[relaxation.pushes]
    return pushes
