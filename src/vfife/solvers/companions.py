"""Companion runs: the same run at other step sizes, 1.4 to 2 times its own, and the rows that are kept of
them.

The effect of the step on the measures of a run shows in the differences to its companions. They cost little,
because they run in lanes of the vector register that a run with contact leaves unused
(:mod:`~vfife.solvers.companion_lanes`). Coarser steps are used, not finer ones: they need fewer steps than
the run, and their differences to it are larger than its own error. Several sizes are used, because two may
agree by chance on the error of an onset.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, StepChoice
from ..assembly.timestep import SAFETY
from .record import places
from .repeating import TurnGrid, outputs_per_turn, turn_grid

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass
class TurnRows:
    """Reduce outputs to one row for each turn of a ``grid``, shape (rows, lanes): the largest value
    of the rows that are ``extreme``, the last value of the others.
    """

    grid: TurnGrid
    extreme: NDArray[np.bool_]
    turns: list[Array] = field(default_factory=list)
    inside: int = 0  # outputs of the current turn so far
    largest: Array | None = None

    def take(self, rows: Array) -> int:
        """Add outputs after that of step 0, shape (outputs, rows, lanes), in pieces of any size; return the
        number of turns that they complete.
        """
        turns_before = len(self.turns)
        while len(rows):
            number = len(self.turns)
            remaining = self.grid.end(number + 1) - self.grid.end(number) - self.inside
            part, rows = rows[:remaining], rows[remaining:]
            peak = part.max(axis=0)
            self.largest = peak if self.largest is None else np.maximum(self.largest, peak)
            self.inside += len(part)
            if len(part) == remaining:
                self.turns.append(np.where(self.extreme[:, None], self.largest, part[-1]))
                self.inside, self.largest = 0, None
        return len(self.turns) - turns_before

    @property
    def checkpoint(self) -> list[Any]:
        """State of the current turn, for JSON."""
        return [self.inside, [] if self.largest is None else self.largest.tolist()]

    def restore(self, checkpoint: list[Any], turns: list[Array]) -> None:
        """Continue from a checkpoint and the turns before it."""
        self.inside, self.turns = int(checkpoint[0]), turns
        self.largest = np.array(checkpoint[1], dtype=float) if self.inside else None

    def array(self, lanes: int, last: int | None = None) -> Array:
        """Return the turns, shape (turns, rows, lanes), up to the one that ends with the output ``last`` if
        given.
        """
        turns = self.turns if last is None else self.turns[: self.grid.count(last)]
        return np.array(turns).reshape(len(turns), len(self.extreme), lanes)


# Companions of a run with contact, on every machine: together with the run they fill a vector of four
# numbers.
DEFAULT = 3
# Range of the ratios of their steps to the run's; all others are spread evenly in it.
SMALLEST_RATIO, LARGEST_RATIO = 1.4, 2.0
# A run is called sensitive if a measure differs by more than this share between run and companions.
SENSITIVE = 0.01
SAMPLED = (
    "joint_moment", "body_alpha", "contact_onsets", "contact_grazing", "contact_deep", "contact_deepest",
    "contact_fastest",
    "contact_duration", "contact_damping_work", "contact_damping_power", "contact_friction_work",
    "contact_friction_power", "wear_work",
)  # fmt: skip
# Needed for means of powers and torques.
DRIVING = ("driven_work", "driven_power", "actuator_work", "actuator_power", "particle_theta")


@dataclass(frozen=True)
class Parting:
    """The ``time`` (s) at which companions diverge from the run, and the ``joint`` whose force is the first
    to differ by more than SENSITIVE of its largest so far.
    """

    time: float
    joint: str


@dataclass
class Companions:
    """Records of companions: their ``rows`` after ``steps``, shape (outputs, rows, companions), of the last
    turn and the output before it.

    ``turns`` has one row for each whole turn, shape (turns, rows, companions), as :class:`TurnRows` makes it;
    none without turns. ``counts`` are the steps of each companion between two
    outputs; in files of earlier versions, which displaced companions, they are those of the run.
    ``divergent`` are the companions whose numbers are no longer finite. ``earlier``: ranges (low, high) by
    measure from an abandoned run with twice the step. ``tries``: ranges of the values of all abandoned runs.
    ``burst``: finite companions that blew up, None before these are looked for
    (:mod:`~vfife.measures.energy`).
    """

    counts: Counts
    row_numbers: NDArray[np.uint32]
    steps: NDArray[np.int64]
    rows: Array
    parting: Parting | None = None
    divergent: tuple[int, ...] = ()
    earlier: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    turns: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    tries: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    burst: tuple[int, ...] | None = None

    @property
    def findings(self) -> dict[str, Any]:
        """Parting and divergent companions, for JSON."""
        return findings(self.parting, self.divergent)


def findings(parting: Parting | None, diverged: Iterable[int]) -> dict[str, Any]:
    """Parting and divergent companions, for JSON."""
    return {"parting": None if parting is None else [parting.time, parting.joint], "lost": sorted(diverged)}


def companion_count(assembly: Assembly, loop: str, setting: int | str) -> int:
    """Return the number of companions of a run. "auto" is three in straight-line code if there is contact, on
    every machine, and none otherwise.
    """
    if assembly.mechanism.settings.analysis == "static" or not assembly.contacts:
        return 0
    if setting == "auto":
        return DEFAULT if loop == "generated" else 0
    return int(setting)


def step_counts(choice: StepChoice, companions: int) -> Counts:
    """Return the steps of companions between two outputs, shape (companions,), the smallest step first.

    The step sizes are spread from 1.4 to 2 times that of the run; a single companion has twice the step. No
    step exceeds the stable one, and no two are equal. If an interval has too few steps for that, or the
    run's step is near the stable one, companions have smaller steps than the run, by the same ratios.
    """
    interval = choice.outputs_every
    largest = SAFETY * choice.stable
    fewest = max(
        -(-interval // 2),
        math.ceil(interval * choice.step / largest * (1.0 - 1e-12)) if math.isfinite(largest) else 1,
    )
    counts: list[int] = []
    for ratio in np.linspace(LARGEST_RATIO, SMALLEST_RATIO, companions).tolist():
        nearest = min(max(round(interval / ratio), fewest), interval - 1)
        coarser = [
            n
            for n in range(max(fewest, nearest - companions), min(interval, nearest + companions + 1))
            if n not in counts
        ]
        if coarser:
            counts.append(min(coarser, key=lambda n: abs(n - interval / ratio)))
            continue
        finer = max(interval + 1, round(interval * ratio))
        while finer in counts:
            finer += 1
        counts.append(finer)
    return np.array(sorted(counts, reverse=True), dtype=np.int64)


def measured_rows(assembly: Assembly) -> NDArray[np.uint32]:
    """Return the rows of S from which measures and figures are computed."""
    layout = assembly.layout
    sampled = [row for name in SAMPLED for row in layout.rows_of(name).tolist()]
    return np.array([*layout.of("extreme"), *sampled], dtype=np.uint32)


def companion_rows(assembly: Assembly) -> NDArray[np.uint32]:
    """Return the rows of S that are kept of companions: those of measures, and those needed for means of
    powers and torques.
    """
    driving = [row for name in DRIVING for row in assembly.layout.rows_of(name).tolist()]
    return np.unique(np.concatenate([measured_rows(assembly), np.array(driving, dtype=np.uint32)])).astype(
        np.uint32
    )


@dataclass(frozen=True)
class CompanionOutputs:
    """Data of companions that a file stores with some outputs: their ``rows``, ``findings`` for JSON, and the
    ``oldest`` step that is still needed.

    ``turns``: rows of the turns that end with these outputs; ``first``: number of the first of them;
    ``ends``: the steps at which they end.
    """

    rows: Array
    findings: dict[str, Any]
    oldest: int
    turns: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    first: int = 1
    ends: tuple[int, ...] = ()


@dataclass
class CompanionRecorder:
    """Receive the rows of all lanes; keep those of the companions for the last turn, and one row for each
    turn.
    """

    assembly: Assembly
    recorded: NDArray[np.uint32]
    counts: Counts  # steps between two outputs of the companions, without the run itself
    parting: Parting | None = None
    divergent: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.row_numbers = companion_rows(self.assembly)
        self.columns = places(self.recorded, self.row_numbers)
        self.watch = PartingWatch(self.assembly, self.recorded)
        self.parts: deque[tuple[NDArray[np.int64], Array]] = deque()
        self.turn_rows = turn_rows_of(self.assembly, self.row_numbers)

    def take(self, steps: NDArray[np.int64], rows: Array) -> CompanionOutputs:
        """Add outputs of all lanes, shape (outputs, recorded, lanes), the run first; return what a file has
        to store.
        """
        count = len(self.counts)
        part = rows.take(self.columns, axis=1)[:, :, 1 : count + 1]
        # Numbers that are not finite remain so: the last output shows all divergent companions.
        self.divergent |= set(np.flatnonzero(~np.isfinite(part[-1:]).all(axis=(0, 1))).tolist())
        if self.parting is None:
            self.parting = self.watch.parting(steps, rows[..., : count + 1])
        self.parts.append((steps, part))
        oldest = oldest_needed(self.assembly, int(steps[-1])) if len(steps) else 0
        while len(self.parts) > 1 and len(self.parts[0][0]) and self.parts[0][0][-1] < oldest:
            self.parts.popleft()
        summary = findings(self.parting, self.divergent)
        if self.turn_rows is None:
            return CompanionOutputs(part, summary, oldest)
        completed = self.turn_rows.take(part[1:] if len(steps) and steps[0] == 0 else part)
        first = len(self.turn_rows.turns) - completed
        turns = np.array(self.turn_rows.turns[first:]).reshape(completed, len(self.row_numbers), count)
        ends = turn_end_steps(self.assembly, self.turn_rows.grid, first + 1, completed)
        return CompanionOutputs(part, summary, oldest, turns, first + 1, ends)

    @property
    def checkpoint(self) -> dict[str, Any]:
        """State for JSON, without the rows that are in the file."""
        turn = None if self.turn_rows is None else self.turn_rows.checkpoint
        return findings(self.parting, self.divergent) | {"turn": turn, "watch": self.watch.checkpoint}

    def restore(
        self,
        checkpoint: Mapping[str, Any],
        last: tuple[dict[str, Any], NDArray[np.int64], Array] | None,
        turns: Array,
    ) -> None:
        """Continue from a checkpoint and the rows in a file: ``last``, the rows of the last turn with their
        steps, and ``turns``, one row for each whole turn, companions side by side.
        """
        parting, shape = checkpoint["parting"], (len(self.row_numbers), len(self.counts))
        self.parting = None if parting is None else Parting(float(parting[0]), str(parting[1]))
        self.divergent = set(checkpoint["lost"])
        self.watch.restore(checkpoint["watch"], len(self.counts) + 1)
        if last is not None:
            _, steps, rows = last
            self.parts = deque([(steps, rows.reshape(len(rows), *shape))])
        if checkpoint.get("turn") is None:  # of a version that kept none
            self.turn_rows = None
        elif self.turn_rows is not None:
            self.turn_rows.restore(checkpoint["turn"], list(turns.reshape(len(turns), *shape)))

    def companions(self, last: int) -> Companions:
        """Return the companions at the end of a run, whose last output is that of the step ``last``."""
        steps = np.concatenate([steps for steps, _ in self.parts])
        rows = np.concatenate([rows for _, rows in self.parts])
        window = (steps >= oldest_needed(self.assembly, last)) & (steps <= last)
        companions = Companions(
            self.counts,
            self.row_numbers,
            steps[window],
            rows[window],
            self.parting,
            tuple(sorted(self.divergent)),
        )
        if self.turn_rows is not None:
            companions.turns = self.turn_rows.array(
                len(self.counts), last // self.assembly.choice.outputs_every
            )
        return companions


class PartingWatch:
    """Detect where companions diverge from the run: a contact force differs by more than SENSITIVE of its
    largest value so far.

    A peak that another lane has in the next or the previous output is no difference. A force is therefore
    compared with the largest of three successive outputs of the other lane, and the last output waits for the
    next one.
    """

    def __init__(self, assembly: Assembly, recorded: NDArray[np.uint32]) -> None:
        self.assembly = assembly
        self.columns = places(recorded, assembly.layout["contact_force_squared_max"])
        self.steps: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self.forces: Array | None = None
        self.largest: Array | None = None

    @property
    def checkpoint(self) -> list[Any] | None:
        """State for JSON; None before the first output."""
        if self.forces is None or self.largest is None:
            return None
        return [self.steps.tolist(), self.forces.tolist(), self.largest.tolist()]

    def restore(self, checkpoint: list[Any] | None, lanes: int) -> None:
        """Continue from a checkpoint."""
        if checkpoint is not None and checkpoint[0]:
            steps, forces, largest = checkpoint
            self.steps, self.largest = np.array(steps, dtype=np.int64), np.array(largest, dtype=float)
            self.forces = np.array(forces, dtype=float).reshape(lanes, len(steps), -1)

    def parting(self, steps: NDArray[np.int64], rows: Array) -> Parting | None:
        """Return the first parting in these outputs, shape (outputs, recorded, lanes), or None."""
        with np.errstate(invalid="ignore"):
            return self._parting(steps, rows)

    def _parting(self, steps: NDArray[np.int64], rows: Array) -> Parting | None:
        # Forces, shape (lanes, outputs, contacts).
        force = np.ascontiguousarray(np.sqrt(rows.take(self.columns, axis=1)).transpose(2, 0, 1))
        if self.forces is None or self.largest is None:
            self.forces, self.largest = force[:, :0], np.zeros(force.shape[2])
        steps, force = np.concatenate([self.steps, steps]), np.concatenate([self.forces, force], axis=1)
        if len(steps) < 3:
            self.steps, self.forces = steps, force
            return None
        largest = np.maximum(np.maximum.accumulate(np.fmax.reduce(force, axis=0), axis=0), self.largest)
        window_peak = np.maximum(np.maximum(force[:, :-2], force[:, 1:-1]), force[:, 2:])
        present = force[:, 1:-1]
        exceeded = (present[1:] - window_peak[0] > SENSITIVE * largest[2:]).any(axis=0) | (
            present[0] - window_peak[1:] > SENSITIVE * largest[2:]
        ).any(axis=0)
        self.steps, self.forces, self.largest = steps[-2:], force[:, -2:], largest[-1]
        if not exceeded.any():
            return None
        output, contact = np.argwhere(exceeded)[0]
        return Parting(
            float(steps[output + 1] * self.assembly.choice.step), self.assembly.contact_joints[contact]
        )


def turn_rows_of(assembly: Assembly, recorded: NDArray[np.uint32]) -> TurnRows | None:
    """Return what reduces these rows of S to one row for each turn; None without turns."""
    grid, extreme = turn_grid(assembly), set(assembly.layout.of("extreme"))
    return None if grid is None else TurnRows(grid, np.array([int(row) in extreme for row in recorded]))


def turn_end_steps(assembly: Assembly, grid: TurnGrid, first: int, count: int) -> tuple[int, ...]:
    """Return the steps at which ``count`` turns end, from the turn ``first`` on."""
    return tuple(grid.end(turn) * assembly.choice.outputs_every for turn in range(first, first + count))


def oldest_needed(assembly: Assembly, last: int) -> int:
    """Return the step of the output before the turn that ends with the step ``last``; 0 without a crank.

    A turn that is no whole number of outputs begins between that output and the next one.
    """
    choice = assembly.choice
    if not choice.turn:
        return 0
    begin = last - choice.turn / choice.step
    if outputs_per_turn(choice) is None:
        return max(0, int(np.floor(begin)) - choice.outputs_every + 1)
    return max(0, int(np.ceil(begin - 0.5)))
