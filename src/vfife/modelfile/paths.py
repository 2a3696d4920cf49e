"""Paths into the tables of a model file: resolution, values set before validation, and what may be
at a path.
"""

from __future__ import annotations

import copy
import dataclasses
import tomllib
from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from typing import Any

from ..errors import Fault, Path, shown, suggestion
from ..laws import MATERIALS
from ..laws.law import LAWS
from ..model.readers import DEFAULTS
from ..schema import Chosen, FixedList, Inner, Names, Value
from .tables import (
    FAMILIES,
    NAMED,
    Raw,
    Slot,
    Table,
    body_table,
    entries,
    keys_at,
    kinds_of,
    law_fields,
    slots_at,
    table,
    tables,
)

WILDCARDS, MOST_LISTED = "*?", 12  # of a pattern; paths that a message lists


def override(raw: Raw, items: Iterable[tuple[str, Any]]) -> tuple[list[Fault], set[Path]]:
    """Set values in the tables; return the faults of their paths, and the paths set."""
    faults, paths_set = [], set()
    for text, value in items:
        try:
            path = resolve(raw, text)
            assign(raw, path, parsed(value) if isinstance(value, str) else copy.deepcopy(value))
            paths_set.add(path)
        except Fault as fault:
            faults.append(fault.at(f"path {shown(text)} (given by set)"))
    for path in paths_set:
        clear_idle(raw, path, paths_set)
    return faults, paths_set


def parsed(text: str) -> Any:
    """Return a TOML value if the text is one, such as 0.5, true and [1, 2], else the text, such as
    "0.5 mm".
    """
    try:
        values = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return values["value"] if list(values) == ["value"] else text


def resolve(raw: Raw, text: str) -> Path:
    """Return keys and indices of a dotted path; ``joint.BODY-BODY`` is the joint that connects the two
    bodies. Raises Fault for an unknown path.
    """
    parts: list[str | int] = [part.strip() for part in text.split(".")]
    if any(mark in text for mark in WILDCARDS):
        raise pattern_fault(raw, text)
    if not all(parts):
        raise Fault("", "a path is names joined by dots", remedy='write it as in "joint.C.clearance"')
    top = keys_at(()) or ()
    if parts[0] not in top:
        raise Fault(
            "", f"a model has no table or key {parts[0]!r} at the top of a model", remedy=nearest(raw, text)
        )
    if parts[0] in NAMED:
        if len(parts) < 2:
            raise Fault(
                "", f"a table, not a number of the model, is at {parts[0]}", remedy=nearest(raw, text)
            )
        parts[1] = entry(raw, str(parts[0]), str(parts[1]), text)
    for depth in range(1, len(parts)):
        parts[depth] = step(raw, tuple(parts[:depth]), str(parts[depth]), text)
    return tuple(parts)


def pattern_fault(raw: Raw, text: str) -> Fault:
    """Return the fault of a pattern where one number is meant, with the list of those that it fits."""
    matches = [path for path in leaves(raw, "") if fnmatchcase(path, text)][:MOST_LISTED]
    listed = ", ".join(map(shown, matches))
    remedy = f"list the paths, as in path = [{listed}]" if matches else nearest(raw, text)
    return Fault("", "a path names one number, not a pattern", shown(text), "", remedy)


def entry(raw: Raw, section: str, name: str, text: str) -> str:
    """Return the name that a part of a path refers to in a section."""
    if section == "material" and name in MATERIALS:
        material = MATERIALS[name]
        materials = raw.setdefault("material", {})
        if isinstance(materials, dict):
            materials.setdefault(
                name,
                {key: value for key, value in vars(material).items() if key != "name" and value is not None},
            )
    if name in table(raw, section):
        return name
    joints = [joint for joint, ends in connected(raw) if name in ends] if section == "joint" else []
    if len(joints) == 1:
        return joints[0]
    if joints:
        raise Fault(
            "",
            f"more than one joint connects {name}",
            remedy=f"name the one that is meant: {' or '.join(joints)}",
        )
    raise Fault("", f"there is no {section} {name!r}", remedy=nearest(raw, text))


def connected(raw: Raw) -> Iterator[tuple[str, tuple[str, str]]]:
    """Yield joints with the two ways to name each by its bodies."""
    for name, joint in entries(raw, "joint"):
        first, second = (str(joint.get(side, "")).partition(".")[0] for side in ("bearing", "journal"))
        yield name, (f"{first}-{second}", f"{second}-{first}")


def step(raw: Raw, parent: Path, part: str, text: str) -> str | int:
    """Return the key or index that ``part`` names in the value at ``parent``."""
    holder: Any = raw
    for key in parent:
        holder = holder.get(key, {}) if isinstance(holder, dict) else holder[key]
    location = ".".join(map(str, parent))
    if holder == {}:
        holder = list_at(raw, parent) or holder
    if isinstance(holder, list):
        if part.isascii() and part.isdigit() and len(part) < 7 and int(part) < len(holder):
            return int(part)
        raise Fault(
            "",
            f"{location} is a list of {len(holder)}",
            remedy=f"end the path in a number from 0 to {len(holder) - 1}",
        )
    if not isinstance(holder, dict):
        raise Fault("", f"{location} is a value, not a table", remedy=nearest(raw, text))
    keys = keys_at(parent)
    if part not in holder and (keys is None or part not in keys):
        raise Fault("", f"there is no {part!r} in {location}", remedy=nearest(raw, text))
    return part


def nearest(raw: Raw, text: str) -> str:
    """Return "did you mean" with similar paths of this model."""
    return suggestion(text, paths(raw), "name a number of the model by its path, such as run.turns")


def paths(raw: Raw) -> Iterator[str]:
    """Yield the paths of this model, and those that it could have."""
    yield from leaves(raw, "")
    for section in ("run", "start"):
        yield from (f"{section}.{key}" for key in keys_at((section,)) or ())
    for name, ends in connected(raw):
        yield from (f"joint.{ends[0]}.{key}" for key in table(raw, "joint", name))
    for section in ("joint", "body", "gear", "spring", "driver", "load"):
        for name, holder in entries(raw, section):
            # Only keys of its own kind: an ideal joint has no clearance.
            kinds = kinds_of(section, holder) if section in (*FAMILIES, "driver") else ()
            keys = kinds[0].keys if kinds else keys_at((section, name)) or ()
            yield from (f"{section}.{name}.{key}" for key in keys)
    yield from (key for key in keys_at(()) or () if not isinstance(raw.get(key), dict))


def leaves(value: Any, path: str, depth: int = 6) -> Iterator[str]:
    """Yield the paths of all values that are no tables."""
    if not isinstance(value, dict) or not depth:
        yield path
        return
    for key, inner in value.items():
        yield from leaves(inner, f"{path}.{key}" if path else key, depth - 1)


def assign(raw: Raw, path: Path, value: Any) -> None:
    """Set a value, making missing tables that the schema allows, and lists with their defaults."""
    holder: Any = raw
    for depth, key in enumerate(path[:-1], 1):
        if isinstance(holder, dict) and key not in holder:
            holder[key] = list_at(raw, path[:depth]) or {}
        holder = holder[key]
    holder[path[-1]] = value


def list_at(raw: Raw, path: Path) -> list[Any] | None:
    """Return the elements of a list of fixed length that a file may leave out: its default, zeros if that is
    None; None at any other path.
    """
    slot = slot_at(raw, path)
    if slot is None or not isinstance(slot.content, FixedList) or slot.field is None:
        return None
    default = slot.field.default
    if default is dataclasses.MISSING:
        return None
    return [0.0] * len(slot.content.parts) if default is None else list(default)


def clear_idle(raw: Raw, path: Path, paths_set: set[Path]) -> None:
    """After a change of model, kind or law, remove the keys that the new one does not use.

    So `body.coupler.model = rigid` suffices, although the file gives the coupler elements.
    """
    holder = table(raw, *path[:-1])
    value = holder.get(str(path[-1]))
    idle: Iterable[str] = ()
    if path[0] == "body" and path[2:] == ("model",):
        kind = body_table(holder)
        idle = [key for key in holder if kind.idle(key, holder)]
    elif path[0] in FAMILIES and path[2:] == ("kind",):
        chosen = [kind for kind in tables(str(path[0])) if kind.word == value]
        idle = set(keys_at((path[0], "")) or ()) - set(chosen[0].keys) if chosen else ()
    elif path[0] == "joint" and len(path) == 4 and path[3] == "law" and path[2] in LAWS:
        law = LAWS[str(path[2])].known().get(str(value))
        idle = set(holder) - {"law", *law_fields(law)} if law else ()
    for key in idle:
        if not any(have[: len(path)] == (*path[:-1], key) for have in paths_set):
            holder.pop(key, None)


def slot_at(raw: Raw, path: Path) -> Slot | None:
    """Return the most likely type at a path; None for a path that no model has."""
    return next(iter(slots_at(path, raw)), None)


def field_at(raw: Raw, path: Path) -> Value | None:
    """Return the type of the value at a path; None for a table and for a path that no model has."""
    slot = slot_at(raw, path)
    return (
        None
        if slot is None or isinstance(slot.content, Table | Inner | Chosen | FixedList | Names)
        else slot.content
    )


def default_at(raw: Raw, path: Path) -> Any:
    """Return the value (SI) at a path where a file leaves it out; None where there is none."""
    slot = slot_at(raw, path)
    if path[-1] == "law" and (law_slot := slot_at(raw, path[:-1])) and isinstance(law_slot.content, Chosen):
        return DEFAULTS[law_slot.content.word].name
    return (
        None
        if slot is None or slot.field is None or slot.field.default is dataclasses.MISSING
        else slot.field.default
    )
