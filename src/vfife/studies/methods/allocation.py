"""The cheapest fits of the joints of a machine with which nearly all machines keep a limit: the tables
``[allocation]`` and ``[cost]``.

Choices of fits are tried from the cheapest on, so the first that passes is the cheapest of all. Trying one to
its end costs hundreds of machines, and one that is far too loose shows it after a few: so several choices are
tried at the same time, each with a few machines first.

The number of choices grows as a power of the number of joints. With ``search = "descent"`` the cheapest
grades that pass in all joints come first, and then joint after joint gets the cheapest fit that still
passes: a few choices for each joint. If none passes in all joints, as where more clearance makes the
measure smaller, the fits that are best by the machines so far come first instead. The answer passes the
same test; a cheaper one may exist. Where less clearance never makes the measure larger, no single joint can
have a cheaper fit.
"""

from __future__ import annotations

import heapq
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...errors import Fault, VfifeError, kind_of, shown
from ...numerics.dense import least_squares
from ...schema import Choice as Word
from ...schema import Integer, Measure, Text, described
from ..engine.study_engine import Engine
from ..spec.distributions import Array, Clearance, Distribution, of_fit, places
from ..spec.limits import CONFIDENCE, Bound, Estimate, allowed_failures, flat, needed, quantile, read_bounds
from ..spec.plan import MOST_CASES, Plan, StudyParameter, case_numbers
from ..spec.study_file import StudyReader, StudyTables, search_plan

GRADE = re.compile(r"IT([0-9]{1,2})")
MOST_CHOICES = 200_000
FIRST = 8  # machines of a choice that are tried before more of them are
WIDTH = 128  # machines that are requested at once
TABLE, COST, LIMIT = "allocation", "cost", "limit"
ALL_CHOICES, DESCENT, SAME_FITS = "all", "descent", "same"
# Returns a measure at rows of clearances (m), one for each joint.
Evaluate = Callable[[Sequence[Sequence[float]]], Array]


@dataclass(frozen=True)
class AllocationTable:
    """The table ``[allocation]``."""

    measure: str = described(Text(), "the measure that has a limit")
    share: float = described(
        Measure("1", above=0.0, high=0.9999), "share of all machines that must keep the limit", 0.99
    )
    confidence: float = described(
        Measure("1", above=0.0, high=0.9999), "confidence with which the sample shows this", CONFIDENCE
    )
    count: int | None = described(
        Integer(1, MOST_CASES), "machines that are drawn; the fewest that can show it unless given", None
    )
    seed: int = described(Integer(0, 2**31 - 1), "which machines are drawn", 1)
    batch: int = described(Integer(FIRST, MOST_CASES), "machines that are simulated at once", WIDTH)
    search: str = described(
        Word((ALL_CHOICES, DESCENT, SAME_FITS)),
        "all choices; or the same grades in all joints; or these first, then cheaper ones joint by joint",
        ALL_CHOICES,
    )

    @property
    def least_count(self) -> int:
        """The fewest machines that can show the share with this confidence."""
        return needed(1.0 - self.share, self.confidence)


@dataclass(frozen=True)
class Option:
    """A fit that a joint may have, its cost, and the distribution of the clearance (m)."""

    name: str
    cost: float
    clearance: Distribution


@dataclass(frozen=True)
class Choice:
    """An option for every joint, and their cost in all."""

    options: tuple[Option, ...]
    cost: float

    @property
    def names(self) -> tuple[str, ...]:
        """The fits."""
        return tuple(option.name for option in self.options)


@dataclass(frozen=True)
class Allotment:
    """An allocation as it was read: the parameters, the options of each (one for a parameter without costs),
    the limit.

    ``chosen``: whether the fit of a parameter is to be chosen.
    """

    parameters: tuple[StudyParameter, ...]
    options: tuple[tuple[Option, ...], ...]
    bound: Bound
    table: AllocationTable
    chosen: tuple[bool, ...]

    def fits(self, choice: Choice) -> dict[str, str]:
        """Return the fits of a choice by the parameters whose fits are to be chosen."""
        return {
            parameter.name: fit
            for parameter, fit, chosen in zip(self.parameters, choice.names, self.chosen, strict=True)
            if chosen
        }


@dataclass(frozen=True)
class Allocated:
    """The cheapest choice that keeps the limit (None where none does), its quantile, its ``failures`` among
    ``count`` machines.

    ``rejected``: choices as cheap or cheaper that do not keep it; ``machines``: cases that were asked for in
    all.
    """

    choice: Choice | None
    estimate: Estimate | None
    failures: int
    count: int
    rejected: tuple[Choice, ...]
    machines: int


def read_allotment(tables: StudyTables) -> tuple[Plan, Allotment]:
    """Read the allocation of a study file. Raises ModelError with every fault."""
    plan, units = search_plan(tables, TABLE, 'measure = "C.force.max"')
    reader = StudyReader()
    table = reader.table((TABLE,), AllocationTable, tables.raw[TABLE])
    limits = tables.raw.get(LIMIT, {})
    bounds = {bound.measure: bound for bound in read_bounds(limits, units, reader)}
    if table.measure is not None and table.measure not in dict(flat(limits)):
        remedy = f'add it under [limit], as in "{table.measure}" = ...'
        reader.refuse(
            (TABLE, "measure"), "it has no limit", shown(table.measure), "a measure of [limit]", remedy
        )
    elif table.measure in bounds and math.isfinite(bounds[table.measure].low):
        message = "an allocation keeps a largest value alone"
        reader.refuse((LIMIT, table.measure, "low"), message, "", "", "leave low out")
    if None not in (table.share, table.confidence, table.count) and table.count < table.least_count:
        reader.add(too_few_machines(table).at((TABLE, "count")))
    costs = tables.raw.get(COST, {})
    costs = costs if isinstance(costs, dict) else {}
    names = [parameter.name for parameter in plan.parameters]
    options = [read_options(parameter, costs.get(parameter.name), reader) for parameter in plan.parameters]
    if not any(name in costs for name in names):
        remedy = "add [cost.NAME] for a parameter with a fit, with a cost for each grade, as in IT7 = 5"
        reader.refuse((COST, ""), "no fit has costs, so there is nothing to choose", "", "", remedy)
    reader.check(tables.source)
    return plan, Allotment(
        plan.parameters, tuple(options), bounds[table.measure], table, tuple(name in costs for name in names)
    )


def too_few_machines(table: AllocationTable) -> Fault:
    """Return the fault of a count of machines that cannot show the share."""
    message = (
        f"too few machines to show {100.0 * table.share:g} % with {100.0 * table.confidence:g} % confidence"
    )
    return Fault(
        "", message, str(table.count), f"at least {table.least_count}", "ask for more, or leave it out"
    )


def read_options(parameter: StudyParameter, costs: Any, reader: StudyReader) -> tuple[Option, ...]:
    """Read the fits that a parameter may have; its own distribution where it has no costs."""
    path = (COST, parameter.name)
    if costs is None:
        if parameter.distribution is None:
            message = "machines are drawn, and this has values"
            reader.refuse(
                ("vary", parameter.name, ""), message, "", "a fit, a tolerance or a distribution", "give one"
            )
            return ()
        return (Option("", 0.0, parameter.distribution),)
    if not isinstance(parameter.distribution, Clearance):
        limit = 'fit = "H8/f7" and diameter in its table of [vary]'
        reader.refuse(path, "costs of what has no fit", "", limit, "add the fit")
        return ()
    faulty_costs = costs
    if isinstance(costs, dict):
        faulty_costs = {
            key: value
            for key, value in costs.items()
            if isinstance(value, bool) or not isinstance(value, int | float)
        }
    if faulty_costs or not isinstance(costs, dict):
        limit = "a number for each grade or fit"
        reader.refuse(
            path, f"this is {kind_of(costs)}", shown(faulty_costs), limit, "write them as in IT7 = 5"
        )
        return ()
    fit = parameter.distribution.fit
    letters = "/".join(name.rstrip("0123456789") for name in (fit.hole.name, fit.shaft.name))
    try:
        return tuple(options_of(letters, fit.diameter, costs))
    except Fault as fault:
        reader.add(fault.at(path))
        return ()


def options_of(letters: str, diameter: float, costs: Mapping[str, float]) -> list[Option]:
    """Return the fits that a joint may have, cheapest first.

    ``costs`` has either fits ("H8/f7"), or grades ("IT7"), each with the cost of a hole or a shaft: then the
    options are those of ``letters`` as in "H/f", in every pair of a hole with a shaft of its own grade or of
    the next finer one. Raises Fault.
    """
    if not costs:
        raise Fault("", "no costs", "", 'a cost for each grade, as in "IT7" = 5, or for each fit', "add them")
    for name, cost in costs.items():
        if not (math.isfinite(cost) and cost >= 0.0):
            raise Fault("", "an invalid cost", f"{name} = {cost:g}", "0 or more", "correct it")
    fits = costs.items() if all("/" in name for name in costs) else fits_of_grades(letters, costs)
    options = [Option(name, float(cost), of_fit(name, diameter)) for name, cost in fits]
    return sorted(options, key=lambda option: (option.cost, option.clearance.limits[1], option.name))


def fits_of_grades(letters: str, costs: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Yield the fits of the grades that have a cost, and their costs. Raises Fault."""
    hole_letter, _, shaft_letter = letters.partition("/")
    if not hole_letter.isupper() or not shaft_letter.islower() or "/" in shaft_letter:
        limit = "that of the hole, a slash, that of the shaft"
        raise Fault("", "not the letters of a fit", f'"{letters}"', limit, 'write them as in "H/f"')
    grades = {}
    for name, cost in costs.items():
        if (match := GRADE.fullmatch(name)) is None:
            limit = '"IT7" or "H8/f7", all of one kind'
            raise Fault("", "neither a grade nor a fit", f'"{name}"', limit, "correct the name")
        grades[int(match[1])] = cost
    for hole, shaft in itertools.product(sorted(grades), repeat=2):
        if hole - 1 <= shaft <= hole:
            yield f"{hole_letter}{hole}/{shaft_letter}{shaft}", grades[hole] + grades[shaft]


def by_cost(joints: Sequence[Sequence[Option]]) -> Iterator[Choice]:
    """Yield every combination of the options of the joints, the cheapest first. The options of a joint are in
    the order of their costs.

    A heap holds the combinations that are one step dearer in one joint than one that was yielded: so it stays
    small, where sorting all of them would need as many as there are.
    """

    def entry(chosen: tuple[int, ...]) -> tuple[float, tuple[int, ...]]:
        return math.fsum(options[k].cost for options, k in zip(joints, chosen, strict=True)), chosen

    start = (0,) * len(joints)
    heap, visited = [entry(start)], {start}
    while heap:
        cost, chosen = heapq.heappop(heap)
        yield Choice(tuple(options[k] for options, k in zip(joints, chosen, strict=True)), cost)
        for joint, k in enumerate(chosen):
            dearer = (*chosen[:joint], k + 1, *chosen[joint + 1 :])
            if k + 1 < len(joints[joint]) and dearer not in visited:
                visited.add(dearer)
                heapq.heappush(heap, entry(dearer))


@dataclass
class Trial:
    """A choice under trial: the clearances of its machines, a row each, and the values of those that were
    run.
    """

    choice: Choice
    clearances: Array
    values: Array = field(default_factory=lambda: np.empty(0))

    def failures(self, limit: float) -> int:
        """Count the machines beyond the limit, or without a value."""
        return int(np.count_nonzero(~(self.values <= limit)))

    def next(self, limit: int) -> Array:
        """Return clearances of the next machines: as many again as were run, eight at first, no more than
        there is room for.
        """
        start = len(self.values)
        return self.clearances[start : start + min(max(FIRST, start), limit)]


@dataclass
class Trials:
    """Trials of choices with the same machines: clearances ``drawn`` (m) by option, the number of failures
    ``allowed`` among ``count`` machines, the choices that were ``rejected``, and how many ``machines`` were
    run.
    """

    drawn: Mapping[int, Array]
    evaluate: Evaluate
    limit: float
    count: int
    allowed: int
    width: int
    rejected: list[Choice] = field(default_factory=list)
    machines: int = 0
    trials: list[Trial] = field(default_factory=list)

    def cheapest(self, choices: Iterator[Choice]) -> Trial | None:
        """Return the trial of the first of the choices that passes, None where none does."""
        trials = list[Trial]()
        while True:
            for choice in itertools.islice(choices, max(0, self.width // FIRST - len(trials))):
                columns = [self.drawn[id(option)] for option in choice.options]
                trials.append(Trial(choice, np.stack(columns, axis=1)))
                self.trials.append(trials[-1])
            if not trials:
                return None
            self.machines += run_machines(trials, self.evaluate, self.width)
            failing = [trial.failures(self.limit) > self.allowed for trial in trials]
            self.rejected += [trial.choice for trial, failed in zip(trials, failing, strict=True) if failed]
            trials = [trial for trial, failed in zip(trials, failing, strict=True) if not failed]
            if trials and len(trials[0].values) == self.count:  # the cheapest of those that are left
                return trials[0]

    def favourable(self, joints: Sequence[Sequence[Option]]) -> Iterator[Choice]:
        """Yield the choice that makes the measure least by a plane through the values of all machines that
        were run: of each joint the fit with the least clearance, or with the largest where more of it makes
        the measure smaller. None where too few machines have a value.
        """
        rows = np.concatenate([trial.clearances[: len(trial.values)] for trial in self.trials])
        values = np.concatenate([trial.values for trial in self.trials])
        finite = np.isfinite(values)
        scale = np.ptp(rows, axis=0)
        if np.count_nonzero(finite) < 2 * (1 + len(joints)) or not (scale > 0.0).all():
            return
        plane = np.column_stack([np.ones(np.count_nonzero(finite)), rows[finite] / scale])
        slopes = least_squares(plane, values[finite])[1:]
        chosen = tuple(
            max(options, key=mean_clearance) if slope < 0.0 else min(options, key=mean_clearance)
            for options, slope in zip(joints, slopes.tolist(), strict=True)
        )
        yield Choice(chosen, math.fsum(option.cost for option in chosen))

    def answer(self, trial: Trial | None, share: float) -> Allocated:
        """Return the answer with a trial that passed."""
        if trial is None:
            return Allocated(None, None, 0, self.count, tuple(self.rejected), self.machines)
        estimate = quantile(np.where(np.isfinite(trial.values), trial.values, math.inf), share)
        cheaper = tuple(choice for choice in self.rejected if choice.cost <= trial.choice.cost)
        failures = trial.failures(self.limit)
        return Allocated(trial.choice, estimate, failures, self.count, cheaper, self.machines)


def allocate(
    joints: Sequence[Sequence[Option]], evaluate: Evaluate, limit: float, table: AllocationTable
) -> Allocated:
    """Find the cheapest choice with which a measure is at most ``limit`` in a share of all machines.

    Of every choice the same ``table.count`` machines are drawn, independent ones, those with most clearance
    first. A choice is rejected as soon as more of them are beyond the limit (or without a value) than show
    the share with this confidence, and taken when all have been run. With ``table.search`` "same" only
    choices with the same grades in all joints are tried; with "descent" the most favourable fits if all of
    these fail, then cheaper fits of one joint after another follow, in the order of the joints.
    ``evaluate`` gets ``table.batch`` rows at once, and may get the same row again. Raises Fault for a count
    too small to show the share, VfifeError for more choices than can be tried.
    """
    count = table.count or table.least_count
    allowed = allowed_failures(count, 1.0 - table.share, table.confidence)
    if allowed < 0:
        raise too_few_machines(table)
    combinations = math.prod(map(len, joints))
    if table.search == ALL_CHOICES and combinations > MOST_CHOICES:
        raise VfifeError(
            f"{combinations:,} choices of fits are more than {MOST_CHOICES:,}; leave grades or joints out, or"
            f' write search = "{DESCENT}" under [{TABLE}]'
        )
    unit = places("random", count, len(joints), table.seed)
    unit = unit[np.argsort(-unit.sum(axis=1), kind="stable")]
    # The clearances of all machines with each option, which choices share.
    drawn = {
        id(option): option.clearance.quantile(unit[:, k])
        for k, options in enumerate(joints)
        for option in options
    }
    trials = Trials(drawn, evaluate, limit, count, allowed, table.batch)
    if table.search == ALL_CHOICES:
        return trials.answer(trials.cheapest(by_cost(joints)), table.share)
    best = trials.cheapest(same_grades(joints))
    if best is None and table.search == DESCENT:
        best = trials.cheapest(trials.favourable(joints))
    for joint in range(len(joints) if best is not None and table.search == DESCENT else 0):
        best = trials.cheapest(cheaper_in(joint, best.choice, joints)) or best  # type: ignore[union-attr]
    return trials.answer(best, table.share)


def mean_clearance(option: Option) -> float:
    """Return the mean of the limits (m) of a clearance."""
    return 0.5 * sum(option.clearance.limits)


def same_grades(joints: Sequence[Sequence[Option]]) -> Iterator[Choice]:
    """Return the choices in which all joints with several options have the same fit, or where their letters
    differ the same grades, the cheapest first. Raises VfifeError where joints have no grades in common.
    """
    for key in (lambda option: option.name, lambda option: tuple(re.findall("[0-9]+", option.name))):
        tables = [{key(option): option for option in options} for options in joints]
        varied_tables = [table for table in tables if len(table) > 1]
        common = [
            name for name in (varied_tables or tables)[0] if all(name in table for table in varied_tables)
        ]
        if common:
            break
    else:
        raise VfifeError('joints have no grades in common; give all the same costs, or write search = "all"')
    choices = []
    for name in common:
        options = tuple(table.get(name) or next(iter(table.values())) for table in tables)
        choices.append(Choice(options, math.fsum(option.cost for option in options)))
    return iter(sorted(choices, key=lambda choice: choice.cost))


def cheaper_in(joint: int, choice: Choice, joints: Sequence[Sequence[Option]]) -> Iterator[Choice]:
    """Yield the choices with a cheaper fit of a joint, the cheapest first."""
    for option in joints[joint]:
        if option.cost < choice.options[joint].cost:
            options = (*choice.options[:joint], option, *choice.options[joint + 1 :])
            yield Choice(options, math.fsum(option.cost for option in options))


def machine_counts(task: Allotment) -> tuple[int, int]:
    """Return how many machines are simulated at least and, unless some choices are close to the limit, at
    most.
    """
    machines, choices = task.table.count or task.table.least_count, math.prod(map(len, task.options))
    if task.table.search == ALL_CHOICES:
        smallest_count = fewest_machines(machines, choices, task.table.batch)
        return smallest_count, max(smallest_count, machines + FIRST * (choices - 1))
    grades = max(map(len, task.options))
    common = FIRST * (grades - 1) + machines
    joint_count = sum(len(options) > 1 for options in task.options) if task.table.search == DESCENT else 0
    return FIRST * (grades + (task.table.search == DESCENT)), common + joint_count * machines


def expected_machines(task: Allotment) -> int:
    """Return the number of machines of a forecast: the geometric mean of fewest and most, since either may be
    some times as many.
    """
    return round(math.sqrt(math.prod(machine_counts(task))))


def most_machines(task: Allotment) -> int:
    """Return how many machines are simulated if all choices that are tried are close to the limit."""
    machines = task.table.count or task.table.least_count
    if task.table.search == ALL_CHOICES:
        return machines * math.prod(map(len, task.options))
    descents = sum(len(options) - 1 for options in task.options) if task.table.search == DESCENT else 0
    return machines * (max(map(len, task.options)) + descents)


def fewest_machines(machines: int, choices: int, batch: int) -> int:
    """Return how many machines are simulated where the cheapest of all choices is taken: batches in which it
    has 8, 8, 16, 32 ... machines, and others have the rest.
    """
    rounds = 1 + (-(-machines // FIRST) - 1).bit_length()
    return min(rounds * batch, machines * choices)


def run_machines(trials: Sequence[Trial], evaluate: Evaluate, width: int) -> int:
    """Run the next machines of the trials, the cheapest choice first, others while there is room; return how
    many were run.
    """
    batches = list[Array]()
    for trial in trials:
        batches.append(trial.next(width - sum(map(len, batches))))
    values = evaluate(np.concatenate(batches).tolist())
    for trial, part in zip(
        trials, np.split(values, np.cumsum([len(batch) for batch in batches])[:-1]), strict=True
    ):
        trial.values = np.concatenate([trial.values, part])
    return len(values)


def allocate_fits(engine: Engine, task: Allotment) -> Allocated:
    """Allocate fits, the machines being cases of a study file. Raises VfifeError."""
    names, measure = [parameter.name for parameter in task.parameters], task.bound.measure

    def evaluate(rows: Sequence[Sequence[float]]) -> Array:
        outcomes = engine.ask(
            [case_numbers(task.parameters, dict(zip(names, row, strict=True))) for row in rows]
        )
        return np.array(
            [math.nan if outcome is None else outcome.get(measure, math.nan) for outcome in outcomes]
        )

    return allocate(task.options, evaluate, task.bound.high, task.table)
