"""Whether a motion repeats, and how fast two that were alike part: periods of points, exponents, and the 0-1 test.

All of it takes numbers of any map or section; the oracles of the tests are maps whose answers are known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

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

    ``points``: shape (points,) or (points, coordinates); two are the same that lie within ``tolerance`` of the range of all of them, or of 1e-9 of
    their size. A period has to be seen three times.
    """
    points = np.asarray(points, dtype=float).reshape(len(points), -1)
    size = np.maximum(np.ptp(points, axis=0), 0.0)
    least = 1e-9 * np.abs(points).max(axis=0) + 1e-300
    for one in range(1, min(longest, len(points) // 3) + 1):
        last = points[-3 * one :]
        apart = np.abs(last[one:] - last[:-one]).max(axis=0)
        if (apart <= np.maximum(tolerance * size, least)).all():
            return one
    return None


def zero_one(series: Array, seed: int = 0) -> float:
    """The 0-1 test for chaos (Gottwald and Melbourne 2009): near 0 for a regular series, near 1 for a chaotic one; shape (points,).

    Of a hundred angles c the median correlation of the mean square displacement of (sum phi cos jc, sum phi sin jc), its oscillating part taken
    off, with time. The series has to be sampled so seldom that its points look unrelated: once a turn, not a hundred times.
    """
    phi = np.asarray(series, dtype=float)
    if np.ptp(phi) <= 1e-9 * np.abs(phi).max(initial=0.0):
        return 0.0
    phi = phi / np.ptp(phi)
    count, most = len(phi), max(2, len(phi) // SHARE)
    j, shifts = np.arange(1, count + 1), np.arange(1, most + 1)
    found = []
    for c in np.random.default_rng(seed).uniform(math.pi / 5.0, 4.0 * math.pi / 5.0, ANGLES):
        p, q = np.cumsum(phi * np.cos(c * j)), np.cumsum(phi * np.sin(c * j))
        square = np.array([np.mean((p[n:] - p[:-n])[: count - most] ** 2 + (q[n:] - q[:-n])[: count - most] ** 2) for n in shifts])
        square -= phi.mean() ** 2 * (1.0 - np.cos(shifts * c)) / (1.0 - math.cos(c))
        found.append(np.corrcoef(shifts, square)[0, 1])
    return float(np.median(found))


def kind(points: Array, found: Exponent | None, tolerance: float = 1e-3) -> str:
    """A motion in words with its evidence: "period 2", "chaotic" where all of a positive exponent says so, else "not periodic"."""
    repeats = period(points, tolerance)
    if repeats is not None:
        return f"period {repeats}"
    return "chaotic" if found is not None and found.low > 0.0 else "not periodic"
