"""Measured branches of force over penetration as few pieces of cubics, of which no unloading one gives
energy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, TypeAlias

from ..numerics import splines
from ..numerics.scalar import integer_power

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array: TypeAlias = NDArray[np.float64]

MOST_PIECES = 24  # that a step looks through
SAME_PLACE = 1e-9  # of the last penetration: what is not farther apart is one place
CLOSE = 1e-4  # of the largest force: by how much a curve through fewer points may miss the others
Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Branches:
    """Pieces as the kernels have them: begin (m), four coefficients of the branches' mean, four of half their
    distance, constant first.

    ``used`` of ``available`` places of both curves are knots; the curve through these misses a point by
    ``missed`` of the largest force. ``levelled``: by how much of it points were moved so that loading does
    not fall and unloading is not above it. ``end``: the last penetration (m).
    """

    pieces: tuple[tuple[float, ...], ...]
    used: int
    available: int
    missed: float
    levelled: float
    end: float

    def scaled(self, place: float, force: float) -> tuple[tuple[float, ...], ...]:
        """Scale the penetrations and forces of the pieces."""
        if place == force == 1.0:
            return self.pieces
        powers = tuple(force / integer_power(place, k) for k in range(4)) * 2
        return tuple(
            (place * piece[0], *(c * power for c, power in zip(piece[1:], powers, strict=True)))
            for piece in self.pieces
        )


@lru_cache(maxsize=256)
def joined(loading: Points, unloading: Points | None) -> Branches:
    """Build the pieces of two curves of ascending penetrations, each from zero force at zero
    penetration.

    Loading is interpolated by monotone cubics (Fritsch and Carlson), and so is its distance from unloading.
    Monotone cubics stay between their points, so the distance is never negative.
    """
    import numpy as np

    up, down = from_nothing(loading), from_nothing(unloading or loading)
    rising = not_falling(up[1])
    size = float(up[1].max())
    places = np.union1d(up[0], down[0])
    places = places[places <= up[0][-1]]
    places = places[
        np.diff(places, prepend=-1.0) > SAME_PLACE * places[-1]
    ]  # one micrometre written twice may differ in its last bit
    inside = np.minimum(places, down[0][-1])  # beyond its end unloading stays as far below loading
    load = _curve(up[0], rising)
    loss = load(inside) - _curve(*down)(inside)
    half = 0.5 * np.maximum(loss, 0.0) if unloading is not None else np.zeros(len(places))
    levelled = (
        max(
            float(np.abs(rising - up[1]).max()),
            float(-loss.min(initial=0.0)) if unloading is not None else 0.0,
        )
        / size
    )
    chosen, missed = chosen_among(places, np.array([load(places), half]), size)
    at = places[chosen]
    force, ahead = splines.monotone(at.tolist(), load(at).tolist()), float(at[-1] - at[-2])
    distance = splines.monotone(at.tolist(), half[chosen].tolist())
    mean = [
        [a - b for a, b in zip(total, half_distance, strict=True)]
        for total, half_distance in zip(force, distance, strict=True)
    ]
    pieces = [(float(begin), *m, *h) for begin, m, h in zip(at[:-1], mean, distance, strict=True)]
    _, rate, bend, third = force[-1]
    slope, last = rate + ahead * (2.0 * bend + ahead * 3.0 * third), float(half[chosen[-1]])
    if any(
        abs(c) > 0.0 for c in (pieces[-1][3], pieces[-1][4], *pieces[-1][6:])
    ):  # one that is straight goes on by itself
        pieces.append((float(at[-1]), float(load(at[-1:])[0]) - last, slope, 0.0, 0.0, last, 0.0, 0.0, 0.0))
    return Branches(tuple(pieces), len(at), len(places), missed, levelled, float(at[-1]))


def _curve(places: Array, values: Array) -> Callable[[Array], Array]:
    """Interpolate points by monotone cubics."""
    import numpy as np

    starts, rows = places.tolist(), splines.monotone(places.tolist(), values.tolist())
    return lambda at: np.array([splines.value_at(starts, rows, x) for x in at.tolist()])


def from_nothing(points: Points) -> tuple[Array, Array]:
    """Penetrations (m) and forces (N), with one of 0 N at 0 m before the others where there is none."""
    import numpy as np

    place, force = np.array(points, dtype=float).T
    return (
        (place, force)
        if place[0] == 0.0
        else (np.concatenate([[0.0], place]), np.concatenate([[0.0], force]))
    )


def not_falling(values: Array) -> Array:
    """Return the nearest non-decreasing values in the sense of least squares (pool adjacent violators)."""
    import numpy as np

    blocks: list[list[float]] = []
    for value in values.tolist():
        blocks.append([value, 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (low, n), (high, m) = blocks[-2:]
            blocks[-2:] = [[(low * n + high * m) / (n + m), n + m]]
    return np.concatenate([np.full(int(count), value) for value, count in blocks])


def chosen_among(places: Array, curves: Array, size: float) -> tuple[NDArray[np.intp], float]:
    """Choose the points that the cubics interpolate, all of a short table, and return their indices and the
    largest deviation from the others, as a share of ``size``.
    """
    import numpy as np

    if len(places) <= MOST_PIECES + 1:
        return np.arange(len(places)), 0.0
    chosen = [0, len(places) - 1]
    while True:
        at = np.array(sorted(chosen))
        off = np.abs([_curve(places[at], curve[at])(places) - curve for curve in curves]).max(axis=0)
        worst = int(np.argmax(off))
        if off[worst] <= CLOSE * size or len(chosen) > MOST_PIECES:
            return at, float(off[worst] / size)
        chosen.append(worst)
