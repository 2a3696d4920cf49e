"""Simulates a mechanism: assembles it at its start, runs it beside its ideal reference, gives the result."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, Unpack

from ..assembly.assembled import Assembly
from ..assembly.possible import Outlook, outlook
from ..compiler.runtime.cache import sources as sources_of_the_step
from ..errors import Fault, ModelError
from ..job.cost import BRIEF, run_cost
from ..job.job import Job, job_of
from ..measures.energy import drifting, too_open
from ..measures.error_ranges import estimate, own_ranges, window
from ..measures.statics import mesh_estimate
from ..measures.trust import finer
from ..model.mechanism import Mechanism
from ..model.validation import validate
from ..modelfile import dump
from ..options import Run, Watch, with_options
from ..results.provenance import companions_meta, keep_reference, provenance, refuse_displaced
from ..results.restart import extended, on_clock, refuse_finished
from ..solvers.arguments import Arguments, Loop, RunArguments
from ..solvers.companions import companion_count, step_counts
from ..solvers.record import IN_MEMORY, Checkpoint, Record, recorded_rows
from ..solvers.refinement import other_meshes, refinable, refine, worth_other_meshes, worth_refining
from ..solvers.statics import equilibrium
from ..solvers.status import Progress, Status
from ..solvers.transient import choose_loop, run
from ..store.connections import located
from ..store.lock import Lock
from ..store.runfile import RunFile
from ..store.schemas import RUN
from .result import Result
from .start import (
    Length,
    RestoredStart,
    RunStart,
    StartFrom,
    StaticStart,
    expected_forces,
    ideal_of,
    referred,
)

Earlier: TypeAlias = dict[str, tuple[float, float]]
Tried: TypeAlias = tuple[tuple[float, float | None], ...]


@dataclass(frozen=True)
class Prepared:
    """A mechanism that can be run: examined, its ideal reference known if there is one, assembled."""

    assembly: Assembly
    reference: Result | None
    loop: Loop
    start: RunStart | StaticStart | RestoredStart  # assembles it with another step
    companions: int = 0
    refined: bool = (
        False  # whether it is repeated with smaller steps, being smooth, or on other meshes, being static
    )
    inputs: Mapping[str, Any] = field(
        default_factory=dict
    )  # what it takes to prepare it again, beside the model
    earlier: Earlier = field(
        default_factory=dict
    )  # ranges of the try before, where it is taken up in a later one
    searches: bool = True  # whether an automatic step may still be halved

    @property
    def static(self) -> bool:
        """Whether it is brought to equilibrium instead of being stepped."""
        return self.assembly.mechanism.settings.analysis == "static"

    @property
    def run_meta(self) -> dict[str, Any]:
        """The meta of its run file."""
        return self.meta(self.assembly)

    def meta(
        self, assembly: Assembly, model: str | None = None, earlier: Earlier | None = None
    ) -> dict[str, Any]:
        """The same of a run with another step; ``model`` is the text of the mechanism where it is written
        already.
        """
        meta = provenance(assembly, recorded_rows(assembly), choose_loop(assembly, self.loop), model)
        arguments = {**self.inputs, "refined": self.refined}
        return (
            meta
            | companions_meta(assembly, step_counts(assembly.choice, self.companions), earlier or {})
            | {"asked": arguments}
        )


class SimulationOptions(Run, Watch, total=False):
    """Keywords of :func:`simulate`."""

    outputs: int | None  # per turn, or per run without a crank
    start: StartFrom | None  # a former run or its folder, or states of bodies by name
    reference: bool | Result  # also run the ideal mechanism to compare with, or take its result
    file: RunFile | None  # takes the outputs while they come, which are not kept in memory then


@with_options(SimulationOptions, loop="auto", force_step=False, confirm=False, reference=True)
def simulate(mechanism: Mechanism, **options: Unpack[SimulationOptions]) -> Result:
    """Simulate a mechanism.

    >>> result = simulate(mechanism, turns=10, step="1 us")  # doctest: +SKIP

    What to run: ``turns`` of the crank or ``duration`` (s); ``step`` (s) or "auto", numbers or texts with a
    unit; ``settle`` (1) ends the run as soon as its turns repeat within that share of their largest values,
    and after ``turns`` at the latest. ``start``: a former run (or its folder) to go on from, or states of
    bodies by name (:func:`~vfife.results.restart.start_from`). ``reference``: also run the ideal mechanism to
    compare with, or its result; there is none without play or a driver, where a joint is none without its
    play, nor where the ideal mechanism does not get through. ``companions``: how often a run with contact is
    repeated with other step sizes, 0 to 7, from which ranges of measures estimate their errors; "auto" is
    three. An automatic step is halved, twice at the most, until run and companions agree within the tolerance
    of the settings, and where first contacts land deeper than a joint allows. A mechanism whose settings ask
    for a static analysis is brought to equilibrium (:func:`~vfife.solvers.statics.equilibrium`), which takes
    neither ``turns``, ``duration`` nor ``step``.

    What to save: ``outputs`` per turn (per run without a crank); a run ``file`` that takes them while they
    come.

    What to compute with: ``loop`` "auto", "data-driven", "generated" or "interpreted", which give the same
    bits; ``force_step`` takes a step beyond the stable one; ``progress`` is called with a
    :class:`~vfife.solvers.status.Progress`; ``confirm`` runs even what takes more than an hour, or half of
    the memory or of the disk.

    Raises ModelError with all faults of the arguments, or of the mechanism, AssemblyError for one that cannot
    be assembled and StepError for too large a step.
    """
    reading = Arguments("simulate")
    reading.mechanism(mechanism)
    reference, start, file, progress = (
        options["reference"],
        options["start"],
        options["file"],
        options["progress"],
    )
    arguments = reading.run(**{name: options.get(name) for name in (*Run.__annotations__, "outputs")})
    reading.kind("reference", reference, (bool, Result), "True, False or a Result")
    reading.kind(
        "start",
        start,
        (Result, str, Path, Mapping, type(None)),
        "a Result, the folder of a run, or states of bodies by name",
    )
    reading.kind("file", file, (RunFile, type(None)), "a RunFile")
    reading.callable("progress", progress)
    reading.kind("confirm", options["confirm"], (bool,), "True or False")
    reading.check()
    with job_of("simulate", None if file is None else file.path, options["confirm"], progress) as job:
        return run_prepared(prepare(mechanism, arguments, reference, start, job), progress=job, file=file)


def forecast(
    job: Job,
    assembly: Assembly,
    reference: Assembly | None = None,
    refined: bool = False,
    companions: int = 0,
) -> None:
    """Begin the job of a run, which ends here where it takes hours, or half of the memory or of the disk, and
    nobody confirmed that.

    Outputs that do not fit into memory are kept in a temporary file. ``reference`` runs beside the run;
    ``refined``: a smooth or static run, which is repeated with smaller steps or other meshes.
    """
    static = assembly.mechanism.settings.analysis == "static"
    less = "ask for less: " + (
        "load_factors, elements or iterations" if static else "turns, duration, outputs"
    )
    cost = run_cost(assembly, reference, companions=companions, refined=refined, measured=True)
    needed = cost.forecast(assembly.choice.steps, less)
    if job.place is None and cost.bytes > IN_MEMORY:  # its rows go into a temporary file
        job.place, needed = Path(tempfile.gettempdir()), dataclasses.replace(needed, disk=float(cost.bytes))
    job.begin(needed)


def prepare(
    mechanism: Mechanism,
    spec: RunArguments,
    reference: bool | Result = True,
    start: StartFrom | None = None,
    job: Job | None = None,
) -> Prepared:
    """Everything that comes before the first step, where most of what can be wrong is told: see
    :func:`simulate`.

    ``reference`` True runs the ideal mechanism, unless :func:`~.start.comparable` says that there is none to
    compare with, or the outlook that it does not get through. ``job`` compares a forecast with the machine:
    of the ideal reference before it is run where that takes long, then of the run.
    """
    if spec.settle is not None:
        mechanism = dataclasses.replace(
            mechanism, settings=dataclasses.replace(mechanism.settings, settle=spec.settle)
        )
    validate(mechanism)
    if mechanism.settings.analysis == "static":
        return _prepare_static(mechanism, spec, start, job)
    former = Result.load(start) if isinstance(start, str | Path) else start
    if former is not None:
        mechanism = on_clock(mechanism, former)
    # what goes on from a former run, or from given states, is not followed beforehand: it counts as through
    prospect = outlook(mechanism, spec.turns, spec.duration) if former is None else Outlook()
    ideal = reference if isinstance(reference, Result) else None
    if reference is True and prospect.through:
        unrun = ideal_of(mechanism, spec.turns, spec.duration, former, prospect.motion)
        if job is not None and unrun is not None and run_cost(unrun).seconds > BRIEF:
            forecast(job, unrun)
        ideal = referred(unrun)
    length = Length(
        turns=spec.turns, duration=spec.duration, outputs=spec.outputs, force_step=spec.force_step
    )
    begin = RunStart(mechanism, length, former, prospect, expected_forces(ideal))
    requested = companions_of(mechanism, spec.companions)
    assembly = begin.first(spec.step, spec.loop, requested)
    companions = companion_count(assembly, choose_loop(assembly, spec.loop), requested)
    refined = repeated(assembly, requested, spec.loop)
    if job is not None:
        forecast(job, assembly, None if ideal is None else ideal.record.assembly, refined, companions)
    description = {**length, "started": former is not None, "sources": sources_of_the_step().decode()}
    return Prepared(assembly, ideal, spec.loop, begin, companions, refined, description)


def _prepare_static(
    mechanism: Mechanism, spec: RunArguments, start: StartFrom | None, job: Job | None
) -> Prepared:
    """Prepare a static analysis."""
    if start is not None:
        fault = Fault(
            "start",
            "a static analysis begins at the mechanism's own start, without loads",
            remedy="leave it out",
        )
        raise ModelError([fault], "simulate()")
    changed = {
        name: value for name in ("turns", "duration", "step") if (value := getattr(spec, name)) is not None
    }
    begin = StaticStart(
        dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, **changed))
    )
    assembly = begin.assemble()
    refined = repeated(assembly, companions_of(mechanism, spec.companions), spec.loop)
    if job is not None:
        forecast(job, assembly, None, refined)
    return Prepared(
        assembly, None, spec.loop, begin, refined=refined, inputs={"sources": sources_of_the_step().decode()}
    )


def companions_of(mechanism: Mechanism, companions: int | str | None) -> int | str:
    """The companions that are wanted, those of the settings unless others are."""
    return mechanism.settings.companions if companions is None else companions


def repeated(assembly: Assembly, companions: int | str, loop: Loop = "auto") -> bool:
    """Whether a run without companions is repeated for an estimate of its errors: a smooth one with smaller
    steps, a static one on other meshes.

    With "auto" companions only a short one is; with 0 none.
    """
    if not companions:
        return False
    if assembly.mechanism.settings.analysis == "static":
        return refinable(assembly.mechanism) and (companions != "auto" or worth_other_meshes(assembly))
    smooth = not assembly.mechanism.contacts and choose_loop(assembly, loop) == "generated"
    return smooth and (companions != "auto" or worth_refining(assembly))


def run_prepared(
    prepared: Prepared,
    *,
    progress: Callable[[Progress], None] | None = None,
    file: RunFile | None = None,
    resume: Checkpoint | None = None,
) -> Result:
    """Runs what was prepared. A run file that does not have it yet takes the model and the reference before
    the first step; one that was taken up (:func:`reopen_run`) goes on from its checkpoint, ``resume``.

    An automatic step is found by the run itself: it is halved while run and companions lie further apart than
    the tolerance of the settings, or first contacts land deeper than a joint allows, and what was tried is
    kept in the choice of the step.
    """
    assembly, loop = prepared.assembly, prepared.loop
    if file is not None and not file.knows("meta", "kept"):
        file.begin(prepared.run_meta)
    if file is not None and prepared.reference is not None and not file.has_reference:
        keep_reference(file, prepared.reference.record)
    if prepared.static:
        return Result(
            meshed(
                prepared,
                equilibrium(assembly, loop=loop, progress=progress, file=file, resume=resume),
                progress,
            )
        )
    judge = partial(drifting, assembly, recorded_rows(assembly))
    record = run(
        assembly,
        loop=loop,
        progress=progress,
        file=file,
        companions=prepared.companions,
        resume=resume,
        judge=judge,
    )
    record = looked_at(prepared, record)
    if record.companions is not None:
        record.companions.earlier = prepared.earlier
    while prepared.searches and (tried := finer(record)) is not None:
        ideal = None if prepared.reference is None else prepared.reference.measures
        earlier = (
            {name: (one.low, one.high) for name, one in own_ranges(record, ideal).items()}
            if record.companions
            else {}
        )
        assembly = halved(prepared, assembly, tried)
        if file is not None:
            file.begin(prepared.meta(assembly, file.meta["model"], earlier))
        judge = partial(drifting, assembly, recorded_rows(assembly))
        record = run(
            assembly, loop=loop, progress=progress, file=file, companions=prepared.companions, judge=judge
        )
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


def reopen_run(file: RunFile, until: float | None = None) -> tuple[Prepared, Checkpoint | None]:
    """What a run file holds, ready to go on, and the checkpoint to go on from; what was written after it is
    taken away.

    ``until``: the time (s) at which the run is to end, if not where it was to; its step stays what it is
    then. Raises ResumeError for a run that has nothing left to do, or whose outputs are damaged.
    """
    where, meta, former, last = str(file.path), file.meta, Result.of(file), file.latest()
    refuse_finished(former.record, until, where)
    refuse_displaced(meta, where)
    record, arguments = former.record, dict(meta.get("asked", {}))
    changed: dict[str, Any] = {"status": Status.RUNNING}
    if until is not None:
        record.assembly = extended(record, until, where)
        arguments |= {"turns": None, "duration": until, "searches": False}
        changed |= {
            "model": dump(record.assembly.mechanism),
            "choice": dataclasses.asdict(record.assembly.choice),
            "asked": arguments,
        }
    if last is None:
        file.begin(meta | changed)
    else:
        file.rewind(last)
        file.put(changed)
        other = (
            ""
            if arguments.get("sources") == sources_of_the_step().decode()
            else "; the step before was that of another version"
        )
        file.event(last.step, f"goes on from here{other}")
    return restore_prepared(former, arguments, meta.get("companions", {})), last


def restore_prepared(former: Result, arguments: dict[str, Any], stored: Mapping[str, Any]) -> Prepared:
    """What a file holds, as :func:`prepare` had it. Of companions rows may be gone that were needed before
    the checkpoint, and are not after it.
    """
    record, reference = former.record, former.reference
    length = Length(
        turns=arguments.get("turns"),
        duration=arguments.get("duration"),
        outputs=arguments.get("outputs"),
        force_step=bool(arguments.get("force_step")),
    )
    return Prepared(
        record.assembly, reference, record.loop,  # type: ignore[arg-type]
        RestoredStart(record, length, expected_forces(reference), bool(arguments.get("started"))),
        companions=len(stored.get("counts", ())),
        refined=bool(arguments.get("refined")), inputs=arguments,
        earlier={name: (float(low), float(high)) for name, (low, high) in stored.get("earlier", {}).items()},
        searches=bool(arguments.get("searches", True)),
    )  # fmt: skip


def resume(
    run: str | Path, *, until: float | str | None = None, progress: Callable[[Progress], None] | None = None
) -> Result:
    """Goes on with a run that was interrupted or killed, from its folder or file, as if nothing had happened:
    the result has the same bits.

    ``until`` (s, or a text with a unit): a later end, also of a run that is complete. Raises ResumeError
    where there is nothing to go on with, HeldError where another process writes into the folder, RunFileError
    and StorageError where the file cannot be read or written.
    """
    arguments = Arguments("resume")
    end = arguments.quantity("until", until, "s")
    arguments.callable("progress", progress)
    arguments.check()
    path = located(RUN, Path(run))
    with Lock(path.parent), RunFile.write(path) as file:
        prepared, last = reopen_run(file, end)
        result = run_prepared(prepared, progress=progress, file=file, resume=last)
        result.finish(file)
    return result


def looked_at(prepared: Prepared, record: Record) -> Record:
    """The record of a smooth run with an estimate of what its step leaves out, where one is made: Ctrl-C
    leaves it out.
    """
    if prepared.refined and record.status == Status.COMPLETE and len(record.steps) > 2:
        with suppress(KeyboardInterrupt):
            record.estimate = estimate(record, refine(record, window(record)))
    return record


def meshed(prepared: Prepared, record: Record, progress: Callable[[Progress], None] | None) -> Record:
    """The record of a static analysis with an estimate of what its mesh leaves out, where one is made: Ctrl-C
    leaves it out.
    """
    with suppress(KeyboardInterrupt):
        if prepared.refined:
            record.estimate = mesh_estimate(record, other_meshes(record, progress))
    return record


def halved(prepared: Prepared, assembly: Assembly, tried: Tried) -> Assembly:
    """The same with half the step, which stays an automatic one that knows what was tried before it."""
    again = prepared.start.assemble(0.5 * assembly.choice.step)
    culprit = (
        f"{prepared.assembly.choice.culprit.partition(', halved ')[0]}, halved {len(tried)}"
        f" time{'s' * (len(tried) > 1)}"
    )
    return dataclasses.replace(
        again, choice=dataclasses.replace(again.choice, automatic=True, culprit=culprit, tried=tried)
    )
