"""Machines whose clearances differ independently, by which clearances are ranked.

Machines of an allocation do not serve: choices that fail early leave few of them, and all those of a choice
have the same grades.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..job.cost import Forecast, cores, timed
from ..job.job import Job
from ..job.progress import span
from ..measures.catalogue import is_coordinate
from ..model.mechanism import Mechanism
from ..report.cautions import law_cautions
from ..results.derivatives import Effect
from ..simulation.simulate import Prepared, run_prepared
from ..solvers.status import Status
from ..studies.engine.cases import Outcome, run_cases
from ..studies.engine.step_trials import repeated_step
from ..studies.methods.allocation import options_of
from ..studies.spec.distributions import places
from ..studies.spec.plan import CaseSpec
from .ranking import Rank, partial_ranks

# With 64 machines a partial rank correlation beyond 0.25 is visible with 95 % confidence.
MACHINES, SEED = 64, 1
NEAR_MACHINES, CLEARANCE_SPREAD = 8, 2e-4  # machines that hardly differ, and the share by which they do
# The growth of a clearance whose effect is quoted (m, and share of the clearance): about half the width of a
# fit of grade 7. Effects of forces with impacts are not smooth: they are those of pairs of machines with
# clearances up to the growth less and more than in the model, each growth in as many parts.
MOST_GROWTH, SHARE_OF_CLEARANCE, PARTS_OF_GROWTH = 10e-6, 0.5, 4
FINER_STEP = 0.8  # a second step of these machines, over the automatic one
# Machines around that with the largest value, in rounds, and half the width of their range over that of the
# limits of the fits.
ROUNDS, AROUND, HALF_WIDTH = 2, 8, 0.125
# Mean square of the difference to the nearest machine, over that of any two, from which a measure does not
# vary smoothly: 0.01 to 0.05 of planes with two or three joints, 1 of noise; fewer machines tell nothing.
ROUGH, FEWEST_FOR_ROUGHNESS = 0.25, 16
MOST_CORNER_JOINTS = 3  # all combinations of limits of more joints are more than eight machines
# Of so many independent machines the largest is exceeded by at most 5 % of all, with 95 % confidence.
EVEN_MACHINES, EVEN_SEED = 59, 2
FIT_MACHINES = EVEN_MACHINES + ROUNDS * AROUND  # within the limits of the fits, beside their corners
LOADS = (".force.max", ".torque.max")  # endings of measures that cautions on the contact law name
PARTS = {
    "sensitivity": "sensitivities", "ranks": "ranks", "fits": "fits",
    "limits": "machines within the limits of the fits", "life": "wear",
}  # fmt: skip
SPREAD = 0.5  # share by which the clearance of a joint without a fit differs among the machines that rank it
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
    def jump(self) -> float:
        """Root mean square of the difference (SI) between machines with nearly the same clearances, where the
        measure does not vary smoothly with them; 0 where it does, or too few machines tell.
        """
        finite = np.isfinite(self.values)
        values, places = self.values[finite], self.clearances[finite]
        width = np.ptp(places, axis=0) if len(places) else np.zeros(0)
        if len(values) < FEWEST_FOR_ROUGHNESS or not width.any() or not np.ptp(values):
            return 0.0
        places = places[:, width > 0.0] / width[width > 0.0]
        distances = np.square(places[:, None] - places[None]).sum(axis=2)
        np.fill_diagonal(distances, math.inf)
        square = float(np.square(values - values[distances.argmin(axis=1)]).mean())
        return math.sqrt(square) if square > ROUGH * 2.0 * float(values.var()) else 0.0

    @property
    def ranks(self) -> dict[str, Rank]:
        """Partial rank correlation of the measure with each clearance, without joints of which it is not
        known.
        """
        ranks = partial_ranks(self.clearances, self.values)
        return {name: rank for name, rank in zip(self.names, ranks, strict=True) if rank is not None}


def sampled_clearances(
    limits: Mapping[str, tuple[float, float]], count: int = MACHINES, seed: int = SEED
) -> Array:
    """Return clearances (m) of independent machines between ``limits`` (m) by joint, all equally likely,
    shape (machines, joints).
    """
    unit = places("random", count, len(limits), seed)
    low, high = np.array(list(limits.values())).T
    return np.asarray(low + (high - low) * unit)


def corner_clearances(limits: Mapping[str, tuple[float, float]]) -> Array:
    """Return clearances (m) at ``limits`` (m) by joint, shape (machines, joints): all combinations for a few
    joints, otherwise all lower and all upper limits.
    """
    if len(limits) <= MOST_CORNER_JOINTS:
        return np.array(list(itertools.product(*limits.values())))
    return np.array(list(limits.values())).T


def clearances_around(machine: Mapping[str, float], limits: Mapping[str, tuple[float, float]]) -> Array:
    """Return clearances (m) near those of a ``machine`` and within ``limits`` (m), both by joint, shape
    (machines, joints).
    """
    low, high = np.array(list(limits.values())).T
    middle, half = np.array([machine[name] for name in limits]), HALF_WIDTH * (high - low)
    unit = places("latin", AROUND, len(limits), SEED)
    return np.asarray(np.clip(middle + half * (2.0 * unit - 1.0), low, high))


def joined(parts: list[MachineSample]) -> MachineSample:
    """Return the machines of samples with the same joints as one."""
    columns = ("clearances", "values")
    return MachineSample(parts[0].names, *(np.concatenate([getattr(p, c) for p in parts]) for c in columns))


def corner_count(joints: int) -> int:
    """Return the number of machines with clearances at the limits of fits of so many joints."""
    return 1 << joints if joints <= MOST_CORNER_JOINTS else 2


def ideal_value(mechanism: Mechanism, spec: CaseSpec) -> float | None:
    """Return the first measure (SI) of ``spec`` of the mechanism without clearance, with rigid bodies; None
    where it does not move.
    """
    try:
        outcomes = [outcome for _, outcome in run_cases(mechanism.ideal(), [{}], spec)]
    except VfifeError:
        return None
    return outcomes[0].values.get(spec.measures[0])


def law_caution(prepared: Prepared, measure: str) -> str | None:
    """Return the caution of a run of the model on what the contact law decides of a force or torque; "" where
    it has none, None for another measure. Raises KeyboardInterrupt for a run that was interrupted.
    """
    if not measure.endswith(LOADS):
        return None
    result = run_prepared(prepared)
    if result.record.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    cautions, joint = law_cautions(result), measure.partition(".")[0]
    texts = cautions.joints.get(joint), cautions.shocks.get(joint), cautions.loads.get(measure)
    return next(filter(None, texts), "")


def limits_of(
    fit: str | None, size: float, cost: Mapping[str, float], clearance: float
) -> tuple[float, float]:
    """Return the least and largest clearance (m) of a joint of nominal ``size`` (m) with the letters of
    ``fit`` and any grade with a ``cost``; half and one and a half times its own ``clearance`` (m) without
    a fit.
    """
    if fit is None:
        return (1.0 - SPREAD) * clearance, (1.0 + SPREAD) * clearance
    letters = "/".join(name.rstrip("0123456789") for name in fit.split("/"))
    limits = [option.clearance.limits for option in options_of(letters, size, cost)]
    return min(low for low, _ in limits), max(high for _, high in limits)


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


def growth_of(clearance: float) -> float:
    """Return the growth (m) of a ``clearance`` (m) whose effect is quoted."""
    return min(MOST_GROWTH, SHARE_OF_CLEARANCE * clearance)


def growth_effects(
    mechanism: Mechanism, clearances: Mapping[str, float], spec: CaseSpec, job: Job
) -> dict[str, Effect]:
    """Return the effect on the first measure of ``spec`` of the growth of each of the ``clearances`` (m) by
    path, from machines that have it: in per cent, or of a coordinate, whose zero is arbitrary, as a
    difference (SI).

    Machines are compared in pairs whose clearances differ by the growth and which are alike in everything
    else; the smaller clearance of a pair is that of the model or up to the growth less, and two steps are
    used. The range covers the pairs; an effect whose sign they do not agree on, or of which one failed, is
    of the kind "unknown".
    """
    places = [k for k in range(-PARTS_OF_GROWTH, 1 + PARTS_OF_GROWTH) if k]
    machines = [dict(clearances)] + [
        {**clearances, path: clearance + growth_of(clearance) * k / PARTS_OF_GROWTH}
        for path, clearance in clearances.items()
        for k in places
    ]
    columns, finer = list[Array](), spec
    for repetition in range(2):
        values, steps = np.full(len(machines), math.nan), [math.inf]
        for done, (k, outcome) in enumerate(run_cases(mechanism, machines, finer), 1):
            count = repetition * len(machines) + done
            job.count(count, 2 * len(machines), "machines", failed=not outcome.values)
            values[k] = outcome.values.get(spec.measures[0], math.nan)
            steps.append(_finer_step(outcome, mechanism.settings.outputs))
        rows = values[1:].reshape(len(clearances), len(places))
        columns.append(np.insert(rows, PARTS_OF_GROWTH, values[0], axis=1))
        if not math.isfinite(min(steps)):  # no machine has a value
            break
        finer = dataclasses.replace(spec, step=min(steps))
    result = {}
    for path, values in zip(clearances, np.stack(columns, axis=1), strict=True):
        smaller, larger = values[:, : 1 + PARTS_OF_GROWTH], values[:, PARTS_OF_GROWTH:]
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = 1.0 if is_coordinate(spec.measures[0]) else 0.01 * np.abs(smaller)
            changes = (larger - smaller) / scale
        low, high = float(changes.min()), float(changes.max())
        agreement = math.isfinite(high - low) and low * high >= 0.0
        result[path] = Effect(path, "change" if agreement else "unknown", float(changes.mean()), low, high)
    return result


def _finer_step(outcome: Outcome, outputs: int) -> float:
    """Return a step (s) smaller than that of a machine by which each output of a turn is a whole number of
    steps; infinite for a machine that failed.
    """
    if not outcome.values or not outcome.turns:
        return math.inf
    return repeated_step({"step": outcome.step}, outcome.steps // outcome.turns, outputs, FINER_STEP)


def with_growths(forecast: Forecast, joints: int, machine: float) -> Forecast:
    """Return the forecast of derivatives by ``joints`` clearances with that of the machines of
    :func:`growth_effects`; ``machine``: time (s) of one.
    """
    seconds = (1 + 2 * PARTS_OF_GROWTH * joints) * (1.0 + 1.0 / FINER_STEP) * machine
    ends = forecast.ends and (forecast.ends[0] + seconds, forecast.ends[1] + seconds)
    return dataclasses.replace(forecast, seconds=forecast.seconds + seconds, ends=ends)


def total_forecast(parts: Mapping[str, Forecast], remedy: str, ranking: float = 0.0) -> Forecast:
    """Return the forecast of all parts, with what makes them shorter; ``ranking``: time (s) of machines that
    are run only if a derivative is not known.
    """
    texts = [f"{PARTS[name]}: {span(forecast.seconds)}{forecast.note}." for name, forecast in parts.items()]
    texts += list(parts["fits"].remarks[-1:]) if "fits" in parts else []
    seconds = sum(forecast.seconds for forecast in parts.values())
    shortest = sum(forecast.ends[0] if forecast.ends else forecast.seconds for forecast in parts.values())
    longest = sum(forecast.longest for forecast in parts.values()) + ranking
    ends = tuple(dict.fromkeys((span(shortest), span(longest))))
    note = f", {' to '.join(ends)} in the cheapest and the dearest case" if len(ends) > 1 else ""
    return Forecast(
        "part", len(parts), seconds=seconds, note=note, ends=(shortest, longest),
        memory=max((forecast.memory for forecast in parts.values()), default=0.0),
        threads=max((forecast.threads for forecast in parts.values()), default=1),
        work=" and ".join(PARTS[name] for name in parts), parts=tuple(texts), remedy=remedy,
    )  # fmt: skip


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
