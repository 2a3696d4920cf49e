"""Runs and streams of simulations: states go in, recorded rows come out.

The lanes of a run have the same number of steps and outputs. The lanes of a stream are independent: each has
its own simulation and outputs, and takes the next simulation as soon as one has ended.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...kernels.advance import Outputs
from ...kernels.arrays import Counts, Integers, layout_of
from ...kernels.arrays import Numbers as Rows
from ...kernels.topology import Topology
from .loops import NO_INTEGERS, NO_STEP, aligned, loop_of, memory_of

# Smaller steps in which a step with an event is repeated: 8 reduce its error of first order to a sixty-fourth
# (kernels/advance.py). Runs of a model have those of its settings, by default as many.
PARTS = 8
LOOK = 1000  # steps between two checks of the lanes of a run


class Watched(NamedTuple):
    """Limits of lanes: a lane breaks if a number in ``rows`` is below ``low`` or above ``high``, shape (rows,
    lanes), or not finite. Only ``lanes`` that are True, shape (lanes,), are checked.
    """

    rows: Integers
    low: Rows
    high: Rows
    lanes: NDArray[np.bool_]


class Runner:
    """Advance one or more simulations of one topology, all lanes by the same number of steps.

    ``loop``: "generated" (straight-line code on vectors), "data-driven", or "interpreted" (the data-driven
    text as plain Python). ``states`` has the shape (rows, lanes), ``functions``, the tables of functions,
    (lanes, length). The rows ``recorded`` are returned after each output. A step with an event is repeated in
    ``parts`` smaller steps (1: not repeated). ``shares``, shape (lanes,), shifts the phase of lanes: right
    after the start, a lane takes a step of that share, so that its step n is at (n + share) dt. A runner has
    its own memory, and several may advance in different threads.

    Lanes that are ``watched`` are checked after every LOOK steps, counted from the start. ``broken`` is then,
    for each lane that has left its limits, the number of steps after which that was found. It does not stop
    the others; a call ends when all watched lanes are broken. Rows of a broken lane have no meaning.

    With ``directions``, in the generated loop only, the state is followed by that number of derivatives with
    as many rows each; ``functions`` are followed by tables of their derivatives by the argument, and by their
    derivatives in each direction. With ``jumps``, derivatives contain the jumps of forces where contacts
    begin, as a small difference feels them (:mod:`~vfife.compiler.trace.jumps`).
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
        jumps: bool = False,
    ) -> None:
        self.topology, self.loop = topology, loop
        self.row_numbers = np.ascontiguousarray(recorded, dtype=np.uint32)
        self.layout = layout_of(topology)
        self.lanes = states.shape[1]
        rows = self.layout.rows
        extremes = np.array(self.layout.of("extreme"), dtype=np.uint32)
        self.extremes = np.concatenate([extremes + np.uint32(k * rows) for k in range(directions + 1)])
        self.functions = np.ascontiguousarray(functions, dtype=float).reshape(-1)
        self.done = 0
        size = rows * (directions + 1) * self.lanes
        limited, limits = (NO_INTEGERS, aligned(0)) if watched is None else self._limits(watched)
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
        self.look = NO_STEP if watched is None else LOOK
        self.states[:] = states
        self.states[self.layout["c"]] = 1.0
        self.take = loop_of(topology, loop, self.lanes, directions, jumps)(self.memory)

    def _limits(self, watched: Watched) -> tuple[Integers, Rows]:
        limits = aligned(2 * watched.low.size)
        limits.reshape(-1, 2, self.lanes)[:] = np.stack([watched.low, watched.high], axis=1)
        return np.ascontiguousarray(watched.rows, dtype=np.uint32), limits

    @property
    def states(self) -> Rows:
        """Present state, shape (rows, lanes)."""
        return self.S.reshape(-1, self.lanes)

    def advance(self, count: int, outputs: int, *, reset: bool = True, record: bool = True) -> Rows:
        """Take ``outputs`` times ``count`` steps from the present state; return the recorded rows, shape
        (outputs, recorded, lanes).

        An interval between two outputs may be taken in several calls: ``reset`` the extremes in the first of
        them only, and ``record`` in the last only. Recorded zeros have no sign, because terms that a topology
        makes zero are dropped from straight-line code, and signs of zeros with them.
        """
        out = np.zeros((outputs, len(self.row_numbers) if record else 0, self.lanes))
        self.take(self.done, count, out, reset, self.look)
        self.done += count * outputs
        out += 0.0
        return out


STREAM_LOOK = 250  # steps between two checks of the lanes of a stream


class Started(NamedTuple):
    """A simulation after its first step, ready for a lane: its state (rows,), tables (length,), and bounds of
    the limited rows (2, limited).
    """

    state: Rows
    tables: Rows
    bounds: Rows


class Starter:
    """Take the first step of simulations before they are put into lanes.

    The first step has another code path than all others. Taken in the lanes of a stream, it would have to be
    taken by all of them at once; its bits are the same in any width.
    """

    def __init__(self, topology: Topology, lanes: int, loop: str, tables: int, parts: int) -> None:
        rows = layout_of(topology).rows
        self.runner = Runner(
            topology, np.zeros((rows, lanes)), np.zeros((lanes, tables)), loop, NO_INTEGERS, parts=parts
        )

    def started(self, state: Rows, tables: Rows, bounds: Rows) -> Started:
        """Return a simulation after step 0."""
        runner = self.runner
        runner.states[:], runner.done = state[:, None], 0
        runner.states[runner.layout["c"]] = 1.0
        runner.functions.reshape(runner.lanes, -1)[:] = tables
        runner.advance(1, 1, record=False)
        return Started(runner.states[:, 0].copy(), tables, bounds)


class Stream:
    """Step simulations of one topology in ``lanes``, each of which can be filled whenever it is free.

    The rows ``handed`` of a lane are written after every interval of its own to ``out``, shape (lanes,
    ``room``, handed), and its extremes are set to zero. All lanes count the steps of the stream; the row
    ``shift`` makes the time of a lane count from its own start, exactly. A lane breaks as in :class:`Runner`;
    ``broken`` is then the number of steps of the stream. The rows ``sound`` and ``limited`` are checked.
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
        self.interval, self.at, self.stop = (np.zeros(lanes, dtype=np.int64) for _ in range(3))
        self.due: Counts = np.full(lanes, NO_STEP, dtype=np.int64)
        self.out = np.zeros((lanes, room, len(handed)))
        self.done = 1  # what comes into a lane has made its first step
        self.memory = memory  # what machine code has the addresses of
        outputs = Outputs(self.due, self.interval, self.at, self.stop, self.out, sound)
        self.take = loop_of(topology, loop, lanes).streaming(memory, outputs, look)

    @property
    def states(self) -> Rows:
        """Present states, shape (rows, lanes)."""
        return self.S.reshape(-1, self.lanes)

    def state(self, lane: int) -> Rows:
        """Return the present state of a lane, (rows,)."""
        return self.states[:, lane]

    def rows(self, lane: int) -> Rows:
        """Return the outputs of a lane since it was filled or continued, (outputs, handed)."""
        return self.out[lane, : self.at[lane]] + 0.0

    def put(self, lane: int, simulation: Started, interval: int, outputs: int) -> int:
        """Put a simulation into a lane, with an output after every ``interval`` steps beyond its first one,
        and a halt after ``outputs`` outputs.

        Returns the number of steps of the stream before its own.
        """
        self.states[:, lane] = simulation.state
        self.states[self.extremes, lane] = 0.0
        self.states[self.layout["shift"], lane] = 1 - self.done
        self.T.reshape(self.lanes, -1)[lane] = simulation.tables
        self.limits.reshape(-1, 2, self.lanes)[:, :, lane] = simulation.bounds.T
        self.broken[lane], self.interval[lane], self.due[lane] = 0.0, interval, self.done + interval
        self.at[lane], self.stop[lane] = 0, outputs
        return self.done - 1

    def go_on(self, lane: int, outputs: int) -> None:
        """Continue a lane for ``outputs`` more outputs, written from the beginning of ``out``."""
        self.at[lane], self.stop[lane] = 0, outputs

    def leave(self, lane: int) -> None:
        """Free a lane: it has no outputs and is not checked."""
        self.broken[lane], self.due[lane], self.at[lane], self.stop[lane] = -1.0, NO_STEP, 0, NO_STEP

    def repeat(self, lane: int, source: int) -> None:
        """Copy the state of another lane into a free one, so that the free one has no events of its own."""
        self.states[:, lane] = self.states[:, source]
        self.T.reshape(self.lanes, -1)[lane] = self.T.reshape(self.lanes, -1)[source]

    @property
    def beat(self) -> int:
        """Number of steps to the next check of lanes. A simulation that is put in when it is zero is checked
        after the same numbers of its own steps, whatever the stream has done before.
        """
        return -(self.done - 1) % STREAM_LOOK

    def advance(self, count: int) -> None:
        """Take up to ``count`` steps; stop when a lane has all its outputs or breaks."""
        self.done = self.take(self.done, count)
