"""Uncertainty of identified parameters: confidence limits, and how far step size and unknown start phase of
the data change them.

Least squares assumes that the simulated curves are exact. For a periodic motion they nearly are. For a
chaotic motion they depend on the step size and on the turn with which the comparison starts, and the best fit
may agree with the data by chance. The best point is therefore repeated with finer steps and from the next
turn (:mod:`.curve_sensitivity`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..results.fit import Fit, FitCurve, FitRecordValues, FitValue
from .batched_queries import Evaluations, Outcome
from .curve_sensitivity import RANK_TOLERANCE, CurveSensitivity, sensitivity_of
from .other_minima import Limits, OtherMinima, Search, dispute_words, excess_of, excess_words, other_minima
from .parameters import FitParameter
from .residuals import FitRecord, Fitted, Misfit, Slopes

Array = NDArray[np.float64]
# Residuals of even size give two estimates of an error that differ by less than this factor by chance.
UNEVEN = 1.25
# Least share of a residual that its own sample leaves free: a sample alone may determine a parameter.
LEAST_FREEDOM = 1e-3
# Cautions are reported if turns differ by more than the first share of the residual, squares grow by more
# than the second factor with other steps, or the residual exceeds the third share of the data's standard
# deviation: confidence limits assume that residuals are noise.
UNSETTLED, INFLATED, UNEXPLAINED = 0.25, 1.1, 0.25
# Factor of the variance where contacts make the sum of squares rough: of 28 limits of 95 % of a four-bar 24
# contained the truth without it, and 27 with half widths 1.25 times as large.
ROUGHNESS = 1.25**2
ROUGH_WORDS = (
    f"limits are {math.sqrt(ROUGHNESS):g} times as wide as those of least squares, because contacts make the"
    " sum of squares rough"
)


@dataclass(frozen=True)
class Confidence:
    """Standard ``errors`` and ``limits`` of parameters (SI), their ``correlation``, and the principal
    ``directions`` of the covariance, each with its standard deviation in shares of the bounds.

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
    inflation: float = 1.0, rows: Sequence[int] = (),
) -> Confidence:  # fmt: skip
    """Confidence in parameters at ``shares`` of the ways between their bounds.

    The covariance is s^2 (J^T J)^-1 over what J determines, s^2 the residuals' mean square for each degree of
    freedom, times (1 + r)/(1 - r) where successive ones have a correlation r; limits are those of Student's
    t. ``residuals`` are those of each curve, J is by shares; ``unknowns`` is the number of fitted numbers;
    ``inflation`` is a factor of s^2. Without J all is unknown (NaN).

    Errors are at least those that hold for residuals of uneven size (:func:`uneven_errors`).

    Where ``rows`` gives the number of residuals of each of several records, the errors are also those by
    which the records disagree (:func:`disagreement`), and the larger ones count: a model that is a little
    wrong is wrong in another way in each record.
    """
    count = len(parameters)
    if jacobian is None:
        unknown = np.full(count, math.nan)
        pairs = np.full((count, count), math.nan)
        return Confidence(unknown, [(math.nan, math.nan)] * count, pairs, [], math.nan, math.nan, unknown)
    from scipy.stats import t

    freedom = max(sum(map(len, residuals)) - unknowns, 1)
    r = autocorrelation(residuals)
    variance = sum(float(curve @ curve) for curve in residuals) / freedom * inflation * (1.0 + r) / (1.0 - r)
    _, sizes, directions = np.linalg.svd(jacobian, full_matrices=False)
    # 1e-100 keeps the square of a singular value above zero.
    sizes = np.maximum(sizes, RANK_TOLERANCE * max(float(sizes.max(initial=0.0)), 1e-100))
    inverse = (directions.T / sizes**2) @ directions
    covariance = variance * inverse
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    correlation = covariance / np.maximum(np.outer(spread, spread), 1e-300)
    growth = math.sqrt(inflation * (1.0 + r) / (1.0 - r))
    uneven = growth * uneven_errors(np.concatenate(residuals), jacobian, inverse)
    spread = np.where(uneven > UNEVEN * spread, uneven, spread)
    reach = float(t.ppf(0.5 + 0.5 * level, freedom)) * spread
    if len(rows) > 1:
        record_errors = disagreement(np.concatenate(residuals), jacobian, inverse, rows)
        spread = np.maximum(spread, record_errors)
        reach = np.maximum(reach, float(t.ppf(0.5 + 0.5 * level, len(rows) - 1)) * record_errors)
    slopes = np.array([parameter.slope(float(x)) for parameter, x in zip(parameters, shares, strict=True)])
    errors, reach = slopes * spread, slopes * reach
    values = [parameter.value(float(x)) for parameter, x in zip(parameters, shares, strict=True)]
    limits = [(value - float(half), value + float(half)) for value, half in zip(values, reach, strict=True)]
    principal = [
        (math.sqrt(variance) / float(size), row)
        for size, row in zip(sizes[::-1], directions[::-1], strict=True)
    ]
    return Confidence(errors, limits, correlation, principal, variance, r, covariance)


def uneven_errors(residuals: Array, jacobian: Array, inverse: Array) -> Array:
    """Return standard errors for residuals whose size differs from sample to sample, in shares of the bounds.

    Where contacts begin, curves depend most on the parameters, and residuals are largest: their mean square
    then makes errors several times too small. Estimate HC2 of MacKinnon and White, Journal of Econometrics 29
    (1985) 305-325, which is unbiased where they are even.

    inverse: (J^T J)^-1, (parameters, parameters)
    """
    leverage = ((jacobian @ inverse) * jacobian).sum(axis=1)
    weighted = residuals / np.sqrt(np.maximum(1.0 - leverage, LEAST_FREEDOM))
    moves = (jacobian * weighted[:, None]) @ inverse
    return np.asarray(np.sqrt((moves**2).sum(axis=0)))


def disagreement(residuals: Array, jacobian: Array, inverse: Array, rows: Sequence[int]) -> Array:
    """Return standard errors from the disagreement between records, in shares of the bounds; correlation
    within a record does not matter. Liang and Zeger, Biometrika 73 (1986) 13-22, with the factor K/(K - 1)
    for K records.

    inverse: (J^T J)^-1, (parameters, parameters)
    rows: number of residuals of each record
    """
    ends = np.cumsum(rows)
    pulls = [
        jacobian[end - count : end].T @ residuals[end - count : end]
        for end, count in zip(ends, rows, strict=True)
    ]
    moves = np.array(pulls) @ inverse
    return np.asarray(np.sqrt((moves**2).sum(axis=0) * len(rows) / (len(rows) - 1)))


def without_own(jacobian: Array, parameters: Sequence[FitParameter]) -> Array:
    """Columns of the parameters that records have in common, without what numbers of one record can do as
    well: least squares of these columns are those of all (Golub and Pereyra, 1973).
    """
    is_own = np.array([bool(parameter.record) for parameter in parameters])
    if not is_own.any():
        return jacobian
    basis, _ = np.linalg.qr(jacobian[:, is_own])
    common = jacobian[:, ~is_own]
    return np.asarray(common - basis @ (basis.T @ common))


def curves_of(records: Sequence[FitRecord], outcome: Outcome) -> list[Array]:
    """Residuals of each curve of each record."""
    return [
        part
        for record, fitted in zip(records, outcome.fitted, strict=True)
        for part in record.misfit.columns(fitted.residuals).T
    ]


def offset_error(offsets: Array | None, confidence: Confidence, misfit: Misfit, curvature: float) -> float:
    """Return the standard error (s) of a record's offset: its own, from the ``curvature`` of the
    cost along it, and the part that follows the parameters.

    offsets: derivatives of the offset by the parameters, (parameters,); None where these are not known
    """
    if misfit.offset.fixed:
        return 0.0
    if offsets is None:
        return math.nan
    own_variance = confidence.variance / curvature if curvature > 0.0 else math.inf
    return math.sqrt(own_variance + max(float(offsets @ confidence.covariance @ offsets), 0.0))


def autocorrelation(residuals: Sequence[Array]) -> float:
    """Return the mean correlation of successive residuals of all curves, limited to 0 to 0.99."""
    correlations = []
    for curve in residuals:
        centred = curve - curve.mean()
        square = float(centred @ centred)
        correlations.append(float(centred[1:] @ centred[:-1]) / square if square > 0.0 else 0.0)
    return min(max(float(np.mean(correlations)), 0.0), 0.99)


def likelihood_margin(confidence: Confidence, freedom: int, level: float) -> float:
    """Return the increase of the cost, half the sum of squares, at the confidence limits of one parameter
    (Bates and Watts: Nonlinear Regression Analysis, 1988, section 6.1: profile t).
    """
    from scipy.stats import t

    return 0.5 * confidence.variance * float(t.ppf(0.5 + 0.5 * level, max(freedom, 1))) ** 2


def widened(
    confidence: Confidence, sensitivity: CurveSensitivity, parameters: Sequence[FitParameter], best: Array,
    points: Sequence[tuple[float, tuple[float, ...]]], margin: float,
) -> tuple[Array, Limits]:  # fmt: skip
    """Return errors and limits that include the error of the step, and all points whose cost is at most that
    of the best one with other steps or turns, or exceeds that of the best one by at most ``margin``.
    """
    # Points that fit as well as the best one does with another step cannot be told apart from it: limits
    # include them, and errors grow by the same ratio. So do those within the confidence region of the sum of
    # squares itself, which the ellipsoid of the derivatives misses where that sum has a jump.
    largest = max(sensitivity.cost, sensitivity.best_cost + margin)
    equal_points = np.array([shares for cost, shares in points if cost <= largest])
    errors, limits = confidence.errors.copy(), list(confidence.limits)
    for k, (parameter, (low, high)) in enumerate(zip(parameters, confidence.limits, strict=True)):
        error, middle = float(errors[k]), 0.5 * (low + high)
        if not math.isfinite(error) or not len(equal_points):
            continue
        errors[k] = math.hypot(error, parameter.slope(best[k]) * float(sensitivity.shift[k]))
        half = 0.5 * (high - low) * float(errors[k]) / max(error, 1e-300)
        ends = [parameter.value(float(end)) for end in (equal_points[:, k].min(), equal_points[:, k].max())]
        limits[k] = min(middle - half, *ends), max(middle + half, *ends)
        errors[k] *= max(1.0, 0.5 * (limits[k][1] - limits[k][0]) / max(half, 1e-300))
    return errors, limits


def concluded(
    name: str,
    units: Mapping[str, str],
    evaluations: Evaluations,
    search: Search,
    slopes: Slopes | None,
    level: float,
) -> Fit:
    """Return the fit at the best point; without ``slopes`` it was interrupted, and its errors are NaN."""
    if evaluations.best is None or not evaluations.best[2].fitted:  # screening raises before
        raise VfifeError("no case has a motion")
    _, shares, outcome = evaluations.best
    records, parameters = evaluations.records, evaluations.parameters
    common = [k for k, parameter in enumerate(parameters) if not parameter.record]
    shared, shared_shares = [parameters[k] for k in common], shares[common]
    jacobian = None if slopes is None else without_own(slopes.jacobian, parameters)
    work = records, shares, outcome
    sensitivity = None if jacobian is None else sensitivity_of(*work, jacobian, shared_shares)
    is_rough = records[0].curves.has_contacts
    inflation = (ROUGHNESS if is_rough else 1.0) * (1.0 if sensitivity is None else sensitivity.inflation)
    parts, unknowns = curves_of(records, outcome), len(parameters) + nuisances(records)
    rows = [record.misfit.count for record in records]
    confidence = confidence_of(parts, shared, shared_shares, jacobian, unknowns, level, inflation, rows)
    errors, limits = confidence.errors, confidence.limits
    near_limits = limits  # without the explored points, by which searches that differ would seem to agree
    if sensitivity is not None:
        points = [(cost, tuple(at[k] for k in common)) for cost, at in evaluations.points]
        margin = likelihood_margin(confidence, sum(map(len, parts)) - unknowns, level)
        _, near_limits = widened(confidence, sensitivity, shared, shared_shares, points, 0.0)
        errors, limits = widened(confidence, sensitivity, shared, shared_shares, points, margin)
    excess = excess_of(records, outcome)
    trusted = not excess and getattr(sensitivity, "trusted", True)
    joint_confidence = confidence if len(common) == len(parameters) else confidence_of(
        parts, parameters, shares, None if slopes is None else slopes.jacobian, unknowns, level, inflation
    )  # fmt: skip
    shared_limits = dict(zip(common, near_limits, strict=True))
    joint_limits = [shared_limits.get(k, pair) for k, pair in enumerate(joint_confidence.limits)]
    last, best = Search() if slopes is None else search, (outcome.cost, shares)
    minima = other_minima(parameters, last, best, joint_limits, joint_confidence.correlation, is_rough)
    errors, limits = minima.cover(common, errors, limits)
    certainty = [trusted and minima.confirmed and not disputed for disputed in minima.disputed]
    values = fit_values(shared, shared_shares, errors, limits, [certainty[k] for k in common])
    record_results = list(record_values(evaluations, outcome, joint_confidence, slopes, minima, certainty))
    curves = [
        curve
        for record, fitted in zip(records, outcome.fitted, strict=True)
        for curve in best_curves(record, fitted, units)
    ]
    misfit, first = records[0].misfit, record_results[0]
    source = "derivatives of the steps" if search.tangents else "differences of runs"
    data = misfit.measured.name if len(records) == 1 else f"{len(records)} records"
    return Fit(
        name, data, "interrupted" if slopes is None else "complete", values,
        confidence.correlation, confidence.directions,
        first.offset, first.offset_error, misfit.measured.over,
        curves, sorted(search.ends), evaluations.runs, len(evaluations.reasons),
        source, confidence.autocorrelation,
        level, time.monotonic() - evaluations.began, misfit.comparison,
        notes_of(evaluations, outcome, search, minima, sensitivity, excess, any(certainty)),
        record_results if len(record_results) > 1 or first.values else [],
    )  # fmt: skip


def notes_of(
    evaluations: Evaluations, outcome: Outcome, search: Search, minima: OtherMinima,
    sensitivity: CurveSensitivity | None, excess: str, is_limited: bool,
) -> list[str]:  # fmt: skip
    """Return notes and cautions on a fit, the gravest first."""
    return [
        *([excess_words(evaluations.share, excess)] if excess else []),
        *search.notes,
        *dispute_words(evaluations.parameters, minima, search, outcome.cost),
        *cautions(evaluations, outcome.unsettled, sensitivity),
        *([ROUGH_WORDS] if is_limited and sensitivity and evaluations.records[0].curves.has_contacts else []),
        *omitted_words(evaluations.records),
        *evaluations.reasons[:3],
    ]


def omitted_words(records: Sequence[FitRecord]) -> Iterator[str]:
    """Yield notes on columns that are not compared: with the name of a channel, and with that of none."""
    names = list(dict.fromkeys(name for record in records for name in record.misfit.measured.omitted))
    if names:
        yield (
            f"not compared: {', '.join(names)}, because other columns were named; name them too to compare"
            " them"
        )
    unknown = list(dict.fromkeys(text for record in records for text in record.misfit.measured.unknown))
    if unknown:
        yield (
            f"not compared, because the model has no channel of this name: {', '.join(unknown)}; assign one"
            " with -c COLUMN=CHANNEL (in Python columns)"
        )


def nuisances(records: Sequence[FitRecord]) -> int:
    """Numbers that are found anew for all parameters: offsets, factors and levels."""
    return sum(
        2 * int(record.misfit.proportional.sum()) + (0 if record.misfit.offset.fixed else 1)
        for record in records
    )


def fit_values(
    parameters: Sequence[FitParameter],
    shares: Array,
    errors: Array,
    limits: Limits,
    certainty: Sequence[bool],
) -> list[FitValue]:
    """Return the identified parameters."""
    return [
        FitValue(
            p.name, p.paths, p.unit, p.value(float(x)), float(error), float(low), float(high),
            (p.low, p.high), p.initial, p.logarithmic, certain, p.signs,
        )
        for p, x, error, (low, high), certain in zip(
            parameters, shares, errors, limits, certainty, strict=True
        )
    ]  # fmt: skip


def record_values(
    evaluations: Evaluations,
    outcome: Outcome,
    confidence: Confidence,
    slopes: Slopes | None,
    minima: OtherMinima,
    certainty: Sequence[bool],
) -> Iterator[FitRecordValues]:
    """Yield the values of each record: its offset, its residual and its own parameters."""
    _, shares, _ = evaluations.best or (0.0, np.zeros(0), outcome)
    for k, (record, fitted) in enumerate(zip(evaluations.records, outcome.fitted, strict=True)):
        indices = [at for at in record.places() if evaluations.parameters[at].record]
        errors, limits = minima.cover(
            indices, confidence.errors[indices], [confidence.limits[at] for at in indices]
        )
        values = fit_values(
            [evaluations.parameters[at] for at in indices], shares[indices], errors, limits,
            [certainty[at] for at in indices],
        )  # fmt: skip
        offsets = None if slopes is None or not all(certainty) else slopes.offsets[k]
        error = offset_error(offsets, confidence, record.misfit, fitted.curvature)
        share = math.sqrt(2.0 * fitted.cost / record.misfit.count)
        name = record.name or record.misfit.measured.name
        yield FitRecordValues(name, best_offset(record.misfit, fitted), error, share, values)


def cautions(
    evaluations: Evaluations, unsettled: float, sensitivity: CurveSensitivity | None
) -> Iterator[str]:
    """Yield cautions: effects that the limits do not include or were widened by."""
    share = evaluations.share
    if unsettled > UNSETTLED * max(share, 1e-3):
        percent = f"{100.0 * unsettled:.2g} %"
        text = (
            f"the model's turns do not repeat after those that are skipped (they differ by {percent} of the"
            " curves' deviations)"
        )
        remedy = "skip more, measure a motion that repeats, or give the offset from the start"
        yield f"{text}: parameters that govern the transient may be wrong; {remedy}"
    if share > UNEXPLAINED:
        causes = "much noise, another minimum, a motion that does not repeat, or a model that is wrong"
        yield (
            f"the model misses the data by {100.0 * share:.3g} % of their deviation, because of {causes};"
            " the errors account only for noise"
        )
    if sensitivity is None or sensitivity.inflation < INFLATED:
        return
    size, cause = max(
        (sensitivity.by_steps, "with other steps"), (sensitivity.by_turns, "from the next turn on")
    )
    count = sum(cost <= sensitivity.cost for cost, _ in evaluations.points)
    text = (
        f"at these numbers the model's own curves differ by {100.0 * size:.2g} % of the data's deviations"
        f" {cause}"
    )
    if sensitivity.trusted:
        yield (
            f"{text}: errors and limits are widened by it, {count} of {len(evaluations.points)} points fit as"
            " well"
        )
    else:
        remedy = "measure fewer turns from a known start, or a motion that repeats"
        if any(record.misfit.comparison == "curve" for record in evaluations.records):
            remedy = f"compare envelopes or spectra, {remedy}"
        yield (
            f"{text}, so confidence is not known: {count} of {len(evaluations.points)} points fit as well as"
            f" they; {remedy}"
        )


def best_offset(misfit: Misfit, best: Fitted) -> float:
    """Return the best offset (s or rad); a free one is reduced to a turn."""
    span = misfit.offset.high if misfit.measured.over == "time" else 2.0 * math.pi
    return best.offset % span if misfit.offset.free else best.offset


def best_curves(record: FitRecord, best: Fitted, units: Mapping[str, str]) -> list[FitCurve]:
    """Measured curves of a record, and those of the best point."""
    misfit = record.misfit
    curves, (abscissa, places) = [], misfit.places()
    for k, curve in enumerate(misfit.measured.curves):
        factor, level = (float(value) for value in best.gains[:, k])
        unit = units.get(curve.channel, "") if not curve.proportional else "1"
        curves.append(
            FitCurve(
                curve.channel,
                curve.head,
                unit,
                abscissa,
                places,
                misfit.target[:, k],
                best.values[:, k],
                factor,
                level,
                record.name,
            )
        )
    return curves
