"""What a run file keeps of the companions of a run: their displacements and names of rows in its meta, the rows of the last turn beside it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import RunFileError
from ..solvers.companions import Beside, Companions, Parting, measured_rows, oldest_needed
from ..solvers.record import Record
from ..solvers.repeating import outputs_of_a_turn
from .provenance import named_rows, rows_named
from .runfile import RunFile


def kept_companions(assembly: Assembly, shifts: NDArray[np.float64], earlier: Mapping[str, tuple[float, float]]) -> dict[str, Any]:
    """The entry of a run file's meta; nothing without companions."""
    if not len(shifts):
        return {}
    kept = named_rows(assembly, measured_rows(assembly))
    return {"companions": {"shifts": [float(one) for one in shifts], "kept": kept, "earlier": dict(earlier)}}


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
    shifts, names = np.array(meta["shifts"], dtype=float), rows_named(record.assembly, meta["kept"], where)
    if rows.shape[1] != len(names) * len(shifts):
        raise RunFileError(f"{where}: {rows.shape[1]} numbers are kept of {len(shifts)} companions with {len(names)} each; run the model again")
    parting = None if told["parting"] is None else Parting(float(told["parting"][0]), str(told["parting"][1]))
    window = steps >= oldest_needed(record.assembly, int(record.steps[-1]))
    rows = rows.reshape(len(rows), len(names), len(shifts))[window]
    earlier = {name: (float(low), float(high)) for name, (low, high) in meta["earlier"].items()}
    turns, outputs = file.turns(), outputs_of_a_turn(record.assembly)
    some = 0 if outputs is None else (len(record.steps) - 1) // outputs
    whole = turns[:some] if turns.shape[1:] == rows.shape[1:] and len(turns) >= some else turns[:0]
    return Companions(shifts, names, steps[window], rows, parting, tuple(told["lost"]), earlier, whole)
