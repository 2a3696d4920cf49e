"""Runs of many variants of one model, side by side in lanes, of which only the measures of the last turn
are kept.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..assembly.timestep import SAFETY, coarse
from ..kernels.topology import Topology
from .record import Columns, Record
from .repeating import whole_outputs
from .streaming import Lane, stepped

Array = NDArray[np.float64]
Look = Callable[[Record], Mapping[str, float]]

CHUNK = 720  # outputs that a lane hands over at a time
# Steps of the variants as multiples of the finest one. Two sizes may agree by chance on the error of an
# onset; four did not in 100 mechanisms.
MULTIPLES = (1.0, 1.4, 1.7, 2.0)
# Steps between two outputs from which on a step is made coarser between its outputs. With fewer, their number
# changes instead.
FINE_OUTPUTS = 10


@dataclass(frozen=True)
class StepSize:
    """A step of a run as the number of steps between two outputs and the number of outputs; ``topology``
    has the corrections that it needs.
    """

    every: int
    outputs: int
    base: Topology
    topology: Topology

    @property
    def steps(self) -> int:
        """Steps of the whole run."""
        return self.every * self.outputs

    def of(self, assembly: Assembly) -> Assembly:
        """Return a variant of the base assembly with this step: what ``assemble`` makes with it, to the
        bit.
        """
        choice, state = assembly.choice, assembly.state.copy()
        step = choice.step * (choice.steps / self.steps)
        same = assembly.topology is self.base or assembly.topology == self.base
        topology = self.topology if same else dataclasses.replace(assembly.topology, coarse=self.topology.coarse)
        state[assembly.layout.row("step")] = step
        found = copy(assembly)  # a batch assembly makes its bodies when they are needed, which ``replace`` would do at once
        changed = dataclasses.replace(choice, step=step, outputs_every=self.every, outputs=self.outputs)
        for name, value in (("state", state), ("choice", changed), ("topology", topology)):
            object.__setattr__(found, name, value)
        return found


def step_sizes(assembly: Assembly) -> list[StepSize]:
    """Return the steps by which the error of a run is estimated; the first one is its own.

    They are 1, 1.4, 1.7 and 2 times the finest. That is the step of the run, or half of it where twice the
    step would not be stable.
    """
    choice = assembly.choice
    coarsest = max(MULTIPLES)
    finest = 1.0 if coarsest * choice.step <= SAFETY * choice.stable * (1.0 + 1e-9) else 1.0 / coarsest
    own = StepSize(choice.outputs_every, choice.outputs, assembly.topology, assembly.topology)
    found = {own.steps: own}
    for multiple in MULTIPLES:
        one = _step_size(assembly, multiple * finest)
        found.setdefault(one.steps, one)
    return list(found.values())


def _step_size(assembly: Assembly, multiple: float) -> StepSize:
    """The step that is nearest to a multiple of the assembly's own and divides its length and, where it is
    possible, its turn.
    """
    choice = assembly.choice
    every, outputs = choice.outputs_every, choice.outputs
    if multiple < 1.0 or every >= FINE_OUTPUTS:
        every = max(1, round(every / multiple))
    else:
        per = choice.turn / (choice.step * every) if choice.turn else float(outputs)
        turns = outputs / per
        whole = abs(turns - round(turns)) < 1e-6 and round(turns) > 0
        outputs = round(turns) * max(1, round(per / multiple)) if whole else max(1, round(outputs / multiple))
    step = choice.step * (choice.steps / (every * outputs))
    topology = assembly.topology
    if assembly.ideals:
        corrections = coarse(assembly.mechanism, dataclasses.replace(choice, step=step), assembly.layout, assembly.state)
        topology = topology if corrections == topology.coarse else dataclasses.replace(topology, coarse=corrections)
    return StepSize(every, outputs, assembly.topology, topology)


def measures_of(variants: Sequence[tuple[Assembly, NDArray[np.uint32], Look]], *, whole: bool = False) -> list[Mapping[str, float] | None]:
    """Return the measures of each variant; None for one whose numbers left all bounds.

    A variant is an assembly, the rows of its state that its measures need, and the function that takes
    measures from its record. The record has the outputs of the last turn and the one before them; with
    ``whole`` as few as possible, which is enough for measures of extremes and of totals. Ctrl-C ends it
    within a second.
    """
    columns: dict[int, Columns] = {}
    lanes = [_Variant(k, *one, columns, whole) for k, one in enumerate(variants)]
    for lane in stepped(lanes, len(lanes)) if lanes else ():
        lane.parts.clear()
    return [lane.values for lane in lanes]


def merged_outputs(assembly: Assembly) -> int:
    """Return how many outputs may be one, so that the last turn begins and ends with an output; all of
    them where there are no turns.
    """
    choice = assembly.choice
    if not choice.turn:
        return choice.outputs
    turn = whole_outputs(choice)
    return 1 if turn is None else math.gcd(turn, choice.outputs)


class _Variant(Lane):
    """A variant in a lane."""

    values: Mapping[str, float] | None = None

    def __init__(self, number: int, assembly: Assembly, handed: NDArray[np.uint32], look: Look, columns: dict[int, Columns], whole: bool) -> None:
        super().__init__(number, assembly, handed)
        self.look, self.columns, self.first = look, columns, 0  # the number of the first output that is kept
        merged = merged_outputs(assembly) if whole else 1
        choice = assembly.choice
        self.every, self.count = merged * choice.outputs_every, choice.outputs // merged
        turn = choice.turn / (choice.step * self.every) if choice.turn else float(self.count)
        self.oldest = max(0, int(np.floor(self.count - turn - 0.5)))

    @property
    def outputs(self) -> int:
        """Outputs up to the next look."""
        return min(CHUNK, self.count - self.done)

    @property
    def ended(self) -> bool:
        """Whether it needs no further step."""
        return self.doubtful or self.done >= self.count

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Keep outputs, and drop those before the last turn."""
        self.doubtful = broken >= 0 or not np.isfinite(rows).all()
        self.parts.append(rows)
        self.done += len(rows)
        while len(self.parts) > 1 and self.first + len(self.parts[0]) <= self.oldest:
            self.first += len(self.parts.pop(0))

    def end(self) -> None:
        """Take the measures."""
        if self.doubtful:
            return
        rows = np.concatenate(self.parts)
        steps = (self.first + np.arange(len(rows), dtype=np.int64)) * self.every
        columns = self.columns.setdefault(id(self.handed), Columns(self.assembly.layout, self.handed))
        alike = columns if columns.layout is self.assembly.layout else None
        self.values = self.look(Record(self.assembly, steps, rows, self.handed, columns=alike))
