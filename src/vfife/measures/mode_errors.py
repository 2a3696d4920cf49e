"""Error of natural frequencies by the mesh: the same vibrations with twice and four times the elements.

Vibrations of two meshes belong together by their shapes and not by their order: with few elements an axial
vibration may be the fifth that is the ninth with more. Masses are lumped, so that frequencies converge from
one side with the square of the elements' size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numerics.dense import product
from ..solvers.refinement import DOUBLE, FOURFOLD, HALF
from .statics import FASTEST, SLOWEST, TWO_MESHES
from .values import Measured

Array = NDArray[np.float64]

SAME_SHAPE = 0.6  # modal assurance criterion from which two shapes are one vibration
# Shapes of one frequency (twins) may be mixed differently on two meshes; they are matched together.
TWIN = 0.01  # relative difference of w^2
# Of an aliased shape, which has the same values at the common nodes, only the lowest frequency counts.
ALIAS = 0.8
# The error that is left on the finest mesh is estimated from two differences and doubled.
SAFETY = 2.0
# A range that ends beyond this multiple of w^2 says nothing, and the error counts as not estimated.
MOST_SQUARE = 4.0
# Rounding of w^2, and differences that replace derivatives of springs and joints.
NUMERICAL = 1e-7


@dataclass(frozen=True, eq=False)
class ModeShapes:
    """Vibrations of one mesh: ``squares`` (1/s^2) [k] in ascending order and ``shapes`` [particles, 3, k] (m,
    m, rad), ``mass`` (kg, kg, kg m^2) [particles, 3] and ``place`` [particles, 2] (m), where a particle is in
    its body, whose number is in ``body`` [particles].
    """

    squares: Array
    shapes: Array
    mass: Array
    place: Array
    body: NDArray[np.intp]

    def nearest(self, other: ModeShapes) -> NDArray[np.intp]:
        """Return the particle of another mesh nearest to each particle, in the same body."""
        result = np.zeros(len(self.place), dtype=np.intp)
        for number in np.unique(self.body):
            numbers, candidates = np.flatnonzero(self.body == number), np.flatnonzero(other.body == number)
            distance = self.place[numbers, None] - other.place[None, candidates]
            result[numbers] = candidates[(distance * distance).sum(axis=2).argmin(axis=1)]
        return result

    def assurance(self, other: ModeShapes) -> Array:
        """Return the modal assurance criterion of each vibration with each of another mesh, [k, other k]
        between 0 and 1, weighted by mass (Allemang and Brown 1982).
        """
        weight = np.sqrt(self.mass)[:, :, None]
        rows = (weight * self.shapes).reshape(-1, len(self.squares))
        columns = (weight * other.shapes[self.nearest(other)]).reshape(-1, len(other.squares))
        rows, columns = (
            values / np.sqrt(np.maximum((values * values).sum(axis=0), np.finfo(float).tiny))
            for values in (rows, columns)
        )
        cosine = product(rows.T, columns)
        return np.asarray(cosine * cosine)

    def counterparts(self, other: ModeShapes) -> list[tuple[float, NDArray[np.intp]] | None]:
        """Return the w^2 (1/s^2) of each vibration on another mesh, and the numbers of its vibrations there;
        None where no shape agrees.
        """
        if not len(other.squares):
            return [None] * len(self.squares)
        return [counterpart(row, other.squares) for row in self.assurance(other)]


def counterpart(assurance: Array, squares: Array) -> tuple[float, NDArray[np.intp]] | None:
    """Return the w^2 of the vibration with the same shape, a mean weighted by ``assurance`` [k] over twins,
    and its numbers; None where no shape agrees.
    """
    first = int(np.flatnonzero(assurance >= ALIAS * assurance.max())[0])
    twins = np.flatnonzero(np.abs(squares - squares[first]) <= TWIN * abs(squares[first]))
    weight = assurance[twins]
    if not weight.sum() >= SAME_SHAPE:
        return None
    return float((weight * squares[twins]).sum() / weight.sum()), twins


def measured_squares(
    base: ModeShapes, by_share: Mapping[float, ModeShapes], exact: bool, largest: float
) -> list[Measured]:
    """Return the w^2 of each vibration with its range from other meshes by their share of the elements; not
    estimated where none has the same shape, or the range says nothing.

    ``exact``: the mechanism has no elements. ``largest`` (1/s^2) is the rounding of w^2.
    """
    matches = {share: base.counterparts(mesh) for share, mesh in by_share.items()}
    result = []
    for k, square in enumerate(base.squares.tolist()):
        floor = max(NUMERICAL * abs(square), largest) if square else 0.0
        values = {share: pair[0] for share, pairs in matches.items() if (pair := pairs[k]) is not None}
        low, high = (square, square) if exact or not square else mesh_range(square, values)
        sufficient = DOUBLE in values and max(high - square, square - low) <= (MOST_SQUARE - 1.0) * abs(
            square
        )
        estimated = exact or not square or sufficient
        result.append(Measured(square, low - floor, high + floor) if estimated else Measured(square))
    return result


def mesh_range(value: float, by_share: Mapping[float, float]) -> tuple[float, float]:
    """Return the range of a value from those with other shares of the elements.

    Three values in the order of their meshes continue as a geometric series, whose ratio lies between FASTEST
    and SLOWEST. Where they change in one direction the range extends to the finest value, and beyond it by
    SAFETY times the rest of the series; else by as much on both sides.
    """
    if DOUBLE not in by_share:
        return value, value
    if FOURFOLD in by_share:
        first, second, third = value, by_share[DOUBLE], by_share[FOURFOLD]
    elif HALF in by_share:
        first, second, third = by_share[HALF], value, by_share[DOUBLE]
    else:
        error = TWO_MESHES * abs(by_share[DOUBLE] - value)
        return value - error, value + error
    coarse, fine = second - first, third - second
    ratio = min(max(abs(fine / coarse) if coarse else SLOWEST, FASTEST), SLOWEST)
    rest = max(abs(fine) * ratio / (1.0 - ratio), abs(coarse) * FASTEST * FASTEST / (1.0 - FASTEST))
    if coarse * fine <= 0.0:
        error = abs(third - value) + abs(coarse) + SAFETY * rest
        return value - error, value + error
    return (value, third + SAFETY * rest) if fine > 0.0 else (third - SAFETY * rest, value)


def frequency_of(square: Measured) -> Measured:
    """Return the frequency (Hz) of a w^2 (1/s^2) with its range; 0 of one that is negative."""
    value, low, high = (
        math.sqrt(max(end, 0.0)) / (2.0 * math.pi) for end in (square.value, square.low, square.high)
    )
    return Measured(value, low, high) if square.estimated else Measured(value)


def missing(base: ModeShapes, double: ModeShapes) -> int:
    """Return how many vibrations with twice the elements lie below the last one and have none of their shape:
    those that these elements cannot show.
    """
    pairs = base.counterparts(double)
    matched = {int(number) for pair in pairs if pair is not None for number in pair[1]}
    lower = np.flatnonzero(double.squares < base.squares.max(initial=0.0))
    return len(set(lower.tolist()) - matched)
