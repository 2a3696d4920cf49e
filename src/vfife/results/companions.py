"""What a run file keeps of the companions of a run: their step counts and names of rows in its meta, the rows of the last turn beside it.

Version 0.2 kept ``shifts`` in place of ``counts``: its companions had the step of the run, and first steps of other sizes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import ResumeError, RunFileError
from ..solvers.companions import Beside, Companions, Parting, companion_rows, oldest_needed
from ..solvers.record import Record
from ..solvers.repeating import outputs_of_a_turn
from .provenance import named_rows, rows_named
from .runfile import RunFile


def kept_companions(
    assembly: Assembly, counts: NDArray[np.int64], earlier: Mapping[str, tuple[float, float]], rows: NDArray[np.uint32] | None = None
) -> dict[str, Any]:
    """The entry of a run file's meta, with the names of ``rows``, those of today unless given; nothing without companions."""
    if not len(counts):
        return {}
    kept = named_rows(assembly, companion_rows(assembly) if rows is None else rows)
    return {"companions": {"counts": [int(one) for one in counts], "kept": kept, "earlier": dict(earlier)}}


def beside(record: Record) -> Beside | None:
    """What the companions of a record left, for a run file that is written at its end."""
    found = record.companions
    if found is None:
        return None
    choice, outputs = record.assembly.choice, outputs_of_a_turn(record.assembly)
    steps = 0 if outputs is None else outputs * choice.outputs_every
    return Beside(found.rows, found.told, oldest_needed(record.assembly, int(record.steps[-1])), found.turns, 1, steps)


def restored_companions(file: RunFile, record: Record) -> Companions | None:
    """The companions of a record that was read from a file, None where none are kept. Raises RunFileError where they do not fit the run."""
    kept, meta = file.companions(), file.meta.get("companions")
    if kept is None or meta is None:
        return None
    (told, steps, rows), where = kept, str(file.path)
    counts, names = counts_of(meta, record.assembly), rows_named(record.assembly, meta["kept"], where)
    if rows.shape[1] != len(names) * len(counts):
        raise RunFileError(f"{where}: {rows.shape[1]} numbers are kept of {len(counts)} companions with {len(names)} each; run the model again")
    parting = None if told["parting"] is None else Parting(float(told["parting"][0]), str(told["parting"][1]))
    window = steps >= oldest_needed(record.assembly, int(record.steps[-1]))
    rows = rows.reshape(len(rows), len(names), len(counts))[window]
    earlier = {name: (float(low), float(high)) for name, (low, high) in meta["earlier"].items()}
    turns, outputs = file.turns(), outputs_of_a_turn(record.assembly)
    some = 0 if outputs is None else (len(record.steps) - 1) // outputs
    whole = turns[:some] if turns.shape[1:] == rows.shape[1:] and len(turns) >= some else turns[:0]
    return Companions(counts, names, steps[window], rows, parting, tuple(told["lost"]), earlier, whole)


def refuse_displaced(meta: Mapping[str, Any], where: str) -> None:
    """Raise ResumeError for a run of version 0.2 whose companions had the step of the run and displaced first steps: they are no longer stepped."""
    if "shifts" in meta.get("companions", {}):
        raise ResumeError(
            f"{where}: version 0.2 wrote this run, with companions of the same step, which are no longer made; its results stay readable; "
            "start a new run from its end (--start-from), or run the model again"
        )


def counts_of(meta: Mapping[str, Any], assembly: Assembly) -> NDArray[np.int64]:
    """Steps of each companion between two outputs, from the entry of a file's meta."""
    if "counts" in meta:
        return np.array(meta["counts"], dtype=np.int64)
    return np.full(len(meta.get("shifts", ())), assembly.choice.outputs_every, dtype=np.int64)
