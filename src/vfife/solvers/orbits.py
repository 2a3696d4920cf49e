"""Motions from starts of their own, side by side in lanes and on all cores, looked at once a turn; members do not know of each other."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import VfifeError
from .interrupts import Halt, Pace
from .lyapunov import ALIGNED, Nearby, plain_runner
from .tangents import Neighbours

Array = NDArray[np.float64]
PATIENCE = 0.1  # s between two looks at signals
LANES = 4  # side by side, on every machine


@dataclass(frozen=True)
class Start:
    """A member: its ``number``, what assembles it when its turn has come, and the ``ahead`` (1) of a turn after which it is at the phase of all."""

    number: int
    make: Callable[[], Assembly]
    ahead: float = 0.0


@dataclass(frozen=True)
class Orbit:
    """A member's ``rows``, recorded once in each turn that is looked at, shape (turns, kept), and the ``growth`` of a small difference in each, its
    logarithm, shape (turns,), empty where none was watched; or ``why`` there is none."""

    number: int
    assembly: Assembly | None
    rows: Array
    growth: Array
    why: str = ""


class Orbits:
    """Members of one topology and so many ``steps`` in a turn, each through ``turns``, the first of them ``dropped``, after a turn and the way to
    the phase. ``near``: neighbours whose difference is watched in all of them; None: none is.

    A motion knows nothing of those beside it. The last bits of a difference do, for where a lane takes a step in parts, its terms are summed in
    another order in all of them: so members go side by side with the same ones always.
    """

    def __init__(self, steps: int, turns: int, dropped: int, near: Neighbours | None = None) -> None:
        self.steps, self.turns, self.dropped, self.near = steps, turns, dropped, near
        self.stop = threading.Event()

    def each(self, starts: Sequence[Start], known: Collection[int] = (), workers: int | None = None) -> Iterator[Orbit]:
        """The members that are not ``known``, as they end; ``starts`` are those of all. Ctrl-C ends it within a second."""
        blocks = [block for block in self.blocks(starts) if not all(one.number in known for one in block)]
        with Halt() as halt, ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
            try:
                waiting: set[Future[list[Orbit]]] = {pool.submit(self.block, block) for block in blocks}
                while waiting:
                    ended, waiting = wait(waiting, PATIENCE, FIRST_COMPLETED)
                    halt.look()
                    for one in ended:
                        yield from (orbit for orbit in one.result() if orbit.number not in known)
            finally:
                self.stop.set()
                pool.shutdown(wait=True, cancel_futures=True)

    def blocks(self, starts: Sequence[Start]) -> list[list[Start]]:
        """Members that go side by side: as far before the phase, so many as there are lanes."""
        by: dict[int, list[Start]] = {}
        for one in starts:
            by.setdefault(self.begins(one), []).append(one)
        return [some[k : k + LANES] for some in by.values() for k in range(0, len(some), LANES)]

    def begins(self, one: Start) -> int:
        """Steps that a member makes before its turns."""
        return 1 + self.steps + round(one.ahead * self.steps) % self.steps

    def block(self, starts: Sequence[Start]) -> list[Orbit]:
        """Some members side by side; lanes that are left over repeat the last."""
        self._end_if()
        made: list[tuple[int, Assembly]] = []
        found: list[Orbit] = []
        for one in starts:
            try:
                made.append((one.number, one.make()))
            except VfifeError as error:
                found.append(Orbit(one.number, None, np.zeros((0, 0)), np.zeros(0), str(error)))
        while made:
            alike = [(number, one) for number, one in made if one.topology == made[0][1].topology and len(one.tables) == len(made[0][1].tables)]
            made = [(number, one) for number, one in made if number not in dict(alike)]
            every = [one for _, one in alike]
            rows, growth = self._through(every + every[-1:] * (LANES - len(every)), self.begins(starts[0]))
            found += [Orbit(number, one, rows[:, :, k], growth[:, k]) for k, (number, one) in enumerate(alike)]
        return found

    def _through(self, every: Sequence[Assembly], begins: int) -> tuple[Array, Array]:
        """Rows and growth of the turns that are looked at."""
        plain, pace, before = plain_runner(every), Pace(self._end_if), max(0, self.dropped - ALIGNED)
        plain.advance(1, 1)
        if self.near is None:
            pace.advance(plain, begins - 1 + self.dropped * self.steps, 1)
            return pace.advance(plain, self.steps, self.turns - self.dropped), np.zeros((0, LANES))
        pace.advance(plain, begins - 1 + before * self.steps, 1)
        nearby = Nearby(every, [self.near] * LANES, self._end_if)
        nearby.begin(every, plain.states, plain.done)
        rows, growth = nearby.turns(every, self.turns - before)
        return rows[self.dropped - before :], growth[self.dropped - before :]

    def _end_if(self) -> None:
        if self.stop.is_set():
            raise KeyboardInterrupt
