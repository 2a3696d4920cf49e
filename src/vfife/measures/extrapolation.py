"""Error of a measure, from its values at several step sizes.

An error C h^p at the step h makes values at h and r h differ by C h^p (r^p - 1). The order p is estimated
from the values if they change monotonically with the step, and the error at the finest step is that
difference over r^p - 1, times a factor of safety (Richardson's extrapolation and the grid convergence index:
P. J. Roache, Perspective: a method for uniform reporting of grid refinement studies, J. Fluids Eng. 116
(1994), 405-413). Contacts begin within a step, so the order is about one and is never taken to be larger. If
values scatter, no order can be observed, and the error is estimated from their scatter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from ..numerics.scalar import power

# Factor of safety of Roache's grid convergence index for three or more grids. Measured on 250 mechanisms with
# contact (tests/loose_sample.py): without it 94 % of the ranges hold the value at a twentieth of the step,
# with it and the three numbers of orders and scatter 99.5 %.
SAFETY = 1.25
# An order below a half cannot be told from a scatter of four values.
LOWEST_ORDER, HIGHEST_ORDER = 0.5, 1.0
# Times the width of values that scatter.
SCATTER = 2.0
# Times the width of all values of a sensitive run and of its tries with larger steps, twelve mostly. Measured
# in 21 such runs (four-bars, slider-cranks, compressors) with 3, 5 and 8 times as many steps: 96.0 % of 3301
# values lie in the ranges of the run alone, 98.8 % with the values of the tries, 99.1 % with this.
SCATTER_OF_TRIES = 0.25
# Means over turns of a motion that is not periodic differ by chance, and their mean is what is reported. Of
# four normal values with the deviation s, the mean lies with 99 % within 5.84 s / 2 of the truth (Student's
# t, three degrees of freedom), and they are 2.06 s wide in the mean: 0.92 widths beyond them to each side.
SCATTER_OF_MEANS, LANES_OF_MEANS = 1.0, 4
# Largest correlation of successive turns that a few turns can show.
LARGEST_CORRELATION = 0.9
# 97.5 % of normal values are below it, and of Student's t with one and two degrees of freedom below these.
NORMAL_QUANTILE = 1.959964
QUANTILES_OF_FEW = {1: 12.7062, 2: 4.30265}
# Share of a value that its error is not told below: extremes are taken at whole steps, and four values may
# agree by chance.
LEAST_ERROR = 1e-4
# One contact more or less: whether a journal grazes its bearing once more may escape all step sizes.
LEAST_COUNT = 1.0
COUNTS = (".impacts", ".grazing", ".deep_landings")
# How deep the first step of a contact lands is the step's doing: it goes to zero with it.
VANISHING = (".landing_depth.max", ".deep_landings")
# Friction is not among them: bristles return energy. For other laws see event_ranges.friction_losses.
NEVER_NEGATIVE = (
    ".max", *COUNTS, ".share.free_flight", ".share.impact", ".share.continuous_contact",
    ".impact_energy.total", ".impact_power.mean", ".sliding_distance.total", ".pressure_velocity.mean",
    "_wear.total",
)  # fmt: skip
BISECTIONS = 40


def error_range(name: str, ratios: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """Return the range that estimates the limit of a measure for vanishing steps.

    ``ratios`` (1): step sizes in any unit, of which at least two differ; ``values``: the measure ``name`` at
    these. The range exceeds the values on both sides by at least their own range.
    """
    low, high = min(values), max(values)
    error = error_factor(ratios, values) * (high - low)
    error = max(error, LEAST_ERROR * max(abs(low), abs(high)))
    if name.endswith(COUNTS):
        error = max(error, LEAST_COUNT)
    return widen(name, low, high, error)


def widen(name: str, low: float, high: float, error: float) -> tuple[float, float]:
    """Widen a range of the measure ``name`` by an error to both sides, not below zero where it cannot be
    negative.
    """
    floor = 0.0 if name.endswith(VANISHING) else low - error
    return (max(floor, min(0.0, low)) if name.endswith(NEVER_NEGATIVE) else floor), high + error


def error_factor(ratios: Sequence[float], values: Sequence[float]) -> float:
    """Estimate the error of the value at the finest step, over the width of all values (1); at least one."""
    order = observed_order(ratios, values)
    if order is None:
        return SCATTER
    largest, order = max(ratios) / min(ratios), min(max(order, LOWEST_ORDER), HIGHEST_ORDER)
    return max(1.0, SAFETY / (power(largest, order) - 1.0))


def observed_order(ratios: Sequence[float], values: Sequence[float]) -> float | None:
    """Return the order with which values converge, from the finest, the next and the coarsest step; between
    zero and three.

    None if the values do not change monotonically, or fewer than three steps differ.
    """
    pairs = sorted(zip(ratios, values, strict=True))
    steps, ordered = [step / pairs[0][0] for step, _ in pairs], [value for _, value in pairs]
    rises = [second - first for first, second in pairwise(ordered)]
    if (
        len(set(steps)) < 3
        or ordered[-1] == ordered[0]
        or not (all(rise >= 0.0 for rise in rises) or all(rise <= 0.0 for rise in rises))
    ):
        return None
    share = (ordered[1] - ordered[0]) / (ordered[-1] - ordered[0])
    low, high = 1e-3, 3.0
    for _ in range(BISECTIONS):  # the share falls as the order grows
        middle = 0.5 * (low + high)
        if (power(steps[1], middle) - 1.0) / (power(steps[-1], middle) - 1.0) > share:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def error_of_mean(lanes: Sequence[Sequence[float]]) -> float:
    """Return by how much the mean over the turns of another run differs at most, with 95 %, from the mean
    over all ``lanes``, the values of the turns of each; zero with fewer than two turns.

    Of N turns with the variance s^2, successive ones of which have a correlation r, the mean has the variance
    s^2/N (1 + r)/(1 - r). The mean over n lanes adds an n-th of that.
    """
    values = [value for lane in lanes for value in lane]
    turns = len(values) / max(len(lanes), 1)
    mean = math.fsum(values) / max(len(values), 1)
    changes = [[value - mean for value in lane] for lane in lanes]
    squares = math.fsum(change * change for lane in changes for change in lane)
    if turns < 2.0 or squares == 0.0:
        return 0.0
    products = math.fsum(first * second for lane in changes for first, second in pairwise(lane))
    correlation = min(max(products / squares * turns / (turns - 1.0), 0.0), LARGEST_CORRELATION)
    growth = min((1.0 + correlation) / (1.0 - correlation), turns)
    freedom = max(len(values) / growth - 1.0, 1.0)
    variance = squares / (len(values) - 1) * growth / turns * (1.0 + 1.0 / len(lanes))
    return student_quantile(max(freedom, len(lanes) - 1.0)) * math.sqrt(variance)


def student_quantile(freedom: float) -> float:
    """Return the value below which 97.5 % of Student's t lie, within 1 % from three degrees of freedom on;
    below three that of the next smaller whole number of them, which is larger.

    Expansion by the reciprocal of the ``freedom`` (Abramowitz and Stegun: Handbook of Mathematical Functions,
    26.7.5), which needs no function of a library. It does not converge below three.
    """
    if freedom < 3.0:
        return QUANTILES_OF_FEW[max(int(freedom), 1)]
    z, v = NORMAL_QUANTILE, freedom
    square = z * z
    first = z * (square + 1.0) / 4.0
    second = z * ((5.0 * square + 16.0) * square + 3.0) / 96.0
    third = z * (((3.0 * square + 19.0) * square + 17.0) * square - 15.0) / 384.0
    return z + (first + (second + third / v) / v) / v
