"""Signals that end a command: Ctrl-C, SIGTERM, SIGHUP. Each becomes a sentence and an exit code, within two
seconds, whatever is under way; within fifteen for a command that writes its answer then.

Next to nothing is imported here, for this is what a process loads first.
"""

from __future__ import annotations

import math
import os
import select
import signal
import sys
import time
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType, TracebackType


class JsonOutput:
    """Whether the command was called with ``--json``, and whether its object is printed."""

    def __init__(self) -> None:
        self.wanted, self.printed = False, False


JSON = JsonOutput()


CODES = {
    getattr(signal, name): code
    for name, code in (("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129))
    if hasattr(signal, name)
}
WORDS = {code: name for name, code in (("Ctrl-C", 130), ("SIGTERM", 143), ("SIGHUP", 129))}
# s after a signal before the process is ended; compilers and drawing libraries may not react to it.
GRACE = 1.6
# s for a command whose answer exists only after the signal: it ends its threads, and writes what it has.
ANSWER_GRACE = 15.0
# s between two signals that count as one: ``timeout`` sends its own to the process and to its group.
REPETITION = 0.2
NOT_STARTED = "Nothing was started, so there is nothing to keep."
DISCARDED_ANSWER = "The answer was not complete, and nothing of it is kept."
COMPLETED = "The command had finished its work."


class Ending:
    """What a command says where it has to end at once, and what it does before."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Note that a command begins."""
        self.code, self.saved, self.heard = 130, NOT_STARTED, False
        self.grace, self.time = GRACE, -math.inf
        self.last: list[Callable[[], None]] = []
        self.cautions: list[str] = []  # about the model, which are printed already

    @property
    def by(self) -> str:
        """What ended it."""
        return f"Stopped by {WORDS[self.code]}"


ENDING = Ending()


def listen() -> None:
    """From now on let a signal end the process at once, with a sentence; ignored signals, as with nohup,
    remain ignored.
    """
    for number in CODES:
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _leave)


def flush_output() -> None:
    """Flush the output after the end of a command; later signals no longer change the exit code."""
    ENDING.saved = COMPLETED
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        return  # nobody reads it any more
    finally:
        for number in CODES:
            if signal.getsignal(number) is _leave:
                signal.signal(number, signal.SIG_IGN)


class Signals:
    """While it is entered, signals raise KeyboardInterrupt in the main thread; one that is not heard there in
    time ends the process, as does a second one.
    """

    def __enter__(self) -> Signals:
        import threading

        ENDING.begin()
        self.former: dict[int, Any] = {}
        self.near = self.waker = -1
        if threading.current_thread() is not threading.main_thread():
            return self
        for number in CODES:
            handler = signal.getsignal(number)
            if handler in (signal.SIG_DFL, signal.default_int_handler, _leave):
                self.former[number] = handler
                signal.signal(number, _raise)
        if self.former and os.name == "posix":
            far, self.near = os.pipe()
            os.set_blocking(self.near, False)
            self.waker = signal.set_wakeup_fd(self.near, warn_on_full_buffer=False)
            threading.Thread(target=_watch, args=(far,), daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self.former.items():
            signal.signal(number, handler)
        if self.near >= 0:
            signal.set_wakeup_fd(self.waker)
            os.close(self.near)  # which ends the watch


def _raise(number: int, frame: FrameType | None) -> None:
    heard_at = time.monotonic()
    if ENDING.heard:
        if CODES[number] == ENDING.code and heard_at - ENDING.time < REPETITION:
            return
        _leave(number, frame)
    ENDING.code, ENDING.heard, ENDING.time = CODES[number], True, heard_at
    raise KeyboardInterrupt


def _leave(number: int, frame: FrameType | None) -> NoReturn:
    ENDING.code = CODES[number]
    end_at_once()


def _watch(far: int) -> None:
    """Wait for a signal, and then for the end of the command."""
    try:
        while heard := os.read(far, 1):
            if heard[0] in CODES:
                break
        else:
            return
        ENDING.code = CODES[heard[0]]
        until = time.monotonic() + ENDING.grace
        while (left := until - time.monotonic()) > 0.0:
            if select.select([far], [], [], left)[0] and not os.read(far, 64):
                return  # the command has ended
    finally:
        os.close(far)
    end_at_once()


def end_at_once() -> NoReturn:
    """End the process with a sentence, and with ``--json`` with an object. Nothing is imported, because the
    signal may have interrupted an import.
    """
    try:
        try:
            _clean_up()
        finally:
            _print_sentence()
    finally:
        os._exit(ENDING.code)


def _clean_up() -> None:
    """Release what the command holds, remove unfinished files and erase the progress line.

    A module that the signal found half imported has nothing to clean up and lacks its later names.
    """
    for action in ENDING.last:
        action()
    if remove := getattr(sys.modules.get("vfife.files"), "remove_unfinished", None):
        remove()
    if activity := getattr(sys.modules.get("vfife.job.activity"), "ACTIVITY", None):
        activity.erase()


def _print_sentence() -> None:
    sentence = f"{ENDING.by}. {ENDING.saved}"
    os.write(2, f"interrupted: {sentence}\n".encode(errors="replace"))
    if JSON.wanted and not JSON.printed:
        os.write(
            1,
            f'{{\n  "status": "interrupted",\n  "faults": [\n    {{\n      "what": {quoted(sentence)}\n  '
            "  }\n  ]\n}\n".encode(),
        )


def quoted(text: str) -> str:
    """Return a text as JSON."""
    return (
        '"'
        + "".join(sign if " " <= sign < "\x7f" and sign not in '"\\' else _escaped(sign) for sign in text)
        + '"'
    )


def _escaped(sign: str) -> str:
    units = sign.encode("utf-16-be", "surrogatepass")
    return "".join(f"\\u{units[k]:02x}{units[k + 1]:02x}" for k in range(0, len(units), 2))
