"""Whether the turns of a crank at constant speed repeat: the distance between two turns, and the detection of
a run that has settled.

Two turns repeat if no quantity differs by more than a tolerance of its size at any output. Quantities that
are small beside others of their kind, near rounding, or small on the scale of the mechanism
(:mod:`~vfife.solvers.scales`), are compared with the larger ones: a joint without a load, or a body whose
rotation has died out, would otherwise never repeat.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, StepChoice
from ..assembly.timestep import FEWEST_OUTPUTS
from ..kernels.arrays import Layout
from ..numerics.elementwise import exp, log
from .scales import least_compared_acceleration

Array = NDArray[np.float64]

LONGEST = 8  # turns of the longest period that is detected
LEAST_STREAK = 2  # turns in a row that must repeat before a run ends: one may repeat by chance
SETTLED = 0.01  # default of the distance at which turns repeat
REPEATED = ("body_alpha", "contact_normal_force")  # compared in addition to the extremes
SQUARES = tuple(f"{entity}_force_squared_max" for entity in ("contact", "guide", "joint", "driven", "spring"))
MOMENTS = ("joint_moment_max", "driven_torque_max")
ACCELERATIONS = ("body_alpha", "body_alpha_max")
LEAST_SHARE = 0.1  # of the largest quantity of its kind: smaller ones are compared with that
ROUNDING = 16.0 * 2.2e-16  # of an angle (rad), which enters its second difference
NOISE = 1e-9  # of the largest load
OVER_NOISE = 1e3  # multiple of the noise with which smaller quantities are compared
# Multiple of the largest load (N, N m) with which smaller moments are compared: a force on an arm of 10 um.
# The torque of a drive that runs idle decays to nothing, and would differ until it is rounding.
LEAST_MOMENT = 1e-5
# Outputs of a turn by which most differing turns are rejected; only all outputs confirm that turns repeat.
GLANCES = 24
SURE = 1.0 + 1e-9  # factor of the tolerance in that test, above all rounding
# Blocks of the state at the end of a turn, by kind: a change is compared with the range of the motion, or
# with this share of the largest range of the kind.
STATE = ("particle_x", "particle_y"), ("particle_theta",), ("particle_u", "particle_v"), ("particle_w",)
LEAST_RANGE = 0.1
# Largest difference of points, as a share of their size, that the step may make, which places onsets
# differently in these turns. A damped stop made 0.0004 of the motion's range; a period of 48 turns had points
# 0.007 apart after 6.
STEP_SHARE = 0.0025
# Share of the scatter of points a period apart, within which those of a longer one repeat.
SHARE_OF_SCATTER = 0.5
# A motion is settling if over its last turns the logarithm of the distance of two turns has at least this
# correlation with their number, and the distance falls at least by this factor.
TREND = 24
FALLING = -0.9
FALLEN = 0.7
# Distances in the later half of a run, and the factor of their fall, that show settling after a transient: of
# six numbers in random order the logarithms correlate so strongly once in 200.
FEWEST_LATE, LATE_FALL = 6, 0.5
# Distances of turns in which a motion that alternates is recognised, and the least ratio of their decay in
# the second half to that in all: of a period of several turns they become constant when its transient ends.
FEWEST_ALTERNATIONS, STEADY_DECAY = 7, 0.5
# Three distances are too few for a correlation; they show a decay if each is smaller and the last is this
# share of the first.
SHORT_DECAY, DECAYED = 3, 0.1
LATEST = max(2 * LONGEST, TREND + 1)  # turns that decide whether a run has settled


def distance(first: Array, second: Array, smallest: Array | None = None) -> float:
    """Return the distance (1) between two turns, shape (outputs, quantities) each: the largest difference of
    a quantity at an output over the largest absolute value of the quantity, of all quantities the largest.

    A quantity that is zero in both turns is left out; one smaller than ``smallest`` is compared with that.
    """
    size = np.maximum(np.abs(first).max(axis=0), np.abs(second).max(axis=0))
    size = size if smallest is None else np.maximum(size, smallest)
    change = np.abs(second - first).max(axis=0)
    return float(np.max(np.divide(change, size, out=np.zeros_like(change), where=size > 0.0), initial=0.0))


def compared_rows(layout: Layout) -> list[int]:
    """Return the rows of S by which two turns are compared: extremes, angular accelerations, contact
    forces.
    """
    return [*layout.of("extreme"), *(int(row) for name in REPEATED for row in layout[name])]


def outputs_of_a_turn(assembly: Assembly) -> int | None:
    """Return the number of outputs in a turn of a crank at constant speed; None without such a crank, or if a
    turn is not a whole number of outputs.
    """
    moving = [driver for driver in assembly.mechanism.drivers.values() if driver.moves]
    return (
        None if any(driver.steady_speed is None for driver in moving) else outputs_per_turn(assembly.choice)
    )


def outputs_per_turn(choice: StepChoice) -> int | None:
    """Return the number of outputs in a turn; None without a turn, or if it is no whole number."""
    if choice.turn is None:
        return None
    exact = choice.turn / (choice.step * choice.outputs_every)
    count = round(exact)
    return count if count >= 1 and abs(exact - count) <= 1e-9 * count else None


@dataclass(frozen=True)
class TurnGrid:
    """Outputs at which the turns of a crank at constant speed end: after every ``exact`` outputs, or at the
    output nearest to that where a turn is no whole number of them.
    """

    exact: float

    @property
    def has_integral_turns(self) -> bool:
        """Whether a turn is a whole number of outputs, so that turns can be compared output by output."""
        return self.exact == round(self.exact)

    def end(self, turn: int) -> int:
        """Return the number of the output at which a ``turn``, counted from 1, ends; 0 for turn 0."""
        return round(turn * self.exact)

    def count(self, outputs: int) -> int:
        """Return the number of turns that end up to the output ``outputs``."""
        turns = int((outputs + 0.5) / self.exact)
        return turns if self.end(turns) <= outputs else turns - 1


def turn_grid(assembly: Assembly) -> TurnGrid | None:
    """Return where turns end; None without a crank of constant speed, or with too few outputs in a turn to
    end it at the nearest one.
    """
    moving = [driver for driver in assembly.mechanism.drivers.values() if driver.moves]
    choice = assembly.choice
    if choice.turn is None or any(driver.steady_speed is None for driver in moving):
        return None
    outputs, exact = outputs_per_turn(choice), choice.turn / (choice.step * choice.outputs_every)
    if outputs is not None:
        return TurnGrid(float(outputs))
    return TurnGrid(exact) if exact >= FEWEST_OUTPUTS else None


class Comparison:
    """Compare turns of a run by its ``recorded`` rows; quantities that are small beside others of their kind,
    or near noise, are compared with larger numbers. ``peaks_only``: by the extremes between outputs alone.
    """

    def __init__(self, assembly: Assembly, recorded: NDArray[np.uint32], *, peaks_only: bool = False) -> None:
        self.layout, self.step = assembly.layout, assembly.choice.step
        self.turning = least_compared_acceleration(assembly.choice)
        place = {int(row): k for k, row in enumerate(recorded)}
        rows = self.layout.of("extreme") if peaks_only else compared_rows(self.layout)
        self.rows = [int(row) for row in rows if int(row) in place]
        self.columns = np.array([place[row] for row in self.rows], dtype=np.intp)

    @cached_property
    def families(self) -> dict[str, NDArray[np.intp]]:
        """Indices, among the columns, of the quantities of each kind."""
        kinds = {"squares": SQUARES, "moments": MOMENTS, "accelerations": ACCELERATIONS}
        kinds |= {name: (name,) for name in ("contact_normal_force", "contact_penetration_max")}
        rows_of_kind = {
            kind: {int(row) for name in names for row in self.layout.rows_of(name)}
            for kind, names in kinds.items()
        }
        return {
            kind: np.array([k for k, row in enumerate(self.rows) if row in rows], dtype=np.intp)
            for kind, rows in rows_of_kind.items()
        }

    def distance(self, first: Array, second: Array) -> float:
        """Return the :func:`distance` of two turns, shape (outputs, columns) each."""
        return distance(
            first,
            second,
            self.smallest_scale(np.maximum(np.abs(first).max(axis=0), np.abs(second).max(axis=0))),
        )

    def smallest_scale(self, size: Array) -> Array:
        """Return the least number with which each quantity is compared, from the largest absolute values
        ``size`` of all, shape (columns,).
        """
        largest = {kind: float(size[places].max(initial=0.0)) for kind, places in self.families.items()}
        load = max(math.sqrt(largest["squares"]), largest["moments"])
        noise = {
            "squares": (OVER_NOISE * NOISE * load) * (OVER_NOISE * NOISE * load),
            "moments": LEAST_MOMENT * load,
            "accelerations": max(OVER_NOISE * ROUNDING / (self.step * self.step), self.turning),
        }
        scale = np.zeros_like(size)
        for kind, places in self.families.items():
            share = LEAST_SHARE * LEAST_SHARE if kind == "squares" else LEAST_SHARE
            scale[places] = max(share * largest[kind], noise.get(kind, 0.0))
        return scale


class Points(NamedTuple):
    """A point for each turn, shape (turns, coordinates), and the size with which each is compared."""

    values: Array
    sizes: Array


class PointRows:
    """Read the point of a turn from its outputs: the largest values and, with ``states``, the state at its
    end, where it is ``recorded``.
    """

    def __init__(self, assembly: Assembly, recorded: NDArray[np.uint32], *, states: bool = True) -> None:
        self.comparison = Comparison(assembly, recorded, peaks_only=True)
        place = {int(row): k for k, row in enumerate(recorded)}
        kinds = [[int(row) for name in kind for row in assembly.layout.rows_of(name)] for kind in STATE]
        if not states or not all(row in place for rows in kinds for row in rows):
            kinds = []
        self.columns = [self.comparison.columns, *(np.array([place[row] for row in rows]) for rows in kinds)]
        self.ends = np.cumsum([len(columns) for columns in self.columns])

    def of_turn(self, rows: Array) -> tuple[Array, Array]:
        """Return the point of a turn and the range of each coordinate, from its outputs of :attr:`columns`,
        shape (outputs, coordinates).
        """
        largest = self.ends[0]
        return np.append(rows[:, :largest].max(axis=0), rows[-1, largest:]), np.ptp(rows, axis=0)

    def of_turns(self, turns: Sequence[tuple[Array, Array]]) -> Points:
        """Return the points of some turns, of :meth:`of_turn`."""
        peaks, *states = np.split(np.array([point for point, _ in turns]), self.ends[:-1], axis=1)
        ranges = np.split(turns[-1][1], self.ends[:-1])[1:]
        largest = np.abs(peaks).max(axis=0)
        values, sizes = [peaks], [np.maximum(largest, self.comparison.smallest_scale(largest))]
        for kind, ends, wide in zip(STATE, states, ranges, strict=False):
            if kind == ("particle_theta",):  # a body that rotates has the same angle in the next turn
                ends = within_gap(ends)
            values.append(ends)
            # Of speeds that are all constant the range is rounding.
            rounding = OVER_NOISE * NOISE * np.abs(ends).max(initial=0.0)
            sizes.append(np.maximum(wide, max(LEAST_RANGE * wide.max(initial=0.0), rounding)))
        return Points(np.concatenate(values, axis=1), np.concatenate(sizes))


def within_gap(angles: Array) -> Array:
    """Return angles (rad), shape (turns, bodies), less whole turns: those of a body lie within 2 pi, cut
    where the gap between them is widest, so that equal ones stay equal but for rounding.
    """
    turn = 2.0 * math.pi
    if not angles.size:
        return angles
    places = np.sort(angles - turn * np.floor(angles / turn), axis=0)
    gaps = np.diff(places, axis=0, append=places[:1] + turn)
    widest = gaps.argmax(axis=0)[None]
    cut = np.take_along_axis(places + 0.5 * gaps, widest, axis=0)
    return np.asarray(angles - turn * np.floor((angles - cut) / turn))


def differences(points: Points, shift: int) -> Array:
    """Return the distance (1) of each point from that a ``shift`` before it, shape (turns - shift,)."""
    sizes = np.where(points.sizes > 0.0, points.sizes, 1.0)
    return np.asarray((np.abs(points.values[shift:] - points.values[:-shift]) / sizes).max(axis=1))


def shorter_period(points: Points, period: int, limit: float) -> tuple[int, float] | None:
    """Return the smallest part of a ``period`` after which the points of its last two repeat within the
    ``limit``, and their largest distance (1); None if turns inside a period differ by more.

    Where an onset moves by one output, turns that differ by nothing else are far apart output by output, and
    agree after several turns by chance.
    """
    latest = Points(points.values[-2 * period :], points.sizes)
    for part in (shift for shift in range(1, period) if period % shift == 0):
        distance_inside = float(differences(latest, part).max())
        if distance_inside <= limit and (part == 1 or distinct(points, part)):
            return part, distance_inside
    return None


def distinct(points: Points, period: int) -> bool:
    """Return whether the turns inside a ``period`` differ: in some phase of it points a part of the period
    apart are always further from each other than the step can make, and than twice those a period apart.

    Over the second half of the points: scatter seems to have any period in a few turns.
    """
    latest = Points(points.values[-max(2 * period, len(points.values) // 2) :], points.sizes)
    limit = max(STEP_SHARE, float(differences(latest, period).max()) / SHARE_OF_SCATTER)
    return all(
        max(float(distances[phase::period].min()) for phase in range(period)) > limit
        for distances in (differences(latest, part) for part in range(1, period) if period % part == 0)
    )


def alternation(points: Points, period: int) -> tuple[float, float] | None:
    """Return the last distance (1) of turns a part of a ``period`` apart, and the share (1) by which it
    shrinks a turn; None if it does not shrink, because the period is one.

    Near the end of a motion's stability its deviation changes its sign every turn and decays slowly, so that
    turns two apart agree long before successive turns do.
    """
    for part in (shift for shift in range(1, period) if period % shift == 0):
        distances = differences(points, part)
        distances = distances[-max(FEWEST_ALTERNATIONS, len(distances) // 2) :]
        count = len(distances)
        if count < FEWEST_ALTERNATIONS or not settles(distances.tolist()):
            continue
        fall, late = (log(distances[-1] / distances[k]) / (count - 1 - k) for k in (0, count // 2))
        if late < STEADY_DECAY * fall:
            return float(distances[-1]), 1.0 - float(exp(fall))
    return None


def settles_late(distances: Sequence[float]) -> bool:
    """Return whether the later half of distances falls steadily and to less than half, after a transient in
    which turns had nothing in common.
    """
    late = distances[-(len(distances) // 2) - 1 :]
    return len(late) > FEWEST_LATE and settles(late, LATE_FALL)


def settles(distances: Sequence[float], fallen: float = FALLEN) -> bool:
    """Return whether distances fall steadily, by a least-squares line through their logarithms, and at least
    by the factor ``fallen``.
    """
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
    return product < FALLING * math.sqrt(wide * high) and product / wide * (len(values) - 1) < log(fallen)


class Settling:
    """Detect, at the end of each turn, whether the turns of a run repeat within a ``tolerance``: then the run
    has settled.

    Turns repeat with a period of p turns when p turns in a row, and at least two, have each been within the
    tolerance of the turn p before. Those of a period of several turns must differ inside it by more than the
    step can make, and not approach each other (:func:`alternation`), or else by less than the tolerance.
    """

    def __init__(self, assembly: Assembly, recorded: NDArray[np.uint32], tolerance: float) -> None:
        outputs = outputs_of_a_turn(assembly)
        self.tolerance, self.outputs = tolerance, outputs or 0
        self.comparison, self.reader = Comparison(assembly, recorded), PointRows(assembly, recorded)
        self.columns = np.concatenate([self.comparison.columns, *self.reader.columns])
        self.points: deque[tuple[Array, Array]] = deque(maxlen=TREND + 1)
        self.turns: deque[Array] = deque(maxlen=LONGEST)
        self.sizes: deque[Array] = deque(maxlen=LONGEST)  # the largest absolute values of each
        self.parts: list[Array] = []
        self.inside = 0  # outputs of the current turn so far
        self.streaks = [0] * LONGEST
        self.period: int | None = None  # shortest with which the turns repeat
        self.motion_period: int | None = None  # of the motion: a part of it where onsets move by an output

    @property
    def remaining(self) -> int:
        """Number of outputs to the end of the current turn; 0 without turns to compare."""
        return self.outputs - self.inside if self.outputs else 0

    @property
    def settled(self) -> bool:
        """Whether turns repeat."""
        return self.period is not None

    def _confirmed(self, period: int) -> int | None:
        """Return the period of the points of the turns: the ``period`` with which turns repeat, or a part;
        None if they have neither.
        """
        if period == 1:
            return period
        points = self.reader.of_turns(self.points)
        if (part := shorter_period(points, period, self.tolerance)) is not None:
            return part[0]
        return period if alternation(points, period) is None and distinct(points, period) else None

    def turns_of_means(self, last: int) -> int:
        """Return over how many turns at the end means of the ``last`` turns extend: once turns repeat, only
        over those that do, in whole periods; a start that still settles is no part of them.
        """
        period = self.period
        if period is None:
            return last
        count = min(last, self.streaks[period - 1] + period)
        return count // period * period or count

    def turns_of_period(self) -> int:
        """Return over how many turns at the end a mean represents the motion: those that repeat, in whole
        periods, if a period has several turns; else the last one.
        """
        if self.period is None or self.motion_period in (None, 1):
            return 1
        period = self.motion_period or 1
        return min(self.streaks[self.period - 1], LONGEST) // period * period

    def take(self, rows: Array) -> None:
        """Add outputs after that of step 0, at most :attr:`remaining` of them."""
        if not self.outputs or not len(rows):
            return
        self.parts.append(rows[:, self.columns])
        self.inside += len(rows)
        if self.inside < self.outputs:
            return
        outputs = self.parts[0] if len(self.parts) == 1 else np.concatenate(self.parts)
        self.parts, self.inside = [], 0
        turn, rest = np.split(outputs, [len(self.comparison.columns)], axis=1)
        self.points.append(self.reader.of_turn(rest))
        size = np.abs(turn).max(axis=0)
        hopeless = self._differing(turn, size)
        for period, former in enumerate(reversed(self.turns), 1):
            repeats = not hopeless[-period] and self.comparison.distance(former, turn) <= self.tolerance
            self.streaks[period - 1] = self.streaks[period - 1] + 1 if repeats else 0
        self.turns.append(turn)
        self.sizes.append(size)
        streaks = enumerate(self.streaks, 1)
        shortest = next((period for period, streak in streaks if streak >= max(period, LEAST_STREAK)), None)
        self.motion_period = None if shortest is None else self._confirmed(shortest)
        self.period = None if self.motion_period is None else shortest

    def _differing(self, turn: Array, size: Array) -> NDArray[np.bool_]:
        """Return which of the former turns differ by more than the tolerance at a few outputs already,
        relative to the largest numbers with which they may be compared.
        """
        if not self.turns:
            return np.zeros(0, dtype=bool)
        largest = np.max([size, *self.sizes], axis=0)
        limit = self.tolerance * SURE * np.maximum(largest, self.comparison.smallest_scale(largest))
        sample = slice(None, None, max(1, len(turn) // GLANCES))
        return np.asarray(
            (np.abs(np.stack([former[sample] for former in self.turns]) - turn[sample]) > limit).any(
                axis=(1, 2)
            )
        )

    def restore(self, rows: Array) -> None:
        """Continue after all outputs so far, including that of step 0; only the latest turns are used."""
        if not self.outputs:
            return
        turns = (len(rows) - 1) // self.outputs
        first = 1 + max(turns - LATEST, 0) * self.outputs
        while first < len(rows):
            self.take(rows[first : first + self.remaining])
            first += self.outputs


def repeated_since(
    turns: Sequence[Array],
    comparison: Comparison,
    tolerance: float,
    streak: int = 1,
    periods: Iterable[int] = range(1, LONGEST + 1),
) -> tuple[int, int] | None:
    """Return the first of some ``periods`` (turns) with which the turns of a run repeat, and the first turn,
    counted from 1, from which each is within ``tolerance`` of the one a period before; None if they do not
    repeat.

    A period of p turns needs p turns that repeat, ``streak`` times. ``turns`` have the shape (outputs,
    columns) each.
    """
    count = len(turns)
    for period in (period for period in periods if period <= count // (streak + 1)):
        first = count
        while (
            first > period and comparison.distance(turns[first - 1 - period], turns[first - 1]) <= tolerance
        ):
            first -= 1
        if count - first >= streak * period:
            return period, first + 1
    return None
