"""Sealed SQLite files of runs, studies, maps, wear and fits; :mod:`~vfife.store.schemas` lists what is in
each.

Seals. Each row ends with a hash of its values. SQLite does not check the content of its pages, so a bit that
flips in a file would otherwise become a wrong number. A row whose seal does not fit is left out and reported;
the other rows are used.

Tally. A seal cannot show that a row is missing. The meta of a file therefore has a tally: for each table the
number of its rows and the exclusive or of their seals. The exclusive or does not depend on the order of the
rows, and is updated for an inserted, replaced or removed row without reading the others; a sum of hashes
would serve as well, a hash of all rows would have to be computed again in every transaction. It is written in
the transaction that writes the rows, and is sealed itself. Runs, whose tables are too large to be counted at
every opening, are counted when they end.

Transactions. What is written while something runs is whole on the disk or not there. Several transactions may
be gathered into one, because each waits several times for the disk. SQLite keeps its rollback journal (no
write-ahead log), so that a file is one file, and can be read while it grows.
"""

from __future__ import annotations

import json
import sqlite3
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self

from ..errors import RunFileError, StorageError, VfifeError
from ..files import path_of, replacement
from .connections import damaged, is_of_storage, located, readable, unwritten, warn_of_damage, writable
from .packing import SEAL_BYTES, packed, seal, unpacked
from .schemas import Columns, Schema

TALLY = "tally"  # key of the tally in the meta
TALLY_FORMAT = 2  # first format of files that must have a tally
Values = tuple[Any, ...]
Counts = dict[str, tuple[int, int]]  # number of rows of a table and the exclusive or of their seals
ERRORS = (sqlite3.Error, zlib.error, json.JSONDecodeError, UnicodeDecodeError)


class Row:
    """An intact row: ``row["state"]`` decodes a column, ``values`` are all columns as stored."""

    __slots__ = ("_columns", "_file", "seal", "values")

    def __init__(self, file: Store, columns: Columns, values: Values, sealed: bytes) -> None:
        self._file, self._columns, self.values, self.seal = file, columns, values, sealed

    def __getitem__(self, column: str) -> Any:
        value = self.values[list(self._columns).index(column)]
        kind = self._columns[column]
        if kind not in ("json", "array"):
            return value
        try:
            return json.loads(value) if kind == "json" else unpacked(value) if value else None
        except ERRORS as error:
            raise self._file.fault(error) from error


class Store:
    """A sealed file, open for writing (:meth:`create`, :meth:`write`) or reading (:meth:`open`); a context
    manager that closes it.

    ``damage`` holds sentences on what was damaged or missing when the file was examined.
    """

    schema: ClassVar[Schema]

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path, self._connection = path, connection
        self.size = 0  # bytes of the transaction under way
        self.damage: tuple[str, ...] = ()
        self.is_structured = True  # whether the pages of the file fit together, as :meth:`examine` found
        self._committed, self._waiting = time.monotonic(), False
        self._counts: Counts | None = None

    # ------------------------------------------------------------------------------------------------ opening

    @classmethod
    def create(
        cls, path: Path, meta: Mapping[str, Any] | None = None, fill: Callable[[Self], object] | None = None
    ) -> Self:
        """Make a new file with entries of its meta and what ``fill`` writes, whole or not at all; it replaces
        one of this name.

        Raises StorageError.
        """
        try:
            with replacement(path) as temporary:
                connection = writable(temporary)
                try:
                    connection.execute(f"PRAGMA application_id = {cls.schema.application}")
                    connection.execute(f"PRAGMA user_version = {cls.schema.format}")
                    file = cls(path, connection)
                    with file._gathered():
                        file.complete()
                        file._put(meta or {})
                        if fill is not None:
                            fill(file)
                finally:
                    connection.close()
        except (OSError, sqlite3.Error) as error:
            reason = f"no {cls.schema.kind} file can be made here ({error})"
            raise StorageError(f"{unwritten(path, reason)} Name a folder you can write to.") from error
        return cls.write(path)

    @classmethod
    def write(cls, path: str | Path) -> Self:
        """Open an existing file for writing. Raises RunFileError for a file of another kind, StorageError."""
        path = located(cls.schema, Path(path))
        try:
            return cls(path, writable(path))
        except sqlite3.Error as error:
            if not isinstance(error, sqlite3.OperationalError):
                raise RunFileError(damaged(path, str(error), cls.schema.kind)) from error
            raise StorageError(unwritten(path, str(error))) from error

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Open a file for reading and examine it; its writer may have been killed, or may be at work. Raises
        RunFileError.
        """
        path = located(cls.schema, path_of(path, "load"))
        file = cls(path, readable(path, cls.schema.kind))
        try:
            file.examine()
        except BaseException:
            file.close()
            raise
        return file

    @classmethod
    def resume(cls, path: Path, spec: Mapping[str, Any]) -> Self:
        """Make a file, or open one with the same specification. Raises VfifeError where its specification is
        another.
        """
        kind = cls.schema.kind
        if not path.exists():
            return cls.create(path, {kind: spec})
        with cls.open(path) as stored:
            warn_of_damage(path, kind, stored.damage, "What is missing is computed again now.")
            if stored.spec != json.loads(json.dumps(spec)):
                raise VfifeError(
                    f"{path}: there is a {kind} file here with another specification; name another file, or"
                    " remove this one"
                )
        return cls.write(path)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Write what was gathered, and close the file."""
        try:
            if self._waiting:
                self.flush()
        finally:
            self._connection.close()

    # ------------------------------------------------------------------------------------------------ writing

    @contextmanager
    def transaction(self, patience: float = 0.0) -> Iterator[None]:
        """Begin a transaction, or continue the one that gathers; it is committed if ``patience`` seconds have
        passed since the last.
        """
        with self.reported(), self._gathered(patience):
            yield

    @contextmanager
    def _gathered(self, patience: float = 0.0) -> Iterator[None]:
        if not self._waiting:
            self._connection.execute("BEGIN IMMEDIATE")
            self.size = 0
        self._waiting = True
        try:
            yield
            if self._due(patience):
                self._settle()
        except BaseException:
            # The tally in memory includes rows that the rollback removes; it is read again when needed.
            self._waiting, self._counts = False, None
            if self._connection.in_transaction:
                self._connection.rollback()
            raise

    def insert(self, table: str, *values: Any) -> None:
        """Write a row with its seal, inside a transaction; it replaces one with its key."""
        kinds = self.schema.tables[table].values()
        self.insert_stored(
            table, tuple(_encoded(kind, value) for kind, value in zip(kinds, values, strict=True))
        )

    def insert_stored(self, table: str, stored: Values) -> None:
        """Write a row with its seal, as :meth:`insert` does; ``stored`` are the values of a :class:`Row`."""
        sealed = seal(table, *stored)
        # A replaced row is taken out of the tally first: its seal is its own inverse under exclusive or. A
        # damaged row need not be, because the tally of a file opened for writing counts intact rows only.
        if self.schema.rows:
            counts = self._tally()
            old_row = self.row(table, stored[0]) if self.knows(table, stored[0]) else None
            count, seals = counts.get(table, (0, 0))  # a file of format 1 may lack the table
            if old_row is not None:
                count, seals = count - 1, seals ^ _number(old_row.seal)
            counts[table] = count + 1, seals ^ _number(sealed)
        marks = ", ".join("?" * (len(stored) + 1))
        self._connection.execute(f"INSERT OR REPLACE INTO {table} VALUES ({marks})", (*stored, sealed))
        self.size += sum(len(value) if isinstance(value, bytes | str) else 8 for value in stored)

    def write_row(self, table: str, *values: Any) -> None:
        """Write a row in a transaction of its own."""
        with self.transaction():
            self.insert(table, *values)

    def put(self, meta: Mapping[str, Any]) -> None:
        """Replace entries of the meta in a transaction of their own."""
        with self.transaction():
            self._put(meta)

    def _put(self, meta: Mapping[str, Any]) -> None:
        for key, value in meta.items():
            self.insert("meta", key, value)

    def complete(self) -> None:
        """Make the tables that a new file, or one of an older format, lacks."""
        for statement in self.schema.statements:
            self._connection.execute(statement)

    def flush(self) -> None:
        """Commit what was gathered."""
        with self.reported():
            self._settle()

    def _due(self, patience: float) -> bool:
        return time.monotonic() - self._committed >= patience

    def _settle(self) -> None:
        # The tally is written in the transaction of its rows, so that a kill between both cannot happen.
        if self._connection.in_transaction:
            if self._counts is not None:
                stored = (
                    TALLY,
                    json.dumps(
                        {table: [count, f"{seals:x}"] for table, (count, seals) in self._counts.items()}
                    ),
                )
                self._connection.execute(
                    "INSERT OR REPLACE INTO meta VALUES (?, ?, ?)", (*stored, seal("meta", *stored))
                )
                if self.version < TALLY_FORMAT:
                    self._connection.execute(f"PRAGMA user_version = {TALLY_FORMAT}")
                    self.version = TALLY_FORMAT
            self._connection.commit()
        self._waiting, self._committed = False, time.monotonic()

    # ------------------------------------------------------------------------------------------------ reading

    @cached_property
    def version(self) -> int:
        """The format of the file."""
        return int(self.query("PRAGMA user_version")[0])

    @property
    def meta(self) -> dict[str, Any]:
        """Entries of the meta. Raises RunFileError where its specification is damaged."""
        entries = {key: row["json"] for key, row in self.read("meta") if row is not None}
        return entries | {self.schema.kind: self.spec}

    @property
    def spec(self) -> dict[str, Any]:
        """Specification of what is computed. Raises RunFileError where it is damaged."""
        spec: dict[str, Any] | None = self.get("meta", self.schema.kind, "json")
        if spec is None:
            raise RunFileError(self.damaged("its specification is lost"))
        return spec

    def row(self, table: str, key: Any) -> Row | None:
        """Return a row by its key; None if it is missing, unreadable or does not match its seal."""
        name = next(iter(self.schema.tables[table]))
        values = None
        with self._past_damage():
            values = self._connection.execute(f"SELECT * FROM {table} WHERE {name} = ?", (key,)).fetchone()
        # A damaged index leads to the row of another key, which is whole itself.
        return None if values is None or values[0] != key else self._sound(table, values)

    def get(self, table: str, key: Any, column: str) -> Any:
        """Return a value of a row; None where the row is missing or damaged."""
        row = self.row(table, key)
        return None if row is None else row[column]

    def keys(self, table: str) -> list[Any]:
        """Return the keys of a table in their order, as far as they can be read; none of a table that the
        file lacks.
        """
        name = next(iter(self.schema.tables[table]))
        orders: tuple[list[Any], list[Any]] = [], []
        for keys, order in zip(orders, ("ASC", "DESC"), strict=True):
            with self._past_damage():  # a damaged page ends a search, but hides no keys behind it
                for (key,) in self._connection.execute(f"SELECT {name} FROM {table} ORDER BY 1 {order}"):
                    keys.append(key)
                break
        return [*dict.fromkeys([*orders[0], *reversed(orders[1])])]

    def read(self, table: str) -> list[tuple[Any, Row | None]]:
        """Return the keys and rows of a table in the order of the keys, None for a damaged row.

        Where pages of the file are damaged, the table is read row by row as far as that is possible.
        """
        # One statement for all rows is fast, but fails as a whole at the first damaged page. Then each key is
        # looked up by itself, which loses only the rows on that page.
        with self._past_damage():
            rows = self._connection.execute(f"SELECT * FROM {table} ORDER BY 1").fetchall()
            return [(row[0], self._sound(table, row)) for row in rows]
        return [(key, self.row(table, key)) for key in self.keys(table)]

    def sequence(self, table: str) -> Iterator[Row]:
        """Yield rows numbered from 0, up to the first that is missing or damaged."""
        number = 0
        while (row := self.row(table, number)) is not None:
            yield row
            number += 1

    def has(self, table: str) -> bool:
        """Return whether the file has a table, which one of an older format may lack."""
        return self.query("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?", table) is not None

    def knows(self, table: str, key: Any) -> bool:
        """Return whether a table has a row with a key, sound or not."""
        name = next(iter(self.schema.tables[table]))
        return self.query(f"SELECT 1 FROM {table} WHERE {name} = ?", key) is not None

    def query(self, statement: str, *values: Any) -> Any:
        """Return the first row of a statement's result, None without any."""
        with self.reported():
            return self._connection.execute(statement, values).fetchone()

    def _sound(self, table: str, stored: Values) -> Row | None:
        """Return the row if its seal fits, else None."""
        *values, sealed = stored
        return (
            Row(self, self.schema.tables[table], tuple(values), sealed)
            if seal(table, *values) == sealed
            else None
        )

    # ------------------------------------------------------------------------------------------------- damage

    def examine(self) -> None:
        """Compare all rows with their seals and the tally, in one snapshot of the file; note the damage."""
        with self.reported():
            self._connection.execute("BEGIN")
            try:
                damage = self._structure()
                self.is_structured = not damage
                tally = self.get("meta", TALLY, "json")
                counted = {table: self._counted(table) for table in self._names() if self.has(table)}
            finally:
                self._connection.rollback()
        damage += [
            f"{damaged_rows:,} {self._names()[table]} are damaged"
            for table, (_, damaged_rows) in counted.items()
            if damaged_rows
        ]
        if tally is None and self.version >= TALLY_FORMAT:
            damage.append(
                f"the number of {' and '.join(self.schema.rows.values())} is damaged, so that some may be"
                " missing"
            )
        if tally is not None:
            damage += self._missing(tally, counted)
        self.damage = tuple(damage)

    def _names(self) -> dict[str, str]:
        return {**self.schema.rows, "meta": "entries"}

    def _tally(self) -> Counts:
        """Return the tally of the sound rows, counted once; damaged rows are computed again and do
        not count.
        """
        if self._counts is None:
            self._counts = {table: self._counted(table)[0] for table in self._names() if self.has(table)}
        return self._counts

    def _counted(self, table: str) -> tuple[tuple[int, int], int]:
        """Return the number of sound rows of a table and the exclusive or of their seals, and the number of
        damaged rows.
        """
        count = seals = damaged = 0
        for key, row in self.read(table):
            if table == "meta" and key == TALLY:
                continue
            if row is None:
                damaged += 1
            else:
                count, seals = count + 1, seals ^ _number(row.seal)
        return (count, seals), damaged

    def _structure(self) -> list[str]:
        """Return a sentence where pages of the file do not fit together: then a search by key fails although
        the row is there.
        """
        if getattr(self._connection, "folder", None) is not None:
            return ["its head does not fit its pages"]
        try:
            answer = self._connection.execute("PRAGMA integrity_check(1)").fetchone()[0]
        except sqlite3.DatabaseError:
            answer = "unreadable"
        return [] if answer == "ok" else ["its pages do not fit together"]

    def _missing(
        self, tally: Mapping[str, Any], counted: Mapping[str, tuple[tuple[int, int], int]]
    ) -> list[str]:
        """Return the sentences on rows that are in the tally but not in the file, beyond those that are
        damaged.
        """
        missing = []
        for table, name in self._names().items():
            counts, damaged = counted.get(table, ((0, 0), 0))
            count, seals = tally.get(table, [0, "0"])
            missing_rows = int(count) - counts[0] - damaged
            if missing_rows > 0:
                missing.append(f"{missing_rows:,} {name} are missing")
            elif not damaged and counts != (int(count), int(seals, 16)):
                missing.append(f"the {name} are not those that were written")
        return missing

    @contextmanager
    def _past_damage(self) -> Iterator[None]:
        """Leave out what damaged pages of the file hide; raise StorageError for an error of the disk."""
        try:
            yield
        except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
            if is_of_storage(error):
                raise self.fault(error) from error

    @contextmanager
    def reported(self) -> Iterator[None]:
        """Turn errors of SQLite, zlib and json about a damaged file or a full disk into ours."""
        try:
            yield
        except ERRORS as error:
            raise self.fault(error) from error

    def fault(self, error: Exception) -> VfifeError:
        """Return the error of the package for one of SQLite, zlib or json."""
        if is_of_storage(error):
            return StorageError(unwritten(self.path, str(error), self.size))
        return RunFileError(self.damaged(str(error)))

    def damaged(self, reason: str) -> str:
        """Return the sentence about this damaged file."""
        return damaged(self.path, reason, self.schema.kind)


def _encoded(kind: str, value: Any) -> Any:
    if kind == "json":
        return json.dumps(value)
    return (b"" if value is None else packed(value)) if kind == "array" else value


def _number(sealed: bytes) -> int:
    return int.from_bytes(sealed[:SEAL_BYTES], "big")


def present_time() -> str:
    """Return the present time (UTC)."""
    return datetime.now(UTC).isoformat(timespec="seconds")
