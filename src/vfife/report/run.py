"""The answer of a run: facts with how far they can be trusted, and tables of reactions, contacts, losses,
wear and accelerations.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..measures.forces import MODES
from ..measures.measured import NOT_ESTIMATED
from .digits import amount, decimals, estimated, fixed, mark, measured, percent, prefixed, spread_of
from .document import Caution, Document, Facts, Paragraph, Part, Table, named, sentences
from .statics import equilibria
from .trust import lines, several, turn_lines, verdict

SHOWN = 1e-4  # share of a measure by which turns have to differ to be shown
NOISE = 1e-6  # share of the largest angular acceleration
MANY = 10.0  # times the mean torque: a larger ripple is shown as an amplitude
SHARED = (
    "* shared by least norm, not unique: joints are redundant, and rigid bodies leave open how these"
    " reactions share the load."
)
CONFORMAL = (
    "* wider than 0.3 of the journal's radius: Hertz' theory is coarse there, and the line pressure too low."
)


def document(summary: dict[str, Any]) -> Document:
    """The document of what :func:`vfife.report.summary.report` returns."""
    model, run = summary["model"], summary["run"]
    title: list[Part] = [Paragraph(model["name"], style="strong")]
    title += [Paragraph(model["note"], style="aside")] if model["note"] else []
    if run.get("analysis") == "static":
        return Document([*title, *equilibria(summary), *(Caution(text) for text in summary["warnings"])])
    leading = verdict(summary)
    title += [Paragraph(leading, style="alarm")] if leading else []
    notes = [Paragraph(text) for text in run["notes"]]
    body: list[Part] = [Facts(facts(summary)), *notes, *tables(summary), *sentences(footnotes(summary))]
    return Document([*title, *body, *(Caution(text) for text in summary["warnings"] if text != leading)])


def footnotes(summary: dict[str, Any]) -> list[str]:
    """What asterisks in the tables mean."""
    return [CONFORMAL] * bool(summary["conformal"]) + [SHARED] * bool(summary["not_unique"])


def tables(summary: dict[str, Any]) -> list[Table]:
    """Tables of what was found; those without rows are left out."""
    of = f"({summary['part']})"
    contacts = (
        "joint",
        "free flight",
        "impact",
        "contact",
        "impacts",
        "grazing",
        "landed too deep",
        "deepest landing",
    )
    losses = ("joint", "friction", "impacts", "sliding", "line pressure", "half-width", "p v, mean")
    worn = ("joint", "bearing, volume", "deepest", "journal, volume", "deepest")
    found = (
        _joint_table(summary, f"Largest reactions {of}"),
        Table.of(contacts, list(_contact_rows(summary)), "Contact (whole run)"),
        Table.of(losses, list(_loss_rows(summary)), f"Losses and pressures {of}"),
        Table.of(worn, list(_wear_rows(summary)), f"Wear by Archard's law {of}"),
        _body_table(summary, f"Largest angular accelerations {of}"),
    )
    return [table for table in found if table.rows]


def facts(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """What was run, and how far it can be trusted: names and sentences; a sentence without a name belongs to
    the name before.
    """
    return [
        ("Bodies", "; ".join(f"{name}: {_body(body)}" for name, body in summary["model"]["bodies"].items())),
        ("Step", _step(summary)),
        (
            "Run",
            (
                f"{summary['status']}, {summary['run']['loop']} loop, {prefixed(summary['wall_s'], 's')},"
                f" {summary['ns_per_step']:.4g} ns a step"
            ),
        ),
        *(("Turns", line) for line in turn_lines(summary)),
        *(("Trust" if k == 0 else "", line) for k, line in enumerate(lines(summary))),
        ("Energy", _energy(summary)),
        *(("Driver", line) for line in _torques(summary)),
        *_machine(summary),
        *(
            ("Laws" if k == 0 else "", line)
            for k, line in enumerate((*_law_lines(summary), *summary["remarks"]))
        ),
    ]


def _body(body: dict[str, Any]) -> str:
    said = str(body["model"])
    if body["elements"] > 1:
        said += f", {body['elements']} elements"
    if body["release"] != "none" and body["elements"]:
        said += ", a bar" if body["release"] == "both" else f", released at its {body['release']}"
    return said + (", driven" if body["driven"] else "")


def _step(summary: dict[str, Any]) -> str:
    run = summary["run"]
    size = f"{summary['steps']:,} steps of {prefixed(summary['step'], 's')}"
    length = prefixed(run["time_s"], "s") + (
        f", {run['turns']:.4g} turns" if run["turns"] is not None else ""
    )
    if run["automatic"]:
        return f"{size} ({length}), set by {run['set_by']}"
    stable = (
        f"; stable below {prefixed(run['stable_step'], 's')} ({run['set_by']})" if run["stable_step"] else ""
    )
    return f"{size} ({length}), as asked for{stable}"


def _energy(summary: dict[str, Any]) -> str:
    end, largest = summary["energy"]["end"], summary["energy"]["largest"]
    put_in = end["driver"] + end["external"]
    lost = {kind: end[f"{kind}_loss"] for kind in ("contact", "friction", "damping", "spring")}
    parts = ", ".join(f"{kind} {value:.4g}" for kind, value in lost.items() if value)
    return (
        f"whole run: put in {put_in:.5g} J, lost {sum(lost.values()):.5g} J{f' ({parts})' if parts else ''}, "
        f"largest {largest:.5g} J; ledger closes to {summary['energy_error']:.1e} of it"
    )


def _torques(summary: dict[str, Any]) -> Iterable[str]:
    for name, body in summary["model"]["bodies"].items():
        if body["torque.max"] is not None:
            ideal = body["ideal_torque.max"]
            largest = amount(body["torque.max"], "N m", spread_of(summary, f"{name}.torque.max")) + _star(
                summary, f"{name}.torque.max"
            )
            yield (
                f"{name}: largest torque {largest}"
                + (f", ideal {amount(ideal, 'N m')}" if ideal is not None else "")
                + f" ({summary['part']})"
            )


def _law_lines(summary: dict[str, Any]) -> Iterable[str]:
    """Laws and what they derive from radii and materials, joints alike in one line."""
    lines: dict[str, list[str]] = {}
    for joint, laws in summary["laws"].items():
        said = []
        for law in laws.values():
            numbers = named(law["derived"], law.get("units", {}))
            said.append(law["law"] + (f" ({numbers})" if numbers else ""))
        lines.setdefault("; ".join(said), []).append(joint)
    for text, joints in lines.items():
        yield f"{', '.join(joints)}: {text}"


def _machine(summary: dict[str, Any]) -> Iterable[tuple[str, str]]:
    """Heading and line: mean torque and power of the drivers, efficiency, what shakes the ground."""
    found = summary["measures"]
    for name in summary["model"]["bodies"]:
        if f"{name}.torque.mean" in found:
            mean, ripple = found[f"{name}.torque.mean"], found.get(f"{name}.torque.ripple", 0.0)
            width = prefixed(ripple * abs(mean), "N m", spread_of(summary, f"{name}.torque.max"))
            swing = (
                f", ripple {100.0 * ripple:,.4g} %{mark(summary, f'{name}.torque.ripple')}"
                if ripple < MANY
                else f", swinging by {width}"
            )
            torque, power = (
                measured(summary, f"{name}.torque.mean", "N m"),
                measured(summary, f"{name}.power.mean", "W"),
            )
            yield (
                "",
                (
                    f"{name}: mean torque {torque}{swing if ripple else ''}, mean power {power}"
                    f" ({summary['part']})"
                ),
            )
    if "mechanism.efficiency" in found:
        doubt = mark(summary, "mechanism.efficiency")
        yield (
            "",
            (
                f"efficiency {100.0 * found['mechanism.efficiency']:.4g} %{doubt} (given off over given off"
                " and lost)"
            ),
        )
    if found.get("ground.shaking_force.max"):
        force, moment = (
            measured(summary, "ground.shaking_force.max", "N"),
            measured(summary, "ground.shaking_moment.max", "N m"),
        )
        yield "Ground", f"shaken by up to {force} and {moment} about its origin ({summary['part']})"


def _joint_table(summary: dict[str, Any], title: str) -> Table:
    joints, rows = summary["joints"], []
    compared = any(joint["ideal_force.max"] is not None for joint in joints.values())
    depths = any("penetration.max" in joint for joint in joints.values())
    moments = any(joint.get("moment.max") for joint in joints.values())
    heads = [
        *_heads(summary, "reaction"),
        *(["ideal", "LIP(F)"] if compared else []),
        *(["moment"] if moments else []),
    ]
    for name, joint in joints.items():
        cells = _with_range(
            summary,
            f"{name}.force.max",
            _sound(joint["force.max"], joints),
            "N",
            _star(summary, f"{name}.force.max"),
        )
        if compared:
            cells += [
                amount(joint["ideal_force.max"], "N"),
                percent(summary["lip"].get(f"{name}.force"), spread_of(summary, f"{name}.force.lip")),
            ]
        if moments:
            moment = f"{name}.moment.max"
            cells.append(
                amount(joint.get("moment.max"), "N m", spread_of(summary, moment)) + _star(summary, moment)
            )
        if depths:
            spread = spread_of(summary, f"{name}.penetration.max")
            cells.append(
                prefixed(joint["penetration.max"], "m", spread) if "penetration.max" in joint else ""
            )
        rows.append((name, *cells))
    return Table.of(("joint", *heads, *(["penetration"] if depths else [])), rows, title)


def _star(summary: dict[str, Any], name: str) -> str:
    """The mark of a reaction that redundant joints leave open."""
    return " *" if name in summary["not_unique"] else ""


def _heads(summary: dict[str, Any], what: str) -> list[str]:
    """A column, that of its range, which leads where the run is sensitive, and that of what varies from turn
    to turn.
    """
    heads = [what]
    if summary["trust"]:
        heads = (
            [f"range of {what}", "mean" if several(summary["turns"]) else "this run"]
            if summary["trust"]["sensitive"]
            else [what, "range"]
        )
    return heads + (["lowest to highest turn"] if _varies(summary) else [])


def _varies(summary: dict[str, Any]) -> bool:
    """Whether turns differ by enough to be shown."""
    if not several(summary["turns"]):
        return False
    sizes = {
        name: one
        for name, one in summary["ranges"].items()
        if name.endswith((".force.max", ".angular_acceleration.max"))
    }
    return any(one["highest"] - one["lowest"] > SHOWN * one["highest"] for one in sizes.values())


def _with_range(summary: dict[str, Any], name: str, value: float, unit: str, mark: str = "") -> list[str]:
    """The cells of those columns: the range in the unit where it leads, else as a share of the value."""
    one, to = summary["ranges"].get(name), spread_of(summary, name)
    shown = amount(value, unit, to) + mark
    cells = [shown]
    if summary["trust"]:
        if one is None or not estimated(summary, name):
            cells = [NOT_ESTIMATED, shown] if summary["trust"]["sensitive"] else [shown, NOT_ESTIMATED]
        elif summary["trust"]["sensitive"]:
            cells = [f"{amount(one['low'], '', to).rstrip()} to {amount(one['high'], unit, to)}", shown]
        else:
            own = summary["measures"][name]
            low, high = ((100.0 * (one[key] / own - 1.0) if own else 0.0) for key in ("low", "high"))
            cells = [
                shown,
                f"{low:+.2f} to {high:+.2f} %" if max(abs(low), abs(high)) >= 0.005 else "within 0.01 %",
            ]
    if _varies(summary):
        cells.append(
            ""
            if one is None
            else f"{amount(one['lowest'], '', to).rstrip()} to {amount(one['highest'], unit, to)}"
        )
    return cells


def _sound(force: float, joints: dict[str, Any]) -> float:
    """The force, or 0 where it is only rounding beside the largest one and the largest moment (N, N m)."""
    largest = max(max(joint["force.max"], joint.get("moment.max") or 0.0) for joint in joints.values())
    return force if force > 1e-9 * largest else 0.0


def _contact_rows(summary: dict[str, Any]) -> Iterable[tuple[str, ...]]:
    for name, joint in summary["contacts"].items():
        if "impacts" in joint:
            shares = (f"{100.0 * joint[f'share.{mode}']:.3g} %" for mode in MODES)
            counts = (f"{joint[kind]:.0f}" for kind in ("impacts", "grazing", "deep_landings"))
            yield name, *shares, *counts, prefixed(joint["landing_depth.max"], "m")


def _loss_rows(summary: dict[str, Any]) -> Iterable[tuple[str, ...]]:
    """Mean powers of the losses, fastest sliding, Hertz' line pressure, and the mean of pressure times speed,
    joint by joint.
    """
    for name in _joints_with(summary, ".friction_power.mean"):
        powers = (measured(summary, f"{name}.{kind}_power.mean", "W") for kind in ("friction", "impact"))
        cells = [
            shown(*_most(summary, name, kind, unit))
            + mark(summary, *_names(summary, name, kind))
            + " *" * (wide and name in summary["conformal"])
            for kind, unit, shown, wide in LOSSES
        ]
        yield name, *powers, *cells


def _wear_rows(summary: dict[str, Any]) -> Iterable[tuple[str, ...]]:
    """Volume that bearing and journal lose, and depth of the place that loses most."""
    measures = summary["measures"]
    for name in _joints_with(summary, ".bearing_wear.total"):
        cells = []
        for side in ("bearing", "journal"):
            total, deepest = f"{name}.{side}_wear.total", f"{name}.{side}_wear_depth.max"
            depth = measures.get(deepest)
            cells += [f"{1e9 * measures[total]:.3g} mm³{mark(summary, total)}"]
            cells += ["" if depth is None else f"{1e9 * depth:.3g} nm{mark(summary, deepest)}"]
        yield name, *cells


def _joints_with(summary: dict[str, Any], ending: str) -> list[str]:
    """Joints that have a measure of this ending."""
    return [name.removesuffix(ending) for name in summary["measures"] if name.endswith(ending)]


def _most(summary: dict[str, Any], joint: str, kind: str, unit: str) -> tuple[float, str, float]:
    """The largest of a measure over the contacts of a joint, its unit and what is not known of it; a block in
    a guide has four contacts.
    """
    known = [
        (summary["measures"][name], unit, spread_of(summary, name)) for name in _names(summary, joint, kind)
    ]
    return max(known, default=(0.0, unit, 0.0))


def _names(summary: dict[str, Any], joint: str, kind: str) -> list[str]:
    """A measure of the contacts of a joint."""
    return [
        name
        for name in (f"{joint}.{kind}", *(f"{joint}.{number}.{kind}" for number in range(1, 5)))
        if name in summary["measures"]
    ]


def _body_table(summary: dict[str, Any], title: str) -> Table:
    bodies = {name: body for name, body in summary["model"]["bodies"].items() if not body["driven"]}
    compared = any(body["ideal_angular_acceleration.max"] is not None for body in bodies.values())
    largest, rows = (
        max((body["angular_acceleration.max"] or 0.0 for body in bodies.values()), default=0.0),
        [],
    )
    for name, body in bodies.items():
        if (body["angular_acceleration.max"] or 0.0) > NOISE * largest:  # what only slides has none
            cells = _with_range(
                summary, f"{name}.angular_acceleration.max", body["angular_acceleration.max"], "rad/s²"
            )
            if compared:
                ideal = amount(body["ideal_angular_acceleration.max"], "rad/s²")
                spread = spread_of(summary, f"{name}.angular_acceleration.lip")
                cells += [ideal, percent(summary["lip"].get(f"{name}.angular_acceleration"), spread)]
            rows.append((name, *cells))
    return Table.of(
        ("body", *_heads(summary, "acceleration"), *(["ideal", "LIP(a)"] if compared else [])), rows, title
    )


def _mega(value: float, unit: str, spread: float = 0.0) -> str:
    """A pressure with its prefix."""
    factor, prefix = (1e9, "G") if value >= 1e9 else (1e6, "M")
    shown = (
        fixed(value / factor, decimals(value / factor, spread / factor))
        if spread > 0.0
        else f"{value / factor:.4g}"
    )
    return f"{shown} {prefix}{unit}"


LOSSES = (  # of the table of losses: measure, unit, how it is shown, whether its contact may be too wide
    ("sliding_velocity.max", "m/s", prefixed, False),
    ("contact_pressure.max", "Pa", _mega, False),
    ("contact_half_width.max", "m", prefixed, True),
    ("pressure_velocity.mean", "Pa m/s", _mega, False),
)
