"""Tables of the long document of a run: reactions, contacts, noise, losses, wear and accelerations."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping

from ..measures.catalogue import is_ideal_zero
from ..measures.forces import MODES
from ..measures.values import NOT_ESTIMATED
from ..model.surfaces import surface_words
from ..numerics.outward import DOWN, NEAREST, UP, exponent, rounded
from . import dead_centres
from .amounts import WIDE, amount, deviations, interval, percent, percent_places, prefixed
from .digits import (  # fmt: skip
    ABOUT_ZERO,
    CERTAIN,
    NOT_DETERMINED,
    SCATTER,
    Json,
    estimate_mark,
    forces_of,
    is_about_zero,
    is_estimated,
    is_undetermined,
    largest_text,
    measure_text,
    share_text,
    shown_uncertainty,
    uncertainty,
    unit_of,
    value_text,
    wide_range,
)
from .document import Table, grouped
from .trust import over_several_turns

BLOW = 0.2  # share of the largest force of a joint from which on a blow is stated
NOISE = 1e-6  # share of the largest angular acceleration
LOSSES = (
    ("sliding_velocity.max", "m/s"),
    ("contact_pressure.max", "Pa"),
    ("contact_half_width.max", "m"),
    ("pressure_velocity.mean", "Pa m/s"),
)
NONE_BEGAN = "none; one began before"  # a contact that was closed when the turns of the measures began
CHANGE = "Change: local influence parameter {}, in per cent of the ideal {}."
MEANS = "The range of a mean covers turns that were not computed too, so it may reach beyond those shown."
IDEAL = "Errors of the ideal mechanism are not estimated; the change has those of the {}."
DAMPED = 0.01  # of the power of all knocks: damping of a closed contact that is mentioned
MOST_SHIFT = 0.25  # of the width of a range, by which rounding may move the number in it


def tables(summary: Json) -> list[Table]:
    """Return the tables of reactions, contacts, losses, wear and accelerations; those without rows are left
    out.
    """
    part = f"({summary['part']})"
    noise = ("joint", "knocks", "hardest knock", "in turns measured", "hardest there", "power of the knocks")
    losses = ("joint", "friction", "impacts", "sliding", "line pressure", "half-width", "p v, mean")
    wear = ("surface", "volume", "deepest")
    knock_ranges = count_ranges({"knocks": _knock_counts(summary)})
    uncertain = [joint for joint in summary["joints"] if may_not_knock(summary, joint)]
    candidates = (
        _joint_table(summary, f"Largest reactions {part}"),
        dead_centres.table(summary, part),
        _contact_table(summary),
        noted(
            Table.numeric(
                noise,
                list(_noise_rows(summary)),
                f"Noise (knocks of the whole run; power: {summary['part']})",
            ),
            knock_ranges,
            _damping_note(summary),
            f"At other step sizes {', '.join(uncertain)} may not knock at all." if uncertain else "",
            f"{NOT_ESTIMATED.capitalize()}: in turns measured." if summary["trust"] else "",
        ),
        noted(Table.numeric(losses, list(_loss_rows(summary)), f"Losses and pressures {part}")),
        noted(Table.numeric(wear, list(_wear_rows(summary)), f"Wear by Archard's law {part}")),
        _body_table(summary, f"Largest angular accelerations {part}"),
    )
    return [table for table in candidates if table.rows]


def noted(table: Table, *notes: str) -> Table:
    """Return a table with notes. Columns of which no error was estimated are named in one of them, instead of
    a mark in every cell.
    """
    mark, unknown = estimate_mark({"trust": True, "not_estimated": [""]}, ""), []
    rows = [list(row) for row in table.rows]
    for k in table.numbers:
        cells = [row[k] for row in rows if row[k] not in ("", ABOUT_ZERO, "none")]
        if cells and all(mark in cell for cell in cells):
            unknown.append(table.headings[k])
            for row in rows:
                row[k] = row[k].replace(mark, "")
    columns = f"{NOT_ESTIMATED.capitalize()}: {', '.join(unknown)}." if unknown else ""
    note = " ".join(text for text in (table.note, *notes, columns) if text)
    return dataclasses.replace(table, rows=rows, note=note)


def count_ranges(counts: Mapping[str, Mapping[str, tuple[int, int]]]) -> str:
    """Return a sentence with the ranges of counts, by what is counted and by joint; "" without any."""
    texts = []
    for kind, by_joint in counts.items():
        groups = grouped((f"{low} to {high}", joint) for joint, (low, high) in by_joint.items() if high > low)
        ranges = ", ".join(f"{text} ({', '.join(joints)})" for text, joints in groups.items())
        texts += [f"{kind} {ranges}"] if ranges else []
    return f"Counts are those of this run; their ranges: {'; '.join(texts)}." if texts else ""


def count_range(summary: Json, names: Iterable[str]) -> tuple[int, int] | None:
    """Return the range of a sum of counts, None where it was not estimated."""
    names = list(names)
    if not names or not all(name in summary["ranges"] and is_estimated(summary, name) for name in names):
        return None
    low, high = (sum(summary["ranges"][name][end] for name in names) for end in ("low", "high"))
    return math.floor(low), math.ceil(high)


def _knock_counts(summary: Json) -> dict[str, tuple[int, int]]:
    ranges = {
        joint: count_range(summary, of_contacts(summary, joint, "impacts")) for joint in summary["joints"]
    }
    return {joint: ends for joint, ends in ranges.items() if ends}


def _contact_table(summary: Json) -> Table:
    """Return the table of shares of time and counts of contacts of the whole run."""
    kinds = {"impacts": "impacts", "grazing": "grazing", "deep_landings": "landed too deep"}
    heads = ("joint", "free flight", "impact", "contact", *kinds.values(), "deepest landing")
    rows, counts = list[tuple[str, ...]](), {word: dict[str, tuple[int, int]]() for word in kinds.values()}
    for name, joint in summary["contacts"].items():
        if "impacts" in joint:
            shares = (share_text(summary, f"{name}.share.{mode}") for mode in MODES)
            texts = (f"{joint[kind]:.0f}{estimate_mark(summary, f'{name}.{kind}')}" for kind in kinds)
            rows.append((name, *shares, *texts, value_text(summary, f"{name}.landing_depth.max", "m")))
            for kind, word in kinds.items():
                if ends := count_range(summary, [f"{name}.{kind}"]):
                    counts[word][name] = ends
    return noted(Table.numeric(heads, rows, "Contact (whole run)"), count_ranges(counts))


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
            cells += _ideal_cells(summary, f"{name}.force", joint["ideal_force.max"], forces_of(summary))
        if moments:
            moment = f"{name}.moment.max"
            cells.append(
                wide_range(summary, moment, "N m") or reaction(summary, moment, joint.get("moment.max"))
            )
        if depths:
            cells.append(deepest_text(summary, name) if "penetration.max" in joint else "")
        rows.append((name, *cells))
    heads = [*_headings(summary, "reaction", compared), *["moment"] * moments, *["penetration"] * depths]
    note = _change_note(summary, "LIP(F)", "reaction") if compared else ""
    means_note = note_on_means(summary, [f"{name}.force.max" for name in joints])
    return noted(Table.numeric(("joint", *heads), rows, title), means_note, note)


def deepest_text(summary: Json, joint: str) -> str:
    """Return the largest penetration of a joint, of a block in a guide that of its deepest corner."""
    names = of_contacts(summary, joint, "penetration.max")
    deepest = max(names, key=summary["measures"].__getitem__)
    wide = any(wide_range(summary, name, "m") for name in names)
    return largest_text(summary, names, "m", WIDE) if wide else value_text(summary, deepest, "m")


def _body_table(summary: Json, title: str) -> Table:
    bodies = {name: body for name, body in summary["model"]["bodies"].items() if not body["driven"]}
    compared = any(body["ideal_angular_acceleration.max"] is not None for body in bodies.values())
    sizes = {name: body["angular_acceleration.max"] or 0.0 for name, body in bodies.items()}
    rows = []
    for name, size in sizes.items():
        if size > NOISE * max(sizes.values()):  # a body that only slides has none
            cells = _range_cells(summary, f"{name}.angular_acceleration.max", size)
            if compared:
                ideal = bodies[name]["ideal_angular_acceleration.max"]
                cells += _ideal_cells(summary, f"{name}.angular_acceleration", ideal, sizes.values())
            rows.append((name, *cells))
    note = _change_note(summary, "LIP(a)", "acceleration") if compared else ""
    heads = ("body", *_headings(summary, "acceleration", compared))
    names = [f"{row[0]}.angular_acceleration.max" for row in rows]
    return noted(Table.numeric(heads, rows, title), note_on_means(summary, names), note)


def _change_note(summary: Json, symbol: str, kind: str) -> str:
    """Return what the change of the largest values of a ``kind`` is, and which errors it has."""
    note = CHANGE.format(symbol, kind)
    return f"{note} {IDEAL.format(kind)}" if summary["trust"] else note


def note_on_means(summary: Json, names: Iterable[str]) -> str:
    """Return why ranges of means over turns that do not repeat reach beyond all of these turns; "" where none
    does.
    """
    if (summary["turns"] or {}).get("motion") != "not repeating":
        return ""
    bounds = [summary["ranges"][name] for name in names if is_estimated(summary, name)]
    is_wider = any(ends["low"] < ends["lowest"] or ends["high"] > ends["highest"] for ends in bounds)
    return MEANS if is_wider else ""


def _headings(summary: Json, measure: str, compared: bool) -> list[str]:
    """Return the headings of :func:`_range_cells` and :func:`_ideal_cells`."""
    heads = [measure]
    if summary["trust"] and summary["trust"]["sensitive"]:
        heads = [f"range of {measure}", "mean" if over_several_turns(summary["turns"]) else "this run"]
    elif summary["trust"]:
        heads = [measure, "range"]
    return heads + ["lowest to highest turn"] * _scatters(summary) + ["ideal", "change"] * compared


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
    text = reaction(summary, name, value)
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


def _ideal_cells(summary: Json, name: str, ideal: float | None, values: Iterable[float | None]) -> list[str]:
    """Return the value of the ideal mechanism, and by how many per cent clearances increase it; ``values``:
    those of its kind.
    """
    if ideal is not None and is_ideal_zero(ideal, values):
        return [ABOUT_ZERO, ""]
    return [amount(ideal, unit_of(f"{name}.max")), influence_text(summary, name)]


def mean_text(summary: Json, name: str, unit: str, certain: float) -> str:
    """Return a mean power or torque, as a range where that is wider than the share ``certain`` of it."""
    value, bounds = summary["measures"][name], summary["ranges"].get(name)
    if bounds is None or not is_estimated(summary, name) or is_about_zero(summary, name):
        return measure_text(summary, name, unit)
    width = bounds["high"] - bounds["low"]
    if is_undetermined(summary, name) or not certain * abs(value) < width < math.inf:
        return measure_text(summary, name, unit)
    return interval(bounds["low"], bounds["high"], unit, uncertainty(summary, name))


def lacks_friction(summary: Json, name: str) -> bool:
    """Return whether a joint has a load but, being ideal, no friction, where other joints have some."""
    measures = summary["measures"]
    powers = [value for measure, value in measures.items() if measure.endswith(".friction_power.mean")]
    loaded = bool(measures.get(f"{name}.force.max")) and not is_about_zero(summary, f"{name}.force.max")
    return any(powers) and loaded and f"{name}.friction_power.mean" not in measures


def force_text(summary: Json, name: str, unit: str = "N") -> str:
    """Return a force or a moment, as a range where it is uncertain; with the same digits wherever an answer
    has it.
    """
    value, width = summary["measures"][name], uncertainty(summary, name)
    bounds = summary["ranges"].get(name)
    exact = bounds is None or width <= CERTAIN * abs(value) or not is_estimated(summary, name)
    if exact or is_about_zero(summary, name) or is_undetermined(summary, name):
        return measure_text(summary, name, unit)
    return interval(bounds["low"], bounds["high"], unit, width)


def influence_text(summary: Json, name: str) -> str:
    """Return by how many per cent clearances increase a force or acceleration, as a range where two digits
    are not known, or where rounding moves the number towards an end of its range; "" if it is not single, and
    for a force that the ideal mechanism has not.
    """
    influence, measure = summary["lip"].get(name), f"{name}.lip"
    ideal = summary["joints"].get(name.removesuffix(".force"), {}).get("ideal_force.max")
    if influence is None or (ideal is not None and is_ideal_zero(ideal, forces_of(summary))):
        return ""
    if wide := wide_range(summary, measure, "%"):
        return wide
    width = uncertainty(summary, measure)
    return _range_of_shifted(summary, measure, influence) or (
        percent(influence, width) + estimate_mark(summary, measure)
    )


def _range_of_shifted(summary: Json, name: str, value: float) -> str:
    """Return the range of a percentage if its range permits only digits near an end of it, else ""."""
    ends = (summary.get("ranges") or {}).get(name)
    if ends is None or not is_estimated(summary, name) or is_about_zero(summary, name):
        return ""
    width, places = ends["high"] - ends["low"], percent_places(value, uncertainty(summary, name))
    is_rounded_to_width = width == uncertainty(summary, name) and exponent(width) >= -places
    if not is_rounded_to_width or abs(rounded(value, places) - value) <= MOST_SHIFT * width:
        return ""
    return interval(ends["low"], ends["high"], "%", 0.1 * width, prefix=False)


def reaction(summary: Json, name: str, value: float | None) -> str:
    """Return a measure, with an asterisk where redundant joints leave it open."""
    if value is not None and is_about_zero(summary, name):
        return ABOUT_ZERO
    if is_undetermined(summary, name):
        return NOT_DETERMINED
    return amount(value, unit_of(name), shown_uncertainty(summary, name)) + (
        " *" if name in summary["not_unique"] else ""
    )


def depths_of_onsets(summary: Json) -> Table:
    """Return the table of the depths at which the contacts of the whole run began."""
    rows, counts = [], {"too deep": dict[str, tuple[int, int]]()}
    for name, contact in summary["contacts"].items():
        numbers = (f"{contact.get(kind, 0.0):.0f}" for kind in ("deep_landings", "impacts"))
        measure = f"{name}.landing_depth.max"
        depth = value_text(summary, measure, "m") if measure in summary["measures"] else ""
        rows.append((name, " of ".join(numbers), depth))
        if ends := count_range(summary, [f"{name}.deep_landings"]):
            counts["too deep"][name] = ends
    table = Table.numeric(("contact", "too deep", "deepest"), rows, "Depth at which contacts began")
    return noted(table, count_ranges(counts))


def _loss_rows(summary: Json) -> Iterator[tuple[str, ...]]:
    """Yield the mean powers of the losses, fastest sliding, Hertz' line pressure, and the mean of pressure
    times speed of each joint.
    """
    for joint in _joints_with(summary, ".friction_power.mean"):
        powers = (value_text(summary, f"{joint}.{kind}_power.mean", "W") for kind in ("friction", "impact"))
        cells = []
        for kind, unit in LOSSES:  # the largest over the contacts of a joint
            names = of_contacts(summary, joint, kind)
            wide = " *" * (kind == "contact_half_width.max" and joint in summary["conformal"])
            cells.append((largest_text(summary, names, unit, WIDE) if names else "") + wide)
        yield joint, *powers, *cells


def blow_texts(summary: Json) -> dict[str, str]:
    """Return in words the blows in closed contact that are a fifth of the largest force of their joint or
    more, by joint, the largest first.
    """
    blows, measures = summary.get("blows") or {}, summary["measures"]
    names = [name for name in blows if blows[name]["excess"] > BLOW * measures[f"{name}.force.max"]]
    texts = {}
    for name in sorted(names, key=lambda name: -float(blows[name]["excess"])):
        excess, lowest, crank = (blows[name][key] for key in ("excess", "lowest", "crank"))
        words = f"up to {prefixed(excess, 'N', 0.1 * excess, UP)}"
        if over_several_turns(summary["turns"]):
            words += f" (single turns {interval(lowest, excess, 'N', 0.1 * excess)})"
        texts[name] = f"{name} {words} above the ideal joint at {crank:.4g}°"
    return texts


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
    """Return the hardest knock of a joint in the turns of the measures, and that of the whole run if
    it is another one; empty texts without clearance.
    """
    count, speed = knocks(summary, joint)
    if not count:
        return "" if count is None else "none", ""
    measured = own_knocks(summary, joint)
    if any(entry["hardest"] and entry["count"] for entry in measured) or not measured:
        return ("none" if speed == ABOUT_ZERO else speed), ""
    hardest = max(float(entry["speed"]) for entry in measured)
    if not hardest:
        return NONE_BEGAN if any(entry.get("overlap") for entry in measured) else "none", speed
    # Three digits, but not more than the hardest of the whole run.
    fastest = max(
        float(summary["measures"][name]) for name in of_contacts(summary, joint, "approach_speed.max")
    )
    way = DOWN if rounded(hardest, 2 - exponent(hardest)) > fastest else NEAREST
    return f"{prefixed(hardest, 'm/s', 0.01 * hardest, way)} ({NOT_ESTIMATED})", speed


def may_not_knock(summary: Json, joint: str) -> bool:
    """Return whether a joint knocks in this run, and the range of the number of its knocks begins at zero."""
    ends = count_range(summary, of_contacts(summary, joint, "impacts"))
    return bool(knocks(summary, joint)[0]) and ends is not None and ends[0] <= 0


def own_knocks(summary: Json, joint: str) -> list[Json]:
    """Return the knocks of a joint's contacts in the turns of the measures; none in a former summary."""
    names = (name.removesuffix(".impacts") for name in of_contacts(summary, joint, "impacts"))
    by_contact = summary.get("knocks", {})
    return [by_contact[name] for name in names if name in by_contact]


def damped_joints(summary: Json) -> list[str]:
    """Return the joints without a knock in the turns of the measures in which the contact law still damps, in
    closed contact: a hundredth of the power of all joints or more.
    """
    powers = {
        name: float(summary["measures"].get(f"{name}.impact_power.mean", 0.0)) for name in summary["joints"]
    }
    limit = DAMPED * sum(powers.values())
    return [
        name
        for name, power in powers.items()
        if power > limit and not any(entry["count"] for entry in own_knocks(summary, name))
        if own_knocks(summary, name) or knocks(summary, name)[0] == 0
    ]


def _damping_note(summary: Json) -> str:
    """Return which joints lose power without a knock; "" for none."""
    if not (joints := damped_joints(summary)):
        return ""
    closed = f"{', '.join(joints)} without a knock, in closed contact"
    return f"The power is that of all damping in contact: {closed}."


def _noise_rows(summary: Json) -> Iterator[tuple[str, ...]]:
    """Yield for each joint the number of impacts, the speed of the hardest, and the mean power lost in
    impacts.
    """
    for joint in summary["joints"]:
        count, speed = knocks(summary, joint)
        if count is not None:
            power = f"{joint}.impact_power.mean"
            loss = value_text(summary, power, "W") if power in summary["measures"] else ""
            measured_count = sum(entry["count"] for entry in own_knocks(summary, joint))
            hardest = knock_texts(summary, joint)[0]
            yield joint, f"{count:,}", speed if count else "none", f"{measured_count:,}", hardest, loss


def _wear_rows(summary: Json) -> Iterator[tuple[str, ...]]:
    """Yield the worn volume and largest depth of each surface: of the bearing and the journal of a joint."""
    for name in _joints_with(summary, ".bearing_wear.total"):
        bodies = summary.get("surfaces", {}).get(name, {})
        for side in ("bearing", "journal"):
            total, deepest = f"{name}.{side}_wear.total", f"{name}.{side}_wear_depth.max"
            depth = _wear_text(summary, deepest, "nm") if deepest in summary["measures"] else ""
            surface = f"{name}: {surface_words(bodies.get(side, ''), side)}"
            yield surface, _wear_text(summary, total, "mm³"), depth


def _wear_text(summary: Json, name: str, unit: str) -> str:
    """Return a worn volume (mm³) or depth (nm)."""
    text = f"{1e9 * summary['measures'][name]:.3g} {unit}{estimate_mark(summary, name)}"
    return wide_range(summary, name, unit, 1e9) or text


def _joints_with(summary: Json, ending: str) -> list[str]:
    return [name.removesuffix(ending) for name in summary["measures"] if name.endswith(ending)]
