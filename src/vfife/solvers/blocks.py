"""Blocks of turns of one mechanism, one after the other, while its worn profiles change between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..assembly.bounds import Bounds
from ..codegen.runner import Runner
from ..errors import VfifeError
from .interrupts import Halt, Pace
from .record import Record, recorded_rows

Array = NDArray[np.float64]


class Blocks:
    """A mechanism with a whole number of steps in a turn, of which so many ``outputs`` a turn are recorded."""

    def __init__(self, assembly: Assembly, outputs: int, halt: Halt) -> None:
        self.assembly, self.outputs = assembly, outputs
        self.kept = recorded_rows(assembly)
        self.every = round((assembly.choice.turn or 0.0) / assembly.choice.step) // outputs
        parts = assembly.mechanism.settings.parts
        self.runner = Runner(assembly.topology, assembly.state[:, None], assembly.tables[None, :], "generated", self.kept, parts=parts)
        self.bounds, self.pace = Bounds(assembly, self.kept), Pace(halt.look)
        self.harmonics = [assembly.layout.rows_of(f"harmonic_{part}") for part in ("cosine", "sine")]

    @property
    def turns(self) -> float:
        """Turns that were simulated."""
        return max(self.runner.done - 1, 0) / (self.every * self.outputs)

    @property
    def state(self) -> Array:
        """The state to go on from, with the number of steps, shape (rows + 1,)."""
        return np.append(self.runner.states[:, 0], self.runner.done)

    def restore(self, state: Array) -> None:
        """Goes on from a state that was kept."""
        self.runner.states[:, 0], self.runner.done = state[:-1], int(state[-1])

    def shape(self, cosines: Array, sines: Array) -> None:
        """Gives all harmonics of all worn profiles their depths (m)."""
        for rows, depths in zip(self.harmonics, (cosines, sines), strict=True):
            self.runner.states[rows, 0] = depths

    def advance(self, dropped: int, counted: int) -> Record:
        """So many turns that nobody looks at, and then a record of so many, which begins with the output before them.

        Raises VfifeError where numbers leave all bounds.
        """
        if self.runner.done == 0:
            self.runner.advance(1, 1)
        first = self.runner.done - 1 + self.every * self.outputs * dropped
        before = self.pace.advance(self.runner, self.every * self.outputs, dropped)[-1:]
        rows = np.concatenate([before, self.pace.advance(self.runner, self.every, self.outputs * counted)])[:, :, 0]
        if self.bounds.unsound(rows).any():
            told = f"numbers left all bounds within {self.turns:.0f} turns that were simulated; give a smaller step, or check the model"
            raise VfifeError(f"{self.assembly.mechanism.name}: {told}")
        steps = first + self.every * np.arange(len(rows), dtype=np.int64)
        return Record(self.assembly, steps, rows, self.kept)
