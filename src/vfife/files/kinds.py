"""Kinds of files that a user may confuse: how each is recognised, and what to do with it."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import Fault, ModelError
from . import open_regular

RUN_FILE = "run.sqlite"  # its name in a run folder
SQLITE = b"SQLite format 3\0"
MARK = slice(68, 72)  # bytes of its header with the application that wrote it
# Number in the header of each kind of file that vfife writes.
APPLICATIONS = {
    "run": 0x56464946,  # "VFIF"
    "study": 0x56465354,  # "VFST"
    "map": 0x56464D50,  # "VFMP"
    "wear": 0x56465752,  # "VFWR"
    "fit": 0x56464654,  # "VFFT"
}
LARGEST_TEXT = 1_000_000  # bytes up to which the tables of a text are looked at


class Kind(NamedTuple):
    """A kind of file: what a user calls it, what to do with one, and top-level keys that only it has."""

    name: str
    advice: str
    keys: tuple[str, ...] = ()


KINDS = {
    "model": Kind(
        "a model",
        "run it with vfife run {file}",
        ("body", "joint", "ground", "driver", "load", "spring", "gear"),
    ),
    "study file": Kind(
        "a study",
        "run it with vfife study {file}",
        ("vary", "point", "measures", "allocation", "optimise", "cost", "limit"),
    ),
    "fit plan": Kind("a fit plan", "run it with vfife fit {file}", ("record", "parameters")),
    "run": Kind(
        "a run",
        "show it with vfife info {file}, read it in Python with vfife.load_result, or name its model.toml",
    ),
    "study": Kind("the results of a study", "show them with vfife study show {file}"),
    "map": Kind("a map", "show it with vfife map show {file}"),
    "wear": Kind("the results of vfife wear", "show them with vfife wear {file}"),
    "fit": Kind("the results of a fit", "show them with vfife fit {file}"),
    "table": Kind("a table of values", "fit a model to it with vfife fit MODEL.toml {file} -p PATH=A..B"),
    "python": Kind("a Python file", "give laws of your own with --laws {file}"),
    "folder": Kind("a folder", "name a file"),
    "empty": Kind("empty", "name another file"),
    "database": Kind("a database of another program", "name another file"),
    "binary": Kind("a binary file", "name another file"),
}
ADVICE = {  # for a kind where another was expected, if it differs from that of the kind
    ("empty", "model"): "vfife new NAME -o FILE writes a model to start from",
    ("empty", "table"): 'begin it with a line such as "time (s), C.force (N)"',
    ("folder", "run"): f"name a folder with a {RUN_FILE} of a run",
}
ENDINGS = {".csv": "table", ".py": "python"}


class FileKindError(ModelError):
    """A file of another kind than expected: which kind it is and what to do with it."""

    def __init__(self, path: str | Path, kind: str, expected: str, key: str = "") -> None:
        name, advice, _ = KINDS[kind]
        evidence = f" (it has {key})" if key else ""
        advice = ADVICE.get((kind, expected), advice).format(file=path)
        description = f"{name}{evidence}, not {KINDS[expected].name}"
        super().__init__(
            [Fault("file", f"this is {description}", "", KINDS[expected].name, advice)], str(path)
        )
        self.args = (f"{path} is {description}; {advice}",)


def kind_of_data(path: Path, data: bytes) -> str:
    """Return the kind of a file by its name or the first bytes of its content; "" for any other."""
    if data.startswith(SQLITE):
        mark = int.from_bytes(data[MARK], "big")
        return next((kind for kind, number in APPLICATIONS.items() if number == mark), "database")
    utf_16 = data.startswith((b"\xff\xfe", b"\xfe\xff"))  # a text that has to be saved as UTF-8
    if b"\0" in data[:LARGEST_TEXT] and not utf_16:
        return "binary"
    return "empty" if not data.strip() else ENDINGS.get(path.suffix.lower(), "")


def refuse_data(path: str | Path, data: bytes, expected: str) -> None:
    """Raise FileKindError if content is of a kind that is not ``expected``, a key of :data:`KINDS`."""
    kind = kind_of_data(Path(path), data)
    if kind and kind != expected:
        raise FileKindError(path, kind, expected)


def refuse_tables(path: str | Path, raw: Mapping[str, Any], expected: str) -> None:
    """Raise FileKindError if the tables of a TOML file are those of a kind that is not ``expected``."""
    if not any(key in raw for key in KINDS[expected].keys):
        for kind, (_, _, keys) in KINDS.items():
            if key := next((key for key in keys if key in raw), ""):
                listed = isinstance(raw[key], list) and all(isinstance(entry, dict) for entry in raw[key])
                evidence = f"the table [{key}]" if isinstance(raw[key], dict) or listed else f"the key {key}"
                raise FileKindError(path, kind, expected, evidence)


def refuse_kind(path: str | Path, expected: str) -> None:
    """Raise FileKindError if a file, or a folder, is of a kind that is not ``expected``."""
    path = Path(path)
    if path.is_dir():
        kind = "run" if (path / RUN_FILE).exists() else "folder"
        if kind != expected:
            raise FileKindError(path, kind, expected)
        return
    try:
        with open_regular(path) as stream:
            data = stream.read(LARGEST_TEXT)
    except OSError:  # reported when it is read
        return
    refuse_data(path, data, expected)
    try:
        raw = tomllib.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError):
        return
    refuse_tables(path, raw, expected)
