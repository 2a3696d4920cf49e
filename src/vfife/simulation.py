"""Simulates a mechanism: assembles it at its start, runs it beside its ideal reference, gives the result."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, TypedDict, Unpack

from .analysis.energy import drifting, too_open
from .analysis.meshes import mesh_estimate
from .analysis.ranges import estimate, finer, own_ranges, window
from .assembly.assemble import assemble
from .assembly.assembled import Assembly
from .assembly.possible import Outlook, outlook
from .assembly.timestep import CONTACT_STEPS, FIRST_CONTACT_STEPS
from .codegen.cache import sources as sources_of_the_step
from .errors import Fault, ModelError
from .job.cost import BRIEF, run_cost
from .job.job import Job, job_of
from .kinematics.initial import Motion
from .model.mechanism import Mechanism
from .model.validate import validate
from .modelfile import dump
from .result import Result
from .results.connections import located
from .results.lock import Lock
from .results.provenance import keep_reference, kept_companions, provenance, refuse_displaced
from .results.restart import (
    States,
    extended,
    initial_state,
    on_clock,
    refuse_ended,
    refuse_stateless,
    restart_record,
    restarted,
    same_layout,
    step_of,
)
from .results.runfile import RunFile
from .results.schemas import RUN
from .results.view import View
from .solvers.arguments import Arguments, Loop, RunArguments
from .solvers.companions import number, step_counts
from .solvers.record import Checkpoint, Record, recorded_rows
from .solvers.refinement import other_meshes, refinable, refine, worth_other_meshes, worth_refining
from .solvers.statics import equilibrium
from .solvers.status import Progress, Status
from .solvers.transient import choose_loop, run

Earlier: TypeAlias = dict[str, tuple[float, float]]
Tried: TypeAlias = tuple[tuple[float, float | None], ...]
StartFrom: TypeAlias = Result | str | Path | States


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
    companions: int = 0
    refined: bool = False  # whether it is repeated with smaller steps, being smooth, or on other meshes, being static
    asked: Mapping[str, Any] = field(default_factory=dict)  # what it takes to prepare it again, beside the model
    earlier: Earlier = field(default_factory=dict)  # ranges of the try before, where it is taken up in a later one
    searches: bool = True  # whether an automatic step may still be halved

    @property
    def static(self) -> bool:
        """Whether it is brought to equilibrium instead of being stepped."""
        return self.assembly.mechanism.settings.analysis == "static"

    @property
    def kept(self) -> dict[str, Any]:
        """The meta of its run file."""
        return self.meta(self.assembly)

    def meta(self, assembly: Assembly, model: str | None = None, earlier: Earlier | None = None) -> dict[str, Any]:
        """The same of a run with another step; ``model`` is the text of the mechanism where it is written already."""
        found = provenance(assembly, recorded_rows(assembly), choose_loop(assembly, self.loop), model)
        asked = {**self.asked, "refined": self.refined}
        return found | kept_companions(assembly, step_counts(assembly.choice, self.companions), earlier or {}) | {"asked": asked}


def expected_forces(reference: Result | None) -> Mapping[str, float]:
    """Largest forces of the ideal mechanism, by joint."""
    if reference is None:
        return {}
    return {name.removesuffix(".force.max"): value for name, value in reference.measures.items() if name.endswith(".force.max")}


def comparable(mechanism: Mechanism) -> bool:
    """Whether there is an ideal mechanism to compare with turn by turn: play, a driver, and joints that are still joints without their play."""
    if mechanism.settings.analysis == "static" or not mechanism.contacts or not any(driver.moves for driver in mechanism.drivers.values()):
        return False
    return len(mechanism.ideal().joints) == len(mechanism.joints)


def ideal_of(
    mechanism: Mechanism,
    turns: float | None = None,
    duration: float | None = None,
    start: Result | States | None = None,
    motion: Motion | None = None,
) -> Assembly | None:
    """The ideal mechanism, where a driver makes it comparable turn by turn: one turn at constant speed, else as long as the run, from its start.

    ``motion``: the start of the mechanism, solved before.
    """
    if not comparable(mechanism):
        return None
    if all(driver.steady_speed is not None for driver in mechanism.drivers.values() if driver.moves):
        turns, duration, start = 1.0, None, None
    ideal = mechanism.ideal()
    given = None if start is None else initial_state(start, ideal)
    return assemble(ideal, beside=mechanism, turns=turns, duration=duration, given=given, motion=motion)


def reference_of(
    mechanism: Mechanism, turns: float | None = None, duration: float | None = None, start: Result | States | None = None
) -> Result | None:
    """What the ideal mechanism does (:func:`ideal_of`). Raises KeyboardInterrupt where it is interrupted."""
    return referred(ideal_of(mechanism, turns, duration, start))


def referred(ideal: Assembly | None) -> Result | None:
    """The result of an ideal mechanism, if there is one. Raises KeyboardInterrupt where it is interrupted."""
    if ideal is None:
        return None
    record = run(ideal)
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
    companions: int | str | None = None,
    settle: float | str | None = None,
    progress: Callable[[Progress], None] | None = None,
    file: RunFile | None = None,
    start: StartFrom | None = None,
    confirm: bool = False,
) -> Result:
    """Simulates a mechanism.

    ``turns`` of the crank or ``duration`` (s); ``step`` (s) or "auto"; both as numbers or as texts with a unit, "1 us". ``outputs`` per turn
    (per run without a crank); ``loop`` "auto", "data-driven", "generated" or "interpreted", which give the same bits; ``reference``: also run
    the ideal mechanism to compare with, or its result. ``companions``: how often a run with contact is repeated with other step sizes, 0 to 7,
    from which ranges of measures estimate their errors; "auto" is three. ``settle`` (1): the run ends as soon as its turns repeat within that share
    of their largest values, and after ``turns`` at the latest. An automatic step is halved, twice at the most, until run and companions agree
    within the tolerance of the settings, and where first contacts land deeper than a joint allows. A mechanism whose settings ask for a static
    analysis is brought to equilibrium instead (:func:`~vfife.solvers.statics.equilibrium`), which takes neither ``turns``, ``duration`` nor
    ``step``. ``file``: a run file that takes the outputs while they come, which are not kept in memory then. ``start``: a former run (or its
    folder) to go on from, or states of bodies by name (:func:`~vfife.results.start_from.start_from`). ``confirm``: run
    even what takes more than an hour, or half of the memory or of the disk. Raises ModelError with all faults of the
    arguments, or of the mechanism, AssemblyError for one that cannot be assembled and StepError for too large a step.
    """
    given = Arguments("simulate")
    given.mechanism(mechanism)
    asked = given.run(turns=turns, duration=duration, step=step, outputs=outputs, loop=loop, force_step=force_step, companions=companions,
                      settle=settle)  # fmt: skip
    given.kind("reference", reference, (bool, Result), "True, False or a Result")
    given.kind("start", start, (Result, str, Path, Mapping, type(None)), "a Result, the folder of a run, or states of bodies by name")
    given.kind("file", file, (RunFile, type(None)), "a RunFile")
    given.callable("progress", progress)
    given.kind("confirm", confirm, (bool,), "True or False")
    given.check()
    with job_of("simulate", None if file is None else file.path, confirm, progress) as job:
        return carry_out(prepare(mechanism, asked, reference, start, job), progress=job, file=file)


def forecast(job: Job, assembly: Assembly, reference: Assembly | None = None, refined: bool = False, companions: int = 0) -> None:
    """Begin the job of a run, which ends here where it takes hours, or half of the memory or of the disk, and nobody confirmed that.

    ``reference`` runs beside it; ``refined``: a smooth or static run, which is repeated with smaller steps or other meshes.
    """
    static = assembly.mechanism.settings.analysis == "static"
    less = "ask for less: " + ("load_factors, elements or iterations" if static else "turns, duration, outputs")
    cost = run_cost(assembly, reference, companions=companions, refined=refined, measured=True)
    job.begin(cost.forecast(assembly.choice.steps, less))


def prepare(
    mechanism: Mechanism,
    asked: RunArguments,
    reference: bool | Result = True,
    start: StartFrom | None = None,
    job: Job | None = None,
) -> Prepared:
    """Everything that comes before the first step, where most of what can be wrong is told: see :func:`simulate`.

    ``job`` compares a forecast with the machine: of the ideal reference before it is run where that takes long, then of the run.
    """
    if asked.settle is not None:
        mechanism = dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, settle=asked.settle))
    validate(mechanism)
    if mechanism.settings.analysis == "static":
        if start is not None:
            fault = Fault("start", "a static analysis begins at the mechanism's own start, without loads", remedy="leave it out")
            raise ModelError([fault], "simulate()")
        given = {name: value for name in ("turns", "duration", "step") if (value := getattr(asked, name)) is not None}
        still = dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, **given))
        assembly, wanted = assemble(still), companions_of(mechanism, asked.companions)
        finer, about = repeated(assembly, wanted, asked.loop), {"sources": sources_of_the_step().decode()}
        if job is not None:
            forecast(job, assembly, None, finer)
        return Prepared(assembly, None, asked.loop, lambda _: assemble(still), refined=finer, asked=about)
    former = Result.load(start) if isinstance(start, str | Path) else start
    if former is not None:
        mechanism = on_clock(mechanism, former)
    seen = outlook(mechanism, asked.turns, asked.duration) if start is None else Outlook()
    ideal = reference if isinstance(reference, Result) else None
    if reference is True and seen.through:
        alone = ideal_of(mechanism, asked.turns, asked.duration, former, seen.motion)
        if job is not None and alone is not None and run_cost(alone).seconds > BRIEF:
            forecast(job, alone)
        ideal = referred(alone)
    length = Length(turns=asked.turns, duration=asked.duration, outputs=asked.outputs, force_step=asked.force_step)

    wanted = companions_of(mechanism, asked.companions)

    def again(step: float | str | None, contact_steps: int = CONTACT_STEPS) -> Assembly:
        found = assembled_at(mechanism, step, former, expected=expected_forces(ideal), contact_steps=contact_steps, motion=seen.motion, **length)
        return dataclasses.replace(found, notes=(*found.notes, *seen.notes))

    begin = first_contact_steps(mechanism, wanted, asked.loop)
    assembly = again(asked.step, begin)
    before = step_of(former.record, assembly) if isinstance(former, View) and asked.step is None else None
    if before is not None:
        assembly = taken_over(again(before))
    companions = number(assembly, choose_loop(assembly, asked.loop), wanted)
    if before is None and begin != CONTACT_STEPS and not companions and assembly.choice.automatic:
        assembly = again(asked.step)  # a large frame: nobody looks whether a coarse step will do
    finer = repeated(assembly, wanted, asked.loop)
    if job is not None:
        forecast(job, assembly, None if ideal is None else ideal.record.assembly, finer, companions)
    kept = {**length, "started": former is not None, "sources": sources_of_the_step().decode()}
    return Prepared(assembly, ideal, asked.loop, again, companions, finer, kept)


def companions_of(mechanism: Mechanism, wanted: int | str | None) -> int | str:
    """The companions that are wanted, those of the settings unless others are."""
    return mechanism.settings.companions if wanted is None else wanted


def repeated(assembly: Assembly, wanted: int | str, loop: Loop = "auto") -> bool:
    """Whether a run without companions is repeated for an estimate of its errors: a smooth one with smaller steps, a static one on other meshes.

    With "auto" companions only a short one is; with 0 none.
    """
    if not wanted:
        return False
    if assembly.mechanism.settings.analysis == "static":
        return refinable(assembly.mechanism) and (wanted != "auto" or worth_other_meshes(assembly))
    smooth = not assembly.mechanism.contacts and choose_loop(assembly, loop) == "generated"
    return smooth and (wanted != "auto" or worth_refining(assembly))


def first_contact_steps(mechanism: Mechanism, companions: int | str, loop: Loop = "auto") -> int:
    """Steps in half a period of the stiffest contact with which an automatic step begins: fewer where companions look whether they will do."""
    looked = mechanism.contacts and companions and (companions != "auto" or loop in ("auto", "generated"))
    return FIRST_CONTACT_STEPS if looked else CONTACT_STEPS


def carry_out(
    prepared: Prepared,
    *,
    progress: Callable[[Progress], None] | None = None,
    file: RunFile | None = None,
    resume: Checkpoint | None = None,
) -> Result:
    """Runs what was prepared. A run file that does not have it yet takes the model and the reference before the first step; one that was taken up
    (:func:`taken_up`) goes on from its checkpoint, ``resume``.

    An automatic step is found by the run itself: it is halved while run and companions lie further apart than the tolerance of the settings, or
    first contacts land deeper than a joint allows, and what was tried is kept in the choice of the step.
    """
    assembly, loop = prepared.assembly, prepared.loop
    if file is not None and not file.knows("meta", "kept"):
        file.begin(prepared.kept)
    if file is not None and prepared.reference is not None and not file.has_reference:
        keep_reference(file, prepared.reference.record)
    if prepared.static:
        return Result(meshed(prepared, equilibrium(assembly, loop=loop, progress=progress, file=file, resume=resume), progress))
    judge = partial(drifting, assembly, recorded_rows(assembly))
    record = run(assembly, loop=loop, progress=progress, file=file, companions=prepared.companions, resume=resume, judge=judge)
    record = looked_at(prepared, record)
    if record.companions is not None:
        record.companions.earlier = prepared.earlier
    while prepared.searches and (tried := finer(record)) is not None:
        ideal = None if prepared.reference is None else prepared.reference.measures
        earlier = {name: (one.low, one.high) for name, one in own_ranges(record, ideal).items()} if record.companions else {}
        assembly = halved(prepared, assembly, tried)
        if file is not None:
            file.begin(prepared.meta(assembly, file.meta["model"], earlier))
        judge = partial(drifting, assembly, recorded_rows(assembly))
        record = run(assembly, loop=loop, progress=progress, file=file, companions=prepared.companions, judge=judge)
        record = looked_at(prepared, record)
        if record.companions is not None:
            record.companions.earlier = earlier
    return concluded(record, prepared.reference)


def concluded(record: Record, reference: Result | None) -> Result:
    """The result of a run, in which energy is accounted for, or its status says that it is not."""
    result = Result(record, reference)
    if record.status == Status.COMPLETE and too_open(record, result.ledger):
        record.status = Status.ENERGY
    return result


def taken_up(file: RunFile, until: float | None = None) -> tuple[Prepared, Checkpoint | None]:
    """What a run file holds, ready to go on, and the checkpoint to go on from; what was written after it is taken away.

    ``until``: the time (s) at which the run is to end, if not where it was to; its step stays what it is then. Raises ResumeError for a run that
    has nothing left to do, or whose outputs are damaged.
    """
    where, meta, former, last = str(file.path), file.meta, Result.of(file), file.latest()
    refuse_ended(former.record, until, where)
    refuse_displaced(meta, where)
    record, asked = former.record, dict(meta.get("asked", {}))
    changed: dict[str, Any] = {"status": Status.RUNNING}
    if until is not None:
        record.assembly = extended(record, until, where)
        asked |= {"turns": None, "duration": until, "searches": False}
        changed |= {"model": dump(record.assembly.mechanism), "choice": dataclasses.asdict(record.assembly.choice), "asked": asked}
    if last is None:
        file.begin(meta | changed)
    else:
        file.rewind(last)
        file.put(changed)
        other = "" if asked.get("sources") == sources_of_the_step().decode() else "; the step before was that of another version"
        file.event(last.step, f"goes on from here{other}")
    return _prepared_again(former, asked, meta.get("companions", {})), last


def _prepared_again(former: Result, asked: dict[str, Any], beside: Mapping[str, Any]) -> Prepared:
    """What a file holds, as :func:`prepare` had it. Of companions rows may be gone that were needed before the checkpoint, and are not after it."""
    record = former.record
    mechanism, expected = record.assembly.mechanism, expected_forces(former.reference)
    length = Length(
        turns=asked.get("turns"), duration=asked.get("duration"), outputs=asked.get("outputs"), force_step=bool(asked.get("force_step"))
    )

    def again(step: float) -> Assembly:
        if record.static or not asked.get("started"):
            return assembled_at(mechanism, step, expected=expected, **length)
        given = initial_state(View(record), mechanism, 0.0)
        found = assemble(mechanism, step, given=given, expected=expected, **length)
        state = record.assembly.state.copy()  # positions alone do not make it: element and contact forces went on
        state[found.layout["step"]] = found.choice.step
        return dataclasses.replace(found, state=state, tables=record.assembly.tables)

    return Prepared(
        record.assembly, former.reference, record.loop, again,  # type: ignore[arg-type]
        companions=len(beside.get("counts", ())), refined=bool(asked.get("refined")), asked=asked,
        earlier={name: (float(low), float(high)) for name, (low, high) in beside.get("earlier", {}).items()},
        searches=bool(asked.get("searches", True)),
    )  # fmt: skip


def resume(run: str | Path, *, until: float | str | None = None, progress: Callable[[Progress], None] | None = None) -> Result:
    """Goes on with a run that was interrupted or killed, from its folder or file, as if nothing had happened: the result has the same bits.

    ``until`` (s, or a text with a unit): a later end, also of a run that is complete. Raises ResumeError where there is nothing to go on with,
    HeldError where another process writes into the folder, RunFileError and StorageError where the file cannot be read or written.
    """
    given = Arguments("resume")
    end = given.quantity("until", until, "s")
    given.callable("progress", progress)
    given.check()
    path = located(RUN, Path(run))
    with Lock(path.parent), RunFile.write(path) as file:
        prepared, last = taken_up(file, end)
        result = carry_out(prepared, progress=progress, file=file, resume=last)
        result.finish(file)
    return result


def taken_over(assembly: Assembly) -> Assembly:
    """The assembly with the step of the run that it goes on from, which may still be halved."""
    choice = dataclasses.replace(assembly.choice, automatic=True, culprit="the run that it goes on from")
    return dataclasses.replace(assembly, choice=choice)


def looked_at(prepared: Prepared, record: Record) -> Record:
    """The record of a smooth run with an estimate of what its step leaves out, where one is made: Ctrl-C leaves it out."""
    if prepared.refined and record.status == Status.COMPLETE and len(record.steps) > 2:
        with suppress(KeyboardInterrupt):
            record.estimate = estimate(record, refine(record, window(record)))
    return record


def meshed(prepared: Prepared, record: Record, progress: Callable[[Progress], None] | None) -> Record:
    """The record of a static analysis with an estimate of what its mesh leaves out, where one is made: Ctrl-C leaves it out."""
    with suppress(KeyboardInterrupt):
        if prepared.refined:
            record.estimate = mesh_estimate(record, other_meshes(record, progress))
    return record


def halved(prepared: Prepared, assembly: Assembly, tried: Tried) -> Assembly:
    """The same with half the step, which stays an automatic one that knows what was tried before it."""
    again = prepared.again(0.5 * assembly.choice.step)
    culprit = f"{prepared.assembly.choice.culprit.partition(', halved ')[0]}, halved {len(tried)} time{'s' * (len(tried) > 1)}"
    return dataclasses.replace(again, choice=dataclasses.replace(again.choice, automatic=True, culprit=culprit, tried=tried))


def assembled_at(
    mechanism: Mechanism,
    step: float | str | None = None,
    start: Result | States | None = None,
    time: float | None = None,
    *,
    expected: Mapping[str, float] | None = None,
    contact_steps: int = CONTACT_STEPS,
    motion: Motion | None = None,
    **length: Unpack[Length],
) -> Assembly:
    """The assembled mechanism at its own start, or where a former run was at ``time`` (s; its end unless given), or at states given by name.

    ``motion``: its own start, solved before.

    A run that ended and is cut alike goes on with its whole state, element and contact forces with it.
    """
    if start is None:
        return assemble(mechanism, step, expected=expected, contact_steps=contact_steps, motion=motion, **length)
    mechanism = on_clock(mechanism, start, time)
    given = initial_state(start, mechanism, time)
    assembly = assemble(mechanism, step, given=given, expected=expected, contact_steps=contact_steps, **length)
    record = restart_record(start, time)
    if isinstance(start, View) and time is None:
        refuse_stateless(start.record, start.name, same_layout(assembly, start.record))
    return restarted(assembly, record) if record is not None and same_layout(assembly, record) else assembly
