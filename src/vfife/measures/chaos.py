"""Classification of a motion by its points once a turn: period, Lyapunov exponent, 0-1 test, closed curve.

No single test decides. Points that repeat show a period, unless a small difference grows: then they repeat
only within the tolerance and for as long as there are points. A motion of a period longer than a third of the
points looks like a quasi-periodic or a chaotic one. Chaos therefore needs an exponent whose range is above
zero, and a 0-1 test, of a hundred points, that does not contradict it; a quasi-periodic motion needs an
exponent of about zero and points in order on one closed curve. A motion whose evidence disagrees is not
decided, and one that no test decides is called not settled.

All functions take points of any map or section; the tests use maps with known answers.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..numerics.outward import DOWN, UP, significant
from ..solvers.repeating import SHARE_OF_SCATTER, STEP_SHARE, TREND, Points, alternation
from .trend import (
    IRREGULAR,
    REGULAR,
    TIMES,
    Rotation,
    alikeness,
    period,
    recurrence_distance,
    rotation,
    rows_of,
    smallest_difference,
    spread,
    winding,
    zero_one_of_bands,
)

Array = NDArray[np.float64]

LONGEST = 16  # longest period of points that scatter, in points
STEP_UNKNOWN = "uncertainty due to the step: not estimated"
# Widths by which the range of an exponent exceeds its values: of two step sizes, and of four means over turns
# (:mod:`~vfife.measures.error_ranges`).
STEP_WIDTHS, SCATTER_WIDTHS = 2.0, 1.0
NO_EXPONENT = (
    "exponent not estimated, because there was no small difference, or it left the range of numbers, in some"
    " turn"
)
UNKNOWN_WIDTH = 1.0  # width (1/turn) of a range about zero from which on the exponent is not known
# Growth below this (ln 1e-300, and its rounding) is that of a difference that vanished; files of former
# versions contain it.
VANISHED = -690.0
NO_BOUND = "exponent below any number, because the small difference vanished in some turn"


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

    def __float__(self) -> float:
        """Return :attr:`value`, as measures do."""
        return float(self.value)

    @property
    def estimated(self) -> bool:
        """Whether the range is known."""
        return self.low <= self.high

    @property
    def vanished(self) -> bool:
        """Whether the small difference vanished in some turn, so that the exponent is -inf."""
        return self.value == -math.inf

    @property
    def unknown(self) -> bool:
        """Whether the range has both signs and is so wide that its value says nothing."""
        return self.low < 0.0 < self.high and self.high - self.low > UNKNOWN_WIDTH

    @property
    def words(self) -> str:
        """The exponent with its range or without, in words."""
        if math.isnan(self.value):
            return NO_EXPONENT
        if self.vanished:
            return NO_BOUND
        if self.unknown:
            return f"exponent not known, between {signed_range(self.low, self.high, 'and')} per turn"
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
    def positive(self) -> bool:
        """Whether the exponent is above zero: it grows, and so does all of its range. Without a range due to
        the step, the error due to the number of turns is less than the exponent.
        """
        return self.grows and (self.low > 0.0 if self.estimated else self.value > self.turn_error)

    @property
    def decays(self) -> bool:
        """Whether the small difference decays in both halves of the turns."""
        return self.halves[1] < -self.margin

    @property
    def turn_error(self) -> float:
        """Error (1/turn) due to the number of turns: the range of the sum of the logarithms about its mean
        slope, over the number of turns.

        A small difference that rotates is longer in some directions than in others (complex multipliers; the
        norm is arbitrary), so that its length swings about the exponential. The mean over n turns contains
        the difference of two points of that swing over n, whatever the step is.
        """
        count = np.arange(1, len(self.running) + 1)
        swing = np.append(0.0, count * (self.running - self.value))
        return float(np.ptp(swing)) / len(count)

    def with_scatter(self) -> Exponent:
        """Return the exponent of a periodic motion whose points scatter with the step: its range is wider by
        the standard deviation of single turns, because near a bifurcation the mean is as far from that of the
        motion itself, with any step.
        """
        if not self.estimated:
            return self
        scatter = float(np.diff(np.arange(1, len(self.running) + 1) * self.running, prepend=0.0).std())
        return dataclasses.replace(self, low=self.low - scatter, high=self.high + scatter)

    def with_finer(self, finer: Exponent) -> Exponent:
        """Return the exponent with a range that includes that of a motion with half the step.

        The range holds both values, widened by twice their distance and by the error due to the number of
        turns; and the four means of halves, widened by their own width.
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


QUASI, CHAOTIC, UNSETTLED, DIVERGED = "quasi-periodic", "chaotic", "not settled", "diverged"
NO_POINTS = "nothing recorded yet"
UNDECIDED = "not decided"  # points repeat although a small difference grows, which excludes each other
TEST_POINTS = 100  # points from which on the 0-1 test is used
ORDINALS = {2: "second", 4: "fourth"}  # points of which the 0-1 test takes one
AGREEING = 2.0  # largest ratio of the exponents of both halves, for fewer points
# Times as many turns as were computed, to which a longer computation is advised: with loose pins and stops,
# transients that looked chaotic ended after up to 700 turns.
LONGER = 10


def kind_words(kind: str, turns: int) -> str:
    """Return a kind of motion in words: chaos within the ``turns`` that were computed, because a transient
    that is longer looks alike.
    """
    return f"{kind} within {turns:,} turns" if kind == CHAOTIC else kind


def longer_transient(turns: int) -> str:
    """Return what chaos within some ``turns`` leaves open, and the remedy."""
    return f"a longer transient is possible: --turns {LONGER * turns}"


@dataclass(frozen=True)
class Verdict:
    """Class of a motion, ``kind``, and the evidence.

    ``distance`` of points a ``period`` apart, as a share of the range of all (of the best period where none
    is within the tolerance). ``scatter``: the same as a share of the motion's range, where its points scatter
    with the step; NaN otherwise. ``exponent``: largest Lyapunov exponent (1/turn); ``zero_one``: 0-1 test, of
    at least 100 points; ``rotation`` about the mean. None was not computed. ``reason``: why nothing is
    decided, where it is not that points repeat although a difference grows. ``longest``: the largest shift
    (points) whose points were compared. ``repeats``: turns after which points repeat that differ by so little
    between these turns that the step may make the difference; 0 for others. ``stride``: the 0-1 test is of
    every so many points. ``winding``: rotation number on a closed curve, NaN if points follow none.
    ``alike``: largest distance of points as a share of their size, where they are equal; NaN otherwise.
    ``turns`` of a chaotic motion, with those before the points.
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
    stride: int = 1
    winding: float = math.nan
    alike: float = math.nan
    turns: int = 0

    def __str__(self) -> str:
        return f"{self.words}: {self.evidence}"

    @property
    def words(self) -> str:
        """The kind in words."""
        return kind_words(self.kind, self.turns)

    @property
    def evidence(self) -> str:
        """The evidence in words."""
        within = f"within {_percent(self.distance)} of the range"
        if self.alike >= 0.0:
            within = f"within {_percent(self.alike)} of their size, as points that are equal"
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
            of = f" of every {ORDINALS[self.stride]} point" if self.stride > 1 else ""
            texts.append(f"0-1 test {self.zero_one:.2f}{of}")
        closed = self.rotation is not None and self.rotation.closed
        number = self.rotation.number if self.rotation is not None and closed else self.winding
        if not math.isnan(number) and not self.reason:
            texts.append(f"one closed curve, gone round {number:.4f} times a turn")
        open_end = f"; {longer_transient(self.turns)}" if self.kind == CHAOTIC else ""
        return ", ".join(texts) + open_end

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


SCATTER = 0.01  # largest scatter of points due to the step, as a share of the motion's range
LONGER_OR_STEP = (
    "a longer period, or an effect of the step, which places onsets differently in these turns; compare half"
    " the step"
)
TAIL = 3 * LONGEST  # latest points: of those before, the motion may still settle
SETTLED = 3.0  # largest ratio of the scatter of the first half of the points to that of the second


def scattered_period(points: Array, ranges: Array, limit: float = SCATTER) -> tuple[int, float] | None:
    """Return the period of points that scatter about periodic ones, and their scatter as a share of
    ``ranges``, shape (coordinates,), the ranges of the motion; None if they scatter by more than ``limit``,
    or still settle: points any multiple of the period apart are much closer in the second half.
    """
    half = len(points) // 2
    shifts = range(1, min(LONGEST, len(points) // 6) + 1)
    shares = {shift: spread(points, shift, ranges) for shift in shifts}
    for shift, share in shares.items():
        if share > limit:
            continue
        for multiple in shifts[shift - 1 :: shift]:
            first, second = (spread(part, multiple, ranges) for part in (points[:half], points[half:]))
            if shares[multiple] <= limit and first <= SETTLED * second:
                return shift, share
    return None


def longer_period(points: Array, ranges: Array, shift: int) -> int:
    """Return the smallest multiple of a ``shift`` after which points that scatter repeat much better, so that
    the step alone does not explain their scatter; 0 for none.
    """
    limit = SHARE_OF_SCATTER * spread(points, shift, ranges)
    multiples = range(2 * shift, len(points) // TIMES + 1, shift)
    return next((multiple for multiple in multiples if spread(points, multiple, ranges) <= limit), 0)


def scattered_verdict(
    points: Array, growth: Exponent | None, repeats: int | None, ranges: Array
) -> Verdict | None:
    """Return the verdict on points that scatter with the step about periodic ones; None for others.

    Steps themselves may repeat after several turns, each with another place of an onset in its step: the
    points of one motion then repeat exactly, a hair's breadth apart. Points further apart may have a longer
    period, and nothing is decided.
    """
    latest = points if repeats is None else points[-max(TAIL, 2 * repeats) :]
    scattered = scattered_period(latest, ranges)
    if scattered is None or (repeats is not None and scattered[0] >= repeats):
        return None
    shift, share = scattered
    distance = recurrence_distance(points, repeats)
    longer = longer_period(latest, ranges, shift) if repeats is None else repeats
    if longer and share > STEP_SHARE:
        gap = "a turn" if shift == 1 else f"{shift} turns"
        reason = (
            f"points {gap} apart lie within {_percent(share)} of the motion's range, and those {longer}"
            f" turns apart much closer: {LONGER_OR_STEP}"
        )
        return Verdict(UNDECIDED, None, distance, growth, reason=reason)
    growth = growth and growth.with_scatter()
    return Verdict(f"period {shift}", shift, distance, growth, scatter=share, repeats=repeats or 0)


def verdict(
    points: Array,
    growth: Exponent | None = None,
    tolerance: float = 1e-3,
    ranges: Callable[[], Array] | None = None,
    dropped: int = 0,
) -> Verdict:
    """Classify a motion by its ``points``, shape (points,) or (points, coordinates), after ``dropped`` turns,
    and the exponent of its ``growth`` if known.

    ``ranges`` computes the range of each coordinate in the whole motion, shape (coordinates,). If a small
    difference decays, points that lie within a hundredth of it are periodic, and scatter with the step. So do
    points that repeat after several turns, unless a small difference grows: a longer period with so small a
    difference is not told from the effect of the step (:func:`scattered_verdict`).

    Points that repeat within ``tolerance`` of their range, three times, have a period, unless the exponent is
    :attr:`~Exponent.positive`: then nothing is decided. Points that alternate about a shorter period and
    approach it (:func:`~vfife.solvers.repeating.alternation`) are not settled. For others
    :func:`_kind_without_period` decides.

    Points within a hundredth of the motion's range look like noise to the 0-1 test if they scatter with the
    step: without a difference that grows over 100 turns they are not decided.
    """
    points = rows_of(points)
    if not len(points):
        return Verdict(UNDECIDED, None, math.nan, reason=NO_POINTS)
    if not np.isfinite(points).all():
        return Verdict(DIVERGED, None, float("nan"), growth)
    repeats = period(points, tolerance)
    grows = growth is not None and growth.positive
    decays = growth is not None and not math.isnan(growth.value) and growth.decays
    if ranges is not None and repeats != 1 and (decays if repeats is None else not grows):
        scattered = scattered_verdict(points, growth, repeats, ranges())
        if scattered is not None:
            return scattered
    distance = recurrence_distance(points, repeats)
    if repeats is not None:
        if grows:
            return Verdict(UNDECIDED, None, distance, growth)
        reason = settling_reason(points, repeats)
        kind, shift = (UNSETTLED, None) if reason else (f"period {repeats}", repeats)
        return Verdict(kind, shift, distance, growth, reason=reason, alike=alikeness(points))
    test, stride = zero_one_of_bands(points[:, 0], grows) if len(points) >= TEST_POINTS else (None, 1)
    turning = rotation(points)
    kind, reason = _kind_without_period(points, growth, test, turning)
    number = curve_number(points, turning) if kind == QUASI else math.nan
    if kind == CHAOTIC and ranges is not None and not (grows and test is not None):
        reason = small_cloud(points, ranges())
        kind = UNDECIDED if reason else kind
    longest = len(points) // TIMES
    return Verdict(
        kind, None, distance, growth, test, turning,
        reason=reason, longest=longest, stride=stride, winding=number, turns=dropped + len(points),
    )  # fmt: skip


def curve_number(points: Array, turning: Rotation | None) -> float:
    """Return the rotation number of points on a closed curve; NaN for others."""
    return turning.number if turning is not None and turning.closed else winding(points)


def _kind_without_period(
    points: Array, growth: Exponent | None, test: float | None, turning: Rotation | None
) -> tuple[str, str]:
    """Return the kind of a motion whose points do not repeat, and why nothing is decided, "" for no reason.
    ``test``: the 0-1 test, of 100 points and more.

    It is chaotic if the exponent is positive and the test is not that of a regular motion (for fewer points,
    if both halves grow about as fast), and not settled if a difference decays as fast or the halves disagree.
    With an exponent of about zero it is quasi-periodic if the points follow a closed curve, never chaotic.
    Without an exponent the test decides. What looks regular, but follows no curve, may have a period that is
    too long to be seen: nothing is decided.
    """
    finite = None if growth is None or math.isnan(growth.value) else growth
    unseen = f"a period of more than {len(points) // TIMES} turns is possible: take more turns"
    if finite is not None and finite.grows:
        agreeing = test is not None or finite.estimated or finite.halves[1] <= AGREEING * finite.halves[0]
        regular = test is not None and test < REGULAR
        if finite.positive and agreeing and not regular:
            return CHAOTIC, ""
        if test is None:
            return UNSETTLED, ""
        cause = (
            "by the 0-1 test the motion is regular"
            if regular
            else f"the exponent may be zero by its range{'' if finite.estimated else ' over these turns'}"
        )
        return UNDECIDED, f"a small difference seems to grow, but {cause}; {unseen}"
    if finite is not None and not (finite.halves[0] >= -finite.margin and finite.value <= finite.margin):
        return UNSETTLED, ""
    if test is None:
        # Successive points that approach their limit lie in order on a line, as on a curve.
        reason = settling_reason(points, 2)
        closed = turning is not None and turning.closed and not reason
        return (QUASI if closed else UNSETTLED), reason
    if test < REGULAR or (test <= IRREGULAR and finite is not None):
        if not math.isnan(curve_number(points, turning)):
            return QUASI, ""
        if test < REGULAR:
            return UNDECIDED, f"points follow no closed curve; {unseen}"
    if test > IRREGULAR and finite is None:
        return CHAOTIC, ""
    return UNSETTLED, ""


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
