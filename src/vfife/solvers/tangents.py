"""Runs with derivatives that are computed along with each step: by numbers of the model, and the growth of a
small difference (Lyapunov exponents).

A step's own derivative (``compiler/trace/tangent.py``) is exact for the run as it is. Differences of runs
would need a distance that is neither lost in rounding nor affected by impacts that begin or end in between.
The derivative of the start and of the parameters is the difference of two assemblies, a little to both sides
of the model. The run has the same bits as without derivatives.
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
from ..numerics.elementwise import log
from .interrupts import ChunkSize, Workers
from .record import Columns, Record, recorded_rows

Array = NDArray[np.float64]
# Numbers of directions in a lane for which steps are compiled: more directions are cheaper each, but take
# longer to compile.
DIRECTIONS = 1, 3, 5
# Records of both models of one neighbourhood, a pair for each displaced run.
Pairs: TypeAlias = "list[tuple[Record, Record]]"


@dataclass(frozen=True)
class Neighbours:
    """Two assemblies, ``up`` and ``down``, with a number of the model a little larger and a little smaller;
    ``distance`` is the difference of the number.
    """

    up: Assembly
    down: Assembly
    distance: float


def comparable(assembly: Assembly, one: Neighbours) -> bool:
    """Return whether neighbours can be stepped like the assembly: the same topology and number of steps, and
    functions with the same number of pieces and the same period.
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
    """Return the head of each function's table: its number of pieces, its period, and the kinks in it."""
    T = assembly.tables
    return np.concatenate(
        [np.zeros(0), *(T[start : _first(T, start)] for start in assembly.topology.function_start)]
    )


def _first(T: Array, start: int) -> int:
    """Return the index of the start times of a function's pieces in the tables."""
    return start + (1 if T[start] > 0.0 else 3)


def rates(assembly: Assembly) -> Array:
    """Return the tables of the derivatives of all functions by their argument."""
    T = assembly.tables.copy()
    for rows in _pieces(assembly):
        T[rows] = _derived(T[rows])
    return T


def changes(assembly: Assembly, one: Neighbours) -> Array:
    """Return the tables of the derivatives of all functions by a number of the model, at a fixed argument.

    A piece is a polynomial of the argument counted from its beginning. If the beginning depends on the
    number, too, the derivative by the argument times that dependence is subtracted.
    """
    T = assembly.tables.copy()
    for start in assembly.topology.function_start:
        first, count = _first(T, start), abs(int(T[start]))
        rows = _rows(first, count)
        later = (one.up.tables[first : first + count] - one.down.tables[first : first + count]) / one.distance
        T[rows] = (one.up.tables[rows] - one.down.tables[rows]) / one.distance - later[:, None] * _derived(
            assembly.tables[rows]
        )
    return T


def _pieces(assembly: Assembly) -> Iterator[NDArray[np.intp]]:
    for start in assembly.topology.function_start:
        yield _rows(_first(assembly.tables, start), abs(int(assembly.tables[start])))


def _rows(first: int, count: int) -> NDArray[np.intp]:
    """Return the indices of the coefficients of pieces, shape (pieces, 7)."""
    return (first + count + np.arange(7 * count)).reshape(count, 7)


def _derived(coefficients: Array) -> Array:
    """Return the coefficients of the derivatives of polynomials, constant first."""
    derived = np.zeros_like(coefficients)
    derived[:, :-1] = coefficients[:, 1:] * np.arange(1, coefficients.shape[1])
    return derived


def displaced(count: int, parts: int) -> tuple[float, ...]:
    """Return the first steps, as shares of a step, of ``count`` displaced runs: spread evenly over a step and
    over the ``parts`` in which a step with an event is repeated.

    An event then lies elsewhere in its step, and elsewhere in its part, in each run. Runs displaced by whole
    parts would all have it at the same place in a part.
    """
    return tuple((k * parts // count + k / count) / parts for k in range(count))


def tangents(
    assembly: Assembly,
    near: Sequence[Neighbours],
    shares: Sequence[float] = (0.0,),
    lanes: int | None = None,
    *,
    recorded: NDArray[np.uint32] | None = None,
    last_turn: bool = False,
) -> list[Pairs]:
    """Return records of the two models of each of ``near``, to first order: the run plus and minus its
    change. The difference of any measure of the two, over ``distance``, is its derivative.

    There is a pair for each of ``shares``, first steps as shares of a step by which the run is displaced; 0
    is the run itself. Every neighbourhood has to be :func:`comparable`. Records have the rows ``recorded``,
    by default all states and extremes, at all outputs. With ``last_turn`` the last turn is one output and all
    before it another, which suffices for measures of extremes. Passes run side by side on all cores. Ctrl-C
    is handled within a quarter of a second.
    """
    # The last bits of a derivative depend on its neighbours in the lanes, so there are as many lanes on every
    # machine.
    lanes = max(lanes or CONTACT_LANES, len(shares))
    cores, groups = os.cpu_count() or 1, lanes // len(shares)
    # With as few directions as occupy all cores the step is quickest to compile; more directions in a lane
    # are cheaper each.
    directions = next((few for few in DIRECTIONS if few * groups * cores >= len(near)), DIRECTIONS[-1])
    rows = recorded_rows(assembly) if recorded is None else recorded
    passes = [near[first : first + groups * directions] for first in range(0, len(near), groups * directions)]
    with Workers(min(cores, len(passes))) as workers:
        one_pass = TangentPass(
            assembly, np.array(shares), lanes, directions, rows, spans(assembly, last_turn), workers.look
        )
        jobs = [workers.submit(one_pass.pairs, some) for some in passes]
        for _ in workers.results(jobs):
            pass
        return [pairs for job in jobs for pairs in job.result()]


def spans(assembly: Assembly, last_turn: bool) -> list[tuple[int, int]]:
    """Return pairs of steps between two outputs and number of outputs, which make up the run."""
    choice = assembly.choice
    if not last_turn:
        return [(choice.outputs_every, choice.outputs)]
    turn = choice.steps if choice.turn is None else choice.turn / choice.step
    before = round(choice.steps - turn)
    return [(before, 1), (choice.steps - before, 1)] if before > 0 else [(choice.steps, 1)]


@dataclass(frozen=True)
class TangentPass:
    """A run with the derivatives of some neighbourhoods, ``directions`` in each lane.

    A group of lanes has the displaced runs of one neighbourhood side by side (``shares``). The next
    neighbourhoods take the next groups, and when all groups are occupied, the next direction. ``parts`` are
    pairs of steps between two outputs and number of outputs.
    """

    assembly: Assembly
    shares: Array
    lanes: int
    directions: int
    recorded: NDArray[np.uint32]
    parts: list[tuple[int, int]]
    look: Callable[[], None]

    def pairs(self, near: Sequence[Neighbours]) -> list[Pairs]:
        """Return the pairs of records of each neighbourhood."""
        assembly, lanes, directions, width = self.assembly, self.lanes, self.directions, len(self.shares)
        rows, groups = assembly.layout.rows, lanes // width
        # The state is followed by its derivatives in each direction; the tables of a lane by those of their
        # derivatives by the argument, and by their derivatives in each direction. All tables need a head.
        state = np.zeros((directions + 1, rows, lanes))
        table = np.zeros((lanes, directions + 2, len(assembly.tables)))
        state[0], table[:, 0], table[:, 1] = assembly.state[:, None], assembly.tables, rates(assembly)
        table[:, 2:] = assembly.tables
        places = [
            (slice(group * width, (group + 1) * width), way)
            for way in range(directions)
            for group in range(groups)
        ]
        for (where, way), one in zip(places, near, strict=False):
            state[way + 1, :, where] = ((one.up.state - one.down.state) / one.distance)[:, None]
            table[where, way + 2] = changes(assembly, one)
        handed = np.concatenate([self.recorded + np.uint32(k * rows) for k in range(directions + 1)])
        runner = Runner(
            assembly.topology, state.reshape(-1, lanes), table.reshape(lanes, -1), "generated", handed,
            parts=assembly.mechanism.settings.parts, shares=np.resize(self.shares, lanes),
            directions=directions,
        )  # fmt: skip
        pace = ChunkSize(self.look)
        trace = np.concatenate(
            [runner.advance(1, 1), *[pace.advance(runner, count, outputs) for count, outputs in self.parts]]
        )
        steps = np.concatenate(
            [[0], np.cumsum([count for count, outputs in self.parts for _ in range(outputs)])]
        ).astype(np.int64)
        values = trace.reshape(len(trace), directions + 1, len(self.recorded), lanes)
        columns = Columns(assembly.layout, self.recorded)
        return [
            [
                _pair(one, steps, columns, values[:, 0, :, lane], values[:, way + 1, :, lane])
                for lane in range(where.start, where.stop)
            ]
            for (where, way), one in zip(places, near, strict=False)
        ]


def _pair(
    one: Neighbours, steps: NDArray[np.int64], columns: Columns, rows: Array, slopes: Array
) -> tuple[Record, Record]:
    """Return the records of both sides of one run."""
    largest = np.isin(columns.row_numbers, columns.layout.of("extreme"))
    both = rows + 0.5 * one.distance * slopes, rows - 0.5 * one.distance * slopes
    for side in both:
        side[:, largest] = np.maximum(side[:, largest], 0.0)  # a size has no sign
    up, down = (
        Record(model, steps, side, columns.row_numbers, columns=columns)
        for model, side in zip((one.up, one.down), both, strict=True)
    )
    return up, down


# ----------------------------------------------------------------------------------------- Lyapunov exponents

ALIGNED = 10  # turns in which a difference aligns with the direction of its largest growth


def steps_of_turn(assembly: Assembly) -> int:
    """Return the number of steps in a turn."""
    return round((assembly.choice.turn or 0.0) / assembly.choice.step)


class LyapunovRunner:
    """Motions in lanes, each with a small difference whose growth is followed turn by turn.

    The difference is the step's own derivative, scaled back to length one after each turn (Benettin et al.,
    Meccanica 15 (1980) 9-30). It begins as the derivative by a number of the model (``near``, for each lane),
    which ideal joints permit; after a turn the number's own difference is set to zero, and only that of the
    motion remains. A random difference would violate the joints.

    ``look`` is called a few times a second; an exception that it raises ends a call.
    """

    def __init__(
        self,
        assemblies: Sequence[Assembly],
        near: Sequence[Neighbours],
        look: Callable[[], None] | None = None,
    ) -> None:
        first = assemblies[0]
        self.rows, self.lanes, self.turn, self.pace = (
            first.layout.rows,
            len(assemblies),
            steps_of_turn(first),
            ChunkSize(look),
        )
        self.parameters = np.array(first.layout.of("parameter"), dtype=np.intp)
        self.weights = np.stack([weights(one) for one in assemblies], axis=1)
        self.seeds, self.changes = (
            np.zeros((self.rows, self.lanes)),
            [changes(*both) for both in zip(assemblies, near, strict=True)],
        )
        for k, one in enumerate(near):
            self.seeds[self.parameters, k] = ((one.up.state - one.down.state) / one.distance)[self.parameters]
        states, tables = np.zeros((2 * self.rows, self.lanes)), np.tile(first.tables, (self.lanes, 3))
        parts = first.mechanism.settings.parts
        self.runner = Runner(
            first.topology, states, tables, "generated", recorded_rows(first), parts=parts, directions=1
        )
        self.fresh = True

    @property
    def states(self) -> Array:
        """The motions followed by their differences, shape (2 rows, lanes)."""
        return self.runner.states

    def begin(self, assemblies: Sequence[Assembly], states: Array, done: int) -> None:
        """Begin from states after ``done`` steps: motions, shape (rows, lanes), with differences by the
        number, or motions and differences, shape (2 rows, lanes).
        """
        self.fresh = len(states) == self.rows
        self.states[: len(states)], self.runner.done = states, done
        if self.fresh:
            self.states[self.rows :] = self.seeds
        self._tables(assemblies)

    def _tables(self, assemblies: Sequence[Assembly]) -> None:
        tables = self.runner.functions.reshape(self.lanes, 3, -1)
        for k, one in enumerate(assemblies):
            tables[k] = (
                one.tables,
                rates(one),
                self.changes[k] if self.fresh else changes(one, Neighbours(one, one, 1.0)),
            )

    def turns(self, assemblies: Sequence[Assembly], count: int) -> tuple[Array, Array]:
        """Make ``count`` turns; return the rows after each, shape (turns, rows, lanes), and the logarithm of
        the growth in each, shape (turns, lanes).
        """
        rows, growth = (
            np.zeros((count, len(self.runner.row_numbers), self.lanes)),
            np.zeros((count, self.lanes)),
        )
        other = self.states[self.rows :]
        for turn in range(count):
            rows[turn] = self.pace.advance(self.runner, self.turn, 1)[0]
            if self.fresh:
                self.fresh, other[self.parameters] = False, 0.0
                self._tables(assemblies)
            with np.errstate(over="ignore", invalid="ignore"):
                own = np.ascontiguousarray(
                    (self.weights * other).T
                )  # summed in one order, however many lanes there are
                size = np.maximum(np.sqrt((own * own).sum(axis=1)), 1e-300)
                other /= size
                growth[turn] = log(size)
        return rows, growth


def weights(assembly: Assembly) -> Array:
    """Return the weight of each row in the norm of a difference, shape (rows,): for velocities the root of
    kinetic energy, for positions the same times the crank's mean rate.
    """
    layout, result = assembly.layout, np.zeros(assembly.layout.rows)
    rate = 2.0 * np.pi / (assembly.choice.turn or 2.0 * np.pi)
    for inverse, places, speeds in (("mass", "xy", "uv"), ("inertia", ("theta",), "w")):
        values = assembly.state[layout[f"particle_inverse_{inverse}"]]
        root = np.sqrt(np.divide(1.0, values, out=np.zeros_like(values), where=values > 0.0))
        for place in places:
            result[layout[f"particle_{place}"]] = rate * root
        for speed in speeds:
            result[layout[f"particle_{speed}"]] = root
    return result
