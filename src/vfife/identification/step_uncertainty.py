"""Uncertainty of identified parameters: confidence limits, and how far step size and unknown start phase of
the data change them.

Least squares assumes that the simulated curves are exact. For a periodic motion they nearly are. For a
chaotic motion they depend on the step size and on the turn with which the comparison starts, and the best fit
may agree with the data by chance. This module repeats the best point with finer steps and from the next turn,
and reports how much curves, cost and parameters change.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..results.fit import Fit, FitCurve, FitValue
from .batched_queries import Evaluations
from .curves import Curves, Trace
from .parameters import FitParameter, numbers_at
from .residuals import Fitted, Misfit, Slopes

Array = NDArray[np.float64]
Limits = list[tuple[float, float]]
# Singular values below this share of the largest are treated as zero.
RANK_TOLERANCE = 1e-12
# The error of a step is about twice the change to half the step, because contact onsets make the method first
# order.
ERROR_OVER_CHANGE = 2.0
# Curves are trusted if they change by less than a tenth of the data's standard deviation, or by less than
# half of the residual.
TRUSTED_CHANGE, TRUSTED_SHARE_OF_RESIDUAL = 0.1, 0.5
# From these on cautions are reported: turns that differ by this share of the residual, squares that grow by
# this factor with other steps, and a
# residual of this share of the data's standard deviation, because limits know only noise.
UNSETTLED, INFLATED, UNEXPLAINED = 0.25, 1.1, 0.25


@dataclass(frozen=True)
class Confidence:
    """Standard errors and limits (SI), correlations, directions with their standard deviations in shares of
    the bounds.

    ``variance`` of the residuals, their ``autocorrelation``, and the ``covariance`` of the shares.
    """

    errors: Array
    limits: Limits
    correlation: Array
    directions: list[tuple[float, Array]]
    variance: float
    autocorrelation: float
    covariance: Array


def confidence_of(
    residuals: Sequence[Array], parameters: Sequence[FitParameter], shares: Array, jacobian: Array | None,
    unknowns: int, level: float,
    inflation: float = 1.0,
) -> Confidence:  # fmt: skip
    """Confidence in parameters at ``shares`` of the ways between their bounds.

    The covariance is s^2 (J^T J)^-1 over what J determines, s^2 the residuals' mean square for each degree of
    freedom, times (1 + r)/(1 - r) where successive ones have a correlation r; limits are those of Student's
    t. ``residuals`` are those of each curve, J is by shares; so many ``unknowns`` were fitted; ``inflation``
    is a factor of s^2. Without J all is unknown (NaN).
    """
    count = len(parameters)
    if jacobian is None:
        unknown = np.full(count, math.nan)
        pairs = np.full((count, count), math.nan)
        return Confidence(unknown, [(math.nan, math.nan)] * count, pairs, [], math.nan, math.nan, unknown)
    from scipy.stats import t

    freedom = max(sum(map(len, residuals)) - unknowns, 1)
    r = autocorrelation(residuals)
    variance = sum(float(one @ one) for one in residuals) / freedom * inflation * (1.0 + r) / (1.0 - r)
    _, sizes, rows = np.linalg.svd(jacobian, full_matrices=False)
    sizes = np.maximum(
        sizes, RANK_TOLERANCE * max(float(sizes.max(initial=0.0)), 1e-100)
    )  # so that its square is a number
    covariance = variance * (rows.T / sizes**2) @ rows
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    correlation = covariance / np.maximum(np.outer(spread, spread), 1e-300)
    quantile = float(t.ppf(0.5 + 0.5 * level, freedom))
    errors = np.array([one.slope(float(x)) * s for one, x, s in zip(parameters, shares, spread, strict=True)])
    values = [one.value(float(x)) for one, x in zip(parameters, shares, strict=True)]
    limits = [
        (value - quantile * float(e), value + quantile * float(e))
        for value, e in zip(values, errors, strict=True)
    ]
    directions = [
        (math.sqrt(variance) / float(size), row) for size, row in zip(sizes[::-1], rows[::-1], strict=True)
    ]
    return Confidence(errors, limits, correlation, directions, variance, r, covariance)


def offset_error(slopes: Slopes | None, confidence: Confidence, misfit: Misfit, along: float) -> float:
    """Standard error of the offset: its own, from how the curves change ``along`` it, and that by which it
    follows the parameters.
    """
    if misfit.offset.fixed:
        return 0.0
    if slopes is None:
        return math.nan
    own = confidence.variance / along if along > 0.0 else math.inf
    return math.sqrt(own + max(float(slopes.offsets @ confidence.covariance @ slopes.offsets), 0.0))


def autocorrelation(residuals: Sequence[Array]) -> float:
    """Mean correlation of successive residuals of all curves, between 0 and 0.99."""
    correlations = []
    for one in residuals:
        centred = one - one.mean()
        square = float(centred @ centred)
        correlations.append(float(centred[1:] @ centred[:-1]) / square if square > 0.0 else 0.0)
    return min(max(float(np.mean(correlations)), 0.0), 0.99)


@dataclass(frozen=True)
class Sensitivity:
    """How far the curves of the best point change with other steps (``by_steps``) and from the next turn on
    (``by_turns``).

    Both are over the deviations of the data, as is the ``residual`` of the best point. ``least`` is the cost
    of that point, ``cost`` the largest with other steps and turns. The error of the step may move the
    parameters by ``shift``, in shares of the bounds, to first order.
    """

    by_steps: float
    by_turns: float
    residual: float
    least: float
    cost: float
    shift: Array

    @property
    def inflation(self) -> float:
        """Growth of the squares with other steps or from another turn on, 1 or more."""
        return self.cost / max(self.least, 1e-300)

    @property
    def trusted(self) -> bool:
        """Whether the curves are those of the model rather than those of its steps, or of one turn.

        Curves that change by more than the part of the data that they explain would explain other data as
        well, however much noise there is: the part is sqrt(1 - residual^2) of the deviation of the data.
        """
        explained = math.sqrt(max(1.0 - self.residual * self.residual, 0.0))
        limit = max(TRUSTED_CHANGE, TRUSTED_SHARE_OF_RESIDUAL * self.residual)
        return max(self.by_steps, self.by_turns) <= min(limit, explained)


def sensitivity_of(
    curves: Curves,
    parameters: Sequence[FitParameter],
    misfit: Misfit,
    shares: Array,
    best: Fitted,
    jacobian: Array,
) -> Sensitivity:
    """How far the curves at ``shares`` change with steps and turns."""
    changes, costs = {"steps": 0.0, "turns": 0.0}, [best.cost]
    shift: Array = np.zeros(len(shares))
    for cause, trace in changed_traces(curves, parameters, misfit, shares):
        one = misfit(trace, best.offset)
        costs.append(one.cost)
        change = one.residuals - best.residuals
        changes[cause] = max(changes[cause], float(np.sqrt((change**2).mean())))
        if cause == "steps":  # the last of these traces has half the step
            shift = np.asarray(
                ERROR_OVER_CHANGE * np.linalg.lstsq(jacobian, change, RANK_TOLERANCE)[0], np.float64
            )
    residual = math.sqrt(2.0 * best.cost / misfit.count)
    return Sensitivity(changes["steps"], changes["turns"], residual, best.cost, max(costs), shift)


def changed_traces(
    curves: Curves, parameters: Sequence[FitParameter], misfit: Misfit, shares: Array
) -> Iterator[tuple[str, Trace]]:
    """Traces from the next turn on, if the turn in which the data began is unknown, of slightly finer steps,
    and of half the step.
    """
    numbers, turns, every = (
        numbers_at(parameters, shares),
        1 if misfit.unknown_turn else 0,
        curves.timing.every,
    )
    for finer in (0, 1, every) if turns else (1, every):
        changed = curves.changed(finer, turns)
        (trace,) = changed.each([numbers])
        if isinstance(trace, str):
            continue
        if finer:
            yield "steps", trace
        else:
            first = changed.timing.outputs
            yield "turns", Trace(trace.places[first:], trace.values[first:], trace.turn)


def widened(
    confidence: Confidence, sensitivity: Sensitivity, parameters: Sequence[FitParameter], best: Array,
    points: Sequence[tuple[float, tuple[float, ...]]],
) -> tuple[Array, Limits]:  # fmt: skip
    """Errors and limits that include the error of the step, and all points that cost no more than the best
    one with other steps or turns.
    """
    alike = np.array([shares for cost, shares in points if cost <= sensitivity.cost])
    errors, limits = confidence.errors.copy(), list(confidence.limits)
    for k, (one, (low, high)) in enumerate(zip(parameters, confidence.limits, strict=True)):
        error, middle = float(errors[k]), 0.5 * (low + high)
        if not math.isfinite(error) or not len(alike):
            continue
        errors[k] = math.hypot(error, one.slope(best[k]) * float(sensitivity.shift[k]))
        half = 0.5 * (high - low) * float(errors[k]) / max(error, 1e-300)
        ends = [one.value(float(end)) for end in (alike[:, k].min(), alike[:, k].max())]
        limits[k] = min(middle - half, *ends), max(middle + half, *ends)
        errors[k] *= max(1.0, 0.5 * (limits[k][1] - limits[k][0]) / max(half, 1e-300))
    return errors, limits


@dataclass
class Search:
    """How searches ended: cost and values of each, whether derivatives were carried along, and notes."""

    ends: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    tangents: bool = False
    notes: list[str] = field(default_factory=list)


def concluded(
    name: str,
    units: Mapping[str, str],
    evaluations: Evaluations,
    search: Search,
    slopes: Slopes | None,
    level: float,
) -> Fit:
    """The fit at the best point; without ``slopes`` it was interrupted, and its errors are unknown."""
    if evaluations.best is None or evaluations.best[2].fitted is None:  # screening raises before
        raise VfifeError("no member has a motion")
    _, shares, point = evaluations.best
    best, misfit, parameters = evaluations.best[2].fitted, evaluations.misfit, evaluations.parameters
    sensitivity = (
        None
        if slopes is None
        else sensitivity_of(evaluations.curves, parameters, misfit, shares, best, slopes.jacobian)
    )
    nuisance = 2 * int(misfit.proportional.sum()) + (0 if misfit.offset.fixed else 1)
    parts, jacobian = list(misfit.columns(best.residuals).T), None if slopes is None else slopes.jacobian
    inflation = 1.0 if sensitivity is None else sensitivity.inflation
    confidence = confidence_of(
        parts, parameters, shares, jacobian, len(parameters) + nuisance, level, inflation
    )
    errors, limits = confidence.errors, confidence.limits
    if sensitivity is not None:
        errors, limits = widened(confidence, sensitivity, parameters, shares, evaluations.points)
    values = [
        FitValue(
            one.name, one.paths, one.unit, one.value(float(x)), float(e), float(low), float(high),
            (one.low, one.high), one.initial,
            one.logarithmic, sensitivity is None or sensitivity.trusted,
        )
        for one, x, e, (low, high) in zip(parameters, shares, errors, limits, strict=True)
    ]  # fmt: skip
    notes = [*search.notes, *cautions(evaluations, point.unsettled, sensitivity), *evaluations.reasons[:3]]
    by = "derivatives of the steps" if search.tangents else "differences of runs"
    return Fit(
        name, misfit.measured.name, "interrupted" if slopes is None else "complete", values,
        confidence.correlation, confidence.directions,
        best_offset(misfit, best), offset_error(slopes, confidence, misfit, best.along), misfit.measured.over,
        best_curves(misfit, best, units), sorted(search.ends), evaluations.runs, len(evaluations.reasons),
        by, confidence.autocorrelation,
        level, time.monotonic() - evaluations.began, misfit.how, notes,
    )  # fmt: skip


def cautions(evaluations: Evaluations, unsettled: float, sensitivity: Sensitivity | None) -> Iterator[str]:
    """What the limits do not include, or had to be widened for."""
    share = evaluations.share
    if unsettled > UNSETTLED * max(share, 1e-3):
        percent = f"{100.0 * unsettled:.2g} %"
        text = (
            f"the model's turns do not repeat after those that are skipped (they differ by {percent} of the"
            " curves' deviations)"
        )
        remedy = "skip more, measure a motion that repeats, or give the offset from the start"
        yield f"{text}: numbers that rule how it settles may be wrong; {remedy}"
    if share > UNEXPLAINED:
        causes = "much noise, another minimum, a motion that does not repeat, or a model that is wrong"
        yield (
            f"the model misses the data by {100.0 * share:.3g} % of their deviation, by {causes}: of these"
            " the errors know only noise"
        )
    if sensitivity is None or sensitivity.inflation < INFLATED:
        return
    size, cause = max(
        (sensitivity.by_steps, "with other steps"), (sensitivity.by_turns, "from the next turn on")
    )
    alike = sum(cost <= sensitivity.cost for cost, _ in evaluations.points)
    text = (
        f"at these numbers the model's own curves differ by {100.0 * size:.2g} % of the data's deviations"
        f" {cause}"
    )
    if sensitivity.trusted:
        yield (
            f"{text}: errors and limits are widened by it, {alike} of {len(evaluations.points)} points fit as"
            " well"
        )
    else:
        remedy = (
            "compare envelopes or spectra, measure fewer turns from a known start, or a motion that repeats"
        )
        yield (
            f"{text}, so no confidence is known: {alike} of {len(evaluations.points)} points fit as well as"
            f" they; {remedy}"
        )


def best_offset(misfit: Misfit, best: Fitted) -> float:
    """The offset; of a free one within a turn."""
    span = misfit.offset.high if misfit.measured.over == "time" else 2.0 * math.pi
    return best.offset % span if misfit.offset.free else best.offset


def best_curves(misfit: Misfit, best: Fitted, units: Mapping[str, str]) -> list[FitCurve]:
    """Measured curves, and those of the best point."""
    curves, (over, places) = [], misfit.places()
    for k, curve in enumerate(misfit.measured.curves):
        factor, level = (float(value) for value in best.gains[:, k])
        unit = units.get(curve.channel, "") if not curve.proportional else "1"
        curves.append(
            FitCurve(
                curve.channel,
                curve.head,
                unit,
                over,
                places,
                misfit.target[:, k],
                best.values[:, k],
                factor,
                level,
            )
        )
    return curves
