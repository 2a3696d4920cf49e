"""Optimisation of a study: axes, aims and limits, read from the table ``[optimise]``; the cases that optuna
asks for; candidates, and the Pareto front of these. :mod:`.local_search` goes on from the best of them.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from ...errors import VfifeError, shown
from ...numerics.pareto import front
from ...numerics.scalar import log, power
from ...schema import Integer, Text, described
from ...schema.parts import FreeList
from ..spec.distributions import Uniform
from ..spec.limits import Bound, read_bounds
from ..spec.plan import MOST_CASES, Plan
from ..spec.study_file import StudyReader, StudyTables, search_plan

EXTRA = 'the search is done by optuna, which is not installed here: pip install "vfife[optimise]"'
REFINE = 20  # cases of the local search, at most
STARTUP = 2  # batches at random first
HUGE = 1e300  # excess of a case without measures, which has to be a number
TABLE, LIMIT = "optimise", "limit"
BATCH = 16  # cases asked for at once; part of the search, so that it does not depend on the machine
Parameters = dict[str, float | str]
Values = Mapping[str, float]
# Returns the measures of cases, None for a failed one.
Evaluate = Callable[[Sequence[Parameters]], Sequence[Values | None]]


class Interval:
    """The values from ``low`` to ``high``, both above zero where it is ``logarithmic``, by shares from 0 to
    1.
    """

    low: float
    high: float

    @property
    def logarithmic(self) -> bool:
        """Whether the range is divided by its logarithm."""
        raise NotImplementedError

    def value(self, share: float) -> float:
        """Return the value (SI) at a share, which is clipped to 0 and 1; there it is the bound to the bit."""
        share = min(max(share, 0.0), 1.0)
        if share == 1.0:
            return self.high
        value = (
            self.low * power(self.high / self.low, share)
            if self.logarithmic
            else self.low + share * (self.high - self.low)
        )
        return min(max(value, self.low), self.high)

    def share(self, value: float) -> float:
        """Return the share of a value."""
        if self.logarithmic:
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def slope(self, share: float) -> float:
        """Return the derivative of the value by the share."""
        return self.value(share) * log(self.high / self.low) if self.logarithmic else self.high - self.low


@dataclass(frozen=True)
class Axis(Interval):
    """A parameter of a search: from ``low`` to ``high`` (SI), or one of ``values``; ``integer`` ones are
    rounded.
    """

    name: str
    low: float = math.nan
    high: float = math.nan
    logarithmic: bool = False
    values: tuple[float | str, ...] = ()
    integer: bool = False

    @property
    def continuous(self) -> bool:
        """Whether it takes every value between its bounds."""
        return not self.values and not self.integer


@dataclass(frozen=True)
class Search:
    """Minimise the measures ``minimised`` and maximise ``maximised`` over ``axes``, within ``bounds``.

    ``cases``: number of cases; ``refine``: number of further cases for the local search, at most.
    """

    axes: tuple[Axis, ...]
    minimised: tuple[str, ...]
    bounds: tuple[Bound, ...] = ()
    cases: int = 200
    seed: int = 0
    batch: int = BATCH
    maximised: tuple[str, ...] = ()
    refine: int = 0

    @property
    def aims(self) -> tuple[tuple[str, float], ...]:
        """Measures, each with the factor by which less is better."""
        return (*((name, 1.0) for name in self.minimised), *((name, -1.0) for name in self.maximised))

    @property
    def measures(self) -> tuple[str, ...]:
        """Measures that are minimised, maximised or limited, each once."""
        return tuple(
            dict.fromkeys([*(name for name, _ in self.aims), *(bound.measure for bound in self.bounds)])
        )


@dataclass(frozen=True)
class Candidate:
    """A case of a search: its number, its parameters, its measures (None where it failed), whether it keeps
    all limits.
    """

    number: int
    parameters: Parameters
    values: Values | None
    feasible: bool

    def measure(self, name: str) -> float:
        """Return a measure, NaN where it has none."""
        return (self.values or {}).get(name, math.nan)


def candidate(search: Search, number: int, parameters: Parameters, values: Values | None) -> Candidate:
    """Return a case as candidate: feasible if it has all minimised or maximised measures and keeps the
    limits.
    """
    case = Candidate(number, parameters, values, False)
    complete = all(math.isfinite(case.measure(name)) for name, _ in search.aims)
    feasible = complete and all(bound.excess(case.measure(bound.measure)) <= 0.0 for bound in search.bounds)
    return Candidate(number, parameters, values, feasible)


def pareto_front(search: Search, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the feasible candidates that no other dominates, the best of the first measure first; of one
    measure the best candidate.

    Of candidates with equal measures the first is returned.
    """
    first: dict[tuple[float, ...], Candidate] = {}
    for case in candidates:
        if case.feasible:
            first.setdefault(tuple(sign * case.measure(name) for name, sign in search.aims), case)
    points = sorted(first)
    best = front(np.array(points).reshape(len(points), len(search.aims)))
    return [first[values] for values, is_best in zip(points, best, strict=True) if is_best]


def nearest(search: Search, candidates: Sequence[Candidate]) -> Candidate | None:
    """Return the best candidate; where none is feasible, the one that exceeds the limits least, as shares of
    these.
    """
    complete = [
        case for case in candidates if all(math.isfinite(case.measure(name)) for name in search.measures)
    ]

    def excess(case: Candidate) -> float:
        sizes = [
            max((abs(end) for end in (bound.low, bound.high) if math.isfinite(end)), default=0.0) or 1.0
            for bound in search.bounds
        ]
        return sum(
            max(bound.excess(case.measure(bound.measure)), 0.0) / size
            for bound, size in zip(search.bounds, sizes, strict=True)
        )

    return next(iter(pareto_front(search, candidates) or sorted(complete, key=excess)), None)


@dataclass(frozen=True)
class OptimiseTable:
    """The table ``[optimise]``."""

    minimise: tuple[str, ...] = described(
        FreeList(Text()), "measures to minimise; several give a Pareto front", ()
    )
    maximise: tuple[str, ...] = described(FreeList(Text()), "measures to maximise", ())
    cases: int = described(Integer(1, MOST_CASES), "number of cases", 200)
    seed: int = described(Integer(0, 2**31 - 1), "seed of the search: the same seed gives the same search", 1)
    batch: int = described(Integer(1, 4096), "cases computed at the same time", BATCH)
    refine: int = described(
        Integer(0, 10000),
        "largest number of further cases of the local search from the best case of a single measure; 0: none",
        REFINE,
    )


def present_keys(raw: Any) -> Any:
    """Rename the key ``members`` of version 0.2 to ``cases``, with a DeprecationWarning."""
    if not isinstance(raw, Mapping) or "members" not in raw or "cases" in raw:
        return raw
    text = f"members of [{TABLE}] is cases now; the old name will be removed in the next version"
    warnings.warn(text, DeprecationWarning, stacklevel=3)
    return {"cases" if key == "members" else key: value for key, value in raw.items()}


def read_search(tables: StudyTables) -> tuple[Plan, Search]:
    """Read the search of a study file with ``[optimise]``. Raises ModelError with every fault."""
    plan, units = search_plan(tables, TABLE, 'minimise = ["C.force.max"]')
    reader = StudyReader()
    table = reader.table((TABLE,), OptimiseTable, present_keys(tables.raw[TABLE]))
    bounds = read_bounds(tables.raw.get(LIMIT, {}), units, reader)
    minimise, maximise = table.minimise or (), table.maximise or ()
    for key, names in (("minimise", minimise), ("maximise", maximise)):
        for k, name in enumerate(names):
            if key == "maximise" and name in minimise:
                remedy = "leave it out of one of both"
                reader.refuse((TABLE, key, k), "it shall be small as well", shown(name), "", remedy)
    if table.minimise == () == table.maximise:
        limit = "one measure or more, here or in maximise"
        reader.refuse((TABLE, "minimise"), "no measure is minimised or maximised", "[]", limit, "name one")
    axes = []
    for parameter in plan.parameters:
        if parameter.values is not None:
            axes.append(Axis(parameter.name, values=parameter.values))
        elif isinstance(parameter.distribution, Uniform):
            axes.append(
                Axis(
                    parameter.name,
                    *parameter.distribution.limits,
                    integer=isinstance(parameter.field, Integer),
                )
            )
        else:
            message = "a search needs a range or values, and this has a distribution"
            reader.refuse(
                ("vary", parameter.name, ""), message, parameter.words, "from and to, or values", "give these"
            )
    reader.check(tables.source)
    refine = table.refine if len(minimise) + len(maximise) == 1 else 0
    return plan, Search(tuple(axes), minimise, bounds, table.cases, table.seed, table.batch, maximise, refine)


def ask_and_tell(search: Search, evaluate: Evaluate) -> list[Candidate]:
    """Return the candidates that optuna asks for, in order. Raises VfifeError without optuna.

    One measure is minimised by the tree-structured Parzen estimator, several by NSGA-II; both take the limits
    by their excess. All cases of a batch are chosen before any of them is evaluated, so that the search is
    the same on every machine.
    """
    optuna = optuna_module()
    excess: dict[int, list[float]] = {}

    def constraints(trial: Any) -> list[float]:
        return excess[trial.number]

    directions = ["minimize" if sign > 0.0 else "maximize" for _, sign in search.aims]
    study = optuna.create_study(directions=directions, sampler=sampler(optuna, search, constraints))
    space, candidates = {axis.name: distribution(optuna, axis) for axis in search.axes}, list[Candidate]()
    while len(candidates) < search.cases:
        trials = [study.ask(space) for _ in range(min(search.batch, search.cases - len(candidates)))]
        for trial, values in zip(trials, evaluate([dict(trial.params) for trial in trials]), strict=True):
            case = candidate(search, trial.number, dict(trial.params), values)
            excess[trial.number] = [
                min(bound.excess(case.measure(bound.measure)), HUGE) for bound in search.bounds
            ]
            objectives = [case.measure(name) for name, _ in search.aims]
            if all(map(math.isfinite, objectives)):
                study.tell(trial, objectives)
            else:
                study.tell(trial, state=optuna.trial.TrialState.FAIL)
            candidates.append(case)
    return candidates


def distribution(optuna: ModuleType, axis: Axis) -> Any:
    """Return the distribution of optuna for a parameter."""
    if axis.values:
        return optuna.distributions.CategoricalDistribution(list(axis.values))
    return optuna.distributions.FloatDistribution(axis.low, axis.high, log=axis.logarithmic)


def sampler(optuna: ModuleType, search: Search, constraints: Callable[[Any], list[float]]) -> Any:
    """Return the sampler of a search, without the warning that its constraints are experimental."""
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


def optuna_module() -> ModuleType:
    """Return optuna, silenced. Raises VfifeError where it is not installed."""
    try:
        import optuna
    except ImportError:
        raise VfifeError(EXTRA) from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    module: ModuleType = optuna
    return module
