"""A run and how it changes with numbers of its model: each step carries its derivatives along, in several
directions in each lane.

What a direction changes at the start is known from two assemblies, a little to both sides of the model. The
run has the bits that it has alone.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..compiler.runtime.native import CONTACT_LANES
from ..compiler.runtime.runner import Runner
from ..errors import VfifeError
from .interrupts import ChunkSize, Workers
from .record import Columns, Record, recorded_rows

Array = NDArray[np.float64]
DIRECTIONS = 1, 3, 5  # in each lane: more are cheaper each, and take longer to compile
Pairs: TypeAlias = "list[tuple[Record, Record]]"  # of a number, one for each of some displaced runs


@dataclass(frozen=True)
class Neighbours:
    """A model whose number is a little larger, ``up``, and a little smaller, ``down``; they are ``apart`` in
    that number.
    """

    up: Assembly
    down: Assembly
    apart: float


def comparable(assembly: Assembly, one: Neighbours) -> bool:
    """Whether the neighbours of an assembly are stepped as it is: one topology, as many steps, functions with
    as many pieces and one period.
    """
    for other in (one.up, one.down):
        alike = (other.topology, other.choice.steps, other.choice.outputs_every) == (
            assembly.topology, assembly.choice.steps, assembly.choice.outputs_every,
        )  # fmt: skip
        if (
            not alike
            or len(other.tables) != len(assembly.tables)
            or not np.array_equal(_fixed(other), _fixed(assembly))
        ):
            return False
    return True


def _fixed(assembly: Assembly) -> Array:
    """Of each function the number of its pieces, and its period with the kinks in it."""
    T = assembly.tables
    return np.concatenate(
        [np.zeros(0), *(T[start : _first(T, start)] for start in assembly.topology.function_start)]
    )


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
    """The tables of the functions' change with a number, at a fixed argument: a piece that begins later is so
    much earlier in itself.
    """
    T = assembly.tables.copy()
    for start in assembly.topology.function_start:
        first, count = _first(T, start), abs(int(T[start]))
        rows = _rows(first, count)
        later = (one.up.tables[first : first + count] - one.down.tables[first : first + count]) / one.apart
        T[rows] = (one.up.tables[rows] - one.down.tables[rows]) / one.apart - later[:, None] * _derived(
            assembly.tables[rows]
        )
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


def displaced(count: int, parts: int) -> tuple[float, ...]:
    """First steps (1) of so many runs, evenly spread both in a step and in the ``parts`` that one with an
    event is taken again in.

    An onset falls elsewhere in its step in each of them; runs displaced by whole parts would all have it at
    one place in its part.
    """
    return tuple((k * parts // count + k / count) / parts for k in range(count))


def tangents(
    assembly: Assembly,
    every: Sequence[Neighbours],
    shares: Sequence[float] = (0.0,),
    lanes: int | None = None,
    *,
    kept: NDArray[np.uint32] | None = None,
    whole: bool = False,
) -> list[Pairs]:
    """Of each neighbourhood the records of its two models, as far as first derivatives tell them: the run
    plus and minus its change.

    There is a pair for each of ``shares``, first steps (1) by which a run is displaced; that of 0 is the run
    itself. Every neighbourhood has to be
    :func:`comparable`. What the two differ by, over ``apart``, is the derivative of whatever is taken of a
    record. Records have the rows ``kept``, all states and extremes without them, of all outputs; ``whole``:
    of the last turn as one output, and of what comes before it as another, which is enough for extremes.
    Passes go side by side on all cores. Ctrl-C is heard within a quarter of a second.
    """
    lanes = max(
        lanes or CONTACT_LANES, len(shares)
    )  # the last bits of differences know their neighbours: the same ones on every machine
    cores, groups = os.cpu_count() or 1, lanes // len(shares)
    directions = next((few for few in DIRECTIONS if few * groups * cores >= len(every)), DIRECTIONS[-1])
    rows = recorded_rows(assembly) if kept is None else kept
    passes = [
        every[first : first + groups * directions] for first in range(0, len(every), groups * directions)
    ]

    def pairs_of(some: Sequence[Neighbours]) -> list[Pairs]:
        return _together(
            assembly, some, np.array(shares), lanes, directions, rows, spans(assembly, whole), workers.look
        )

    with Workers(min(cores, len(passes))) as workers:
        jobs = [workers.submit(pairs_of, some) for some in passes]
        for _ in workers.results(jobs):
            pass
        return [pairs for job in jobs for pairs in job.result()]


def spans(assembly: Assembly, whole: bool) -> list[tuple[int, int]]:
    """Steps between two outputs, and how many such outputs: all of a run, or its last turn as one."""
    choice = assembly.choice
    if not whole:
        return [(choice.outputs_every, choice.outputs)]
    turn = choice.steps if choice.turn is None else choice.turn / choice.step
    before = round(choice.steps - turn)
    return [(before, 1), (choice.steps - before, 1)] if before > 0 else [(choice.steps, 1)]


def jacobian(
    assembly: Assembly,
    every: Sequence[Neighbours],
    look: Callable[[Record], Array],
    shares: Sequence[float] = (0.0,),
) -> tuple[Array, Array]:
    """What ``look`` takes of the record of a run, shape (values,), and its derivatives by numbers, shape
    (values, numbers), by one run.

    ``look``: a smooth function of the rows of a record, shape (values,): a series, measures. Means over
    displaced runs, where there are ``shares``. Raises ValueError for neighbours that are not
    :func:`comparable`.
    """
    if not all(comparable(assembly, one) for one in every):
        raise VfifeError(
            "a number changes the topology, the number of steps or the pieces of a function; take two runs"
            " for its derivative"
        )
    values, columns = [], []
    for one, pairs in zip(every, tangents(assembly, every, shares), strict=True):
        both = np.array([[look(up), look(down)] for up, down in pairs])
        values.append(both.mean(axis=(0, 1)))
        columns.append((both[:, 0] - both[:, 1]).mean(axis=0) / one.apart)
    return values[0], np.stack(columns, axis=1)


def _together(
    assembly: Assembly, some: Sequence[Neighbours], shares: Array, lanes: int, directions: int, kept: NDArray[np.uint32],
    parts: list[tuple[int, int]], look: Callable[[], None],
) -> list[Pairs]:  # fmt: skip
    rows = assembly.layout.rows
    state, table = (
        np.zeros((directions + 1, rows, lanes)),
        np.zeros((lanes, directions + 2, len(assembly.tables))),
    )
    state[0], table[:, 0], table[:, 1] = assembly.state[:, None], assembly.tables, rates(assembly)
    table[:, 2:] = assembly.tables  # with the head that every table has, also where nothing changes
    groups = lanes // len(shares)
    places = [
        (slice(group * len(shares), (group + 1) * len(shares)), way)
        for way in range(directions)
        for group in range(groups)
    ]
    for (where, way), one in zip(places, some, strict=False):
        state[way + 1, :, where] = ((one.up.state - one.down.state) / one.apart)[:, None]
        table[where, way + 2] = changes(assembly, one)
    every = np.concatenate([kept + np.uint32(k * rows) for k in range(directions + 1)])
    runner = Runner(
        assembly.topology, state.reshape(-1, lanes), table.reshape(lanes, -1), "generated", every,
        parts=assembly.mechanism.settings.parts, shares=np.resize(shares, lanes), directions=directions,
    )  # fmt: skip
    pace = ChunkSize(look)
    found = np.concatenate(
        [runner.advance(1, 1), *[pace.advance(runner, count, outputs) for count, outputs in parts]]
    )
    steps = np.concatenate(
        [[0], np.cumsum([count for count, outputs in parts for _ in range(outputs)])]
    ).astype(np.int64)
    values = found.reshape(len(found), directions + 1, len(kept), lanes)
    seen = Columns(assembly.layout, kept)
    return [
        [
            _pair(one, steps, seen, values[:, 0, :, lane], values[:, way + 1, :, lane])
            for lane in range(where.start, where.stop)
        ]
        for (where, way), one in zip(places, some, strict=False)
    ]


def _pair(
    one: Neighbours, steps: NDArray[np.int64], seen: Columns, rows: Array, slopes: Array
) -> tuple[Record, Record]:
    """The records of both sides of one run."""
    largest = np.isin(seen.kept, seen.layout.of("extreme"))
    both = rows + 0.5 * one.apart * slopes, rows - 0.5 * one.apart * slopes
    for side in both:
        side[:, largest] = np.maximum(side[:, largest], 0.0)  # a size has no sign
    up, down = (
        Record(model, steps, side, seen.kept, columns=seen)
        for model, side in zip((one.up, one.down), both, strict=True)
    )
    return up, down
