"""``vfife optimise`` and ``vfife study allocate``: searches, whose cases are kept in a study file."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from typing import Any

import typer

from ...job.job import Interrupted
from ..job import study_job
from ..options import StudyRunOptions
from ..terminal import command, end_interrupted, sentences, tell

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
