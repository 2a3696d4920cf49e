"""The text of a model file: line numbers of keys, and values changed in place without touching anything else.

The parser of the standard library reports no positions, and tomlkit takes a hundred times as long to parse a
file. But TOML is a format of lines: outside multi-line strings and brackets, a line is a header, a key with
its value, or neither.
"""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from ..errors import Fault, ModelError, Path, shown
from .paths import assign, clear_idle, parsed

if TYPE_CHECKING:
    from tomlkit import TOMLDocument
    from tomlkit.items import Table

BY_HAND = "change it in the text of the file"
ABSENT = object()
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
    here: Any = tomllib.loads(f"{text} = 0")
    keys = list[str]()
    while isinstance(here, dict):
        ((key, here),) = here.items()
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


# ---------------------------------------------------------------------------------------------------- edits


def edited(text: str, path: Path, written: str | None) -> str:
    """Return the text with the value at ``path`` replaced or added, or removed if ``written`` is None.

    ``written`` is read like a value of ``--set``: as TOML if possible, else as text. Keys that a new kind,
    model or law does not use are removed. Raises ModelError if the text is no TOML, if the path passes
    through a value that is no table, or if the value is in a form that cannot be changed alone. The result is
    read again and compared, so that nothing else changes.
    """
    import tomlkit

    shown_value = "" if written is None else shown(written)
    try:
        raw = tomllib.loads(text)
        target = copy.deepcopy(raw)
        _put(target, path, written)
        document = tomlkit.parse(text)
        for keys, value in _changes(raw, target):
            _change(document, keys, value)
        match = tomlkit.dumps(document).rstrip("\n") + "\n"
    except (LookupError, TypeError, ValueError, RecursionError, AttributeError):
        raise ModelError(
            [Fault(path, "there is no place for this value", shown_value, "", BY_HAND)]
        ) from None
    if not _says(match, target):
        raise ModelError(
            [Fault(path, "it stands in a form that cannot be changed alone", shown_value, "", BY_HAND)]
        )
    return match


def _says(text: str, target: Any) -> bool:
    """Return whether a text contains exactly these tables."""
    try:
        return bool(tomllib.loads(text) == target)
    except (ValueError, RecursionError):
        return False


def _put(raw: dict[str, Any], path: Path, written: str | None) -> None:
    """Change the value in the tables, as it is to be read from the text."""
    if written is not None:
        assign(raw, path, parsed(written))
        clear_idle(raw, path, {path})
        return
    here: Any = raw
    for part in path[:-1]:
        here = here[part]
    del here[path[-1]]


def _changes(raw: Any, target: Any, at: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield the paths of values that differ with their new values; ABSENT for removed ones."""
    if isinstance(raw, dict) and isinstance(target, dict):
        for name in {**raw, **target}:
            yield from _changes(raw.get(name, ABSENT), target.get(name, ABSENT), (*at, name))
    elif isinstance(raw, list) and isinstance(target, list) and len(raw) == len(target):
        for k, (one, other) in enumerate(zip(raw, target, strict=True)):
            yield from _changes(one, other, (*at, k))
    elif type(raw) is not type(target) or raw != target:
        yield at, target


def _change(document: TOMLDocument, path: Path, value: Any) -> None:
    """Change one value in the document; a missing table is made."""
    import tomlkit
    from tomlkit.items import Table

    here: Any = document
    for depth, key in enumerate(path[:-1]):
        if isinstance(key, str) and key not in here:
            leaf = depth == len(path) - 2
            new_table = tomlkit.table(is_super_table=not leaf)
            if leaf:
                new_table.add(str(path[-1]), value)
                new_table.add(tomlkit.nl())
            here[key] = new_table
            if leaf:
                return
        here = here[key]
    if value is ABSENT:
        del here[path[-1]]
    elif isinstance(here, Table) and path[-1] not in here:
        _append(here, str(path[-1]), value)
    else:
        here[path[-1]] = value


def _append(table: Table, key: str, value: Any) -> None:
    """Add a key after the last one of a table, before comments that belong to the next table."""
    body, behind = table.value.body, []
    while body and body[-1][0] is None:
        behind.append(body.pop())
    table.append(key, value)
    body.extend(reversed(behind))
