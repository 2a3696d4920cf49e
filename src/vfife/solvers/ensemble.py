"""Many simulations at once: lanes of the generated loop on all cores, turn by turn, until each one's turns repeat.

Mechanisms of one topology share lanes; each lane has its own parameters and its own step. Memory does not
grow with the length of the runs: of a member only its last turn is kept, and one row for each turn before. What a member gives depends
neither on those beside it nor on the loop, to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..codegen.cuda import card
from ..errors import VfifeError
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..model.validate import validate
from .arguments import Arguments, Loop
from .record import Record
from .repeating import compared_rows, distance
from .status import Status
from .streaming import Lane, stepped

Array = NDArray[np.float64]


@dataclass
class Member:
    """What one simulation of an ensemble leaves.

    ``turns``: a record with one row a turn (and the start), the state at its end and the extremes over all of it. ``last``: the last turn,
    output by output, with the output before it, so that maxima over it are those of the turn; of a member that diverged no number from there on
    (NaN). ``distances``: of each turn from the one
    before, as :func:`distance` has it (1, infinite for the first). ``settled``: the first turn whose distance is within the tolerance, counted
    from 1, or None. ``status``: "complete" or "diverged".
    """

    turns: Record
    last: Record
    distances: Array
    settled: int | None
    status: Status = Status.COMPLETE

    @property
    def assembly(self) -> Assembly:
        """The mechanism as it was stepped."""
        return self.last.assembly


def ensemble(
    mechanisms: Sequence[Mechanism],
    *,
    step: float | str | Sequence[float | str],
    turns: int,
    outputs: int = 720,
    tolerance: float | None = None,
    loop: Loop = "auto",
    lanes: int | None = None,
    workers: int | None = None,
    device: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Member]:
    """Simulates driven mechanisms, each until its turns repeat within ``tolerance`` or for ``turns`` turns (all of them without a tolerance).

    ``step`` (s, or a text with a unit), one for all or one each, is shortened so that a turn of the crank holds a whole number of steps for each
    of ``outputs``. ``lanes``: simulations side by side in a vector register, as many as this machine's hold if not given. ``workers``: threads,
    as many as there are cores if not given. ``device``: "cuda" steps them on an NVIDIA card, thousands side by side; we have not tried it on one.
    ``progress`` is told how many members of how many are done. Raises ModelError with all faults of the arguments or of a mechanism, VfifeError
    for one without a driver, DeviceError for a card that cannot be used, and what :func:`~vfife.assembly.assemble.assemble` raises. Ctrl-C ends it
    within a second.
    """
    given = Arguments("ensemble")
    mechanisms = given.mechanisms(mechanisms)
    steps, loop = given.each("step", step, len(mechanisms)), given.loop(loop)
    counts = {"turns": turns, "outputs": outputs, "lanes": lanes, "workers": workers}
    for name, value in counts.items():
        given.count(name, value, optional=name in ("lanes", "workers"))
    given.quantity("tolerance", tolerance, "1", zero=True)
    given.device(device)
    given.callable("progress", progress)
    given.check()
    if device == "cuda":
        card()  # what is missing is told before anything is assembled
    for mechanism in mechanisms:
        validate(mechanism)
    assemblies = [placed(mechanism, size, turns, outputs) for mechanism, size in zip(mechanisms, steps, strict=True)]
    return advance(assemblies, tolerance=tolerance, loop=loop, lanes=lanes, workers=workers, device=device, progress=progress)


def placed(mechanism: Mechanism, step: float, turns: int, outputs: int) -> Assembly:
    """The mechanism assembled for ``turns`` turns, its step (s) the largest that divides an output interval and is no larger than ``step``."""
    turn = turn_of(mechanism)
    if turn is None:
        raise VfifeError(f"{mechanism.name}: an ensemble counts turns of a crank, and no driver turns one; drive a body, or use simulate")
    every = max(1, int(np.ceil(turn / (outputs * step) * (1.0 - 1e-9))))
    return assemble(mechanism, turn / (outputs * every), turns=turns, outputs=outputs, force_step=True)


def advance(
    assemblies: Sequence[Assembly],
    *,
    tolerance: float | None = None,
    loop: Loop = "auto",
    lanes: int | None = None,
    workers: int | None = None,
    device: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Member]:
    """As :func:`ensemble`, for mechanisms that are assembled already."""
    found: dict[int, Member] = {}
    every = (_Member(k, assembly, tolerance, loop) for k, assembly in enumerate(assemblies))
    for lane in stepped(every, len(assemblies), lanes=lanes, workers=workers, device=device):
        found[lane.number] = lane.member()
        if progress is not None:
            progress(len(found), len(assemblies))
    return [found[k] for k in range(len(assemblies))]


class _Member(Lane):
    """A member in a lane."""

    def __init__(self, number: int, assembly: Assembly, tolerance: float | None, loop: str) -> None:
        super().__init__(number, assembly, loop=loop)
        self.tolerance, self.status = tolerance, Status.COMPLETE
        self.settled: int | None = None
        self.summaries: list[Array] = []
        self.distances: list[float] = []
        self.rows = np.zeros((0, len(self.handed)))
        layout = assembly.layout
        self.extreme, self.repeated = (np.isin(self.handed, rows) for rows in (layout.of("extreme"), compared_rows(layout)))

    @property
    def ended(self) -> bool:
        """Whether it needs no further turn."""
        turns = self.assembly.choice.outputs // self.per
        return self.settled is not None or self.status != Status.COMPLETE or len(self.distances) == turns

    def start(self, state: Array) -> None:
        """Take the output of step 0."""
        self.rows = state[None, self.handed]
        self.summaries.append(self.rows[0])

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Take a turn; what comes after numbers left all bounds is no number."""
        rows = np.concatenate([rows, np.full((self.per - len(rows), rows.shape[1]), np.nan)])
        bad = self.bounds.unsound(rows).any(axis=1)
        if broken >= 0:
            done = len(self.distances) * len(rows)
            bad |= (done + 1 + np.arange(len(rows))) * self.every >= broken - 1
        if bad.any():
            self.status = Status.DIVERGED
            rows = rows.copy()
            rows[int(np.argmax(bad)) :] = np.nan
        before, self.rows = self.rows, np.concatenate([self.rows[-1:], rows])
        self.summaries.append(np.where(self.extreme, rows.max(axis=0), rows[-1]))
        known = len(before) == len(self.rows) and self.status == Status.COMPLETE
        apart = distance(before[1:, self.repeated], rows[:, self.repeated]) if known else np.inf
        self.distances.append(apart)
        if self.tolerance is not None and apart <= self.tolerance:
            self.settled = len(self.distances)

    def member(self) -> Member:
        """Return what it leaves."""
        end, step = len(self.distances) * self.per, self.every
        ends, last = np.arange(0, end + 1, self.per, dtype=np.int64), np.arange(end - self.per, end + 1, dtype=np.int64)
        turns = Record(self.assembly, ends * step, np.array(self.summaries), self.handed, status=self.status)
        return Member(
            turns,
            Record(self.assembly, last * step, self.rows, self.handed, status=self.status),
            np.array(self.distances),
            self.settled,
            self.status,
        )
