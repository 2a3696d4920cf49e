"""How far a run's numbers can be trusted: every measure with a range that estimates the error of its step.

Companions repeat a run with about 1.4, 1.7 and 2 times its step. How a measure changes with the step gives
the range that holds its limit (:mod:`~vfife.measures.convergence`); how far its values lie apart says whether
the step is fine enough, what an automatic step has to become, and whether a run is sensitive.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..solvers.companions import SENSITIVE, Parting, oldest_needed
from ..solvers.record import Estimate, Record
from ..solvers.refinement import Refined
from ..solvers.repeating import outputs_of_a_turn
from ..solvers.status import Status
from .catalogue import PEAKS, Measure, compared, last_turn, measures, over_run, over_turn
from .convergence import LANES_OF_MEANS, SCATTER, SCATTER_OF_MEANS, error_range, widen
from .energy import ledger, own_floor
from .measured import Measured, Measures
from .meshes import EXACT
from .meshes import spreads as static_spreads
from .turns import Turns, each_turn, each_turn_beside, part_of, record_of_companion, turns

Array = NDArray[np.float64]
Some: TypeAlias = tuple[Measure, ...] | None  # of the measures of a turn; all of them

JUDGED = (
    "force.max",
    "moment.max",
    "penetration.max",
    "angular_acceleration.max",
    "torque.max",
)  # largest values of a turn
LOADS = (".force.max", ".moment.max", ".torque.max")
NOISE = 1e-9  # of the largest load: what rounding leaves of one that is zero
ROUNDING = 16.0 * 2.2e-16  # of an angle (rad)
SAFETY = 1.25  # times an estimated error: that of Roache's grid convergence index for three grids
FIRST_ORDER, SECOND_ORDER = (
    0.5,
    0.25,
)  # ratio of a difference to that before it, from halving to halving of the step
SLOWEST = 0.75  # that ratio at the most: an order of 0.4
FLOOR = 0.1  # of the error of the largest value that is known worst, relative to its size
PLACES = (".place",)  # endings of measures that jump from node to node, whose differences are no errors
# of the largest of its kind: what is smaller is compared with that, so that an idle joint makes no run
# sensitive
LEAST = 0.1


def companion_records(record: Record) -> Iterator[Record]:
    """What each companion of a run leaves, as a record of the last turn that measures can be taken of; those
    with infinite numbers are left out.
    """
    found = record.companions
    if found is None:
        return
    for k in range(len(found.counts)):
        if k not in found.lost:
            yield record_of_companion(record, k)


@dataclass(frozen=True)
class Samples:
    """A measure at the step sizes of a run and its companions: ``value`` is what is reported, ``values``
    those of all lanes, the run's first.

    ``ratios`` are the steps of the lanes over that of the run. ``lowest`` and ``highest`` are those of the
    turns that it is of. ``scatters``: the value is a mean over all lanes, which differ by chance.
    """

    value: float
    values: tuple[float, ...]
    ratios: tuple[float, ...]
    lowest: float
    highest: float
    scatters: bool = False

    @property
    def low(self) -> float:
        """The least of all lanes."""
        return min(self.values)

    @property
    def high(self) -> float:
        """The largest of all lanes."""
        return max(self.values)

    @property
    def hull(self) -> Measured:
        """The measure with the range of its values."""
        return Measured(self.value, self.low, self.high, lowest=self.lowest, highest=self.highest)

    def error_range(self, name: str) -> tuple[float, float]:
        """The range that estimates its error; that of its values where all lanes have one step size."""
        if len(set(self.ratios)) < 2:
            return self.low, self.high
        if self.scatters:
            share = SCATTER_OF_MEANS if len(self.values) >= LANES_OF_MEANS else SCATTER
            return widen(name, self.low, self.high, share * (self.high - self.low))
        return error_range(name, self.ratios, self.values)


def ranged(record: Record, reference: Mapping[str, float] | None = None, every: Some = None) -> Measures:
    """The measures of a run (:func:`~vfife.measures.catalogue.measures`): means of its turns after the
    transient, with what varies and what is not known; see :func:`samples`.

    Ranges estimate the error of the step, from the values at all step sizes. Where a try with twice the step
    was given up, and its range does not hold what has come out now, the estimate of that try has failed: then
    the ranges reach over both. Ranges of a smooth run are its estimated errors to both sides.
    """
    open_ones = {f"{name}.max" for name in record.assembly.shared}
    found, joins = samples(record, reference, every), contradiction(record)
    made = Measures()
    for name, one in found.items():
        low, high = _reach(record, name, one)
        if name in joins:
            least, most = min(one.low, joins[name][0]), max(one.high, joins[name][1])
            wide = widen(name, least, most, SCATTER * (most - least))
            low, high = min(low, wide[0]), max(high, wide[1])
        made[name] = Measured(
            one.value,
            low,
            high,
            name not in open_ones,
            one.lowest,
            one.highest,
            _estimated(record, name, one),
        )
    made.part = part_of(record, counted(record))
    return made


def contradiction(record: Record) -> Mapping[str, tuple[float, float]]:
    """The ranges of the try with twice the step, where its estimate does not hold what has come out now; none
    where it does, or there was none.
    """
    earlier = {} if record.companions is None else record.companions.earlier
    return {} if not earlier or followed(record, own_ranges(record, every=PEAKS), earlier) else earlier


def over_tries(
    record: Record, reference: Mapping[str, float] | None = None, every: Some = None
) -> dict[str, Measured]:
    """The measures with the ranges of their values at all step sizes: those of the run and its companions,
    and of the try before it where its estimate does not hold what has come out now.
    """
    found, joins = own_ranges(record, reference, every), contradiction(record)
    for name in joins.keys() & found.keys():
        one, (low, high) = found[name], joins[name]
        found[name] = Measured(one, min(one.low, low), max(one.high, high), True, one.lowest, one.highest)
    return found


def _reach(record: Record, name: str, one: Samples) -> tuple[float, float]:
    """Low and high by the values at several step sizes, or by the estimated error of a smooth run."""
    if record.estimate is None:
        return one.error_range(name)
    error = record.estimate.errors.get(name, 0.0)
    low = one.value - error
    return max(low, 0.0) if one.value >= 0.0 and name.endswith(".max") else low, one.value + error


def _estimated(record: Record, name: str, one: Samples) -> bool:
    """Whether the error of a measure is known, from companions, or from a run at finer steps or on a finer
    mesh.
    """
    if record.static and name in EXACT:
        return True
    return len(one.values) > 1 if record.estimate is None else name in record.estimate.errors


def step_ratios(record: Record) -> tuple[float, ...]:
    """Step sizes of a run and those of its companions that have finite numbers, over that of the run; version
    0.2 gave all the step of the run.
    """
    left, every = record.companions, record.assembly.choice.outputs_every
    return (
        1.0,
        *(
            every / int(count)
            for k, count in enumerate(() if left is None else left.counts)
            if left is None or k not in left.lost
        ),
    )


def own_ranges(
    record: Record, reference: Mapping[str, float] | None = None, every: Some = None
) -> dict[str, Measured]:
    """The measures with the ranges of their values over the run and its companions, whatever was tried
    before.
    """
    return {name: one.hull for name, one in samples(record, reference, every).items()}


def samples(
    record: Record, reference: Mapping[str, float] | None = None, every: Some = None
) -> dict[str, Samples]:
    """The measures at all step sizes.

    Of a run whose turns repeat: means over its turns since then, from the lowest to the highest of them, and
    how these means differ over run and companions. Of one that is not periodic: means over turns of run and
    companions together. Of a run of few turns, or one that has not settled: its last turn. Counts are those
    of the whole run. ``every``: some of the measures of a turn only.
    """
    said, ratios = counted(record), step_ratios(record)
    if said is None or not said.several:
        return joined(
            measures(record, reference, every),
            [measures(one, reference, every) for one in companion_records(record)],
            ratios,
        )
    left = record.companions
    sound = [] if left is None else [k for k in range(len(left.counts)) if k not in left.lost]
    lanes = [
        each_turn(record, said.first, said.last),
        *(each_turn_beside(record, k, said.first, said.last) for k in sound),
    ]
    taken = [[_of_a_turn(one, reference, every) for one in lane] for lane in lanes]
    whole = joined(over_run(record), [over_run(one) for one in companion_records(record)], ratios)
    return over_turns(taken, ratios, together=said.motion == "not periodic") | whole


def counted(record: Record) -> Turns | None:
    """The turns of a run, told by its last one where nothing is kept of those before of its companions."""
    said = turns(record)
    if said is not None and record.companions is not None and len(record.companions.turns) < said.last:
        return dataclasses.replace(said, first=said.last)
    return said


def _of_a_turn(record: Record, reference: Mapping[str, float] | None, every: Some) -> dict[str, float]:
    found = over_turn(record, last_turn(record), every)
    return found | compared(record, found, reference)


def joined(
    own: Mapping[str, float], others: Sequence[Mapping[str, float]], ratios: Sequence[float]
) -> dict[str, Samples]:
    """Measures of a run and its companions, whose steps have these ``ratios``, the run's first."""
    found = {}
    for name, value in own.items():
        pairs = [(ratio, one[name]) for ratio, one in zip(ratios, (own, *others), strict=True) if name in one]
        found[name] = Samples(
            value, tuple(one for _, one in pairs), tuple(ratio for ratio, _ in pairs), value, value
        )
    return found


def over_turns(
    lanes: Sequence[Sequence[Mapping[str, float]]], ratios: Sequence[float], *, together: bool
) -> dict[str, Samples]:
    """Measures from those of the turns of each lane, the run itself first: means over its turns, or over the
    turns of all lanes ``together``.
    """
    found = {}
    for name in lanes[0][-1]:
        turnly = [[turn[name] for turn in lane if name in turn] for lane in lanes]
        pairs = [
            (ratio, math.fsum(lane) / len(lane)) for ratio, lane in zip(ratios, turnly, strict=True) if lane
        ]
        means = tuple(mean for _, mean in pairs)
        every = [value for lane in (turnly if together else turnly[:1]) for value in lane]
        value = math.fsum(means) / len(means) if together else means[0]
        found[name] = Samples(
            value, means, tuple(ratio for ratio, _ in pairs), min(every), max(every), together
        )
    return found


def window(record: Record) -> int:
    """The step of the output from which on the measures of a run need its outputs: that before their first
    turn.
    """
    said, outputs = counted(record), outputs_of_a_turn(record.assembly)
    if said is None or outputs is None:
        return oldest_needed(record.assembly, int(record.steps[-1]))
    return int(record.steps[(said.first - 1) * outputs])


def estimate(record: Record, refined: Refined) -> Estimate:
    """Errors of all measures of a smooth run, from the same measures at half and at a quarter of its step
    (:func:`error_of`).

    Two runs may agree on a measure by chance. So none is taken to be better known than FLOOR times the
    largest value that is known worst.
    """
    own, half, quarter = (values_of(one, record) for one in (record, refined.half, refined.quarter))
    names = [name for name in own if not name.endswith(PLACES) and name in half and name in quarter]
    errors = {name: error_of(own[name], half[name], quarter[name], refined.ratio) for name in names}
    size = sizes({name: Measured(value) for name, value in own.items()}, record.assembly.choice.step)
    floor = FLOOR * max((errors[name] / size[name] for name in errors if name in size), default=0.0)
    return Estimate(
        refined.order,
        {name: max(one, floor * size.get(name, abs(own[name]))) for name, one in errors.items()},
        refined.converges,
    )


def error_of(own: float, half: float, quarter: float, motion: float | None) -> float:
    """Error of a value from those at half and at a quarter of the step; ``motion`` is the ratio of both
    differences of the positions.

    The distance from h/4, and what h/4 misses: the differences from halving to halving continue as a
    geometric series. Its ratio is that of the two differences of the value, SLOWEST at the most, and that of
    the motion at the least, which counts between that of the second order and that of the first (the second
    where there is only rounding). For a regular value the second difference alone would do; it may not be
    smaller than the first lets expect. Largest values are met between steps and converge unevenly: hence
    SAFETY.
    """
    first, second, both = abs(own - half), abs(half - quarter), abs(own - quarter)
    least = min(max(SECOND_ORDER if motion is None else motion, SECOND_ORDER), FIRST_ORDER)
    ratio = min(max(second / first if first > 0.0 else SLOWEST, least), SLOWEST)
    return SAFETY * max(first / (1.0 - least), both + second * ratio / (1.0 - ratio))


def values_of(part: Record, run: Record) -> dict[str, float]:
    """The measures of a ``run``, taken of the last outputs of it or of its repetition at another step."""
    said, outputs = counted(run), outputs_of_a_turn(run.assembly)
    if said is None or outputs is None or not said.several:
        return measures(part)
    count = said.last - said.first + 1
    rows = slice(len(part.steps) - count * outputs - 1, None)
    part = dataclasses.replace(part, steps=part.steps[rows], source=part.rows[rows], companions=None)
    lanes = [[_of_a_turn(one, None, None) for one in each_turn(part, 1, count)]]
    return {name: one.value for name, one in over_turns(lanes, (1.0,), together=False).items()}


def followed(
    record: Record, found: Mapping[str, Measured], earlier: Mapping[str, tuple[float, float]]
) -> bool:
    """Whether every largest value lies within its earlier range, widened by its own width and by the
    tolerance of its size.
    """
    sizes_now, tolerance = (
        sizes(found, record.assembly.choice.step),
        record.assembly.mechanism.settings.tolerance,
    )
    several = len(set(step_ratios(record))) > 1
    for name, (low, high) in earlier.items():
        room = tolerance * sizes_now.get(name, math.inf) + (high - low if several else 0.0)
        if name in sizes_now and not low - room <= found[name] <= high + room:
            return False
    return True


def sizes(found: Mapping[str, Measured], step: float) -> dict[str, float]:
    """The size of each largest value of a turn, by name: the largest of its range, or a tenth of the largest
    of its kind where it is less.

    What never touches has none, nor has what is rounding: moments and forces beside the largest of both (N m,
    N), and second differences of an angle with a ``step`` (s).
    """
    result = {}
    loads = max((one.high for name, one in found.items() if name.endswith(LOADS)), default=0.0)
    noise = dict.fromkeys(LOADS, NOISE * loads) | {".angular_acceleration.max": ROUNDING / (step * step)}
    for kind in JUDGED:
        members = [(name, one) for name, one in found.items() if name.endswith(f".{kind}")]
        floor = LEAST * max((one.high for _, one in members), default=0.0)
        result.update(
            {name: max(one.high, floor) for name, one in members if one.high > noise.get(f".{kind}", 0.0)}
        )
    return result


def spreads(found: Mapping[str, Measured], step: float) -> dict[str, float]:
    """Width of the range of each largest value of a turn over its size (1), by name."""
    return {
        name: (found[name].high - max(found[name].low, 0.0)) / size
        for name, size in sizes(found, step).items()
    }


def band(record: Record, series: Callable[[Record], Array]) -> tuple[Array, Array] | None:
    """Lowest and highest of a series over run and companions at the outputs of the last turn and the one
    before, each of the series' shape.
    """
    found = record.companions
    if found is None:
        return None
    own = series(record)[np.isin(record.steps, found.steps)]
    every = np.stack([own, *(series(one)[-len(own) :] for one in companion_records(record))])
    return every.min(axis=0), every.max(axis=0)


HALVINGS = 2  # of an automatic step for companions that lie apart, at the most
SMOOTH_HALVINGS = 3  # of one of a smooth run for errors that are too large
DEEP_HALVINGS = (
    3,
    4,
    # of one for first contacts that land too deep: from the step of a run without companions, and from that
    # of
    # one with them
)
# Of one for an energy ledger that stays open, or a motion that is not periodic: of a run without companions,
# and of one with
# them, which begins with twice the step.
OPEN_HALVINGS = 2, 1
OPEN = 1e-3  # of the largest energy: a ledger that is open by more is not to be trusted


@dataclass(frozen=True)
class Trust:
    """What companions, or a run at half the step, say of a run.

    ``measure`` is known worst: its values at all step sizes lie ``apart`` by that share of its size (1), and
    the range that estimates its error is from ``low`` to ``high``. ``parting`` is where they part, ``lost``
    how many of the ``companions`` have infinite numbers. Of a smooth or static run, which has none, ``apart``
    is the estimated error; ``order`` is that of the step, and ``converges`` is False where runs at smaller
    steps do not come together.
    """

    companions: int
    measure: str
    apart: float
    low: float
    high: float
    parting: Parting | None
    lost: int
    order: float | None = None
    converges: bool = True

    @property
    def sensitive(self) -> bool:
        """Whether the motion is decided by the steps."""
        return self.apart > SENSITIVE or not self.converges


def trust(record: Record, found: dict[str, Measured] | None = None) -> Trust | None:
    """What companions or an estimate say of a run, None without any; ``found`` are its measures where they
    are known already.
    """
    left, said = record.companions, record.estimate
    if left is None and said is None:
        return None
    found = ranged(record, every=PEAKS) if found is None else found
    seen = found if left is None else over_tries(record, every=PEAKS)
    widths = static_spreads(record, found) if record.static else spreads(seen, record.assembly.choice.step)
    name, apart = max(widths.items(), key=lambda item: item[1], default=("", 0.0))
    low, high = (found[name].low, found[name].high) if name else (0.0, 0.0)
    if left is None:
        return Trust(
            0,
            name,
            0.5 * apart,
            low,
            high,
            None,
            0,
            None if said is None else said.order,
            said is None or said.converges,
        )
    return Trust(len(left.counts), name, 1.0 if left.lost else apart, low, high, left.parting, len(left.lost))


def finer(record: Record) -> tuple[tuple[float, float | None], ...] | None:
    """What was tried of an automatic step so far, this run's with it, where half of it should be tried next;
    None where it will do, or has to.
    """
    choice = record.assembly.choice
    if not choice.automatic or record.status not in (Status.COMPLETE, Status.DIVERGED, Status.ENERGY):
        return None
    said = trust(record)
    diverged = record.status == Status.DIVERGED
    apart = 0.0 if said is None else 1.0 if diverged or not said.converges else said.apart
    accompanied = record.companions is not None
    open_halvings = OPEN_HALVINGS[accompanied]
    most = open_halvings if not_periodic(record) else HALVINGS if accompanied else SMOOTH_HALVINGS
    if (
        apart > record.assembly.mechanism.settings.tolerance
        and sum(one is not None for _, one in choice.tried) < most
    ):
        return (*choice.tried, (choice.step, apart))
    if diverged:
        return None
    stopped = record.status == Status.ENERGY
    closes = len(choice.tried) < open_halvings and not own_floor(record)
    unlike = (record.companions is not None or stopped) and closes and ledger(record).error > OPEN
    if unlike or (too_deep(record) and len(choice.tried) < DEEP_HALVINGS[said is not None]):
        return (*choice.tried, (choice.step, None))
    return None


def not_periodic(record: Record) -> bool:
    """Whether means over turns are told: no step brings companions of such a motion together, and theirs
    differ by chance.
    """
    said = turns(record)
    return said is not None and said.motion == "not periodic"


def too_deep(record: Record) -> bool:
    """Whether a first contact landed deeper than its joint allows."""
    return record.final is not None and bool(np.any(record.final[record.assembly.layout["contact_deep"]]))
