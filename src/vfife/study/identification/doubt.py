"""What nobody can know of a fit's best point, its steps and where in a motion the data began: how far the curves change with them, and which
other points fit as well then.

A motion that repeats itself hardly heeds either. In one that does not, curves part after some turns, and the least misfit is that of a point whose
curves happen to run along the data: least squares calls it sure, and so it is told here that it is not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .confidence import Confident
from .curves import Curves, Trace
from .misfit import Fitted, Misfit
from .sought import Sought, numbers_at

Array = NDArray[np.float64]
Limits = list[tuple[float, float]]
ORDER = 2.0  # times the change from a step to its half: the error of a step, of first order where contacts begin in it
WEAK = 1e-12  # of the largest singular value: what is less is nothing
LARGE, BESIDE = 0.1, 0.5  # of the deviation of the data, and of what is missed: curves that change by more are not known


@dataclass(frozen=True)
class Doubt:
    """By how much curves change with other steps (``by_steps``) and from the next turn on (``by_turns``), over the deviations of the data; what the
    best point misses (``missed``) and costs (``least``), and the largest ``cost`` of it with others; by what shares of the bounds the error of the
    step may move the parameters, to first order (``shift``).
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


def doubt(curves: Curves, sought: Sequence[Sought], misfit: Misfit, shares: Array, best: Fitted, jacobian: Array) -> Doubt:
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
    return Doubt(apart["steps"], apart["turns"], math.sqrt(2.0 * best.cost / misfit.count), best.cost, max(costs), shift)


def beside(curves: Curves, sought: Sequence[Sought], misfit: Misfit, shares: Array) -> Iterator[tuple[str, Trace]]:
    """Traces of the same steps from the next turn on, where nobody knows in which the data began, of steps a little finer, and of half of them."""
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
    told: Confident, found: Doubt, sought: Sequence[Sought], best: Array, points: Sequence[tuple[float, tuple[float, ...]]]
) -> tuple[Array, Limits]:
    """Errors and limits with the error of the step, and with all points that cost no more than the best one with other steps or in another turn."""
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
