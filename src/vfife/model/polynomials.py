"""Piecewise polynomials, the form in which the kernels evaluate functions of time, of a speed or of an angle."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

from ..kernels.polynomial import polynomial

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

KINK = 1e-6  # jump, over the size of a piece's value, slope and curvature, from which two pieces meet in a kink
HARMONIC_PIECES = 128  # a period: of degree 6 through value, rate and second derivative, they are right to 1e-15 of the amplitude


@dataclass(frozen=True)
class Polynomials:
    """Pieces: start times (s), ascending, and coefficients, seven each, constant first, time counted from the piece's start.

    With a ``period`` (s) the function repeats itself; the pieces then cover [0, period). A kink is where the value jumps, or one of its
    derivatives up to ``order``: 2 for motions, whose acceleration must not jump unseen; 0 for forces, of which steps take the sum as the
    trapezoidal rule does, to second order over bends too. ``breaks``: pieces that begin with a kink whatever they are; ``edges``: those that may
    begin with a kink or a bend, all unless said.
    """

    starts: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]
    period: float | None = None
    order: int = 2
    breaks: tuple[int, ...] = ()
    edges: tuple[int, ...] | None = None

    def table(self) -> NDArray[np.float64]:
        """As the kernels read it."""
        return self._table.copy()

    @cached_property
    def _table(self) -> NDArray[np.float64]:
        import numpy as np

        padded = [tuple(c) + (0.0,) * (7 - len(c)) for c in self.coefficients]
        count = len(self.starts)
        kinks = [0]
        for k in range(1, count):
            kinks.append(kinks[-1] + self._kink(k - 1, k, self.starts[k] - self.starts[k - 1]))
        if self.period is None:
            head: tuple[float, ...] = (count,)
        else:
            head = (-count, self.period, kinks[-1] + self._kink(count - 1, 0, self.period - self.starts[-1] + self.starts[0]))
        return np.array([*head, *self.starts, *(value for row in padded for value in row), *kinks], dtype=float)

    def _kink(self, before: int, after: int, length: float) -> bool:
        """Whether value, slope or curvature, up to the ``order``, jumps from the end of one piece, so long (s), to the begin of another."""
        known = self.edges is None or after in self.edges
        return after in self.breaks or (known and any(self._jumps(before, after, length)[: self.order + 1]))

    def _jumps(self, before: int, after: int, length: float) -> list[float]:
        """By how much value, slope and curvature jump there; 0 for what is next to nothing."""
        ends = [_derivatives(self.coefficients[before], length), _derivatives(self.coefficients[after], 0.0)]
        size = max(abs(x) * length**k for end in ends for k, x in enumerate(end))
        least = KINK * max(size, 1e-300, 0.0 if self.order else self._largest)
        return [abs(x - y) if abs(x - y) * length**k > least else 0.0 for k, (x, y) in enumerate(zip(*ends, strict=True))]

    @cached_property
    def _largest(self) -> float:
        """Largest absolute value at the begins of pieces."""
        return max(abs(row[0]) for row in self.coefficients)

    @cached_property
    def bends(self) -> tuple[tuple[float, float], ...]:
        """Where the slope jumps without a kink, with the jump over the mean length of the two pieces: a second derivative for their sum."""
        count, span = len(self.starts), (self.period or self.starts[-1] - self.starts[0])
        lengths = [late - early for early, late in pairwise(self.starts)]
        lengths.append(span - self.starts[-1] + self.starts[0] if self.period else span)
        found = []
        for k in range(0 if self.period else 1, count) if self.edges is None else self.edges:
            value, slope, _ = self._jumps(k - 1, k, lengths[k - 1])
            if slope and not value and self.order < 1:
                found.append((self.starts[k], 2.0 * slope / (lengths[k - 1] + lengths[k])))
        return tuple(found)

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """Begins of the pieces that meet the one before in a kink, those of the first period only."""
        counts = self._table[-len(self.starts) :]
        inside = [start for start, before, after in zip(self.starts[1:], counts[:-1], counts[1:], strict=True) if after > before]
        again = self.period is not None and self._table[2] > counts[-1]
        return (self.starts[0], *inside) if again else tuple(inside)

    def sampled(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Value and first two derivatives at many times, shape (times, 3)."""
        import numpy as np

        if self.period is not None:
            times = times - np.floor(times / self.period) * self.period
        count = len(self.starts)
        starts, c = self._table[-9 * count : -8 * count], self._table[-8 * count : -count].reshape(count, 7)
        piece = np.maximum(np.searchsorted(starts, times, side="right") - 1, 0)
        x = times - starts[piece]
        value, rate, half = (np.zeros(len(times)) for _ in range(3))
        for k in range(6, -1, -1):
            half, rate, value = half * x + rate, rate * x + value, value * x + c[piece, k]
        return np.stack([value, rate, 2.0 * half], axis=1)

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Value and first two derivatives, as the step evaluates them."""
        value, rate, second, _ = polynomial(self._table, 0, time)
        return float(value), float(rate), float(second)


def _derivatives(coefficients: tuple[float, ...], x: float) -> tuple[float, float, float]:
    """Value and first two derivatives of a polynomial, constant first."""
    value = rate = half = 0.0
    for c in reversed(coefficients):
        half, rate, value = half * x + rate, rate * x + value, value * x + c
    return value, rate, 2.0 * half


def moved(function: Polynomials, by: float) -> Polynomials:
    """The function with its argument counted from ``by``: f(x - by). Pieces of one that repeats itself still begin in [0, period)."""
    if function.period is None:
        return replace(function, starts=tuple(start + by for start in function.starts))
    period, count = function.period, len(function.starts)
    turned = [(start + by) - math.floor((start + by) / period) * period for start in function.starts]
    turned = [0.0 if start >= period else start for start in turned]
    first = min(range(count), key=turned.__getitem__)
    order = [(first + k) % count for k in range(count)]
    starts, rows = [turned[k] for k in order], [function.coefficients[k] for k in order]
    edges = [order.index(k) for k in (range(count) if function.edges is None else function.edges)]
    if starts[0] > 0.0:  # the last piece goes on into the next period, whose begin is the table's
        rows.insert(0, recentred(rows[-1], period - starts[-1]))
        starts.insert(0, 0.0)
        edges = [k + 1 for k in edges]
    return replace(function, starts=tuple(starts), coefficients=tuple(rows), edges=tuple(sorted(edges)))


def raised(function: Polynomials, by: float) -> Polynomials:
    """The function with a constant added."""
    return replace(function, coefficients=tuple((row[0] + by, *row[1:]) for row in function.coefficients))


def recentred(coefficients: tuple[float, ...], at: float) -> tuple[float, ...]:
    """The polynomial in x + at, for x."""
    rows = list(coefficients)
    for k in range(len(rows) - 1):
        for m in range(len(rows) - 2, k - 1, -1):
            rows[m] += at * rows[m + 1]
    return tuple(rows)


def spline(times: tuple[float, ...], values: tuple[float, ...], offset: float = 0.0) -> Polynomials:
    """Natural cubic spline through the points; a straight line through two. Needs ascending times."""
    if len(times) == 2:
        slope = (values[1] - values[0]) / (times[1] - times[0])
        return Polynomials((times[0],), ((values[0] + offset, slope),))
    from scipy.interpolate import CubicSpline

    fit = CubicSpline(times, values, bc_type="natural")
    rows = [tuple(float(c) for c in fit.c[::-1, k]) for k in range(len(times) - 1)]
    return Polynomials(tuple(map(float, times[:-1])), tuple((row[0] + offset, *row[1:]) for row in rows))


def clamped(places: tuple[float, ...], values: tuple[float, ...]) -> Polynomials:
    """The spline through the points, which keeps its end values beyond its ends."""
    inside = spline(places, values)
    starts = (float(places[0]) - 1.0, *inside.starts, float(places[-1]))
    return Polynomials(starts, ((float(values[0]),), *inside.coefficients, (float(values[-1]),)))


def constant(value: float) -> Polynomials:
    """A constant."""
    return Polynomials((0.0,), ((value,),))


def sine(amplitude: float, frequency: float, phase: float, offset: float = 0.0) -> Polynomials:
    """offset + amplitude [sin(2 pi frequency t + phase) - sin(phase)].

    Pieces of degree 6 with the value, rate and second derivative of the sine at both ends, and its value in the middle.
    """
    import numpy as np

    h = 2.0 * math.pi / HARMONIC_PIECES
    powers = np.arange(7)
    ends = [(at, order) for at in (0.0, 1.0) for order in (0, 1, 2)] + [(0.5, 0)]
    matrix = np.array([[math.perm(k, order) * at ** (k - order) if k >= order else 0.0 for k in range(7)] for at, order in ends])
    rows, time = [], 1.0 / (frequency * HARMONIC_PIECES)
    for piece in range(HARMONIC_PIECES):
        angles = [piece * h + phase + at * h for at, _ in ends]
        wanted = [h**order * math.sin(angle + 0.5 * math.pi * order) for angle, (_, order) in zip(angles, ends, strict=True)]
        c = amplitude * np.linalg.solve(matrix, wanted)
        c[0] += offset - amplitude * math.sin(phase)
        rows.append(tuple(float(value) for value in c / time**powers))
    return Polynomials(tuple(piece * time for piece in range(HARMONIC_PIECES)), tuple(rows), 1.0 / frequency)
