"""Piecewise polynomials: the form in which kernels evaluate functions of time, speed, angle or travel."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...kernels.polynomial import polynomial
from ...numerics.dense import solve
from ...numerics.scalar import integer_power, sin
from ...numerics.splines import natural

# Smaller jumps, relative to the value, slope and curvature of a piece, are rounding errors and make no kink.
KINK = 1e-6
# Conditions of a piece of a sine: place in the piece, and order of the derivative that it matches there.
ENDS = (*((at, order) for at in (0.0, 1.0) for order in (0, 1, 2)), (0.5, 0))
# Pieces in a period; with degree 6 they agree with the sine to 1e-15 of its amplitude.
HARMONIC_PIECES = 128


@dataclass(frozen=True)
class Polynomials:
    """A piecewise polynomial: ascending start times (s) and coefficients, up to seven each, constant first,
    in the time since the piece's start.

    With a ``period`` (s) the function is periodic and the pieces cover [0, period). A kink is a jump of the
    value or of a derivative up to ``order``: 2 for motions, because steps must notice jumps of the
    acceleration; 0 for forces, which the trapezoidal rule integrates to second order across jumps of the
    slope. ``breaks``: pieces that always begin with a kink; ``edges``: pieces that may begin with a kink or a
    jump of the slope, by default all.
    """

    starts: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]
    period: float | None = None
    order: int = 2
    breaks: tuple[int, ...] = ()
    edges: tuple[int, ...] | None = None

    def table(self) -> NDArray[np.float64]:
        """Return the function as the kernels read it."""
        return self._table.copy()

    @cached_property
    def _table(self) -> NDArray[np.float64]:
        count, kinks = len(self.starts), np.cumsum(self._kinked)
        head: tuple[float, ...] = (count,)
        if self.period is not None:
            head = (-count, self.period, float(kinks[-1]))
        counts = kinks - kinks[0]  # that of the first piece is the period's
        return np.array([*head, *self.starts, *self._rows.ravel().tolist(), *counts.tolist()], dtype=float)

    @cached_property
    def _numbers(self) -> list[float]:
        """The table as a list, whose entries Python reads faster than those of an array."""
        return list(map(float, self._table))

    @cached_property
    def _rows(self) -> NDArray[np.float64]:
        """Coefficients, shape (pieces, 7)."""
        return np.array([tuple(c) + (0.0,) * (7 - len(c)) for c in self.coefficients], dtype=float)

    @cached_property
    def _lengths(self) -> NDArray[np.float64]:
        """Lengths of the pieces; that of an unlimited last piece is the total length of all others."""
        last = (
            self.period + self.starts[0]
            if self.period is not None
            else 2.0 * self.starts[-1] - self.starts[0]
        )
        return np.diff(np.array([*self.starts, last], dtype=float))

    @cached_property
    def _jumps(self) -> NDArray[np.float64]:
        """Jumps of value, slope and curvature at the beginning of each piece, shape (pieces, 3); negligible
        ones are 0.

        The first row is the jump between two periods; without a period it is 0.
        """
        with np.errstate(all="ignore"):
            return self._jumped(np.roll(self._lengths, 1), np.roll(self._rows, 1, axis=0))

    def _jumped(self, lengths: NDArray[np.float64], ends: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the jumps from the ends of the previous pieces, given by their ``lengths`` and coefficients
        ``ends``.
        """
        value, rate, half = (np.zeros(len(self.starts)) for _ in range(3))
        for k in range(6, -1, -1):
            half, rate, value = half * lengths + rate, rate * lengths + value, value * lengths + ends[:, k]
        old, new = np.stack([value, rate, 2.0 * half], axis=1), self._rows[:, :3] * (1.0, 1.0, 2.0)
        scales = np.stack([np.ones_like(lengths), lengths, lengths * lengths], axis=1)
        sizes = np.maximum(np.abs(old) * scales, np.abs(new) * scales).max(axis=1)
        sizes = np.maximum(
            sizes, 1e-300 if self.order else max(1e-300, float(np.abs(self._rows[:, 0]).max()))
        )
        jumps: NDArray[np.float64] = np.abs(old - new)
        jumps[jumps * scales <= KINK * sizes[:, None]] = 0.0
        if self.period is None:
            jumps[0] = 0.0
        if self.edges is not None:
            jumps[np.setdiff1d(np.arange(len(self.starts)), self.edges)] = 0.0
        return jumps

    @cached_property
    def _kinked(self) -> NDArray[np.bool_]:
        """Whether each piece begins with a kink or a break."""
        kinked: NDArray[np.bool_] = np.asarray((self._jumps[:, : self.order + 1] > 0.0).any(axis=1))
        kinked[list(self.breaks)] = True
        return kinked

    @cached_property
    def bends(self) -> tuple[tuple[float, float], ...]:
        """Places where the slope jumps without a kink, each with the jump over the mean length of the two
        pieces: an equivalent second derivative for the error of sums.
        """
        if self.order > 0:
            return ()
        value, slope, _ = self._jumps.T
        mean = 0.5 * (self._lengths + np.roll(self._lengths, 1))
        return tuple(
            (self.starts[k], float(slope[k] / mean[k]))
            for k in np.flatnonzero((slope > 0.0) & (value == 0.0)).tolist()
        )

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """Beginnings of the pieces with a kink, of the first period only."""
        counts = self._table[-len(self.starts) :]
        inside = [
            start
            for start, previous, count in zip(self.starts[1:], counts[:-1], counts[1:], strict=True)
            if count > previous
        ]
        periodic_kink = self.period is not None and self._table[2] > counts[-1]
        return (self.starts[0], *inside) if periodic_kink else tuple(inside)

    def sampled(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the value and two derivatives at many times, shape (times, 3)."""
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
        """Return the value and two derivatives, as a step evaluates them."""
        value, rate, second, _ = polynomial(self._numbers, 0, time)
        return float(value), float(rate), float(second)


def moved(function: Polynomials, by: float) -> Polynomials:
    """Return f(x - ``by``). The pieces of a periodic function still begin in [0, period)."""
    if function.period is None:
        return replace(function, starts=tuple(start + by for start in function.starts))
    period, count = function.period, len(function.starts)
    turned = [(start + by) - math.floor((start + by) / period) * period for start in function.starts]
    turned = [0.0 if start >= period else start for start in turned]
    first = min(range(count), key=turned.__getitem__)
    order = [(first + k) % count for k in range(count)]
    starts, rows = [turned[k] for k in order], [function.coefficients[k] for k in order]
    edges = [(k - first) % count for k in (range(count) if function.edges is None else function.edges)]
    if starts[0] > 0.0:  # the last piece goes on into the next period, whose begin is the table's
        rows.insert(0, recentred(rows[-1], period - starts[-1]))
        starts.insert(0, 0.0)
        edges = [k + 1 for k in edges]
    return replace(function, starts=tuple(starts), coefficients=tuple(rows), edges=tuple(sorted(edges)))


def raised(function: Polynomials, by: float) -> Polynomials:
    """Return the function plus a constant."""
    return replace(function, coefficients=tuple((row[0] + by, *row[1:]) for row in function.coefficients))


def recentred(coefficients: tuple[float, ...], at: float) -> tuple[float, ...]:
    """Return the coefficients of the polynomial in x + ``at``, for x."""
    rows = list(coefficients)
    for k in range(len(rows) - 1):
        for m in range(len(rows) - 2, k - 1, -1):
            rows[m] += at * rows[m + 1]
    return tuple(rows)


def spline(times: tuple[float, ...], values: tuple[float, ...], offset: float = 0.0) -> Polynomials:
    """Return the natural cubic spline through the points; a straight line through two. Needs
    ascending times.
    """
    if len(times) == 2:
        slope = (values[1] - values[0]) / (times[1] - times[0])
        return Polynomials((times[0],), ((values[0] + offset, slope),))
    rows = natural(times, values)
    return Polynomials(tuple(map(float, times[:-1])), tuple((row[0] + offset, *row[1:]) for row in rows))


def constant(value: float) -> Polynomials:
    """Return a constant function."""
    return Polynomials((0.0,), ((value,),))


def sine(amplitude: float, frequency: float, phase: float, offset: float = 0.0) -> Polynomials:
    """Return offset + amplitude [sin(2 pi frequency t + phase) - sin(phase)].

    Its pieces of degree 6 match the value and two derivatives of the sine at both ends, and its value in the
    middle.
    """
    # Scalars of one mechanism; a batch of mechanisms calls this function for each.
    amplitude, frequency, phase, offset = map(float, (amplitude, frequency, phase, offset))
    h, time = 2.0 * math.pi / HARMONIC_PIECES, 1.0 / (frequency * HARMONIC_PIECES)
    quarters = [0.5 * math.pi * order for _, order in ENDS]
    matrix = np.array(
        [
            [math.perm(k, order) * integer_power(at, k - order) if k >= order else 0.0 for k in range(7)]
            for at, order in ENDS
        ]
    )
    shares = [at * h for at, _ in ENDS]
    scales = [integer_power(h, order) for _, order in ENDS]
    conditions = []
    for piece in range(HARMONIC_PIECES):
        begin = piece * h + phase
        conditions.append(
            [
                scale * sin(begin + share + quarter)
                for scale, share, quarter in zip(scales, shares, quarters, strict=True)
            ]
        )
    c = amplitude * solve(matrix, np.array(conditions).T).T
    c[:, 0] += offset - amplitude * sin(phase)
    rows = tuple(map(tuple, (c / [integer_power(time, k) for k in range(7)]).tolist()))
    return Polynomials(tuple(piece * time for piece in range(HARMONIC_PIECES)), rows, 1.0 / frequency)
