"""Other minima of a fit: ends of searches that fit nearly as well as the best point.

Least squares knows the neighbourhood of one minimum. Contacts make the sum of squares rough, and curves that
hardly depend on a number leave each search in another of its minima. Limits therefore cover the ends of all
searches that leave little more than the least residual. All searches may miss the least minimum; then the
residual is more than noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..results.fit import SAME_POINT
from .batched_queries import Outcome
from .parameters import FitParameter
from .residuals import FitRecord

Array = NDArray[np.float64]
Limits = list[tuple[float, float]]
# Other minima count if they leave at most this many times the residual of the best one. Contacts make the sum
# of squares rough: where the data hardly know a spring, its minima left 1.05 to 1.45 times the least
# residual, and the true value lay between them.
NEAR_RESIDUAL = 1.5
# Concentration of n residuals that is more than noise: 1 + CONCENTRATED/sqrt(n), five standard deviations of
# that of normal numbers. At the true numbers of four-bars with 2 % noise it is 0.92 to 1.01 (n = 417), in
# minima beside them 1.1 to 5. Of a single residual, SPIKE times this over the deviation of most.
CONCENTRATED, SPIKE = 4.5, 6.0
# A residual is more than noise if it is this many times that of the record, and less than this share of the
# data's deviation is none; of envelopes and spectra, which are never white, by their concentration only.
NOISE_RATIO, NEGLIGIBLE = 1.5, 0.002
SMOOTHED_SHARE, SMOOTHED_CONCENTRATION = 0.05, 1.5
NORMAL = 1.4826  # standard deviation of normal numbers over the median of their sizes
# Order of the differences that leave the noise of a smooth curve, and their deviation over that of the noise.
ORDER, GROWTH = 4, math.sqrt(70.0)


@dataclass
class Search:
    """Ends of the searches (cost and values of each), whether derivatives were ``tangents``, and
    ``notes``.
    """

    ends: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    tangents: bool = False
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class OtherMinima:
    """Ends of searches that fit nearly as well as the best one: the lowest and highest value of each
    parameter (SI), shape (parameters, 2), and which of them the searches do not agree on. ``confirmed``: two
    searches reached the best point, within the limits, or contacts do not make the sum of squares rough.
    """

    spans: Array
    disputed: Sequence[bool]
    confirmed: bool = True

    def cover(self, places: Sequence[int], errors: Array, limits: Limits) -> tuple[Array, Limits]:
        """Return errors and limits of the parameters at some ``places`` that include those of the ends."""
        wide = [
            (min(low, float(self.spans[k, 0])), max(high, float(self.spans[k, 1])))
            for k, (low, high) in zip(places, limits, strict=True)
        ]
        growth = [
            max(1.0, (covered[1] - covered[0]) / max(limit[1] - limit[0], 1e-300)) if math.isfinite(limit[0])
            else 1.0
            for limit, covered in zip(limits, wide, strict=True)
        ]  # fmt: skip
        return errors * np.array(growth), [
            covered if math.isfinite(limit[0]) else limit for limit, covered in zip(limits, wide, strict=True)
        ]


def other_minima(
    parameters: Sequence[FitParameter],
    search: Search,
    best: tuple[float, Array],
    limits: Limits,
    correlation: Array,
    is_rough: bool,
) -> OtherMinima:
    """Return the minima that fit nearly as well as the ``best`` point, its cost and its shares of the bounds.

    Searches dispute a parameter if one of them ended more than SAME_POINT of the bounds, and more than the
    width of its ``limits``, from the best value. They also dispute each parameter that the ``correlation``,
    shape (parameters, parameters), moves out of its limits when the first one moves to that end.
    """
    cost, shares = best
    values = np.array([parameter.value(float(x)) for parameter, x in zip(parameters, shares, strict=True)])
    ends = [np.array(end) for end_cost, end in search.ends if end_cost <= NEAR_RESIDUAL**2 * cost]
    points = np.array([values, *ends])
    disputed = np.zeros(len(parameters), dtype=bool)
    for k, (parameter, (low, high)) in enumerate(zip(parameters, limits, strict=True)):
        distance = max(abs(parameter.share(float(x)) - float(shares[k])) for x in points[:, k])
        away = float(np.abs(points[:, k] - values[k]).max())
        if distance > SAME_POINT and not away <= high - low:
            disputed[k] = True
            disputed |= np.abs(correlation[k]) * away > 0.5 * (high - low)
    width = np.ptp(np.array(limits), axis=1)
    reached = sum(bool((np.abs(end - values) <= width).all()) for end in ends)
    spans = np.stack([points.min(axis=0), points.max(axis=0)], axis=1)
    return OtherMinima(spans, disputed.tolist(), reached > 1 or not is_rough or not search.ends)


def dispute_words(
    parameters: Sequence[FitParameter], minima: OtherMinima, search: Search, cost: float
) -> Iterator[str]:
    """Yield a caution on parameters that the searches dispute."""
    if not minima.confirmed:
        yield (
            "no two searches ended at this point to within its limits, and with contacts a better one may lie"
            " beside it, so confidence is not known; search from more starts (--starts)"
        )
    names = [
        parameter.name for parameter, disputed in zip(parameters, minima.disputed, strict=True) if disputed
    ]
    if names:
        near = sum(end_cost <= NEAR_RESIDUAL**2 * cost for end_cost, _ in search.ends)
        yield (
            f"searches do not agree on {', '.join(dict.fromkeys(names))}: {near} of {len(search.ends)} leave"
            f" at most {NEAR_RESIDUAL:g} times the least residual, at other values of these or of correlated"
            " parameters, so confidence is not known; measure a curve that depends more on them"
        )


# ------------------------------------------------------------------------------------------ more than noise


def excess_of(records: Sequence[FitRecord], outcome: Outcome) -> str:
    """Return in words by what the residuals of a point are more than noise; empty if they may be noise.

    In a minimum beside the true one the model strikes at other times than the rig, which few samples show. So
    it does with too long a step, which moves the minimum away from the true numbers.
    """
    for record, fitted in zip(records, outcome.fitted, strict=True):
        misfit = record.misfit
        residuals = misfit.columns(fitted.residuals).T
        for k, curve in enumerate(residuals):
            size = deviation(curve)
            rms = float(np.sqrt(np.mean(curve * curve)))
            if rms <= NEGLIGIBLE:
                continue
            name = f"{record.name}: " * bool(record.name) + misfit.measured.curves[k].channel
            if misfit.comparison != "curve":
                if rms > SMOOTHED_SHARE and concentration(curve) > SMOOTHED_CONCENTRATION:
                    return concentration_words(name, curve)
                continue
            margin = CONCENTRATED / math.sqrt(len(curve))
            if concentration(curve) > 1.0 + margin:
                return concentration_words(name, curve)
            spikes = int((np.abs(curve - np.median(curve)) > SPIKE * (1.0 + margin) * size).sum())
            if spikes and size > 0.0:
                return f"{name} misses {spikes} of {len(curve)} samples by more than {SPIKE:g} times the rest"
            noise = noise_of(misfit.data[:, k]) * float(misfit.weights[k])
            if len(records) == 1 and rms > (NOISE_RATIO + margin) * noise > 0.0:
                return f"{name} leaves {rms / noise:.2g} times the noise of its samples"
    return ""


def deviation(values: Array) -> float:
    """Return the standard deviation of most values: of normal numbers with the same median distance from
    their median.
    """
    return NORMAL * float(np.median(np.abs(values - np.median(values))))


def noise_of(values: Array) -> float:
    """Return the standard deviation of the white noise in samples of a curve, smooth in most places."""
    changes = np.diff(values, ORDER)
    return NORMAL * float(np.median(np.abs(changes))) / GROWTH if len(changes) else 0.0


def concentration(residuals: Array) -> float:
    """Return the root mean square of residuals over that of normal numbers with the same median size: 1 for
    noise, more if few of them are large.
    """
    centred = residuals - np.median(residuals)
    usual = deviation(residuals)
    return float(np.sqrt(np.mean(centred * centred))) / usual if usual > 0.0 else 1.0


def concentration_words(name: str, curve: Array) -> str:
    """Return what :func:`concentration` says of a curve that is more than noise."""
    return f"the root mean square of {name} is {concentration(curve):.2g} times what most samples leave"


def excess_words(share: float, excess: str) -> str:
    """Return a caution on residuals, a ``share`` of the data's deviation, that are more than noise."""
    return (
        f"the residual, {100.0 * share:.2g} % of the data's deviation, is more than noise: {excess}. The"
        " searches ended in another minimum, or the model differs from the rig or needs a finer step, so"
        " confidence is not known; search within narrower bounds or from more starts"
    )
