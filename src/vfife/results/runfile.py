"""One SQLite file a run: model, start, versions, history, checkpoints, events; whole up to the last transaction.

Rows of S are stored chunk by chunk, each in one transaction with the checkpoint that goes on from its end. SQLite keeps its rollback journal (no
write-ahead log), so a finished run is one file. A transaction waits several times for the disk, so those of a short run are gathered.
"""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError, StorageError
from ..solvers.record import Checkpoint
from . import meta as known
from . import tables
from .header import APPLICATION, FORMAT, is_run_file
from .opening import connected, run_file_at
from .packing import packed
from .storedrun import StoredRun
from .tables import told, unwritten

if TYPE_CHECKING:
    from ..solvers.companions import Beside

CHECKPOINTS = 2  # the latest ones are kept


class RunFile(StoredRun):
    """A run file, open for writing (:meth:`create`, :meth:`write`) or reading (:meth:`open`); a context manager that closes it."""

    def __init__(self, path: Path, connection: sqlite3.Connection, gather: float = 0.0) -> None:
        super().__init__(path, connection)
        self._gather = gather
        self._next: dict[str, Any] = {}  # the meta of a try whose first output is still to come
        self.arrive: Callable[[], Path] | None = None  # moves the file to its place, once its first outputs are in it

    @classmethod
    def create(cls, path: str | Path, meta: Mapping[str, Any] | None = None, *, replace: bool = False, gather: float = 0.0) -> RunFile:
        """A new run file with ``meta``: anything JSON can say, and arrays; best from :func:`~vfife.results.provenance.provenance`.

        What is written within ``gather`` seconds becomes one transaction, which ends with a checkpoint; each is one of its own by default.
        Raises StorageError where the file cannot be made, RunFileError where it is there already and ``replace`` is false, or is no run file.
        """
        path = Path(path)
        if path.exists():
            if not replace:
                raise RunFileError(f"{path}: there is a run file already; name another one or remove it first")
            if path.stat().st_size and not is_run_file(path):
                raise RunFileError(f"{path}: there is another file of this name, which is no run file of vfife; name another one")
            for old in (path, path.with_name(path.name + "-journal")):
                old.unlink(missing_ok=True)
        try:
            connection = connected(path)
            connection.execute(f"PRAGMA application_id = {APPLICATION}")
            connection.execute(f"PRAGMA user_version = {FORMAT}")
            file = cls(path, connection, gather)
            with file._transaction():
                for statement in tables.SCHEMA:
                    connection.execute(statement)
                file._put({"status": "running", "created": tables.now(), **(meta or {})})
        except sqlite3.Error as error:
            raise StorageError(f"{unwritten(str(path), f'no run file can be made here ({error})')} Name a folder you can write to") from error
        return file

    @classmethod
    def write(cls, path: str | Path, *, gather: float = 0.0) -> RunFile:
        """A run file that is there, to go on with. Raises RunFileError for one of a former format, which has no such checkpoints, StorageError."""
        path = run_file_at(path)
        try:
            file = cls(path, connected(path), gather)
            if file.sealed:
                tables.complete(file._connection)
                return file
        except sqlite3.Error as error:
            raise StorageError(unwritten(str(path), str(error))) from error
        file.close()
        raise RunFileError(f"{path}: a former version wrote this run, without all it takes to go on; run the model again (vfife run)")

    @told
    def begin(self, meta: Mapping[str, Any]) -> None:
        """Starts the run anew, as after a try with too large a step: ``meta`` is replaced key by key, and what was computed gives way, once the
        first output of the new try is there.
        """
        self._next = {"status": "running", **meta}
        if self._counts() == (0, 0):
            with self._transaction():
                self._anew()

    @told
    def put(self, meta: Mapping[str, Any]) -> None:
        """Replaces entries of the meta."""
        with self._transaction():
            self._put(meta)

    @told
    def append(
        self, steps: NDArray[np.int64], rows: NDArray[np.float64], beside: Beside | None = None, checkpoint: Checkpoint | None = None
    ) -> None:
        """Adds outputs in one transaction: steps, shape (outputs,), and rows, shape (outputs, kept). Step 0 starts
        anew. ``beside`` is what companions leave at the last of these outputs; of theirs only those still needed stay. ``checkpoint`` is the
        state at their end.
        """
        if len(steps) == 0 and checkpoint is None:
            return
        with self._transaction(math.inf if checkpoint is None else self._gather):
            if len(steps):
                self._append(steps, rows, beside)
            if checkpoint is not None:
                self._checkpoint(checkpoint)
        if self.arrive is not None and len(steps):
            self._move(self.arrive)

    def _append(self, steps: NDArray[np.int64], rows: NDArray[np.float64], beside: Beside | None) -> None:
        if int(steps[0]) == 0:
            self._anew()
            self._insert("copies", known.FIRST, packed(rows[:1]))
        chunk, first = self._counts()
        self._insert("history", chunk, first, len(steps), packed(steps.astype(float)), packed(rows))
        if beside is not None:
            outputs = len(beside.rows)
            values = json.dumps(beside.told), packed(steps[len(steps) - outputs :].astype(float)), packed(beside.rows.reshape(outputs, -1))
            self._insert("companions", first + len(steps) - outputs, outputs, int(steps[-1]), *values)
            self._connection.execute("DELETE FROM companions WHERE last < ?", (beside.oldest,))
            for turn, values in enumerate(beside.turns, beside.first):
                self._insert("turns", turn, turn * beside.steps, packed(values))

    @told
    def checkpoint(self, step: int, state: NDArray[np.float64], more: Mapping[str, Any] | None = None) -> None:
        """Keeps the state after ``step``, from which a run can go on, in the order of the blocks of the start, shape (rows,) or (rows, lanes).

        ``more``: what the solver needs beside it, for JSON.
        """
        with self._transaction(self._gather):
            self._checkpoint(Checkpoint(step, state, more or {}))

    def _checkpoint(self, checkpoint: Checkpoint) -> None:
        more = json.dumps(dict(checkpoint.more))
        self._insert("checkpoints", int(checkpoint.step), *self._counts(), more, packed(checkpoint.values))
        old = "DELETE FROM checkpoints WHERE step NOT IN (SELECT step FROM checkpoints ORDER BY step DESC LIMIT ?)"
        self._connection.execute(old, (CHECKPOINTS,))

    @told
    def rewind(self, checkpoint: Checkpoint) -> None:
        """Takes away what was written after a checkpoint, from which the run goes on."""
        with self._transaction():
            for table, column in (("checkpoints", "step"), ("companions", "last"), ("turns", "last")):
                self._connection.execute(f"DELETE FROM {table} WHERE {column} > ?", (checkpoint.step,))
            self._connection.execute("DELETE FROM history WHERE chunk >= ?", (checkpoint.chunks,))
            self._put({known.COUNTED: None})

    @told
    def event(self, step: int, text: str) -> None:
        """Notes that something happened after ``step``."""
        with self._transaction():
            number = self._connection.execute("SELECT coalesce(max(number) + 1, 1) FROM events").fetchone()[0]
            self._insert("events", int(number), int(step), tables.now(), text)

    @told
    def keep_reference(self, meta: Mapping[str, Any], steps: NDArray[np.int64], rows: NDArray[np.float64]) -> None:
        """Keeps the record of the ideal mechanism beside the run."""
        parts = known.reference_parts(meta, steps, rows)
        with self._transaction(math.inf):
            for part, data in parts.items():
                self._insert("reference", part, data)

    @told
    def finish(self, status: str, summary: Mapping[str, Any] | None = None, **meta: Any) -> None:
        """Says how the run ended ("complete", "interrupted", "diverged"), with its summary and what else is known."""
        with self._transaction():
            self._put(
                {
                    "status": status,
                    "finished": tables.now(),
                    "summary": dict(summary or {}),
                    **meta,
                    **known.count(self._connection, self._counts()),
                }
            )

    def _due(self, patience: float) -> bool:
        return not self._gather or self.arrive is not None or super()._due(patience)

    def _insert(self, table: str, *values: Any) -> None:
        self.size += tables.insert(self._connection, table, *values)

    def _move(self, move: Callable[[], Path]) -> None:
        """Brings the file to its place and goes on there."""
        self._settle()
        self._connection.close()
        self.arrive = None
        try:
            self.path = move()
        finally:
            self._connection = connected(self.path)

    def _put(self, meta: Mapping[str, Any]) -> None:
        known.put(self._connection, self._insert, meta)

    def _anew(self) -> None:
        """Takes away what was computed, and says what is computed next."""
        for table in ("history", "checkpoints", "companions", "turns"):
            self._connection.execute(f"DELETE FROM {table}")
        self._put({**self._next, known.COUNTED: None})
        self._next = {}
