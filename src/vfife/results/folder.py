"""Where a run is kept: a folder of its own, never one that holds something else."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path

RUN_FILE, MODEL, SUMMARY, FIGURES = "run.sqlite", "model.toml", "summary.json", "figures"
SQLITE_TRACES = tuple(f"{RUN_FILE}{end}" for end in ("-wal", "-shm", "-journal"))


@dataclass
class RunFolder:
    """A run folder; ``notes`` say what became of an earlier run."""

    path: Path
    created: bool = False
    notes: tuple[str, ...] = ()

    @property
    def run_file(self) -> Path:
        """The run file in it."""
        return self.path / RUN_FILE

    def clear(self) -> None:
        """Removes what a run leaves in its folder, and nothing else."""
        for name in (RUN_FILE, *SQLITE_TRACES, MODEL, SUMMARY):
            (self.path / name).unlink(missing_ok=True)
        if (self.path / FIGURES).is_dir():
            for figure in (self.path / FIGURES).glob("*.png"):
                figure.unlink()
            with suppress(OSError):  # something of the user's is in there
                (self.path / FIGURES).rmdir()

    def discard(self) -> None:
        """Removes a run that has not begun, and the folder if it was made for it."""
        self.clear()
        if self.created:
            with suppress(OSError):
                self.path.rmdir()


def refuse_foreign(asked: Path | None, trace: str = RUN_FILE, what: str = "run") -> None:
    """Raises ValueError for a folder that is given and holds something else: not the ``trace`` that a run, or ``what`` is meant, leaves."""
    if asked is None or not asked.exists():
        return
    if not asked.is_dir():
        raise ValueError(f"-o {asked}: this is a file; name a folder")
    if any(asked.iterdir()) and not (asked / trace).is_file():
        raise ValueError(f"-o {asked}: the folder holds files that are no {what} of vfife; name another one, or one that is empty")


def numbered(first: Path) -> Iterator[Path]:
    """A name, and those with the next numbers."""
    yield first
    for number in count(2):
        yield first.with_name(f"{first.name}-{number}")


def make_folder(asked: Path | None, model: Path) -> RunFolder:
    """The folder of a run, ready for it.

    A folder that is given is made; an earlier run in it gives way. Else it is runs/<model>, or with the next free number
    where there is one already.
    """
    if asked is not None:
        refuse_foreign(asked)
        created = not asked.exists()
        asked.mkdir(parents=True, exist_ok=True)
        folder = RunFolder(asked, created)
        if folder.run_file.exists():
            folder.notes = (f"{asked} held an earlier run, which this one replaces",)
            folder.clear()
        return folder
    first = Path("runs") / model.stem
    first.parent.mkdir(parents=True, exist_ok=True)
    for path in numbered(first):
        with suppress(FileExistsError):
            path.mkdir()
            break
    notes = (f"{first} is there already and stays as it is: this run goes to {path}",) if path != first else ()
    return RunFolder(path, True, notes)


def find_run(given: Path) -> Path:
    """The run file that a folder or a file stands for; raises ValueError where there is none."""
    path = given / RUN_FILE if given.is_dir() else given
    if path.is_file():
        return path
    if given.is_dir():
        raise ValueError(f"{given}: there is no {RUN_FILE} in this folder; name the folder that `vfife run` told")
    raise ValueError(f"{given}: there is no such file or folder; name the folder that `vfife run` told")
