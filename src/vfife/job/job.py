"""A job: long work with a forecast before it begins, confirmation if it takes hours or much memory, and
progress.

Functions of the package take a job as their ``progress``: the command line passes its own
(``vfife.cli.job``), a script gets this one, which calls the script's function or shows a line on a terminal
or in a notebook.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import Fault, ModelError, VfifeError
from ..files import share_done
from ..solvers.status import Progress
from .progress import Counter, ProgressLine, ScriptLine

if TYPE_CHECKING:
    from ..store.lock import Lock
    from .cost import Forecast


FORECAST_SECONDS = 10.0  # of work in a script from which on its forecast is printed
FINE = 10_000  # steps of the progress of a job of several parts


class Interrupted(KeyboardInterrupt):
    """Raised when Ctrl-C ends a search or the derivatives of a run; ``result`` is what was
    finished.

    It is a KeyboardInterrupt: a script that does not catch it ends as usual. ``optimise`` and
    ``studies.allocate`` raise it with the :class:`~vfife.studies.Study` of the cases that have ended, which a
    ``file`` saves, too; ``sensitivity`` raises it with the unchecked derivatives.

    >>> try:
    ...     best = vfife.optimise(model, vary, measures, optimise=aim).best  # doctest: +SKIP
    ... except vfife.Interrupted as interrupted:
    ...     study = interrupted.result
    """

    def __init__(self, result: Any) -> None:
        super().__init__("the attribute result of this exception contains the complete results")
        self.result = result


class Job:
    """A job begun by a script that called the function ``caller``; its results go to the file ``place``, or
    to memory.
    """

    def __init__(
        self, caller: str, place: Path | None, confirm: bool, progress: Callable[[Progress], None] | None
    ) -> None:
        self.caller, self.place, self.confirm = caller, place, confirm
        self.line = ScriptLine() if progress is None else None
        self.progress = self.line if progress is None else progress
        self.counter: Counter | None = None
        self.counted = ""  # items that are done, of how many
        self.began = time.monotonic()
        self.limit = 0

    def begin(self, forecast: Forecast) -> None:
        """Compare a forecast with this machine before the work begins. Raises ModelError for hours of work,
        or half of the memory or disk, without confirmation.
        """
        if self.line is not None and forecast.count and forecast.seconds > FORECAST_SECONDS:
            self.line.note(f"{self.caller}: {forecast.sentence(self.place)}")
        if self.confirm:
            return
        if self.place is None:
            forecast = dataclasses.replace(forecast, disk=0.0)
        else:  # rows go into the file while they come
            forecast = dataclasses.replace(forecast, memory=0.0)
        if excess := forecast.excess(self.place or Path()):
            remedy = f"add confirm=True to confirm, or {forecast.remedy}"
            raise ModelError(
                [Fault("run", f"it takes {excess}", forecast.amount, "", remedy)], f"{self.caller}()"
            )

    def hold(self, lock: Lock) -> None:
        """Note the lock of the file of the job."""

    def __call__(self, progress: Progress) -> None:
        """Show the progress."""
        if self.progress is not None:
            self.progress(progress)

    def phase(self, text: str) -> None:
        """Show what is computed after the last step; functions of scripts receive steps only."""
        if isinstance(self.progress, ScriptLine | ProgressLine):
            self.progress.phase(text)

    def count(self, done: int, total: int, noun: str, failed: bool = False) -> None:
        """Report that one more of many equal items is done."""
        counter = self.counter or Counter(noun, self.began, self.limit)
        if noun != counter.noun or done < counter.done:  # another piece of the work
            limit = self.limit if noun == counter.noun else 0
            counter = Counter(noun, counter.began + counter.seconds, limit)
        self.counter = counter
        self.counted = share_done(done, total, noun)
        self(self.counter(done, total, failed))

    def interrupted(self) -> None:
        """Print on standard error that Ctrl-C ended the work, because the script goes on with the result."""
        if sys.stderr is not None:
            place = f" after {self.counted}" if self.counted else ""
            print(
                f"{self.caller}() was interrupted{place}; it returns the results computed until then.",
                file=sys.stderr,
            )

    def __enter__(self) -> Job:
        if self.line is not None:
            self.line.open()
        return self

    def __exit__(self, *_: object) -> None:
        if self.line is not None:
            self.line.close()


class PartJob(Job):
    """The job of a part of a longer one: its ``title``, and the ``share`` of the work before and after it.

    ``limit``: the largest number of items of a search that may need more than forecast; 0 for other work.
    """

    def __init__(self, job: Job, title: str, share: tuple[float, float], limit: int = 0) -> None:
        super().__init__(job.caller, None, job.confirm, self.report)
        self.job, self.title, self.share, self.limit, self.done = job, title, share, limit, 0

    def begin(self, forecast: Forecast) -> None:
        """Raise VfifeError for hours of work, or half of the memory, without confirmation; the whole job has
        printed its own forecast.
        """
        if not self.confirm and (excess := dataclasses.replace(forecast, disk=0.0).excess(Path())):
            raise VfifeError(
                f"it takes {excess} for {forecast.amount}; confirm that (--yes, confirm=True), or"
                f" {forecast.remedy}"
            )

    def hold(self, lock: Lock) -> None:
        """Note the lock of a file."""
        self.job.hold(lock)

    def interrupted(self) -> None:
        """Print nothing: the whole job does."""

    def report(self, progress: Progress) -> None:
        """Show the progress of the part as that of the whole."""
        begin, end = self.share
        text = progress.text or f"{progress.done:,} of {progress.steps:,} steps"
        # A search may end after a few cases or need many times as many. The square root moves in both cases.
        share = math.sqrt(progress.done / max(self.limit, progress.steps)) if self.limit else progress.share
        # Its share stays where another part of the search counts from zero, instead of going backward.
        self.done = max(self.done, round(FINE * (begin + (end - begin) * share)))
        text = f"{self.title}: {text}"
        self.job(Progress(self.done, FINE, progress.seconds, text, progress.beyond_forecast))


def job_of(
    caller: str,
    place: str | Path | None,
    confirm: bool,
    progress: Any,
    convert: Callable[[Progress], None] | None = None,
) -> Job:
    """Return the job passed as ``progress``, or a new one that calls the function passed.

    ``convert`` passes a :class:`Progress` to that function in another form. Raises ModelError for anything
    else.
    """
    if isinstance(progress, Job):
        return progress
    faults = []
    if progress is not None and not callable(progress):
        message, limit = "this cannot be called", "a function, or None"
        faults.append(Fault("progress", message, repr(progress), limit, "leave it out"))
    if not isinstance(confirm, bool):
        message, limit = "this is not a truth value", "True or False"
        faults.append(Fault("confirm", message, repr(confirm), limit, "leave it out"))
    if faults:
        raise ModelError(faults, f"{caller}()")
    return Job(
        caller,
        None if place is None else Path(place),
        confirm,
        progress if progress is None or convert is None else convert,
    )
