"""Records whose rows a test writes, so that analyses of them have closed forms and nothing is run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from vfife.assembly.assemble import assemble
from vfife.model.mechanism import Mechanism
from vfife.solvers.record import Record, recorded_rows

STEP = 1e-3  # s


def made_record(
    mechanism: Mechanism,
    blocks: Mapping[str, ArrayLike],
    steps: ArrayLike,
    *,
    turns: float | None = None,
    step: float = STEP,
    outputs: int | None = None,
) -> Record:
    """Make a record of a mechanism with these values of blocks after these steps; all other rows are those of
    the start.

    Values have the shape (outputs, entities), or (outputs,) where all entities are alike. ``step`` is in
    seconds.
    """
    length = {"duration": 1.0} if turns is None else {"turns": turns}
    assembly, at = (
        assemble(mechanism, step, force_step=True, outputs=outputs, **length),
        np.asarray(steps, dtype=np.int64),
    )
    kept = recorded_rows(assembly)
    rows = np.tile(np.nan_to_num(assembly.state[kept]), (len(at), 1))
    record = Record(assembly, at, rows, kept)
    for name, values in blocks.items():
        columns = record._columns.of(name)
        given = np.asarray(values, dtype=float)
        rows[:, columns] = given[:, None] if given.ndim == 1 else given
    return record
