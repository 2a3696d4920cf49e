"""Mechanism -> TOML text that reads back as an equal mechanism. All numbers are in SI units, to the last bit."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from ..bodies import Body, Link, PointMass, RigidBody, Section
from ..drivers import AngleTable, ConstantSpeed, Driver, Ramp, Torque
from ..joints import ClearanceRevolute, Joint
from ..laws import Law, Material
from ..loads import PointForce
from ..mechanism import Mechanism, Settings, Start
from .tables import IDLE_KEYS

Entries = Mapping[str, Any]

# Keys of the file that are called otherwise in the nouns.
KEYS = {"link_model": "model", "extra_points": "pins", "points": "pins"}


def dump(mechanism: Mechanism) -> str:
    """TOML text of a mechanism; ``loads`` makes an equal one of it.

    What equals its default is left out, and so is what a link's model has no use for. Raises ValueError where two
    different materials share a name, and TypeError for a noun that the file has no table for.
    """
    top: dict[str, Any] = {"name": mechanism.name}
    if mechanism.note:
        top["note"] = mechanism.note
    if any(mechanism.gravity):
        top["gravity"] = mechanism.gravity
    lines = ["# All numbers are in SI units.", *assignments(top)]
    for header, entries in tables(mechanism):
        lines += ["", f"[{header}]", *assignments(entries)]
    return "\n".join(lines) + "\n"


def tables(mechanism: Mechanism) -> Iterator[tuple[str, Entries]]:
    """Headers and entries of the tables, in the order a reader wants them."""
    for header, entries in (
        ("run", changed(mechanism.settings, Settings())),
        ("start", changed(mechanism.start, Start())),
    ):
        if entries:
            yield header, entries
    for material in materials(mechanism):
        yield dotted("material", material.name), {k: v for k, v in vars(material).items() if k != "name"}
    if mechanism.points:
        yield "ground", mechanism.points
    for name, body in mechanism.bodies.items():
        yield from body_tables(name, body)
    for name, joint in mechanism.joints.items():
        yield from joint_tables(name, joint)
    for name, driver in mechanism.drivers.items():
        yield dotted("driver", name), driver_entries(driver)
    for name, load in mechanism.loads.items():
        yield dotted("load", name), changed(load, PointForce(name=load.name, at=""), leave=("name",))


def changed(noun: Any, default: Any, leave: tuple[str, ...] = ()) -> dict[str, Any]:
    """Fields that differ from those of ``default``, under the keys of the file."""
    pairs = ((field.name, getattr(noun, field.name)) for field in dataclasses.fields(noun) if field.name not in leave)
    return {KEYS.get(name, name): value for name, value in pairs if value is not None and value != getattr(default, name)}


def materials(mechanism: Mechanism) -> list[Material]:
    """Every material but the predefined steel, once."""
    used = [body.material for body in mechanism.bodies.values()]
    for joint in mechanism.clearances.values():
        used += [one for one in (joint.bearing_material, joint.journal_material) if one is not None]
    known: dict[str, Material] = {}
    for material in used:
        if known.setdefault(material.name, material) != material:
            raise ValueError(f"two different materials are called {material.name!r}; give one of them another name")
    return [material for material in known.values() if material != Material()]


def body_tables(name: str, body: Body) -> Iterator[tuple[str, Entries]]:
    """The table of a body, and that of its pins."""
    nan = float("nan")  # differs from every number, so that what a body must have is always written
    if isinstance(body, Link):
        idle = [{"pins": "extra_points"}.get(key, key) for key in IDLE_KEYS[body.link_model]]
        entries = {
            "model": body.link_model,
            **changed(body, Link(name="", length=nan), leave=("name", "material", "link_model", *idle)),
        }
    elif isinstance(body, RigidBody):
        entries = {
            "model": "rigid",
            **changed(body, RigidBody(name="", mass=nan, inertia=nan), leave=("name", "material")),
        }
    elif isinstance(body, PointMass):
        entries = {"model": "particle", **changed(body, PointMass(name="", mass=nan), leave=("name", "material"))}
    else:
        raise TypeError(f"body {name!r}: a model file has no table for {type(body).__name__}")
    if body.material.name != "steel":
        entries["material"] = body.material.name
    points = entries.pop("pins", {})
    yield dotted("body", name), entries
    if points:
        yield dotted("body", name, "pins"), points


def joint_tables(name: str, joint: Joint) -> Iterator[tuple[str, Entries]]:
    """The table of a joint, and those of its laws with every parameter, so that a later default changes nothing."""
    ends = {"bearing": joint.bearing, "journal": joint.journal}
    if not isinstance(joint, ClearanceRevolute):
        yield dotted("joint", name), ends
        return
    skip = ("name", "bearing", "journal", "contact", "friction", "bearing_material", "journal_material")
    fields = {f.name: getattr(joint, f.name) for f in dataclasses.fields(joint) if f.name not in skip}
    for side in ("bearing_material", "journal_material"):
        material = getattr(joint, side)
        fields[side] = material.name if material is not None else None
    yield dotted("joint", name), {"kind": "clearance", **ends, **fields}
    for kind, law in (("contact", joint.contact), ("friction", joint.friction)):
        yield dotted("joint", name, kind), law_entries(law)


def law_entries(law: Law) -> Entries:
    """Name and parameters of a law."""
    return {"law": law.name, **vars(law)}


def driver_entries(driver: Driver) -> Entries:
    """Keys of a driver."""
    if isinstance(driver, ConstantSpeed):
        return {"speed": driver.speed}
    if isinstance(driver, Ramp):
        return {"speed": driver.speed, "ramp": driver.duration}
    if isinstance(driver, AngleTable):
        return {"times": driver.times, "angles": driver.angles}
    if isinstance(driver, Torque):
        return {"torque": driver.torque, "times": driver.times}
    raise TypeError(f"driver of {driver.body!r}: a model file has no table for {type(driver).__name__}")


def assignments(entries: Entries) -> list[str]:
    """Lines of a table."""
    return [f"{key(name)} = {value(entry)}" for name, entry in entries.items() if entry is not None]


def value(entry: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(entry, bool):
        return "true" if entry else "false"
    if isinstance(entry, str):
        return quoted(entry)
    if isinstance(entry, Section):
        return f"{{ area = {value(entry.area)}, second_moment = {value(entry.second_moment)} }}"
    if isinstance(entry, tuple | list):
        return "[" + ", ".join(value(one) for one in entry) + "]"
    if isinstance(entry, int):
        return str(entry)
    return repr(float(entry))


def quoted(text: str) -> str:
    """A basic string: JSON's escapes are TOML's, but for the one control character that JSON leaves."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def key(name: str) -> str:
    """A key, quoted if it has to be."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else quoted(name)


def dotted(*names: str) -> str:
    """Header of a table."""
    return ".".join(key(name) for name in names)
