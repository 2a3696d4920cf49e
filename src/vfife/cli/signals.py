"""Signals that end a command: Ctrl-C, SIGTERM, SIGHUP. Each becomes a sentence and an exit code, within two seconds, whatever is under way."""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from types import FrameType, TracebackType
from typing import Any, NoReturn

CODES = {getattr(signal, name): code for name, code in (("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)) if hasattr(signal, name)}
WORDS = {code: name for name, code in (("Ctrl-C", 130), ("SIGTERM", 143), ("SIGHUP", 129))}
GRACE = 1.6  # s after a signal, within which a command ends by itself; compilers and drawers do not always hear


@dataclass
class Ending:
    """What a command says where it has to end at once, and what it does before."""

    code: int = 130
    saved: str = "Nothing was begun, so there is nothing to keep."
    last: list[Callable[[], None]] = field(default_factory=list)

    @property
    def by(self) -> str:
        """What ended it."""
        return f"Stopped by {WORDS[self.code]}"


NOW = Ending()


class Signals:
    """While it is entered, signals raise KeyboardInterrupt in the main thread; one that is not heard there in time ends the process."""

    def __enter__(self) -> Signals:
        NOW.code, NOW.saved, NOW.last = 130, Ending.saved, []
        self.former: dict[int, Any] = {}
        self.near = self.waker = -1
        if threading.current_thread() is not threading.main_thread():
            return self
        for number in CODES:
            handler = signal.getsignal(number)
            if handler in (signal.SIG_DFL, signal.default_int_handler):  # what is ignored, as by nohup, stays so
                self.former[number] = handler
                signal.signal(number, _raise)
        if self.former and os.name == "posix":
            far, self.near = os.pipe()
            os.set_blocking(self.near, False)
            self.waker = signal.set_wakeup_fd(self.near, warn_on_full_buffer=False)
            threading.Thread(target=_watch, args=(far,), daemon=True).start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for number, handler in self.former.items():
            signal.signal(number, handler)
        if self.near >= 0:
            signal.set_wakeup_fd(self.waker)
            os.close(self.near)  # which ends the watch


def _raise(number: int, frame: FrameType | None) -> NoReturn:
    NOW.code = CODES[number]
    raise KeyboardInterrupt


def _watch(far: int) -> None:
    """Waits for a signal, and then for the command to end."""
    try:
        while heard := os.read(far, 1):
            if heard[0] in CODES:
                break
        else:
            return
        NOW.code = CODES[heard[0]]
        until = time.monotonic() + GRACE
        while (left := until - time.monotonic()) > 0.0:
            if select.select([far], [], [], left)[0] and not os.read(far, 64):
                return  # the command has ended
    finally:
        os.close(far)
    _end_at_once()


def _end_at_once() -> None:
    for action in NOW.last:
        action()
    print(f"interrupted: {NOW.by}. {NOW.saved}", file=sys.stderr, flush=True)
    os._exit(NOW.code)
