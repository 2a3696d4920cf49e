"""Whether points repeat, and how fast two motions that were alike part: periods, exponents, and the 0-1 test.

All of it takes numbers of any map or section; the oracles of the tests are maps whose answers are known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import sincos

Array = NDArray[np.float64]

ALIKE = 1e-5  # of their size, within which two points are one whatever the range of all is
LONGEST = 16  # points of a period that is looked for
ANGLES = 100  # of the 0-1 test
SHARE = 10  # the 0-1 test looks at displacements over up to a tenth of the series


@dataclass(frozen=True)
class Exponent:
    """Largest Lyapunov exponent: mean logarithm of the growth of a small difference in one turn (1/turn), with ``low`` and ``high`` of its halves.

    ``running``: the mean after each turn, by which its convergence is seen.
    """

    value: float
    low: float
    high: float
    running: Array


def exponent(growth: Sequence[float] | Array) -> Exponent:
    """From the logarithms of the growth of a tangent in each turn, renormalised after it (Benettin et al. 1980)."""
    logs = np.asarray(growth, dtype=float)
    running = np.cumsum(logs) / np.arange(1, len(logs) + 1)
    half = len(logs) // 2
    parts = [float(part.mean()) for part in (logs[:half], logs[half:]) if len(part)]
    return Exponent(float(running[-1]), min(parts), max(parts), running)


def period(points: Array, tolerance: float = 1e-3, longest: int = LONGEST) -> int | None:
    """The least number of points after which they repeat, None where they do not within ``longest``.

    ``points``: shape (points,) or (points, coordinates); two are the same that lie within ``tolerance`` of the range of all of them, or
    :data:`ALIKE` of their size: what comes to rest has no range, and the largest force of a turn is known no better. A period has to be seen
    three times.
    """
    points = np.asarray(points, dtype=float).reshape(len(points), -1)
    size = np.maximum(tolerance * np.ptp(points, axis=0), least(points))
    for one in range(1, min(longest, len(points) // 3) + 1):
        if (between(points, one) <= size).all():
            return one
    return None


def least(points: Array) -> Array:
    """By how much coordinates may differ that are the same, shape (coordinates,)."""
    found: Array = ALIKE * np.abs(points).max(axis=0) + 1e-300
    return found


def between(points: Array, shift: int) -> Array:
    """Largest difference of points so many apart among the last three times as many, shape (coordinates,)."""
    last = points[-3 * shift :]
    found: Array = np.abs(last[shift:] - last[:-shift]).max(axis=0)
    return found


def apart(points: Array, shift: int | None = None, longest: int = LONGEST) -> float:
    """How far points so many apart lie from each other, as a share of the range of all; without ``shift`` the least of all up to ``longest``."""
    points = np.asarray(points, dtype=float).reshape(len(points), -1)
    size = np.maximum(np.ptp(points, axis=0), least(points))
    shifts = range(1, min(longest, len(points) // 3) + 1) if shift is None else (shift,)
    return min((float((between(points, one) / size).max()) for one in shifts), default=float("nan"))


def zero_one(series: Array, seed: int = 0) -> float:
    """The 0-1 test for chaos (Gottwald and Melbourne 2009): near 0 for a regular series, near 1 for a chaotic one; shape (points,).

    Of a hundred angles c the median correlation of the mean square displacement of (sum phi cos jc, sum phi sin jc) with time, phi being the
    series less its mean, which would make that displacement oscillate. The series has to be sampled so seldom that its points look unrelated:
    once a turn, not a hundred times.
    """
    phi = np.asarray(series, dtype=float)
    if np.ptp(phi) <= 1e-9 * np.abs(phi).max(initial=0.0):
        return 0.0
    phi = (phi - phi.mean()) / np.ptp(phi)  # a mean far above what varies would hide it: the oscillating part is its square
    count, most = len(phi), max(2, len(phi) // SHARE)
    j, shifts = np.arange(1, count + 1), np.arange(1, most + 1)
    found = []
    for c in math.pi / 5.0 + 3.0 * math.pi / 5.0 * np.random.default_rng(seed).random(ANGLES):
        s, e = sincos(c * j)
        p, q = np.cumsum(phi * e), np.cumsum(phi * s)
        square = np.array([_ways(p, n, count - most) + _ways(q, n, count - most) for n in range(1, most + 1)])
        found.append(correlation(shifts.astype(float), square))
    return float(np.median(found))


def _ways(series: Array, shift: int, count: int) -> float:
    """Mean square of so many differences of a series over a shift."""
    way = (series[shift:] - series[:-shift])[:count]
    return float((way * way).mean())


def correlation(first: Array, other: Array) -> float:
    """Correlation of two series; 0 where one does not change."""
    a, b = first - first.mean(), other - other.mean()
    size = math.sqrt(float((a * a).sum()) * float((b * b).sum()))
    return float((a * b).sum()) / size if size > 0.0 else 0.0
