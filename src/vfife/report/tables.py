"""The summary of a run as tables for people."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..analysis.forces import MODES
from ..analysis.measured import NOT_ESTIMATED
from .digits import amount, estimated, percent, prefixed, spread_of
from .trust import lines, verdict
from .turns import lines as turn_lines
from .turns import several
from .wear import CONFORMAL, archard_table, machine_lines, wear_table, worn, worn_off

SHOWN = 1e-4  # of a measure: what turns have to differ by to be shown
NOISE = 1e-6  # of the largest angular acceleration
SHARED = "* shared by least norm, not unique: joints are redundant, and rigid bodies leave open how these reactions share the load."


def print_report(console: Console, told: dict[str, Any]) -> None:
    """Prints what :func:`vfife.report.summary.report` says."""
    model, run = told["model"], told["run"]
    console.print()
    console.print(Text(model["name"], style="bold"))
    if model["note"]:
        console.print(Text(model["note"], style="italic"))
    leading = verdict(told)
    if leading:
        console.print(Text(leading, style="bold yellow"))
    console.print(facts(told))
    for text in run["notes"]:
        console.print(Text(text))
    for title, table in found_tables(told):
        console.print(Text(title, style="bold"))
        console.print(table)
    if told["conformal"]:
        console.print(Text(CONFORMAL))
    if told["not_unique"]:
        console.print(Text(SHARED))
    for text in told["warnings"]:
        if text == leading:
            continue
        console.print(Text.assemble(("Warning: ", "bold yellow"), text))


def found_tables(told: dict[str, Any]) -> Iterable[tuple[str, Table]]:
    """Tables of what was found, each with its title; those that a run has nothing for are left out."""
    turning = any(body["angular_acceleration.max"] for body in told["model"]["bodies"].values() if not body["driven"])
    contact = any("impacts" in one for one in told["contacts"].values())
    for title, there, table in (
        (f"Largest reactions ({told['part']})", bool(told["joints"]), _joint_table),
        ("Contact (whole run)", contact, _contact_table),
        (f"Losses and pressures ({told['part']})", bool(worn(told)), wear_table),
        (f"Wear by Archard's law ({told['part']})", bool(worn_off(told)), archard_table),
        (f"Largest angular accelerations ({told['part']})", turning, _body_table),
    ):
        if there:
            yield title, table(told)


def facts(told: dict[str, Any]) -> Table:
    """What was run, and how far it can be trusted: names and sentences."""
    table = Table.grid(padding=(0, 2))
    for name, text in (
        ("Bodies", "; ".join(f"{name}: {_body(body)}" for name, body in told["model"]["bodies"].items())),
        ("Step", _step(told)),
        ("Run", _pace(told)),
        *(("Turns", line) for line in turn_lines(told)),
        *(("Trust" if k == 0 else "", line) for k, line in enumerate(lines(told))),
        ("Energy", _energy(told)),
        *(("Driver", line) for line in _torques(told)),
        *machine_lines(told),
        *(("Laws" if k == 0 else "", line) for k, line in enumerate((*_law_lines(told), *told["remarks"]))),
    ):
        table.add_row(Text(name, style="cyan"), Text(text))
    return table


def _body(body: dict[str, Any]) -> str:
    said = str(body["model"])
    if body["elements"] > 1:
        said += f", {body['elements']} elements"
    if body["release"] != "none" and body["elements"]:
        said += ", a bar" if body["release"] == "both" else f", released at its {body['release']}"
    return said + (", driven" if body["driven"] else "")


def _step(told: dict[str, Any]) -> str:
    run = told["run"]
    size = f"{told['steps']:,} steps of {prefixed(told['step'], 's')}"
    length = prefixed(run["time_s"], "s") + (f", {run['turns']:.4g} turns" if run["turns"] is not None else "")
    if run["automatic"]:
        return f"{size} ({length}), set by {run['set_by']}"
    stable = f"; stable below {prefixed(run['stable_step'], 's')} ({run['set_by']})" if run["stable_step"] else ""
    return f"{size} ({length}), as asked for{stable}"


def _pace(told: dict[str, Any]) -> str:
    pace = f"{prefixed(told['wall_s'], 's')}, {told['ns_per_step']:.4g} ns a step"
    return f"{told['status']}, {told['run']['loop']} loop, {pace}"


def _energy(told: dict[str, Any]) -> str:
    end, largest = told["energy"]["end"], told["energy"]["largest"]
    put_in = end["driver"] + end["external"]
    lost = {kind: end[f"{kind}_loss"] for kind in ("contact", "friction", "damping", "spring")}
    parts = ", ".join(f"{kind} {value:.4g}" for kind, value in lost.items() if value)
    return (
        f"whole run: put in {put_in:.5g} J, lost {sum(lost.values()):.5g} J{f' ({parts})' if parts else ''}, "
        f"largest {largest:.5g} J; ledger closes to {told['energy_error']:.1e} of it"
    )


def _torques(told: dict[str, Any]) -> Iterable[str]:
    for name, body in told["model"]["bodies"].items():
        if body["torque.max"] is not None:
            ideal = body["ideal_torque.max"]
            largest = amount(body["torque.max"], "N m", spread_of(told, f"{name}.torque.max")) + _star(told, f"{name}.torque.max")
            yield f"{name}: largest torque {largest}" + (f", ideal {amount(ideal, 'N m')}" if ideal is not None else "") + f" ({told['part']})"


def _law_lines(told: dict[str, Any]) -> Iterable[str]:
    """Laws and what they derive from radii and materials, joints alike in one line."""
    lines: dict[str, list[str]] = {}
    for joint, laws in told["laws"].items():
        said = []
        for law in laws.values():
            units = {name: unit for name, unit in law.get("units", {}).items() if unit != "1"}
            numbers = ", ".join(f"{name} {value} {units.get(name, '')}".rstrip() for name, value in law["derived"].items())
            said.append(law["law"] + (f" ({numbers})" if numbers else ""))
        lines.setdefault("; ".join(said), []).append(joint)
    for text, joints in lines.items():
        yield f"{', '.join(joints)}: {text}"


def _grid(*headings: str) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for k, heading in enumerate(headings):
        table.add_column(heading, justify="right" if k else "left")
    return table


def _joint_table(told: dict[str, Any]) -> Table:
    joints = told["joints"]
    compared = any(joint["ideal_force.max"] is not None for joint in joints.values())
    depths = any("penetration.max" in joint for joint in joints.values())
    moments = any(joint.get("moment.max") for joint in joints.values())
    headings = [*_heads(told, "reaction"), *(["ideal", "LIP(F)"] if compared else []), *(["moment"] if moments else [])]
    table = _grid("joint", *headings, *(["penetration"] if depths else []))
    for name, joint in joints.items():
        cells = _with_range(told, f"{name}.force.max", _sound(joint["force.max"], joints), "N", _star(told, f"{name}.force.max"))
        if compared:
            cells += [amount(joint["ideal_force.max"], "N"), percent(told["lip"].get(f"{name}.force"), spread_of(told, f"{name}.force.lip"))]
        if moments:
            cells.append(amount(joint.get("moment.max"), "N m", spread_of(told, f"{name}.moment.max")) + _star(told, f"{name}.moment.max"))
        if depths:
            spread = spread_of(told, f"{name}.penetration.max")
            cells.append(prefixed(joint["penetration.max"], "m", spread) if "penetration.max" in joint else "")
        table.add_row(Text(name), *cells)
    return table


def _star(told: dict[str, Any], name: str) -> str:
    """The mark of a reaction that redundant joints leave open."""
    return " *" if name in told["not_unique"] else ""


def _heads(told: dict[str, Any], what: str) -> list[str]:
    """A column, that of its range, which leads where the run is sensitive, and that of what varies from turn to turn."""
    heads = [what]
    if told["trust"]:
        heads = [f"range of {what}", "mean" if several(told["turns"]) else "this run"] if told["trust"]["sensitive"] else [what, "range"]
    return heads + (["lowest to highest turn"] if _varies(told) else [])


def _varies(told: dict[str, Any]) -> bool:
    """Whether turns differ by enough to be shown."""
    if not several(told["turns"]):
        return False
    sizes = {name: one for name, one in told["ranges"].items() if name.endswith((".force.max", ".angular_acceleration.max"))}
    return any(one["highest"] - one["lowest"] > SHOWN * one["highest"] for one in sizes.values())


def _with_range(told: dict[str, Any], name: str, value: float, unit: str, mark: str = "") -> list[str]:
    """The cells of those columns: the range in the unit where it leads, else as a share of the value."""
    one, to = told["ranges"].get(name), spread_of(told, name)
    shown = amount(value, unit, to) + mark
    cells = [shown]
    if told["trust"]:
        if one is None or not estimated(told, name):
            cells = [NOT_ESTIMATED, shown] if told["trust"]["sensitive"] else [shown, NOT_ESTIMATED]
        elif told["trust"]["sensitive"]:
            cells = [f"{amount(one['low'], '', to).rstrip()} to {amount(one['high'], unit, to)}", shown]
        else:
            own = told["measures"][name]
            low, high = ((100.0 * (one[key] / own - 1.0) if own else 0.0) for key in ("low", "high"))
            cells = [shown, f"{low:+.2f} to {high:+.2f} %" if max(abs(low), abs(high)) >= 0.005 else "within 0.01 %"]
    if _varies(told):
        cells.append("" if one is None else f"{amount(one['lowest'], '', to).rstrip()} to {amount(one['highest'], unit, to)}")
    return cells


def _sound(force: float, joints: dict[str, Any]) -> float:
    """The force, or 0 where it is only rounding beside the largest one and the largest moment (N, N m)."""
    largest = max(max(joint["force.max"], joint.get("moment.max") or 0.0) for joint in joints.values())
    return force if force > 1e-9 * largest else 0.0


def _contact_table(told: dict[str, Any]) -> Table:
    headings = ("free flight", "impact", "contact", "impacts", "grazing", "landed too deep", "deepest landing")
    table = _grid("joint", *headings)
    for name, joint in told["contacts"].items():
        if "impacts" in joint:
            shares = (f"{100.0 * joint[f'share.{mode}']:.3g} %" for mode in MODES)
            counts = (f"{joint[kind]:.0f}" for kind in ("impacts", "grazing", "deep_landings"))
            table.add_row(Text(name), *shares, *counts, prefixed(joint["landing_depth.max"], "m"))
    return table


def _body_table(told: dict[str, Any]) -> Table:
    bodies = {name: body for name, body in told["model"]["bodies"].items() if not body["driven"]}
    compared = any(body["ideal_angular_acceleration.max"] is not None for body in bodies.values())
    headings = [*_heads(told, "acceleration"), *(["ideal", "LIP(a)"] if compared else [])]
    table = _grid("body", *headings)
    largest = max(body["angular_acceleration.max"] or 0.0 for body in bodies.values())
    for name, body in bodies.items():
        if (body["angular_acceleration.max"] or 0.0) > NOISE * largest:  # what only slides has none
            cells = _with_range(told, f"{name}.angular_acceleration.max", body["angular_acceleration.max"], "rad/s²")
            if compared:
                ideal = amount(body["ideal_angular_acceleration.max"], "rad/s²")
                to = spread_of(told, f"{name}.angular_acceleration.lip")
                cells += [ideal, percent(told["lip"].get(f"{name}.angular_acceleration"), to)]
            table.add_row(Text(name), *cells)
    return table
