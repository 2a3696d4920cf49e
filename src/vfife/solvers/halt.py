"""Signals that ask a run to end wait until it can be left: between two calls of the loop, when all that was computed is whole."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

ASKING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


class Halt:
    """While it is entered, handlers of :data:`ASKING` that are functions are called by :meth:`look` and at the end instead of anywhere.

    A second signal is handled where it comes. In a thread that is not the main one, which hears no signals, it does nothing.
    """

    def __init__(self) -> None:
        self.former: dict[int, Callable[[int, FrameType | None], Any]] = {}
        self.asked: int | None = None

    def __enter__(self) -> Halt:
        if threading.current_thread() is threading.main_thread():
            for number in ASKING:
                handler = signal.getsignal(number)
                if callable(handler):
                    self.former[number] = handler
                    signal.signal(number, self._hear)
        return self

    def _hear(self, number: int, frame: FrameType | None) -> None:
        if self.asked is not None:
            self.former[number](number, frame)
        self.asked = number

    def look(self) -> None:
        """Handles a signal that came, if there is one: most handlers raise KeyboardInterrupt."""
        number, self.asked = self.asked, None
        if number is not None:
            self.former[number](number, None)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for number, handler in self.former.items():
            signal.signal(number, handler)
        if kind is None:
            self.look()
