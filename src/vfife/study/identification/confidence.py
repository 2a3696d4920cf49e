"""Confidence of what was fitted, from the derivatives of the residuals at the best point, and what the data cannot tell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .jacobians import Slopes
from .misfit import Misfit
from .sought import Sought

Array = NDArray[np.float64]
WEAK = 1e-12  # of the largest singular value: what is less is nothing


@dataclass(frozen=True)
class Confident:
    """Standard errors and limits in SI units, correlations, directions with their standard deviations in shares of the bounds; the variance of
    residuals and the covariance of shares.
    """

    errors: Array
    limits: list[tuple[float, float]]
    correlation: Array
    directions: list[tuple[float, Array]]
    variance: float
    autocorrelation: float
    covariance: Array


def confident(
    residuals: Sequence[Array], sought: Sequence[Sought], shares: Array, jacobian: Array | None, unknown: int, confidence: float,
    inflation: float = 1.0,
) -> Confident:  # fmt: skip
    """Covariance s^2 (J^T J)^-1 over what J determines, s^2 the residuals' mean square for each degree of freedom, times (1 + r)/(1 - r) where they
    follow one another with a correlation r; limits by Student's t. ``residuals`` are those of each curve, J is by shares of the bounds; ``unknown``
    numbers were fitted in all; ``inflation`` is of the squares, for what they do not know. Without J nothing is known, which is said as NaN.
    """
    count = len(sought)
    if jacobian is None:
        nothing = np.full(count, math.nan)
        return Confident(nothing, [(math.nan, math.nan)] * count, np.full((count, count), math.nan), [], math.nan, math.nan, nothing)
    from scipy.stats import t

    freedom = max(sum(map(len, residuals)) - unknown, 1)
    follow = autocorrelation(residuals)
    variance = sum(float(one @ one) for one in residuals) / freedom * inflation * (1.0 + follow) / (1.0 - follow)
    _, sizes, rows = np.linalg.svd(jacobian, full_matrices=False)
    known = np.maximum(sizes, WEAK * max(float(sizes.max(initial=0.0)), 1e-100))  # whose square is a number
    covariance = variance * (rows.T / known**2) @ rows
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    correlation = covariance / np.maximum(np.outer(spread, spread), 1e-300)
    wide = float(t.ppf(0.5 + 0.5 * confidence, freedom))
    errors = np.array([one.slope(float(x)) * s for one, x, s in zip(sought, shares, spread, strict=True)])
    middle = [one.value(float(x)) for one, x in zip(sought, shares, strict=True)]
    limits = [(value - wide * float(e), value + wide * float(e)) for value, e in zip(middle, errors, strict=True)]
    directions = [(math.sqrt(variance) / float(size), row) for size, row in zip(known[::-1], rows[::-1], strict=True)]
    return Confident(errors, limits, correlation, directions, variance, follow, covariance)


def offset_error(slopes: Slopes | None, told: Confident, misfit: Misfit, along: float) -> float:
    """Standard error of the offset: its own, from how the curves change ``along`` it, and what it follows of the parameters."""
    if misfit.offset.fixed:
        return 0.0
    if slopes is None:
        return math.nan
    own = told.variance / along if along > 0.0 else math.inf
    return math.sqrt(own + max(float(slopes.offsets @ told.covariance @ slopes.offsets), 0.0))


def autocorrelation(residuals: Sequence[Array]) -> float:
    """Mean correlation of residuals with the next, of all curves; between 0 and 0.99."""
    found = []
    for one in residuals:
        apart = one - one.mean()
        square = float(apart @ apart)
        found.append(float(apart[1:] @ apart[:-1]) / square if square > 0.0 else 0.0)
    return min(max(float(np.mean(found)), 0.0), 0.99)
