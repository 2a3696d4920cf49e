"""Ideal mechanisms of members run side by side: their largest values over a turn, by which steps are chosen and peaks are judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..analysis.measures import PEAKS, last_turn, over_turn
from ..assembly.assembled import Assembly
from ..assembly.bounds import Bounds, limited_rows
from ..solvers.record import Columns, Record, places, recorded_rows
from ..solvers.status import Status
from ..solvers.streaming import stepped
from ..solvers.transient import run

Array = NDArray[np.float64]


@dataclass
class Ideal:
    """An ideal mechanism in a lane, over its turn, of which the extremes are handed out at its end."""

    number: int
    assembly: Assembly
    handed: NDArray[np.uint32]
    columns: Columns
    limited: NDArray[np.intp]
    loop: str = "auto"
    ended: bool = False
    peaks: dict[str, float] | None = None
    before: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.every, self.outputs = self.assembly.choice.steps, 1

    def start(self, state: Array) -> None:
        """The first output."""
        self.before = state[None, self.handed]

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """The last one."""
        self.ended = True
        every = np.concatenate([self.before, rows])
        if broken < 0 and not Bounds(self.assembly, self.handed, self.limited).unsound(every).any():
            record = Record(self.assembly, np.array([0, self.every]), every, self.handed, columns=self.columns)
            self.peaks = over_turn(record, last_turn(record), PEAKS)

    def end(self) -> None:
        """Nothing takes its place."""


def peaks_of(ideals: Sequence[Assembly]) -> list[dict[str, float] | None]:
    """Those of each over its last turn; None where it does not come to its end."""
    if len(ideals) == 1:
        record = run(ideals[0])
        return [over_turn(record, last_turn(record), PEAKS) if record.status == Status.COMPLETE else None]
    handed = recorded_rows(ideals[0])
    shared = handed, Columns(ideals[0].layout, handed), places(handed, limited_rows(ideals[0]))
    found: list[dict[str, float] | None] = [None] * len(ideals)
    for one in stepped((Ideal(k, assembly, *shared) for k, assembly in enumerate(ideals)), len(ideals)):
        if isinstance(one, Ideal):
            found[one.number] = one.peaks
    return found
