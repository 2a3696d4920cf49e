"""One writer at a time in a run folder, or of a file, by a lock that the system takes back when its process
ends, however it ends.
"""

from __future__ import annotations

import errno
import json
import os
from contextlib import suppress
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path
from types import ModuleType, TracebackType
from typing import IO, Any

from ..errors import HeldError
from ..files import read_bytes, require_regular


def _module(name: str) -> ModuleType | None:
    """A module that some systems have."""
    try:
        return import_module(name)
    except ImportError:
        return None


# POSIX has the one, Windows the other; where neither is there nobody is kept out.
fcntl: Any = _module("fcntl")
msvcrt: Any = _module("msvcrt") if fcntl is None else None

LOCK = "run.lock"
LARGEST = 10_000  # bytes of a lock file, which names a process and a time
NO_LOCKS = {
    errno.ENOLCK,
    errno.ENOSYS,
    errno.EOPNOTSUPP,
    errno.EINVAL,
}  # what a file system says that knows none


class Lock:
    """The right to write into a folder, until :meth:`release` or the end of the process. Raises HeldError,
    which names who has it.

    Of a single file in a folder the lock has a ``name`` of its own, and ``what`` says what is written there.
    """

    def __init__(self, folder: Path, name: str = LOCK, what: str = "a run here") -> None:
        self.path = folder / name
        self.stream: IO[str] | None = _held(self.path, what)
        self.stream.seek(0)
        self.stream.truncate()
        told = {
            "process": os.getpid(),
            "host": _host(),
            "since": datetime.now(UTC).isoformat(timespec="seconds"),
        }
        self.stream.write(json.dumps(told))
        self.stream.flush()

    def moved(self, folder: Path) -> None:
        """The folder has another name now, the file in it with it."""
        self.path = folder / LOCK

    def release(self) -> None:
        """Gives the right back; the file goes with it."""
        if self.stream is None:
            return
        stays = False
        with suppress(OSError):
            if os.path.samestat(os.fstat(self.stream.fileno()), self.path.stat()):
                stays = True
                self.path.unlink()
                stays = False
        self.stream.close()
        self.stream = None
        if stays:  # Windows removes no open file
            with suppress(OSError):
                self.path.unlink()

    def __enter__(self) -> Lock:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()


def _host() -> str:
    if hasattr(os, "uname"):
        return os.uname().nodename
    import platform

    return platform.node()


def holder(folder: Path, name: str = LOCK) -> str | None:
    """Who writes into a folder and since when, in words; None where nobody does."""
    path = folder / name
    try:
        with open(path, "r+", encoding="utf-8", opener=_opened) as stream:
            if not _taken(stream):
                return None
            return _who(path)
    except OSError:
        return None
    except HeldError as error:
        return str(error)


def _held(path: Path, what: str) -> IO[str]:
    """The lock file, locked: one that was unlinked meanwhile by its former holder is not it."""
    while True:
        stream = open(path, "a+", encoding="utf-8", opener=_opened)  # noqa: SIM115 - the lock holds it
        try:
            if _taken(stream):
                raise HeldError(_refusal(path, what))
            if os.path.samestat(os.fstat(stream.fileno()), path.stat()):
                return stream
        except FileNotFoundError:
            pass
        except BaseException:
            stream.close()
            raise
        stream.close()


def _opened(path: str, flags: int) -> int:
    """Open a lock file, but no link that somebody has planted, whose target would be cut off, and no pipe.
    Raises OSError.
    """
    descriptor = os.open(path, flags | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0), 0o666)
    try:
        require_regular(os.fstat(descriptor), path)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _refusal(path: Path, what: str) -> str:
    where, other = (path.parent, "folder") if path.name == LOCK else (path.with_suffix(""), "file")
    return f"{where}: {_who(path)} writes {what}; wait until it has ended, or name another {other}"


def _taken(stream: IO[str]) -> bool:
    """Tries to lock a file; True where another one has it. A file system without locks lets everyone in."""
    try:
        if fcntl is not None:
            fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        elif msvcrt is not None:
            stream.seek(2**20)  # far behind what is written, which others can read then
            msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
    except OSError as error:
        return error.errno not in NO_LOCKS
    return False


def _who(path: Path) -> str:
    """The holder in words, as far as its file says."""
    try:
        told = json.loads(read_bytes(path, LARGEST))
        return f"process {int(told['process'])} on {told['host']}, since {told['since']},"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"
