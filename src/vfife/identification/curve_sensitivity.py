"""Change of simulated curves at the best point of a fit with step size, outputs and start turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .batched_queries import Outcome
from .curves import Trace
from .residuals import FitRecord, Fitted

Array = NDArray[np.float64]
# Singular values below this share of the largest are treated as zero.
RANK_TOLERANCE = 1e-12
# The error of a step is about twice the change to half the step, because contact onsets make the method first
# order.
ERROR_OVER_CHANGE = 2.0
# Curves are trusted if they change by less than a tenth of the data's standard deviation, or by less than
# half of the residual.
TRUSTED_CHANGE, TRUSTED_SHARE_OF_RESIDUAL = 0.1, 0.5
# Nor are curves trusted that change by this many times the residual, if that is above NOISY: the search
# fitted the error of the step. A four-bar with 2 % noise changed by 7.9 %, and its limits missed.
STEP_OVER_RESIDUAL, NOISY = 3.0, 0.01


@dataclass(frozen=True)
class CurveSensitivity:
    """Change of the curves at the best point with other steps (``by_steps``) and from the next turn on
    (``by_turns``).

    Both are relative to the data's deviations, as is the ``residual`` of the best point. ``best_cost`` is
    the cost of that point, ``cost`` the largest with other steps and turns. ``shift`` is the effect on the
    parameters, in shares of the bounds and to first order, of the error of the step, of the interpolation
    between outputs, and of the distance from the minimum that the derivatives predict.
    """

    by_steps: float
    by_turns: float
    residual: float
    best_cost: float
    cost: float
    shift: Array

    @property
    def inflation(self) -> float:
        """Ratio of the largest cost with other steps and turns to that of the best point, 1 or more."""
        return self.cost / max(self.best_cost, 1e-300)

    @property
    def trusted(self) -> bool:
        """Whether the curves depend on the model rather than on its step or on the choice of a turn.

        Curves that change by more than the part of the data that they explain would explain other data as
        well, whatever the noise; that part is sqrt(1 - residual^2) of the data's deviation.
        """
        explained = math.sqrt(max(1.0 - self.residual * self.residual, 0.0))
        limit = max(TRUSTED_CHANGE, TRUSTED_SHARE_OF_RESIDUAL * self.residual)
        if self.residual > NOISY:
            limit = min(limit, STEP_OVER_RESIDUAL * self.residual)
        return max(self.by_steps, self.by_turns) <= min(limit, explained)


def sensitivity_of(
    records: Sequence[FitRecord], shares: Array, best: Outcome, jacobian: Array, at: Array
) -> CurveSensitivity:
    """How far the curves of all records at ``shares`` change with steps and turns. ``jacobian`` is by the
    parameters that they have in common, whose shares are ``at``.
    """
    changes, costs = {"steps": 0.0, "turns": 0.0}, [best.cost]
    shift = distance_to_minimum(at, best, jacobian) ** 2
    turns = any(record.misfit.unknown_turn for record in records)
    for cause in (*(("turns",) if turns else ()), "steps", "half steps", "outputs"):
        changed = changed_fits(records, shares, best, cause)
        change = np.concatenate(
            [new.residuals - old.residuals for new, old in zip(changed, best.fitted, strict=True)]
        )
        if cause in ("half steps", "outputs"):
            shift = shift + (ERROR_OVER_CHANGE * np.linalg.lstsq(jacobian, change, RANK_TOLERANCE)[0]) ** 2
        if cause == "outputs":
            continue
        costs.append(sum(fitted.cost for fitted in changed))
        kind = cause.removeprefix("half ")
        changes[kind] = max(changes[kind], float(np.sqrt((change**2).mean())))
    residual = math.sqrt(2.0 * best.cost / sum(record.misfit.count for record in records))
    return CurveSensitivity(
        changes["steps"], changes["turns"], residual, best.cost, max(costs), np.sqrt(shift)
    )


def distance_to_minimum(at: Array, best: Outcome, jacobian: Array) -> Array:
    """Return how far a step of Gauss and Newton leads from the best point ``at``, in shares of the bounds.

    At a smooth minimum it is zero. Where contacts make the sum of squares rough, searches end in a dent, and
    the derivatives over a wider interval point to the minimum of its trend.
    """
    residuals = np.concatenate([fitted.residuals for fitted in best.fitted])
    move = -np.linalg.lstsq(jacobian, residuals, RANK_TOLERANCE)[0]
    return np.asarray(np.clip(at + move, 0.0, 1.0) - at)


def changed_fits(records: Sequence[FitRecord], shares: Array, best: Outcome, cause: str) -> list[Fitted]:
    """Curves of all records from the next turn on, of slightly finer steps, of half the step, or with twice
    the outputs; those of the best point where a record has no others.
    """
    cases = []
    for record in records:
        finer = {"steps": 1, "half steps": record.curves.length.steps_per_output}.get(cause, 0)
        turns = 1 if record.misfit.unknown_turn else 0
        changed = record.curves.changed(finer, turns, 2 if cause == "outputs" else 1)
        cases.append((changed, record.numbers([shares[k] for k in record.places()])))
    result, traces = [], cases[0][0].case_traces(cases)
    for record, (changed, _), trace, fitted in zip(records, cases, traces, best.fitted, strict=True):
        if isinstance(trace, str) or (cause == "turns" and not record.misfit.unknown_turn):
            result.append(fitted)
            continue
        if cause == "turns":
            first = changed.length.outputs
            trace = Trace(trace.places[first:], trace.values[first:], trace.turn)
        result.append(record.misfit(trace, fitted.offset))
    return result
