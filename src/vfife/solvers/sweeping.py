"""Sweeps: a mechanism whose number moves on after so many turns, while its motion goes on; and how fast motions nearby leave it.

Chains of values lie in lanes side by side: the way up, the way down. What is looked at is the state once a turn, at one phase of the crank. The
growth of a small difference is that of the step's own derivative, which begins as that by the number that is swept, is freed from it after a
turn, and is taken back to length one after each (Benettin et al. 1980).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
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

ALIGNED = 10  # turns in which a difference takes the direction in which it grows most


@dataclass(frozen=True)
class Leg:
    """What the chains leave at one value: ``rows`` recorded once a turn, shape (turns, kept, chains), ``growth`` of a small difference in each of
    them, its logarithm, shape (turns, chains), and the ``state`` to go on from, shape (rows, chains)."""

    number: int
    rows: Array
    growth: Array
    state: Array


class Sweep:
    """Chains of assemblies that differ in one number, ``up`` and ``down`` it: one topology, as many steps in a turn.

    ``phase`` (1) is the part of a turn at which it is looked at. ``near``: neighbours of the first of each chain, whose difference is the small
    one. Derivatives are carried along from ``ALIGNED`` turns before those that are looked at, no sooner, for they cost twice as much as the motion.
    """

    def __init__(self, chains: Sequence[Sequence[Assembly]], near: Sequence[Neighbours], phase: float = 0.0) -> None:
        self.chains, first = chains, chains[0][0]
        self.kept, self.rows, self.lanes = recorded_rows(first), first.layout.rows, len(chains)
        self.turn = round((first.choice.turn or 0.0) / first.choice.step)
        self.ahead = round(phase * self.turn) % self.turn
        self.given = np.array(first.layout.of("parameter"), dtype=np.intp)
        self.weights = np.stack([weights(chain[0]) for chain in chains], axis=1)
        self.seeds, self.changes = np.zeros((self.rows, self.lanes)), [changes(chain[0], one) for chain, one in zip(chains, near, strict=True)]
        for k, one in enumerate(near):
            self.seeds[self.given, k] = ((one.up.state - one.down.state) / one.apart)[self.given]
        start = np.stack([chain[0].state for chain in chains], axis=1)
        self.plain, self.derived = (self._runner(first, np.concatenate([start] + [0.0 * start] * count), count) for count in (0, 1))
        self.pace, self.stop = Pace(), threading.Event()

    def _runner(self, first: Assembly, states: Array, directions: int) -> Runner:
        tables = np.tile(first.tables, (self.lanes, directions + 2 if directions else 1))
        parts = first.mechanism.settings.parts
        return Runner(first.topology, states, tables, "generated", self.kept, parts=parts, directions=directions)

    @property
    def states(self) -> Array:
        """The state, shape (rows, chains)."""
        return self.plain.states

    def legs(self, turns: int, dropped: int, resume: tuple[int, Array] | None = None) -> Iterator[Leg]:
        """At each value so many ``turns``, the first of them ``dropped``; from the leg after ``resume``, the number and state of one before.

        A second thread carries derivatives through the turns that are looked at, while the motion goes on to the next value.
        """
        first, before = 0 if resume is None else resume[0] + 1, max(0, dropped - ALIGNED)
        with Halt() as halt, ThreadPoolExecutor(1) as beside:
            self.pace.look = halt.look
            try:
                self._begin(first, turns, resume)
                waiting: tuple[int, Array, Future[list[tuple[Array, Array]]]] | None = None
                for number in range(first, len(self.chains[0])):
                    self._take_up(number)
                    if before:
                        self.pace.advance(self.plain, before * self.turn, 1)
                    job = beside.submit(self._with_derivatives, number, self.states.copy(), self.plain.done, turns - before)
                    self.pace.advance(self.plain, (turns - before) * self.turn, 1)
                    if waiting is not None:
                        yield self._leg(*waiting, dropped - before)
                    waiting = number, self.states.copy(), job
                if waiting is not None:
                    yield self._leg(*waiting, dropped - before)
            finally:
                self.stop.set()

    def _begin(self, first: int, turns: int, resume: tuple[int, Array] | None) -> None:
        """The start, a turn, and the way to the phase; or the state of a leg before."""
        if resume is None:
            self._take_up(0)
            self.plain.advance(1, 1)
            self.pace.advance(self.plain, self.turn + self.ahead, 1)
        else:
            self.plain.done = 1 + self.turn + self.ahead + first * turns * self.turn
            self.states[:] = resume[1]

    def _leg(self, number: int, state: Array, job: Future[list[tuple[Array, Array]]], dropped: int) -> Leg:
        kept = job.result()[dropped:]
        return Leg(number, np.array([rows for rows, _ in kept]), np.array([growth for _, growth in kept]), state)

    def _take_up(self, number: int) -> None:
        """The numbers of the next models; their motion stays."""
        for k, chain in enumerate(self.chains):
            self.states[self.given, k] = chain[number].state[self.given]
            self.plain.functions.reshape(self.lanes, -1)[k] = chain[number].tables

    def _with_derivatives(self, number: int, states: Array, done: int, turns: int) -> list[tuple[Array, Array]]:
        """Turns with a difference that is one of the number at first and, after a turn, of the motion alone: rows and growth of each."""
        runner, found, pace = self.derived, [], Pace(self._end_if)
        both, tables = runner.states.reshape(2, self.rows, self.lanes), runner.functions.reshape(self.lanes, 3, -1)
        both[0], both[1], runner.done = states, self.seeds, done
        for k, chain in enumerate(self.chains):
            tables[k] = chain[number].tables, rates(chain[number]), self.changes[k]
        for turn in range(turns):
            rows = pace.advance(runner, self.turn, 1)[0]
            if turn == 0:
                both[1, self.given] = 0.0
                for k, chain in enumerate(self.chains):
                    tables[k, 2] = changes(chain[number], Neighbours(chain[number], chain[number], 1.0))
            size = np.maximum(np.sqrt(((self.weights * both[1]) ** 2).sum(axis=0)), 1e-300)
            both[1] /= size
            found.append((rows, np.log(size)))
        return found

    def _end_if(self) -> None:
        if self.stop.is_set():
            raise KeyboardInterrupt


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
