"""TOML text of a mechanism that reads back as an equal one, in SI units to the last bit."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..errors import Fault, ModelError
from ..files import path_of, replacement
from ..laws import Law, Material
from ..model.bodies import Frame
from ..model.drivers import Driver
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..model.readers import users_of
from ..model.validation import refuse_types
from ..options import with_faults
from ..schema import Chosen, Direction, Field, Named, default_of
from ..schema import Names as NamedValues
from .tables import Raw, Table, tables

Names = tuple[str, ...]
Entries = Mapping[str, Any]


def dump(mechanism: Mechanism) -> str:
    """Return the TOML text of a mechanism; ``loads`` returns an equal one.

    Values equal to their defaults, and values that the link model or analysis does not use, are left out.
    Raises ValueError if two different materials share a name, ModelError where a value is of another type,
    and TypeError for an object without a table.
    """
    lines = ["# All numbers are in SI units."]
    try:
        lines += assignments(heads(mechanism))
        for header, entries in contents(mechanism):
            lines += ["", f"[{dotted(*header)}]", *assignments(entries)]
    except (AttributeError, TypeError):
        refuse_types(mechanism)
        raise
    return "\n".join(lines) + "\n"


def tables_of(mechanism: Mechanism) -> Raw:
    """Return the tables that a TOML parser reads from :func:`dump`. Raises as that does."""
    raw: Raw = {key: plain(entry) for key, entry in heads(mechanism).items()}
    for header, entries in contents(mechanism):
        holder = raw
        for name in header:
            holder = holder.setdefault(name, {})
        holder |= {name: plain(entry) for name, entry in entries.items() if entry is not None}
    return raw


def plain(entry: Any) -> Any:
    """Return a value as a TOML parser returns it."""
    if isinstance(entry, bool | str | int):
        return entry
    if isinstance(entry, Material):
        return entry.name
    if dataclasses.is_dataclass(entry):
        return {name: plain(part) for name, part in vars(entry).items() if part is not None}
    return [plain(part) for part in entry] if isinstance(entry, tuple | list) else float(entry)


def heads(mechanism: Mechanism) -> Entries:
    """Return the entries before all tables."""
    top: dict[str, Any] = {"name": mechanism.name}
    if mechanism.note:
        top["note"] = mechanism.note
    if any(mechanism.gravity):
        top["gravity"] = mechanism.gravity
    return top


def contents(mechanism: Mechanism) -> Iterator[tuple[Names, Entries]]:
    """Yield headers and entries of the tables in reading order."""
    yield from item_tables(("run",), Table(Settings), mechanism.settings, brief=True)
    yield from item_tables(("start",), Table(StartSettings), mechanism.start, brief=True)
    for material in materials(mechanism):
        yield from item_tables(("material", material.name), Table(Material), material)
    if mechanism.points:
        yield ("ground",), mechanism.points
    for name, body in mechanism.bodies.items():
        yield from item_tables(
            ("body", name), table_of("body", name, body), body, {"model": body.model}, brief=True
        )
    fields = Table(Mechanism).fields
    for section in ("joint", "gear", "spring", "driver", "load"):
        for name, item in vars(mechanism)[fields[section].name].items():
            kind = table_of(section, name, item)
            tags = {} if kind.optional or not kind.tag else {kind.tag: kind.word}
            yield from item_tables(
                (section, name), kind, item, tags | aimed(name, item), brief=section == "load"
            )


def table_of(section: str, name: str, item: Any) -> Table:
    """Return the table of an object. Raises TypeError if there is none."""
    target = item.target if isinstance(item, Driver) else ""
    for kind in tables(section):
        if type(item) is kind.model_class and kind.target == target:
            return kind
    raise TypeError(f"{section} {name!r}: a model file has no table for {type(item).__name__}")


def aimed(name: str, item: Any) -> dict[str, Any]:
    """Return the entries of a driver on its target, if that is not the body of its name; {} for other
    objects.
    """
    if not isinstance(item, Driver) or item.target != "body":
        return {}
    return {
        "body": item.body if item.body != name else None,
        "against": item.against if item.against != "ground" else None,
    }


def item_tables(
    header: Names, kind: Table, item: Any, tags: Entries | None = None, *, brief: bool = False
) -> Iterator[tuple[Names, Entries]]:
    """Yield the table of an object and those within it; a ``brief`` one leaves out defaults.

    Laws are written with every parameter, so that a later change of a default does not affect the file.
    """
    entries, inner = dict(tags or {}), []
    for key, field in kind.fields.items():
        entry, value_type = getattr(item, field.name), kind.value(key)
        default = default_of(field)
        # A round beside another has a direction by default, and none in a file.
        if (
            key in entries
            or entry is None
            or unused(item, field)
            or ((brief or isinstance(value_type, Direction)) and entry == default)
        ):
            continue
        if isinstance(value_type, Named):
            if entry.name != "steel" or default is None:
                entries[key] = entry.name
        elif isinstance(value_type, Chosen):
            inner.append(((*header, key), law_entries(entry)))
        elif isinstance(value_type, NamedValues):
            inner += [((*header, key), entry)] if entry else []
        else:
            entries[key] = entry
    if entries or inner or header not in (("run",), ("start",)):
        yield header, entries
    yield from inner


def unused(item: Any, field: Field) -> bool:
    """Return whether the link model or analysis does not use a field."""
    word = getattr(item, getattr(item, "selected_by", ""), None)
    return bool(users_of(type(item), field, word))


def materials(mechanism: Mechanism) -> list[Material]:
    """Return all materials except the predefined steel, each once."""
    used: list[Material | None] = []
    for body in mechanism.bodies.values():
        used.append(body.material)
        used += [member.material for member in body.members] if isinstance(body, Frame) else []
    for joint in mechanism.contacts.values():
        used += [joint.bearing_material, joint.journal_material]
    materials_by_name: dict[str, Material] = {}
    for material in used:
        if material is not None and materials_by_name.setdefault(material.name, material) != material:
            raise ValueError(
                f"two different materials are called {material.name!r}; give one of them another name"
            )
    return [material for material in materials_by_name.values() if material != Material()]


def law_entries(law: Law) -> Entries:
    """Return name and parameters of a law."""
    return {"law": law.name, **vars(law)}


def assignments(entries: Entries) -> list[str]:
    """Return the lines of a table."""
    return [f"{key(name)} = {value(entry)}" for name, entry in entries.items() if entry is not None]


def value(entry: Any) -> str:
    """Return a value as TOML text; a nested object is an inline table."""
    if isinstance(entry, bool):
        return "true" if entry else "false"
    if isinstance(entry, str):
        return quoted(entry)
    if isinstance(entry, Material):
        return quoted(entry.name)
    if dataclasses.is_dataclass(entry):
        return "{ " + ", ".join(assignments(vars(entry))) + " }"
    if isinstance(entry, dict):
        return "{ " + ", ".join(assignments(entry)) + " }" if entry else "{}"
    if isinstance(entry, tuple | list):
        if entry and dataclasses.is_dataclass(entry[0]):
            return "[\n" + "".join(f"  {value(part)},\n" for part in entry) + "]"
        return "[" + ", ".join(value(part) for part in entry) + "]"
    if isinstance(entry, int):
        return str(entry)
    return repr(float(entry))


def quoted(text: str) -> str:
    """Return a basic string; JSON's escapes are those of TOML, except for one control character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def key(name: str) -> str:
    """Return a key, quoted if necessary."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else quoted(name)


def dotted(*names: str) -> str:
    """Return the header of a table."""
    return ".".join(key(name) for name in names)


@with_faults()
def save_model(mechanism: Mechanism, path: str | Path) -> None:
    """Write a model file that :func:`load_model` reads as an equal mechanism.

    mechanism: the mechanism
    path: the file (TOML); an existing one is replaced when the new one is complete

    Raises ModelError for a mechanism that no model file can contain, and if the file cannot be written.
    """
    path = path_of(path, "save_model")
    try:
        text = dump(mechanism)
    except (TypeError, ValueError) as error:
        raise ModelError(
            [Fault("mechanism", f"it cannot be written as a model file: {error}")], str(path)
        ) from None
    try:
        with replacement(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
    except OSError as error:
        remedy = "name a file in an existing, writable folder"
        raise ModelError(
            [Fault("file", f"it cannot be written ({error.strerror})", remedy=remedy)], str(path)
        ) from None
