"""Forecasts of studies and searches: how many cases are left, and their time and bytes.

The time of a step and of assembling a case follow from a cost table; where a study takes longer than a few
seconds, a few of its cases are run for a turn first.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..compiler.runtime.native import CONTACT_LANES, stream_lanes
from ..errors import VfifeError
from ..job.cost import LONG, WORTH, Forecast, Stream, cores, pilot, run_cost, stream, timed_step
from ..job.progress import counted, span
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.parameter import Parameter
from ..results.case_errors import sample_size
from ..results.study import Study
from ..store.studyfile import hash_of
from .engine.cases import run_cases
from .engine.lanes import streams
from .engine.study_engine import RATIO
from .methods.allocation import FIRST, Allotment
from .methods.local_search import derivatives_impossible
from .methods.optimise import Search
from .spec.plan import Numbers, Plan, StudySpec, case_numbers
from .spec.study_file import remark_on_last

SAMPLE_CASES = 8  # cases by which the others are judged; every third of them is assembled
PILOT_TURNS = 6  # turns of each in all, where they are run
PILOT_SHARE, PILOT_SECONDS = 0.1, 1.0  # of the work, or s, that this may take
CASE_BYTES, NUMBER_BYTES = 400, 60  # of a case in its file, and of each number that it has or leaves
MOST_KINDS = 12
PARTS = 360  # of a turn; cases go into lanes where it has a whole number of steps in each
# s to choose a case, and for each other one: Parzen estimators, NSGA-II; measured with three parameters
CHOOSING = (2e-3, 6e-6), (6e-4, 0.0)
LOCAL_SHARE = 0.3  # of the time that a local search may take, until it converges
DISPLACED = 2  # runs of which derivatives are the mean
TANGENT = 1.6  # time that derivatives by one number take, by that of a lane's own steps
REMEDY = "ask for fewer cases or turns"


@dataclass(frozen=True)
class CasesLeft:
    """The cases of a study that are still to run: ``some`` of them, how many are ``left`` and ``done``, and
    the ``width``, how many run at once.
    """

    plan: Plan
    numbers: Sequence[Numbers]
    left: int
    done: int
    width: float = math.inf

    def forecast(self) -> Forecast:
        """Return the forecast of their runs. Lanes are not used if a given step does not divide the turn into
        whole outputs.
        """
        every = [one for numbers in self.numbers[::3] if (one := self.assembled(numbers)) is not None]
        if not every or not self.left:
            return Forecast("case", self.left, done=self.done, less=REMEDY)
        unfit = {one.choice.turn for one in every if not streams(one) and not one.choice.automatic} - {None}
        single = bool(unfit or self.plan.spec.duration)
        lanes = 1 if single else stream_lanes(max(len(one.topology.contact_bearing) for one in every))
        seconds = sum(stream(one, self.width, lanes).seconds(self.left) for one in every) / len(every)
        if WORTH < seconds < LONG:
            seconds = self.timed(every, seconds, lanes).seconds(self.left)
        steps = sum(one.choice.steps for one in every) / len(every)
        disk = self.left * (CASE_BYTES + NUMBER_BYTES * len(self.numbers[0]))
        remarks = [text] if (text := remark_on_last(self.plan.spec)) else []
        remarks += [remark_on_step({turn for turn in unfit if turn}, self.plan.spec)] if unfit else []
        return Forecast(
            "case", self.left, steps, seconds, disk=disk, done=self.done, threads=cores(), lanes=lanes,
            less=REMEDY, remarks=tuple(remarks),
        )  # fmt: skip

    def assembled(self, numbers: Numbers) -> Assembly | None:
        """Assemble a case; None where it cannot be, which is reported when it is run."""
        spec = self.plan.spec
        with suppress(VfifeError):
            mechanism = loads(dump(self.plan.base), set=list(numbers.items()))
            return assemble(mechanism, spec.step, **spec.of_case().length)
        return None

    def timed(self, every: Sequence[Assembly], seconds: float, lanes: int) -> Stream:
        """Return the stream of the cases, timed by running a few of them if that is a small share of the
        work, else from the steps of one.
        """
        turns, some = self.plan.spec.turns, self.numbers[: round(min(self.width, self.left))]
        share = len(some) * min(PILOT_TURNS, 3 * turns) / (self.left * turns)
        if self.plan.spec.duration or (share > PILOT_SHARE and share * seconds > PILOT_SECONDS):
            one = stream(every[0], self.width, lanes)
            stepping = one.stepping * 1e9 * timed_step(every[0]) / run_cost(every[0]).ns_per_step
            return dataclasses.replace(one, stepping=stepping)

        def once(turns: int) -> None:
            brief = dataclasses.replace(self.plan.spec.of_case(), turns=turns, last=1, settle=None)
            for _ in run_cases(self.plan.base, some, brief):
                pass

        return pilot(once, turns, len(some), self.width)


def remark_on_step(turns: set[float], spec: StudySpec) -> str:
    """Return a sentence on cases that go into no lanes because of their step, and a step that fits."""
    what = f"a turn of the crank is no whole number of outputs at the step that is given, {spec.step:g} s"
    what = f"{what}: cases run one by one, not in lanes"
    if len(turns) > 1:
        return f'{what}; with step = "auto" many more run in a second.'
    (turn,) = turns
    step = turn / (PARTS * math.ceil(turn / (spec.step or turn) / PARTS))
    return f'{what}; with step = "{step!r} s" or "auto" many more run in a second.'


def some_of(numbers: Sequence[Numbers]) -> list[Numbers]:
    """Return some of many cases: the first, the last and some between them."""
    count = min(SAMPLE_CASES, len(numbers))
    return [numbers[k * (len(numbers) - 1) // max(count - 1, 1)] for k in range(count)]


def finished(file: Path | None) -> set[str]:
    """Return the hashes of the cases that have ended in a study file."""
    return {one.hash for one in Study.open(file).done} if file is not None and file.is_file() else set()


def study_forecast(plan: Plan, file: Path | None, retry: bool = False) -> Forecast:
    """Forecast the cases of a plan that the file does not have, and the sample of them that is repeated."""
    numbers, hashes = plan.numbers(), finished(file)
    left = [one for one in numbers if hash_of(one) not in hashes]
    cases = CasesLeft(plan, some_of(left), len(left), len(numbers) - len(left)).forecast()
    if not left:
        what = f"nothing is left to compute: all {len(numbers):,} cases are in {file}."
        return dataclasses.replace(cases, remarks=() if retry else (what,))
    repeated = 1.0 + sample_size(len(numbers)) / (RATIO * len(left))
    remarks = (*cases.remarks, *remarks_on_kinds(numbers, plan.base))
    return dataclasses.replace(cases, seconds=repeated * cases.seconds, remarks=remarks)


def search_forecast(plan: Plan, search: Search, file: Path | None) -> Forecast:
    """Forecast an optimisation: its cases, the time to choose them, and the local search."""

    def at(share: float) -> dict[str, float | str]:
        values = {one.name: one.values[int(share * len(one.values))] for one in search.axes if one.values}
        return {one.name: values[one.name] if one.values else one.value(share) for one in search.axes}

    some = [case_numbers(plan.parameters, at((k + 0.5) / SAMPLE_CASES)) for k in range(SAMPLE_CASES)]
    done = min(len(finished(file)), search.cases)
    cases = CasesLeft(plan, some, search.cases - done, done, search.batch)
    forecast, refining = cases.forecast(), local_search_seconds(cases, search)
    first, each = CHOOSING[len(search.aims) > 1]
    choosing = search.cases * (first + each * search.cases)  # those that are known are chosen again
    further = counted(search.refine, "case")
    parts = (
        (f"up to {further} more by derivatives, which take {span(refining)} at most.",) if refining else ()
    )
    seconds = forecast.seconds + choosing + LOCAL_SHARE * refining
    return dataclasses.replace(forecast, seconds=seconds, parts=parts)


def local_search_seconds(cases: CasesLeft, search: Search) -> float:
    """Return the time (s) of the cases of a local search, each with its derivatives: two runs, and its steps
    with derivatives.
    """
    if not search.refine or derivatives_impossible(search):
        return 0.0
    names = {axis.name for axis in search.axes if axis.continuous}
    paths = sum(len(one.paths) for one in cases.plan.parameters if one.name in names)
    for numbers in cases.numbers:
        if (assembly := cases.assembled(numbers)) is not None:
            directions = TANGENT * paths * (DISPLACED if assembly.contacts else 1) / CONTACT_LANES
            seconds = timed_step(assembly) * assembly.choice.steps
            return search.refine * seconds * (3.0 + directions)
    return 0.0


def allotment_forecast(plan: Plan, task: Allotment, file: Path | None) -> Forecast:
    """Forecast an allocation: all machines of one choice, and the first few of each other choice."""
    machines, choices = task.table.count or task.table.least_count, math.prod(map(len, task.options))
    shares, numbers = [(k + 0.5) / SAMPLE_CASES for k in range(SAMPLE_CASES)], []
    options = zip(task.parameters, task.options, strict=True)
    clearances = {one.name: each[0].clearance for one, each in options}
    for share in shares:
        values = {name: float(clearance.quantile(share)) for name, clearance in clearances.items()}
        numbers.append(case_numbers(plan.parameters, values))
    least = fewest_machines(machines, choices, task.table.batch)
    most = max(least, machines + FIRST * (choices - 1))
    count = (least + most) // 2  # between the cheapest choice and the dearest
    done = min(len(finished(file)), count)
    cases = CasesLeft(plan, numbers, count - done, done, task.table.batch).forecast()
    remark = (
        f"{counted(choices, 'choice')} of fits: some {least:,} machines where the cheapest is taken, {most:,}"
        f" where the dearest is, more where some are close to the limit, {machines * choices:,} at most."
    )
    return dataclasses.replace(cases, remarks=(*cases.remarks, remark) if cases.count else ())


def fewest_machines(machines: int, choices: int, batch: int) -> int:
    """Return how many machines are simulated where the cheapest of the choices is taken: batches in which it
    has 8, 8, 16, 32 ... machines, and others have the rest.
    """
    rounds = 1 + (-(-machines // FIRST) - 1).bit_length()
    return min(rounds * batch, machines * choices)


def remarks_on_kinds(numbers: Sequence[Numbers], base: Mechanism) -> tuple[str, ...]:
    """Return a sentence on cases that differ in words or whole numbers, and so share no lanes."""
    paths = [path for path in next(iter(numbers), {}) if Parameter(base, path).quantity is None]
    kinds = Counter(tuple(one[path] for path in paths) for one in numbers)
    if not paths or len(kinds) < 2:
        return ()
    listed = []
    for values, count in list(kinds.items())[:MOST_KINDS]:
        words = (f"{one:g}" if isinstance(one, float) else one for one in values)
        named = ", ".join(f"{path} = {word}" for path, word in zip(paths, words, strict=True))
        listed.append(f"{named}: {count:,}")
    rest = "; ..." if len(kinds) > MOST_KINDS else ""
    what = f"cases of {len(kinds)} kinds are run group by group, each with its own compiled step"
    return (f"{what} ({'; '.join(listed)}{rest}).",)
