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
from .engine.step_trials import trials_cost
from .engine.study_engine import RATIO
from .methods.allocation import (
    ALL_CHOICES,
    SAME_FITS,
    Allotment,
    expected_machines,
    machine_counts,
    most_machines,
)
from .methods.derivatives import DISPLACED, TANGENT
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
REMEDY = "ask for fewer cases or turns"


@dataclass(frozen=True)
class CasesLeft:
    """The cases of a study that are still to run: the ``numbers`` of a few of them, how many are ``left`` and
    ``done``, and the ``width``, how many run at once.
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
        assemblies = [
            assembly for numbers in self.numbers[::3] if (assembly := self.assembled(numbers)) is not None
        ]
        if not assemblies or not self.left:
            return Forecast("case", self.left, done=self.done, remedy=REMEDY)
        unfit = {
            assembly.choice.turn
            for assembly in assemblies
            if not streams(assembly) and not assembly.choice.automatic
        } - {None}
        single = bool(unfit or self.plan.spec.duration)
        lanes = (
            1
            if single
            else stream_lanes(max(len(assembly.topology.contact_bearing) for assembly in assemblies))
        )
        seconds = sum(
            stream(assembly, self.width, lanes).seconds(self.left) for assembly in assemblies
        ) / len(assemblies)
        if WORTH < seconds < LONG:
            seconds = self.timed(assemblies, seconds, lanes).seconds(self.left)
        steps = sum(assembly.choice.steps for assembly in assemblies) / len(assemblies)
        disk = self.left * (CASE_BYTES + NUMBER_BYTES * len(self.numbers[0]))
        remarks = [text] if (text := remark_on_last(self.plan.spec)) else []
        remarks += [remark_on_step({turn for turn in unfit if turn}, self.plan.spec)] if unfit else []
        return Forecast(
            "case", self.left, steps, seconds, disk=disk, done=self.done, threads=cores(), lanes=lanes,
            remedy=REMEDY, remarks=tuple(remarks),
        )  # fmt: skip

    def assembled(self, numbers: Numbers) -> Assembly | None:
        """Assemble a case; None where it cannot be, which is reported when it is run."""
        spec = self.plan.spec
        with suppress(VfifeError):
            mechanism = loads(dump(self.plan.base), set=list(numbers.items()))
            return assemble(mechanism, spec.step, **spec.of_case().length)
        return None

    def timed(self, assemblies: Sequence[Assembly], seconds: float, lanes: int) -> Stream:
        """Return the stream of the cases, timed by running a few of them if that is a small share of the
        work, else from the steps of one.
        """
        turns, sample = self.plan.spec.turns, self.numbers[: round(min(self.width, self.left))]
        share = len(sample) * min(PILOT_TURNS, 3 * turns) / (self.left * turns)
        if self.plan.spec.duration or (share > PILOT_SHARE and share * seconds > PILOT_SECONDS):
            table_stream = stream(assemblies[0], self.width, lanes)
            stepping = (
                table_stream.stepping * 1e9 * timed_step(assemblies[0]) / run_cost(assemblies[0]).ns_per_step
            )
            return dataclasses.replace(table_stream, stepping=stepping)

        def run_sample(turns: int) -> None:
            brief = dataclasses.replace(self.plan.spec.of_case(), turns=turns, last=1, settle=None)
            for _ in run_cases(self.plan.base, sample, brief):
                pass

        return pilot(run_sample, turns, len(sample), self.width)


def remark_on_step(turns: set[float], spec: StudySpec) -> str:
    """Return a sentence on cases that go into no lanes because of their step, and a step that fits."""
    remark = f"a turn of the crank is no whole number of outputs at the step that is given, {spec.step:g} s"
    remark = f"{remark}: cases run one by one, not in lanes"
    if len(turns) > 1:
        return f'{remark}; with step = "auto" many more run in a second.'
    (turn,) = turns
    step = turn / (PARTS * math.ceil(turn / (spec.step or turn) / PARTS))
    return f'{remark}; with step = "{step!r} s" or "auto" many more run in a second.'


def some_of(numbers: Sequence[Numbers]) -> list[Numbers]:
    """Return some of many cases: the first, the last and some between them."""
    count = min(SAMPLE_CASES, len(numbers))
    return [numbers[k * (len(numbers) - 1) // max(count - 1, 1)] for k in range(count)]


def finished(file: Path | None) -> set[str]:
    """Return the hashes of the cases that have ended in a study file."""
    return {case.hash for case in Study.open(file).done} if file is not None and file.is_file() else set()


def study_forecast(plan: Plan, file: Path | None, retry: bool = False) -> Forecast:
    """Forecast the cases of a plan that the file does not have, and the sample of them that is repeated: with
    one other step, and with further ones as a note, because only the first shows whether they are needed.
    """
    numbers, hashes = plan.numbers(), finished(file)
    left = [case for case in numbers if hash_of(case) not in hashes]
    cases = CasesLeft(plan, some_of(left), len(left), len(numbers) - len(left)).forecast()
    if not left:
        remark = f"nothing is left to compute: all {len(numbers):,} cases are in {file}."
        return dataclasses.replace(cases, remarks=() if retry else (remark,))
    seconds, note = cases.seconds, ""
    if plan.base.settings.analysis != "static":
        sample = sample_size(len(numbers))
        regular, different = (1.0 / RATIO + trials_cost(sample, scatter) for scatter in (False, True))
        of_sample = sample / len(left) * cases.seconds
        seconds += regular * of_sample
        note = f"; {span((different - regular) * of_sample)} more if the motion is sensitive to the step"
    remarks = (*cases.remarks, *remarks_on_kinds(numbers, plan.base))
    return dataclasses.replace(cases, seconds=seconds, remarks=remarks, note=note)


def search_forecast(plan: Plan, search: Search, file: Path | None) -> Forecast:
    """Forecast an optimisation: its cases, the time to choose them, and the local search."""

    def at(share: float) -> dict[str, float | str]:
        return {
            axis.name: axis.values[int(share * len(axis.values))] if axis.values else axis.value(share)
            for axis in search.axes
        }

    sample = [case_numbers(plan.parameters, at((k + 0.5) / SAMPLE_CASES)) for k in range(SAMPLE_CASES)]
    done = min(len(finished(file)), search.cases)
    cases = CasesLeft(plan, sample, search.cases - done, done, search.batch)
    forecast, refining = cases.forecast(), local_search_seconds(cases, search)
    case_seconds, pair_seconds = CHOOSING[len(search.aims) > 1]
    choosing = search.cases * (
        case_seconds + pair_seconds * search.cases
    )  # those that are known are chosen again
    refined_cases = counted(search.refine, "case")
    parts = (
        (f"up to {refined_cases} more by derivatives, which take {span(refining)} at most.",)
        if refining
        else ()
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
    paths = sum(len(parameter.paths) for parameter in cases.plan.parameters if parameter.name in names)
    for numbers in cases.numbers:
        if (assembly := cases.assembled(numbers)) is not None:
            directions = TANGENT * paths * (DISPLACED if assembly.contacts else 1) / CONTACT_LANES
            seconds = timed_step(assembly) * assembly.choice.steps
            return search.refine * seconds * (3.0 + directions)
    return 0.0


def allotment_forecast(plan: Plan, task: Allotment, file: Path | None) -> Forecast:
    """Forecast an allocation: all machines of one choice, and the first few of each other choice."""
    shares, numbers = [(k + 0.5) / SAMPLE_CASES for k in range(SAMPLE_CASES)], []
    options = zip(task.parameters, task.options, strict=True)
    clearances = {parameter.name: fits[0].clearance for parameter, fits in options}
    for share in shares:
        values = {name: float(clearance.quantile(share)) for name, clearance in clearances.items()}
        numbers.append(case_numbers(plan.parameters, values))
    count = expected_machines(task)
    done = min(len(finished(file)), count)
    cases = CasesLeft(plan, numbers, count - done, done, task.table.batch).forecast()
    if not cases.count:
        return dataclasses.replace(cases, remarks=())
    remark = allotment_remark(task, cases.seconds / cases.count)
    return dataclasses.replace(cases, remarks=(*cases.remarks, remark))


def allotment_remark(task: Allotment, seconds: float) -> str:
    """Return a sentence on the machines of an allocation, each of which takes ``seconds`` on all cores."""
    choices = math.prod(map(len, task.options))
    (smallest_count, largest_count), limit = machine_counts(task), most_machines(task)
    largest = f"{largest_count:,} ({span(largest_count * seconds)})"
    if task.table.search == ALL_CHOICES:
        return (
            f"{counted(choices, 'choice')} of fits: about {smallest_count:,} machines where the cheapest is"
            f" taken, {largest} where the dearest is, more where some are close to the limit,"
            f" {limit:,} ({span(limit * seconds)}) at most."
        )
    order = "" if task.table.search == SAME_FITS else ", then cheaper ones joint by joint"
    return (
        f"the same grades in all joints{order}: about {smallest_count:,} machines where none keeps the limit,"
        f" {largest} where some do, more where some are close to the limit, {limit:,}"
        f" ({span(limit * seconds)}) at most."
    )


def remarks_on_kinds(numbers: Sequence[Numbers], base: Mechanism) -> tuple[str, ...]:
    """Return a sentence on cases that differ in words or whole numbers, and so share no lanes."""
    paths = [path for path in next(iter(numbers), {}) if Parameter(base, path).quantity is None]
    kinds = Counter(tuple(case[path] for path in paths) for case in numbers)
    if not paths or len(kinds) < 2:
        return ()
    listed = []
    for values, count in list(kinds.items())[:MOST_KINDS]:
        words = (f"{value:g}" if isinstance(value, float) else value for value in values)
        named = ", ".join(f"{path} = {word}" for path, word in zip(paths, words, strict=True))
        listed.append(f"{named}: {count:,}")
    ellipsis = "; ..." if len(kinds) > MOST_KINDS else ""
    remark = f"cases of {len(kinds)} kinds are run group by group, each with its own compiled step"
    return (f"{remark} ({'; '.join(listed)}{ellipsis}).",)
