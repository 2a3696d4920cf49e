"""Machines whose clearances differ independently, by which clearances are ranked.

Machines of an allocation do not serve: choices that fail early leave few of them, and all those of a choice
have the same grades.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..job.job import Job
from ..model.mechanism import Mechanism
from ..studies.engine.cases import run_cases
from ..studies.spec.distributions import places
from ..studies.spec.plan import CaseSpec
from .ranking import Rank, partial_ranks

# With 64 machines a partial rank correlation beyond 0.25 is visible with 95 % confidence.
MACHINES, SEED = 64, 1
Array = NDArray[np.float64]


@dataclass(frozen=True)
class MachineSample:
    """Machines with ``clearances`` (m), shape (machines, joints), of the joints ``names``; ``values`` (SI)
    of the measure, NaN for a machine that failed.
    """

    names: tuple[str, ...]
    clearances: Array
    values: Array

    @property
    def count(self) -> int:
        """Number of machines that have a value."""
        return int(np.isfinite(self.values).sum())

    @property
    def span(self) -> tuple[float, float]:
        """Least and largest value."""
        finite = self.values[np.isfinite(self.values)]
        return float(finite.min()), float(finite.max())

    @property
    def ranks(self) -> dict[str, Rank]:
        """Partial rank correlation of the measure with each clearance, without joints of which it is not
        known.
        """
        ranks = partial_ranks(self.clearances, self.values)
        return {name: rank for name, rank in zip(self.names, ranks, strict=True) if rank is not None}


def sampled_clearances(limits: Mapping[str, tuple[float, float]]) -> Array:
    """Return clearances (m) of machines between ``limits`` (m) by joint, each range divided evenly, shape
    (machines, joints).
    """
    unit = places("latin", MACHINES, len(limits), SEED)
    low, high = np.array(list(limits.values())).T
    return np.asarray(low + (high - low) * unit)


def run_sample(
    mechanism: Mechanism,
    limits: Mapping[str, tuple[float, float]],
    paths: Mapping[str, str],
    spec: CaseSpec,
    job: Job,
) -> MachineSample:
    """Run machines with clearances between ``limits`` (m) by joint and return the first measure of ``spec``;
    ``paths`` of the clearances by joint. The ``job`` counts the machines.
    """
    clearances = sampled_clearances(limits)
    numbers = [
        {paths[name]: float(value) for name, value in zip(limits, row, strict=True)} for row in clearances
    ]
    values = np.full(len(numbers), math.nan)
    for done, (k, outcome) in enumerate(run_cases(mechanism, numbers, spec), 1):
        job.count(done, len(numbers), "machines", failed=not outcome.values)
        values[k] = outcome.values.get(spec.measures[0], math.nan)
    return MachineSample(tuple(limits), clearances, values)
