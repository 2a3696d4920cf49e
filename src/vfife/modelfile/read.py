"""TOML text -> mechanism: values set by path, keys read by the fields, checks across objects; all faults at
once, with their lines.

The parser of the standard library reports no positions, and tomlkit takes a hundred times as long to parse a
file. But TOML is a format of lines: outside multi-line strings and brackets, a line is a header, a key with
its value, or neither.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

from ..errors import Fault, ModelError, Path, place, shown, value_fault
from ..files import read_bytes
from ..files.kinds import refuse_data, refuse_kind, refuse_tables
from ..model.mechanism import Mechanism
from ..model.validation import Checks, check_laws, conflict_faults
from ..model.validation.settings import check_name
from ..options import with_faults
from .csvtables import expand
from .paths import override
from .reader import Written
from .tables import Raw, table

# What opens or closes something that may go on in the next line; strings and comments in one line are stepped
# over as a whole.
MARK = re.compile(r'"""|\'\'\'|"(?:[^"\\]|\\.)*"|\'[^\']*\'|#.*|[\[\]{}]')
PART = r'(?:[A-Za-z0-9_-]+|"(?:[^"\\]|\\.)*"|\'[^\']*\')'
HEADER = re.compile(rf"\s*\[\s*({PART}(?:\s*\.\s*{PART})*)\s*\]")
KEY = re.compile(rf"\s*({PART}(?:\s*\.\s*{PART})*)\s*=")


def lines_of(text: str) -> dict[Path, int]:
    """Return the line number, from 1, of each header and key of a TOML text, by path."""
    lines: dict[Path, int] = {}
    table: Path = ()
    quote, depth = "", 0  # the string and the brackets that are open at the beginning of a line
    for number, line in enumerate(text.splitlines(), 1):
        if not quote and not depth:
            if match := HEADER.match(line):
                table = keys_of(match[1])
                lines.setdefault(table, number)
            elif match := KEY.match(line):
                lines.setdefault((*table, *keys_of(match[1])), number)
        at = 0
        while mark := (re.compile(quote) if quote else MARK).search(line, at):
            at, sign = mark.end(), mark[0]
            if sign in ('"""', "'''"):
                quote = "" if quote else sign
            elif sign in "[{":
                depth += 1
            elif sign in "]}":
                depth -= 1
    return lines


def keys_of(text: str) -> Path:
    """Return the keys of a dotted key."""
    nested: Any = tomllib.loads(f"{text} = 0")
    keys = list[str]()
    while isinstance(nested, dict):
        ((key, nested),) = nested.items()
        keys.append(key)
    return tuple(keys)


def line_at(lines: dict[Path, int], path: Path) -> int | None:
    """Return the line of a value or, if the file leaves it out, of its table."""
    return next((lines[path[:depth]] for depth in range(len(path), 0, -1) if path[:depth] in lines), None)


def locate(faults: Iterable[Fault], text: str, paths_set: Iterable[Path]) -> None:
    """Add line numbers to faults, except to those of values that do not stand in the text."""
    lines = lines_of(text)
    for fault in faults:
        if fault.path and not any(fault.path[: len(path)] == path for path in paths_set):
            fault.line = line_at(lines, fault.path)


Items = Iterable[tuple[str, Any]]


@with_faults()
def load(path: str | FilePath, overrides: Mapping[str, Any] | None = None, *, set: Items = ()) -> Mechanism:
    """Return the mechanism of a model file, with some of its values replaced or added before validation.

    >>> m = load("machine.toml", {"joint.C.clearance": "0.5 mm", "run.turns": 3})  # doctest: +SKIP

    ``overrides``: values by path, as ``vfife run --set`` accepts them; ``set``: the same as pairs.
    "joint.coupler-follower" is the joint that connects the two bodies. A text is read as TOML if possible,
    else as text. If a ``model``, ``kind`` or ``law`` is set, keys of the file that the new one does not use
    are dropped. Raises ModelError with all faults of the file and the values.
    """
    if not isinstance(path, str | os.PathLike):
        raise ModelError([value_fault(path, "the name of a model file", "name one").at("path")], "load()")
    values: Any = {} if overrides is None else overrides
    if not isinstance(values, Mapping) or not all(isinstance(key, str) for key in values):
        fault = value_fault(values, "values by path", 'give them as in {"joint.C.clearance": "0.5 mm"}')
        raise ModelError([fault.at("overrides")], "load()")
    pairs, text = [*values.items(), *pairs_of(set)], text_of(path)
    return of_tables(raw_of(text, str(path), "model"), pairs, str(path), text)


@with_faults()
def load_model(path: str | FilePath, set: Items = ()) -> Mechanism:
    """Return the mechanism of a model file; :func:`load` also takes values by path as a mapping.

    ``set`` has (path, value) pairs that replace or add values before validation, as in ("joint.C.clearance",
    "0.5 mm"). Raises ModelError with all faults of the file.
    """
    return load(path, set=set)


def text_of(path: str | FilePath, expected: str = "model") -> str:
    """Return the text of a file. Raises ModelError where it cannot be read, or is not of the kind
    ``expected``.
    """
    try:
        data = read_bytes(path)
        refuse_data(path, data, expected)
        return data.decode("utf-8-sig")
    except OSError as error:
        refuse_kind(path, expected)
        remedy = "check the name" if isinstance(error, FileNotFoundError) else "name a file that can be read"
        raise ModelError(
            [Fault("file", f"it cannot be read ({error.strerror})", remedy=remedy)], str(path)
        ) from None
    except UnicodeDecodeError as error:
        fault = Fault(f"byte {error.start}", "the text is not UTF-8", remedy="save the file in this encoding")
        raise ModelError([fault], str(path)) from None


def raw_of(text: str, file: str, expected: str = "") -> Raw:
    """Return the tables of a text. Raises ModelError where it is no TOML, or has the tables of a kind of file
    that is not ``expected``.
    """
    try:
        raw = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ModelError([syntax_fault(text, error)], file) from None
    if expected:
        refuse_tables(file, raw, expected)
    return raw


def loads(text: str, set: Items = (), *, file: str | None = None) -> Mechanism:
    """Return the mechanism of a model file's text; ``file`` names it in messages. See :func:`load`."""
    return of_tables(raw_of(text, file or "model"), set, file, text)


def pairs_of(items: Any) -> list[tuple[str, Any]]:
    """Return values by path as pairs. Raises ModelError for anything else, also for a mapping."""
    pairs: list[Any] = list(items) if isinstance(items, Iterable) else [None]
    if isinstance(items, str | bytes | Mapping) or not all(map(is_pair, pairs)):
        remedy = 'give them as in [("joint.C.clearance", "0.5 mm")], or use load(path, {...})'
        raise ModelError([value_fault(items, "pairs of a path and a value", remedy).at("set")], "load()")
    return pairs


def is_pair(item: Any) -> bool:
    """Return whether an item is a pair of a path and a value."""
    return isinstance(item, tuple | list) and len(item) == 2 and isinstance(item[0], str)


def of_tables(raw: Raw, set: Items = (), file: str | None = None, text: str = "") -> Mechanism:
    """Return the mechanism of a model file's tables, in which the values of ``set`` are put; faults have
    their lines in the ``text``. See :func:`load`.
    """
    faults, paths_set = override(raw, pairs_of(set))
    broken = expand(raw, file)
    reader = Written(raw, paths_set)
    mechanism = reader.mechanism()
    faults += reader.faults
    faults += cross_faults(mechanism, reader)
    if broken:  # what else is said of their tables comes of the numbers that are missing
        paths = [path for fault in broken for path in ((*fault.path[:2], ""), fault.path)]
        tables = tuple(map(place, paths))
        faults = [fault for fault in faults if not fault.where.startswith(tables)]
        faults += [fault.at(fault.path, paths_set) for fault in broken]
    faults = faults or check_laws(mechanism)
    if faults:
        locate(faults, text, paths_set)
        raise ModelError(faults, file or "model")
    return replace(mechanism, source=file)


def cross_faults(mechanism: Mechanism, reader: Written) -> list[Fault]:
    """Return the faults that no table shows alone, with values as they are written."""
    raw, paths_set = reader.raw, reader.given
    faulty_paths = [fault.path for fault in reader.faults]
    checks = Checks(mechanism, faulty_paths, paths_set, lambda path: written(raw, path))
    for name in table(raw, "material"):
        check_name(checks, ("material", name))
    return conflict_faults(checks)


def written(raw: Raw, path: Path) -> str:
    """Return the value at a path as it is written, nothing where there is none."""
    holder = table(raw, *path[:-1])
    return shown(holder[str(path[-1])]) if path[-1] in holder else ""


def syntax_fault(text: str, error: Exception) -> Fault:
    """Return the line and column of a fault in the TOML itself, with the line."""
    if isinstance(error, RecursionError):
        return Fault(
            "file",
            "lists or tables are nested too deeply",
            remedy="a model needs no more than lists of numbers",
        )
    message, _, position = str(error).partition(" (at ")
    problem, location = f"this is not valid TOML: {message}", position.rstrip(")") or "file"
    if location == "end of document":
        location = f"line {text.count(chr(10)) + 1}, column {len(text) - text.rfind(chr(10))} (the end)"
    if match := re.match(r"line (\d+), column (\d+)", location):
        line = text.splitlines()[int(match[1]) - 1 : int(match[1])]
        problem += f", in {shown(line[0].strip())}" if line else ""
    remedy = "put texts and quantities with units in quotes, and close every quote and bracket"
    if "overwrite" in message or "twice" in message:
        remedy = "give each key and each table once"
    elif "digits" in message:
        problem, remedy = "this is not valid TOML: a number of thousands of digits", "shorten it"
    return Fault(location, problem, remedy=remedy)
