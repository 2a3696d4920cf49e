"""The missing members of a study file: one engine computes and keeps them, for studies and for searches."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import threading
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing, suppress
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ...assembly.assemble import assemble
from ...compiler.runtime.cache import sources as sources_of_the_step
from ...errors import VfifeError, shown, suggestion
from ...laws import ContactLaw, FrictionLaw
from ...model.mechanism import Mechanism
from ...modelfile import dump, loads
from ...modelfile.paths import parsed
from ...results.series import REDUCTION
from ...results.studied import Study, unit_of
from ...results.view import standing
from ...solvers.status import Status
from ...store.member_errors import sample_of
from ...store.provenance import own_laws, versions
from ...store.studyfile import WHAT, StudyCase, StudyFile, hash_of
from ..spec.plan import Parameter, Plan
from ..spec.varied import number
from .cases import Outcome, Wanted, run_members
from .cluster import THREADS, Resources, Runner
from .study_file import StudyTables, Written, wanted_of

Numbers = Mapping[str, float | str]
Progress = Callable[[int, int, Outcome], None]
NOTHING: Any = MappingProxyType({})
STEP = "run.step"  # path of the step in a model
RATIO = 1.5  # step of a repetition over that of its member; the coarser run costs two thirds of the member


def asked_of(plan: Plan) -> dict[str, Any]:
    """What a study file says of a plan: enough to go on with it, to add to it, and to read it without any
    other file.
    """
    base = plan.base
    return {
        "name": plan.name,
        "note": plan.asked.note.strip(),
        "model": base.name,
        "source": base.source,
        "text": dump(base),
        "raw": plan.raw,
        "wanted": {**dataclasses.asdict(wanted_of(plan.asked)), "measures": list(plan.asked.measures)},
        "measures": units_of(plan),
        "parameters": [
            {
                "name": one.name,
                "paths": list(one.paths),
                "unit": one.unit,
                "kind": one.kind,
                "words": one.words,
            }
            for one in plan.parameters
        ],
        "own_laws": own_laws(base),
        "versions": versions(),
        "step": hashlib.blake2b(sources_of_the_step(), digest_size=16).hexdigest(),
    }


def units_of(plan: Plan) -> dict[str, str]:
    """Units of measures, and of channels that are reduced."""
    measures = plan.asked.measures
    reduced = {name: match[2] for name in measures if (match := REDUCTION.fullmatch(name))}
    view = standing(assemble(plan.base)) if reduced else None
    found = {name: unit_of(name) for name in measures}
    if view is not None:
        found |= {name: view.series.column(channel).unit for name, channel in reduced.items()}
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


@dataclasses.dataclass
class Engine:
    """Compute the members of a study file that it has no outcome of, and keep them: all at once for a study,
    or as a search asks for them.

    What ended is kept, whatever ends the work. ``runner`` is what runs members, as
    :func:`~vfife.studies.engine.cases.run_members` does, this process without one; outcomes may come in any
    order, and twice. ``progress`` is called after each member with how many have ended, of how many, and its
    outcome. ``lasting``: the file remains when the work is done.
    """

    file: StudyFile
    base: Mechanism
    resources: Resources = THREADS
    runner: Runner | None = None
    progress: Progress | None = None
    lasting: bool = True

    @property
    def wanted(self) -> Wanted:
        """What is wanted of each member."""
        return Wanted.of(self.file.meta[WHAT]["wanted"])

    def run(self, retry: bool = False) -> bool:
        """Compute the members without an outcome, with ``retry`` also those that failed; return whether all
        were computed.

        Raises StorageError where nothing can be written.
        """
        wanted, members, ended = self.wanted, self.file.members(), self.file.outcomes()
        left = alike_first([one for one in members if not done(one, ended.get(one.number), retry)])
        before, new = len(members) - len(left), set[int]()
        with suppress(KeyboardInterrupt), closing(self._outcomes(left, wanted)) as found:
            for member, outcome in found:
                self.file.record(member, outcome)
                new.add(member.number)
                if self.progress is not None:
                    self.progress(before + len(new), len(members), outcome)
        whole = before + len(new) == len(members)
        if not whole:
            self.file.flush()
        self.file.finish(Status.COMPLETE.value if whole else Status.INTERRUPTED.value)
        return whole

    def ask(self, numbers: Sequence[Numbers]) -> list[Mapping[str, float] | None]:
        """Return the measures of members that a search asks for, None of those that failed.

        Raises KeyboardInterrupt where they were not all computed, StorageError where nothing can be written.
        """
        names = [hash_of(one) for one in numbers]
        if not self._known.keys() >= set(names):
            self.file.add(
                [one for one, name in zip(numbers, names, strict=True) if name not in self._known],
                self.file.meta[WHAT],
            )
            if not self.run():
                raise KeyboardInterrupt
            del self._known
        return [self._known[name] for name in names]

    @cached_property
    def _known(self) -> dict[str, Mapping[str, float] | None]:
        """Measures of the members that the file has, by the hash of their numbers."""
        outcomes = self.file.outcomes()
        ended = [
            (one, outcomes[one.number])
            for one in self.file.members()
            if done(one, outcomes.get(one.number), retry=False)
        ]
        return {
            one.hash: outcome["measures"] if outcome["status"] == Status.COMPLETE else None
            for one, outcome in ended
        }

    def repeat_sample(self) -> bool:
        """Compute a sample of the members again with other steps, by which the numerical error of their
        measures is known.

        A member that is not stable with the coarser step is repeated with a finer one, and one that fails
        with both is kept as failed. A static analysis has no step, and is not repeated. Returns whether the
        sample is complete: after Ctrl-C it is not.
        """
        if self.base.settings.analysis == "static":
            return True
        outcomes, repeats = self.file.outcomes(), self.file.repeats()
        left = [
            one
            for one in sample_of(self.file.members(), outcomes)
            if repeats.get(one.number, {}).get("hash") != one.hash
        ]
        if not left:
            return True
        self.file.begin_repeats({"order": 1 if self.base.contacts else 2, "ratio": RATIO})
        wanted = dataclasses.replace(self.wanted, step=None)
        try:
            for ratio, last in ((RATIO, False), (1.0 / RATIO, True)):
                failed = []
                steps = [
                    {STEP: repeated_step(outcomes[one.number], self.base.settings.outputs, ratio)}
                    for one in left
                ]
                with closing(self._outcomes(left, wanted, steps)) as found:
                    for member, outcome in found:
                        if outcome.status == Status.COMPLETE or last:
                            self.file.record_repeat(member, outcome)
                        else:
                            failed.append(member)
                left = sorted(failed, key=lambda one: one.number)
        except KeyboardInterrupt:
            return False
        finally:
            self.file.flush()
        return True

    def _outcomes(
        self, members: Sequence[StudyCase], wanted: Wanted, more: Sequence[Numbers] = ()
    ) -> Generator[tuple[StudyCase, Outcome]]:
        """Run members, each with ``more`` numbers where there are any; no more of them once it is closed."""
        if not members:
            return
        stop, run = threading.Event(), self.runner or run_members
        numbers = [{**one.numbers, **other} for one, other in zip_longest(members, more, fillvalue=NOTHING)]
        found = run(
            self.base, numbers, wanted, workers=self.resources.workers, lanes=self.resources.lanes, stop=stop
        )
        try:
            for k, outcome in found:
                yield members[k], complete(outcome, wanted)
        finally:
            stop.set()
            if isinstance(found, Generator):
                found.close()

    def study(self) -> Study:
        """Return the study as far as the file has it."""
        return Study(
            self.file.path if self.lasting else None,
            self.file.meta,
            self.file.members(),
            self.file.outcomes(),
            self.file.repeats(),
        )


def repeated_step(outcome: Mapping[str, Any], outputs: int, ratio: float) -> float:
    """The step (s) nearest ``ratio`` times that of a member by which a turn has a whole number of
    ``outputs``, and each of these of steps.
    """
    turn = outcome["steps"] // outcome["turns"]
    every = turn // outputs if turn % outputs == 0 else 0
    count = outputs * max(1, round(every / ratio)) if every > 1 else round(turn / ratio)
    return float(outcome["step"] * turn / max(1, count))


def done(member: StudyCase, outcome: Mapping[str, Any] | None, retry: bool) -> bool:
    """Whether nothing of a member is left to compute."""
    return (
        outcome is not None
        and outcome["hash"] == member.hash
        and not (retry and outcome["status"] != Status.COMPLETE)
    )


def alike_first(members: list[StudyCase]) -> list[StudyCase]:
    """Members that differ in their joints alone one after another, for what is closed and assembled serves
    all of them.
    """
    return sorted(
        members,
        key=lambda one: [
            (path, str(value)) for path, value in one.numbers.items() if not path.startswith("joint.")
        ],
    )


def complete(outcome: Outcome, wanted: Wanted) -> Outcome:
    """The outcome with a reason where a measure is missing."""
    missing = [name for name in wanted.measures if name not in outcome.values]
    if not missing or outcome.reason is not None:
        return outcome
    return dataclasses.replace(outcome, reason=f"it has no measure {', '.join(missing)}")


def opened(
    path: Path, asked: Mapping[str, Any], numbers: Sequence[Numbers], *, replace: bool = False
) -> StudyFile:
    """Return the study file with these members, which is made, or gone on with and added to. Raises
    VfifeError where another study is there.
    """
    if not path.exists() or replace:
        return StudyFile.begin(path, asked, numbers)
    file = StudyFile.write(path)
    try:
        if why := same_question(file, asked):
            raise VfifeError(f"{path}: the study in this file {why}; name another file, or replace it")
        if numbers:
            file.add(numbers, asked)
    except BaseException:
        file.close()
        raise
    return file


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
) -> Plan:
    """The plan of a study file with what is added. Raises ModelError with all faults, VfifeError."""
    found = Study.open(path)
    before, raw = plan_of(found), copy.deepcopy(found.asked["raw"])
    for name, more in values.items():
        listed = [parsed(one.strip()) for one in more.split(",")] if isinstance(more, str) else list(more)
        extend(
            raw,
            next(one for one in before.parameters if one.name == found.parameter(name).name),
            listed,
            str(path),
        )
    if points:
        own = [
            {
                found.parameter(name).name: parsed(one) if isinstance(one, str) else one
                for name, one in point.items()
            }
            for point in points
        ]
        raw["point"] = [*raw.get("point", []), *own]
    if count is not None:
        if count < (drawn := before.asked.count or 0):
            raise VfifeError(
                f"{path}: {drawn:,} samples are asked for already, and --count {count} says how many there"
                " shall be in all; give more"
            )
        raw["count"] = count
    return StudyTables(raw, str(path), base=before.base, name=found.name).plan()


def plan_of(found: Study) -> Plan:
    """The plan of a study. Raises VfifeError where a law of the user's own is not at hand."""
    return StudyTables(
        copy.deepcopy(found.asked["raw"]), str(found.path), base=base_of(found), name=found.name
    ).plan()


def extend(raw: dict[str, Any], one: Parameter, more: list[Any], where: str) -> None:
    """Adds values to a parameter, which has them one by one from then on. Raises VfifeError for one of which
    samples are taken.
    """
    if one.values is None:
        raise VfifeError(
            f"{where}: samples are taken of {one.name}; add some with --count, or single members with --point"
        )
    had = list(one.values)
    new = [
        value for value in more if number(value, one.held, ("vary", one.name, "values"), Written()) not in had
    ]
    raw["vary"][one.name] = {"path": list(one.paths), "values": [*had, *new]}


def base_of(found: Study) -> Mechanism:
    """The model of a study, from the text in its file. Raises VfifeError where a law of the user's own is not
    at hand.
    """
    unknown = [
        law
        for law in found.asked["own_laws"]
        if law["name"] not in (ContactLaw if law["kind"] == "contact" else FrictionLaw).registry
    ]
    if unknown:
        names = ", ".join(law["name"] for law in unknown)
        remedy = suggestion(names, [], f"give the file that defines it: --laws {unknown[0]['file']}")
        raise VfifeError(
            f"{found.path}: its model uses the law {shown(names)} of your own, which is not known here;"
            f" {remedy}"
        )
    base = loads(found.asked["text"])
    base.source = found.asked["source"]
    return base
