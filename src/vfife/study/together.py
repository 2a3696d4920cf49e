"""Prepared runs side by side in the lanes of the loop, every output kept: each is the run that :func:`~vfife.simulation.carry_out` makes of it."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.ranges import finer
from ..assembly.assembled import Assembly
from ..result import Result
from ..simulation import Prepared, carry_out, concluded, halved
from ..solvers.record import Record
from ..solvers.repeating import Settling
from ..solvers.status import Progress
from ..solvers.streaming import Lane, stepped
from ..solvers.transient import choose_loop

Array = NDArray[np.float64]
ROOM = 720  # outputs between two looks


class Recorded(Lane):
    """A run in a lane. It is ``doubtful`` where numbers left all bounds: then its own run tells where."""

    def __init__(self, number: int, prepared: Prepared, assembly: Assembly) -> None:
        super().__init__(number, assembly, loop=prepared.loop)
        self.prepared, settle = prepared, assembly.mechanism.settings.settle
        self.settling = None if settle is None else Settling(assembly, self.handed, settle)
        self.result: Result | None = None

    @property
    def outputs(self) -> int:
        """Outputs up to the next look; a turn is looked at when it ends."""
        room = self.settling.room if self.settling is not None else 0
        return min(ROOM, room or ROOM, self.assembly.choice.outputs - self.done)

    def start(self, state: Array) -> None:
        """The first output."""
        self.began = time.perf_counter()
        super().start(state)

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Some outputs."""
        super().take(rows, broken, state)
        if self.settling is not None:
            self.settling.take(rows)
        self.final = state + 0.0

    @property
    def ended(self) -> bool:
        """Whether no output is left to make."""
        return super().ended or (self.settling is not None and self.settling.ended)

    def end(self) -> Recorded | None:
        """Its result; where an automatic step was too large, it is made again with half of that."""
        if self.doubtful:
            self.parts.clear()
            return None
        rows, loop = np.concatenate(self.parts), choose_loop(self.assembly, self.prepared.loop)
        steps, wall = np.arange(len(rows), dtype=np.int64) * self.every, time.perf_counter() - self.began
        record = Record(self.assembly, steps, rows, self.handed, wall, loop, final=self.final, reached=int(steps[-1]))
        if self.prepared.searches and (tried := finer(record)) is not None:
            return Recorded(self.number, self.prepared, halved(self.prepared, self.assembly, tried))
        self.result = concluded(record, self.prepared.reference)
        return None


def fits(one: Prepared) -> bool:
    """Whether a run may be made in a lane: not one with companions, which have the lanes beside it, nor one that is made again at half its step."""
    return not (one.static or one.companions or one.refined) and choose_loop(one.assembly, one.loop) == "generated"


def carried_out(ready: Sequence[Prepared], told: Callable[[Progress], None] | None = None) -> Iterator[tuple[int, Result]]:
    """Results by the place of what was prepared, as they end: on all cores in lanes where that is possible, then one after the other. ``told``
    hears how far all of them are.
    """
    alone = [k for k, one in enumerate(ready) if not fits(one)]
    beside = [Recorded(k, one, one.assembly) for k, one in enumerate(ready) if k not in alone]
    alike, began = Counter(one.assembly.topology for one in beside), time.perf_counter()

    def tick() -> None:
        if told is not None:
            done, steps = sum(one.done * one.every for one in beside), sum(one.assembly.choice.steps for one in beside)
            told(Progress(done, steps, time.perf_counter() - began))

    for one in stepped(beside, len(beside), alike=max(alike.values()), tick=tick) if len(beside) > 1 else ():
        if one.result is not None:
            yield one.number, one.result
            tick()
        else:
            alone.append(one.number)
    for k in sorted([*alone, *(one.number for one in beside if len(beside) == 1)]):
        yield k, carry_out(ready[k], progress=told)
