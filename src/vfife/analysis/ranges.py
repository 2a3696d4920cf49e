"""How far a run's numbers can be trusted: every measure with its range over the run and its companions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Record
from .measures import measures

Array = NDArray[np.float64]

JUDGED = ("force.max", "moment.max", "penetration.max", "angular_acceleration.max", "torque.max")  # largest values of a turn
LEAST = 0.1  # of the largest of its kind: what is smaller is compared with that, so that an idle joint makes no run sensitive


class Measured(float):
    """A measure of a run: a number that knows its range, ``low`` to ``high``, over the run and its companions.

    ``value`` is the run's own, and what it counts as wherever a number is expected. Without companions all three are the same.
    """

    low: float
    high: float

    def __new__(cls, value: float, low: float | None = None, high: float | None = None) -> Measured:
        made = super().__new__(cls, value)
        made.low, made.high = (value if low is None else low), (value if high is None else high)
        return made

    def __getnewargs__(self) -> tuple[float, float, float]:  # type: ignore[override]
        return self.value, self.low, self.high

    @property
    def value(self) -> float:
        """The plain number."""
        return float(self)

    @property
    def width(self) -> float:
        """``high`` - ``low``."""
        return self.high - self.low


def companion_records(record: Record) -> Iterator[Record]:
    """What each companion of a run leaves, as a record of the last turn that measures can be taken of; those with infinite numbers are left out."""
    found = record.companions
    if found is None:
        return
    for k in range(len(found.shifts)):
        if k not in found.lost:
            yield dataclasses.replace(record, steps=found.steps, source=found.rows[:, :, k], kept=found.kept, companions=None)


def ranged(record: Record, reference: Mapping[str, float] | None = None) -> dict[str, Measured]:
    """The measures of a run (:func:`~vfife.analysis.measures.measures`) with their ranges over run and companions."""
    own = measures(record, reference)
    others = [measures(one, reference) for one in companion_records(record)]
    found = {}
    for name, value in own.items():
        every = [value, *(one[name] for one in others if name in one)]
        found[name] = Measured(value, min(every), max(every))
    return found


def spreads(found: Mapping[str, Measured]) -> dict[str, float]:
    """Width of the range of each largest value of a turn over its size (1), by name.

    Its size is the largest of the range, or a tenth of the largest of its kind where it is less. What never touches has none.
    """
    of_kind = {kind: [(name, one) for name, one in found.items() if name.endswith(f".{kind}")] for kind in JUDGED}
    result = {}
    for members in of_kind.values():
        floor = LEAST * max((one.high for _, one in members), default=0.0)
        for name, one in members:
            if one.high > 0.0:
                result[name] = (one.high - max(one.low, 0.0)) / max(one.high, floor)
    return result


def widest_range(found: Mapping[str, Measured]) -> tuple[str, float] | None:
    """Name and relative width of the measure that is known worst, None where there is none."""
    every = spreads(found)
    return max(every.items(), key=lambda item: item[1]) if every else None


def band(record: Record, series: Callable[[Record], Array]) -> tuple[Array, Array] | None:
    """Lowest and highest of a series over run and companions at the outputs of the last turn and the one before, each of the series' shape."""
    found = record.companions
    if found is None:
        return None
    own = series(record)[np.isin(record.steps, found.steps)]
    every = np.stack([own, *(series(one)[-len(own) :] for one in companion_records(record))])
    return every.min(axis=0), every.max(axis=0)
