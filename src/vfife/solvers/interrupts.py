"""Interruption of long runs: calls of the loop that last a quarter of a second, and signals that wait for the
end of a call.

A signal handler of Python may run between any two bytecodes, also while a file or the state is being written.
Signals are therefore only noted when they come, and handled between two calls.
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

REPETITION = 0.2  # s between two signals that count as one, as those of the program ``timeout``
SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


class Interrupts:
    """A context in which the handlers of :data:`SIGNALS` are called only by :meth:`look` and at its end.

    A second signal is handled at once, unless it is the same and comes with the first. In a thread other than
    the main one, which receives no signals, the context does nothing.
    """

    def __init__(self) -> None:
        self.former: dict[int, Callable[[int, FrameType | None], Any]] = {}
        self.received: int | None = None
        self.time = 0.0  # s, of the signal that was received

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():
            for number in SIGNALS:
                handler = signal.getsignal(number)
                if callable(handler):
                    self.former[number] = handler
                    signal.signal(number, self._hear)
        return self

    def _hear(self, number: int, frame: FrameType | None) -> None:
        moment = time.monotonic()
        if self.received is not None and (number != self.received or moment - self.time > REPETITION):
            self.former[number](number, frame)
        self.received, self.time = number, moment

    def look(self) -> None:
        """Handle a signal that was received, if there is one; most handlers raise KeyboardInterrupt."""
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


PATIENCE = 0.1  # s between two checks for signals
Result = TypeVar("Result")


def one_behind(items: Iterable[Result]) -> Iterator[Result]:
    """Yield each item after the next one has been made, so that another thread can work on it meanwhile."""
    last: list[Result] = []
    for item in items:
        yield from last
        last = [item]
    yield from last


class Workers:
    """Threads, by default one for each core, that end within one call of the loop when the thread that waits
    for them is interrupted.
    """

    def __init__(self, count: int | None = None) -> None:
        self.halt, self.stop = Interrupts(), threading.Event()
        self.count = max(1, count or os.cpu_count() or 1)

    def __enter__(self) -> Workers:
        self.halt.__enter__()
        self.pool = ThreadPoolExecutor(self.count)
        return self

    def submit(self, work: Callable[..., Result], *arguments: Any) -> Future[Result]:
        """Start some work in a thread; return its future."""
        return self.pool.submit(work, *arguments)

    def results(self, jobs: Iterable[Future[Result]]) -> Iterator[Result]:
        """Yield results as jobs end, or raise what the first failing job raises; handle signals meanwhile."""
        waiting = set(jobs)
        while waiting:
            done, waiting = wait(waiting, PATIENCE, FIRST_COMPLETED)
            self.halt.look()
            yield from (job.result() for job in done)

    def look(self) -> None:
        """Raise KeyboardInterrupt in a thread that has to end."""
        if self.stop.is_set():
            raise KeyboardInterrupt

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop.set()
        self.pool.shutdown(wait=True, cancel_futures=True)
        self.halt.__exit__(kind, error, trace)


SECONDS = 0.25  # of one call, between two checks for signals, the clock and the progress line
FIRST = 16  # steps of the first call, before the time of a step is known
QUICK = 1000  # the same for steps known to be short: some 50 microseconds at most
GROWTH = 4  # largest factor from one call to the next


class ChunkSize:
    """The number of steps of a call of the loop, ``steps``, adapted to the time of a step; ``first`` is that
    of the first call. ``look`` is called after each call.
    """

    def __init__(self, look: Callable[[], None] | None = None, first: int = FIRST) -> None:
        self.look, self.steps, self.seconds = look, first, 0.0

    def call(
        self, runner: Stepper, count: int, outputs: int = 1, *, reset: bool = True, record: bool = True
    ) -> NDArray[np.float64]:
        """Call the loop once and time it; see :meth:`~vfife.compiler.runtime.runner.Runner.advance`."""
        began = time.perf_counter()
        rows = runner.advance(count, outputs, reset=reset, record=record)
        self.learn(count * outputs, time.perf_counter() - began)
        if self.look is not None:
            self.look()
        return rows

    def learn(self, steps: int, spent: float) -> None:
        """Adapt the number of steps of a call to the time ``spent`` (s) for ``steps`` steps."""
        self.seconds += spent
        self.steps = max(1, min(GROWTH * max(steps, FIRST), int(steps * SECONDS / max(spent, 1e-6))))

    def advance(self, runner: Stepper, count: int, outputs: int) -> NDArray[np.float64]:
        """Take ``outputs`` times ``count`` steps in as many calls as needed; return the rows of one call."""
        parts = []
        done = 0
        while done < outputs:
            if (batch := min(outputs - done, self.steps // count)) > 0:
                parts.append(self.call(runner, count, batch))
            else:
                batch, inside = 1, 0
                while inside < count:
                    piece = min(self.steps, count - inside)
                    rows = self.call(runner, piece, reset=inside == 0, record=inside + piece == count)
                    inside += piece
                parts.append(rows)
            done += batch
        return parts[0] if len(parts) == 1 else np.concatenate(parts)
