"""``vfife study``: many cases of one model, run from a study file into one file, which is shown, drawn,
exported and added to.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import typer

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
from .optimise import allocate
from .study_info import export, indices, plot, show, tolerance

if TYPE_CHECKING:
    from ...results.study import Study
    from ...store.lock import Lock
    from ...studies.study_work import StudyWork


class StudyGroup(DefaultGroup):
    """The commands of a study. What is no command is a study file, which is run."""

    default = "run"


study = typer.Typer(
    cls=StudyGroup,
    no_args_is_help=True,
    help=(
        "Run a model once for every choice of some of its numbers: vfife study STUDY.toml. What the cases"
        " come to is kept in one file, which can be read while it grows; after a kill the same command"
        " goes on."
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
