"""A validator of JSON Schema, of the words that the model file's schema uses; an unknown word is an error."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

TYPES = {
    "object": dict,
    "array": list,
    "string": str,
    "number": (int, float),
    "integer": int,
    "boolean": bool,
}
SILENT = {
    "$schema",
    "$id",
    "title",
    "description",
    "default",
    "definitions",
    "x-unit",
    "x-limits",
    "additionalItems",
}


def complaints(value: Any, schema: Any, root: Any, where: str = "") -> Iterator[str]:
    """What is wrong with a value, one text each."""
    for word, told in schema.items():
        if word not in SILENT:
            yield from globals()[f"check_{word.lstrip('$')}"](value, told, schema, root, where)


def fits(value: Any, schema: Any, root: Any) -> bool:
    return not any(True for _ in complaints(value, schema, root))


def check_ref(value: Any, told: str, schema: Any, root: Any, where: str) -> Iterator[str]:
    assert told.startswith("#/definitions/")
    yield from complaints(value, root["definitions"][told.rpartition("/")[2]], root, where)


def check_type(value: Any, told: str, schema: Any, root: Any, where: str) -> Iterator[str]:
    if not isinstance(value, TYPES[told]) or (isinstance(value, bool) and told != "boolean"):
        yield f"{where}: {value!r} is no {told}"


def check_enum(value: Any, told: list[Any], schema: Any, root: Any, where: str) -> Iterator[str]:
    if value not in told:
        yield f"{where}: {value!r} is none of {told}"


def check_minimum(value: Any, told: float, schema: Any, root: Any, where: str) -> Iterator[str]:
    if isinstance(value, int | float) and value < told:
        yield f"{where}: {value} is below {told}"


def check_maximum(value: Any, told: float, schema: Any, root: Any, where: str) -> Iterator[str]:
    if isinstance(value, int | float) and value > told:
        yield f"{where}: {value} is above {told}"


def check_minItems(value: Any, told: int, schema: Any, root: Any, where: str) -> Iterator[str]:
    if isinstance(value, list) and len(value) < told:
        yield f"{where}: {len(value)} items, not {told}"


def check_maxItems(value: Any, told: int, schema: Any, root: Any, where: str) -> Iterator[str]:
    if isinstance(value, list) and len(value) > told:
        yield f"{where}: {len(value)} items, not {told}"


def check_items(value: Any, told: Any, schema: Any, root: Any, where: str) -> Iterator[str]:
    for k, one in enumerate(value if isinstance(value, list) else []):
        if isinstance(told, dict) or k < len(told):
            yield from complaints(one, told if isinstance(told, dict) else told[k], root, f"{where}[{k}]")


def check_required(value: Any, told: list[str], schema: Any, root: Any, where: str) -> Iterator[str]:
    if isinstance(value, dict):
        yield from (f"{where}: {key} is missing" for key in told if key not in value)


def check_properties(value: Any, told: dict[str, Any], schema: Any, root: Any, where: str) -> Iterator[str]:
    if isinstance(value, dict):
        for key in told.keys() & value.keys():
            yield from complaints(value[key], told[key], root, f"{where}.{key}")


def check_patternProperties(value: Any, told: Any, schema: Any, root: Any, where: str) -> Iterator[str]:
    for pattern, part in told.items():
        for key in value if isinstance(value, dict) else ():
            if re.search(pattern, key):
                yield from complaints(value[key], part, root, f"{where}.{key}")


def check_additionalProperties(value: Any, told: Any, schema: Any, root: Any, where: str) -> Iterator[str]:
    patterns = schema.get("patternProperties", {})
    for key in (value.keys() - schema.get("properties", {}).keys()) if isinstance(value, dict) else ():
        if any(re.search(pattern, key) for pattern in patterns):
            continue
        if told is False:
            yield f"{where}: unknown key {key}"
        elif isinstance(told, dict):
            yield from complaints(value[key], told, root, f"{where}.{key}")


def check_anyOf(value: Any, told: list[Any], schema: Any, root: Any, where: str) -> Iterator[str]:
    if not any(fits(value, one, root) for one in told):
        yield f"{where}: {value!r} fits none of {len(told)}"


def check_allOf(value: Any, told: list[Any], schema: Any, root: Any, where: str) -> Iterator[str]:
    for one in told:
        yield from complaints(value, one, root, where)


def check_oneOf(value: Any, told: list[Any], schema: Any, root: Any, where: str) -> Iterator[str]:
    count = sum(fits(value, one, root) for one in told)
    if count != 1:
        yield f"{where}: {value!r} fits {count} of {len(told)}"
