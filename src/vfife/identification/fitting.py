"""Identification of parameters from measured curves: points that are run first, searches from the best of
them, and the fit file.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypedDict, Unpack, get_args

import numpy as np
from numpy.typing import NDArray

from ..compiler.runtime.native import stream_lanes
from ..errors import Fault, ModelError, VfifeError
from ..job.amounts import counted
from ..job.cost import LIBRARIES, LONG, RECORD_COPIES, WORTH, Forecast, Stream, cores, run_cost, stream, timed
from ..job.job import job_of
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..results.fit import Fit, FitFile
from ..solvers.arguments import Arguments
from ..solvers.status import Progress
from ..store.lock import Lock
from ..studies.spec.sampling import sobol
from .batched_queries import BatchedQueries, Evaluations, Point, Query
from .curves import Curves, units_of
from .measurements import Measured, columns_of, measured
from .parameters import FitParameter, numbers_at, parameters_of
from .residuals import Fitted, How, Misfit, Slopes, columns_agree
from .step_uncertainty import RANK_TOLERANCE, Search, autocorrelation, concluded
from .timing import Timing, envelope_width, offset_of, refuse_few_samples, timing_of

Array = NDArray[np.float64]
Ask = Callable[[list[Query]], list[Point]]
Derivatives = Literal["auto", "tangents", "differences"]
DISTANCE = 0.05  # of starts from each other, as a share of the diagonal of the bounds
CLOSE = 1e-6  # relative change of cost and of the parameters at which a search ends
PATIENCE, HOPELESS_COST = (
    8,
    30.0,
)  # a search is left after so many evaluations if its cost is so many times the best
MOST_EVALUATIONS = 40  # of one local search
MOST_RESTARTS = 3
# A residual above this share of the deviation, whose values are correlated with the next more than this, is
# more than noise.
NEGLIGIBLE, CORRELATED = 0.01, 0.2
# times: parameters known so much better than the rest stay where they are when more points are looked for
SHARPER = 5.0
BATCH = 16  # first points at once, so that progress is seen, and lanes are full


class Hopeless(Exception):
    """A search leads nowhere compared with another."""


@dataclass
class Descents:
    """Local searches under way.

    What one of them knows of the others is the best point when its answer came, which is the same whichever
    is quicker.
    """

    evaluations: Evaluations
    search: Search
    derivatives: Derivatives

    def run(self, screened: int, starts: int, seed: int) -> None:
        """Screen points and descend from the best; again from other points while the best residual is more
        than noise.
        """
        parameters = self.evaluations.parameters
        places = sobol(screened, len(parameters), seed)
        if all(one.initial is not None for one in parameters):
            own = [one.share(one.initial) for one in parameters if one.initial is not None]
            places = np.concatenate([[own], places[: max(screened - 1, 0)]])
        chosen = self.distant(self.screen(places), starts, [])
        self.choose_derivatives(*chosen[0])
        self.descend(chosen)
        for restart in range(1, MOST_RESTARTS + 1):
            if not self.unexplained or self.evaluations.best is None:
                return
            best = self.evaluations.best[1]
            points = self.screen(self.further(max(screened // 2, starts), seed + restart))
            self.descend(self.distant(points, starts, [best]))

    @property
    def unexplained(self) -> bool:
        """Whether the best residual is more than noise: its values are correlated, as they are where a search
        ended in a wrong place.
        """
        misfit, best = self.evaluations.misfit, self.evaluations.best
        if (
            best is None
            or best[2].fitted is None
            or misfit.how != "curve"
            or self.evaluations.share < NEGLIGIBLE
        ):
            return False
        parts = misfit.columns(best[2].fitted.residuals).T
        return autocorrelation(list(parts)) > CORRELATED + 2.0 / math.sqrt(parts.shape[1])

    def further(self, count: int, seed: int) -> Array:
        """More points. Parameters known much better than the rest, as the speed of a drive, stay as they are
        at the best point.

        With another speed all curves are out of step, and equally wrong.
        """
        _, shares, best = self.evaluations.best or (0.0, np.zeros(0), Point(None))
        slopes = self.evaluations.slopes(Query(tuple(shares), None, self.search.tangents), best)
        _, sizes, rows = np.linalg.svd(slopes.jacobian, full_matrices=False)
        spread = np.ones(len(shares))
        if sizes[0] > 0.0:
            spread = np.sqrt(((rows.T / np.maximum(sizes, RANK_TOLERANCE * sizes[0])) ** 2).sum(axis=1))
        vague = np.flatnonzero(spread >= spread.max() / SHARPER)
        places = np.tile(shares, (count, 1))
        places[:, vague] = sobol(count, len(vague), seed)
        return places

    def screen(self, places: Array) -> list[tuple[Array, Fitted]]:
        """Points with their curves, the best first. Raises VfifeError where none has a motion."""
        screened: list[tuple[Array, Fitted]] = []
        for first in range(0, len(places), BATCH):
            batch = places[first : first + BATCH]
            points = self.evaluations([Query(tuple(one)) for one in batch])
            screened += [
                (at, one.fitted) for at, one in zip(batch, points, strict=True) if one.fitted is not None
            ]
        if not screened:
            reason = self.evaluations.reasons[0]
            raise VfifeError(f"none of {len(places)} members has a motion: {reason}; correct the bounds")
        return sorted(screened, key=lambda one: one[1].cost)

    def distant(
        self, points: list[tuple[Array, Fitted]], count: int, former: list[Array]
    ) -> list[tuple[Array, Fitted]]:
        """The best points that are far enough from each other and from those that are ``known``."""
        chosen: list[tuple[Array, Fitted]] = []
        for at, one in points:
            others = [*former, *(other for other, _ in chosen)]
            if len(chosen) < count and all(
                np.linalg.norm(at - other) > DISTANCE * math.sqrt(len(at)) for other in others
            ):
                chosen.append((at, one))
        return chosen

    def choose_derivatives(self, shares: Array, one: Fitted) -> None:
        """Take tangents where differences of runs agree with them.

        Where they do not, a contact ends or a neighbour is far away, and the tangent of one run leads
        nowhere.
        """
        if self.derivatives == "differences":
            return
        at, point = tuple(shares), Point(one)
        try:
            tangents = self.evaluations.slopes(Query(at, one.offset, True), point)
        except VfifeError as error:
            if self.derivatives == "tangents":
                raise
            self.search.notes.append(f"no derivatives were carried along: {' '.join(str(error).split())}")
            return
        differences = self.evaluations.slopes
        self.search.tangents = self.derivatives == "tangents" or columns_agree(
            tangents, differences(Query(at, one.offset, False), point)
        )

    def descend(self, chosen: list[tuple[Array, Fitted]]) -> None:
        """Search from several points side by side."""
        BatchedQueries(self.evaluations).run([lambda ask, at=at: self.descent(ask, *at) for at in chosen])  # type: ignore[misc]

    def descent(self, ask: Ask, start: Array, first: Fitted) -> None:
        """One search from a start. A point and what its derivatives need are computed at once: lanes have
        room for both.
        """
        from scipy.optimize import least_squares

        near, count, misfit = first.offset, 0, self.evaluations.misfit
        cache: dict[bytes, tuple[Array, Slopes | None]] = {}

        def at(shares: Array) -> tuple[Array, Slopes | None]:
            nonlocal near, count
            if (key := shares.tobytes()) not in cache:
                (point,) = ask([Query(tuple(shares), near, self.search.tangents)])
                if point.fitted is None:
                    cache[key] = misfit.penalty, None
                else:
                    near, count = point.fitted.offset, count + 1
                    cache[key] = point.fitted.residuals, point.slopes
                    best = self.evaluations.best
                    if count > PATIENCE and best is not None and point.fitted.cost > HOPELESS_COST * best[0]:
                        raise Hopeless
            return cache[key]

        def jacobian(shares: Array) -> Array:
            slopes = at(shares)[1]
            return slopes.jacobian if slopes is not None else np.zeros((misfit.count, len(shares)))

        inside, limits = (
            np.clip(start, 1e-6, 1.0 - 1e-6),
            {"ftol": CLOSE, "xtol": CLOSE, "gtol": 1e-12, "max_nfev": MOST_EVALUATIONS},
        )
        try:
            minimum: Any = least_squares(
                lambda shares: at(shares)[0], inside, jacobian, (0.0, 1.0), "trf", **limits
            )
        except Hopeless:
            return
        values = (float(one.value(x)) for one, x in zip(self.evaluations.parameters, minimum.x, strict=True))
        self.search.ends.append((float(minimum.cost), tuple(values)))


MOST_SKIPPED = 100_000  # turns
EVALUATIONS = 8  # of a search from one start, as a rule: for forecast and progress alone
RESTARTS = 2  # runs of a fit over those of its first searches: one to four, as searches begin again
PILOT_RUNS = 8  # points that are run for a forecast
COMPARISON = 2e-6  # s that a sample of a curve takes, compared with a run at all offsets
COMPRESSED = 0.9  # bytes of a fit file over those of its numbers
SEARCH = (
    "screened",
    "starts",
    "seed",
    "confidence",
    "derivatives",
)  # settings that decide where a fit looks, not what it compares


class FitOptions(TypedDict, total=False):
    """Keywords of a fit."""

    columns: Sequence[str] | Mapping[str, str] | None
    weights: Mapping[str, float] | None
    offset: str | float | tuple[Any, Any] | None
    skip: float
    compare: How
    width: str | float | None
    step: float | str | None
    screened: int
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
    compare: How = "curve"
    width: Any = None
    step: Any = None
    screened: int = 64
    starts: int = 4
    confidence: float = 0.95
    derivatives: Derivatives = "auto"
    seed: int = 0
    workers: int | None = None

    def check(self, arguments: Arguments) -> None:
        """Raises ModelError with all faults."""
        for name in ("screened", "starts", "workers"):
            arguments.count(name, getattr(self, name), optional=name == "workers")
        for name, words in (("compare", get_args(How)), ("derivatives", get_args(Derivatives))):
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
    mechanism: Mechanism, data: str | Path | Measured, parameters: Mapping[Any, Any] | Sequence[str], *,
    file: str | Path | None = None,
    progress: Callable[[Progress], None] | None = None, confirm: bool = False, **options: Unpack[FitOptions],
) -> Fit:  # fmt: skip
    """Identify parameters of a mechanism from measured curves: a CSV file with time or crank_angle and
    channels of a result as columns.

    ``parameters``: a mapping ``{"joint.C.clearance": ("0.1 mm", "1 mm")}``, several paths in one key having
    one value; or texts, ``"joint.C.clearance=0.1..1 mm"``. ``columns`` says which column is which channel,
    ``{"acc": "C.force"}``, and which is only proportional to one, ``{"mic": "~rod.angular_acceleration"}``;
    ``weights`` of columns, 1 unless given: residuals are over each curve's standard deviation.

    ``offset``: where the first sample lies; "free": anywhere in a turn, after ``skip`` turns (3); a number or
    two bounds (s or rad) add to the places of the file. None: free over time where a crank turns, else 0.
    ``compare``: the curves themselves ("curve"), their "envelope" (moving root mean square over a ``width``,
    a fiftieth of the data if not given) or "spectrum", where motions do not repeat. ``step`` (s): one for
    all, the finest that the model's automatic choice takes at the bounds if not given.

    ``screened`` points (64) are run first, the best ``starts`` (4) of them are searched from.
    ``derivatives``: carried along the run ("tangents"), by "differences" of runs in lanes, or the former
    where both agree ("auto"). ``seed`` of the points. ``confidence`` (0.95) of the limits. ``workers``:
    threads, one a core unless given.

    A ``file`` keeps every point as it is computed, and the same call continues it, to the same bits.
    ``confirm``: fit even where it takes more than an hour, half of the memory or of the disk. With Ctrl-C the
    best so far is returned, its status "interrupted".

    Raises ModelError with all faults of arguments, data and parameters, VfifeError where no case has a motion
    or the file is of another fit, and HeldError where another process writes it.
    """
    arguments = Arguments("fit")
    arguments.callable("progress", progress)
    arguments.check()
    task = planned(mechanism, data, parameters, **options)
    with job_of("fit", file, confirm, progress) as job:
        job.begin(task.forecast(file))
        return task.run(file, job)


def planned(
    mechanism: Mechanism,
    data: str | Path | Measured,
    parameters: Mapping[Any, Any] | Sequence[str],
    **options: Unpack[FitOptions],
) -> FitTask:
    """A fit that is understood and not begun; see :func:`fit`. Raises ModelError."""
    arguments, settings = Arguments("fit"), FitSettings(**options)
    arguments.mechanism(mechanism)
    settings.check(arguments)
    if mechanism.settings.analysis == "static":
        raise ModelError(
            [Fault("run.analysis", "a static analysis has no curves over time", "static", "dynamic")],
            mechanism.name,
        )
    if not isinstance(data, Measured):
        data = measured(data, units_of(mechanism), columns_of(settings.columns), settings.weights)
    text = dump(mechanism)
    unknowns = parameters_of(parameters, mechanism)
    offset = offset_of(settings.offset, data, mechanism)
    refuse_few_samples(data, unknowns)
    timing = timing_of(mechanism, text, data, unknowns, offset, settings.skip, settings.step)
    misfit = Misfit(data, offset, settings.skip, settings.compare, envelope_width(settings.width, data))
    return FitTask(mechanism, text, data, unknowns, misfit, timing, settings)


@dataclass(frozen=True)
class FitTask:
    """A fit that is understood: what is identified, from what, and how."""

    mechanism: Mechanism
    text: str
    data: Measured
    parameters: list[FitParameter]
    misfit: Misfit
    timing: Timing
    settings: FitSettings

    @property
    def question(self) -> dict[str, Any]:
        """What decides how well every point fits: fits with the same question have points in common."""
        data, offset, timing = self.data, self.misfit.offset, self.timing
        numbers = hashlib.sha256(data.places.tobytes())
        for one in data.curves:
            numbers.update(
                repr((one.channel, one.head, one.proportional, one.weight)).encode() + one.values.tobytes()
            )
        return {
            "model": self.text, "data": data.name, "numbers": numbers.hexdigest(), "over": data.over,
            "parameters": [[one.name, list(one.paths), one.low, one.high] for one in self.parameters],
            "offset": [offset.low, offset.high, offset.free], "skip": self.misfit.skip,
            "compare": self.misfit.how, "window": self.misfit.window,
            "step": timing.step, "outputs": timing.outputs, "every": timing.every,
            "duration": timing.duration,
        }  # fmt: skip

    @property
    def search(self) -> dict[str, Any]:
        """Settings of the search: what else decides the answer."""
        return {name: getattr(self.settings, name) for name in SEARCH}

    @property
    def runs(self) -> int:
        """Expected number of runs, with derivatives by differences, between searches that end at once and
        those that begin again.
        """
        one_search = EVALUATIONS * (2 * len(self.parameters) + 1)
        return RESTARTS * (self.settings.screened + self.settings.starts * one_search)

    def forecast(self, file: str | Path | None, replace: bool = False) -> Forecast:
        """Forecast of the runs that the file does not have; some are run for it where there are many. Raises
        VfifeError as assembling does.
        """
        one = self.curves().cases.assembled(numbers_at(self.parameters, np.full(len(self.parameters), 0.5)))
        lanes, stored = (
            stream_lanes(len(one.topology.contact_bearing)),
            0 if file is None or replace else self.stored_runs(Path(file)),
        )
        left, values = max(self.runs - stored, 0), self.misfit.count
        at_once = self.settings.starts * (2 * len(self.parameters) + 1)
        table = stream(one, at_once, lanes)
        seconds = table.seconds(left) + COMPARISON * values * left
        if WORTH < seconds < LONG and left > PILOT_RUNS:
            evaluations = Evaluations(self.curves(), self.parameters, self.misfit)
            queries = [
                Query(tuple(place))
                for place in sobol(2 * PILOT_RUNS, len(self.parameters), self.settings.seed)
            ]
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
        """Runs that a fit file has of the same question; all of them if the fit is complete."""
        try:
            with FitFile.open(file) as store:
                return self.runs if store.fit(self.search) is not None else len(store.keys("looks"))
        except VfifeError:  # reported when the fit is continued
            return 0

    def curves(self) -> Curves:
        """What computes curves of cases."""
        return Curves(
            self.mechanism, [one.channel for one in self.data.curves], self.timing, self.settings.workers
        )

    def run(
        self,
        file: str | Path | None = None,
        progress: Callable[[Progress], None] | None = None,
        replace: bool = False,
    ) -> Fit:
        """The whole fit, or the rest of it that the file does not have; with ``replace`` a former file is
        overwritten.
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
        """The file of the fit. Raises VfifeError for one of another fit."""
        return (
            FitFile.create(path, {"fit": self.question}) if replace else FitFile.resume(path, self.question)
        )

    def result(self, file: FitFile | None, progress: Callable[[Progress], None] | None) -> Fit:
        """Search, with the points of a file; Ctrl-C ends it with the best point so far."""
        settings = self.settings
        evaluations = Evaluations(self.curves(), self.parameters, self.misfit, file, progress, self.runs)
        search, slopes = Search(), None
        try:
            Descents(evaluations, search, settings.derivatives).run(
                settings.screened, settings.starts, settings.seed
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
