"""How far a run's numbers can be trusted: every measure with its range over the run and its companions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Estimate, Record
from ..solvers.refinement import Refined
from .measured import Measured, Measures
from .measures import measures

Array = NDArray[np.float64]

JUDGED = ("force.max", "moment.max", "penetration.max", "angular_acceleration.max", "torque.max")  # largest values of a turn
LOADS = (".force.max", ".moment.max", ".torque.max")
NOISE = 1e-9  # of the largest load: what rounding leaves of one that is zero
ROUNDING = 16.0 * 2.2e-16  # of an angle (rad)
LEAST = 0.1  # of the largest of its kind: what is smaller is compared with that, so that an idle joint makes no run sensitive


def companion_records(record: Record) -> Iterator[Record]:
    """What each companion of a run leaves, as a record of the last turn that measures can be taken of; those with infinite numbers are left out."""
    found = record.companions
    if found is None:
        return
    for k in range(len(found.shifts)):
        if k not in found.lost:
            yield dataclasses.replace(record, steps=found.steps, source=found.rows[:, :, k], kept=found.kept, companions=None)


def ranged(record: Record, reference: Mapping[str, float] | None = None) -> Measures:
    """The measures of a run (:func:`~vfife.analysis.measures.measures`) with their ranges over run and companions.

    Companions share the size of the step. Where a try with twice the step was given up, and its range does not hold what has come out now, it was
    that size which decided: then the ranges reach over both. Ranges of a smooth run are its estimated errors to both sides.
    """
    open_ones = {f"{name}.max" for name in record.assembly.shared}
    return Measures({name: Measured(one, one.low, one.high, name not in open_ones) for name, one in _ranged(record, reference).items()})


def _ranged(record: Record, reference: Mapping[str, float] | None = None) -> dict[str, Measured]:
    if record.estimate is not None:
        errors = record.estimate.errors
        own = measures(record, reference)
        return {name: Measured(value, value - errors.get(name, 0.0), value + errors.get(name, 0.0)) for name, value in own.items()}
    found = own_ranges(record, reference)
    earlier = {} if record.companions is None else record.companions.earlier
    if not earlier or followed(record, found, earlier):
        return found
    both = {name: (min(one.low, *earlier[name]), max(one.high, *earlier[name])) for name, one in found.items() if name in earlier}
    return {name: Measured(one.value, *both.get(name, (one.low, one.high))) for name, one in found.items()}


def own_ranges(record: Record, reference: Mapping[str, float] | None = None) -> dict[str, Measured]:
    """The measures with their ranges over run and companions, whatever was tried before."""
    own = measures(record, reference)
    others = [measures(one, reference) for one in companion_records(record)]
    found = {}
    for name, value in own.items():
        every = [value, *(one[name] for one in others if name in one)]
        found[name] = Measured(value, min(every), max(every))
    return found


def estimate(record: Record, refined: Refined) -> Estimate:
    """Errors of the largest values of a turn: what they differ by from those at half the step, times 2^p/(2^p - 1) with the order p.

    An order is taken as it is found, between one and two; two where nothing but rounding is left to tell it by.
    """
    finer = dataclasses.replace(record, steps=refined.steps, source=refined.rows, kept=refined.kept)
    own, other = measures(record), measures(finer)
    power = 2.0 ** min(max(2.0 if refined.order is None else refined.order, 1.0), 2.0)
    judged = [name for name in own if name.endswith(tuple(f".{kind}" for kind in JUDGED)) and name in other]
    return Estimate(refined.order, {name: abs(own[name] - other[name]) * power / (power - 1.0) for name in judged})


def followed(record: Record, found: Mapping[str, Measured], earlier: Mapping[str, tuple[float, float]]) -> bool:
    """Whether every largest value lies within its earlier range, widened by the tolerance of its size."""
    sizes_now, tolerance = sizes(found, record.assembly.choice.step), record.assembly.mechanism.settings.tolerance
    return all(low - tolerance * sizes_now[name] <= found[name] <= high + tolerance * sizes_now[name]
               for name, (low, high) in earlier.items() if name in sizes_now)  # fmt: skip


def sizes(found: Mapping[str, Measured], step: float) -> dict[str, float]:
    """The size of each largest value of a turn, by name: the largest of its range, or a tenth of the largest of its kind where it is less.

    What never touches has none, nor has what is rounding: moments and forces beside the largest of both (N m, N), and second differences of an
    angle with a ``step`` (s).
    """
    result = {}
    loads = max((one.high for name, one in found.items() if name.endswith(LOADS)), default=0.0)
    noise = dict.fromkeys(LOADS, NOISE * loads) | {".angular_acceleration.max": ROUNDING / step**2}
    for kind in JUDGED:
        members = [(name, one) for name, one in found.items() if name.endswith(f".{kind}")]
        floor = LEAST * max((one.high for _, one in members), default=0.0)
        result.update({name: max(one.high, floor) for name, one in members if one.high > noise.get(f".{kind}", 0.0)})
    return result


def spreads(found: Mapping[str, Measured], step: float) -> dict[str, float]:
    """Width of the range of each largest value of a turn over its size (1), by name."""
    return {name: (found[name].high - max(found[name].low, 0.0)) / size for name, size in sizes(found, step).items()}


def band(record: Record, series: Callable[[Record], Array]) -> tuple[Array, Array] | None:
    """Lowest and highest of a series over run and companions at the outputs of the last turn and the one before, each of the series' shape."""
    found = record.companions
    if found is None:
        return None
    own = series(record)[np.isin(record.steps, found.steps)]
    every = np.stack([own, *(series(one)[-len(own) :] for one in companion_records(record))])
    return every.min(axis=0), every.max(axis=0)
