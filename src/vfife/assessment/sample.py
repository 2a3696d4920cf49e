"""Machines whose clearances differ independently, by which clearances are ranked.

Machines of an allocation do not serve: choices that fail early leave few of them, and all those of a choice
have the same grades.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..job.cost import cores, timed
from ..job.job import Job
from ..model.mechanism import Mechanism
from ..studies.engine.cases import run_cases
from ..studies.spec.distributions import places
from ..studies.spec.plan import CaseSpec
from .ranking import Rank, partial_ranks

# With 64 machines a partial rank correlation beyond 0.25 is visible with 95 % confidence.
MACHINES, SEED = 64, 1
NEAR_MACHINES, CLEARANCE_SPREAD = 8, 2e-4  # machines that hardly differ, and the share by which they do
MOST_CORNER_JOINTS = 3  # all combinations of limits of more joints are more than eight machines
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

    def within(self, limits: Mapping[str, tuple[float, float]]) -> NDArray[np.bool_]:
        """Return which machines have clearances within ``limits`` (m) by joint, shape (machines,)."""
        inside = np.ones(len(self.clearances), dtype=bool)
        for name, column in zip(self.names, self.clearances.T, strict=True):
            low, high = limits.get(name, (-math.inf, math.inf))
            inside &= (low <= column) & (column <= high)
        return inside

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


def corner_clearances(limits: Mapping[str, tuple[float, float]]) -> Array:
    """Return clearances (m) at ``limits`` (m) by joint, shape (machines, joints): all combinations for a few
    joints, otherwise all lower and all upper limits.
    """
    if len(limits) <= MOST_CORNER_JOINTS:
        return np.array(list(itertools.product(*limits.values())))
    return np.array(list(limits.values())).T


def corner_count(joints: int) -> int:
    """Return the number of machines with clearances at the limits of fits of so many joints."""
    return 1 << joints if joints <= MOST_CORNER_JOINTS else 2


def run_machines(
    mechanism: Mechanism, clearances: Array, paths: Mapping[str, str], spec: CaseSpec, job: Job
) -> MachineSample:
    """Run machines with ``clearances`` (m), shape (machines, joints), and return the first measure of
    ``spec``; ``paths`` of the clearances by joint, in the order of the columns. The
    ``job`` counts the machines.
    """
    numbers = [
        {path: float(value) for path, value in zip(paths.values(), row, strict=True)} for row in clearances
    ]
    values = np.full(len(numbers), math.nan)
    for done, (k, outcome) in enumerate(run_cases(mechanism, numbers, spec), 1):
        job.count(done, len(numbers), "machines", failed=not outcome.values)
        values[k] = outcome.values.get(spec.measures[0], math.nan)
    return MachineSample(tuple(paths), clearances, values)


def timed_machine(
    mechanism: Mechanism, limits: Mapping[str, tuple[float, float]], measure: str, count: int
) -> float:
    """Return the time (s) of a turn of a machine on all cores, from ``count`` machines as those that rank;
    ``limits`` of clearances (m) by path.

    Machines that hardly differ do not serve: their contacts begin in the same steps, so that all lanes take
    the short way through a step. With five pins they take half as long.
    """
    rows = sampled_clearances(limits)[:count]
    machines = [dict(zip(limits, row.tolist(), strict=True)) for row in rows]
    spec = CaseSpec((measure,), 1, last=1)
    list(run_cases(mechanism, machines[:1], spec))  # compiles
    return timed(lambda: list(run_cases(mechanism, machines, spec))) / len(machines) / cores()


def near_machines(clearances: Mapping[str, float]) -> list[dict[str, float | str]]:
    """Return the numbers of machines with nearly the ``clearances`` (m) by path."""
    shares = (1.0 + CLEARANCE_SPREAD * (k / (NEAR_MACHINES - 1) - 0.5) for k in range(NEAR_MACHINES))
    return [{path: share * clearance for path, clearance in clearances.items()} for share in shares]
