"""Measures with ranges that estimate their numerical errors.

Companions repeat a run with about 1.4, 1.7 and 2 times its step. The change of a measure with the step gives
the range that contains its limit for vanishing steps. A smooth run is repeated at half and at a quarter of
its step instead, after it has ended (:mod:`~vfife.measures.smooth_errors`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..solvers.companions import SENSITIVE, oldest_needed
from ..solvers.record import Record
from ..solvers.repeating import turn_grid
from ..solvers.scales import NEGLIGIBLE, Scales
from ..solvers.status import Status
from .catalogue import INFLUENCE, PEAKS, Groups, compared, lip, measures, over_run, over_turn, unit_of
from .contacts import pressure_bounds
from .energy import unstable_companions
from .event_ranges import event_errors, friction_losses, widened
from .extrapolation import SCATTER, SCATTER_OF_TRIES, VANISHING, error_of_mean, widen
from .output_intervals import cut_errors
from .repetition import Turns, part_of, turns
from .samples import Samples
from .statics import EXACT
from .turns import after_first, companion_turns_of, each_turn, last_turn, of_window, record_of_companion
from .values import Measured, Measures
from .zero_limits import scales_of_run, zero_limits

Array = NDArray[np.float64]
Choice: TypeAlias = Groups | None  # some measures of a turn, or all

# Largest values of a turn, by which step sizes are judged.
JUDGED = ("force.max", "moment.max", "penetration.max", "angular_acceleration.max", "torque.max")
LOADS = (".force.max", ".moment.max", ".torque.max")
# Share of the largest load that rounding leaves of one that is zero, and rounding of an angle (rad).
NOISE = 1e-9
ROUNDING = 16.0 * 2.2e-16
# The share of time of the first steps of contacts is their number times the step, and its limit is zero.
FIRST_STEPS = ".share.impact"
# Largest angular acceleration that vanishes with the step, with its error, over what the step leaves in a
# body that turns evenly; a rod about its end has 0.25, and an error of 0.31.
REMAINDER = 2.5
GROUND = "ground."  # measures at outputs, whose own estimates hold where they are rounding
# A force that is the same at seven steps, up to the share RESOLVED, does not scatter by chance. Where a
# coarser step made it BLOW_UP times as large, that step was not stable.
RESOLVED, BLOW_UP = 1e-3, 10.0
# Values below this share of the largest of their kind are compared with that share, so that an idle joint
# makes no run sensitive.
LEAST_SHARE = 0.1
LEAST_CHANGE = -100.0  # per cent: of a largest value that vanishes


def companion_records(record: Record) -> Iterator[Record]:
    """Yield the last turn of each companion with finite values."""
    for k in sound_companions(record):
        yield record_of_companion(record, k)


def sound_companions(record: Record) -> list[int]:
    """Return the numbers of the companions with finite numbers that have not blown up."""
    companions, omissions = record.companions, unstable_companions(record)
    return [] if companions is None else [k for k in range(len(companions.counts)) if k not in omissions]


def ranged(record: Record, reference: Mapping[str, float] | None = None, groups: Choice = None) -> Measures:
    """Return the measures of a run (:func:`~vfife.measures.catalogue.measures`) with uncertainty and scatter:
    means over turns after the transient, see :func:`samples`.

    Ranges estimate the error of the step from the values at all step sizes. If the range of a try with twice
    the step does not contain the present value, its estimate has failed, and the range covers both tries.
    Ranges also cover the largest values after run and companions diverge (:func:`peaks_after_parting`). A
    smooth run has its estimated error to both sides. A quantity that is about zero
    (:func:`~vfife.measures.zero_limits.about_zero`) lies between zero and the limit below which it is called
    that. The range of a loss by friction does not begin below zero
    (:func:`~vfife.measures.event_ranges.friction_losses`).
    """
    open_ones = {f"{name}.max" for name in record.assembly.shared}
    by_name, joins = samples(record, reference, groups), contradiction(record)
    later = peaks_after_parting(record)
    extremes = {name: max(abs(sample.low), abs(sample.high)) for name, sample in by_name.items()}
    limits = {} if record.static else zero_limits(record, extremes)
    has_several_steps = len(set(step_ratios(record))) > 1
    events = event_errors(record, by_name) if has_several_steps else {}
    normal_parts = {} if record.static else pressure_bounds(*of_window(record, last_turn(record)))
    friction = friction_losses(record)
    tries, cuts = sensitive_tries(record), cut_errors(record, evaluated_turns(record), groups)
    ranges = Measures()
    for name, sample in by_name.items():
        # Four sources widen a range, in this order: the values at all step sizes, the largest values after a
        # divergence (only upwards: the value itself is from before it), a failed try, and, where the steps
        # decide the motion, all tries.
        low, high = _reach(record, name, sample)
        if name in later:
            high = max(high, later[name].error_range(name)[1])
        if name in joins:
            joined_low, joined_high = min(sample.low, joins[name][0]), max(sample.high, joins[name][1])
            wide = widen(name, joined_low, joined_high, SCATTER * (joined_high - joined_low))
            low, high = min(low, wide[0]), max(high, wide[1])
        if name in tries and not name.endswith(VANISHING):
            low, high = over_scatter(name, sample, (low, high), tries[name])
        if name in events:
            low, high = widened(name, sample, (low, high), events[name])
        if cuts.get(name):  # of a turn that begins or ends between two outputs
            low, high = widen(name, low, high, cuts[name])
        if name in normal_parts:  # the friction in the largest force is estimated where no output meets it
            lower, upper = normal_parts[name]
            low, high = min(low, lower * sample.value), max(high, upper * sample.value)
        estimated = _estimated(record, name, sample)
        if estimated and name in limits and not name.startswith(GROUND):
            low, high = (0.0 if name.endswith(".max") else -limits[name]), limits[name]
        if estimated and name.endswith(FIRST_STEPS):
            low = 0.0
        if name in friction:
            low = max(low, min(0.0, sample.low))
        unique = name not in open_ones
        ranges[name] = Measured(sample.value, low, high, unique, sample.lowest, sample.highest, estimated)
        ranges[name].unit = unit_of(name)
    widen_influences(ranges, reference or {})
    ranges.part = part_of(record, evaluated_turns(record))
    return ranges


def widen_influences(ranges: Measures, ideal: Mapping[str, float]) -> None:
    """Widen the ranges of local influence parameters to those of the largest values that they compare with
    the ``ideal`` ones; that of a value without an estimate has none.

    The changes with the step of a curve and of its ideal one nearly cancel in their difference, and what an
    output or an event adds to the error of the curve does not. A largest value is not negative, so that no
    change is below -100 %.
    """
    for name, measure in ranges.items():
        largest_name = name.removesuffix(".lip") + ".max"
        if not name.endswith(INFLUENCE) or not ideal.get(largest_name) or largest_name not in ranges:
            continue
        peak = ranges[largest_name]
        measure.estimated = measure.estimated and peak.estimated
        if measure.estimated:
            lowest = min(measure.low, lip(peak.low, ideal[largest_name]))
            measure.low = max(lowest, LEAST_CHANGE)
            measure.high = max(measure.high, lip(peak.high, ideal[largest_name]))
        else:
            measure.low = measure.high = measure.value


def contradiction(record: Record) -> Mapping[str, tuple[float, float]]:
    """Return the ranges of the try with twice the step if they do not contain the present values; else
    nothing.
    """
    earlier = {} if record.companions is None else record.companions.earlier
    return {} if not earlier or followed(record, own_ranges(record, groups=PEAKS), earlier) else earlier


def peaks_after_parting(record: Record) -> dict[str, Samples]:
    """Return the largest values after run and companions diverge within their last turn, at all step sizes;
    nothing if they do not, or if measures are means over several turns.

    Before they diverge all lanes have the same motion, and so the same largest value, which tells nothing
    about later ones: there the motion depends on the steps, and its largest values scatter.
    """
    companions, motion = record.companions, evaluated_turns(record)
    if companions is None or companions.parting is None or (motion is not None and motion.has_several):
        return {}
    begin = companions.parting.time * (1.0 - 1e-9)
    lanes = [
        (lane, last_turn(lane) & (lane.steps * lane.assembly.choice.step >= begin))
        for lane in (record, *companion_records(record))
    ]
    if not all(window.any() for _, window in lanes):  # outputs of a damaged file are missing
        return {}
    peaks, *companion_peaks = (over_turn(lane, window, PEAKS) for lane, window in lanes)
    return joined(peaks, companion_peaks, step_ratios(record))


def over_tries(
    record: Record, reference: Mapping[str, float] | None = None, groups: Choice = None
) -> dict[str, Measured]:
    """Return the measures with the ranges of their values at all step sizes: of the run, its companions and,
    if its estimate has failed, the try before.
    """
    ranges, joins = own_ranges(record, reference, groups), contradiction(record)
    for name in joins.keys() & ranges.keys():
        old, (low, high) = ranges[name], joins[name]
        ranges[name] = Measured(old, min(old.low, low), max(old.high, high), True, old.lowest, old.highest)
    return ranges


def _reach(record: Record, name: str, sample: Samples) -> tuple[float, float]:
    """Return low and high from the values at several step sizes, or from the estimated error of a
    smooth run and that of sampling.
    """
    if record.estimate is None:
        return sample.error_range(name)
    error = record.estimate.errors.get(name, 0.0) + sample.mean_error
    return widen(name, sample.value, sample.value, error)


def step_hulls(record: Record, ranges: Mapping[str, Measured]) -> dict[str, Measured]:
    """Return measures with the ranges of their values at all steps and tries or, of a run with an estimate,
    within their estimated errors, without the errors of sampling that ``ranges`` contain.
    """
    if record.estimate is None:
        return over_tries(record, groups=PEAKS)
    errors = record.estimate.errors
    return {
        name: Measured(value, *widen(name, value, value, errors.get(name, 0.0)))
        for name, value in ranges.items()
    }


def _estimated(record: Record, name: str, sample: Samples) -> bool:
    """Return whether the error of a measure is estimated, by companions or by a repetition with finer steps
    or mesh.
    """
    if record.static and name in EXACT:
        return True
    return len(sample.values) > 1 if record.estimate is None else name in record.estimate.errors


def step_ratios(record: Record) -> tuple[float, ...]:
    """Return the step sizes of a run and its sound companions over that of the run; in version 0.2 all were
    equal.
    """
    companions, interval = record.companions, record.assembly.choice.outputs_every
    return (
        (1.0,)
        if companions is None
        else (1.0, *(interval / int(companions.counts[k]) for k in sound_companions(record)))
    )


def own_ranges(
    record: Record, reference: Mapping[str, float] | None = None, groups: Choice = None
) -> dict[str, Measured]:
    """Return the measures with the ranges of their values over the run and its companions, without earlier
    tries.
    """
    return {name: sample.hull for name, sample in samples(record, reference, groups).items()}


def ranges_of_next_try(
    record: Record, reference: Mapping[str, float] | None
) -> tuple[dict[str, tuple[float, float]], dict[str, tuple[float, float]]]:
    """Return the ranges (low, high) of a run that is abandoned for half its step, and those of all tries with
    it; nothing of one whose step was not stable.
    """
    former = {} if record.companions is None else record.companions.tries
    if record.status == Status.DIVERGED or unstable_companions(record):
        return {}, dict(former)  # its own values may have grown with those that are lost
    by_name = samples(record, reference)
    last = {name: (sample.low, sample.high) for name, sample in by_name.items()}
    draws = {name: sample.draws(name) for name, sample in by_name.items()}
    tries = {
        name: (min(low, former.get(name, (low, high))[0]), max(high, former.get(name, (low, high))[1]))
        for name, (low, high) in draws.items()
    }
    return last, tries


def samples(
    record: Record, reference: Mapping[str, float] | None = None, groups: Choice = None
) -> dict[str, Samples]:
    """Return the measures at all step sizes.

    If turns repeat: means over the turns since then, with their extremes, for each lane. If the motion is not
    periodic: means over the turns of all lanes. If there are few turns, or they have not settled: the last
    turn. Counts are those of the whole run. ``groups``: some groups of measures of a turn only.
    """
    motion, ratios = evaluated_turns(record), step_ratios(record)
    if motion is None or not motion.has_several:
        return joined(
            measures(record, reference, groups),
            [measures(lane, reference, groups) for lane in companion_records(record)],
            ratios,
        )
    companion_turns = (
        companion_turns_of(record, k, motion.first, motion.last) for k in sound_companions(record)
    )
    lanes = [each_turn(record, motion.first, motion.last), *companion_turns]
    values = [[of_a_turn(turn, reference, groups) for turn in lane] for lane in lanes]
    counts = joined(over_run(record), [over_run(lane) for lane in companion_records(record)], ratios)
    is_chaotic = motion.motion == "not repeating"
    return over_turns(values, ratios, all_lanes=not motion.repeats, chaotic=is_chaotic) | counts


def evaluated_turns(record: Record) -> Turns | None:
    """Return the classification of the turns; of the last turn only, if earlier turns of companions are not
    stored.
    """
    motion = turns(record)
    if motion is not None and record.companions is not None and len(record.companions.turns) < motion.last:
        return dataclasses.replace(motion, first=motion.last)
    return motion


def of_a_turn(record: Record, reference: Mapping[str, float] | None, groups: Choice) -> dict[str, float]:
    """Return the measures of the last turn of a record, with those compared with the ideal ``reference``."""
    values = over_turn(record, after_first(record), groups)
    return values | compared(record, values, reference)


def joined(
    values: Mapping[str, float], companion_values: Sequence[Mapping[str, float]], ratios: Sequence[float]
) -> dict[str, Samples]:
    """Return the measures of a run and its companions with step ``ratios``, those of the run first."""
    by_name = {}
    lanes = (values, *companion_values)
    for name, value in values.items():
        pairs = [(ratio, lane[name]) for ratio, lane in zip(ratios, lanes, strict=True) if name in lane]
        by_name[name] = Samples(
            value, tuple(number for _, number in pairs), tuple(ratio for ratio, _ in pairs), value, value
        )
    return by_name


def over_turns(
    lanes: Sequence[Sequence[Mapping[str, float]]],
    ratios: Sequence[float],
    *,
    all_lanes: bool,
    chaotic: bool = False,
) -> dict[str, Samples]:
    """Return measures from those of the turns of each lane, the run first: means over its turns, or with
    ``all_lanes`` over the turns of all. Only turns of a ``chaotic`` motion have an error of sampling.
    """
    by_name = {}
    for name in lanes[0][-1]:
        turnly = [[turn[name] for turn in lane if name in turn] for lane in lanes]
        pairs = [
            (ratio, math.fsum(lane) / len(lane)) for ratio, lane in zip(ratios, turnly, strict=True) if lane
        ]
        means = tuple(mean for _, mean in pairs)
        turn_values = [value for lane in (turnly if all_lanes else turnly[:1]) for value in lane]
        value = math.fsum(means) / len(means) if all_lanes else means[0]
        by_name[name] = Samples(
            value, means, tuple(ratio for ratio, _ in pairs), min(turn_values), max(turn_values), all_lanes,
            error_of_mean([lane for lane in turnly if lane]) if chaotic else 0.0,
        )  # fmt: skip
    return by_name


def window(record: Record) -> int:
    """Return the step of the output from which the measures of a run need its outputs: the one before their
    first turn.
    """
    motion, grid = evaluated_turns(record), turn_grid(record.assembly)
    if motion is None or grid is None:
        return oldest_needed(record.assembly, int(record.steps[-1]))
    output = grid.end(motion.first - 1)
    return int(record.steps[output if grid.has_integral_turns else max(0, output - 1)])


def followed(
    record: Record, ranges: Mapping[str, Measured], earlier: Mapping[str, tuple[float, float]]
) -> bool:
    """Return whether every largest value lies within its earlier range, widened by its own width and by the
    tolerance of its size.
    """
    sizes_now = sizes(ranges, record.assembly.choice.step, scales_of_run(record))
    tolerance = record.assembly.mechanism.settings.tolerance
    has_several_steps = len(set(step_ratios(record))) > 1
    for name, (low, high) in earlier.items():
        room = tolerance * sizes_now.get(name, math.inf) + (high - low if has_several_steps else 0.0)
        if name in sizes_now and not low - room <= ranges[name] <= high + room:
            return False
    return True


def sizes(ranges: Mapping[str, Measured], step: float, scale: Scales | None = None) -> dict[str, float]:
    """Return the size of each largest value of a turn, by name: its upper limit, or a tenth of the largest of
    its kind if that is larger.

    A contact that never touches has no size, and neither have rounding errors: of moments and forces compared
    with the largest of both (N m, N), and of second differences of an angle with a ``step`` (s). Quantities
    that are about zero on the ``scale`` of the mechanism have none either, and neither have angular
    accelerations that vanish with the step.
    """
    result = {}
    loads = max((measured.high for name, measured in ranges.items() if name.endswith(LOADS)), default=0.0)
    noise = dict.fromkeys(LOADS, NOISE * loads) | {".angular_acceleration.max": ROUNDING / (step * step)}
    for kind in JUDGED:
        members = [(name, measured) for name, measured in ranges.items() if name.endswith(f".{kind}")]
        floor = LEAST_SHARE * max((measured.high for _, measured in members), default=0.0)
        limit = noise.get(f".{kind}", 0.0)
        for name, entry in members:
            negligible = 0.0 if scale is None else NEGLIGIBLE * scale.of(name)
            if scale is not None and kind == "angular_acceleration.max" and entry.low <= 0.0:
                negligible = max(negligible, REMAINDER * scale.remainder)
            if entry.high > max(limit, negligible):
                result[name] = max(entry.high, floor)
    return result


def spreads(ranges: Mapping[str, Measured], step: float, scale: Scales | None = None) -> dict[str, float]:
    """Return the width of the range of each largest value of a turn over its size (1), by name."""
    return {
        name: (ranges[name].high - max(ranges[name].low, 0.0)) / size
        for name, size in sizes(ranges, step, scale).items()
    }


def spreads_after_parting(record: Record, hulls: Mapping[str, Measured]) -> dict[str, float]:
    """Return how much the largest values after a divergence
    (:func:`~vfife.measures.error_ranges.peaks_after_parting`) differ, over their size (1), where their range
    exceeds the largest value of all (``hulls``).
    """
    size = sizes(hulls, record.assembly.choice.step, scales_of_run(record))
    return {
        name: (later.high - later.low) / size[name]
        for name, later in peaks_after_parting(record).items()
        if name in size and later.error_range(name)[1] > hulls[name].high
    }


def later_spread(record: Record, hulls: Mapping[str, Measured], peak: tuple[str, float]) -> tuple[str, float]:
    """Return the measure whose largest values after a divergence differ most (:func:`spreads_after_parting`)
    and by how much, if that is sensitive, else that of the whole run, ``peak``.
    """
    name, spread = largest(spreads_after_parting(record, hulls))
    return (name, spread) if spread > SENSITIVE else peak


def largest(spreads: Mapping[str, float]) -> tuple[str, float]:
    """Return the measure of the largest spread, and that (1)."""
    return max(spreads.items(), key=lambda item: item[1], default=("", 0.0))


def sensitive_tries(record: Record) -> Mapping[str, tuple[float, float]]:
    """Return the ranges of all tries with larger steps if the steps decide the motion, else nothing.

    Values at all of these steps are then draws from the same scatter, and four of them may agree by chance.
    Of tries that blew up (:func:`tries_blew_up`) only the last one remains.
    """
    companions = record.companions
    if companions is None or not companions.tries:
        return {}
    hulls = over_tries(record, groups=PEAKS)
    worst = largest(spreads(hulls, record.assembly.choice.step, scales_of_run(record)))
    _, spread = worst if worst[1] > SENSITIVE else later_spread(record, hulls, worst)
    if spread <= SENSITIVE and not unstable_companions(record):
        return {}
    return companions.earlier if tries_blew_up(record, hulls) else companions.tries


def tries_blew_up(record: Record, ranges: Mapping[str, Measured] | None = None) -> bool:
    """Return whether a step before the last try was not stable, although nothing diverged: the largest force
    of a joint is the same in the run, its companions and the last try, up to :data:`RESOLVED`, and exceeded
    :data:`BLOW_UP` times this in a try before. ``ranges`` are those of :func:`over_tries`.
    """
    companions = record.companions
    if companions is None or not companions.tries or not companions.earlier:
        return False
    ranges = over_tries(record, groups=PEAKS) if ranges is None else ranges
    for name in companions.tries.keys() & companions.earlier.keys() & ranges.keys():
        (low, high), present = companions.earlier[name], ranges[name]
        low, high = min(low, present.low), max(high, present.high)
        resolved = name.endswith(".force.max") and high - low <= RESOLVED * high
        if resolved and companions.tries[name][1] > BLOW_UP * high > 0.0:
            return True
    return False


def over_scatter(
    name: str, sample: Samples, bounds: tuple[float, float], tried: tuple[float, float]
) -> tuple[float, float]:
    """Return a range of a sensitive run that covers its values at the steps ``tried`` too, and what so many
    values miss.
    """
    low, high = min(sample.low, tried[0]), max(sample.high, tried[1])
    # Tries of a motion that is not periodic include the means of other runs already.
    wide = widen(name, low, high, 0.0 if sample.mean_error else SCATTER_OF_TRIES * (high - low))
    return min(bounds[0], wide[0]), max(bounds[1], wide[1])


def band(record: Record, series: Callable[[Record], Array]) -> tuple[Array, Array] | None:
    """Return the extremes of a series over run and companions at the outputs of the last two turns, each of
    the shape of the series.
    """
    companions = record.companions
    if companions is None:
        return None
    values = series(record)[np.isin(record.steps, companions.steps)]
    stacked = np.stack([values, *(series(lane)[-len(values) :] for lane in companion_records(record))])
    return stacked.min(axis=0), stacked.max(axis=0)
