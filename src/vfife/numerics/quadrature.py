"""Gauss' rule of integration between -1 and 1."""

import math
from functools import lru_cache

from .scalar import cos

ROUNDS = 20  # of Newton's method, which squares the error: four or five do


@lru_cache(maxsize=8)
def gauss(count: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Places, ascending, and weights with which ``count`` values integrate polynomials of degree 2 count - 1
    exactly.

    Places are the roots of Legendre's polynomial, by Newton's method from their asymptotic values; those of
    the lower half mirror the upper ones.
    """
    nodes, weights = [0.0] * count, [0.0] * count
    for k in range((count + 1) // 2):
        x = cos(math.pi * (k + 0.75) / (count + 0.5)) if 2 * k + 1 != count else 0.0
        for _ in range(ROUNDS):
            value, slope = _legendre(count, x)
            previous, x = x, x - value / slope
            if x == previous:
                break
        slope = _legendre(count, x)[1]
        nodes[k], nodes[count - 1 - k] = -x, x
        weights[k] = weights[count - 1 - k] = 2.0 / ((1.0 - x) * (1.0 + x) * (slope * slope))
    return tuple(nodes), tuple(weights)


def _legendre(count: int, x: float) -> tuple[float, float]:
    """Value and slope of Legendre's polynomial of a degree, inside -1 and 1."""
    previous, value = 1.0, x
    for k in range(2, count + 1):
        previous, value = value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / k
    return (value, count * (previous - x * value) / ((1.0 - x) * (1.0 + x))) if count else (1.0, 0.0)
