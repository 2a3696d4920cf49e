"""Step a run and its companions in neighbouring lanes, so that all of them meet at every output.

The time of a step with contact is that of its divisions, and a vector register divides four numbers in
the time of two. Three repetitions of a run in the other lanes of its register therefore cost little.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, bounds, limited_rows, watched
from ..compiler.runtime.loops import NO_STEP
from ..compiler.runtime.runner import LOOK, Runner, Stream
from .record import places

Array = NDArray[np.float64]
Integers = NDArray[np.uint32]
Counts = NDArray[np.int64]


class Stepper(Protocol):
    """One or more lanes with the interface of :class:`~vfife.compiler.runtime.runner.Runner`."""

    done: int
    broken: Array

    @property
    def states(self) -> Array:
        """Present states, shape (rows, lanes); a state written into it is that from which steps continue."""

    def advance(self, count: int, outputs: int, *, reset: bool = True, record: bool = True) -> Array:
        """Take ``outputs`` times ``count`` steps of the run; return the rows recorded after each, shape
        (outputs, rows, lanes).
        """


def single_runner(
    assembly: Assembly, loop: str, recorded: Integers, state: Array | None = None, watch: bool = True
) -> Runner:
    """Return the runner of one assembly, from its start or another ``state``, shape (rows, 1).

    ``watch``: whether it is checked that numbers stay within the bounds of the model.
    """
    return Runner(
        assembly.topology,
        assembly.state[:, None] if state is None else state,
        assembly.tables[None, :],
        loop,
        recorded,
        parts=assembly.mechanism.settings.parts,
        watched=watched([assembly], np.ones(1, dtype=bool)) if watch else None,
    )


def step_sizes(assembly: Assembly, counts: Counts) -> Array:
    """Return the step sizes (s) of lanes that take ``counts`` steps between two outputs; that of the run is
    the same to the bit.
    """
    choice = assembly.choice
    return np.where(counts == choice.outputs_every, choice.step, choice.step * choice.outputs_every / counts)


def steps_inside(counts: Counts, inside: int) -> Counts:
    """Return the steps of each lane since the last output when the run has taken ``inside`` steps of its own:
    in proportion, rounded down.
    """
    steps: Counts = inside * counts // counts[0]
    return steps


def initial_states(assembly: Assembly, counts: Counts) -> Array:
    """Return the states at the start, shape (rows, lanes). They differ only in their step sizes, except in a
    run that goes on from a former one: its companions go on from those of that run, one after the other.
    """
    states, starts = np.repeat(assembly.state[:, None], len(counts), axis=1), assembly.companion_states
    if starts is not None:
        states[:, 1:] = starts[:, np.arange(len(counts) - 1) % starts.shape[1]]
    states[assembly.layout["step"]] = step_sizes(assembly, counts)
    return states


class SynchronisedLanes:
    """Step a run and its companions in the lanes of one vector register, so that all of them meet at each
    output of the run.

    ``counts`` are the steps of each lane between two outputs, the run first. All lanes of a register step at
    once, but companions need fewer steps for an interval. In a stream
    (:class:`~vfife.compiler.runtime.runner.Stream`) each lane has outputs after its own number of steps.
    Calls cover several intervals; a lane that has all its outputs is stored, and its place repeats another
    lane until the last lane has finished. The run has the bits that it has alone, because its lane never
    waits.
    """

    def __init__(self, assembly: Assembly, counts: Counts, recorded: Integers, capacity: int) -> None:
        self.assembly, self.layout, self.counts = assembly, assembly.layout, counts
        self.row_numbers, self.capacity, self.done = recorded, capacity, 0
        self.extremes = np.array(assembly.layout.of("extreme"), dtype=np.intp)
        self.columns = places(recorded, self.extremes)
        self.lanes = 1 << (len(counts) - 1).bit_length()  # a vector holds 1, 2, 4 or 8 numbers
        self.states = initial_states(assembly, counts)
        # Number of steps after which the run was found outside its bounds; companions may leave theirs.
        self.broken = np.zeros(1)
        self.stream: Stream | None = None

    def advance(self, count: int, outputs: int, *, reset: bool = True, record: bool = True) -> Array:
        """Take ``outputs`` whole intervals of ``count`` steps of the run, or ``count`` steps within one
        interval; the first call takes the start.
        """
        if self.done == 0:
            return self._begin()
        inside = (self.done - 1) % int(self.counts[0])
        past, until = steps_inside(self.counts, inside), steps_inside(self.counts, inside + count)
        if reset:
            self.states[self.extremes] = 0.0
        self.done += count * outputs
        if inside == 0 and count == self.counts[0]:
            return self._intervals(outputs)
        output = (self.done - 1 - inside - count) // int(self.counts[0])
        self._piece(output * self.counts + past, until - past)
        return (
            np.array(self.states[self.row_numbers][None]) + 0.0
            if record
            else np.zeros((1, 0, len(self.counts)))
        )

    def _begin(self) -> Array:
        """Take the start of all lanes; return the first output."""
        assembly = self.assembly
        runner = Runner(
            assembly.topology,
            self._padded(self.states),
            np.repeat(assembly.tables[None, :], self.lanes, axis=0),
            "generated",
            self.row_numbers,
            parts=assembly.mechanism.settings.parts,
        )
        rows = runner.advance(1, 1)[:, :, : len(self.counts)]
        self.states[:], self.done = runner.states[:, : len(self.counts)], 1
        return rows

    def _padded(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values of the lanes, shape (..., lanes), with that of the run in the unused places of the
        vector.
        """
        return values[..., [lane if lane < len(self.counts) else 0 for lane in range(self.lanes)]]

    def _intervals(self, outputs: int) -> Array:
        """Take whole intervals; return the outputs of all lanes, shape (outputs, rows, lanes)."""
        first_output = (self.done - 1) // int(self.counts[0]) - outputs
        stream = self._loaded(first_output * self.counts)
        used = len(self.counts)
        stream.at[:used], stream.stop[:used], stream.interval[:used] = 0, outputs, self.counts
        stream.due[:used] = stream.done + self.counts
        waiting = set(range(used))
        while waiting:
            stream.advance(
                int(
                    max(
                        stream.due[lane] + (outputs - 1 - stream.at[lane]) * stream.interval[lane]
                        for lane in waiting
                    )
                )
                - stream.done
            )
            self._watch(stream, waiting)
            self._finish(stream, {lane for lane in waiting if stream.at[lane] >= outputs}, waiting)
        rows = np.ascontiguousarray(stream.out[:used, :outputs].transpose(1, 2, 0)) + 0.0
        # A stream sets extremes to zero after an output; a run does so before its next step.
        self.states[self.extremes] = rows[-1][self.columns]
        return rows

    def _piece(self, past: Counts, missing: Counts) -> None:
        """Take ``missing`` steps in each lane, which has taken ``past`` steps since its start, without an
        output.
        """
        stream = self._loaded(past)
        end = stream.done + missing
        waiting = set(np.flatnonzero(missing).tolist())
        self._repeat(stream, waiting)
        while waiting:
            stream.advance(int(min(end[lane] for lane in waiting)) - stream.done)
            self._watch(stream, waiting)
            self._finish(stream, {lane for lane in waiting if stream.done >= end[lane]}, waiting)

    def _loaded(self, past: Counts) -> Stream:
        """Return the stream, filled with the states of all lanes after ``past`` steps of their own."""
        stream = self.stream
        if stream is None:
            assembly = self.assembly
            stream = self.stream = Stream(
                assembly.topology,
                self.lanes,
                "generated",
                self.row_numbers,
                self.capacity,
                self.row_numbers,
                limited_rows(assembly),
                len(assembly.tables),
                assembly.mechanism.settings.parts,
                look=LOOK,
            )
            stream.T.reshape(self.lanes, -1)[:] = assembly.tables
            stream.limits.reshape(-1, 2, self.lanes)[:] = np.stack(bounds(assembly)).T[:, :, None]
        stream.states[:] = self._padded(self.states)
        # The stream counts the steps of the run; a companion's own step is n + shift, counted from its start.
        stream.done = 1 + int(past[0])
        stream.states[self.layout["shift"]] = self._padded(1 + past - stream.done)
        stream.due[:], stream.broken[:] = NO_STEP, -1.0
        if self.broken[0] == 0.0:
            stream.broken[0] = 0.0
        return stream

    def _watch(self, stream: Stream, waiting: set[int]) -> None:
        """Store the number of steps after which the run was found outside its bounds; its companions continue
        to the end of the call.
        """
        if 0 in waiting and stream.broken[0] > 0.0:
            self.broken[0] = stream.broken[0]
            self._finish(stream, {0}, waiting)

    def _finish(self, stream: Stream, lanes: set[int], waiting: set[int]) -> None:
        """Store the states of ``lanes`` that have reached the end of a call; let their places repeat another
        lane.
        """
        for lane in lanes & waiting:
            self.states[:, lane] = stream.state(lane)
            self.states[self.layout["shift"], lane] = 0.0
            waiting.discard(lane)
        self._repeat(stream, waiting)

    def _repeat(self, stream: Stream, waiting: set[int]) -> None:
        """Let lanes that have nothing to do repeat one that has."""
        for lane in set(range(self.lanes)) - waiting if waiting else ():
            stream.repeat(lane, min(waiting))
            stream.due[lane], stream.broken[lane] = NO_STEP, -1.0


class SeparateLanes:
    """The same as :class:`SynchronisedLanes` for loops that step one lane after the other: a runner for
    each.
    """

    def __init__(self, assembly: Assembly, counts: Counts, recorded: Integers, loop: str) -> None:
        self.counts, self.done = counts, 0
        self.states = initial_states(assembly, counts)
        self.runners = [
            single_runner(assembly, loop, recorded, self.states[:, lane : lane + 1], watch=lane == 0)
            for lane in range(len(counts))
        ]
        self.states[:] = np.concatenate([runner.states for runner in self.runners], axis=1)
        self.broken = self.runners[0].broken

    def advance(self, count: int, outputs: int, *, reset: bool = True, record: bool = True) -> Array:
        """Take ``outputs`` whole intervals of ``count`` steps of the run, or ``count`` steps within one
        interval; the first call takes the start.
        """
        begins = self.done == 0
        output, inside = divmod(max(self.done - 1, 0), int(self.counts[0]))
        past, until = steps_inside(self.counts, inside), steps_inside(self.counts, inside + count)
        rows = []
        for lane, runner in enumerate(self.runners):
            runner.states[:, 0] = self.states[:, lane]
            runner.done = 0 if begins else 1 + output * int(self.counts[lane]) + int(past[lane])
            steps = 1 if begins else int(until[lane] - past[lane])
            rows.append(runner.advance(steps, outputs, reset=reset, record=record))
            self.states[:, lane] = runner.states[:, 0]
        self.done += count * outputs
        return np.concatenate(rows, axis=2)
