"""Simulates a mechanism: assembles it at its start, runs it beside its ideal reference, gives the result."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, TypedDict, Unpack

import numpy as np

from .assembly.assemble import assemble
from .assembly.assembled import Assembly
from .errors import Fault, ModelError
from .model.mechanism import Mechanism
from .model.validate import validate
from .result import Result
from .results.provenance import keep_reference, provenance
from .results.restart import restart_record, restarted, same_layout
from .results.runfile import RunFile
from .results.start_from import States, initial_state
from .solvers.arguments import Arguments, Asked, Loop
from .solvers.progress import Progress
from .solvers.record import Record, recorded_rows
from .solvers.statics import equilibrium
from .solvers.status import Status
from .solvers.transient import choose_loop, run

StartFrom: TypeAlias = Result | str | Path | States
HALVINGS = 3  # of an automatic step, at the most


class Length(TypedDict, total=False):
    """How long a run is and how much of it is kept, as assemble takes it."""

    turns: float | None
    duration: float | None
    outputs: int | None
    force_step: bool


@dataclass(frozen=True)
class Prepared:
    """A mechanism that can be run: examined, its ideal reference known, assembled at its start."""

    assembly: Assembly
    reference: Result | None
    loop: Loop
    again: Callable[[float], Assembly]  # the same with another step (s)

    @property
    def static(self) -> bool:
        """Whether it is brought to equilibrium instead of being stepped."""
        return self.assembly.mechanism.settings.analysis == "static"

    @property
    def kept(self) -> dict[str, Any]:
        """The meta of its run file."""
        return provenance(self.assembly, recorded_rows(self.assembly), choose_loop(self.assembly, self.loop))


def expected_forces(reference: Result | None) -> Mapping[str, float]:
    """Largest forces of the ideal mechanism, by joint."""
    if reference is None:
        return {}
    return {name.removesuffix(".force.max"): value for name, value in reference.measures.items() if name.endswith(".force.max")}


def reference_of(mechanism: Mechanism, turns: float | None = None, duration: float | None = None) -> Result | None:
    """The ideal mechanism, where a driver makes it comparable turn by turn: one turn at constant speed, else as long as the run."""
    if mechanism.settings.analysis == "static":
        return None
    moving = [driver for driver in mechanism.drivers.values() if driver.moves]
    if not mechanism.contacts or not moving or len(mechanism.ideal().joints) < len(mechanism.joints):
        return None
    if all(driver.steady_speed is not None for driver in moving):
        turns, duration = 1.0, None
    record = run(assemble(mechanism.ideal(), beside=mechanism, turns=turns, duration=duration))
    if record.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    return Result(record)


def simulate(
    mechanism: Mechanism,
    *,
    turns: float | None = None,
    duration: float | str | None = None,
    step: float | str | None = None,
    outputs: int | None = None,
    loop: Loop = "auto",
    reference: bool | Result = True,
    force_step: bool = False,
    progress: Callable[[Progress], None] | None = None,
    file: RunFile | None = None,
    start: StartFrom | None = None,
) -> Result:
    """Simulates a mechanism.

    ``turns`` of the crank or ``duration`` (s); ``step`` (s) or "auto"; both as numbers or as texts with a unit, "1 us". ``outputs`` per turn
    (per run without a crank); ``loop`` "auto", "data-driven", "generated" or "interpreted", which give the same bits; ``reference``: also run
    the ideal mechanism to compare with, or its result. An automatic step is halved, three times at the most, while first contacts land deeper
    than a joint allows. A mechanism whose settings ask for a static analysis is brought to equilibrium instead
    (:func:`~vfife.solvers.statics.equilibrium`), which takes neither ``turns``, ``duration`` nor ``step``. ``file``: a run file that takes the
    outputs while they come, which are not kept in memory then. ``start``: a former run (or its folder) to go on from, or states of bodies by
    name (:func:`~vfife.results.start_from.start_from`). Raises ModelError with all faults of the arguments, or of the mechanism, AssemblyError
    for one that cannot be assembled and StepError for too large a step.
    """
    given = Arguments("simulate")
    given.mechanism(mechanism)
    asked = given.run(turns=turns, duration=duration, step=step, outputs=outputs, loop=loop, force_step=force_step)
    given.one_of("reference", reference, (bool, Result), "True, False or a Result")
    given.one_of("start", start, (Result, str, Path, Mapping, type(None)), "a Result, the folder of a run, or states of bodies by name")
    given.one_of("file", file, (RunFile, type(None)), "a RunFile")
    given.callable("progress", progress)
    given.tell()
    return carry_out(prepare(mechanism, asked, reference, start), progress=progress, file=file)


def prepare(mechanism: Mechanism, asked: Asked, reference: bool | Result = True, start: StartFrom | None = None) -> Prepared:
    """Everything that comes before the first step, where most of what can be wrong is told: see :func:`simulate`."""
    validate(mechanism)
    if mechanism.settings.analysis == "static":
        if start is not None:
            fault = Fault("start", "a static analysis begins at the mechanism's own start, without loads", remedy="leave it out")
            raise ModelError([fault], "simulate()")
        given = {name: value for name in ("turns", "duration", "step") if (value := getattr(asked, name)) is not None}
        still = dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, **given))
        return Prepared(assemble(still), None, asked.loop, lambda _: assemble(still))
    ideal = reference if isinstance(reference, Result) else reference_of(mechanism, asked.turns, asked.duration) if reference else None
    former = Result.load(start) if isinstance(start, str | Path) else start
    length = Length(turns=asked.turns, duration=asked.duration, outputs=asked.outputs, force_step=asked.force_step)

    def again(step: float | str | None) -> Assembly:
        return assembled_at(mechanism, step, former, expected=expected_forces(ideal), **length)

    return Prepared(again(asked.step), ideal, asked.loop, again)


def carry_out(prepared: Prepared, *, progress: Callable[[Progress], None] | None = None, file: RunFile | None = None) -> Result:
    """Runs what was prepared. A run file that does not have it yet takes the model and the reference before the first step."""
    assembly, loop = prepared.assembly, prepared.loop
    if file is not None and not file.knows("kept"):
        file.begin(prepared.kept)
    if file is not None and prepared.reference is not None and not file.has_reference:
        keep_reference(file, prepared.reference.record)
    if prepared.static:
        return Result(equilibrium(assembly, loop=loop, progress=progress, file=file))
    record = run(assembly, loop=loop, progress=progress, file=file)
    tries = HALVINGS if assembly.choice.automatic else 0
    while tries and record.status == Status.COMPLETE and _too_deep(record):
        tries -= 1
        assembly = prepared.again(0.5 * assembly.choice.step)
        if file is not None:
            file.begin(provenance(assembly, recorded_rows(assembly), choose_loop(assembly, loop), file.meta["model"]))
        record = run(assembly, loop=loop, progress=progress, file=file)
    return Result(record, prepared.reference)


def assembled_at(
    mechanism: Mechanism,
    step: float | str | None = None,
    start: Result | States | None = None,
    time: float | None = None,
    *,
    expected: Mapping[str, float] | None = None,
    **length: Unpack[Length],
) -> Assembly:
    """The assembled mechanism at its own start, or where a former run was at ``time`` (s; its end unless given), or at states given by name.

    A run that ended and is cut alike goes on with its whole state, element and contact forces with it.
    """
    if start is None:
        return assemble(mechanism, step, expected=expected, **length)
    assembly = assemble(mechanism, step, given=initial_state(start, mechanism, time), expected=expected, **length)
    record = restart_record(start, time)
    return restarted(assembly, record) if record is not None and same_layout(assembly, record) else assembly


def _too_deep(record: Record) -> bool:
    """Whether a first contact landed deeper than its joint allows."""
    return record.final is not None and bool(np.any(record.final[record.assembly.layout["contact_deep"]]))
