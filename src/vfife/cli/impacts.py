"""``vfife impacts``: the contacts that began in a run, one by one as far as its outputs tell them apart."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Annotated

import typer

from .options import JsonOption, RunArgument
from .terminal import grid, output, print_json, row, sentences

if TYPE_CHECKING:
    from ..analysis.contacts import Impact, Impacts

Count = Annotated[int, typer.Option("-n", "--count", metavar="N", min=1, help="So many of the hardest.")]


def impacts(run: RunArgument, count: Count = 10, as_json: JsonOption = False) -> None:
    """The impacts of a run: time, crank angle, approach speed, energy lost and depth, the hardest first; with --json all of them in their order.

    None is missed. Those that began between the same two outputs are told together, with their number and mean speed; more outputs
    (vfife run --outputs) tell more of them apart.
    """
    with sentences(str(run)):
        from ..result import Result

        found = Result.load(run).impacts
    if as_json:
        entries = [dataclasses.asdict(one) for one in found.entries]
        print_json({"count": found.count, "alone": found.alone, "before": found.before, "impacts": entries})
    else:
        show(found, count)


def show(found: Impacts, count: int) -> None:
    """The same for people."""
    from rich.text import Text

    console = output()
    together = found.count - found.alone
    more = f", {together} of them between the same two outputs as others" if together else ""
    if not found.entries:
        console.print(Text("No contact began in this run."))
        return
    hardest = found.hardest(count)
    most = f" The hardest {len(hardest)} (--count for more):" if len(hardest) < len(found.entries) else ""
    lost = sum(one.energy for one in found.entries)
    console.print(Text(f"{found.count} contact{'s' * (found.count != 1)} began{more}. They lost {lost:.4g} J in all.{most}"))
    crank = any(one.crank is not None for one in found.entries)
    heads = ("joint", "time, ms", *(("crank, deg",) if crank else ()), "began", "speed, m/s", "lost, J", "depth, µm")
    table = grid(*heads, right=tuple(range(1, len(heads))))
    for one in hardest:
        row(table, one.joint, *cells(one))
    console.print(table)


def cells(one: Impact) -> tuple[str, ...]:
    """Numbers of an entry; the time is that of the output that shows it."""
    crank = () if one.crank is None else (f"{one.crank:.1f}",)
    speed = "" if one.speed is None else f"{one.speed:.4g}"
    return f"{1e3 * one.time:.4f}", *crank, str(one.count), speed, f"{one.energy:.4g}", f"{1e6 * one.depth:.4g}"
