"""Search of the best values of parameters, with optuna: axes and their scales, limits, and the Pareto front
of several measures.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Protocol

from ...errors import VfifeError
from ...numerics.scalar import log, power
from ..spec.limits import Bound


class Ends(Protocol):
    """What lies between two bounds (SI)."""

    @property
    def low(self) -> float: ...

    @property
    def high(self) -> float: ...

    @property
    def logarithmic(self) -> bool: ...

    def value(self, share: float) -> float: ...


class Between:
    """The way from ``low`` to ``high``, both above zero where it is ``logarithmic``."""

    def value(self: Ends, share: float) -> float:
        """The value (SI) at a share of the way, which is held between the bounds; at its ends it is a bound
        to the bit.
        """
        share = min(max(share, 0.0), 1.0)
        if share == 1.0:
            return self.high
        found = (
            self.low * power(self.high / self.low, share)
            if self.logarithmic
            else self.low + share * (self.high - self.low)
        )
        return min(max(found, self.low), self.high)

    def share(self: Ends, value: float) -> float:
        """Where a value lies on the way."""
        if self.logarithmic:
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def slope(self: Ends, share: float) -> float:
        """Derivative of the value by the share."""
        return self.value(share) * log(self.high / self.low) if self.logarithmic else self.high - self.low


EXTRA = 'the search is done by optuna, which is not installed here: pip install "vfife[optimise]"'
BATCH = 16  # members asked for at once; it is part of the search, so it does not hang on the machine
STARTUP = 2  # batches at random first

Number = float | str
Numbers = dict[str, Number]
Values = Mapping[str, float]


@dataclass(frozen=True)
class Axis(Between):
    """What may be varied: from ``low`` to ``high`` in SI units, evenly or by its logarithm, or one of
    ``values``; ``whole`` numbers are rounded.
    """

    name: str
    low: float = math.nan
    high: float = math.nan
    logarithmic: bool = False
    values: tuple[Number, ...] = ()
    whole: bool = False

    @property
    def continuous(self) -> bool:
        """Whether it takes every value between its bounds."""
        return not self.values and not self.whole


@dataclass(frozen=True)
class Search:
    """What is searched for: the least of ``minimised`` and the most of ``maximised`` measures over ``axes``,
    within ``bounds``, in so many ``members``, and ``refine`` more at the most that derivatives lead to.
    """

    axes: tuple[Axis, ...]
    minimised: tuple[str, ...]
    bounds: tuple[Bound, ...] = ()
    members: int = 200
    seed: int = 0
    batch: int = BATCH
    maximised: tuple[str, ...] = ()
    refine: int = 0

    @property
    def aims(self) -> tuple[tuple[str, float], ...]:
        """Measures, each with what multiplies it so that less is better."""
        return (*((name, 1.0) for name in self.minimised), *((name, -1.0) for name in self.maximised))


@dataclass(frozen=True)
class Found:
    """A member of the search: its place among them, its parameters, measures (None where it failed), whether
    it keeps the limits.
    """

    number: int
    parameters: Numbers
    values: Values | None
    feasible: bool


Ask = Callable[[Sequence[Numbers]], Sequence[Values | None]]


def searched(search: Search, ask: Ask, told: Callable[[list[Found]], None] | None = None) -> list[Found]:
    """Every member of a search, in order. ``ask`` computes members, or takes them from where they are kept,
    and says None for one that failed; ``told`` hears of each batch. Raises VfifeError without optuna.

    One measure is searched by the tree-structured Parzen estimator, several by NSGA-II; both hold to the
    limits by their excess.
    """
    optuna = imported()
    excess: dict[int, list[float]] = {}

    def constraints(trial: Any) -> list[float]:
        return excess[trial.number]

    directions = ["minimize" if sign > 0.0 else "maximize" for _, sign in search.aims]
    study = optuna.create_study(directions=directions, sampler=sampler(optuna, search, constraints))
    spaces, found = {one.name: space(optuna, one) for one in search.axes}, list[Found]()
    while len(found) < search.members:
        trials = [study.ask(spaces) for _ in range(min(search.batch, search.members - len(found)))]
        batch: list[Found] = []
        for trial, values in zip(trials, ask([dict(trial.params) for trial in trials]), strict=True):
            one = judged(search, trial.number, dict(trial.params), values)
            # Rounded: a sampler may compare what it is told, and the excess of a member that failed has to be
            # a number.
            excess[trial.number] = [
                min(bound.excess((values or {}).get(bound.measure, math.nan)), 1e300)
                for bound in search.bounds
            ]
            objectives = [(values or {}).get(name, math.nan) for name, _ in search.aims]
            if all(map(math.isfinite, objectives)):
                study.tell(trial, objectives)
            else:
                study.tell(trial, state=optuna.trial.TrialState.FAIL)
            batch.append(one)
        found += batch
        if told is not None:
            told(batch)
    return found


def judged(search: Search, number: int, parameters: Numbers, values: Values | None) -> Found:
    """A member with whether it has all that is sought, within the limits."""
    known = values or {}
    whole = all(math.isfinite(known.get(name, math.nan)) for name, _ in search.aims)
    return Found(
        number,
        parameters,
        values,
        whole and all(bound.excess(known.get(bound.measure, math.nan)) <= 0.0 for bound in search.bounds),
    )


def best(search: Search, found: Sequence[Found]) -> list[Found]:
    """The Pareto front: members within the limits than which no other is as good in every measure sought and
    better in one, the best of the first measure first.

    Of one measure that is the best. Of members with equal measures the first is told.
    """
    kept: dict[tuple[float, ...], Found] = {}
    for one in found:
        if one.feasible and one.values is not None:
            kept.setdefault(tuple(sign * one.values[name] for name, sign in search.aims), one)
    front = [at for at in sorted(kept) if not any(dominates(other, at) for other in kept)]
    return [kept[at] for at in front]


def dominates(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether one is nowhere worse and somewhere better."""
    return all(a <= b for a, b in zip(one, other, strict=True)) and any(
        a < b for a, b in zip(one, other, strict=True)
    )


def space(optuna: ModuleType, axis: Axis) -> Any:
    """What optuna is told of a parameter."""
    if axis.values:
        return optuna.distributions.CategoricalDistribution(list(axis.values))
    return optuna.distributions.FloatDistribution(axis.low, axis.high, log=axis.logarithmic)


def sampler(optuna: ModuleType, search: Search, constraints: Callable[[Any], list[float]]) -> Any:
    """The sampler of a search; optuna calls how it takes limits an experiment, and says so each time."""
    limited = constraints if search.bounds else None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if len(search.aims) == 1:
            return optuna.samplers.TPESampler(
                seed=search.seed,
                n_startup_trials=STARTUP * search.batch,
                multivariate=True,
                constant_liar=True,
                constraints_func=limited,
            )
        return optuna.samplers.NSGAIISampler(
            seed=search.seed, population_size=2 * search.batch, constraints_func=limited
        )


def imported() -> ModuleType:
    """optuna, which is quiet. Raises VfifeError where it is not installed."""
    try:
        import optuna
    except ImportError:
        raise VfifeError(EXTRA) from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    module: ModuleType = optuna
    return module
