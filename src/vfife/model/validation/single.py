"""Checks of one object when a script adds it: everything that does not depend on objects added later."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ...errors import Fault, Path
from ...schema import Text, described_fields, key_of, value_of
from . import written
from .bodies import check_bodies
from .checks import Checks
from .drivers import check_tables
from .joints import check_strength
from .loads import check_alone
from .settings import check_name

if TYPE_CHECKING:
    from ..mechanism import Mechanism


def faults_of(
    mechanism: Mechanism, section: str, name: str, noun: Any, refusals: Iterable[Path] = ()
) -> list[Fault]:
    """Return the faults of an object (possibly known in part) that is to be added to a mechanism under a
    name; ``refusals`` are the paths of its invalid values.
    """
    path: Path = (section, name)
    field = next(field for field in described_fields(type(mechanism)) if key_of(field) == section)
    one: dict[str, Any] = {field.name: {name: noun}}
    holding = dataclasses.replace(mechanism, **one)
    around = mechanism if section != "body" else dataclasses.replace(holding, drivers={}, joints={})
    checks = Checks(around, refusals, written=lambda path: written(holding, path))
    check_name(checks, path)
    if section == "body":
        if name == "ground":
            checks.add(path, '"ground" is what does not move', "choose another name for the body")
        check_bodies(checks)
    if section == "spring":
        check_strength(checks, path, noun)
    elif section == "load":
        check_alone(checks, path, noun)
    elif section == "driver":
        check_tables(checks, path, noun)
    elif hasattr(noun, "conflicts"):
        for conflict in noun.conflicts():
            checks.take(path, conflict)
    ends = references(checks, path, noun)
    if section == "gear" and noun.ratio == 0.0:
        remedy = "give the teeth of the first over those of the second, negative for external gears"
        checks.add(
            (*path, "ratio"),
            "with a ratio of zero the second body would not turn at all",
            remedy,
            "any number but 0",
        )
    if section == "joint" and len(ends) == 2 and len({end.partition(".")[0] for end in ends}) == 1:
        checks.add(
            (*path, "journal"),
            "bearing and journal are on the same body",
            "name a pin of another body, or of the ground",
        )
    return checks.faults


def references(checks: Checks, path: Path, noun: Any) -> list[str]:
    """Return the names that an object refers to, and check their form; pins are checked if their
    body exists.
    """
    names = []
    for field in described_fields(type(noun)):
        held, text = value_of(field), getattr(noun, field.name)
        if not isinstance(held, Text) or not held.refers or not text or checks.fails((*path, key_of(field))):
            continue
        names.append(text)
        at, body = (*path, key_of(field)), text.partition(".")[0]
        if held.refers == "pin" and (body in checks.bodies or not text.partition(".")[2]):
            checks.side(at, text)
        elif held.refers == "body" and "." in text:
            checks.body(at, text)
    return names
