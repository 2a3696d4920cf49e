"""Raw tables of a model file, as the TOML reader leaves them: walks that never fail, and which keys a table knows."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from typing import Any

from ..errors import Path, QuantityError
from ..laws import ContactLaw, FrictionLaw, Law
from ..units import number
from .schema import (
    BODY_TABLES,
    DRIVER_TABLES,
    JOINT_TABLES,
    SPRING_TABLES,
    GearTable,
    LoadTable,
    MaterialTable,
    MemberTable,
    ModelFile,
    RunTable,
    SectionTable,
    StartTable,
    Table,
    body_kind,
)

Raw = dict[str, Any]

# Keys of a link that say nothing about a link of this model.
IDLE_KEYS: dict[str, tuple[str, ...]] = {
    "rigid": ("elements", "release", "stiffness_factor"),
    "elastic": ("inertia", "center_at", "pins"),
    "two-particle": ("inertia", "center_at", "pins", "elements", "via"),
}
LAWS: dict[str, type[Law]] = {"contact": ContactLaw, "friction": FrictionLaw}
NAMED = ("material", "ground", "body", "joint", "gear", "spring", "driver", "load")


def table(raw: Any, *path: str | int) -> Raw:
    """The table at a path, empty if there is none."""
    for key in path:
        if isinstance(raw, list) and isinstance(key, int) and 0 <= key < len(raw):
            raw = raw[key]
        else:
            raw = raw.get(key) if isinstance(raw, dict) else None
    return raw if isinstance(raw, dict) else {}


def entries(raw: Raw, section: str) -> Iterator[tuple[str, Raw]]:
    """Names and tables of a section such as "body"; what is no table is left out."""
    return ((name, entry) for name, entry in table(raw, section).items() if isinstance(entry, dict))


def amount(holder: Raw, key: str, unit: str) -> float | None:
    """SI value of a key, None where it is missing or no such quantity (which the schema tells)."""
    try:
        return number(holder[key], unit) if key in holder else None
    except QuantityError:
        return None


def amounts(value: Any, units: Iterable[str]) -> tuple[float, ...] | None:
    """SI values of a list that has one for each of the units, None where it has not."""
    units = tuple(units)
    if not isinstance(value, list | tuple) or len(value) != len(units):
        return None
    try:
        return tuple(number(one, unit) for one, unit in zip(value, units, strict=True))
    except QuantityError:
        return None


def text(holder: Raw, key: str, default: str = "") -> str:
    """A text of a table, the default where there is none."""
    value = holder.get(key, default)
    return value if isinstance(value, str) else default


def own_pins(body: Raw) -> tuple[str, ...]:
    """Pins that a body of its kind has, whatever is wrong with it."""
    return {"<link>": ("start", "end"), "<frame>": ()}.get(body_kind(body), ("center",))


def pins(raw: Raw, body: str) -> tuple[str, ...]:
    """Pins of a body, or points of the ground."""
    if body == "ground":
        return tuple(table(raw, "ground"))
    holder = table(raw, "body", body)
    return (*own_pins(holder), *table(holder, "nodes" if body_kind(holder) == "<frame>" else "pins"))


def law_fields(law: type[Law]) -> tuple[str, ...]:
    """Parameters of a law."""
    return tuple(field.name for field in dataclasses.fields(law))


def keys_of(*models: type[Table]) -> tuple[str, ...]:
    """Keys that one of the tables has."""
    return tuple(dict.fromkeys(key for model in models for key in model.model_fields))


def known_keys(path: Path) -> tuple[str, ...] | None:
    """Keys that the table at a path can have, of whatever kind it is; None where keys are names that the user gives."""
    match path:
        case ():
            return keys_of(ModelFile)
        case ("run",):
            return keys_of(RunTable)
        case ("start",):
            return keys_of(StartTable)
        case ("material", _):
            return keys_of(MaterialTable)
        case ("body", _):
            return keys_of(*BODY_TABLES.values())
        case ("body", _, "section") | ("body", _, "members", _, "section"):
            return keys_of(SectionTable)
        case ("body", _, "members", _):
            return keys_of(MemberTable)
        case ("joint", _):
            return keys_of(*JOINT_TABLES.values())
        case ("joint", _, "contact" | "friction" as kind):
            fields = dict.fromkeys(name for law in LAWS[kind].registry.values() for name in law_fields(law))
            return ("law", *fields)
        case ("gear", _):
            return keys_of(GearTable)
        case ("spring", _):
            return keys_of(*SPRING_TABLES.values())
        case ("driver", _):
            return keys_of(*DRIVER_TABLES.values())
        case ("load", _):
            return keys_of(LoadTable)
    return None
