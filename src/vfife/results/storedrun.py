"""What a run file says, read: model, start, versions, history, checkpoints, events.

Rows of S lie there chunk by chunk, and are read into memory or, where they are many, into a mapped file of no name. Every row of every table is
sealed: one that was damaged is left out and told, the others are used.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from ..solvers.record import Checkpoint
from . import formerfile, tables
from . import meta as known
from .opening import readable, run_file_at
from .packing import unpacked
from .space import space
from .tables import damaged, told
from .transactions import Transactions

LARGE = 10**8  # bytes of a file whose outputs are read when they are asked for


class StoredRun(Transactions):
    """A run file, open for reading (:meth:`open`); a context manager that closes it.

    ``lost`` says, after reading, what was damaged and is left out.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        super().__init__(path, connection)
        self.version = int(connection.execute("PRAGMA user_version").fetchone()[0])
        self._lost: dict[str, None] = {}

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """A run file, or that of a run folder, for reading; also one whose writer was killed or is still at work. Raises RunFileError."""
        path = run_file_at(path)
        file = cls(path, readable(path))
        file.meta  # noqa: B018 - a damaged file is told here, not at its first use
        return file

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

    def _counts(self) -> tuple[int, int]:
        """Chunks and outputs there are."""
        row = self._connection.execute("SELECT chunk + 1, first + outputs FROM history ORDER BY chunk DESC LIMIT 1").fetchone()
        return (0, 0) if row is None else (int(row[0]), int(row[1]))

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
    with StoredRun.open(path) as file:
        rows = file.rows
        if file.lost:
            raise RunFileError(damaged(path, ", ".join(file.lost)))
        return rows
