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
from ..kernels.jumps import TOUCH
from ..kernels.topology import STOP
from ..numerics.elementwise import log
from .interrupts import ChunkSize, Workers
from .record import Columns, Record, recorded_rows

Array = NDArray[np.float64]
# Numbers of directions in a lane for which steps are compiled: more directions are cheaper each, but take
# longer to compile.
DIRECTIONS = 1, 3, 5
# A force (SI) above this at first touch is a jump: powers of the penetration TOUCH are far below.
LEAST_JUMP = 1e-100
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

    @property
    def state_slope(self) -> Array:
        """Derivative of the start by the number, shape (rows,)."""
        return (self.up.state - self.down.state) / self.distance


def comparable(assembly: Assembly, neighbours: Neighbours) -> bool:
    """Return whether neighbours can be stepped like the assembly: the same topology and number of steps, and
    functions with the same number of pieces and the same period.
    """
    for side in (neighbours.up, neighbours.down):
        alike = (side.topology, side.choice.steps, side.choice.outputs_every) == (
            assembly.topology, assembly.choice.steps, assembly.choice.outputs_every,
        )  # fmt: skip
        if (
            not alike
            or len(side.tables) != len(assembly.tables)
            or not np.array_equal(_fixed(side), _fixed(assembly))
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


def force_jumps(assembly: Assembly) -> bool:
    """Return whether the force of some contact or stop jumps where it is first touched, found by the value of
    its law or damper.
    """
    topology, state = assembly.topology, assembly.state
    dampers = [
        state[assembly.layout.row("spring_damping", k) + 2]
        for k, kind in enumerate(topology.spring_kind)
        if kind == STOP
    ]
    contacts = assembly.mechanism.contacts
    laws = [
        contacts[joint].contact.force(TOUCH, 1.0, assembly.contact_slots(k))
        for k, joint in enumerate(assembly.contact_joints)
        if not topology.knots[k][1]
    ]
    return any(abs(force) > LEAST_JUMP for force in (*dampers, *(part for law in laws for part in law)))


def rates(assembly: Assembly) -> Array:
    """Return the tables of the derivatives of all functions by their argument."""
    T = assembly.tables.copy()
    for rows in _pieces(assembly):
        T[rows] = _derived(T[rows])
    return T


def changes(assembly: Assembly, neighbours: Neighbours) -> Array:
    """Return the tables of the derivatives of all functions by a number of the model, at a fixed argument.

    A piece is a polynomial of the argument counted from its beginning. If the beginning depends on the
    number, too, the derivative by the argument times that dependence is subtracted.
    """
    T = assembly.tables.copy()
    slope = (neighbours.up.tables - neighbours.down.tables) / neighbours.distance
    for start in assembly.topology.function_start:
        first, count = _first(T, start), abs(int(T[start]))
        rows = _rows(first, count)
        begins = slope[first : first + count]
        T[rows] = slope[rows] - begins[:, None] * _derived(assembly.tables[rows])
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
    neighbourhoods: Sequence[Neighbours],
    shares: Sequence[float] = (0.0,),
    *,
    recorded: NDArray[np.uint32] | None = None,
    last_turn: bool = False,
) -> list[Pairs]:
    """Return records of the two models of each of ``neighbourhoods``, to first order: the run plus and minus
    its change. The difference of any measure of the two, over ``distance``, is its derivative.

    There is a pair for each of ``shares``, first steps as shares of a step by which the run is displaced; 0
    is the run itself. Every neighbourhood has to be :func:`comparable`. Records have the rows ``recorded``,
    by default all states and extremes, at all outputs. With ``last_turn`` the last turn is one output and all
    before it another, which suffices for measures of extremes. Passes run side by side on all cores. Ctrl-C
    is handled within a quarter of a second.
    """
    lanes, size, directions = pass_size(len(neighbourhoods), len(shares))
    cores = os.cpu_count() or 1
    rows = recorded_rows(assembly) if recorded is None else recorded
    passes = [neighbourhoods[first : first + size] for first in range(0, len(neighbourhoods), size)]
    with Workers(min(cores, len(passes))) as workers:
        one_pass = TangentPass(
            assembly,
            np.array(shares),
            lanes,
            directions,
            rows,
            spans(assembly, last_turn),
            workers.look,
            force_jumps(assembly),
        )
        jobs = [workers.submit(one_pass.pairs, chunk) for chunk in passes]
        for _ in workers.results(jobs):
            pass
        return [pairs for job in jobs for pairs in job.result()]


def pass_size(count: int, displaced_runs: int) -> tuple[int, int, int]:
    """Return the lanes of a pass, how many of ``count`` neighbourhoods it takes, and the directions in a
    lane.
    """
    # The last bits of a derivative depend on its neighbours in the lanes, so there are as many lanes on every
    # machine.
    lanes = max(CONTACT_LANES, displaced_runs)
    cores, groups = os.cpu_count() or 1, lanes // displaced_runs
    # With as few directions as occupy all cores the step is quickest to compile; more directions in a lane
    # are cheaper each.
    directions = next((number for number in DIRECTIONS if number * groups * cores >= count), DIRECTIONS[-1])
    return lanes, groups * directions, directions


def spans(assembly: Assembly, last_turn: bool) -> list[tuple[int, int]]:
    """Return pairs of steps between two outputs and number of outputs, which make up the run."""
    choice = assembly.choice
    if not last_turn:
        return [(choice.outputs_every, choice.outputs)]
    turn = choice.steps if choice.turn is None else choice.turn / choice.step
    steps_before = round(choice.steps - turn)
    return [(steps_before, 1), (choice.steps - steps_before, 1)] if steps_before > 0 else [(choice.steps, 1)]


@dataclass(frozen=True)
class TangentPass:
    """A run with the derivatives of some neighbourhoods, ``directions`` in each lane.

    A group of lanes has the displaced runs of one neighbourhood side by side (``shares``). The next
    neighbourhoods take the next groups, and when all groups are occupied, the next direction. ``parts`` are
    pairs of steps between two outputs and number of outputs. ``jumps``: whether forces jump at first touch.
    """

    assembly: Assembly
    shares: Array
    lanes: int
    directions: int
    recorded: NDArray[np.uint32]
    parts: list[tuple[int, int]]
    look: Callable[[], None]
    jumps: bool = False

    def pairs(self, neighbourhoods: Sequence[Neighbours]) -> list[Pairs]:
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
        for (group_lanes, direction), neighbours in zip(places, neighbourhoods, strict=False):
            state[direction + 1, :, group_lanes] = neighbours.state_slope[:, None]
            table[group_lanes, direction + 2] = changes(assembly, neighbours)
        handed = np.concatenate([self.recorded + np.uint32(k * rows) for k in range(directions + 1)])
        runner = Runner(
            assembly.topology, state.reshape(-1, lanes), table.reshape(lanes, -1), "generated", handed,
            parts=assembly.mechanism.settings.parts, shares=np.resize(self.shares, lanes),
            directions=directions, jumps=self.jumps,
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
                _pair(neighbours, steps, columns, values[:, 0, :, lane], values[:, direction + 1, :, lane])
                for lane in range(group_lanes.start, group_lanes.stop)
            ]
            for (group_lanes, direction), neighbours in zip(places, neighbourhoods, strict=False)
        ]


def _pair(
    neighbours: Neighbours, steps: NDArray[np.int64], columns: Columns, rows: Array, slopes: Array
) -> tuple[Record, Record]:
    """Return the records of both sides of one run."""
    largest = np.isin(columns.row_numbers, columns.layout.of("extreme"))
    sides = rows + 0.5 * neighbours.distance * slopes, rows - 0.5 * neighbours.distance * slopes
    for side in sides:
        side[:, largest] = np.maximum(side[:, largest], 0.0)  # a size has no sign
    up, down = (
        Record(model, steps, side, columns.row_numbers, columns=columns)
        for model, side in zip((neighbours.up, neighbours.down), sides, strict=True)
    )
    return up, down


# ----------------------------------------------------------------------------------------- Lyapunov exponents

OVERFLOW = 1e200  # of differences that have no weight in the norm
ALIGNED = 10  # turns in which a difference aligns with the direction of its largest growth


def steps_of_turn(assembly: Assembly) -> int:
    """Return the number of steps in a turn."""
    return round((assembly.choice.turn or 0.0) / assembly.choice.step)


class LyapunovRunner:
    """Motions in lanes, each with a small difference whose growth is followed turn by turn.

    The difference is the step's own derivative, scaled back to length one after each turn (Benettin et al.,
    Meccanica 15 (1980) 9-30). It begins as the derivative by a number of the model (``near``, for each lane),
    which ideal joints permit; after a turn the number's own difference is set to zero, and only that of the
    motion remains. A random difference would violate the joints. If the number had no effect in that turn (a
    stop that was not touched), it keeps its difference for another one; the growth of such turns is NaN. A
    difference that vanishes has the growth -inf, and begins anew.

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
        self.weights = np.stack([weights(assembly) for assembly in assemblies], axis=1)
        self.seeds, self.changes = (np.zeros((self.rows, self.lanes)), list(map(changes, assemblies, near)))
        for k, neighbours in enumerate(near):
            self.seeds[self.parameters, k] = neighbours.state_slope[self.parameters]
        states, tables = np.zeros((2 * self.rows, self.lanes)), np.tile(first.tables, (self.lanes, 3))
        parts = first.mechanism.settings.parts
        self.runner = Runner(
            first.topology, states, tables, "generated", recorded_rows(first), parts=parts, directions=1,
            jumps=True,
        )  # fmt: skip
        self.fresh = np.ones(self.lanes, dtype=bool)

    @property
    def states(self) -> Array:
        """The motions followed by their differences, shape (2 rows, lanes)."""
        return self.runner.states

    def begin(self, assemblies: Sequence[Assembly], states: Array, done: int) -> None:
        """Begin from states after ``done`` steps: motions, shape (rows, lanes), with differences by the
        number, or motions and differences, shape (2 rows, lanes).
        """
        self.states[: len(states)], self.runner.done = states, done
        if len(states) == self.rows:
            self.states[self.rows :], self.fresh[:] = self.seeds, True
        else:
            self.fresh[:] = (self.states[self.rows :][self.parameters] != 0.0).any(axis=0)
        self._tables(assemblies)

    def _tables(self, assemblies: Sequence[Assembly]) -> None:
        tables = self.runner.functions.reshape(self.lanes, 3, -1)
        for k, assembly in enumerate(assemblies):
            tables[k] = (
                assembly.tables,
                rates(assembly),
                self.changes[k] if self.fresh[k] else changes(assembly, Neighbours(assembly, assembly, 1.0)),
            )

    def turns(self, assemblies: Sequence[Assembly], count: int) -> tuple[Array, Array]:
        """Make ``count`` turns; return the rows after each, shape (turns, rows, lanes), and the logarithm of
        the growth in each, shape (turns, lanes).
        """
        rows, growth = (
            np.zeros((count, len(self.runner.row_numbers), self.lanes)),
            np.zeros((count, self.lanes)),
        )
        difference = self.states[self.rows :]
        for turn in range(count):
            rows[turn] = self.pace.advance(self.runner, self.turn, 1)[0]
            with np.errstate(over="ignore", invalid="ignore"):
                weighted = np.ascontiguousarray(
                    (self.weights * difference).T
                )  # summed in one order, however many lanes there are
                size = np.sqrt((weighted * weighted).sum(axis=1))
            growth[turn] = self._renormalise(assemblies, size)
        return rows, growth

    def _renormalise(self, assemblies: Sequence[Assembly], size: Array) -> Array:
        """Scale the differences, of ``size`` in each lane, to length one; return the logarithms of their
        growth, shape (lanes,).
        """
        difference, vanished, was_fresh = self.states[self.rows :], size == 0.0, self.fresh.copy()
        with np.errstate(over="ignore", invalid="ignore"):
            growth = np.asarray(log(np.where(vanished, 1.0, size)))
            difference[np.ix_(self.parameters, ~vanished)] = 0.0
            difference /= np.where(vanished, 1.0, size)
        # Sums such as energies do not act on the motion: their differences stay while that of a strongly
        # attracting one decays, so that each scaling enlarges them, without end.
        difference[(self.weights == 0.0) & (np.abs(difference) > OVERFLOW)] = 0.0
        growth[vanished] = np.where(was_fresh[vanished], np.nan, -np.inf)
        difference[:, vanished], self.fresh = self.seeds[:, vanished], vanished
        if (self.fresh != was_fresh).any():
            self._tables(assemblies)
        return growth


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
