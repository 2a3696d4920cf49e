"""``vfife.study``, ``optimise`` and ``allocate``: cases of one mechanism with different numbers, saved in one
study file.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypedDict, TypeVar, Unpack

from ..errors import Fault, ModelError, former_names, kind_of, shown
from ..job.cost import Forecast
from ..job.job import Interrupted, Job, job_of
from ..model.mechanism import Mechanism
from ..modelfile import load
from ..options import Compute, Save, Watch, with_options
from ..report.html import NotebookDocument
from ..results.study import Study
from ..solvers.status import Status
from ..store.lock import Lock
from ..store.studyfile import SEARCH
from .engine.cluster import THREADS, Resources
from .engine.outcome import Outcome
from .engine.study_engine import Engine, description_of, open_study
from .forecast import allotment_forecast, search_forecast, study_forecast
from .methods.allocation import Allotment, Choice, allocate_fits, read_allotment
from .methods.local_search import optimise as run_search
from .methods.optimise import Candidate, Search, optuna_module, pareto_front, read_search
from .spec.limits import Estimate
from .spec.plan import Plan
from .spec.study_file import StudyTables, plain_tables

ENDING = ".study"
Answer = TypeVar("Answer")


class StudyKeys(TypedDict, total=False):
    """What to run in every case: keys of a study file."""

    turns: int  # of the crank, at most
    duration: float | str  # s, instead of turns
    settle: float | str | None  # 1: a case ends when its turns repeat within this share of their size
    last: int  # turns at the end that are measured
    counts: str  # "case": impacts and speeds of approach count from the start on; "last": in those turns
    step: float | str  # s, or "auto"
    method: str  # "grid", "list", or how samples are taken
    count: int  # of samples
    seed: int
    set: Mapping[str, Any]  # numbers of the model that are replaced in all cases, by path
    note: str
    point: Sequence[Mapping[str, Any]]  # further cases, by names of parameters
    limit: Mapping[str, Any]  # by measure


class SearchKeys(StudyKeys, total=False):
    """What to search for: further tables of a study file."""

    optimise: Mapping[str, Any]  # minimise, maximise, cases, seed, batch, refine
    allocation: Mapping[str, Any]  # measure, share, confidence, count, seed
    cost: Mapping[str, Any]  # by parameter


class StudyOptions(StudyKeys, Save, Compute, Watch, total=False):
    """Keywords of :func:`study`."""

    lanes: int | None  # cases side by side in a thread
    retry: bool  # try again the cases that failed before


class SearchOptions(SearchKeys, Save, Compute, Watch, total=False):
    """Keywords of :func:`optimise` and :func:`allocate`."""


Model = str | Path | Mechanism
Vary = Mapping[str, Any] | None
Names = str | Iterable[str] | None


@with_options(StudyOptions, force=False, retry=False, confirm=False)
def study(model: Model, vary: Vary = None, measures: Names = None, **options: Unpack[StudyOptions]) -> Study:
    """Run a mechanism for many values of some of its numbers, and measure each run.

    >>> vary = {"joint.C.clearance": ["0.1 mm", "0.2 mm"]}
    >>> vfife.study(model, vary, ["C.force.max"], turns=10).data  # doctest: +SKIP

    model: a mechanism, a model file, or alone the path of a study file
    vary: by path a list of values or a table as a study file has it (``values``, ``from`` and ``to`` ...),
    or by any name such a table with its ``path``
    measures: names of measures, or max, min, mean, rms, range of a channel, as in "mean(C.force)"

    Keys of a study file:

    turns: of the crank, at most
    duration: length of each case (s, or a text with a unit) instead of turns, as without a driven crank
    settle: a case ends when its turns repeat within this share of their size
    last: number of turns at the end that are measured; counts and depths of landings, speeds of approach and
    shares of contact are of the whole run
    counts: "last" counts landings, speeds of approach and shares of contact over these turns too, without
    the fall of the journals at the start; the depth of the deepest landing stays that of the whole run
    step: time step (s, or a text with a unit), or "auto"
    method: "grid", "list", or the kind of samples: "random", "latin", "sobol"
    count: number of samples
    seed: of the samples
    set: numbers of the model that are replaced in all cases, by path
    note: a text that the study keeps
    point: further cases, each a mapping of names of parameters to values
    limit: by measure its largest value, or ``low`` and ``high``

    What to save and what to compute with:

    file: study file; cases that it has are not computed again
    force: True replaces another study in the file
    retry: True computes again the cases that failed
    workers: number of threads, one for each core by default
    lanes: number of cases side by side in a thread
    cluster: "local" for processes, or the address of a scheduler of dask.distributed
    device: "cuda" for an NVIDIA card
    progress: called with the numbers of cases that have ended and of all
    confirm: True runs it even if it takes more than an hour, or half of the disk

    Returns a :class:`~vfife.studies.Study`; after Ctrl-C it has the cases that have ended. Raises ModelError
    with all faults, HeldError if another process writes the file, StorageError if it cannot be written,
    DeviceError for a card that cannot be used.
    """
    plan = tables_of(model, vary, measures, keys_of(options), "study()").plan()
    progress: Any = options["progress"]
    job = job_of(
        "study",
        options["file"],
        options["confirm"],
        progress,
        lambda state: progress(state.done, state.steps),
    )
    resources = Resources(options["workers"], options["lanes"], options["cluster"], options["device"])
    return StudyWork(options["file"], plan, resources, options["force"]).run(job, options["retry"])[0]


def keys_of(options: Any) -> dict[str, Any]:
    """Return the keywords that are keys of a study file."""
    return {name: options[name] for name in SearchKeys.__annotations__ if options.get(name) is not None}


@dataclass(frozen=True)
class StudyWork:
    """The cases of a plan, computed by ``resources`` into a study ``file``, a temporary one without it;
    ``force`` replaces another study.
    """

    file: str | Path | None
    plan: Plan
    resources: Resources = THREADS
    force: bool = False

    def run(self, job: Job, retry: bool = False, lock: Lock | None = None) -> tuple[Study, bool]:
        """Compute the cases that the file does not have, with ``retry`` also those that failed; return the
        study, and whether it is complete. ``lock``: that of the file, where the caller holds it.
        """
        if self.plan.spec.method == SEARCH:
            raise ValueError(
                f'the cases of method = "{SEARCH}" are asked for by vfife optimise or vfife study allocate;'
                " give it to one of them"
            )
        job.begin(study_forecast(self.plan, self.finished_file, retry))
        with self.engine(job, self.plan.numbers(), 0, lock) as engine:
            complete = engine.run(retry) and engine.repeat_sample()
            if not complete:
                job.interrupted()
            return engine.study(), complete

    def search(self, job: Job, forecast: Forecast, work: Callable[[Engine], Answer]) -> tuple[Answer, Study]:
        """Return the answer of a search, and the study of its cases. Raises Interrupted with the study of
        those that have ended.
        """
        job.begin(forecast)
        with self.engine(job, [], forecast.done + forecast.count) as engine:
            try:
                return work(engine), engine.study()
            except KeyboardInterrupt:
                raise Interrupted(engine.study()) from None

    @property
    def finished_file(self) -> Path | None:
        """The file whose cases are not computed again."""
        return None if self.force or self.file is None else Path(self.file)

    @contextmanager
    def engine(
        self, job: Job, numbers: Sequence[Any], cases: int, lock: Lock | None = None
    ) -> Iterator[Engine]:
        """Open the engine of these cases, whose file is locked meanwhile; a cluster that cannot be had costs
        no file. ``cases``: how many the job reports at least.
        """

        def report(done: int, total: int, outcome: Outcome) -> None:
            job.count(done, max(total, cases), "cases", outcome.status != Status.COMPLETE)

        with ExitStack() as stack:
            path = Path(self.file or Path(stack.enter_context(TemporaryDirectory())) / f"s{ENDING}")
            stack.enter_context(job)
            job.hold(stack.enter_context(lock or study_lock(path)))
            runner = stack.enter_context(self.resources.runner())
            description = description_of(self.plan)
            file = stack.enter_context(open_study(path, description, numbers, replace=self.force))
            yield Engine(file, self.plan.base, self.resources, runner, report, lasting=self.file is not None)


def study_lock(path: Path) -> Lock:
    """Return the lock of a study file. Raises HeldError."""
    return Lock(path.absolute().parent, f"{path.name}.lock", "this study")


def tables_of(model: Any, vary: Any, measures: Any, keys: Mapping[str, Any], caller: str) -> StudyTables:
    """Return the arguments of a function as the tables of a study file. Raises ModelError."""
    if vary is None and measures is None and isinstance(model, str | os.PathLike):
        for name, value in keys.items():
            message, remedy = "a study file contains this", "leave it out, or change the file"
            raise ModelError([Fault(name, message, shown(value), "", remedy)], caller)
        return StudyTables.load(Path(model))
    if not isinstance(model, str | os.PathLike | Mechanism):
        limit, remedy = "a Mechanism, or a model file", "make one, or name a file"
        raise ModelError([Fault("model", f"this is {kind_of(model)}", shown(model), limit, remedy)], caller)
    base = model if isinstance(model, Mechanism) else load(Path(model))
    names = list(measures) if isinstance(measures, Iterable) and not isinstance(measures, str) else measures
    names = [names] if isinstance(names, str) else names
    raw = plain_tables({"measures": names, "vary": dict(vary) if isinstance(vary, Mapping) else vary, **keys})
    return StudyTables(raw, caller, base=base)


@former_names(members="cases", why="reason")
@dataclass(frozen=True, repr=False)
class Optimum(NotebookDocument):
    """The answer of an optimisation, in SI units.

    ``best``: the best case, or the Pareto front of several measures, the best of the first measure first;
    empty where none keeps the limits. ``cases``: all cases in order, saved in the ``study``; ``search``: the
    aims. ``refined``: how many of the last of them are of the local search, and the ``reason`` why it
    ended, where it did not converge.
    """

    best: tuple[Candidate, ...]
    cases: tuple[Candidate, ...]
    study: Study
    search: Search
    refined: int = 0
    reason: str = ""

    def __repr__(self) -> str:
        counts = f"{len(self.best)} best of {len(self.cases)} cases"
        return f"<Optimum of {self.study.model!r}: {counts}; see .best, .study>"


@dataclass(frozen=True, repr=False)
class Allocation(NotebookDocument):
    """The answer of an allocation ``task``: the cheapest ``choice`` (None where none keeps the limit), the
    ``quantile`` of the measure with it, the number of ``failures`` among ``machines``, choices ``rejected``
    that are as cheap or cheaper with their costs, and the ``study`` of all machines.
    """

    task: Allotment
    choice: Choice | None
    quantile: Estimate | None
    failures: int
    machines: int
    rejected: tuple[tuple[Mapping[str, str], float], ...]
    study: Study

    @property
    def fits(self) -> Mapping[str, str] | None:
        """The fits of the choice by parameter."""
        return None if self.choice is None else self.task.fits(self.choice)

    @property
    def cost(self) -> float | None:
        """The cost of the choice."""
        return None if self.choice is None else self.choice.cost

    def __repr__(self) -> str:
        answer = f"{self.fits}, cost {self.cost}"
        return f"<Allocation for {self.study.model!r}: {answer}; see .quantile, .rejected, .study>"


def search_work(function: str, plan: Plan, options: SearchOptions) -> tuple[Job, StudyWork]:
    """Return the job of a search, and the work of its cases."""
    progress: Any = options["progress"]
    job = job_of(function, options["file"], options["confirm"], progress, lambda state: progress(state.done))
    resources = Resources(options["workers"], None, options["cluster"], options["device"])
    return job, StudyWork(options["file"], plan, resources, options["force"])


@with_options(SearchOptions, force=False, confirm=False)
def optimise(
    model: Model, vary: Vary = None, measures: Names = None, **options: Unpack[SearchOptions]
) -> Optimum:
    """Find the parameters x that minimise measures f(x), or maximise them, within limits low ≤ g(x)
    ≤ high.

    One measure is minimised by tree-structured Parzen estimators, of several the Pareto front is found by
    NSGA-II (optuna, extra ``optimise``). From the best case of one measure a local search goes on with at
    most ``refine`` further cases: by derivatives (SLSQP), or by values where these cannot be trusted.

    >>> vary = {"clearance": {"path": "joint.C.clearance", "from": "0.1 mm", "to": "0.5 mm"}}
    >>> aim = {"minimise": ["C.force.max"], "cases": 100}
    >>> measures, limit = ["C.force.max", "C.impacts"], {"C.impacts": 40}
    >>> vfife.optimise(model, vary, measures, optimise=aim, limit=limit).best  # doctest: +SKIP

    model, measures: as of :func:`vfife.study`
    vary: parameters as of :func:`vfife.study`, each with ``from`` and ``to``, or ``values``
    optimise: ``minimise`` and ``maximise`` (names of measures), ``cases``, ``seed``, ``batch``, ``refine``
    limit: by measure its largest value, or ``low`` and ``high``, in SI units or as texts with a unit
    file: study file that keeps the cases; the same search continues with those that it has
    force: True replaces another study in the file
    progress: called with the number of cases computed
    turns, duration, settle, last, counts, step, method, count, seed, set, note, point: keys of a study file,
    as of :func:`vfife.study`
    allocation, cost: tables of a study file that :func:`vfife.studies.allocate` uses
    workers, cluster, device, confirm: as of :func:`vfife.study`

    Returns the best cases and the study. Raises ModelError with all faults, VfifeError without optuna or if
    another study is in the file, HeldError, StorageError, DeviceError; after Ctrl-C
    :class:`~vfife.Interrupted`, whose ``result`` is the study of the cases that have ended.
    """
    plan, search = read_search(tables_of(model, vary, measures, keys_of(options), "optimise()"))
    optuna_module()
    job, work = search_work("optimise", plan, options)
    forecast = search_forecast(plan, search, work.finished_file)
    (candidates, last), study = work.search(job, forecast, lambda engine: run_search(engine, plan, search))
    best = tuple(pareto_front(search, candidates))
    return Optimum(best, tuple(candidates), study, search, len(last.candidates), last.reason)


@with_options(SearchOptions, force=False, confirm=False)
def allocate(
    model: Model, vary: Vary = None, measures: Names = None, **options: Unpack[SearchOptions]
) -> Allocation:
    """Find the cheapest fits with which a measure y keeps its limit in a share of all machines: min Σ cost
    with P(y ≤ limit) ≥ share.

    >>> vfife.studies.allocate("crank.toml").fits  # doctest: +SKIP

    model, measures: as of :func:`vfife.study`
    vary: parameters as of :func:`vfife.study`, each with a fit, a tolerance or a distribution
    allocation: ``measure``, ``share``, ``confidence``, ``count``, ``seed``
    cost: by parameter a cost for each grade, as in {"IT7": 5}, or for each fit, as in {"H8/f7": 7.5}
    limit: of the measure, a number in SI units or a text with a unit
    optimise: table of a study file that :func:`vfife.optimise` uses
    turns, duration, settle, last, counts, step, method, count, seed, set, note, point: keys of a study file,
    as of :func:`vfife.study`
    file, force, workers, cluster, device, progress, confirm: as of :func:`vfife.optimise`

    Choices are tried from the cheapest on with the same ``machines`` drawn for all. One is taken when at most
    k of n are beyond the limit, k the most with P(B ≤ k) ≤ 1 - confidence for B binomial of n and 1 - share;
    so of none beyond it n is 299 for 99 % with 95 %.

    Returns the cheapest fits and the study. Raises what :func:`vfife.optimise` raises, but needs no optuna.
    """
    plan, task = read_allotment(tables_of(model, vary, measures, keys_of(options), "allocate()"))
    job, work = search_work("allocate", plan, options)
    forecast = allotment_forecast(plan, task, work.finished_file)
    answer, study = work.search(job, forecast, lambda engine: allocate_fits(engine, task))
    rejected = tuple((task.fits(choice), choice.cost) for choice in answer.rejected)
    return Allocation(task, answer.choice, answer.estimate, answer.failures, answer.count, rejected, study)
