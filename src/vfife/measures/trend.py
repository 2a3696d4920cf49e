"""Points of a motion, once a turn: whether they repeat, the closed curve on which those of a quasi-periodic
motion lie, and the 0-1 test, whether they are irregular. Whether they settle:
:mod:`~vfife.solvers.repeating`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import atan2, hypot, sincos

Array = NDArray[np.float64]

# Points are equal if they differ by less than this share of their size, however small the range of all points
# is.
EQUAL = 1e-5
TIMES = 3  # that a period must be seen
ROUGHEST = 5.0  # variation of the radius along a closed curve, over twice its range
ORDERED = 0.95  # share of neighbours along a closed curve whose next points have the same order
ANGLES = 100  # angles of the 0-1 test
SHARE = 10  # the 0-1 test uses displacements over up to a tenth of the series
REGULAR, IRREGULAR = 0.3, 0.7  # its answers below and above which a motion is regular and chaotic
STRIDES = 2, 4  # points, of which the 0-1 test takes one to see chaos in bands
BAND_POINTS = 50  # that it needs then
FOLLOWED = 120  # latest points whose curve is sought: of more, scatter outweighs the steps along it
PEAKS = 8  # of the spectrum, whose frequencies may be the rotation number
# Largest distance of neighbours along a curve, over their mean distance: longer periods leave larger ones.
LARGEST_GAP = 5.0
# Largest sum of the distances of points from the line between their neighbours along a curve, over that of
# the steps along it: 1 of points in groups, 0.9 of random ones, and of 200 on a curve of five lobes 0.1.
SMOOTH = 0.25


def rows_of(points: Array) -> Array:
    """Return the points as numbers, shape (points, coordinates)."""
    points = np.asarray(points, dtype=float)
    return points.reshape(len(points), math.prod(points.shape[1:]))


def period(points: Array, tolerance: float = 1e-3) -> int | None:
    """Return the smallest number of points after which they repeat, None if they do not within a third of
    them.

    ``points``: shape (points,) or (points, coordinates); two are equal within ``tolerance`` of the range of
    all, or :data:`EQUAL` of their size, because a motion that comes to rest has no range. A period must be
    seen three times.
    """
    points = rows_of(points)
    size = np.maximum(tolerance * np.ptp(points, axis=0), smallest_difference(points))
    for shift in range(1, len(points) // TIMES + 1):
        if (largest_difference(points, shift) <= size).all():
            return shift
    return None


def smallest_difference(points: Array) -> Array:
    """Return the difference below which coordinates are equal, shape (coordinates,)."""
    return np.asarray(EQUAL * np.abs(points).max(axis=0) + 1e-300)


def alikeness(points: Array) -> float:
    """Return the largest range of coordinates as a share of their size if none exceeds :data:`EQUAL`, so that
    all points are equal and a share of their range says nothing; NaN otherwise.
    """
    share = float((np.ptp(points, axis=0) / (np.abs(points).max(axis=0) + 1e-300)).max())
    return share if share <= EQUAL else math.nan


def recurrence_distance(points: Array, shift: int | None = None) -> float:
    """Return the difference of points a ``shift`` apart, as a share of the range of all; without ``shift``
    the smallest.
    """
    points = rows_of(points)
    size = np.maximum(np.ptp(points, axis=0), smallest_difference(points))
    shifts = range(1, len(points) // TIMES + 1) if shift is None else (shift,)
    return min(
        (float((largest_difference(points, shift) / size).max()) for shift in shifts), default=float("nan")
    )


def spread(points: Array, shift: int, ranges: Array) -> float:
    """Return the largest difference (1, of ``ranges``) of points a ``shift`` apart."""
    size = np.maximum(ranges, smallest_difference(points))
    return float((np.abs(points[shift:] - points[:-shift]) / size).max())


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


def winding(points: Array) -> float:
    """Return the rotation number of points that follow any closed curve in order, in turns for each point,
    shape (points, coordinates); NaN if they do not, or lie in groups as those of a long period.

    Sorted by the phase n w of point n, points of a curve are neighbours in space. The rotation number w is
    sought near the peaks of the spectrum. A curve may cross itself in the coordinates, and need not go round
    its mean.
    """
    rows = rows_of(points)[-FOLLOWED:]
    count = len(rows)
    rows = rows[:, np.ptp(rows, axis=0) > 0.0]
    if count < 8 or not rows.shape[1]:
        return math.nan
    order, best = np.arange(count), (2.0 * ROUGHEST, math.nan)
    for peak in _frequencies(rows[:, 0]):
        for number in peak + np.arange(-count, count + 1) / (2.0 * count * count):
            phase = np.mod(order * number, 1.0)
            along = np.argsort(phase, kind="stable")
            gaps = np.diff(phase[along], append=phase[along[0]] + 1.0)
            if gaps.max() * count <= LARGEST_GAP and (way := _way(rows[along])) < best[0]:
                best = (way, float(number)) if _roughness(rows[along], gaps) <= SMOOTH else best
    return best[1] if math.isnan(best[1]) else float(np.mod(best[1], 1.0))


def _frequencies(series: Array) -> Array:
    """Return the frequencies (1/point) of the highest peaks of the spectrum of a series."""
    count = len(series)
    grid = np.arange(1, 2 * count) / (4.0 * count)
    sin, cos = sincos(2.0 * math.pi * np.outer(grid, np.arange(count)))
    off = series - series.mean()
    height, width = (off * sin).sum(axis=1), (off * cos).sum(axis=1)
    power = height * height + width * width
    inner = np.flatnonzero((power[1:-1] >= power[:-2]) & (power[1:-1] > power[2:])) + 1
    return np.asarray(grid[inner[np.argsort(-power[inner], kind="stable")][:PEAKS]])


def _way(rows: Array) -> float:
    """Return the largest sum (1), of all coordinates, of the steps along a closed curve, in its range."""
    return float((np.abs(rows - np.roll(rows, 1, axis=0)).sum(axis=0) / np.ptp(rows, axis=0)).max())


def _roughness(rows: Array, gaps: Array) -> float:
    """Return the largest share (1), of all coordinates, of the distances of points from the line between
    their neighbours, in the steps along a closed curve. ``gaps`` of phase follow the points.
    """
    former, following = np.roll(rows, 1, axis=0), np.roll(rows, -1, axis=0)
    part = (np.roll(gaps, 1) / np.maximum(np.roll(gaps, 1) + gaps, 1e-300))[:, None]
    off = np.abs(rows - former - part * (following - former)).sum(axis=0)
    return float((off / np.abs(rows - former).sum(axis=0)).max())


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


def largest_difference(points: Array, shift: int) -> Array:
    """Return the largest difference of points a ``shift`` apart among the last three times as many, shape
    (coordinates,).
    """
    last = points[-3 * shift :]
    return np.asarray(np.abs(last[shift:] - last[:-shift]).max(axis=0))


def zero_one_of_bands(series: Array, grows: bool) -> tuple[float, int]:
    """Return the result of the 0-1 test, and of every how many points it is.

    Chaos in bands, which the motion visits in a fixed order, looks regular in so few points. If a small
    difference ``grows``, it is chaos where every second or fourth point is irregular, from whichever point
    they begin.
    """
    test = zero_one(series)
    for stride in STRIDES if grows else ():
        if test < REGULAR and len(series) >= BAND_POINTS * stride:
            smallest = min(zero_one(series[first::stride]) for first in range(stride))
            if smallest > IRREGULAR:
                return smallest, stride
    return test, 1
