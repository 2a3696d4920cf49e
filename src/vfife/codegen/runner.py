"""The two loops behind one face: state in, recorded rows out."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.topology import Topology
from .compile import compiled, interpreted, remembered
from .graph import tables
from .inline import written_out
from .source import data_driven
from .straight_line import straight_line

Rows = NDArray[np.float64]


def aligned(count: int) -> Rows:
    """Zeros that begin a cache line: vector loads that straddle two lines cost a quarter of the speed."""
    space = np.zeros(count + 8)
    skip = (-space.ctypes.data // 8) % 8
    return space[skip : skip + count]


@lru_cache(maxsize=16)
def _data_driven(contact: tuple[type, ...], friction: tuple[type, ...], interpret: bool) -> Callable[..., Any]:
    if interpret:
        return interpreted(data_driven(contact, friction), "advance")

    def make() -> str:
        return written_out(data_driven(contact, friction), "advance")

    sources = _sources(contact + friction)
    return compiled(remembered(sources, make) if sources else make(), "advance")


def _sources(laws: tuple[type, ...]) -> list[bytes]:
    """All that the data-driven text of the package's own laws is made from; nothing for laws from elsewhere, which may call anything."""
    package = Path(__file__).parents[1]
    names = [f"{law.__module__}.{law.__qualname__}" for law in laws]
    if not all(name.startswith("vfife.laws.") for name in names):
        return []
    files = sorted([*package.glob("kernels/*.py"), *package.glob("codegen/*.py"), *package.glob("laws/**/*.py")])
    return [*(name.encode() for name in names), *(file.read_bytes() for file in files)]


@lru_cache(maxsize=16)
def _straight_line(topology: Topology, lanes: int, interpret: bool) -> Callable[..., Any]:
    body = straight_line(topology, lanes)
    return interpreted(body, "advance") if interpret else compiled(body, "advance")


class Runner:
    """Advances one or more simulations of one topology, all lanes in step.

    ``loop``: "data-driven" (one lane), "generated" (any number of lanes), or "interpreted" (the data-driven text as plain Python).
    ``states`` has shape (rows, lanes), ``tables`` (lanes, length). ``advance`` takes ``outputs`` times ``count`` steps and returns the rows
    ``kept`` after each ``count``, shape (outputs, kept, lanes).
    """

    def __init__(self, topology: Topology, states: Rows, functions: Rows, loop: str, kept: NDArray[np.uint32]) -> None:
        self.topology, self.loop, self.kept = topology, loop, kept
        self.integers, self.layout, self.rows = tables(topology)
        self.lanes = states.shape[1]
        self.extremes = np.array(self.layout.of("extreme"), dtype=np.uint32)
        self.functions = np.ascontiguousarray(functions, dtype=float).reshape(-1)
        self.done = 0
        self.single = _data_driven(topology.contact_laws, topology.friction_laws, loop == "interpreted")
        self.wide = _straight_line(topology, self.lanes, False) if loop == "generated" else None
        self.S = aligned((self.layout.rows + 1) * self.lanes)
        self.S.reshape(-1, self.lanes)[: self.layout.rows] = states
        self.states[self.layout["c"]] = self.states[self.layout["cn"]] = 1.0
        self.scratch = np.zeros(self.rows)
        self.spare = np.zeros(self.layout.rows * self.lanes)
        self.nothing = np.zeros(0, dtype=np.uint32), np.zeros((1, 0, self.lanes))
        if self.wide is not None:  # compiles, so that the run is not timed with it
            self.wide(self.S, self.functions, 0, 1, 0, np.zeros((0, len(kept), self.lanes)), kept, self.extremes, self.spare)

    @property
    def states(self) -> Rows:
        """Present state, shape (rows, lanes)."""
        return self.S.reshape(-1, self.lanes)[: self.layout.rows]

    def advance(self, count: int, outputs: int) -> Rows:
        """``outputs`` times ``count`` steps from where the state is."""
        out = np.zeros((outputs, len(self.kept), self.lanes))
        if self.wide is None:
            self._single(self.done, count, out, self.kept, self.extremes)
        else:
            self._wide(self.wide, count, out)
        self.done += count * outputs
        return out

    def _wide(self, wide: Callable[..., Any], count: int, out: Rows) -> None:
        total, done = count * len(out), 0
        if self.done == 0:  # the first step starts the central difference and is not in the straight line
            self._single(0, 1, self.nothing[1], self.nothing[0], self.extremes)
            done = self._note(1, count, out)
        while done < total:
            done = wide(self.S, self.functions, self.done, count, done, out, self.kept, self.extremes, self.spare)
            if done < total:
                self._single(self.done + done, 1, self.nothing[1], self.nothing[0], self.nothing[0])
                done = self._note(done + 1, count, out)

    def _note(self, done: int, count: int, out: Rows) -> int:
        if done % count == 0:
            out[done // count - 1] = self.states[self.kept]
        return done

    def _single(self, n: int, count: int, out: Rows, kept: NDArray[np.uint32], extremes: NDArray[np.uint32]) -> None:
        """The data-driven loop on every lane."""
        self.single(self.scratch, self.functions, self.integers, self.S, self.layout.rows, self.lanes, n, count, out, kept, extremes)
