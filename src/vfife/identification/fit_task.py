"""Identification of parameters from measured curves of one record or of several, and the fit file."""

from __future__ import annotations

import dataclasses
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np

from ..assembly.assembled import Assembly
from ..compiler.runtime.native import stream_lanes
from ..errors import Fault, ModelError, VfifeError
from ..job.amounts import span
from ..job.cost import LIBRARIES, LONG, RECORD_COPIES, WORTH, Forecast, Stream, cores, run_cost, stream, timed
from ..job.job import job_of
from ..job.progress import counted
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..options import named_interrupt, with_faults
from ..results.fit import Fit, FitFile
from ..solvers.arguments import Arguments
from ..solvers.status import Progress, Status
from ..store.studyfile import locked_file
from ..studies.spec.distributions import sobol
from .batched_queries import Evaluations, Query
from .curves import Channels, Curves, units_of
from .descents import MOST_RESTARTS, USUAL_SEARCH, Budget, Derivatives, Descents
from .measurements import Measured
from .other_minima import Search
from .parameters import FitParameter
from .records import Data, FitSettings, Record, RecordReader, RecordTask, Start
from .residuals import Comparison, FitRecord
from .run_length import middle_and_ends, refuse_few_samples
from .step_uncertainty import concluded

# For forecast only: ratio of all runs of a fit to those of its first searches, which is 1 to 4 depending on
# restarts.
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


@with_faults(FitOptions)
@named_interrupt("fit")
def fit(
    mechanism: Mechanism, data: Data | Sequence[Data], parameters: Mapping[Any, Any] | Sequence[str], *,
    file: str | Path | None = None,
    progress: Callable[[Progress], None] | None = None, confirm: bool = False, **options: Unpack[FitOptions],
) -> Fit:  # fmt: skip
    """Identify parameters of a mechanism from measured curves.

    mechanism: the mechanism
    data: a CSV file or a pandas data frame with time or crank_angle and channels of a result as columns, as
    ``time (ms)``, in SI units where a column has none (a frame's index may be the time), or a list of these
    or of :class:`Record` that have the parameters in common
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
    arguments.mechanism(mechanism)
    pandas: Any = sys.modules.get("pandas")
    kinds = (str, os.PathLike, Record, Measured, *((pandas.DataFrame,) if pandas is not None else ()))
    for entry in data if isinstance(data, list | tuple) else [data]:
        arguments.kind("data", entry, kinds, "a CSV file, a data frame, or a list of them")
    arguments.callable("progress", progress)
    arguments.check()
    task = plan_fit(mechanism, data, parameters, **options)
    with job_of("fit", file, confirm, progress) as job:
        job.begin(task.forecast(file))
        result = task.run(file, job)
        if result.status == Status.INTERRUPTED.value:
            job.interrupted()
        return result


def plan_fit(
    mechanism: Mechanism,
    data: Data | Sequence[Data],
    parameters: Mapping[Any, Any] | Sequence[str],
    **options: Unpack[FitOptions],
) -> FitTask:
    """Return the checked task of a fit, without running it; arguments are those of :func:`fit`.

    Raises ModelError with all faults.
    """
    return task_of(mechanism, data, parameters, FitSettings(**options))


def task_of(mechanism: Mechanism, data: Any, parameters: Any, settings: FitSettings) -> FitTask:
    """Return the checked task of a fit with ``settings``. Raises ModelError with all faults."""
    arguments = Arguments("fit")
    arguments.mechanism(mechanism)
    settings.check(arguments)
    if mechanism.settings.analysis == "static":
        raise ModelError(
            [Fault("run.analysis", "a static analysis has no curves over time", "static", "dynamic")],
            mechanism.name,
        )
    reader = RecordReader(mechanism, settings)
    records, unknowns = reader.read(data, parameters)
    refuse_few_samples([task.data for task in records], unknowns)
    return FitTask(mechanism, dump(mechanism), unknowns, records, settings)


@dataclass(frozen=True)
class FitTask:
    """A checked fit: what is identified, from which records, and how."""

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
        common = [
            [parameter.name, list(parameter.paths), parameter.low, parameter.high]
            for parameter in self.parameters
            if not parameter.record
        ]
        questions = [task.question for task in self.records]
        question = {"model": self.text, "parameters": common}
        if len(questions) > 1 or any(parameter.record for parameter in self.parameters):
            return {**question, "records": questions}
        return {**question, **questions[0]}

    @property
    def search(self) -> dict[str, Any]:
        """Settings that decide which points are computed, and with the question the answer."""
        restarts = self.settings.restarts
        extra = {} if restarts == MOST_RESTARTS else {"restarts": restarts}  # version 0.2 had none
        return {**{name: getattr(self.settings, name) for name in SEARCH}, **extra}

    @property
    def runs(self) -> int:
        """Expected number of runs with derivatives by differences and an average number of restarts."""
        return RESTARTS * self.least_runs

    @property
    def least_runs(self) -> int:
        """Expected number of runs without restarts and rounds around the best point."""
        return self.settings.screened * len(self.records) + USUAL_SEARCH * self.simultaneous_runs

    @property
    def most_runs(self) -> int:
        """Number of runs with all restarts and long searches."""
        return max(self.budget.first + self.budget.later(self.settings.restarts), self.runs)

    @property
    def budget(self) -> Budget:
        """Runs with all restarts and long searches, with derivatives by differences."""
        counts = [len(task.parameters) for task in self.records]
        has_contacts = self.evaluated[0].curves.has_contacts
        return Budget.of(counts, self.settings.screened, self.settings.starts, has_contacts)

    @property
    def simultaneous_runs(self) -> int:
        """Number of runs of one evaluation of all searches, with derivatives by differences."""
        return self.settings.starts * sum(2 * len(task.parameters) + 1 for task in self.records)

    def forecast(self, file: str | Path | None, replace: bool = False) -> Forecast:
        """Forecast of the runs that the file does not have; some are run for it where there are many. Raises
        VfifeError as assembling does.
        """
        record = max(self.evaluated, key=lambda record: record.curves.length.duration)
        assembly = assembled_within(record)
        lanes, stored = (
            stream_lanes(len(assembly.topology.contact_bearing)),
            0 if file is None or replace else self.stored_runs(Path(file)),
        )
        left, values = max(self.runs - stored, 0), record.misfit.count
        table, tangent_bound = stream(assembly, self.simultaneous_runs, lanes), 0.0
        seconds = table.seconds(left) + COMPARISON * values * left
        if WORTH < seconds < LONG and left > PILOT_RUNS:
            pilot = dataclasses.replace(record, indices=())
            evaluations = Evaluations([pilot], pilot.parameters)
            places = sobol(2 * PILOT_RUNS, len(pilot.parameters), self.settings.seed)
            queries = [Query(tuple(place)) for place in places]
            evaluations(queries[:PILOT_RUNS])  # compiles
            seconds_per_run = timed(lambda: evaluations(queries[PILOT_RUNS:])) / PILOT_RUNS
            overhead, stepping = (
                max(seconds_per_run - table.stepping, 0.0),
                min(seconds_per_run, table.stepping),
            )
            seconds = Stream(overhead, stepping, self.simultaneous_runs).seconds(left)
            if self.settings.derivatives != "differences":
                query = Query(tuple(places[0]), None, True)
                point_seconds = timed(lambda: evaluations([query]))
                tangent_bound = self.tangent_bound(point_seconds, seconds / left)
        memory = RECORD_COPIES * run_cost(assembly).bytes * min(cores() * lanes, self.runs) + LIBRARIES
        remedy = "give fewer points (screened, starts), a shorter piece of the data or a coarser step"
        work = f"about {counted(left, 'run')} of {assembly.choice.steps:,} steps" + (
            f" beside {stored:,} that are there" if stored else ""
        )
        bound = max(seconds / max(left, 1) * max(self.most_runs - stored, 0), tangent_bound)
        return Forecast(
            "run", left, assembly.choice.steps, seconds, memory, COMPRESSED * 8.0 * values * left, stored,
            cores(), lanes, remedy=remedy, work=work,
            note=f"; {self.least_runs:,} to {self.most_runs:,} runs by how the searches go, at most"
            f" {span(bound)}",
        )  # fmt: skip

    def tangent_bound(self, point_seconds: float, run_seconds: float) -> float:
        """Return the time (s) of a fit with all restarts and long searches whose derivatives are tangents: a
        point with them takes ``point_seconds``, because no other lanes run beside it, and a run without
        ``run_seconds``.
        """
        budget = self.budget
        points = budget.search_points(self.settings.restarts)
        return (
            points * len(self.records) * point_seconds
            + max(self.most_runs - points * budget.slopes, 0) * run_seconds
        )

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
        multiple, workers = len(self.records) > 1, self.settings.workers
        names = [tuple(curve.channel for curve in task.data.curves) for task in self.records]
        channels = {
            channel_names: Channels(self.mechanism, channel_names) for channel_names in dict.fromkeys(names)
        }
        return [
            FitRecord(
                Curves(task.mechanism, channels[names[k]], task.length, workers),
                [self.parameters[at] for at in task.indices], task.misfit, task.indices,
                task.name if multiple else "", f" {k}" if multiple else "",
            )
            for k, task in enumerate(self.records)
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
        with locked_file(FitFile, file, self.question, "this fit", replace) as store:
            if store is None:
                return self.result(None, progress)
            former = store.fit(self.search)
            if former is not None and former.status == "complete":
                return former
            result = self.result(store, progress)
            store.conclude(result, self.search)
            return result

    def result(self, file: FitFile | None, progress: Callable[[Progress], None] | None) -> Fit:
        """Search, using the points in a file, and return the result; Ctrl-C ends the search with the best
        point so far.
        """
        settings = self.settings
        evaluations = Evaluations(self.evaluated, self.parameters, file, progress)
        search, slopes = Search(), None
        try:
            Descents(evaluations, search, settings.derivatives).run(
                settings.screened, settings.starts, settings.seed, settings.restarts
            )
            evaluations.recall()
            if evaluations.best is not None:
                best = evaluations.best
                slopes = evaluations.slopes(Query(tuple(best[1]), None, search.tangents), best[2])
        except KeyboardInterrupt:
            if evaluations.best is None:
                raise
            evaluations.recall()
        former = None if file is None else file.fit()
        if former is not None:  # searches of other fits to the same question dispute its values too
            search.ends += [end for end in former.starts if end not in search.ends]
        result = concluded(
            self.mechanism.name, units_of(self.mechanism), evaluations, search, slopes, settings.confidence
        )
        if slopes is not None:
            evaluations.finish()
        return result


def assembled_within(record: FitRecord) -> Assembly:
    """Return the assembly of a record's model in the middle of the bounds, or where one can be made. Raises
    ModelError with the bounds if there is none.
    """
    parameters, reason = record.parameters, ""
    for shares in (*middle_and_ends(len(parameters)), np.zeros(len(parameters))):  # the last are as written
        try:
            return record.curves.cases.assembled(record.numbers([float(share) for share in shares]))
        except VfifeError as error:
            reason = " ".join(str(error).split()).replace(" (given by set)", "")
    bounds = ", ".join(f"{p.name} = {p.low:.6g} .. {p.high:.6g} {p.unit}" for p in parameters)
    raise ModelError([Fault(bounds, f"no model can be made within these bounds: {reason}")], "fit")
