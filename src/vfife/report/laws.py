"""Documents of laws and materials: the list of those that a model may name, and single laws."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from .document import Document, Paragraph, Part, Table, quantities

LIMITS = {"above": "above", "low": "at least", "high": "at most"}


def described() -> Iterator[dict[str, Any]]:
    """Yield a description of every law, contact laws first, by name."""
    from ..laws import ContactLaw, FrictionLaw
    from ..laws.law import built_in

    for kind, base in (("contact", ContactLaw), ("friction", FrictionLaw)):
        for name, law in sorted(base.registry.items()):
            yield {
                "name": name,
                "kind": kind,
                "own": not built_in(law),
                "source": law.source,
                "formula": law.formula,
                "parameters": [parameter(field) for field in dataclasses.fields(law)],
                "slots": list(law.slots),
            }


def parameter(field: dataclasses.Field[Any]) -> dict[str, Any]:
    """Return a description of a parameter of a law; a default of None is derived from the surfaces, a
    required value has none.
    """
    entry = {
        "name": field.name,
        "unit": field.metadata.get("unit", "1"),
        "meaning": field.metadata.get("meaning", ""),
    }
    entry |= {limit: field.metadata[limit] for limit in LIMITS if field.metadata.get(limit) is not None}
    return entry if field.default is dataclasses.MISSING else {**entry, "default": field.default}


def limits(entry: Mapping[str, Any]) -> str:
    """Return the limits of a parameter as text."""
    return ", ".join(f"{words} {entry[limit]:g}" for limit, words in LIMITS.items() if limit in entry)


def law_list(laws: Sequence[Mapping[str, Any]]) -> Document:
    """Return a document with one line for each law."""
    parts, width = list[Part](), max(len(law["name"]) for law in laws) + 2
    for kind in ("contact", "friction"):
        parts.append(Paragraph(f"{kind.capitalize()} laws", style="strong"))
        for law in laws:
            if law["kind"] == kind:
                source = "(your own) " * law["own"] + " ".join(law["source"].split())
                parts.append(Paragraph(source, lead=law["name"].ljust(width), style="code", lines="cut"))
    hint = (
        "Formula, parameters and limits of a law: vfife laws NAME; its behaviour in numbers and a figure:"
        " vfife laws NAME --plot."
    )
    return Document([*parts, Paragraph(hint)], data=laws)


def law_details(laws: Sequence[Mapping[str, Any]]) -> Document:
    """Return a document with source, formula and parameters of each law, and its numbers if computed."""
    return Document([part for law in laws for part in _law(law)], data=laws)


def _law(law: Mapping[str, Any]) -> Iterator[Part]:
    yield Paragraph(f"  ({law['kind']} law{', your own' if law['own'] else ''})", lead=law["name"])
    yield Paragraph(law["formula"], style="code", indent=2)
    yield Paragraph(law["source"], indent=2)
    if "compared" in law:
        yield Paragraph(f"Compared: {law['compared']}.", indent=2)
    if law["parameters"]:
        rows = [
            (
                parameter["name"],
                parameter["unit"],
                _default(parameter),
                limits(parameter),
                parameter["meaning"],
            )
            for parameter in law["parameters"]
        ]
        yield Table(("parameter", "unit", "default", "limits", "meaning"), rows)
    else:
        yield Paragraph("")
    if "picture" in law:
        derived = quantities(law["derived"], law["units"])
        yield Paragraph(f"For these surfaces: {derived}" if derived else "")
        yield from _numbers(law["numbers"])
        yield Paragraph(law["picture"], lead="Picture: ")


def _default(entry: Mapping[str, Any]) -> str:
    value = entry.get("default", "to be given")
    return "derived" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def _numbers(numbers: Mapping[str, Any]) -> Iterator[Part]:
    """Yield a contact law in free impacts, or a friction law in steady sliding."""
    if "impacts" in numbers:
        yield Paragraph(f"Free impact of {numbers['mass']:g} kg at {numbers['speed']:g} m/s")
        heads = (
            "restitution asked for",
            "delivered",
            "deepest, µm",
            "largest force, N",
            "time in contact, µs",
        )
        yield Table.numeric(heads, [_impact(impact) for impact in numbers["impacts"]], texts=0)
        return
    normal = numbers["normal_force"]
    yield Paragraph(f"Steady sliding under a normal force of {normal:g} N")
    rows = [
        (f"{state['speed']:g}", f"{state['force']:.5g}", f"{state['force'] / normal:.5f}")
        for state in numbers["steady"]
    ]
    yield Table.numeric(
        ("sliding velocity, m/s", "resisting force, N", "over the normal force"), rows, texts=0
    )
    if "breakaway" in numbers:
        yield Paragraph(
            "Pulled slowly from rest, it reaches 95 % of its largest force after"
            f" {1e6 * numbers['breakaway']:.4g} µm."
        )


def _impact(impact: Mapping[str, Any]) -> tuple[str, ...]:
    restitution = "-" if impact["restitution"] is None else f"{impact['restitution']:.2f}"
    depth, time = f"{1e6 * impact['deepest']:.4g}", f"{1e6 * impact['time']:.4g}"
    return restitution, f"{impact['delivered']:.4f}", depth, f"{impact['force']:,.5g}", time


def wear_coefficients() -> list[Part]:
    """Return a table of the wear coefficients of pairs of materials, and what oil and scatter do to them."""
    from ..laws.materials import ARCHARD, HARDNESS, OILED, PAIRS, SCATTER

    hardness = HARDNESS["steel"][0]
    rows = [(name, f"{k:.2g}", f"{k / hardness:.1g}") for name, (k, _) in PAIRS.items()]
    note = (
        f"Source: {ARCHARD}. Tests of the same pair differ by a factor of {SCATTER:g} in both directions;"
        f" with oil use {OILED:g} of these values or less. 1 mm³/(N m) is 1e-9 1/Pa."
    )
    title = 'Wear coefficients of the surface named first, dry: wear = { bearing = "brass on tool steel" }'
    heads = ("pair", "K", f"k of {1e-9 * hardness:.2g} GPa, 1/Pa")
    return [Table(heads, rows, title, numbers=(1, 2)), Paragraph(note)]


def materials() -> Document:
    """Return a document of the materials that a model may name, with the sources of their numbers.

    Data: name, Young's modulus (Pa), Poisson's ratio, density (kg/m^3), meaning, source, and hardness (Pa)
    with its source.
    """
    from ..laws.materials import HARDNESS, TABLE

    keys = ("youngs_modulus", "poissons_ratio", "density", "meaning", "source")
    entries: list[dict[str, Any]] = []
    for name, entry in TABLE.items():
        hardness, source = HARDNESS.get(name, (None, None))
        numbers = dict(zip(keys, entry, strict=True))
        entries.append({"name": name, **numbers, "hardness": hardness, "hardness_source": source})
    sources = list(
        dict.fromkeys(
            source
            for material in entries
            for source in (material["source"], material["hardness_source"])
            if source
        )
    )
    rows = []
    for material in entries:
        modulus = f"{1e-9 * material['youngs_modulus']:.4g}"
        ratio, density = (f"{material[key]:.4g}" for key in ("poissons_ratio", "density"))
        hard = "" if material["hardness"] is None else f"{1e-9 * material['hardness']:.3g}"
        cited = ", ".join(
            f"[{1 + sources.index(source)}]"
            for source in (material["source"], material["hardness_source"])
            if source
        )
        rows.append((material["name"], modulus, ratio, density, hard, material["meaning"], cited))
    heads = (
        "material",
        "Young's modulus, GPa",
        "Poisson's ratio",
        "density, kg/m³",
        "hardness, GPa",
        "description",
        "source",
    )
    note = "A table [material.NAME] in a model file adds a material or replaces one of these."
    notes = [Paragraph(f"[{number}] {source}") for number, source in enumerate(sources, 1)]
    parts: list[Part] = [Table(heads, rows, numbers=(1, 2, 3, 4)), *notes, Paragraph(""), Paragraph(note)]
    return Document([*parts, *wear_coefficients()], data=entries)
