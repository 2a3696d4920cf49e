"""The missing cases of a study file: one engine computes and saves them, for studies and for searches.

A study asks for all of its cases at once, a search for those that it needs next (ask), from whose measures it
decides on others (tell). Both go through the same file, in which each case is saved as it ends: whatever ends
the work, the same call goes on with the rest.
"""

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

from ...compiler.runtime.cache import sources as sources_of_the_step
from ...errors import VfifeError, shown, suggestion
from ...laws import ContactLaw, FrictionLaw
from ...model.functions import turn_of
from ...model.mechanism import Mechanism
from ...modelfile import dump, loads
from ...modelfile.paths import parsed
from ...results.case_errors import sample_of
from ...results.provenance import own_laws, versions
from ...results.study import Study
from ...solvers.status import Status
from ...store.salvage import salvage
from ...store.studyfile import (
    MEASURE_VERSION,
    MEASURE_VERSION_KEY,
    REPEATS,
    SPECIFICATION,
    StudyCase,
    StudyFile,
    has_former_measures,
    hash_of,
)
from ..spec.parameters import read_value
from ..spec.plan import CaseSpec, Plan, StudyParameter
from ..spec.study_file import StudyReader, StudyTables, units_of
from .cases import Cases, run_cases
from .cluster import THREADS, Resources, Runner
from .outcome import Outcome
from .step_trials import StepOf, missing_trials, repeated_step, steps_of_turn

Numbers = Mapping[str, float | str]
Progress = Callable[[int, int, Outcome], None]
EMPTY: Any = MappingProxyType({})
STEP = "run.step"  # path of the step in a model
FORMER_MEASURES = (
    "the cases of this file were computed by an older version of vfife, which measured the last turn"
    " counted from the start, not the last 360 degrees before the end; new cases would not be"
    " comparable: name another file, or replace it"
)
RATIO = 1.5  # step of a repetition over that of its case; the coarser run costs two thirds of the case


def description_of(plan: Plan) -> dict[str, Any]:
    """Return what a study file says of a plan: enough to go on with it, to add to it, and to read it without
    any other file.
    """
    base, spec, keys = plan.base, plan.spec, ("name", "unit", "kind", "words")
    return {
        "name": plan.name,
        "note": spec.note.strip(),
        "model": base.name,
        "source": base.source,
        "text": dump(base),
        "raw": plan.raw,
        "wanted": spec.of_case().fields,
        "measures": units_of(plan),
        MEASURE_VERSION_KEY: MEASURE_VERSION,
        "parameters": [
            {**{key: getattr(parameter, key) for key in keys}, "paths": list(parameter.paths)}
            for parameter in plan.parameters
        ],
        "own_laws": own_laws(base),
        "versions": versions(),
        "step": hashlib.blake2b(sources_of_the_step(), digest_size=16).hexdigest(),
    }


def difference(saved: Mapping[str, Any], description: Mapping[str, Any]) -> str:
    """Return why cases of a saved study cannot be mixed with those of a description, empty where they can."""
    # Each entry that could change a case is compared by itself, so that the message names what differs.
    if saved["text"] != description["text"]:
        return "is that of another model"
    spec, saved_spec = (CaseSpec.of(source["wanted"]) for source in (description, saved))
    if dataclasses.replace(saved_spec, period_means=spec.period_means) == spec != saved_spec:
        return (
            "measures one turn where turns alternate, as former versions did and last = 1 does, or whole"
            " periods, as settle without last does"
        )
    if spec != saved_spec or saved["measures"] != description["measures"]:
        return "wants other measures, turns or another step"
    if [parameter["paths"] for parameter in saved["parameters"]] != [
        parameter["paths"] for parameter in description["parameters"]
    ]:
        return "varies other numbers"
    if law_texts(saved) != law_texts(description):
        return "was made with another text of your own laws"
    if saved["step"] != description["step"]:
        return f"was computed by the text of vfife {saved['versions'].get('vfife', '')}, whose steps differ"
    return ""


def law_texts(description: Mapping[str, Any]) -> dict[tuple[str, str], str]:
    """Return the texts of user laws by kind and name."""
    return {(law["kind"], law["name"]): law["text"] for law in description["own_laws"]}


@dataclasses.dataclass
class Engine:
    """Computes the cases of a study file that have no outcome, and saves each as it ends: all of them for a
    study (:meth:`run`), or those that a search asks for (:meth:`ask`).

    ``runner`` runs cases as :func:`~vfife.studies.engine.cases.run_cases` does, which is used without one;
    outcomes may come in any order, and twice. ``progress`` is called after each case with the number of cases
    that have ended, of all cases, and the outcome. ``lasting``: the file remains when the work is done.
    """

    file: StudyFile
    base: Mechanism
    resources: Resources = THREADS
    runner: Runner | None = None
    progress: Progress | None = None
    lasting: bool = True

    @property
    def spec(self) -> CaseSpec:
        """What is computed of each case."""
        return CaseSpec.of(self.file.meta[SPECIFICATION]["wanted"])

    def run(self, retry: bool = False) -> bool:
        """Compute the cases without an outcome, with ``retry`` also those that failed; return whether all
        were computed, which they are not after Ctrl-C. Raises StorageError where nothing can be written.

        Each case is run once and saved whatever its outcome. One that failed counts as computed: it is not
        tried again in this call, as its own run has the same bits each time, and in later calls with
        ``retry`` alone.
        """
        spec, cases, outcomes = self.spec, self.file.cases(), self.file.outcomes()
        # Results are stored by number, so the order of computing is free; grouping by model saves assemblies.
        left = sorted_by_model(
            [case for case in cases if not is_done(case, outcomes.get(case.number), retry)]
        )
        first_count, new = len(cases) - len(left), set[int]()
        # Closing the generator stops its threads before the file is flushed, also after Ctrl-C. An outcome
        # may arrive twice (dask repeats a batch that it believes lost); a set counts it once, the file
        # replaces it.
        with suppress(KeyboardInterrupt), closing(self._outcomes(left, spec)) as results:
            for case, outcome in results:
                self.file.record(case, outcome)
                new.add(case.number)
                if self.progress is not None:
                    self.progress(first_count + len(new), len(cases), outcome)
        complete = first_count + len(new) == len(cases)
        if not complete:
            self.file.flush()
        self.file.finish(Status.COMPLETE.value if complete else Status.INTERRUPTED.value)
        return complete

    def ask(self, numbers: Sequence[Numbers]) -> list[Mapping[str, float] | None]:
        """Return the measures of cases that a search asks for, None of those that failed.

        Cases are known by the hash of their numbers, so a search that was interrupted asks for the same ones
        again and gets them from the file. Raises KeyboardInterrupt where they were not all computed,
        StorageError where nothing can be written.
        """
        # A search may propose a point again, and one that continues proposes all former ones: only the
        # missing ones are computed. Its proposals depend on nothing but seed and measures, so they are the
        # same again.
        hashes = [hash_of(case_numbers) for case_numbers in numbers]
        missing = [
            case_numbers
            for case_numbers, key in zip(numbers, hashes, strict=True)
            if key not in self._measures
        ]
        if missing:
            self.file.add(missing, self.file.meta[SPECIFICATION])
            if not self.run():
                raise KeyboardInterrupt
            del self._measures
        return [self._measures[key] for key in hashes]

    @cached_property
    def _measures(self) -> dict[str, Mapping[str, float] | None]:
        """Measures of the cases that have an outcome, by the hash of their numbers."""
        measures: dict[str, Mapping[str, float] | None] = {}
        outcomes = self.file.outcomes()
        for case in self.file.cases():
            outcome = outcomes.get(case.number)
            if outcome is not None and is_done(case, outcome, retry=False):
                measures[case.hash] = outcome["measures"] if outcome["status"] == Status.COMPLETE else None
        return measures

    def repeat_sample(self) -> bool:
        """Repeat a sample of the cases with another step, by which the numerical error of their measures is
        estimated, and with further steps where the motion is sensitive; return whether the sample is
        complete, which it is not after Ctrl-C.

        The other step is coarser, so that a repetition costs less than its case; one that is not stable with
        it is repeated with a finer step, and one that fails with both is saved as failed. A static analysis
        has no step, and is not repeated.
        """
        if self.base.settings.analysis == "static":
            return True
        outcomes = self.file.outcomes()
        sample = sample_of(self.file.cases(), outcomes)
        try:
            step_of = self._steps_of(sample, outcomes)
            self._repeat(sample, step_of)
            self._try_steps(sample, outcomes, step_of)
        except KeyboardInterrupt:
            return False
        finally:
            self.file.flush()
        return True

    def _steps_of(self, sample: Sequence[StudyCase], outcomes: Mapping[int, Mapping[str, Any]]) -> StepOf:
        """Return the function of a case and a ratio that gives the step (s) of its repetition."""
        cases, outputs = Cases(self.base, self.spec), self.base.settings.outputs
        # Parameters may change the speed of the crank, so each case has its own turn.
        timed = self.spec.duration is not None
        turns = {case.number: turn_of(cases.mechanism(case.numbers)) if timed else None for case in sample}

        def step_of(case: StudyCase, ratio: float) -> float:
            outcome = outcomes[case.number]
            return repeated_step(outcome, steps_of_turn(outcome, turns[case.number]), outputs, ratio)

        return step_of

    def _repeat(self, sample: Sequence[StudyCase], step_of: StepOf) -> None:
        """Compute the cases of the sample that were not repeated."""
        repeats = self.file.repeats()
        left = [case for case in sample if repeats.get(case.number, {}).get("hash") != case.hash]
        if not left:
            return
        self.file.begin_repeats({"order": 1 if self.base.contacts else 2, "ratio": RATIO})
        for ratio, last in ((RATIO, False), (1.0 / RATIO, True)):
            failed = []
            steps = [step_of(case, ratio) for case in left]
            with closing(self._with_steps(left, steps, examine=True)) as results:
                for case, outcome in results:
                    if outcome.status == Status.COMPLETE or last:
                        self.file.record_repeat(case, outcome)
                    else:
                        failed.append(case)
            left = sorted(failed, key=lambda case: case.number)

    def _try_steps(
        self, sample: Sequence[StudyCase], outcomes: Mapping[int, Mapping[str, Any]], step_of: StepOf
    ) -> None:
        """Compute a sensitive sample with further steps. Each round takes one trial of every case that needs
        another value; a case that fails has another trial in the next round.
        """
        while trials := missing_trials(self.file, sample, outcomes, step_of):
            self.file.begin_repeats(self.file.meta[REPEATS])
            numbers = {trial.case.number: trial.trial for trial in trials}
            left, steps = [trial.case for trial in trials], [trial.step for trial in trials]
            with closing(self._with_steps(left, steps)) as results:
                for case, outcome in results:
                    self.file.record_step_trial(case, numbers[case.number], outcome)
            self.file.flush()

    def _with_steps(
        self, cases: Sequence[StudyCase], steps: Sequence[float], examine: bool = False
    ) -> Generator[tuple[StudyCase, Outcome]]:
        """Run cases, each with its own step (s); ``examine`` their cautions."""
        # The step of a case is given as a number of its model, so that each repetition can have another one.
        spec = dataclasses.replace(self.spec, step=None, examine=examine)
        return self._outcomes(cases, spec, [{STEP: step} for step in steps])

    def _outcomes(
        self, cases: Sequence[StudyCase], spec: CaseSpec, changes: Sequence[Numbers] = ()
    ) -> Generator[tuple[StudyCase, Outcome]]:
        """Run cases, each with its ``further`` numbers, if any; once closed, begin no more of them."""
        if not cases:
            return
        stop, run = threading.Event(), self.runner or run_cases
        numbers = [
            {**case.numbers, **change} for case, change in zip_longest(cases, changes, fillvalue=EMPTY)
        ]
        workers, lanes = self.resources.workers, self.resources.lanes
        results = run(self.base, numbers, spec, workers=workers, lanes=lanes, stop=stop)
        try:
            for k, outcome in results:
                yield cases[k], with_reason(outcome, spec)
        finally:
            stop.set()
            if isinstance(results, Generator):
                results.close()

    def study(self) -> Study:
        """Return the study as far as the file has it."""
        file, path = self.file, self.file.path if self.lasting else None
        return Study(path, file.meta, file.cases(), file.outcomes(), file.repeats(), file.step_trials())


def is_done(case: StudyCase, outcome: Mapping[str, Any] | None, retry: bool) -> bool:
    """Return whether nothing of a case is left to compute: it has an outcome for these numbers and, with
    ``retry``, a complete one.
    """
    if outcome is None or outcome["hash"] != case.hash:
        return False
    return not retry or bool(outcome["status"] == Status.COMPLETE)


def sorted_by_model(cases: list[StudyCase]) -> list[StudyCase]:
    """Sort cases so that those that differ in their joints alone follow each other: they share the solved
    start and the assembly, of which few are cached.
    """

    def model(case: StudyCase) -> list[tuple[str, str]]:
        return [(path, str(value)) for path, value in case.numbers.items() if not path.startswith("joint.")]

    return sorted(cases, key=model)


def with_reason(outcome: Outcome, spec: CaseSpec) -> Outcome:
    """Return the outcome, with a reason where a measure is missing."""
    missing = [name for name in spec.measures if name not in outcome.values]
    if not missing or outcome.reason is not None:
        return outcome
    return dataclasses.replace(outcome, reason=f"it has no measure {', '.join(missing)}")


def open_study(
    path: Path, description: Mapping[str, Any], numbers: Sequence[Numbers], *, replace: bool = False
) -> StudyFile:
    """Open the study file with these cases, which are added to those that it has; begin it where there is
    none. Of a file whose pages do not fit together, the intact rows go into a new one.

    Raises VfifeError where another study is there.
    """
    if not path.exists() or replace:
        return StudyFile.begin(path, description, numbers)
    salvage(StudyFile, path)
    file = StudyFile.write(path)
    try:
        if reason := difference(file.meta[SPECIFICATION], description):
            raise VfifeError(f"{path}: the study in this file {reason}; name another file, or replace it")
        if has_former_measures(file.meta[SPECIFICATION], file.outcomes()):
            raise VfifeError(f"{path}: {FORMER_MEASURES}")
        if numbers or MEASURE_VERSION_KEY not in file.meta[SPECIFICATION]:
            file.add(numbers, description)
    except BaseException:
        file.close()
        raise
    return file


def split_values(text: str, option: str) -> list[tuple[str, str]]:
    """Return the names and values of ``name=value,value,name=value``. Raises ValueError."""
    pairs: list[tuple[str, str]] = []
    for part in text.split(","):
        name, sign, value = part.partition("=")
        if sign:
            pairs.append((name.strip(), value.strip()))
        elif pairs:
            pairs[-1] = (pairs[-1][0], f"{pairs[-1][1]},{part.strip()}")
        else:
            raise ValueError(
                f'{option} {text}: this is not NAME=VALUE; write it as in clearance="0.3 mm, 0.4 mm"'
            )
    return pairs


def extended_plan(
    path: Path, values: Mapping[str, Any], points: Sequence[Mapping[str, Any]] = (), count: int | None = None
) -> Plan:
    """Return the plan of a study file with further values of parameters by name, further single ``points``,
    or a ``count`` of samples in all. Raises ModelError with all faults, VfifeError.
    """
    study = Study.open(path)
    plan, raw = plan_of(study), copy.deepcopy(study.request["raw"])
    parameters = {parameter.name: parameter for parameter in plan.parameters}
    for name, added in values.items():
        listed = (
            [parsed(text.strip()) for text in added.split(",")] if isinstance(added, str) else list(added)
        )
        add_values(raw, parameters[study.parameter(name).name], listed, str(path))
    for point in points:
        numbers = {name: parsed(value) if isinstance(value, str) else value for name, value in point.items()}
        named = {study.parameter(name).name: value for name, value in numbers.items()}
        raw["point"] = [*raw.get("point", []), named]
    if count is not None:
        if count < (drawn := plan.spec.count or 0):
            problem = f"{path}: {drawn:,} samples are asked for already"
            raise VfifeError(f"{problem}, and --count {count} says how many there shall be in all; give more")
        raw["count"] = count
    return StudyTables(raw, str(path), base=plan.base, name=study.name).plan()


def add_values(raw: dict[str, Any], parameter: StudyParameter, added: list[Any], path: str) -> None:
    """Add values to a parameter, which lists them from then on. Raises VfifeError for one that is sampled."""
    if parameter.values is None:
        remedy = "add some with --count, or single cases with --point"
        raise VfifeError(f"{path}: samples are taken of {parameter.name}; {remedy}")
    place, by, listed = ("vary", parameter.name, "values"), StudyReader(), list[Any](parameter.values)
    listed += [
        value for value in added if read_value(value, parameter.field, place, by) not in parameter.values
    ]
    raw["vary"][parameter.name] = {"path": list(parameter.paths), "values": listed}


def plan_of(study: Study) -> Plan:
    """Return the plan of a study. Raises VfifeError where a user law of its model is not loaded."""
    raw = copy.deepcopy(study.request["raw"])
    return StudyTables(raw, str(study.path), base=base_of(study), name=study.name).plan()


def base_of(study: Study) -> Mechanism:
    """Return the model of a study. Raises VfifeError where a user law of it is not loaded."""
    registries = {"contact": ContactLaw.registry, "friction": FrictionLaw.registry}
    unknown = [law for law in study.request["own_laws"] if law["name"] not in registries[law["kind"]]]
    if unknown:
        names = ", ".join(law["name"] for law in unknown)
        remedy = suggestion(names, [], f"give the file that defines it: --laws {unknown[0]['file']}")
        problem = f"{study.path}: its model uses the law {shown(names)} of your own"
        raise VfifeError(f"{problem}, which is not known here; {remedy}")
    base = loads(study.request["text"])
    base.source = study.request["source"]
    return base
