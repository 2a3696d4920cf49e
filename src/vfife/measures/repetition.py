"""Classification of a run by its turns: whether they repeat, from which one, with which period, and which of
them measures are taken of.

A turn repeats if each quantity is within a tolerance of its value one period before, output by output. Turns
of a period of several must differ inside it, in their largest values or in the state at their ends, by more
than the step can make: output by output they agree after several turns by chance. Where
a step decides at which output an impact appears, outputs differ although the motion is periodic: its turns
scatter with the step about it, by less than the tolerance in their largest values and in the state at their
ends. A motion whose turns approach each other is still settling: the logarithms of their distances lie on a
falling line, at least those of the later half after a transient. So is one whose turns alternate about their
limit and repeat in pairs for the moment, while the
two of a pair approach each other. A motion that neither repeats, scatters nor settles within ten turns is
called not repeating: it has no period, or a longer transient. Its measures are means, because no single turn
represents it.

If the step does not divide a turn, the turns have no outputs in common, and are compared by their largest
values alone.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..model.functions import cycle_of, turns_of_cycles
from ..model.mechanism import Mechanism
from ..solvers.record import Record, columns_of
from ..solvers.repeating import (
    FEWEST_LATE,
    LONGEST,
    SETTLED,
    SHARE_OF_SCATTER,
    TREND,
    Comparison,
    PointRows,
    Points,
    TurnGrid,
    alternation,
    differences,
    distinct,
    repeated_since,
    settles,
    settles_late,
    shorter_period,
    turn_grid,
)
from .chaos import scattered_period

Array = NDArray[np.float64]
Motion = Literal["periodic", "settling", "unsettled", "not repeating"]

FEWEST_TURNS = 4  # turns of a run below which its measures are those of its last period, not means
MANY_TURNS = 10  # turns from which on measures of a motion that neither repeats nor settles are means
MOST_TURNS = 100  # turns of which a mean is taken
# Largest distance of points in the later half of the turns over that in the earlier half, of points that
# approach each other: a transient falls so, if not steadily. Of 400 chaotic sequences of 10 to 25 points 1 %
# did, with shifts of up to four turns 7 %.
APPROACH = 0.35
LONGEST_APPROACH = 2  # turns apart, of which points that approach each other show settling
PARTS = 2, 4  # of all turns, of which one counts without the transient before it
PEAK_STREAK = 3  # times that a period must repeat by largest values alone, which agree by chance more easily


@dataclass(frozen=True)
class Turns:
    """Turns of a run at constant speed.

    ``motion``: "periodic" if each turn from ``since`` on (counted from 1) repeats the one ``period`` turns
    before it within ``tolerance``; "settling" if turns approach each other; "not repeating" if many turns do
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
        return self.motion != "not repeating" and not self.scatters

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
    cycle = math.lcm(*cycle_of(record.assembly.mechanism).values())
    motion = classify(columns, comparison, tolerance, partial(points, record, grid), streak, cycle)
    motion = _in_cycles(motion, record.assembly.mechanism)
    return dataclasses.replace(motion, peaks_only=not grid.has_integral_turns)


def _in_cycles(motion: Turns, mechanism: Mechanism) -> Turns:
    """Return turns without a period whose measures are means over whole cycles of drivers and gears: single
    turns of a cycle have other loads, and mean powers of either sign. A run shorter than a cycle has none.
    """
    if motion.period is not None:
        return motion
    latest = turns_of_cycles(mechanism, motion.last - motion.first + 1, motion.count)
    return dataclasses.replace(motion, first=motion.last - latest + 1)


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


def points(record: Record, grid: TurnGrid, first: int, last: int) -> Points:
    """Return the largest values of the turns ``first`` to ``last`` and the states at their ends.

    The states are left out where turns end between two outputs, or were not recorded.
    """
    reader = PointRows(record.assembly, record.row_numbers, states=grid.has_integral_turns)
    columns, turns = np.concatenate(reader.columns), range(first, last + 1)
    outputs = [record.rows[grid.end(turn - 1) + 1 : grid.end(turn) + 1] for turn in turns]
    return reader.of_turns([reader.of_turn(columns_of(rows, columns)) for rows in outputs])


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
        latest = points_of(first, count)
        match = scattered_period(*latest, tolerance)
        if match is not None and match[0] > 1 and not distinct(latest, match[0]):
            match = shorter_period(latest, match[0], tolerance / SHARE_OF_SCATTER)
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
    cycle: int = 1,
) -> Turns:
    """Classify turns, each of shape (outputs, columns); ``points_of`` returns the points of the turns from
    one to another, by which turns that scatter with the step are recognised. ``streak``: how often a period
    must repeat. ``cycle``: turns after which drivers and gears are back, the only longer period that is
    looked for.
    """
    motion = _classify(turns, comparison, tolerance, points_of, streak)
    if cycle > LONGEST and motion.period is None:
        match = repeated_since(turns, comparison, tolerance, streak, (cycle,))
        if match is not None:
            return _periodic(turns, comparison, tolerance, match)
        if motion.motion == "not repeating" and motion.count < (streak + 1) * cycle:
            return dataclasses.replace(motion, motion="unsettled", first=motion.count)
        return motion
    if points_of is None or motion.period == 1 or motion.motion in ("settling", "unsettled"):
        return motion
    count, first = motion.count, max(1, motion.count - TREND)
    latest = points_of(first, count)
    if motion.period is not None:
        decision = _settling(motion, latest) if motion.scatters else _confirmed(motion, latest)
        if decision is not None or motion.scatters or distinct(latest, motion.period):
            return decision or motion
    approach = approaching(latest)
    if approach is not None:
        return Turns(count, "settling", None, None, approach, tolerance, count, count)
    if motion.period is None:
        return scattered(count, max(tolerance, SETTLED), points_of, LONGEST) or motion
    unsettled = Turns(count, "unsettled", None, None, motion.distance, tolerance, count, count)
    return _shorter(motion, latest, max(tolerance, SETTLED)) or unsettled


def _confirmed(motion: Turns, points: Points) -> Turns | None:
    """Return turns that seem to be periodic with the shorter period that their points have within the
    tolerance, or as settling; None for others.
    """
    return _shorter(motion, points, motion.tolerance) or _settling(motion, points)


def _settling(motion: Turns, points: Points) -> Turns | None:
    """Return turns that seem to be periodic, but alternate and approach each other, as settling; None for
    others.
    """
    trend = None if motion.period is None else alternation(points, motion.period)
    if trend is None:
        return None
    count, (distance, decay) = motion.count, trend
    return Turns(count, "settling", None, None, distance, motion.tolerance, count, count, decay=decay)


def _shorter(motion: Turns, points: Points, limit: float) -> Turns | None:
    """Return turns that seem to have a period of several turns, but whose points differ by less than a
    ``limit`` inside it, with the shorter period; None for others.
    """
    longest, count = motion.period or 1, motion.count
    match = shorter_period(points, longest, limit)
    if match is None:
        return None
    period, distance = match
    first = count - min(2 * longest, count) // period * period + 1
    since = first + period
    return Turns(count, "periodic", period, since, distance, motion.tolerance, first, count, scatters=True)


def approaching(points: Points) -> float | None:
    """Return the last distance (1) of points a few turns apart that approach each other; None if those of no
    such shift do.

    Output by output turns of an impact are far apart until its onset lies between the same outputs, however
    close their largest values and the states at their ends are.
    """
    for shift in range(1, LONGEST_APPROACH + 1):
        if len(points.values) <= 2 * shift + FEWEST_LATE:
            break
        if all(_falls(differences(points, multiple)[1:]) for multiple in (shift, 2 * shift)):
            return float(differences(points, shift)[-1])
    return None


def _falls(distances: Array) -> bool:
    """Return whether distances fall steadily, or their later half is small beside the earlier one."""
    half = len(distances) // 2
    falls = float(distances[half:].max()) < APPROACH * float(distances[:half].max())
    return falls or settles(distances.tolist())


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
        return _periodic(turns, comparison, tolerance, repeated)
    # Of a motion that does not repeat the second half of the turns counts, without the transient before it.
    distances = nearest(turns, comparison)
    motion: Motion = "not repeating" if count >= MANY_TURNS else "unsettled"
    if settles(distances) or settles_late(distances):
        motion = "settling"
    first = count - min(count // 2, MOST_TURNS) + 1 if motion == "not repeating" else count
    return Turns(count, motion, None, None, distances[-1] if distances else math.nan, tolerance, first, count)


def _periodic(
    turns: Sequence[Array], comparison: Comparison, tolerance: float, repeated: tuple[int, int]
) -> Turns:
    """Return turns that repeat with a period from some turn on."""
    (period, since), count = repeated, len(turns)
    # Whole periods only, or the mean would depend on where in the period the run ends.
    latest = count - since + 1
    latest = period if count < FEWEST_TURNS else max(min(latest, MOST_TURNS) // period, 1) * period
    distance = comparison.distance(turns[count - 1 - period], turns[count - 1])
    return Turns(count, "periodic", period, since, distance, tolerance, count - latest + 1, count)


def nearest(turns: Sequence[Array], comparison: Comparison) -> list[float]:
    """Return the distances of the latest turns, each from the nearest of those up to the longest period
    before it.
    """
    count = len(turns)
    return [
        min(comparison.distance(turns[k - period], turns[k]) for period in range(1, min(LONGEST, k) + 1))
        for k in range(max(1, count - TREND), count)
    ]
