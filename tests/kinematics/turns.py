"""Extremes over a turn: found among points far apart, and looked at closely where they are."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np


def parabola(left: float, middle: float, right: float) -> tuple[float, float]:
    """Top of the parabola through three values at -1, 0 and 1: where it is, and how high."""
    bend = left - 2.0 * middle + right
    return (left - right) / (2.0 * bend), middle - (right - left) ** 2 / (8.0 * bend)


def extremes(at: Callable[[float, Any], tuple[Sequence[float], Any]], points: int = 48) -> np.ndarray:
    """Least and largest of each number, shape (2, numbers); ``at(angle, guess)`` gives them and the position
    that is the next guess.
    """
    angles, rows, places, guess = np.linspace(0.0, 2.0 * np.pi, points, endpoint=False), [], [], None
    for angle in angles:
        row, guess = at(angle, guess)
        rows.append(row)
        places.append(guess)
    coarse = np.array(rows)
    found = np.empty((2, coarse.shape[1]))
    for number, values in enumerate(coarse.T):
        for which, sign in enumerate((-1.0, 1.0)):
            k = int(np.argmax(sign * values))
            where, apart, three = angles[k], angles[1], values[[k - 1, k, (k + 1) % points]]
            for _ in range(2):
                where += apart * parabola(*three)[0]
                apart /= 8.0
                three = [at(where + apart * side, places[k])[0][number] for side in (-1, 0, 1)]
            found[which, number] = parabola(*three)[1]
    return found
