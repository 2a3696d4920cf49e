"""Progress of long work on standard error: a bar on a terminal, a line that changes in a notebook, else a
line every ten seconds. Times, sizes and counts as text.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..compiler.runtime import MISSED
from ..solvers.status import Progress
from .activity import ACTIVITY, on_terminal
from .amounts import amount_of_bytes, counted, span

if TYPE_CHECKING:
    from rich.progress import Progress as Bars

__all__ = ["amount_of_bytes", "counted", "on_terminal", "span"]  # for commands and reports
PLAIN_SECONDS = 10.0  # between two lines where standard error is no terminal
START = "preparing the loop"
COMPILING = "compiling the step (once for this kind of mechanism and these laws)"
PATIENCE = 1.0  # s of work in a script that need no line on a terminal or in a notebook


class ProgressLine:
    """Percentage, speed and remaining time: one line that changes on a terminal, else one every ten seconds
    and at the end.
    """

    def __init__(self, quiet: bool) -> None:
        self.quiet, self.live = quiet, not quiet and on_terminal()
        self.bars: Bars | None = None
        self.step_count, self.written, self.last, self.note = 0, time.monotonic(), "", ""
        self.share, self.done = 0.0, 0  # the largest share that was shown of work whose amount grows
        self.began = self.written

    def __enter__(self) -> ProgressLine:
        ACTIVITY.pause()
        MISSED.append(self.compiling)
        if self.live:
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn
            from rich.progress import Progress as Bars

            console = Console(stderr=True, highlight=False, soft_wrap=True)
            self.bars = Bars(
                BarColumn(),
                TextColumn("{task.description}", markup=False),
                console=console,
                auto_refresh=False,
                redirect_stdout=sys.stdout.isatty(),  # else answers would be printed on standard error
            )
            self.task = self.bars.add_task(START, total=1.0)
            self.bars.start()
            self.bars.refresh()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        MISSED.remove(self.compiling)
        if self.bars is not None:  # elsewhere the oldest rich would print an empty line
            self.bars.stop()
        elif not self.quiet and self.last and kind is None:
            print(self.last, file=sys.stderr)
        ACTIVITY.resume()

    def compiling(self) -> None:
        """Report that a step is being compiled."""
        if self.bars is not None:
            self.bars.update(self.task, description=COMPILING, refresh=True)
        elif not self.quiet:
            print(f"note: {COMPILING}.", file=sys.stderr)

    def __call__(self, progress: Progress) -> None:
        """Show the progress; called after each chunk of work."""
        # A run has more steps than before if its step was halved; a search, which has a text, if it needs
        # cases.
        halved = self.step_count and progress.steps > self.step_count and not progress.text
        note = " (again, with half the step)" if halved else ""
        if note or not self.step_count:
            self.step_count, self.note = progress.steps, note
        # The share of a search that needs more cases than forecast stays, instead of going backward.
        new = not progress.text or progress.done < self.done  # another part of the work
        share = progress.share if new else max(progress.share, self.share)
        self.share, self.done = (share, progress.done) if progress.text else (0.0, 0)
        self.last = sentence(progress, share) + ("" if progress.text else self.note)
        if self.bars is not None:
            self.bars.update(self.task, completed=share, description=self.last, refresh=True)
        elif not self.quiet and time.monotonic() - self.written > PLAIN_SECONDS:
            self.written = time.monotonic()
            print(self.last, file=sys.stderr)

    def phase(self, text: str) -> None:
        """Show what is computed after the last step; of short work only on a terminal."""
        shown = f"{self.last}; {text}" if self.last else text
        if self.bars is not None:
            self.bars.update(self.task, description=shown, refresh=True)
        elif not self.quiet and time.monotonic() - self.began > PLAIN_SECONDS:
            self.written = time.monotonic()
            print(shown, file=sys.stderr)


class NotebookLine:
    """A line below a notebook cell that is replaced as the work continues."""

    def __init__(self, display: Any) -> None:
        self.shown, self.written, self.last = display(plain_text("..."), display_id=True), 0.0, ""

    def __enter__(self) -> NotebookLine:
        return self

    def __exit__(self, *_: object) -> None:
        self.shown.update(plain_text(self.last))

    def __call__(self, progress: Progress) -> None:
        """Show the progress, at most ten times a second."""
        self.last = sentence(progress)
        if time.monotonic() - self.written > 0.1:
            self.written = time.monotonic()
            self.shown.update(plain_text(self.last))

    def phase(self, text: str) -> None:
        """Show what is computed after the last step."""
        self.shown.update(plain_text(f"{self.last}; {text}" if self.last else text))


class ScriptLine:
    """Progress of work of a script: nothing in the first second, nor in the first ten where standard error is
    no terminal.
    """

    def __init__(self) -> None:
        self.began = time.monotonic()
        self.line: Any = None
        self.make = script_line()
        visible = in_notebook() or (sys.stderr is not None and on_terminal())
        self.patience = PATIENCE if visible else PLAIN_SECONDS

    def note(self, text: str) -> None:
        """Print a forecast of long work on standard error."""
        if self.make is not None:
            print(text, file=sys.stderr)

    def __call__(self, progress: Progress) -> None:
        """Show the progress."""
        if self._due():
            self.line(progress)

    def phase(self, text: str) -> None:
        """Show what is computed after the last step."""
        if self._due():
            self.line.phase(text)

    def compiling(self) -> None:
        """Report that a step is being compiled, where no line does."""
        if self.line is None:
            self.note(f"note: {COMPILING}.")

    def _due(self) -> bool:
        """Whether the work takes long enough to be shown; its line then begins at once."""
        if self.line is None and self.make is not None and time.monotonic() - self.began > self.patience:
            self.line = self.make().__enter__()
            if isinstance(self.line, ProgressLine):
                self.line.began = self.line.written = self.began
        return self.line is not None

    def open(self) -> None:
        """Report steps that are compiled from now on."""
        MISSED.append(self.compiling)

    def close(self) -> None:
        """End the line with its last content."""
        if self.compiling in MISSED:
            MISSED.remove(self.compiling)
        if self.line is not None:
            self.line.__exit__(None, None, None)
            self.line = None


def script_line() -> Callable[[], Any] | None:
    """Return a maker of progress lines for a script; None without standard error."""
    if in_notebook():
        display = sys.modules["IPython.display"].display
        return lambda: NotebookLine(display)
    return None if sys.stderr is None else lambda: ProgressLine(False)


def in_notebook() -> bool:
    """Return whether a notebook runs this."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return type(shell).__name__ == "ZMQInteractiveShell"


def plain_text(text: str) -> Any:
    """Return a text that a notebook shows without quotes."""
    return type("Text", (), {"__repr__": lambda self: text})()


# A wait of this share of the longest one ends a burst of items, which are complete together in lanes. One so
# many times as long shows that those before were waits within a burst; no other one for so long, that the
# longest was an exception. Share of the time up to the first item from which on later ones show a rate.
SAME_WAIT, LONGER_WAIT, LATER = 0.5, 4.0, 0.25


class Counter:
    """Progress of work that ``began`` at a monotonic time (s), on many equal items: number done, and rate and
    remaining time as soon as items after the first ones show them. ``limit``: the largest number of items of
    a search, which may need fewer than its total; 0 for other work.
    """

    def __init__(self, noun: str, began: float, limit: int = 0) -> None:
        self.noun, self.began, self.limit, self.failed = noun, began, limit, 0
        self.first: int | None = None
        self.forecast: int | None = None  # the total when the work began
        self.done, self.seconds = 0, 0.0  # of the item before
        self.prepared = 0.0  # s, up to the first item
        self.ends = list[tuple[float, int]]()  # time (s) and number at the ends of bursts of items
        self.wait = 0.0  # s, the longest between two items

    def __call__(self, done: int, total: int, failed: bool = False) -> Progress:
        """Count an item and return the progress. Where the total grows, or a search may need less, how much
        is left is not known.
        """
        begin = self.first is None
        self.first = max(done - 1, 0) if self.first is None else self.first
        self.forecast = total if self.forecast is None else self.forecast
        self.failed += failed
        seconds = max(time.monotonic() - self.began, 1e-9)
        rate = (done - self.first) / seconds if done >= total else 0.0
        if begin:
            self.prepared = seconds
        else:
            rate = rate or self._rate(seconds)
        self.done, self.seconds = done, seconds
        speed = f"  {rate:.3g} {self.noun}/s" if rate else ""
        left = f"  {span((total - done) / rate)} left" if rate else ""
        if done >= total:
            left = f"  in {span(seconds)}"
        elif self.limit:
            left = f"  {self.limit:,} at most" if total <= self.limit else ""
        bad = f"  {self.failed:,} failed" if self.failed else ""
        if surplus := total > max(self.forecast, self.limit):
            left = f"  more than the {max(self.forecast, self.limit):,} of the forecast"
        return Progress(done, total, seconds, f"{done:,} of {total:,} {self.noun}{speed}{left}{bad}", surplus)

    def _rate(self, seconds: float) -> float:
        """Return the number of items a second between the ends of the first and the last complete burst,
        because the work was prepared before the first and the last one is still arriving; 0 if not known.
        """
        wait = seconds - self.seconds
        since = seconds - (self.ends[-1][0] if self.ends else self.seconds)
        if max(wait, since) > LONGER_WAIT * self.wait:
            self.ends, self.wait = [], 0.0
        if wait >= SAME_WAIT * self.wait:
            self.ends = [*self.ends[:1], (self.seconds, self.done)]
        self.wait = max(self.wait, wait)
        (begin, count), (end, last) = self.ends[0], self.ends[-1]
        if last == count or seconds - begin < LATER * self.prepared:
            return 0.0
        return (last - count) / (end - begin)


def sentence(progress: Progress, share: float | None = None) -> str:
    """Return the progress as a sentence; ``share``: what is shown of work with a text, if not its own."""
    if progress.beyond_forecast:
        return progress.text
    if progress.text:
        return f"{100.0 * (progress.share if share is None else share):3.0f} %  {progress.text}"
    head = f"{100.0 * progress.share:3.0f} %  {progress.done:,} of {progress.steps:,} steps"
    if not progress.speed:
        return head
    left = (
        f"  {span(progress.left)} left"
        if progress.done < progress.steps
        else f"  in {span(progress.seconds)}"
    )
    return f"{head}  {speed(progress.speed)}{left}"


def speed(steps_a_second: float) -> str:
    """Return steps per second with a prefix."""
    for factor, prefix in ((1e6, "million "), (1e3, "thousand ")):
        if steps_a_second >= factor:
            return f"{steps_a_second / factor:.3g} {prefix}steps/s"
    return f"{steps_a_second:.3g} steps/s"
