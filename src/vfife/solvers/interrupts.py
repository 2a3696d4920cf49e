"""Interruption of long runs: calls of the loop that last a quarter of a second, and signals that wait for the
end of one.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from types import FrameType, TracebackType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .companion_lanes import Stepper

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


class Interrupts:
    """While it is entered, handlers of :data:`SIGNALS` that are functions are called by :meth:`look` and at
    the end instead of anywhere.

    A second signal is handled where it comes. In a thread that is not the main one, which hears no signals,
    it does nothing.
    """

    def __init__(self) -> None:
        self.former: dict[int, Callable[[int, FrameType | None], Any]] = {}
        self.received: int | None = None

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():
            for number in SIGNALS:
                handler = signal.getsignal(number)
                if callable(handler):
                    self.former[number] = handler
                    signal.signal(number, self._hear)
        return self

    def _hear(self, number: int, frame: FrameType | None) -> None:
        if self.received is not None:
            self.former[number](number, frame)
        self.received = number

    def look(self) -> None:
        """Handles a signal that came, if there is one: most handlers raise KeyboardInterrupt."""
        number, self.received = self.received, None
        if number is not None:
            self.former[number](number, None)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self.former.items():
            signal.signal(number, handler)
        if kind is None:
            self.look()


PATIENCE = 0.1  # s between two looks at signals
Result = TypeVar("Result")


def one_behind(items: Iterable[Result]) -> Iterator[Result]:
    """Yield each item when the next one has been made, so that work of another thread on it goes on
    meanwhile.
    """
    last: list[Result] = []
    for item in items:
        yield from last
        last = [item]
    yield from last


class Workers:
    """Threads, one a core unless given, that end within a call of the loop when whoever waits for them is
    interrupted.
    """

    def __init__(self, count: int | None = None) -> None:
        self.halt, self.stop, self.count = (
            Interrupts(),
            threading.Event(),
            max(1, count or os.cpu_count() or 1),
        )

    def __enter__(self) -> Workers:
        self.halt.__enter__()
        self.pool = ThreadPoolExecutor(self.count)
        return self

    def submit(self, work: Callable[..., Result], *arguments: Any) -> Future[Result]:
        """Have a thread do some work."""
        return self.pool.submit(work, *arguments)

    def results(self, jobs: Iterable[Future[Result]]) -> Iterator[Result]:
        """Yield results as they come, or raise what the first job that fails raises. Signals are heard
        meanwhile.
        """
        waiting = set(jobs)
        while waiting:
            done, waiting = wait(waiting, PATIENCE, FIRST_COMPLETED)
            self.halt.look()
            yield from (job.result() for job in done)

    def look(self) -> None:
        """Raise KeyboardInterrupt in a thread that is to end."""
        if self.stop.is_set():
            raise KeyboardInterrupt

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop.set()
        self.pool.shutdown(wait=True, cancel_futures=True)
        self.halt.__exit__(kind, error, trace)


SECONDS = 0.25  # of one call, between two looks at signals, the clock and the progress line
FIRST = 16  # steps of the first call, when nobody knows how long one lasts
QUICK = 1000  # the same where a step is known to be short: some 50 microseconds at the most
GROWTH = 4  # from one call to the next, at the most


class ChunkSize:
    """Learns how long steps last, from so many in the ``first`` call; ``look`` is called after each call of
    the loop.
    """

    def __init__(self, look: Callable[[], None] | None = None, first: int = FIRST) -> None:
        self.look, self.room, self.seconds = look, first, 0.0

    def call(
        self, runner: Stepper, count: int, outputs: int = 1, *, reset: bool = True, record: bool = True
    ) -> NDArray[np.float64]:
        """One call of the loop, timed; see :meth:`~vfife.compiler.runtime.runner.Runner.advance`."""
        began = time.perf_counter()
        rows = runner.advance(count, outputs, reset=reset, record=record)
        self.learn(count * outputs, time.perf_counter() - began)
        if self.look is not None:
            self.look()
        return rows

    def learn(self, steps: int, spent: float) -> None:
        """Take the time (s) of so many steps into account."""
        self.seconds += spent
        self.room = max(1, min(GROWTH * max(steps, FIRST), int(steps * SECONDS / max(spent, 1e-6))))

    def advance(self, runner: Stepper, count: int, outputs: int) -> NDArray[np.float64]:
        """``outputs`` times ``count`` steps, in as many calls as it takes; the same rows as in one."""
        parts = []
        done = 0
        while done < outputs:
            if (some := min(outputs - done, self.room // count)) > 0:
                parts.append(self.call(runner, count, some))
            else:
                some, inside = 1, 0
                while inside < count:
                    piece = min(self.room, count - inside)
                    rows = self.call(runner, piece, reset=inside == 0, record=inside + piece == count)
                    inside += piece
                parts.append(rows)
            done += some
        return parts[0] if len(parts) == 1 else np.concatenate(parts)
