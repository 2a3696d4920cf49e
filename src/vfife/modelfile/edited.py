"""A value of a model file changed where it stands: every other sign of the text stays, comments too."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import Fault, ModelError, Path, place, shown
from .paths import assign, clear_idle, parsed
from .write import dotted, key, value

KeyPath = tuple[str, ...]
BY_HAND = "change it in the text of the file"
ABSENT = object()


@dataclass(frozen=True)
class Statement:
    """Lines ``first`` up to, not with, ``end`` of a text: the header of a table (``header``), or a key with its value; ``path`` of either."""

    first: int
    end: int
    path: KeyPath
    header: bool


def edited(text: str, path: Path, written: str | None) -> str:
    """The text with the value at ``path`` replaced or added, or removed where ``written`` is None.

    ``written`` is read as a value of ``--set`` is: TOML where it is that, else the text itself. What a new kind, model or law has no use for is
    dropped. Raises ModelError where the text is no TOML, the path leads through a value that is no table, or the value stands in a form that cannot
    be changed alone; what comes out is read again and compared, so that nothing else changes.
    """
    try:
        raw = tomllib.loads(text)
        wanted = copy.deepcopy(raw)
        _put(wanted, path, written)
        lines = text.splitlines()
        for where, there in _changes(raw, wanted):
            lines = _with(lines, where, there, wanted)
    except (LookupError, TypeError, ValueError, RecursionError):
        raise _refused(path, written, "there is no place for this value") from None
    found = "\n".join(lines) + "\n"
    if _read(found) != wanted:
        raise _refused(path, written, "it stands in a form that cannot be changed alone")
    return found


def _refused(path: Path, written: str | None, what: str) -> ModelError:
    return ModelError([Fault(place(path), what, "" if written is None else shown(written), "", BY_HAND)])


def _read(text: str) -> Any:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError):
        return None


def _put(raw: dict[str, Any], path: Path, written: str | None) -> None:
    if written is not None:
        assign(raw, path, parsed(written))
        clear_idle(raw, path, {path})
        return
    here: Any = raw
    for part in path[:-1]:
        here = here[part]
    del here[path[-1]]


def _changes(raw: Any, wanted: Any, at: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """Paths whose values differ, and what they shall be; ABSENT for what goes away."""
    for name in {**raw, **wanted}:
        one, other = raw.get(name, ABSENT), wanted.get(name, ABSENT)
        if isinstance(one, dict) and isinstance(other, dict):
            yield from _changes(one, other, (*at, name))
        elif isinstance(other, dict) and one is ABSENT and other:
            yield from _changes({}, other, (*at, name))
        elif one is ABSENT or other is ABSENT or type(one) is not type(other) or one != other:
            yield (*at, name), other


def statements(lines: list[str]) -> Iterator[Statement]:
    """Headers and assignments, each over as many lines as it takes to be whole."""
    header: KeyPath | None = ()
    first = 0
    while first < len(lines):
        end = first + 1
        while end < len(lines) and _read("\n".join(lines[first:end])) is None:
            end += 1
        line = lines[first].strip()
        if line.startswith("["):
            header = None if line.startswith("[[") else _chain("\n".join(lines[first:end]))
            if header is not None:
                yield Statement(first, end, header, True)
        elif line and not line.startswith("#") and header is not None:
            yield Statement(first, end, (*header, *_chain(_key_of(line) + "= 0")), False)
        first = end


def _chain(text: str) -> KeyPath:
    """The names that a header, or a key, is made of."""
    found: list[str] = []
    here: Any = _read(text)
    while isinstance(here, dict) and here:
        ((name, here),) = here.items()
        found.append(name)
    return tuple(found)


def _key_of(line: str) -> str:
    """What stands before the sign of equality that is in no quotes."""
    for at, sign in enumerate(line):
        if sign == "=" and _read(line[:at] + "= 0") is not None:
            return line[:at]
    return line


def _with(lines: list[str], path: KeyPath, there: Any, wanted: Mapping[str, Any]) -> list[str]:
    """The lines with one value changed."""
    known = list(statements(lines))
    for one in known:
        if not one.header and path[: len(one.path)] == one.path:
            if there is ABSENT and one.path == path:
                return lines[: one.first] + lines[one.end :]
            here: Any = wanted
            for name in one.path:
                here = here[name]
            return lines[: one.first] + [_rewritten(lines[one.first : one.end], here)] + lines[one.end :]
    if there is ABSENT:
        return lines
    return _added(lines, known, path, there)


def _rewritten(old: list[str], there: Any) -> str:
    """An assignment with another value; a comment behind it stays."""
    name, last = _key_of(old[0]), old[-1]
    whole = _read("\n".join(old))
    marks = (at for at, sign in enumerate(last) if sign == "#")
    cut = next((at for at in marks if _read("\n".join([*old[:-1], last[:at]])) == whole), len(last))
    comment = f"  {last[cut:]}" if cut < len(last) else ""
    return f"{name.rstrip()} = {inline(there)}{comment}"


def _added(lines: list[str], known: list[Statement], path: KeyPath, there: Any) -> list[str]:
    """An assignment more, at the end of the nearest table above it that has a header, or of what stands before all tables."""
    headers = [one for one in known if one.header and one.path == path[: len(one.path)]]
    above = max(headers, key=lambda one: len(one.path), default=None)
    depth = 0 if above is None else len(above.path)
    if depth < min(len(path) - 1, 2) and len(path) > 1:  # a table of its own
        return [*lines, "", f"[{dotted(*path[:-1])}]", f"{key(path[-1])} = {inline(there)}"]
    first = 0 if above is None else above.end
    ends = [first]
    for one in known:
        if one.first >= first:
            if one.header:
                break
            ends.append(one.end)
    return [*lines[: ends[-1]], f"{dotted(*path[depth:])} = {inline(there)}", *lines[ends[-1] :]]


def inline(entry: Any) -> str:
    """A value in one line, tables too."""
    if isinstance(entry, dict):
        return "{ " + ", ".join(f"{key(name)} = {inline(one)}" for name, one in entry.items()) + " }" if entry else "{}"
    if isinstance(entry, list):
        return "[" + ", ".join(inline(one) for one in entry) + "]"
    return value(entry)
