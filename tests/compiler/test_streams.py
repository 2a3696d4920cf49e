"""Lanes with outputs and ends of their own: each simulation has the bits of one that runs alone, whoever was
in its lane before it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lane_models
from support import bits
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly, bounds, limited_rows
from vfife.compiler.runtime.runner import Runner, Starter, Stream
from vfife.solvers.record import recorded_rows

WITHIN = 250  # steps in which a lane that breaks is seen, so that no case waits long for its lane
# Contacts with their events; drivers and loads over time.
MODELS: tuple[tuple[Callable[[int], Any], float], ...] = (
    (lane_models.one_clearance, 4e-6),
    (lane_models.swing, 2e-5),
)

STREAM_LOOK = 250  # steps between two looks of a stream at its lanes, as docs/internals.md says


def assembled(model: Callable[[int], Any], step: float, which: int) -> Assembly:
    """One of several simulations, each of its own parameters and step."""
    return assemble(model(which % 4), step * (1.0, 0.8, 0.5)[which % 3], duration=1.0, force_step=True)


def alone(assembly: Assembly, every: int, outputs: int) -> np.ndarray:
    """Rows after every so many steps of one that runs by itself."""
    runner = Runner(
        assembly.topology,
        assembly.state[:, None],
        assembly.tables[None],
        "generated",
        recorded_rows(assembly),
    )
    runner.advance(1, 1)
    return runner.advance(every, outputs)[:, :, 0]


class Filled:
    """A stream that is filled from a queue."""

    def __init__(self, assemblies: list[Assembly], lanes: int, loop: str = "generated") -> None:
        first = self.first = assemblies[0]
        self.assemblies, self.queue = assemblies, list(range(len(assemblies)))
        assert all(one.topology == first.topology for one in assemblies)
        kept = recorded_rows(first)
        self.stream = Stream(
            first.topology, lanes, loop, kept, 8, kept, limited_rows(first), len(first.tables)
        )
        self.starter = Starter(first.topology, lanes, loop, len(first.tables), 8)
        self.inside: dict[int, int] = {}
        self.rows: dict[int, list[np.ndarray]] = {k: [] for k in self.queue}

    def fill(self, lane: int) -> None:
        """The next of the queue."""
        self.inside.pop(lane, None)
        if self.queue:
            k = self.inside[lane] = self.queue.pop(0)
            one = self.assemblies[k]
            self.stream.put(
                lane,
                self.starter.started(one.state, one.tables, np.stack(bounds(one))),
                20 + 7 * k,
                3 + k % 3,
            )
        else:
            self.stream.leave(lane)

    def run(self, piece: int) -> None:
        """Until all have handed out their outputs twice; never more than ``piece`` steps in a call."""
        for lane in range(self.stream.lanes):
            self.fill(lane)
        while self.inside:
            self.stream.advance(piece)
            for lane, k in list(self.inside.items()):
                if self.stream.at[lane] >= self.stream.stop[lane]:
                    self.rows[k].append(self.stream.out[lane, : self.stream.at[lane]].copy())
                    if len(self.rows[k]) == 2:
                        self.fill(lane)
                    else:
                        self.stream.go_on(lane, 3 + k % 3)


@pytest.mark.parametrize(("model", "step"), MODELS, ids=lambda one: getattr(one, "__name__", ""))
@pytest.mark.parametrize(("lanes", "piece"), [(1, 1000), (2, 33), (4, 1000), (8, 101)])
def test_a_simulation_has_the_bits_of_one_that_runs_alone(
    model: Callable[[int], Any], step: float, lanes: int, piece: int
) -> None:
    assemblies = [assembled(model, step, which) for which in range(7)]
    filled = Filled(assemblies, lanes)
    filled.run(piece)
    for k, one in enumerate(assemblies):
        expected = alone(one, 20 + 7 * k, 2 * (3 + k % 3))
        assert (bits(np.concatenate(filled.rows[k])) == bits(expected)).all(), k


@pytest.mark.parametrize("loop", ["data-driven", "interpreted"])
def test_the_other_loops_know_streams_of_one_lane(loop: str) -> None:
    model, step = MODELS[0]
    assemblies = [assembled(model, step, which) for which in range(2)]
    filled = Filled(assemblies, 1, loop)
    filled.run(50)
    for k, one in enumerate(assemblies):
        assert (bits(np.concatenate(filled.rows[k])) == bits(alone(one, 20 + 7 * k, 2 * (3 + k % 3)))).all()


def test_a_lane_that_breaks_ends_the_call_and_no_other_lane() -> None:
    """Seen within WITHIN steps, where the call ends; it is not looked at again when it is left."""
    model, step = MODELS[0]
    assemblies = [assembled(model, step, which) for which in (0, 3)]
    filled = Filled(assemblies, 2)
    wild = np.full((2, len(limited_rows(filled.first))), 0.0)
    wild[:] = [[1.0], [2.0]]  # no number of it lies there
    for lane, one in enumerate(assemblies):
        limits = np.stack(bounds(one)) if lane == 0 else wild
        filled.stream.put(lane, filled.starter.started(one.state, one.tables, limits), 10**6, 1)
    filled.stream.advance(10_000)
    look = filled.stream.done
    assert look <= WITHIN
    assert filled.stream.broken.tolist() == [0.0, look]
    filled.stream.leave(1)
    filled.stream.advance(10_000)
    assert filled.stream.done == look + 10_000
    expected = alone(assemblies[0], look + 10_000 - 1, 1)[0]
    assert (bits(filled.stream.states[recorded_rows(filled.first), 0]) == bits(expected)).all()


def test_a_lane_is_looked_at_after_as_many_steps_of_its_own_whenever_it_came() -> None:
    """As a run by itself is: it comes where ``beat`` is zero."""
    model, step = MODELS[0]
    assemblies = [assembled(model, step, which) for which in (0, 3)]
    filled = Filled(assemblies, 2)
    wild = np.array([[1.0], [2.0]]) * np.ones(len(limited_rows(filled.first)))
    for lane, one in enumerate(assemblies):
        filled.stream.put(
            lane, filled.starter.started(one.state, one.tables, np.stack(bounds(one))), 10**6, 1
        )
    filled.stream.advance(3 * WITHIN + 7)
    filled.stream.advance(filled.stream.beat)
    one = assemblies[1]
    begun = filled.stream.put(1, filled.starter.started(one.state, one.tables, wild), 10**6, 1)
    filled.stream.advance(10_000)
    assert filled.stream.broken[1] - begun == WITHIN
