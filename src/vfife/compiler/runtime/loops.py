"""The loops that step simulations with one driver: straight-line code of a topology, the data-driven loop,
and both as plain Python.

The driver is the text of :mod:`vfife.kernels.advance`. For straight-line code it is compiled once for all
mechanisms and widths, and calls the steps of a mechanism by their names. The data-driven loop is compiled
together with the driver, once for all mechanisms with the same laws.

Arrays begin at a line of the processor's cache: vectors that straddle two lines cost a quarter of the speed.
"""

from __future__ import annotations

import gc
import math
import platform
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...kernels.advance import RUN, Memory, Outputs
from ...kernels.arrays import Integers, Numbers
from ...kernels.topology import Topology
from ..backends.kinds import ENTRIES
from ..trace.source import data_driven
from ..trace.tables import tables
from ..trace.traceable import WRITING
from . import cache, native
from .native import Called, interpreted, library, stored_code

if TYPE_CHECKING:
    from ..backends.modules import Pieces


LINE = 8  # doubles in a line of the cache


def padded(count: int) -> int:
    """Return ``count`` rounded up to whole lines of the cache."""
    return -(-count // LINE) * LINE


def aligned(count: int) -> Numbers:
    """Return ``count`` zeros that begin at a line of the cache, with space up to the end of the last line."""
    space = np.zeros(padded(count) + LINE)
    skip = (-space.ctypes.data // 8) % LINE
    return space[skip : skip + count]


NO_STEP = 2**62  # number of a step that is never reached
NO_INTEGERS: Integers = np.zeros(0, dtype=np.uint32)


def memory_of(
    size: int,
    lanes: int,
    tables: Numbers,
    parts: int,
    recorded: Integers,
    extremes: Integers,
    *,
    limited: Integers = NO_INTEGERS,
    limits: Numbers | None = None,
) -> Memory:
    """Return the memory of a run for a state of ``size`` numbers in all lanes together, in which no lane is
    shifted or broken; arguments are fields of :class:`~vfife.kernels.advance.Memory`.
    """
    S, Q, R = aligned(size), aligned(padded(size)), aligned(padded(size))
    numbers = np.array([lanes, lanes, size // lanes, parts, NO_STEP], dtype=np.int64)
    bounds = aligned(2 * len(limited) * lanes) if limits is None else limits
    return Memory(
        S,
        Q,
        R,
        aligned(3 * lanes),
        tables,
        NO_INTEGERS,
        numbers,
        aligned(lanes),
        recorded,
        extremes,
        limited,
        bounds,
        aligned(lanes),
    )


# A function (n0, steps, out, reset, look): take len(out) times ``steps`` steps from step n0, and fill out[m]
# with the rows recorded after each interval (out may have no rows). ``reset``: extremes begin anew before
# each interval; lanes are checked after every multiple of ``look`` steps.
Take = Callable[..., None]


class Stepped:
    """A loop whose lanes lie side by side, from the driver's functions ``advance`` and ``stream``."""

    def __init__(self, functions: Mapping[str, Any]) -> None:
        self.functions = functions

    def __call__(self, memory: Memory) -> Take:
        """Return the function that takes steps on a memory."""
        advance = self.functions["advance"].bound(memory)

        def take(n0: int, steps: int, out: Numbers, reset: bool = True, look: int = NO_STEP) -> None:
            memory.N[RUN.look] = look
            advance(int(reset), look - n0 % look, n0, steps, len(out), out.reshape(-1))

        return take

    def streaming(self, memory: Memory, outputs: Outputs, look: int) -> Callable[[int, int], int]:
        """Return a function (n0, count) that takes up to ``count`` steps from step n0 and returns the number
        of the last; each lane records outputs of its own and is checked every ``look`` steps.
        """
        memory.N[RUN.look] = look
        stream = self.functions["stream"].bound(
            memory, outputs._replace(out=outputs.out.reshape(-1)), outputs.out.shape[1]
        )
        return lambda n0, count: int(stream(look - n0 % look, n0, count))


def straight(code: bytes) -> Stepped:
    """Return the loop of straight-line code, from the object code of :func:`step_code`."""
    memory = native.Code(driver_code(), *_split(code))
    return Stepped({name: Called(memory, name, entry) for name, entry in ENTRIES.items()})


class DataDriven:
    """The data-driven loop, compiled or as plain Python, lane by lane."""

    def __init__(self, topology: Topology, lanes: int, interpret: bool) -> None:
        self.integers, self.layout, self.size = tables(topology)
        self.lanes = lanes
        self.lane_loop = Stepped(data_driven_loop(topology.contact_laws, topology.friction_laws, interpret))

    def _lane_memory(self, memory: Memory, lane: int) -> Memory:
        """Return a memory of its own for one lane: the loop needs scratch behind the rows of a state."""
        rows, lanes = self.layout.rows, self.lanes
        limits = np.ascontiguousarray(memory.limits.reshape(-1, 2, lanes)[:, :, lane]).reshape(-1)
        shares, broken = (array[lane : lane + 1] for array in (memory.shares, memory.broken))
        S, Q, R, C = (np.zeros(size) for size in (self.size, self.size, rows, 3))
        numbers = np.array([1, 1, rows, memory.N[RUN.parts], NO_STEP], dtype=np.int64)
        T = memory.T.reshape(lanes, -1)[lane]
        return memory._replace(
            S=S, Q=Q, R=R, C=C, T=T, I=self.integers, N=numbers, shares=shares, limits=limits, broken=broken
        )

    def __call__(self, memory: Memory) -> Take:
        """Return the function that takes steps on a memory, lane by lane."""
        rows = self.layout.rows
        states = memory.S.reshape(rows, self.lanes)
        memories = [self._lane_memory(memory, lane) for lane in range(self.lanes)]
        takes = [self.lane_loop(lane_memory) for lane_memory in memories]

        def take(n0: int, steps: int, out: Numbers, reset: bool = True, look: int = NO_STEP) -> None:
            for lane, (lane_memory, advance) in enumerate(zip(memories, takes, strict=True)):
                if lane_memory.broken[0] > 0.0:
                    continue
                lane_memory.S[:rows] = states[:, lane]
                records = np.zeros((*out.shape[:2], 1))
                advance(n0, steps, records, reset, look)
                states[:, lane], out[:, :, lane] = lane_memory.S[:rows], records[:, :, 0]

        return take

    def streaming(self, memory: Memory, outputs: Outputs, look: int) -> Callable[[int, int], int]:
        """Return the function that steps the one lane of a stream; see :meth:`Stepped.streaming`."""
        lane_memory, rows = self._lane_memory(memory, 0), self.layout.rows
        stream = self.lane_loop.streaming(lane_memory, outputs, look)

        def take(n0: int, count: int) -> int:
            lane_memory.S[:rows] = memory.S
            last = stream(n0, count)
            memory.S[:] = lane_memory.S[:rows]
            return last

        return take


class Interpreted:
    """A plain Python function with the interface of a compiled one."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def bound(self, *first: Any) -> Callable[..., Any]:
        """Return the function with its first arguments bound."""
        return partial(self.function, *first)


@lru_cache(maxsize=16)
def data_driven_loop(
    contact: tuple[type, ...], friction: tuple[type, ...], interpret: bool
) -> dict[str, Any]:
    """Return ``advance`` and ``stream`` of the data-driven loop for these laws, compiled or interpreted."""
    with WRITING:
        text = data_driven(contact, friction)
        return (
            {name: Interpreted(interpreted(text, name)) for name in ENTRIES}
            if interpret
            else dict(library(text, ENTRIES))
        )


def driver_code() -> bytes:
    """Return the object code of the driver for straight-line code, from the cache or compiled."""

    def text() -> str:
        from ..backends.modules import processor_driver  # what writes code is loaded where some is written

        return str(native.simplified(processor_driver()))

    return stored_code(("driver",), text, native.object_code)


@contextmanager
def without_collection() -> Iterator[None]:
    """Suspend Python's garbage collection: a trace consists of a hundred thousand objects that all live until
    it is written, and every collection would visit them in vain.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()


def step_code(pieces: Pieces) -> bytes:
    """Return the object code of a step: both pieces, each behind its length."""
    codes = (
        native.object_code(pieces.frequent),
        native.object_code(pieces.rare, native.LEAST_EFFORT if pieces.hurried else native.EFFORT),
    )
    return b"".join(len(code).to_bytes(8, "little") + code for code in codes)


def _split(code: bytes) -> list[bytes]:
    """Return the object codes in the result of :func:`step_code`."""
    rows, at = [], 0
    while at < len(code):
        end = at + 8 + int.from_bytes(code[at : at + 8], "little")
        rows.append(code[at + 8 : end])
        at = end
    return rows


def name_of(topology: Topology, width: int, directions: int = 0, jumps: bool = False) -> str:
    """Return the name of the cache's file with a topology's machine code."""
    numbers = str(width), f"{directions}{' jumps' if jumps else ''}"
    parts = (native.llvmlite_version(), platform.machine(), *native.processor(), *numbers)
    return f"step-{cache.digest([*cache.origin(topology), *(part.encode() for part in parts)])}.o"


@lru_cache(maxsize=64)
def straight_line(topology: Topology, width: int, directions: int = 0, jumps: bool = False) -> Stepped:
    """Return the loop of a topology in ``width`` lanes, with derivatives in ``directions`` directions, which
    contain the ``jumps`` of forces or not, from the cache or compiled.
    """

    def code() -> bytes:
        from ..backends.modules import pieces  # what writes code is loaded where some is written

        with without_collection():
            texts = pieces(topology, width, directions, jumps)
        return step_code(texts)

    with WRITING:
        return straight(cache.stored(name_of(topology, width, directions, jumps), code))


def loop_of(
    topology: Topology, loop: str, lanes: int, directions: int = 0, jumps: bool = False
) -> Stepped | DataDriven:
    """Return a loop by its name: "generated", "data-driven" or "interpreted"."""
    if loop == "generated":
        return straight_line(topology, lanes, directions, jumps)
    return DataDriven(topology, lanes, loop == "interpreted")


def forget_steps() -> None:
    """Drop all steps that this process has traced, compiled or loaded, because the text of a law changed."""
    from ..trace.straight_line import steps_of  # what writes steps is loaded where one is written
    from .ptx import program

    for cached in (data_driven_loop, straight_line, steps_of, program):
        cached.cache_clear()


def compiler_of(loop: str) -> dict[str, str]:
    """Return the compiler of a loop with its version; empty for the interpreted loop."""
    return {} if loop == "interpreted" else {"llvmlite": native.llvmlite_version()}


def python_line(topology: Topology) -> Stepped:
    """Return the straight-line code of a topology as a loop of plain Python with one lane: slow, for
    debugging.
    """
    from ..backends.python import module

    space: dict[str, Any] = {"sqrt": math.sqrt}
    # The text is our own and the user's laws, never a model file's.
    exec(compile(module(topology), "<vfife straight line>", "exec"), space)
    return Stepped({name: Interpreted(space[name]) for name in ENTRIES})
