"""Connections to run files: one that writes, one that reads whatever a killed writer left."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import RunFileError, StorageError
from ..files import replacement
from .header import FIT_APPLICATION, FORMAT, MAP_APPLICATION, RUN_FILE, WEAR_APPLICATION, head_of, head_with, study_head
from .tables import damaged, unwritten

BEAT = 1_000_000  # instructions of SQLite's machine between two looks at the budget, some 20 ms
MOST_BEATS = 5_000  # about two minutes; the longest statement of ours, a read of all rows of a study of a million members, takes 40
SYNCHRONOUS = "NORMAL"  # what is complete is on the disk before a run goes on, though the machine should lose its power


def run_file_at(path: str | Path) -> Path:
    """The run file that a path means. Raises RunFileError where there is none that this version reads."""
    path = Path(path)
    path = path / RUN_FILE if path.is_dir() else path
    if not path.is_file():
        raise RunFileError(f"{path}: there is no run file of this name; name the folder or file of a run")
    head = head_of(path)
    if head is None and study_head(path) is not None:
        raise RunFileError(f"{path}: this is a study file, of many runs; see vfife study show, plot and export, and vfife report")
    if head is None and head_with(path, MAP_APPLICATION) is not None:
        raise RunFileError(f"{path}: this is a map file, of many turns; see vfife map show")
    if head is None and head_with(path, WEAR_APPLICATION) is not None:
        raise RunFileError(f"{path}: this is a wear file, of many turns; see vfife wear, which shows it")
    if head is None and head_with(path, FIT_APPLICATION) is not None:
        raise RunFileError(f"{path}: this is a fit file, of many runs; see vfife fit, which shows it")
    if head is None:
        raise RunFileError(f"{path}: this is no run file of vfife; name the folder or the {RUN_FILE} that a run left")
    if int.from_bytes(head[60:64], "big") > FORMAT:
        raise RunFileError(f"{path}: this run file was written by a newer vfife; install that version to read it")
    return path


class Connection(sqlite3.Connection):
    """A connection that runs only short statements: one that needs more than MOST_BEATS, as a file made to trap us might, fails."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.beats = 0
        self.execute("PRAGMA trusted_schema = OFF")
        self.set_progress_handler(self.beat, BEAT)

    def execute(self, *args: Any) -> sqlite3.Cursor:
        """Run a statement, with the whole budget before it."""
        self.beats = 0
        return super().execute(*args)

    def beat(self) -> bool:
        """Count a beat; True ends the statement."""
        self.beats += 1
        return self.beats > MOST_BEATS


def refuse_schema(connection: sqlite3.Connection) -> None:
    """Raise sqlite3.DatabaseError for a file with views, triggers or virtual tables: none of ours has any, and they run statements of their own."""
    for kind, name, root in connection.execute("SELECT type, name, rootpage FROM sqlite_master"):
        if kind not in ("table", "index") or not root:  # a virtual table has no page of its own
            raise sqlite3.DatabaseError(f"it has a {kind} {str(name)[:40]!r}, which vfife never makes")


def connected(path: Path) -> sqlite3.Connection:
    """A connection that writes."""
    connection = sqlite3.connect(path, timeout=60.0, isolation_level=None, factory=Connection)
    try:
        refuse_schema(connection)
    except BaseException:
        connection.close()
        raise
    connection.execute("PRAGMA journal_mode = DELETE")
    connection.execute(f"PRAGMA synchronous = {SYNCHRONOUS}")
    return connection


@contextmanager
def new_file(path: Path, kind: str, application: int, version: int, schema: Iterable[str]) -> Iterator[sqlite3.Connection]:
    """A connection to a new file with its tables, which is there whole or not at all; one of this name gives way. Raises StorageError."""
    try:
        with replacement(path) as part:
            connection = connected(part)
            try:
                connection.execute(f"PRAGMA application_id = {application}")
                connection.execute(f"PRAGMA user_version = {version}")
                for statement in schema:
                    connection.execute(statement)
                yield connection
            finally:
                connection.close()
    except (OSError, sqlite3.Error) as error:
        raise StorageError(f"{unwritten(str(path), f'no {kind} file can be made here ({error})')} Name a folder you can write to") from error


def readable(path: Path, kind: str = "run") -> sqlite3.Connection:
    """A connection that can read the file; the journal of a killed writer is rolled back first.

    That needs to write: where it cannot be done in place, it is done on a copy that vanishes.
    """
    try:
        connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=rw", uri=True, timeout=60.0, isolation_level=None, factory=Connection)
        refuse_schema(connection)
        connection.execute("PRAGMA query_only = ON")
        return connection
    except sqlite3.OperationalError as error:
        if "locked" in str(error):
            raise RunFileError(f"{path}: another program keeps this {kind} file locked; try again when it has ended") from error
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        raise RunFileError(damaged(path, str(error), kind)) from error
    import tempfile

    memory = sqlite3.connect(":memory:", isolation_level=None, factory=Connection)
    try:
        with tempfile.TemporaryDirectory() as folder:
            for name in (path.name, f"{path.name}-journal"):
                if (path.parent / name).exists():
                    shutil.copy(path.parent / name, folder)
                    (Path(folder) / name).chmod(0o600)
            copy = sqlite3.connect(Path(folder) / path.name, factory=Connection)
            refuse_schema(copy)
            copy.backup(memory)
            copy.close()
    except (sqlite3.DatabaseError, UnicodeDecodeError, OSError) as error:
        raise RunFileError(damaged(path, str(error), kind)) from error
    return memory
