"""``vfife optimise`` and ``vfife study allocate``: members are asked for as a search needs them, and kept in a study file."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import typer

from ..solvers.status import Status
from .membered import Device, Force, MemberLine, Quiet, StudyArgument, Target, Workers, Yes, refuse_foreign
from .options import ClusterOption, JsonOption, LawsOption, take_laws
from .searchcost import told_of_allotment, told_of_search
from .signals import NOW
from .terminal import command, grid, output, print_json, row, sentences, tell, writing

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..study.allocation import Allocated
    from ..study.cluster import Resources
    from ..study.plan import Plan
    from ..study.run_missing import Engine
    from ..study.searches import Allotment

Work = TypeVar("Work")
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
        from ..study.searches import load_search, optimised

        take_laws(laws)
        resources = Resources(workers, None, cluster, device)
        plan, base, search = load_search(file)
    target = placed(file, output_, force)
    told_of_search(plan, base, search, target, yes, quiet, force)
    found, more = grown(target, plan, base, file.stem, force, resources, quiet, search.members, lambda engine: optimised(engine, plan, search))
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
        from ..study.run_missing import units_of
        from ..study.searches import allotted, load_allotment

        take_laws(laws)
        resources = Resources(workers, None, cluster, device)
        plan, base, task = load_allotment(file)
    target = placed(file, output_, force)
    told_of_allotment(plan, base, task, target, yes, quiet, force)
    found = grown(target, plan, base, file.stem, force, resources, quiet, None, lambda engine: allotted(engine, task))
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


def placed(file: Path, target: Path | None, force: bool) -> Path:
    """Where a study is kept. Ends with a sentence where something else has the name."""
    found = target if target is not None else Path("runs") / f"{file.stem}.study"
    with sentences(str(file)):
        refuse_foreign(found, force)
    return found


def grown(
    target: Path,
    plan: Plan,
    base: Mechanism,
    name: str,
    force: bool,
    resources: Resources,
    quiet: bool,
    of: int | None,
    work: Callable[[Engine], Work],
) -> Work:
    """What a search comes to, its members kept in a file; ends with the code of a signal, and says how to go on."""
    from ..job.progress import ProgressLine

    kept = f"Members that ended are kept in {target}; the same command goes on after them."
    with sentences(str(target)), writing(str(target), kept):
        from ..study.run_missing import Engine, asked_of, opened
        from ..study.studies import locked

        target.parent.mkdir(parents=True, exist_ok=True) if target.parent.name == "runs" else None
        with locked(target) as lock:
            NOW.last.append(lock.release)
            NOW.saved = kept
            asked = asked_of(plan, base, name)
            with resources.runner() as runner, opened(target, asked, [], replace=force) as file, ProgressLine(quiet) as line:
                show = MemberLine(line)
                told = (lambda done, many, outcome: show(done, max(many, of), outcome)) if of is not None else show
                try:
                    return work(Engine(file, base, resources, runner, told))
                except KeyboardInterrupt:
                    ended = len(file.keys("outcomes"))
    tell(Status.INTERRUPTED, f"{NOW.by}: {ended:,} members have ended; the same command goes on: {again()}")
    raise typer.Exit(NOW.code)


def again() -> str:
    """The command as it was given."""
    import sys

    return " ".join([command(), *map(shlex.quote, sys.argv[1:])])
