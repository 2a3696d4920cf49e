"""JSON Schema of a model file, for editors and validators: the tables, with the units and limits of their keys, and the laws."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from typing import Any

from ..laws import Law
from ..model.readers import Choice, Measure
from .lawtables import DEFAULTS, SYMBOLIC
from .schema import ModelFile
from .tables import LAWS

Json = dict[str, Any]

DIALECT = "http://json-schema.org/draft-07/schema#"
IDENTITY = "urn:vfife:model"
TITLE = "Model file of vfife"


def model_schema() -> Json:
    """The schema, with what vfife brings as laws.

    Written in what drafts 4 and 7 have in common, because editors know no later one: no ``prefixItems``, ``const``, ``$defs``.
    """
    raw = ModelFile.model_json_schema()
    tables = {name: described(table) for name, table in sorted(raw.pop("$defs").items())}
    laws = {f"{kind}_law": {"oneOf": list(law_tables(kind))} for kind in LAWS}
    for kind in LAWS:
        for table in tables.values():
            if kind in table["properties"]:
                meaning = table["properties"][kind]["description"]
                table["properties"][kind] = {"description": meaning, "allOf": [{"$ref": f"#/definitions/{kind}_law"}]}
    top = described(raw)
    heads = {"$schema": DIALECT, "$id": IDENTITY, "title": TITLE, "description": top.pop("description")}
    top.pop("title", None)
    schema: Json = older({**heads, **top, "definitions": {**tables, **laws}})
    return schema


def text() -> str:
    """The schema as the package ships it."""
    return json.dumps(model_schema(), indent=1, ensure_ascii=False) + "\n"


def described(table: Json) -> Json:
    """A table whose keys say their units and limits, and no titles that repeat the keys."""
    for entry in table.get("properties", {}).values():
        entry.pop("title", None)
        units = [unit for unit in dict.fromkeys(units_of(entry)) if unit]
        if units:
            entry["description"] = f"{entry.get('description', '')} [{'; '.join(units)}]".strip()
    return table


def units_of(entry: Any) -> Iterator[str]:
    """Units and limits of a key, or of the parts of its value."""
    if isinstance(entry, list):
        for one in entry:
            yield from units_of(one)
    elif isinstance(entry, dict):
        if "x-unit" in entry:
            unit = "a number" if entry["x-unit"] == "1" else entry["x-unit"]
            yield f"{unit}, {entry['x-limits']}" if entry["x-limits"] else unit
        elif entry.get("type") == "integer":
            yield f"a whole number from {entry['minimum']} to {entry['maximum']}"
        else:
            for key in ("anyOf", "prefixItems", "items", "additionalProperties"):
                yield from units_of(entry.get(key))


def law_tables(kind: str) -> Iterator[Json]:
    """A table for each law of the package, in the order of their names; the default needs no name."""
    for name, law in sorted(LAWS[kind].registry.items()):
        if not law.__module__.startswith("vfife."):
            continue
        default = name == DEFAULTS[kind].name
        named = {"enum": [name], "description": f"name of the {kind} law{'; taken if left out' if default else ''}"}
        fields = {field.name: parameter(law, field) for field in dataclasses.fields(law)}
        needed = [field.name for field in dataclasses.fields(law) if field.default is dataclasses.MISSING]
        needed = needed if default else ["law", *needed]
        yield {
            "type": "object",
            "title": name,
            "description": f"{law.formula}. {law.source}",
            "properties": {"law": named, **fields},
            **({"required": needed} if needed else {}),
            "additionalProperties": False,
        }


def parameter(law: type[Law], field: dataclasses.Field[Any]) -> Json:
    """What a parameter of a law may be."""
    meta, default = field.metadata, field.default
    told: Json = {"description": str(meta.get("meaning", ""))}
    if default not in (None, dataclasses.MISSING):
        told["default"] = default
    if isinstance(default, bool):
        return {"type": "boolean", **told}
    if isinstance(default, str) or field.type in (str, "str"):
        words = meta.get("choices") or meta.get("options")
        return {**(Choice(tuple(words)).json() if words else {"type": "string"}), **told}
    unit = str(meta.get("unit", "1"))
    above, low, high = (meta.get(limit) for limit in ("above", "low", "high"))
    one = Measure("1" if SYMBOLIC.search(unit) else unit, above=above, low=low, high=high).json()
    told["description"] += f" [{', '.join(part for part in ('a number' if unit == '1' else unit, one['x-limits']) if part)}]"
    return {**one, "x-unit": unit, **told}


def older(entry: Any) -> Any:
    """The same in words of drafts 4 and 7; lists with a place for each value keep their length."""
    if isinstance(entry, list):
        return [older(one) for one in entry]
    if not isinstance(entry, dict):
        return entry
    result = {key: older(value) for key, value in entry.items() if key not in ("discriminator", "prefixItems")}
    if {"type": "null"} in result.get("anyOf", ()):  # a key is left out, never null
        kept = [one for one in result.pop("anyOf") if one != {"type": "null"}]
        result |= {"anyOf": kept} if len(kept) > 1 else kept[0] | result
    if "prefixItems" in entry:
        result |= {"items": older(entry["prefixItems"]), "additionalItems": False}
    if isinstance(entry.get("$ref"), str):
        result["$ref"] = entry["$ref"].replace("#/$defs/", "#/definitions/")
    if result.get("default", 0) is None:
        del result["default"]
    return result
