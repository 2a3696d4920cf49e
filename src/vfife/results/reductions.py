"""Reductions of channels over turns: ``mean(C.force)``, ``rms(follower.angle)``, of any channel that a run has."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.measures import last_turn
from ..analysis.motion import times
from ..solvers.record import Record
from .channels import entities
from .view import View

Array = NDArray[np.float64]
REDUCTION = re.compile(r"(max|min|mean|rms|range)\((.+)\)")


def mean(time: Array, values: Array) -> float:
    """Mean over time, ∫ x dt / T, by trapezoids between outputs."""
    return float(np.trapezoid(values, time) / (time[-1] - time[0]))


# Each of values at outputs, with the times of these (s).
REDUCED: dict[str, Callable[[Array, Array], float]] = {
    "max": lambda time, values: float(values.max()),
    "min": lambda time, values: float(values.min()),
    "mean": mean,
    "rms": lambda time, values: math.sqrt(mean(time, values * values)),
    "range": lambda time, values: float(np.ptp(values)),
}


class Reductions:
    """Those of some names that are reductions: what each takes of which channel."""

    def __init__(self, names: Sequence[str]) -> None:
        self.asked = {name: (found[1], found[2]) for name in names if (found := REDUCTION.fullmatch(name))}

    def over(self, turns: Sequence[Record]) -> dict[str, float]:
        """Each over all the turns together, records of which the next begins with the last output of the one before.

        Of a record that is longer than a turn its last turn counts. What happens between two outputs is not seen. A channel that a mechanism
        does not have is left out, and so is what is not finite.
        """
        parts = [View(one) for one in turns]
        own = [turn_of(one) for one in turns]
        time = joined([times(one)[at:] for one, at in zip(turns, own, strict=True)])
        found: dict[str, float] = {}
        for name, (how, channel) in self.asked.items():
            if channel in parts[0].series and len(time) > 1:
                found[name] = REDUCED[how](time, joined([along(one, channel)[at:] for one, at in zip(parts, own, strict=True)]))
        return {name: value for name, value in found.items() if math.isfinite(value)}


def turn_of(record: Record) -> int:
    """The output with which the last turn of a record begins."""
    return max(int(np.argmax(last_turn(record))) - 1, 0)


def along(view: View, name: str) -> Array:
    """A channel by the name of its series, shape (outputs,)."""
    variable, entity, noun = view.series.place(name)
    values = np.asarray(view.channels[variable].values, dtype=float)
    return values if entity is None else values[:, entities(view.record)[entity].index(noun)]


def joined(parts: Sequence[Array]) -> Array:
    """Turns one after another, the output between two of them once."""
    return np.concatenate([one if k == 0 else one[1:] for k, one in enumerate(parts)])
