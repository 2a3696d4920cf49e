"""The same pendulums as equations of motion, integrated by SciPy: what is found has to be theirs, too."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .mechanisms import LENGTH, LOWER_MASS, REST_SPEED, UPPER_MASS, G

Array = NDArray[np.float64]


def solved(rates: Any, start: list[float], times: Array) -> Array:
    """Angles (rad), shape (times, bodies): order 8, relative tolerance 1e-10."""
    from scipy.integrate import solve_ivp

    run = solve_ivp(
        rates, (0.0, float(times[-1])), start, "DOP853", t_eval=times, rtol=1e-10, atol=1e-12, max_step=0.01
    )
    return np.asarray(run.y[: len(start) // 2].T, dtype=float)


def dry(moment: float, rate: float) -> float:
    """Dry friction (N m), which grows with the rate (rad/s) below ``REST_SPEED``."""
    return moment * min(max(rate / REST_SPEED, -1.0), 1.0)


def single(numbers: dict[str, float], start: list[float], times: Array) -> Array:
    """Integrate the single pendulum, J a'' = m g r sin a - c a' - M sign a', from an angle (rad) and a rate
    (rad/s).
    """
    inertia = numbers["inertia"] + numbers["mass"] * numbers["arm"] ** 2
    weight = numbers["mass"] * G * numbers["arm"]

    def rates(_: float, y: Array) -> list[float]:
        moment = weight * math.sin(y[0]) - numbers["damping"] * y[1] - dry(numbers["dry"], y[1])
        return [y[1], moment / inertia]

    return solved(rates, start, times)


def double(numbers: dict[str, float], start: list[float], times: Array) -> Array:
    """Integrate the double pendulum by Lagrange's equations, from two angles (rad) and two rates (rad/s);
    friction of the elbow depends on the difference of the rates.
    """
    r1, r2, m1, m2, long = numbers["upper arm"], numbers["lower arm"], UPPER_MASS, LOWER_MASS, LENGTH
    first = numbers["upper inertia"] + m1 * r1 * r1 + m2 * long * long
    second, mixed = numbers["lower inertia"] + m2 * r2 * r2, m2 * long * r2

    def rates(_: float, y: Array) -> list[float]:
        a, b, u, v = y
        c, s = math.cos(a - b), math.sin(a - b)
        elbow = numbers["elbow damping"] * (v - u) + dry(numbers["elbow dry"], v - u)
        pivot = numbers["pivot damping"] * u + dry(numbers["pivot dry"], u)
        p = (m1 * r1 + m2 * long) * G * math.sin(a) - mixed * s * v * v - pivot + elbow
        q = m2 * r2 * G * math.sin(b) + mixed * s * u * u - elbow
        determinant = first * second - mixed * mixed * c * c
        return [u, v, (second * p - mixed * c * q) / determinant, (first * q - mixed * c * p) / determinant]

    return solved(rates, start, times)
