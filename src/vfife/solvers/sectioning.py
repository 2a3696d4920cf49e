"""One long motion, looked at once a turn and at impacts, in pieces after each of which it can be taken up again."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from .impact_section import COLUMNS, Strikes
from .interrupts import Halt, Pace
from .lyapunov import ALIGNED, Nearby, plain_runner, steps_of_turn
from .tangents import Neighbours

Array = NDArray[np.float64]

TURNS = 50  # of a piece


@dataclass(frozen=True)
class Piece:
    """Some turns: ``rows`` recorded once in each that is looked at, shape (turns, kept), the ``growth`` of a small difference in it, its logarithm,
    shape (turns,), what was ``struck`` (:class:`Strikes`), and the ``state`` to go on from, shape (rows,) or (2 rows,)."""

    number: int
    rows: Array
    growth: Array
    struck: Array
    state: Array


class Sectioning:
    """A motion of so many ``turns``, the first of them ``dropped``, looked at at a ``phase`` (1) of the turn, and at impacts of some ``contacts``.

    The run makes a turn before these, and the way to the phase. ``near``: neighbours whose difference is the small one.
    """

    def __init__(self, assembly: Assembly, near: Neighbours, phase: float, turns: int, dropped: int, contacts: Sequence[int] = ()) -> None:
        self.assembly, self.turn, self.stop = assembly, steps_of_turn(assembly), threading.Event()
        self.begins = 1 + self.turn + round(phase * self.turn) % self.turn
        before = max(0, dropped - ALIGNED)
        spans = ((0, before), (before, dropped), (dropped, turns))
        self.cuts = [(k, min(k + TURNS, last)) for first, last in spans for k in range(first, last, TURNS)]
        self.before, self.dropped = before, dropped
        self.nearby, self.plain, self.pace = Nearby([assembly], [near]), plain_runner([assembly]), Pace()
        self.kept = self.plain.kept
        self.strikes = Strikes.of(assembly, contacts) if contacts else None

    def pieces(self, resume: tuple[int, Array] | None = None) -> Iterator[Piece]:
        """The pieces, from that after ``resume`` on, the number and state of one before. A second thread looks for impacts."""
        with Halt() as halt, ThreadPoolExecutor(1) as beside:
            self.pace.look = self.nearby.pace.look = halt.look
            try:
                state = self._begun() if resume is None else resume[1]
                waiting: tuple[int, Array, Array, Array, Future[Array] | None] | None = None
                for number in range(0 if resume is None else resume[0] + 1, len(self.cuts)):
                    first, last = self.cuts[number]
                    job, done = None, self.begins + first * self.turn
                    if self.strikes is not None and first >= self.dropped:
                        job = beside.submit(
                            self.strikes.over, state[: self.assembly.layout.rows].copy(), done, (last - first) * self.turn, self._end_if
                        )
                    rows, growth, state = self._turns(first, last, state)
                    if waiting is not None:
                        yield _piece(*waiting)
                    waiting = number, rows, growth, state, job
                if waiting is not None:
                    yield _piece(*waiting)
            finally:
                self.stop.set()

    def _begun(self) -> Array:
        self.plain.advance(1, 1)
        self.pace.advance(self.plain, self.begins - 1, 1)
        return self.plain.states[:, 0].copy()

    def _turns(self, first: int, last: int, state: Array) -> tuple[Array, Array, Array]:
        """Rows and growth of turns, where they are looked at, and the state after them."""
        done, nothing = self.begins + first * self.turn, (np.zeros((0, len(self.kept))), np.zeros(0))
        if last <= self.before:
            self.plain.states[:, 0], self.plain.done = state, done
            self.pace.advance(self.plain, (last - first) * self.turn, 1)
            return *nothing, self.plain.states[:, 0].copy()
        self.nearby.begin([self.assembly], state[:, None], done)
        rows, growth = self.nearby.turns([self.assembly], last - first)
        after = self.nearby.states[:, 0].copy()
        return (rows[:, :, 0], growth[:, 0], after) if first >= self.dropped else (*nothing, after)

    def _end_if(self) -> None:
        if self.stop.is_set():
            raise KeyboardInterrupt


def _piece(number: int, rows: Array, growth: Array, state: Array, job: Future[Array] | None) -> Piece:
    return Piece(number, rows, growth, np.zeros((0, len(COLUMNS))) if job is None else job.result(), state)
