"""Errors of the measures of a smooth run, which is repeated at half and at a quarter of its step."""

from __future__ import annotations

from ..assembly.input_functions import input_functions, peak_error
from ..solvers.record import Estimate, Record
from ..solvers.refinement import Refined
from ..solvers.repeating import turn_grid
from .catalogue import measures
from .error_ranges import evaluated_turns, of_a_turn, over_turns, sizes, window
from .extrapolation import SAFETY
from .output_intervals import with_intervals
from .turns import each_turn
from .values import Measured
from .zero_limits import scales_of_run

# Ratio of a difference to the one before it, from one halving of the step to the next: of first and second
# order, and the largest that is believed, which is an order of 0.4.
FIRST_ORDER, SECOND_ORDER = 0.5, 0.25
SLOWEST = 0.75
# Share of the largest relative error below which none is taken to be: two runs may agree by chance.
FLOOR = 0.1
PLACES = (".place",)  # measures that jump from node to node, whose differences are no errors


def estimate(record: Record, refined: Refined) -> Estimate:
    """Return the errors of all measures of a smooth run, from the same measures at half and a quarter of its
    step (:func:`error_of`).

    Two runs may agree on a measure by chance. Therefore no relative error is taken to be smaller than FLOOR
    times the largest relative error of the largest values. All steps may miss the peak of a prescribed force
    with a corner, which is added to the errors of largest values.
    """
    full, half, quarter = (values_of(part, record) for part in (record, refined.half, refined.quarter))
    names = [name for name in full if not name.endswith(PLACES) and name in half and name in quarter]
    errors = {name: error_of(full[name], half[name], quarter[name], refined.ratio) for name in names}
    run_sizes = {name: Measured(value, value - errors.get(name, 0.0), value) for name, value in full.items()}
    size = sizes(run_sizes, record.assembly.choice.step, scales_of_run(record))
    floor = FLOOR * max((errors[name] / size[name] for name in errors if name in size), default=0.0)
    errors = {name: max(error, floor * size.get(name, abs(full[name]))) for name, error in errors.items()}
    peak = peak_errors(record)
    errors = {name: error + peak * size.get(name, 0.0) for name, error in errors.items()}
    return Estimate(refined.order, with_intervals(errors, record, window(record)), refined.converges)


def peak_errors(record: Record) -> float:
    """Return by how much the steps of a run may miss the peak of a force over time, as a share of it."""
    mechanism, step = record.assembly.mechanism, record.assembly.choice.step
    length = step * record.assembly.choice.steps
    functions = input_functions(mechanism, length, 0.0, lambda: 1.0)
    return max((peak_error(function, step) for function in functions), default=0.0)


def error_of(value: float, half: float, quarter: float, motion: float | None) -> float:
    """Return the error of a value from those at half and at a quarter of the step; ``motion`` is the ratio of
    both differences of the positions.

    The distance from h/4, and what h/4 misses: the differences from halving to halving continue as a
    geometric series. Its ratio is that of the two differences of the value, SLOWEST at the most, and that of
    the motion at the least, which counts between that of the second order and that of the first (the second
    where there is only rounding). For a regular value the second difference alone would do; it may not be
    smaller than the first lets expect. Largest values are met between steps and converge unevenly: hence
    SAFETY.
    """
    # The ratio of a single value's differences may be small by chance; that of the positions is taken over
    # all of them and is not. So the latter bounds it from below.
    first, second, total = abs(value - half), abs(half - quarter), abs(value - quarter)
    lowest_ratio = min(max(SECOND_ORDER if motion is None else motion, SECOND_ORDER), FIRST_ORDER)
    ratio = min(max(second / first if first > 0.0 else SLOWEST, lowest_ratio), SLOWEST)
    return SAFETY * max(first / (1.0 - lowest_ratio), total + second * ratio / (1.0 - ratio))


def values_of(part: Record, run: Record) -> dict[str, float]:
    """Return the measures of a ``run`` from its last outputs, or from those of its repetition at another
    step.
    """
    motion, grid = evaluated_turns(run), turn_grid(run.assembly)
    if motion is None or grid is None or not motion.has_several:
        return measures(part)
    # The outputs of a repetition are the last ones of the run; ``missing`` others come before them.
    missing = len(run.steps) - len(part.steps)
    lanes = [[of_a_turn(turn, None, None) for turn in each_turn(part, motion.first, motion.last, missing)]]
    return {name: sample.value for name, sample in over_turns(lanes, (1.0,), all_lanes=False).items()}
