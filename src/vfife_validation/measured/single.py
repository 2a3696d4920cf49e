"""The measured single pendulum: one parameter set for four records, and records that no fit has seen."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from vfife.results.fit import Fit

from . import independent
from .mechanisms import ARM, CURVE, DRY, MASS, G, single
from .records import names, record
from .swings import angles_of, fitted, misses, starts, swings, with_numbers

BODIES = ("rod",)
THIN = 20  # samples of 1 ms of which one counts
FIRST = 0.5  # s, from which the start of a record is known that is to be predicted
VISCOUS_AND_DRY: dict[str, Any] = {
    "body.rod.inertia": (5e-5, 2e-4), "spring.bearing.damping": (0.0, 6e-4), DRY: (0.0, 5e-4)
}  # fmt: skip
OVER_SPEED: dict[str, Any] = {
    "body.rod.inertia": (5e-5, 2e-4), CURVE[0]: (0.0, 2e-3), CURVE[1]: (0.0, 5e-3), CURVE[2]: (0.0, 1e-2)
}  # fmt: skip
FRICTIONS = {"viscous and dry": VISCOUS_AND_DRY, "curve": OVER_SPEED}


def identify(friction: str, chosen: tuple[str, ...] = ()) -> Fit:
    """One set of numbers for the records ``which``, all if none is named."""
    data = [record(name, BODIES) for name in chosen or names("single")]
    return fitted(single(friction), data, FRICTIONS[friction], every=THIN)


def fit_each(friction: str = "viscous and dry") -> Fit:
    """Numbers of each record by itself."""
    data = [record(name, BODIES) for name in names("single")]
    return fitted(single(friction), data, {}, own=FRICTIONS[friction], every=THIN)


def frequency(inertia: float, error: float) -> tuple[float, float]:
    """Square of the circular frequency of small swings (1/s2), and its standard error."""
    about_pivot = inertia + MASS * ARM * ARM
    square = MASS * G * ARM / about_pivot
    return square, square * error / about_pivot


class Prediction(NamedTuple):
    """How far a record is missed: its name, the records that the numbers are from, and root mean squares over
    its standard deviation (1).
    """

    name: str
    others: tuple[str, ...]
    ours: float


def predicted(friction: str) -> list[Prediction]:
    """Each pair of records by the numbers of the other two, from their first half second on."""
    result = []
    for pair in combinations(names("single"), 2):
        rest_of_names = tuple(name for name in names("single") if name not in pair)
        result += pair_by(friction, pair, rest_of_names)
    return result


def pair_by(friction: str, pair: tuple[str, ...], rest_of_names: tuple[str, ...]) -> list[Prediction]:
    """Predict records from their first half second, with parameters identified from ``others``."""
    model = with_numbers(single(friction), identify(friction, rest_of_names))
    begins = starts(model, [record(name, BODIES, FIRST) for name in pair])
    records = [record(name, BODIES, every=THIN) for name in pair]
    return [
        Prediction(name, rest_of_names, misses(angles, angles_of(data)))
        for name, data, angles in zip(pair, records, swings(model, records, begins), strict=True)
    ]


def authors() -> list[float]:
    """Misses of the authors' numbers from the first sample on: angle and speed of a parabola there."""
    records = [record(name, BODIES, every=THIN) for name in names("single")]
    begins = []
    for name in names("single"):
        data = record(name, BODIES, 0.02)
        rate = float(np.polyfit(data.places, data.curves[0].values, 2)[1])
        begins.append(
            {"start.rod.angle": float(data.curves[0].values[0]), "start.rod.angular_velocity": rate}
        )
    return [
        misses(angles, angles_of(data))
        for data, angles in zip(records, swings(single(), records, begins), strict=True)
    ]


def difference(fit: Fit) -> float:
    """Largest difference (rad) of our swings from the equation of motion, integrated by SciPy."""
    inertia, damping, dry = (value.value for value in fit.values)
    numbers = {"inertia": inertia, "mass": MASS, "arm": ARM, "damping": damping, "dry": dry}
    records = [record(name, BODIES, every=THIN) for name in names("single")]
    begins = [dict(record.set) for record in fit.records]
    ours = swings(with_numbers(single(), fit), records, begins)
    return max(
        float(np.abs(angles - independent.single(numbers, list(start.values()), data.places)).max())
        for data, angles, start in zip(records, ours, begins, strict=True)
    )


def per_inertia(value: float, error: float, inertia: float) -> tuple[float, float]:
    """Divide a friction and its error by the moment of inertia about the pivot."""
    about_pivot = inertia + MASS * ARM * ARM
    return value / about_pivot, error / about_pivot if math.isfinite(error) else math.inf
