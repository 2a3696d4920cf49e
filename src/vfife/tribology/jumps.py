"""Cycle jumps: integrate a quantity that changes slowly from turn to turn, with few simulated turns and long
jumps between them.

The equation is dh/dN = r(h); the rate r costs the simulation of a block of turns. A jump over D turns is a
step of Heun's method. Its error is estimated by the difference to Euler's method, D/2 |r(h + D r) - r(h)|,
which is of second order in D; the next jump is as long as that error allows (Hairer, Norsett, Wanner: Solving
Ordinary Differential Equations I, 2nd ed. (1993), Section II.4). A method of higher order would need more
rates for each jump, and rates have scatter. Jumps for wear: Mukras, Kim, Sawyer, Jackson, Bergquist, Wear
266, 822 (2009).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Control of the size: safety factor of the error, and the limits by which the size changes at once.
SAFETY, SHRINK, GROW = 0.9, 0.2, 4.0
SHORTEST_JUMP = 1.0  # turns of the shortest jump


@dataclass(frozen=True)
class Standing:
    """A point of a sequence of jumps: ``turns`` so far, the ``depth`` that changes (any array), its ``rate``
    per turn, and the size (turns) that the ``next`` jump may have.

    Of the jump that led here: its ``size`` (turns), its ``error`` in the measure of the tolerance, and the
    number of larger jumps that were ``refused``. ``end_rate`` is the rate at the end of Euler's step; with it
    the depth inside the jump is known to second order (:func:`between`).
    """

    turns: float
    depth: Array
    rate: Array
    next: float
    size: float = 0.0
    error: float = 0.0
    refused: int = 0
    end_rate: Array | None = None


def jumps(
    rate: Callable[[Array], Array],
    point: Standing,
    end_turns: float,
    tolerance: float,
    measure: Callable[[Array], float],
    reach: float,
) -> Iterator[Standing]:
    """Yield the points after ``point`` up to ``end_turns`` turns.

    ``rate`` returns the change per turn at a depth. ``measure`` returns the size of a change; in that measure
    no jump has an error above ``tolerance`` or a change above ``reach``. A jump of a single turn is accepted
    with any error.
    """
    while point.turns < end_turns * (1.0 - 1e-12):
        left = end_turns - point.turns
        size = min(max(point.next, SHORTEST_JUMP), allowed(point.rate, measure, reach), left)
        refused = 0
        while True:
            # Euler's step and the rate at its end: half the change of the rate is the error of Euler's step,
            # and the correction that makes it Heun's.
            end_rate = rate(point.depth + size * point.rate)
            error = 0.5 * size * measure(end_rate - point.rate)
            if error <= tolerance or size <= SHORTEST_JUMP:
                break
            size, refused = max(SHORTEST_JUMP, size * factor(error, tolerance)), refused + 1
        depth = point.depth + 0.5 * size * (point.rate + end_rate)
        turns = end_turns if size == left else point.turns + size
        point = Standing(
            turns, depth, rate(depth), size * factor(error, tolerance), size, error, refused, end_rate
        )
        yield point


def factor(error: float, tolerance: float) -> float:
    """Return the factor of the size after a jump with an ``error``: the square root of tolerance over error,
    because the error is of second order in the size.
    """
    return GROW if error <= 0.0 else min(GROW, max(SHRINK, SAFETY * math.sqrt(tolerance / error)))


def allowed(rate: Array, measure: Callable[[Array], float], reach: float) -> float:
    """Return the turns in which the depth changes by ``reach`` at its present ``rate``."""
    change = measure(rate)
    return reach / change if change > 0.0 else math.inf


def depth_within(point: Standing, share: float, size: float, end_rate: Array) -> Array:
    """Return the depth at a ``share`` (1) of a jump over ``size`` turns from ``point``, the rate changing
    linearly to ``end_rate``.
    """
    way = share * size
    return np.asarray(
        point.depth + way * point.rate + 0.5 * way * share * (end_rate - point.rate), dtype=float
    )
