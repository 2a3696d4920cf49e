"""Ensembles of mechanisms in lanes on all cores, each until its turns repeat, and variants of one model for
the error of the step.

Mechanisms of one topology share lanes; each lane has its own parameters and its own step. Memory does not
grow with the length of runs. The results of a mechanism do not depend on the other lanes or on the loop, to
the bit.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Unpack

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..assembly.timestep import SAFETY, coarse
from ..compiler.runtime.cuda import card
from ..errors import VfifeError
from ..kernels.topology import Topology
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..model.validation import validate
from ..options import with_faults
from .arguments import Arguments, Loop
from .record import Columns, Record
from .repeating import compared_rows, distance, outputs_per_turn
from .status import Status
from .streaming import Lane, Processor, stepped

Array = NDArray[np.float64]


@dataclass
class EnsembleCase:
    """The result of one simulation of an ensemble.

    ``turns``: a record with one row for the start and one for each turn, the state at its end with the
    extremes over it. ``last``: a record of the last turn, output by output, with the output before it; NaN
    from where a simulation diverged. ``distances``: the distance of each turn from the one before
    (:func:`distance`), infinite for the first, shape (turns,). ``settled``: the first turn, counted from 1,
    whose distance is within the tolerance, or None. ``status``: "complete" or "diverged".
    """

    turns: Record
    last: Record
    distances: Array
    settled: int | None
    status: Status = Status.COMPLETE

    @property
    def assembly(self) -> Assembly:
        """The assembly that was stepped."""
        return self.last.assembly


@with_faults(Processor)
def ensemble(
    mechanisms: Sequence[Mechanism], *, step: float | str | Sequence[float | str], turns: int,
    outputs: int = 720,
    tolerance: float | None = None, loop: Loop = "auto", progress: Callable[[int, int], None] | None = None,
    **processor: Unpack[Processor],
) -> list[EnsembleCase]:  # fmt: skip
    """Simulate driven mechanisms, each until its turns repeat or for a number of turns, side by side on all
    cores.

    mechanisms: the mechanisms, each with a driver
    step: time step (s, or a text with a unit), one for all or one for each; it is reduced until a turn of the
    crank has a whole number of steps for each output
    turns: of the crank, at most
    outputs: number per turn
    tolerance: share of the largest values within which turns repeat (1)
    loop: as of :func:`vfife.simulate`
    progress: ``progress(done, total)`` is called after each simulation
    processor: ``lanes``, simulations side by side in a vector register, by default as many as this machine's
    holds; ``workers``, threads, by default one for each core; ``device``, "cuda" for an NVIDIA card, with
    thousands side by side

    Returns one case for each mechanism, in their order. Raises ModelError with all faults of the arguments or
    of a mechanism, VfifeError for a mechanism without a driver, DeviceError for a card that cannot be used,
    and what :func:`~vfife.assembly.assemble.assemble` raises. Ctrl-C ends it within a second.
    """
    arguments = Arguments("ensemble")
    mechanisms = arguments.mechanisms(mechanisms)
    steps, loop = arguments.positive_times("step", step, len(mechanisms)), arguments.loop(loop)
    for name, value in {
        "turns": turns,
        "outputs": outputs,
        "lanes": None,
        "workers": None,
        **processor,
    }.items():
        if name != "device":
            arguments.count(name, value, optional=name in ("lanes", "workers"))
    arguments.quantity("tolerance", tolerance, "1", zero=True)
    arguments.device(device := processor.get("device"))
    arguments.callable("progress", progress)
    arguments.check()
    if device == "cuda":
        card()  # raises what is missing before anything is assembled
    for mechanism in mechanisms:
        validate(mechanism)
    assemblies = [
        placed(mechanism, size, turns, outputs) for mechanism, size in zip(mechanisms, steps, strict=True)
    ]
    return advance(assemblies, tolerance=tolerance, loop=loop, progress=progress, **processor)


def placed(mechanism: Mechanism, step: float, turns: int, outputs: int) -> Assembly:
    """Return the mechanism assembled for ``turns`` turns, with the largest step (s) that divides an output
    interval and is not larger than ``step``. Raises VfifeError without a crank.
    """
    turn = turn_of(mechanism)
    if turn is None:
        raise VfifeError(
            f"{mechanism.name}: an ensemble counts turns of a crank, and no driver turns one; drive a body,"
            " or use simulate"
        )
    interval = max(1, int(np.ceil(turn / (outputs * step) * (1.0 - 1e-9))))
    return assemble(mechanism, turn / (outputs * interval), turns=turns, outputs=outputs, force_step=True)


def advance(
    assemblies: Sequence[Assembly], *, tolerance: float | None = None, loop: Loop = "auto",
    progress: Callable[[int, int], None] | None = None, **processor: Unpack[Processor],
) -> list[EnsembleCase]:  # fmt: skip
    """Simulate assembled mechanisms; everything else is as in :func:`ensemble`."""
    cases: dict[int, EnsembleCase] = {}
    lanes = (EnsembleLane(k, assembly, tolerance, loop) for k, assembly in enumerate(assemblies))
    for lane in stepped(lanes, len(assemblies), **processor):
        cases[lane.number] = lane.case()
        if progress is not None:
            progress(len(cases), len(assemblies))
    return [cases[k] for k in range(len(assemblies))]


class EnsembleLane(Lane):
    """A simulation of an ensemble in a lane."""

    def __init__(self, number: int, assembly: Assembly, tolerance: float | None, loop: str) -> None:
        super().__init__(number, assembly, loop=loop)
        self.tolerance, self.status = tolerance, Status.COMPLETE
        self.settled: int | None = None
        self.summaries: list[Array] = []
        self.distances: list[float] = []
        self.rows = np.zeros((0, len(self.handed)))
        layout = assembly.layout
        self.extreme, self.repeated = (
            np.isin(self.handed, rows) for rows in (layout.of("extreme"), compared_rows(layout))
        )

    @property
    def finished(self) -> bool:
        """Whether the simulation needs no further turn."""
        turns = self.assembly.choice.outputs // self.per
        return self.settled is not None or self.status != Status.COMPLETE or len(self.distances) == turns

    def start(self, state: Array) -> None:
        """Receive the output of step 0."""
        self.rows = state[None, self.handed]
        self.summaries.append(self.rows[0])

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Receive a turn; outputs after numbers left their bounds become NaN."""
        rows = np.concatenate([rows, np.full((self.per - len(rows), rows.shape[1]), np.nan)])
        bad = self.bounds.unsound(rows).any(axis=1)
        if broken >= 0:
            done = len(self.distances) * len(rows)
            bad |= (done + 1 + np.arange(len(rows))) * self.every >= broken - 1
        if bad.any():
            self.status = Status.DIVERGED
            rows = rows.copy()
            rows[int(np.argmax(bad)) :] = np.nan
        previous_rows, self.rows = self.rows, np.concatenate([self.rows[-1:], rows])
        self.summaries.append(np.where(self.extreme, rows.max(axis=0), rows[-1]))
        complete = len(previous_rows) == len(self.rows) and self.status == Status.COMPLETE
        change = distance(previous_rows[1:, self.repeated], rows[:, self.repeated]) if complete else np.inf
        self.distances.append(change)
        if self.tolerance is not None and change <= self.tolerance:
            self.settled = len(self.distances)

    def case(self) -> EnsembleCase:
        """Return the result of the simulation."""
        end, step = len(self.distances) * self.per, self.every
        ends = np.arange(0, end + 1, self.per, dtype=np.int64)
        last = np.arange(end - self.per, end + 1, dtype=np.int64)
        turns = Record(self.assembly, ends * step, np.array(self.summaries), self.handed, status=self.status)
        return EnsembleCase(
            turns,
            Record(self.assembly, last * step, self.rows, self.handed, status=self.status),
            np.array(self.distances),
            self.settled,
            self.status,
        )


Look = Callable[[Record], Mapping[str, float]]

CHUNK = 720  # outputs that a lane receives at a time
# Steps of the variants as multiples of the finest one. Two sizes may agree by chance on the error of an
# onset; four did not in 100 mechanisms.
MULTIPLES = (1.0, 1.4, 1.7, 2.0)
# Fewest steps between two outputs with which that number is changed for another step; with fewer, the number
# of outputs is changed.
FINE_OUTPUTS = 10


@dataclass(frozen=True)
class StepSize:
    """A step of a run as the number of steps between two outputs and the number of outputs; ``topology``
    has the corrections that it needs.
    """

    interval: int
    outputs: int
    base: Topology
    topology: Topology

    @property
    def steps(self) -> int:
        """Steps of the whole run."""
        return self.interval * self.outputs

    def of(self, assembly: Assembly) -> Assembly:
        """Return a variant of the base assembly with this step: what ``assemble`` makes with it, to the
        bit.
        """
        choice, state = assembly.choice, assembly.state.copy()
        step = choice.step * (choice.steps / self.steps)
        is_base = assembly.topology is self.base or assembly.topology == self.base
        topology = self.topology if is_base else assembly.topology.corrected(self.topology.coarse)
        state[assembly.layout.row("step")] = step
        # A copy, not ``replace``, which would make the bodies of a batch assembly: they are made on demand.
        variant = copy(assembly)
        changed = dataclasses.replace(choice, step=step, outputs_every=self.interval, outputs=self.outputs)
        for name, value in (("state", state), ("choice", changed), ("topology", topology)):
            object.__setattr__(variant, name, value)
        return variant


def step_sizes(assembly: Assembly) -> list[StepSize]:
    """Return the steps by which the error of a run is estimated; the first one is its own.

    They are 1, 1.4, 1.7 and 2 times the finest. That is the step of the run, or half of it where twice the
    step would not be stable.
    """
    choice = assembly.choice
    coarsest = max(MULTIPLES)
    finest = 1.0 if coarsest * choice.step <= SAFETY * choice.stable * (1.0 + 1e-9) else 1.0 / coarsest
    run_size = StepSize(choice.outputs_every, choice.outputs, assembly.topology, assembly.topology)
    sizes = {run_size.steps: run_size}
    for multiple in MULTIPLES:
        size = _step_size(assembly, multiple * finest)
        sizes.setdefault(size.steps, size)
    return list(sizes.values())


def _step_size(assembly: Assembly, multiple: float) -> StepSize:
    """Return the step that is nearest to a multiple of the assembly's own and divides the run and, if
    possible, a turn.
    """
    choice = assembly.choice
    interval, outputs = choice.outputs_every, choice.outputs
    if multiple < 1.0 or interval >= FINE_OUTPUTS:
        interval = max(1, round(interval / multiple))
    else:
        per = choice.turn / (choice.step * interval) if choice.turn else float(outputs)
        turns = outputs / per
        integer = abs(turns - round(turns)) < 1e-6 and round(turns) > 0
        outputs = (
            round(turns) * max(1, round(per / multiple)) if integer else max(1, round(outputs / multiple))
        )
    step = choice.step * (choice.steps / (interval * outputs))
    topology = assembly.topology
    if assembly.ideals:
        corrections = coarse(
            assembly.mechanism, dataclasses.replace(choice, step=step), assembly.layout, assembly.state
        )
        topology = topology.corrected(corrections)
    return StepSize(interval, outputs, assembly.topology, topology)


def measures_of(
    variants: Sequence[tuple[Assembly, NDArray[np.uint32], Look]],
    *,
    merged: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> list[Mapping[str, float] | None]:
    """Return the measures of each variant; None for one whose numbers left all bounds.

    A variant is an assembly, the rows of its state that its measures need, and the function that takes
    measures from its record. The record has the outputs of the last turn and the one before them; if
    ``merged``, as few as possible, which suffices for measures of extremes and of totals.
    ``progress(done, total)`` is called after each run. Ctrl-C ends it within a second.
    """
    columns: dict[int, Columns] = {}
    lanes = [VariantLane(k, *variant, columns, merged) for k, variant in enumerate(variants)]
    for done, lane in enumerate(stepped(lanes, len(lanes)) if lanes else (), 1):
        lane.parts.clear()
        if progress is not None:
            progress(done, len(lanes))
    return [lane.values for lane in lanes]


def merged_outputs(assembly: Assembly) -> int:
    """Return how many outputs may be one, so that the last turn begins and ends with an output; all of
    them where there are no turns.
    """
    choice = assembly.choice
    if not choice.turn:
        return choice.outputs
    turn = outputs_per_turn(choice)
    return 1 if turn is None else math.gcd(turn, choice.outputs)


class VariantLane(Lane):
    """A variant of a model in a lane."""

    values: Mapping[str, float] | None = None

    def __init__(
        self,
        number: int,
        assembly: Assembly,
        handed: NDArray[np.uint32],
        look: Look,
        columns: dict[int, Columns],
        merge: bool,
    ) -> None:
        super().__init__(number, assembly, handed)
        self.look, self.columns = look, columns
        self.first = 0  # number of the first output that is kept
        merged = merged_outputs(assembly) if merge else 1
        choice = assembly.choice
        self.every, self.count = merged * choice.outputs_every, choice.outputs // merged
        turn = choice.turn / (choice.step * self.every) if choice.turn else float(self.count)
        self.oldest = max(0, int(np.floor(self.count - turn - 0.5)))

    @property
    def outputs(self) -> int:
        """Number of outputs up to the next call of :meth:`take`."""
        return min(CHUNK, self.count - self.done)

    @property
    def finished(self) -> bool:
        """Whether the variant needs no further step."""
        return self.doubtful or self.done >= self.count

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Receive outputs, and drop those before the last turn."""
        self.doubtful = broken >= 0 or not np.isfinite(rows).all()
        self.parts.append(rows)
        self.done += len(rows)
        while len(self.parts) > 1 and self.first + len(self.parts[0]) <= self.oldest:
            self.first += len(self.parts.pop(0))

    def end(self) -> None:
        """Compute the measures from the outputs that were kept."""
        if self.doubtful:
            return
        rows = np.concatenate(self.parts)
        steps = (self.first + np.arange(len(rows), dtype=np.int64)) * self.every
        columns = self.columns.setdefault(id(self.handed), Columns(self.assembly.layout, self.handed))
        alike = columns if columns.layout is self.assembly.layout else None
        self.values = self.look(Record(self.assembly, steps, rows, self.handed, columns=alike))
