"""``vfife optimise`` and ``vfife study allocate``: searches, whose cases are kept in a study file."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from ...job.job import Interrupted
from ..job import StudyCommand
from ..options import StudyRunOptions
from ..terminal import answer, command, end_interrupted, sentences, tell

if TYPE_CHECKING:
    from ...studies.spec.study_file import StudyTables

UNMET = 3  # exit code where nothing keeps the limits


class SearchOptions(StudyRunOptions):
    """Options of a search."""

    def tables(self) -> StudyTables:
        """The tables of the study file."""
        from ...studies.spec.study_file import StudyTables

        return StudyTables.load(self.file)


def optimise(options: SearchOptions) -> None:
    """Find the parameters with which measures are least, or largest, within limits: what the table optimise
    of a study file asks for.

    A forecast of time and bytes comes first. One measure has a best case, from which derivatives of the run
    lead on, several have a Pareto front. Cases are kept in one study file as they end, so the same command
    goes on after a kill, and `vfife study show` and `plot` read it. Exit codes as of `vfife study`; 3 where
    no case keeps the limits.
    """
    with sentences(str(options.file)):
        from ...studies.forecast import search_forecast
        from ...studies.methods.local_search import optimise as run_search
        from ...studies.methods.optimise import read_search
        from ...studies.study_work import StudyWork

        options.take_laws()
        plan, search = read_search(options.tables())
        job = StudyCommand(options, options.yes, "search")
        work = StudyWork(job.target, plan, options.resources(), options.force)
    with searching(job):
        forecast = search_forecast(plan, search, work.finished_file)
        (cases, refined), _ = work.search(job, forecast, lambda engine: run_search(engine, plan, search))
    from ...studies.methods.optimise import pareto_front
    from ...studies.spec.study_file import units_of

    front, units = pareto_front(search, cases), units_of(plan)
    if options.as_json or not options.quiet:
        from ...report.study import optimum

        counts = {
            "file": str(job.target),
            "cases": len(cases),
            "members": len(cases),  # the key of version 0.2
            "feasible": sum(one.feasible for one in cases),
            "refined": len(refined.candidates),
            "why": refined.reason,
        }
        answer(optimum(search, plan.parameters, front, units, counts), options.as_json)
    if not front:
        fail_unmet(
            f"none of {len(cases):,} cases keeps the limits; widen them, or what is varied, or ask for"
            " more cases"
        )


def allocate(options: SearchOptions) -> None:
    """Find the cheapest fits with which nearly all machines keep a limit: what the tables allocation and cost
    of a study file ask for.

    A forecast of time and bytes comes first. Choices of fits are tried from the cheapest on, each until more
    machines are beyond the limit than may be. Cases are kept in one study file, so the same command goes on
    after a kill. Exit codes as of `vfife study`; 3 where no choice keeps the limit.
    """
    with sentences(str(options.file)):
        from ...studies.forecast import allotment_forecast
        from ...studies.methods.allocation import allocate_fits, read_allotment
        from ...studies.spec.study_file import units_of
        from ...studies.study_work import StudyWork

        options.take_laws()
        plan, task = read_allotment(options.tables())
        job = StudyCommand(options, options.yes, "search")
        work = StudyWork(job.target, plan, options.resources(), options.force)
    with searching(job):
        result, _ = work.search(
            job,
            allotment_forecast(plan, task, work.finished_file),
            lambda engine: allocate_fits(engine, task),
        )
    if options.as_json or not options.quiet:
        from ...report.study import allocation

        answer(allocation(task, result, str(job.target), units_of(plan)[task.bound.measure]), options.as_json)
    if result.choice is None:
        fail_unmet(
            f"none of {len(result.rejected):,} choices keeps the limit; allow finer grades, or a higher limit"
        )


def fail_unmet(sentence: str) -> None:
    """End where nothing keeps the limits."""
    tell("failed", sentence, "bold red")
    raise typer.Exit(UNMET)


@contextmanager
def searching(job: StudyCommand) -> Iterator[None]:
    """While a search goes on; one that is interrupted ends with the code of the signal, and says how to go
    on.
    """
    with job.at_work(str(job.target), job.saved_before):
        try:
            yield
            return
        except Interrupted as error:
            count = len(error.result.outcomes)
    again = " ".join([command(), *map(shlex.quote, sys.argv[1:])])
    end_interrupted(f": {count:,} cases have ended; the same command goes on: {again}")
