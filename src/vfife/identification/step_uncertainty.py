"""How far the best point of a fit can be trusted: confidence ranges of its numbers, and their uncertainty due
to step size and start phase.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..results.fit import Fit, Laid, Value
from .batched_queries import Evaluations
from .curves import Curves, Trace
from .measurements import Measured
from .residuals import Fitted, Misfit, Slopes
from .sought import Sought, numbers_at

Array = NDArray[np.float64]
WEAK = 1e-12  # of the largest singular value: what is less is nothing


@dataclass(frozen=True)
class Confident:
    """Standard errors and limits in SI units, correlations, directions with their standard deviations in
    shares of the bounds; the variance of residuals and the covariance of shares.
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
    """Covariance s^2 (J^T J)^-1 over what J determines, s^2 the residuals' mean square for each degree of
    freedom, times (1 + r)/(1 - r) where they follow one another with a correlation r; limits by Student's t.
    ``residuals`` are those of each curve, J is by shares of the bounds; ``unknown`` numbers were fitted in
    all; ``inflation`` is of the squares, for what they do not know. Without J nothing is known, which is said
    as NaN.
    """
    count = len(sought)
    if jacobian is None:
        nothing = np.full(count, math.nan)
        return Confident(
            nothing,
            [(math.nan, math.nan)] * count,
            np.full((count, count), math.nan),
            [],
            math.nan,
            math.nan,
            nothing,
        )
    from scipy.stats import t

    freedom = max(sum(map(len, residuals)) - unknown, 1)
    follow = autocorrelation(residuals)
    variance = (
        sum(float(one @ one) for one in residuals) / freedom * inflation * (1.0 + follow) / (1.0 - follow)
    )
    _, sizes, rows = np.linalg.svd(jacobian, full_matrices=False)
    known = np.maximum(sizes, WEAK * max(float(sizes.max(initial=0.0)), 1e-100))  # whose square is a number
    covariance = variance * (rows.T / known**2) @ rows
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    correlation = covariance / np.maximum(np.outer(spread, spread), 1e-300)
    wide = float(t.ppf(0.5 + 0.5 * confidence, freedom))
    errors = np.array([one.slope(float(x)) * s for one, x, s in zip(sought, shares, spread, strict=True)])
    middle = [one.value(float(x)) for one, x in zip(sought, shares, strict=True)]
    limits = [
        (value - wide * float(e), value + wide * float(e)) for value, e in zip(middle, errors, strict=True)
    ]
    directions = [
        (math.sqrt(variance) / float(size), row) for size, row in zip(known[::-1], rows[::-1], strict=True)
    ]
    return Confident(errors, limits, correlation, directions, variance, follow, covariance)


def offset_error(slopes: Slopes | None, told: Confident, misfit: Misfit, along: float) -> float:
    """Standard error of the offset: its own, from how the curves change ``along`` it, and what it follows of
    the parameters.
    """
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


Limits = list[tuple[float, float]]
# times the change from a step to its half: the error of a step, of first order where contacts begin in it
ORDER = 2.0
LARGE, BESIDE = (
    0.1,
    0.5,
)  # of the deviation of the data, and of what is missed: curves that change by more are not known


@dataclass(frozen=True)
class Doubt:
    """By how much curves change with other steps (``by_steps``) and from the next turn on (``by_turns``),
    over the deviations of the data; what the best point misses (``missed``) and costs (``least``), and the
    largest ``cost`` of it with others; by what shares of the bounds the error of the step may move the
    parameters, to first order (``shift``).
    """

    by_steps: float
    by_turns: float
    missed: float
    least: float
    cost: float
    shift: Array

    @property
    def inflation(self) -> float:
        """By how much the squares grow with other steps or from another turn on, 1 or more."""
        return self.cost / max(self.least, 1e-300)

    @property
    def known(self) -> bool:
        """Whether the curves are the model's own, and not those of its steps or of one turn."""
        return max(self.by_steps, self.by_turns) <= max(LARGE, BESIDE * self.missed)


def doubt(
    curves: Curves, sought: Sequence[Sought], misfit: Misfit, shares: Array, best: Fitted, jacobian: Array
) -> Doubt:
    """That of a point."""
    apart, costs = {"steps": 0.0, "turns": 0.0}, [best.cost]
    shift: Array = np.zeros(len(shares))
    for what, trace in beside(curves, sought, misfit, shares):
        one = misfit(trace, best.offset)
        costs.append(one.cost)
        change = one.residuals - best.residuals
        apart[what] = max(apart[what], float(np.sqrt((change**2).mean())))
        if what == "steps":  # the last has steps of half the size
            shift = np.asarray(ORDER * np.linalg.lstsq(jacobian, change, WEAK)[0], np.float64)
    return Doubt(
        apart["steps"],
        apart["turns"],
        math.sqrt(2.0 * best.cost / misfit.count),
        best.cost,
        max(costs),
        shift,
    )


def beside(
    curves: Curves, sought: Sequence[Sought], misfit: Misfit, shares: Array
) -> Iterator[tuple[str, Trace]]:
    """Traces of the same steps from the next turn on, where nobody knows in which the data began, of steps a
    little finer, and of half of them.
    """
    numbers, turns, every = numbers_at(sought, shares), 1 if misfit.any_turn else 0, curves.timing.every
    for finer in (0, 1, every) if turns else (1, every):
        other = curves.beside(finer, turns)
        (trace,) = other.each([numbers])
        if isinstance(trace, str):
            continue
        if finer:
            yield "steps", trace
        else:
            first = other.timing.outputs
            yield "turns", Trace(trace.places[first:], trace.values[first:], trace.turn)


def widened(
    told: Confident,
    found: Doubt,
    sought: Sequence[Sought],
    best: Array,
    points: Sequence[tuple[float, tuple[float, ...]]],
) -> tuple[Array, Limits]:
    """Errors and limits with the error of the step, and with all points that cost no more than the best one
    with other steps or in another turn.
    """
    alike = np.array([shares for cost, shares in points if cost <= found.cost])
    errors, limits = told.errors.copy(), list(told.limits)
    for k, (one, (low, high)) in enumerate(zip(sought, told.limits, strict=True)):
        if not math.isfinite(told.errors[k]) or not len(alike):
            continue
        error, middle = float(told.errors[k]), 0.5 * (low + high)
        errors[k] = math.hypot(error, one.slope(best[k]) * float(found.shift[k]))
        half = 0.5 * (high - low) * float(errors[k]) / max(error, 1e-300)
        ends = [one.value(float(end)) for end in (alike[:, k].min(), alike[:, k].max())]
        limits[k] = min(middle - half, *ends), max(middle + half, *ends)
        errors[k] *= max(1.0, 0.5 * (limits[k][1] - limits[k][0]) / max(half, 1e-300))
    return errors, limits


UNSETTLED = 0.25  # of what is left, from which on turns that differ are told
WIDER = 1.1  # times the squares of the best point with other steps, from which on that is told
MISSED = 0.25  # of the data's deviation, from which on what is left is told: ± knows of noise alone


@dataclass
class Ended:
    """How searches ended: cost and values of each, whether derivatives were carried along, and notes."""

    searches: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    tangents: bool = False
    notes: list[str] = field(default_factory=list)


def concluded(
    name: str,
    seen: Measured,
    units: Mapping[str, str],
    looked: Evaluations,
    ended: Ended,
    slopes: Slopes | None,
    confidence: float,
) -> Fit:
    """The fit at the best point; without ``slopes`` it was broken off, and nothing is known of its errors."""
    if looked.best is None:  # told before
        raise VfifeError("no member has a motion")
    _, shares, best = looked.best
    one, misfit, sought = best.fitted, looked.misfit, looked.sought
    if one is None:
        raise VfifeError("no member has a motion")
    found = None if slopes is None else doubt(looked.curves, sought, misfit, shares, one, slopes.jacobian)
    nuisance = 2 * int(misfit.proportional.sum()) + (0 if misfit.offset.fixed else 1)
    parts, jacobian = list(misfit.columns(one.residuals).T), None if slopes is None else slopes.jacobian
    told = confident(
        parts,
        sought,
        shares,
        jacobian,
        len(sought) + nuisance,
        confidence,
        1.0 if found is None else found.inflation,
    )
    errors, limits = (
        (told.errors, told.limits) if found is None else widened(told, found, sought, shares, looked.points)
    )
    values = [
        Value(
            s.name, s.paths, s.unit, s.value(float(x)), float(e), float(low), float(high), (s.low, s.high), s.here, s.logarithmic,
            found is None or found.known,
        )
        for s, x, e, (low, high) in zip(sought, shares, errors, limits, strict=True)
    ]  # fmt: skip
    notes = [*ended.notes, *warnings(looked, best.unsettled, found)]
    by = "derivatives of the steps" if ended.tangents else "differences of runs"
    return Fit(
        name, seen.name, "interrupted" if slopes is None else "complete", values, told.correlation, told.directions, where(looked, one),
        offset_error(slopes, told, misfit, one.along), seen.over, curves_of(looked, one, units), sorted(ended.searches), looked.runs,
        len(looked.reasons), by, told.autocorrelation, confidence, time.monotonic() - looked.began, misfit.how, [*notes, *looked.reasons[:3]],
    )  # fmt: skip


def warnings(looked: Evaluations, unsettled: float, found: Doubt | None) -> Iterator[str]:
    """What the errors do not know, or had to be widened for."""
    if unsettled > UNSETTLED * max(looked.share, 1e-3):
        said = (
            "the model's turns do not repeat after those that are skipped (they differ by"
            f" {100.0 * unsettled:.2g} % of the curves' deviations)"
        )
        remedy = "skip more, measure a motion that repeats, or give the offset from the start"
        yield f"{said}: numbers that rule how it settles may be wrong; {remedy}"
    if looked.share > MISSED:
        causes = "much noise, another minimum, a motion that does not repeat, or a model that is wrong"
        yield (
            f"the model misses the data by {100.0 * looked.share:.3g} % of their deviation, by {causes}: of"
            " these the errors know only noise"
        )
    if found is None or found.inflation < WIDER:
        return
    ways = [(found.by_steps, "with other steps"), (found.by_turns, "from the next turn on")]
    size, way = max(ways)
    alike = sum(cost <= found.cost for cost, _ in looked.points)
    what = (
        f"at these numbers the model's own curves differ by {100.0 * size:.2g} % of the data's deviations"
        f" {way}"
    )
    if found.known:
        yield (
            f"{what}: errors and limits are widened by it, {alike} of {len(looked.points)} points fit as well"
        )
    else:
        remedy = (
            "compare envelopes or spectra, measure fewer turns from a known start, or a motion that repeats"
        )
        yield (
            f"{what}, so no confidence is known: {alike} of {len(looked.points)} points fit as well as they;"
            f" {remedy}"
        )


def where(looked: Evaluations, one: Fitted) -> float:
    """The offset; of a free one within a turn."""
    offset = looked.misfit.offset
    span = offset.high if looked.misfit.measured.over == "time" else 2.0 * math.pi
    return one.offset % span if offset.free else one.offset


def curves_of(looked: Evaluations, one: Fitted, units: Mapping[str, str]) -> list[Laid]:
    """Measured and model's curves."""
    misfit, found = looked.misfit, []
    over, places = misfit.places()
    for k, curve in enumerate(misfit.measured.curves):
        factor, level = (float(value) for value in one.gains[:, k])
        unit = units.get(curve.channel, "") if not curve.proportional else "1"
        found.append(
            Laid(
                curve.channel,
                curve.head,
                unit,
                over,
                places,
                misfit.wanted[:, k],
                one.values[:, k],
                factor,
                level,
            )
        )
    return found
