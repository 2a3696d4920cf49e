"""Points of a fit, computed for several searches at once, side by side in lanes.

Each search is a thread of plain code, because scipy's least squares calls its function one point at a time.
Only when every search waits is everything that they wait for computed, by the thread that began them, which
hears signals. So an answer does not depend on how quick the other searches are, and lanes are full.
"""

from __future__ import annotations

import hashlib
import math
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..job.amounts import span
from ..results.fit import Evaluation, FitFile
from ..solvers.status import Progress
from .curves import Curves
from .parameters import FitParameter
from .residuals import Fitted, Misfit, RunRequest, Slopes, derivative_runs, traces_of

Array = NDArray[np.float64]
Question = TypeVar("Question")
Answer = TypeVar("Answer")


class Abandoned(Exception):
    """No answers come any more."""


class BatchedQueries(Generic[Question, Answer]):
    """Runs searches side by side. Each gets a function that answers a list of questions; ``answer`` answers
    those of all searches at once.
    """

    def __init__(self, answer: Callable[[list[Question]], Sequence[Answer]]) -> None:
        self.answer = answer
        self.changed = threading.Condition()
        self.questions: dict[int, list[Question]] = {}
        self.answers: dict[int, list[Answer]] = {}
        self.running, self.over = 0, False
        self.error: BaseException | None = None

    def run(self, searches: Sequence[Callable[[Callable[[Sequence[Question]], list[Answer]]], None]]) -> None:
        """Return when all have ended. Raises what a search or ``answer`` raised, KeyboardInterrupt too, when
        all have ended.
        """
        self.running = len(searches)
        threads = [
            threading.Thread(target=self._search, args=(k, one), daemon=True)
            for k, one in enumerate(searches)
        ]
        for thread in threads:
            thread.start()
        try:
            self._serve()
        finally:
            with self.changed:
                self.over = True
                self.changed.notify_all()
            for thread in threads:
                thread.join()
        if self.error is not None:
            raise self.error

    def _serve(self) -> None:
        while True:
            with self.changed:
                while self.running and len(self.questions) < self.running and self.error is None:
                    self.changed.wait(0.2)
                if not self.running or self.error is not None:
                    return
                waiting, self.questions = dict(sorted(self.questions.items())), {}
            results = iter(self.answer([one for questions in waiting.values() for one in questions]))
            answers = {k: [next(results) for _ in questions] for k, questions in waiting.items()}
            with self.changed:
                self.answers |= answers
                self.changed.notify_all()

    def _search(self, number: int, search: Callable[[Any], None]) -> None:
        def ask(questions: Sequence[Question]) -> list[Answer]:
            with self.changed:
                self.questions[number] = list(questions)
                self.changed.notify_all()
                while number not in self.answers and not self.over:
                    self.changed.wait()
                if number not in self.answers:
                    raise Abandoned
                return self.answers.pop(number)

        try:
            search(ask)
        except Abandoned:
            pass
        except BaseException as error:
            self.error = error
        finally:
            with self.changed:
                self.running -= 1
                self.changed.notify_all()


@dataclass(frozen=True)
class Query:
    """A point that is wanted: ``shares`` of the ways between the bounds, and an offset ``near`` by that is
    known.

    ``tangents``: derivatives carried along the run (True), as differences of runs (False), or none.
    """

    shares: tuple[float, ...]
    near: float | None = None
    tangents: bool | None = None


@dataclass(frozen=True)
class Point:
    """Curves compared with the samples, None without a motion, for a ``reason``; how far successive turns
    differ; derivatives.
    """

    fitted: Fitted | None
    reason: str = ""
    unsettled: float = 0.0
    slopes: Slopes | None = None


@dataclass
class Evaluations:
    """Computes points, keeps them in a file, and remembers the best of all and what every other one cost."""

    curves: Curves
    parameters: Sequence[FitParameter]
    misfit: Misfit
    file: FitFile | None = None
    progress: Callable[[Progress], None] | None = None
    expected: int = 1
    points: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    best: tuple[float, Array, Point] | None = None
    reasons: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.began, self.runs = time.monotonic(), 0

    def __call__(self, queries: Sequence[Query]) -> list[Point]:
        """Answer all queries at once; points that are not in the file are computed together, and written in
        one transaction.
        """
        stored = [self.stored(one) for one in queries]
        requests = [list(missing(query, one)) for query, one in zip(queries, stored, strict=True)]
        every = [request for some in requests for request in some]
        traces = iter(traces_of(self.curves, self.parameters, every) if every else ())
        rows: list[Evaluation] = []
        points = []
        for query, point, some in zip(queries, stored, requests, strict=True):
            one = (
                self.computed(query, point, [next(traces) for _ in some], rows)
                if some or point is None
                else point
            )
            points.append(one)
        if self.file is not None and rows:
            self.file.add_points(rows)
        for query, one in zip(queries, points, strict=True):
            self.count(query, one)
        self.report()
        return points

    def stored(self, query: Query) -> Point | None:
        """A point in the file; without derivatives where these are not there."""
        row = None if self.file is None else self.file.point(key("curves", query.shares, query.near))
        if row is None:
            return None
        fields, values = row
        if values is None:
            return Point(None, fields["reason"])
        residuals = self.misfit.residuals(values)
        fitted = Fitted(fields["offset"], np.array(fields["gains"]), values, residuals, fields["along"])
        slopes = (
            None
            if query.tangents is None
            else self.stored_slopes(query.shares, fitted.offset, query.tangents)
        )
        return Point(fitted, "", fields["unsettled"], slopes)

    def stored_slopes(self, shares: tuple[float, ...], offset: float, tangents: bool) -> Slopes | None:
        """Derivatives at a point in the file."""
        row = None if self.file is None else self.file.point(key("slopes", shares, offset, tangents))
        return None if row is None else Slopes(np.asarray(row[1]), np.array(row[0]["offsets"]))

    def computed(self, query: Query, point: Point | None, traces: list[Any], rows: list[Evaluation]) -> Point:
        """A point from the runs that were missing; what is new is added to ``rows``."""
        if point is None:
            trace = traces.pop(0)
            if isinstance(trace, str):
                point = Point(None, trace)
            else:
                point = Point(self.misfit(trace, query.near), "", self.misfit.unsettled(trace))
            rows.append((key("curves", query.shares, query.near), *row_of(point)))
        if query.tangents is None or point.fitted is None:
            return point
        if query.tangents and isinstance(
            traces[0], VfifeError
        ):  # there are no tangents here: differences are taken instead
            traces = traces_of(self.curves, self.parameters, derivative_runs(query.shares, False))
            slopes = Slopes.of(traces, self.misfit, query.shares, point.fitted.offset, False)
        else:
            slopes = Slopes.of(traces, self.misfit, query.shares, point.fitted.offset, query.tangents)
        rows.append(slopes_row(query.shares, point.fitted.offset, query.tangents, slopes))
        return replace(point, slopes=slopes)

    def slopes(self, query: Query, point: Point) -> Slopes:
        """Derivatives at a known point. Raises VfifeError where steps carry none along."""
        shares, offset, tangents = (
            query.shares,
            0.0 if point.fitted is None else point.fitted.offset,
            bool(query.tangents),
        )
        if (stored := self.stored_slopes(shares, offset, tangents)) is not None:
            return stored
        traces = traces_of(self.curves, self.parameters, derivative_runs(shares, tangents))
        if isinstance(traces[0], VfifeError):
            raise traces[0]
        slopes = Slopes.of(traces, self.misfit, shares, offset, tangents)
        if self.file is not None:
            self.file.add_points([slopes_row(shares, offset, tangents, slopes)])
        return slopes

    def count(self, query: Query, point: Point) -> None:
        """Count the runs of a point, and remember the best."""
        self.runs += 1 + (0 if query.tangents is None else len(derivative_runs(query.shares, query.tangents)))
        if point.fitted is None:
            self.reasons.append(point.reason)
            return
        cost = point.fitted.cost
        if math.isfinite(cost):
            self.points.append((cost, query.shares))
            if self.best is None or cost < self.best[0]:
                self.best = (cost, np.array(query.shares), point)

    def report(self) -> None:
        """Show progress: runs, residual of the best point, time left."""
        if self.progress is not None:
            best = f", residual {100.0 * self.share:.3g} %" if self.best is not None else ""
            done, seconds = min(self.runs, self.expected), time.monotonic() - self.began
            left = (
                f", some {span(seconds * (self.expected - done) / done)} left"
                if seconds > 1.0 and 0 < done < self.expected
                else ""
            )
            self.progress(Progress(done, self.expected, seconds, f"{self.runs} runs{best}{left}"))

    @property
    def share(self) -> float:
        """Root mean square of the residuals of the best point."""
        return math.inf if self.best is None else math.sqrt(2.0 * self.best[0] / self.misfit.count)


def missing(query: Query, point: Point | None) -> Iterator[RunRequest]:
    """Runs that an answer lacks."""
    if point is None:
        yield RunRequest(query.shares)
    if query.tangents is not None and (point is None or (point.fitted is not None and point.slopes is None)):
        yield from derivative_runs(query.shares, query.tangents)


def row_of(point: Point) -> tuple[dict[str, Any], Array | None]:
    """Row of a point in a fit file, without its key."""
    one = point.fitted
    if one is None:
        return {"reason": point.reason}, None
    return {
        "offset": one.offset,
        "gains": one.gains.tolist(),
        "along": one.along,
        "unsettled": point.unsettled,
    }, one.values


def slopes_row(shares: tuple[float, ...], offset: float, tangents: bool, slopes: Slopes) -> Evaluation:
    """Row of derivatives in a fit file."""
    return key("slopes", shares, offset, tangents), {"offsets": slopes.offsets.tolist()}, slopes.jacobian


def key(what: str, shares: Sequence[float], near: float | None, tangents: bool | None = None) -> str:
    """Key of a row in a fit file."""
    text = f"{what}|{[float(one) for one in shares]!r}|{None if near is None else float(near)!r}|{tangents!r}"
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
