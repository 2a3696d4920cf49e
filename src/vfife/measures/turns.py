"""Whether the turns of a run repeat, from which one on and with which period, and which of them its measures
are of.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import log
from ..solvers.record import Record
from ..solvers.repeating import LONGEST, SETTLED, Comparison, outputs_of_a_turn, repeated_since

Array = NDArray[np.float64]
Motion = Literal["periodic", "settling", "unsettled", "not periodic"]

FEW = 4  # turns of a run below which its measures are those of its last period, and no mean
MANY = 10  # turns after which one that neither repeats nor is about to is called not periodic
MOST = 100  # turns that a mean is taken over
TREND = 24  # turns back from the end by which it is told whether a motion is settling
FALLING = (
    -0.9
)  # correlation of the logarithm of distances with the number of the turn, of a motion that is settling
FALLEN = 0.7  # by which factor they fall over those turns, at the least


@dataclass(frozen=True)
class Turns:
    """What the turns of a run at constant speed are like.

    ``motion``: "periodic", where each turn from ``since`` on (counted from 1) repeats the one ``period``
    turns before it within ``tolerance``; "settling" where turns come nearer to each other and are not there
    yet; "not periodic" where many of them do neither; "unsettled" where there are too few to tell.
    ``distance`` is that of the last turn from the one it is nearest to
    (:func:`~vfife.solvers.repeating.distance`), NaN of a single turn. Measures are of the turns ``first`` to
    ``last`` of ``count``.
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
    def several(self) -> bool:
        """Whether measures are means over turns."""
        return self.last > self.first


def turns(record: Record) -> Turns | None:
    """What the turns of a run are like; None where nothing turns at constant speed, where a turn holds no
    whole number of outputs, or there is none.
    """
    outputs = None if record.static else outputs_of_a_turn(record.assembly)
    if outputs is None or len(record.steps) <= outputs or not _unbroken(record):
        return None
    comparison, settle = Comparison(record.assembly, record.kept), record.assembly.mechanism.settings.settle
    columns = _Columns(record, comparison, outputs)
    return told(columns, comparison, SETTLED if settle is None else settle)


def part_of(record: Record, said: Turns | None) -> str:
    """Which part of a run its measures are of, in a few words: ``mean of turns 3 to 8``,
    ``last turn, the 2nd``, ``whole run``.
    """
    choice, left = record.assembly.choice, record.companions
    if record.static:
        return "all load factors"
    if said is not None and said.several:
        many = said.motion == "not periodic" and left is not None
        beside = f", of the run and {len(left.counts)} companions" if many and left is not None else ""
        return f"mean of turns {said.first} to {said.last}{beside}"
    if choice.turn is None or record.steps[-1] * choice.step < (1.0 - 1e-9) * choice.turn:
        return "whole run"
    whole = said is not None and len(record.steps) - 1 == said.count * (
        outputs_of_a_turn(record.assembly) or 0
    )
    return f"last turn, the {ordinal(said.last)}" if said is not None and whole else "last turn"


def ordinal(number: int) -> str:
    """``1st``, ``2nd``, ``3rd``, ``4th`` ..."""
    ending = "th" if 10 < number % 100 < 14 else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"


def _unbroken(record: Record) -> bool:
    """Whether no output was lost."""
    return bool(record.steps[-1] == (len(record.steps) - 1) * record.assembly.choice.outputs_every)


class _Columns(Sequence[Array]):
    """The turns of a record, each read when it is looked at, shape (outputs, columns)."""

    def __init__(self, record: Record, comparison: Comparison, outputs: int) -> None:
        self.rows, self.columns, self.outputs = record.rows, comparison.columns, outputs

    def __len__(self) -> int:
        return (len(self.rows) - 1) // self.outputs

    def __getitem__(self, turn):  # type: ignore[no-untyped-def]
        first = 1 + turn * self.outputs
        return np.asarray(self.rows[first : first + self.outputs])[:, self.columns]


def told(every: Sequence[Array], comparison: Comparison, tolerance: float) -> Turns:
    """The same of turns by themselves, each of shape (outputs, columns)."""
    count = len(every)
    found = repeated_since(every, comparison, tolerance)
    if found is not None:
        period, since = found
        some = count - since + 1
        some = period if count < FEW else min(some, MOST) // period * period
        distance = comparison.distance(every[count - 1 - period], every[count - 1])
        return Turns(count, "periodic", period, since, distance, tolerance, count - some + 1, count)
    near = nearest(every, comparison)
    distance = near[-1] if near else math.nan
    if settling(near):
        return Turns(count, "settling", None, None, distance, tolerance, count, count)
    if count < MANY:
        return Turns(count, "unsettled", None, None, distance, tolerance, count, count)
    return Turns(
        count, "not periodic", None, None, distance, tolerance, count - min(count // 2, MOST) + 1, count
    )


def nearest(every: Sequence[Array], comparison: Comparison) -> list[float]:
    """Distances of the latest turns, each from that of those a period before it to which it is nearest."""
    count = len(every)
    return [
        min(comparison.distance(every[k - period], every[k]) for period in range(1, min(LONGEST, k) + 1))
        for k in range(max(1, count - TREND), count)
    ]


def settling(distances: Sequence[float]) -> bool:
    """Whether distances fall steadily: they are so many times smaller at the end of a line through their
    logarithms than at its begin.
    """
    values = np.array(distances[1:] if len(distances) > 4 else distances)  # the first is that of the start
    if len(values) < 4 or not (np.isfinite(values) & (values > 0.0)).all():
        return False
    logarithms = log(values)
    if np.ptp(logarithms) == 0.0:
        return False
    at, off = np.arange(len(values)) - 0.5 * (len(values) - 1), logarithms - logarithms.mean()
    along, wide, high = (float(one.sum()) for one in (at * off, at * at, off * off))
    return along < FALLING * math.sqrt(wide * high) and along / wide * (len(values) - 1) < log(FALLEN)


def each_turn(record: Record, first: int, last: int) -> Iterator[Record]:
    """Turns of a run, counted from 1, as records that begin with the output before them."""
    outputs = outputs_of_a_turn(record.assembly) or 0
    for turn in range(first, last + 1):
        part = slice((turn - 1) * outputs, turn * outputs + 1)
        yield dataclasses.replace(
            record, steps=record.steps[part], source=record.rows[part], companions=None, final=None
        )


def each_turn_beside(record: Record, companion: int, first: int, last: int) -> Iterator[Record]:
    """The same of a companion: of each turn one row, with the largest of extremes and the last of all else,
    and the row before it.
    """
    left, outputs = record.companions, outputs_of_a_turn(record.assembly) or 0
    if left is None:
        return
    alone = record_of_companion(record, companion)
    size = outputs * alone.assembly.choice.outputs_every
    for turn in range(first, last + 1):
        own = left.turns[turn - 1, :, companion]
        before = left.turns[turn - 2, :, companion] if turn > 1 else np.zeros_like(own)  # sums begin at 0
        steps = np.array([turn - 1, turn], dtype=np.int64) * size
        yield dataclasses.replace(alone, steps=steps, source=np.stack([before, own]), final=None)


def record_of_companion(record: Record, companion: int) -> Record:
    """What a companion leaves, as a record of its own step, of the last turn. Raises ValueError for a run
    that has none.
    """
    left = record.companions
    if left is None:
        raise ValueError("a run without companions has no record of one")
    choice, count = record.assembly.choice, int(left.counts[companion])
    if count == choice.outputs_every:
        return dataclasses.replace(
            record, steps=left.steps, source=left.rows[:, :, companion], kept=left.kept, companions=None
        )
    size = choice.step * choice.outputs_every / count
    state = record.assembly.state.copy()
    state[record.assembly.layout["step"]] = size
    own = dataclasses.replace(choice, step=size, outputs_every=count)
    assembly = dataclasses.replace(record.assembly, choice=own, state=state)
    steps = left.steps // choice.outputs_every * count
    return dataclasses.replace(
        record,
        assembly=assembly,
        steps=steps,
        source=left.rows[:, :, companion],
        kept=left.kept,
        companions=None,
    )
