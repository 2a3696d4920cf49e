"""Jobs of the command line: a forecast on standard error, ``--yes`` where it is much, a progress line, and words for what a signal leaves."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..job.cost import Forecast
from ..job.job import Job
from ..job.progress import ProgressLine
from ..results.folder import is_own
from .signals import NOW
from .terminal import STORAGE, fail, sentences, tell, writing

RUNS = Path("runs")
FIGURES = (".png", ".svg", ".pdf")
GO_ON = "the same command goes on after it"


class CommandJob(Job):
    """A job that a command began. ``what`` it makes ("map"), ``place``: the file or folder that keeps it, ``saved``: what a signal leaves of it."""

    def __init__(self, what: str, place: Path, *, yes: bool, quiet: bool, saved: str = "", silent: bool = False) -> None:
        super().__init__(what, place, yes, None)
        self.what, self.quiet, self.silent, self.bars = what, quiet, silent, ProgressLine(quiet)
        self.target, self.saved, self.working = place, saved or f"What is complete is kept in {place}; {GO_ON}.", False

    def begin(self, forecast: Forecast) -> None:
        """Report a forecast; end the command where the disk has no room, or where it takes much and nobody said ``--yes``."""
        if excess := forecast.excess(self.target):
            said = f"this {self.what} takes {excess}, for {forecast.amount}"
            if forecast.overflows(self.target):
                fail(f"{self.target}: {said}; {forecast.less}, or name a place on another disk. Nothing was begun, and nothing is touched.", STORAGE)
            if not self.confirm:
                fail(f"{said}; add --yes if that is meant, or {forecast.less}. Nothing was begun.")
        if not (self.quiet or self.silent) and forecast.count:
            tell("forecast", forecast.sentence(self.target), "bold")
            for remark in forecast.remarks:
                tell("note", remark)

    def __call__(self, progress) -> None:
        """Show where the work stands."""
        self.bars(progress)

    @contextmanager
    def at_work(self, name: str = "") -> Iterator[CommandJob]:
        """While the work goes on: sentences for what ends it, the line, and what a signal leaves."""
        with sentences(name or str(self.target)), writing(str(self.target), self.saved if self.target.exists() else ""):
            if self.target.parent == RUNS:
                RUNS.mkdir(parents=True, exist_ok=True)
            with self.bars:
                yield self
