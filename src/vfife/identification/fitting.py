"""Searches of a fit: the first points, which of them are begun from, and the way down from each, side by
side.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

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
from .batched_queries import BatchedQueries, Evaluations, Look, Seen
from .curves import Curves, Timing, units_of
from .extent import few, length, offset_of, timing_of
from .measurements import Measured, columns_of, measured
from .residuals import Fitted, How, Misfit, Slopes, compared
from .sought import Sought, numbers_at
from .sought import parameters as understood
from .step_uncertainty import WEAK, Ended, autocorrelation, concluded

Array = NDArray[np.float64]
Ask = Callable[[list[Look]], list[Seen]]
Derivatives = Literal["auto", "tangents", "differences"]
APART = 0.05  # of the diagonal of the bounds: how far apart starts lie
CLOSE = 1e-6  # relative change of cost and of the parameters at which a search ends
PATIENT, HOPELESS = 8, 30.0  # evaluations after which a search is left whose cost is so many times the best
ROUNDS = 40  # evaluations of one local search, at the most
AGAIN = 3  # times that searches are begun from other points, at the most
LITTLE, FOLLOWS = (
    0.01,
    0.2,
    # of the deviation: what is left and need not be noise; correlation of residuals from which on they are no
    # noise
)
SHARPER = 5.0  # times: what is known so much better than the rest stays, where more points are looked for
AT_ONCE = 16  # first points, so that progress is seen, and lanes are full


class Hopeless(Exception):
    """A search that leads nowhere beside another."""


@dataclass
class Descents:
    """Searches under way. What one of them sees of the others is the best point when its answer came, which
    is the same whoever is quicker.
    """

    looked: Evaluations
    ended: Ended
    derivatives: Derivatives

    def run(self, screened: int, starts: int, seed: int) -> None:
        """All of them; again from other points as long as what the best one leaves is no noise."""
        sought = self.looked.sought
        places = sobol(screened, len(sought), seed)
        if all(one.here is not None for one in sought):
            own = [one.share(one.here) for one in sought if one.here is not None]
            places = np.concatenate([[own], places[: max(screened - 1, 0)]])
        chosen = self.chosen(self.screen(places), starts, [])
        self.choose_derivatives(*chosen[0])
        self.descend_together(chosen)
        for again in range(1, AGAIN + 1):
            if not self.unexplained or self.looked.best is None:
                return
            best = self.looked.best[1]
            found = self.screen(self.further(max(screened // 2, starts), seed + again))
            self.descend_together(self.chosen(found, starts, [best]))

    @property
    def unexplained(self) -> bool:
        """Whether the best point leaves more than noise: residuals that follow one another, as they do where
        a search ended in a wrong place.
        """
        misfit, best = self.looked.misfit, self.looked.best
        if best is None or best[2].fitted is None or misfit.how != "curve" or self.looked.share < LITTLE:
            return False
        parts = misfit.columns(best[2].fitted.residuals).T
        return autocorrelation(list(parts)) > FOLLOWS + 2.0 / math.sqrt(parts.shape[1])

    def further(self, count: int, seed: int) -> Array:
        """Points anew. What the best one knows much more sharply than the rest, as the speed of a drive,
        stays as it is: beside another speed all curves are out of step, and look alike.
        """
        _, shares, seen = self.looked.best or (0.0, np.zeros(0), Seen(None))
        slopes = self.looked.slopes(Look(tuple(shares), None, self.ended.tangents), seen)
        _, sizes, rows = np.linalg.svd(slopes.jacobian, full_matrices=False)
        spread = (
            np.sqrt(((rows.T / np.maximum(sizes, WEAK * sizes[0])) ** 2).sum(axis=1))
            if sizes[0] > 0.0
            else np.ones(len(shares))
        )
        open_ = np.flatnonzero(spread >= spread.max() / SHARPER)
        places = np.tile(shares, (count, 1))
        places[:, open_] = sobol(count, len(open_), seed)
        return places

    def screen(self, places: Array) -> list[tuple[Array, Fitted]]:
        """Points with their curves, the best first. Raises VfifeError where none has a motion."""
        found: list[tuple[Array, Fitted]] = []
        for first in range(0, len(places), AT_ONCE):
            some = places[first : first + AT_ONCE]
            seen = self.looked([Look(tuple(one)) for one in some])
            found += [(at, one.fitted) for at, one in zip(some, seen, strict=True) if one.fitted is not None]
        if not found:
            raise VfifeError(
                f"none of {len(places)} members has a motion: {self.looked.reasons[0]}; correct the bounds"
            )
        return sorted(found, key=lambda one: one[1].cost)

    def chosen(
        self, found: list[tuple[Array, Fitted]], starts: int, known: list[Array]
    ) -> list[tuple[Array, Fitted]]:
        """The best points that are far enough from each other and from those that are ``known``."""
        chosen: list[tuple[Array, Fitted]] = []
        for at, one in found:
            there = [*known, *(other for other, _ in chosen)]
            if len(chosen) < starts and all(
                np.linalg.norm(at - other) > APART * math.sqrt(len(at)) for other in there
            ):
                chosen.append((at, one))
        return chosen

    def descend_together(self, chosen: list[tuple[Array, Fitted]]) -> None:
        """Searches from several points, side by side."""
        BatchedQueries(self.looked).run([lambda ask, at=at: self.descend(ask, *at) for at in chosen])  # type: ignore[misc]

    def choose_derivatives(self, shares: Array, one: Fitted) -> None:
        """Tangents where differences of runs say the same; where they do not, an end of a contact or a far
        neighbour decides, and a tangent of one run leads nowhere.
        """
        if self.derivatives == "differences":
            return
        at = tuple(shares)
        seen = Seen(one)
        try:
            by_steps = self.looked.slopes(Look(at, one.offset, True), seen)
        except VfifeError as error:
            if self.derivatives == "tangents":
                raise
            self.ended.notes.append(f"no derivatives were carried along: {' '.join(str(error).split())}")
            return
        self.ended.tangents = self.derivatives == "tangents" or compared(
            by_steps, self.looked.slopes(Look(at, one.offset, False), seen)
        )

    def descend(self, ask: Ask, start: Array, first: Fitted) -> None:
        """One search from a start. A member and what its derivatives need are asked for at once: lanes have
        room for them.
        """
        from scipy.optimize import least_squares

        near, count, misfit = first.offset, 0, self.looked.misfit
        met: dict[bytes, tuple[Array, Slopes | None]] = {}

        def at(shares: Array) -> tuple[Array, Slopes | None]:
            nonlocal near, count
            if (key := shares.tobytes()) not in met:
                (seen,) = ask([Look(tuple(shares), near, self.ended.tangents)])
                if seen.fitted is None:
                    met[key] = misfit.lost, None
                else:
                    near, count = seen.fitted.offset, count + 1
                    met[key] = seen.fitted.residuals, seen.slopes
                    if (
                        count > PATIENT
                        and self.looked.best is not None
                        and seen.fitted.cost > HOPELESS * self.looked.best[0]
                    ):
                        raise Hopeless
            return met[key]

        def jacobian(shares: Array) -> Array:
            slopes = at(shares)[1]
            return slopes.jacobian if slopes is not None else np.zeros((misfit.count, len(shares)))

        inside, tight = (
            np.clip(start, 1e-6, 1.0 - 1e-6),
            {"ftol": CLOSE, "xtol": CLOSE, "gtol": 1e-12, "max_nfev": ROUNDS},
        )
        try:
            found: Any = least_squares(
                lambda shares: at(shares)[0], inside, jacobian, (0.0, 1.0), "trf", **tight
            )
        except Hopeless:
            return
        values = (float(one.value(x)) for one, x in zip(self.looked.sought, found.x, strict=True))
        self.ended.searches.append((float(found.cost), tuple(values)))


MOST_SKIPPED = 100_000  # turns
GUESS = 8  # evaluations that a search from one start usually takes: for forecast and progress alone
# runs of a fit, by those of its first searches: one to four, as residuals are noise or searches begin again
TWICE = 2
PILOT_RUNS = 8  # points that are run for a forecast
LAID = 2e-6  # s that a sample of a curve takes, laid on a run at all offsets that are tried
COMPRESSED = 0.9  # bytes of a fit file, by those of its numbers


def fit(
    mechanism: Mechanism,
    data: str | Path | Measured,
    parameters: Mapping[Any, Any] | Sequence[str],
    *,
    columns: Sequence[str] | Mapping[str, str] | None = None,
    weights: Mapping[str, float] | None = None,
    offset: str | float | tuple[Any, Any] | None = None,
    skip: float = 3.0,
    compare: How = "curve",
    width: str | float | None = None,
    step: float | str | None = None,
    screened: int = 64,
    starts: int = 4,
    confidence: float = 0.95,
    derivatives: Derivatives = "auto",
    seed: int = 0,
    workers: int | None = None,
    file: str | Path | None = None,
    progress: Callable[[Progress], None] | None = None,
    confirm: bool = False,
) -> Fit:
    """Finds numbers of a mechanism from measured curves: a CSV file with time or crank_angle and channels of
    a result as columns.

    ``parameters``: what is looked for, as ``{"joint.C.clearance": ("0.1 mm", "1 mm")}``, several paths in one
    key being one number; or texts, ``"joint.C.clearance=0.1..1 mm"``. ``columns`` says which column is which
    channel, ``{"acc": "C.force"}``, and which is only proportional to one,
    ``{"mic": "~rod.angular_acceleration"}``; ``weights`` of columns, 1 unless said: residuals are over each
    curve's standard deviation.

    ``offset``: where the first sample lies; "free": anywhere in a turn, after ``skip`` turns; a number or two
    bounds (s or rad) add to the places of the file. None: free over time where a crank turns, else 0.
    ``compare``: the curves themselves, their "envelope" (moving root mean square over a ``width``, a fiftieth
    of the data if not given) or "spectrum", where motions do not repeat. ``step`` (s): one for all, the
    finest that the model's automatic choice takes at the bounds if not given.

    ``screened`` points are run first, the best ``starts`` of them are searched from. ``derivatives``: carried
    along the run ("tangents"), by "differences" of runs in lanes, or the former where both agree. ``seed`` of
    the points. With a ``file`` every point is kept in it as it is known, and the same call goes on there, to
    the same bits. ``confirm``: fit even where it takes more than an hour, half of the memory or of the disk.
    With Ctrl-C the best so far is returned, its status "interrupted".

    Raises ModelError with all faults of arguments, data and parameters, VfifeError where no member of them
    has a motion or the file asks something else, and HeldError where another process writes it.
    """
    given = Arguments("fit")
    given.callable("progress", progress)
    given.check()
    task = planned(
        mechanism, data, parameters, columns=columns, weights=weights, offset=offset, skip=skip, compare=compare, width=width, step=step,
        screened=screened, starts=starts, confidence=confidence, derivatives=derivatives, seed=seed, workers=workers,
    )  # fmt: skip
    with job_of("fit", file, confirm, progress) as job:
        job.begin(task.forecast(file))
        return task.run(file, job)


def planned(
    mechanism: Mechanism, data: str | Path | Measured, parameters: Mapping[Any, Any] | Sequence[str], *,
    columns: Sequence[str] | Mapping[str, str] | None, weights: Mapping[str, float] | None, offset: Any, skip: float, compare: How,
    width: str | float | None, step: float | str | None, screened: int, starts: int, confidence: float, derivatives: Derivatives, seed: int,
    workers: int | None = None,
) -> Task:  # fmt: skip
    """A fit that is understood and not begun; see :func:`fit`. Raises ModelError."""
    given = Arguments("fit")
    given.mechanism(mechanism)
    for name, value in {"screened": screened, "starts": starts, "workers": workers}.items():
        given.count(name, value, optional=name == "workers")
    for name, word, words in (
        ("compare", compare, get_args(How)),
        ("derivatives", derivatives, get_args(Derivatives)),
    ):
        if word not in words:
            given.fault(
                name,
                "this is none of the words",
                word,
                " or ".join(f'"{one}"' for one in words),
                "name one of them",
            )
    if not 0.0 < confidence < 1.0:
        given.fault(
            "confidence", "this is no share", confidence, "above 0 and below 1", "write 0.95 for 95 per cent"
        )
    if not 0.0 <= skip < MOST_SKIPPED:
        given.fault("skip", "out of range", skip, f"0 to {MOST_SKIPPED:,} turns", "give fewer")
    given.check()
    if mechanism.settings.analysis == "static":
        raise ModelError(
            [Fault("run.analysis", "a static analysis has no curves over time", "static", "dynamic")],
            mechanism.name,
        )
    seen = (
        data
        if isinstance(data, Measured)
        else measured(data, units_of(mechanism), columns_of(columns), weights)
    )
    text = dump(mechanism)
    sought = understood(parameters, mechanism)
    laid = offset_of(offset, seen, mechanism)
    few(seen, sought)
    timing = timing_of(mechanism, text, seen, sought, laid, skip, step)
    misfit = Misfit(seen, laid, skip, compare, length(width, seen))
    return Task(
        mechanism,
        text,
        seen,
        sought,
        misfit,
        timing,
        screened,
        starts,
        seed,
        confidence,
        derivatives,
        workers,
    )


@dataclasses.dataclass(frozen=True)
class Task:
    """A fit that is understood: what is looked for, in what, and how."""

    mechanism: Mechanism
    text: str
    seen: Measured
    sought: list[Sought]
    misfit: Misfit
    timing: Timing
    screened: int
    starts: int
    seed: int
    confidence: float
    derivatives: Derivatives
    workers: int | None

    @property
    def asked(self) -> dict[str, Any]:
        """What decides how every point fits: two fits that ask the same have points in common."""
        seen, offset, timing = self.seen, self.misfit.offset, self.timing
        numbers = hashlib.sha256(seen.places.tobytes())
        for one in seen.curves:
            numbers.update(
                repr((one.channel, one.head, one.proportional, one.weight)).encode() + one.values.tobytes()
            )
        return {
            "model": self.text, "data": seen.name, "numbers": numbers.hexdigest(), "over": seen.over,
            "parameters": [[one.name, list(one.paths), one.low, one.high] for one in self.sought],
            "offset": [offset.low, offset.high, offset.free], "skip": self.misfit.skip, "compare": self.misfit.how, "window": self.misfit.window,
            "step": timing.step, "outputs": timing.outputs, "every": timing.every, "duration": timing.duration,
        }  # fmt: skip

    @property
    def how(self) -> dict[str, Any]:
        """How it is looked for: what else decides what is found."""
        return {
            name: getattr(self, name) for name in ("screened", "starts", "seed", "confidence", "derivatives")
        }

    @property
    def runs(self) -> int:
        """About so many, with derivatives by differences: between searches that end at once and those that
        begin again.
        """
        return TWICE * (self.screened + self.starts * GUESS * (2 * len(self.sought) + 1))

    def forecast(self, file: str | Path | None, replace: bool = False) -> Forecast:
        """The forecast of the runs that the file does not have; the first points are run for it where there
        are many. Raises VfifeError as assembling
        does.
        """
        one = self.curves().cases.assembled(numbers_at(self.sought, np.full(len(self.sought), 0.5)))
        lanes, known = (
            stream_lanes(len(one.topology.contact_bearing)),
            0 if file is None or replace else self.known(Path(file)),
        )
        left, values, together = (
            max(self.runs - known, 0),
            self.misfit.count,
            self.starts * (2 * len(self.sought) + 1),
        )
        table = stream(one, together, lanes)
        seconds = table.seconds(left) + LAID * values * left
        if WORTH < seconds < LONG and left > PILOT_RUNS:
            looked = Evaluations(self.curves(), self.sought, self.misfit)
            looks = [Look(tuple(place)) for place in sobol(2 * PILOT_RUNS, len(self.sought), self.seed)]
            looked(looks[:PILOT_RUNS])  # compiles
            each = timed(lambda: looked(looks[PILOT_RUNS:])) / PILOT_RUNS
            seconds = Stream(max(each - table.stepping, 0.0), min(each, table.stepping), together).seconds(
                left
            )
        memory = RECORD_COPIES * run_cost(one).bytes * min(cores() * lanes, self.runs) + LIBRARIES
        remedy = "give fewer points (screened, starts), a shorter piece of the data or a coarser step"
        beside = f" beside {known:,} that are there" if known else ""
        return Forecast(
            "run", left, one.choice.steps, seconds, memory, COMPRESSED * 8.0 * values * left, known, cores(), lanes, less=remedy,
            work=f"about {counted(left, 'run')} of {one.choice.steps:,} steps{beside}", note="; half or twice of that by how the searches go",
        )  # fmt: skip

    def known(self, file: Path) -> int:
        """Runs that a fit file has of the same question; all of them where it was answered."""
        try:
            with FitFile.open(file) as found:
                return self.runs if found.fit(self.how) is not None else len(found.keys("looks"))
        except VfifeError:  # reported when the fit goes on with it
            return 0

    def curves(self) -> Curves:
        """What makes curves of members."""
        return Curves(self.mechanism, [one.channel for one in self.seen.curves], self.timing, self.workers)

    def run(
        self,
        file: str | Path | None = None,
        progress: Callable[[Progress], None] | None = None,
        replace: bool = False,
    ) -> Fit:
        """The whole fit, or the rest of it that the file does not have; with ``replace`` what is there gives
        way.
        """
        if file is None:
            return self.found(None, progress)
        with (
            Lock(Path(file).absolute().parent, f"{Path(file).name}.lock", "this fit"),
            self.opened(Path(file), replace) as kept,
        ):
            before = kept.fit(self.how)
            if before is not None and before.status == "complete":
                return before
            found = self.found(kept, progress)
            kept.conclude(found, self.how)
            return found

    def opened(self, path: Path, replace: bool) -> FitFile:
        """The file of the fit. Raises VfifeError for one that asks something else."""
        return FitFile.create(path, {"fit": self.asked}) if replace else FitFile.resume(path, self.asked)

    def found(self, file: FitFile | None, progress: Callable[[Progress], None] | None) -> Fit:
        """What is found, with the points of a file."""
        looked = Evaluations(self.curves(), self.sought, self.misfit, file, progress, self.runs)
        ended, slopes = Ended(), None
        try:
            descents = Descents(looked, ended, self.derivatives)
            descents.run(self.screened, self.starts, self.seed)
            if looked.best is not None:
                slopes = looked.slopes(Look(tuple(looked.best[1]), None, ended.tangents), looked.best[2])
            return concluded(
                self.mechanism.name,
                self.seen,
                units_of(self.mechanism),
                looked,
                ended,
                slopes,
                self.confidence,
            )
        except KeyboardInterrupt:
            if looked.best is None:
                raise
            return concluded(
                self.mechanism.name, self.seen, units_of(self.mechanism), looked, ended, None, self.confidence
            )
