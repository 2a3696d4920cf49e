"""Raw tables of a model file, as the TOML reader leaves them: walks that never fail, and which keys a table knows."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

from ..laws import ContactLaw, FrictionLaw, Law
from ..quantities import QuantityError, number
from ..schema import (
    ClearanceTable,
    DriverTable,
    IdealTable,
    LinkTable,
    LoadTable,
    MaterialTable,
    ModelFile,
    ParticleTable,
    RigidTable,
    RunTable,
    SectionTable,
    StartTable,
    body_kind,
)
from .faults import Path

Raw = dict[str, Any]

# Keys of a link that say nothing about a link of this model.
IDLE_KEYS: dict[str, tuple[str, ...]] = {
    "rigid": ("elements", "release", "stiffness_factor"),
    "elastic": ("inertia", "center_at", "pins"),
    "two-particle": ("inertia", "center_at", "pins", "elements"),
}
LAWS: dict[str, type[Law]] = {"contact": ContactLaw, "friction": FrictionLaw}
NAMED = ("material", "ground", "body", "joint", "driver", "load")


def table(raw: Any, *path: str) -> Raw:
    """The table at a path, empty if there is none."""
    for key in path:
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


def own_pins(body: Raw) -> tuple[str, ...]:
    """Pins that a body of its kind has, whatever is wrong with it."""
    return ("start", "end") if body_kind(body) == "<link>" else ("center",)


def pins(raw: Raw, body: str) -> tuple[str, ...]:
    """Pins of a body, or points of the ground."""
    if body == "ground":
        return tuple(table(raw, "ground"))
    holder = table(raw, "body", body)
    return (*own_pins(holder), *table(holder, "pins"))


def law_fields(law: type[Law]) -> tuple[str, ...]:
    """Parameters of a law."""
    return tuple(field.name for field in dataclasses.fields(law))


def known_keys(path: Path) -> tuple[str, ...] | None:
    """Keys that the table at a path can have, of whatever kind it is; None where keys are names that the user gives."""
    match path:
        case ():
            return tuple(ModelFile.model_fields)
        case ("run",):
            return tuple(RunTable.model_fields)
        case ("start",):
            return tuple(StartTable.model_fields)
        case ("material", _):
            return tuple(MaterialTable.model_fields)
        case ("body", _):
            return tuple({**LinkTable.model_fields, **RigidTable.model_fields, **ParticleTable.model_fields})
        case ("body", _, "section"):
            return tuple(SectionTable.model_fields)
        case ("joint", _):
            return tuple({**IdealTable.model_fields, **ClearanceTable.model_fields})
        case ("joint", _, "contact" | "friction" as kind):
            fields = dict.fromkeys(name for law in LAWS[kind].registry.values() for name in law_fields(law))
            return ("law", *fields)
        case ("driver", _):
            return tuple(DriverTable.model_fields)
        case ("load", _):
            return tuple(LoadTable.model_fields)
    return None
