"""Sweeps: a mechanism whose number moves on after so many turns, while its motion goes on; and how fast motions nearby leave it.

Chains of values lie in lanes side by side: the way up, the way down. What is looked at is the state once a turn, at one phase of the crank.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from .interrupts import Halt, Pace
from .lyapunov import ALIGNED, Nearby, plain_runner, steps_of_turn
from .tangents import Neighbours

Array = NDArray[np.float64]
Beside: TypeAlias = Callable[[int, Array, int, Callable[[], None]], Any]
Found: TypeAlias = tuple[Array, Array, Any]
TOGETHER = 2  # values whose differences go side by side: twice the lanes take hardly longer


@dataclass(frozen=True)
class Leg:
    """What the chains leave at one value: ``rows`` recorded once a turn, shape (turns, kept, chains), ``growth`` of a small difference in each of
    them, its logarithm, shape (turns, chains), the ``state`` to go on from, shape (rows, chains), and what was looked at ``beside`` it."""

    number: int
    rows: Array
    growth: Array
    state: Array
    beside: Any = None


@dataclass(frozen=True)
class Begun:
    """A value whose motion is under way: the states ``first``, and after the turns at which its difference begins, ``here``; steps made by then."""

    number: int
    first: Array
    done_first: int
    here: Array
    done: int


class Sweep:
    """Chains of assemblies that differ in one number, ``up`` and ``down`` it: one topology, as many steps in a turn.

    ``phase`` (1) is the part of a turn at which it is looked at. ``near``: neighbours of the first of each chain, whose difference is the small
    one. Derivatives are carried along from ``ALIGNED`` turns before those that are looked at, no sooner, for they cost twice as much as the motion,
    and at :data:`TOGETHER` values side by side. The last bits of a difference know of its neighbours in lanes, so these are the same ones always:
    what is gone on with begins where such values begin (:meth:`whole`).

    ``beside``: called in a thread of its own with the number of a value, the state before it, shape (rows, chains), the steps made by then, and
    what is to be called now and then.
    """

    def __init__(self, chains: Sequence[Sequence[Assembly]], near: Sequence[Neighbours], phase: float = 0.0, beside: Beside | None = None) -> None:
        self.chains, first, self.beside = chains, chains[0][0], beside
        self.turn = steps_of_turn(first)
        self.ahead = round(phase * self.turn) % self.turn
        self.given = np.array(first.layout.of("parameter"), dtype=np.intp)
        self.pace, self.stop = Pace(), threading.Event()
        self.plain = plain_runner([chain[0] for chain in chains])
        self.nearby = Nearby([chain[0] for chain in chains] * TOGETHER, [*near] * TOGETHER, self._end_if)
        self.shift = first.layout.row("shift")
        self.kept = self.plain.kept

    @property
    def states(self) -> Array:
        """The state, shape (rows, chains)."""
        return self.plain.states

    def begun(self, leg: int, turns: int) -> int:
        """Steps that are made before a leg of so many turns begins."""
        return 1 + self.turn + self.ahead + leg * turns * self.turn

    @staticmethod
    def whole(known: int) -> int:
        """Of so many legs that are known, those after which it can be gone on with; the others are made again."""
        return known - known % TOGETHER

    def legs(self, turns: int, dropped: int, resume: tuple[int, Array] | None = None) -> Iterator[Leg]:
        """At each value so many ``turns``, the first of them ``dropped``; from the leg after ``resume``, the number and state of one before.

        A second thread carries derivatives through the turns that are looked at, while the motion goes on to the next values.
        """
        first, before = 0 if resume is None else resume[0] + 1, max(0, dropped - ALIGNED)
        last = len(self.chains[0]) - 1
        with Halt() as halt, ThreadPoolExecutor(1) as pool:
            self.pace.look = halt.look
            try:
                self._begin(first, turns, resume)
                begun: list[Begun] = []
                states: list[Array] = []
                waiting: tuple[list[Begun], list[Array], Future[list[Found]]] | None = None
                for number in range(first, last + 1):
                    begun.append(self._under_way(number, before))
                    full = len(begun) == TOGETHER or number == last
                    job = pool.submit(self._with_derivatives, tuple(begun), turns - before) if full else None
                    self.pace.advance(self.plain, (turns - before) * self.turn, 1)
                    states.append(self.states.copy())
                    if job is not None:
                        if waiting is not None:
                            yield from _legs(*waiting, dropped - before)
                        waiting, begun, states = (begun, states, job), [], []
                if waiting is not None:
                    yield from _legs(*waiting, dropped - before)
            finally:
                self.stop.set()

    def _under_way(self, number: int, before: int) -> Begun:
        """Takes a value up, and goes to where its difference begins."""
        first, done = self.states.copy(), self.plain.done
        self._take_up(number)
        if before:
            self.pace.advance(self.plain, before * self.turn, 1)
        return Begun(number, first, done, self.states.copy(), self.plain.done)

    def _begin(self, first: int, turns: int, resume: tuple[int, Array] | None) -> None:
        """The start, a turn, and the way to the phase; or the state of a leg before."""
        if resume is None:
            self._take_up(0)
            self.plain.advance(1, 1)
            self.pace.advance(self.plain, self.turn + self.ahead, 1)
        else:
            self.plain.done = self.begun(first, turns)
            self.states[:] = resume[1]

    def _take_up(self, number: int) -> None:
        """The numbers of the next models; their motion stays."""
        for k, chain in enumerate(self.chains):
            self.states[self.given, k] = chain[number].state[self.given]
            self.plain.functions.reshape(len(self.chains), -1)[k] = chain[number].tables

    def _with_derivatives(self, begun: Sequence[Begun], turns: int) -> list[Found]:
        """Turns with a difference that is one of the number at first and, after a turn, of the motion alone: rows and growth of each value.

        Clocks of later values are ahead of the first one's, by whole steps; lanes that are left over repeat the last value.
        """
        lanes, chains = [*begun, *[begun[-1]] * (TOGETHER - len(begun))], len(self.chains)
        here = [chain[one.number] for one in lanes for chain in self.chains]
        states = [one.here.copy() for one in lanes]
        for one, state in zip(lanes, states, strict=True):
            state[self.shift] += one.done - begun[0].done
        self.nearby.begin(here, np.concatenate(states, axis=1), begun[0].done)
        rows, growth = self.nearby.turns(here, turns)
        looked = [None if self.beside is None else self.beside(one.number, one.first, one.done_first, self._end_if) for one in begun]
        spans = [slice(k * chains, (k + 1) * chains) for k in range(len(begun))]
        return [(rows[:, :, span], growth[:, span], seen) for span, seen in zip(spans, looked, strict=True)]

    def _end_if(self) -> None:
        if self.stop.is_set():
            raise KeyboardInterrupt


def _legs(begun: Sequence[Begun], states: Sequence[Array], job: Future[list[Found]], dropped: int) -> Iterator[Leg]:
    for one, state, (rows, growth, beside) in zip(begun, states, job.result(), strict=True):
        yield Leg(one.number, rows[dropped:], growth[dropped:], state, beside)


def carried_on(first: Assembly, other: Assembly, tolerance: float = 1e-9) -> Callable[[], str] | None:
    """None where the motion of one model can go on in another: the same bodies at the same places; else what says why not."""
    if (why := side_by_side(first, other)) is not None:
        return why
    if first.ideals:
        places = [first.layout.rows_of(f"joint_{side}_{axis}") for side in ("bearing", "journal") for axis in "xy"]
        rows = np.concatenate(places)
        size = max(float(np.abs(first.state[rows]).max(initial=0.0)), 1e-300)
        if float(np.abs(first.state[rows] - other.state[rows]).max(initial=0.0)) > tolerance * size:
            return lambda: "pins of ideal joints are elsewhere in their bodies, so that the position of one is none of the other"
    return None


def side_by_side(first: Assembly, other: Assembly) -> Callable[[], str] | None:
    """None where two models can be stepped in lanes of one loop; else what says why not."""
    if first.topology != other.topology:
        return lambda: "they are not of one topology"
    if len(first.tables) != len(other.tables):
        return lambda: "their functions of time have other pieces"
    return None
