"""What a command does while it prints nothing: a line on standard error after two seconds of silence.

A progress line counts steps or cases. Reading, drawing and writing have nothing to count, and may take a
minute. A command therefore names each such part of its work (``ACTIVITY("writing forces.csv", 12.0)``), and a
thread prints the name if the part takes long: on a terminal in a line that changes and is erased at the end,
elsewhere in a line every ten seconds.
"""

from __future__ import annotations

import os
import shutil
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from .amounts import span

PATIENCE = 2.0  # s of silence before the first line
INTERVAL, REFRESH = 10.0, 0.5  # s between two lines; between two changes of the line on a terminal
LOOK = 0.1  # s between two looks at the clock


class Activity:
    """The present part of the work of this process: its ``text``, and the ``seconds`` that it is forecast to
    take, 0 if unknown.
    """

    def __init__(self) -> None:
        self.text, self.seconds, self.command = "", 0.0, ""
        self.began = self.due = self.command_began = 0.0
        self.width = self.pauses = 0  # columns of the line on a terminal; progress lines that are shown
        self.stop: threading.Event | None = None

    def __call__(self, text: str, seconds: float = 0.0) -> None:
        """Note what is done from now on, and how long (s) that takes, 0 if unknown."""
        self.erase()
        self.text, self.seconds, moment = text, seconds, time.monotonic()
        # The name of a command without a part has the time of the command, also after a progress line.
        self.began = self.command_began if text == self.command else moment
        self.due = moment + PATIENCE

    @contextmanager
    def watched(self, text: str, quiet: bool = False) -> Iterator[None]:
        """Return a context in which this is shown; nothing is shown of a ``quiet`` command, nor by a context
        within another one.
        """
        if quiet or self.stop is not None:
            yield
            return
        self.command, self.command_began = text, time.monotonic()
        self(text)
        self.pauses, self.stop = 0, threading.Event()
        threading.Thread(target=self.watch, args=(self.stop,), daemon=True).start()
        try:
            yield
        finally:
            self.end()

    def end(self) -> None:
        """Show nothing any more."""
        if self.stop is not None:
            self.stop.set()
            self.stop = None
        self.erase()

    def pause(self) -> None:
        """Leave standard error to a progress line."""
        self.erase()
        self.pauses += 1

    def resume(self) -> None:
        """Continue after a progress line."""
        self.pauses -= 1
        self(self.text, self.seconds)

    def watch(self, stop: threading.Event) -> None:
        """Print a line whenever one is due, until the command has ended."""
        terminal: bool | None = None
        while not stop.wait(LOOK):
            moment = time.monotonic()
            if self.pauses or moment < self.due:
                continue
            terminal = on_terminal() if terminal is None else terminal
            self.due = moment + (REFRESH if terminal else INTERVAL)
            self.show(terminal)

    def show(self, terminal: bool) -> None:
        """Print the present line."""
        spent = time.monotonic() - self.began
        expected = f"of about {span(self.seconds)}" if spent < self.seconds else "so far"
        line = f"{self.text}: {span(spent)} {expected}"
        if not terminal:
            print(f"note: {line}.", file=sys.stderr)
            return
        line = line[: shutil.get_terminal_size().columns - 1]
        sys.stderr.write(f"\r{line.ljust(self.width)}")
        sys.stderr.flush()
        self.width = len(line)

    def erase(self) -> None:
        """Erase the line on a terminal."""
        if self.width:
            sys.stderr.write(f"\r{' ' * self.width}\r")
            sys.stderr.flush()
            self.width = 0


ACTIVITY = Activity()


def on_terminal() -> bool:
    """Return whether standard error is a terminal or is to be treated as one; loads the drawing library only
    if so.
    """
    forced = {"FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE"} & set(os.environ)
    if not (forced or sys.stderr.isatty()):
        return False
    from rich.console import Console

    return Console(stderr=True).is_terminal
