"""The answer of a run on one screen: what was run, how certain it is, and the numbers a designer needs."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from ..measures.stops import stop_sentence
from ..numerics.scalar import log10, power
from ..solvers.status import Status
from ..units import in_rpm
from . import dead_centres
from .amounts import WIDE, interval, prefixed
from .damping_cautions import law_words
from .digits import (
    ABOUT_ZERO,
    CERTAIN,
    RADIAL,
    SCATTER,
    Json,
    ideal_force_text,
    ideal_shaking_text,
    is_about_zero,
    is_estimated,
    is_undetermined,
    largest_text,
    shaking_text,
    sum_text,
    turns_text,
    uncertainty,
    unit_of,
)
from .document import Document, Facts, Paragraph, Part, Section, Table, paragraphs
from .freedom import freedom_left_words
from .noise import blow, noise
from .run import (
    CONFORMAL,
    ROUNDING,
    SHARED,
    actuator_facts,
    document,
    effort_facts,
    reversed_power,
    torque_text,
    wear_facts,
)
from .run_tables import (
    deepest_text,
    force_text,
    influence_text,
    knock_texts,
    lacks_friction,
    mean_text,
    note_on_means,
    noted,
    of_contacts,
)
from .run_up import WITH_RUN_UP, motor_sentence, run_ups
from .trust import (
    FAILURES,
    LEAST_DISTANCE,
    UNCOMPARED,
    former_clause,
    mesh_clause,
    missing_estimate,
    over_several_turns,
    period_sentence,
    scatter_over_turns,
    settling_options,
    settling_sentence,
    turn_distance,
    turns_to_settle,
    unstable_tries,
    verdict,
    without_turns,
)
from .wear import length_note

STEPS_DECIDE = "Sensitive to the step size"
RELIABLE = "Reliable numerically"  # laws and data of the model are no part of it
NOT_COMPUTED = "not computed"  # friction of ideal joints
LOOSE = 1.5  # times the shaking force at the outputs: a larger estimate is left to the long answer
NEGLIGIBLE = 0.01  # of the largest measure with the same unit: no warning about smaller ones
# measures whose errors decide whether a run is sensitive
DECISIVE = (".force.max", ".moment.max", ".torque.max")
CORNER = re.compile(r"\.(\d)\.")  # of a block in a guide, as a part of the name of a measure
PREFIXES_OF = ("m", "N", "N m")  # units with a prefix in sentences, as in the table
TWO_TURNS = 2.0 - 1e-9  # a run of two turns ends by rounding just before
MOST_JOINTS, MOST_CAUTIONS, MOST_EXCEPTIONS, MOST_FACTORS = 8, 4, 3, 3


def overview(summary: Json) -> Document:
    """Return the short document of what :func:`vfife.report.summary.run_summary` returns.

    :func:`vfife.report.run.document` gives the long one. A static analysis has that one only.
    """
    if summary["run"].get("analysis") == "static":
        return document(summary, MOST_FACTORS)
    parts: list[Part] = [Paragraph(heading_sentence(summary), style="strong")]
    parts += paragraphs(
        [certainty(summary)], style="alarm" if uncertain(summary) or certainty_leads(summary) else "good"
    )
    table = joint_table(summary)
    parts += [table] if table.rows else []
    facts = [
        *_machine(summary),
        *wear_facts(summary),
        *dead_centres.facts(summary),
        *noise(summary),
        *blow(summary),
    ]
    parts += [Facts(facts)] if facts else []
    if texts := list(cautions(summary)):
        rows = [(str(k), text) for k, text in enumerate(texts[:MOST_CAUTIONS], 1)]
        left = len(texts) - len(rows)
        remainder = [("", f"{left} more: add --long, or vfife info RUN --long.")] * bool(left)
        parts.append(Section("Cautions", [Facts([*rows, *remainder])]))
    return Document(parts, data=summary)


def heading_sentence(summary: Json) -> str:
    """Return the model, its speeds, the length of the run and the part that values are of."""
    run, name = summary["run"], summary["model"]["name"]
    speeds = [in_rpm(abs(speed)) for speed in run.get("speeds", {}).values()]
    count = run.get("crank_turns", run["turns"])
    turns = "" if count is None else f"{count:.4g} turn{'s' * (count != 1.0)}"
    length = interrupted_length(summary) or turns or prefixed(run["time_s"], "s")
    ending = [freedom_left_words(run), str(summary["status"]) * (summary["status"] != Status.COMPLETE)]
    part = "means over turns" if over_several_turns(summary["turns"]) else f"values of the {summary['part']}"
    period = (summary["turns"] or {}).get("period") or 1
    part = f"period {period} · {part}" if period > 1 else part
    part += f" {WITH_RUN_UP}" if run_ups(summary) else ""
    return " · ".join(filter(None, [name, *speeds, length, contact_counts(summary), part, *ending]))


def interrupted_length(summary: Json) -> str:
    """Return which part of an interrupted run is computed, as in "9.5 of 20 turns"; empty for others."""
    run, share = summary["run"], summary["run"].get("steps_planned", 0) / max(summary["steps"], 1)
    if not share:
        return ""
    if run["turns"] is None:
        return f"{prefixed(run['time_s'], 's')} of {prefixed(share * run['time_s'], 's')}"
    return f"{run['turns']:.4g} of {share * run['turns']:.4g} turns"


def contact_counts(summary: Json) -> str:
    """Return the numbers of joints with clearance and of external contacts, such as stops and floors."""
    clearances = [joint["clearance"] for joint in summary["joints"].values() if "clearance" in joint]
    external = clearances.count(None)
    loose = len(clearances) - external
    texts = [f"{loose} joint{'s' * (loose > 1)} with clearance"] if loose else []
    texts += [f"{external} external contact{'s' * (external > 1)}"] if external else []
    return ", ".join(texts) or "no clearance"


# -------------------------------------------------------------------------------------------------- certainty


def errors(summary: Json) -> dict[str, float]:
    """Relative errors (1) of forces, moments and torques whose error was estimated, the largest first.

    Measures below :data:`NEGLIGIBLE` of the largest of their kind are left out.
    """
    sizes: dict[str, float] = {}
    for ending in DECISIVE:
        values = {name: abs(value) for name, value in summary["measures"].items() if name.endswith(ending)}
        largest = max(values.values(), default=0.0)
        for name, value in values.items():
            ranged = name in summary["ranges"] and is_estimated(summary, name)
            if value > NEGLIGIBLE * largest and ranged and not is_about_zero(summary, name):
                sizes[name] = _margin(summary, name)
    return dict(sorted(sizes.items(), key=lambda item: -item[1]))


def uncertain(summary: Json) -> bool:
    """Return whether a force, moment or torque is known less well than :data:`CERTAIN`, or not at all."""
    trust = summary["trust"]
    if summary["status"] in FAILURES or not trust or trust.get("lost") or not trust.get("converges", True):
        return True
    former = trust.get("former", {"included": True})
    return (
        (not former["included"] and (former["sensitive"] or not former["measure"]))
        or bool(scatter_over_turns(summary))
        or without_turns(summary)
        or (bool(settling_sentence(summary)) and summary["turns"]["distance"] > CERTAIN)
        or any(error > CERTAIN for error in errors(summary).values())
    )


def certainty(summary: Json) -> str:
    """Return how far the forces, moments and torques of a run can be trusted, in one or two sentences."""
    numerical = [settling_sentence(summary), _from_its_start(summary, _with_meshes(summary))]
    if numerical[1].startswith(STEPS_DECIDE):
        numerical.reverse()
    sentences = [
        motor_sentence(summary),
        fall_sentence(summary),
        *numerical,
        law_sentence(summary),
        period_sentence(summary),
    ]
    if without_turns(summary):
        sentences.append(
            f"{UNCOMPARED[0].upper()}{UNCOMPARED[1:]}: all values are those of the last turn alone."
        )
    return " ".join(sentence for sentence in sentences if sentence)


def has_fall(summary: Json) -> bool:
    """Return whether the largest forces are those of the fall of journals at the start."""
    return bool(summary.get("start_fall")) and summary["status"] not in FAILURES


def certainty_leads(summary: Json) -> bool:
    """Return whether values are not those of the machine in operation, which is said before them."""
    return has_fall(summary) or bool(motor_sentence(summary))


def fall_sentence(summary: Json) -> str:
    """Return that the largest forces are those of the fall of journals at the start, with the number of the
    caution that explains it; "" for other runs.
    """
    if not has_fall(summary):
        return ""
    number = list(cautions(summary)).index(summary["warnings"][summary["start_fall"]["index"]]) + 1
    return (
        "The largest forces are those of the journals' fall at the start, not of the machine: see caution"
        f" {number}."
    )


def _with_meshes(summary: Json) -> str:
    """Return how far the values can be trusted, and which meshes that leaves out: in the sentence that calls
    them reliable, else in the next one.
    """
    text, clause = _certainty(summary), mesh_clause(summary)
    if not clause or not summary["trust"] or summary["status"] in FAILURES:
        return text
    head, stop, rest = text.partition(". ")
    if text.startswith(RELIABLE):
        return f"{head.removesuffix('.')}; {clause}.{stop[1:]}{rest}"
    return f"{text} {clause[0].upper()}{clause[1:]}."


def _from_its_start(summary: Json, text: str) -> str:
    """Return how far the values can be trusted, with the errors of the run from which a run goes on where no
    range includes them. A run that goes on from a sensitive one, or from one without ranges, is not
    called reliable.
    """
    clause, trust = former_clause(summary["trust"]), summary["trust"]
    if not clause or summary["status"] in FAILURES:
        return text
    if not text.startswith(RELIABLE):
        return f"{text} {clause[0].upper()}{clause[1:]}."
    head, stop, rest = text.partition(". ")
    lead, colon, change = head.removesuffix(".").partition(": ")
    former = trust["former"]
    if former["sensitive"] or not former["measure"]:
        state = "is sensitive" if former["sensitive"] else "has no estimate of its errors"
        lead = f"The run that it goes on from {state}"
    change = f"from its start on {change}; " if change else ""
    return f"{lead}{colon or ': '}{change}{clause}.{stop[1:]}{rest}"


def law_sentence(summary: Json) -> str:
    """Return which forces the contact law decides, with the numbers of the cautions that explain it; "" for
    none.
    """
    dependent, shocks, loads = (summary.get(f"law_{key}") or {} for key in ("dependent", "shocks", "loads"))
    if not (dependent or shocks) or summary["status"] in FAILURES:
        return ""
    texts = list(cautions(summary))
    indices = {*dependent.values(), *shocks.values(), *loads.values()}
    numbers = sorted({texts.index(summary["warnings"][index]) + 1 for index in indices})
    *first, last = map(str, numbers)
    listed = f"caution{'s' * bool(first)} {', '.join(first)}{' and ' * bool(first)}{last}"
    left = " (--long)" if numbers[-1] > MOST_CAUTIONS else ""
    compared = not summary["run"].get("without_ideal")
    return f"{law_words(dependent, shocks, loads, compared)}: see {listed}{left}."


def _certainty(summary: Json) -> str:
    """Return how far the values can be trusted, without what turns differ by."""
    trust = summary["trust"]
    if summary["status"] in FAILURES:
        return "Quote no number of this run: it did not end well."
    if not trust:
        return f"Errors are not estimated: {missing_estimate(summary)}."
    if trust.get("lost") or not trust.get("converges", True) or is_undetermined(summary, trust["measure"]):
        return verdict(summary)
    if scatter := scatter_over_turns(summary):
        return scatter
    sizes = errors(summary)
    inexact = [name for name, error in sizes.items() if error > CERTAIN]
    within = [error for error in sizes.values() if error <= CERTAIN]
    turns = summary["turns"]
    settled = not over_several_turns(turns) or (turns["motion"], turns["period"]) == ("periodic", 1)
    means = "means of " * (not settled)
    change = f"change by at most {_share(max(within))} with the step" if within else ""
    sure = f"{means}forces and torques {change}" if within else ""
    shown = [_interval(summary, name) for name in inexact[:MOST_EXCEPTIONS]]
    unlisted = [f"{len(inexact) - MOST_EXCEPTIONS} more (--long)"] * (len(inexact) > MOST_EXCEPTIONS)
    measure = trust["measure"]
    # Of a run without forces no measure decides: its name is empty, and it has no range.
    excepted = trust["sensitive"] and measure and measure not in sizes and not measure.endswith(DECISIVE)
    exception = [_interval(summary, measure)] if excepted else []
    of_turn = " for this turn alone" * bool(settling_sentence(summary))
    if not inexact:
        head = f"{RELIABLE}{of_turn}{f': {sure}' if sure else ''}"
        return f"{head}.{' Less certain: ' + exception[0] + '.' if exception else ''}{unstable_tries(trust)}"
    remainder = f" {RELIABLE}{of_turn}: {'the other ' if shown else ''}{sure}." if sure else ""
    if not trust.get("automatic", True):
        remainder = " The step was given: ranges cover it and its companions only; others may differ more."
    # An acceleration leads only where nothing that a joint has to carry is uncertain.
    values = "; ".join([*shown, *unlisted])
    return f"{STEPS_DECIDE}: {values}. Quote these ranges.{remainder}{unstable_tries(trust)}"


def _share(error: float) -> str:
    """Return an error (1) in per cent, rounded up to one digit."""
    percents = max(100.0 * error, 0.01)
    unit = power(10.0, math.floor(log10(percents)))
    return f"{math.ceil(percents / unit - 1e-9) * unit:.1g} %"


def _interval(summary: Json, name: str) -> str:
    """Return a measure in words, with its range."""
    bounds, width, unit = summary["ranges"][name], uncertainty(summary, name), unit_of(name)
    return (
        f"{_words(name)} {interval(bounds['low'], bounds['high'], unit, width, prefix=unit in PREFIXES_OF)}"
    )


def _words(name: str) -> str:
    """Return the name of a measure in words."""
    return CORNER.sub(r" corner \1 ", name.removesuffix(".max")).replace("_", " ").replace(".", " ")


# ------------------------------------------------------------------------------------------------------ table


def joint_table(summary: Json) -> Table:
    """Return the forces against the ideal mechanism, knocks, friction and pressure of each joint; empty
    columns are left out.
    """
    heads = (
        "joint", "ideal", "force", "turns", "change", "moment", "knocks", "friction", "pressure",
        "penetration",
    )  # fmt: skip
    shown, moments = _shown_joints(summary), moment_texts(summary)
    rows = [_joint_row(summary, name, moments.get(name, "")) for name in shown]
    if any(row[8] for row in rows):  # a pressure says what a penetration says
        rows = [row[:9] for row in rows]
    used = [k for k in range(len(rows[0]) if rows else 0) if any(row[k] for row in rows)]
    table = [tuple(row[k] for k in used) for row in rows]
    if left := len(summary["joints"]) - len(shown):
        table.append((f"{left} more: --long", *[""] * (len(used) - 1)))
    compared = any(row[1] for row in rows)
    words = {"force": "with clearance"} if compared else {}
    if any(row[3] for row in rows):
        words |= {"force": "largest, mean", "turns": "single turns"}
    loose = [joint for joint in summary["joints"].values() if joint.get("clearance")]
    if loose:
        words["joint"] = f"joint ({'each side' if all(joint.get('guide') for joint in loose) else 'radial'})"
    headings = [words.get(heads[k], heads[k]) for k in used]
    means = [
        f"{name}.force.max" for name, row in zip(shown, rows, strict=True) if row[3] and " to " in row[2]
    ]
    lengths = length_note(summary, [name for name, row in zip(shown, rows, strict=True) if row[8]])
    note = note_on_means(summary, means)
    return noted(Table(headings, table, numbers=range(1, len(headings)), names=(0,)), note, lengths)


def _margin(summary: Json, name: str) -> float:
    """Return the relative error (1) of a measure, to the farther end of its range."""
    bounds, value = summary["ranges"][name], summary["measures"][name]
    return float(max(bounds["high"] - value, value - bounds["low"]) / abs(value))


def clearance_note(summary: Json) -> list[Part]:
    """Return a sentence on what a clearance is, for a run that has one, and on worn surfaces."""
    if not any(joint.get("clearance") for joint in summary["joints"].values()):
        return []
    return [*paragraphs([RADIAL, *(f"Worn surfaces: {text}." for _, text in wear_facts(summary))])]


def _shown_joints(summary: Json) -> list[str]:
    """Return all joints if they are few, else those with clearance and then those with the largest forces."""
    names = list(summary["joints"])
    if len(names) <= MOST_JOINTS:
        return names
    loose = [name for name in names if "clearance" in summary["joints"][name]]
    by_force = sorted(names, key=lambda name: -float(summary["joints"][name]["force.max"]))
    first = dict.fromkeys([*loose, *by_force])
    return sorted(list(first)[:MOST_JOINTS], key=names.index)


def _joint_row(summary: Json, name: str, moment: str) -> tuple[str, ...]:
    joint, measure = summary["joints"][name], f"{name}.force.max"
    clearance = joint.get("clearance")
    label = f"{name} {prefixed(clearance, 'm')}" if clearance else name
    label += ", worn" if joint.get("worn") else ""
    shared = " *" if measure in summary["not_unique"] else ""
    knock = knock_texts(summary, name)[0]
    pressures = of_contacts(summary, name, "contact_pressure.max")
    friction = f"{name}.friction_power.mean"
    power = mean_text(summary, friction, "W", WIDE) if summary["measures"].get(friction) else ""
    return (
        label,
        ideal_force_text(summary, name),
        force_text(summary, measure) + shared,
        turns_text(summary, measure, "N", CERTAIN),
        influence_text(summary, f"{name}.force"),
        moment,
        knock,
        NOT_COMPUTED if lacks_friction(summary, name) else power,
        largest_text(summary, pressures, "Pa", WIDE) if pressures else "",
        deepest_text(summary, name) if joint.get("penetration.max") else "",
    )


def moment_texts(summary: Json) -> dict[str, str]:
    """Return the moments of joints that are above :data:`NEGLIGIBLE` of the largest moment or torque."""
    sizes = {name: abs(value) for name, value in summary["measures"].items() if name.endswith(DECISIVE[1:])}
    limit = NEGLIGIBLE * max(sizes.values(), default=0.0)
    names = {joint: f"{joint}.moment.max" for joint in summary["joints"]}
    large = {joint: name for joint, name in names.items() if sizes.get(name, 0.0) > limit}
    texts = {joint: force_text(summary, name, "N m") for joint, name in large.items()}
    return {joint: text for joint, text in texts.items() if text != ABOUT_ZERO}


# ---------------------------------------------------------------------------------------------------- machine


def _machine(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield the power, torque and shaking force."""
    measures = summary["measures"]
    friction = [name for name in measures if name.endswith(".friction_power.mean")]
    for name, body in summary["model"]["bodies"].items():
        if body["torque.max"] is None:
            continue
        texts = []
        if abs(measures.get(f"{name}.torque.mean", 0.0)) > ROUNDING * body["torque.max"]:
            total = sum(measures[loss] for loss in friction)
            losses = f" ({sum_text(summary, friction, 'W')} friction)" if total else ""
            power = mean_text(summary, f"{name}.power.mean", "W", SCATTER)
            texts.append(f"mean power {power}{losses}")
            texts += reversed_power(summary, f"{name}.power.mean")
            torque = mean_text(summary, f"{name}.torque.mean", "N m", CERTAIN)
            texts.append(f"mean torque {torque}")
        elif f"{name}.torque.mean" in measures:
            losses = sum(value for term, value in summary["energy"]["end"].items() if term.endswith("_loss"))
            reason = ": nothing is lost, and loads return what they take up" if losses == 0.0 else ""
            texts.append(f"mean power about zero{reason}")
        ideal = body["ideal_torque.max"]
        compared = f" (ideal {prefixed(ideal, 'N m')})" if ideal is not None else ""
        texts.append(f"largest torque {torque_text(summary, f'{name}.torque.max')}{compared}")
        yield f"Driver {name}", ", ".join(texts)
    yield from ((f"Driver {name}", text) for name, text in actuator_facts(summary))
    ground, shaking = summary.get("ground") or {}, measures.get("ground.shaking_force.max", 0.0)
    largest = ground.get("estimate", ground.get("at_most", 0.0))
    if shaking > 0.0 and (ground.get("joint") or largest <= LOOSE * shaking):
        yield "Shaking force", f"{shaking_text(summary)}{ideal_shaking_text(summary)}"
    yield from effort_facts(summary)
    if stops := summary.get("stops"):
        yield "Stops", stop_sentence(stops, summary.get("stop_interval"))


# --------------------------------------------------------------------------------------------------- cautions


def cautions(summary: Json) -> Iterator[str]:
    """Yield the sentences of caution, the gravest first: about the run, its turns, its laws, its notes."""
    leading = verdict(summary)
    yield from (text for text in summary["warnings"] if text != leading)
    turns = summary["turns"]
    if turns and turns["motion"] in ("settling", "unsettled") and turns["distance"] is not None:
        if turns["distance"] < LEAST_DISTANCE:
            yield (
                f"The last turn is {turn_distance(turns['distance'])} from one before it; whether turns"
                f" repeat shows in more: --turns {turns_to_settle(turns['count'])}."
            )
    elif (
        summary["contacts"] and summary["run"].get("steady") and (summary["run"]["turns"] or 0.0) < TWO_TURNS
    ):
        yield (
            "The run has fewer than two turns, so whether turns repeat is not known, and later ones may have"
            f" other forces: run it with {settling_options(0)}."
        )
    yield from summary["run"]["notes"]
    if summary["conformal"]:
        yield f"{', '.join(summary['conformal'])}: contact {CONFORMAL.removeprefix('* ')}"
    if summary["not_unique"]:
        yield SHARED
