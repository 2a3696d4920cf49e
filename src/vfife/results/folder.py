"""Where a run is kept: a folder of its own, never one that holds something else; what in it is ours, and what is not."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from itertools import count
from pathlib import Path

from ..errors import RunFileError
from ..files import read_bytes
from .lock import LOCK, holder
from .schemas import RUN_FILE, is_run_file

MODEL, SUMMARY, FIGURES = "model.toml", "summary.json", "figures"
SQLITE_TRACES = tuple(f"{RUN_FILE}{end}" for end in ("-wal", "-shm", "-journal"))
SUMMARY_KEYS = {"status", "step", "steps", "measures"}
FIGURE_NAMES = ("mechanism", "orbits", "guides", "forces", "moments", "accelerations")  # that a run draws with --figures
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
    """Raises ValueError for a folder that is given and holds something else: not the ``trace`` that a run, or ``what`` is meant, leaves."""
    if asked is None or not asked.exists():
        return
    if not asked.is_dir():
        raise ValueError(f"-o {asked}: this is a file; name a folder")
    own = is_run_file(asked / trace) if trace == RUN_FILE else (asked / trace).is_file()
    if entries(asked) and not own:
        raise ValueError(f"-o {asked}: the folder holds files that are no {what} of vfife; name another one, or one that is empty")


def own_files(folder: Path, model: str | None) -> list[Path]:
    """Files in a run folder that a run left there, as their content tells; ``model`` is the text that its run file has."""
    found = [path for path in (folder / RUN_FILE, folder / MODEL, folder / SUMMARY) if path.is_file() and is_own(path, model)]
    if folder / RUN_FILE in found:
        found += [folder / name for name in SQLITE_TRACES if (folder / name).is_file()]
    return found + [path for path in sorted((folder / FIGURES).glob("*")) if path.suffix in PICTURES and is_own(path, model)]


def in_the_way(folder: Path, model: str | None) -> list[Path]:
    """Files that a run would write and that are not ours."""
    names = [RUN_FILE, *SQLITE_TRACES, MODEL, SUMMARY, *(f"{FIGURES}/{name}.png" for name in FIGURE_NAMES)]
    own = set(own_files(folder, model))
    return [folder / name for name in names if (folder / name).exists() and folder / name not in own]


def is_own(path: Path, model: str | None) -> bool:
    """Whether a run wrote a file: the run file by its header, the model by its text, a summary by its keys, a figure by its head."""
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


def find_run(given: Path) -> Path:
    """The run file that a folder or a file stands for; raises ValueError where there is none."""
    path = given / RUN_FILE if given.is_dir() else given
    if path.is_file():
        return path
    if given.is_dir():
        raise ValueError(f"{given}: there is no {RUN_FILE} in this folder; name the folder that `vfife run` told")
    raise ValueError(f"{given}: there is no such file or folder; name the folder that `vfife run` told")
