"""Jobs of the command line: forecast on standard error, confirmation by ``--yes``, progress line, and
messages about what a signal leaves.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from .. import files
from ..job.job import Job
from ..job.progress import ProgressLine, span
from ..store.schemas import STUDY
from .options import CaseOptions, Options, StudyRunOptions
from .outputs import RUNS, answer_file
from .signals import ENDING
from .terminal import STORAGE, fail, sentences, tell, writing

if TYPE_CHECKING:
    from ..job.cost import Forecast
    from ..store.lock import Lock

LONG_LOOK = 60.0  # s of a forecast from which on a first look is named


class CommandJob(Job):
    """The job of a command that makes ``work`` ("map") in the file or folder ``target``.

    ``first_look``: options that give a quicker first answer; not ``announced``: a forecast is printed only if
    the job ends because of it.
    """

    def __init__(
        self,
        work: str,
        target: Path,
        options: Options,
        *,
        first_look: str = "",
        announced: bool = True,
        saved: str = "",
    ) -> None:
        quiet = getattr(options, "quiet", False)
        self.bars, self.begun = ProgressLine(quiet), False
        super().__init__(work, target, getattr(options, "yes", True), self.bars)
        self.target, self.quiet, self.first_look, self.announced = target, quiet, first_look, announced
        self.saved = saved or f"Complete results are kept in {target}; the same command continues after them."
        self.saved_before = self.saved if target.exists() else ""

    def begin(self, forecast: Forecast) -> None:
        """Print a forecast; exit if the disk is too small, or if the work is long and ``--yes`` is
        missing.
        """
        if excess := forecast.excess(self.target):
            free = files.free_bytes(self.target)
            if free is not None and forecast.disk > free:
                size = f"about {forecast.disk:,.0f} bytes for {forecast.amount}, and {free:,} are free there"
                remedy = (
                    f"{forecast.remedy}, or name a file on another disk. Nothing was started, and no file"
                    " was changed."
                )
                fail(f"{self.target}: this {self.caller} takes {size}; {remedy}", STORAGE)
            if not self.confirm:
                size = f"this {self.caller} takes {excess} for {forecast.amount}"
                fail(f"{size}; add --yes to confirm, or {forecast.remedy}. Nothing was started.")
        if not self.announced:
            return
        if not self.quiet and forecast.count:
            tell("forecast", forecast.sentence(self.target), "bold")
            for part in forecast.parts:
                tell("forecast", part, "bold")
            if forecast.seconds > LONG_LOOK and forecast.first_look < forecast.seconds:
                tell(
                    "note",
                    f"for a first look: {self.first_look} -o first{self.target.suffix}, about"
                    f" {span(forecast.first_look)}.",
                )
        for remark in forecast.remarks if not self.quiet else ():
            tell("note", remark)
        self.start()

    def hold(self, lock: Lock) -> None:
        """Note a lock, to release it even if a signal ends the process at once."""
        ENDING.last.append(lock.release)

    def interrupted(self) -> None:
        """Print nothing: the command says what is kept."""

    def start(self) -> None:
        """Begin the work: make its folder; from now on a signal leaves complete results."""
        if self.target.parent == RUNS:
            RUNS.mkdir(exist_ok=True)
        ENDING.saved = self.saved
        if not self.begun:
            self.begun = True
            self.bars.__enter__()

    def end(self, kind: type[BaseException] | None = None) -> None:
        """End the progress line."""
        if self.begun:
            self.begun = False
            self.bars.__exit__(kind)

    @contextmanager
    def at_work(self, name: str) -> Iterator[None]:
        """Return a context for the work that turns errors into a sentence and an exit code; ``name``: subject
        of faults.
        """
        with sentences(name, str(self.target)), writing(str(self.target), self.saved_before):
            try:
                yield
            except BaseException as error:
                self.end(type(error))
                raise
            self.end()


def study_job(options: CaseOptions, work: str = "study") -> CommandJob:
    """Return the job of a command that computes cases. Raises ValueError if another file has the name of the
    study file.
    """
    place = options.file
    if isinstance(options, StudyRunOptions):
        place = answer_file(STUDY, options.output, place)
    saved = f"Complete cases are kept in {place}; the same command continues after them."
    return CommandJob(work, place, options, saved=saved)
