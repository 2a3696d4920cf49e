"""A member of a waterfall while it is stepped: of it no more is kept than its series over the last turns."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...assembly.assembled import Assembly
from ...assembly.bounds import Bounds
from ...results.channels import entities
from ...results.view import View
from ...solvers.record import Record, recorded_rows

Array = NDArray[np.float64]


class Spectral:
    """A simulation in a lane, of whose ``turns`` the ``last`` are kept, output by output, of each of ``series``."""

    loop = "generated"

    def __init__(self, number: int, assembly: Assembly, turns: int, last: int, series: Sequence[str]) -> None:
        self.number, self.assembly, self.turns, self.series = number, assembly, turns, series
        self.handed = recorded_rows(assembly)
        choice = assembly.choice
        self.every, self.outputs = choice.outputs_every, round((choice.turn or 0.0) / (choice.step * choice.outputs_every))
        self.bounds = Bounds(assembly, self.handed)
        self.parts: deque[Array] = deque(maxlen=last)
        self.done, self.diverged = 0, False
        self.before = np.zeros((1, len(self.handed)))

    @property
    def ended(self) -> bool:
        """Whether it needs no further turn."""
        return self.diverged or self.done == self.turns

    def end(self) -> None:
        """It is as it is."""

    def start(self, state: Array) -> None:
        """The output of step 0."""
        self.before = state[self.handed][None, :]

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """A turn, and the step after which it was seen broken, less than 0 where it was not."""
        if broken >= 0 or len(rows) < self.outputs or self.bounds.unsound(rows).any():
            self.diverged = True
            return
        self.done += 1
        if self.done > self.turns - (self.parts.maxlen or 0):
            self.parts.append(values_of(self.assembly, np.concatenate([self.before, rows]), self.handed, self.series, self.every)[:, 1:])
        self.before = rows[-1:].copy()

    @property
    def values(self) -> Array:
        """The series over the last turns, shape (series, outputs)."""
        return np.concatenate(self.parts, axis=1)


def values_of(assembly: Assembly, rows: Array, kept: NDArray[np.uint32], series: Sequence[str], every: int) -> Array:
    """Series of outputs that follow each other, shape (series, outputs)."""
    view = View(Record(assembly, np.arange(len(rows), dtype=np.int64) * every, rows, kept))
    names, found = entities(view.record), []
    for name in series:
        variable, entity, label = view.series.place(name)
        values = view.channels[variable].values
        found.append(values if entity is None else values[:, names[entity].index(label)])
    return np.array(found, dtype=float)
