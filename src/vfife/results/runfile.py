"""One SQLite file a run: model, start, versions, history, checkpoints, events; whole up to the last transaction.

Rows of S are stored chunk by chunk, and read into memory or, where they are many, into a mapped file of no name. SQLite keeps its rollback
journal (no write-ahead log), so a finished run is one file. A transaction waits several times for the disk, so those of a short run are gathered.
"""

from __future__ import annotations

import json
import math
import shutil
import sqlite3
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from .packing import packed, unpacked

if TYPE_CHECKING:
    from ..solvers.companions import Beside

RUN_FILE = "run.sqlite"  # its name in a run folder
ARRAY = "array."  # of the meta, among the parts of a reference
APPLICATION = 0x56464946  # "VFIF", in the header of the file
FORMAT = 2  # 1 had no arrays, and so no start
CHECKPOINTS = 2  # the latest ones are kept
IN_MEMORY = 2**28  # bytes of rows that are read into memory; more are mapped

SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, json TEXT NOT NULL);
CREATE TABLE arrays (key TEXT PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE history (chunk INTEGER PRIMARY KEY, first INTEGER NOT NULL, outputs INTEGER NOT NULL, data BLOB NOT NULL);
CREATE TABLE steps (output INTEGER PRIMARY KEY, step INTEGER NOT NULL);
CREATE TABLE checkpoints (step INTEGER PRIMARY KEY, state BLOB NOT NULL);
CREATE TABLE events (number INTEGER PRIMARY KEY, step INTEGER NOT NULL, time TEXT NOT NULL, text TEXT NOT NULL);
CREATE TABLE reference (part TEXT PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE companions (first INTEGER PRIMARY KEY, outputs INTEGER NOT NULL, last INTEGER NOT NULL, told TEXT NOT NULL, data BLOB NOT NULL);
"""

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")


def told(method: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
    """Turns what SQLite, zlib and json say about a damaged file into a sentence; the first argument has the path."""

    @wraps(method)
    def checked(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Answer:
        try:
            return method(*args, **kwargs)
        except sqlite3.OperationalError as error:
            if "no such table" not in str(error):
                raise RunFileError(f"{path_of(args[0])}: {error}; is the disk full, or the folder gone?") from error
            raise RunFileError(damaged(args[0], str(error))) from error
        except (sqlite3.DatabaseError, zlib.error, json.JSONDecodeError, UnicodeDecodeError) as error:
            raise RunFileError(damaged(args[0], str(error))) from error

    return checked


def path_of(file: Any) -> str:
    """Path of a run file in messages."""
    return str(getattr(file, "path", file))


def damaged(file: Any, what: str) -> str:
    """The sentence about a damaged file."""
    return f"{path_of(file)}: this run file is damaged ({what}); run the model again, or take a copy of the file"


class RunFile:
    """A run file, open for writing (:meth:`create`) or reading (:meth:`open`); a context manager that closes it."""

    def __init__(self, path: Path, connection: sqlite3.Connection, gather: float = 0.0) -> None:
        self.path, self._connection = path, connection
        self._gather, self._kept, self._waiting = gather, time.monotonic(), False

    @classmethod
    def create(cls, path: str | Path, meta: Mapping[str, Any] | None = None, *, replace: bool = False, gather: float = 0.0) -> RunFile:
        """A new run file with ``meta``: anything JSON can say, and arrays; best from :func:`~vfife.results.provenance.provenance`.

        What is written within ``gather`` seconds becomes one transaction, which ends with a checkpoint; each is one of its own by default.
        Raises RunFileError where the file cannot be made, or is there already and ``replace`` is false.
        """
        path = Path(path)
        if path.exists():
            if not replace:
                raise RunFileError(f"{path}: there is a run file already; name another one or remove it first")
            for old in (path, path.with_name(path.name + "-journal")):
                old.unlink(missing_ok=True)
        try:
            connection = sqlite3.connect(path, timeout=60.0, isolation_level=None)
            connection.execute("PRAGMA journal_mode = DELETE")
            connection.execute("PRAGMA synchronous = NORMAL")
            connection.execute(f"PRAGMA application_id = {APPLICATION}")
            connection.execute(f"PRAGMA user_version = {FORMAT}")
            file = cls(path, connection, gather)
            with file._transaction():
                for statement in SCHEMA.strip().split("\n"):
                    connection.execute(statement)
                file._put({"status": "running", "created": now(), **(meta or {})})
        except sqlite3.Error as error:
            raise RunFileError(f"{path}: no run file can be made here ({error}); name a folder you can write to") from error
        return file

    @classmethod
    def open(cls, path: str | Path) -> RunFile:
        """A run file, or that of a run folder, for reading; also one whose writer was killed or is still at work."""
        path = Path(path)
        path = path / RUN_FILE if path.is_dir() else path
        if not path.is_file():
            raise RunFileError(f"{path}: there is no run file of this name; name the folder or file of a run")
        with path.open("rb") as stream:
            head = stream.read(100)
        if not head.startswith(b"SQLite format 3\0") or int.from_bytes(head[68:72], "big") != APPLICATION:
            raise RunFileError(f"{path}: this is no run file of vfife; name the folder or the {RUN_FILE} that a run left")
        if int.from_bytes(head[60:64], "big") > FORMAT:
            raise RunFileError(f"{path}: this run file was written by a newer vfife; install that version to read it")
        file = cls(path, _readable(path))
        file.meta  # noqa: B018 - a damaged file is told here, not at its first use
        return file

    def __enter__(self) -> RunFile:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    @told
    def close(self) -> None:
        """Closes the file; what was gathered goes to the disk first."""
        try:
            if self._waiting:
                self._settle()
        finally:
            self._connection.close()

    # ------------------------------------------------------------------------------------------------------- writing

    @told
    def begin(self, meta: Mapping[str, Any]) -> None:
        """Starts the run anew, as after a try with too large a step: the history goes, ``meta`` is replaced key by
        key.
        """
        with self._transaction():
            self._forget()
            self._put({"status": "running", **meta})

    @told
    def append(self, steps: NDArray[np.int64], rows: NDArray[np.float64], beside: Beside | None = None) -> None:
        """Adds outputs in one transaction: steps, shape (outputs,), and rows, shape (outputs, kept). Step 0 starts
        anew. ``beside`` is what companions leave at the last of these outputs; of theirs only those still needed stay.
        """
        if len(steps) == 0:
            return
        with self._transaction(math.inf):
            if int(steps[0]) == 0:
                self._forget()
            row = self._connection.execute("SELECT count(*), coalesce(max(output) + 1, 0) FROM steps").fetchone()
            first = int(row[1])
            chunk = self._connection.execute("SELECT coalesce(max(chunk) + 1, 0) FROM history").fetchone()[0]
            numbered = [(first + k, int(step)) for k, step in enumerate(steps)]
            self._connection.executemany("INSERT INTO steps VALUES (?, ?)", numbered)
            self._connection.execute("INSERT INTO history VALUES (?, ?, ?, ?)", (chunk, first, len(steps), packed(rows)))
            if beside is not None:
                self._keep_companions(first + len(steps) - len(beside.rows), int(steps[-1]), beside)

    def _keep_companions(self, first: int, last: int, beside: Beside) -> None:
        outputs = len(beside.rows)
        values = (first, outputs, last, json.dumps(beside.told), packed(beside.rows.reshape(outputs, -1)))
        self._connection.execute("INSERT OR REPLACE INTO companions VALUES (?, ?, ?, ?, ?)", values)
        self._connection.execute("DELETE FROM companions WHERE last < ?", (beside.oldest,))

    @told
    def checkpoint(self, step: int, state: NDArray[np.float64]) -> None:
        """Keeps the state after ``step``, from which a run can go on, in the order of the blocks of the start."""
        with self._transaction(self._gather):
            self._connection.execute("INSERT OR REPLACE INTO checkpoints VALUES (?, ?)", (int(step), packed(state)))
            old = "DELETE FROM checkpoints WHERE step NOT IN (SELECT step FROM checkpoints ORDER BY step DESC LIMIT ?)"
            self._connection.execute(old, (CHECKPOINTS,))

    @told
    def event(self, step: int, text: str) -> None:
        """Notes that something happened after ``step``."""
        with self._transaction():
            self._connection.execute("INSERT INTO events (step, time, text) VALUES (?, ?, ?)", (int(step), now(), text))

    @told
    def keep_reference(self, meta: Mapping[str, Any], steps: NDArray[np.int64], rows: NDArray[np.float64]) -> None:
        """Keeps the record of the ideal mechanism beside the run."""
        entries, arrays = parted(meta)
        parts = {"meta": json.dumps(entries).encode(), "steps": packed(steps.astype(float)), "rows": packed(rows)}
        parts |= {f"{ARRAY}{key}": packed(values) for key, values in arrays.items()}
        with self._transaction(math.inf):
            self._connection.executemany("INSERT OR REPLACE INTO reference VALUES (?, ?)", list(parts.items()))

    @told
    def finish(self, status: str, summary: Mapping[str, Any] | None = None, **meta: Any) -> None:
        """Says how the run ended ("complete", "interrupted", "diverged"), with its summary and what else is known."""
        with self._transaction():
            self._put({"status": status, "finished": now(), "summary": dict(summary or {}), **meta})

    @contextmanager
    def _transaction(self, patience: float = 0.0) -> Iterator[None]:
        """A transaction, or more of the one that gathers: it ends unless the last ended less than ``patience`` seconds ago."""
        if not self._waiting:
            self._connection.execute("BEGIN IMMEDIATE")
        self._waiting = True
        try:
            yield
        except BaseException:
            self._waiting = False
            self._connection.rollback()
            raise
        if not self._gather or time.monotonic() - self._kept >= patience:
            self._settle()

    def _settle(self) -> None:
        """Brings to the disk what was gathered."""
        self._waiting = False
        self._connection.commit()
        self._kept = time.monotonic()

    def _put(self, meta: Mapping[str, Any]) -> None:
        entries, arrays = parted(meta)
        self._connection.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", [(key, json.dumps(value)) for key, value in entries.items()])
        self._connection.executemany("INSERT OR REPLACE INTO arrays VALUES (?, ?)", [(key, packed(values)) for key, values in arrays.items()])

    def _forget(self) -> None:
        for table in ("history", "steps", "checkpoints", "companions"):
            self._connection.execute(f"DELETE FROM {table}")

    # ------------------------------------------------------------------------------------------------------- reading

    @property
    @told
    def meta(self) -> dict[str, Any]:
        """What is known of the run: model text, start, versions, step, loop, kept rows, laws, status, summary."""
        found: dict[str, Any] = {key: json.loads(text) for key, text in self._connection.execute("SELECT key, json FROM meta")}
        if self._connection.execute("PRAGMA user_version").fetchone()[0] > 1:
            found |= {key: unpacked(data) for key, data in self._connection.execute("SELECT key, data FROM arrays")}
        return found

    @told
    def knows(self, key: str) -> bool:
        """Whether the meta has an entry."""
        return self._connection.execute("SELECT 1 FROM meta WHERE key = ?", (key,)).fetchone() is not None

    @property
    @told
    def steps(self) -> NDArray[np.int64]:
        """Step numbers of the outputs, shape (outputs,)."""
        found = self._connection.execute("SELECT step FROM steps ORDER BY output")
        return np.fromiter((step for (step,) in found), dtype=np.int64)

    @property
    @told
    def rows(self) -> NDArray[np.float64]:
        """Recorded rows, shape (outputs, kept)."""
        total, filled = int(self._connection.execute("SELECT coalesce(sum(outputs), 0) FROM history").fetchone()[0]), 0
        rows: NDArray[np.float64] = np.zeros((0, 0))
        for first, outputs, data in self._connection.execute("SELECT first, outputs, data FROM history ORDER BY chunk"):
            part = unpacked(data)
            if filled == 0 and part.ndim == 2 and len(part) == outputs:
                rows = space(total, part.shape[1])
            if first != filled or part.shape != (outputs, rows.shape[1]) or filled + len(part) > total:
                raise RunFileError(damaged(self, f"the outputs from {first} on do not follow those before"))
            rows[filled : filled + len(part)] = part
            filled += len(part)
        return rows

    @told
    def later(self) -> Callable[[], NDArray[np.float64]]:
        """What reads :attr:`rows` when they are asked for, also after this file is closed."""
        self._settle()
        return partial(rows_of, self.path.absolute())

    @told
    def companions(self) -> tuple[dict[str, Any], NDArray[np.int64], NDArray[np.float64]] | None:
        """What is told of the companions, their steps, and their rows, shape (outputs, kept times companions); None without any."""
        if self._connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'companions'").fetchone() is None:
            return None  # a file of version 0.2 or before
        chunks = self._connection.execute("SELECT first, outputs, told, data FROM companions ORDER BY first").fetchall()
        if not chunks:
            return None
        every, parts = self.steps, [unpacked(data) for *_, data in chunks]
        steps = [every[first : first + outputs] for first, outputs, *_ in chunks]
        if any(len(one) != len(part) or part.ndim != 2 or part.shape[1] != parts[0].shape[1] for one, part in zip(steps, parts, strict=True)):
            raise RunFileError(damaged(self, "the outputs of the companions do not fit those of the run"))
        return json.loads(chunks[-1][2]), np.concatenate(steps), np.concatenate(parts)

    @told
    def last_checkpoint(self) -> tuple[int, NDArray[np.float64]] | None:
        """Step number and state S of the latest checkpoint, or None."""
        row = self._connection.execute("SELECT step, state FROM checkpoints ORDER BY step DESC LIMIT 1").fetchone()
        return None if row is None else (int(row[0]), unpacked(row[1]))

    @property
    @told
    def events(self) -> list[tuple[int, str, str]]:
        """Step, time (UTC) and text of the events, in their order."""
        return list(self._connection.execute("SELECT step, time, text FROM events ORDER BY number"))

    @property
    @told
    def has_reference(self) -> bool:
        """Whether the record of the ideal mechanism is kept."""
        return self._connection.execute("SELECT 1 FROM reference LIMIT 1").fetchone() is not None

    @told
    def reference(self) -> tuple[dict[str, Any], NDArray[np.int64], NDArray[np.float64]] | None:
        """Meta, steps and rows of the ideal mechanism's record, or None."""
        parts = dict(self._connection.execute("SELECT part, data FROM reference").fetchall())
        if not parts:
            return None
        meta = json.loads(parts["meta"]) | {key.removeprefix(ARRAY): unpacked(data) for key, data in parts.items() if key.startswith(ARRAY)}
        return meta, unpacked(parts["steps"]).astype(np.int64), unpacked(parts["rows"])


def parted(meta: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
    """What JSON can say, and arrays."""
    arrays = {key: value for key, value in meta.items() if isinstance(value, np.ndarray)}
    return {key: value for key, value in meta.items() if key not in arrays}, arrays


def space(outputs: int, width: int) -> NDArray[np.float64]:
    """Room for rows: memory, or where they are many a file of no name, of which the system keeps in memory what is looked at."""
    if 8 * outputs * width <= IN_MEMORY:
        return np.empty((outputs, width))
    import tempfile

    with tempfile.TemporaryFile() as file:
        return np.memmap(file, dtype=float, mode="w+", shape=(outputs, width)).view(np.ndarray)


def rows_of(path: Path) -> NDArray[np.float64]:
    """Recorded rows of a run file."""
    with RunFile.open(path) as file:
        return file.rows


def _readable(path: Path) -> sqlite3.Connection:
    """A connection that can read the file; the journal of a killed writer is rolled back first.

    That needs to write: where it cannot be done in place, it is done on a copy that vanishes.
    """
    try:
        connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=rw", uri=True, timeout=60.0, isolation_level=None)
        connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
        connection.execute("PRAGMA query_only = ON")
        return connection
    except sqlite3.OperationalError as error:
        if "locked" in str(error):
            raise RunFileError(f"{path}: another program keeps this run file locked; try again when it has ended") from error
    except sqlite3.DatabaseError as error:
        raise RunFileError(damaged(path, str(error))) from error
    import tempfile

    memory = sqlite3.connect(":memory:", isolation_level=None)
    try:
        with tempfile.TemporaryDirectory() as folder:
            for name in (path.name, f"{path.name}-journal"):
                if (path.parent / name).exists():
                    shutil.copy(path.parent / name, folder)
                    (Path(folder) / name).chmod(0o600)
            copy = sqlite3.connect(Path(folder) / path.name)
            copy.backup(memory)
            copy.close()
    except (sqlite3.DatabaseError, OSError) as error:
        raise RunFileError(damaged(path, str(error))) from error
    return memory


def now() -> str:
    """The present time (UTC)."""
    return datetime.now(UTC).isoformat(timespec="seconds")
