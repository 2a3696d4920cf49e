"""The loops behind one face: state in, recorded rows out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.arrays import layout_of
from ..kernels.topology import Topology
from .cachelines import aligned
from .loops import NEVER, NONE, Integers, Rows, loop_of, memory_of

PARTS = 8  # steps that a step with an event is taken again in
LOOK = 1000  # steps between two looks at lanes that may break


class Watched(NamedTuple):
    """What breaks a lane: a number of ``rows`` that is less than ``low`` or more than ``high``, shape (rows, lanes), or one that is not finite.

    Only ``lanes`` that are True, shape (lanes,), are looked at.
    """

    rows: Integers
    low: Rows
    high: Rows
    lanes: NDArray[np.bool_]


class Runner:
    """Advances one or more simulations of one topology, all lanes in step.

    ``loop``: "data-driven", "generated" (straight-line code, vectors of ``lanes`` numbers), or "interpreted" (the data-driven text as plain
    Python). ``states`` has shape (rows, lanes), ``tables`` (lanes, length). ``advance`` takes ``outputs`` times ``count`` steps and returns the
    rows ``kept`` after each ``count``, shape (outputs, kept, lanes). A step in which something begins, ends or changes its regime is taken
    again in ``parts`` (1: as it is). ``shares``, shape (lanes,), puts lanes out of phase: right after the start, one is moved on by so large a
    part of a step, so that its step n is at (n + share) dt. Its memory is its own: runners may advance in several threads at once.

    Where lanes are ``watched``, each is looked at after every 1000 steps, counted from the first (``look``); ``broken`` says of one whose numbers
    had left all bounds then after how many steps that was. It stops no other; a call ends when all that are watched are broken. Rows of a lane
    after it broke mean nothing.

    With ``directions``, in the generated loop, the state is followed by as many derivatives of it, of as many rows each; ``tables`` are followed by
    the tables of their derivatives by their argument, and by those in each direction.
    """

    def __init__(
        self,
        topology: Topology,
        states: Rows,
        functions: Rows,
        loop: str,
        kept: Integers,
        *,
        parts: int = PARTS,
        shares: Rows | None = None,
        watched: Watched | None = None,
        directions: int = 0,
    ) -> None:
        self.topology, self.loop = topology, loop
        self.kept = np.ascontiguousarray(kept, dtype=np.uint32)
        self.layout = layout_of(topology)
        self.lanes = states.shape[1]
        rows = self.layout.rows
        own = np.array(self.layout.of("extreme"), dtype=np.uint32)
        self.extremes = np.concatenate([own + np.uint32(k * rows) for k in range(directions + 1)])
        self.functions = np.ascontiguousarray(functions, dtype=float).reshape(-1)
        self.done = 0
        size = rows * (directions + 1) * self.lanes
        limited, limits = (NONE, aligned(0)) if watched is None else self._limits(watched)
        self.memory = memory_of(size, self.lanes, self.functions, parts, self.kept, self.extremes, limited, limits)
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

    def advance(self, count: int, outputs: int, *, anew: bool = True, record: bool = True) -> Rows:
        """``outputs`` times ``count`` steps from where the state is.

        An interval between two outputs may be taken in several calls: the extremes begin ``anew`` in the first of them only, and the last alone
        has to ``record``. Zeros that are recorded have no sign: terms that a topology makes zero drop out of a straight line, and signs with them.
        """
        out = np.zeros((outputs, len(self.kept) if record else 0, self.lanes))
        self.take(self.done, count, out, anew, self.look)
        self.done += count * outputs
        out += 0.0
        return out
