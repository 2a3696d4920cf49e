"""``vfife study``: many members of one model, run from a study file into one file, which is shown, drawn,
exported and added to.
"""

from __future__ import annotations

import shlex
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from ...solvers.status import Status
from ...store.schemas import STUDY
from ..options import (
    ClusterOption,
    Device,
    FileArgument,
    Force,
    JsonOption,
    LawsOption,
    Quiet,
    Retry,
    StudyArgument,
    StudyCommand,
    Target,
    Workers,
    Yes,
    take_laws,
)
from ..registry import Command, Plainly
from ..signals import NOW
from ..terminal import DIVERGED, answer, command, sentences, tell
from .optimise import allocate
from .study_info import export, indices, plot, show, tolerance

if TYPE_CHECKING:
    from ...results.studied import Study
    from ...store.lock import Lock
    from ...studies.study import StudyWork

RUN = "run"
Added = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="NAME=VALUE,VALUE",
        help='Values to add, as in play="0.3 mm, 0.4 mm"; they are combined with all others.',
    ),
]
Point = Annotated[
    list[str] | None,
    typer.Option(
        "--point",
        metavar="NAME=VALUE,NAME=VALUE",
        help="One member, a value for each parameter; may be repeated.",
    ),
]
Count = Annotated[int | None, typer.Option(metavar="N", min=1, help="So many samples in all.")]


class Group(Plainly, TyperGroup):
    """The commands of a study. What is no command is a study file, which is run."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Puts the command before a study file; a word that is no file's name is a command that there is not."""
        word = args[0] if args else "--help"
        if (
            word not in self.commands
            and word != "--help"
            and (word.startswith("-") or Path(word).suffix or Path(word).exists())
        ):
            args = [RUN, *args]
        return super().parse_args(ctx, args)


study = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    help=(
        "Run a model once for every choice of some of its numbers: vfife study STUDY.toml. What the members"
        " come to is kept in one file, which can be read while it grows; after a kill the same command"
        " goes on."
    ),
)


@study.command(RUN, cls=Command)
def run(
    file: StudyArgument,
    output: Target = None,
    laws: LawsOption = None,
    force: Force = False,
    yes: Yes = False,
    retry: Retry = False,
    workers: Workers = None,
    cluster: ClusterOption = None,
    device: Device = None,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Run a study; `run` itself may be left out.

    A forecast of time and bytes comes first. Members that the file has already are not computed again, so the
    same command goes on after a kill, and computes what was added to STUDY.toml. A member that fails is kept
    with its reason, and tried again with --retry alone. Exit codes: 2 for input that cannot be used, 3 where
    a member failed, 5 where something could not be written, 130, 143 and 129 after Ctrl-C, SIGTERM and
    SIGHUP.
    """
    with sentences(str(file)):
        from ...studies.engine.cluster import Resources
        from ...studies.spec.plan import SEARCH
        from ...studies.spec.study_file import StudyTables
        from ...studies.study import StudyWork

        take_laws(laws)
        if STUDY.owns(file):
            raise ValueError(
                f"{file}: this is what a study was kept in; see vfife study show, resume or add, or name its"
                " STUDY.toml"
            )
        plan = StudyTables.load(file).plan()
        if plan.spec.method == SEARCH:
            raise ValueError(
                f'the members of method = "{SEARCH}" are asked for by vfife optimise or vfife study allocate;'
                " give it to one of them"
            )
        resources = Resources(workers, None, cluster, device)
        job = StudyCommand(file, output, yes, quiet)
        work = StudyWork(job.target, plan, resources, force)
    computed(job, work, as_json, retry)


@study.command(cls=Command)
def resume(
    file: FileArgument,
    laws: LawsOption = None,
    retry: Retry = False,
    workers: Workers = None,
    cluster: ClusterOption = None,
    device: Device = None,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Go on with a study that was interrupted or killed, from its file alone. Members that failed are tried
    again with --retry.
    """
    add(file, None, None, None, laws, True, retry, workers, cluster, device, as_json, quiet)


@study.command(cls=Command)
def add(
    file: FileArgument,
    values: Added = None,
    point: Point = None,
    count: Count = None,
    laws: LawsOption = None,
    yes: Yes = False,
    retry: Retry = False,
    workers: Workers = None,
    cluster: ClusterOption = None,
    device: Device = None,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Add members to a study and compute those alone: values of a parameter, single points, or samples."""
    with ExitStack() as held:
        with sentences(str(file)):
            from ...studies.engine.cluster import Resources
            from ...studies.engine.run_missing import extended_plan, split_values
            from ...studies.study import StudyWork, study_lock

            take_laws(laws)
            resources = Resources(workers, None, cluster, device)
            items, points = (
                [split_values(text, "a value") for text in values or ()],
                [split_values(text, "--point") for text in point or ()],
            )
            lock = (
                held.enter_context(study_lock(file)) if file.exists() else None
            )  # two that add at once would lose what one of them asks for
            plan = extended_plan(
                file, dict(pair for item in items for pair in item), [dict(one) for one in points], count
            )
            work = StudyWork(file, plan, resources)
        computed(StudyCommand(file, file, yes, quiet), work, as_json, retry, lock)


study.command(cls=Command)(show)
study.command(cls=Command)(plot)
study.command(cls=Command)(export)
study.command(cls=Command)(tolerance)
study.command(cls=Command)(indices)
study.command(cls=Command)(allocate)


def computed(
    job: StudyCommand, work: StudyWork, as_json: bool, retry: bool, lock: Lock | None = None
) -> None:
    """Computes what is left; says what was kept, and ends with the exit code of that."""
    with job.at_work(str(job.target), job.kept):
        found, whole = work.run(job, retry, lock)
    if as_json or not job.quiet:
        from ...report.study import document

        answer(document(found), as_json)
    if not whole:
        go_on = f"{command()} study resume {shlex.quote(str(job.target))}"
        tell(
            Status.INTERRUPTED,
            f"{NOW.by}: {len(found.outcomes):,} of {len(found.members):,} members have ended; go on with:"
            f" {go_on}",
        )
        raise typer.Exit(NOW.code)
    ended(found)


def ended(found: Study) -> None:
    """The exit code of members that failed, which are told."""
    bad = [reason for one, reason in found.failed if found.outcomes[one.number]["status"] != Status.COMPLETE]
    if bad:
        again = (
            f"; {command()} study resume --retry {shlex.quote(str(found.path))} tries them again"
            if found.path
            else ""
        )
        tell(
            "failed",
            f"{len(bad):,} of {len(found.members):,} members gave no measures; the first: {bad[0]}{again}",
            "bold red",
        )
        raise typer.Exit(DIVERGED)
