"""A run from start to result: validation, ideal reference, assembly, steps, refinement of the step,
run file.
"""

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
from ..files import path_of
from ..job.cost import BRIEF, run_cost
from ..job.job import Job, job_of
from ..job.progress import ProgressLine
from ..measures.energy import drifting, too_open
from ..measures.error_ranges import ranges_of_next_try, window
from ..measures.smooth_errors import estimate
from ..measures.statics import mesh_estimate
from ..measures.trust import finer
from ..model.mechanism import Mechanism
from ..model.validation import validate
from ..options import Run, Watch, with_options
from ..results.continuation import on_clock
from ..results.export import RESULT_FORMATS
from ..results.provenance import companions_meta, keep_reference, provenance
from ..solvers.arguments import Arguments, Loop, RunArguments
from ..solvers.companions import companion_count, step_counts
from ..solvers.record import IN_MEMORY, Checkpoint, Record, recorded_rows
from ..solvers.refinement import other_meshes, refinable, refine, worth_other_meshes, worth_refining
from ..solvers.statics import equilibrium
from ..solvers.status import Progress, Status
from ..solvers.transient import choose_loop, run
from ..store.lock import run_lock
from ..store.runfile import GATHER, RunFile
from ..store.schemas import is_run_file
from .result import Result
from .start import (
    RestoredStart,
    RunStart,
    Span,
    StartFrom,
    StaticStart,
    changed_clearances,
    expected_forces,
    former_errors,
    ideal_of,
    referred,
)

# What is computed after the last step.
COMPARING = "comparing turns and steps"
MEASURING = "taking measures and their ranges"
Earlier: TypeAlias = dict[str, tuple[float, float]]
Tried: TypeAlias = tuple[tuple[float, float | None], ...]


@dataclass(frozen=True)
class Prepared:
    """A run before its first step: assembly, result of the ideal reference, and what a retry with half the
    step needs.
    """

    assembly: Assembly
    reference: Result | None
    loop: Loop
    start: RunStart | StaticStart | RestoredStart  # assembles the mechanism with another step
    companions: int = 0
    # Whether the run is repeated for an error estimate: a smooth one with smaller steps, a static one on
    # other meshes.
    refined: bool = False
    # Arguments from which resume() restores this object, together with the model.
    inputs: Mapping[str, Any] = field(default_factory=dict)
    # Ranges of the previous try, if the run was interrupted in a later one.
    earlier: Earlier = field(default_factory=dict)
    tries: Earlier = field(default_factory=dict)  # of all previous tries
    searches: bool = True  # whether an automatic step may still be halved

    @property
    def static(self) -> bool:
        """Whether the run is a static analysis."""
        return self.assembly.mechanism.settings.analysis == "static"

    @property
    def run_meta(self) -> dict[str, Any]:
        """Metadata of the run file."""
        return self.meta(self.assembly)

    def meta(
        self,
        assembly: Assembly,
        model: str | None = None,
        earlier: Earlier | None = None,
        tries: Earlier | None = None,
    ) -> dict[str, Any]:
        """Return the metadata of a run file for an ``assembly`` with another step. ``model``: text of the
        mechanism, if already known; ``earlier``: ranges of the previous try, ``tries``: of all.
        """
        meta = provenance(assembly, recorded_rows(assembly), choose_loop(assembly, self.loop), model)
        arguments = {**self.inputs, "refined": self.refined}
        return (
            meta
            | companions_meta(
                assembly, step_counts(assembly.choice, self.companions), earlier or {}, tries or {}
            )
            | {"asked": arguments}
        )


class SimulationOptions(Run, Watch, total=False):
    """Keywords of :func:`simulate`."""

    outputs: int | None  # per turn, or per run without a crank
    start: StartFrom | None  # a former run or its folder, or states of bodies by name
    reference: bool | Result  # also run the ideal mechanism to compare with, or take its result
    file: str | Path | RunFile | None  # takes the outputs while they come: resume() goes on after a kill


@with_options(SimulationOptions, loop="auto", force_step=False, confirm=False, reference=True)
def simulate(mechanism: Mechanism, **options: Unpack[SimulationOptions]) -> Result:
    """Simulate a mechanism and return the result.

    >>> result = simulate(mechanism, turns=10, step="1 us")  # doctest: +SKIP

    What to run:

    mechanism: the mechanism; if its settings request a static analysis,
    :func:`~vfife.solvers.statics.equilibrium` is computed, which takes neither ``turns``, ``duration`` nor
    ``step``
    turns: of the crank, or
    duration: of the run (s, or a text with a unit); without both, as the settings of the mechanism, else two
    turns, without a crank the time of the drivers' tables, or one second
    step: time step (s, or a text with a unit), or "auto". An automatic step is halved, at most twice, while
    run and companions differ by more than the tolerance of the settings or first contacts are deeper than a
    joint allows
    settle: the run ends as soon as two turns agree within this share of their largest values, as in 0.01 or
    "1 %", at the latest after ``turns``
    start: a former run (or its folder) to continue from, or states of bodies by name,
    ``{"ball": (x, y, angle)}`` in m, m, rad, or with rates ``{"ball": ((x, y, angle), (vx, vy, rate))}`` in
    m/s, m/s, rad/s; joints and drivers place the others (:func:`~vfife.results.continuation.start_from`)
    reference: True to run the ideal mechanism for comparison, or its result. Its forces take part in
    the choice of an automatic step: without it step and numbers may differ, these within their ranges. There
    is none without clearance or driver, if a joint has no ideal counterpart, or if the ideal mechanism locks
    companions: number of repetitions of a run with contact with other step sizes, 0 to 7, from which the
    uncertainty of measures is estimated; "auto" is three

    What to save:

    outputs: number per turn; per run without a crank. With a ``step`` that does not divide a turn so, the run
    keeps the step and has the nearest number that fits, and a caution of the result names both and the next
    smaller step with the given outputs
    file: a new run file that takes the outputs during the run, which then does not keep them in memory. After
    a kill it has all but the last quarter of a second, and :func:`vfife.resume` continues it with the same
    bits; :func:`vfife.load_result` and ``vfife info`` read it

    What to compute with:

    loop: "auto", "data-driven", "generated" or "interpreted"; with the same step all give the same bits. By
        default only "generated" runs companions: the others have no ranges and another automatic step,
        unless ``companions`` is a number
    force_step: True accepts an unstable step
    progress: called with a :class:`~vfife.solvers.status.Progress`
    confirm: True allows runs of more than an hour, or of half the memory or disk

    Returns a :class:`~vfife.Result`; after Ctrl-C it has the outputs so far, its status "interrupted". Raises
    ModelError with all faults of the arguments or of the mechanism, AssemblyError for a mechanism that cannot
    be assembled and StepError for an unstable step.
    """
    checks = Arguments("simulate")
    checks.mechanism(mechanism)
    reference, start, file = options["reference"], options["start"], options["file"]
    progress = options["progress"]
    arguments = checks.run(**{name: options.get(name) for name in (*Run.__annotations__, "outputs")})
    checks.kind("reference", reference, (bool, Result), "True, False or a Result")
    checks.kind(
        "start",
        start,
        (Result, str, Path, Mapping, type(None)),
        "a Result, the folder of a run, or states of bodies by name",
    )
    checks.kind("file", file, (RunFile, str, Path, type(None)), "the path of a new run file")
    path = new_file(checks, file) if isinstance(file, str | Path) else None
    checks.callable("progress", progress)
    checks.kind("confirm", options["confirm"], (bool,), "True or False")
    checks.check()
    run_file = file if isinstance(file, RunFile) else None
    with job_of("simulate", run_file.path if run_file else path, options["confirm"], progress) as job:
        prepared = prepare(mechanism, arguments, reference, start, job)
        if path is None:
            result = run_prepared(prepared, progress=job, file=run_file)
        else:
            result = run_into(prepared, path, job)
        if result.record.status == Status.INTERRUPTED:
            job.interrupted()
        return result


def new_file(checks: Arguments, value: str | Path) -> Path:
    """Return the path of a new run file; add a fault for another format and for a file that is there."""
    path = path_of(value, "simulate")
    checks.folder("file", path)
    if path.suffix.lower() in RESULT_FORMATS:
        remedy = f"give it another ending, and write {path.suffix} with the export() of the result"
        checks.fault("file", "this is not the ending of a run file", str(value), "", remedy)
    elif path.exists():
        remedy = "name another one, or remove it"
        if is_run_file(path):
            resumed = f"go on with vfife.resume({str(value)!r})"
            remedy = f"{resumed}, or read it with vfife.load_result(); else {remedy}"
        checks.fault("file", "there is a file of this name", str(value), "a new file", remedy)
    return path


def run_into(prepared: Prepared, path: Path, job: Job) -> Result:
    """Run what :func:`prepare` returned into a new run file, and return the result. A run that fails before
    its first output leaves no file.
    """
    with run_lock(path), RunFile.create(path, prepared.run_meta, gather=GATHER) as file:
        try:
            result = run_prepared(prepared, progress=job, file=file)
            show_phase(job, result.record, MEASURING)
            result.finish(file)
        except BaseException:
            if not file.outputs_so_far:
                path.unlink(missing_ok=True)
            raise
    return result


def forecast(
    job: Job,
    assembly: Assembly,
    reference: Assembly | None = None,
    refined: bool = False,
    companions: int = 0,
) -> None:
    """Begin the job of a run; raises if the run takes hours, or half of the memory or disk, without
    confirmation.

    Outputs that exceed the memory limit go to a temporary file. ``reference``: assembly of the ideal
    mechanism; ``refined``: the run is repeated with smaller steps or other meshes; ``companions``: their
    number.
    """
    static = assembly.mechanism.settings.analysis == "static"
    advice = "ask for less: " + (
        "load_factors, elements or iterations" if static else "turns, duration, outputs"
    )
    cost = run_cost(assembly, reference, companions=companions, refined=refined, measured=True)
    needed = cost.forecast(assembly.choice.steps, advice)
    if job.place is None and cost.bytes > IN_MEMORY:  # its rows go into a temporary file
        job.place = Path(tempfile.gettempdir())
        needed = dataclasses.replace(needed, disk=float(cost.bytes), disk_growth=1.0)
    job.begin(needed)


def prepare(
    mechanism: Mechanism,
    spec: RunArguments,
    reference: bool | Result = True,
    start: StartFrom | None = None,
    job: Job | None = None,
) -> Prepared:
    """Return a run before its first step; arguments and errors as in :func:`simulate`.

    ``reference`` True runs the ideal mechanism, if it is :func:`~.start.comparable` and passes its whole
    range of motion; however short the run, for a whole turn at constant speed (:func:`~.start.ideal_of`).
    ``job`` receives forecasts: one of the ideal reference if that takes long, then one of the run.
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
    # The outlook follows the ideal mechanism from its own start; with another start it is assumed to pass.
    prospect = outlook(mechanism, spec.turns, spec.duration) if former is None else Outlook()
    # The reference comes before the assembly, because the automatic step follows from its largest forces. The
    # length of the run is not known yet: it is that of ``spec``, else of the settings (timestep.length_of).
    ideal = reference if isinstance(reference, Result) else None
    if reference is True and prospect.passes:
        unrun = ideal_of(mechanism, spec.turns, spec.duration, former, prospect.motion)
        if job is not None and unrun is not None and run_cost(unrun).seconds > BRIEF:
            forecast(job, unrun)
        ideal = referred(unrun)
    length = Span(turns=spec.turns, duration=spec.duration, outputs=spec.outputs, force_step=spec.force_step)
    begin = RunStart(mechanism, length, former, prospect, expected_forces(ideal))
    requested = companions_of(mechanism, spec.companions)
    assembly = begin.first(spec.step, spec.loop, requested)
    companions = companion_count(assembly, choose_loop(assembly, spec.loop), requested)
    refined = repeated(assembly, requested, spec.loop)
    if job is not None:
        forecast(job, assembly, None if ideal is None else ideal.record.assembly, refined, companions)
    description = {**length, "started": former is not None, "sources": sources_of_the_step().decode()}
    if isinstance(former, Result):
        description["former"] = former_errors(former, assembly)
        description["jumps"] = changed_clearances(former, mechanism)
    return Prepared(assembly, ideal, spec.loop, begin, companions, refined, description)


def _prepare_static(
    mechanism: Mechanism, spec: RunArguments, start: StartFrom | None, job: Job | None
) -> Prepared:
    """Return a static analysis before its first iteration."""
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
    """Return the number of companions requested: the argument, else that of the settings."""
    return mechanism.settings.companions if companions is None else companions


def repeated(assembly: Assembly, companions: int | str, loop: Loop = "auto") -> bool:
    """Return whether a run without companions is repeated for an error estimate: a smooth run with smaller
    steps, a static analysis on other meshes. With "auto" companions this holds for short runs only.
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
    """Run what :func:`prepare` returned, and return the result.

    A new ``file`` takes model and reference before the first step; one reopened by
    :func:`~.resumption.reopen_run` continues from the checkpoint ``resume``. An automatic step is halved, and
    the run repeated, while run and companions differ by more than the tolerance of the settings or first
    contacts are deeper than a joint allows; the choice of the step lists all tries.
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
            ),
            arguments={**prepared.inputs, "refined": prepared.refined},
        )
    # The judge stops a run whose energy balance opens, which costs less than running it to its end.
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
    show_phase(progress, record, COMPARING)
    record = looked_at(prepared, record)
    if record.companions is not None:
        record.companions.earlier, record.companions.tries = prepared.earlier, prepared.tries
    # Each try starts anew with half the step: a coarse run cannot be continued, because errors at its
    # contacts have changed the motion. The ranges of the try before go into the file first, so that a
    # killed run compares with the same numbers when it is resumed.
    while prepared.searches and (tried := finer(record)) is not None:
        ideal = None if prepared.reference is None else prepared.reference.measures
        earlier, tries = (
            ranges_of_next_try(record, ideal) if record.companions else (dict[str, Any](), dict[str, Any]())
        )
        assembly = halved(prepared, assembly, tried)
        if file is not None:
            file.begin(prepared.meta(assembly, file.meta["model"], earlier, tries))
        judge = partial(drifting, assembly, recorded_rows(assembly))
        record = run(
            assembly, loop=loop, progress=progress, file=file, companions=prepared.companions, judge=judge
        )
        show_phase(progress, record, COMPARING)
        record = looked_at(prepared, record)
        if record.companions is not None:
            record.companions.earlier, record.companions.tries = earlier, tries
    return concluded(record, prepared.reference, {**prepared.inputs, "refined": prepared.refined})


def show_phase(progress: Any, record: Record, text: str) -> None:
    """Show what is computed after the last step of a complete run, where progress has a line."""
    if isinstance(progress, Job | ProgressLine) and record.status == Status.COMPLETE:
        progress.phase(text)


def concluded(record: Record, reference: Result | None, arguments: Mapping[str, Any] | None = None) -> Result:
    """Return the result of a record; its status becomes ``ENERGY`` if the energy balance is open."""
    result = Result(record, reference, arguments)
    if record.status == Status.COMPLETE and too_open(record, result.ledger):
        record.status = Status.ENERGY
    return result


def looked_at(prepared: Prepared, record: Record) -> Record:
    """Return the record of a smooth run with an estimate of its step error if it is to be refined; Ctrl-C
    skips it.
    """
    if prepared.refined and record.status == Status.COMPLETE and len(record.steps) > 2:
        with suppress(KeyboardInterrupt):
            record.estimate = estimate(record, refine(record, window(record)))
    return record


def meshed(prepared: Prepared, record: Record, progress: Callable[[Progress], None] | None) -> Record:
    """Return the record of a static analysis with an estimate of its mesh error if it is to be refined;
    Ctrl-C skips it.
    """
    with suppress(KeyboardInterrupt):
        if prepared.refined:
            record.estimate = mesh_estimate(record, other_meshes(record, progress))
    return record


def halved(prepared: Prepared, assembly: Assembly, tried: Tried) -> Assembly:
    """Return the assembly with half the step, marked as automatic, with the tries so far."""
    assembly_of_half = prepared.start.assemble(0.5 * assembly.choice.step)
    culprit = (
        f"{prepared.assembly.choice.culprit.partition(', halved ')[0]}, halved {len(tried)}"
        f" time{'s' * (len(tried) > 1)}"
    )
    return dataclasses.replace(
        assembly_of_half,
        choice=dataclasses.replace(assembly_of_half.choice, automatic=True, culprit=culprit, tried=tried),
    )
