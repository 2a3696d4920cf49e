"""The progress line of a run, on standard error."""

from __future__ import annotations

import os
import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING

from ..codegen import cache
from .terminal import errors, span

if TYPE_CHECKING:
    from ..solvers.status import Progress

PLAIN_SECONDS = 10.0  # between two lines where standard error is no terminal
START = "preparing the loop"
COMPILING = "compiling the step for this kind of mechanism and these laws; it is kept, and later runs of the kind begin at once"


class ProgressLine:
    """Percentage, steps a second and time left: one line that changes on a terminal, else one every ten seconds and the last."""

    def __init__(self, quiet: bool) -> None:
        self.quiet, self.live = quiet, not quiet and coloured()
        if self.live:
            from rich.progress import BarColumn, TextColumn
            from rich.progress import Progress as Bars

            self.bars = Bars(BarColumn(), TextColumn("{task.description}", markup=False), console=errors(), auto_refresh=False)
            self.task = self.bars.add_task(START, total=1.0)
        self.step_count, self.told, self.last = 0, time.monotonic(), ""

    def __enter__(self) -> ProgressLine:
        cache.MISSED.append(self.compiling)
        if self.live:
            self.bars.start()
            self.bars.refresh()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        cache.MISSED.remove(self.compiling)
        if self.live:  # elsewhere the oldest rich would print an empty line
            self.bars.stop()
        if not self.live and not self.quiet and self.last and kind is None:
            print(self.last, file=sys.stderr)

    def compiling(self) -> None:
        """Says that a compiler is at work."""
        if self.live:
            self.bars.update(self.task, description=COMPILING, refresh=True)
        elif not self.quiet:
            print(f"note: {COMPILING}.", file=sys.stderr)

    def __call__(self, progress: Progress) -> None:
        """Shows where the run stands; called after each chunk of steps."""
        halved = self.step_count and progress.steps > self.step_count and not progress.text  # members of a search may become more, too
        again = " (again, with half the step)" if halved else ""
        if again or not self.step_count:
            self.step_count, self.again = progress.steps, again
        self.last = sentence(progress) + self.again
        if self.live:
            self.bars.update(self.task, completed=progress.share, description=self.last, refresh=True)
        elif not self.quiet and time.monotonic() - self.told > PLAIN_SECONDS:
            self.told = time.monotonic()
            print(self.last, file=sys.stderr)


def coloured() -> bool:
    """Whether standard error is a terminal, or is to be taken for one; the library that draws is asked only where it may be."""
    asked = {"FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE"} & set(os.environ)
    return bool(asked or sys.stderr.isatty()) and errors().is_terminal


def sentence(progress: Progress) -> str:
    """Where a run stands, in words."""
    if progress.text:
        return f"{100.0 * progress.share:3.0f} %  {progress.text}"
    head = f"{100.0 * progress.share:3.0f} %  {progress.done:,} of {progress.steps:,} steps"
    if not progress.speed:
        return head
    left = f"  {span(progress.left)} left" if progress.done < progress.steps else f"  in {span(progress.seconds)}"
    return f"{head}  {speed(progress.speed)}{left}"


def speed(steps_a_second: float) -> str:
    """Steps a second with a prefix."""
    for factor, prefix in ((1e6, "million "), (1e3, "thousand ")):
        if steps_a_second >= factor:
            return f"{steps_a_second / factor:.3g} {prefix}steps/s"
    return f"{steps_a_second:.3g} steps/s"
