"""Removal of parts of a mechanism, with what cannot exist without them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ...model.functions import turn_of
from ...modelfile.tables import NAMED, entries, kinds_of
from ...schema import Text, value_of
from .edit import Edit, refusal

SECTIONS = tuple(section for section in NAMED if section not in ("material", "ground"))
# A load along a guide or over the angle of a crank is not removed with them, because it took work to write.
WORK = ("slider", "crank")


class Reference(NamedTuple):
    """A key of a table whose value names a body, a pin or a joint."""

    section: str
    name: str
    key: str
    refers: str
    value: str


def references(raw: dict[str, Any]) -> Iterator[Reference]:
    """Yield all references between the tables of a model."""
    for section in SECTIONS:
        for name, holder in entries(raw, section):
            [*tables] = kinds_of(section, holder)
            for key, field in tables[0].fields.items():
                value = value_of(field, tables[0].is_linear)
                target = holder.get(key, name if (section, key) == ("driver", "body") else None)
                if isinstance(value, Text) and value.refers and isinstance(target, str) and target:
                    yield Reference(section, name, key, value.refers, target)


def delete(edit: Edit, section: str, name: str) -> None:
    """Delete a body, joint, gear, spring, driver or load, or a pin ``body.pin`` or ``ground.point``.

    With a body go the joints, gears, springs and drivers that hold it, and the forces on it. A load along a
    guide, or over the angle of a crank, keeps them from being deleted, as does whatever uses a pin.
    """
    if section == "pin":
        return _delete_pin(edit, name)
    if section not in SECTIONS:
        raise refusal(f"{section!r} cannot be deleted", f"name one of pin, {', '.join(SECTIONS)}")
    edit.entry(section, name)
    doomed, waiting = {(section, name): None}, [(section, name)]
    all_references = list(references(edit.raw))
    while waiting:
        part = waiting.pop()
        for reference in all_references:
            follower = reference.section, reference.name
            if follower not in doomed and _needs(reference, part):
                if reference.section == "load" and reference.key in WORK:
                    load = f"{reference.section}.{reference.name}"
                    raise refusal(
                        f"{load} needs {part[0]} {part[1]}",
                        f"delete {load} first, or let it name another {part[0]}",
                    )
                doomed[follower] = None
                waiting.append(follower)
    for kind, follower_name in doomed:
        del edit.raw[kind][follower_name]
        if not edit.raw[kind]:
            del edit.raw[kind]
    _count_time(edit, [follower_name for kind, follower_name in doomed if kind == "driver"])


def _needs(reference: Reference, part: tuple[str, str]) -> bool:
    """Return whether a reference names a part, or a pin of a body."""
    section, name = part
    if section == "joint":
        return reference.refers == "joint" and reference.value == name
    return (
        section == "body"
        and reference.refers in ("body", "pin")
        and reference.value.partition(".")[0] == name
    )


def _count_time(edit: Edit, drivers: list[str]) -> None:
    """Give a run that was counted in turns of a removed crank the same duration."""
    run, period = edit.raw.get("run", {}), turn_of(edit.mechanism)
    turning = [
        driver for name, driver in edit.mechanism.drivers.items() if name not in drivers and driver.moves
    ]
    if drivers and "turns" in run and period and not any(driver.target == "body" for driver in turning):
        run["duration"] = f"{float(run.pop('turns')) * period:.6g} s"


def _delete_pin(edit: Edit, pin: str) -> None:
    body, name = edit.side(pin)
    users = [
        f"{reference.section}.{reference.name}"
        for reference in references(edit.raw)
        if reference.refers == "pin" and reference.value == pin
    ]
    holder = edit.raw["ground"] if body == "ground" else edit.entry("body", body).get("pins", {})
    if users:
        raise refusal(f"{pin} is used by {' and '.join(users)}", "delete that first")
    if name not in holder:
        raise refusal(f"{name} belongs to every body of this kind", f"delete {body} as a whole")
    del holder[name]
    if not holder and body != "ground":
        del edit.raw["body"][body]["pins"]
