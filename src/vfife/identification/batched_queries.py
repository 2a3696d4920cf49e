"""Several searches that ask for members at once: what all of them wait for is computed together, in lanes.

Each search is a thread of plain code. When every one of them waits, what they asked for is computed by the
thread that began them, which hears signals; so what a search sees does not depend on how quick the others
are.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..job.amounts import span
from ..results.fit import Evaluation, FitFile
from ..solvers.status import Progress
from .curves import Curves, Trace
from .residuals import Fitted, Misfit, Point, Slopes, answers, questions
from .sought import Sought

Question = TypeVar("Question")
Answer = TypeVar("Answer")


class Abandoned(Exception):
    """Nobody answers any more."""


class BatchedQueries(Generic[Question, Answer]):
    """Runs searches side by side; each gets a function that answers a list of questions. ``answer`` answers
    those of all of them at once.
    """

    def __init__(self, answer: Callable[[list[Question]], Sequence[Answer]]) -> None:
        self.answer = answer
        self.changed = threading.Condition()
        self.asked: dict[int, list[Question]] = {}
        self.answers: dict[int, list[Answer]] = {}
        self.running, self.over = 0, False
        self.trouble: BaseException | None = None

    def run(self, searches: Sequence[Callable[[Callable[[Sequence[Question]], list[Answer]]], None]]) -> None:
        """Returns when all have ended. Raises what a search or ``answer`` raised, KeyboardInterrupt among it,
        when all have left.
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
        if self.trouble is not None:
            raise self.trouble

    def _serve(self) -> None:
        while True:
            with self.changed:
                while self.running and len(self.asked) < self.running and self.trouble is None:
                    self.changed.wait(0.2)
                if not self.running or self.trouble is not None:
                    return
                asked, self.asked = dict(sorted(self.asked.items())), {}
            every = iter(self.answer([one for questions in asked.values() for one in questions]))
            answers = {k: [next(every) for _ in questions] for k, questions in asked.items()}
            with self.changed:
                self.answers |= answers
                self.changed.notify_all()

    def _search(self, number: int, search: Callable[[Any], None]) -> None:
        def ask(questions: Sequence[Question]) -> list[Answer]:
            with self.changed:
                self.asked[number] = list(questions)
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
            self.trouble = error
        finally:
            with self.changed:
                self.running -= 1
                self.changed.notify_all()


Array = NDArray[np.float64]


@dataclass(frozen=True)
class Look:
    """A question: the curves at shares of the ways between the bounds, their offset ``near`` one that is
    known, and derivatives, carried along (``by_steps``), as differences of runs, or none.
    """

    shares: tuple[float, ...]
    near: float | None = None
    by_steps: bool | None = None


@dataclass(frozen=True)
class Seen:
    """The answer: curves laid on the samples, None without a motion, for a ``reason``; how far its turns
    differ; derivatives.
    """

    fitted: Fitted | None
    reason: str = ""
    unsettled: float = 0.0
    slopes: Slopes | None = None


@dataclass
class Evaluations:
    """Answers questions, and keeps the best point of all and what every other one cost."""

    curves: Curves
    sought: Sequence[Sought]
    misfit: Misfit
    file: FitFile | None = None
    progress: Callable[[Progress], None] | None = None
    expected: int = 1
    points: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    best: tuple[float, Array, Seen] | None = None
    reasons: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.began, self.runs, self.made = time.monotonic(), 0, 0

    def __call__(self, looks: Sequence[Look]) -> list[Seen]:
        """Answers of all at once; what is not kept is computed together, and kept in one transaction."""
        seen = [self.known(one) for one in looks]
        asked = [list(missing(look, one)) for look, one in zip(looks, seen, strict=True)]
        points = [point for some in asked for point in some]
        found = iter(answers(self.curves, self.sought, points) if points else ())
        rows: list[Evaluation] = []
        for k, (look, some) in enumerate(zip(looks, asked, strict=True)):
            if some:
                seen[k] = self.taken(look, seen[k], [next(found) for _ in some], rows)
        if self.file is not None and rows:
            self.file.add_points(rows)
        self.made += len(points)
        told = [one for one in seen if one is not None]
        for look, one in zip(looks, told, strict=True):
            self.note(look, one)
        self.tell()
        return told

    def known(self, look: Look) -> Seen | None:
        """What is kept of a point; without derivatives where these are not."""
        row = None if self.file is None else self.file.point(key("curves", look.shares, look.near))
        if row is None or self.file is None:
            return None
        said, values = row
        if values is None:
            return Seen(None, said["reason"])
        gains = np.array(said["gains"])
        one = Seen(
            Fitted(said["offset"], gains, values, self.misfit.residuals(values), said["along"]),
            "",
            said["unsettled"],
        )
        if (
            look.by_steps is None
            or (kept := self.file.point(key("slopes", look.shares, said["offset"], look.by_steps))) is None
        ):
            return one
        return dataclasses.replace(one, slopes=Slopes(np.asarray(kept[1]), np.array(kept[0]["offsets"])))

    def taken(self, look: Look, seen: Seen | None, found: list[Any], rows: list[Evaluation]) -> Seen:
        """A point from the runs that were missing."""
        if seen is None:
            trace = found.pop(0)
            seen = Seen(None, trace) if isinstance(trace, str) else self.laid(trace, look.near)
            rows.append((key("curves", look.shares, look.near), *said(seen)))
        if look.by_steps is None or seen.fitted is None:
            return seen
        shares, offset = np.array(look.shares), seen.fitted.offset
        if look.by_steps and isinstance(
            found[0], VfifeError
        ):  # it has no derivatives here: differences are taken instead
            found = answers(self.curves, self.sought, questions(shares, False))
            slopes = Slopes.of(found, self.misfit, shares, offset, False)
        else:
            slopes = Slopes.of(found, self.misfit, shares, offset, look.by_steps)
        rows.append(
            (
                key("slopes", look.shares, offset, look.by_steps),
                {"offsets": slopes.offsets.tolist()},
                slopes.jacobian,
            )
        )
        return dataclasses.replace(seen, slopes=slopes)

    def slopes(self, look: Look, seen: Seen) -> Slopes:
        """Derivatives at a point that was seen, kept or made. Raises VfifeError where steps carry none along."""
        shares, offset, by_steps = (
            np.array(look.shares),
            0.0 if seen.fitted is None else seen.fitted.offset,
            bool(look.by_steps),
        )
        name = key("slopes", look.shares, offset, by_steps)
        if self.file is not None and (kept := self.file.point(name)) is not None:
            return Slopes(np.asarray(kept[1]), np.array(kept[0]["offsets"]))
        found = answers(self.curves, self.sought, questions(shares, by_steps))
        if isinstance(found[0], VfifeError):
            raise found[0]
        slopes = Slopes.of(found, self.misfit, shares, offset, by_steps)
        if self.file is not None:
            self.file.add_points([(name, {"offsets": slopes.offsets.tolist()}, slopes.jacobian)])
        return slopes

    def laid(self, trace: Trace, near: float | None) -> Seen:
        """A trace on the samples."""
        return Seen(self.misfit(trace, near), "", self.misfit.unsettled(trace))

    def note(self, look: Look, one: Seen) -> None:
        """Counts a point, and keeps the best."""
        self.runs += 1 + (
            0 if look.by_steps is None else len(questions(np.array(look.shares), look.by_steps))
        )
        if one.fitted is None:
            self.reasons.append(one.reason)
            return
        cost = one.fitted.cost
        if math.isfinite(cost):
            self.points.append((cost, look.shares))
            if self.best is None or cost < self.best[0]:
                self.best = (cost, np.array(look.shares), one)

    def tell(self) -> None:
        """Says where it stands."""
        if self.progress is not None:
            best = f", residual {100.0 * self.share:.3g} %" if self.best is not None else ""
            done = min(self.runs, self.expected)
            seconds = time.monotonic() - self.began
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


def missing(look: Look, seen: Seen | None) -> Iterator[Point]:
    """What has to be run for an answer."""
    if seen is None:
        yield Point(look.shares)
    if look.by_steps is not None and (seen is None or (seen.fitted is not None and seen.slopes is None)):
        yield from questions(np.array(look.shares), look.by_steps)


def said(seen: Seen) -> tuple[dict[str, Any], Array | None]:
    """What is kept of a point beside its key."""
    one = seen.fitted
    if one is None:
        return {"reason": seen.reason}, None
    return {
        "offset": one.offset,
        "gains": one.gains.tolist(),
        "along": one.along,
        "unsettled": seen.unsettled,
    }, one.values


def key(what: str, shares: Sequence[float], near: float | None, by_steps: bool | None = None) -> str:
    """By which an answer is known."""
    text = f"{what}|{[float(one) for one in shares]!r}|{None if near is None else float(near)!r}|{by_steps!r}"
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
