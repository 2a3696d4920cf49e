"""``vfife study``: cases of one model, run from a study file into one file, which is shown, drawn, exported
and added to; ``vfife optimise`` and ``vfife study allocate``: searches among cases.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import typer

from ...job.job import Interrupted
from ...solvers.status import Status
from ..job import CommandJob, study_job
from ..options import (
    CaseOptions,
    JobOptions,
    LawOptions,
    RetryOptions,
    StudyFileOptions,
    StudyRunOptions,
    argument,
    option,
)
from ..registry import DefaultGroup, add_command
from ..terminal import DIVERGED, command, end_interrupted, sentences, tell
from .study_info import export, indices, plot, show, tolerance

if TYPE_CHECKING:
    from ...results.study import Study
    from ...store.lock import Lock
    from ...studies.study_work import StudyWork


UNMET = 3  # exit code where nothing keeps the limits


def optimise(options: StudyRunOptions) -> None:
    """Find the parameters with which measures are least, or largest, within limits: what the table optimise
    of a study file asks for.

    A forecast of time and bytes comes first. One measure has a best case, from which derivatives of the run
    lead on, several have a Pareto front. Cases are kept in one study file as they end, so the same command
    goes on after a kill, and `vfife study show` and `plot` read it. Exit codes as of `vfife study`; 3 where
    no case keeps the limits.
    """
    from ...report.study import optimum
    from ...studies.study_work import optimise as search

    result = run_search(options, search)
    options.answer(optimum(result))
    if not result.best:
        count = f"none of {len(result.cases):,} cases keeps the limits"
        fail_unmet(f"{count}; widen them, or what is varied, or ask for more cases")


def allocate(options: StudyRunOptions) -> None:
    """Find the cheapest fits with which nearly all machines keep a limit: what the tables allocation and cost
    of a study file ask for.

    A forecast of time and bytes comes first. Choices of fits are tried from the cheapest on, each until more
    machines are beyond the limit than may be. Cases are kept in one study file, so the same command goes on
    after a kill. Exit codes as of `vfife study`; 3 where no choice keeps the limit.
    """
    from ...report.study import allocation
    from ...studies.study_work import allocate as search

    result = run_search(options, search)
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
        options.take_laws()
        job = study_job(options, "search")
    keys = {name: getattr(options, name) for name in ("force", "workers", "cluster", "device")}
    try:
        with job.at_work(str(options.file)):
            return search(options.file, file=job.target, progress=job, **keys)
    except Interrupted as error:
        count = len(error.result.outcomes)
    again = " ".join([command(), *map(shlex.quote, sys.argv[1:])])
    end_interrupted(f": {count:,} cases have ended; the same command goes on: {again}")


class StudyGroup(DefaultGroup):
    """The commands of a study. What is no command is a study file, which is run."""

    default = "run"


study = typer.Typer(
    cls=StudyGroup,
    no_args_is_help=True,
    help=(
        "Run a model for many values of its parameters: vfife study STUDY.toml. Results go into one"
        " file, which can be read while it grows; an interrupted study continues with the same command."
    ),
)


class RunStudyOptions(StudyRunOptions, RetryOptions):
    """Options of ``vfife study run``."""


def run(options: RunStudyOptions) -> None:
    """Run a study; `run` itself may be left out.

    A forecast of time and bytes comes first. Cases that the file has already are not computed again, so the
    same command goes on after a kill, and computes what was added to STUDY.toml. A case that fails is kept
    with its reason, and tried again with --retry alone. Exit codes: 2 for input that cannot be used, 3 where
    a case failed, 5 where something could not be written, 130, 143 and 129 after Ctrl-C, SIGTERM and
    SIGHUP.
    """
    file = options.file
    with sentences(str(file)):
        from ...studies.spec.study_file import StudyTables
        from ...studies.study_work import StudyWork

        options.take_laws()
        plan = StudyTables.load(file).plan()
        job = study_job(options)
        work = StudyWork(job.target, plan, options.resources(), options.force)
    compute(options, job, work)


class ResumeOptions(StudyFileOptions, CaseOptions, LawOptions, RetryOptions):
    """Options of ``vfife study resume``."""


def resume(options: ResumeOptions) -> None:
    """Go on with a study that was interrupted or killed, from its file alone. Cases that failed are tried
    again with --retry.
    """
    compute_added(options)


class AddOptions(StudyFileOptions, CaseOptions, LawOptions, RetryOptions, JobOptions):
    """Options of ``vfife study add``."""

    values: list[str] | None = argument(
        'Values to add, as in clearance="0.3 mm, 0.4 mm"; they are combined with all others.',
        "NAME=VALUE,VALUE",
        None,
        show_default=True,
    )
    point: list[str] | None = option(
        None, "One case, a value for each parameter; may be repeated.", "NAME=VALUE,NAME=VALUE", "--point"
    )
    count: int | None = option(None, "So many samples in all.", "N", min=1)


def add(options: AddOptions) -> None:
    """Add cases to a study and compute those alone: values of a parameter, single points, or samples."""
    compute_added(options, options.values or (), options.point or (), options.count)


def compute_added(
    options: ResumeOptions | AddOptions,
    values: Sequence[str] = (),
    points: Sequence[str] = (),
    count: int | None = None,
) -> None:
    """Add cases to a study, and compute all that it lacks."""
    file = options.file
    with ExitStack() as held:
        with sentences(str(file)):
            from ...studies.engine.study_engine import extended_plan, split_values
            from ...studies.study_work import StudyWork, study_lock

            options.take_laws()
            resources = options.resources()
            items = dict(pair for text in values for pair in split_values(text, "a value"))
            cases = [dict(split_values(text, "--point")) for text in points]
            # The file is locked before it is read: of two commands that add at once, one would lose what the
            # other adds.
            lock = held.enter_context(study_lock(file)) if file.exists() else None
            work = StudyWork(file, extended_plan(file, items, cases, count), resources)
        compute(options, study_job(options), work, lock)


for function in (run, resume, add, show, plot, export, tolerance, indices, allocate):
    add_command(study, function)


def compute(
    options: RunStudyOptions | ResumeOptions | AddOptions,
    job: CommandJob,
    work: StudyWork,
    lock: Lock | None = None,
) -> None:
    """Compute what a study lacks; describe it, and end with the exit code of that."""
    with job.at_work(str(options.file)):
        result, complete = work.run(job, options.retry, lock)
    from ...report.study import document

    options.answer(document(result))
    if not complete:
        go_on = f"{command()} study resume {shlex.quote(str(job.target))}"
        end_interrupted(
            f": {len(result.outcomes):,} of {len(result.cases):,} cases have ended; go on with: {go_on}"
        )
    end(result)


def end(result: Study) -> None:
    """End with the exit code of cases that failed, and with the reason of the first."""
    bad = [
        reason for one, reason in result.failed if result.outcomes[one.number]["status"] != Status.COMPLETE
    ]
    if bad:
        again = (
            f"; {command()} study resume --retry {shlex.quote(str(result.path))} tries them again"
            if result.path
            else ""
        )
        tell(
            "failed",
            f"{len(bad):,} of {len(result.cases):,} cases gave no measures; the first: {bad[0]}{again}",
            "bold red",
        )
        raise typer.Exit(DIVERGED)
