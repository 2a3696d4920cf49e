"""JSON Schema of model files for editors and validators: tables, keys with units and limits, and laws."""

from __future__ import annotations

import dataclasses
import inspect
import json
from collections.abc import Iterator
from typing import Any

from ..laws import Material
from ..laws.law import LAWS, built_in
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..model.readers import DEFAULTS
from ..schema import (
    Chosen,
    Entries,
    Field,
    FreeList,
    Inner,
    Value,
    default_of,
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
        value_type = value_of(field)
        schema: Json = (
            {"$ref": reference(value_type.model_class)}
            if isinstance(value_type, Inner)
            else value_type.json()
        )
        if isinstance(value_type, Entries):
            schema = {"type": "object", "additionalProperties": one_of(named_tables(key, definitions))}
        properties[key] = {**schema, "description": described(meaning_of(field), value_type)}
        if field.default is not dataclasses.MISSING:
            properties[key]["default"] = plain(field.default)
    materials = "materials by name, beside those of `vfife materials`"
    properties["material"] = {
        "type": "object",
        "additionalProperties": {"$ref": reference(Material)},
        "description": materials,
    }
    for model_class, header in (
        (Material, "[material.NAME]"),
        (Settings, "[run]"),
        (StartSettings, "[start]"),
    ):
        definitions[f"{model_class.__name__}Table"] = class_table(
            Table(model_class, complete=model_class is Material), header, definitions
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


def reference(model_class: type) -> str:
    """Return the reference to the table of a model class."""
    return f"#/definitions/{model_class.__name__}Table"


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
    for kind in tables(section):
        if built_in(kind.model_class):
            names.append(f"{kind.model_class.__name__}Table")
            header = f"[{section}.NAME]" + (
                f' with {kind.tag} = "{kind.word}"' if kind.tag and not kind.optional else ""
            )
            definitions[names[-1]] = class_table(kind, header, definitions)
    return names


def class_table(kind: Table, header: str, definitions: Json) -> Json:
    """Return the schema of the table of a model class."""
    properties: Json = {}
    if kind.tag:
        properties[kind.tag] = {
            "enum": [kind.word],
            "description": f"{kind.word}{', also if left out' if kind.optional else ''}",
        }
    for key, field in kind.fields.items():
        properties[key] = entry(field, kind.value(key), kind.is_linear)
        for inner in classes_in(kind.value(key)):
            if f"{inner.__name__}Table" not in definitions:
                definitions[f"{inner.__name__}Table"] = {}
                definitions[f"{inner.__name__}Table"] = class_table(Table(inner), "In a line", definitions)
    for key, (shape, meaning) in getattr(kind.model_class, "shapes", {}).items():
        properties[key] = {**shape.json(), "description": described(meaning, shape)}
    if getattr(kind.model_class, "tabled", False):
        properties[CSV] = CSV_FILE
    return closed(f"{header}: {summary(kind.model_class)}", properties, kind.needed)


def driver_table(target: str) -> Json:
    """Return the schema of drivers of a body, slider or point: the keys of all kinds."""
    keys = merged(target)
    properties = {}
    for key, (kind, must) in keys.items():
        properties[key] = entry(kind.fields[key], kind.value(key), kind.is_linear)
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


def summary(model_class: type) -> str:
    """Return the first paragraph of the docstring of a model class."""
    return " ".join((inspect.getdoc(model_class) or "").partition("\n\n")[0].replace("``", '"').split())


def classes_in(value_type: Value) -> Iterator[type]:
    """Yield the model classes whose tables may be in a value."""
    if isinstance(value_type, FreeList):
        yield from classes_in(value_type.part)
    elif isinstance(value_type, Inner):
        yield value_type.model_class


def entry(field: Field, value_type: Value, linear: bool = False) -> Json:
    """Return the schema of a key."""
    schema = {**value_type.json(), "description": described(meaning_of(field, linear), value_type)}
    default = field.default if isinstance(value_type, Chosen) else default_of(field)
    if isinstance(default, Material):
        schema["default"] = default.name
    elif default not in (None, dataclasses.MISSING, ""):
        schema["default"] = plain(default)
    return schema


def described(meaning: str, value_type: Value) -> str:
    """Return the meaning with units and limits."""
    units = [unit for unit in dict.fromkeys(value_type.units()) if unit]
    return f"{meaning} [{'; '.join(units)}]" if units else meaning


def plain(value: Any) -> Any:
    """Return a default as JSON data."""
    return [plain(part) for part in value] if isinstance(value, tuple) else value


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
