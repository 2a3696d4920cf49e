"""Singular positions of mechanisms with redundant joints, between the positions that a follower visits.

The determinant of independent rows has a factor for each loop. In parallel cranks the factors of two loops
vanish together, and the sign of the determinant stays. The smallest singular value of all rows is zero there
and nowhere else, so its local minima are searched.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..numerics import dense

if TYPE_CHECKING:
    from .follower import Follower

Array = NDArray[np.float64]

GOLDEN = 0.6180339887498949
SEARCHES = 24  # golden sections: they narrow an interval by 1e-5
# Share of the neighbouring values below which a minimum is zero. A singular value falls linearly towards a
# singular position, so that the searches end far below.
ZERO_SHARE = 1e-3
RANK = 1e-6  # singular value below which rows are dependent, as in Follower.of


@dataclass(frozen=True, eq=False)
class Visit:
    """A closed position [n, 3] at a ``place`` of a way, with dq/ds [n, 3] as its ``velocity``, and the
    smallest singular value of all rows.
    """

    place: float
    position: Array
    velocity: Array
    smallest: float


def visit(follower: Follower, place: float, position: Array, velocity: Array, aims: Array) -> Visit:
    """Return the visit of a position."""
    return Visit(place, position, velocity, float(dense.singular_values(_rows(follower, position, aims))[-1]))


def singular_between(
    follower: Follower, visits: Sequence[Visit], aims: Callable[[float], Array]
) -> list[tuple[float, Array]]:
    """Return the places between the first and the last visit where all rows lose a rank, each with its
    self-stress [rows]: absolute multipliers, the largest being 1.
    """
    result = []
    for first, middle, last in zip(visits, visits[1:], visits[2:], strict=False):
        if not (first.smallest > middle.smallest <= last.smallest):
            continue
        place, value = _minimum(follower, first, last, aims)
        if value <= ZERO_SHARE * max(first.smallest, last.smallest):
            result.append(
                (place, _stress(follower, _between(follower, first, last, aims, place), aims(place)))
            )
    return result


def _minimum(
    follower: Follower, first: Visit, last: Visit, aims: Callable[[float], Array]
) -> tuple[float, float]:
    """Return the place of the least singular value between two visits, and the value, by golden sections."""

    def at(place: float) -> float:
        position = _between(follower, first, last, aims, place)
        return float(dense.singular_values(_rows(follower, position, aims(place)))[-1])

    low, high = first.place, last.place
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = at(left), at(right)
    for _ in range(SEARCHES):
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = at(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = at(right)
    return (left, at_left) if at_left <= at_right else (right, at_right)


def _between(
    follower: Follower, first: Visit, last: Visit, aims: Callable[[float], Array], place: float
) -> Array:
    """Return the position [n, 3] at a place between two visits: Hermite's cubic, closed where Newton's method
    closes it. Next to a singular position the cubic alone is as near.
    """
    width = last.place - first.place
    x = (place - first.place) / width
    y = 1.0 - x
    guess = (
        (1.0 + 2.0 * x) * y * y * first.position
        + x * y * y * width * first.velocity
        + x * x * (3.0 - 2.0 * x) * last.position
        - x * x * y * width * last.velocity
    )
    closed = follower.closed(guess, aims(place))
    return guess if closed is None else closed[0]


def _stress(follower: Follower, position: Array, aims: Array) -> Array:
    """Return the size [rows] of each row's part in all self-stresses of a position, the largest being 1."""
    rows = _rows(follower, position, aims)
    left, sizes, _ = dense.svd(rows)
    rank = int(np.sum(sizes > max(RANK, 10.0 * float(sizes[-1]))))
    stress = np.sqrt((left[:, rank:] * left[:, rank:]).sum(axis=1))
    result: Array = stress / stress.max()
    return result


def _rows(follower: Follower, position: Array, aims: Array) -> Array:
    """Return all rows of a position in the coordinates that joints feel."""
    result: Array = follower.system.dense_rows(position, aims)[1][:, follower.columns]
    return result
