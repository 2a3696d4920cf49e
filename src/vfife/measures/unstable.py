"""Companions whose step was not stable: their forces and energies are many times those of the run.

What blew up is no draw from the scatter of a sensitive motion, and has no part in ranges.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Record
from .energy import ledger

Array = NDArray[np.float64]
# Largest contact force over that of the run, and work over the largest energy of the run, from which a
# companion blew up. A force alone may be small in the run by chance, as where a contact begins with its end;
# but no work exceeds what there is.
BURST, BURST_WORK = 30.0, 10.0
WORKS = ("contact_damping_work", "contact_friction_work", "driven_work", "actuator_work")
# Share of the largest energy by which the ledger of a run beside lost companions is open if it blew up too.
OPEN = 1e-3


def unstable_companions(record: Record) -> tuple[int, ...]:
    """Return the numbers of the companions that are not finite, or that have larger steps than the run and
    blew up.
    """
    companions = record.companions
    if companions is None:
        return ()
    if companions.burst is None:
        companions.burst = _burst(record)
    return tuple(sorted({*companions.divergent, *companions.burst}))


def is_unstable(record: Record) -> bool:
    """Return whether the step of the run itself is not stable: all companions are lost, or some are and its
    ledger is open.
    """
    lost = unstable_companions(record)
    if record.companions is None or not lost:
        return False
    return len(lost) == len(record.companions.counts) or not ledger(record).error <= OPEN


def _burst(record: Record) -> tuple[int, ...]:
    """Return the numbers of the finite companions that blew up."""
    companions, layout = record.companions, record.assembly.layout
    if companions is None or not record.assembly.contacts or not len(companions.counts):
        return ()
    squares = _largest(record, layout["contact_force_squared_max"])
    largest = float(record.block("contact_force_squared_max").max(initial=0.0))
    coarser = companions.counts < record.assembly.choice.outputs_every
    with np.errstate(invalid="ignore"):
        suspects = np.flatnonzero(coarser & (squares > BURST * BURST * largest) & (largest > 0.0))
    if not len(suspects):
        return ()
    rows = np.array([row for name in WORKS for row in layout.rows_of(name).tolist()], dtype=np.uint32)
    works, energy = _largest(record, rows), ledger(record).largest
    return tuple(int(k) for k in suspects if math.isfinite(energy) and works[k] > BURST_WORK * energy)


def _largest(record: Record, rows: NDArray[Any]) -> Array:
    """Return the largest magnitude of some rows of S of each companion, over its turns and last outputs."""
    companions = record.companions
    if companions is None:
        return np.zeros(0)
    columns = np.isin(companions.row_numbers, rows)
    parts = [part for part in (companions.rows, companions.turns) if part.ndim == 3 and part.size]
    result: Array = np.max(
        [np.abs(part[:, columns]).max(axis=(0, 1), initial=0.0) for part in parts]
        or [np.zeros(len(companions.counts))],
        axis=0,
    )
    return result
