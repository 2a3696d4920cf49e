"""Turns of a run: whether they repeat, from which one, with which period, and which of them measures are
taken of.

A turn repeats if each quantity is within a tolerance of its value one period before, output by output. Where
a step decides at which output an impact appears, outputs differ although the motion is periodic: its turns
scatter with the step about it, by less than the tolerance in their largest values and in the state at their
ends. A motion whose turns approach each other is still settling: the logarithms of their distances lie on a
falling line. So is one whose turns alternate about their limit and repeat in pairs for the moment, while the
two of a pair approach each other. A motion that neither repeats, scatters nor settles within ten turns is
called not periodic; its measures are means, because no single turn represents it.

If the step does not divide a turn, the turns have no outputs in common, and are compared by their largest
values alone.

A window is a selection of outputs, by default the last turn, of which a measure is taken.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import exp, log
from ..solvers.record import Record, columns_of, rows_between
from ..solvers.repeating import LONGEST, SETTLED, Comparison, TurnGrid, repeated_since, turn_grid
from .chaos import scattered_period
from .normal_forces import normal_shares
from .turn_ends import ends_of_companion, ends_of_last_turn, ends_of_turn

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
# Distances of turns in which a motion that alternates is recognised, and the least ratio of their decay in
# the second half to that in all: of a period of several turns they become constant when its transient ends.
FEWEST_ALTERNATIONS, STEADY_DECAY = 7, 0.5
# Three distances are too few for a correlation; they show a decay if each is smaller and the last is this
# share of the first.
SHORT_DECAY, DECAYED = 3, 0.1
# Blocks of the state at the end of a turn, by kind: a change is compared with the range of the motion, or
# with this share of the largest range of the kind.
STATE = ("particle_x", "particle_y"), ("particle_theta",), ("particle_u", "particle_v"), ("particle_w",)
LEAST_RANGE = 0.1
PARTS = 2, 4  # of all turns, of which one counts without the transient before it
PEAK_STREAK = 3  # times that a period must repeat by largest values alone, which agree by chance more easily


@dataclass(frozen=True)
class Turns:
    """Turns of a run at constant speed.

    ``motion``: "periodic" if each turn from ``since`` on (counted from 1) repeats the one ``period`` turns
    before it within ``tolerance``; "settling" if turns approach each other; "not periodic" if many turns do
    neither; "unsettled" if there are too few. ``distance`` of the last turn from the one it is nearest to
    (:func:`~vfife.solvers.repeating.distance`) is NaN for a single turn. Measures are of the turns ``first``
    to ``last`` of ``count``.

    ``scatters``: the turns of a periodic motion scatter about it with the step, and ``distance`` is the
    largest difference of turns a period apart. ``peaks_only``: turns were compared by their largest values
    alone, because the step does not divide a turn. ``decay``: share (1) by which ``distance``, then that of
    successive largest values and states, shrinks a turn in a settling motion that alternates; 0 for others.
    """

    count: int
    motion: Motion
    period: int | None
    since: int | None
    distance: float
    tolerance: float
    first: int
    last: int
    scatters: bool = False
    peaks_only: bool = False
    decay: float = 0.0

    @property
    def repeats(self) -> bool:
        """Whether measures are those of a single motion, not means that scatter by chance."""
        return self.motion != "not periodic" and not self.scatters

    @property
    def has_several(self) -> bool:
        """Whether measures are means over turns."""
        return self.last > self.first


def turns(record: Record) -> Turns | None:
    """Classify the turns of a run.

    None without a crank of constant speed, or without a full turn.
    """
    grid = None if record.static else turn_grid(record.assembly)
    if grid is None or grid.count(len(record.steps) - 1) < 1 or not _unbroken(record):
        return None
    comparison = Comparison(record.assembly, record.row_numbers, peaks_only=not grid.has_integral_turns)
    settle = record.assembly.mechanism.settings.settle
    columns = _Columns(record, comparison, grid)
    streak = 1 if grid.has_integral_turns else PEAK_STREAK
    tolerance = SETTLED if settle is None else settle
    motion = classify(columns, comparison, tolerance, partial(points, record, grid), streak)
    return dataclasses.replace(motion, peaks_only=not grid.has_integral_turns)


def part_of(record: Record, motion: Turns | None) -> str:
    """Name the part of a run that its measures are of: ``mean of turns 3 to 8``, ``last turn, the 2nd``,
    ``whole run``.
    """
    choice, left = record.assembly.choice, record.companions
    if record.static:
        return "all load factors"
    if motion is not None and motion.has_several:
        of_companions = ""
        if not motion.repeats and left is not None:
            of_companions = f", of the run and {len(left.counts)} companions"
        return f"mean of turns {motion.first} to {motion.last}{of_companions}"
    if choice.turn is None or record.steps[-1] * choice.step < (1.0 - 1e-9) * choice.turn:
        return "whole run"
    grid = turn_grid(record.assembly)
    complete = motion is not None and grid is not None and len(record.steps) - 1 == grid.end(motion.count)
    return f"last turn, the {ordinal(motion.last)}" if motion is not None and complete else "last turn"


def ordinal(number: int) -> str:
    """Return a number as ``1st``, ``2nd``, ``3rd``, ``4th`` ..."""
    ending = "th" if 10 < number % 100 < 14 else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"


def _unbroken(record: Record) -> bool:
    """Return whether no output is missing."""
    return bool(record.steps[-1] == (len(record.steps) - 1) * record.assembly.choice.outputs_every)


class _Columns(Sequence[Array]):
    """Turns of a record, each read when it is used, shape (outputs, columns); one row of their largest values
    where a turn is no whole number of outputs.
    """

    def __init__(self, record: Record, comparison: Comparison, grid: TurnGrid) -> None:
        self.rows, self.columns, self.grid = record.rows, comparison.columns, grid

    def __len__(self) -> int:
        return self.grid.count(len(self.rows) - 1)

    def __getitem__(self, turn):  # type: ignore[no-untyped-def]
        inside = slice(1 + self.grid.end(turn), 1 + self.grid.end(turn + 1))
        values = columns_of(self.rows[inside], self.columns)
        return values if self.grid.has_integral_turns else values.max(axis=0, keepdims=True)


class Points(NamedTuple):
    """A point for each turn, shape (turns, coordinates), and the size with which each is compared."""

    values: Array
    sizes: Array


def points(record: Record, grid: TurnGrid, first: int, last: int) -> Points:
    """Return the largest values of the turns ``first`` to ``last`` and the states at their ends.

    The states are left out where turns end between two outputs, or were not recorded.
    """
    comparison = Comparison(record.assembly, record.row_numbers, peaks_only=True)
    outputs = [slice(grid.end(turn - 1) + 1, grid.end(turn) + 1) for turn in range(first, last + 1)]
    peaks = np.array([columns_of(record.rows[turn], comparison.columns).max(axis=0) for turn in outputs])
    largest = np.abs(peaks).max(axis=0)
    parts = [Points(peaks, np.maximum(largest, comparison.smallest_scale(largest)))]
    ends = [grid.end(turn) for turn in range(first, last + 1)]
    complete = all(record.keeps(name) for kind in STATE for name in kind)
    for kind in STATE if complete and grid.has_integral_turns else ():
        states = np.concatenate([record.block(name) for name in kind], axis=1)
        ranges = np.ptp(states[outputs[-1]], axis=0)
        states = states[ends]
        if kind == ("particle_theta",):  # a body that rotates has the same angle in the next turn
            states = states - 2.0 * math.pi * np.round((states - states[0]) / (2.0 * math.pi))
        parts.append(Points(states, np.maximum(ranges, LEAST_RANGE * ranges.max(initial=0.0))))
    return Points(*(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)))


def scattered(
    count: int, tolerance: float, points_of: Callable[[int, int], Points], longest: int
) -> Turns | None:
    """Classify turns that scatter about a periodic motion with the step, by the second half of ``count``
    turns, or by the last quarter after a long transient; None for others, or if their period is above
    ``longest``.

    A section of the motion has the same criterion (:func:`~vfife.measures.chaos.scattered_period`).
    """
    for part in PARTS:
        first = count - min(count // part, MOST_TURNS) + 1
        match = scattered_period(*points_of(first, count), tolerance)
        if match is not None and match[0] <= longest:
            period, scatter = match
            begin = count - (count - first + 1) // period * period + 1
            return Turns(count, "periodic", period, first, scatter, tolerance, begin, count, scatters=True)
    return None


def classify(
    turns: Sequence[Array],
    comparison: Comparison,
    tolerance: float,
    points_of: Callable[[int, int], Points] | None = None,
    streak: int = 1,
) -> Turns:
    """Classify turns, each of shape (outputs, columns); ``points_of`` returns the points of the turns from
    one to another, by which turns that scatter with the step are recognised. ``streak``: how often a period
    must repeat.
    """
    motion = _classify(turns, comparison, tolerance, points_of, streak)
    if points_of is None or motion.period is None or motion.period == 1:
        return motion
    count, first = motion.count, max(1, motion.count - TREND)
    trend = alternation(points_of(first, count), motion.period)
    if trend is None:
        return motion
    distance, decay = trend
    return Turns(count, "settling", None, None, distance, tolerance, count, count, decay=decay)


def alternation(points: Points, period: int) -> tuple[float, float] | None:
    """Return the last distance (1) of turns a part of a ``period`` apart, and the share (1) by which it
    shrinks a turn; None if it does not shrink, because the period is one.

    Near the end of a motion's stability its deviation changes its sign every turn and decays slowly, so that
    turns two apart agree long before successive turns do.
    """
    sizes = np.where(points.sizes > 0.0, points.sizes, 1.0)
    for part in (shift for shift in range(1, period) if period % shift == 0):
        distances = (np.abs(points.values[part:] - points.values[:-part]) / sizes).max(axis=1)
        distances = distances[-max(FEWEST_ALTERNATIONS, len(distances) // 2) :]
        count = len(distances)
        if count < FEWEST_ALTERNATIONS or not settling(distances.tolist()):
            continue
        fall, late = (log(distances[-1] / distances[k]) / (count - 1 - k) for k in (0, count // 2))
        if late < STEADY_DECAY * fall:
            return float(distances[-1]), 1.0 - float(exp(fall))
    return None


def _classify(
    turns: Sequence[Array],
    comparison: Comparison,
    tolerance: float,
    points_of: Callable[[int, int], Points] | None,
    streak: int,
) -> Turns:
    """Classify turns; those that alternate and still settle count as periodic."""
    count = len(turns)
    repeated = repeated_since(turns, comparison, tolerance, streak)
    # A period of several turns may be one of fewer whose turns scatter: outputs agree by chance.
    if points_of is not None and count >= MANY_TURNS and (repeated is None or repeated[0] > 1):
        longest = LONGEST if repeated is None else repeated[0] - 1
        if (periodic := scattered(count, tolerance, points_of, longest)) is not None:
            return periodic
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
