"""Runs of a model from many crank angles: a single run of a motion with impacts tells little."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import vfife
from vfife import Mechanism
from vfife.results.study import Study

Array = NDArray[np.float64]
COUNT = 16  # crank angles at the start
RPM = math.pi / 30.0  # rad/s
# Two-sided quantiles of Student's t for 95 %, by number of values.
STUDENT = {4: 3.182, 8: 2.365, 16: 2.131}


@dataclass(frozen=True)
class Scatter:
    """A measure over the crank angles of one set of numbers, shape (phases,)."""

    values: Array

    @property
    def mean(self) -> float:
        """Mean over the crank angles."""
        return float(self.values.mean())

    @property
    def error(self) -> float:
        """Half width of the confidence interval of 95 % of the mean, of the scatter over crank angles."""
        return STUDENT[len(self.values)] * float(self.values.std(ddof=1)) / math.sqrt(len(self.values))

    def text(self, unit: str, scale: float = 1.0, digits: int = 3) -> str:
        """Return the mean, its confidence and the range of single runs."""
        low, high = scale * self.values.min(), scale * self.values.max()
        return (
            f"{scale * self.mean:.{digits}g} ± {scale * self.error:.2g} {unit}"
            f" ({low:.{digits}g} to {high:.{digits}g})"
        )

    def relative_to(self, reference: float) -> Scatter:
        """Return the values over a reference."""
        return Scatter(self.values / reference)


@dataclass(frozen=True)
class Scatters:
    """Measures of several sets of numbers over crank angles, and the study that computed them."""

    study: Study
    sets: int

    def of(self, measure: str, k: int = 0) -> Scatter:
        """Return a measure of the set ``k``."""
        return Scatter(self.study.values(measure).reshape(self.sets, -1)[k])

    def step_change(self, measure: str) -> float:
        """Return the mean change of a measure with 1.5 times the step over its mean, in the repeated cases.

        Single runs of a chaotic motion change altogether with the step; the mean over many must not.
        """
        repeats = [(number, entry) for number, entry in self.study.repeats.items() if "measures" in entry]
        values = np.array([self.study.outcomes[number]["measures"][measure] for number, _ in repeats])
        repeated = np.array([entry["measures"][measure] for _, entry in repeats])
        return float(repeated.mean() / values.mean() - 1.0)


def angles(count: int = COUNT) -> list[float]:
    """Return crank angles (rad), equally spaced over a turn."""
    return [2.0 * math.pi * (k + 0.5) / count for k in range(count)]


def scatters(
    model: Mechanism, sets: Sequence[Mapping[str, Any]], measures: Sequence[str], *, turns: int = 2,
    last: int = 1, count: int = COUNT, crank: str = "crank",
    shared: Mapping[str, Sequence[str]] | None = None,
) -> Scatters:  # fmt: skip
    """Run a model with each of several sets of numbers by path, each from ``count`` crank angles.

    All sets name the same paths. ``shared``: paths that receive the value of another one. Measures are
    those of the ``last`` turns.
    """
    rows = [{**numbers, f"body.{crank}.angle": angle} for numbers in sets or [{}] for angle in angles(count)]
    common = shared or {}
    vary = {
        f"number {k}": {"path": [path, *common.get(path, ())], "values": [value]}
        for k, (path, value) in enumerate(rows[0].items())
    }
    points = [{f"number {k}": value for k, value in enumerate(row.values())} for row in rows]
    study = vfife.study(model, vary, list(measures), method="list", point=points, turns=turns, last=last)
    if study.failed:
        raise ValueError(f"a case cannot be run: {study.failed[0][1]}")
    return Scatters(study, max(1, len(sets)))
