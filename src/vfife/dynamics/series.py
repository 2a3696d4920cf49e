"""The series that a map records: their choice, their values once a turn, and their ranges."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError, suggestion
from ..measures.chaos import Exponent, Verdict, verdict
from ..modelfile import loads
from ..results.run_data import RunData, standing
from ..simulation.turn_steps import with_steps
from ..solvers.record import Record
from ..solvers.tangents import steps_of_turn
from ..solvers.turn_runner import TurnRunner

Array = NDArray[np.float64]
# Turns, and outputs of each turn, that are simulated to find out which series vary.
PROBE_TURNS, PROBE_OUTPUTS = 2, 36
# A series varies if its range exceeds this share of the largest value of its kind. It is far above rounding,
# so that the choice is the same on every machine.
VARIATION = 1e-6
# Ending of the names of series that record the largest value since the record before.
PEAK = "_max"
# Series of a body, grouped by unit. Places distinguish potential wells; speeds do not where the body rests.
MOTIONS = (("angular_velocity",), ("x", "y"))


def chosen_series(
    first: Assembly, series: Sequence[str], defaults: Callable[[Assembly], tuple[str, ...]] | None = None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return ``series``, or the ``defaults`` of the assembly if it is empty, and their units.

    Raises ModelError for an unknown name.
    """
    series, start = tuple(series) or (defaults or default_series)(first), standing(first)
    message, remedy = "the mechanism has none of this name", "name one that it has"
    refuse_unknown("series", series, list(start.series), message, remedy, first)
    return series, tuple(start.series.column(name).unit for name in series)


def refuse_unknown(
    argument: str, names: Sequence[str], choices: Sequence[str], message: str, otherwise: str, model: Assembly
) -> None:
    """Raise ModelError with a fault of the ``argument`` for each of ``names`` that is not among ``choices``,
    with the names of its body or joint, the most similar name or the remedy ``otherwise``.
    """
    wrong = []
    for name in (name for name in names if name not in choices):
        part = f"{str(name).partition('.')[0]}."
        of_part = ", ".join(choice for choice in choices if choice.startswith(part))
        remedy = f"name one of {of_part}" if of_part else suggestion(name, choices, otherwise)
        wrong.append(Fault(argument, message, name, "", remedy))
    if wrong:
        raise ModelError(wrong, model.mechanism.name)


def default_series(assembly: Assembly) -> tuple[str, ...]:
    """Choose series that vary in the first turns of a motion.

    The choice is the penetration and the largest force of the first contact in which both vary. Without such
    a contact it is the angular velocity of the last body; if that is constant, the place or speed with the
    largest range, as a share of the largest value of its kind. Bodies turned by a driver count only if
    nothing else varies.
    """
    bodies, series = list(assembly.bodies), set(standing(assembly).series)
    contacts = zip(assembly.contacts, assembly.contact_joints, strict=True)
    pairs = [(f"{contact}.penetration", f"{joint}.force_max") for contact, joint in contacts]
    journals = [pair for pair in pairs if series.issuperset(pair)]
    kinds = [
        [name for body in bodies for quantity in kind if (name := f"{body}.{quantity}") in series]
        for kind in MOTIONS
    ]
    ranges = variations(assembly, [*((name,) for pair in journals for name in pair), *kinds])
    for pair in journals:
        if all(ranges[name] > VARIATION for name in pair):
            return pair
    last = f"{bodies[-1]}.angular_velocity"
    if ranges.get(last, 0.0) > VARIATION:
        return (last,)
    moving = [name for kind in kinds for name in kind if ranges[name] > VARIATION]
    free = [name for name in moving if name.rpartition(".")[0] not in assembly.mechanism.drivers]
    return (max(free or moving, key=ranges.__getitem__, default=last),)


def variations(assembly: Assembly, kinds: Iterable[Sequence[str]]) -> dict[str, float]:
    """Return the range of each series in the first turns, as a share of the largest absolute value of its
    kind; 0 if it is not finite.
    """
    kinds = [list(kind) for kind in kinds]
    names = [name for kind in kinds for name in kind]
    values = dict(zip(names, first_turns(assembly, names).T, strict=True))
    ranges = {}
    for kind in kinds:
        size = max((float(np.abs(values[name]).max()) for name in kind), default=0.0)
        for name in kind:
            share = float(np.ptp(values[name])) / size if size > 0.0 else 0.0
            ranges[name] = share if np.isfinite(share) else 0.0
    return ranges


def motion_ranges(spec: Any, points: Array) -> Array:
    """Return the size of each series of a map in a motion, of which ``points`` are recorded once a turn,
    shape (turns, series): its range in the first turns of the model, or the largest recorded peak.

    A peak is the largest value of a turn, so it is the size of the motion itself, as for the turns of a run.
    The model may have no contact yet in its first turns.
    """
    return with_peaks(_ranges(spec.model, spec.series, spec.steps), spec.series, points)


def classified(spec: Any, points: Array, growth: Exponent | None) -> Verdict:
    """Classify a motion of a map by its ``points``, shape (turns, series), and the exponent of its
    ``growth``.
    """
    return verdict(points, growth, ranges=partial(motion_ranges, spec, points), dropped=spec.dropped)


def with_peaks(ranges: Array, series: Sequence[str], points: Array) -> Array:
    """Return the ranges of ``series``, shape (series,), or, of a peak, the largest of its ``points``, shape
    (turns, series), if that is larger.
    """
    peaks = np.abs(points.reshape(len(points), -1)).max(axis=0, initial=0.0)
    is_peak = np.array([name.endswith(PEAK) for name in series])
    return np.where(is_peak, np.maximum(ranges, peaks), ranges)


@lru_cache(maxsize=4)
def _ranges(model: str, series: tuple[str, ...], steps: int) -> Array:
    assembly = with_steps(loads(model), steps)
    return np.asarray(np.ptp(first_turns(assembly, series), axis=0))


def first_turns(assembly: Assembly, series: Sequence[str]) -> Array:
    """Return series at the outputs of the first turns, shape (outputs, series)."""
    motion, interval = TurnRunner([assembly]), max(1, steps_of_turn(assembly) // PROBE_OUTPUTS)
    motion.runner.advance(1, 1)
    rows = motion.record(interval, PROBE_TURNS * PROBE_OUTPUTS)[:, :, 0]
    return series_values(assembly, motion.row_numbers, rows, series, interval)


def series_values(
    assembly: Assembly, columns: NDArray[np.uint32], rows: Array, series: Sequence[str], steps: int
) -> Array:
    """Return series once a turn of ``steps`` steps, shape (turns, series), from rows of the state, shape
    (turns, rows).
    """
    values = np.zeros((len(rows), len(series)))
    if len(rows):
        view = RunData(Record(assembly, np.arange(1, len(rows) + 1, dtype=np.int64) * steps, rows, columns))
        for j, name in enumerate(series):
            values[:, j] = view.series.column(name).values
    return values
