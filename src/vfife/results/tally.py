"""Files whose rows are counted: a row that is missing is noticed, as one that was changed is.

Each row has a seal, a hash of its values. A seal shows that a row was changed; it cannot show that a row is gone. The meta of
a file therefore has a tally: for each table the number of rows and the exclusive or of their seals, which does not depend on
their order. It is written in the transaction that writes the rows, and has a seal itself. Files of format 1 have no tally;
of them damaged rows alone are noticed.
"""

from __future__ import annotations

import json
import sqlite3
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

from ..errors import DamageWarning
from . import tables
from .packing import SEAL_BYTES, seal
from .transactions import Transactions

TALLY = "tally"  # its key in the meta
SINCE = 2  # the format of a file that must have one
Counts = dict[str, tuple[int, int]]  # rows of a table and the exclusive or of their seals


class TalliedFile(Transactions):
    """A file with a tally of its rows.

    ``rows`` gives for each table what its rows are called. ``damage`` holds sentences on what was damaged or missing when the
    file was examined.
    """

    kind: ClassVar[str]
    rows: ClassVar[dict[str, str]]

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        super().__init__(path, connection)
        self._counts: Counts | None = None
        self.damage: tuple[str, ...] = ()

    def _insert(self, table: str, *values: Any) -> int:
        """Write a row in the place of one with its key, inside a transaction; return its size (bytes)."""
        counts = self._tally()
        there = self._connection.execute(f"SELECT 1 FROM {table} WHERE {tables.KEYS[table]} = ?", (values[0],)).fetchone()
        before = tables.sound(self._connection, table, values[0]) if there else None
        count, seals = counts.get(table, (0, 0))  # a file of format 1 gets a table that it lacks
        if before is not None:
            count, seals = count - 1, seals ^ number_of(seal(table, *before))
        counts[table] = count + 1, seals ^ number_of(seal(table, *values))
        return tables.insert(self._connection, table, *values)

    @contextmanager
    def _transaction(self, patience: float = 0.0) -> Iterator[None]:
        try:
            with super()._transaction(patience):
                yield
        except BaseException:
            self._counts = None  # what was rolled back does not count
            raise

    def _settle(self) -> None:
        if self._connection.in_transaction and self._counts is not None:
            told = {table: [count, f"{seals:x}"] for table, (count, seals) in self._counts.items()}
            tables.insert(self._connection, "meta", TALLY, json.dumps(told))
            if self._version() < SINCE:
                self._connection.execute(f"PRAGMA user_version = {SINCE}")
        super()._settle()

    def _version(self) -> int:
        return int(self._connection.execute("PRAGMA user_version").fetchone()[0])

    def _tally(self) -> Counts:
        """The tally of the sound rows, counted once; rows that are damaged are to be computed again and do not count."""
        if self._counts is None:
            self._counts = {table: counted(self._connection, table)[0] for table in self._names()}
        return self._counts

    def _names(self) -> dict[str, str]:
        """What the rows of each table are called."""
        return {table: name for table, name in self.rows.items() if tables.has(self._connection, table)} | {"meta": "entries"}

    def examine(self) -> None:
        """Compare all rows with their seals and with the tally, in one snapshot of the file, and note the damage."""
        self._connection.execute("BEGIN")
        try:
            said = structure(self._connection)
            row = tables.sound(self._connection, "meta", TALLY)
            must = self._version() >= SINCE
            found = {table: counted(self._connection, table) for table in self._names()}
        finally:
            self._connection.rollback()
        said += [f"{lost:,} {self._names()[table]} are damaged" for table, (_, lost) in found.items() if lost]
        if row is None and must:
            said.append(f"the number of {' and '.join(self.rows.values())} is damaged, so that some may be missing")
        if row is not None:
            said += missing(json.loads(row[1]), found, self.rows | {"meta": "entries"})
        self.damage = tuple(said)


def structure(connection: sqlite3.Connection) -> list[str]:
    """A sentence where pages of a file do not fit together: then a search by key fails although the row is there."""
    try:
        found = connection.execute("PRAGMA integrity_check(1)").fetchone()[0]
    except sqlite3.DatabaseError as error:
        found = str(error)
    return [] if found == "ok" else [f"its pages do not fit together ({' '.join(str(found).split())})"]


def counted(connection: sqlite3.Connection, table: str) -> tuple[tuple[int, int], int]:
    """The number of sound rows of a table and the exclusive or of their seals, and the number of damaged rows."""
    count = seals = lost = 0
    for key, row in tables.rows(connection, table):
        if table == "meta" and key == TALLY:
            continue
        if row is None:
            lost += 1
        else:
            count, seals = count + 1, seals ^ number_of(seal(table, *row))
    return (count, seals), lost


def missing(tally: dict[str, Any], found: dict[str, tuple[tuple[int, int], int]], names: dict[str, str]) -> list[str]:
    """Sentences on rows that the tally has and the file has not, beyond those that are damaged."""
    said = []
    for table in names:
        counts, lost = found.get(table, ((0, 0), 0))
        known = tally.get(table, [0, "0"])
        gone = int(known[0]) - counts[0] - lost
        if gone > 0:
            said.append(f"{gone:,} {names[table]} are missing")
        elif not lost and counts != (int(known[0]), int(known[1], 16)):
            said.append(f"the {names[table]} are not those that were written")
    return said


def number_of(one: bytes) -> int:
    """A seal as a number."""
    return int.from_bytes(one[:SEAL_BYTES], "big")


def warn_of_damage(path: Path | None, kind: str, damage: tuple[str, ...], remedy: str) -> None:
    """Warn that a file is damaged, with what computes again what is gone; nothing where it is sound.

    The line that is blamed is the one of the user which called the package.
    """
    if not damage:
        return
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and str(frame.f_globals.get("__name__", "")).partition(".")[0] == __package__.partition(".")[0]:
        level, frame = level + 1, frame.f_back
    text = f"{path}: this {kind} file is damaged: {'; '.join(damage)}; the rest is used. {remedy}"
    warnings.warn(text, DamageWarning, stacklevel=level)
