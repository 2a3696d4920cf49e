"""The measured double pendulum: one parameter set for 26 records, and how far it foretells them.

Chaotic swings have many wrong minima of their squares. So only the first 0.8 s of all records are fitted,
over which none of them has lost its start yet; the rest is foretold.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vfife import Mechanism
from vfife.results.fit import Fit

from .mechanisms import double
from .records import names, record
from .swings import angles_of, fitted, misses, starts, swings, with_numbers

Array = NDArray[np.float64]
BODIES = ("upper", "lower")
THIN = 20  # samples of 1 ms of which one counts
FIRST, EARLY = 0.25, 0.8  # s, from which a start is known; of the first fit
SPANS = (1.0, 2.666)  # s, over which predictions are judged
CHAOTIC = 4.0  # times that two neighbours part within a record that is called chaotic
NEIGHBOUR_ANGLE = 1e-6  # rad, by which they lie neighbours at first
LIMIT = 0.1  # rad, by which a prediction is off where it ends
PARAMETERS: dict[str, Any] = {
    "body.upper.center.1": (0.09, 0.13), "body.upper.inertia": (2e-4, 8e-4),
    "body.lower.inertia": (1e-3, 1.6e-3), "spring.O.damping": (0.0, 6e-4),
    "driver.upper.torque.0,-driver.upper.torque.1": (0.0, 1e-3),
    "driver.lower.torque.0,-driver.lower.torque.1": (0.0, 5e-4),
}  # fmt: skip


def identify(chosen: Sequence[str] = (), end: float = EARLY) -> Fit:
    """One set of numbers for the records ``which``, all if none is named, from their first piece."""
    data = [record(name, BODIES, end) for name in chosen or names("double")]
    return fitted(double(0.0), data, PARAMETERS, every=THIN // 2)


class Swing(NamedTuple):
    """What is foretold of a record: misses over its deviation within each of ``SPANS``, by our numbers and by
    the authors', times (s) at which either is off by more than ``LIMIT``, and how neighbours part.
    """

    name: str
    ours: tuple[float, ...]
    authors: tuple[float, ...]
    horizon: float
    horizon_of_authors: float
    growth: float

    @property
    def chaotic(self) -> bool:
        """Whether neighbours part so fast that it is called chaotic."""
        return self.growth > CHAOTIC

    @property
    def lyapunov_time(self) -> float:
        """Time (s) within which neighbours part e times as far, over the record."""
        return SPANS[-1] / math.log(self.growth) if self.growth > 1.0 else math.inf


def foretold(fit: Fit, chosen: Sequence[str] = ()) -> list[Swing]:
    """Predict records whose start is identified from their first quarter of a second."""
    chosen = list(chosen or names("double"))
    data_of_all = [record(name, BODIES, every=THIN // 4) for name in chosen]
    model = with_numbers(double(0.0), fit)
    ours, begins = courses(model, chosen)
    authors, _ = courses(double(), chosen)
    neighbours = swings(model, data_of_all, [moved(start) for start in begins])
    result = []
    for k, data in enumerate(data_of_all):
        measured, times = angles_of(data), data.places
        parts = [slice(0, int(np.searchsorted(times, end, "right"))) for end in SPANS]
        distance = np.abs(neighbours[k] - ours[k]).max(axis=1)
        result.append(
            Swing(
                data.name, tuple(misses(ours[k], measured, part) for part in parts),
                tuple(misses(authors[k], measured, part) for part in parts),
                horizon(ours[k], measured, times), horizon(authors[k], measured, times),
                float(distance.max() / NEIGHBOUR_ANGLE),
            )
        )  # fmt: skip
    return result


def foretold_by_halves() -> list[Swing]:
    """Every record by the numbers of 13 others: every second one is fitted, and foretells those between."""
    records = names("double")
    halves = (records[0::2], records[1::2])
    swings = [
        swing
        for fitted_half, predicted_half in (halves, halves[::-1])
        for swing in foretold(identify(fitted_half), predicted_half)
    ]
    return sorted(swings, key=lambda swing: swing.name)


def courses(model: Mechanism, chosen: Sequence[str]) -> tuple[list[Array], list[dict[str, float]]]:
    """Angles of a model in each record, and the starts, which are found in the first pieces alone."""
    begins = starts(model, [record(name, BODIES, FIRST) for name in chosen])
    return swings(model, [record(name, BODIES, every=THIN // 4) for name in chosen], begins), begins


def moved(start: Mapping[str, float]) -> dict[str, float]:
    """Return a start with a slightly larger upper angle."""
    return {**start, "start.upper.angle": start["start.upper.angle"] + NEIGHBOUR_ANGLE}


def horizon(model: Array, measured: Array, times: Array) -> float:
    """Time (s) at which an angle is off by ``LIMIT`` for the first time; infinite where none ever is."""
    off = np.flatnonzero(np.abs(model - measured).max(axis=1) > LIMIT)
    return float(times[off[0]]) if len(off) else math.inf
