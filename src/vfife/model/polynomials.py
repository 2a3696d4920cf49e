"""Piecewise polynomials, the form in which the kernels evaluate functions of time, of a speed or of an angle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
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

    With a ``period`` (s) the function repeats itself; the pieces then cover [0, period).
    """

    starts: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]
    period: float | None = None

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
        """Whether value, slope or curvature jumps from the end of one piece, so long (s), to the begin of another."""
        ends = [_derivatives(self.coefficients[before], length), _derivatives(self.coefficients[after], 0.0)]
        sizes = [max(abs(x) * length**k for end in ends for k, x in enumerate(end)), 1e-300]
        return any(abs(x - y) * length**k > KINK * max(sizes) for k, (x, y) in enumerate(zip(*ends, strict=True)))

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
