"""Functions of time as piecewise polynomials, the form in which the kernels evaluate them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .drivers import AngleTable, ConstantSpeed, Driver, Ramp
from .kernels.drive import polynomial


@dataclass(frozen=True)
class Polynomials:
    """Pieces: start times (s), ascending, and coefficients, seven each, constant first, time counted from the piece's start."""

    starts: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]

    def table(self) -> NDArray[np.float64]:
        """As the kernels read it."""
        padded = [tuple(c) + (0.0,) * (7 - len(c)) for c in self.coefficients]
        return np.array([len(self.starts), *self.starts, *(value for row in padded for value in row)])

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Value and first two derivatives, as the step evaluates them."""
        value, rate, second = polynomial(self.table(), 0, time)
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


def constant(value: float) -> Polynomials:
    """A constant."""
    return Polynomials((0.0,), ((value,),))


def angle_function(driver: Driver, start: float) -> Polynomials:
    """Angle (rad) of a driven body that starts at ``start``.

    A ramp's speed is w (10 s^3 - 15 s^4 + 6 s^5), s = t/T, so its angle is w T (5/2 s^4 - 3 s^5 + s^6), then it goes on at w.
    """
    if isinstance(driver, ConstantSpeed):
        return Polynomials((0.0,), ((start, driver.speed),))
    if isinstance(driver, Ramp):
        w, t = driver.speed, driver.duration
        rising = (start, 0.0, 0.0, 0.0, 2.5 * w / t**3, -3.0 * w / t**4, w / t**5)
        return Polynomials((0.0, t), (rising, (start + 0.5 * w * t, w)))
    if isinstance(driver, AngleTable):
        return spline(driver.times, driver.angles, start)
    raise TypeError(f"{type(driver).__name__} prescribes no angle")


motion_function = angle_function


def largest_speed(driver: Driver) -> float:
    """Largest angular speed (rad/s) that a driver asks for."""
    if isinstance(driver, (ConstantSpeed, Ramp)):
        return abs(driver.speed)
    if isinstance(driver, AngleTable):
        function = angle_function(driver, 0.0)
        times = np.linspace(driver.times[0], driver.times[-1], 1000)
        return max(abs(function(time)[1]) for time in times)
    return 0.0
