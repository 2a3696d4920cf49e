"""Runs of a fit: possible place of the first sample in a run, length of runs, and their outputs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..errors import Fault, ModelError, VfifeError
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import loads
from ..units import number
from .measurements import Abscissa, Measured
from .parameters import FitParameter, Numbers, numbers_at
from .starts import PREFIX

Array = NDArray[np.float64]
FREE = "free"
# Outputs of the model for each sample, at least and at most: as many as leave STEPS_AN_OUTPUT steps between
# two.
# Forces between outputs are not smooth. With four outputs a sample, the true numbers of a four-bar left 4.6 %
# of a force with 2 % noise, all of the excess at impacts, and searches ended beside them in points that left
# less; with eight they left 2.1 %, with sixteen 2.0 %.
OUTPUTS_A_SAMPLE, DENSE_OUTPUTS_A_SAMPLE, STEPS_AN_OUTPUT = 4, 16, 8
# In a turn. Those above the first number of each sample are not worth the memory beyond DENSE_OUTPUTS.
MOST_OUTPUTS, DENSE_OUTPUTS, FEWEST_OUTPUTS = 20_000, 8_000, 360
ENVELOPES = 50.0  # default number of windows of an envelope in the data


@dataclass(frozen=True)
class Offset:
    """The place of the first sample in a run: ``low`` to ``high`` (s or rad) after the origin of the
    comparison; ``free``: anywhere in a turn.
    """

    low: float
    high: float
    free: bool = False

    @property
    def fixed(self) -> bool:
        """Whether the offset is known."""
        return self.low == self.high and not self.free


@dataclass(frozen=True)
class RunLength:
    """Length and outputs of runs.

    ``turns`` returns the number of turns of a run from the duration of a turn (s); if it is None, a run has
    the ``duration`` (s). ``outputs`` is their number in a turn, or in a run without turns, with
    ``steps_per_output`` steps between two; ``step`` (s) is the largest step.
    """

    abscissa: Abscissa
    turns: Callable[[float], float] | None
    duration: float
    outputs: int
    steps_per_output: int
    step: float


def refuse_few_samples(records: Sequence[Measured], parameters: Sequence[FitParameter]) -> None:
    """Raise ModelError for fewer than three values for each unknown number."""
    count = sum(len(data.places) * len(data.curves) for data in records)
    unknown = len(parameters) + sum(
        1 + 2 * sum(curve.proportional for curve in data.curves) for data in records
    )
    if count < 3 * unknown:
        message = f"{count} values are too few for {unknown} unknown numbers"
        remedy = "measure more, or identify fewer parameters"
        raise ModelError([Fault("data", message, "", f"{3 * unknown} or more", remedy)], records[0].name)


def offset_of(value: Any, data: Measured, mechanism: Mechanism) -> Offset:
    """Return the offset described by ``value``: "free", a number, or two bounds; None is free for curves over
    time if a crank turns, otherwise 0. Raises ModelError for anything else.
    """
    unit, turn = data.unit, turn_of(mechanism)
    if value is None:
        value = FREE if data.over == "time" and turn is not None else 0.0
    if value == FREE:
        if turn is None:
            fault = Fault(
                "offset",
                "no crank turns, so an offset cannot be free over a turn",
                FREE,
                "two bounds",
                "write 0..10 ms",
            )
            raise ModelError([fault], "fit")
        return Offset(0.0, turn, True)
    if isinstance(value, str) and ".." in value:
        value = tuple(part.strip() for part in value.split(".."))
    ends = tuple(value) if isinstance(value, tuple | list) else (value, value)
    try:
        low, high = (number(end, unit) for end in ends)
    except (VfifeError, ValueError) as error:
        raise ModelError(
            [Fault("offset", str(error), "", f"free, a number or two bounds in {unit}", "")], "fit"
        ) from None
    if low > high:
        raise ModelError(
            [Fault("offset", "the bounds do not ascend", f"{low:g} .. {high:g}", "", "exchange them")], "fit"
        )
    # A crank angle is known up to whole turns, so only a time can lie before the run.
    if data.over == "time" and data.places[0] + low < -1e-9 * data.span:
        message, limit = "the first sample lies before the run begins", f"{-data.places[0]:.4g} s or more"
        raise ModelError([Fault("offset", message, f"{low:.4g} s", limit, "the run begins at 0 s")], "fit")
    return Offset(low, high)


def envelope_width(value: Any, data: Measured) -> float:
    """Return the width of an envelope's window (s or rad).

    Raises ModelError for a width that is not positive or exceeds the length of the data.
    """
    if value is None:
        return data.span / ENVELOPES
    limit = f"above 0 and at most {data.span:.4g} {data.unit}, the length of the data"
    return positive("width", value, data.unit, data.span, limit)


def positive(name: str, value: Any, unit: str, largest: float, limit: str) -> float:
    """Return an argument in its unit. Raises ModelError if it is not positive or exceeds ``largest``."""
    quantity = float(number(value, unit))
    if not 0.0 < quantity <= largest:
        message = "zero or negative" if quantity <= 0.0 else "too large"
        raise ModelError(
            [Fault(name, message, f"{quantity:.4g} {unit}", limit, "correct it, or leave it out")], "fit"
        )
    return quantity


def models_of(mechanism: Mechanism, text: str, parameters: Sequence[FitParameter]) -> list[Mechanism]:
    """Return the model, and the models with each parameter at the middle and at the bounds of its range, as
    far as they can be assembled. Start values do not change the model.
    """
    numbers = [parameter for parameter in parameters if not parameter.paths[0].startswith(PREFIX)]
    probes = (probe(text, numbers_at(numbers, shares)) for shares in middle_and_ends(len(numbers)))
    return [mechanism, *(model for model in probes if model is not None)]


def step_of(step: Any, models: Sequence[Mechanism]) -> float:
    """Return the step (s) of all runs: the given one, or the finest automatic step of the models. Raises
    ModelError.
    """
    if step in (None, "auto"):
        return float(min(assemble(model).choice.step for model in models))
    return positive("step", step, "s", math.inf, "above 0 s")


def run_length_of(
    models: Sequence[Mechanism], data: Measured, offset: Offset, skip: float, step: float
) -> RunLength:
    """Compute length and outputs of runs for ``data`` at a ``step`` (s), after ``skip`` turns if the offset
    is free; ``models`` are the mechanism and others of its kind.

    Raises ModelError for data over the angle of a crank where no crank turns.
    """
    mechanism = models[0]
    turn = turn_of(mechanism)
    if data.over == "angle" and (turn is None or not assemble(mechanism).topology.driven):
        fault = Fault(
            "data", "it is over the angle of a crank, and no driver turns one", remedy="give times instead"
        )
        raise ModelError([fault], data.name)
    end = data.places[-1] + max(offset.high, 0.0)
    if turn is None:
        outputs = outputs_of(math.ceil(end / data.spacing), end / step)
        return RunLength(
            data.over, None, float(end), outputs, max(1, math.ceil(end / outputs / step)), float(step)
        )
    longest = max(time for time in map(turn_of, models) if time is not None)
    samples = 2.0 * math.pi / data.spacing if data.over == "angle" else longest / data.spacing
    outputs = outputs_of(math.ceil(samples), longest / step)
    steps_per_output = max(1, math.ceil(longest / (outputs * step) * (1.0 - 1e-9)))

    def turns(time: float) -> float:
        if data.over == "angle":
            return (
                skip
                + 1.0
                + (data.span + (2.0 * math.pi if offset.free else offset.high - offset.low)) / (2.0 * math.pi)
            )
        return skip + 1.0 + data.span / time if offset.free else max(1.0, end / time)

    return RunLength(data.over, turns, 0.0, outputs, steps_per_output, float(step))


def outputs_of(samples: int, steps: float) -> int:
    """Return the number of outputs of a turn, or of a run without turns, with as many ``samples`` and
    ``steps``.
    """
    dense = min(DENSE_OUTPUTS_A_SAMPLE * samples, DENSE_OUTPUTS, int(steps) // STEPS_AN_OUTPUT)
    return int(np.clip(max(OUTPUTS_A_SAMPLE * samples, dense), FEWEST_OUTPUTS, MOST_OUTPUTS))


def middle_and_ends(count: int) -> list[Array]:
    """Return the middle of all bounds, and each parameter at both of its bounds with the others in the
    middle, as shares (1) of the intervals, shape (parameters,) each.
    """
    ends = (np.where(np.arange(count) == k, end, 0.5) for k in range(count) for end in (0.0, 1.0))
    return [np.full(count, 0.5), *ends]


def probe(text: str, values: Numbers) -> Mechanism | None:
    """Return the mechanism with these ``values`` by path; None if it cannot be assembled."""
    try:
        mechanism = loads(text, set=list(values.items()))
        assemble(mechanism)
    except VfifeError:
        return None
    return mechanism
