"""What Windows and macOS do otherwise, as far as that can be told without them: modules, signals, calls that
are not there, files that are open.
"""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from vfife.errors import HeldError
from vfife.store import folder as folders
from vfife.store import lock
from vfife.store.lock import LOCK, Lock, holder

# What POSIX has and Windows has not, taken away before anything of ours is loaded; then every module is, and
# a run made.
WITHOUT = """
import os, signal, sys
# theirs, which know their system
import h5netcdf, llvmlite.binding, matplotlib.figure, numpy, rich.console, sqlite3, subprocess, typer, xarray
for name in ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog"):
    sys.modules[name] = None
for name in ("SIGHUP", "SIGKILL", "SIGALRM", "SIGUSR1", "SIGXFSZ", "SIGPIPE"):
    delattr(signal, name)
for name in (
    "geteuid", "getuid", "uname", "fork", "forkpty", "sysconf", "fchmod",
    "getpgid", "killpg", "mkfifo", "wait", "nice"
):
    delattr(os, name)
import importlib, pkgutil, vfife
for one in pkgutil.walk_packages(vfife.__path__, "vfife."):
    if not one.name.endswith("__main__"):
        importlib.import_module(one.name)
sys.argv = ["vfife", "run", "model.toml", "-o", "out", "--set", "run.turns=0.01"]
from vfife.cli.app import app
app()
"""


@pytest.mark.system("starts a process on a system made poorer")
def test_it_runs_without_what_posix_alone_has(tmp_path: Path) -> None:
    import vfife

    vfife.save_model(vfife.gallery.slider_crank(), tmp_path / "model.toml")
    done = subprocess.run([sys.executable, "-c", WITHOUT], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "run.sqlite").is_file() and not (tmp_path / "out" / LOCK).exists()


class Locking:
    """The locks of Windows: a byte range that one handle has, by process here because POSIX forgets which
    handle.
    """

    LK_NBLCK = 2

    def __init__(self) -> None:
        self.held: dict[tuple[int, int], int] = {}

    def locking(self, handle: int, mode: int, count: int) -> None:
        """Takes the range, or raises what Windows raises."""
        found = os.fstat(handle)
        key = found.st_dev, found.st_ino
        if self.held.get(key, handle) != handle and is_open(self.held[key]):
            raise OSError(errno.EACCES, "Permission denied")
        self.held[key] = handle


def is_open(handle: int) -> bool:
    """Whether a handle is one still."""
    try:
        os.fstat(handle)
    except OSError:
        return False
    return True


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Locks of the other kind, and folders that do not move while a file in them is open."""
    monkeypatch.setattr(lock, "fcntl", None)
    monkeypatch.setattr(lock, "msvcrt", Locking())
    monkeypatch.setattr(folders, "OPEN_MOVES", False)


@pytest.mark.usefixtures("windows")
def test_one_writer_at_a_time_by_the_locks_of_windows(tmp_path: Path) -> None:
    with Lock(tmp_path):
        with pytest.raises(HeldError, match="writes a run here"):
            Lock(tmp_path)
        assert "process" in (holder(tmp_path) or "")
    assert holder(tmp_path) is None
    Lock(tmp_path).release()
    assert os.listdir(tmp_path) == []


@pytest.mark.usefixtures("windows")
def test_a_run_moves_in_although_open_files_keep_folders_where_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    renamed, released = os.rename, []

    def rename(source: Any, target: Any) -> None:
        assert holder(Path(source)) is None, "Windows renames no folder with an open file"
        released.append(source)
        renamed(source, target)

    monkeypatch.setattr(folders.os, "rename", rename)
    folder = folders.placed(tmp_path / "run", tmp_path / "model.toml")
    folder.begin()
    folder.run_file.write_text("")
    folder.settle()
    assert released and (tmp_path / "run" / LOCK).exists()
    with pytest.raises(HeldError):
        Lock(tmp_path / "run")
    folder.leave()
    assert os.listdir(tmp_path / "run") == ["run.sqlite"]


def test_without_locks_everybody_is_let_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lock, "fcntl", None)
    monkeypatch.setattr(lock, "msvcrt", None)
    first, second = Lock(tmp_path), Lock(tmp_path)
    second.release()
    first.release()
    assert os.listdir(tmp_path) == []
