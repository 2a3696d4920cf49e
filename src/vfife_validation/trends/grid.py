"""Measures over clearance and speed, each from several start angles of the crank."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

import vfife
from vfife import Mechanism

Array = NDArray[np.float64]
Axis = Literal["clearance", "speed"]
PHASES = 10
# The second and the ninth of ten values enclose the median of their distribution in 97.9 % of samples.
INNER = slice(1, PHASES - 1)
TURNS, LAST = 6, 3  # turns of a run, and the last of them, over which measures are averaged


@dataclass(frozen=True)
class Grid:
    """Measures by name, shape (phases, clearances, speeds) each, over clearances (m) and speeds (rad/s), and
    their numerical errors: the median and the largest of the cases that were repeated with a larger step.
    """

    clearances: Sequence[float]
    speeds: Sequence[float]
    values: Mapping[str, Array]
    step_errors: Mapping[str, tuple[float, float]]

    def median(self, name: str) -> Array:
        """Median over the phases, shape (clearances, speeds)."""
        return np.asarray(np.median(self.values[name], axis=0), dtype=np.float64)

    def band(self, name: str) -> tuple[Array, Array]:
        """10 and 90 % of the phases, shape (clearances, speeds) each."""
        low, high = np.quantile(self.values[name], (0.1, 0.9), axis=0)
        return low, high

    def scatter(self, name: str) -> Array:
        """Width of the band over the median, shape (clearances, speeds)."""
        low, high = self.band(name)
        return np.asarray((high - low) / self.median(name), dtype=np.float64)

    def interval(self, name: str) -> tuple[Array, Array]:
        """Limits of 97.9 % of the median, from order statistics, shape (clearances, speeds) each."""
        inner = np.sort(self.values[name], axis=0)[INNER]
        return inner[0], inner[-1]


def grid(
    mechanism: Mechanism, joints: str | Sequence[str], clearances: Sequence[float], speeds: Sequence[float],
    measures: Sequence[str], phases: int = PHASES, turns: int = TURNS, last: int = LAST,
) -> Grid:  # fmt: skip
    """Run a mechanism for all clearances (m) of its ``joints``, which are equal, and all speeds (rad/s) of
    its crank, from ``phases`` start angles each. Raises ValueError if a case fails.
    """
    angles = [2.0 * math.pi * k / phases for k in range(phases)]
    vary = {
        "phase": {"path": "body.crank.angle", "values": angles},
        "clearance": {"path": [f"joint.{name}.clearance" for name in joints], "values": list(clearances)},
        "speed": {"path": "driver.crank.speed", "values": list(speeds)},
    }
    study = vfife.study(mechanism, vary, list(measures), turns=turns, last=last)
    data = study.data
    failed = int((data["status"] != "complete").sum())
    if failed:
        raise ValueError(f"{failed} of {data['status'].size} cases of {mechanism.name} failed")
    values = {name: data[name].transpose("phase", "clearance", "speed").values for name in measures}
    errors = {name: (study.errors[name].typical, study.errors[name].most) for name in measures}
    return Grid(clearances, speeds, values, errors)


@dataclass(frozen=True)
class Steps:
    """How a median changes from each value of an axis to the next: how often it surely rises, surely falls,
    and how often the intervals of both medians overlap; and the factor from the first to the last value,
    least and largest over the other axis.
    """

    rises: int
    falls: int
    undecided: int
    factors: tuple[float, float]

    @property
    def holds(self) -> bool | None:
        """Whether the median grows: false if it falls anywhere, open if most steps are undecided."""
        if self.falls:
            return False
        return True if self.rises > self.undecided else None

    @property
    def text(self) -> str:
        """In words."""
        low, high = self.factors
        return (
            f"rises in {self.rises} steps, falls in {self.falls}, undecided in {self.undecided}; from first"
            f" to last by a factor of {low:.3g} to {high:.3g}"
        )


def steps(grid: Grid, name: str, axis: Axis) -> Steps:
    """Count the increases and decreases of a measure along an axis."""
    dimension = 0 if axis == "clearance" else 1
    low, high = (np.moveaxis(limit, dimension, 0) for limit in grid.interval(name))
    median = np.moveaxis(grid.median(name), dimension, 0)
    rises, falls = int((low[1:] > high[:-1]).sum()), int((high[1:] < low[:-1]).sum())
    factors = median[-1] / median[0]
    return Steps(rises, falls, low[1:].size - rises - falls, (float(factors.min()), float(factors.max())))
