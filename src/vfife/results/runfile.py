"""One SQLite file a run: model, start, versions, history, checkpoints, events; whole up to the last transaction.

Rows of S are stored chunk by chunk, each in one transaction with the checkpoint that goes on from its end, and read into memory or, where they
are many, into a mapped file of no name. Every row of every table is sealed: one that was damaged is left out and told, the others are used.
SQLite keeps its rollback journal (no write-ahead log), so a finished run is one file. A transaction waits several times for the disk, so
those of a short run are gathered.
"""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError, StorageError
from ..solvers.record import Checkpoint
from . import formerfile, tables
from . import meta as known
from .header import APPLICATION, FORMAT, is_run_file
from .opening import connected, readable, run_file_at
from .packing import packed, unpacked
from .space import space
from .tables import damaged, told, unwritten
from .transactions import Transactions

if TYPE_CHECKING:
    from ..solvers.companions import Beside

CHECKPOINTS = 2  # the latest ones are kept
LARGE = 10**8  # bytes of a file whose outputs are read when they are asked for


class RunFile(Transactions):
    """A run file, open for writing (:meth:`create`, :meth:`write`) or reading (:meth:`open`); a context manager that closes it.

    ``lost`` says, after reading, what was damaged and is left out.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection, gather: float = 0.0) -> None:
        super().__init__(connection)
        self.path, self._gather = path, gather
        self.version = int(connection.execute("PRAGMA user_version").fetchone()[0])
        self._lost: dict[str, None] = {}
        self._next: dict[str, Any] = {}  # the meta of a try whose first output is still to come
        self.arrive: Callable[[], Path] | None = None  # moves the file to its place, once its first outputs are in it

    @classmethod
    def create(cls, path: str | Path, meta: Mapping[str, Any] | None = None, *, replace: bool = False, gather: float = 0.0) -> RunFile:
        """A new run file with ``meta``: anything JSON can say, and arrays; best from :func:`~vfife.results.provenance.provenance`.

        What is written within ``gather`` seconds becomes one transaction, which ends with a checkpoint; each is one of its own by default.
        Raises RunFileError where the file cannot be made, or is there already and ``replace`` is false, or is no run file.
        """
        path = Path(path)
        if path.exists():
            if not replace:
                raise RunFileError(f"{path}: there is a run file already; name another one or remove it first")
            if not is_run_file(path):
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
    def open(cls, path: str | Path) -> RunFile:
        """A run file, or that of a run folder, for reading; also one whose writer was killed or is still at work."""
        path = run_file_at(path)
        file = cls(path, readable(path))
        file.meta  # noqa: B018 - a damaged file is told here, not at its first use
        return file

    @classmethod
    def write(cls, path: str | Path, *, gather: float = 0.0) -> RunFile:
        """A run file that is there, to go on with. Raises RunFileError for one of a former format, which has no such checkpoints."""
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

    def _counts(self) -> tuple[int, int]:
        """Chunks and outputs there are."""
        row = self._connection.execute("SELECT chunk + 1, first + outputs FROM history ORDER BY chunk DESC LIMIT 1").fetchone()
        return (0, 0) if row is None else (int(row[0]), int(row[1]))

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

    # ------------------------------------------------------------------------------------------------------- reading

    @property
    def sealed(self) -> bool:
        """Whether every row has its seal."""
        return self.version > 2

    @property
    def lost(self) -> tuple[str, ...]:
        """What was found damaged so far, and is left out."""
        return tuple(self._lost)

    def _lose(self, what: str) -> None:
        self._lost[what] = None

    @property
    @told
    def meta(self) -> dict[str, Any]:
        """What is known of the run: model text, start, versions, step, loop, kept rows, laws, status, summary."""
        if not self.sealed:
            return formerfile.meta(self._connection, self.version)
        found = known.read(self._connection, self._lose)
        if not found:
            raise RunFileError(damaged(self, "nothing is left of what it says"))
        return found

    @told
    def knows(self, key: str) -> bool:
        """Whether the meta has an entry."""
        return self._connection.execute("SELECT 1 FROM meta WHERE key = ?", (key,)).fetchone() is not None

    @property
    def steps(self) -> NDArray[np.int64]:
        """Step numbers of the outputs, shape (outputs,)."""
        return self.outputs(only_steps=True)[0]

    @told
    def steps_alone(self) -> NDArray[np.int64] | None:
        """The same of a large file of a run that ended, soon, for no output is read, nor its damage seen; None of any other."""
        large = self.sealed and self.path.stat().st_size > LARGE
        return known.steps_alone(self._connection) if large else None

    @property
    @told
    def outputs_so_far(self) -> int:
        """How many outputs were written."""
        return self._counts()[1]

    @property
    def rows(self) -> NDArray[np.float64]:
        """Recorded rows, shape (outputs, kept)."""
        return self.outputs()[1]

    @told
    def outputs(self, only_steps: bool = False) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Steps of the outputs, shape (outputs,), and their rows, shape (outputs, kept); those that are damaged are left out, and told."""
        if not self.sealed:
            rows = np.zeros((0, 0)) if only_steps else formerfile.rows(self._connection, self)
            return formerfile.steps(self._connection), rows
        chunks, total = self._planned()
        steps, rows, filled, at = np.zeros(total, dtype=np.int64), np.zeros((0, 0)), 0, 0
        for first, own, values in self._chunks(chunks, only_steps):
            if first > at:
                self._lose(tables.missing(at, first))
            if not only_steps and rows.size == 0:
                rows = space(total, values.shape[1])
            if len(own) > total - filled or not (only_steps or values.shape == (len(own), rows.shape[1])):
                self._lose(tables.missing(first, first + len(own)))
                continue
            steps[filled : filled + len(own)] = own
            if not only_steps:
                rows[filled : filled + len(own)] = values
            filled, at = filled + len(own), first + len(own)
        if at < total:
            self._lose(tables.missing(at, total))
        return steps[:filled], rows[:filled]

    def _planned(self) -> tuple[int, int]:
        """Chunks and outputs that there should be."""
        numbers = tables.keys(self._connection, "history")
        chunks, total = known.counted(self._connection, "history")
        counts = [(int(chunks), int(total))]
        for _, row in tables.each(self._connection, "checkpoints"):
            counts += [(int(row[1]), int(row[2]))] if row is not None else []
        for chunk in reversed(numbers):
            row = tables.sound(self._connection, "history", chunk)
            if row is not None:
                counts.append((int(row[0]) + 1, int(row[1]) + int(row[2])))
                break
        return max(chunks for chunks, _ in counts), max(outputs for _, outputs in counts)

    def _chunks(self, chunks: int, only_steps: bool) -> Iterator[tuple[int, NDArray[np.int64], NDArray[np.float64]]]:
        """First output, steps and rows of each chunk that is whole; of the first one, where it is not, at least its first output."""
        last = -1
        for chunk in range(chunks):
            part = self._chunk(chunk, last, only_steps)
            if part is None and chunk == 0 and (row := known.first_output(self._connection)) is not None:
                part = 0, np.zeros(1, dtype=np.int64), np.zeros((0, 0)) if only_steps else row
            if part is not None:
                last = int(part[1][-1])
                yield part

    def _chunk(self, chunk: int, last: int, only_steps: bool) -> tuple[int, NDArray[np.int64], NDArray[np.float64]] | None:
        """First output, steps and rows of a chunk; None where it is damaged, or its steps do not rise from ``last`` on."""
        row = tables.sound(self._connection, "history", chunk)
        if row is None:
            return None
        steps = unpacked(row[3]).astype(np.int64)
        if len(steps) != row[2] or len(steps) == 0 or steps[0] <= last or (np.diff(steps) <= 0).any():
            return None
        return int(row[1]), steps, np.zeros((0, 0)) if only_steps else unpacked(row[4])

    @told
    def later(self) -> Callable[[], NDArray[np.float64]]:
        """What reads :attr:`rows` when they are asked for, also after this file is closed."""
        self._settle()
        return partial(rows_of, self.path.absolute())

    @told
    def companions(self) -> tuple[dict[str, Any], NDArray[np.int64], NDArray[np.float64]] | None:
        """What is told of the companions, their steps, and their rows, shape (outputs, kept times companions); None without any, or where they are
        damaged.
        """
        if not self.sealed:
            return formerfile.companions(self._connection, self)
        found = list(tables.each(self._connection, "companions"))
        if len(found) < known.counted(self._connection, "companions"):
            self._lose("the companions")
            return None
        chunks = [row for _, row in found if row is not None]
        steps, parts = [unpacked(row[4]).astype(np.int64) for row in chunks], [unpacked(row[5]) for row in chunks]
        fit = all(len(one) == len(part) and part.ndim == 2 and part.shape[1] == parts[0].shape[1] for one, part in zip(steps, parts, strict=True))
        follow = all(one[0] + one[1] == other[0] for one, other in zip(chunks, chunks[1:], strict=False))
        if len(chunks) != len(found) or not (fit and follow):
            self._lose("the companions")
            return None
        return (json.loads(chunks[-1][3]), np.concatenate(steps), np.concatenate(parts)) if chunks else None

    @told
    def turns(self) -> NDArray[np.float64]:
        """What companions leave of each whole turn, shape (turns, kept, companions); without any where they are damaged, or none were kept."""
        if not self.sealed or not tables.has(self._connection, "turns"):
            return np.zeros((0, 0, 0))
        found = list(tables.each(self._connection, "turns"))
        rows = [row for _, row in found if row is not None]
        parts = [unpacked(row[2]) for row in rows]
        if [row[0] for row in rows] != list(range(1, len(found) + 1)) or len({part.shape for part in parts}) > 1:
            self._lose("the companions' turns")
            return np.zeros((0, 0, 0))
        return np.array(parts) if parts else np.zeros((0, 0, 0))

    @told
    def latest(self) -> Checkpoint | None:
        """The latest checkpoint that is whole, from which the run can go on; None where there is none, or the file is of a former format."""
        if not self.sealed:
            return None
        found = list(tables.each(self._connection, "checkpoints"))
        if len(found) < known.counted(self._connection, "checkpoints"):
            self._lose("a checkpoint")
        for step, row in reversed(found):
            if row is None:
                self._lose(f"the checkpoint of step {step:,}")
                continue
            return Checkpoint(int(row[0]), unpacked(row[4]), json.loads(row[3]), int(row[1]), int(row[2]))
        return None

    @told
    def last_checkpoint(self) -> tuple[int, NDArray[np.float64]] | None:
        """Step number and state S of the latest checkpoint, or None."""
        if not self.sealed:
            return formerfile.checkpoint(self._connection)
        found = self.latest()
        return None if found is None else (found.step, found.values if found.values.ndim == 1 else np.ascontiguousarray(found.values[:, 0]))

    @property
    @told
    def events(self) -> list[tuple[int, str, str]]:
        """Step, time (UTC) and text of the events, in their order."""
        if not self.sealed:
            return list(self._connection.execute("SELECT step, time, text FROM events ORDER BY number"))
        found = [row[1:] for _, row in tables.each(self._connection, "events") if row is not None]
        if len(found) < known.counted(self._connection, "events"):
            self._lose("some of its events")
        return found

    @property
    @told
    def has_reference(self) -> bool:
        """Whether the record of the ideal mechanism is kept."""
        return self._connection.execute("SELECT 1 FROM reference LIMIT 1").fetchone() is not None

    @told
    def reference(self) -> tuple[dict[str, Any], NDArray[np.int64], NDArray[np.float64]] | None:
        """Meta, steps and rows of the ideal mechanism's record; None where there is none, or it is damaged."""
        if self.sealed:
            found = dict(tables.each(self._connection, "reference"))
            parts = {key: row[1] for key, row in found.items() if row is not None}
            if len(parts) != max(len(found), known.counted(self._connection, "reference")):
                self._lose("the ideal reference")
                return None
        else:
            parts = formerfile.reference(self._connection)
        if not parts:
            return None
        found_again = known.reference_of(parts)
        if found_again is None:
            self._lose("the ideal reference")
        return found_again


def rows_of(path: Path) -> NDArray[np.float64]:
    """Recorded rows of a run file. Raises RunFileError where some of them are damaged."""
    with RunFile.open(path) as file:
        rows = file.rows
        if file.lost:
            raise RunFileError(damaged(path, ", ".join(file.lost)))
        return rows
