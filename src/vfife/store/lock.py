"""Locks: one process at a time writes into a run folder or a file. The system releases a lock however its
process ends.
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
from ..files.kinds import RUN_FILE


def _module(name: str) -> ModuleType | None:
    """Return a module that some systems have."""
    try:
        return import_module(name)
    except ImportError:
        return None


# POSIX has fcntl, Windows msvcrt; without either there is no lock.
fcntl: Any = _module("fcntl")
msvcrt: Any = _module("msvcrt") if fcntl is None else None

LOCK = "run.lock"
LARGEST = 10_000  # bytes of a lock file, which names a process and a time
# Errors of a file system without locks, where nobody is refused.
NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}


class Lock:
    """The right to write into a folder, until :meth:`release` or the end of the process. Raises HeldError,
    which names the holder.

    The lock of a single file in a folder has a ``name`` of its own; ``content`` names what is written, for
    messages.
    """

    def __init__(self, folder: Path, name: str = LOCK, content: str = "a run here") -> None:
        self.path = folder / name
        self.stream: IO[str] | None = _held(self.path, content)
        self.stream.seek(0)
        self.stream.truncate()
        holder = {
            "process": os.getpid(),
            "host": _host(),
            "since": datetime.now(UTC).isoformat(timespec="seconds"),
        }
        self.stream.write(json.dumps(holder))
        self.stream.flush()

    def moved(self, folder: Path) -> None:
        """Follow the folder to its new name."""
        self.path = folder / LOCK

    def release(self) -> None:
        """Release the lock and remove its file."""
        if self.stream is None:
            return
        # The file is unlinked before it is unlocked: the other way round, a process that locked it in between
        # would hold the lock of a file without a name, and a third one could take a new file of this name. It
        # is unlinked only if it is still ours, since a folder may have been moved.
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
    """Name the process that writes into a folder, and since when; None without any."""
    path = folder / name
    try:
        with open(path, "r+", encoding="utf-8", opener=_opened) as stream:
            if not _is_locked(stream):
                return None
            return _who(path)
    except OSError:
        return None
    except HeldError as error:
        return str(error)


def run_lock(path: Path) -> Lock:
    """Lock a run file: its folder if it is that of a run, else the file alone. Raises HeldError."""
    path = path.absolute()
    if path.name == RUN_FILE:
        return Lock(path.parent)
    return Lock(path.parent, f"{path.name}.lock", "this run file")


def _held(path: Path, content: str) -> IO[str]:
    """Open and lock the lock file.

    Its former holder may unlink it between both; then the locked file is no longer the one of this name, and
    the next is tried.
    """
    while True:
        stream = open(path, "a+", encoding="utf-8", opener=_opened)  # noqa: SIM115 - the lock holds it
        try:
            if _is_locked(stream):
                raise HeldError(_refusal(path, content))
            if os.path.samestat(os.fstat(stream.fileno()), path.stat()):
                return stream
        except FileNotFoundError:
            pass
        except BaseException:
            stream.close()
            raise
        stream.close()


def _opened(path: str, flags: int) -> int:
    """Open a lock file, but no link, whose target would be truncated, and no pipe. Raises OSError."""
    descriptor = os.open(path, flags | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0), 0o666)
    try:
        require_regular(os.fstat(descriptor), path)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _refusal(path: Path, content: str) -> str:
    place, noun = (path.parent, "folder") if path.name == LOCK else (path.with_suffix(""), "file")
    return f"{place}: {_who(path)} writes {content}; wait until it has ended, or name another {noun}"


def _is_locked(stream: IO[str]) -> bool:
    """Try to lock a file; True if another process holds it. A file system without locks lets everyone in."""
    try:
        if fcntl is not None:
            fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        elif msvcrt is not None:
            stream.seek(2**20)  # far behind the content, which others can then read
            msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
    except OSError as error:
        return error.errno not in NO_LOCKS
    return False


def _who(path: Path) -> str:
    """Name the holder as far as the lock file does."""
    try:
        holder = json.loads(read_bytes(path, LARGEST))
        return f"process {int(holder['process'])} on {holder['host']}, since {holder['since']},"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"
