"""A smooth run repeated with half and with a quarter of its step: the difference is the error of its own
step, and both give the order.

Both runs are as long as the run itself, because errors grow with its length: close to a bifurcation
transients decay slowly, and a small error of the step becomes a large one at the end. An order observed in
the first half says nothing about the second.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..codegen.runner import Runner
from ..codegen.straight_line import about
from ..numerics.scalar import log
from .halt import Halt
from .pace import Pace
from .record import Record, places, recorded_rows

Array = NDArray[np.float64]

MOST_LINES = 5e9  # lines times steps of a run that is repeated by default: half a second, three with both repetitions
FINER = (2, 4)  # steps of the repetitions in one step of the run
CHUNK = 64  # outputs between two looks
SAMPLED = ("particle_x", "particle_y", "particle_theta", "particle_ax", "particle_ay", "particle_aw")  # what is of the time t_n
EXACT = 1e-13  # what rounding leaves of positions, relative
EPS = float(np.finfo(float).eps)
OVER_NOISE = 30.0
TINY = 1e-100
PARTS = 8  # of the run, in each of which the differences are compared
DECISIVE = 1e-3  # of the size of the motion: smaller differences between h and h/2 decide nothing, whatever their order
FALLING = 0.5  # a difference that falls by less from one halving to the next falls more slowly than the step
APART = 0.1  # of the size of the motion: runs at h/2 and h/4 that differ by more do not show the same motion


@dataclass
class Refined:
    """Runs at ``half`` and at a ``quarter`` of the step: their outputs from the step ``first`` (of the run
    itself) on.

    ``ratio``: of the second difference of positions and accelerations to the first, over all outputs, 1/4
    where they converge with the second order; None where there is only rounding. ``converges``: whether the
    differences fall with the step wherever outputs were kept.
    """

    half: Record
    quarter: Record
    ratio: float | None
    converges: bool

    @property
    def order(self) -> float | None:
        """By which power of the step positions and accelerations converge."""
        return -log(self.ratio) / log(2.0) if self.ratio else None


def worth(assembly: Assembly) -> bool:
    """Whether a run is short enough to be repeated by default."""
    return about(assembly.topology) * float(assembly.choice.steps) <= MOST_LINES


def refine(record: Record, first: int = 0) -> Refined:
    """Repeats a smooth run with half and with a quarter of its step, and keeps the outputs from the step
    ``first`` on.
    """
    kept = recorded_rows(record.assembly)
    finer = [divided(record.assembly, parts) for parts in FINER]
    runners = [started(one, kept) for one in finer]
    begin = [runner.advance(1, 1)[:, :, 0] for runner in runners]
    windows = [[rows] if first <= 0 else [] for rows in begin]
    compared, outputs = Differences(record, kept), len(record.steps) - 1
    with Halt() as halt:
        paces = [Pace(halt.look) for _ in runners]
        for done in range(0, outputs, CHUNK):
            count = min(CHUNK, outputs - done)
            both = [
                pace.advance(runner, one.choice.outputs_every, count)[:, :, 0]
                for pace, runner, one in zip(paces, runners, finer, strict=True)
            ]  # fmt: skip
            wanted = np.asarray(record.steps[done + 1 : done + 1 + count]) >= first
            for window, rows in zip(windows, both, strict=True):
                window.append(rows[wanted])
            compared.take(done, *both)
    half, quarter = (_record(record, one, parts, kept, np.concatenate(window)) for one, parts, window in zip(finer, FINER, windows, strict=True))
    since = (len(record.steps) - len(half.steps)) * PARTS // len(record.steps)
    return Refined(half, quarter, compared.ratio(), compared.converges(since))


def _record(record: Record, finer: Assembly, parts: int, kept: NDArray[np.uint32], rows: Array) -> Record:
    """The last outputs of a repetition as a record with its own steps."""
    steps = parts * np.asarray(record.steps[len(record.steps) - len(rows) :])
    return Record(finer, steps, rows, kept, loop="generated", status=record.status)


def with_step(assembly: Assembly, step: float) -> Assembly:
    """The same start with another step (s), on which nothing else of it depends."""
    state = assembly.state.copy()
    state[assembly.layout["step"]] = step
    return dataclasses.replace(assembly, state=state)


def divided(assembly: Assembly, parts: int) -> Assembly:
    """The same start with a step that is one of ``parts`` of its own, and outputs at the same times."""
    choice = assembly.choice
    choice = dataclasses.replace(choice, step=choice.step / parts, outputs_every=parts * choice.outputs_every)
    return dataclasses.replace(with_step(assembly, choice.step), choice=choice)


def started(assembly: Assembly, kept: NDArray[np.uint32]) -> Runner:
    """What steps it."""
    return Runner(
        assembly.topology, assembly.state[:, None].copy(), assembly.tables[None, :], "generated", kept, parts=assembly.mechanism.settings.parts
    )


class Differences:
    """Sums the squares of the differences between a step, half and a quarter of it, at the outputs of each
    of ``PARTS`` parts of a run.
    """

    def __init__(self, record: Record, kept: NDArray[np.uint32]) -> None:
        sampled = np.concatenate([record.assembly.layout.rows_of(name) for name in SAMPLED]).astype(np.uint32)
        self.columns, self.own = places(kept, sampled), record.rows[:, places(record.kept, sampled)]
        self.squares, self.counts = np.zeros((PARTS, 2, len(sampled))), np.zeros(PARTS)
        self.step = record.assembly.choice.step

    def take(self, done: int, half: Array, quarter: Array) -> None:
        """Outputs after the first ``done``, shape (outputs, kept) each."""
        fine, finest, own = half[:, self.columns], quarter[:, self.columns], self.own[done + 1 : done + 1 + len(half)]
        part = (done + 1 + np.arange(len(half))) * PARTS // len(self.own)
        with np.errstate(over="ignore", invalid="ignore"):
            for k in np.unique(part):
                inside = part == k
                first, second = (own - fine)[inside], (fine - finest)[inside]
                self.squares[k] += (first * first).sum(axis=0), (second * second).sum(axis=0)
                self.counts[k] += inside.sum()

    def scaled(self) -> tuple[Array, Array, Array]:
        """Mean squares of both differences, of all parts and kinds over the squared size of each kind, and
        the noise of each kind.
        """
        largest = np.abs(self.own).reshape(len(self.own), len(SAMPLED), -1).max(axis=(0, 2), initial=0.0)
        size, turn, push = max(*largest[:2], TINY), max(largest[2], 1.0), max(*largest[3:5], TINY)
        spin = max(largest[5], push / size)
        rounding = EPS * FINER[-1] * FINER[-1] / (self.step * self.step)  # of a second difference of numbers near one
        scale = np.array([size, size, turn, push, push, spin])
        noise = np.array([EXACT, EXACT, EXACT, rounding * size / push, rounding * size / push, rounding * turn / spin])
        found = self.squares.reshape(PARTS, 2, len(SAMPLED), -1).sum(axis=3) / (scale * scale) / np.maximum(self.counts, 1.0)[:, None, None]
        return found[:, 0], found[:, 1], noise

    def ratio(self) -> float | None:
        """Root of the ratio of the squares of both differences, of those kinds of quantities in which
        there is more than rounding.
        """
        coarse, fine, noise = self.scaled()
        share = self.counts[:, None] / max(self.counts.sum(), 1.0)
        coarse, fine = (coarse * share).sum(axis=0), (fine * share).sum(axis=0)
        telling = (np.sqrt(fine) > OVER_NOISE * noise) & (coarse > 0.0)
        return sqrt(float(fine[telling].sum() / coarse[telling].sum())) if telling.any() else None

    def converges(self, since: int) -> bool:
        """Whether the differences fall with the step in all parts from number ``since`` on, where they are
        large enough to matter.
        """
        coarse, fine, noise = self.scaled()
        for k in range(since, PARTS):
            telling = np.sqrt(fine[k]) > OVER_NOISE * noise
            first, second = (sqrt(float(one[k][telling].sum())) for one in (coarse, fine))
            if not second <= APART or (first > DECISIVE and second > FALLING * first):
                return False
        return True
