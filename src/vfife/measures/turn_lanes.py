"""Turns that measures are of, in the record of a run and in those of its companions."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..solvers.record import Record
from ..solvers.repeating import turn_grid
from .error_ranges import sound_companions
from .repetition import Turns
from .turns import last_turn, record_of_companion


class TurnLane(NamedTuple):
    """Outputs of ``turns`` of a run (``lane`` 0) or of a companion, in a ``record``."""

    lane: int
    record: Record
    turns: tuple[slice, ...]


def windows(record: Record, motion: Turns | None) -> Iterator[slice]:
    """Yield the outputs of each turn that measures are of."""
    grid = turn_grid(record.assembly)
    if motion is not None and motion.has_several and grid is not None:
        for turn in range(motion.first, motion.last + 1):
            yield slice(grid.end(turn - 1) + 1, grid.end(turn) + 1)
    else:
        rows = np.flatnonzero(last_turn(record))
        yield slice(int(rows[0]), int(rows[-1]) + 1)


def turn_lanes(record: Record, motion: Turns | None) -> Iterator[TurnLane]:
    """Yield the turns of the run and then those of its companions with finite numbers.

    A companion keeps the outputs of its last turn. Of each turn before it keeps one row with the largest
    value of every extreme; these need not belong to the same moment.
    """
    yield TurnLane(0, record, tuple(windows(record, motion)))
    for lane, k in enumerate(sound_companions(record), 1):
        last = record_of_companion(record, k)
        outputs = slice(1, len(last.steps))
        if record.companions is None or motion is None or not motion.has_several:
            yield TurnLane(lane, last, (outputs,))
            continue
        rows = record.companions.turns[motion.first - 1 : motion.last, :, k]
        if _ends_with(record, motion.last):
            rows = rows[:-1]
            yield TurnLane(lane, last, (outputs,))
        steps = np.arange(len(rows), dtype=np.int64)
        turns = dataclasses.replace(last, steps=steps, source=rows, final=None)
        yield TurnLane(lane, turns, tuple(slice(turn, turn + 1) for turn in range(len(rows))))


def _ends_with(record: Record, turn: int) -> bool:
    """Return whether a run ends with the end of a turn."""
    grid = turn_grid(record.assembly)
    return grid is not None and grid.end(turn) == len(record.steps) - 1
