"""Run folders: each run has a folder of its own, and files that no run wrote are never replaced or removed.

A run begins in a temporary folder beside its place and moves in with its first output, so that a run that
fails at its start leaves an earlier one as it was. Whether a file was written by a run is decided by its
content, because names can be reused.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

from ..errors import HeldError, RunFileError
from ..files import read_bytes
from ..files.kinds import RUN_FILE
from .lock import LOCK, Lock, holder
from .schemas import is_run_file

MODEL, SUMMARY, FIGURES = "model.toml", "summary.json", "figures"
SQLITE_TRACES = tuple(f"{RUN_FILE}{end}" for end in ("-wal", "-shm", "-journal"))
SUMMARY_KEYS = {"status", "step", "steps", "measures"}
FIGURE_NAMES = ("mechanism", "orbits", "guides", "forces", "moments", "accelerations")  # that --figures draws
PICTURES = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}  # first bytes of figures
HEAD = 5000  # bytes in which a figure names its program
DRAWN_BY = (b"vfife", b"Matplotlib")  # programs in the head of a figure; the second of versions before 0.3
STAGE = ".new-"  # part of the name of a folder in which a run begins


def numbered(first: Path) -> Iterator[Path]:
    """Yield a path, and the same with the numbers 2, 3, ..."""
    yield first
    for number in count(2):
        yield first.with_name(f"{first.name}-{number}")


def entries(folder: Path) -> list[Path]:
    """List the content of a folder without locks and temporary folders of runs."""
    return [path for path in folder.iterdir() if path.name != LOCK and STAGE not in path.name]


def refuse_foreign(place: Path | None, trace: str = RUN_FILE, noun: str = "run") -> None:
    """Raise ValueError for a folder with files but without the ``trace`` that a run, or another ``noun``,
    leaves.
    """
    if place is None or not place.exists():
        return
    if not place.is_dir():
        raise ValueError(f"-o {place}: this is a file; name a folder")
    has_trace = is_run_file(place / trace) if trace == RUN_FILE else (place / trace).is_file()
    if entries(place) and not has_trace:
        raise ValueError(
            f"-o {place}: the folder contains files that are not a {noun} of vfife; name another one, or an"
            " empty one"
        )


def own_files(folder: Path, model: str | None) -> list[Path]:
    """Return the files in a run folder whose content shows a run wrote them; ``model`` is the text in its run
    file.
    """
    files = [
        path
        for path in (folder / RUN_FILE, folder / MODEL, folder / SUMMARY)
        if path.is_file() and is_own(path, model)
    ]
    if folder / RUN_FILE in files:
        files += [folder / name for name in SQLITE_TRACES if (folder / name).is_file()]
    return files + [
        path
        for path in sorted((folder / FIGURES).glob("*"))
        if path.suffix in PICTURES and is_own(path, model)
    ]


def foreign_files(folder: Path, model: str | None) -> list[Path]:
    """Return the files that a run would replace and that no run wrote."""
    names = [RUN_FILE, *SQLITE_TRACES, MODEL, SUMMARY, *(f"{FIGURES}/{name}.png" for name in FIGURE_NAMES)]
    written = set(own_files(folder, model))
    return [folder / name for name in names if (folder / name).exists() and folder / name not in written]


def is_own(path: Path, model: str | None) -> bool:
    """Return whether a run wrote a file: the run file by its header, the model by its text, a summary by its
    keys, a figure by its head.
    """
    try:
        if path.name == RUN_FILE:
            return is_run_file(path)
        if path.name == MODEL:
            return read_bytes(path).decode("utf-8") == model
        if path.name == SUMMARY:
            summary = json.loads(read_bytes(path))
            return isinstance(summary, dict) and set(summary) >= SUMMARY_KEYS
        with path.open("rb") as stream:
            head = stream.read(HEAD)
            stream.seek(max(path.stat().st_size - HEAD, 0))
            head += stream.read(HEAD) if path.suffix == ".pdf" else b""  # which says at its end who made it
        return head.startswith(PICTURES[path.suffix]) and any(name in head for name in DRAWN_BY)
    except (OSError, ValueError, RecursionError, KeyError):
        return False


def model_of(folder: Path) -> str | None:
    """Return the text of the model in a folder's run file; None if it cannot be read."""
    from .runfile import RunFile

    with suppress(RunFileError), RunFile.open(folder) as file:
        text = file.meta.get("model")
        return text if isinstance(text, str) else None
    return None


def tidy(parent: Path, name: str) -> None:
    """Remove temporary folders of runs whose processes have ended."""
    if not parent.is_dir():
        return
    for path in parent.glob(f"{name}{STAGE}*"):
        if path.is_dir() and holder(path) is None:
            empty(path)


def empty(stage: Path) -> None:
    """Remove a temporary folder of a run with what the run wrote."""
    for name in (RUN_FILE, *SQLITE_TRACES, MODEL, SUMMARY, LOCK):
        with suppress(OSError):
            (stage / name).unlink(missing_ok=True)
    with suppress(OSError):  # it holds a file of the user's
        stage.rmdir()


OPEN_MOVES = os.name != "nt"  # whether a folder with an open file, its lock, can be renamed


@dataclass
class RunFolder:
    """A run folder; ``path`` is where the run is now, beside its ``target`` until it has ``settled`` there.

    ``chosen``: the user named the folder; otherwise the next free name will do. ``notes`` mention an earlier
    run. ``made`` are folders above it that were made for it.
    """

    target: Path
    chosen: bool = True
    replaces: bool = False
    notes: tuple[str, ...] = ()
    path: Path = field(default_factory=Path)
    lock: Lock | None = None
    settled: bool = False
    created: tuple[Path, ...] = ()

    @property
    def run_file(self) -> Path:
        """The run file in it."""
        return self.path / RUN_FILE

    def begin(self) -> None:
        """Make a temporary folder beside the place, or inside an existing one; lock it. Raises OSError."""
        home = self.target.resolve()
        inside = home.is_dir()
        parent, name = (home, "") if inside else (home.parent, f".{home.name}")
        if not inside:
            self.created = tuple(folder for folder in parent.parents if not folder.exists())
            self.created = (*((parent,) if not parent.exists() else ()), *self.created)
            parent.mkdir(parents=True, exist_ok=True)
        # A random name lets several runs begin beside the same place; the first that settles takes it.
        tidy(parent, name)
        self.path = parent / f"{name}{STAGE}{os.urandom(4).hex()}"
        self.path.mkdir()
        self.lock = Lock(self.path)

    def settle(self) -> Path:
        """Move the run, whose file is closed, to its place; return the path of the run file.

        Raises HeldError or ValueError if another run has been put there in the meantime; then this one stays
        where it is.
        """
        home = self.target.resolve()
        if home.is_dir() and (self.chosen or entries(home)):
            self._move_in(home) if self.chosen else self._next()
        else:
            self._rename(home)
        self.path, self.settled = self.target, True
        return self.run_file

    def _next(self) -> None:
        self.target = next(path for path in numbered(self.target) if not path.exists())
        self._rename(self.target.resolve())

    def _rename(self, home: Path) -> None:
        lock = self.lock
        if lock is not None and not OPEN_MOVES:
            lock.release()
        try:
            os.rename(self.path, home)
        except OSError:
            self.lock = Lock(self.path) if lock is not None and not OPEN_MOVES else lock
            if not home.exists():
                raise
            if self.chosen:
                raise HeldError(
                    f"{self.target}: another run has been put here; name another folder"
                ) from None
            self._next()
            return
        if lock is not None and OPEN_MOVES:
            lock.moved(home)
        elif lock is not None:
            self.lock = Lock(home)

    def _move_in(self, home: Path) -> None:
        """Move file by file into an existing folder; the run that is replaced keeps its run file until the
        new one is there.
        """
        lock = Lock(home)
        try:
            if not self.replaces and entries(home):
                raise HeldError(
                    f"{self.target}: another run has been put here; name another folder, or add --force to"
                    " replace it"
                )
            model = model_of(home)
            refuse_changed_files(self.target, model)
            # The order keeps a readable run in the folder at every moment. A journal of the old file is
            # removed first: SQLite would apply it to the new one. Then the new run file replaces the old one
            # at once, and only then are the old figures and summary removed.
            old = own_files(home, model)
            for path in old:
                if path.name.startswith(f"{RUN_FILE}-"):
                    path.unlink()
            for name in (RUN_FILE, MODEL):
                os.replace(self.path / name, home / name)
            for path in old:
                if path.name not in (RUN_FILE, MODEL):
                    path.unlink(missing_ok=True)
            with suppress(OSError):  # it holds a file of the user's
                (home / FIGURES).rmdir()
        except BaseException:
            lock.release()
            raise
        if self.lock is not None:
            self.lock.release()
        empty(self.path)
        self.lock = lock

    def leave(self) -> None:
        """Release the lock; remove a run that has not settled, and folders that were made for it."""
        if self.lock is not None:
            self.lock.release()
            self.lock = None
        if not self.settled:
            empty(self.path)
            for folder in self.created:
                with suppress(OSError):
                    folder.rmdir()


def placed(place: Path | None, model: Path, *, replace: bool = False, start: Path | None = None) -> RunFolder:
    """Choose the folder of a run without changing anything: the given one, else runs/<model>, or with the
    next free number.

    Raises ValueError if it holds something else or, unless ``replace``, a run, if the run in it is the
    ``start``, or if files of the user's would be replaced; HeldError if another process writes into it.
    """
    if place is None:
        first = Path("runs") / model.stem
        path = next(path for path in numbered(first) if not path.exists())
        notes = (
            (f"{first} is there already and stays as it is: this run goes to {path}",)
            if path != first
            else ()
        )
        return RunFolder(path, False, notes=notes)
    refuse_foreign(place)
    if not place.exists() or not entries(place):
        return RunFolder(place)
    if (
        start is not None
        and (start / RUN_FILE if start.is_dir() else start).resolve() == (place / RUN_FILE).resolve()
    ):
        raise ValueError(
            f"-o {place}: the run would replace the one from which it starts; name another folder"
        )
    if not replace:
        raise ValueError(
            f"-o {place}: there is a run here already; name another folder, continue it (--resume), or add"
            " --force to replace it"
        )
    if (process := holder(place)) is not None:
        raise HeldError(
            f"-o {place}: {process} writes a run here; wait until it has ended, or name another folder"
        )
    refuse_changed_files(place, model_of(place))
    return RunFolder(place, True, True, (f"{place} held an earlier run, which this one replaces",))


def refuse_changed_files(folder: Path, model: str | None) -> None:
    """Raise ValueError for files a run would replace and that no run wrote, or that were changed since."""
    if files := foreign_files(folder, model):
        names = ", ".join(str(path.relative_to(folder)) for path in files)
        raise ValueError(
            f"-o {folder}: {names} here would be overwritten and was not written by a run; move it, or"
            " name another folder"
        )


def existing_run(path: Path) -> RunFolder:
    """Lock the folder of an existing run to continue it. Raises HeldError if another process writes there."""
    return RunFolder(path, path=path, lock=Lock(path), settled=True)
