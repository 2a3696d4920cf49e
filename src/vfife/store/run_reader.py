"""Reading of run files: metadata, outputs, companions, checkpoints, events and reference.

Chunks are read into memory or, if there are many, into a mapped file without a name. A damaged entry of the
metadata is read from its copy, and so is the first output; other damaged outputs are left out and named.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from ..solvers.record import PIECE_BYTES, READ_IN_MEMORY, Checkpoint, release, room_for_rows
from .packing import seal, unpacked
from .schemas import RUN, Schema
from .store import Row, Store

Array = NDArray[np.float64]
Steps = NDArray[np.int64]
LARGE = 10**8  # bytes of a file above which its outputs are read when they are first used
ARRAY = "array."  # prefix of arrays of the meta among the parts of a reference
KEYS = "*"  # entry of the meta that names all others, so that a missing one is noticed
FIRST = "first output"  # key of the copy of the first output
# entry with the numbers of rows of a run that ended, so that a table without any row is noticed
COUNTED = "counted"
META = (("meta", "json"), ("arrays", "data"))  # tables of entries and their columns


class StoredRecord(NamedTuple):
    """Rows of companions or of the ideal reference, shape (outputs, rows), steps, shape (outputs,), and their
    meta.
    """

    meta: dict[str, Any]
    steps: Steps
    rows: Array


class Chunk(NamedTuple):
    """Outputs of one transaction: number of the first one, steps, shape (outputs,), and rows, shape (outputs,
    kept).
    """

    first: int
    steps: Steps
    rows: Array


class RunReader(Store):
    """A run file open for reading. ``damaged_parts`` names what was found damaged and is left out."""

    schema: ClassVar[Schema] = RUN

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        super().__init__(path, connection)
        self._damaged_parts: dict[str, None] = {}

    def examine(self) -> None:
        """Read the metadata, so that a damaged file is reported now; other rows are checked when they are
        read.
        """
        _ = self.meta

    # --------------------------------------------------------------------------------------------------- meta

    @property
    def damaged_parts(self) -> tuple[str, ...]:
        """Descriptions of what was found damaged so far and is left out."""
        return tuple(self._damaged_parts)

    def _report_damage(self, part: str) -> None:
        self._damaged_parts[part] = None

    @property
    def meta(self) -> dict[str, Any]:
        """Model text, start, versions, step, loop, kept rows, laws, status and summary of the run. Raises
        RunFileError.
        """
        entries: dict[str, Any] = {}
        missing_entries: set[str] = set()
        copies = [str(key) for key in self.keys("copies")]
        with self.reported():
            for table, _ in META:
                prefix = f"{table}."
                for key in {
                    *self.keys(table),
                    *(key.removeprefix(prefix) for key in copies if key.startswith(prefix)),
                }:
                    value = self._entry(table, key)
                    if value is None:
                        missing_entries.add(str(key))
                    else:
                        entries[str(key)] = json.loads(value) if table == "meta" else unpacked(value)
        names = entries.pop(KEYS, None)
        if names is None and (entries or missing_entries):
            self._report_damage("the list of its metadata")
        for name in sorted((missing_entries | set(names or ())) - set(entries) - {KEYS}):
            self._report_damage(f"its {name}" if name.isprintable() else "an entry of its metadata")
        entries.pop(COUNTED, None)
        if not entries:
            raise RunFileError(self.damaged("no metadata is left"))
        return entries

    def _entry(self, table: str, key: Any) -> Any:
        """Return an entry, or its copy, as stored; None if both are missing or damaged."""
        row = self.row(table, key) or self.row("copies", f"{table}.{key}")
        return None if row is None else row.values[1]

    def _counted(self, table: str) -> Any:
        """Return the number of rows of a table at the end of the run, of the history its chunks and outputs;
        zero before the end, or if unknown.
        """
        with self.reported():
            counts = json.loads(self._entry("meta", COUNTED) or "null")
        return (counts or {"history": (0, 0)}).get(table, 0)

    # ------------------------------------------------------------------------------------------------ history

    @property
    def steps(self) -> Steps:
        """Step numbers of the outputs, shape (outputs,)."""
        return self.outputs(only_steps=True)[0]

    def finished_steps(self) -> Steps | None:
        """Step numbers of a large file that ended, without reading its outputs; None for any other file."""
        if self.path.stat().st_size <= LARGE:
            return None
        try:
            blobs = self._stored_steps()
        except (sqlite3.DatabaseError, UnicodeDecodeError, TypeError):
            return None
        if not blobs or steps_seal(blobs) != self._counted("steps"):
            return None
        with self.reported():
            return np.concatenate([unpacked(data) for data in blobs]).astype(np.int64)

    def _stored_steps(self) -> list[bytes]:
        """Step numbers of all chunks, as they are stored; the outputs in the same rows are not read."""
        return [
            bytes(data) for (data,) in self._connection.execute("SELECT steps FROM history ORDER BY chunk")
        ]

    @property
    def outputs_so_far(self) -> int:
        """Number of outputs that were written."""
        return self._present_counts()[1]

    @property
    def rows(self) -> Array:
        """Recorded rows, shape (outputs, rows)."""
        return self.outputs()[1]

    def outputs(self, only_steps: bool = False) -> tuple[Steps, Array]:
        """Read the steps of the outputs, shape (outputs,), and the rows, shape (outputs, rows); damaged
        outputs are omitted and noted.
        """
        chunks, total = self._expected_counts()
        steps, rows, count, at = np.zeros(total, dtype=np.int64), np.zeros((0, 0)), 0, 0
        unreleased = 0  # bytes of a mapped array that are in memory
        # Outputs are placed one after the other, gaps closed: readers get the step numbers of what remains.
        for first, chunk_steps, values in self._chunks(chunks, only_steps):
            if first > at:
                self._report_damage(missing(at, first))
            if not only_steps and rows.size == 0:
                rows = room_for_rows(total, values.shape[1], READ_IN_MEMORY)
            if len(chunk_steps) > total - count or not (
                only_steps or values.shape == (len(chunk_steps), rows.shape[1])
            ):
                self._report_damage(missing(first, first + len(chunk_steps)))
                continue
            steps[count : count + len(chunk_steps)] = chunk_steps
            if not only_steps:
                rows[count : count + len(chunk_steps)] = values
                unreleased += values.nbytes
                if unreleased > PIECE_BYTES:
                    release(rows)
                    unreleased = 0
            count, at = count + len(chunk_steps), first + len(chunk_steps)
        if at < total:
            self._report_damage(missing(at, total))
        return steps[:count], rows[:count]

    def later(self) -> Callable[[], Array]:
        """Return a function that reads the rows of the outputs, which works after this file is closed."""
        self.flush()
        return partial(rows_of, self.path.absolute())

    def _present_counts(self) -> tuple[int, int]:
        """Numbers of chunks and outputs in the file."""
        row = self.query("SELECT chunk + 1, first + outputs FROM history ORDER BY chunk DESC LIMIT 1")
        return (0, 0) if row is None else (int(row[0]), int(row[1]))

    def _expected_counts(self) -> tuple[int, int]:
        """Return the numbers of chunks and outputs that should be in the file: the largest that any intact
        row states.
        """
        # A run that was killed has no final counts. Every checkpoint states how many outputs preceded it, so
        # that lost chunks at the end of the history are noticed as long as one checkpoint is intact.
        chunks, outputs = self._counted("history")
        counts = [(int(chunks), int(outputs))]
        counts += [
            (int(row["chunks"]), int(row["outputs"]))
            for _, row in self.read("checkpoints")
            if row is not None
        ]
        for chunk in reversed(self.keys("history")):
            row = self.row("history", chunk)
            if row is not None:
                counts.append((int(row["chunk"]) + 1, int(row["first"]) + int(row["outputs"])))
                break
        return max(chunks for chunks, _ in counts), max(outputs for _, outputs in counts)

    def _chunks(self, chunks: int, only_steps: bool) -> Iterator[Chunk]:
        """Yield the intact chunks; if the first is damaged, at least the copy of its first output."""
        # Output 0 is stored twice, because energies and works are counted from it: without it no later output
        # of the run could be used.
        last = -1
        for chunk in range(chunks):
            part = self._chunk(chunk, last, only_steps)
            if part is None and chunk == 0 and (row := self.row("copies", FIRST)) is not None:
                with self.reported():
                    part = Chunk(
                        0,
                        np.zeros(1, dtype=np.int64),
                        np.zeros((0, 0)) if only_steps else unpacked(row["data"]),
                    )
            if part is not None:
                last = int(part.steps[-1])
                yield part

    def _chunk(self, chunk: int, last: int, only_steps: bool) -> Chunk | None:
        """Return a chunk; None if it is damaged, or its steps do not increase from ``last`` on."""
        row = self.row("history", chunk)
        if row is None:
            return None
        steps = row["steps"].astype(np.int64)
        if len(steps) != row["outputs"] or len(steps) == 0 or steps[0] <= last or (np.diff(steps) <= 0).any():
            return None
        return Chunk(int(row["first"]), steps, np.zeros((0, 0)) if only_steps else row["data"])

    # ------------------------------------------------------------------------------ what belongs to a history

    def _sound_rows(self, table: str, part: str) -> list[Row] | None:
        """Return all rows of a table; None if some are damaged or missing, which is noted."""
        stored = [row for _, row in self.read(table)]
        rows = [row for row in stored if row is not None]
        if len(rows) == len(stored) >= self._counted(table):
            return rows
        self._report_damage(part)
        return None

    def companions(self) -> StoredRecord | None:
        """Return the rows of the companions, shape (outputs, kept times companions); None without any, or if
        they are damaged.
        """
        chunks = self._sound_rows("companions", "the companions")
        if not chunks:
            return None
        steps, parts = [row["steps"].astype(np.int64) for row in chunks], [row["data"] for row in chunks]
        fit = all(
            len(numbers) == len(part) and part.ndim == 2 and part.shape[1] == parts[0].shape[1]
            for numbers, part in zip(steps, parts, strict=True)
        )
        follow = all(
            chunk["first"] + chunk["outputs"] == next_chunk["first"]
            for chunk, next_chunk in zip(chunks, chunks[1:], strict=False)
        )
        if not (fit and follow):
            self._report_damage("the companions")
            return None
        return StoredRecord(chunks[-1]["told"], np.concatenate(steps), np.concatenate(parts))

    def turns(self) -> Array:
        """Return the extremes of the companions in each full turn, shape (turns, rows, companions); without
        turns if damaged.
        """
        rows = [row for _, row in self.read("turns")]  # a table that is missing has no rows
        parts = [row["data"] for row in rows if row is not None]
        if [row and row["turn"] for row in rows] != list(range(1, len(rows) + 1)) or len(
            {part.shape for part in parts}
        ) > 1:
            self._report_damage("the companions' turns")
            return np.zeros((0, 0, 0))
        return np.array(parts) if parts else np.zeros((0, 0, 0))

    def latest(self) -> Checkpoint | None:
        """Return the latest intact checkpoint, from which the run can continue; None without any."""
        stored = list(self.read("checkpoints"))
        if len(stored) < self._counted("checkpoints"):
            self._report_damage("a checkpoint")
        for step, row in reversed(stored):
            if row is not None:
                return Checkpoint(
                    int(row["step"]), row["state"], row["more"], int(row["chunks"]), int(row["outputs"])
                )
            self._report_damage(f"the checkpoint of step {step:,}")
        return None

    def last_checkpoint(self) -> tuple[int, Array] | None:
        """Step number and state S of the latest checkpoint, or None."""
        if (latest := self.latest()) is None:
            return None
        values = latest.values
        return latest.step, values if values.ndim == 1 else np.ascontiguousarray(values[:, 0])

    @property
    def events(self) -> list[tuple[int, str, str]]:
        """Step, time (UTC) and text of the events, in their order."""
        stored = [row.values[1:] for _, row in self.read("events") if row is not None]
        if len(stored) < self._counted("events"):
            self._report_damage("some of its events")
        return [(step, time, text) for step, time, text in stored]

    @property
    def has_reference(self) -> bool:
        """Whether the record of the ideal mechanism is there."""
        return self.query("SELECT 1 FROM reference LIMIT 1") is not None

    def reference(self) -> StoredRecord | None:
        """Return the meta, steps and rows of the ideal mechanism's record; None without any, or if it is
        damaged.
        """
        rows = self._sound_rows("reference", "the ideal reference")
        if not rows:
            return None
        with self.reported():
            record = _reference_of({row["part"]: row["data"] for row in rows})
        if record is None:
            self._report_damage("the ideal reference")
        return record


def _reference_of(parts: Mapping[str, bytes]) -> StoredRecord | None:
    """Record of the rows of its table; None if some of them are missing."""
    blocks = sorted(
        (key for key in parts if key.startswith("rows")), key=lambda key: int(key.partition(".")[2] or 0)
    )
    meta = json.loads(parts.get("meta", b"{}"))
    if not blocks or not {"meta", "steps", *meta.pop(KEYS, ())} <= set(parts):
        return None
    meta |= {key.removeprefix(ARRAY): unpacked(data) for key, data in parts.items() if key.startswith(ARRAY)}
    steps = unpacked(parts["steps"]).astype(np.int64)
    rows = np.concatenate([unpacked(parts[key]) for key in blocks])
    return StoredRecord(meta, steps, rows) if len(steps) == len(rows) else None


def steps_seal(blobs: list[bytes]) -> str:
    """Return the seal of all step numbers."""
    return seal("steps", *blobs).hex()


def missing(first: int, end: int) -> str:
    """Return a description of missing outputs."""
    return f"output {first:,}" if end == first + 1 else f"outputs {first:,} to {end - 1:,}"


def rows_of(path: Path) -> Array:
    """Read the recorded rows of a run file. Raises RunFileError where some of them are damaged."""
    with RunReader.open(path) as file:
        rows = file.rows
        if file.damaged_parts:
            raise RunFileError(file.damaged(", ".join(file.damaged_parts)))
        return rows
