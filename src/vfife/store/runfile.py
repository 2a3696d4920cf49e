"""Run files: model, start, versions, history, checkpoints, events, companions, reference.

Outputs are stored in chunks. Each chunk is one transaction with the checkpoint from which the run can
continue after it, so a killed process loses what it computed since the last one and nothing else.
:mod:`~vfife.store.run_reader` reads them.

Every entry of the meta has a copy elsewhere in the file, and so has the first output, from which energies are
counted: a page that is damaged loses none of them. Other rows have no copy, because one of the history would
double the file; outputs that are damaged are left out and named.
"""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from ..solvers.record import Checkpoint
from .connections import writable
from .packing import packed
from .run_reader import ARRAY, COUNTED, FIRST, KEYS, RunReader, steps_seal
from .schemas import is_run_file
from .store import present_time

if TYPE_CHECKING:
    from ..solvers.companions import CompanionOutputs

Array = NDArray[np.float64]
Steps = NDArray[np.int64]
GATHER = 0.25  # s: what a kill may cost, beside the steps that are being taken
CHECKPOINTS = 2  # the latest ones are kept
PART_BYTES = 2**26  # bytes of the reference's rows in one block
NOT_COPIED = {"summary"}  # entries that can be computed again


class RunFile(RunReader):
    """A run file: it is written here, and read as :class:`~vfife.store.run_reader.RunReader` does."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        super().__init__(path, connection)
        self._gather = 0.0
        self._next: dict[str, Any] = {}  # meta of a try that has not written its first output
        # moves the file to its place once its first outputs are in it
        self.arrive: Callable[[], Path] | None = None

    @classmethod
    def create(
        cls, path: str | Path, meta: Mapping[str, Any] | None = None, fill: Callable[[Self],
        object] | None = None, *, replace: bool = False,
        gather: float = 0.0,
    ) -> Self:  # fmt: skip
        """Make a run file with ``meta``: arrays and what JSON can express, as
        :func:`~vfife.results.provenance.provenance` has it.

        What is written within ``gather`` seconds becomes one transaction, which ends with a checkpoint.
        Raises StorageError where the file cannot be made, RunFileError where it is there already and
        ``replace`` is false, or is no run file.
        """
        path = Path(path)
        if path.exists():
            if not replace:
                raise RunFileError(
                    f"{path}: this run file exists already; choose another name, or remove it first"
                )
            if path.stat().st_size and not is_run_file(path):
                raise RunFileError(
                    f"{path}: a file of this name exists that is not a run file of vfife; choose another name"
                )
            path.with_name(path.name + "-journal").unlink(missing_ok=True)
        file = super().create(path, {"status": "running", "created": present_time(), **(meta or {})}, fill)
        file._gather = gather
        return file

    @classmethod
    def write(cls, path: str | Path, *, gather: float = 0.0) -> Self:
        """Open an existing run file for writing. Raises RunFileError, StorageError."""
        file = super().write(path)
        file._gather = gather
        with file.reported():
            file.complete()
        return file

    # ------------------------------------------------------------------------------------------------ writing

    def begin(self, meta: Mapping[str, Any]) -> None:
        """Start the run again, as after a try with too large a step.

        ``meta`` is replaced key by key, and what was computed is removed, with the first output of the new
        try.
        """
        # The former try stays readable until the first output of the next one: a process killed in between
        # leaves a run that can be shown and resumed.
        self._next = {"status": "running", **meta}
        if self._present_counts() == (0, 0):
            with self.transaction():
                self._clear()

    def append(
        self,
        steps: Steps,
        rows: Array,
        companions: CompanionOutputs | None = None,
        checkpoint: Checkpoint | None = None,
    ) -> None:
        """Add outputs in one transaction: steps, shape (outputs,), and rows, shape (outputs, rows); step 0
        starts the run again.

        ``companions``: rows of companions at the last of these outputs; older ones that are no longer needed
        are removed. ``checkpoint``: the state after these outputs.
        """
        if len(steps) == 0 and checkpoint is None:
            return
        # Outputs without a checkpoint wait for the next one: committed alone, they would be removed when the
        # run continues from the checkpoint before them.
        with self.transaction(math.inf if checkpoint is None else self._gather):
            if len(steps):
                self._append(steps, rows, companions)
            if checkpoint is not None:
                self._checkpoint(checkpoint)
        if self.arrive is not None and len(steps):
            self._move(self.arrive)

    def _append(self, steps: Steps, rows: Array, companions: CompanionOutputs | None) -> None:
        if int(steps[0]) == 0:
            self._clear()
            self.insert("copies", FIRST, packed(rows[:1]))
        chunk, first = self._present_counts()
        self.insert("history", chunk, first, len(steps), steps.astype(float), rows)
        if companions is not None:
            outputs = len(companions.rows)
            companion_steps = steps[len(steps) - outputs :].astype(float)
            self.insert(
                "companions",
                first + len(steps) - outputs,
                outputs,
                int(steps[-1]),
                companions.findings,
                companion_steps,
                companions.rows.reshape(outputs, -1),
            )
            # Only the companions' outputs of the latest turn are compared with those of the run.
            self._connection.execute("DELETE FROM companions WHERE last < ?", (companions.oldest,))
            for turn, values in enumerate(companions.turns):
                self.insert("turns", companions.first + turn, companions.ends[turn], values)

    def checkpoint(self, step: int, state: Array, extra: Mapping[str, Any] | None = None) -> None:
        """Write the state after ``step``, from which a run can continue, in the order of the blocks of the
        start.

        ``state``: shape (rows,) or (rows, lanes). ``extra``: what the solver needs besides, for JSON.
        """
        with self.transaction(self._gather):
            self._checkpoint(Checkpoint(step, state, extra or {}))

    def _checkpoint(self, checkpoint: Checkpoint) -> None:
        self.insert(
            "checkpoints",
            int(checkpoint.step),
            *self._present_counts(),
            dict(checkpoint.extra),
            checkpoint.values,
        )
        old = (
            "DELETE FROM checkpoints WHERE step NOT IN (SELECT step FROM checkpoints ORDER BY step DESC"
            " LIMIT ?)"
        )
        self._connection.execute(old, (CHECKPOINTS,))

    def rewind(self, checkpoint: Checkpoint) -> None:
        """Remove what was written after a checkpoint, from which the run continues."""
        with self.transaction():
            for table, column in (("checkpoints", "step"), ("companions", "last"), ("turns", "last")):
                self._connection.execute(f"DELETE FROM {table} WHERE {column} > ?", (checkpoint.step,))
            self._connection.execute("DELETE FROM history WHERE chunk >= ?", (checkpoint.chunks,))
            self._put({COUNTED: None})

    def leave_companions(self) -> None:
        """Remove the companions, which do not go on with the run."""
        with self.transaction():
            for table in ("companions", "turns"):
                self._connection.execute(f"DELETE FROM {table}")
            self._put({"companions": {}, COUNTED: None})

    def event(self, step: int, text: str) -> None:
        """Record an event after ``step``."""
        with self.transaction():
            number = self.query("SELECT coalesce(max(number) + 1, 1) FROM events")[0]
            self.insert("events", int(number), int(step), present_time(), text)

    def keep_reference(self, meta: Mapping[str, Any], steps: Steps, rows: Array) -> None:
        """Write the record of the ideal mechanism beside the run."""
        entries, arrays = _split_arrays(meta)
        rows_per_part = max(1, PART_BYTES // max(8 * rows.shape[1], 1))
        parts = {"steps": packed(steps.astype(float))}
        parts |= {
            f"rows.{k}": packed(rows[first : first + rows_per_part])
            for k, first in enumerate(range(0, max(len(rows), 1), rows_per_part))
        }
        parts |= {f"{ARRAY}{key}": packed(values) for key, values in arrays.items()}
        parts |= {"meta": json.dumps({**entries, KEYS: sorted(parts)}).encode()}
        with self.transaction(math.inf):
            for part, data in parts.items():
                self.insert("reference", part, data)

    def finish(self, status: str, summary: Mapping[str, Any] | None = None, **meta: Any) -> None:
        """Write status ("complete", "interrupted", "diverged"), summary and further metadata of the ended
        run.
        """
        with self.transaction():
            counted = {
                table: self.query(f"SELECT count(*) FROM {table}")[0]
                for table in ("checkpoints", "companions", "reference", "events")
            }
            counted |= {"history": self._present_counts(), "steps": steps_seal(self._stored_steps())}
            self._put(
                {
                    "status": status,
                    "finished": present_time(),
                    "summary": dict(summary or {}),
                    **meta,
                    COUNTED: counted,
                }
            )

    def _due(self, patience: float) -> bool:
        return not self._gather or self.arrive is not None or super()._due(patience)

    def _move(self, move: Callable[[], Path]) -> None:
        """Move the file to its place and continue there."""
        self.flush()
        self._connection.close()
        self.arrive = None
        try:
            self.path = move()
        finally:
            self._connection = writable(self.path)

    def _put(self, meta: Mapping[str, Any]) -> None:
        entries, arrays = _split_arrays(meta)
        if not meta:
            return
        names = self._entry("meta", KEYS)
        entries[KEYS] = sorted({*entries, *arrays, *(json.loads(names) if names else ())})
        for table, values in (("meta", entries), ("arrays", arrays)):
            for key, value in values.items():
                self.insert(table, key, value)
                if key not in NOT_COPIED:
                    self.insert(
                        "copies",
                        f"{table}.{key}",
                        packed(value) if table == "arrays" else json.dumps(value).encode(),
                    )

    def _clear(self) -> None:
        """Remove what was computed, and write the meta of the next try."""
        for table in ("history", "checkpoints", "companions", "turns"):
            self._connection.execute(f"DELETE FROM {table}")
        self._put({**self._next, COUNTED: None})
        self._next = {}


def _split_arrays(meta: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the separate arrays from what JSON can express."""
    arrays = {key: value for key, value in meta.items() if isinstance(value, np.ndarray)}
    return {key: value for key, value in meta.items() if key not in arrays}, arrays
