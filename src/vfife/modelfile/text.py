"""The text of a model file: line numbers of its keys.

The parser of the standard library reports no positions, and tomlkit takes a hundred times as long to parse a
file. But TOML is a format of lines: outside multi-line strings and brackets, a line is a header, a key with
its value, or neither.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from typing import Any

from ..errors import Fault, Path

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
