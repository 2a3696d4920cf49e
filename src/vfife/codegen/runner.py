"""The loops behind one face: state in, recorded rows out."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from .cachelines import aligned, padded
from .compile import compiled, interpreted
from .graph import tables
from .lock import WRITING
from .native import NEVER, Memory, Take, llvmlite_version, straight_line
from .source import data_driven

PARTS = 8  # steps that a step with an event is taken again in
LOOK = 1000  # steps between two looks at lanes that may break
Rows = NDArray[np.float64]
Integers = NDArray[np.uint32]
NONE: Integers = np.zeros(0, dtype=np.uint32)
ARGUMENTS = "f1 f1 f1 u1 f1 i i i i i f1 f3 u1 u1 i u1 f1 f1"  # of the data-driven loop


@lru_cache(maxsize=16)
def _data_driven(contact: tuple[type, ...], friction: tuple[type, ...], interpret: bool) -> Callable[..., Any]:
    with WRITING:
        text = data_driven(contact, friction)
        return interpreted(text, "advance") if interpret else compiled(text, "advance", ARGUMENTS)


def forget_steps() -> None:
    """Drops all steps that this process has traced, compiled or loaded: the text of a law is another one."""
    from .pieces import _traced  # what writes steps is loaded where one is written
    from .ptx import program

    for cached in (_data_driven, straight_line, _traced, program):
        cached.cache_clear()


def compiler_of(loop: str) -> dict[str, str]:
    """What compiles a loop, and its version."""
    return {} if loop == "interpreted" else {"llvmlite": llvmlite_version()}


class DataDriven:
    """The data-driven loop, compiled or as plain Python, lane by lane."""

    def __init__(self, topology: Topology, lanes: int, interpret: bool) -> None:
        self.integers, layout, size = tables(topology)
        self.rows, self.lanes = layout.rows, lanes
        self.scratch, self.kept = np.zeros(size), np.zeros(layout.rows)
        self.function = _data_driven(topology.contact_laws, topology.friction_laws, interpret)

    def __call__(self, memory: Memory) -> Take:
        """Steps on a memory."""

        def take(n0: int, steps: int, out: Rows, anew: bool = True, look: int = NEVER) -> None:
            self.function(
                self.scratch, self.kept, memory.T, self.integers, memory.S, self.rows, self.lanes, n0, steps, memory.parts, memory.shares,
                out, memory.kept, memory.extremes if anew else NONE, look, memory.limited, memory.limits, memory.broken,
            )  # fmt: skip

        return take


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
        self.layout = Layout(topology)
        self.lanes = states.shape[1]
        rows = self.layout.rows
        own = np.array(self.layout.of("extreme"), dtype=np.uint32)
        self.extremes = np.concatenate([own + np.uint32(k * rows) for k in range(directions + 1)])
        self.functions = np.ascontiguousarray(functions, dtype=float).reshape(-1)
        self.done = 0
        size = rows * (directions + 1) * self.lanes
        self.S, self.spare = aligned(size), aligned(2 * padded(size))
        self.shares = aligned(self.lanes)
        self.shares[:] = 0.0 if shares is None else shares
        self.states[:] = states
        self.states[self.layout["c"]] = 1.0
        self.look, self.broken = NEVER, aligned(self.lanes)
        limited, limits = self._watch(watched)
        self.memory = Memory(self.S, self.spare, self.functions, parts, self.shares, self.kept, self.extremes, limited, limits, self.broken)
        chosen = straight_line(topology, self.lanes, directions) if loop == "generated" else DataDriven(topology, self.lanes, loop == "interpreted")
        self.take = chosen(self.memory)

    def _watch(self, watched: Watched | None) -> tuple[Integers, Rows]:
        if watched is None:
            return NONE, aligned(0)
        self.look = LOOK
        self.broken[:] = np.where(watched.lanes, 0.0, -1.0)
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
