"""Many simulations at once: lanes of the generated loop on all cores, turn by turn, until each one's turns repeat.

Mechanisms of one topology and one number of steps a turn share lanes; each lane has its own parameters and its own step. Memory does not
grow with the length of the runs: of a member only its last turn is kept, and one row for each turn before. What a member gives depends
neither on those beside it nor on the loop, to the bit.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..assembly.bounds import Bounds, watched
from ..codegen.cuda import card
from ..codegen.native import widest
from ..codegen.ondevice import DeviceRunner
from ..codegen.runner import Runner
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..model.validate import validate
from .arguments import Arguments, Loop
from .pace import Pace
from .record import Record, recorded_rows
from .repeating import compared_rows, distance
from .status import Status
from .transient import choose_loop

Array = NDArray[np.float64]
ON_CARD = 4096  # members side by side on a card: of each, rows of a turn come back, some 100 kB


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
    ``progress`` is told how many members of how many are done. Raises ModelError with all faults of the arguments or of a mechanism, ValueError
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
    given.tell()
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
        raise ValueError(f"{mechanism.name}: an ensemble counts turns of a crank, and no driver turns one; drive a body, or use simulate")
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
    make = DeviceRunner if device == "cuda" else Runner
    lanes = lanes or (ON_CARD if device == "cuda" else widest())
    batches = [(choice, batch) for choice, group in _alike(assemblies, loop) for batch in _cut(group, lanes if choice == "generated" else 1)]
    stop, found = threading.Event(), dict[int, Member]()

    def work(choice: str, batch: list[int]) -> list[tuple[int, Member]]:
        members = [_Lane(assemblies[k], tolerance) for k in batch]
        _run(members, choice, len(batch) if device == "cuda" else lanes if choice == "generated" else 1, stop, make)
        return [(k, lane.member()) for k, lane in zip(batch, members, strict=True) if lane.distances]

    pool = ThreadPoolExecutor(1 if device == "cuda" else workers or os.cpu_count() or 1)
    try:
        left: set[Future[list[tuple[int, Member]]]] = {pool.submit(work, choice, batch) for choice, batch in batches}
        while left:
            done, left = wait(left, timeout=0.2, return_when=FIRST_COMPLETED)
            for future in done:
                found |= dict(future.result())
            if done and progress is not None:
                progress(len(found), len(assemblies))
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)
    return [found[k] for k in range(len(assemblies))]


def _alike(assemblies: Sequence[Assembly], loop: Loop) -> Iterator[tuple[str, list[int]]]:
    """Indices of the assemblies that can share lanes, with the loop for them."""
    groups: dict[tuple[object, ...], list[int]] = {}
    for k, assembly in enumerate(assemblies):
        choice = assembly.choice
        groups.setdefault(
            (assembly.topology, choice.outputs_every, choice.outputs, len(assembly.tables), assembly.mechanism.settings.parts), []
        ).append(k)
    for group in groups.values():
        yield choose_loop(assemblies[group[0]], loop), group


def _cut(group: list[int], size: int) -> Iterator[list[int]]:
    for first in range(0, len(group), size):
        yield group[first : first + size]


def _run(members: list[_Lane], loop: str, lanes: int, stop: threading.Event, make: type[Runner]) -> None:
    """Steps a batch turn by turn until every member has ended; lanes without a member repeat the last one."""
    every = [*members, *[members[-1]] * (lanes - len(members))]
    first = members[0].assembly
    states = np.stack([lane.assembly.state for lane in every], axis=1)
    tables = np.stack([lane.assembly.tables for lane in every])
    own = watched([lane.assembly for lane in every], np.arange(lanes) < len(members))
    runner = make(first.topology, states, tables, loop, recorded_rows(first), parts=first.mechanism.settings.parts, watched=own)
    start = runner.advance(1, 1)
    for k, lane in enumerate(members):
        lane.start(start[0, :, k])
    count, outputs = first.choice.outputs_every, _per_turn(first)
    pace = Pace(partial(_end_if, stop))
    for _ in range(first.choice.outputs // outputs):
        if all(lane.ended for lane in members):
            return
        try:
            rows = pace.advance(runner, count, outputs)
        except _Ended:
            return
        for k, lane in enumerate(members):
            if not lane.ended:
                lane.take(rows[:, :, k], int(runner.broken[k]) - 1)
                if lane.ended:
                    runner.broken[k] = -1.0  # nobody waits for it any more


class _Ended(Exception):
    """The ensemble was broken off."""


def _end_if(stop: threading.Event) -> None:
    if stop.is_set():
        raise _Ended


def _per_turn(assembly: Assembly) -> int:
    """Outputs in a turn."""
    choice = assembly.choice
    return round((choice.turn or 0.0) / (choice.step * choice.outputs_every))


@dataclass
class _Lane:
    """A member while it is stepped."""

    assembly: Assembly
    tolerance: float | None
    summaries: list[Array] = field(default_factory=list)
    distances: list[float] = field(default_factory=list)
    settled: int | None = None
    status: Status = Status.COMPLETE

    def __post_init__(self) -> None:
        self.kept = recorded_rows(self.assembly)
        self.bounds = Bounds(self.assembly, self.kept)
        layout = self.assembly.layout
        extreme = set(layout.of("extreme"))
        self.extreme = np.array([int(row) in extreme for row in self.kept])
        rows = set(compared_rows(layout))
        self.repeated = np.array([int(row) in rows for row in self.kept])
        self.rows = np.zeros((0, len(self.kept)))

    @property
    def ended(self) -> bool:
        """Whether it needs no further turn."""
        return self.settled is not None or self.status != Status.COMPLETE

    def start(self, row: Array) -> None:
        """The output of step 0."""
        self.summaries.append(row)
        self.rows = row[None, :]

    def take(self, rows: Array, broken: int) -> None:
        """A turn, and the step after which it was seen broken, less than 0 where it was not; what comes after that is no number."""
        bad = self.bounds.unsound(rows).any(axis=1)
        if broken >= 0:
            done = len(self.distances) * len(rows)
            bad |= (done + 1 + np.arange(len(rows))) * self.assembly.choice.outputs_every >= broken
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
        """What it leaves."""
        per = _per_turn(self.assembly)
        end, every = len(self.distances) * per, self.assembly.choice.outputs_every
        outputs = np.arange(end - per, end + 1, dtype=np.int64)
        turns = Record(self.assembly, np.arange(0, end + 1, per, dtype=np.int64) * every, np.array(self.summaries), self.kept, status=self.status)
        last = Record(self.assembly, outputs * every, self.rows, self.kept, status=self.status)
        return Member(turns, last, np.array(self.distances), self.settled, self.status)
