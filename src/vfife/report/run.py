"""Documents of a run: its summary, and the equilibria of a static analysis."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from ..measures.efforts import STEADY
from ..measures.statics import EXACT
from ..measures.stops import stop_sentence
from ..measures.values import NOT_ESTIMATED
from ..numerics.outward import UP
from .amounts import amount, interval, prefixed
from .design_words import and_words
from .digits import (
    CERTAIN,
    Json,
    estimate_mark,
    ideal_shaking_text,
    is_about_zero,
    is_estimated,
    is_negative,
    is_undetermined,
    largest_of_turns,
    measure_text,
    over_turns,
    plain_number,
    range_text,
    shaking_text,
    sum_text,
    turns_text,
    uncertainty,
    unit_of,
    value_text,
)
from .document import Caution, Document, Facts, Paragraph, Part, Table, grouped, paragraphs, quantities
from .run_tables import blow_texts, noted, reaction, tables
from .run_up import motor_sentence
from .trust import missing_mesh_estimate, over_several_turns, trust_lines, turn_lines, verdict

LEAST_WORK = 1e-6  # of the largest energy: less is rounding
EXACT_SHARE = 1e-9  # of a value: outputs miss no more than rounding
ONLY_ROUNDING = "rounding"
SMALL = 1e-3  # J or rad/s: smaller numbers have prefixes
ROUNDING = 1e-6  # of the largest power or torque of a driver: a smaller mean is rounding
RIPPLE = 10.0  # times the mean torque: a larger ripple is shown as an amplitude
SHARED = (
    "* shared by least norm, not unique: joints are redundant, and rigid bodies do not determine how"
    " these reactions share the load."
)
CONFORMAL = (
    "* wider than 0.3 of the journal's radius: Hertz' theory is inaccurate there, and the line pressure too"
    " low."
)
MESHED = (
    "Ranges cover the error of the mesh, from the same analysis with other numbers of elements, and the"
    " remaining unbalanced forces of all particles (residual and rounding)."
)
REDUNDANT = "Joints are redundant: rigid bodies do not determine how they share the load."
REACTIONS = 6  # joints whose reactions fit beside each other
FACTORS = 40  # load factors that a table shows, evenly
NAMED = 6  # load factors that are left out of a table and named
AXES = ("force_x", "force_y")


def document(summary: Json, limit: int = FACTORS) -> Document:
    """Return the long document of what :func:`vfife.report.summary.run_summary` returns; ``limit``: load
    factors.
    """
    model, run = summary["model"], summary["run"]
    title = [Paragraph(model["name"], style="strong"), *paragraphs([model["note"]], style="aside")]
    if run.get("analysis") == "static":
        warnings = [Caution(text) for text in (*summary["warnings"], *run["notes"])]
        # An unstable or missing equilibrium makes the tables useless.
        return Document([*title, *warnings, *equilibria(summary, limit)])
    leading = verdict(summary)
    first = [summary["warnings"][fall["index"]]] if (fall := summary.get("start_fall")) else []
    first.insert(0, motor_sentence(summary, remedy=True))
    title += paragraphs([leading, *first], style="alarm")
    notes = [Paragraph(text) for text in run["notes"]]
    body: list[Part] = [Facts(facts(summary)), *notes, *tables(summary), *paragraphs(footnotes(summary))]
    return Document(
        [*title, *body, *(Caution(text) for text in summary["warnings"] if text not in (leading, *first))]
    )


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
    stops = stop_sentence(summary.get("stops", {}), summary.get("stop_interval"))
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
        *(("Driver", f"{name}: {text} ({summary['part']})") for name, text in actuator_facts(summary)),
        *(("Driver", f"{name}: {text}") for name, text in effort_lines(summary)),
        *_machine(summary),
        *wear_facts(summary),
        *_named_once(
            "Blows",
            [
                f"{text} ({NOT_ESTIMATED}); no contact begins, so it is no knock"
                for text in blow_texts(summary).values()
            ],
        ),
        *([("Stops", stops)] if stops else []),
        *_named_once("Laws", [*law_lines, *facts_of(summary), *summary["remarks"]]),
    ]


def facts_of(summary: Json) -> list[str]:
    """Return the sentences on the laws and surfaces of the joints."""
    return [*summary["law_facts"], *summary["surface_facts"]]


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
        f", {run.get('crank_turns', run['turns']):.4g} turns" if run["turns"] is not None else ""
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
    unknown = f" (their errors are {NOT_ESTIMATED})" if summary["trust"] else ""
    return (
        f"whole run: {supplied_text(summary)}, lost {sum(losses.values()):.5g}"
        f" J{f' ({parts})' if parts else ''}, largest {largest:.5g} J{unknown}; ledger closes to"
        f" {summary['energy_error']:.1e} of it"
    )


def _torques(summary: Json) -> Iterator[str]:
    for name, body in summary["model"]["bodies"].items():
        if body["torque.max"] is not None:
            ideal = body["ideal_torque.max"]
            unknown = f" ({NOT_ESTIMATED})" if summary["trust"] else ""
            compared = f"; ideal {amount(ideal, 'N m')}{unknown}" if ideal is not None else ""
            measure = f"{name}.torque.max"
            torque = (
                torque_text(summary, measure)
                if has_range(summary, measure)
                else reaction(summary, measure, body["torque.max"])
            )
            yield f"{name}: largest torque {torque} ({summary['part']}){compared}"


def has_range(summary: Json, name: str) -> bool:
    """Return whether a largest value is shown as a range, because it is uncertain."""
    exact = summary["ranges"].get(name) is None or not is_estimated(summary, name)
    if exact or is_about_zero(summary, name) or is_undetermined(summary, name):
        return False
    return uncertainty(summary, name) > CERTAIN * abs(float(summary["measures"][name]))


def torque_text(summary: Json, name: str, unit: str = "N m") -> str:
    """Return the largest torque or force of a driver, with the same range as in the sentence on what is
    reliable.
    """
    if not has_range(summary, name):
        return largest_of_turns(summary, name, unit)
    bounds = summary["ranges"][name]
    text = interval(bounds["low"], bounds["high"], unit, uncertainty(summary, name))
    return over_turns(text, turns_text(summary, name, unit, CERTAIN))


def actuator_facts(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield name and text of each actuator: mean power, and largest force or torque."""
    friction = [measure for measure in summary["measures"] if measure.endswith(".friction_power.mean")]
    total = sum(summary["measures"][measure] for measure in friction)
    losses = f" ({sum_text(summary, friction, 'W')} friction)" if total else ""
    for name, actuator in summary.get("actuators", {}).items():
        measure, power = actuator["measure"], f"{name}.actuator_power.mean"
        texts = []
        if abs(summary["measures"].get(power, 0.0)) > ROUNDING * actuator["power"]:
            texts.append(f"mean power {value_text(summary, power, 'W')}{losses}")
            texts += reversed_power(summary, power)
        if measure in summary["measures"]:
            word = "force" if actuator["unit"] == "N" else "torque"
            ideal = actuator["ideal"]
            compared = "" if ideal is None else f" (ideal {prefixed(ideal, actuator['unit'])})"
            largest = torque_text(summary, measure, actuator["unit"])
            texts.append(f"largest {word} {largest}{compared}")
        yield name, ", ".join(texts)


def reversed_power(summary: Json, power: str) -> list[str]:
    """Return the words on a driver whose mean ``power``, a measure, is negative throughout its range."""
    if not is_negative(summary, power):
        return []
    bodies = summary["model"]["bodies"].values()
    drivers = len(summary.get("actuators", {})) + sum(body["torque.max"] is not None for body in bodies)
    return ["the loads or other drivers drive it" if drivers > 1 else "the loads drive the motor"]


def effort_facts(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield name and text of each driver that applies a torque or force, and the speed that it reached."""
    for name, effort in summary.get("efforts", {}).items():
        texts = [text for _, text, _ in _figures(effort)]
        yield f"Driver {name}", f"{', '.join(texts)} in {_span(effort)}{_pace(effort)} ({NOT_ESTIMATED})"
    for name, speed in summary["run"].get("reached", {}).items():
        low, high, end = (f"{speed[key]:.4g} rad/s" for key in ("low", "high", "end"))
        rpm = f"{30.0 * speed['end'] / math.pi:,.4g} rpm"
        yield f"Speed {name}", f"{end} ({rpm}) at the end, least {low}, largest {high} ({NOT_ESTIMATED})"


def effort_lines(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield name and text of each such driver, with what its figures miss between outputs."""
    for name, effort in summary.get("efforts", {}).items():
        figures = list(_figures(effort))
        yield name, f"{', '.join(text for _, text, _ in figures)} in {_span(effort)}{_pace(effort)}"
        missed = ", ".join(f"{word} {missed}" for word, _, missed in figures)
        yield name, f"what outputs miss: {missed}; change with the step {NOT_ESTIMATED}"


def _span(effort: Json) -> str:
    """Return the part of the run of which the figures are."""
    times = f"{effort['begin']:.4g} to {effort['end']:.4g} s"
    count, body = effort["turns"], effort["body"]
    turns = f"the last {count} turns" if count > 1 else "the last turn"
    return f"{turns} of {body}, {times}" if count else f"the second half of the run, {times}"


def _pace(effort: Json) -> str:
    """Return the mean power of the kinetic energy while a machine speeds up or slows down, and the power that
    this leaves for loads and losses; "" for a machine that does neither.
    """
    rise, power = effort.get("rise", {"value": 0.0})["value"], effort["power"]["value"]
    if abs(rise) <= STEADY * abs(power):
        return ""
    text = f", while kinetic energy {'takes' if rise > 0.0 else 'gives'} {prefixed(abs(rise), 'W')}"
    if (rest := effort["rest"]) is None:
        return text
    is_small = abs(rest["value"]) <= max(STEADY * abs(power), rest["missed"] or 0.0)
    return f"{text}, which leaves {'about 0 W' if is_small else _rounded(rest, 'W')}"


def effort_texts(effort: Json) -> dict[str, tuple[float, str]]:
    """Return value and text of each figure of a driver by its word; the part of the run has no value."""
    keys = ("power", "rms", "largest", "low", "high")
    return {"part": (0.0, f"{_span(effort)}{_pace(effort)}")} | {
        word: (effort[key]["value"], f"{text.removeprefix(word).lstrip()} ({NOT_ESTIMATED})")
        for key, (word, text, _) in zip(keys, _figures(effort), strict=True)
    }


def _figures(effort: Json) -> Iterator[tuple[str, str, str]]:
    """Yield word, text and what outputs miss of power, torque and speed."""
    word, unit, rate = ("force", "N", "m/s") if effort["linear"] else ("torque", "N m", "rad/s")
    for key, name, measure in (
        ("power", "mean power", "W"),
        ("rms", f"rms {word}", unit),
        ("largest", f"largest {word}", unit),
        ("low", "least speed", rate),
        ("high", "largest speed", rate),
    ):
        estimate = effort[key]
        yield name, f"{name} {_rounded(estimate, measure)}", _missed(estimate, measure)


def _rounded(estimate: Json, unit: str) -> str:
    """Return a value with the digits that the outputs leave."""
    words = amount if unit == "rad/s" else prefixed
    return words(estimate["value"], unit, 2.0 * (estimate["missed"] or 0.0))


def _missed(estimate: Json, unit: str) -> str:
    """Return what outputs miss of a value."""
    missed = estimate["missed"]
    if missed is None:
        return NOT_ESTIMATED
    if missed <= EXACT_SHARE * abs(estimate["value"]):
        return ONLY_ROUNDING
    words = amount if unit in ("J", "rad/s") and missed > SMALL else prefixed
    return f"up to {words(missed, unit, missed, UP)}"


def supplied_text(summary: Json) -> str:
    """Return the work of drivers, and that of loads and weight, up to the end of a run.

    The step keeps the works of torques and of loads in one sum. Of drivers whose work is not known the words
    name all that is in it.
    """
    energy = summary["energy"]
    total, work = energy["end"]["driver"] + energy["end"]["external"], energy.get("drivers")
    if work is None:
        return f"work of drivers, loads and weight together {total:.5g} J"
    width, rest = 2.0 * (work["missed"] or 0.0), total - work["value"]
    text = _missed(work, "J")
    missed = "" if text == ONLY_ROUNDING else f" (what outputs miss: {text})"
    parts = {f"drivers {_joule(work['value'], width)}{missed}": work["value"]}
    parts |= {f"loads and weight {_joule(rest, width)}": rest}
    texts = [text for text, value in parts.items() if abs(value) > max(LEAST_WORK * energy["largest"], width)]
    return f"work of {', of '.join(texts) or 'drivers, loads and weight 0 J'}" + (
        f", together {total:.5g} J" if len(texts) > 1 else ""
    )


def _joule(value: float, width: float) -> str:
    return amount(value, "J", width) if width else f"{value:.5g} J"


def _laws(laws: Json) -> str:
    """Return the laws of a joint, with what they derive from radii and materials."""
    derived = [(law["law"], quantities(law["derived"], law.get("units", {}))) for law in laws.values()]
    return "; ".join(name + (f" ({numbers})" if numbers else "") for name, numbers in derived)


def wear_facts(summary: Json) -> list[tuple[str, str]]:
    """Return a line on the surfaces that are worn already: their clearance is that without the wear."""
    texts = [
        f"{name} up to "
        + " and ".join(f"{prefixed(depth, 'm', direction=UP)} ({side})" for side, depth in depths.items())
        for name, joint in summary["joints"].items()
        if (depths := joint.get("worn"))
    ]
    return [("Worn surfaces", f"{'; '.join(texts)}, in addition to the clearance")] if texts else []


def _machine(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield the mean torque and power of the drivers, efficiency, and the shaking force on the ground."""
    measures, part = summary["measures"], summary["part"]
    for name in summary["model"]["bodies"]:
        if f"{name}.torque.mean" in measures:
            mean, ripple = measures[f"{name}.torque.mean"], measures.get(f"{name}.torque.ripple", 0.0)
            width = prefixed(ripple * abs(mean), "N m", uncertainty(summary, f"{name}.torque.max"))
            # The mean of a ratio over turns is no range of the torque over its mean.
            means = over_several_turns(summary["turns"])
            reach = f"ripple {ripple:,.4g} times the mean torque" if means else f"varying by {width}"
            swing = f", ripple {100.0 * ripple:,.4g} %{estimate_mark(summary, f'{name}.torque.ripple')}"
            swing = (
                ""
                if is_about_zero(summary, f"{name}.torque.max")
                else swing
                if ripple < RIPPLE
                else f", {reach}{estimate_mark(summary, f'{name}.torque.ripple')}"
            )
            torque, power = (
                value_text(summary, f"{name}.torque.mean", "N m"),
                value_text(summary, f"{name}.power.mean", "W"),
            )
            rms = f"{name}.torque.rms"
            square = f", rms torque {value_text(summary, rms, 'N m')}" if rms in measures else ""
            braking = "".join(f", {words}" for words in reversed_power(summary, f"{name}.power.mean"))
            yield (
                "",
                f"{name}: mean torque {torque}{swing if ripple else ''}{square}, mean power {power}{braking}"
                f" ({part})",
            )
        if (energy := f"{name}.energy_fluctuation") in measures:
            text = value_text(summary, energy, "J")
            yield "", f"{name}: energy fluctuation {text}, which a flywheel would take up ({part})"
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
    shown, rows = [*factors[: -1 : -(-len(factors) // limit)], *factors[-1:]], []
    for state in shown:
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
        Paragraph(done),
        noted(
            Table.numeric(heads, rows, "Equilibria, reactions on the journals", texts=0),
            _omitted_factors(factors, shown, limit),
        ),
        Table.numeric(("measure", "value", "range"), largest, "Largest values of all load factors"),
        Paragraph(
            MESHED if summary["trust"] else f"Errors are not estimated: {missing_mesh_estimate(summary)}."
        ),
    ]
    if summary["not_unique"]:
        shared = ", ".join(name.removesuffix(".max") for name in summary["not_unique"])
        parts.append(Paragraph(f"Shared by least norm, not unique: {shared}. {REDUNDANT}"))
    return parts


def _omitted_factors(factors: Sequence[Json], shown: Sequence[Json], limit: int) -> str:
    """Return which load factors a table of at most ``limit`` leaves out, by name if they are few, and where
    they are; "" if it has all.
    """
    omitted = [f"{state['load_factor']:g}" for state in factors if state not in shown]
    if not omitted:
        return ""
    named = f"load factor{'s' * (len(omitted) > 1)} {and_words(omitted)}"
    words = f"{len(omitted):,} load factors between these" if len(omitted) > NAMED else named
    place = "add --long, or vfife info RUN --long" if limit < FACTORS else "the run file has all"
    return f"Left out: {words}; {place}."
