"""``vfife study``: cases of one model, run from a study file into one file, which is shown, drawn, exported
and added to; ``vfife optimise`` and ``vfife study allocate``: searches among cases.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import typer

from ...job.activity import ACTIVITY
from ...job.job import Interrupted
from ...report.searches import allocation, optimum
from ...report.study import document, tolerances
from ...report.study import indices as indices_document
from ...results.study import Study
from ...solvers.status import Status
from ...store.lock import Lock
from ...studies import study_work
from ...studies.engine import study_engine
from ...studies.engine.cluster import Resources
from ...studies.engine.study_engine import split_values
from ...studies.methods.sensitivity_indices import sensitivities
from ...studies.methods.tolerance import bounds_of, spreads
from ...studies.spec.limits import Bound
from ...studies.spec.study_file import StudyTables
from ...units import assignments, unit_fault
from ..arguments.studies import (
    AddOptions,
    AllocateOptions,
    ExportOptions,
    IndicesOptions,
    OptimiseOptions,
    PlotOptions,
    ResumeOptions,
    RunStudyOptions,
    ShowOptions,
    ToleranceOptions,
)
from ..job import CommandJob, study_job
from ..options import ResourceOptions, StudyRunOptions
from ..outputs import one_target, refuse_ending, refuse_existing
from ..terminal import DIVERGED, amount_of_bytes, command, end_interrupted, sentences, tell, writing
from ..values import take_laws, tell_cautions

UNMET = 3  # exit code where nothing keeps the limits


def optimise(options: OptimiseOptions) -> None:
    """Run ``vfife optimise``."""
    result = run_search(options, study_work.optimise)
    options.answer(optimum(result))
    if not result.best:
        count = f"none of {len(result.cases):,} cases keeps the limits"
        fail_unmet(f"{count}; widen the limits or the ranges of the parameters, or ask for more cases")


def allocate(options: AllocateOptions) -> None:
    """Run ``vfife study allocate``."""
    result = run_search(options, study_work.allocate)
    options.answer(allocation(result))
    if result.choice is None:
        count = f"none of {len(result.rejected):,} choices keeps the limit"
        fail_unmet(f"{count}; allow finer grades, or a higher limit")


def fail_unmet(sentence: str) -> None:
    """End where nothing keeps the limits."""
    tell("failed", sentence, "bold red")
    raise typer.Exit(UNMET)


def run_search(options: StudyRunOptions, search: Callable[..., Any]) -> Any:
    """Return the answer of a search; one that is interrupted ends with the code of the signal, and says how
    to go on.
    """
    with sentences(str(options.file)):
        take_laws(options.laws)
        job = study_job(options, "search")
        if (model := StudyTables.load(options.file).model) is not None:
            tell_cautions(model)
    keys = {name: getattr(options, name) for name in ("force", "workers", "cluster", "device")}
    try:
        with job.at_work(str(options.file)):
            return search(options.file, file=job.target, progress=job, **keys)
    except Interrupted as error:
        count = len(error.result.outcomes)
    next_command = " ".join([command(), *map(shlex.quote, sys.argv[1:])])
    end_interrupted(f": {count:,} cases are complete; the same command continues: {next_command}")


def run(options: RunStudyOptions) -> None:
    """Run ``vfife study run``."""
    file = options.file
    with sentences(str(file)):
        take_laws(options.laws)
        plan = StudyTables.load(file).plan()
        job = study_job(options)
        work = study_work.StudyWork(job.target, plan, resources_of(options), options.force)
    compute(options, job, work)


def resume(options: ResumeOptions) -> None:
    """Run ``vfife study resume``."""
    compute_added(options)


def add(options: AddOptions) -> None:
    """Run ``vfife study add``."""
    compute_added(options, options.values or (), options.point or (), options.count)


def compute_added(
    options: ResumeOptions | AddOptions,
    values: Sequence[str] = (),
    points: Sequence[str] = (),
    count: int | None = None,
) -> None:
    """Add cases to a study, and compute all that it lacks."""
    file = options.file
    with ExitStack() as locks:
        with sentences(str(file)):
            take_laws(options.laws)
            resources = resources_of(options)
            items = dict(pair for text in values for pair in split_values(text, "a value"))
            cases = [dict(split_values(text, "--point")) for text in points]
            # The file is locked before it is read: of two commands that add at once, one would lose what the
            # other adds.
            lock = locks.enter_context(study_work.study_lock(file)) if file.exists() else None
            work = study_work.StudyWork(
                file, study_engine.extended_plan(file, items, cases, count), resources
            )
        compute(options, study_job(options), work, lock)


def compute(
    options: RunStudyOptions | ResumeOptions | AddOptions,
    job: CommandJob,
    work: study_work.StudyWork,
    lock: Lock | None = None,
) -> None:
    """Compute what a study lacks; describe it, and end with the exit code of that."""
    tell_cautions(work.plan.base)
    with job.at_work(str(options.file)):
        result, complete = work.run(job, options.retry, lock)
    options.answer(document(result))
    if not complete:
        go_on = f"{command()} study resume {shlex.quote(str(job.target))}"
        end_interrupted(
            f": {len(result.outcomes):,} of {len(result.cases):,} cases are complete; continue with: {go_on}"
        )
    end(result)


def end(result: Study) -> None:
    """End with the exit code of cases that failed, and with the reason of the first."""
    bad = [
        reason for case, reason in result.failed if result.outcomes[case.number]["status"] != Status.COMPLETE
    ]
    if bad:
        advice = (
            f"; {command()} study resume --retry {shlex.quote(str(result.path))} repeats them"
            if result.path
            else ""
        )
        tell(
            "failed",
            f"{len(bad):,} of {len(result.cases):,} cases gave no measures; the first: {bad[0]}{advice}",
            "bold red",
        )
        raise typer.Exit(DIVERGED)


def resources_of(options: ResourceOptions) -> Resources:
    """Return the resources of these options. Raises ValueError, DeviceError."""
    return Resources(options.workers, None, options.cluster, options.device)


# -------------------------------------------------------------------------------- studies that were made

ENDINGS = (".csv", ".xlsx", ".nc", ".parquet")


def show(options: ShowOptions) -> None:
    """Run ``vfife study show``."""
    study = read(options.file)
    options.answer(document(study, options.cases, options.members))


def read(file: Path) -> Study:
    """Open a study in the present state of its file."""
    ACTIVITY(f"reading {file}")
    with sentences(str(file)):
        return Study.open(file)


def export(options: ExportOptions) -> None:
    """Run ``vfife study export``."""
    with sentences(str(options.file)):
        target = one_target(options.out, options.target)
    with sentences(str(target)):
        refuse_ending(target, ENDINGS)
        refuse_existing(target, options.force)
    study = read(options.file)
    with sentences(str(options.file)), writing(str(target), "The study and existing files are unchanged."):
        ACTIVITY(f"writing {target}")
        study.export(target, options.decimal)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)})")


def plot(options: PlotOptions) -> None:
    """Run ``vfife study plot``."""
    file = options.file
    study = read(file)
    target = options.folder if options.folder is not None else file.with_name(f"{file.stem}-figures")
    with sentences(str(file)), writing(str(target), "The study is unchanged."):
        from ...plots.study import save_figures

        target.mkdir(parents=True, exist_ok=True)
        ending = f".{options.kind.lower().removeprefix('.')}"
        ACTIVITY(f"drawing figures in {target}")
        paths = save_figures(
            study, target, options.figure or (), options.measure or (), ending, options.maximise or ()
        )
    for path in paths:
        typer.echo(path)


def tolerance(options: ToleranceOptions) -> None:
    """Run ``vfife study tolerance``."""
    study, confidence = read(options.file), options.confidence / 100.0
    with sentences(str(options.file)):
        take_laws(options.laws)
        rows = spreads(study, limits_of(study, options.limit or []), percents(options.quantiles), confidence)
    options.answer(tolerances(study, str(options.file), confidence, rows))


def indices(options: IndicesOptions) -> None:
    """Run ``vfife study indices``."""
    study = read(options.file)
    with sentences(str(options.file)):
        take_laws(options.laws)
        rows = sensitivities(study, options.measure or ())
    options.answer(indices_document(study, str(options.file), rows))


def limits_of(study: Study, texts: list[str]) -> tuple[Bound, ...]:
    """Limits of the command line, or else those of the study file. Raises ModelError, ValueError."""
    items = list(assignments("--limit", texts, 'C.force.max="2 kN"', "not MEASURE=VALUE"))
    for measure, text in items:
        if measure in study.measures:
            sizes = sorted(abs(value) for value in study.values(measure).tolist() if value == value)
            middle = sizes[len(sizes) // 2] if sizes else None
            origin = f"the median of {measure} in the study"
            if fault := unit_fault(f"--limit {measure}", text, study.measures[measure], middle, origin):
                raise ValueError(str(fault))
    return bounds_of(study, {measure: number_or_text(value) for measure, value in items})


def number_or_text(text: str) -> float | str:
    """Convert a bare number to a float in SI units, and keep any other text."""
    try:
        return float(text)
    except ValueError:
        return text


def percents(text: str) -> tuple[float, ...]:
    """Shares from percents. Raises ValueError."""
    try:
        shares = tuple(sorted({float(part) / 100.0 for part in text.split(",")}))
    except ValueError:
        shares = ()
    if not shares or not all(0.0 < share < 1.0 for share in shares):
        raise ValueError(
            f"--quantiles {text}: these are not percentages between 0 and 100; write them as in --quantiles"
            " 5,50,95"
        )
    return shares
