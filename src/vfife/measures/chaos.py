"""Classification of a motion by its points once a turn: period, Lyapunov exponent, 0-1 test, closed curve.

No single test decides. Points that repeat show a period, unless a small difference grows: then they repeat
only within the tolerance and for as long as there are points. A positive exponent shows chaos, but it
converges as ln(n)/n, so near zero it does not distinguish a quasi-periodic motion. The 0-1 test needs no
exponent, but a hundred points. Fewer points are quasi-periodic if they lie in order on one closed curve. A
motion that no test decides is called not settled.

All functions take points of any map or section; the tests use maps with known answers.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import atan2, hypot, sincos
from ..numerics.outward import DOWN, UP, significant
from .trend import TREND, Points, alternation

Array = NDArray[np.float64]

# Points are equal if they differ by less than this share of their size, however small the range of all points
# is.
EQUAL = 1e-5
LONGEST = 16  # longest period that is searched, in points
TIMES = 3  # that a period must be seen
ANGLES = 100  # angles of the 0-1 test
STEP_UNKNOWN = "uncertainty due to the step: not estimated"
# Widths by which the range of an exponent exceeds its values: of two step sizes, and of four means over turns
# (:mod:`~vfife.measures.error_ranges`).
STEP_WIDTHS, SCATTER_WIDTHS = 2.0, 1.0
NO_EXPONENT = (
    "exponent not estimated, because there was no small difference, or it left the range of numbers, in some"
    " turn"
)
# Growth below this (ln 1e-300, and its rounding) is that of a difference that vanished; files of former
# versions contain it.
VANISHED = -690.0
NO_BOUND = "exponent below any number, because the small difference vanished in some turn"
SHARE = 10  # the 0-1 test uses displacements over up to a tenth of the series


def _percent(share: float) -> str:
    """Return a share in per cent with two digits, without an exponent from 100 % on."""
    return f"{100.0 * share:.{3 if share >= 0.995 else 2}g} %"


def signed_range(low: float, high: float, word: str = "to") -> str:
    """Return a range of exponents with signs and three digits, its ends rounded outwards."""
    ends = (float(significant(low, 3, DOWN)), float(significant(high, 3, UP)))
    return f"{ends[0]:+.3g} {word} {ends[1]:+.3g}"


@dataclass(frozen=True)
class Exponent:
    """Largest Lyapunov exponent (1/turn): the mean logarithm of the growth of a small difference in one turn.

    ``low`` and ``high``: its range, from a motion with half the step, from the scatter of halves of the
    turns and from their number (:meth:`with_finer`); NaN where there is no such motion, and the uncertainty
    due to the step is not estimated. ``running``: the mean after each turn, which shows its convergence.
    ``halves``: the means of both halves of the turns, the lower first; they say nothing about the step.
    """

    value: float
    low: float
    high: float
    running: Array = field(repr=False)
    halves: tuple[float, float]

    @property
    def estimated(self) -> bool:
        """Whether the range is known."""
        return self.low <= self.high

    @property
    def vanished(self) -> bool:
        """Whether the small difference vanished in some turn, so that the exponent is -inf."""
        return self.value == -math.inf

    @property
    def words(self) -> str:
        """The exponent with its range or without, in words."""
        if math.isnan(self.value):
            return NO_EXPONENT
        if self.vanished:
            return NO_BOUND
        if self.estimated:
            return f"exponent {self.value:+.3g} per turn ({signed_range(self.low, self.high)})"
        halves = f"{signed_range(*self.halves, 'and')} in its halves"
        return f"exponent {self.value:+.3g} per turn ({halves}; {STEP_UNKNOWN})"

    @property
    def margin(self) -> float:
        """Size (1/turn) below which the exponent may be zero: that of a motion that neither attracts nor
        repels converges to zero as ln(n)/n over n turns.
        """
        return 2.0 / max(len(self.running), 2)

    @property
    def grows(self) -> bool:
        """Whether the small difference grows in both halves of the turns."""
        return self.halves[0] > self.margin

    @property
    def decays(self) -> bool:
        """Whether the small difference decays in both halves of the turns."""
        return self.halves[1] < -self.margin

    @property
    def turn_error(self) -> float:
        """Error (1/turn) due to the number of turns: the range of the sum of the logarithms about its mean
        slope, over the number of turns.

        A small difference that rotates is longer in some directions than in others (complex multipliers of a
        periodic motion; the norm is arbitrary), so that its length swings about the exponential. The mean
        over n turns contains the difference of two points of that swing over n, whatever the step is.
        """
        count = np.arange(1, len(self.running) + 1)
        swing = np.append(0.0, count * (self.running - self.value))
        return float(np.ptp(swing)) / len(count)

    def with_finer(self, finer: Exponent) -> Exponent:
        """Return the exponent with a range that includes that of a motion with half the step.

        The range holds both values, widened by twice their distance, as those of two step sizes are
        elsewhere, and by the error due to the number of turns; and the four means of halves, widened by their
        own width, as those of four means over turns are.
        """
        values, halves = (self.value, finer.value), (*self.halves, *finer.halves)
        scatter = max(halves) - min(halves)
        reach = STEP_WIDTHS * abs(values[0] - values[1]) + max(self.turn_error, finer.turn_error)
        low = min(min(values) - reach, min(halves) - SCATTER_WIDTHS * scatter)
        high = max(max(values) + reach, max(halves) + SCATTER_WIDTHS * scatter)
        return dataclasses.replace(self, low=low, high=high)


def exponent(growth: Sequence[float] | Array) -> Exponent:
    """Compute the exponent from the logarithms of the growth of a tangent in each turn, renormalised after it
    (Benettin et al. 1980).
    """
    logs = np.asarray(growth, dtype=float)
    logs = np.where(logs < VANISHED, -np.inf, logs)
    running = np.cumsum(logs) / np.arange(1, len(logs) + 1)
    half = len(logs) // 2
    means = [float(part.mean()) for part in (logs[:half], logs[half:]) if len(part)]
    return Exponent(float(running[-1]), math.nan, math.nan, running, (min(means), max(means)))


def rows_of(points: Array) -> Array:
    """Return the points as numbers, shape (points, coordinates)."""
    points = np.asarray(points, dtype=float)
    return points.reshape(len(points), math.prod(points.shape[1:]))


def period(points: Array, tolerance: float = 1e-3, longest: int = LONGEST) -> int | None:
    """Return the smallest number of points after which they repeat, None if they do not within ``longest``.

    ``points``: shape (points,) or (points, coordinates); two are equal within ``tolerance`` of the range of
    all, or :data:`EQUAL` of their size, because a motion that comes to rest has no range. A period must be
    seen three times.
    """
    points = rows_of(points)
    size = np.maximum(tolerance * np.ptp(points, axis=0), smallest_difference(points))
    for shift in range(1, min(longest, len(points) // TIMES) + 1):
        if (largest_difference(points, shift) <= size).all():
            return shift
    return None


def smallest_difference(points: Array) -> Array:
    """Return the difference below which coordinates are equal, shape (coordinates,)."""
    return np.asarray(EQUAL * np.abs(points).max(axis=0) + 1e-300)


def largest_difference(points: Array, shift: int) -> Array:
    """Return the largest difference of points a ``shift`` apart among the last three times as many, shape
    (coordinates,).
    """
    last = points[-3 * shift :]
    return np.asarray(np.abs(last[shift:] - last[:-shift]).max(axis=0))


def recurrence_distance(points: Array, shift: int | None = None, longest: int = LONGEST) -> float:
    """Return the difference of points a ``shift`` apart, as a share of the range of all; without ``shift``
    the smallest up to ``longest``.
    """
    points = rows_of(points)
    size = np.maximum(np.ptp(points, axis=0), smallest_difference(points))
    shifts = range(1, min(longest, len(points) // TIMES) + 1) if shift is None else (shift,)
    return min(
        (float((largest_difference(points, shift) / size).max()) for shift in shifts), default=float("nan")
    )


def zero_one(series: Array, seed: int = 0) -> float:
    """Return the result of the 0-1 test for chaos (Gottwald and Melbourne 2009) of a series, shape (points,):
    near 0 if regular, near 1 if chaotic.

    For an angle c, the mean square displacement of (sum phi cos jc, sum phi sin jc) over time grows linearly
    if the motion is chaotic and stays bounded if it is regular. The result is the median over a hundred
    angles of its correlation with time. phi is the series minus its mean, which would make the displacement
    oscillate. Points must be sampled so rarely that they look unrelated: once a turn, not a hundred times.
    """
    phi = np.asarray(series, dtype=float)
    if np.ptp(phi) <= 1e-9 * np.abs(phi).max(initial=0.0):
        return 0.0
    phi = (phi - phi.mean()) / np.ptp(phi)
    count, longest = len(phi), max(2, len(phi) // SHARE)
    j, shifts = np.arange(1, count + 1), np.arange(1, longest + 1)
    correlations = []
    for c in math.pi / 5.0 + 3.0 * math.pi / 5.0 * np.random.default_rng(seed).random(ANGLES):
        s, e = sincos(c * j)
        p, q = np.cumsum(phi * e), np.cumsum(phi * s)
        square = [
            mean_square(p, n, count - longest) + mean_square(q, n, count - longest)
            for n in range(1, longest + 1)
        ]
        correlations.append(correlation(shifts.astype(float), np.array(square)))
    return float(np.median(correlations))


def mean_square(series: Array, shift: int, count: int) -> float:
    """Return the mean square of the first ``count`` differences of a series over a shift."""
    way = (series[shift:] - series[:-shift])[:count]
    return float((way * way).mean())


def correlation(first: Array, second: Array) -> float:
    """Return the correlation of two series; 0 if one is constant. The sums are ours, because those of BLAS
    depend on the processor.
    """
    a, b = first - first.mean(), second - second.mean()
    size = math.sqrt(float((a * a).sum()) * float((b * b).sum()))
    return float((a * b).sum()) / size if size > 0.0 else 0.0


QUASI, CHAOTIC, UNSETTLED, DIVERGED = "quasi-periodic", "chaotic", "not settled", "diverged"
NO_POINTS = "nothing recorded yet"
UNDECIDED = "not decided"  # points repeat although a small difference grows, which excludes each other
TEST_POINTS = 100  # points from which on the 0-1 test is used
REGULAR, IRREGULAR = 0.3, 0.7  # its answers below and above which a motion is regular and chaotic
AGREEING = 2.0  # largest ratio of the exponents of both halves, for fewer points
ROUGHEST = 5.0  # variation of the radius along a closed curve, over twice its range
ORDERED = 0.95  # share of neighbours along a closed curve whose next points have the same order


@dataclass(frozen=True)
class Rotation:
    """Rotation of points about their mean: ``number`` of turns for each point.

    ``rough``: variation of the radius along the angles over twice its range, about 1 for a closed curve and a
    share of the number of points for a cloud. ``order``: share of neighbours whose next points have the same
    order.
    """

    number: float
    rough: float
    order: float

    @property
    def closed(self) -> bool:
        """Whether the points lie on one closed curve and go round it in order, as no chaotic motion does."""
        return self.rough <= ROUGHEST and self.order >= ORDERED


@dataclass(frozen=True)
class Verdict:
    """Class of a motion, ``kind``, and the evidence.

    ``distance`` of points a ``period`` apart, as a share of the range of all (of the best period where none
    is within the tolerance). ``scatter``: the same as a share of the motion's range, where its points scatter
    with the step; NaN otherwise. ``exponent``: largest Lyapunov exponent (1/turn); ``zero_one``: 0-1 test, of
    at least 100 points; ``rotation`` about the mean. None was not computed. ``reason``: why nothing is
    decided, where it is not that points repeat although a difference grows. ``longest``: the largest shift
    (points) whose points were compared. ``repeats``: turns after which points repeat that differ by so little
    between these turns that the step may make the difference; 0 for others.
    """

    kind: str
    period: int | None
    distance: float
    exponent: Exponent | None = None
    zero_one: float | None = None
    rotation: Rotation | None = None
    scatter: float = math.nan
    reason: str = ""
    longest: int = LONGEST
    repeats: int = 0

    def __str__(self) -> str:
        return f"{self.kind}: {self.evidence}"

    @property
    def evidence(self) -> str:
        """The evidence in words."""
        within = f"within {_percent(self.distance)} of the range"
        turns = "a turn" if self.period == 1 else f"{self.period} turns"
        texts = [
            (
                f"points {turns} apart lie within {_percent(self.scatter)} of the motion's range,"
                f" {self._cause}"
                if self.scatter >= 0.0
                else f"points {turns} apart lie {within}"
                if self.period
                else f"points {self._shifts} agree {within} at best, so there is no period"
                if self.longest
                else f"with fewer than {TIMES} points whether turns repeat is not known"
            )
        ]
        if self.kind == UNDECIDED or self.reason:
            texts = [
                self.reason
                or f"points come back {within}, as those of a periodic motion do, although a small difference"
                " grows: try a smaller step"
            ]
        if self.exponent is not None:
            texts.append(self.exponent.words)
        if self.zero_one is not None:
            texts.append(f"0-1 test {self.zero_one:.2f}")
        if self.rotation is not None and self.rotation.closed and not self.reason:
            texts.append(f"one closed curve, gone round {self.rotation.number:.4f} times a turn")
        return ", ".join(texts)

    @property
    def _cause(self) -> str:
        """Why points that scatter are taken for those of a shorter period."""
        if not self.repeats:
            return "and scatter with the step, because a small difference decays"
        return (
            f"and repeat after {self.repeats}: so small a difference may be one of the step, which places"
            " onsets differently in these turns; compare half the step"
        )

    @property
    def _shifts(self) -> str:
        """How far apart the points are that were compared."""
        return "a turn apart" if self.longest == 1 else f"up to {self.longest} turns apart"


def rotation(points: Array) -> Rotation | None:
    """Measure the rotation of points about their mean, shape (points,) or (points, coordinates); None for
    fewer than eight.

    The plane is that of the first two coordinates, or of each value and the next one.
    """
    points = rows_of(points)
    plane = points[:, :2] if points.shape[1] > 1 else np.column_stack([points[:-1, 0], points[1:, 0]])
    if len(plane) < 8:
        return None
    size = np.ptp(plane, axis=0)
    if not (size > 0.0).all():
        return None
    around = (plane - plane.mean(axis=0)) / size
    angle, radius = atan2(around[:, 1], around[:, 0]), hypot(around[:, 0], around[:, 1])
    turn = 2.0 * np.pi
    radii, next_angle = (
        radius[np.argsort(angle, kind="stable")],
        angle[1:][np.argsort(angle[:-1], kind="stable")],
    )
    swing = max(float(np.ptp(radii)), 1e-3 * float(radii.mean()))
    rough = float(np.abs(np.diff(radii)).sum()) / (2.0 * swing)
    order = float((np.mod(np.diff(next_angle), turn) < np.pi).mean())
    return Rotation(float(np.mod(np.diff(angle), turn).mean()) / turn, rough, order)


SCATTER = 0.01  # largest scatter of points due to the step, as a share of the motion's range
TAIL = 3 * LONGEST  # latest points: of those before, the motion may still settle
SETTLED = 3.0  # largest ratio of the scatter of the first half of the points to that of the second


def scattered_period(points: Array, ranges: Array, limit: float = SCATTER) -> tuple[int, float] | None:
    """Return the period of points that scatter about periodic ones, and their scatter as a share of
    ``ranges``, shape (coordinates,), the ranges of the motion; None if they scatter by more than ``limit``,
    or still settle.
    """
    size = np.maximum(ranges, smallest_difference(points))

    def spread(part: Array, shift: int) -> float:
        return float((np.abs(part[shift:] - part[:-shift]) / size).max())

    half = len(points) // 2
    for shift in range(1, min(LONGEST, len(points) // 6) + 1):
        share = spread(points, shift)
        if share <= limit and spread(points[:half], shift) <= SETTLED * spread(points[half:], shift):
            return shift, share
    return None


def verdict(
    points: Array,
    growth: Exponent | None = None,
    tolerance: float = 1e-3,
    ranges: Callable[[], Array] | None = None,
) -> Verdict:
    """Classify a motion by its ``points``, shape (points,) or (points, coordinates), and the exponent of its
    ``growth`` if known.

    ``ranges`` computes the range of each coordinate in the whole motion, shape (coordinates,). If a small
    difference decays, points that lie within a hundredth of it are periodic, and scatter with the step. So do
    points that repeat after several turns, unless a small difference grows: a longer period with so small a
    difference is not told from the effect of the step.

    Points that repeat within ``tolerance`` of their range, three times, have a period, unless a small
    difference grows more than e-fold in each half of the turns: then nothing is decided. Points that
    alternate about a shorter period and approach it, as the turns of a run do
    (:func:`~vfife.measures.trend.alternation`), are not settled. Without a period, a
    motion is chaotic if a difference grows so (for fewer than 100 points, about as fast in both halves), and
    not settled if it decays as fast or the halves disagree. In between the 0-1 test decides, or for fewer
    than 100 points whether they lie on a closed curve.

    Points within a hundredth of the motion's range may be those of a periodic motion that scatter with the
    step, which looks like noise to the 0-1 test: without a difference that grows over 100 turns they are not
    called chaotic, but not decided. Without points nothing is decided either.
    """
    points = rows_of(points)
    if not len(points):
        return Verdict(UNDECIDED, None, math.nan, reason=NO_POINTS)
    if not np.isfinite(points).all():
        return Verdict(DIVERGED, None, float("nan"), growth)
    repeats = period(points, tolerance)
    distance = recurrence_distance(points, repeats)
    finite = None if growth is None or math.isnan(growth.value) else growth
    margin = 0.0 if growth is None else growth.margin
    grows, decays = growth is not None and growth.grows, finite is not None and finite.decays
    if ranges is not None and repeats != 1 and (decays if repeats is None else not grows):
        # Steps themselves may repeat after several turns, each with another place of an onset in its step:
        # the points of one motion then repeat exactly, a hair's breadth apart.
        scattered = scattered_period(points if repeats is None else points[-TAIL:], ranges())
        if scattered is not None and (repeats is None or scattered[0] < repeats):
            kind = f"period {scattered[0]}"
            return Verdict(kind, scattered[0], distance, growth, scatter=scattered[1], repeats=repeats or 0)
    if repeats is not None:
        if grows:
            return Verdict(UNDECIDED, None, distance, growth)
        reason = settling_reason(points, repeats)
        kind, shift = (UNSETTLED, None) if reason else (f"period {repeats}", repeats)
        return Verdict(kind, shift, distance, growth, reason=reason)
    test = zero_one(points[:, 0]) if len(points) >= TEST_POINTS else None
    turning, reason = rotation(points), ""
    if (
        growth is not None
        and grows
        and (len(points) >= TEST_POINTS or growth.halves[1] <= AGREEING * growth.halves[0])
    ):
        kind = CHAOTIC
    elif finite is not None and not (finite.halves[0] >= -margin and finite.value <= margin):
        kind = UNSETTLED
    elif test is None:
        # Successive points that approach their limit lie in order on a line, as on a curve.
        reason = settling_reason(points, 2)
        kind = QUASI if turning is not None and turning.closed and not reason else UNSETTLED
    else:
        kind = QUASI if test < REGULAR else CHAOTIC if test > IRREGULAR else UNSETTLED
    if kind == CHAOTIC and ranges is not None and not (grows and len(points) >= TEST_POINTS):
        reason = small_cloud(points, ranges())
        kind = UNDECIDED if reason else kind
    longest = min(LONGEST, len(points) // TIMES)
    return Verdict(kind, None, distance, growth, test, turning, reason=reason, longest=longest)


def settling_reason(points: Array, repeats: int) -> str:
    """Return why points that repeat after ``repeats`` turns, or lie in order on a curve, do neither
    yet: those a part of these turns apart approach each other; empty where they do not.
    """
    size = np.maximum(np.ptp(points, axis=0), smallest_difference(points))
    trend = alternation(Points(points[-1 - TREND :], np.asarray(size)), repeats)
    if trend is None:
        return ""
    distance, decay = trend
    return (
        f"points still settle: they are {_percent(distance)} of the range apart, and approach each other by"
        f" {_percent(decay)} a turn: drop more turns"
    )


def small_cloud(points: Array, ranges: Array) -> str:
    """Return why points decide nothing that all lie within a hundredth of the ``ranges`` of the motion, shape
    (coordinates,); empty where they do not.
    """
    share = float((np.ptp(points, axis=0) / np.maximum(ranges, smallest_difference(points))).max())
    if share > SCATTER:
        return ""
    return (
        f"all points lie within {_percent(share)} of the motion's range, as those of a periodic motion do"
        " that scatter with the step: follow a small difference for 100 turns, or try a smaller step"
    )
