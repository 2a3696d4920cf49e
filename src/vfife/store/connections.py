"""Connections to sealed files, also to those that a killed process left; messages on damage and
full disks.
"""

from __future__ import annotations

import shutil
import sqlite3
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

from ..errors import DamageWarning, RunFileError
from ..files import free_bytes
from ..files.kinds import RUN_FILE, FileKindError, refuse_kind
from .schemas import RUN, Schema

# A file may be made to trap its reader. A statement is ended after about two minutes: MOST_BEATS times BEAT
# instructions of SQLite's machine, of 20 ms. The longest of ours, a read of a study of a million cases,
# takes 40 beats.
BEAT = 1_000_000
MOST_BEATS = 5_000
SYNCHRONOUS = "NORMAL"  # a committed transaction is on the disk, even if the machine loses power
PAGE = 4096  # bytes of a page of SQLite
# What the heads of all our files have in common, by its place: size of a page, formats, the share of a page
# for a row, an empty list of free pages (which is not needed for reading), the format of the schema, UTF-8.
HEAD = {
    16: PAGE.to_bytes(2, "big"),
    18: bytes((1, 1, 0, 64, 32, 32)),
    32: bytes(8),
    44: (4).to_bytes(4, "big"),
    52: bytes(4),
    56: (1).to_bytes(4, "big"),
    64: bytes(4),
    72: bytes(20),
}  # fmt: skip
# Words in errors of SQLite that are about the disk, not about a damaged file.
STORAGE = (
    "full", "disk i/o", "unable to open", "readonly", "read-only", "permission", "locked", "too big",
)  # fmt: skip


class Connection(sqlite3.Connection):
    """A connection that ends statements after MOST_BEATS, because a crafted file could make one run
    for ever. ``folder`` has the copy that it reads in place of a file whose head is damaged, else None.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.beats, self.folder = 0, None
        self.execute("PRAGMA trusted_schema = OFF")
        self.set_progress_handler(self.beat, BEAT)

    folder: tempfile.TemporaryDirectory[str] | None

    def close(self) -> None:
        """Close the connection and remove the copy."""
        super().close()
        if self.folder is not None:
            self.folder.cleanup()

    def execute(self, *args: Any) -> sqlite3.Cursor:
        """Run a statement with a new budget."""
        self.beats = 0
        return super().execute(*args)

    def beat(self) -> bool:
        """Count a beat; True ends the statement."""
        self.beats += 1
        return self.beats > MOST_BEATS


def refuse_schema(connection: sqlite3.Connection) -> None:
    """Raise sqlite3.DatabaseError for views, triggers and virtual tables, which run statements; our files
    have none.
    """
    for kind, name, root in connection.execute("SELECT type, name, rootpage FROM sqlite_master"):
        if kind not in ("table", "index") or not root:  # virtual tables have no root page
            raise sqlite3.DatabaseError(f"it has a {kind} {str(name)[:40]!r}, which vfife never makes")


def writable(path: Path) -> sqlite3.Connection:
    """Open a connection that writes."""
    connection = sqlite3.connect(path, timeout=60.0, isolation_level=None, factory=Connection)
    try:
        refuse_schema(connection)
    except BaseException:
        connection.close()
        raise
    connection.execute("PRAGMA journal_mode = DELETE")
    connection.execute(f"PRAGMA synchronous = {SYNCHRONOUS}")
    return connection


def readable(path: Path, kind: str = "run") -> sqlite3.Connection:
    """Open a connection that reads; the journal of a killed writer is rolled back first.

    SQLite writes for that. Where it may not, the file is read through a temporary copy. Raises RunFileError.
    """
    try:
        connection = sqlite3.connect(
            f"{path.resolve().as_uri()}?mode=rw",
            uri=True,
            timeout=60.0,
            isolation_level=None,
            factory=Connection,
        )
        refuse_schema(connection)
        connection.execute("PRAGMA query_only = ON")
        return connection
    except sqlite3.OperationalError as error:
        if "locked" in str(error):
            raise RunFileError(
                f"{path}: another program keeps this {kind} file locked; try again when it has ended"
            ) from error
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        try:
            return copy_with_new_head(path)
        except (sqlite3.DatabaseError, UnicodeDecodeError, OSError):
            raise RunFileError(damaged(path, str(error), kind)) from error
    # On a read-only medium SQLite can neither roll back the journal nor take its lock. File and journal are
    # copied, the copy is recovered, and its content is held in memory, so that no file remains.
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


def copy_with_new_head(path: Path) -> Connection:
    """Open a temporary copy of a file that was cut off or whose head is damaged, with a head that fits the
    pages that are there: SQLite refuses the whole file otherwise. Raises sqlite3.DatabaseError, OSError.
    """
    folder = tempfile.TemporaryDirectory()
    try:
        copy = Path(folder.name) / path.name
        shutil.copyfile(path, copy)
        with copy.open("rb+") as stream:
            head = bytearray(stream.read(100))
            for place, value in HEAD.items():
                head[place : place + len(value)] = value
            head[28:32] = (path.stat().st_size // PAGE).to_bytes(4, "big")  # number of pages
            head[92:96] = head[24:28]  # the change for which that number holds: the last one
            stream.seek(0)
            stream.write(head)
        connection = sqlite3.connect(copy, isolation_level=None, factory=Connection)
        connection.folder = folder
        refuse_schema(connection)
        connection.execute("PRAGMA query_only = ON")
        return connection
    except BaseException:
        folder.cleanup()
        raise


def located(schema: Schema, path: Path) -> Path:
    """Return the file of a schema at a path, which may be the folder of a run. Raises RunFileError if this
    version reads none there.
    """
    try:
        refuse_kind(path, schema.kind)
    except FileKindError as error:
        raise RunFileError(str(error)) from None
    if schema is RUN and path.is_dir():
        path = path / RUN_FILE
    if not path.is_file():
        raise RunFileError(f"{path}: there is no {schema.kind} file of this name; {schema.source}")
    head = schema.head(path)
    if head is None:
        raise RunFileError(f"{path}: this is not a {schema.kind} file of vfife; {schema.source}")
    version = int.from_bytes(head[60:64], "big")
    if version > schema.format:
        raise RunFileError(
            f"{path}: this {schema.kind} file was written by a newer vfife; install that version to read it"
        )
    if version < schema.oldest:
        raise RunFileError(
            f"{path}: this {schema.kind} file was written by vfife 0.1; install version 0.2 to read it, or"
            " make it again"
        )
    return path


def is_of_storage(error: Exception) -> bool:
    """Return whether an error of SQLite is about the disk, not about a damaged file."""
    return isinstance(error, sqlite3.OperationalError) and any(word in str(error).lower() for word in STORAGE)


def damaged(path: Path | str, reason: str, kind: str) -> str:
    """Return the sentence about a damaged file."""
    remedy = "run the model again" if kind == "run" else f"make the {kind} again in another file"
    if "malformed" in reason or "not a database" in reason:  # words of SQLite, which mean nothing to a user
        reason = "its head, or its list of tables, cannot be read"
    return f"{path}: this {kind} file is damaged ({reason}); {remedy}, or use a backup"


def unwritten(path: Path | str, reason: str, needed: int = 0) -> str:
    """Return the sentence about a file that could not be written: the system's reason, and bytes needed and
    free if these may be it.
    """
    if any(word in reason.lower() for word in ("readonly", "read-only", "permi")):
        return f"{path}: {reason}; you may not write to this file or its folder."
    free = free_bytes(Path(path))
    written = f"{needed:,} bytes were to be written, " if needed else ""
    room = "" if free is None else f" ({written}{free:,} bytes are free there)"
    return f"{path}: {reason}{room}; is the disk full, or the folder gone or read-only?"


def warn_of_damage(path: Path | None, kind: str, damage: tuple[str, ...], remedy: str) -> None:
    """Warn of a damaged file, with the ``remedy`` that computes the missing rows again; a sound file gets no
    warning.

    The warning names the line of the user's code that called the package.
    """
    if damage:
        warn_at_caller(
            f"{path}: this {kind} file is damaged: {'; '.join(damage)}; the rest is used. {remedy}"
        )


def warn_at_caller(text: str) -> None:
    """Warn of damage, at the line of the user's code that called the package."""
    level, frame = 2, sys._getframe(1)
    while (
        frame.f_back is not None
        and str(frame.f_globals.get("__name__", "")).partition(".")[0] == __package__.partition(".")[0]
    ):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, DamageWarning, stacklevel=level)
