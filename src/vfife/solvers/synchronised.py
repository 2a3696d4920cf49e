"""Lanes with different step sizes that meet at every output: a run and its companions.

Between two outputs lane k makes ``counts[k]`` steps, lane 0 (the run) ``counts[0]``. All of a vector register step at once, so a lane that has
reached the output waits there: its state is set aside, and its place repeats a lane that is still under way, in which nothing else happens.
After part of an interval, n steps of the run, lane k has made floor(n counts[k]/counts[0]) steps. So the state of every lane follows from the
number of steps of the run alone, wherever a run is cut into calls, and checkpoints need nothing else.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, bounds, limited_rows, watched
from ..codegen.loops import NEVER
from ..codegen.runner import LOOK, Runner, Stream
from .record import places

Array = NDArray[np.float64]
Integers = NDArray[np.uint32]
Counts = NDArray[np.int64]


class Stepper(Protocol):
    """One or more lanes, as :class:`~vfife.codegen.runner.Runner` has them."""

    done: int
    broken: Array

    @property
    def states(self) -> Array:
        """Present states, shape (rows, lanes); what is written into it is gone on with."""

    def advance(self, count: int, outputs: int, *, anew: bool = True, record: bool = True) -> Array:
        """``outputs`` times ``count`` steps of the run; the rows recorded after each, shape (outputs, kept, lanes)."""


def step_sizes(assembly: Assembly, counts: Counts) -> Array:
    """Step (s) of lanes that make so many steps between two outputs; that of the run itself to the bit."""
    choice = assembly.choice
    return np.where(counts == choice.outputs_every, choice.step, choice.step * choice.outputs_every / counts)


def initial_states(assembly: Assembly, counts: Counts) -> Array:
    """States at the start, which differ in their steps only, shape (rows, lanes)."""
    states = np.repeat(assembly.state[:, None], len(counts), axis=1)
    states[assembly.layout["step"]] = step_sizes(assembly, counts)
    return states


class SynchronisedLanes:
    """Steps a run and its companions in the lanes of one vector register."""

    def __init__(self, assembly: Assembly, counts: Counts, kept: Integers, room: int) -> None:
        self.counts, self.kept, self.room, self.done = counts, kept, room, 0
        self.layout, self.tables, self.parts = assembly.layout, assembly.tables, assembly.mechanism.settings.parts
        self.topology, self.bounds = assembly.topology, np.stack(bounds(assembly))
        self.limited, self.extremes = limited_rows(assembly), np.array(assembly.layout.of("extreme"), dtype=np.intp)
        self.columns = places(kept, self.extremes)
        self.lanes = 1 << (len(counts) - 1).bit_length()  # a vector holds 1, 2, 4 or 8 numbers
        self.states = initial_states(assembly, counts)
        self.broken = np.zeros(1)  # steps of the run after which its numbers were seen to have left all bounds; companions may leave them
        self.stream: Stream | None = None

    def advance(self, count: int, outputs: int, *, anew: bool = True, record: bool = True) -> Array:
        """Goes on by ``outputs`` whole intervals of ``count`` steps, or by ``count`` steps within one."""
        if self.done == 0:
            return self._begin()
        inside = (self.done - 1) % int(self.counts[0])
        made, until = self.steps_inside(inside), self.steps_inside(inside + count)
        if anew:
            self.states[self.extremes] = 0.0
        self.done += count * outputs
        if inside == 0 and count == self.counts[0]:
            return self._intervals(outputs)
        output = (self.done - 1 - inside - count) // int(self.counts[0])
        self._piece(output * self.counts + made, until - made)
        return np.array(self.states[self.kept][None]) + 0.0 if record else np.zeros((1, 0, len(self.counts)))

    def steps_inside(self, inside: int) -> Counts:
        """Steps that each lane has made since the last output, when the run has made ``inside`` of them."""
        found: Counts = inside * self.counts // self.counts[0]
        return found

    def _begin(self) -> Array:
        """The first output: the start, as the first step of a run has it."""
        tables = np.repeat(self.tables[None, :], self.lanes, axis=0)
        runner = Runner(self.topology, self._filled(self.states), tables, "generated", self.kept, parts=self.parts)
        rows = runner.advance(1, 1)[:, :, : len(self.counts)]
        self.states[:], self.done = runner.states[:, : len(self.counts)], 1
        return rows

    def _filled(self, states: Array) -> Array:
        """States of the lanes, and that of the run in places that are left of the vector."""
        return states[:, [lane if lane < len(self.counts) else 0 for lane in range(self.lanes)]]

    def _intervals(self, outputs: int) -> Array:
        """So many whole intervals, in which each lane hands out its own outputs."""
        before = (self.done - 1) // int(self.counts[0]) - outputs
        stream = self._loaded(before * self.counts)
        own = len(self.counts)
        stream.at[:own], stream.stop[:own], stream.every[:own] = 0, outputs, self.counts
        stream.due[:own] = stream.done + self.counts
        waiting = set(range(own))
        while waiting:
            stream.advance(int(max(stream.due[lane] + (outputs - 1 - stream.at[lane]) * stream.every[lane] for lane in waiting)) - stream.done)
            self._watch(stream, waiting)
            self._set_aside(stream, {lane for lane in waiting if stream.at[lane] >= outputs}, waiting)
        rows = np.ascontiguousarray(stream.out[:own, :outputs].transpose(1, 2, 0)) + 0.0
        self.states[self.extremes] = rows[-1][self.columns]  # a stream clears them when it hands them out; a run does so in its next step
        return rows

    def _piece(self, made: Counts, missing: Counts) -> None:
        """So many steps of each lane, which has ``made`` so many after its start, without any output."""
        stream = self._loaded(made)
        end = stream.done + missing
        waiting = set(np.flatnonzero(missing).tolist())
        self._rest(stream, waiting)
        while waiting:
            stream.advance(int(min(end[lane] for lane in waiting)) - stream.done)
            self._watch(stream, waiting)
            self._set_aside(stream, {lane for lane in waiting if stream.done >= end[lane]}, waiting)

    def _loaded(self, made: Counts) -> Stream:
        """The stream with the states of all lanes, each after so many steps of its own."""
        stream = self.stream
        if stream is None:
            parts, tables = self.parts, len(self.tables)
            stream = self.stream = Stream(
                self.topology, self.lanes, "generated", self.kept, self.room, self.kept, self.limited, tables, parts, look=LOOK
            )
            stream.T.reshape(self.lanes, -1)[:] = self.tables
            stream.limits.reshape(-1, 2, self.lanes)[:] = self.bounds.T[:, :, None]
        stream.states[:] = self._filled(self.states)
        stream.done = 1 + int(made[0])  # counted as the run's own steps are
        ahead = 1 + made - stream.done  # a lane's step n + shift is its own, counted from its start
        stream.states[self.layout["shift"]] = ahead[[lane if lane < len(made) else 0 for lane in range(self.lanes)]]
        stream.due[:], stream.broken[:] = NEVER, -1.0
        if self.broken[0] == 0.0:
            stream.broken[0] = 0.0
        return stream

    def _watch(self, stream: Stream, waiting: set[int]) -> None:
        """Notes after how many of its steps the run has broken; its companions go on up to the end of the call."""
        if 0 in waiting and stream.broken[0] > 0.0:
            self.broken[0] = stream.broken[0]
            self._set_aside(stream, {0}, waiting)

    def _set_aside(self, stream: Stream, some: set[int], waiting: set[int]) -> None:
        """Keeps the states of lanes that have come to the end of a call, and lets their places repeat another lane."""
        for lane in some & waiting:
            self.states[:, lane] = stream.state(lane)
            self.states[self.layout["shift"], lane] = 0.0
            waiting.discard(lane)
        self._rest(stream, waiting)

    def _rest(self, stream: Stream, waiting: set[int]) -> None:
        """Has lanes for which nothing is left to do repeat one that is under way."""
        for lane in set(range(self.lanes)) - waiting if waiting else ():
            stream.repeat(lane, min(waiting))
            stream.due[lane], stream.broken[lane] = NEVER, -1.0


class SeparateLanes:
    """The same for loops that step one lane after the other: a runner for each."""

    def __init__(self, assembly: Assembly, counts: Counts, kept: Integers, loop: str) -> None:
        self.counts, self.done = counts, 0
        self.states, parts = initial_states(assembly, counts), assembly.mechanism.settings.parts
        self.runners = [
            Runner(
                assembly.topology, self.states[:, lane : lane + 1], assembly.tables[None, :], loop, kept, parts=parts,
                watched=watched([assembly], np.array([lane == 0])),
            )
            for lane in range(len(counts))
        ]  # fmt: skip
        self.states[:] = np.concatenate([runner.states for runner in self.runners], axis=1)
        self.broken = self.runners[0].broken

    def advance(self, count: int, outputs: int, *, anew: bool = True, record: bool = True) -> Array:
        """Goes on by ``outputs`` whole intervals of ``count`` steps, or by ``count`` steps within one."""
        begins = self.done == 0
        output, inside = divmod(max(self.done - 1, 0), int(self.counts[0]))
        made, until = (n * self.counts // self.counts[0] for n in (inside, inside + count))
        rows = []
        for lane, runner in enumerate(self.runners):
            runner.states[:, 0] = self.states[:, lane]
            runner.done = 0 if begins else 1 + output * int(self.counts[lane]) + int(made[lane])
            own = 1 if begins else int(until[lane] - made[lane])
            rows.append(runner.advance(own, outputs, anew=anew, record=record))
            self.states[:, lane] = runner.states[:, 0]
        self.done += count * outputs
        return np.concatenate(rows, axis=2)
