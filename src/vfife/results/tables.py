"""The tables of a run file, each row sealed; what damage and a full disk are told as."""

from __future__ import annotations

import json
import shutil
import sqlite3
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from datetime import UTC, datetime
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from ..errors import RunFileError, StorageError
from .packing import seal

# Of each table its columns but the seal, which is the last; the first is the key.
COLUMNS = {
    "meta": ("key TEXT PRIMARY KEY", "json TEXT NOT NULL"),
    "arrays": ("key TEXT PRIMARY KEY", "data BLOB NOT NULL"),
    "copies": ("key TEXT PRIMARY KEY", "data BLOB NOT NULL"),
    "history": ("chunk INTEGER PRIMARY KEY", "first INTEGER NOT NULL", "outputs INTEGER NOT NULL", "steps BLOB NOT NULL", "data BLOB NOT NULL"),
    "checkpoints": ("step INTEGER PRIMARY KEY", "chunks INTEGER NOT NULL", "outputs INTEGER NOT NULL", "more TEXT NOT NULL", "state BLOB NOT NULL"),
    "events": ("number INTEGER PRIMARY KEY", "step INTEGER NOT NULL", "time TEXT NOT NULL", "text TEXT NOT NULL"),
    "reference": ("part TEXT PRIMARY KEY", "data BLOB NOT NULL"),
    "companions": (
        "first INTEGER PRIMARY KEY", "outputs INTEGER NOT NULL", "last INTEGER NOT NULL", "told TEXT NOT NULL", "steps BLOB NOT NULL",
        "data BLOB NOT NULL",
    ),
    "turns": ("turn INTEGER PRIMARY KEY", "last INTEGER NOT NULL", "data BLOB NOT NULL"),
}  # fmt: skip
# The same of a study file.
STUDY = {
    "meta": COLUMNS["meta"],
    "members": ("number INTEGER PRIMARY KEY", "hash TEXT NOT NULL", "numbers TEXT NOT NULL"),
    "outcomes": (
        "number INTEGER PRIMARY KEY", "hash TEXT NOT NULL", "status TEXT NOT NULL", "reason TEXT NOT NULL", "turns INTEGER NOT NULL",
        "settled INTEGER NOT NULL", "steps INTEGER NOT NULL", "step REAL NOT NULL", "measures TEXT NOT NULL",
    ),
}  # fmt: skip
STUDY["repeats"] = STUDY["outcomes"]  # of a sample of members, with another step
# The same of a map file: at each value of a number the points of all chains, and the state to go on from; what is told beside it in arrays.
MAP = {
    "meta": COLUMNS["meta"],
    "arrays": COLUMNS["arrays"],
    "legs": ("number INTEGER PRIMARY KEY", "points BLOB NOT NULL", "growth BLOB NOT NULL", "state BLOB NOT NULL"),
}
# The same of a wear file: after each number of turns what is told of it, depths around all surfaces and their rates, and the state to go on from.
WEAR = {
    "meta": COLUMNS["meta"],
    "points": ("number INTEGER PRIMARY KEY", "told TEXT NOT NULL", "depth BLOB NOT NULL", "rate BLOB NOT NULL", "state BLOB NOT NULL"),
}
# The same of a fit file: what each point that was looked at told, by the hash of the question, and what was found in the end.
FIT = {
    "meta": COLUMNS["meta"],
    "looks": ("key TEXT PRIMARY KEY", "told TEXT NOT NULL", "data BLOB NOT NULL"),
    "found": ("key TEXT PRIMARY KEY", "told TEXT NOT NULL", "data BLOB NOT NULL"),
}
SCHEMA, STUDY_SCHEMA, MAP_SCHEMA, WEAR_SCHEMA, FIT_SCHEMA = (
    [f"CREATE TABLE IF NOT EXISTS {table} ({', '.join(columns)}, seal BLOB NOT NULL)" for table, columns in one.items()]
    for one in (COLUMNS, STUDY, MAP, WEAR, FIT)
)
KEYS = {table: columns[0].split()[0] for table, columns in (FIT | WEAR | MAP | STUDY | COLUMNS).items()}
STORAGE = ("full", "disk i/o", "unable to open", "readonly", "read-only", "permission", "locked", "too big")  # in what SQLite says

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")


def has(connection: sqlite3.Connection, table: str) -> bool:
    """Whether a file has a table: one that was written before there was any lacks it."""
    return connection.execute("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?", (table,)).fetchone() is not None


def complete(connection: sqlite3.Connection) -> None:
    """Makes the tables that a file written before there were any lacks."""
    for statement in SCHEMA:
        connection.execute(statement)


def insert(connection: sqlite3.Connection, table: str, *values: Any) -> int:
    """Writes a row with its seal, in the place of one with its key; returns its size (bytes)."""
    marks = ", ".join("?" * (len(values) + 1))
    connection.execute(f"INSERT OR REPLACE INTO {table} VALUES ({marks})", (*values, seal(table, *values)))
    return sum(len(value) if isinstance(value, bytes | str) else 8 for value in values)


def sound(connection: sqlite3.Connection, table: str, key: Any) -> tuple[Any, ...] | None:
    """A row without its seal; None where it is missing, cannot be read, or is not what was written."""
    try:
        row = connection.execute(f"SELECT * FROM {table} WHERE {KEYS[table]} = ?", (key,)).fetchone()
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        if _of_storage(error):
            raise
        return None
    if row is None or row[0] != key:  # a damaged index leads to the row of another key, whole as that may be
        return None
    return None if seal(table, *row[:-1]) != row[-1] else tuple(row[:-1])


def keys(connection: sqlite3.Connection, table: str) -> list[Any]:
    """Keys of a table, as far as they can be read."""
    found: list[Any] = []
    try:
        for (key,) in connection.execute(f"SELECT {KEYS[table]} FROM {table} ORDER BY 1"):
            found.append(key)
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        if _of_storage(error):
            raise
    return found


def each(connection: sqlite3.Connection, table: str) -> Iterator[tuple[Any, tuple[Any, ...] | None]]:
    """Keys and rows of a table in the order of the keys, None for a row that is damaged."""
    for key in keys(connection, table):
        yield key, sound(connection, table, key)


def rows(connection: sqlite3.Connection, table: str) -> list[tuple[Any, tuple[Any, ...] | None]]:
    """The same at once, for a table of many small rows; row by row where the file is so damaged that it cannot be read through."""
    try:
        found = connection.execute(f"SELECT * FROM {table} ORDER BY 1").fetchall()
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        if _of_storage(error):
            raise
        return list(each(connection, table))
    return [(row[0], tuple(row[:-1]) if seal(table, *row[:-1]) == row[-1] else None) for row in found]


def told(method: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
    """Turns what SQLite, zlib and json say about a damaged file or a full disk into a sentence; the first argument has the path."""

    @wraps(method)
    def checked(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Answer:
        try:
            return method(*args, **kwargs)
        except (sqlite3.Error, zlib.error, json.JSONDecodeError, UnicodeDecodeError) as error:
            if _of_storage(error):
                raise StorageError(unwritten(path_of(args[0]), str(error), getattr(args[0], "size", 0))) from error
            raise RunFileError(damaged(args[0], str(error))) from error

    return checked


def _of_storage(error: Exception) -> bool:
    return isinstance(error, sqlite3.OperationalError) and any(word in str(error).lower() for word in STORAGE)


def path_of(file: Any) -> str:
    """Path of a run file in messages."""
    return str(getattr(file, "path", file))


def damaged(file: Any, what: str, kind: str = "run") -> str:
    """The sentence about a damaged file, which says itself of what ``kind`` it is, or is a path."""
    kind = getattr(file, "kind", kind)
    again = "run the model again" if kind == "run" else f"make the {kind} again"
    return f"{path_of(file)}: this {kind} file is damaged ({what}); {again}, or take a copy of the file"


def unwritten(path: str, what: str, needed: int = 0) -> str:
    """The sentence about a file that could not be written: what the system says, and bytes that were needed and are free where it may be these."""
    if any(word in what.lower() for word in ("readonly", "read-only", "permi")):
        return f"{path}: {what}; you may not write to this file or its folder."
    free = free_bytes(Path(path))
    wanted = f"{needed:,} bytes were to be written, " if needed else ""
    room = "" if free is None else f" ({wanted}{free:,} bytes are free there)"
    return f"{path}: {what}{room}; is the disk full, or the folder gone or read-only?"


def free_bytes(path: Path) -> int | None:
    """Bytes that are free where a file is, or is to be; None where nobody knows."""
    for place in (path, *path.absolute().parents):
        with suppress(OSError):
            return shutil.disk_usage(place).free
    return None


def missing(first: int, end: int) -> str:
    """Outputs that are lost, in words."""
    return f"output {first:,}" if end == first + 1 else f"outputs {first:,} to {end - 1:,}"


def now() -> str:
    """The present time (UTC)."""
    return datetime.now(UTC).isoformat(timespec="seconds")
