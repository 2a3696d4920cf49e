"""Timing of a fit: where the first sample may lie in a model's run, how long runs are, and how finely they
are recorded.
"""

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
from .measurements import Measured, Over
from .parameters import FitParameter, Numbers, numbers_at
from .starts import PREFIX

Array = NDArray[np.float64]
FREE = "free"
# Outputs of the model for each sample: forces between outputs are not smooth, and two a sample bias a speed
# by five standard errors.
OUTPUTS_A_SAMPLE = 4
MOST_OUTPUTS, FEWEST_OUTPUTS = 20_000, 360  # in a turn
ENVELOPES = 50.0  # windows of an envelope in the data, unless its width is given


@dataclass(frozen=True)
class Offset:
    """Where the first sample lies in the model's run: ``low`` to ``high`` (s or rad) after its ``origin``;
    ``free``: anywhere in a turn.
    """

    low: float
    high: float
    free: bool = False

    @property
    def fixed(self) -> bool:
        """Whether it is known."""
        return self.low == self.high and not self.free


@dataclass(frozen=True)
class Timing:
    """Length of runs, and how finely they are recorded.

    ``turns`` of a run by the time of one (s), or None and a ``duration`` (s); ``outputs`` in a turn, or in
    all, with ``every`` steps between two; the largest ``step`` (s).
    """

    over: Over
    turns: Callable[[float], float] | None
    duration: float
    outputs: int
    every: int
    step: float


def refuse_few_samples(records: Sequence[Measured], parameters: Sequence[FitParameter]) -> None:
    """Raises ModelError for fewer than three values for each unknown number."""
    count = sum(len(data.places) * len(data.curves) for data in records)
    unknown = len(parameters) + sum(1 + 2 * sum(one.proportional for one in data.curves) for data in records)
    if count < 3 * unknown:
        what, remedy = (
            f"{count} values are too few for {unknown} unknown numbers",
            "measure more, or look for fewer numbers",
        )
        raise ModelError([Fault("data", what, "", f"{3 * unknown} or more", remedy)], records[0].name)


def offset_of(value: Any, data: Measured, mechanism: Mechanism) -> Offset:
    """Where the first sample may lie; None: free over time if a crank turns, else 0. Raises ModelError."""
    unit, turn = data.unit, turn_of(mechanism)
    if value is None:
        value = FREE if data.over == "time" and turn is not None else 0.0
    if value == FREE:
        if turn is None:
            fault = Fault(
                "offset",
                "nothing turns round, so no offset is free over a turn",
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
        low, high = (number(one, unit) for one in ends)
    except (VfifeError, ValueError) as error:
        raise ModelError(
            [Fault("offset", str(error), "", f"free, a number or two bounds in {unit}", "")], "fit"
        ) from None
    if low > high:
        raise ModelError(
            [Fault("offset", "the bounds do not ascend", f"{low:g} .. {high:g}", "", "exchange them")], "fit"
        )
    if (
        data.over == "time" and data.places[0] + low < -1e-9 * data.span
    ):  # an angle is known to whole turns, a time is not
        what, limit = "the first sample lies before the run begins", f"{-data.places[0]:.4g} s or more"
        raise ModelError([Fault("offset", what, f"{low:.4g} s", limit, "the run begins at 0 s")], "fit")
    return Offset(low, high)


def envelope_width(value: Any, data: Measured) -> float:
    """Width of an envelope's window (s or rad). Raises ModelError for one that is not positive, or wider than
    the data.
    """
    if value is None:
        return data.span / ENVELOPES
    limit = f"above 0 and at most {data.span:.4g} {data.unit}, the length of the data"
    return positive("width", value, data.unit, data.span, limit)


def positive(name: str, value: Any, unit: str, largest: float, limit: str) -> float:
    """An argument in its unit. Raises ModelError if it is not positive, or exceeds the ``largest``."""
    quantity = float(number(value, unit))
    if not 0.0 < quantity <= largest:
        what = "zero or negative" if quantity <= 0.0 else "too large"
        raise ModelError(
            [Fault(name, what, f"{quantity:.4g} {unit}", limit, "correct it, or leave it out")], "fit"
        )
    return quantity


def models_of(mechanism: Mechanism, text: str, parameters: Sequence[FitParameter]) -> list[Mechanism]:
    """The model, and those of its kind in the middle and at the bounds of each parameter that can be
    assembled; of a start all are alike.
    """
    numbers = [one for one in parameters if not one.paths[0].startswith(PREFIX)]
    probes = (probe(text, numbers_at(numbers, shares)) for shares in middle_and_ends(len(numbers)))
    return [mechanism, *(one for one in probes if one is not None)]


def step_of(step: Any, models: Sequence[Mechanism]) -> float:
    """The step (s) of all runs: as given, or the finest automatic one of the models. Raises ModelError."""
    if step in (None, "auto"):
        return float(min(assemble(one).choice.step for one in models))
    return positive("step", step, "s", math.inf, "above 0 s")


def timing_of(
    models: Sequence[Mechanism], data: Measured, offset: Offset, skip: float, step: float
) -> Timing:
    """Timing of runs with the samples of ``data`` at a ``step`` (s), after ``skip`` turns where the offset is
    free; ``models`` are the mechanism and others of its kind.

    Raises ModelError for data over the angle of a crank where no crank turns.
    """
    mechanism = models[0]
    turn = turn_of(mechanism)
    if data.over == "angle" and (turn is None or not assemble(mechanism).topology.driven):
        fault = Fault(
            "data", "it goes by the angle of a crank, and no driver turns one", remedy="give times instead"
        )
        raise ModelError([fault], data.name)
    end = data.places[-1] + max(offset.high, 0.0)
    if turn is None:
        outputs = int(np.clip(OUTPUTS_A_SAMPLE * math.ceil(end / data.spacing), FEWEST_OUTPUTS, MOST_OUTPUTS))
        return Timing(
            data.over, None, float(end), outputs, max(1, math.ceil(end / outputs / step)), float(step)
        )
    longest = max(time for time in map(turn_of, models) if time is not None)
    samples = 2.0 * math.pi / data.spacing if data.over == "angle" else longest / data.spacing
    outputs = int(np.clip(OUTPUTS_A_SAMPLE * math.ceil(samples), FEWEST_OUTPUTS, MOST_OUTPUTS))
    every = max(1, math.ceil(longest / (outputs * step) * (1.0 - 1e-9)))

    def turns(time: float) -> float:
        if data.over == "angle":
            return (
                skip
                + 1.0
                + (data.span + (2.0 * math.pi if offset.free else offset.high - offset.low)) / (2.0 * math.pi)
            )
        return skip + 1.0 + data.span / time if offset.free else max(1.0, end / time)

    return Timing(data.over, turns, 0.0, outputs, every, float(step))


def middle_and_ends(count: int) -> list[Array]:
    """The middle of the bounds, and each parameter at both of its own, as shares of the ways between them."""
    ends = (np.where(np.arange(count) == k, end, 0.5) for k in range(count) for end in (0.0, 1.0))
    return [np.full(count, 0.5), *ends]


def probe(text: str, values: Numbers) -> Mechanism | None:
    """The mechanism with other values by path; None if it cannot be assembled."""
    try:
        mechanism = loads(text, set=list(values.items()))
        assemble(mechanism)
    except VfifeError:
        return None
    return mechanism
