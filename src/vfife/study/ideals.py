"""Ideal mechanisms of members run side by side: their largest values over a turn, by which steps are chosen and peaks are judged."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.measures import PEAKS, highest_of_each, last_turn, over_turn
from ..assembly.assembled import Assembly
from ..assembly.bounds import limited_rows
from ..model.bodies import PointMass
from ..solvers.record import Columns, Record, places, recorded_rows
from ..solvers.status import Status
from ..solvers.streaming import Lane, stepped
from ..solvers.transient import run

Array = NDArray[np.float64]


class Ideal(Lane):
    """An ideal mechanism in a lane, over its turn, of which the extremes are handed out at its end."""

    def __init__(self, number: int, assembly: Assembly, handed: NDArray[np.uint32], limited: NDArray[np.intp]) -> None:
        super().__init__(number, assembly, handed, limited=limited)
        self.every, self.per = assembly.choice.steps, 1

    @property
    def ended(self) -> bool:
        """Whether its turn is over."""
        return self.doubtful or self.done > 0

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """The last output."""
        super().take(rows, broken, state)
        self.doubtful |= not np.isfinite(self.parts[0]).all()


def peaks_of(ideals: Sequence[Assembly]) -> list[dict[str, float] | None]:
    """Those of each over its last turn; None where it does not come to its end. They have one topology."""
    if len(ideals) == 1:
        record = run(ideals[0])
        return [over_turn(record, last_turn(record), PEAKS) if record.status == Status.COMPLETE else None]
    handed = recorded_rows(ideals[0])
    limited = places(handed, limited_rows(ideals[0]))
    found: list[dict[str, float] | None] = [None] * len(ideals)
    every = (Ideal(k, assembly, handed, limited) for k, assembly in enumerate(ideals))
    ended = list(stepped(every, len(ideals), workers=max(1, (os.cpu_count() or 1) // 2)))  # others have lanes to step
    for one, peaks in zip(ended, peaks_at_ends(ended), strict=True):
        if not one.doubtful:
            found[one.number] = peaks
    return found


def peaks_at_ends(ended: Sequence[Ideal]) -> list[dict[str, float]]:
    """The measures of each turn: those of all at once where nouns with other numbers have the same measures."""
    first, columns = ended[0], Columns(ended[0].assembly.layout, ended[0].handed)

    def turn(one: Ideal) -> Record:
        return Record(one.assembly, np.array([0, one.every]), np.concatenate(one.parts), one.handed, columns=columns)

    own = any(isinstance(body, PointMass) for body in first.assembly.mechanism.bodies.values())  # of those without inertia nothing is told
    if own or last_turn(turn(first))[0]:
        return [over_turn(turn(one), last_turn(turn(one)), PEAKS) for one in ended]
    every = np.concatenate([one.parts[-1] for one in ended])
    return highest_of_each(Record(first.assembly, np.arange(len(ended)), every, first.handed, columns=columns))
