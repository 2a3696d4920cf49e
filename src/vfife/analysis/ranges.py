"""How far a run's numbers can be trusted: every measure with its range over the run and its companions."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..solvers.companions import oldest_needed
from ..solvers.record import Estimate, Record
from ..solvers.refinement import Refined
from ..solvers.repeating import outputs_of_a_turn
from .measured import Measured, Measures
from .measures import Measure, compared, last_turn, measures, over_run, over_turn
from .meshes import EXACT
from .turns import Turns, each_turn, each_turn_beside, part_of, turns

Array = NDArray[np.float64]
Some: TypeAlias = tuple[Measure, ...] | None  # of the measures of a turn; all of them

JUDGED = ("force.max", "moment.max", "penetration.max", "angular_acceleration.max", "torque.max")  # largest values of a turn
LOADS = (".force.max", ".moment.max", ".torque.max")
NOISE = 1e-9  # of the largest load: what rounding leaves of one that is zero
ROUNDING = 16.0 * 2.2e-16  # of an angle (rad)
SAFETY = 1.25  # times an estimated error: that of Roache's grid convergence index for three grids
SLOWEST = 0.75  # ratio of a difference to that before it, at the most: an order of 0.4
FLOOR = 0.1  # of the error of the largest value that is known worst, relative to its size
PLACES = (".place",)  # endings of measures that jump from node to node, whose differences are no errors
LEAST = 0.1  # of the largest of its kind: what is smaller is compared with that, so that an idle joint makes no run sensitive


def companion_records(record: Record) -> Iterator[Record]:
    """What each companion of a run leaves, as a record of the last turn that measures can be taken of; those with infinite numbers are left out."""
    found = record.companions
    if found is None:
        return
    for k in range(len(found.shifts)):
        if k not in found.lost:
            yield dataclasses.replace(record, steps=found.steps, source=found.rows[:, :, k], kept=found.kept, companions=None)


def ranged(record: Record, reference: Mapping[str, float] | None = None, every: Some = None) -> Measures:
    """The measures of a run (:func:`~vfife.analysis.measures.measures`): means of its turns after the transient, with what varies and what is
    not known; see :func:`own_ranges`.

    Companions share the size of the step. Where a try with twice the step was given up, and its range does not hold what has come out now, it was
    that size which decided: then the ranges reach over both. Ranges of a smooth run are its estimated errors to both sides.
    """
    open_ones = {f"{name}.max" for name in record.assembly.shared}
    found = {name: (one, *_reach(record, name, one)) for name, one in own_ranges(record, reference, every).items()}
    earlier = {} if record.companions is None else record.companions.earlier
    if earlier and not followed(record, {name: one for name, (one, _, _) in found.items()}, earlier):
        found = {
            name: (one, min(low, earlier[name][0]), max(high, earlier[name][1])) if name in earlier else (one, low, high)
            for name, (one, low, high) in found.items()
        }
    made = Measures({
        name: Measured(one, low, high, name not in open_ones, one.lowest, one.highest, _estimated(record, name, one))
        for name, (one, low, high) in found.items()
    })  # fmt: skip
    made.part = part_of(record, counted(record))
    return made


def _reach(record: Record, name: str, one: Measured) -> tuple[float, float]:
    """Low and high over the companions, or by the estimated error of a smooth run."""
    if record.estimate is None:
        return one.low, one.high
    error = record.estimate.errors.get(name, 0.0)
    return one.value - error, one.value + error


def _estimated(record: Record, name: str, one: Measured) -> bool:
    """Whether the error of a measure is known, from companions, or from a run at finer steps or on a finer mesh."""
    if record.static and name in EXACT:
        return True
    return one.estimated if record.estimate is None else name in record.estimate.errors


def own_ranges(record: Record, reference: Mapping[str, float] | None = None, every: Some = None) -> dict[str, Measured]:
    """The measures with their ranges, whatever was tried before.

    Of a run whose turns repeat: means over its turns since then, from the lowest to the highest of them, and how these means differ over run and
    companions. Of one that is not periodic: means over turns of run and companions together. Of a run of few turns, or one that has not settled:
    its last turn. Counts are those of the whole run. ``every``: some of the measures of a turn only.
    """
    said = counted(record)
    if said is None or not said.several:
        return joined(measures(record, reference, every), [measures(one, reference, every) for one in companion_records(record)])
    left = record.companions
    sound = [] if left is None else [k for k in range(len(left.shifts)) if k not in left.lost]
    lanes = [each_turn(record, said.first, said.last), *(each_turn_beside(record, k, said.first, said.last) for k in sound)]
    taken = [[_of_a_turn(one, reference, every) for one in lane] for lane in lanes]
    whole = joined(over_run(record), [over_run(one) for one in companion_records(record)])
    return over_turns(taken, together=said.motion == "not periodic") | whole


def counted(record: Record) -> Turns | None:
    """The turns of a run, told by its last one where nothing is kept of those before of its companions."""
    said = turns(record)
    if said is not None and record.companions is not None and len(record.companions.turns) < said.last:
        return dataclasses.replace(said, first=said.last)
    return said


def _of_a_turn(record: Record, reference: Mapping[str, float] | None, every: Some) -> dict[str, float]:
    found = over_turn(record, last_turn(record), every)
    return found | compared(record, found, reference)


def joined(own: Mapping[str, float], others: Sequence[Mapping[str, float]]) -> dict[str, Measured]:
    """Measures of a run with their ranges over it and its companions."""
    found = {}
    for name, value in own.items():
        every = [value, *(one[name] for one in others if name in one)]
        found[name] = Measured(value, min(every), max(every), estimated=len(every) > 1)
    return found


def over_turns(lanes: Sequence[Sequence[Mapping[str, float]]], *, together: bool) -> dict[str, Measured]:
    """Measures from those of the turns of each lane, the run itself first: means over its turns, or over the turns of all lanes ``together``."""
    found = {}
    for name in lanes[0][-1]:
        turnly = [[turn[name] for turn in lane if name in turn] for lane in lanes]
        means = [math.fsum(lane) / len(lane) for lane in turnly if lane]
        every = [value for lane in (turnly if together else turnly[:1]) for value in lane]
        value = math.fsum(means) / len(means) if together else means[0]
        found[name] = Measured(value, min(means), max(means), lowest=min(every), highest=max(every), estimated=len(means) > 1)
    return found


def window(record: Record) -> int:
    """The step of the output from which on the measures of a run need its outputs: that before their first turn."""
    said, outputs = counted(record), outputs_of_a_turn(record.assembly)
    if said is None or outputs is None:
        return oldest_needed(record.assembly, int(record.steps[-1]))
    return int(record.steps[(said.first - 1) * outputs])


def estimate(record: Record, refined: Refined) -> Estimate:
    """Errors of all measures of a smooth run, from the same measures at half and at a quarter of its step (:func:`error_of`).

    Two runs may agree on a measure by chance. So none is taken to be better known than FLOOR times the largest value that is known worst.
    """
    own, half, quarter = (_values(one, record) for one in (record, refined.half, refined.quarter))
    names = [name for name in own if not name.endswith(PLACES) and name in half and name in quarter]
    errors = {name: error_of(own[name], half[name], quarter[name], refined.order) for name in names}
    size = sizes({name: Measured(value) for name, value in own.items()}, record.assembly.choice.step)
    floor = FLOOR * max((errors[name] / size[name] for name in errors if name in size), default=0.0)
    return Estimate(refined.order, {name: max(one, floor * size.get(name, abs(own[name]))) for name, one in errors.items()}, refined.converges)


def error_of(own: float, half: float, quarter: float, order: float | None) -> float:
    """Error of a value from those at half and at a quarter of the step, where positions converge with ``order``.

    The distance from h/4, and what h/4 misses: the differences from halving to halving continue as a geometric series. Its ratio is that of the
    two differences of the value, 3/4 at the most, and 2^-p at the least, p the order between one and two (two where there is only rounding). The
    second difference alone would do for a regular value, so it may not be smaller than the first lets expect. Largest values are met between
    steps and converge unevenly: hence SAFETY.
    """
    first, second, both = abs(own - half), abs(half - quarter), abs(own - quarter)
    least = 2.0 ** -min(max(2.0 if order is None else order, 1.0), 2.0)
    ratio = min(max(second / first if first > 0.0 else SLOWEST, least), SLOWEST)
    return SAFETY * max(first / (1.0 - least), both + second * ratio / (1.0 - ratio))


def _values(part: Record, run: Record) -> dict[str, float]:
    """The measures of a ``run``, taken of the last outputs of it or of its repetition at another step."""
    said, outputs = counted(run), outputs_of_a_turn(run.assembly)
    if said is None or outputs is None or not said.several:
        return measures(part)
    count = said.last - said.first + 1
    rows = slice(len(part.steps) - count * outputs - 1, None)
    part = dataclasses.replace(part, steps=part.steps[rows], source=part.rows[rows], companions=None)
    lanes = [[_of_a_turn(one, None, None) for one in each_turn(part, 1, count)]]
    return {name: one.value for name, one in over_turns(lanes, together=False).items()}


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
