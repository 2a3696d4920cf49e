"""Output files of a command: where they may be written, and how."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..files import read_bytes
from ..job.activity import ACTIVITY
from ..methods import attach
from ..store.folder import is_own
from .terminal import writing

if TYPE_CHECKING:
    from ..store.schemas import Schema

PICTURES = (".png", ".svg", ".pdf")  # endings of figures, as plots has them; a test compares
TABLES = (".csv", ".xlsx")  # endings of tables
ENDINGS = {"--figure": PICTURES, "--csv": TABLES, "--fitted": (".toml",), "--worn": (".toml",)}
RUNS = Path("runs")  # the folder of files that have no other place; a job makes it
DECIMAL = "Decimal sign in .csv; with comma the values are separated by semicolons."
LARGEST_MODEL = 8_000_000  # bytes of a model in which names of CSV files are looked for


def refuse_inputs(targets: Iterable[tuple[str, Path | None]], inputs: Iterable[Path | None]) -> None:
    """Raise ValueError with all targets (option and file) that are folders or would replace an input or each
    other.

    Inputs are the files named on the command line and the CSV files that models among them name.
    """
    read = [path for file in inputs if file is not None for path in (file, *tables_of(file))]
    refusals: list[str] = []
    targets_so_far: list[tuple[str, Path]] = []
    for option, path in targets:
        if path is None:
            continue
        if path.is_dir():
            refusals.append(f"{option} {path}: this is a folder; name a file")
        elif any(same_file(path, input_path) for input_path in read):
            refusals.append(
                f"{option} {path}: this file is an input and would be overwritten; name another file"
            )
        elif (
            clash := next((word for word, target in targets_so_far if same_file(path, target)), None)
        ) is not None:
            refusals.append(f"{option} {path}: {clash} is written there too; name another file")
        targets_so_far.append((option, path))
    if refusals:
        raise ValueError("; ".join(refusals))


def same_file(path: Path, other_path: Path) -> bool:
    """Return whether two names, also through links, are of one file."""
    try:
        return path.samefile(other_path)
    except (OSError, ValueError):
        return path.absolute() == other_path.absolute()


def tables_of(model: Path) -> list[Path]:
    """Return the CSV files that a model names, as far as it can be read."""
    try:
        if model.suffix.lower() != ".toml" or model.stat().st_size > LARGEST_MODEL:
            return []
        raw = tomllib.loads(read_bytes(model).decode("utf-8"))
        return [model.parent / text for text in texts(raw) if text.lower().endswith(".csv")]
    except (OSError, ValueError, RecursionError):  # reported when the model is read
        return []


def texts(value: Any) -> Iterator[str]:
    """Yield all texts in a table of TOML."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from texts(entry)


def refuse_files(
    files: Sequence[tuple[str, Path | None]], inputs: Iterable[Path | None], folder: Path | None = None
) -> None:
    """Raise ValueError for output files (option and path) with another extension than their option has, in a
    folder that does not exist, or for which :func:`refuse_inputs` raises; ``folder`` will exist.
    """
    for option, path in files:
        endings = ENDINGS.get(option)
        if path is None or endings is None:
            continue
        if path.suffix.lower() not in endings:
            raise ValueError(f"{option} {path}: name a file ending in {' or '.join(endings)}")
        if folder is None or path.absolute().parent != folder.absolute():
            refuse_folder(option, path)
    refuse_inputs(files, inputs)


def refuse_ending(target: Path, endings: Sequence[str]) -> None:
    """Raise ValueError if the extension of a file is none of these."""
    if target.suffix.lower() not in endings:
        endings_text = f"{', '.join(endings[:-1])} and {endings[-1]}"
        raise ValueError(
            f'"{target.suffix or target.name}" is not a format of this file; name a file such as'
            f" {target.stem}{endings[0]}: there are {endings_text}"
        )


def one_target(argument: Path | None, option: Path | None) -> Path:
    """Return the file that is named once, as an argument or with ``-o``. Raises ValueError."""
    if (target := argument or option) is None or (argument and option):
        raise ValueError("name one file to write, as in -o out.csv")
    return target


def refuse_existing(target: Path, force: bool) -> None:
    """Raise ValueError if a file cannot be written, or would replace another one without ``force``."""
    if target.is_dir():
        raise ValueError(f"this is a folder; name a file, such as out{target.suffix}")
    if target.exists() and not force:
        raise ValueError("this file exists; choose another name, or add --force to replace it")
    refuse_folder("", target)


def refuse_folder(option: str, target: Path) -> None:
    """Raise ValueError if the folder of a file does not exist."""
    if not (folder := target.absolute().parent).is_dir():
        raise ValueError(
            f"{option} {target}: there is no folder {folder}; make it first"
            if option
            else f"there is no folder {folder}; make it first"
        )


def answer_file(schema: Schema, target: Path | None, source: Path, kind: str = "", ending: str = "") -> Path:
    """Return the file of an answer of a ``kind``: the ``target``, else a file in runs/ named after the
    ``source``, with its ``ending``. Raises ValueError for one that cannot be, or that is something else.
    """
    kind = kind or schema.kind
    place = target if target is not None else RUNS / f"{source.stem}{ending or f'.{kind}'}"
    if place.is_dir() or place.suffix.lower() in (*PICTURES, *TABLES):
        raise ValueError(
            f"-o {place}: a {kind} file is kept here; name a file with another ending, as in"
            f" {place.stem or 'model'}.{kind}"
        )
    refuse_inputs([("-o", place)], [source])
    if place.exists() and not schema.owns(place):
        raise ValueError(
            f"-o {place}: a file or folder of this name exists that is not a {kind} file; choose another name"
        )
    if target is not None:
        refuse_folder("-o", place)
    return place


def own_figure(place: Path, kind: str) -> Path:
    """Return the path of the figure beside a file of a ``kind``. Raises ValueError for a picture of another
    program there.
    """
    # A model has files of several kinds.
    path = place.with_suffix(".png") if kind == "map" else place.with_name(f"{place.stem}-{kind}.png")
    if path.is_file() and not is_own(path, None):
        raise ValueError(
            f"{path}: this picture is not one of vfife and would be overwritten; name another file with"
            " --figure"
        )
    return path


def write_files(
    result: Any,
    figure: Path | None,
    csv: Path | None,
    draw: Callable[[], Any] | None = None,
    decimal: str = "point",
) -> None:
    """Draw a result and write its table, if a path is given for them; ``draw`` returns another figure than
    :meth:`plot`; ``decimal`` as in :func:`~vfife.files.write_rows`.
    """
    if figure is not None:
        with writing(str(figure)):
            from ..plots.style import saved

            ACTIVITY(f"drawing {figure}")
            attach()
            saved((draw or result.plot)(), figure)
    if csv is not None:
        with writing(str(csv)):
            ACTIVITY(f"writing {csv}")
            result.write_table(csv, **({} if decimal == "point" else {"decimal": decimal}))
