"""What a static analysis came to, as one object for scripts and as tables for people."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..analysis.measures import equilibria
from ..analysis.meshes import EXACT
from ..solvers.status import Status
from .digits import bounds, plain
from .trust import trusted, verdict

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from ..results.view import View

UNITS = {"displacement.max": "m", "force.max": "N", "moment.max": "N m", "torque.max": "N m", "penetration.max": "m"}
MESHED = "Ranges are the errors of the mesh, from the same analysis with other numbers of elements."
UNESTIMATED = (
    "Errors are not estimated: nothing here is cut into elements that could be halved, the analysis did not come to its end, or it is long or was "
    "told not to be repeated (companions = 1 has it repeated)."
)
COLUMNS = 6  # joints whose reactions fit beside each other
MOST = 40  # rows that a table shows, spread evenly over the load factors


def static_run(result: View) -> dict[str, Any]:
    """What stands under ``run`` in the summary of a static analysis."""
    record = result.record
    settings = record.assembly.mechanism.settings
    return {
        "analysis": "static",
        "loop": record.loop,
        "load_factors": len(settings.load_factors),
        "reached": max(len(record.steps) - 1, 0),
        "iterations": int(record.block("iterations").sum()),
        "residual": settings.residual,
        "factors": equilibria(record),
        "notes": list(record.assembly.notes),
    }


def static_warnings(result: View) -> Iterable[str]:
    """Sentences about what makes the equilibria doubtful, each with what to do."""
    record = result.record
    if record.lost:
        yield f"The run file is damaged: {', '.join(record.lost)} could not be read; run the model again."
    if record.message:
        yield record.message
    elif record.status != Status.COMPLETE:
        yield f"The analysis is {record.status}: only the load factors that are told here were reached."
    found = {"trust": trusted(result), "turns": {}, "static": True}
    if coarse := verdict(found):
        yield coarse
    moved = [entry["displacement"] for entry in equilibria(record)]
    jumps = [later - earlier for earlier, later in zip(moved, moved[1:], strict=False)]
    for k, jump in enumerate(jumps[1:], start=1):
        before = max(abs(jumps[k - 1]), 1e-300)
        if jump > 20.0 * before and jump > 0.05 * max(moved):
            factor = record.assembly.mechanism.settings.load_factors[k]
            yield (
                f"At load factor {factor:g} the displacement leaps by {jump:.4g} m, {jump / before:.3g} times the step before: a limit load was "
                "passed and the structure snapped through. Put load factors closer together before it, or prescribe a travel to follow the way."
            )
            break


def largest(told: dict[str, Any]) -> Table:
    """The measures with their ranges."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for k, heading in enumerate(("measure", "value", "range")):
        table.add_column(heading, justify="right" if k else "left")
    for name in told["measures"]:
        if name not in EXACT:
            unit = UNITS.get(name) or next((unit for kind, unit in UNITS.items() if name.endswith(f".{kind}")), "")
            table.add_row(Text(name), f"{plain(told, name)} {unit}".rstrip(), bounds(told, name))
    return table


def print_static(console: Console, told: dict[str, Any]) -> None:
    """Prints the summary of a static analysis."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    run, factors = told["run"], told["run"]["factors"]
    console.print()
    console.print(Text(told["model"]["name"], style="bold"))
    if told["model"]["note"]:
        console.print(Text(told["model"]["note"], style="italic"))
    console.print(
        Text(
            f"Static analysis by dynamic relaxation: {run['reached']} of {run['load_factors']} load factors, {run['iterations']:,} iterations in "
            f"{told['wall_s']:.3g} s; {told['status']}."
        )
    )
    for text in run["notes"]:
        console.print(Text(text))
    joints = list(factors[0]["reactions"])[:COLUMNS] if factors else []
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for heading in ("load factor", "iterations", "unbalanced", "displacement, m", *(f"{name}, N" for name in joints)):
        table.add_column(Text(heading), justify="right")
    most = max([0.0, *(abs(entry["reactions"][name][axis]) for entry in factors for name in joints for axis in ("force_x", "force_y"))])

    def pair(reaction: dict[str, float]) -> str:
        return "({})".format(", ".join(f"{reaction[axis]:.5g}" if abs(reaction[axis]) > 1e-9 * most else "0" for axis in ("force_x", "force_y")))

    stride = -(-len(factors) // MOST)
    for entry in [*factors[:-1:stride], *factors[-1:]]:
        reactions = [pair(entry["reactions"][name]) for name in joints]
        cells = (f"{entry['load_factor']:g}", f"{entry['iterations']:,}", f"{entry['unbalanced']:.1e}", f"{entry['displacement']:.6g}")
        table.add_row(*cells, *reactions)
    console.print(Text("Equilibria, reactions on the journals", style="bold"))
    console.print(table)
    console.print(Text("Largest values of all load factors", style="bold"))
    console.print(largest(told))
    console.print(Text(MESHED if told["trust"] else UNESTIMATED))
    if told["not_unique"]:
        named = ", ".join(name.removesuffix(".max") for name in told["not_unique"])
        console.print(Text(f"Shared by least norm, not unique: {named}. Joints are redundant: rigid bodies leave open how these share the load."))
    for text in told["warnings"]:
        console.print(Text.assemble(("Warning: ", "bold yellow"), text))
