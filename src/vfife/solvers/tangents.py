"""A run and how it changes with numbers of its model: each step carries its derivatives along, in several directions in each lane.

What a direction changes at the start is known from two assemblies, a little to both sides of the model. The run has the bits that it has alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..codegen.native import widest
from ..codegen.runner import Runner
from .halt import Halt
from .pace import Pace
from .record import Record, recorded_rows

Array = NDArray[np.float64]
DIRECTIONS = 2  # in each lane: more are cheaper each, and take longer to compile


@dataclass(frozen=True)
class Neighbours:
    """A model whose number is a little larger, ``up``, and a little smaller, ``down``; they are ``apart`` in that number."""

    up: Assembly
    down: Assembly
    apart: float


def comparable(assembly: Assembly, one: Neighbours) -> bool:
    """Whether the neighbours of an assembly are stepped as it is: one topology, as many steps, functions with as many pieces and one period."""
    for other in (one.up, one.down):
        alike = (other.topology, other.choice.steps, other.choice.outputs_every) == (
            assembly.topology, assembly.choice.steps, assembly.choice.outputs_every,
        )  # fmt: skip
        if not alike or len(other.tables) != len(assembly.tables) or not np.array_equal(_fixed(other), _fixed(assembly)):
            return False
    return True


def _fixed(assembly: Assembly) -> Array:
    """Of each function the number of its pieces, and its period with the kinks in it."""
    T = assembly.tables
    return np.concatenate([np.zeros(0), *(T[start : _first(T, start)] for start in assembly.topology.function_start)])


def _first(T: Array, start: int) -> int:
    """Where the start times of a function's pieces lie in the tables."""
    return start + (1 if T[start] > 0.0 else 3)


def rates(assembly: Assembly) -> Array:
    """The tables of the functions' derivatives by their argument."""
    T = assembly.tables.copy()
    for rows in _pieces(assembly):
        T[rows] = _derived(T[rows])
    return T


def changes(assembly: Assembly, one: Neighbours) -> Array:
    """The tables of the functions' change with a number, at a fixed argument: a piece that begins later is so much earlier in itself."""
    T = assembly.tables.copy()
    for start in assembly.topology.function_start:
        first, count = _first(T, start), abs(int(T[start]))
        rows = _rows(first, count)
        later = (one.up.tables[first : first + count] - one.down.tables[first : first + count]) / one.apart
        T[rows] = (one.up.tables[rows] - one.down.tables[rows]) / one.apart - later[:, None] * _derived(assembly.tables[rows])
    return T


def _pieces(assembly: Assembly) -> Iterator[NDArray[np.intp]]:
    for start in assembly.topology.function_start:
        yield _rows(_first(assembly.tables, start), abs(int(assembly.tables[start])))


def _rows(first: int, count: int) -> NDArray[np.intp]:
    """Where the coefficients of pieces lie, shape (pieces, 7)."""
    return (first + count + np.arange(7 * count)).reshape(count, 7)


def _derived(coefficients: Array) -> Array:
    """Coefficients of derivatives, constant first."""
    derived = np.zeros_like(coefficients)
    derived[:, :-1] = coefficients[:, 1:] * np.arange(1, coefficients.shape[1])
    return derived


def tangents(
    assembly: Assembly, every: Sequence[Neighbours], shares: Sequence[float] = (0.0,), lanes: int | None = None
) -> Iterator[list[tuple[Record, Record]]]:
    """Of each neighbourhood the records of its two models, as far as first derivatives tell them: the run plus and minus its change.

    There is a pair for each of ``shares``, first steps (1) by which a run is displaced; that of 0 is the run itself. Every neighbourhood has to be
    :func:`comparable`. What the two differ by, over ``apart``, is the derivative of whatever is taken of a record. Ctrl-C is heard within a quarter
    of a second.
    """
    lanes = max(lanes or widest(), len(shares))
    at_once = lanes // len(shares) * DIRECTIONS
    for first in range(0, len(every), at_once):
        yield from _together(assembly, every[first : first + at_once], np.array(shares), lanes)


def _together(assembly: Assembly, some: Sequence[Neighbours], shares: Array, lanes: int) -> Iterator[list[tuple[Record, Record]]]:
    kept, rows, choice = recorded_rows(assembly), assembly.layout.rows, assembly.choice
    state, table = np.zeros((DIRECTIONS + 1, rows, lanes)), np.zeros((lanes, DIRECTIONS + 2, len(assembly.tables)))
    state[0], table[:, 0], table[:, 1] = assembly.state[:, None], assembly.tables, rates(assembly)
    table[:, 2:] = assembly.tables  # with the head that every table has, also where nothing changes
    places = [(slice(group * len(shares), (group + 1) * len(shares)), way) for group in range(len(some)) for way in range(DIRECTIONS)]
    for (where, way), one in zip(places, some, strict=False):
        state[way + 1, :, where] = ((one.up.state - one.down.state) / one.apart)[:, None]
        table[where, way + 2] = changes(assembly, one)
    every = np.concatenate([kept + np.uint32(k * rows) for k in range(DIRECTIONS + 1)])
    runner = Runner(
        assembly.topology, state.reshape(-1, lanes), table.reshape(lanes, -1), "generated", every,
        parts=assembly.mechanism.settings.parts, shares=np.resize(shares, lanes), directions=DIRECTIONS,
    )  # fmt: skip
    with Halt() as halt:
        start = runner.advance(1, 1)
        found = np.concatenate([start, Pace(halt.look).advance(runner, choice.outputs_every, choice.outputs)])
    parts = found.reshape(len(found), DIRECTIONS + 1, len(kept), lanes)
    for (where, way), one in zip(places, some, strict=False):
        yield [_pair(assembly, one, kept, parts[:, 0, :, lane], parts[:, way + 1, :, lane]) for lane in range(where.start, where.stop)]


def _pair(assembly: Assembly, one: Neighbours, kept: NDArray[np.uint32], rows: Array, slopes: Array) -> tuple[Record, Record]:
    """The records of both sides of one run."""
    steps = np.arange(len(rows), dtype=np.int64) * assembly.choice.outputs_every
    largest = np.isin(kept, assembly.layout.of("extreme"))
    both = rows + 0.5 * one.apart * slopes, rows - 0.5 * one.apart * slopes
    for side in both:
        side[:, largest] = np.maximum(side[:, largest], 0.0)  # a size has no sign
    return Record(one.up, steps, both[0], kept), Record(one.down, steps, both[1], kept)
