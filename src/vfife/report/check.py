"""A mechanism before a run: bodies, joints and laws as numbers (SI), step and cost; the answer of ``vfife
check``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..job.progress import amount_of_bytes, counted, span
from ..laws.materials import PAIRS, coefficient
from ..model.bodies import MOST_ELEMENTS, Frame, Link
from ..model.lumping import rigid_properties
from ..model.surfaces import body_of, surface_words, surfaces
from ..model.wear import deepest
from ..solvers.refinement import DOUBLE, with_elements
from .digits import ABOUT_ZERO, RADIAL, is_ideal_zero
from .document import Document, Paragraph, Part, Table, grouped, paragraphs, quantities
from .freedom import degrees_of_freedom, freedom_words, redundancy
from .loads import load_words
from .run import facts_of

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..laws import Pair
    from ..model.drivers import Driver
    from ..model.joints import Joint
    from ..model.mechanism import Mechanism
    from ..model.wear import Wear

SIZES = ("axial_length", "friction_moment", "landing")  # of all joints with clearance, after their own
LIMITS = 3  # limits of the step that are shown at once
ROWS = 30  # of a table


@dataclass(frozen=True)
class Checked:
    """A valid mechanism: ``free`` degrees of freedom with ideal joints, ``after_drives`` with drivers,
    ``redundant`` joints.

    ``step`` (s) is the initial step of a run, ``set_by`` its cause; ``notes`` are cautions.
    """

    name: str
    bodies: int
    joints: int
    free: int
    after_drives: int
    redundant: tuple[str, ...]
    step: float
    set_by: str
    notes: tuple[str, ...]

    def __str__(self) -> str:
        counts = f"{self.bodies} {'body' if self.bodies == 1 else 'bodies'}, {counted(self.joints, 'joint')}"
        lines = [f"{self.name}: no faults; {counts}.", degrees_of_freedom(self.free, self.after_drives)]
        if self.redundant:
            lines.append(redundancy("Redundant constraints", self.redundant))
        if self.step > 0.0:
            lines.append(f"Step {self.step:.4g} s, set by {self.set_by}.")
        return "\n".join([*lines, *self.notes])

    __repr__ = __str__


def checked(assembly: Assembly, notes: Sequence[str] = ()) -> Checked:
    """Return the summary of an assembled mechanism, with further ``notes``."""
    mechanism, mobility = assembly.mechanism, assembly.mobility
    return Checked(
        name=mechanism.name, bodies=len(mechanism.bodies), joints=len(mechanism.joints), free=mobility.free,
        after_drives=mobility.after_drives,
        redundant=tuple(mobility.redundant_joints) if mobility.redundant else (),
        step=assembly.choice.step, set_by=assembly.choice.culprit, notes=(*assembly.notes, *notes),
    )  # fmt: skip


# ---------------------------------------------------------------------------------------------------- numbers


def mechanism_parts(mechanism: Mechanism) -> list[Table]:
    """Return tables of the bodies, joints, gears, springs, drivers and loads of a mechanism."""
    pairs: dict[str, Any] = {**mechanism.gears, **mechanism.springs}
    drivers = [
        (name, driver(drive), drive.body or drive.slider or drive.point)
        for name, drive in mechanism.drivers.items()
    ]
    tables = (
        Table(
            ("body", "model", "pins"),
            [(n, b.model, ", ".join(b.points)) for n, b in mechanism.bodies.items()],
            "Bodies",
        ),
        Table(
            ("joint", "what", "bearing", "journal"),
            [(n, j.words, j.bearing, j.journal) for n, j in mechanism.joints.items()],
            "Joints",
        ),
        Table(
            ("name", "what", "between"),
            [(n, pair.words, f"{pair.first} and {pair.second}") for n, pair in pairs.items()],
            "Gears and springs",
        ),
        Table(("driver", "what", "of"), drivers, "Drivers"),
        Table(
            ("load", "what", "at"),
            [(name, load.words, load.place) for name, load in mechanism.loads.items()],
            "Loads",
        ),
    )
    return [table for table in tables if table.rows]


def bodies(assembly: Assembly) -> list[dict[str, Any]]:
    """Return model, mass (kg), inertia about the centre of mass (kg m^2) and centre of mass (m) of
    each body.
    """
    drivers, excess = assembly.mechanism.drivers, inertia_excess(assembly)
    return [
        {
            "name": name,
            "model": body.model,
            "elements": len(body.elements),
            "mass": body.mass,
            "inertia": body.inertia,
            "center": list(body.center),
            "driver": driver(drivers[name]) if name in drivers else None,
            **({"inertia_excess": excess[name]} if name in excess else {}),
        }
        for name, body in assembly.bodies.items()
    ]


def inertia_excess(assembly: Assembly) -> dict[str, float]:
    """Return by which share (1) the inertia of the particles of elastic bodies exceeds that of infinitely
    many.

    The excess falls with the square of the number of elements, so that twice as many show it. Bent links,
    whose elements do not halve, are left out.
    """
    bodies = {
        name: body
        for name, body in assembly.mechanism.bodies.items()
        if isinstance(body, Frame) or (isinstance(body, Link) and body.model == "elastic" and not body.via)
    }
    excess = {}
    for name, body in bodies.items():
        finer = with_elements(body, DOUBLE)
        if finer is None or 2 * len(assembly.bodies[name].elements) > MOST_ELEMENTS:
            continue
        inertia, fine = assembly.bodies[name].inertia, rigid_properties(finer).inertia
        limit = (4.0 * fine - inertia) / 3.0
        if inertia > limit > 0.0:
            excess[name] = inertia / limit - 1.0
    return excess


def driver(driver: Driver) -> str:
    """Return the description of a driver."""
    return driver.words + (f", against {driver.against}" if driver.against != "ground" else "")


def joints(assembly: Assembly, expected: Mapping[str, float]) -> list[dict[str, Any]]:
    """Return kind, sides, clearance (m), laws and expected force (N) of each joint."""
    mechanism, entries = assembly.mechanism, []
    for name, joint in mechanism.joints.items():
        entry = {
            "name": name,
            "kind": joint.words + (", driven pivot" if name in assembly.pivots else ""),
            "bearing": joint.bearing,
            "journal": joint.journal,
            "expected_force": expected.get(name),
        }
        entries.append(entry | (_contact(mechanism, joint) if name in mechanism.contacts else {}))
    return entries


def _contact(mechanism: Mechanism, joint: Any) -> dict[str, Any]:
    """Return sizes and laws of a joint with clearance."""
    pair = surfaces(mechanism, joint)
    entry = {
        key: getattr(joint, key) for key in (*joint.sizes, *SIZES) if getattr(joint, key, None) is not None
    }
    entry |= {kind: _law(getattr(joint, kind), pair) for kind in ("contact", "friction")}
    entry["contact"] |= {
        "modulus": pair.composite_modulus,
        "exponent": joint.contact.exponent_at(joint.landing, pair),
    }
    if joint.wear is not None:
        entry["wear"] = _wear(joint, joint.wear, pair)
    return entry | {"bearing_material": pair.bearing.name, "journal_material": pair.journal.name}


def _wear(joint: Joint, wear: Wear, pair: Pair) -> dict[str, dict[str, Any]]:
    """Return the body, coefficient of wear (1/Pa), named pair of materials with its source, and initial
    depth (m) of bearing and journal.
    """
    sides: dict[str, dict[str, Any]] = {}
    for side in ("bearing", "journal"):
        value = getattr(wear, side)
        source = {"pair": value, "source": PAIRS[value][1]} if isinstance(value, str) else {}
        depth = {"worn": deepest(profile)} if (profile := getattr(wear, f"{side}_profile")) else {}
        number = coefficient(value, getattr(pair, side))
        sides[side] = {"body": body_of(joint, side), "coefficient": number, **source, **depth}
    return sides


def couplings(assembly: Assembly) -> list[dict[str, str]]:
    """Return name, kind and ends of gears, springs, and drivers whose name is not that of the body
    they turn.
    """
    mechanism = assembly.mechanism
    pairs: dict[str, Any] = {**mechanism.gears, **mechanism.springs}
    couplings = [(name, pair.words, pair.first, pair.second) for name, pair in pairs.items()]
    couplings += [
        (name, f"driver: {driver(drive)}", drive.body or drive.slider or drive.point, "")
        for name, drive in mechanism.drivers.items()
        if name not in mechanism.bodies
    ]
    return [dict(zip(("name", "what", "first", "second"), coupling, strict=True)) for coupling in couplings]


def _law(law: Any, pair: Any) -> dict[str, Any]:
    """Return a law with its parameters, and the numbers derived from them and the two surfaces."""
    parameters = {field.name: getattr(law, field.name) for field in dataclasses.fields(law)}
    return {"law": law.name, "parameters": parameters, "derived": law.derived(pair), "units": law.units(pair)}


def step(assembly: Assembly) -> dict[str, Any]:
    """Return the step (s) with its cause, and all limits."""
    choice = assembly.choice
    origin = {"automatic": choice.automatic, "set_by": choice.culprit}
    return {"size": choice.step, **origin, "stable": choice.stable, "limits": dict(choice.limits)}


# ------------------------------------------------------------------------------------------------------ words


def document(check: Mapping[str, Any], long: bool = False) -> Document:
    """Return the document of a check: mechanism, step and cost of a run; with all defaults, limits and rows
    if ``long``.
    """
    limit = None if long else ROWS
    texts = (note.strip() for note in (check["note"], *check["notes"]) if note)
    parts: list[Part] = [
        Paragraph(f"  ({check['file']})", lead=check["model"]),
        *paragraphs(list(texts), style="caution"),
        Paragraph(""),
    ]
    parts += [*_bodies(check["bodies"], limit), *_joints(check["joints"], limit)]
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
        parts.append(
            Paragraph(
                f"{len(check['defaults'])} values are not in the file and have their defaults; --long"
                " lists them."
            )
        )
    return Document(parts, data=check)


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
    from ..job.cost import BRIEF, MOST_TRIES, START

    cost = check["estimate"]
    besides = START + cost["measuring"]
    total = cost["seconds"] + besides
    pace, compiling = (
        f"{cost['ns_per_step']:.0f} ns a step, {cost['loop']} loop",
        span(cost["compile_seconds"]),
    )
    repetitions = (
        f"; {span(MOST_TRIES * cost['seconds'] + besides)} if the step has to be halved twice"
        if check["step"]["searched"]
        else ""
    )
    repetitions += "; half and a quarter of the step with it, for the errors" if check["repeated"] else ""
    lines = [
        f"Time, an estimate from a table of costs: {span(total)} ({pace}){repetitions};",
        (
            f"  {span(besides)} of it to start, to write and to measure, and about {compiling} more to"
            " compile that loop if it was never used here."
        ),
        (
            f"The results take {amount_of_bytes(cost['bytes'])}, compressed to about half of it in the run"
            f" file, which may grow to {amount_of_bytes(cost['disk_growth'] * cost['disk'])}."
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
