"""The answer of a static analysis: its equilibria, as data and as tables."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..measures.catalogue import equilibria as equilibria_of
from ..measures.meshes import EXACT
from ..solvers.status import Status
from .digits import bounds, plain
from .document import Paragraph, Part, Table, sentences
from .trust import trusted, verdict

if TYPE_CHECKING:
    from ..results.view import View

UNITS = {
    "displacement.max": "m",
    "force.max": "N",
    "moment.max": "N m",
    "torque.max": "N m",
    "penetration.max": "m",
}
MESHED = "Ranges are the errors of the mesh, from the same analysis with other numbers of elements."
UNESTIMATED = (
    "Errors are not estimated: nothing here is cut into elements that could be halved, the analysis did not"
    " come to its end, or it is long or was told not to be repeated (companions = 1 has it repeated)."
)
REDUNDANT = "Joints are redundant: rigid bodies leave open how these share the load."
COLUMNS = 6  # joints whose reactions fit beside each other
AXES = ("force_x", "force_y")
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
        "factors": equilibria_of(record),
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
    moved = [entry["displacement"] for entry in equilibria_of(record)]
    jumps = [later - earlier for earlier, later in zip(moved, moved[1:], strict=False)]
    for k, jump in enumerate(jumps[1:], start=1):
        before = max(abs(jumps[k - 1]), 1e-300)
        if jump > 20.0 * before and jump > 0.05 * max(moved):
            factor = record.assembly.mechanism.settings.load_factors[k]
            yield (
                f"At load factor {factor:g} the displacement leaps by {jump:.4g} m, {jump / before:.3g} times"
                " the step before: a limit load was passed and the structure snapped through. Put load"
                " factors closer together before it, or prescribe a travel to follow the way."
            )
            break


def equilibria(summary: dict[str, Any]) -> list[Part]:
    """Equilibria with their reactions, and the largest values with their ranges."""
    run, factors = summary["run"], summary["run"]["factors"]
    what = (
        f"Static analysis by dynamic relaxation: {run['reached']} of {run['load_factors']} load factors,"
        f" {run['iterations']:,} iterations in {summary['wall_s']:.3g} s; {summary['status']}."
    )
    joints = list(factors[0]["reactions"])[:COLUMNS] if factors else []
    smallest = 1e-9 * max(
        [0.0, *(abs(one["reactions"][name][axis]) for one in factors for name in joints for axis in AXES)]
    )
    stride, rows = -(-len(factors) // MOST), []
    for one in [*factors[:-1:stride], *factors[-1:]]:
        numbers = (
            f"{one['load_factor']:g}",
            f"{one['iterations']:,}",
            f"{one['unbalanced']:.1e}",
            f"{one['displacement']:.6g}",
        )
        rows.append((*numbers, *(_pair(one["reactions"][name], smallest) for name in joints)))
    heads = ("load factor", "iterations", "unbalanced", "displacement, m", *(f"{name}, N" for name in joints))
    table = Table.of(heads, rows, "Equilibria, reactions on the journals", words=0)
    parts: list[Part] = [*sentences([what, *run["notes"]]), table, _largest(summary)]
    parts += sentences([MESHED if summary["trust"] else UNESTIMATED])
    if summary["not_unique"]:
        shared = ", ".join(name.removesuffix(".max") for name in summary["not_unique"])
        parts.append(Paragraph(f"Shared by least norm, not unique: {shared}. {REDUNDANT}"))
    return parts


def _pair(reaction: dict[str, float], smallest: float) -> str:
    """Both components of a reaction (N); 0 for what is only rounding."""
    return "({})".format(
        ", ".join(f"{reaction[axis]:.5g}" if abs(reaction[axis]) > smallest else "0" for axis in AXES)
    )


def _largest(summary: dict[str, Any]) -> Table:
    """The measures with their ranges."""
    rows = []
    for name in summary["measures"]:
        if name not in EXACT:
            unit = UNITS.get(name) or next(
                (unit for kind, unit in UNITS.items() if name.endswith(f".{kind}")), ""
            )
            rows.append((name, f"{plain(summary, name)} {unit}".rstrip(), bounds(summary, name)))
    return Table.of(("measure", "value", "range"), rows, "Largest values of all load factors")
