"""Lyapunov exponents: the growth of a small difference, turn by turn, beside the motion itself.

It is that of the step's own derivative, which begins as that by a number of the model, is freed from it after
a turn, and is taken back to length one after each (Benettin et al. 1980).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..compiler.runtime.runner import Runner
from ..numerics.elementwise import log
from .interrupts import ChunkSize
from .record import recorded_rows
from .tangents import Neighbours, changes, rates

Array = NDArray[np.float64]

ALIGNED = 10  # turns in which a difference takes the direction in which it grows most


def steps_of_turn(assembly: Assembly) -> int:
    """Steps in a turn."""
    return round((assembly.choice.turn or 0.0) / assembly.choice.step)


class LyapunovRunner:
    """Motions in lanes, each with a small difference beside it. ``near`` has of each lane the neighbours
    whose difference is the first one.

    ``look`` is called a few times a second; what it raises ends a call.
    """

    def __init__(
        self,
        assemblies: Sequence[Assembly],
        near: Sequence[Neighbours],
        look: Callable[[], None] | None = None,
    ) -> None:
        first = assemblies[0]
        self.rows, self.lanes, self.turn, self.pace = (
            first.layout.rows,
            len(assemblies),
            steps_of_turn(first),
            ChunkSize(look),
        )
        self.given = np.array(first.layout.of("parameter"), dtype=np.intp)
        self.weights = np.stack([weights(one) for one in assemblies], axis=1)
        self.seeds, self.changes = (
            np.zeros((self.rows, self.lanes)),
            [changes(*both) for both in zip(assemblies, near, strict=True)],
        )
        for k, one in enumerate(near):
            self.seeds[self.given, k] = ((one.up.state - one.down.state) / one.apart)[self.given]
        states, tables = np.zeros((2 * self.rows, self.lanes)), np.tile(first.tables, (self.lanes, 3))
        parts = first.mechanism.settings.parts
        self.runner = Runner(
            first.topology, states, tables, "generated", recorded_rows(first), parts=parts, directions=1
        )
        self.fresh = True

    @property
    def states(self) -> Array:
        """The motions and, below them, their differences, shape (2 rows, lanes)."""
        return self.runner.states

    def begin(self, assemblies: Sequence[Assembly], states: Array, done: int) -> None:
        """From the state of motions after so many steps, shape (rows, lanes), with differences by the number;
        shape (2 rows, lanes): with these.
        """
        self.fresh = len(states) == self.rows
        self.states[: len(states)], self.runner.done = states, done
        if self.fresh:
            self.states[self.rows :] = self.seeds
        self._tables(assemblies)

    def _tables(self, assemblies: Sequence[Assembly]) -> None:
        tables = self.runner.functions.reshape(self.lanes, 3, -1)
        for k, one in enumerate(assemblies):
            tables[k] = (
                one.tables,
                rates(one),
                self.changes[k] if self.fresh else changes(one, Neighbours(one, one, 1.0)),
            )

    def turns(self, assemblies: Sequence[Assembly], count: int) -> tuple[Array, Array]:
        """So many turns: rows after each, shape (turns, kept, lanes), and the logarithm of the growth in
        each, shape (turns, lanes).
        """
        rows, growth = np.zeros((count, len(self.runner.kept), self.lanes)), np.zeros((count, self.lanes))
        other = self.states[self.rows :]
        for turn in range(count):
            rows[turn] = self.pace.advance(self.runner, self.turn, 1)[0]
            if self.fresh:
                self.fresh, other[self.given] = False, 0.0
                self._tables(assemblies)
            with np.errstate(over="ignore", invalid="ignore"):
                own = np.ascontiguousarray(
                    (self.weights * other).T
                )  # summed in one order, however many lanes there are
                size = np.maximum(np.sqrt((own * own).sum(axis=1)), 1e-300)
                other /= size
                growth[turn] = log(size)
        return rows, growth


def weights(assembly: Assembly) -> Array:
    """What a row counts in the length of a difference, shape (rows,): of velocities the root of kinetic
    energy, of positions so much as they change in a radian of the crank.
    """
    layout, found = assembly.layout, np.zeros(assembly.layout.rows)
    rate = 2.0 * np.pi / (assembly.choice.turn or 2.0 * np.pi)
    for inverse, places, speeds in (("mass", "xy", "uv"), ("inertia", ("theta",), "w")):
        values = assembly.state[layout[f"particle_inverse_{inverse}"]]
        root = np.sqrt(np.divide(1.0, values, out=np.zeros_like(values), where=values > 0.0))
        for place in places:
            found[layout[f"particle_{place}"]] = rate * root
        for speed in speeds:
            found[layout[f"particle_{speed}"]] = root
    return found
