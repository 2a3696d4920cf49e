"""Members of a plan computed one after another into a study file: those that are there already never again."""

from __future__ import annotations

import dataclasses
import hashlib
import threading
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..assembly.assemble import assemble
from ..codegen.cache import sources as sources_of_the_step
from ..errors import VfifeError
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..results.provenance import own_laws, versions
from ..results.reductions import REDUCTION
from ..results.studied import Study, unit_of
from ..results.studyfile import WHAT, Kept, StudyFile
from ..results.view import standing
from ..solvers.status import Status
from .engine import Outcome, Wanted, run_members
from .plan import Plan
from .wanted import wanted_of

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


def done(member: Kept, outcome: Mapping[str, Any] | None, retry: bool) -> bool:
    """Whether nothing of a member is left to compute."""
    return outcome is not None and outcome["hash"] == member.hash and not (retry and outcome["status"] != Status.COMPLETE)


def alike_first(members: list[Kept]) -> list[Kept]:
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
        return StudyFile.create(path, asked, plan.numbers())
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
