"""Signals that end a command: Ctrl-C, SIGTERM, SIGHUP. Each becomes a sentence and an exit code, within two seconds, whatever is under way."""

from __future__ import annotations

import os
import signal
import socket
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
        if threading.current_thread() is not threading.main_thread():
            return self
        for number in CODES:
            handler = signal.getsignal(number)
            if handler in (signal.SIG_DFL, signal.default_int_handler):  # what is ignored, as by nohup, stays so
                self.former[number] = handler
                signal.signal(number, _raise)
        self.near, self.far = socket.socketpair()
        self.near.setblocking(False)
        self.waker = signal.set_wakeup_fd(self.near.fileno(), warn_on_full_buffer=False)
        threading.Thread(target=_watch, args=(self.far,), daemon=True).start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if not self.former:
            return
        signal.set_wakeup_fd(self.waker)
        for number, handler in self.former.items():
            signal.signal(number, handler)
        self.near.close()  # which ends the watch


def _raise(number: int, frame: FrameType | None) -> NoReturn:
    NOW.code = CODES[number]
    raise KeyboardInterrupt


def _watch(far: socket.socket) -> None:
    """Waits for a signal, and then for the command to end."""
    with far:
        while heard := far.recv(1):
            if heard[0] in CODES:
                break
        else:
            return
        NOW.code = CODES[heard[0]]
        until = time.monotonic() + GRACE
        far.settimeout(GRACE)
        while time.monotonic() < until:
            try:
                if not far.recv(64):
                    return  # the command has ended
            except TimeoutError:
                break
    _end_at_once()


def _end_at_once() -> None:
    for action in NOW.last:
        action()
    print(f"interrupted: {NOW.by}. {NOW.saved}", file=sys.stderr, flush=True)
    os._exit(NOW.code)
