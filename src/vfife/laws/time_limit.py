"""Time limit for code of a user's law, which may contain a loop that does not end."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

# Limit for a file of laws and for the parameters of a law. Those of the package take microseconds.
SECONDS = 10.0


class Endless(BaseException):
    """The code of a user does not end."""


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise Endless in code that runs for more than ``seconds``.

    In the main thread the system's timer interrupts the code. In other threads Python checks the clock line
    by line, which cannot interrupt a single call that never returns.
    """
    if hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread():
        former = signal.signal(signal.SIGALRM, _late)
        try:
            signal.setitimer(signal.ITIMER_REAL, seconds)
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, former)
    else:
        end, former_trace = time.monotonic() + seconds, sys.gettrace()

        def look(frame: FrameType, event: str, argument: Any) -> Any:
            if time.monotonic() > end:
                raise Endless
            return look

        try:
            sys.settrace(look)
            yield
        finally:
            sys.settrace(former_trace)


def _late(number: int, frame: FrameType | None) -> NoReturn:
    raise Endless
