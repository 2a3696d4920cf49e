"""Sweeps: a mechanism whose number moves on after so many turns, while its motion goes on; and how fast motions nearby leave it.

Chains of values lie in lanes side by side: the way up, the way down. What is looked at is the state once a turn, at one phase of the crank. The
growth of a small difference is that of the step's own derivative, which begins as that by the number that is swept, is freed from it after a
turn, and is taken back to length one after each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..codegen.runner import Runner
from .halt import Halt
from .pace import Pace
from .record import recorded_rows
from .tangents import Neighbours, changes, rates

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Leg:
    """What the chains leave at one value: ``rows`` recorded once a turn, shape (turns, kept, chains), ``growth`` of a small difference in each of
    them, its logarithm, shape (turns, chains), and the ``state`` to go on from, derivatives with it."""

    number: int
    rows: Array
    growth: Array
    state: Array


class Sweep:
    """Chains of assemblies that differ in one number, ``up`` and ``down`` it: one topology, as many steps in a turn.

    ``phase`` (1) is the part of a turn at which it is looked at. ``near``: neighbours of the first of each chain, whose difference is the small
    one.
    """

    def __init__(self, chains: Sequence[Sequence[Assembly]], near: Sequence[Neighbours], phase: float = 0.0) -> None:
        self.chains, first = chains, chains[0][0]
        self.kept, self.rows, self.lanes = recorded_rows(first), first.layout.rows, len(chains)
        self.turn = round((first.choice.turn or 0.0) / first.choice.step)
        self.ahead = round(phase * self.turn) % self.turn
        state = np.zeros((2, self.rows, self.lanes))
        tables = np.zeros((self.lanes, 3, len(first.tables)))
        for k, (chain, one) in enumerate(zip(chains, near, strict=True)):
            state[0, :, k], state[1, :, k] = chain[0].state, (one.up.state - one.down.state) / one.apart
            tables[k] = chain[0].tables, rates(chain[0]), changes(chain[0], one)
        self.runner = Runner(
            first.topology, state.reshape(-1, self.lanes), tables.reshape(self.lanes, -1), "generated", self.kept,
            parts=first.mechanism.settings.parts, directions=1,
        )  # fmt: skip
        self.given = np.array(first.layout.of("parameter"), dtype=np.intp)
        self.weights = np.stack([weights(chain[0]) for chain in chains], axis=1)
        self.pace = Pace()

    @property
    def states(self) -> Array:
        """State and derivative, shape (2, rows, chains)."""
        return self.runner.states.reshape(2, self.rows, self.lanes)

    def legs(self, turns: int, dropped: int, resume: tuple[int, Array] | None = None) -> Iterator[Leg]:
        """At each value so many ``turns``, the first of them ``dropped``; from the leg after ``resume``, the number and state of one before."""
        with Halt() as halt:
            self.pace.look = halt.look
            if resume is None:
                self._begin()
            else:
                self.runner.done = 1 + self.turn + self.ahead + (resume[0] + 1) * turns * self.turn
                self.states[:] = resume[1]
            for number in range(0 if resume is None else resume[0] + 1, len(self.chains[0])):
                self._take_up(number)
                every = [self._turn() for _ in range(turns)]
                kept = every[dropped:]
                yield Leg(number, np.array([rows for rows, _ in kept]), np.array([growth for _, growth in kept]), self.states.copy())

    def _begin(self) -> None:
        """The start, a turn in which the difference of the number becomes one of the motion, and the way to the phase."""
        self.runner.advance(1, 1)
        self.pace.advance(self.runner, self.turn, 1)
        if self.ahead:
            self.pace.advance(self.runner, self.ahead, 1)
        self._renew()

    def _take_up(self, number: int) -> None:
        """The numbers of the next models; their motion stays, and what differed by them is free."""
        tables = self.runner.functions.reshape(self.lanes, 3, -1)
        for k, chain in enumerate(self.chains):
            self.states[0, self.given, k] = chain[number].state[self.given]
            tables[k, 0], tables[k, 1] = chain[number].tables, rates(chain[number])
            tables[k, 2] = changes(chain[number], Neighbours(chain[number], chain[number], 1.0))
        self.states[1, self.given] = 0.0

    def _turn(self) -> tuple[Array, Array]:
        rows = self.pace.advance(self.runner, self.turn, 1)[0]
        return rows, np.log(self._renew())

    def _renew(self) -> Array:
        """The length of the difference in each chain, which becomes one."""
        size = np.maximum(np.sqrt(((self.weights * self.states[1]) ** 2).sum(axis=0)), 1e-300)
        self.states[1] /= size
        return np.asarray(size)


def weights(assembly: Assembly) -> Array:
    """What a row counts in the length of a difference, shape (rows,): of velocities the root of kinetic energy, of positions so much as they
    change in a radian of the crank."""
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


def carried_on(first: Assembly, other: Assembly, tolerance: float = 1e-9) -> Callable[[], str] | None:
    """None where the motion of one model can go on in another: the same bodies at the same places; else what says why not."""
    if first.topology != other.topology:
        return lambda: "they are not of one topology"
    if len(first.tables) != len(other.tables):
        return lambda: "their functions of time have other pieces"
    if first.ideals:
        places = [first.layout.rows_of(f"joint_{side}_{axis}") for side in ("bearing", "journal") for axis in "xy"]
        rows = np.concatenate(places)
        size = max(float(np.abs(first.state[rows]).max(initial=0.0)), 1e-300)
        if float(np.abs(first.state[rows] - other.state[rows]).max(initial=0.0)) > tolerance * size:
            return lambda: "pins of ideal joints are elsewhere in their bodies, so that the position of one is none of the other"
    return None
