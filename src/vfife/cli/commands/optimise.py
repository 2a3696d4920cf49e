"""``vfife optimise`` and ``vfife study allocate``: members are asked for as a search needs them, and kept in
a study file.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from ...job.job import Interrupted
from ...solvers.status import Status
from ..options import (
    ClusterOption,
    Device,
    Force,
    JsonOption,
    LawsOption,
    Quiet,
    StudyArgument,
    StudyCommand,
    Target,
    Workers,
    Yes,
    take_laws,
)
from ..signals import NOW
from ..terminal import answer, command, sentences, tell

UNMET = 3  # exit code where nothing keeps the limits


def optimise(
    file: StudyArgument,
    output_: Target = None,
    laws: LawsOption = None,
    force: Force = False,
    yes: Yes = False,
    workers: Workers = None,
    cluster: ClusterOption = None,
    device: Device = None,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Find the parameters with which measures are least, or largest, within limits: what the table optimise
    of a study file asks for.

    A forecast of time and bytes comes first. One measure has a best member, from which derivatives of the run
    lead on, several have a Pareto front. Members are kept in one study file as they end, so the same command
    goes on after a kill, and `vfife study show` and `plot` read it. Exit codes as of `vfife study`; 3 where
    no member keeps the limits.
    """
    with sentences(str(file)):
        from ...studies.engine.cluster import Resources
        from ...studies.forecast import search_forecast
        from ...studies.methods.local_search import optimise as run_search
        from ...studies.methods.optimise import read_search
        from ...studies.spec.study_file import StudyTables
        from ...studies.study import StudyWork

        take_laws(laws)
        resources = Resources(workers, None, cluster, device)
        plan, search = read_search(StudyTables.load(file))
        job = StudyCommand(file, output_, yes, quiet, "search")
        target = job.target
        work = StudyWork(target, plan, resources, force)
    with searching(job):
        forecast = search_forecast(plan, search, work.known)
        (found, more), _ = work.search(job, forecast, lambda engine: run_search(engine, plan, search))
    from ...studies.methods.optimise import pareto_front
    from ...studies.spec.study_file import units_of

    front, units = pareto_front(search, found), units_of(plan)
    feasible = sum(one.feasible for one in found)
    if as_json or not quiet:
        from ...report.study import optimum

        counts = {
            "file": str(target),
            "members": len(found),
            "feasible": feasible,
            "refined": len(more.candidates),
            "why": more.reason,
        }
        answer(optimum(search, plan.parameters, front, units, counts), as_json)
    if not front:
        tell(
            "failed",
            f"none of {len(found):,} members keeps the limits; widen them, or what is varied, or ask for more"
            " members",
            "bold red",
        )
        raise typer.Exit(UNMET)


def allocate(
    file: StudyArgument,
    output_: Target = None,
    laws: LawsOption = None,
    force: Force = False,
    yes: Yes = False,
    workers: Workers = None,
    cluster: ClusterOption = None,
    device: Device = None,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Find the cheapest fits with which nearly all machines keep a limit: what the tables allocation and cost
    of a study file ask for.

    A forecast of time and bytes comes first. Choices of fits are tried from the cheapest on, each until more
    machines are beyond the limit than may be. Members are kept in one study file, so the same command goes on
    after a kill. Exit codes as of `vfife study`; 3 where no choice keeps the limit.
    """
    with sentences(str(file)):
        from ...studies.engine.cluster import Resources
        from ...studies.forecast import allotment_forecast
        from ...studies.methods.allocation import allocate_fits, read_allotment
        from ...studies.spec.study_file import StudyTables, units_of
        from ...studies.study import StudyWork

        take_laws(laws)
        resources = Resources(workers, None, cluster, device)
        plan, task = read_allotment(StudyTables.load(file))
        job = StudyCommand(file, output_, yes, quiet, "search")
        target = job.target
        work = StudyWork(target, plan, resources, force)
    with searching(job):
        found, _ = work.search(
            job, allotment_forecast(plan, task, work.known), lambda engine: allocate_fits(engine, task)
        )
    if as_json or not quiet:
        from ...report.study import allocation

        answer(allocation(task, found, str(target), units_of(plan)[task.bound.measure]), as_json)
    if found.choice is None:
        tell(
            "failed",
            f"none of {len(found.rejected):,} choices keeps the limit; allow finer grades, or a higher limit",
            "bold red",
        )
        raise typer.Exit(UNMET)


@contextmanager
def searching(job: StudyCommand) -> Iterator[None]:
    """While a search goes on; one that is interrupted ends with the code of the signal, and says how to go
    on.
    """

    with job.at_work(str(job.target), job.kept):
        try:
            yield
            return
        except Interrupted as error:
            ended = len(error.result.outcomes)
    tell(Status.INTERRUPTED, f"{NOW.by}: {ended:,} members have ended; the same command goes on: {again()}")
    raise typer.Exit(NOW.code)


def again() -> str:
    """The command as it was given."""
    import sys

    return " ".join([command(), *map(shlex.quote, sys.argv[1:])])
