"""Where a run is kept: a folder of its own, never one that holds something else; what in it is ours, and what
is not.

A run begins in a folder beside its place, and moves in when its first output is there. Until then nothing is
touched.
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
from .lock import LOCK, Lock, holder
from .schemas import RUN_FILE, is_run_file

MODEL, SUMMARY, FIGURES = "model.toml", "summary.json", "figures"
SQLITE_TRACES = tuple(f"{RUN_FILE}{end}" for end in ("-wal", "-shm", "-journal"))
SUMMARY_KEYS = {"status", "step", "steps", "measures"}
FIGURE_NAMES = (
    "mechanism",
    "orbits",
    "guides",
    "forces",
    "moments",
    "accelerations",
)  # that a run draws with --figures
PICTURES = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}  # how they begin
HEAD = 5000  # bytes in which a figure says who made it
DRAWN_BY = (b"vfife", b"Matplotlib")  # in the head of a figure; the second by versions before 0.3
STAGE = ".new-"  # in the name of a folder in which a run begins


def numbered(first: Path) -> Iterator[Path]:
    """A name, and those with the next numbers."""
    yield first
    for number in count(2):
        yield first.with_name(f"{first.name}-{number}")


def entries(folder: Path) -> list[Path]:
    """What lies in a folder, without locks and folders in which runs began."""
    return [path for path in folder.iterdir() if path.name != LOCK and STAGE not in path.name]


def refuse_foreign(asked: Path | None, trace: str = RUN_FILE, what: str = "run") -> None:
    """Raises ValueError for a folder that is given and holds something else: not the ``trace`` that a run, or
    ``what`` is meant, leaves.
    """
    if asked is None or not asked.exists():
        return
    if not asked.is_dir():
        raise ValueError(f"-o {asked}: this is a file; name a folder")
    own = is_run_file(asked / trace) if trace == RUN_FILE else (asked / trace).is_file()
    if entries(asked) and not own:
        raise ValueError(
            f"-o {asked}: the folder holds files that are no {what} of vfife; name another one, or one that"
            " is empty"
        )


def own_files(folder: Path, model: str | None) -> list[Path]:
    """Files in a run folder that a run left there, as their content tells; ``model`` is the text that its run
    file has.
    """
    found = [
        path
        for path in (folder / RUN_FILE, folder / MODEL, folder / SUMMARY)
        if path.is_file() and is_own(path, model)
    ]
    if folder / RUN_FILE in found:
        found += [folder / name for name in SQLITE_TRACES if (folder / name).is_file()]
    return found + [
        path
        for path in sorted((folder / FIGURES).glob("*"))
        if path.suffix in PICTURES and is_own(path, model)
    ]


def in_the_way(folder: Path, model: str | None) -> list[Path]:
    """Files that a run would write and that are not ours."""
    names = [RUN_FILE, *SQLITE_TRACES, MODEL, SUMMARY, *(f"{FIGURES}/{name}.png" for name in FIGURE_NAMES)]
    own = set(own_files(folder, model))
    return [folder / name for name in names if (folder / name).exists() and folder / name not in own]


def is_own(path: Path, model: str | None) -> bool:
    """Whether a run wrote a file: the run file by its header, the model by its text, a summary by its keys, a
    figure by its head.
    """
    try:
        if path.name == RUN_FILE:
            return is_run_file(path)
        if path.name == MODEL:
            return read_bytes(path).decode("utf-8") == model
        if path.name == SUMMARY:
            said = json.loads(read_bytes(path))
            return isinstance(said, dict) and set(said) >= SUMMARY_KEYS
        with path.open("rb") as stream:
            told = stream.read(HEAD)
            stream.seek(max(path.stat().st_size - HEAD, 0))
            told += stream.read(HEAD) if path.suffix == ".pdf" else b""  # which says at its end who made it
        return told.startswith(PICTURES[path.suffix]) and any(name in told for name in DRAWN_BY)
    except (OSError, ValueError, RecursionError, KeyError):
        return False


def model_of(folder: Path) -> str | None:
    """The text of the model that a folder's run file has; None where it cannot be read."""
    from .runfile import RunFile

    with suppress(RunFileError), RunFile.open(folder) as file:
        text = file.meta.get("model")
        return text if isinstance(text, str) else None
    return None


def tidy(parent: Path, name: str) -> None:
    """Removes folders in which runs of a name began whose processes are gone."""
    if not parent.is_dir():
        return
    for path in parent.glob(f"{name}{STAGE}*"):
        if path.is_dir() and holder(path) is None:
            empty(path)


def empty(stage: Path) -> None:
    """Removes a folder in which a run began, with what it wrote."""
    for name in (RUN_FILE, *SQLITE_TRACES, MODEL, SUMMARY, LOCK):
        with suppress(OSError):
            (stage / name).unlink(missing_ok=True)
    with suppress(OSError):  # something that is not ours
        stage.rmdir()


OPEN_MOVES = os.name != "nt"  # whether a folder can be renamed in which a file is open: its lock


@dataclass
class RunFolder:
    """A run folder; ``notes`` say what becomes of an earlier run. ``path`` is where the run is now: beside
    its place until it has settled there.
    """

    target: Path
    chosen: bool = True  # the name was given; else the next free one will do as well
    replaces: bool = False
    notes: tuple[str, ...] = ()
    path: Path = field(default_factory=Path)
    lock: Lock | None = None
    settled: bool = False
    made: tuple[Path, ...] = ()  # folders above it that were made for it

    @property
    def run_file(self) -> Path:
        """The run file in it."""
        return self.path / RUN_FILE

    def begin(self) -> None:
        """Makes a folder beside the place, inside it where there is one already, and takes its lock. Raises
        OSError.
        """
        home = self.target.resolve()
        inside = home.is_dir()
        parent, name = (home, "") if inside else (home.parent, f".{home.name}")
        if not inside:
            self.made = tuple(above for above in parent.parents if not above.exists())
            self.made = (*((parent,) if not parent.exists() else ()), *self.made)
            parent.mkdir(parents=True, exist_ok=True)
        tidy(parent, name)
        self.path = parent / f"{name}{STAGE}{os.urandom(4).hex()}"
        self.path.mkdir()
        self.lock = Lock(self.path)

    def settle(self) -> Path:
        """Moves the run to its place; its run file is closed. Returns where the run file is.

        Raises HeldError or ValueError where somebody else has come there in the meantime; then the run stays
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
        held = self.lock
        if held is not None and not OPEN_MOVES:
            held.release()
        try:
            os.rename(self.path, home)
        except OSError:
            self.lock = Lock(self.path) if held is not None and not OPEN_MOVES else held
            if not home.exists():
                raise
            if self.chosen:
                raise HeldError(
                    f"{self.target}: another run has been put here; name another folder"
                ) from None
            self._next()
            return
        if held is not None and OPEN_MOVES:
            held.moved(home)
        elif held is not None:
            self.lock = Lock(home)

    def _move_in(self, home: Path) -> None:
        """File by file into a folder that is there; the run that it replaces has its run file until the new
        one is there.
        """
        lock = Lock(home)
        try:
            if not self.replaces and entries(home):
                raise HeldError(
                    f"{self.target}: another run has been put here; name another folder, or add --force to"
                    " replace it"
                )
            model = model_of(home)
            refuse_in_the_way(self.target, model)
            old = own_files(home, model)
            for path in old:
                if path.name.startswith(f"{RUN_FILE}-"):  # a journal is that of the old file
                    path.unlink()
            for name in (RUN_FILE, MODEL):
                os.replace(self.path / name, home / name)
            for path in old:
                if path.name not in (RUN_FILE, MODEL):
                    path.unlink(missing_ok=True)
            with suppress(OSError):  # something of the user's is in there
                (home / FIGURES).rmdir()
        except BaseException:
            lock.release()
            raise
        if self.lock is not None:
            self.lock.release()
        empty(self.path)
        self.lock = lock

    def leave(self) -> None:
        """Ends the work in the folder; a run that has not settled is gone, and so are folders that were made
        for it.
        """
        if self.lock is not None:
            self.lock.release()
            self.lock = None
        if not self.settled:
            empty(self.path)
            for folder in self.made:
                with suppress(OSError):
                    folder.rmdir()


def placed(asked: Path | None, model: Path, *, replace: bool = False, start: Path | None = None) -> RunFolder:
    """The place of a run, found without touching anything: the folder that is given, else runs/<model>, or
    with the next free number.

    Raises ValueError where it holds something else or, unless ``replace``, a run already, where ``start`` is
    the run in it, or where files are in the way that are not ours; HeldError where another process writes
    into it.
    """
    if asked is None:
        first = Path("runs") / model.stem
        path = next(path for path in numbered(first) if not path.exists())
        notes = (
            (f"{first} is there already and stays as it is: this run goes to {path}",)
            if path != first
            else ()
        )
        return RunFolder(path, False, notes=notes)
    refuse_foreign(asked)
    if not asked.exists() or not entries(asked):
        return RunFolder(asked)
    if (
        start is not None
        and (start / RUN_FILE if start.is_dir() else start).resolve() == (asked / RUN_FILE).resolve()
    ):
        raise ValueError(
            f"-o {asked}: the run is to start from the one that is here, which would be lost; name another"
            " folder"
        )
    if not replace:
        raise ValueError(
            f"-o {asked}: there is a run here already; name another folder, go on with it (--resume), or add"
            " --force to replace it"
        )
    if (who := holder(asked)) is not None:
        raise HeldError(
            f"-o {asked}: {who} writes a run here; wait until it has ended, or name another folder"
        )
    refuse_in_the_way(asked, model_of(asked))
    return RunFolder(asked, True, True, (f"{asked} held an earlier run, which this one replaces",))


def refuse_in_the_way(folder: Path, model: str | None) -> None:
    """Raises ValueError for files that a run would write over and that no run left there, or that were
    changed since.
    """
    if ours_not := in_the_way(folder, model):
        names = ", ".join(str(path.relative_to(folder)) for path in ours_not)
        raise ValueError(
            f"-o {folder}: {names} here would be written over and was not left so by a run; move it away, or"
            " name another folder"
        )


def kept_run(path: Path) -> RunFolder:
    """The place of a run that is there, to go on with, locked. Raises HeldError where another process writes
    into it.
    """
    return RunFolder(path, path=path, lock=Lock(path), settled=True)
