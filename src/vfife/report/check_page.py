"""The answer of ``vfife check``: tables of bodies, joints and laws, step and cost, from the numbers of
:mod:`~vfife.report.check`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..job.progress import amount_of_bytes, counted, span
from ..measures.catalogue import is_ideal_zero
from ..model.joints import Contact
from ..model.surfaces import surface_words
from .amounts import prefixed
from .digits import ABOUT_ZERO, RADIAL
from .document import Document, Paragraph, Part, Table, grouped, paragraphs, quantities
from .freedom import freedom_words
from .loads import load_words
from .run import facts_of

LIMITS = 3  # limits of the step that are shown at once


ROWS = 30  # of a table
SCREEN = 20  # lines of an answer, after which its beginning may have left the screen
HEAD = 3  # lines of a table without rows


def document(check: Mapping[str, Any], long: bool = False) -> Document:
    """Return the document of a check: mechanism, step and cost of a run; with all defaults, limits and rows
    if ``long``. Cautions come first, but at the end of an answer that is longer than a screen.
    """
    limit = None if long else ROWS
    notes = [note.strip() for note in check["notes"] if note]
    parts: list[Part] = [*_bodies(check["bodies"], limit), *_joints(check["joints"], limit)]
    if check["couplings"]:
        ends = [" and ".join(filter(None, (pair["first"], pair["second"]))) for pair in check["couplings"]]
        rows = [(pair["name"], pair["what"], end) for pair, end in zip(check["couplings"], ends, strict=True)]
        parts.append(Table(("name", "what", "acts on"), rows))
    parts += [Paragraph(f"{words}.") for words in map(load_words, check["loads"])]
    if check.get("unloaded"):
        parts.append(Paragraph("No loads: the model has neither a load, nor gravity, nor a spring."))
    parts += [Paragraph(f"Law {name} of your own: {words}.") for name, words in check.get("laws", {}).items()]
    parts += paragraphs(
        [
            *freedom_words(check["degrees_of_freedom"]),
            *(_statics(check) if check["load_factors"] else _transient(check, long)),
        ]
    )
    parts += _laws(check, limit)
    if long:
        parts += _defaults(check["defaults"])
    elif check["defaults"]:
        parts.append(Paragraph(_default_words(check["defaults"])))
    begin, end = notes, list[str]()
    if notes and _is_long(parts):
        begin, end = [f"{counted(len(notes), 'caution')} at the end of this answer."], notes
    head = [
        Paragraph(f"  ({check['file']})", lead=check["model"]),
        *paragraphs([note.strip() for note in (check["note"],) if note] + begin, style="caution"),
        Paragraph(""),
    ]
    return Document([*head, *parts, *paragraphs(end, style="caution")], data=check)


def _is_long(parts: Sequence[Part]) -> bool:
    """Return whether parts of an answer fill more than a screen, above which cautions scroll away."""
    lines = sum(len(part.rows) + HEAD if isinstance(part, Table) else 1 for part in parts)
    return lines > SCREEN


def _bodies(bodies: Sequence[Mapping[str, Any]], limit: int | None) -> Iterator[Part]:
    rows = []
    for body in bodies[:limit]:
        elements = f", {body['elements']} elements" if body["elements"] > 1 else ""
        center = f"({body['center'][0]:.6g}, {body['center'][1]:.6g})"
        numbers = (f"{body['mass']:.6g}", f"{body['inertia']:.6g}")
        rows.append((body["name"], body["model"] + elements, *numbers, center, body["driver"] or ""))
    yield Table(
        ("body", "model", "mass, kg", "inertia, kg m²", "centre of mass, m", "driver"), rows, numbers=(2, 3)
    )
    excess = {body["name"]: 100.0 * body["inertia_excess"] for body in bodies if "inertia_excess" in body}
    if shares := [f"{name} {share:.2g} %" for name, share in excess.items()][:limit]:
        yield Paragraph(
            f"Inertia of particles above that of the elastic body: {', '.join(shares)} (a quarter with twice"
            " the elements)."
        )
    yield from _left_out(len(bodies), limit, "bodies")


def _left_out(count: int, limit: int | None, parts: str) -> Iterator[Part]:
    if limit is not None and count > limit:
        yield Paragraph(f"and {count - limit:,} more {parts}; --long lists them.\n")


def _joints(joints: Sequence[Mapping[str, Any]], limit: int | None) -> Iterator[Part]:
    """Yield the table of joints."""
    rows, forces = [], [joint["expected_force"] for joint in joints]
    for joint in joints:
        sizes = [f"{1e3 * joint[key]:.6g}" if key in joint else "" for key in ("clearance", "bearing_radius")]
        ideal = joint["expected_force"]
        force = "" if ideal is None else ABOUT_ZERO if is_ideal_zero(ideal, forces) else f"{ideal:.5g}"
        rows.append((joint["name"], joint["kind"], joint["bearing"], joint["journal"], *sizes, force))
    heads = ("joint", "kind", "bearing", "journal", "clearance, mm", "radius, mm", "ideal force, N")
    yield Table(heads, rows[:limit], numbers=(4, 5, 6))
    yield from _left_out(len(joints), limit, "joints")
    if any("clearance" in joint for joint in joints):
        yield Paragraph(RADIAL)


def _laws(check: Mapping[str, Any], limit: int | None) -> Iterator[Part]:
    """Yield the laws of the joints with clearance, which joints may share, and facts about these."""
    laws: list[tuple[str, str]] = []
    for joint in check["joints"]:
        kinds = ("contact", "friction") if "contact" in joint else ()
        laws += [(_law_words(kind, joint[kind]), joint["name"]) for kind in kinds]
        laws += [(_wear_words(side, entry), joint["name"]) for side, entry in joint.get("wear", {}).items()]
    yield from [Paragraph("")] * bool(laws)
    for text, names in grouped(laws).items():
        remainder = "" if limit is None or len(names) <= limit else ", ..."
        yield Paragraph(f"{', '.join(names[:limit])}{remainder}: {text}")
    yield from paragraphs(facts_of(check))


def _law_words(kind: str, entry: Mapping[str, Any]) -> str:
    """Return a law with its parameters and derived numbers."""
    parameters = ", ".join(
        f"{name} {_points(value) or _shown(value)}"
        for name, value in entry["parameters"].items()
        if value is not None
    )
    derived = [text for text in (quantities(entry["derived"], entry["units"]),) if text]
    if "modulus" in entry:
        derived += [
            f"exponent {entry['exponent']:.4g}",
            f"composite modulus E* {1e-9 * entry['modulus']:.4g} GPa",
        ]
    return (
        f"{kind} {entry['law']}"
        + (f" ({parameters})" if parameters else "")
        + (f"; {', '.join(derived)}" if derived else "")
    )


def _wear_words(side: str, entry: Mapping[str, Any]) -> str:
    """Return the coefficient of wear of a surface, and its initial depth."""
    pair = f", {entry['pair']} ({entry['source']}) over its hardness" if "pair" in entry else ""
    initial = f"; worn already, up to {1e6 * entry['worn']:.4g} µm" if "worn" in entry else ""
    return f"{surface_words(entry['body'], side)} wears by {entry['coefficient']:.4g} 1/Pa{pair}{initial}"


def _points(value: Any) -> str:
    """Return number and last point of a curve as text; "" for other values."""
    curve = isinstance(value, list | tuple) and len(value) > 0 and isinstance(value[-1], list | tuple)
    return f"{len(value)} points up to {value[-1][1]:.4g} N at {value[-1][0]:.4g} m" if curve else ""


def _transient(check: Mapping[str, Any], long: bool) -> list[str]:
    """Return the step with its limits, and the cost, in sentences."""
    step = check["step"]
    endless = step["stable"] == float("inf")
    origin = (
        f"chosen; set by {step['set_by']}"
        + (
            "; a run halves it and starts again while companions with other step sizes disagree"
            if step["searched"]
            else ""
        )
        if step["automatic"]
        else "as given"
        if endless
        else f"as given; the stable step is set by {step['set_by']}"
    )
    turns = f" = {check['turns']:.6g} turns" if check["turns"] else ""
    turns += f" at full speed; the run-up leaves {check['crank_turns']:.6g}" if "crank_turns" in check else ""
    until = f", or less: until turns repeat within {100.0 * check['settle']:.3g} %" if check["settle"] else ""
    limits = sorted(step["limits"].items(), key=lambda item: float(item[1]))
    shown = limits if long or len(limits) <= LIMITS + 1 else limits[:LIMITS]
    left_out = [f"  and {len(limits) - len(shown)} larger ones (--long)"] if len(shown) < len(limits) else []
    stable = "There is no largest stable step: nothing here limits it but accuracy." if endless else ""
    return [
        f"Step {step['size']:.4g} s, {origin}.",
        stable or f"The largest stable step is {step['stable']:.4g} s:",
        *(f"  {value:.4g} s  {name}" for name, value in shown),
        *left_out,
        (
            f"{check['steps']:,} steps make {check['duration']:.6g} s{turns}{until}; an output every"
            f" {check['steps_between_outputs']:,} steps."
        ),
        *_cost(check),
    ]


def _statics(check: Mapping[str, Any]) -> list[str]:
    """Load factors and cost of a static analysis in sentences."""
    factors = check["load_factors"]
    repetitions = (
        ", with the repetitions on other meshes, which estimate its error"
        if check["repeated"]
        else "; errors of the mesh are not estimated"
    )
    time = (
        f"Time: about {span(check['estimate']['seconds'])}{repetitions}; a fifth or five times as long is"
        " possible, because the number of iterations until rest is unknown. An equilibrium ends after"
        f" {check['iterations']:,} iterations at the latest."
    )
    equilibria = f"equilibrium under load factor {factors[0]:g}"
    if len(factors) > 1:
        equilibria = f"equilibria under {len(factors)} load factors from {factors[0]:g} to {factors[-1]:g}"
    return [f"Static analysis: {equilibria}, by dynamic relaxation.", time, *_confirmation(check["estimate"])]


def _cost(check: Mapping[str, Any]) -> list[str]:
    from ..job.cost import BRIEF, LEAST_COMPRESSED, START

    cost = check["estimate"]
    besides = START + cost["measuring"]
    ends = cost["spread"] or (cost["seconds"] + cost["measuring"],)
    total = " to ".join(dict.fromkeys(span(START + end) for end in ends))
    pace, compiling = (
        f"{cost['ns_per_step']:.0f} ns a step, {cost['loop']} loop",
        span(cost["compile_seconds"]),
    )
    repetitions = (
        f", up to {span(START + cost['halved'])} if halved {cost['halvings']}" if cost["halved"] else ""
    )
    repetitions += "; half and a quarter of the step with it, for the errors" if check["repeated"] else ""
    lines = [
        f"Time, an estimate from a table of costs: {total} ({pace}){repetitions};",
        (
            f"  up to {span(besides)} of it to start, to write and to measure, and about {compiling} more to"
            " compile that loop if it was never used here."
        ),
        (
            f"The results take {amount_of_bytes(cost['bytes'])}, compressed in the run file"
            f" {amount_of_bytes(LEAST_COMPRESSED * cost['bytes'])} to"
            f" {amount_of_bytes(cost['disk_growth'] * cost['disk'])}, mostly below half of it."
        ),
        (
            f"  Loaded as one dataset, they take about {amount_of_bytes(cost['memory'])} of memory; run,"
            " info and export read them piece by piece."
        ),
    ]
    if cost["ideal_seconds"] > BRIEF:
        lines.append(
            f"The ideal mechanism alone takes {span(cost['ideal_seconds'])}; only the run computes the forces"
            " in its joints."
        )
    return lines + _confirmation(cost)


def _confirmation(cost: Mapping[str, Any]) -> list[str]:
    """Return the confirmation that a run requires."""
    return [f"That is {cost['asks_for_yes']}: vfife run needs --yes for it."] if cost["asks_for_yes"] else []


def _default_words(defaults: Sequence[Mapping[str, Any]]) -> str:
    """Return the number of default values, and the joints whose pressure and wear rest on one of them."""
    count = f"{len(defaults)} values are not in the file and have their defaults; --long lists them"
    paths = [entry["path"].split(".") for entry in defaults]
    names = [path[1] for path in paths if path[0] == "joint" and path[-1] == "axial_length"]
    if not names:
        return f"{count}."
    length = prefixed(Contact.axial_length, "m")
    of_joints = f"axial_length of {', '.join(names)}, {length}"
    return f"{count}. Among them is {of_joints}: pressure and wear depend on it."


def _defaults(defaults: Sequence[Mapping[str, Any]]) -> Iterator[Part]:
    """Yield the table of default values; bodies or joints that take the same value share a row."""
    alike: list[tuple[tuple[str, str, str], str]] = []
    for entry in defaults:
        section, _, field = entry["path"].partition(".")
        name, _, key = field.partition(".") if field.count(".") else ("", "", field)
        unit = "" if entry["unit"] == "1" else f" {entry['unit']}"
        default = (
            f"{section}.*.{key}" if name else entry["path"],
            f"{_shown(entry['value'])}{unit}",
            entry["meaning"],
        )
        alike.append((default, name))
    rows = [
        (
            path.replace("*", names[0]) if len(names) == 1 else path,
            ", ".join(names) if len(names) > 1 else "",
            value,
            meaning,
        )
        for (path, value, meaning), names in grouped(alike).items()
    ]
    if rows:
        yield Table(
            ("filled in", "of", "value", "meaning"), rows, "Defaults of values that are not in the file"
        )


def _shown(value: Any) -> str:
    """Return a default as a model file shows it."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_shown, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
