"""``vfife optimise`` and ``vfife study allocate``: members are asked for as a search needs them, and kept in a study file."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import typer

from ..solvers.status import Status
from .membered import Device, Force, Quiet, StudyArgument, StudyCommand, Target, Workers, Yes
from .options import ClusterOption, JsonOption, LawsOption, take_laws
from .signals import NOW
from .terminal import command, grid, output, print_json, row, sentences, tell

if TYPE_CHECKING:
    from ..study.allocation import Allocated
    from ..study.searches import Allotment

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
    """Find the parameters with which measures are least, or largest, within limits: what the table optimise of a study file asks for.

    A forecast of time and bytes comes first. One measure has a best member, from which derivatives of the run lead on, several have a Pareto front.
    Members are kept in one study file as they end, so the same command goes on after a kill, and `vfife study show` and `plot` read it. Exit codes
    as of `vfife study`; 3 where no member keeps the limits.
    """
    from ..report.study import quantity

    with sentences(str(file)):
        from ..study.cluster import Resources
        from ..study.forecast import search_forecast
        from ..study.searches import load_search, optimised
        from ..study.studies import StudyWork

        take_laws(laws)
        resources = Resources(workers, None, cluster, device)
        plan, base, search = load_search(file)
        job = StudyCommand(file, output_, yes, quiet, "search")
        target = job.target
        work = StudyWork(target, plan, base, file.stem, resources, force)
    with searching(job):
        forecast = search_forecast(plan, base, search, work.known)
        (found, more), _ = work.search(job, forecast, lambda engine: optimised(engine, plan, search))
    from ..study.optimise import best
    from ..study.run_missing import units_of

    front, units = best(search, found), units_of(plan.asked.measures, base)
    feasible = sum(one.feasible for one in found)
    if as_json:
        rows = [{"member": one.number, "parameters": one.parameters, "measures": dict(one.values or {})} for one in front]
        aims = {"minimised": list(search.minimised), "maximised": list(search.maximised)}
        counts = {"members": len(found), "feasible": feasible, "refined": len(more.members), "why": more.why}
        print_json({"file": str(target), **counts, **aims, "best": rows})
    elif not quiet and front:
        names = [one.name for one in plan.parameters]
        table = grid(*names, *units, right=tuple(range(len(names) + len(units))))
        for one in front:
            cells = [quantity(one.parameters[axis.name], axis.unit) for axis in plan.parameters]
            row(table, *cells, *(quantity((one.values or {}).get(name), unit) for name, unit in units.items()))
        one_way = "the least of" if search.minimised else "the most of"
        sought = [*search.minimised, *(f"{name} (large)" if len(search.aims) > 1 else name for name in search.maximised)]
        what = one_way if len(search.aims) == 1 else "the Pareto front of"
        last = f", the last {len(more.members):,} by derivatives" if more.members else ""
        output().print(f"{len(found):,} members{last}, {feasible:,} within the limits; {what} {', '.join(sought)}:")
        output().print(table)
    if more.why and not quiet:
        tell("note", f"derivatives lead no further: {more.why}.")
    if not front:
        tell("failed", f"none of {len(found):,} members keeps the limits; widen them, or what is varied, or ask for more members", "bold red")
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
    """Find the cheapest fits with which nearly all machines keep a limit: what the tables allocation and cost of a study file ask for.

    A forecast of time and bytes comes first. Choices of fits are tried from the cheapest on, each until more machines are beyond the limit than may
    be. Members are kept in one study file, so the same command goes on after a kill. Exit codes as of `vfife study`; 3 where no choice keeps the
    limit.
    """
    with sentences(str(file)):
        from ..study.cluster import Resources
        from ..study.forecast import allotment_forecast
        from ..study.run_missing import units_of
        from ..study.searches import allotted, load_allotment
        from ..study.studies import StudyWork

        take_laws(laws)
        resources = Resources(workers, None, cluster, device)
        plan, base, task = load_allotment(file)
        job = StudyCommand(file, output_, yes, quiet, "search")
        target = job.target
        work = StudyWork(target, plan, base, file.stem, resources, force)
    with searching(job):
        found, _ = work.search(job, allotment_forecast(plan, base, task, work.known), lambda engine: allotted(engine, task))
    if as_json:
        print_json({"file": str(target), **allocated(task, found)})
    elif not quiet and found.choice is not None:
        print_allocated(task, found, units_of(plan.asked.measures, base)[task.bound.measure])
    if found.choice is None:
        tell("failed", f"none of {len(found.rejected):,} choices keeps the limit; allow finer grades, or a higher limit", "bold red")
        raise typer.Exit(UNMET)


def allocated(task: Allotment, found: Allocated) -> dict[str, Any]:
    """What ``--json`` prints of an allocation."""
    asked = task.asked
    return {
        "fits": None if found.choice is None else task.chosen(found.choice),
        "cost": None if found.choice is None else found.choice.cost,
        "measure": asked.measure,
        "limit": task.bound.high,
        "share": asked.share,
        "confidence": asked.confidence,
        "quantile": None if found.estimate is None else found.estimate.value,
        "failures": found.failures,
        "machines": found.count,
        "rejected": [{"fits": task.chosen(one), "cost": one.cost} for one in found.rejected],
    }


def print_allocated(task: Allotment, found: Allocated, unit: str) -> None:
    """The chosen fits for people."""
    from ..report.study import quantity

    if found.choice is None or found.estimate is None:
        return
    table, asked = grid("fit of", "fit", "cost", "clearance", right=(2,)), task.asked
    for one, option, own in zip(task.parameters, found.choice.options, task.fits, strict=True):
        if own:
            low, high = option.clearance.limits
            row(table, one.name, option.name, f"{option.cost:g}", f"{quantity(low, 'm')} to {quantity(high, 'm')}")
    console = output()
    console.print(table)
    console.print(f"cost {found.choice.cost:g}; {len(found.rejected):,} choices as cheap or cheaper do not keep the limit")
    console.print(
        f"{100.0 * asked.share:g} % quantile of {asked.measure}: {quantity(found.estimate.value, unit)}, limit {quantity(task.bound.high, unit)}; "
        f"{found.failures} of {found.count:,} machines are beyond it ({100.0 * asked.confidence:g} % confidence)"
    )


@contextmanager
def searching(job: StudyCommand) -> Iterator[None]:
    """While a search goes on; one that is interrupted ends with the code of the signal, and says how to go on."""
    from ..job.job import Interrupted

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
