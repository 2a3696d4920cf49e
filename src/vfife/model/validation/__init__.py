"""Validation of mechanisms: limits of all fields, references, and constraints or drivers that contradict each
other.

Model files and scripts get the same messages. An object with invalid fields is checked for everything else,
see :func:`~vfife.schema.partial`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ...errors import Fault, ModelError, Path, shown
from ...schema import Entries, Reader, Text, described_fields, key_of, value_of
from ..drivers import Driver
from .bodies import check_bodies
from .checks import Checks
from .drivers import check_drivers, check_tables
from .joints import check_gears, check_joints, check_ratio, check_sides, check_springs, check_strength
from .loads import check_alone, check_loads
from .settings import check_laws, check_name, check_names, check_settings

if TYPE_CHECKING:
    from ..mechanism import Mechanism


__all__ = ["Checks", "check_laws", "conflict_faults", "faults", "refuse_types", "validate"]


def validate(mechanism: Mechanism) -> None:
    """Raise ModelError with all faults of a mechanism, if it has any."""
    all_faults = faults(mechanism)
    if all_faults:
        raise ModelError(all_faults, str(mechanism.name) or "mechanism")


def refuse_types(mechanism: Mechanism) -> None:
    """Raise ModelError with all faults of a mechanism if a value is of another type or beyond its limits:
    nothing can be done with the name of a law in place of the law. Contradictions alone are not refused.
    """
    reader = Reader()
    read(mechanism, reader)
    if reader.faults:
        validate(mechanism)


def faults(mechanism: Mechanism) -> list[Fault]:
    """Return all faults of a mechanism: invalid fields, contradictions, and laws that do not suit their
    surfaces.
    """
    reader = Reader()
    partial_mechanism = read(mechanism, reader)
    checks = Checks(
        partial_mechanism,
        refusals={fault.path for fault in reader.faults},
        written=lambda path: written(mechanism, path),
    )
    # The settings of a static analysis are checked when it is assembled, where Python may give a driver a
    # speed.
    all_faults = reader.faults + conflict_faults(checks, settings=mechanism.settings.analysis != "static")
    return all_faults or check_laws(mechanism)


def conflict_faults(checks: Checks, settings: bool = True) -> list[Fault]:
    """Return the faults that involve more than one field; the mechanism may be known only in part.
    ``settings``: check those of the run too.
    """
    for check in (
        check_names,
        check_bodies,
        check_joints,
        check_gears,
        check_springs,
        check_drivers,
        check_loads,
    ):
        check(checks)
    if settings:
        check_settings(checks)
    return checks.faults


def read(mechanism: Mechanism, reader: Reader) -> Mechanism:
    """Return the mechanism with None for each invalid value."""
    values: dict[str, Any] = {}
    for field in described_fields(type(mechanism)):
        value, path, value_type = getattr(mechanism, field.name), (key_of(field),), value_of(field)
        if isinstance(value_type, Entries):
            values[field.name] = entries(value, path, value_type.base, reader)
        else:
            values[field.name] = value_type.read(value, path, reader)
    return dataclasses.replace(mechanism, **values)


def entries(value: Any, path: Path, base: type, reader: Reader) -> dict[str, Any]:
    """Return the objects of a section by name, with None for anything else."""
    if not isinstance(value, dict):
        reader.unexpected(path, value, "a dict of objects by name", "give one")
        return {}
    items = {}
    for name, item in value.items():
        linear = isinstance(item, Driver) and item.is_linear
        items[name] = (
            reader.fields((*path, name), item, linear)
            if isinstance(item, base)
            else reader.one_of((*path, name), base, item)
        )
    return items


def written(mechanism: Mechanism, path: Path) -> str:
    """Return the value at a path as a model file shows it; "" for a path that names an object or nothing."""
    value: Any = mechanism
    for part in path:
        if isinstance(value, dict):
            value = value.get(part)
        elif isinstance(part, int):
            value = value[part] if part < len(value) else None
        else:
            linear = isinstance(value, Driver) and value.is_linear
            keys = (
                {key_of(field, linear): field.name for field in dataclasses.fields(value)}
                if dataclasses.is_dataclass(value)
                else {}
            )
            value = getattr(value, keys[part]) if part in keys else None
    return "" if value is None or dataclasses.is_dataclass(value) else shown(value)


def faults_of(
    mechanism: Mechanism, section: str, name: str, item: Any, refusals: Iterable[Path] = ()
) -> list[Fault]:
    """Return the faults of an object (possibly known in part) that is to be added to a mechanism under a
    name; ``refusals`` are the paths of its invalid values.
    """
    path: Path = (section, name)
    field = next(field for field in described_fields(type(mechanism)) if key_of(field) == section)
    changes: dict[str, Any] = {field.name: {name: item}}
    holding = dataclasses.replace(mechanism, **changes)
    around = mechanism if section != "body" else dataclasses.replace(holding, drivers={}, joints={})
    checks = Checks(around, refusals, written=lambda path: written(holding, path))
    check_name(checks, path)
    if section == "body":
        check_bodies(checks)
    if section == "spring":
        check_strength(checks, path, item)
    elif section == "load":
        check_alone(checks, path, item)
    elif section == "driver":
        check_tables(checks, path, item)
    elif hasattr(item, "conflicts"):
        checks.conflicts(path, item)
    ends = references(checks, path, item)
    if section == "gear":
        check_ratio(checks, path, item)
    if section == "joint" and len(ends) == 2:
        check_sides(checks, path, item)
    return checks.faults


def references(checks: Checks, path: Path, item: Any) -> list[str]:
    """Return the names that an object refers to, and check their form; pins are checked if their
    body exists.
    """
    names = []
    for field in described_fields(type(item)):
        value_type, text = value_of(field), getattr(item, field.name)
        if (
            not isinstance(value_type, Text)
            or not value_type.refers
            or not text
            or checks.fails((*path, key_of(field)))
        ):
            continue
        names.append(text)
        at, body = (*path, key_of(field)), text.partition(".")[0]
        if value_type.refers == "pin" and (body in checks.bodies or not text.partition(".")[2]):
            checks.side(at, text)
        elif value_type.refers == "body" and "." in text:
            checks.body(at, text)
    return names
