"""Rows of S gathered into one a turn: the largest of what is an extreme, the last of all else."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, StepChoice
from ..assembly.timestep import SAFETY
from .record import places
from .repeating import outputs_of_a_turn

Array = NDArray[np.float64]


@dataclass
class TurnRows:
    """Gathers outputs, so many in a turn, into rows of whole turns, shape (rows, lanes) each; ``extreme`` says which rows are extremes."""

    outputs: int
    extreme: NDArray[np.bool_]
    turns: list[Array] = field(default_factory=list)
    inside: int = 0  # outputs of the turn under way
    largest: Array | None = None

    def take(self, rows: Array) -> int:
        """Outputs after that of step 0, shape (outputs, rows, lanes), in pieces of any size; how many turns they end."""
        before = len(self.turns)
        while len(rows):
            part, rows = rows[: self.outputs - self.inside], rows[self.outputs - self.inside :]
            most = part.max(axis=0)
            self.largest = most if self.largest is None else np.maximum(self.largest, most)
            self.inside += len(part)
            if self.inside == self.outputs:
                self.turns.append(np.where(self.extreme[:, None], self.largest, part[-1]))
                self.inside, self.largest = 0, None
        return len(self.turns) - before

    @property
    def remembered(self) -> list[Any]:
        """What a checkpoint keeps of the turn under way, for JSON."""
        return [self.inside, [] if self.largest is None else self.largest.tolist()]

    def restore(self, remembered: list[Any], turns: list[Array]) -> None:
        """Takes up what a checkpoint remembers, and the turns before it."""
        self.inside, self.turns = int(remembered[0]), turns
        self.largest = np.array(remembered[1], dtype=float) if self.inside else None

    def array(self, lanes: int, last: int | None = None) -> Array:
        """The turns, shape (turns, rows, lanes); up to the one that ends with the output ``last``, where it is given."""
        some = self.turns if last is None else self.turns[: last // self.outputs]
        return np.array(some).reshape(len(some), len(self.extreme), lanes)


Counts = NDArray[np.int64]

DEFAULT = 3  # companions of a run with contact on every machine: with the run itself they fill a vector of four numbers
SMALLEST_RATIO, LARGEST_RATIO = 1.4, 2.0  # between the steps of companions and that of the run; others are spread evenly between them
SENSITIVE = 0.01  # range of a measure over run and companions, as a share of its size, beyond which a run is called sensitive
SAMPLED = (
    "joint_moment", "body_alpha", "contact_onsets", "contact_grazing", "contact_deep", "contact_deepest", "contact_fastest",
    "contact_duration", "contact_damping_work", "contact_damping_power", "contact_friction_work", "contact_friction_power", "wear_work",
)  # fmt: skip


DRIVING = ("driven_work", "driven_power", "particle_theta")  # what means of powers and torques take beside it


@dataclass(frozen=True)
class Parting:
    """Where the companions part: the time (s) and the joint whose force first differs by more than SENSITIVE of its largest so far."""

    time: float
    joint: str


@dataclass
class Companions:
    """What companions leave: ``rows`` of S after ``steps``, shape (outputs, kept, companions), of the last turn and the output before it.

    ``turns`` has one row for each whole turn, shape (turns, kept, companions): the largest of extremes, the last of all else; without any where
    turns cannot be told. ``counts`` are the steps that each makes between two outputs; those of a version that displaced its companions have the
    step of the run. ``lost`` are those whose numbers are no longer finite. ``earlier`` are ranges, low and high by measure, of a try with twice
    the step that was given up.
    """

    counts: Counts
    kept: NDArray[np.uint32]
    steps: NDArray[np.int64]
    rows: Array
    parting: Parting | None = None
    lost: tuple[int, ...] = ()
    earlier: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    turns: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))

    @property
    def told(self) -> dict[str, Any]:
        """What is known beside the rows, for JSON."""
        return {"parting": None if self.parting is None else [self.parting.time, self.parting.joint], "lost": list(self.lost)}


def number(assembly: Assembly, loop: str, wanted: int | str) -> int:
    """Companions of a run: as many as are wanted; "auto" is three in straight-line code wherever there is contact, on every machine."""
    if assembly.mechanism.settings.analysis == "static" or not assembly.contacts:
        return 0
    if wanted == "auto":
        return DEFAULT if loop == "generated" else 0
    return int(wanted)


def step_counts(choice: StepChoice, companions: int) -> Counts:
    """Steps between two outputs of companions, the smallest step first.

    They are spread from 1.4 to 2 times the step of the run; a single one has twice the step. None has a step larger than the stable one allows, and
    no two have the same. Where an interval has too few steps for that, or the run's step is near the stable one, companions take smaller steps
    than the run instead, by the same ratios.
    """
    every = choice.outputs_every
    largest = SAFETY * choice.stable
    least = max(-(-every // 2), math.ceil(every * choice.step / largest * (1.0 - 1e-12)) if math.isfinite(largest) else 1)
    found: list[int] = []
    for ratio in np.linspace(LARGEST_RATIO, SMALLEST_RATIO, companions).tolist():
        near = min(max(round(every / ratio), least), every - 1)
        coarser = [n for n in range(max(least, near - companions), min(every, near + companions + 1)) if n not in found]
        if coarser:
            found.append(min(coarser, key=lambda n: abs(n - every / ratio)))
            continue
        finer = max(every + 1, round(every * ratio))
        while finer in found:
            finer += 1
        found.append(finer)
    return np.array(sorted(found, reverse=True), dtype=np.int64)


def measured_rows(assembly: Assembly) -> NDArray[np.uint32]:
    """Rows of S that measures and figures are made of."""
    layout = assembly.layout
    sampled = [row for name in SAMPLED for row in layout.rows_of(name).tolist()]
    return np.array([*layout.of("extreme"), *sampled], dtype=np.uint32)


def companion_rows(assembly: Assembly) -> NDArray[np.uint32]:
    """Rows of S that are kept of companions."""
    driving = [row for name in DRIVING for row in assembly.layout.rows_of(name).tolist()]
    return np.unique(np.concatenate([measured_rows(assembly), np.array(driving, dtype=np.uint32)])).astype(np.uint32)


@dataclass(frozen=True)
class Beside:
    """What belongs to the last of some outputs: rows of the companions, what is told of them, and the oldest step that is still needed; rows of
    whole turns that end with them.
    """

    rows: Array
    told: dict[str, Any]
    oldest: int
    turns: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))  # rows of turns that end here
    first: int = 1  # the number of the first of them
    steps: int = 0  # of a turn


@dataclass
class Gathering:
    """Takes the rows of all lanes as they come, and keeps of the companions what belongs to the last turn."""

    assembly: Assembly
    recorded: NDArray[np.uint32]
    counts: Counts  # steps between two outputs of the companions, without the run itself
    parting: Parting | None = None
    lost: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.kept = companion_rows(self.assembly)
        self.columns = places(self.recorded, self.kept)
        self.watch = Watch(self.assembly, self.recorded)
        self.parts: deque[tuple[NDArray[np.int64], Array]] = deque()
        self.turnly = turn_rows(self.assembly, self.kept)

    def take(self, steps: NDArray[np.int64], rows: Array) -> Beside:
        """Outputs of all lanes, shape (outputs, recorded, lanes), the run itself first."""
        count = len(self.counts)
        part = rows.take(self.columns, axis=1)[:, :, 1 : count + 1]
        self.lost |= set(np.flatnonzero(~np.isfinite(part[-1:]).all(axis=(0, 1))).tolist())  # what is not finite stays so
        if self.parting is None:
            self.parting = self.watch.look(steps, rows[..., : count + 1])
        self.parts.append((steps, part))
        oldest = self.oldest(int(steps[-1])) if len(steps) else 0
        while len(self.parts) > 1 and len(self.parts[0][0]) and self.parts[0][0][-1] < oldest:
            self.parts.popleft()
        told = Companions(self.counts, self.kept, steps, part, self.parting, tuple(sorted(self.lost))).told
        if self.turnly is None:
            return Beside(part, told, oldest)
        ended = self.turnly.take(part[1:] if len(steps) and steps[0] == 0 else part)
        first = len(self.turnly.turns) - ended
        turns = np.array(self.turnly.turns[first:]).reshape(ended, len(self.kept), count)
        return Beside(part, told, oldest, turns, first + 1, self.turnly.outputs * self.assembly.choice.outputs_every)

    @property
    def remembered(self) -> dict[str, Any]:
        """What a checkpoint keeps of this, beside the rows that a file has."""
        watch = self.watch
        told = Companions(self.counts, self.kept, watch.steps, np.zeros(0), self.parting, tuple(sorted(self.lost))).told
        told |= {"turn": None if self.turnly is None else self.turnly.remembered}
        if watch.forces is None or watch.largest is None:
            return {**told, "watch": None}
        return {**told, "watch": [watch.steps.tolist(), watch.forces.tolist(), watch.largest.tolist()]}

    def restore(self, remembered: Mapping[str, Any], kept: tuple[dict[str, Any], NDArray[np.int64], Array] | None, turns: Array) -> None:
        """Takes up what a checkpoint remembers, and rows that a file has, shapes (outputs, kept times companions) and (turns, the same)."""
        parting = remembered["parting"]
        self.parting, self.lost = None if parting is None else Parting(float(parting[0]), str(parting[1])), set(remembered["lost"])
        if remembered["watch"] is not None and remembered["watch"][0]:
            steps, forces, largest = remembered["watch"]
            count = len(self.counts) + 1
            self.watch.steps = np.array(steps, dtype=np.int64)
            self.watch.forces = np.array(forces, dtype=float).reshape(count, len(steps), -1)
            self.watch.largest = np.array(largest, dtype=float)
        if kept is not None:
            _, steps, rows = kept
            self.parts = deque([(steps, rows.reshape(len(rows), len(self.kept), len(self.counts)))])
        if self.turnly is not None:
            if remembered.get("turn") is None:  # of a version that kept none
                self.turnly = None
            else:
                self.turnly.restore(remembered["turn"], list(turns.reshape(len(turns), len(self.kept), len(self.counts))))

    def oldest(self, last: int) -> int:
        """The output before the turn that ends with a step."""
        return oldest_needed(self.assembly, last)

    def left(self, last: int) -> Companions:
        """What they leave at the end of a run, whose last output is that of a step."""
        steps = np.concatenate([steps for steps, _ in self.parts])
        rows = np.concatenate([rows for _, rows in self.parts])
        window = (steps >= self.oldest(last)) & (steps <= last)
        found = Companions(self.counts, self.kept, steps[window], rows[window], self.parting, tuple(sorted(self.lost)))
        if self.turnly is not None:
            found.turns = self.turnly.array(len(self.counts), last // self.assembly.choice.outputs_every)
        return found


class Watch:
    """Finds where lanes part: forces of contacts differ by more than SENSITIVE of the largest so far, and not only because a peak fell into the
    output interval beside.
    """

    def __init__(self, assembly: Assembly, recorded: NDArray[np.uint32]) -> None:
        self.assembly = assembly
        self.columns = places(recorded, assembly.layout["contact_force_squared_max"])
        self.steps: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self.forces: Array | None = None
        self.largest: Array | None = None

    def look(self, steps: NDArray[np.int64], rows: Array) -> Parting | None:
        """The first parting in these outputs, shape (outputs, recorded, lanes); the last output waits for the next ones."""
        with np.errstate(invalid="ignore"):
            return self._look(steps, rows)

    def _look(self, steps: NDArray[np.int64], rows: Array) -> Parting | None:
        force = np.ascontiguousarray(np.sqrt(rows.take(self.columns, axis=1)).transpose(2, 0, 1))  # lanes, outputs, contacts
        if self.forces is None or self.largest is None:
            self.forces, self.largest = force[:, :0], np.zeros(force.shape[2])
        steps, force = np.concatenate([self.steps, steps]), np.concatenate([self.forces, force], axis=1)
        if len(steps) < 3:
            self.steps, self.forces = steps, force
            return None
        largest = np.maximum(np.maximum.accumulate(np.fmax.reduce(force, axis=0), axis=0), self.largest)
        near = np.maximum(np.maximum(force[:, :-2], force[:, 1:-1]), force[:, 2:])
        present = force[:, 1:-1]
        over = (present[1:] - near[0] > SENSITIVE * largest[2:]).any(axis=0) | (present[0] - near[1:] > SENSITIVE * largest[2:]).any(axis=0)
        self.steps, self.forces, self.largest = steps[-2:], force[:, -2:], largest[-1]
        if not over.any():
            return None
        output, contact = np.argwhere(over)[0]
        return Parting(float(steps[output + 1] * self.assembly.choice.step), self.assembly.contact_joints[contact])


def turn_rows(assembly: Assembly, kept: NDArray[np.uint32]) -> TurnRows | None:
    """What gathers these rows of S into one a turn; None where a turn holds no whole number of outputs."""
    outputs, extreme = outputs_of_a_turn(assembly), set(assembly.layout.of("extreme"))
    return None if outputs is None else TurnRows(outputs, np.array([int(row) in extreme for row in kept]))


def oldest_needed(assembly: Assembly, last: int) -> int:
    """The step of the output before the turn that ends with a step; 0 without a crank."""
    choice = assembly.choice
    return max(0, int(np.ceil(last - choice.turn / choice.step - 0.5))) if choice.turn else 0
