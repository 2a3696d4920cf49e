"""A smooth run again with half the step: what its own step leaves out is known from the difference, and from a quarter of it the order."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from math import log2

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..codegen.runner import Runner
from ..codegen.straight_line import about
from .companions import measured_rows, oldest_needed
from .halt import Halt
from .pace import Pace
from .record import Record, places

Array = NDArray[np.float64]

MOST_LINES = 5e9  # lines times steps of a run that is made again unasked: a second or two
WORTH_LANES = 1e9  # beyond which two lanes, which have to be compiled, are quicker than two runs
CHUNK = 64  # outputs between two looks
SAMPLED = ("particle_x", "particle_y", "particle_theta", "particle_ax", "particle_ay", "particle_aw")  # what is of the time t_n
EXACT = 1e-13  # what rounding leaves of positions, relative
EPS = float(np.finfo(float).eps)
OVER_NOISE = 30.0
TINY = 1e-100


@dataclass
class Refined:
    """A run at half the step: measured ``rows`` of S at the outputs ``steps`` (numbers of the coarse step) of the last turn and the one before.

    ``order``: by which power of the step positions and accelerations at the outputs converge, over the first half of the run; None where there is
    nothing but rounding left.
    """

    kept: NDArray[np.uint32]
    steps: NDArray[np.int64]
    rows: Array
    order: float | None


def worth(assembly: Assembly) -> bool:
    """Whether a run is short enough to be made again unasked."""
    return about(assembly.topology) * float(assembly.choice.steps) <= MOST_LINES


def refine(record: Record) -> Refined:
    """Runs the first half of a smooth run at a quarter of its step beside all of it at half."""
    half, quarter = (with_step(record.assembly, part * record.assembly.choice.step) for part in (0.5, 0.25))
    choice, kept = record.assembly.choice, measured_rows(record.assembly)
    sampled = np.concatenate([record.assembly.layout.rows_of(name) for name in SAMPLED]).astype(np.uint32)
    outputs, every = len(record.steps) - 1, 2 * choice.outputs_every
    together = about(half.topology) * float(choice.steps) > WORTH_LANES
    runners = [started(group, np.concatenate([kept, sampled])) for group in ([(half, quarter)] if together else [(half,), (quarter,)])]
    begin = runners[0].advance(1, 1)[:, : len(kept), 0]
    for runner in runners[1:]:
        runner.advance(1, 1)
    oldest = oldest_needed(record.assembly, int(record.steps[-1]))
    window = [begin] if oldest == 0 else []
    compared = Differences(record, sampled)
    with Halt() as halt:
        paces = [Pace(halt.look) for _ in runners]
        for done in range(0, outputs, CHUNK):
            count = min(CHUNK, outputs - done)
            rows = np.concatenate([pace.advance(runner, every, count) for pace, runner in zip(paces, runners, strict=True)], axis=2)
            wanted = (done + 1 + np.arange(count)) * choice.outputs_every >= oldest
            window.append(rows[wanted, : len(kept), 0])
            compared.take(done, rows[:, len(kept) :])
    rows = np.concatenate(window)
    return Refined(kept, np.asarray(record.steps[len(record.steps) - len(rows) :]), rows, compared.order())


def with_step(assembly: Assembly, step: float) -> Assembly:
    """The same start with another step (s), on which nothing else of it depends."""
    state = assembly.state.copy()
    state[assembly.layout["step"]] = step
    return dataclasses.replace(assembly, state=state)


def started(group: tuple[Assembly, ...], kept: NDArray[np.uint32]) -> Runner:
    """A runner with a lane for each."""
    states, tables = np.stack([one.state for one in group], axis=1), np.stack([one.tables for one in group])
    return Runner(group[0].topology, states, tables, "generated", kept, parts=group[0].mechanism.settings.parts)


class Differences:
    """Sums the squares of what a step, half of it and a quarter of it differ by at the outputs of the first half of a run."""

    def __init__(self, record: Record, sampled: NDArray[np.uint32]) -> None:
        self.own = record.rows[:, places(record.kept, sampled)]
        self.halves: dict[int, Array] = {}
        self.squares, self.count = np.zeros((2, len(sampled))), 0
        self.step = record.assembly.choice.step

    def take(self, done: int, rows: Array) -> None:
        """Outputs after ``done``, shape (outputs, sampled, 2): at half the step, and at a quarter of it, whose time is half of that."""
        for k, row in enumerate(rows):
            output = done + k + 1
            self.halves[output] = row[:, 0]
            if output % 2 == 0:
                half, own = self.halves.pop(output // 2), self.own[output // 2]
                self.squares += (own - half) ** 2, (half - row[:, 1]) ** 2
                self.count += 1

    def order(self) -> float | None:
        """Logarithm to base two of the ratio of both differences, of those of the four kinds of quantities in which there is more than rounding."""
        largest = np.abs(self.own).reshape(len(self.own), len(SAMPLED), -1).max(axis=(0, 2), initial=0.0)
        size, turn, push = max(*largest[:2], TINY), max(largest[2], 1.0), max(*largest[3:5], TINY)
        spin = max(largest[5], push / size)
        rounding = EPS / (0.25 * self.step) ** 2  # of a second difference of numbers near one
        scale = np.array([size, size, turn, push, push, spin])
        noise = np.array([EXACT, EXACT, EXACT, rounding * size / push, rounding * size / push, rounding * turn / spin])
        coarse, fine = self.squares.reshape(2, len(SAMPLED), -1).sum(axis=2) / scale**2 / max(self.count, 1)
        telling = (np.sqrt(fine) > OVER_NOISE * noise) & (coarse > 0.0)
        return 0.5 * log2(float(coarse[telling].sum() / fine[telling].sum())) if telling.any() else None
