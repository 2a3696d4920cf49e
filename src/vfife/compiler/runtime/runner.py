"""Runs and streams of simulations: a state goes in, recorded rows come out.

Lanes of a run go in step. Those of a stream never wait for each other: each has its own simulation, its own
outputs, and room for the next one as soon as it has ended.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...kernels.advance import Outputs
from ...kernels.arrays import Counts, Integers, layout_of
from ...kernels.arrays import Numbers as Rows
from ...kernels.topology import Topology
from .loops import NEVER, NONE, aligned, loop_of, memory_of

PARTS = 8  # steps that a step with an event is taken again in
LOOK = 1000  # steps between two looks at lanes that may break


class Watched(NamedTuple):
    """What breaks a lane: a number of ``rows`` that is less than ``low`` or more than ``high``, shape (rows,
    lanes), or one that is not finite.

    Only ``lanes`` that are True, shape (lanes,), are looked at.
    """

    rows: Integers
    low: Rows
    high: Rows
    lanes: NDArray[np.bool_]


class Runner:
    """Advances one or more simulations of one topology, all lanes in step.

    ``loop``: "data-driven", "generated" (straight-line code, vectors of ``lanes`` numbers), or "interpreted"
    (the data-driven text as plain Python). ``states`` has shape (rows, lanes), ``tables`` (lanes, length).
    ``advance`` takes ``outputs`` times ``count`` steps and returns the rows ``row_numbers`` after each
    ``count``, shape (outputs, rows, lanes). A step in which something begins, ends or changes its regime is
    taken again in ``parts`` (1: as it is). ``shares``, shape (lanes,), puts lanes out of phase: right after
    the start, one is moved on by so large a part of a step, so that its step n is at (n + share) dt. Its
    memory is its own: runners may advance in several threads at once.

    Where lanes are ``watched``, each is looked at after every 1000 steps, counted from the first (``look``);
    ``broken`` says of one whose numbers had left all bounds then after how many steps that was. It stops no
    other; a call ends when all that are watched are broken. Rows of a lane after it broke mean nothing.

    With ``directions``, in the generated loop, the state is followed by as many derivatives of it, of as many
    rows each; ``tables`` are followed by the tables of their derivatives by their argument, and by those in
    each direction.
    """

    def __init__(
        self,
        topology: Topology,
        states: Rows,
        functions: Rows,
        loop: str,
        recorded: Integers,
        *,
        parts: int = PARTS,
        shares: Rows | None = None,
        watched: Watched | None = None,
        directions: int = 0,
    ) -> None:
        self.topology, self.loop = topology, loop
        self.row_numbers = np.ascontiguousarray(recorded, dtype=np.uint32)
        self.layout = layout_of(topology)
        self.lanes = states.shape[1]
        rows = self.layout.rows
        own = np.array(self.layout.of("extreme"), dtype=np.uint32)
        self.extremes = np.concatenate([own + np.uint32(k * rows) for k in range(directions + 1)])
        self.functions = np.ascontiguousarray(functions, dtype=float).reshape(-1)
        self.done = 0
        size = rows * (directions + 1) * self.lanes
        limited, limits = (NONE, aligned(0)) if watched is None else self._limits(watched)
        self.memory = memory_of(
            size,
            self.lanes,
            self.functions,
            parts,
            self.row_numbers,
            self.extremes,
            limited=limited,
            limits=limits,
        )
        self.S, self.shares, self.broken = self.memory.S, self.memory.shares, self.memory.broken
        self.shares[:] = 0.0 if shares is None else shares
        self.broken[:] = 0.0 if watched is None else np.where(watched.lanes, 0.0, -1.0)
        self.look = NEVER if watched is None else LOOK
        self.states[:] = states
        self.states[self.layout["c"]] = 1.0
        self.take = loop_of(topology, loop, self.lanes, directions)(self.memory)

    def _limits(self, watched: Watched) -> tuple[Integers, Rows]:
        limits = aligned(2 * watched.low.size)
        limits.reshape(-1, 2, self.lanes)[:] = np.stack([watched.low, watched.high], axis=1)
        return np.ascontiguousarray(watched.rows, dtype=np.uint32), limits

    @property
    def states(self) -> Rows:
        """Present state, shape (rows, lanes)."""
        return self.S.reshape(-1, self.lanes)

    def advance(self, count: int, outputs: int, *, reset: bool = True, record: bool = True) -> Rows:
        """``outputs`` times ``count`` steps from where the state is.

        An interval between two outputs may be taken in several calls: the extremes are ``reset`` in the
        first of them only, and the last alone has to ``record``. Zeros that are recorded have no sign: terms
        that a topology makes zero drop out of a straight line, and signs with them.
        """
        out = np.zeros((outputs, len(self.row_numbers) if record else 0, self.lanes))
        self.take(self.done, count, out, reset, self.look)
        self.done += count * outputs
        out += 0.0
        return out


STREAM_LOOK = 250  # steps between two looks at lanes that may break


class Started(NamedTuple):
    """A simulation after its first step, ready for a lane: its state (rows,), tables, and bounds (2, limited)
    of the rows that are limited.
    """

    state: Rows
    tables: Rows
    bounds: Rows


class Starter:
    """Takes the first step of one simulation after the other, before they come into lanes; the bits are those
    of any other width.
    """

    def __init__(self, topology: Topology, lanes: int, loop: str, tables: int, parts: int) -> None:
        rows = layout_of(topology).rows
        self.runner = Runner(
            topology, np.zeros((rows, lanes)), np.zeros((lanes, tables)), loop, NONE, parts=parts
        )

    def started(self, state: Rows, tables: Rows, bounds: Rows) -> Started:
        """A simulation after step 0."""
        runner = self.runner
        runner.states[:], runner.done = state[:, None], 0
        runner.states[runner.layout["c"]] = 1.0
        runner.functions.reshape(runner.lanes, -1)[:] = tables
        runner.advance(1, 1, record=False)
        return Started(runner.states[:, 0].copy(), tables, bounds)


class Stream:
    """Steps simulations of one topology in ``lanes``, which are filled one by one, whenever one is free.

    The rows ``handed`` of a lane are handed out after every so many of its own steps, into ``out``, shape
    (lanes, ``room``, handed); rows that are extremes start anew then. Time of a lane is counted from its own
    start: its steps are numbered n + shift, which is exact. A lane breaks as in
    :class:`~vfife.compiler.runtime.runner.Runner`: ``broken`` then says after how many steps of the stream;
    rows ``sound`` and ``limited`` are looked at.
    """

    def __init__(
        self, topology: Topology, lanes: int, loop: str, handed: Integers, room: int, sound: Integers,
        limited: Integers, tables: int, parts: int = PARTS, look: int = STREAM_LOOK,
    ) -> None:  # fmt: skip
        self.layout, self.lanes, self.handed, self.room = layout_of(topology), lanes, handed, room
        self.extremes = np.array(self.layout.of("extreme"), dtype=np.uint32)
        memory = memory_of(
            self.layout.rows * lanes,
            lanes,
            np.zeros(lanes * tables),
            parts,
            handed,
            self.extremes,
            limited=limited,
        )
        self.S, self.T, self.limits, self.broken = memory.S, memory.T, memory.limits, memory.broken
        self.broken[:] = -1.0
        self.every, self.at, self.stop = (np.zeros(lanes, dtype=np.int64) for _ in range(3))
        self.due: Counts = np.full(lanes, NEVER, dtype=np.int64)
        self.out = np.zeros((lanes, room, len(handed)))
        self.done = 1  # what comes into a lane has made its first step
        self.memory = memory  # what machine code has the addresses of
        outputs = Outputs(self.due, self.every, self.at, self.stop, self.out, sound)
        self.take = loop_of(topology, loop, lanes).streaming(memory, outputs, look)

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

    def put(self, lane: int, simulation: Started, every: int, outputs: int) -> int:
        """A simulation that begins in a lane: an output after ``every`` of its steps (its first one counts
        for none), a halt after so many.

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
        """A lane that nobody waits for does what another one does, so that nothing happens in it that does
        not happen there.
        """
        self.states[:, lane] = self.states[:, other]
        self.T.reshape(self.lanes, -1)[lane] = self.T.reshape(self.lanes, -1)[other]

    @property
    def beat(self) -> int:
        """Steps up to the next look at lanes; a simulation that begins when there are none left is looked at
        after so many of its own steps.
        """
        return -(self.done - 1) % STREAM_LOOK

    def advance(self, count: int) -> None:
        """So many steps, or fewer: up to where a lane has all its outputs, or breaks."""
        self.done = self.take(self.done, count)
