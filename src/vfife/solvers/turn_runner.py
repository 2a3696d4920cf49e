"""Motions turn by turn, looked at once in each: values swept up and down, motions from starts of their own,
blocks of turns that wear a joint.

All of them step lanes of one topology by a :class:`TurnRunner`, with a small difference beside each motion
from a turn on.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, Bounds
from ..compiler.runtime.runner import Runner
from ..compiler.trace.tables import tables
from ..errors import VfifeError
from ..kernels.data_driven import change_step
from .interrupts import ChunkSize, Interrupts, Workers, one_behind
from .record import Record, recorded_rows
from .tangents import ALIGNED, LyapunovRunner, Neighbours, steps_of_turn

Array = NDArray[np.float64]
ValueCheck: TypeAlias = Callable[[int, Array, int, Callable[[], None]], Any]
VALUES_AT_ONCE = 2  # values of a sweep whose differences go side by side: twice the lanes take hardly longer
LANES = 4  # starts side by side, on every machine


class TurnRunner:
    """Motions in lanes, each from the start of its assembly: a step, a turn, the way to the ``phase`` (1) of
    a turn, and from there turn by turn.

    The assemblies have one topology and as many steps in a turn. ``row_numbers`` are the rows that are
    recorded; ``look`` is called a few times a second.
    """

    def __init__(
        self,
        assemblies: Sequence[Assembly],
        phase: float = 0.0,
        recorded: NDArray[np.uint32] | None = None,
        look: Callable[[], None] | None = None,
    ) -> None:
        self.assemblies, first = assemblies, assemblies[0]
        self.turn, self.pace = steps_of_turn(first), ChunkSize(look)
        self.begins = 1 + self.turn + round(phase * self.turn) % self.turn
        states, functions = (
            np.stack([one.state for one in assemblies], axis=1),
            np.stack([one.tables for one in assemblies]),
        )
        self.row_numbers = recorded_rows(first) if recorded is None else recorded
        self.runner = Runner(
            first.topology,
            states,
            functions,
            "generated",
            self.row_numbers,
            parts=first.mechanism.settings.parts,
        )

    @property
    def states(self) -> Array:
        """The states, shape (rows, lanes)."""
        return self.runner.states

    @property
    def done(self) -> int:
        """Steps made."""
        return self.runner.done

    def begin(self) -> None:
        """Go to where the turns begin."""
        self.runner.advance(1, 1)
        self.steps(self.begins - 1)

    def restore(self, state: Array, done: int) -> None:
        """Go on from a state, shape (rows,) or (rows, lanes), after so many steps."""
        self.states[:], self.runner.done = state.reshape(len(state), -1), done

    def steps(self, count: int) -> None:
        """Make so many steps; nothing is recorded."""
        if count:
            self.pace.advance(self.runner, count, 1)

    def skip(self, turns: int) -> None:
        """Make so many turns; nothing is recorded."""
        self.steps(turns * self.turn)

    def rows(self, turns: int, outputs: int = 1) -> Array:
        """Make so many turns; the rows after each of so many ``outputs`` in each, shape (turns * outputs,
        rows, lanes).
        """
        return self.record(self.turn // outputs, turns * outputs)

    def record(self, every: int, count: int) -> Array:
        """Make ``count`` times ``every`` steps; the rows after each, shape (count, rows, lanes)."""
        return self.pace.advance(self.runner, every, count)

    def growing(self, turns: int, dropped: int, near: Sequence[Neighbours]) -> tuple[Array, Array]:
        """Make so many turns; of those after the first ``dropped`` the rows, shape (turns, rows, lanes), and
        the logarithm of the growth of a small difference, shape (turns, lanes). It begins as that of the
        neighbours ``near``, no sooner than it has to.
        """
        before = max(0, dropped - ALIGNED)
        self.skip(before)
        difference = LyapunovRunner(self.assemblies, near, self.pace.look)
        difference.begin(self.assemblies, self.states, self.done)
        rows, growth = difference.turns(self.assemblies, turns - before)
        return rows[dropped - before :], growth[dropped - before :]


def restepped(state: Array, done: int, assembly: Assembly) -> tuple[Array, int]:
    """A state after so many steps, shape (rows,), as ``assembly`` has it, which differs in its step and in
    other numbers: state and steps done.

    Positions, velocities, forces and what contacts remember stay; half-step velocities become those of the
    new step, by the text of the step. The clock stays where it is.
    """
    integers, layout, room = tables(assembly.topology)
    changed = np.zeros(room)
    changed[: layout.rows] = state
    shift, own = layout.row("shift"), layout.row("step")
    time, size = (done - 1 + float(changed[shift])) * float(changed[own]), assembly.choice.step
    number = round(time / size)
    kernel: Any = change_step
    kernel(changed, integers.tolist(), size, time / size - number, 0.0)
    parameters = layout.of("parameter")
    ahead = changed[shift]
    changed[parameters] = assembly.state[parameters]
    changed[shift] = ahead
    return changed[: layout.rows], number + 1


# ----------------------------------------------------------------------------------------------------- sweeps


@dataclass(frozen=True)
class Leg:
    """What the chains leave at one value: ``rows`` recorded once a turn, shape (turns, rows, chains),
    ``growth`` of a small difference in each of them, its logarithm, shape (turns, chains), the ``state`` to
    go on from, shape (rows, chains), and what was looked at ``check`` it.
    """

    number: int
    rows: Array
    growth: Array
    state: Array
    check: Any = None


class StartedValue(NamedTuple):
    """A value whose motion is under way: the states ``first``, and after the turns at which its difference
    begins, ``here``; steps made by then.
    """

    number: int
    first: Array
    done_first: int
    here: Array
    done: int


Growths: TypeAlias = tuple[Array, Array, Any]
# values, their last states, rows and growth
Group: TypeAlias = "tuple[list[StartedValue], list[Array], Future[list[Growths]]]"


class Sweep:
    """Chains of assemblies that differ in one number, ``up`` and ``down`` it, in lanes: the number moves on
    while the motion goes on.

    ``phase`` (1) is the part of a turn at which it is looked at. ``near``: neighbours of the first of each
    chain, whose difference is the small one. Derivatives are carried along from ``ALIGNED`` turns before
    those that are looked at, no sooner, for they cost twice as much as the motion, and at
    :data:`VALUES_AT_ONCE`
    values side by side. The last bits of a difference know of its neighbours in lanes, so these are the same
    ones always: what is gone on with begins where such values begin (:meth:`complete_legs`).

    ``check``: called in a thread of its own with the number of a value, the state before it, shape (rows,
    chains), the steps made by then, and what is to be called now and then.
    """

    def __init__(
        self,
        chains: Sequence[Sequence[Assembly]],
        near: Sequence[Neighbours],
        phase: float = 0.0,
        check: ValueCheck | None = None,
    ) -> None:
        self.chains, first, self.check = chains, chains[0][0], check
        self.parameters, self.shift = (
            np.array(first.layout.of("parameter"), dtype=np.intp),
            first.layout.row("shift"),
        )
        self.motion = TurnRunner([chain[0] for chain in chains], phase)
        self.difference = LyapunovRunner(
            [chain[0] for chain in chains] * VALUES_AT_ONCE, [*near] * VALUES_AT_ONCE
        )
        self.row_numbers, self.states = self.motion.row_numbers, self.motion.states

    @staticmethod
    def complete_legs(count: int) -> int:
        """Of so many legs that are known, those after which it can be gone on with; the others are made
        again.
        """
        return count - count % VALUES_AT_ONCE

    def legs(self, turns: int, dropped: int, resume: tuple[int, Array] | None = None) -> Iterator[Leg]:
        """At each value so many ``turns``, the first of them ``dropped``; from the leg after ``resume``, the
        number and state of one before.

        A second thread carries derivatives through the turns that are looked at, while the motion goes on to
        the next values.
        """
        with Workers(1) as workers:
            self.motion.pace.look, self.difference.pace.look = workers.halt.look, workers.look
            before = max(0, dropped - ALIGNED)
            for values, states, job in one_behind(self._groups(workers, turns, before, resume)):
                for one, state, (rows, growth, check) in zip(values, states, job.result(), strict=True):
                    yield Leg(one.number, rows[dropped - before :], growth[dropped - before :], state, check)

    def _groups(
        self, workers: Workers, turns: int, before: int, resume: tuple[int, Array] | None
    ) -> Iterator[Group]:
        """Go through the values, and have the second thread follow differences of some of them side by
        side.
        """
        first, last = 0 if resume is None else resume[0] + 1, len(self.chains[0])
        if resume is None:
            self._take_up(0)
            self.motion.begin()
        else:
            self.motion.restore(resume[1], self.motion.begins + first * turns * self.motion.turn)
        for group in (range(k, min(k + VALUES_AT_ONCE, last)) for k in range(first, last, VALUES_AT_ONCE)):
            values, states = list[StartedValue](), list[Array]()
            for number in group:
                values.append(self._under_way(number, before))
                if number == group[-1]:
                    job = workers.submit(self._with_derivatives, values, turns - before, workers.look)
                self.motion.skip(turns - before)
                states.append(self.states.copy())
            yield values, states, job

    def _under_way(self, number: int, before: int) -> StartedValue:
        """Takes a value up, and goes to where its difference begins."""
        first, done = self.states.copy(), self.motion.done
        self._take_up(number)
        self.motion.skip(before)
        return StartedValue(number, first, done, self.states.copy(), self.motion.done)

    def _take_up(self, number: int) -> None:
        """The numbers of the next models; their motion stays."""
        functions = self.motion.runner.functions.reshape(len(self.chains), -1)
        for k, chain in enumerate(self.chains):
            self.states[self.parameters, k], functions[k] = (
                chain[number].state[self.parameters],
                chain[number].tables,
            )

    def _with_derivatives(
        self, values: Sequence[StartedValue], turns: int, look: Callable[[], None]
    ) -> list[Growths]:
        """Turns with a difference that is one of the number at first and, after a turn, of the motion alone:
        rows and growth of each value.

        Clocks of later values are ahead of the first one's, by whole steps; lanes that are left over repeat
        the last value.
        """
        lanes, chains = [*values, *[values[-1]] * (VALUES_AT_ONCE - len(values))], len(self.chains)
        here = [chain[one.number] for one in lanes for chain in self.chains]
        states = [one.here.copy() for one in lanes]
        for one, state in zip(lanes, states, strict=True):
            state[self.shift] += one.done - values[0].done
        self.difference.begin(here, np.concatenate(states, axis=1), values[0].done)
        rows, growth = self.difference.turns(here, turns)
        results = []
        for k, one in enumerate(values):
            span = slice(k * chains, (k + 1) * chains)
            check = None if self.check is None else self.check(one.number, one.first, one.done_first, look)
            results.append((rows[:, :, span], growth[:, span], check))
        return results


def discontinuity(first: Assembly, other: Assembly, tolerance: float = 1e-9) -> Callable[[], str] | None:
    """None where the motion of one model can go on in another: the same bodies at the same places; else what
    says why not.
    """
    if (why := side_by_side(first, other)) is not None:
        return why
    if first.ideals:
        places = [
            first.layout.rows_of(f"joint_{side}_{axis}") for side in ("bearing", "journal") for axis in "xy"
        ]
        rows = np.concatenate(places)
        size = max(float(np.abs(first.state[rows]).max(initial=0.0)), 1e-300)
        if float(np.abs(first.state[rows] - other.state[rows]).max(initial=0.0)) > tolerance * size:
            return lambda: (
                "pins of ideal joints are elsewhere in their bodies, so that the position of one is none of"
                " the other"
            )
    return None


def side_by_side(first: Assembly, other: Assembly) -> Callable[[], str] | None:
    """None where two models can be stepped in lanes of one loop; else what says why not."""
    if first.topology != other.topology:
        return lambda: "they are not of one topology"
    if len(first.tables) != len(other.tables):
        return lambda: "their functions of time have other pieces"
    return None


# ----------------------------------------------------------------------------------------------------- starts


@dataclass(frozen=True)
class Start:
    """A member: its ``number``, what assembles it when its turn has come, and the ``ahead`` (1) of a turn
    after which it is at the phase of all.
    """

    number: int
    make: Callable[[], Assembly]
    ahead: float = 0.0


@dataclass(frozen=True)
class Orbit:
    """A member's ``rows``, recorded once in each turn that is looked at, shape (turns, rows), and the
    ``growth`` of a small difference in each, its logarithm, shape (turns,), empty where none was watched; or
    ``why`` there is none.
    """

    number: int
    assembly: Assembly | None
    rows: Array
    growth: Array
    why: str = ""


class Orbits:
    """Members of one topology and so many ``steps`` in a turn, each through ``turns``, the first of them
    ``dropped``, after a turn and the way to the phase. ``near``: neighbours whose difference is watched in
    all of them; None: none is.

    A motion knows nothing of those beside it. The last bits of a difference do, for where a lane takes a step
    in parts, its terms are summed in another order in all of them: so members go side by side with the same
    ones always.
    """

    def __init__(self, steps: int, turns: int, dropped: int, near: Neighbours | None = None) -> None:
        self.steps, self.turns, self.dropped, self.near = steps, turns, dropped, near

    def each(
        self, starts: Sequence[Start], done: Collection[int] = (), workers: int | None = None
    ) -> Iterator[Orbit]:
        """The members that are not ``known``, as they end; ``starts`` are those of all. Ctrl-C ends it within
        a second.
        """
        blocks = [block for block in self.blocks(starts) if not all(one.number in done for one in block)]
        with Workers(workers) as threads:
            for orbits in threads.results(
                [threads.submit(self.block, block, threads.look) for block in blocks]
            ):
                yield from (orbit for orbit in orbits if orbit.number not in done)

    def blocks(self, starts: Sequence[Start]) -> list[list[Start]]:
        """Members that go side by side: as far before the phase, so many as there are lanes."""
        by: dict[int, list[Start]] = {}
        for one in starts:
            by.setdefault(round(one.ahead * self.steps) % self.steps, []).append(one)
        return [some[k : k + LANES] for some in by.values() for k in range(0, len(some), LANES)]

    def block(self, starts: Sequence[Start], look: Callable[[], None]) -> list[Orbit]:
        """Some members side by side; lanes that are left over repeat the last."""
        look()
        assemblies: list[tuple[int, Assembly]] = []
        orbits: list[Orbit] = []
        for one in starts:
            try:
                assemblies.append((one.number, one.make()))
            except VfifeError as error:
                orbits.append(Orbit(one.number, None, np.zeros((0, 0)), np.zeros(0), str(error)))
        while assemblies:
            alike = [
                (number, one) for number, one in assemblies if side_by_side(assemblies[0][1], one) is None
            ]
            assemblies = [(number, one) for number, one in assemblies if number not in dict(alike)]
            every = [one for _, one in alike]
            runner = TurnRunner(every + every[-1:] * (LANES - len(every)), starts[0].ahead, look=look)
            rows, growth = self.through(runner)
            orbits += [
                Orbit(number, one, rows[:, :, k], growth[:, k]) for k, (number, one) in enumerate(alike)
            ]
        return orbits

    def through(self, runner: TurnRunner) -> tuple[Array, Array]:
        """Rows and growth of the turns that are looked at."""
        runner.begin()
        if self.near is not None:
            return runner.growing(self.turns, self.dropped, [self.near] * LANES)
        runner.skip(self.dropped)
        return runner.rows(self.turns - self.dropped), np.zeros((0, LANES))


# ------------------------------------------------------------------------------------------------------- wear


class WearRunner(TurnRunner):
    """A mechanism, of which so many ``outputs`` a turn are recorded, while its worn profiles change between
    blocks of turns.
    """

    def __init__(self, assembly: Assembly, outputs: int, halt: Interrupts) -> None:
        super().__init__([assembly], look=halt.look)
        self.assembly, self.outputs, self.bounds = assembly, outputs, Bounds(assembly, self.row_numbers)
        self.harmonics = [assembly.layout.rows_of(f"harmonic_{part}") for part in ("cosine", "sine")]

    @property
    def turns(self) -> float:
        """Turns that were simulated."""
        return max(self.done - 1, 0) / self.turn

    @property
    def state(self) -> Array:
        """The state to go on from, with the number of steps, shape (rows + 1,)."""
        return np.append(self.states[:, 0], self.done)

    def shape(self, cosines: Array, sines: Array) -> None:
        """Gives all harmonics of all worn profiles their depths (m)."""
        for rows, depths in zip(self.harmonics, (cosines, sines), strict=True):
            self.states[rows, 0] = depths

    def block(self, dropped: int, counted: int) -> Record:
        """So many turns that nobody looks at, and then a record of so many, which begins with the output
        before them.

        Raises VfifeError where numbers leave all bounds.
        """
        if self.done == 0:
            self.runner.advance(1, 1)
        first = self.done - 1 + self.turn * dropped
        rows = np.concatenate([self.rows(dropped)[-1:], self.rows(counted, self.outputs)])[:, :, 0]
        if self.bounds.unsound(rows).any():
            text = (
                f"numbers left all bounds within {self.turns:.0f} turns that were simulated; give a smaller"
                " step, or check the model"
            )
            raise VfifeError(f"{self.assembly.mechanism.name}: {text}")
        steps = first + self.turn // self.outputs * np.arange(len(rows), dtype=np.int64)
        return Record(self.assembly, steps, rows, self.row_numbers)
