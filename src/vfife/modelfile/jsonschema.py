"""JSON Schema of model files for editors and validators: tables, keys with units and limits, and laws."""

from __future__ import annotations

import dataclasses
import inspect
import json
from collections.abc import Iterator
from typing import Any

from ..laws import Material
from ..laws.law import built_in
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..model.readers import DEFAULTS, LAWS
from ..schema import (
    Chosen,
    Entries,
    Field,
    FreeList,
    Inner,
    Value,
    described_fields,
    meaning_of,
    required,
    value_of,
)
from .reader import merged
from .tables import CSV, TARGETS, Table, tables

Json = dict[str, Any]

DIALECT = "http://json-schema.org/draft-07/schema#"
IDENTITY = "urn:vfife:model"
TITLE = "Model file of vfife"
CSV_FILE: Json = {
    "type": "string",
    "description": "a CSV file beside the model with the columns of a table, as in: angle (deg), force (kN)",
}
DRIVERS = "a speed, a travel, an amplitude, a table of values, a torque or a force"


def model_schema() -> Json:
    """Return the schema with all kinds and laws of the package.

    It uses what drafts 4 and 7 have in common, because editors support no later one: no ``prefixItems``,
    ``const``, ``$defs``.
    """
    definitions: Json = {}
    properties = {}
    for key, field in Table(Mechanism).fields.items():
        held = value_of(field)
        schema: Json = {"$ref": reference(held.noun)} if isinstance(held, Inner) else held.json()
        if isinstance(held, Entries):
            schema = {"type": "object", "additionalProperties": one_of(named_tables(key, definitions))}
        properties[key] = {**schema, "description": described(meaning_of(field), held)}
        if field.default is not dataclasses.MISSING:
            properties[key]["default"] = plain(field.default)
    materials = "materials by name, beside those of `vfife materials`"
    properties["material"] = {
        "type": "object",
        "additionalProperties": {"$ref": reference(Material)},
        "description": materials,
    }
    for noun, header in ((Material, "[material.NAME]"), (Settings, "[run]"), (StartSettings, "[start]")):
        definitions[f"{noun.__name__}Table"] = noun_table(
            Table(noun, complete=noun is Material), header, definitions
        )
    laws = {f"{kind}_law": {"oneOf": list(law_tables(kind))} for kind in LAWS}
    heads = {"$schema": DIALECT, "$id": IDENTITY, "title": TITLE, "description": "A model file."}
    ordered = {name: definitions[name] for name in sorted(definitions)}
    return {
        **heads,
        "type": "object",
        "properties": properties,
        "additionalProperties": False,
        "definitions": {**ordered, **laws},
    }


def text() -> str:
    """Return the schema as the package ships it."""
    return json.dumps(model_schema(), indent=1, ensure_ascii=False) + "\n"


def reference(noun: type) -> str:
    """Return the reference to the table of a model class."""
    return f"#/definitions/{noun.__name__}Table"


def one_of(names: list[str]) -> Json:
    """Return a schema of alternatives."""
    refs = [{"$ref": f"#/definitions/{name}"} for name in names]
    return refs[0] if len(refs) == 1 else {"oneOf": refs}


def named_tables(section: str, definitions: Json) -> list[str]:
    """Add the tables of a section to ``definitions`` and return their names."""
    names = []
    if section == "driver":
        for target in TARGETS:
            names.append(f"{target.capitalize()}DriverTable")
            definitions[names[-1]] = driver_table(target)
        return names
    for what in tables(section):
        if built_in(what.noun):
            names.append(f"{what.noun.__name__}Table")
            header = f"[{section}.NAME]" + (
                f' with {what.tag} = "{what.word}"' if what.tag and not what.optional else ""
            )
            definitions[names[-1]] = noun_table(what, header, definitions)
    return names


def noun_table(what: Table, header: str, definitions: Json) -> Json:
    """Return the schema of the table of a model class."""
    properties: Json = {}
    if what.tag:
        properties[what.tag] = {
            "enum": [what.word],
            "description": f"{what.word}{', also if left out' if what.optional else ''}",
        }
    for key, field in what.fields.items():
        properties[key] = entry(field, what.value(key), what.is_linear)
        for inner in nouns_in(what.value(key)):
            if f"{inner.__name__}Table" not in definitions:
                definitions[f"{inner.__name__}Table"] = {}
                definitions[f"{inner.__name__}Table"] = noun_table(Table(inner), "In a line", definitions)
    for key, (held, meaning) in getattr(what.noun, "shapes", {}).items():
        properties[key] = {**held.json(), "description": described(meaning, held)}
    if getattr(what.noun, "tabled", False):
        properties[CSV] = CSV_FILE
    return closed(f"{header}: {summary(what.noun)}", properties, what.needed)


def driver_table(target: str) -> Json:
    """Return the schema of drivers of a body, slider or point: the keys of all kinds."""
    keys = merged(target)
    properties = {}
    for key, (what, must) in keys.items():
        properties[key] = entry(what.fields[key], what.value(key), what.is_linear)
        if not must and key not in TARGETS[target]:
            properties[key].pop("default", None)
    properties[CSV] = CSV_FILE
    needed = tuple(key for key, (_, must) in keys.items() if must)
    return closed(f"[driver.NAME] of a {target}: {DRIVERS}", properties, needed)


def closed(description: str, properties: Json, needed: tuple[str, ...]) -> Json:
    """Return the schema of a table without other keys."""
    return {
        "type": "object",
        "description": description,
        "properties": properties,
        **({"required": list(needed)} if needed else {}),
        "additionalProperties": False,
    }


def summary(noun: type) -> str:
    """Return the first paragraph of the docstring of a model class."""
    return " ".join((inspect.getdoc(noun) or "").partition("\n\n")[0].replace("``", '"').split())


def nouns_in(held: Value) -> Iterator[type]:
    """Yield the model classes whose tables may be in a value."""
    if isinstance(held, FreeList):
        yield from nouns_in(held.part)
    elif isinstance(held, Inner):
        yield held.noun


def entry(field: Field, held: Value, along: bool = False) -> Json:
    """Return the schema of a key."""
    schema = {**held.json(), "description": described(meaning_of(field, along), held)}
    default = (
        field.default
        if field.default_factory is dataclasses.MISSING or isinstance(held, Chosen)
        else field.default_factory()
    )
    if isinstance(default, Material):
        schema["default"] = default.name
    elif default not in (None, dataclasses.MISSING, ""):
        schema["default"] = plain(default)
    return schema


def described(meaning: str, held: Value) -> str:
    """Return the meaning with units and limits."""
    units = [unit for unit in dict.fromkeys(held.units()) if unit]
    return f"{meaning} [{'; '.join(units)}]" if units else meaning


def plain(value: Any) -> Any:
    """Return a default as JSON data."""
    return [plain(one) for one in value] if isinstance(value, tuple) else value


def law_tables(kind: str) -> Iterator[Json]:
    """Yield the schema of each law of the package, by name; the default law needs no name."""
    for name, law in sorted(LAWS[kind].registry.items()):
        if not built_in(law):
            continue
        default = name == DEFAULTS[kind].name
        named = {
            "enum": [name],
            "description": f"name of the {kind} law{'; taken if left out' if default else ''}",
        }
        fields: tuple[Field, ...] = dataclasses.fields(law)
        needed = [field.name for field in fields if required(field)]
        needed = needed if default else ["law", *needed]
        properties = {"law": named, **{field.name: parameter(field) for field in described_fields(law)}}
        yield {**closed(f"{law.formula}. {law.source}", properties, tuple(needed)), "title": name}


def parameter(field: Field) -> Json:
    """Return the schema of a parameter of a law, whose unit may depend on the law's exponent."""
    schema = entry(field, value_of(field))
    unit = field.metadata["unit"]
    if "x-unit" in schema and schema["x-unit"] != unit:
        schema["x-unit"] = unit
        limits = [part for part in (unit, schema["x-limits"]) if part]
        schema["description"] = f"{meaning_of(field)} [{', '.join(limits)}]"
    return schema
