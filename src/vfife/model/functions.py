"""Functions of time (or of a speed or an angle) as piecewise polynomials, the form in which the kernels evaluate them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..kernels.polynomial import polynomial
from .drivers import AngleTable, ConstantSpeed, Driver, Harmonic, Ramp, StepTo, Torque
from .mechanism import Mechanism

HARMONIC_PIECES = 128  # a period: of degree 6 through value, rate and second derivative, they are right to 1e-15 of the amplitude
STEEPEST = 1.875  # largest rate of the step 10 s^3 - 15 s^4 + 6 s^5, at its middle


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
        padded = [tuple(c) + (0.0,) * (7 - len(c)) for c in self.coefficients]
        count = len(self.starts)
        head = (count,) if self.period is None else (-count, self.period)
        return np.array([*head, *self.starts, *(value for row in padded for value in row)], dtype=float)

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Value and first two derivatives, as the step evaluates them."""
        value, rate, second = polynomial(self._table, 0, time)
        return float(value), float(rate), float(second)


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


def motion_function(driver: Driver, offset: float = 0.0) -> Polynomials:
    """What a driver prescribes (rad or m), ``offset`` added.

    A ramp's speed is w (10 s^3 - 15 s^4 + 6 s^5), s = t/T, so its angle is w T (5/2 s^4 - 3 s^5 + s^6), then it goes on at w. TypeError for a
    driver that prescribes no motion.
    """
    if isinstance(driver, ConstantSpeed):
        return Polynomials((0.0,), ((offset, driver.speed),))
    if isinstance(driver, Ramp):
        w, t = driver.speed, driver.duration
        rising = (offset, 0.0, 0.0, 0.0, 2.5 * w / t**3, -3.0 * w / t**4, w / t**5)
        return Polynomials((0.0, t), (rising, (offset + 0.5 * w * t, w)))
    if isinstance(driver, StepTo):
        r, t = driver.travel, driver.duration
        step = (offset, 0.0, 0.0, 10.0 * r / t**3, -15.0 * r / t**4, 6.0 * r / t**5)
        return Polynomials((driver.begin - t, driver.begin, driver.begin + t), ((offset,), step, (offset + r,)))
    if isinstance(driver, Harmonic):
        return _harmonic(driver, offset)
    if isinstance(driver, AngleTable):
        return spline(driver.times, driver.values, offset)
    raise TypeError(f"{type(driver).__name__} prescribes no motion")


def _harmonic(driver: Harmonic, offset: float) -> Polynomials:
    """Pieces of degree 6 with the value, rate and second derivative of the sine at both ends, and its value in the middle."""
    h = 2.0 * math.pi / HARMONIC_PIECES
    powers = np.arange(7)
    ends = [(at, order) for at in (0.0, 1.0) for order in (0, 1, 2)] + [(0.5, 0)]
    matrix = np.array([[math.perm(k, order) * at ** (k - order) if k >= order else 0.0 for k in range(7)] for at, order in ends])
    rows, time = [], 1.0 / (driver.frequency * HARMONIC_PIECES)
    for piece in range(HARMONIC_PIECES):
        angles = [piece * h + driver.phase + at * h for at, _ in ends]
        wanted = [h**order * math.sin(angle + 0.5 * math.pi * order) for angle, (_, order) in zip(angles, ends, strict=True)]
        c = driver.amplitude * np.linalg.solve(matrix, wanted)
        c[0] += offset - driver.amplitude * math.sin(driver.phase)
        rows.append(tuple(float(value) for value in c / time**powers))
    return Polynomials(tuple(piece * time for piece in range(HARMONIC_PIECES)), tuple(rows), 1.0 / driver.frequency)


def torque_function(driver: Torque) -> Polynomials:
    """Torque (N m) or force (N): over time (s), speed (rad/s) or angle (rad), whichever the driver has; else constant."""
    if isinstance(driver.value, int | float):
        return constant(float(driver.value))
    if driver.speeds is not None or driver.angles is not None:
        return clamped(driver.speeds or driver.angles or (), driver.value)
    return clamped(driver.times, driver.value) if driver.times is not None else constant(float(driver.value[0]))


def largest_speed(driver: Driver) -> float:
    """Largest speed (rad/s or m/s) that a driver asks for."""
    if isinstance(driver, ConstantSpeed | Ramp):
        return abs(driver.speed)
    if isinstance(driver, StepTo):
        return STEEPEST * abs(driver.travel) / driver.duration
    if isinstance(driver, Harmonic):
        return 2.0 * math.pi * driver.frequency * abs(driver.amplitude)
    if isinstance(driver, AngleTable):
        function = motion_function(driver)
        times = np.linspace(driver.times[0], driver.times[-1], 1000)
        return max(abs(function(time)[1]) for time in times)
    return 0.0


def turning_speed(driver: Driver) -> float:
    """Speed (rad/s) at which a driver turns a body round and round; 0 for those that move it to and fro, or along a line."""
    around = isinstance(driver, ConstantSpeed | Ramp | AngleTable) and not driver.slider and not driver.point
    return largest_speed(driver) if around else 0.0


def turn_of(mechanism: Mechanism) -> float | None:
    """Period (s) of a turn of the fastest driven body, or None."""
    speed = max((turning_speed(driver) for driver in mechanism.drivers.values()), default=0.0)
    return 2.0 * math.pi / speed if speed > 0.0 else None
