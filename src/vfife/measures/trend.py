"""Trend of the turns of a motion that settles: their distances fall, steadily or alternating in sign.

Points are the numbers of one turn each: a section of the motion, or the largest values of a run's turn with
the state at its end. Runs and maps have the same criteria.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import exp, log

Array = NDArray[np.float64]

# A motion is settling if over its last turns the logarithm of the distance of two turns has at least this
# correlation with their number, and the distance falls at least by this factor.
TREND = 24
FALLING = -0.9
FALLEN = 0.7
# Distances in the later half of a run, and the factor of their fall, that show settling after a transient: of
# six numbers in random order the logarithms correlate so strongly once in 200.
FEWEST_LATE, LATE_FALL = 6, 0.5
# Distances of turns in which a motion that alternates is recognised, and the least ratio of their decay in
# the second half to that in all: of a period of several turns they become constant when its transient ends.
FEWEST_ALTERNATIONS, STEADY_DECAY = 7, 0.5
# Three distances are too few for a correlation; they show a decay if each is smaller and the last is this
# share of the first.
SHORT_DECAY, DECAYED = 3, 0.1


class Points(NamedTuple):
    """A point for each turn, shape (turns, coordinates), and the size with which each is compared."""

    values: Array
    sizes: Array


def alternation(points: Points, period: int) -> tuple[float, float] | None:
    """Return the last distance (1) of turns a part of a ``period`` apart, and the share (1) by which it
    shrinks a turn; None if it does not shrink, because the period is one.

    Near the end of a motion's stability its deviation changes its sign every turn and decays slowly, so that
    turns two apart agree long before successive turns do.
    """
    sizes = np.where(points.sizes > 0.0, points.sizes, 1.0)
    for part in (shift for shift in range(1, period) if period % shift == 0):
        distances = (np.abs(points.values[part:] - points.values[:-part]) / sizes).max(axis=1)
        distances = distances[-max(FEWEST_ALTERNATIONS, len(distances) // 2) :]
        count = len(distances)
        if count < FEWEST_ALTERNATIONS or not settles(distances.tolist()):
            continue
        fall, late = (log(distances[-1] / distances[k]) / (count - 1 - k) for k in (0, count // 2))
        if late < STEADY_DECAY * fall:
            return float(distances[-1]), 1.0 - float(exp(fall))
    return None


def settles_late(distances: Sequence[float]) -> bool:
    """Return whether the later half of distances falls steadily and to less than half, after a transient in
    which turns had nothing in common.
    """
    late = distances[-(len(distances) // 2) - 1 :]
    return len(late) > FEWEST_LATE and settles(late, LATE_FALL)


def settles(distances: Sequence[float], fallen: float = FALLEN) -> bool:
    """Return whether distances fall steadily, by a least-squares line through their logarithms, and at least
    by the factor ``fallen``.
    """
    values = np.array(distances[1:] if len(distances) > 4 else distances)  # without that of the start
    if len(values) == SHORT_DECAY:
        return bool(values[0] > values[1] > values[2] > 0.0 and values[2] < DECAYED * values[0])
    if len(values) < 4 or not (np.isfinite(values) & (values > 0.0)).all():
        return False
    # Two conditions: the correlation with time is clearly negative, and the whole fall is large enough. A
    # chaotic motion easily meets one of them by chance.
    logarithms = log(values)
    if np.ptp(logarithms) == 0.0:
        return False
    at, off = np.arange(len(values)) - 0.5 * (len(values) - 1), logarithms - logarithms.mean()
    product, wide, high = (float(terms.sum()) for terms in (at * off, at * at, off * off))
    return product < FALLING * math.sqrt(wide * high) and product / wide * (len(values) - 1) < log(fallen)
