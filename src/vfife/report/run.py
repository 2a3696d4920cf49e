"""Documents of a run: its summary, and the equilibria of a static analysis."""

from __future__ import annotations

from collections.abc import Iterator

from ..measures.forces import MODES
from ..measures.statics import EXACT
from ..measures.values import NOT_ESTIMATED
from ..model.surfaces import surface_words
from . import dead_centres
from .digits import (
    ABOUT_ZERO,
    CERTAIN,
    NOT_DETERMINED,
    SCATTER,
    Json,
    amount,
    deviations,
    estimate_mark,
    ideal_shaking_text,
    interval,
    is_about_zero,
    is_estimated,
    is_undetermined,
    largest_text,
    measure_text,
    percent,
    plain_number,
    prefixed,
    range_text,
    shaking_text,
    uncertainty,
    unit_of,
)
from .document import Caution, Document, Facts, Paragraph, Part, Table, grouped, paragraphs, quantities
from .trust import missing_mesh_estimate, over_several_turns, trust_lines, turn_lines, verdict

NOISE = 1e-6  # share of the largest angular acceleration
RIPPLE = 10.0  # times the mean torque: a larger ripple is shown as an amplitude
SHARED = (
    "* shared by least norm, not unique: joints are redundant, and rigid bodies do not determine how"
    " these reactions share the load."
)
CONFORMAL = (
    "* wider than 0.3 of the journal's radius: Hertz' theory is inaccurate there, and the line pressure too"
    " low."
)
LOSSES = (
    ("sliding_velocity.max", "m/s"),
    ("contact_pressure.max", "Pa"),
    ("contact_half_width.max", "m"),
    ("pressure_velocity.mean", "Pa m/s"),
)
MESHED = (
    "Ranges cover the error of the mesh, from the same analysis with other numbers of elements, and the"
    " remaining unbalanced forces of all particles (residual and rounding)."
)
REDUNDANT = "Joints are redundant: rigid bodies do not determine how they share the load."
REACTIONS = 6  # joints whose reactions fit beside each other
FACTORS = 40  # load factors that a table shows, evenly
AXES = ("force_x", "force_y")


def document(summary: Json, limit: int = FACTORS) -> Document:
    """Return the long document of what :func:`vfife.report.summary.run_summary` returns; ``limit``: load
    factors.
    """
    model, run = summary["model"], summary["run"]
    title = [Paragraph(model["name"], style="strong"), *paragraphs([model["note"]], style="aside")]
    if run.get("analysis") == "static":
        warnings = [Caution(text) for text in summary["warnings"]]
        return Document([*title, *equilibria(summary, limit), *warnings])
    leading = verdict(summary)
    title += paragraphs([leading], style="alarm")
    notes = [Paragraph(text) for text in run["notes"]]
    body: list[Part] = [Facts(facts(summary)), *notes, *tables(summary), *paragraphs(footnotes(summary))]
    return Document([*title, *body, *(Caution(text) for text in summary["warnings"] if text != leading)])


def footnotes(summary: Json) -> list[str]:
    """Return the meanings of the asterisks in the tables."""
    return [CONFORMAL] * bool(summary["conformal"]) + [SHARED] * bool(summary["not_unique"])


# ------------------------------------------------------------------------------------------------------ facts


def facts(summary: Json) -> list[tuple[str, str]]:
    """Names and sentences on what was run and how reliable it is; a sentence without a name belongs to the
    name before.
    """
    laws = grouped((_laws(laws), joint) for joint, laws in summary["laws"].items())
    law_lines = [f"{', '.join(joints)}: {text}" for text, joints in laws.items()]
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
        *_named_once("Trust", list(trust_lines(summary))),
        ("Energy", _energy(summary)),
        *(("Driver", line) for line in _torques(summary)),
        *_machine(summary),
        *_named_once("Laws", [*law_lines, *summary["law_facts"], *summary["remarks"]]),
    ]


def _named_once(name: str, lines: list[str]) -> list[tuple[str, str]]:
    return [(name if k == 0 else "", line) for k, line in enumerate(lines)]


def _body(body: Json) -> str:
    text = str(body["model"])
    if body["elements"] > 1:
        text += f", {body['elements']} elements"
    if body["release"] != "none" and body["elements"]:
        text += ", a bar" if body["release"] == "both" else f", released at its {body['release']}"
    return text + (", driven" if body["driven"] else "")


def _step(summary: Json) -> str:
    run = summary["run"]
    length = prefixed(run["time_s"], "s") + (
        f", {run['turns']:.4g} turns" if run["turns"] is not None else ""
    )
    size = f"{summary['steps']:,} steps of {prefixed(summary['step'], 's')} ({length})"
    if run["automatic"]:
        return f"{size}, set by {run['set_by']}"
    stable = (
        f"; stable below {prefixed(run['stable_step'], 's')} ({run['set_by']})" if run["stable_step"] else ""
    )
    return f"{size}, as requested{stable}"


def _energy(summary: Json) -> str:
    end, largest = summary["energy"]["end"], summary["energy"]["largest"]
    losses = {kind: end[f"{kind}_loss"] for kind in ("contact", "friction", "damping", "spring")}
    parts = ", ".join(f"{kind} {value:.4g}" for kind, value in losses.items() if value)
    return (
        f"whole run: supplied {end['driver'] + end['external']:.5g} J, lost {sum(losses.values()):.5g}"
        f" J{f' ({parts})' if parts else ''}, largest {largest:.5g} J; ledger closes to"
        f" {summary['energy_error']:.1e} of it"
    )


def _torques(summary: Json) -> Iterator[str]:
    for name, body in summary["model"]["bodies"].items():
        if body["torque.max"] is not None:
            ideal = body["ideal_torque.max"]
            compared = f", ideal {amount(ideal, 'N m')}" if ideal is not None else ""
            yield (
                f"{name}: largest torque"
                f" {_reaction(summary, f'{name}.torque.max', body['torque.max'])}{compared}"
                f" ({summary['part']})"
            )


def _laws(laws: Json) -> str:
    """Return the laws of a joint, with what they derive from radii and materials."""
    derived = [(law["law"], quantities(law["derived"], law.get("units", {}))) for law in laws.values()]
    return "; ".join(name + (f" ({numbers})" if numbers else "") for name, numbers in derived)


def _machine(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield the mean torque and power of the drivers, efficiency, and the shaking force on the ground."""
    measures, part = summary["measures"], summary["part"]
    for name in summary["model"]["bodies"]:
        if f"{name}.torque.mean" in measures:
            mean, ripple = measures[f"{name}.torque.mean"], measures.get(f"{name}.torque.ripple", 0.0)
            width = prefixed(ripple * abs(mean), "N m", uncertainty(summary, f"{name}.torque.max"))
            swing = f", ripple {100.0 * ripple:,.4g} %{estimate_mark(summary, f'{name}.torque.ripple')}"
            swing = (
                ""
                if is_about_zero(summary, f"{name}.torque.max")
                else swing
                if ripple < RIPPLE
                else f", varying by {width}"
            )
            torque, power = (
                measure_text(summary, f"{name}.torque.mean", "N m"),
                measure_text(summary, f"{name}.power.mean", "W"),
            )
            yield "", f"{name}: mean torque {torque}{swing if ripple else ''}, mean power {power} ({part})"
    if (name := "mechanism.efficiency") in measures:
        yield (
            "",
            (
                f"efficiency {100.0 * measures[name]:.4g} %{estimate_mark(summary, name)} (useful energy over"
                " useful and lost energy)"
            ),
        )
    if measures.get("ground.shaking_force.max"):
        force = shaking_text(summary)
        ideal = ideal_shaking_text(summary)
        yield ("Ground", (f"shaken by {force}{ideal}{_shaking_moment(summary)} ({part})"))


def _shaking_moment(summary: Json) -> str:
    """Return the largest moment on the ground, "" for one that is about zero."""
    name = "ground.shaking_moment.max"
    moment = "" if is_about_zero(summary, name) else measure_text(summary, name, "N m")
    return f" and {moment} about its origin" if moment else ""


# ----------------------------------------------------------------------------------------------------- tables


def tables(summary: Json) -> list[Table]:
    """Return the tables of reactions, contacts, losses, wear and accelerations; those without rows are left
    out.
    """
    part = f"({summary['part']})"
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
    noise = ("joint", "knocks", "hardest knock", "in turns measured", "hardest there", "power of the knocks")
    wear = ("surface", "volume", "deepest")
    candidates = (
        _joint_table(summary, f"Largest reactions {part}"),
        dead_centres.table(summary, part),
        Table.numeric(contacts, list(_contact_rows(summary)), "Contact (whole run)"),
        Table.numeric(
            noise, list(_noise_rows(summary)), f"Noise (knocks of the whole run; power: {summary['part']})"
        ),
        Table.numeric(losses, list(_loss_rows(summary)), f"Losses and pressures {part}"),
        Table.numeric(wear, list(_wear_rows(summary)), f"Wear by Archard's law {part}"),
        _body_table(summary, f"Largest angular accelerations {part}"),
    )
    return [table for table in candidates if table.rows]


def _joint_table(summary: Json, title: str) -> Table:
    joints, rows = summary["joints"], []
    compared = any(joint["ideal_force.max"] is not None for joint in joints.values())
    depths = any("penetration.max" in joint for joint in joints.values())
    moments = any(joint.get("moment.max") for joint in joints.values())
    largest = max(
        (max(joint["force.max"], joint.get("moment.max") or 0.0) for joint in joints.values()), default=0.0
    )
    for name, joint in joints.items():
        force = joint["force.max"] if joint["force.max"] > 1e-9 * largest else 0.0  # below that only rounding
        cells = _range_cells(summary, f"{name}.force.max", force)
        if compared:
            cells += _ideal_cells(summary, f"{name}.force", joint["ideal_force.max"])
        if moments:
            cells.append(_reaction(summary, f"{name}.moment.max", joint.get("moment.max")))
        if depths:
            spread = uncertainty(summary, f"{name}.penetration.max")
            cells.append(
                prefixed(joint["penetration.max"], "m", spread) if "penetration.max" in joint else ""
            )
        rows.append((name, *cells))
    heads = [
        *_headings(summary, "reaction", compared, "LIP(F)"),
        *["moment"] * moments,
        *["penetration"] * depths,
    ]
    return Table.numeric(("joint", *heads), rows, title)


def _body_table(summary: Json, title: str) -> Table:
    bodies = {name: body for name, body in summary["model"]["bodies"].items() if not body["driven"]}
    compared = any(body["ideal_angular_acceleration.max"] is not None for body in bodies.values())
    sizes = {name: body["angular_acceleration.max"] or 0.0 for name, body in bodies.items()}
    rows = []
    for name, size in sizes.items():
        if size > NOISE * max(sizes.values()):  # a body that only slides has none
            cells = _range_cells(summary, f"{name}.angular_acceleration.max", size)
            if compared:
                cells += _ideal_cells(
                    summary, f"{name}.angular_acceleration", bodies[name]["ideal_angular_acceleration.max"]
                )
            rows.append((name, *cells))
    return Table.numeric(("body", *_headings(summary, "acceleration", compared, "LIP(a)")), rows, title)


def _headings(summary: Json, measure: str, compared: bool, influence: str) -> list[str]:
    """Return the headings of :func:`_range_cells` and :func:`_ideal_cells`."""
    heads = [measure]
    if summary["trust"] and summary["trust"]["sensitive"]:
        heads = [f"range of {measure}", "mean" if over_several_turns(summary["turns"]) else "this run"]
    elif summary["trust"]:
        heads = [measure, "range"]
    return heads + ["lowest to highest turn"] * _scatters(summary) + ["ideal", influence] * compared


def _scatters(summary: Json) -> bool:
    """Return whether turns differ by enough to be shown."""
    if not over_several_turns(summary["turns"]):
        return False
    sizes = (
        spread
        for name, spread in summary["ranges"].items()
        if name.endswith((".force.max", ".angular_acceleration.max"))
    )
    return any(spread["highest"] - spread["lowest"] > SCATTER * spread["highest"] for spread in sizes)


def _range_cells(summary: Json, name: str, value: float) -> list[str]:
    """Return the value of a measure, its range, and its scatter over turns.

    The range of a sensitive run leads, in the unit of the measure; else it follows as a share of the value.
    """
    bounds, width, unit = summary["ranges"].get(name), uncertainty(summary, name), unit_of(name)
    text = _reaction(summary, name, value)
    cells = [text]
    if summary["trust"]:
        sensitive = summary["trust"]["sensitive"]
        if bounds is None or not is_estimated(summary, name):
            margin = NOT_ESTIMATED
        elif is_about_zero(summary, name):
            margin = f"below {amount(summary['about_zero'][name], unit)}"
        elif is_undetermined(summary, name):
            margin = NOT_DETERMINED
        elif sensitive:
            margin = interval(bounds["low"], bounds["high"], unit, width, prefix=False)
        else:
            measured, ends = summary["measures"][name], (bounds["low"], bounds["high"])
            wide = any(abs(end - measured) > 5e-5 * abs(measured) for end in ends)
            margin = deviations(*ends, measured) if wide else "within 0.01 %"
        cells = [margin, text] if sensitive else [text, margin]
    if _scatters(summary):
        lowest, highest = (0.0, 0.0) if bounds is None else (bounds["lowest"], bounds["highest"])
        cells.append("" if bounds is None else interval(lowest, highest, unit, width, prefix=False))
    return cells


def _ideal_cells(summary: Json, name: str, ideal: float | None) -> list[str]:
    """Return the value of the ideal mechanism, and by how many per cent clearances increase it."""
    return [
        amount(ideal, unit_of(f"{name}.max")),
        percent(summary["lip"].get(name), uncertainty(summary, f"{name}.lip")),
    ]


def _reaction(summary: Json, name: str, value: float | None) -> str:
    """Return a measure, with an asterisk where redundant joints leave it open."""
    if value is not None and is_about_zero(summary, name):
        return ABOUT_ZERO
    if is_undetermined(summary, name):
        return NOT_DETERMINED
    return amount(value, unit_of(name), uncertainty(summary, name)) + (
        " *" if name in summary["not_unique"] else ""
    )


def _contact_rows(summary: Json) -> Iterator[tuple[str, ...]]:
    for name, joint in summary["contacts"].items():
        if "impacts" in joint:
            shares = (f"{100.0 * joint[f'share.{mode}']:.3g} %" for mode in MODES)
            counts = (f"{joint[kind]:.0f}" for kind in ("impacts", "grazing", "deep_landings"))
            yield name, *shares, *counts, prefixed(joint["landing_depth.max"], "m")


def _loss_rows(summary: Json) -> Iterator[tuple[str, ...]]:
    """Yield the mean powers of the losses, fastest sliding, Hertz' line pressure, and the mean of pressure
    times speed of each joint.
    """
    for joint in _joints_with(summary, ".friction_power.mean"):
        powers = (measure_text(summary, f"{joint}.{kind}_power.mean", "W") for kind in ("friction", "impact"))
        cells = []
        for kind, unit in LOSSES:  # the largest over the contacts of a joint
            names = of_contacts(summary, joint, kind)
            largest = max(
                ((summary["measures"][name], uncertainty(summary, name)) for name in names),
                default=(0.0, 0.0),
            )
            if names and all(is_about_zero(summary, name) for name in names):
                cells.append(ABOUT_ZERO)
                continue
            wide = " *" * (kind == "contact_half_width.max" and joint in summary["conformal"])
            cells.append(prefixed(largest[0], unit, largest[1]) + estimate_mark(summary, *names) + wide)
        yield joint, *powers, *cells


def of_contacts(summary: Json, joint: str, kind: str) -> list[str]:
    """Names of a measure of all contacts of a joint; a block in a guide has four."""
    names = (f"{joint}.{place}{kind}" for place in ("", "1.", "2.", "3.", "4."))
    return [name for name in names if name in summary["measures"]]


def knocks(summary: Json, joint: str) -> tuple[int | None, str]:
    """Return the number of impacts of a joint over the whole run, None without clearance, and the speed of
    the hardest.
    """
    speeds = of_contacts(summary, joint, "approach_speed.max")
    if not speeds:
        return None, ""
    count = sum(int(summary["measures"][name]) for name in of_contacts(summary, joint, "impacts"))
    return count, largest_text(summary, speeds, "m/s", CERTAIN)


def knock_texts(summary: Json, joint: str) -> tuple[str, str]:
    """Return the hardest knock of a joint in the turns of the measures, and that of the start if it is
    another one; empty texts without clearance.
    """
    count, speed = knocks(summary, joint)
    if not count:
        return "" if count is None else "none", ""
    measured = own_knocks(summary, joint)
    if any(entry["hardest"] and entry["count"] for entry in measured) or not measured:
        return ("none" if speed == ABOUT_ZERO else speed), ""
    hardest = max(entry["speed"] for entry in measured)
    # Two digits, as of a value without an error.
    return f"{prefixed(hardest, 'm/s', 0.1 * hardest)} ({NOT_ESTIMATED})" if hardest else "none", speed


def own_knocks(summary: Json, joint: str) -> list[Json]:
    """Return the knocks of a joint's contacts in the turns of the measures; none in a former summary."""
    names = (name.removesuffix(".impacts") for name in of_contacts(summary, joint, "impacts"))
    by_contact = summary.get("knocks", {})
    return [by_contact[name] for name in names if name in by_contact]


def _noise_rows(summary: Json) -> Iterator[tuple[str, ...]]:
    """Yield for each joint the number of impacts, the speed of the hardest, and the mean power lost in
    impacts.
    """
    for joint in summary["joints"]:
        count, speed = knocks(summary, joint)
        if count is not None:
            power = f"{joint}.impact_power.mean"
            loss = measure_text(summary, power, "W") if power in summary["measures"] else ""
            measured_count = sum(entry["count"] for entry in own_knocks(summary, joint))
            hardest = knock_texts(summary, joint)[0]
            yield joint, f"{count:,}", speed if count else "none", f"{measured_count:,}", hardest, loss


def _wear_rows(summary: Json) -> Iterator[tuple[str, ...]]:
    """Yield the worn volume and largest depth of each surface: of the bearing and the journal of a joint."""
    measures = summary["measures"]
    for name in _joints_with(summary, ".bearing_wear.total"):
        bodies = summary.get("surfaces", {}).get(name, {})
        for side in ("bearing", "journal"):
            total, deepest = f"{name}.{side}_wear.total", f"{name}.{side}_wear_depth.max"
            depth = measures.get(deepest)
            volume = f"{1e9 * measures[total]:.3g} mm³{estimate_mark(summary, total)}"
            deepest_cell = "" if depth is None else f"{1e9 * depth:.3g} nm{estimate_mark(summary, deepest)}"
            yield f"{name}: {surface_words(bodies.get(side, ''), side)}", volume, deepest_cell


def _joints_with(summary: Json, ending: str) -> list[str]:
    return [name.removesuffix(ending) for name in summary["measures"] if name.endswith(ending)]


# -------------------------------------------------------------------------------------------- static analyses


def equilibria(summary: Json, limit: int = FACTORS) -> list[Part]:
    """Return the equilibria with their reactions, and the largest values with their ranges."""
    run, factors = summary["run"], summary["run"]["factors"]
    done = (
        f"Static analysis by dynamic relaxation: {run['reached']} of {run['load_factors']} load factors,"
        f" {run['iterations']:,} iterations in {summary['wall_s']:.3g} s; {summary['status']}."
    )
    joints = list(factors[0]["reactions"])[:REACTIONS] if factors else []
    smallest = 1e-9 * max(
        [0.0, *(abs(state["reactions"][name][axis]) for state in factors for name in joints for axis in AXES)]
    )
    stride, rows = -(-len(factors) // limit), []
    for state in [*factors[:-1:stride], *factors[-1:]]:
        numbers = (
            f"{state['load_factor']:g}",
            f"{state['iterations']:,}",
            f"{state['unbalanced']:.1e}" if state["unbalanced"] else "rounding",
            f"{state['displacement']:.6g}",
        )
        pairs = ([state["reactions"][name][axis] for axis in AXES] for name in joints)
        reactions = (
            ", ".join(f"{force:.5g}" if abs(force) > smallest else "0" for force in pair) for pair in pairs
        )
        rows.append((*numbers, *(f"({text})" for text in reactions)))
    heads = ("load factor", "iterations", "unbalanced", "displacement, m", *(f"{name}, N" for name in joints))
    largest = [
        (name, f"{plain_number(summary, name)} {unit_of(name)}".rstrip(), range_text(summary, name))
        for name in summary["measures"]
        if name not in EXACT
    ]
    parts: list[Part] = [
        *paragraphs([done, *run["notes"]]),
        Table.numeric(heads, rows, "Equilibria, reactions on the journals", texts=0),
        Table.numeric(("measure", "value", "range"), largest, "Largest values of all load factors"),
        Paragraph(
            MESHED if summary["trust"] else f"Errors are not estimated: {missing_mesh_estimate(summary)}."
        ),
    ]
    if summary["not_unique"]:
        shared = ", ".join(name.removesuffix(".max") for name in summary["not_unique"])
        parts.append(Paragraph(f"Shared by least norm, not unique: {shared}. {REDUNDANT}"))
    return parts
