"""Points of a fit, computed for several searches at once, side by side in lanes.

Each search is a thread, because scipy's least squares calls its function one point at a time. When every
search waits, all points for which they wait are computed together by the main thread, which also receives
signals. Lanes are full, and an answer does not depend on the speed of the other searches: a queue that is
served at once would group points by chance, and Ctrl-C would reach the wrong thread.
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
from ..job.progress import span
from ..results.fit import Evaluation, FitFile
from ..solvers.status import Progress
from .parameters import FitParameter
from .residuals import FitRecord, Fitted, RunRequest, Slopes, derivative_runs, traces_of

Array = NDArray[np.float64]
Question = TypeVar("Question")
Answer = TypeVar("Answer")


class Abandoned(Exception):
    """Raised in a search when no more answers will come, because another one failed or was interrupted."""


class BatchedQueries(Generic[Question, Answer]):
    """Run searches side by side; ``answer`` computes the answers to the questions of all searches at once.

    Each search gets a function that takes a list of questions and returns a list of answers.
    """

    def __init__(self, answer: Callable[[list[Question]], Sequence[Answer]]) -> None:
        self.answer = answer
        self.changed = threading.Condition()
        self.questions: dict[int, list[Question]] = {}
        self.answers: dict[int, list[Answer]] = {}
        self.running, self.ended = 0, False
        self.error: BaseException | None = None

    def run(self, searches: Sequence[Callable[[Callable[[Sequence[Question]], list[Answer]]], None]]) -> None:
        """Run ``searches`` and return when all have ended.

        Raises, after all have ended, the exception of a search or of ``answer``, KeyboardInterrupt included.
        """
        self.running = len(searches)
        threads = [
            threading.Thread(target=self._search, args=(k, search), daemon=True)
            for k, search in enumerate(searches)
        ]
        for thread in threads:
            thread.start()
        try:
            self._serve()
        finally:
            with self.changed:
                # Searches that still wait for answers raise Abandoned, so that join returns.
                self.ended = True
                self.changed.notify_all()
            for thread in threads:
                thread.join()
        if self.error is not None:
            raise self.error

    def _serve(self) -> None:
        while True:
            with self.changed:
                while self.running and len(self.questions) < self.running and self.error is None:
                    # A wait without a limit would keep Ctrl-C from the main thread on some systems.
                    self.changed.wait(0.2)
                if not self.running or self.error is not None:
                    return
                # In the order of the searches, not of their arrival: the same points share lanes every time.
                waiting, self.questions = dict(sorted(self.questions.items())), {}
            results = iter(
                self.answer([question for questions in waiting.values() for question in questions])
            )
            answers = {k: [next(results) for _ in questions] for k, questions in waiting.items()}
            with self.changed:
                self.answers |= answers
                self.changed.notify_all()

    def _search(self, number: int, search: Callable[[Any], None]) -> None:
        def ask(questions: Sequence[Question]) -> list[Answer]:
            with self.changed:
                self.questions[number] = list(questions)
                self.changed.notify_all()
                while number not in self.answers and not self.ended:
                    self.changed.wait()
                if number not in self.answers:
                    raise Abandoned
                return self.answers.pop(number)

        try:
            search(ask)
        except Abandoned:
            pass
        except BaseException as error:
            # The main thread sees the error in _serve, ends all searches and raises it there: an exception in
            # a thread would be printed and lost.
            self.error = error
        finally:
            with self.changed:
                self.running -= 1
                self.changed.notify_all()


Offsets = tuple[float, ...]


@dataclass(frozen=True)
class Query:
    """A requested point: ``shares`` of the ways between the bounds, and known ``offsets`` near which the
    best ones lie, one a record.

    ``tangents``: derivatives carried along the run (True), as differences of runs (False), or none.
    """

    shares: tuple[float, ...]
    offsets: Offsets | None = None
    tangents: bool | None = None

    def of(self, record: FitRecord, number: int) -> Query:
        """Return the part of the query that concerns one record."""
        shares = tuple(self.shares[k] for k in record.places())
        return Query(shares, None if self.offsets is None else (self.offsets[number],), self.tangents)


@dataclass(frozen=True)
class Point:
    """Curves of a record compared with the samples, None without a motion, for a ``reason``; how far
    successive turns differ; derivatives.
    """

    fitted: Fitted | None
    reason: str = ""
    unsettled: float = 0.0
    slopes: Slopes | None = None


@dataclass(frozen=True)
class Outcome:
    """The points of all records at the same parameters, and all their derivatives."""

    points: tuple[Point, ...]
    slopes: Slopes | None = None

    @property
    def fitted(self) -> list[Fitted]:
        """The curves of every record; empty where one of them has no motion."""
        fitted = [point.fitted for point in self.points if point.fitted is not None]
        return fitted if len(fitted) == len(self.points) else []

    @property
    def reason(self) -> str:
        """Why there is no motion."""
        return next((point.reason for point in self.points if point.fitted is None), "")

    @property
    def residuals(self) -> Array:
        """Residuals of all records, one after the other."""
        return np.concatenate([curves.residuals for curves in self.fitted])

    @property
    def cost(self) -> float:
        """Half the sum of squares."""
        return sum(curves.cost for curves in self.fitted)

    @property
    def offsets(self) -> Offsets:
        """Offset of each record."""
        return tuple(curves.offset for curves in self.fitted)

    @property
    def unsettled(self) -> float:
        """How far successive turns differ, at most."""
        return max(point.unsettled for point in self.points)


# Share of the runs of a stage that it still needs if it is longer than usual, for progress only.
LONGER = 0.25


@dataclass
class Evaluations:
    """Compute points, store them in a file, and keep the best one and the cost of all others."""

    records: Sequence[FitRecord]
    parameters: Sequence[FitParameter]
    file: FitFile | None = None
    progress: Callable[[Progress], None] | None = None
    points: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    best: tuple[float, Array, Outcome] | None = None
    reasons: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.began = time.monotonic()
        # Of runs without derivatives and with them: number, usual number at the end of the stage and after
        # it, calls and time (s) of a run in the latest of them.
        self.counts, self.stage_end, self.later = np.zeros(2, dtype=int), np.ones(2), np.zeros(2)
        self.stage_begin = np.zeros(2)
        self.calls, self.paces = np.zeros(2, dtype=int), np.zeros(2)
        self.rows: list[Evaluation] = []  # to write
        self.mark: list[Any] | None = None  # cost, shares and offsets of a new best point, to write with them

    @property
    def runs(self) -> int:
        """Number of runs."""
        return int(self.counts.sum())

    def begin(self, stage: Array, later: Array) -> None:
        """Begin a stage of a fit with about as many runs, without and with derivatives, and as many after
        it.
        """
        self.stage_begin, self.stage_end, self.later = self.counts.copy(), self.counts + stage, later

    @property
    def left(self) -> Array:
        """Numbers of runs, without and with derivatives, that are left if stages are as long as usual, or
        longer by a share of what is done.
        """
        longer = LONGER * (self.counts - self.stage_begin)
        return np.asarray(np.maximum(self.stage_end - self.counts, longer) + self.later)

    @property
    def expected(self) -> int:
        """Number of runs of the whole fit, if its stages are as long as usual."""
        return self.runs + math.ceil(float(self.left.sum()))

    def __call__(self, queries: Sequence[Query]) -> list[Outcome]:
        """Return the points of all queries; those that are not in the file are computed together and written
        in one transaction.
        """
        points = iter(self.answers([part for query in queries for part in self.parts(query)]))
        outcomes = [self.joined(tuple(next(points) for _ in self.records)) for _ in queries]
        for query, outcome in zip(queries, outcomes, strict=True):
            self.count(query, outcome)
        self.write()
        self.report()
        return outcomes

    def write(self) -> None:
        """Write what was computed, and which point is the best, in one transaction."""
        if self.file is not None and (self.rows or self.mark):
            self.file.add_points(self.rows, self.mark)
        self.rows, self.mark = [], None

    def parts(self, query: Query) -> list[tuple[FitRecord, Query]]:
        """Return each record with its part of a query."""
        return [(record, query.of(record, k)) for k, record in enumerate(self.records)]

    def answers(self, parts: Sequence[tuple[FitRecord, Query]]) -> list[Point]:
        """Points of records; those that are not in the file are computed together."""
        return self.completed(parts, [self.stored(record, query) for record, query in parts])

    def completed(
        self, parts: Sequence[tuple[FitRecord, Query]], points: Sequence[Point | None], strict: bool = False
    ) -> list[Point]:
        """Return the points of records with what they lack, computed together; :meth:`write` has to follow.
        With ``strict`` raise VfifeError where no tangents exist, else take differences there.
        """
        requests = [list(missing(*part, point)) for part, point in zip(parts, points, strict=True)]
        # One call for the runs of all points fills the lanes. One call for each point would leave most of
        # them idle.
        runs = [request for group in requests for request in group]
        began = time.monotonic()
        traces = iter(traces_of(runs) if runs else ())
        answers = []
        for (record, query), point, group in zip(parts, points, requests, strict=True):
            if group or point is None:
                point = self.computed(record, query, point, [next(traces) for _ in group], strict)
            answers.append(point)
        if runs:
            kind = int(any(query.tangents is not None for _, query in parts))
            self.calls[kind] += 1
            self.paces[kind] = (time.monotonic() - began) / len(runs)
        return answers

    def joined(self, points: tuple[Point, ...]) -> Outcome:
        """Combine the points of all records into one outcome, with derivatives if every point has them."""
        slopes = [point.slopes for point in points if point.slopes is not None]
        return Outcome(points, self.all_slopes(slopes) if len(slopes) == len(points) else None)

    def all_slopes(self, slopes: Sequence[Slopes]) -> Slopes:
        """Return the derivatives of all residuals by all parameters (residuals, parameters), and those of the
        offsets (records, parameters).
        """
        count, row = len(self.parameters), 0
        jacobian = np.zeros((sum(len(record_slopes.jacobian) for record_slopes in slopes), count))
        offsets = np.zeros((len(slopes), count))
        for k, (record, record_slopes) in enumerate(zip(self.records, slopes, strict=True)):
            jacobian[row : row + len(record_slopes.jacobian), record.places()] = record_slopes.jacobian
            offsets[k, record.places()] = record_slopes.offsets
            row += len(record_slopes.jacobian)
        return Slopes(jacobian, offsets)

    def stored(self, record: FitRecord, query: Query) -> Point | None:
        """Return a point in the file, or None; without derivatives if these are not stored."""
        row = None if self.file is None else self.file.point(key(f"curves{record.key}", query))
        if row is None:
            return None
        fields, values = row
        if values is None:
            return Point(None, fields["reason"])
        residuals = record.misfit.residuals(values)
        fitted = Fitted(fields["offset"], np.array(fields["gains"]), values, residuals, fields["along"])
        slopes = None if query.tangents is None else self.stored_slopes(record, query, fitted.offset)
        return Point(fitted, "", fields["unsettled"], slopes)

    def stored_slopes(self, record: FitRecord, query: Query, offset: float) -> Slopes | None:
        """Return the derivatives at a point in the file, or None."""
        row = None if self.file is None else self.file.point(slopes_key(record, query, offset))
        return None if row is None else Slopes(np.asarray(row[1]), np.array(row[0]["offsets"]))

    def computed(
        self, record: FitRecord, query: Query, point: Point | None, traces: list[Any], strict: bool
    ) -> Point:
        """Return a point from the ``traces`` of missing runs; add what is new to the ``rows``."""
        misfit = record.misfit
        if point is None:
            trace = traces.pop(0)
            if isinstance(trace, str):
                point = Point(None, trace)
            else:
                guess = None if query.offsets is None else query.offsets[0]
                point = Point(misfit(trace, guess), "", misfit.unsettled(trace))
            self.rows.append((key(f"curves{record.key}", query), *row_of(point)))
        if query.tangents is None or point.fitted is None:
            return point
        by_tangents, offset = query.tangents, point.fitted.offset
        if by_tangents and isinstance(traces[0], VfifeError):
            if strict:
                raise traces[0]
            traces, by_tangents = traces_of(derivative_runs(record, query.shares, False)), False
        slopes = Slopes.of(traces, misfit, query.shares, offset, by_tangents)
        self.rows.append(slopes_row(record, query, offset, slopes))
        return replace(point, slopes=slopes)

    def slopes(self, query: Query, outcome: Outcome) -> Slopes:
        """Return the derivatives at an evaluated point, from tangents of the steps or else from differences.
        Raises VfifeError where no tangents exist.
        """
        parts = self.parts(replace(query, tangents=bool(query.tangents)))
        points = [
            replace(point, slopes=self.stored_slopes(record, part, offset))
            for (record, part), point, offset in zip(parts, outcome.points, outcome.offsets, strict=True)
        ]
        completed = self.completed(parts, points, strict=True)
        self.write()
        return self.all_slopes([point.slopes for point in completed if point.slopes is not None])

    def count(self, query: Query, outcome: Outcome) -> None:
        """Count the runs of a point, and remember the best."""
        for record, part in self.parts(query):
            derivatives = [] if part.tangents is None else derivative_runs(record, part.shares, part.tangents)
            self.counts[int(part.tangents is not None)] += 1 + len(derivatives)
        if not outcome.fitted:
            self.reasons.append(outcome.reason)
            return
        cost = outcome.cost
        # A cost that is not finite is neither the best nor a point with which others can be compared.
        if math.isfinite(cost):
            self.points.append((cost, query.shares))
            if self.best is None or cost < self.best[0]:
                self.best = (cost, np.array(query.shares), outcome)
                if self.file is not None and cost < self.least_stored[0]:
                    shares = [float(share) for share in query.shares]
                    self.mark = [cost, shares, query.offsets]

    @property
    def least_stored(self) -> tuple[float, Query]:
        """Cost and query of the best point of all fits in the file; infinite where no point is marked."""
        row = None if self.file is None else self.file.get("found", "best", "told")
        cost, shares, offsets = (math.inf, (), None) if row is None else row["point"]
        return cost, Query(tuple(shares), None if offsets is None else tuple(offsets))

    def recall(self) -> None:
        """Take the best point of all fits in the file if it leaves less than the best one of this fit."""
        cost, query = self.least_stored
        if self.best is not None and cost < self.best[0]:
            self.count(query, self.joined(tuple(self.answers(self.parts(query)))))
            self.write()

    def finish(self) -> None:
        """Report that nothing is left to run."""
        self.begin(np.zeros(2), np.zeros(2))
        self.report()

    def report(self) -> None:
        """Report progress: runs, residual of the best point, time left."""
        if self.progress is not None:
            best = f", residual {100.0 * self.share:.3g} %" if self.best is not None else ""
            seconds, expected = time.monotonic() - self.began, self.expected
            left = self.time_left() if self.runs < expected else ""
            self.progress(Progress(self.runs, expected, seconds, f"{self.runs} runs{best}{left}"))

    def time_left(self) -> str:
        """Return the time that the rest of the fit usually takes at the pace of the latest runs, as text.

        Points with derivatives are slower, and the first call compiles: until the second one there is no
        pace, and before the first search that of runs without derivatives.
        """
        if self.calls[0] < 2:
            return ""
        paces = self.paces if self.calls[1] > 1 else self.paces[[0, 0]]
        return f", about {span(float(paces @ self.left))} left"

    @property
    def residuals(self) -> int:
        """Residuals of all records."""
        return sum(record.misfit.count for record in self.records)

    @property
    def penalty(self) -> Array:
        """Residuals where a record has no curves."""
        return np.concatenate([record.misfit.penalty for record in self.records])

    @property
    def share(self) -> float:
        """Root mean square of the residuals of the best point (1, of the data's deviation)."""
        return math.inf if self.best is None else math.sqrt(2.0 * self.best[0] / self.residuals)


def missing(record: FitRecord, query: Query, point: Point | None) -> Iterator[RunRequest]:
    """Yield the runs that the answer to a query still needs."""
    if point is None:
        yield RunRequest(record, query.shares)
    if query.tangents is not None and (point is None or (point.fitted is not None and point.slopes is None)):
        yield from derivative_runs(record, query.shares, query.tangents)


def row_of(point: Point) -> tuple[dict[str, Any], Array | None]:
    """Return the row of a point in a fit file, without its key."""
    fitted = point.fitted
    if fitted is None:
        return {"reason": point.reason}, None
    return {
        "offset": fitted.offset,
        "gains": fitted.gains.tolist(),
        "along": fitted.curvature,
        "unsettled": point.unsettled,
    }, fitted.values


def slopes_row(record: FitRecord, query: Query, offset: float, slopes: Slopes) -> Evaluation:
    """Return the row of derivatives in a fit file, with its key."""
    return slopes_key(record, query, offset), {"offsets": slopes.offsets.tolist()}, slopes.jacobian


def slopes_key(record: FitRecord, query: Query, offset: float) -> str:
    """Key of derivatives in a fit file, taken at an offset."""
    return key(f"slopes{record.key}", replace(query, offsets=(offset,)), query.tangents)


def key(kind: str, query: Query, tangents: bool | None = None) -> str:
    """Return the key of a row in a fit file: a digest of the exact numbers of its query."""
    offset = None if query.offsets is None else float(query.offsets[0])
    text = f"{kind}|{[float(share) for share in query.shares]!r}|{offset!r}|{tangents!r}"
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
