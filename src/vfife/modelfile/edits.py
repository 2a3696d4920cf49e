"""Changes in the text of a model file that leave comments, order and form of everything else as they are."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import Fault, ModelError, Path, shown
from .paths import assign, clear_idle, parsed
from .read import HEADER, keys_of, lines_of
from .tables import NAMED
from .write import assignments, dotted

if TYPE_CHECKING:
    from tomlkit import TOMLDocument
    from tomlkit.items import Table

BY_HAND = "change it in the text of the file"
ABSENT = object()


def edited(text: str, path: Path, written: str | None) -> str:
    """Return the text with the value at ``path`` replaced or added, or removed if ``written`` is None.

    ``written`` is read like a value of ``--set``: as TOML if possible, else as text. Keys that a new kind,
    model or law does not use are removed. Raises ModelError if the text is no TOML, if the path passes
    through a value that is no table, or if the value is in a form that cannot be changed alone. The result is
    read again and compared, so that nothing else changes.
    """
    value = "" if written is None else shown(written)
    try:
        target = tomllib.loads(text)
        _put(target, path, written)
    except (LookupError, TypeError, ValueError, RecursionError, AttributeError):
        raise ModelError([Fault(path, "there is no place for this value", value, "", BY_HAND)]) from None
    return rewritten(text, target, path, value)


def rewritten(text: str, target: dict[str, Any], path: Path = (), value: str = "") -> str:
    """Return the text with its values changed to those of ``target``; all other lines remain.

    A table of a body, joint, ... that ``target`` lacks is removed with the comment directly above it; a new
    one follows the last of its section. Raises ModelError, at ``path`` with ``value``, if the text has a form
    in which that is impossible. The result is read again and compared, so that nothing else changes.
    """
    import tomlkit

    try:
        match = with_tables(without_tables(text, target), target)
        document = tomlkit.parse(match)
        changes = list(_changes(tomllib.loads(match), target))
        for keys, new in changes:
            _change(document, keys, new)
        if changes:
            match = tomlkit.dumps(document).rstrip("\n") + "\n"
    except (LookupError, TypeError, ValueError, RecursionError, AttributeError):
        raise ModelError([Fault(path, "there is no place for this value", value, "", BY_HAND)]) from None
    if not _says(match, target):
        fault = Fault(path, "it stands in a form that cannot be changed alone", value, "", BY_HAND)
        raise ModelError([fault])
    return match


def without_tables(text: str, target: dict[str, Any]) -> str:
    """Return the text without the named tables that ``target`` lacks."""
    lines = text.splitlines(keepends=True)
    for block in reversed(blocks_of(text)):
        name = block.path[:2]
        if name[0] in NAMED and len(name) == 2 and name[1] not in target.get(str(name[0]), {}):
            end = block.end
            while end < len(lines) and not lines[end].strip():
                end += 1
            del lines[block.begin : end]
    return "".join(lines).rstrip("\r\n") + _newline(text)


def with_tables(text: str, target: dict[str, Any]) -> str:
    """Return the text with the named tables of ``target`` that it lacks."""
    raw = tomllib.loads(text)
    for section in NAMED:
        for name, table in target.get(section, {}).items():
            if isinstance(table, dict) and name not in raw.get(section, {}):
                text = _inserted(text, section, [f"[{dotted(section, name)}]", *assignments(table)])
    return text


def _inserted(text: str, section: str, table: list[str]) -> str:
    """Return the text with a table after the last of its section, or of the sections before."""
    rank: tuple[Any, ...] = ("run", "start", *NAMED)
    lines, blocks, at = text.splitlines(keepends=True), blocks_of(text), None
    for block in blocks:
        block_section = block.path[0]
        if block_section in rank and rank.index(block_section) <= rank.index(section):
            at = block.end
    at = (blocks[0].begin if blocks else len(lines)) if at is None else at
    nl = _newline(text)
    return "".join([*lines[:at], nl, *(line + nl for line in table), *lines[at:]])


def _newline(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"


class Block(NamedTuple):
    """The lines of a table, from the comment directly above its header to its last value: indices ``begin``
    and ``end`` (exclusive).
    """

    path: Path
    begin: int
    end: int


def blocks_of(text: str) -> list[Block]:
    """Return the lines of every table of a TOML text, in the order of the text."""
    lines = text.splitlines()
    headers = [
        (number - 1, path)
        for path, number in lines_of(text).items()
        if (match := HEADER.match(lines[number - 1])) and keys_of(match[1]) == path
    ]
    begins = []
    for begin, _ in headers:
        while begin and is_comment(lines[begin - 1]):
            begin -= 1
        begins.append(begin)
    blocks = []
    for (header, path), begin, behind in zip(headers, begins, [*begins[1:], len(lines)], strict=True):
        end = (
            max(
                k
                for k in range(header, behind)
                if k == header or (lines[k].strip() and not is_comment(lines[k]))
            )
            + 1
        )
        while end < behind and is_comment(lines[end]):  # directly below the last value
            end += 1
        blocks.append(Block(path, begin, end))
    return blocks


def is_comment(line: str) -> bool:
    """Return whether a line contains a comment only."""
    return line.lstrip().startswith("#")


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
    holder: Any = raw
    for part in path[:-1]:
        holder = holder[part]
    del holder[path[-1]]


def _changes(raw: Any, target: Any, at: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield the paths of values that differ with their new values; ABSENT for removed ones."""
    if isinstance(raw, dict) and isinstance(target, dict):
        for name in {**raw, **target}:
            yield from _changes(raw.get(name, ABSENT), target.get(name, ABSENT), (*at, name))
    elif isinstance(raw, list) and isinstance(target, list) and len(raw) == len(target):
        for k, (old, new) in enumerate(zip(raw, target, strict=True)):
            yield from _changes(old, new, (*at, k))
    elif type(raw) is not type(target) or raw != target:
        yield at, target


def _change(document: TOMLDocument, path: Path, value: Any) -> None:
    """Change one value in the document; a missing table is made."""
    import tomlkit
    from tomlkit.items import Table

    holder: Any = document
    for depth, key in enumerate(path[:-1]):
        if isinstance(key, str) and key not in holder:
            leaf = depth == len(path) - 2
            new_table = tomlkit.table(is_super_table=not leaf)
            if leaf:
                new_table.add(str(path[-1]), value)
                new_table.add(tomlkit.nl())
            holder[key] = new_table
            if leaf:
                return
        holder = holder[key]
    if value is ABSENT:
        del holder[path[-1]]
    elif isinstance(holder, Table) and path[-1] not in holder:
        _append(holder, str(path[-1]), value)
    else:
        holder[path[-1]] = value


def _append(table: Table, key: str, value: Any) -> None:
    """Add a key after the last one of a table, before comments that belong to the next table; a table in it
    is written on one line.
    """
    import tomlkit

    if isinstance(value, dict):
        value = tomlkit.value("{ " + ", ".join(assignments(value)) + " }")
    body, behind = table.value.body, []
    while body and body[-1][0] is None:
        behind.append(body.pop())
    table.append(key, value)
    body.extend(reversed(behind))
