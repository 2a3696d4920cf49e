"""Forecasts of studies and searches: how many cases are left, and what they take; a few of them are run for a
turn where there are many.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..compiler.runtime.native import CONTACT_LANES, stream_lanes
from ..errors import VfifeError
from ..job.amounts import counted, span
from ..job.cost import LONG, WORTH, Forecast, Stream, cores, pilot, run_cost, stream, timed_step
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.parameter import Parameter
from ..results.studied import Study
from ..store.member_errors import sample_size
from ..store.studyfile import hash_of
from .engine.cases import run_members, streams
from .engine.run_missing import RATIO
from .engine.study_file import beside_last, wanted_of
from .methods.allocation import FIRST
from .methods.local_search import refuses
from .methods.optimise import Search
from .methods.searches import WIDTH, Allotment, numbers_at
from .spec.limits import needed
from .spec.plan import Asked, Plan

Numbers = Mapping[str, float | str]

LOOKED_AT = 8  # cases that are looked at for a forecast; every third of them is assembled
PILOT_TURNS = 6  # turns of each in all, where they are run
PILOT_SHARE, PILOT_SECONDS = 0.1, 1.0  # of the work, or s, that this may take
BYTES = 400, 60  # of a case in its file, and of each number that it has or leaves
MOST_KINDS = 12
PARTS = 360  # of a turn; cases go into lanes where it has a whole number of steps in each
CHOOSING = (
    (2e-3, 6e-6),
    (6e-4, 0.0),
)  # s to choose a case, and for each other one; Parzen estimators, NSGA-II; measured with three parameters
DISPLACED = 2  # runs of which derivatives are the mean
TANGENT = 1.6  # time that derivatives by one number take, by that of a lane's own steps
LESS = "ask for fewer members or turns"


@dataclass(frozen=True)
class Cases:
    """Cases of a study that are to be run: some of them as an example, how many are left and known, how many
    are asked for at once.
    """

    plan: Plan
    some: Sequence[Numbers]
    left: int
    known: int
    width: float = math.inf

    def forecast(self, place: Path | None) -> Forecast:
        """Their forecast; cases of which a turn holds no whole number of outputs, as a given step may have
        it, go into no lanes.
        """
        every = [one for numbers in self.some[::3] if (one := self.assembled(numbers)) is not None]
        if not every or not self.left:
            return Forecast("member", self.left, known=self.known, less=LESS)
        unfit = {
            one.choice.turn
            for one in every
            if not streams(one) and not one.choice.automatic and one.choice.turn is not None
        }
        contacts = max(len(one.topology.contact_bearing) for one in every)
        lanes = 1 if unfit else stream_lanes(contacts)
        seconds = sum(stream(one, self.width, lanes).seconds(self.left) for one in every) / len(every)
        if WORTH < seconds < LONG:
            seconds = self.measured(every, seconds, lanes).seconds(self.left)
        first, each = BYTES
        return Forecast(
            "member", self.left, sum(one.choice.steps for one in every) / len(every), seconds, known=self.known, threads=cores(), lanes=lanes,
            disk=self.left * (first + each * len(self.some[0])), less=LESS, remarks=self.remarks(unfit, lanes),
        )  # fmt: skip

    def assembled(self, numbers: Numbers) -> Assembly | None:
        """A case; None where it cannot be assembled, which is reported when it is run."""
        try:
            return assemble(
                loads(dump(self.plan.base), set=list(numbers.items())),
                self.plan.asked.step,
                turns=float(self.plan.asked.turns),
            )
        except VfifeError:
            return None

    def measured(self, every: Sequence[Assembly], seconds: float, lanes: int) -> Stream:
        """The stream of the cases, timed with a few of them where these take a small share of the work, else
        with the steps of one.
        """
        turns, some = self.plan.asked.turns, self.some[: round(min(self.width, self.left))]
        share = len(some) * min(PILOT_TURNS, 3 * turns) / (self.left * turns)
        if share > PILOT_SHARE and share * seconds > PILOT_SECONDS:
            one = stream(every[0], self.width, lanes)
            return dataclasses.replace(
                one, stepping=one.stepping * 1e9 * timed_step(every[0]) / run_cost(every[0]).ns_per_step
            )
        wanted = wanted_of(self.plan.asked)

        def once(turns: int) -> None:
            brief = dataclasses.replace(wanted, turns=turns, last=1, settle=None)
            for _ in run_members(self.plan.base, some, brief):
                pass

        return pilot(once, turns, len(some), self.width)

    def remarks(self, unfit: set[float], lanes: int) -> tuple[str, ...]:
        """Sentences on turns that measures leave out, and on cases that go into no lanes."""
        found = [text] if (text := beside_last(self.plan.asked)) else []
        return (*found, one_by_one(unfit, self.plan.asked)) if unfit and lanes == 1 else tuple(found)


def one_by_one(turns: set[float], asked: Asked) -> str:
    """Why cases go into no lanes, in words, and what step of theirs would."""
    said = (
        f"a turn of the crank is no whole number of outputs at the step that is given, {asked.step:g} s:"
        " members run one by one, not in lanes"
    )
    if len(turns) > 1:
        return f'{said}; with step = "auto" many more run in a second.'
    (turn,) = turns
    fitting = turn / (PARTS * math.ceil(turn / (asked.step or turn) / PARTS))
    return f'{said}; with step = "{fitting!r} s" or "auto" many more run in a second.'


def evenly(numbers: Sequence[Numbers]) -> list[Numbers]:
    """Some of many cases: the first, the last and some between them."""
    count = min(LOOKED_AT, len(numbers))
    return [numbers[k * (len(numbers) - 1) // max(count - 1, 1)] for k in range(count)]


def ended(file: Path | None) -> set[str]:
    """Hashes of the cases that ended in a study file."""
    return {one.hash for one in Study.open(file).done} if file is not None and file.is_file() else set()


def study_forecast(plan: Plan, file: Path | None, retry: bool = False) -> Forecast:
    """The forecast of the cases of a plan that the file does not have; a sample of them is repeated with
    coarser steps.
    """
    numbers, known = plan.numbers(), ended(file)
    left = [one for one in numbers if hash_of(one) not in known]
    found = Cases(plan, evenly(left), len(left), len(numbers) - len(left)).forecast(file)
    if not left:
        what = f"nothing is left to compute: all {len(numbers):,} members are in {file}."
        return dataclasses.replace(found, remarks=() if retry else (what,))
    repeated = 1.0 + sample_size(len(numbers)) / (RATIO * len(left))
    return dataclasses.replace(
        found, seconds=repeated * found.seconds, remarks=(*found.remarks, *groups(numbers, plan.base))
    )


def search_forecast(plan: Plan, search: Search, file: Path | None) -> Forecast:
    """The forecast of an optimisation: its members, choosing them, and those that derivatives lead to."""

    def along(share: float) -> dict[str, float | str]:
        return {
            one.name: one.values[int(share * len(one.values))] if one.values else one.value(share)
            for one in search.axes
        }

    some = [numbers_at(plan.parameters, along((k + 0.5) / LOOKED_AT)) for k in range(LOOKED_AT)]
    known = min(len(ended(file)), search.members)
    cases = Cases(plan, some, search.members - known, known, search.batch)
    found, refined = cases.forecast(file), refinement(cases, search)
    first, more = CHOOSING[len(search.aims) > 1]
    seconds = (
        found.seconds + search.members * (first + more * search.members) + refined
    )  # those that are known are chosen again
    words = (
        f"up to {counted(search.refine, 'member')} more by derivatives, in at most {span(refined)} of that."
    )
    return dataclasses.replace(found, seconds=seconds, parts=(words,) if refined else ())


def refinement(cases: Cases, search: Search) -> float:
    """Time (s) of the cases that derivatives lead to, each with derivatives of its own: two runs, and its
    steps with derivatives.
    """
    if not search.refine or refuses(search):
        return 0.0
    names = {axis.name for axis in search.axes if axis.continuous}
    paths = sum(len(one.paths) for one in cases.plan.parameters if one.name in names)
    for numbers in cases.some:
        if (assembly := cases.assembled(numbers)) is not None:
            directions = TANGENT * paths * (DISPLACED if assembly.contacts else 1) / CONTACT_LANES
            return search.refine * run_cost(assembly).seconds * (3.0 + directions)
    return 0.0


def allotment_forecast(plan: Plan, task: Allotment, file: Path | None) -> Forecast:
    """The forecast of an allocation: all machines of the choice that is taken, the first few of each other
    choice.
    """
    machines = task.asked.count or needed(1.0 - task.asked.share, task.asked.confidence)
    choices = math.prod(map(len, task.options))
    first = [
        (one.name, options[0].clearance) for one, options in zip(task.parameters, task.options, strict=True)
    ]
    shares = [(k + 0.5) / LOOKED_AT for k in range(LOOKED_AT)]
    some = [
        numbers_at(plan.parameters, {name: float(drawn.quantile(share)) for name, drawn in first})
        for share in shares
    ]
    members = machines + FIRST * (choices - 1)
    known = min(len(ended(file)), members)
    found = Cases(plan, some, members - known, known, WIDTH).forecast(file)
    words = (
        f"{counted(choices, 'choice')} of fits: {machines:,} machines of the one that is taken, and {FIRST}"
        " of each other are reckoned with; fewer where a cheap one is taken, more where some are close to"
        f" the limit, {machines * choices:,} at most."
    )
    return dataclasses.replace(found, remarks=(*found.remarks, words) if found.count else ())


def groups(numbers: Sequence[Numbers], base: Mechanism) -> tuple[str, ...]:
    """Cases of other topologies, which share no lanes, in words: those that differ in words or in whole
    numbers of the model.
    """
    paths = [path for path in next(iter(numbers), {}) if Parameter(base, path).quantity is None]
    kinds = (
        Counter(tuple(one[path] for path in paths) for one in numbers)
        if paths
        else Counter[tuple[float | str, ...]]()
    )
    if len(kinds) < 2:
        return ()
    words = [
        ", ".join(
            f"{path} = {one:g}" if isinstance(one, float) else f"{path} = {one}"
            for path, one in zip(paths, key, strict=True)
        )
        for key in kinds
    ]
    listed = "; ".join(
        f"{text}: {count:,}" for text, count in list(zip(words, kinds.values(), strict=True))[:MOST_KINDS]
    )
    more = "; ..." if len(kinds) > MOST_KINDS else ""
    return (
        (
            f"members of {len(kinds)} kinds are run group by group, each with its own compiled step"
            f" ({listed}{more})."
        ),
    )
