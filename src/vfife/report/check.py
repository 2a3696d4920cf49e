"""What is known of a mechanism before a run: bodies, joints and laws in plain numbers (SI), step and cost,
and the answer of ``vfife check``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..job.amounts import amount_of_bytes, span
from ..laws.materials import PAIRS, coefficient
from ..model.wear import deepest
from .document import Document, Paragraph, Part, Table, named, sentences

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..laws import Pair
    from ..model.drivers import Driver
    from ..model.joints import Joint
    from ..model.mechanism import Mechanism
    from ..model.wear import Wear

SIZES = ("axial_length", "friction_moment", "landing")  # of all joints with play, after their own
LIMITS = 3  # limits of the step that are shown at once
ROWS = 30  # of a table


@dataclass(frozen=True)
class Checked:
    """A mechanism without faults: ``free`` degrees of freedom with ideal joints, ``after_drives`` with the
    drivers at work, what is ``redundant``.

    ``step`` (s) is the one that a run begins with, ``set_by`` what sets it; ``notes`` are sentences on what
    to be careful with.
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
        counts = (
            f"{self.bodies} {'body' if self.bodies == 1 else 'bodies'}, {self.joints}"
            f" joint{'s' * (self.joints != 1)}"
        )
        lines = [
            f"{self.name}: no faults; {counts}.",
            (
                f"Degrees of freedom with ideal joints: {self.free}; {self.after_drives} with the drivers at"
                " work."
            ),
        ]
        if self.redundant:
            lines.append(
                f"Redundant constraints, at {', '.join(self.redundant)}: rigid links do not determine how"
                " these joints share their load."
            )
        if self.step > 0.0:
            lines.append(f"Step {self.step:.4g} s, set by {self.set_by}.")
        return "\n".join([*lines, *self.notes])

    __repr__ = __str__


def checked(assembly: Assembly, notes: Sequence[str] = ()) -> Checked:
    """Summarise an assembled mechanism, with further ``notes``."""
    mechanism, found = assembly.mechanism, freedom(assembly)
    return Checked(
        name=mechanism.name, bodies=len(mechanism.bodies), joints=len(mechanism.joints), free=found["free"],
        after_drives=found["after_drives"], redundant=tuple(found["redundant_joints"]) if found["redundant"] else (),
        step=assembly.choice.step, set_by=assembly.choice.culprit, notes=(*assembly.notes, *notes),
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------------------- numbers


def mechanism_parts(mechanism: Mechanism) -> list[Table]:
    """Tables of the bodies, joints, gears, springs, drivers and loads of a mechanism."""
    pairs: dict[str, Any] = {**mechanism.gears, **mechanism.springs}
    drivers = [
        (name, driver(one), one.body or one.slider or one.point) for name, one in mechanism.drivers.items()
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
            [(n, one.words, f"{one.first} and {one.second}") for n, one in pairs.items()],
            "Gears and springs",
        ),
        Table(("driver", "what", "of"), drivers, "Drivers"),
        Table(
            ("load", "what", "at"),
            [(name, one.words, one.place) for name, one in mechanism.loads.items()],
            "Loads",
        ),
    )
    return [table for table in tables if table.rows]


def bodies(assembly: Assembly) -> list[dict[str, Any]]:
    """Model, mass (kg), inertia about the centre of mass (kg m^2) and centre of mass (m) of each body."""
    drivers = assembly.mechanism.drivers
    return [
        {
            "name": name,
            "model": where.model,
            "elements": len(where.elements),
            "mass": where.mass,
            "inertia": where.inertia,
            "center": list(where.center),
            "driver": driver(drivers[name]) if name in drivers else None,
        }
        for name, where in assembly.bodies.items()
    ]


def driver(noun: Driver) -> str:
    """A driver in words."""
    return noun.words + (f", against {noun.against}" if noun.against != "ground" else "")


def joints(assembly: Assembly, expected: Mapping[str, float]) -> list[dict[str, Any]]:
    """Kind, sides, clearance (m), laws and expected force (N) of each joint."""
    contacts = assembly.mechanism.contacts
    found = []
    for name, joint in assembly.mechanism.joints.items():
        entry = {
            "name": name,
            "kind": joint.words + (", driven pivot" if name in assembly.pivots else ""),
            "bearing": joint.bearing,
            "journal": joint.journal,
            "expected_force": expected.get(name),
        }
        found.append(entry | (_contact(assembly, joint) if name in contacts else {}))
    return found


def _contact(assembly: Assembly, joint: Joint) -> dict[str, Any]:
    """Sizes and laws of a joint with play."""
    from ..model.surfaces import surfaces

    noun = assembly.mechanism.contacts[joint.name]
    pair = surfaces(assembly.mechanism, noun)
    sizes = {key: getattr(noun, key) for key in (*noun.sizes, *SIZES) if getattr(noun, key, None) is not None}
    found = sizes | {kind: _law(getattr(noun, kind), pair) for kind in ("contact", "friction")}
    found["contact"] |= {
        "modulus": pair.composite_modulus,
        "exponent": noun.contact.exponent_at(noun.landing, pair),
    }
    worn = {} if noun.wear is None else {"wear": _wear(noun.wear, pair)}
    return found | worn | {"bearing_material": pair.bearing.name, "journal_material": pair.journal.name}


def _wear(noun: Wear, pair: Pair) -> dict[str, dict[str, Any]]:
    """Of bearing and journal the coefficient of wear (1/Pa), the named pair of materials with its source, and
    the initial depth (m).
    """
    found: dict[str, dict[str, Any]] = {}
    for side in ("bearing", "journal"):
        chosen = getattr(noun, side)
        source = {"pair": chosen, "source": PAIRS[chosen][1]} if isinstance(chosen, str) else {}
        depth = {"worn": deepest(profile)} if (profile := getattr(noun, f"{side}_profile")) else {}
        found[side] = {"coefficient": coefficient(chosen, getattr(pair, side)), **source, **depth}
    return found


def couplings(assembly: Assembly) -> list[dict[str, str]]:
    """Gears, springs, and drivers that do not bear the name of the body they turn: name, what it is, what it
    acts on.
    """
    mechanism = assembly.mechanism
    pairs: dict[str, Any] = {**mechanism.gears, **mechanism.springs}
    found = [
        {"name": name, "what": one.words, "first": one.first, "second": one.second}
        for name, one in pairs.items()
    ]
    for name, noun in mechanism.drivers.items():
        if name not in mechanism.bodies:
            found.append(
                {
                    "name": name,
                    "what": f"driver: {driver(noun)}",
                    "first": noun.body or noun.slider or noun.point,
                    "second": "",
                }
            )
    return found


def _law(noun: Any, pair: Any) -> dict[str, Any]:
    """A law with its parameters and what is derived from them and the two surfaces."""
    parameters = {field.name: getattr(noun, field.name) for field in dataclasses.fields(noun)}
    return {
        "law": noun.name,
        "parameters": parameters,
        "derived": noun.derived(pair),
        "units": noun.units(pair),
    }


def step(assembly: Assembly) -> dict[str, Any]:
    """The step (s), what set it, and every limit."""
    choice = assembly.choice
    limits = dict(choice.limits)
    return {
        "size": choice.step,
        "automatic": choice.automatic,
        "set_by": choice.culprit,
        "stable": choice.stable,
        "limits": limits,
    }


def freedom(assembly: Assembly) -> dict[str, Any]:
    """Degrees of freedom of the ideal mechanism, redundant and singular joints, and the class of a four-bar."""
    from ..kinematics.mobility import grashof

    mobility = assembly.mobility
    return {
        "free": mobility.free,
        "after_drives": mobility.after_drives,
        "redundant": mobility.redundant,
        "redundant_joints": list(mobility.redundant_joints),
        "shared": list(assembly.shared),
        "singular": list(mobility.singular),
        "blocked": mobility.blocked,
        "four_bar": grashof(assembly.mechanism),
    }


# --------------------------------------------------------------------------------------------------------------- words


def document(found: Mapping[str, Any], long: bool = False) -> Document:
    """What would run and what it would cost; ``long``: with all defaults, limits and rows."""
    most = None if long else ROWS
    texts = (note.strip() for note in (found["note"], *found["notes"]) if note)
    parts: list[Part] = [
        Paragraph(f"  ({found['file']})", lead=found["model"]),
        *sentences(list(texts), style="caution"),
        Paragraph(""),
    ]
    parts += [*_bodies(found["bodies"], most), *_joints(found["joints"], most)]
    if found["couplings"]:
        rows = [
            (one["name"], one["what"], one["first"] + (f" and {one['second']}" if one["second"] else ""))
            for one in found["couplings"]
        ]
        parts.append(Table(("name", "what", "acts on"), rows))
    parts += [Paragraph(f"Law {name} of your own: {words}.") for name, words in found.get("laws", {}).items()]
    parts += sentences(
        [
            *freedom_words(found["degrees_of_freedom"]),
            *(_statics(found) if found["load_factors"] else _transient(found, long)),
        ]
    )
    if long:
        parts += _defaults(found["defaults"])
    elif found["defaults"]:
        parts.append(
            Paragraph(
                f"{len(found['defaults'])} values that the file does not give are taken by default; --long"
                " lists them."
            )
        )
    return Document(parts, data=found)


def _bodies(found: Sequence[Mapping[str, Any]], most: int | None) -> Iterator[Part]:
    rows = []
    for body in found[:most]:
        elements = f", {body['elements']} elements" if body["elements"] > 1 else ""
        center = f"({body['center'][0]:.6g}, {body['center'][1]:.6g})"
        numbers = (f"{body['mass']:.6g}", f"{body['inertia']:.6g}")
        rows.append((body["name"], body["model"] + elements, *numbers, center, body["driver"] or ""))
    yield Table(
        ("body", "model", "mass, kg", "inertia, kg m²", "centre of mass, m", "driver"), rows, numbers=(2, 3)
    )
    yield from _left_out(len(found), most, "bodies")


def _left_out(count: int, most: int | None, what: str) -> Iterator[Part]:
    if most is not None and count > most:
        yield Paragraph(f"and {count - most:,} more {what}; --long lists them.\n")


def _joints(found: Sequence[Mapping[str, Any]], most: int | None) -> Iterator[Part]:
    """Table of joints, then the laws of those with clearance; joints with the same laws share their lines."""
    rows, laws = [], dict[str, list[str]]()
    for joint in found:
        sizes = [f"{1e3 * joint[key]:.6g}" if key in joint else "" for key in ("clearance", "bearing_radius")]
        force = "" if joint["expected_force"] is None else f"{joint['expected_force']:.5g}"
        rows.append((joint["name"], joint["kind"], joint["bearing"], joint["journal"], *sizes, force))
        for kind in ("contact", "friction") if "contact" in joint else ():
            laws.setdefault(_law_words(kind, joint[kind]), []).append(joint["name"])
        for side, entry in joint.get("wear", {}).items():
            laws.setdefault(_wear_words(side, entry), []).append(joint["name"])
    heads = ("joint", "kind", "bearing", "journal", "clearance, mm", "radius, mm", "ideal force, N")
    yield Table(heads, rows[:most], numbers=(4, 5, 6))
    yield from _left_out(len(found), most, "joints")
    for text, names in laws.items():
        yield Paragraph(
            f"{', '.join(names[:most])}{'' if most is None or len(names) <= most else ', ...'}: {text}"
        )
    if laws:
        yield Paragraph("")


def _law_words(kind: str, entry: Mapping[str, Any]) -> str:
    """A law: its parameters, and what follows from them and the surfaces."""
    parameters = ", ".join(
        f"{name} {_points(value) or _shown(value)}"
        for name, value in entry["parameters"].items()
        if value is not None
    )
    derived = [text for text in (named(entry["derived"], entry["units"]),) if text]
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
    """How a surface wears, and how much it has."""
    pair = f", {entry['pair']} ({entry['source']}) over its hardness" if "pair" in entry else ""
    worn = f"; worn already, up to {1e6 * entry['worn']:.4g} µm" if "worn" in entry else ""
    return f"{side} wears by {entry['coefficient']:.4g} 1/Pa{pair}{worn}"


def _points(value: Any) -> str:
    """A curve by its number of points and its last one; nothing of other values."""
    curve = isinstance(value, list | tuple) and len(value) > 0 and isinstance(value[-1], list | tuple)
    return f"{len(value)} points up to {value[-1][1]:.4g} N at {value[-1][0]:.4g} m" if curve else ""


def freedom_words(found: Mapping[str, Any]) -> list[str]:
    """Degrees of freedom in sentences."""
    lines = [
        f"Degrees of freedom with ideal joints: {found['free']}; {found['after_drives']} with the drivers at"
        " work."
    ]
    if found["redundant"]:
        count, joints = found["redundant"], ", ".join(found["redundant_joints"])
        many = f"{count} redundant constraint{'s' * (count > 1)}, at {joints}"
        lines.append(f"{many}: rigid links do not determine how these joints share their load.")
    if found["shared"]:
        lines.append(f"Shared by least norm, not unique: {', '.join(found['shared'])}.")
    if found["singular"]:
        lines.append(
            "The start is a singular position (a change point or dead centre), at"
            f" {', '.join(found['singular'])}: beside it these hold something of their own. The branch that"
            " the motion takes from here is not determined; start a little aside."
        )
    if found["blocked"]:
        lines.append(
            "A motion that the joints allow leads nowhere: links lie in line, where no force along them holds"
            " anything across."
        )
    if found["four_bar"]:
        lines.append(f"Four-bar: {found['four_bar']}.")
    return lines


def _transient(found: Mapping[str, Any], long: bool) -> list[str]:
    """The step with its limits, and the cost, in sentences."""
    step = found["step"]
    endless = step["stable"] == float("inf")
    how = (
        f"chosen; set by {step['set_by']}"
        + ("; a run halves it while runs with other step sizes disagree" if step["searched"] else "")
        if step["automatic"]
        else "as given"
        if endless
        else f"as given; the stable one is set by {step['set_by']}"
    )
    turns = f" = {found['turns']:.6g} turns" if found["turns"] else ""
    until = f", or less: until turns repeat within {100.0 * found['settle']:.3g} %" if found["settle"] else ""
    limits = sorted(step["limits"].items(), key=lambda item: float(item[1]))
    shown = limits if long or len(limits) <= LIMITS + 1 else limits[:LIMITS]
    rest = [f"  and {len(limits) - len(shown)} larger ones (--long)"] if len(shown) < len(limits) else []
    stable = "There is no largest stable step: nothing here limits it but accuracy." if endless else ""
    return [
        f"Step {step['size']:.4g} s, {how}.",
        stable or f"The largest stable step is {step['stable']:.4g} s:",
        *(f"  {value:.4g} s  {name}" for name, value in shown),
        *rest,
        (
            f"{found['steps']:,} steps make {found['duration']:.6g} s{turns}{until}; an output every"
            f" {found['steps_between_outputs']:,} steps."
        ),
        *_cost(found),
    ]


def _statics(found: Mapping[str, Any]) -> list[str]:
    """Load factors and cost of a static analysis in sentences."""
    factors = found["load_factors"]
    again = (
        ", other numbers of elements with it"
        if found["repeated"]
        else "; errors of the mesh are not estimated"
    )
    time = (
        f"Time, a rough estimate: {span(found['estimate']['seconds'])}{again}; each equilibrium ends after"
        f" {found['iterations']:,} iterations."
    )
    what = f"equilibrium under load factor {factors[0]:g}"
    if len(factors) > 1:
        what = f"equilibria under {len(factors)} load factors from {factors[0]:g} to {factors[-1]:g}"
    return [f"Static analysis: {what}, by dynamic relaxation.", time, *_confirmation(found["estimate"])]


def _cost(found: Mapping[str, Any]) -> list[str]:
    from ..job.cost import BRIEF, MOST_TRIES

    cost = found["estimate"]
    pace, compiling = (
        f"{cost['ns_per_step']:.0f} ns a step, {cost['loop']} loop",
        span(cost["compile_seconds"]),
    )
    again = (
        f"; {span(MOST_TRIES * cost['seconds'])} if the step has to be halved twice"
        if found["step"]["searched"]
        else ""
    )
    again += "; half and a quarter of the step with it, for the errors" if found["repeated"] else ""
    lines = [
        f"Time, an estimate from a table of costs: {span(cost['seconds'])} ({pace}){again},",
        f"  and some {compiling} to compile that loop if it was never used here.",
        (
            f"The record takes {amount_of_bytes(cost['bytes'])}, which is packed to about half of it in the"
            " run file; to be read, it takes"
        ),
        f"  some {amount_of_bytes(cost['memory'])} of memory.",
    ]
    if cost["ideal_seconds"] > BRIEF:
        lines.append(
            f"The ideal mechanism alone takes {span(cost['ideal_seconds'])}: what forces its joints carry is"
            " told by the run."
        )
    return lines + _confirmation(cost)


def _confirmation(cost: Mapping[str, Any]) -> list[str]:
    """What vfife run wants to be confirmed."""
    return [f"That is {cost['asks_for_yes']}: vfife run wants --yes for it."] if cost["asks_for_yes"] else []


def _defaults(defaults: Sequence[Mapping[str, Any]]) -> Iterator[Part]:
    """Table of default values; bodies or joints that take the same value share a row."""
    alike: dict[tuple[str, str, str], list[str]] = {}
    for entry in defaults:
        section, _, rest = entry["path"].partition(".")
        name, _, key = rest.partition(".") if rest.count(".") else ("", "", rest)
        unit = "" if entry["unit"] == "1" else f" {entry['unit']}"
        same = (
            f"{section}.*.{key}" if name else entry["path"],
            f"{_shown(entry['value'])}{unit}",
            entry["meaning"],
        )
        alike.setdefault(same, []).append(name)
    rows = [
        (
            path.replace("*", names[0]) if len(names) == 1 else path,
            ", ".join(names) if len(names) > 1 else "",
            value,
            meaning,
        )
        for (path, value, meaning), names in alike.items()
    ]
    if rows:
        yield Table(("filled in", "of", "value", "meaning"), rows, "Not in the file, so taken by default")


def _shown(value: Any) -> str:
    """A default as a model file has it."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_shown, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
