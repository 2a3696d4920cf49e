"""Members of a plan computed one after another into a study file: those that are there already never again."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import threading
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..assembly.assemble import assemble
from ..codegen.cache import sources as sources_of_the_step
from ..errors import VfifeError, shown, suggestion
from ..laws import ContactLaw, FrictionLaw
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.paths import parsed
from ..results.member_errors import sample_of
from ..results.provenance import own_laws, versions
from ..results.reductions import REDUCTION
from ..results.studied import Study, unit_of
from ..results.studyfile import WHAT, StudyCase, StudyFile, hash_of
from ..results.view import standing
from ..solvers.status import Status
from .engine import Outcome, Wanted, run_members
from .plan import Parameter, Plan
from .study_file import Written, understood, wanted_of
from .varied import number

Told = Callable[[int, int, Outcome], None]
Runner = Callable[..., Iterator[tuple[int, Outcome]]]


def asked_of(plan: Plan, base: Mechanism, name: str) -> dict[str, Any]:
    """What a study file says of a plan: enough to go on with it, to add to it, and to read it without any other file."""
    return {
        "name": name,
        "note": plan.asked.note.strip(),
        "model": base.name,
        "source": base.source,
        "text": dump(base),
        "raw": plan.raw,
        "wanted": {**dataclasses.asdict(wanted_of(plan.asked)), "measures": list(plan.asked.measures)},
        "measures": units_of(plan.asked.measures, base),
        "parameters": [
            {"name": one.name, "paths": list(one.paths), "unit": one.unit, "kind": one.kind, "words": one.words} for one in plan.parameters
        ],
        "own_laws": own_laws(base),
        "versions": versions(),
        "step": hashlib.blake2b(sources_of_the_step(), digest_size=16).hexdigest(),
    }


def units_of(measures: Sequence[str], base: Mechanism) -> dict[str, str]:
    """Units of measures, and of channels that are reduced."""
    reduced = {name: match[2] for name in measures if (match := REDUCTION.fullmatch(name))}
    view = standing(assemble(base)) if reduced else None
    found = {name: unit_of(name) for name in measures}
    if view is not None:
        found |= {name: view.channels[view.series.place(channel)[0]].unit for name, channel in reduced.items()}
    return found


def same_question(file: StudyFile, asked: Mapping[str, Any]) -> str:
    """Why members of a file cannot stand beside those of a plan, empty where they can."""
    kept = file.meta[WHAT]
    if kept["text"] != asked["text"]:
        return "is that of another model"
    if kept["wanted"] != asked["wanted"] or kept["measures"] != asked["measures"]:
        return "wants other measures, turns or another step"
    if [one["paths"] for one in kept["parameters"]] != [one["paths"] for one in asked["parameters"]]:
        return "varies other numbers"
    if texts_of(kept) != texts_of(asked):
        return "was made with another text of your own laws"
    if kept["step"] != asked["step"]:
        return f"was computed by the text of vfife {kept['versions'].get('vfife', '')}, which steps otherwise"
    return ""


def texts_of(asked: Mapping[str, Any]) -> dict[tuple[str, str], str]:
    """Texts of the user's own laws, by kind and name."""
    return {(one["kind"], one["name"]): one["text"] for one in asked["own_laws"]}


def carry_out(
    file: StudyFile,
    base: Mechanism,
    *,
    workers: int | None = None,
    lanes: int | None = None,
    told: Told | None = None,
    runner: Runner | None = None,
    retry: bool = False,
) -> bool:
    """Computes what the file has no outcome of; whether all of it was computed. What ended is kept, whatever ends this.

    ``retry``: members that failed are computed again.

    ``runner``: what runs members, as :func:`~vfife.study.engine.run_members` does; outcomes may come in any order, and twice. ``told`` hears after
    each member how many have ended, of how many, and what it came to. Raises StorageError where nothing can be written.
    """
    wanted = Wanted(**{**file.meta[WHAT]["wanted"], "measures": tuple(file.meta[WHAT]["wanted"]["measures"])})
    members, ended = file.members(), file.outcomes()
    left = alike_first([one for one in members if not done(one, ended.get(one.number), retry)])
    ended_now, before, stop = set[int](), len(members) - len(left), threading.Event()
    found = runner_of(runner)(base, [one.numbers for one in left], wanted, workers=workers, lanes=lanes, stop=stop)
    try:
        for k, outcome in found if left else ():
            kept = complete(outcome, wanted)
            file.record(left[k], kept)
            ended_now.add(k)
            if told is not None:
                told(before + len(ended_now), len(members), kept)
    except KeyboardInterrupt:
        file.flush()
    finally:
        stop.set()
        if isinstance(found, Generator):
            found.close()
    whole = before + len(ended_now) == len(members)
    file.finish(Status.COMPLETE.value if whole else Status.INTERRUPTED.value)
    return whole


def runner_of(runner: Runner | None) -> Runner:
    """Return what runs members: ``runner``, or this process without one."""
    return runner or run_members


def done(member: StudyCase, outcome: Mapping[str, Any] | None, retry: bool) -> bool:
    """Whether nothing of a member is left to compute."""
    return outcome is not None and outcome["hash"] == member.hash and not (retry and outcome["status"] != Status.COMPLETE)


def alike_first(members: list[StudyCase]) -> list[StudyCase]:
    """Members that differ in their joints alone one after another, for what is closed and assembled serves all of them."""
    return sorted(members, key=lambda one: [(path, str(value)) for path, value in one.numbers.items() if not path.startswith("joint.")])


def complete(outcome: Outcome, wanted: Wanted) -> Outcome:
    """The outcome with a reason where a measure is missing."""
    missing = [name for name in wanted.measures if name not in outcome.values]
    if not missing or outcome.reason is not None:
        return outcome
    return dataclasses.replace(outcome, reason=f"it has no measure {', '.join(missing)}")


def opened(path: Path, plan: Plan, base: Mechanism, name: str, *, replace: bool = False) -> StudyFile:
    """The study file of a plan, made, or gone on with and added to. Raises VfifeError where another study is there."""
    asked = asked_of(plan, base, name)
    if not path.exists() or replace:
        return StudyFile.begin(path, asked, plan.numbers())
    return taken_up(path, plan, asked)


def taken_up(path: Path, plan: Plan, asked: Mapping[str, Any]) -> StudyFile:
    """A study file that is there, with the members of a plan. Raises VfifeError where it is that of another study."""
    file = StudyFile.write(path)
    try:
        if why := same_question(file, asked):
            raise VfifeError(f"{path}: the study in this file {why}; name another file, or replace it")
        file.add(plan.numbers(), asked)
    except BaseException:
        file.close()
        raise
    return file


def read_back(file: StudyFile) -> Study:
    """The study of a file that is open."""
    members = file.members()
    return Study(file.path, file.meta, members, file.outcomes(), file.repeats())


Numbers = Mapping[str, float | str]


class BrokenOff(Exception):
    """A study was interrupted; what ended is kept."""


class Growing:
    """Members of a study by their numbers. ``runner`` and ``told`` are those of :func:`~vfife.study.run_missing.carry_out`."""

    def __init__(
        self, file: StudyFile, base: Mechanism, *, workers: int | None = None, runner: Runner | None = None, told: Told | None = None
    ) -> None:
        self.file, self.base, self.workers, self.runner, self.told = file, base, workers, runner, told
        self.known: dict[str, Mapping[str, float] | None] = {}
        self.read()

    def read(self) -> None:
        """Takes what the file has."""
        outcomes = self.file.outcomes()
        for one in self.file.members():
            if (outcome := outcomes.get(one.number)) is not None and outcome["hash"] == one.hash:
                self.known[one.hash] = outcome["measures"] if outcome["status"] == Status.COMPLETE else None

    def __call__(self, numbers: Sequence[Numbers]) -> list[Mapping[str, float] | None]:
        """Measures of members, None of those that failed. Raises BrokenOff after Ctrl-C, StorageError where nothing can be kept."""
        asked = [hash_of(one) for one in numbers]
        if new := [one for one, name in zip(numbers, asked, strict=True) if name not in self.known]:
            self.file.add(new, self.file.meta[WHAT])
            if not carry_out(self.file, self.base, workers=self.workers, runner=self.runner, told=self.told):
                raise BrokenOff
            self.read()
        return [self.known[name] for name in asked]


def grown(path: Path, plan: Plan, base: Mechanism, name: str, *, replace: bool = False) -> StudyFile:
    """The study file of a plan without members of its own, made or gone on with. Raises VfifeError where another study is there."""
    asked: dict[str, Any] = asked_of(plan, base, name)
    if not path.exists() or replace:
        return StudyFile.begin(path, asked, [])
    file = StudyFile.write(path)
    if why := same_question(file, asked):
        file.close()
        raise VfifeError(f"{path}: the study in this file {why}; name another file, or replace it")
    return file


STEP = "run.step"  # path of the step in a model
RATIO = 1.5  # step of a repetition over that of its member; the coarser run costs two thirds of the member


def repeat_sample(file: StudyFile, base: Mechanism, *, workers: int | None = None, lanes: int | None = None, runner: Runner | None = None) -> bool:
    """Compute the members of the sample again with other steps, and keep what they come to; those that are kept are not repeated.

    A member that is not stable with the coarser step is repeated with a finer one, and one that fails with both is kept as failed. A static
    analysis has no step, and is not repeated. ``runner`` is as in :func:`~vfife.study.run_missing.carry_out`.

    Returns whether the sample is complete: after Ctrl-C it is not. Raises StorageError if nothing can be written.
    """
    if base.settings.analysis == "static":
        return True
    outcomes, known = file.outcomes(), file.repeats()
    left = [one for one in sample_of(file.members(), outcomes) if known.get(one.number, {}).get("hash") != one.hash]
    if not left:
        return True
    file.begin_repeats({"order": 1 if base.contacts else 2, "ratio": RATIO})
    run = Repetition(file, base, outcomes, workers, lanes, runner_of(runner))
    try:
        finer = run.repeat(left, RATIO, last=False)
        run.repeat(finer, 1.0 / RATIO, last=True)
    except KeyboardInterrupt:
        file.flush()
        return False
    file.flush()
    return True


@dataclasses.dataclass
class Repetition:
    """Members that are repeated into a study file, ``outcomes`` being those of their own steps."""

    file: StudyFile
    base: Mechanism
    outcomes: Mapping[int, Mapping[str, Any]]
    workers: int | None
    lanes: int | None
    runner: Runner

    def repeat(self, members: Sequence[StudyCase], ratio: float, last: bool) -> list[StudyCase]:
        """Run members with about so many times their step; return those that failed, which are kept only the ``last`` time."""
        if not members:
            return []
        asked = self.file.meta[WHAT]["wanted"]
        wanted = Wanted(**{**asked, "measures": tuple(asked["measures"]), "step": None})
        numbers = [{**one.numbers, STEP: self.step(one, ratio)} for one in members]
        failed, stop = list[StudyCase](), threading.Event()
        found = self.runner(self.base, numbers, wanted, workers=self.workers, lanes=self.lanes, stop=stop)
        try:
            for k, outcome in found:
                if outcome.status == Status.COMPLETE or last:
                    self.file.record_repeat(members[k], complete(outcome, wanted))
                else:
                    failed.append(members[k])
        finally:
            stop.set()
            if isinstance(found, Generator):
                found.close()
        return sorted(failed, key=lambda one: one.number)

    def step(self, member: StudyCase, ratio: float) -> float:
        """The step (s) nearest ``ratio`` times that of a member by which a turn has a whole number of outputs, and each of these of steps."""
        outcome, per = self.outcomes[member.number], self.base.settings.outputs
        turn = outcome["steps"] // outcome["turns"]
        every = turn // per if turn % per == 0 else 0
        count = per * max(1, round(every / ratio)) if every > 1 else round(turn / ratio)
        return float(outcome["step"] * turn / max(1, count))


def split(text: str, what: str) -> list[tuple[str, str]]:
    """Names and values of ``name=value,value,name=value``. Raises ValueError."""
    found: list[tuple[str, str]] = []
    for part in text.split(","):
        name, sign, value = part.partition("=")
        if sign:
            found.append((name.strip(), value.strip()))
        elif found:
            found[-1] = (found[-1][0], f"{found[-1][1]},{part.strip()}")
        else:
            raise ValueError(f'{what} {text}: this is not NAME=VALUE; write it as in play="0.3 mm, 0.4 mm"')
    return found


def added(
    path: Path, values: Mapping[str, Any], points: Sequence[Mapping[str, Any]] = (), count: int | None = None
) -> tuple[Plan, Mechanism, dict[str, Any]]:
    """The plan of a study file with what is added, the model, and what the file is to say. Raises ModelError with all faults, VfifeError."""
    found = Study.open(path)
    base = base_of(found)
    raw = copy.deepcopy(found.asked["raw"])
    before, _ = understood(raw, str(path), base=base)
    for name, more in values.items():
        listed = [parsed(one.strip()) for one in more.split(",")] if isinstance(more, str) else list(more)
        extend(raw, next(one for one in before.parameters if one.name == found.parameter(name).name), listed, str(path))
    if points:
        own = [{found.parameter(name).name: parsed(one) if isinstance(one, str) else one for name, one in point.items()} for point in points]
        raw["point"] = [*raw.get("point", []), *own]
    if count is not None:
        if count < (drawn := before.asked.count or 0):
            raise VfifeError(f"{path}: {drawn:,} samples are asked for already, and --count {count} says how many there shall be in all; give more")
        raw["count"] = count
    plan, base = understood(raw, str(path), base=base)
    return plan, base, asked_of(plan, base, found.name)


def extend(raw: dict[str, Any], one: Parameter, more: list[Any], where: str) -> None:
    """Adds values to a parameter, which has them one by one from then on. Raises VfifeError for one of which samples are taken."""
    if one.values is None:
        raise VfifeError(f"{where}: samples are taken of {one.name}; add some with --count, or single members with --point")
    had = list(one.values)
    new = [value for value in more if number(value, one.held, ("vary", one.name, "values"), Written()) not in had]
    raw["vary"][one.name] = {"path": list(one.paths), "values": [*had, *new]}


def base_of(found: Study) -> Mechanism:
    """The model of a study, from the text in its file. Raises VfifeError where a law of the user's own is not at hand."""
    unknown = [law for law in found.asked["own_laws"] if law["name"] not in (ContactLaw if law["kind"] == "contact" else FrictionLaw).registry]
    if unknown:
        names = ", ".join(law["name"] for law in unknown)
        remedy = suggestion(names, [], f"give the file that defines it: --laws {unknown[0]['file']}")
        raise VfifeError(f"{found.path}: its model uses the law {shown(names)} of your own, which is not known here; {remedy}")
    base = loads(found.asked["text"])
    base.source = found.asked["source"]
    return base
