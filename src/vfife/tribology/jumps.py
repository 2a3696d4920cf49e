"""Cycle jumps: what changes slowly from turn to turn is followed by few turns that are simulated, and far
jumps between them.

dh/dN = r(h) with a rate that takes a block of turns to know. A jump is a step of Heun's method, its error the
difference to Euler's,
D/2 |r(h + D r) - r(h)|: of second order in the size D, so the next jump is as long as that error allows
(Hairer, Norsett, Wanner: Solving Ordinary
Differential Equations I, 2nd ed. (1993), Section II.4). Jumps for wear: Mukras, Kim, Sawyer, Jackson,
Bergquist, Wear 266, 822 (2009).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SAFETY, SHRINK, GROW = 0.9, 0.2, 4.0
LEAST = 1.0  # turns of a jump


@dataclass(frozen=True)
class Standing:
    """Where a sequence of jumps is: ``turns``, what changes, ``depth``, and its ``rate`` a turn; how far the
    ``next`` jump may go.

    Of the jump that led here: its ``size`` (turns), its ``error`` in the measure of the tolerance, and how
    many larger ones were ``refused``; ``after`` is the rate at its end as Euler's method has it, so that what
    was between is known to the second order.
    """

    turns: float
    depth: Array
    rate: Array
    next: float
    size: float = 0.0
    error: float = 0.0
    refused: int = 0
    after: Array | None = None


def jumps(
    rate: Callable[[Array], Array],
    here: Standing,
    until: float,
    tolerance: float,
    measure: Callable[[Array], float],
    reach: float,
) -> Iterator[Standing]:
    """Goes from one place to the next, up to so many turns. No jump errs by more than ``tolerance``, nor goes
    further than ``reach``, both as ``measure`` has a change; one of a single turn is taken whatever it errs
    by.
    """
    while here.turns < until * (1.0 - 1e-12):
        left = until - here.turns
        size = min(max(here.next, LEAST), allowed(here.rate, measure, reach), left)
        refused = 0
        while True:
            other = rate(here.depth + size * here.rate)
            error = 0.5 * size * measure(other - here.rate)
            if error <= tolerance or size <= LEAST:
                break
            size, refused = max(LEAST, size * factor(error, tolerance)), refused + 1
        depth = here.depth + 0.5 * size * (here.rate + other)
        turns = until if size == left else here.turns + size
        here = Standing(
            turns, depth, rate(depth), size * factor(error, tolerance), size, error, refused, other
        )
        yield here


def factor(error: float, tolerance: float) -> float:
    """By how much a jump changes after one with an error."""
    return GROW if error <= 0.0 else min(GROW, max(SHRINK, SAFETY * math.sqrt(tolerance / error)))


def allowed(rate: Array, measure: Callable[[Array], float], reach: float) -> float:
    """Turns in which a depth changes by ``reach``."""
    change = measure(rate)
    return reach / change if change > 0.0 else math.inf


def between(before: Standing, share: float, size: float, after: Array) -> Array:
    """Depth at a share of a jump that led from one place with a rate to another, the rate changing evenly."""
    way = share * size
    return np.asarray(
        before.depth + way * before.rate + 0.5 * way * share * (after - before.rate), dtype=float
    )
