"""Schemas of the sealed files: what tells one from any other file, its tables and columns, and the formats
that are read.

A schema is data; :class:`~vfife.store.store.Store` does the rest. Every command asks for the kind of a file,
so this module loads neither SQLite nor numpy.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from ..files import open_regular
from ..files.kinds import APPLICATIONS, RUN_FILE, SQLITE

HEADER = 100  # bytes of SQLite's header
# What SQLite stores of a kind of column. "json" is an object as text, "array" numbers as compressed bytes,
# empty for None.
TYPES = {
    "integer": "INTEGER",
    "real": "REAL",
    "text": "TEXT",
    "json": "TEXT",
    "array": "BLOB",
    "bytes": "BLOB",
}
Columns = Mapping[str, str]  # kind of each column by its name; the first is the key


class Schema(NamedTuple):
    """A kind of file.

    ``application`` is the id in SQLite's header. Files of formats from ``oldest`` to ``format`` are read.
    ``rows`` says what the rows of each table are called that a tally counts in every transaction (from format
    2 on). ``source`` says where files of this kind come from.
    """

    kind: str
    application: int
    format: int
    oldest: int
    tables: Mapping[str, Columns]
    rows: Mapping[str, str]
    source: str

    @property
    def statements(self) -> list[str]:
        """SQL that makes the tables that a file lacks; the last column of each is the seal of the row."""
        statements = []
        for table, columns in self.tables.items():
            key, *values = [*(f"{name} {TYPES[kind]}" for name, kind in columns.items()), "seal BLOB"]
            declared = [f"{key} PRIMARY KEY", *(f"{column} NOT NULL" for column in values)]
            statements.append(f"CREATE TABLE IF NOT EXISTS {table} ({', '.join(declared)})")
        return statements

    def head(self, path: Path) -> bytes | None:
        """Return the header of a file of this kind; None for any other file."""
        try:
            with open_regular(path) as stream:
                head = stream.read(HEADER)
        except OSError:
            return None
        is_kind = head.startswith(SQLITE) and int.from_bytes(head[68:72], "big") == self.application
        return head if is_kind else None

    def owns(self, path: Path) -> bool:
        """Return whether a file is of this kind."""
        return self.head(path) is not None


META = {"key": "text", "json": "json"}
ARRAYS = {"key": "text", "data": "array"}
OUTCOMES = {
    "number": "integer", "hash": "text", "status": "text", "reason": "text", "turns": "integer",
    "settled": "integer", "steps": "integer", "step": "real", "measures": "json",
}  # fmt: skip

# A run is counted when it ends, not in every transaction. Format 3 is that of version 0.2; 1 and 2 had no
# seals.
RUN = Schema(
    "run", APPLICATIONS["run"], 3, 3,
    {
        "meta": META,
        "arrays": ARRAYS,
        "copies": {"key": "text", "data": "bytes"},
        "history": {"chunk": "integer", "first": "integer", "outputs": "integer", "steps": "array",
            "data": "array"},
        "checkpoints": {"step": "integer", "chunks": "integer", "outputs": "integer", "more": "json",
            "state": "array"},
        "events": {"number": "integer", "step": "integer", "time": "text", "text": "text"},
        "reference": {"part": "text", "data": "bytes"},
        "companions": {"first": "integer", "outputs": "integer", "last": "integer", "told": "json",
            "steps": "array", "data": "array"},
        "turns": {"turn": "integer", "last": "integer", "data": "array"},
    },
    {}, f"name the folder or the {RUN_FILE} that a run left",
)  # fmt: skip
# Format 1 of the four below had no tally; it is added when something is written.
STUDY = Schema(
    "study", APPLICATIONS["study"], 2, 1,
    {
        "meta": META, "members": {"number": "integer", "hash": "text", "numbers": "json"},
        "outcomes": OUTCOMES, "repeats": OUTCOMES, "step_trials": {"key": "text", **OUTCOMES},
    },
    {
        "members": "cases", "outcomes": "outcomes", "repeats": "repetitions",
        "step_trials": "further steps",
    },
    "`vfife study STUDY.toml` makes one",
)  # fmt: skip
MAP = Schema(
    "map", APPLICATIONS["map"], 2, 1,
    {
        "meta": META, "arrays": ARRAYS,
        "legs": {"number": "integer", "points": "array", "growth": "array", "state": "array"},
    },
    {"legs": "values", "arrays": "arrays"},
    "name a file that vfife map wrote",
)  # fmt: skip
WEAR = Schema(
    "wear", APPLICATIONS["wear"], 2, 1,
    {
        "meta": META,
        "points": {"number": "integer", "told": "json", "depth": "array", "rate": "array", "state": "array"},
    },
    {"points": "points"},
    "name a file that vfife wear wrote",
)  # fmt: skip
FIT = Schema(
    "fit", APPLICATIONS["fit"], 2, 1,
    {
        "meta": META,
        "looks": {"key": "text", "told": "json", "data": "array"},
        "found": {"key": "text", "told": "json", "data": "array"},
    },
    {"looks": "points", "found": "results"},
    "name a file that vfife fit wrote",
)  # fmt: skip


def is_run_file(path: Path) -> bool:
    """Return whether a file is a run file."""
    return RUN.owns(path)
