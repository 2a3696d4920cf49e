"""Turns of a run: whether they repeat, from which one, with which period, and which of them measures are
taken of.

A turn repeats if each quantity is within a tolerance of its value one period before, output by output. A
motion whose turns approach each other is still settling: the logarithms of their distances lie on a falling
line. A motion that neither repeats nor settles within ten turns is called not periodic; its measures are
means, because no single turn represents it.

A window is a selection of outputs, by default the last turn, of which a measure is taken.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import log
from ..solvers.record import Record, columns_of, rows_between
from ..solvers.repeating import LONGEST, SETTLED, Comparison, outputs_of_a_turn, repeated_since
from .normal_forces import normal_shares

Array = NDArray[np.float64]
Motion = Literal["periodic", "settling", "unsettled", "not periodic"]

FEWEST_TURNS = 4  # turns of a run below which its measures are those of its last period, not means
MANY_TURNS = 10  # turns from which on a motion that neither repeats nor settles is called not periodic
MOST_TURNS = 100  # turns of which a mean is taken
# A motion is settling if over its last turns the logarithm of the distance of two turns has at least this
# correlation with their number, and the distance falls at least by this factor.
TREND = 24
FALLING = -0.9
FALLEN = 0.7
# Three distances are too few for a correlation; they show a decay if each is smaller and the last is this
# share of the first.
SHORT_DECAY, DECAYED = 3, 0.1


@dataclass(frozen=True)
class Turns:
    """Turns of a run at constant speed.

    ``motion``: "periodic" if each turn from ``since`` on (counted from 1) repeats the one ``period`` turns
    before it within ``tolerance``; "settling" if turns approach each other; "not periodic" if many turns do
    neither; "unsettled" if there are too few. ``distance`` of the last turn from the one it is nearest to
    (:func:`~vfife.solvers.repeating.distance`) is NaN for a single turn. Measures are of the turns ``first``
    to ``last`` of ``count``.
    """

    count: int
    motion: Motion
    period: int | None
    since: int | None
    distance: float
    tolerance: float
    first: int
    last: int

    @property
    def has_several(self) -> bool:
        """Whether measures are means over turns."""
        return self.last > self.first


def turns(record: Record) -> Turns | None:
    """Classify the turns of a run.

    None without a crank of constant speed, without a full turn, or if a turn is no whole number of outputs.
    """
    outputs = None if record.static else outputs_of_a_turn(record.assembly)
    if outputs is None or len(record.steps) <= outputs or not _unbroken(record):
        return None
    comparison = Comparison(record.assembly, record.row_numbers)
    settle = record.assembly.mechanism.settings.settle
    columns = _Columns(record, comparison, outputs)
    return classify(columns, comparison, SETTLED if settle is None else settle)


def part_of(record: Record, motion: Turns | None) -> str:
    """Name the part of a run that its measures are of: ``mean of turns 3 to 8``, ``last turn, the 2nd``,
    ``whole run``.
    """
    choice, left = record.assembly.choice, record.companions
    if record.static:
        return "all load factors"
    if motion is not None and motion.has_several:
        of_companions = ""
        if motion.motion == "not periodic" and left is not None:
            of_companions = f", of the run and {len(left.counts)} companions"
        return f"mean of turns {motion.first} to {motion.last}{of_companions}"
    if choice.turn is None or record.steps[-1] * choice.step < (1.0 - 1e-9) * choice.turn:
        return "whole run"
    complete = motion is not None and len(record.steps) - 1 == motion.count * (
        outputs_of_a_turn(record.assembly) or 0
    )
    return f"last turn, the {ordinal(motion.last)}" if motion is not None and complete else "last turn"


def ordinal(number: int) -> str:
    """Return a number as ``1st``, ``2nd``, ``3rd``, ``4th`` ..."""
    ending = "th" if 10 < number % 100 < 14 else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"


def _unbroken(record: Record) -> bool:
    """Return whether no output is missing."""
    return bool(record.steps[-1] == (len(record.steps) - 1) * record.assembly.choice.outputs_every)


class _Columns(Sequence[Array]):
    """Turns of a record, each read when it is used, shape (outputs, columns)."""

    def __init__(self, record: Record, comparison: Comparison, outputs: int) -> None:
        self.rows, self.columns, self.outputs = record.rows, comparison.columns, outputs

    def __len__(self) -> int:
        return (len(self.rows) - 1) // self.outputs

    def __getitem__(self, turn):  # type: ignore[no-untyped-def]
        first = 1 + turn * self.outputs
        return columns_of(self.rows[first : first + self.outputs], self.columns)


def classify(turns: Sequence[Array], comparison: Comparison, tolerance: float) -> Turns:
    """Classify turns, each of shape (outputs, columns)."""
    count = len(turns)
    repeated = repeated_since(turns, comparison, tolerance)
    if repeated is not None:
        period, since = repeated
        # Whole periods only, or the mean would depend on where in the period the run ends.
        latest = count - since + 1
        latest = period if count < FEWEST_TURNS else min(latest, MOST_TURNS) // period * period
        distance = comparison.distance(turns[count - 1 - period], turns[count - 1])
        return Turns(count, "periodic", period, since, distance, tolerance, count - latest + 1, count)
    # Of a motion that is not periodic the second half of the turns counts, without the transient before it.
    distances = nearest(turns, comparison)
    motion: Motion = (
        "settling" if settling(distances) else "unsettled" if count < MANY_TURNS else "not periodic"
    )
    first = count - min(count // 2, MOST_TURNS) + 1 if motion == "not periodic" else count
    return Turns(count, motion, None, None, distances[-1] if distances else math.nan, tolerance, first, count)


def nearest(turns: Sequence[Array], comparison: Comparison) -> list[float]:
    """Return the distances of the latest turns, each from the nearest of those up to the longest period
    before it.
    """
    count = len(turns)
    return [
        min(comparison.distance(turns[k - period], turns[k]) for period in range(1, min(LONGEST, k) + 1))
        for k in range(max(1, count - TREND), count)
    ]


def settling(distances: Sequence[float]) -> bool:
    """Return whether distances fall steadily, by a least-squares line through their logarithms."""
    values = np.array(distances[1:] if len(distances) > 4 else distances)  # without that of the start
    if len(values) == SHORT_DECAY:
        return bool(values[0] > values[1] > values[2] > 0.0 and values[2] < DECAYED * values[0])
    if len(values) < 4 or not (np.isfinite(values) & (values > 0.0)).all():
        return False
    # Two conditions: the correlation with time is clearly negative, and the whole fall is large enough. A
    # chaotic motion easily meets one of them by chance.
    logarithms = log(values)
    if np.ptp(logarithms) == 0.0:
        return False
    at, off = np.arange(len(values)) - 0.5 * (len(values) - 1), logarithms - logarithms.mean()
    product, wide, high = (float(terms.sum()) for terms in (at * off, at * at, off * off))
    return product < FALLING * math.sqrt(wide * high) and product / wide * (len(values) - 1) < log(FALLEN)


def each_turn(record: Record, first: int, last: int) -> Iterator[Record]:
    """Yield the record of each turn from ``first`` to ``last``, counted from 1; each starts with the output
    before it.
    """
    outputs = outputs_of_a_turn(record.assembly) or 0
    for turn in range(first, last + 1):
        begin, end = (turn - 1) * outputs, turn * outputs + 1
        rows = rows_between(record.rows, begin, end)
        yield dataclasses.replace(
            record, steps=record.steps[begin:end], source=rows, companions=None, final=None
        )


def companion_turns_of(record: Record, companion: int, first: int, last: int) -> Iterator[Record]:
    """Yield the record of each turn of a companion: the end of the turn before, then one row with the
    extremes and the end of the turn.
    """
    left, outputs = record.companions, outputs_of_a_turn(record.assembly) or 0
    if left is None:
        return
    alone = record_of_companion(record, companion)
    size = outputs * alone.assembly.choice.outputs_every
    for turn in range(first, last + 1):
        values = left.turns[turn - 1, :, companion]
        former = left.turns[turn - 2, :, companion] if turn > 1 else np.zeros_like(values)  # sums begin at 0
        steps = np.array([turn - 1, turn], dtype=np.int64) * size
        yield dataclasses.replace(alone, steps=steps, source=np.stack([former, values]), final=None)


def record_of_companion(record: Record, companion: int) -> Record:
    """Record of the last turn of a companion, with its own step. Raises ValueError for a run without."""
    left = record.companions
    if left is None:
        raise ValueError("a run without companions has no record of one")
    if record.normal_shares is None and record.assembly.contacts:
        part, inside = of_window(record, last_turn(record))
        record.normal_shares = normal_shares(part, inside)
    choice, count = record.assembly.choice, int(left.counts[companion])
    if count == choice.outputs_every:
        return dataclasses.replace(
            record,
            steps=left.steps,
            source=left.rows[:, :, companion],
            row_numbers=left.row_numbers,
            companions=None,
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


def named(names: Iterable[str], quantities: Mapping[str, Sequence[Any] | NDArray[Any]]) -> dict[str, float]:
    """Name the values of some quantities for each joint or body, the last axis: ``<name>.<quantity>``."""
    arrays = {quantity: np.asarray(values, dtype=float) for quantity, values in quantities.items()}
    return {
        f"{name}.{quantity}": values[..., k].tolist()
        for k, name in enumerate(names)
        for quantity, values in arrays.items()
    }
