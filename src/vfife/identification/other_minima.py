"""Other minima of a fit: ends of searches that fit nearly as well as the best point.

Least squares knows the neighbourhood of one minimum. Contacts make the sum of squares rough, and curves that
hardly depend on a number leave each search in another of its minima. Limits therefore cover the ends of all
searches that leave little more than the least residual.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..results.fit import SAME_POINT
from .parameters import FitParameter

Array = NDArray[np.float64]
Limits = list[tuple[float, float]]
# Other minima count if they leave at most this many times the residual of the best one. Contacts make the sum
# of squares rough: where the data hardly know a spring, its minima left 1.05 to 1.45 times the least
# residual, and the true value lay between them.
NEAR_RESIDUAL = 1.5


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
    parameter (SI), shape (parameters, 2), and which of them the searches do not agree on.
    """

    spans: Array
    disputed: Sequence[bool]

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
    parameters: Sequence[FitParameter], search: Search, best: tuple[float, Array], limits: Limits
) -> OtherMinima:
    """Return the minima that fit nearly as well as the ``best`` point, its cost and its shares of the bounds.

    Searches dispute a parameter if one of them ended more than SAME_POINT of the bounds, and more than the
    width of its ``limits``, from the best value.
    """
    cost, shares = best
    values = np.array([parameter.value(float(x)) for parameter, x in zip(parameters, shares, strict=True)])
    ends = [np.array(end) for end_cost, end in search.ends if end_cost <= NEAR_RESIDUAL**2 * cost]
    points = np.array([values, *ends])
    disputed = []
    for k, (parameter, (low, high)) in enumerate(zip(parameters, limits, strict=True)):
        distance = max(abs(parameter.share(float(x)) - float(shares[k])) for x in points[:, k])
        away = float(np.abs(points[:, k] - values[k]).max())
        disputed.append(distance > SAME_POINT and not away <= high - low)
    return OtherMinima(np.stack([points.min(axis=0), points.max(axis=0)], axis=1), disputed)


def dispute_words(
    parameters: Sequence[FitParameter], minima: OtherMinima, search: Search, cost: float
) -> Iterator[str]:
    """Yield a caution on parameters that the searches dispute."""
    names = [
        parameter.name for parameter, disputed in zip(parameters, minima.disputed, strict=True) if disputed
    ]
    if names:
        near = sum(end_cost <= NEAR_RESIDUAL**2 * cost for end_cost, _ in search.ends)
        yield (
            f"searches ended at different values of {', '.join(dict.fromkeys(names))}: {near} of"
            f" {len(search.ends)} leave at most {NEAR_RESIDUAL:g} times the least residual, so confidence is"
            " not known; in Python their ends enclose all values that fit nearly as well; measure a curve"
            " that depends more on them"
        )
