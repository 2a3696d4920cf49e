"""The moments of a run that a film shows: as many as its frames, evenly spaced, between the outputs where need be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..results.view import View
from ..solvers.record import Record

Array = NDArray[np.float64]


def first_output(result: View, turns: float) -> int:
    """The output at which the last ``turns`` turns of the crank begin; 0 without a crank, and where the run is shorter."""
    record = result.record
    turn, step = record.assembly.choice.turn, record.assembly.choice.step
    if turn is None or record.static:
        return 0
    begin = float(record.steps[-1]) - turns * turn / step
    return int(np.argmax(record.steps > begin - 0.5))


def places_between(outputs: int, first: int, frames: int) -> Array:
    """Where among the outputs each frame is, shape (frames,): output 7 and a quarter is 7.25. Never more frames than outputs."""
    return np.linspace(first, outputs - 1, min(frames, outputs - first))


def moments(result: View, at: Array) -> View:
    """The run as it is at places between its outputs: positions and angles on a straight line from one to the next, shape (places, rows)."""
    record = result.record
    low = np.minimum(at.astype(int), max(len(record.steps) - 2, 0))
    share = (at - low)[:, None]
    high = np.minimum(low + 1, len(record.steps) - 1)
    rows = record.rows[low] * (1.0 - share) + record.rows[high] * share if len(record.steps) > 1 else record.rows[low]
    steps = record.steps[np.rint(at).astype(int)]
    return View(Record(record.assembly, steps, rows, record.kept, status=record.status))
