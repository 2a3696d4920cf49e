"""Motions recorded once a turn: sweeps of a parameter up and down, motions from given starts, and blocks of
turns for wear.

All of them step lanes of one topology by a :class:`TurnRunner`. Where a Lyapunov exponent is needed, a small
difference of each motion is computed along with it for the recorded turns and some turns before.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
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
VALUES_AT_ONCE = 2  # values of a sweep with differences side by side: twice the lanes take hardly longer
PIN_TOLERANCE = 1e-9  # relative difference of places of pins that is rounding
PATH_OUTPUTS = 36  # outputs of the turn whose path is recorded
LANES = 4  # starts side by side, on every machine, so that differences have the same bits


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
            np.stack([assembly.state for assembly in assemblies], axis=1),
            np.stack([assembly.tables for assembly in assemblies]),
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
        """Present states, shape (rows, lanes)."""
        return self.runner.states

    @property
    def done(self) -> int:
        """Number of steps so far."""
        return self.runner.done

    def begin(self) -> None:
        """Step to where the recorded turns begin."""
        self.runner.advance(1, 1)
        self.steps(self.begins - 1)

    def restore(self, state: Array, done: int) -> None:
        """Continue from a state, shape (rows,) or (rows, lanes), after ``done`` steps."""
        self.states[:], self.runner.done = state.reshape(len(state), -1), done

    def steps(self, count: int) -> None:
        """Take ``count`` steps without a record."""
        if count:
            self.pace.advance(self.runner, count, 1)

    def skip(self, turns: int) -> None:
        """Make ``turns`` turns without a record."""
        self.steps(turns * self.turn)

    def path(self, lead: int) -> Array:
        """Take ``lead`` steps and make a turn; return the rows at :data:`PATH_OUTPUTS` outputs of it, shape
        (outputs, rows, lanes).
        """
        interval = max(1, self.turn // PATH_OUTPUTS)
        outputs = self.turn // interval
        self.steps(lead)
        rows = self.record(interval, outputs)
        self.steps(self.turn - outputs * interval)
        return rows

    def rows(self, turns: int, outputs: int = 1) -> Array:
        """Make ``turns`` turns; return the rows at ``outputs`` outputs in each, shape (turns * outputs, rows,
        lanes).
        """
        return self.record(self.turn // outputs, turns * outputs)

    def record(self, interval: int, count: int) -> Array:
        """Take ``count`` times ``interval`` steps; return the rows after each, shape (count, rows, lanes)."""
        return self.pace.advance(self.runner, interval, count)

    def growing(self, turns: int, dropped: int, neighbourhoods: Sequence[Neighbours]) -> tuple[Array, Array]:
        """Make ``turns`` turns; return, for those after the first ``dropped``, the rows, shape (turns, rows,
        lanes), and the logarithm of the growth of a small difference, shape (turns, lanes).

        The difference begins as that of ``neighbourhoods``, as late as alignment permits, because derivatives
        cost more than the motion.
        """
        lead = max(0, dropped - ALIGNED)
        self.skip(lead)
        difference = LyapunovRunner(self.assemblies, neighbourhoods, self.pace.look)
        difference.begin(self.assemblies, self.states, self.done)
        rows, growth = difference.turns(self.assemblies, turns - lead)
        return rows[dropped - lead :], growth[dropped - lead :]


def restepped(state: Array, done: int, assembly: Assembly) -> tuple[Array, int]:
    """Return a state after ``done`` steps, shape (rows,), for another ``assembly``, which differs in its step
    and in other numbers; return the number of its steps, too.

    Positions, velocities, forces and the memory of contacts remain; half-step velocities become those of the
    new step, by the text of the step. The time remains the same.
    """
    integers, layout, rows = tables(assembly.topology)
    changed = np.zeros(rows)
    changed[: layout.rows] = state
    shift, step_row = layout.row("shift"), layout.row("step")
    time, size = (done - 1 + float(changed[shift])) * float(changed[step_row]), assembly.choice.step
    # A state is at the time (step + phase) * size: the nearest step is its number, and the rest its phase.
    number = round(time / size)
    kernel: Any = change_step
    kernel(changed, integers.tolist(), size, time / size - number, 0.0)
    parameters = layout.of("parameter")
    # The phase is stored among the parameters, but it belongs to the motion and keeps its time continuous.
    ahead = changed[shift]
    changed[parameters] = assembly.state[parameters]
    changed[shift] = ahead
    return changed[: layout.rows], number + 1


# ----------------------------------------------------------------------------------------------------- sweeps


@dataclass(frozen=True)
class Leg:
    """The result of the chains at one value: ``rows`` recorded once a turn, shape (turns, rows, chains), the
    logarithm of the ``growth`` of a small difference in each turn, shape (turns, chains), the ``state`` after
    it, shape (rows, chains), and the result of a ``check``.
    """

    number: int
    rows: Array
    growth: Array
    state: Array
    check: Any = None


class StartedValue(NamedTuple):
    """A value whose motion has begun: the states before it, ``first``, and those at which its difference
    begins, ``begin``, each with the number of steps so far.
    """

    number: int
    first: Array
    done_first: int
    begin: Array
    done: int


Growths: TypeAlias = tuple[Array, Array, Any]
# values, their last states, rows and growth
Group: TypeAlias = "tuple[list[StartedValue], list[Array], Future[list[Growths]]]"


class Sweep:
    """Chains of assemblies that differ in one number, one chain with ascending and one with descending
    values, in lanes: the number changes while the motion continues.

    The motion is recorded at the ``phase`` (1) of a turn. ``near`` are neighbours of the first assembly of
    each chain, whose difference is followed. Derivatives cost twice as much as the motion. They are computed
    from ``ALIGNED`` turns before the recorded ones, in a second thread, for :data:`VALUES_AT_ONCE` values
    side by side, while the motion goes on to the next values. The last bits of a difference depend on its
    neighbours in the lanes, which must always be the same: a sweep is continued only where such a group of
    values begins (:meth:`complete_legs`).

    ``check`` is called in that thread with the number of a value, the state before it, shape (rows, chains),
    the number of steps so far, and a function to call now and then.
    """

    def __init__(
        self,
        chains: Sequence[Sequence[Assembly]],
        near: Sequence[Neighbours],
        phase: float,
        check: ValueCheck | None,
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
        """Return the number of legs, of ``count`` computed ones, after which a sweep can be continued; the
        others are computed again.
        """
        return count - count % VALUES_AT_ONCE

    def legs(self, turns: int, dropped: int, resume: tuple[int, Array] | None = None) -> Iterator[Leg]:
        """Yield the legs of all values, with ``turns`` turns at each, the first ``dropped`` not recorded;
        ``resume`` is the number and state of a leg after which to continue.
        """
        with Workers(1) as workers:
            self.motion.pace.look, self.difference.pace.look = workers.halt.look, workers.look
            lead = max(0, dropped - ALIGNED)
            # The results of a group are waited for after the motion of the next one, so that both threads
            # always have work.
            for values, states, job in one_behind(self._groups(workers, turns, lead, resume)):
                for value, state, (rows, growth, check) in zip(values, states, job.result(), strict=True):
                    yield Leg(value.number, rows[dropped - lead :], growth[dropped - lead :], state, check)

    def _groups(
        self, workers: Workers, turns: int, lead: int, resume: tuple[int, Array] | None
    ) -> Iterator[Group]:
        """Go through the values; yield groups of them, whose differences the second thread follows side by
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
                values.append(self._under_way(number, lead))
                # The difference needs only the states at which it begins. The thread gets them before the
                # motion of the last value goes on, and both proceed at the same time.
                if number == group[-1]:
                    job = workers.submit(self._with_derivatives, values, turns - lead, workers.look)
                self.motion.skip(turns - lead)
                states.append(self.states.copy())
            yield values, states, job

    def _under_way(self, number: int, lead: int) -> StartedValue:
        """Begin a value, and step to where its difference begins."""
        first, done = self.states.copy(), self.motion.done
        self._take_up(number)
        self.motion.skip(lead)
        return StartedValue(number, first, done, self.states.copy(), self.motion.done)

    def _take_up(self, number: int) -> None:
        """Set the parameters of the next models; the motion continues."""
        functions = self.motion.runner.functions.reshape(len(self.chains), -1)
        for k, chain in enumerate(self.chains):
            self.states[self.parameters, k] = chain[number].state[self.parameters]
            functions[k] = chain[number].tables

    def _with_derivatives(
        self, values: Sequence[StartedValue], turns: int, look: Callable[[], None]
    ) -> list[Growths]:
        """Return rows, growth and check of each of ``values`` over ``turns`` turns with a difference.

        The values began at different steps; their clocks are shifted to the first one's by whole steps.
        Unused lanes repeat the last value.
        """
        lanes, chains = [*values, *[values[-1]] * (VALUES_AT_ONCE - len(values))], len(self.chains)
        assemblies = [chain[value.number] for value in lanes for chain in self.chains]
        states = [value.begin.copy() for value in lanes]
        for value, state in zip(lanes, states, strict=True):
            state[self.shift] += value.done - values[0].done
        self.difference.begin(assemblies, np.concatenate(states, axis=1), values[0].done)
        rows, growth = self.difference.turns(assemblies, turns)
        results = []
        for k, value in enumerate(values):
            span = slice(k * chains, (k + 1) * chains)
            check = (
                None if self.check is None else self.check(value.number, value.first, value.done_first, look)
            )
            results.append((rows[:, :, span], growth[:, span], check))
        return results


def discontinuity(first: Assembly, second: Assembly) -> Callable[[], str] | None:
    """Return None if the motion of one model can continue in another, with the same bodies at the same
    places; otherwise a function that returns the reason.
    """
    if (reason := side_by_side(first, second)) is not None:
        return reason
    if first.ideals:
        places = [
            first.layout.rows_of(f"joint_{side}_{axis}") for side in ("bearing", "journal") for axis in "xy"
        ]
        rows = np.concatenate(places)
        size = max(float(np.abs(first.state[rows]).max(initial=0.0)), 1e-300)
        if float(np.abs(first.state[rows] - second.state[rows]).max(initial=0.0)) > PIN_TOLERANCE * size:
            return lambda: (
                "pins of ideal joints have moved in their bodies, so the position of one does not fit the"
                " other"
            )
    return None


def side_by_side(first: Assembly, second: Assembly) -> Callable[[], str] | None:
    """Return None if two models can be stepped in lanes of one loop; otherwise a function that returns the
    reason.
    """
    if first.topology != second.topology:
        return lambda: "their topologies differ"
    if len(first.tables) != len(second.tables):
        return lambda: "their functions of time have other pieces"
    return None


# ----------------------------------------------------------------------------------------------------- starts


@dataclass(frozen=True)
class Start:
    """A case: its ``number``, the function that assembles it, and the share ``ahead`` (1) of a turn from its
    start to the phase at which all cases are recorded.
    """

    number: int
    make: Callable[[], Assembly]
    ahead: float = 0.0


@dataclass(frozen=True)
class Orbit:
    """The motion of a case: ``rows`` recorded once a turn, shape (turns, rows), and the logarithm of the
    ``growth`` of a small difference in each turn, shape (turns,), empty if none was followed; or the
    ``reason`` why there is no motion. ``path``: rows at the outputs of a turn before the recorded ones, shape
    (outputs, rows).
    """

    number: int
    assembly: Assembly | None
    rows: Array
    growth: Array
    reason: str = ""
    path: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)


class Orbits:
    """Motions of cases with ``steps`` steps in a turn, through ``turns`` turns, the first ``dropped`` not
    recorded, after a turn and the way to the phase. ``near``: neighbours whose difference is followed in all
    of them, or None.

    A motion does not depend on the cases beside it. The last bits of a difference do: if one lane repeats a
    step in parts, all lanes take the full step, whose derivatives sum their terms in another order. Cases
    therefore always run beside the same ones.
    """

    def __init__(self, steps: int, turns: int, dropped: int, near: Neighbours | None = None) -> None:
        self.steps, self.turns, self.dropped, self.near = steps, turns, dropped, near

    def run_cases(
        self, starts: Sequence[Start], done: Collection[int] = (), workers: int | None = None
    ) -> Iterator[Orbit]:
        """Yield the cases that are not ``done`` as they end; ``starts`` are those of all cases. Ctrl-C ends
        it within a second.
        """
        blocks = [block for block in self.blocks(starts) if not all(start.number in done for start in block)]
        with Workers(workers) as threads:
            for orbits in threads.results(
                [threads.submit(self.block, block, threads.look) for block in blocks]
            ):
                yield from (orbit for orbit in orbits if orbit.number not in done)

    def blocks(self, starts: Sequence[Start]) -> list[list[Start]]:
        """Return the groups of cases that run side by side: with the same way to the phase, as many as there
        are lanes.
        """
        by_phase: dict[int, list[Start]] = {}
        for start in starts:
            by_phase.setdefault(round(start.ahead * self.steps) % self.steps, []).append(start)
        return [cases[k : k + LANES] for cases in by_phase.values() for k in range(0, len(cases), LANES)]

    def block(self, starts: Sequence[Start], look: Callable[[], None]) -> list[Orbit]:
        """Run some cases side by side; unused lanes repeat the last one."""
        look()
        assemblies: dict[int, Assembly] = {}
        orbits: list[Orbit] = []
        for start in starts:
            try:
                assemblies[start.number] = start.make()
            except VfifeError as error:
                orbits.append(Orbit(start.number, None, np.zeros((0, 0)), np.zeros(0), str(error)))
        # A parameter may change the topology, for example the number of corrections of ideal joints. Such
        # cases need another loop, and run after one another.
        while assemblies:
            first = next(iter(assemblies.values()))
            alike = {number: case for number, case in assemblies.items() if side_by_side(first, case) is None}
            for number in alike:
                del assemblies[number]
            cases = list(alike.values())
            runner = TurnRunner(cases + cases[-1:] * (LANES - len(cases)), starts[0].ahead, look=look)
            path, rows, growth = self.record_turns(runner)
            orbits += [
                Orbit(number, case, rows[:, :, k], growth[:, k], path=path[:, :, k])
                for k, (number, case) in enumerate(alike.items())
            ]
        return orbits

    def record_turns(self, runner: TurnRunner) -> tuple[Array, Array, Array]:
        """Return the rows at the outputs of the last turn before a difference or the record begins, and the
        rows and growth of the recorded turns.
        """
        lead = self.dropped if self.near is None else max(0, self.dropped - ALIGNED)
        runner.runner.advance(1, 1)
        path = runner.path(runner.begins - 1 + (lead - 1) * runner.turn)
        if self.near is not None:
            return path, *runner.growing(self.turns - lead, self.dropped - lead, [self.near] * LANES)
        return path, runner.rows(self.turns - self.dropped), np.zeros((0, LANES))


# ------------------------------------------------------------------------------------------------------- wear


class WearRunner(TurnRunner):
    """A motion in blocks of turns, with ``outputs`` outputs in a turn; its worn profiles change between
    blocks.
    """

    def __init__(self, assembly: Assembly, outputs: int, halt: Interrupts) -> None:
        super().__init__([assembly], look=halt.look)
        self.assembly, self.outputs, self.bounds = assembly, outputs, Bounds(assembly, self.row_numbers)
        self.harmonics = [assembly.layout.rows_of(f"harmonic_{part}") for part in ("cosine", "sine")]

    @property
    def turns(self) -> float:
        """Number of simulated turns."""
        return max(self.done - 1, 0) / self.turn

    @property
    def state(self) -> Array:
        """The present state with the number of steps at its end, shape (rows + 1,)."""
        return np.append(self.states[:, 0], self.done)

    def shape(self, cosines: Array, sines: Array) -> None:
        """Set the harmonics (m) of all worn profiles."""
        for rows, depths in zip(self.harmonics, (cosines, sines), strict=True):
            self.states[rows, 0] = depths

    def block(self, dropped: int, counted: int) -> Record:
        """Make ``dropped`` turns without a record; return the record of ``counted`` turns, which begins with
        the output before them.

        Raises VfifeError if numbers leave their bounds.
        """
        if self.done == 0:
            self.runner.advance(1, 1)
        first = self.done - 1 + self.turn * dropped
        rows = np.concatenate([self.rows(dropped)[-1:], self.rows(counted, self.outputs)])[:, :, 0]
        if self.bounds.unsound(rows).any():
            text = (
                f"numbers grew without bound within {self.turns:.0f} turns that were simulated; give a"
                " smaller step, or check the model"
            )
            raise VfifeError(f"{self.assembly.mechanism.name}: {text}")
        steps = first + self.turn // self.outputs * np.arange(len(rows), dtype=np.int64)
        return Record(self.assembly, steps, rows, self.row_numbers)
