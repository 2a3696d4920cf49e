"""Where measured samples may lie in a model's run, how long that has to be, and how finely it is looked at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..errors import Fault, ModelError, VfifeError
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import loads
from ..units import number
from .curves import Timing
from .measurements import Measured
from .residuals import Offset
from .sought import Numbers, Sought, numbers_at

Array = NDArray[np.float64]
FREE = "free"
# outputs of the model for each sample: forces between are not smooth, and two bias a speed by five standard
# errors
FINER = 4
FINEST, COARSEST = 20_000, 360  # outputs of a turn


def few(seen: Measured, sought: Sequence[Sought]) -> None:
    """Raises ModelError for fewer samples than tell so many parameters."""
    count, unknown = (
        len(seen.places) * len(seen.curves),
        len(sought) + 1 + 2 * sum(one.proportional for one in seen.curves),
    )
    if count < 3 * unknown:
        what = f"{count} values are too few for {unknown} unknown numbers"
        raise ModelError(
            [Fault("data", what, "", f"{3 * unknown} or more", "measure more, or look for fewer numbers")],
            seen.name,
        )


def offset_of(told: Any, seen: Measured, mechanism: Mechanism) -> Offset:
    """Where the first sample may lie. Raises ModelError."""
    unit, turn = ("rad", turn_of(mechanism)) if seen.over == "angle" else ("s", turn_of(mechanism))
    if told is None:
        told = FREE if seen.over == "time" and turn is not None else 0.0
    if told == FREE:
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
    if isinstance(told, str) and ".." in told:
        told = tuple(part.strip() for part in told.split(".."))
    ends = tuple(told) if isinstance(told, tuple | list) else (told, told)
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
        seen.over == "time" and seen.places[0] + low < -1e-9 * seen.span
    ):  # an angle is known to whole turns, a time is not
        first = f"{-seen.places[0]:.4g} s or more"
        raise ModelError(
            [
                Fault(
                    "offset",
                    "the first sample lies before the run begins",
                    f"{low:.4g} s",
                    first,
                    "the run begins at 0 s",
                )
            ],
            "fit",
        )
    return Offset(low, high)


def length(told: Any, seen: Measured) -> float:
    """The width of an envelope's window (s or rad). Raises ModelError for one that is none, or wider than the
    data.
    """
    if told is None:
        return seen.span / 50.0
    unit = "rad" if seen.over == "angle" else "s"
    return wanted(
        "width", told, unit, seen.span, f"above 0 and at most {seen.span:.4g} {unit}, the length of the data"
    )


def wanted(name: str, told: Any, unit: str, most: float, limit: str) -> float:
    """An argument in its unit. Raises ModelError for zero, less, or more than ``most``."""
    value = float(number(told, unit))
    if not 0.0 < value <= most:
        what = "zero or negative" if value <= 0.0 else "too large"
        raise ModelError(
            [Fault(name, what, f"{value:.4g} {unit}", limit, "correct it, or leave it out")], "fit"
        )
    return value


def timing_of(
    mechanism: Mechanism,
    text: str,
    seen: Measured,
    sought: Sequence[Sought],
    laid: Offset,
    skip: float,
    step: Any,
) -> Timing:
    """How long and how finely members run. Raises ModelError for an angle of no crank, and what assembling
    raises.
    """
    turn = turn_of(mechanism)
    if seen.over == "angle" and (turn is None or not assemble(mechanism).topology.driven):
        raise ModelError(
            [
                Fault(
                    "data",
                    "it goes by the angle of a crank, and no driver turns one",
                    remedy="give times instead",
                )
            ],
            seen.name,
        )
    corners = [numbers_at(sought, shares) for shares in middle_and_ends(len(sought))]
    found = [mechanism, *(one for one in (made(text, numbers) for numbers in corners) if one is not None)]
    size = (
        wanted("step", step, "s", math.inf, "above 0 s")
        if step not in (None, "auto")
        else min(assemble(one).choice.step for one in found)
    )
    end = seen.places[-1] + max(laid.high, 0.0)
    if turn is None:
        outputs = int(np.clip(FINER * math.ceil(end / seen.spacing), COARSEST, FINEST))
        return Timing(
            seen.over, None, float(end), outputs, max(1, math.ceil(end / outputs / size)), float(size)
        )
    longest = max(one for one in (turn_of(each) for each in found) if one is not None)
    samples = 2.0 * math.pi / seen.spacing if seen.over == "angle" else longest / seen.spacing
    outputs = int(np.clip(FINER * math.ceil(samples), COARSEST, FINEST))
    every = max(1, math.ceil(longest / (outputs * size) * (1.0 - 1e-9)))

    def turns(one: float) -> float:
        if seen.over == "angle":
            return (
                skip
                + 1.0
                + (seen.span + (2.0 * math.pi if laid.free else laid.high - laid.low)) / (2.0 * math.pi)
            )
        return skip + 1.0 + seen.span / one if laid.free else max(1.0, end / one)

    return Timing(seen.over, turns, 0.0, outputs, every, float(size))


def middle_and_ends(count: int) -> list[Array]:
    """The middle of the bounds, and each parameter at both of its own."""
    found = [np.full(count, 0.5)]
    for k in range(count):
        for end in (0.0, 1.0):
            found.append(np.where(np.arange(count) == k, end, 0.5))
    return found


def made(text: str, numbers: Numbers) -> Mechanism | None:
    """A mechanism at other numbers; None where there is none."""
    try:
        found = loads(text, set=list(numbers.items()))
        assemble(found)
    except VfifeError:
        return None
    return found
