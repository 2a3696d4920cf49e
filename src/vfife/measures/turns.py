"""Division of a run into turns and windows.

A window is a selection of outputs, by default the last turn, of which a measure is taken.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Record, rows_between
from ..solvers.repeating import turn_grid
from .turn_ends import ends_of_companion, ends_of_last_turn, ends_of_turn


def each_turn(record: Record, first: int, last: int, missing: int = 0) -> Iterator[Record]:
    """Yield the record of each turn from ``first`` to ``last``, counted from 1; each starts with the output
    before it. ``missing``: outputs of the run that the record lacks at its start.
    """
    grid = turn_grid(record.assembly)
    if grid is None:
        return
    for turn in range(first, last + 1):
        begin, end = grid.end(turn - 1) - missing, grid.end(turn) - missing + 1
        rows = rows_between(record.rows, begin, end)
        yield dataclasses.replace(
            record,
            steps=record.steps[begin:end],
            source=rows,
            companions=None,
            final=None,
            turn_ends=ends_of_turn(record, grid, turn, last, missing),
        )


def companion_turns_of(record: Record, companion: int, first: int, last: int) -> Iterator[Record]:
    """Yield the record of each turn of a companion: the end of the turn before, then one row with the
    extremes and the end of the turn.
    """
    left, grid = record.companions, turn_grid(record.assembly)
    if left is None or grid is None:
        return
    alone = record_of_companion(record, companion)
    size = alone.assembly.choice.outputs_every
    for turn in range(first, last + 1):
        values = left.turns[turn - 1, :, companion]
        former = left.turns[turn - 2, :, companion] if turn > 1 else np.zeros_like(values)  # sums begin at 0
        steps = np.array([grid.end(turn - 1), grid.end(turn)], dtype=np.int64) * size
        ends = ends_of_turn(record, grid, turn, last)
        turn_record = dataclasses.replace(alone, steps=steps, source=np.stack([former, values]), final=None)
        turn_record.turn_ends = None if ends is None else ends_of_companion(turn_record, record, ends)
        yield turn_record


def record_of_companion(record: Record, companion: int) -> Record:
    """Record of the last turn of a companion, with its own step. Raises ValueError for a run without."""
    left = record.companions
    if left is None:
        raise ValueError("a run without companions has no record of one")
    choice, count = record.assembly.choice, int(left.counts[companion])
    if count == choice.outputs_every:
        return dataclasses.replace(
            record,
            steps=left.steps,
            source=left.rows[:, :, companion],
            row_numbers=left.row_numbers,
            companions=None,
            run=record,
        )
    size = choice.step * choice.outputs_every / count
    state = record.assembly.state.copy()
    state[record.assembly.layout["step"]] = size
    step_choice = dataclasses.replace(choice, step=size, outputs_every=count)
    assembly = dataclasses.replace(record.assembly, choice=step_choice, state=state)
    steps = left.steps // choice.outputs_every * count
    return dataclasses.replace(
        record,
        assembly=assembly,
        steps=steps,
        source=left.rows[:, :, companion],
        row_numbers=left.row_numbers,
        companions=None,
        run=record,
    )


Window: TypeAlias = NDArray[np.bool_]  # shape (outputs,)


class WindowRecord(NamedTuple):
    """A window with the output before it as a ``record``; ``inside`` are the outputs of the window in it."""

    record: Record
    inside: slice


def full_run(record: Record) -> Window:
    """Return a window of all outputs."""
    return np.ones(len(record.steps), dtype=bool)


def last_turn(record: Record) -> Window:
    """Return a window of the outputs of the last full crank turn, which ends with the run; of all outputs
    without a crank, or if the run is shorter.
    """
    turn = record.assembly.choice.turn
    steps = record.steps
    if turn is None or len(steps) < 2:
        return full_run(record)
    # Steps are whole numbers and a turn seldom is: an output belongs to the turn if its interval begins
    # within half a step of the beginning of the turn, or later.
    begin = steps[-1] - turn / record.assembly.choice.step
    if begin < -0.5:
        return full_run(record)
    window = np.zeros(len(steps), dtype=bool)
    window[1:] = steps[:-1] > begin - 0.5
    return window


def after_first(record: Record) -> Window:
    """Return a window of all outputs but the first, which is the end of the turn before."""
    window = full_run(record)
    window[0] = False
    return window


def of_window(record: Record, window: Window) -> WindowRecord:
    """Return the record of a window, so that a measure of a turn costs as much as that turn in a run of any
    length.

    The output before the window belongs to the record, because sums and intervals count from it.
    """
    inside = np.flatnonzero(window)
    first, last = max(int(inside[0]) - 1, 0), int(inside[-1]) + 1
    part = dataclasses.replace(
        record, steps=record.steps[first:last], source=rows_between(record.rows, first, last), companions=None
    )
    return WindowRecord(part, slice(int(inside[0]) - first, None))


def of_turn(record: Record, window: Window, part: Record | None = None) -> Record:
    """Return the record of a window of a turn for sums and means over it: its first and last rows are those
    at the exact ends of the turn, interpolated where they lie between outputs
    (:mod:`~vfife.measures.turn_ends`).

    That of a window of other length, or of a turn of whole outputs, is ``part``: that of :func:`of_window`.
    """
    part = of_window(record, window).record if part is None else part
    ends = record.turn_ends
    if ends is None and np.array_equal(window, last_turn(record)):
        ends = ends_of_last_turn(record)
    if ends is None:
        return part
    inside = (record.steps > ends.steps[0]) & (record.steps < ends.steps[1])
    steps = np.concatenate([ends.steps[:1], record.steps[inside], ends.steps[1:]])
    rows = np.concatenate([ends.rows[:1], record.rows[inside], ends.rows[1:]])
    return dataclasses.replace(part, steps=steps, source=rows)


def named(names: Iterable[str], quantities: Mapping[str, Sequence[Any] | NDArray[Any]]) -> dict[str, float]:
    """Name the values of some quantities for each joint or body, the last axis: ``<name>.<quantity>``."""
    arrays = {quantity: np.asarray(values, dtype=float) for quantity, values in quantities.items()}
    return {
        f"{name}.{quantity}": values[..., k].tolist()
        for k, name in enumerate(names)
        for quantity, values in arrays.items()
    }
