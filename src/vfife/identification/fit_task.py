"""Identification of parameters from measured curves of one record or of several, and the fit file."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypedDict, Unpack, get_args

from ..compiler.runtime.native import stream_lanes
from ..errors import Fault, ModelError, VfifeError
from ..job.cost import LIBRARIES, LONG, RECORD_COPIES, WORTH, Forecast, Stream, cores, run_cost, stream, timed
from ..job.job import job_of
from ..job.progress import counted
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..results.fit import Fit, FitFile
from ..solvers.arguments import Arguments
from ..solvers.status import Progress
from ..store.lock import Lock
from ..studies.spec.distributions import sobol
from .batched_queries import Evaluations, Query
from .curves import Channels, Curves, units_of
from .descents import MOST_RESTARTS, Derivatives, Descents
from .other_minima import Search
from .parameters import FitParameter
from .records import Data, RecordReader, RecordTask, Start
from .residuals import Comparison, FitRecord
from .run_length import refuse_few_samples
from .step_uncertainty import concluded

MOST_SKIPPED = 100_000  # turns
MOST_SEARCHES = 1000  # that are begun again
# For forecast and progress only: typical evaluations of a search, and the ratio of all runs of a fit to those
# of its first searches, which is 1 to 4 depending on restarts.
EVALUATIONS = 8
RESTARTS = 2
PILOT_RUNS = 8  # points that are run for a forecast
COMPARISON = 2e-6  # time (s) to compare one sample of a curve with a run at all offsets
COMPRESSED = 0.9  # ratio of the bytes of a fit file to those of its numbers
# Settings that decide which points are computed. They are not part of the question, so that fits that differ
# in them share the points of a file.
SEARCH = ("screened", "starts", "seed", "confidence", "derivatives")


class FitOptions(TypedDict, total=False):
    """Keywords of a fit."""

    columns: Sequence[str] | Mapping[str, str] | None
    weights: Mapping[str, float] | None
    offset: str | float | tuple[Any, Any] | None
    skip: float
    compare: Comparison
    width: str | float | None
    step: float | str | None
    start: Start
    own: Mapping[str, Any] | Sequence[str] | None
    every: int
    screened: int
    restarts: int
    starts: int
    confidence: float
    derivatives: Derivatives
    seed: int
    workers: int | None


@dataclass(frozen=True)
class FitSettings:
    """Keywords of a fit with their defaults; see :func:`fit`."""

    columns: Any = None
    weights: Mapping[str, float] | None = None
    offset: Any = None
    skip: float = 3.0
    compare: Comparison = "curve"
    width: Any = None
    step: Any = None
    start: Start = "model"
    own: Any = None
    every: int = 1
    screened: int = 64
    restarts: int = MOST_RESTARTS
    starts: int = 4
    confidence: float = 0.95
    derivatives: Derivatives = "auto"
    seed: int = 0
    workers: int | None = None

    def check(self, arguments: Arguments) -> None:
        """Add the faults of the settings to ``arguments``. Raises ModelError with all faults."""
        for name in ("screened", "starts", "every", "workers"):
            arguments.count(name, getattr(self, name), optional=name == "workers")
        if not 0 <= self.restarts <= MOST_SEARCHES:
            limit = f"0 to {MOST_SEARCHES}"
            arguments.fault("restarts", "out of range", self.restarts, limit, "give fewer")
        for name, words in (
            ("compare", get_args(Comparison)), ("derivatives", get_args(Derivatives)),
            ("start", get_args(Start)),
        ):  # fmt: skip
            if (word := getattr(self, name)) not in words:
                limit = " or ".join(f'"{one}"' for one in words)
                arguments.fault(name, "this is none of the words", word, limit, "name one of them")
        if not 0.0 < self.confidence < 1.0:
            limit = "above 0 and below 1"
            arguments.fault(
                "confidence", "this is no share", self.confidence, limit, "write 0.95 for 95 per cent"
            )
        if not 0.0 <= self.skip < MOST_SKIPPED:
            arguments.fault("skip", "out of range", self.skip, f"0 to {MOST_SKIPPED:,} turns", "give fewer")
        arguments.check()


def fit(
    mechanism: Mechanism, data: Data | Sequence[Data], parameters: Mapping[Any, Any] | Sequence[str], *,
    file: str | Path | None = None,
    progress: Callable[[Progress], None] | None = None, confirm: bool = False, **options: Unpack[FitOptions],
) -> Fit:  # fmt: skip
    """Identify parameters of a mechanism from measured curves.

    mechanism: the mechanism
    data: a CSV file with time or crank_angle and channels of a result as columns, or a list of files or
    :class:`Record` that have the parameters in common
    parameters: bounds by path, ``{"joint.C.clearance": ("0.1 mm", "1 mm")}`` or ``"joint.C.clearance=0.1..1
    mm"``; several paths in one key have one value, the opposite one after a ``-``
    file: keeps every point as it is computed; the same call continues it, to the same bits
    progress: called with a :class:`~vfife.solvers.status.Progress`
    confirm: True fits even if it takes more than an hour, half of the memory or of the disk
    options: the keywords below

    Data and comparison:

    own: bounds of parameters of which each record has its own value, as ``parameters``
    start: "model", or "data" to identify the angle and speed of each body whose angle was measured
    (``start.BODY.angle``, ``start.BODY.angular_velocity``) near the first samples
    columns: channel of each column, ``{"acc": "C.force"}``; a column that is only proportional to one has a
    ``~``, ``{"mic": "~rod.angular_acceleration"}``. Only these are compared; without it, all columns with the
    name of a channel
    weights: of the columns, 1 by default; residuals are divided by each curve's standard deviation
    every: of each record, one sample out of this number is compared
    offset: place of the first sample; "free": anywhere in a turn, after ``skip`` turns; a number or two
    bounds (s or rad) add to the places of the file. None: free over time if a crank turns, else 0
    skip: number of turns (3)
    compare: the curves themselves ("curve"), or, for motions that do not repeat, their "envelope" (moving
    root mean square) or "spectrum"
    width: of the envelope's window, a fiftieth of the data by default
    step: time step of all runs (s), by default the finest automatic step at the bounds

    Search:

    screened: number of points that are run first (64)
    starts: number of best points from which searches begin (4)
    restarts: number of times that searches begin again, at most, if more than noise is left (3)
    derivatives: computed along the run ("tangents"), by "differences" of runs in lanes, or the former where
    both agree ("auto")
    seed: of the points
    confidence: of the limits (0.95)
    workers: number of threads, one for each core by default

    Returns a :class:`~vfife.identification.Fit`; after Ctrl-C the best so far, its status "interrupted".
    Raises ModelError with all faults of arguments, data and parameters, VfifeError if no case has a motion or
    the file is of another fit, and HeldError if another process writes it.
    """
    arguments = Arguments("fit")
    arguments.callable("progress", progress)
    arguments.check()
    task = plan_fit(mechanism, data, parameters, **options)
    with job_of("fit", file, confirm, progress) as job:
        job.begin(task.forecast(file))
        return task.run(file, job)


def plan_fit(
    mechanism: Mechanism,
    data: Data | Sequence[Data],
    parameters: Mapping[Any, Any] | Sequence[str],
    **options: Unpack[FitOptions],
) -> FitTask:
    """Return the checked task of a fit, without running it; arguments are those of :func:`fit`.

    Raises ModelError with all faults.
    """
    arguments, settings = Arguments("fit"), FitSettings(**options)
    arguments.mechanism(mechanism)
    settings.check(arguments)
    if mechanism.settings.analysis == "static":
        raise ModelError(
            [Fault("run.analysis", "a static analysis has no curves over time", "static", "dynamic")],
            mechanism.name,
        )
    reader = RecordReader(mechanism, settings)
    records, unknowns = reader.read(data, parameters)
    refuse_few_samples([one.data for one in records], unknowns)
    return FitTask(mechanism, dump(mechanism), unknowns, records, settings)


@dataclass(frozen=True)
class FitTask:
    """A fit that is understood: what is identified, from what records, and how."""

    mechanism: Mechanism
    text: str
    parameters: list[FitParameter]
    records: list[RecordTask]
    settings: FitSettings

    @property
    def question(self) -> dict[str, Any]:
        """All that decides the residuals at a point: fits with the same question share the points of a
        file.
        """
        common = [[one.name, list(one.paths), one.low, one.high] for one in self.parameters if not one.record]
        questions = [one.question for one in self.records]
        question = {"model": self.text, "parameters": common}
        if len(questions) > 1 or any(one.record for one in self.parameters):
            return {**question, "records": questions}
        return {**question, **questions[0]}

    @property
    def search(self) -> dict[str, Any]:
        """Settings that decide which points are computed, and with the question the answer."""
        restarts = self.settings.restarts
        others = {} if restarts == MOST_RESTARTS else {"restarts": restarts}  # version 0.2 had none
        return {**{name: getattr(self.settings, name) for name in SEARCH}, **others}

    @property
    def runs(self) -> int:
        """Expected number of runs with derivatives by differences and an average number of restarts."""
        derivatives = sum(2 * len(one.parameters) + 1 for one in self.records)
        return RESTARTS * (
            self.settings.screened * len(self.records) + self.settings.starts * EVALUATIONS * derivatives
        )

    def forecast(self, file: str | Path | None, replace: bool = False) -> Forecast:
        """Forecast of the runs that the file does not have; some are run for it where there are many. Raises
        VfifeError as assembling does.
        """
        record = max(self.evaluated, key=lambda one: one.curves.length.duration)
        one = record.curves.cases.assembled(record.numbers([0.5] * len(record.parameters)))
        lanes, stored = (
            stream_lanes(len(one.topology.contact_bearing)),
            0 if file is None or replace else self.stored_runs(Path(file)),
        )
        left, values = max(self.runs - stored, 0), record.misfit.count
        at_once = self.settings.starts * sum(2 * len(one.parameters) + 1 for one in self.records)
        table = stream(one, at_once, lanes)
        seconds = table.seconds(left) + COMPARISON * values * left
        if WORTH < seconds < LONG and left > PILOT_RUNS:
            pilot = dataclasses.replace(record, which=())
            evaluations = Evaluations([pilot], pilot.parameters)
            places = sobol(2 * PILOT_RUNS, len(pilot.parameters), self.settings.seed)
            queries = [Query(tuple(place)) for place in places]
            evaluations(queries[:PILOT_RUNS])  # compiles
            each = timed(lambda: evaluations(queries[PILOT_RUNS:])) / PILOT_RUNS
            seconds = Stream(max(each - table.stepping, 0.0), min(each, table.stepping), at_once).seconds(
                left
            )
        memory = RECORD_COPIES * run_cost(one).bytes * min(cores() * lanes, self.runs) + LIBRARIES
        remedy = "give fewer points (screened, starts), a shorter piece of the data or a coarser step"
        work = f"about {counted(left, 'run')} of {one.choice.steps:,} steps" + (
            f" beside {stored:,} that are there" if stored else ""
        )
        return Forecast(
            "run", left, one.choice.steps, seconds, memory, COMPRESSED * 8.0 * values * left, stored,
            cores(), lanes, less=remedy, work=work,
            note="; half or twice of that by how the searches go",
        )  # fmt: skip

    def stored_runs(self, file: Path) -> int:
        """Return the number of runs in a fit file of the same question; all runs if the fit is complete."""
        try:
            with FitFile.open(file) as store:
                return self.runs if store.fit(self.search) is not None else len(store.keys("looks"))
        except VfifeError:  # reported when the fit is continued
            return 0

    @cached_property
    def evaluated(self) -> list[FitRecord]:
        """The records, each with what computes its curves."""
        several, workers = len(self.records) > 1, self.settings.workers
        names = [tuple(curve.channel for curve in one.data.curves) for one in self.records]
        channels = {some: Channels(self.mechanism, some) for some in dict.fromkeys(names)}
        return [
            FitRecord(
                Curves(one.mechanism, channels[names[k]], one.length, workers),
                [self.parameters[at] for at in one.which], one.misfit, one.which,
                one.name if several else "", f" {k}" if several else "",
            )
            for k, one in enumerate(self.records)
        ]  # fmt: skip

    def run(
        self,
        file: str | Path | None = None,
        progress: Callable[[Progress], None] | None = None,
        replace: bool = False,
    ) -> Fit:
        """Run the fit, or what is missing in its file, and return the result; ``replace`` overwrites a former
        file.
        """
        if file is None:
            return self.result(None, progress)
        with (
            Lock(Path(file).absolute().parent, f"{Path(file).name}.lock", "this fit"),
            self.opened(Path(file), replace) as store,
        ):
            before = store.fit(self.search)
            if before is not None and before.status == "complete":
                return before
            result = self.result(store, progress)
            store.conclude(result, self.search)
            return result

    def opened(self, path: Path, replace: bool) -> FitFile:
        """Open or create the file of the fit. Raises VfifeError for a file of another fit."""
        return (
            FitFile.create(path, {"fit": self.question}) if replace else FitFile.resume(path, self.question)
        )

    def result(self, file: FitFile | None, progress: Callable[[Progress], None] | None) -> Fit:
        """Search, using the points in a file, and return the result; Ctrl-C ends the search with the best
        point so far.
        """
        settings = self.settings
        evaluations = Evaluations(self.evaluated, self.parameters, file, progress, self.runs)
        search, slopes = Search(), None
        try:
            Descents(evaluations, search, settings.derivatives).run(
                settings.screened, settings.starts, settings.seed, settings.restarts
            )
            if evaluations.best is not None:
                best = evaluations.best
                slopes = evaluations.slopes(Query(tuple(best[1]), None, search.tangents), best[2])
        except KeyboardInterrupt:
            if evaluations.best is None:
                raise
        return concluded(
            self.mechanism.name, units_of(self.mechanism), evaluations, search, slopes, settings.confidence
        )
