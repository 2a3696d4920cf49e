"""Lanes that never wait for each other: each has its own simulation, its own outputs, and room for the next one as soon as it has ended."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from .loops import NEVER, NONE, Counts, Integers, Lanes, Rows, loop_of, memory_of
from .runner import PARTS, Runner

LOOK = 250  # steps between two looks at lanes that may break


class Begun(NamedTuple):
    """A simulation after its first step, ready for a lane: its state (rows,), tables, and bounds (2, limited) of the rows that are limited."""

    state: Rows
    tables: Rows
    bounds: Rows


class Starter:
    """Takes the first step of one simulation after the other, before they come into lanes; the bits are those of any other width."""

    def __init__(self, topology: Topology, lanes: int, loop: str, tables: int, parts: int) -> None:
        rows = Layout(topology).rows
        self.runner = Runner(topology, np.zeros((rows, lanes)), np.zeros((lanes, tables)), loop, NONE, parts=parts)

    def begun(self, state: Rows, tables: Rows, bounds: Rows) -> Begun:
        """A simulation after step 0."""
        runner = self.runner
        runner.states[:], runner.done = state[:, None], 0
        runner.states[runner.layout["c"]] = 1.0
        runner.functions.reshape(runner.lanes, -1)[:] = tables
        runner.advance(1, 1, record=False)
        return Begun(runner.states[:, 0].copy(), tables, bounds)


class Stream:
    """Steps simulations of one topology in ``lanes``, which are filled one by one, whenever one is free.

    The rows ``handed`` of a lane are handed out after every so many of its own steps, into ``out``, shape (lanes, ``room``, handed); rows that are
    extremes start anew then. Time of a lane is counted from its own start: its steps are numbered n + shift, which is exact. A lane breaks as in
    :class:`~vfife.codegen.runner.Runner`: ``broken`` then says after how many steps of the stream; rows ``sound`` and ``limited`` are looked at.
    """

    def __init__(
        self, topology: Topology, lanes: int, loop: str, handed: Integers, room: int, sound: Integers, limited: Integers, tables: int,
        parts: int = PARTS, look: int = LOOK,
    ) -> None:  # fmt: skip
        self.layout, self.lanes, self.handed, self.room = Layout(topology), lanes, handed, room
        self.extremes = np.array(self.layout.of("extreme"), dtype=np.uint32)
        memory = memory_of(self.layout.rows * lanes, lanes, np.zeros(lanes * tables), parts, handed, self.extremes, limited)
        self.S, self.T, self.limits, self.broken = memory.S, memory.T, memory.limits, memory.broken
        self.broken[:] = -1.0
        self.every, self.at, self.stop = (np.zeros(lanes, dtype=np.int64) for _ in range(3))
        self.due: Counts = np.full(lanes, NEVER, dtype=np.int64)
        self.out = np.zeros((lanes, room, len(handed)))
        self.done = 1  # what comes into a lane has made its first step
        self.memory = memory  # what machine code has the addresses of
        self.take = loop_of(topology, loop, lanes).streaming(memory, Lanes(self.due, self.every, self.at, self.stop, self.out, sound, look))

    @property
    def states(self) -> Rows:
        """Present states, shape (rows, lanes)."""
        return self.S.reshape(-1, self.lanes)

    def state(self, lane: int) -> Rows:
        """Present state of a lane, (rows,)."""
        return self.states[:, lane]

    def rows(self, lane: int) -> Rows:
        """What a lane has handed out since it went on, (outputs, handed)."""
        return self.out[lane, : self.at[lane]] + 0.0

    def put(self, lane: int, simulation: Begun, every: int, outputs: int) -> int:
        """A simulation that begins in a lane: an output after ``every`` of its steps (its first one counts for none), a halt after so many.

        Steps that were made in the lane before its own are returned.
        """
        self.states[:, lane] = simulation.state
        self.states[self.extremes, lane] = 0.0
        self.states[self.layout["shift"], lane] = 1 - self.done
        self.T.reshape(self.lanes, -1)[lane] = simulation.tables
        self.limits.reshape(-1, 2, self.lanes)[:, :, lane] = simulation.bounds.T
        self.broken[lane], self.every[lane], self.due[lane] = 0.0, every, self.done + every
        self.at[lane], self.stop[lane] = 0, outputs
        return self.done - 1

    def go_on(self, lane: int, outputs: int) -> None:
        """So many outputs more, from the first place of ``out`` on."""
        self.at[lane], self.stop[lane] = 0, outputs

    def leave(self, lane: int) -> None:
        """Nobody waits for a lane any more."""
        self.broken[lane], self.due[lane], self.at[lane], self.stop[lane] = -1.0, NEVER, 0, NEVER

    def repeat(self, lane: int, other: int) -> None:
        """A lane that nobody waits for does what another one does, so that nothing happens in it that does not happen there."""
        self.states[:, lane] = self.states[:, other]
        self.T.reshape(self.lanes, -1)[lane] = self.T.reshape(self.lanes, -1)[other]

    @property
    def beat(self) -> int:
        """Steps up to the next look at lanes; a simulation that begins when there are none left is looked at after so many of its own steps."""
        return -(self.done - 1) % LOOK

    def advance(self, count: int) -> None:
        """So many steps, or fewer: up to where a lane has all its outputs, or breaks."""
        self.done = self.take(self.done, count)
