"""A job: long work with a forecast before it begins, a confirmation where it takes hours or much memory, and
progress while it goes on.

Functions of the package take one as their ``progress``: the command line hands in its own
(``vfife.cli.job``), and a script gets this one, around its own call for progress or with a line on a terminal
or in a notebook.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import Fault, ModelError
from ..solvers.status import Progress
from .progress import Counter, ScriptLine

if TYPE_CHECKING:
    from ..store.lock import Lock
    from .cost import Forecast


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a job of a script; ``result`` is what was finished until then."""

    def __init__(self, result: Any) -> None:
        super().__init__("what was finished is in the attribute result of this exception")
        self.result = result


class Job:
    """A job that a script began by calling the function ``caller``; it keeps its results in the file
    ``place``, or in memory.
    """

    def __init__(
        self, caller: str, place: Path | None, confirm: bool, progress: Callable[[Progress], None] | None
    ) -> None:
        self.caller, self.place, self.confirm = caller, place, confirm
        self.line = ScriptLine() if progress is None else None
        self.progress = self.line if progress is None else progress
        self.counter: Counter | None = None

    def begin(self, forecast: Forecast) -> None:
        """Compare a forecast with this machine before anything is begun. Raises ModelError for hours of work,
        or half of the memory or the disk.
        """
        if self.confirm:
            return
        if self.place is None:
            forecast = dataclasses.replace(forecast, disk=0.0)
        else:  # rows go into the file while they come
            forecast = dataclasses.replace(forecast, memory=0.0)
        if excess := forecast.excess(self.place or Path()):
            remedy = f"add confirm=True if that is meant, or {forecast.less}"
            raise ModelError(
                [Fault("run", f"it takes {excess}", forecast.amount, "", remedy)], f"{self.caller}()"
            )

    def hold(self, lock: Lock) -> None:
        """The file of the job is locked from now on."""

    def __call__(self, progress: Progress) -> None:
        """Show where the work stands."""
        if self.progress is not None:
            self.progress(progress)

    def count(self, done: int, total: int, noun: str, failed: bool = False) -> None:
        """One more of many things alike is done."""
        self.counter = self.counter or Counter(noun)
        self(self.counter(done, total, failed))

    def __enter__(self) -> Job:
        return self

    def __exit__(self, *_: object) -> None:
        if self.line is not None:
            self.line.close()


def job_of(
    caller: str,
    place: str | Path | None,
    confirm: bool,
    progress: Any,
    convert: Callable[[Progress], None] | None = None,
) -> Job:
    """The job that a function was handed as its ``progress``, or one around the call that it was given for
    it.

    ``convert`` hands a :class:`Progress` to that call in its own form. Raises ModelError for what can be
    neither.
    """
    if isinstance(progress, Job):
        return progress
    if progress is not None and not callable(progress):
        raise ModelError(
            [
                Fault(
                    "progress", "this cannot be called", repr(progress), "a function, or None", "leave it out"
                )
            ],
            f"{caller}()",
        )
    if not isinstance(confirm, bool):
        raise ModelError(
            [Fault("confirm", "this is no truth value", repr(confirm), "True or False", "leave it out")],
            f"{caller}()",
        )
    return Job(
        caller,
        None if place is None else Path(place),
        confirm,
        progress if progress is None or convert is None else convert,
    )
