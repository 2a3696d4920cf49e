"""Mechanism -> TOML text that reads back as an equal mechanism. All numbers are in SI units, to the last bit."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from ..laws import Law, Material
from ..model.bodies import Body, Frame, Link, Member, PointMass, RigidBody, Section
from ..model.drivers import AngleTable, ConstantSpeed, Driver, Harmonic, Ramp, StepTo, Torque
from ..model.joints import Contact, ExternalContact, Gear, IdealRevolute, Joint
from ..model.loads import PointForce
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..model.springs import AnySpring, Spring
from .build import JOINTS, SPRINGS
from .schema import STATIC_ONLY
from .tables import IDLE_KEYS

Entries = Mapping[str, Any]

# Keys of the file that are called otherwise in the nouns.
KEYS: dict[str, str] = {}
NAN = float("nan")  # differs from every number, so that what a noun must have is always written


def dump(mechanism: Mechanism) -> str:
    """TOML text of a mechanism; ``loads`` makes an equal one of it.

    What equals its default is left out, and so is what a link's model or the kind of analysis has no use for. Raises ValueError
    where two different materials share a name, and TypeError for a noun that the file has no table for.
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
    idle = () if mechanism.settings.analysis == "static" else STATIC_ONLY
    for header, entries in (
        ("run", changed(mechanism.settings, Settings(), leave=idle)),
        ("start", changed(mechanism.start, StartSettings())),
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
    for name, gear in mechanism.gears.items():
        yield dotted("gear", name), changed(gear, Gear(name=name, first="", second="", ratio=NAN), leave=("name",))
    for name, spring in mechanism.springs.items():
        yield dotted("spring", name), spring_entries(name, spring)
    for name, driver in mechanism.drivers.items():
        yield dotted("driver", name), driver_entries(name, driver)
    for name, load in mechanism.loads.items():
        yield dotted("load", name), changed(load, PointForce(name=load.name, at=""), leave=("name",))


def changed(noun: Any, default: Any, leave: tuple[str, ...] = ()) -> dict[str, Any]:
    """Fields that differ from those of ``default``, under the keys of the file."""
    pairs = ((field.name, getattr(noun, field.name)) for field in dataclasses.fields(noun) if field.name not in leave)
    return {KEYS.get(name, name): value for name, value in pairs if value is not None and value != getattr(default, name)}


def materials(mechanism: Mechanism) -> list[Material]:
    """Every material but the predefined steel, once."""
    used: list[Material | None] = []
    for body in mechanism.bodies.values():
        used.append(body.material)
        used += [member.material for member in body.members] if isinstance(body, Frame) else []
    for joint in mechanism.contacts.values():
        used += [joint.bearing_material, joint.journal_material]
    known: dict[str, Material] = {}
    for material in used:
        if material is not None and known.setdefault(material.name, material) != material:
            raise ValueError(f"two different materials are called {material.name!r}; give one of them another name")
    return [material for material in known.values() if material != Material()]


def body_tables(name: str, body: Body) -> Iterator[tuple[str, Entries]]:
    """The table of a body, and those of its pins, nodes and masses."""
    leave: tuple[str, ...] = ("name", "material")
    default: Body
    if isinstance(body, Link):
        leave = (*leave, "model", *IDLE_KEYS.get(body.model, ()))
        default = Link(name="", length=NAN)
    elif isinstance(body, RigidBody):
        default = RigidBody(name="", mass=NAN, inertia=NAN)
    elif isinstance(body, PointMass):
        default = PointMass(name="", mass=NAN)
    elif isinstance(body, Frame):
        default = Frame(name="", nodes={}, members=())
    else:
        raise TypeError(f"body {name!r}: a model file has no table for {type(body).__name__}")
    entries = {"model": body.model, **changed(body, default, leave)}
    if body.material.name != "steel":
        entries["material"] = body.material.name
    inner = {key: entries.pop(key, {}) for key in ("pins", "nodes", "masses")}
    yield dotted("body", name), entries
    for key, points in inner.items():
        if points:
            yield dotted("body", name, key), points


def joint_tables(name: str, joint: Joint) -> Iterator[tuple[str, Entries]]:
    """The table of a joint, and those of its laws with every parameter, so that a later default changes nothing."""
    kind = next((kind for kind, noun in JOINTS.items() if type(joint) is noun), None)
    if kind is None:
        raise TypeError(f"joint {name!r}: a model file has no table for {type(joint).__name__}")
    said = {} if isinstance(joint, IdealRevolute) else {"kind": kind}
    skip = ("name", "contact", "friction", "bearing_material", "journal_material")
    fields = {f.name: getattr(joint, f.name) for f in dataclasses.fields(joint) if f.name not in skip}
    if isinstance(joint, ExternalContact) and joint.bearing_radius is not None:
        del fields["direction"]  # of a line, and there is none
    if not isinstance(joint, Contact):
        yield dotted("joint", name), said | fields
        return
    for side in ("bearing_material", "journal_material"):
        material = getattr(joint, side)
        fields[side] = material.name if material is not None else None
    yield dotted("joint", name), said | fields
    for slot, law in (("contact", joint.contact), ("friction", joint.friction)):
        yield dotted("joint", name, slot), law_entries(law)


def law_entries(law: Law) -> Entries:
    """Name and parameters of a law."""
    return {"law": law.name, **vars(law)}


def spring_entries(name: str, spring: AnySpring) -> Entries:
    """Keys of a spring."""
    kind = next((kind for kind, noun in SPRINGS.items() if type(spring) is noun), None)
    if kind is None:
        raise TypeError(f"spring {name!r}: a model file has no table for {type(spring).__name__}")
    fields = {key: value for key, value in vars(spring).items() if key != "name"}
    return fields if isinstance(spring, Spring) else {"kind": kind, **fields}


def driver_entries(name: str, driver: Driver) -> Entries:
    """Keys of a driver: what it drives, unless that is the body of its name, and how."""
    linear = bool(driver.slider or driver.point)
    entries: dict[str, Any] = {
        "slider": driver.slider or None,
        "point": driver.point or None,
        "direction": driver.direction if driver.point else None,
        "body": driver.body if not linear and driver.body != name else None,
        "against": driver.against if not linear and driver.against != "ground" else None,
    }
    places = "travels" if linear else "angles"
    if isinstance(driver, ConstantSpeed):
        return entries | {"speed": driver.speed}
    if isinstance(driver, Ramp):
        return entries | {"speed": driver.speed, "ramp": driver.duration}
    if isinstance(driver, StepTo):
        return entries | {"travel": driver.travel, "duration": driver.duration, "begin": driver.begin}
    if isinstance(driver, Harmonic):
        return entries | {"amplitude": driver.amplitude, "frequency": driver.frequency, "phase": driver.phase}
    if isinstance(driver, AngleTable):
        return entries | {"times": driver.times, places: driver.values}
    if isinstance(driver, Torque):
        effort = "force" if driver.point else "torque"
        return entries | {effort: driver.value, "times": driver.times, "speeds": driver.speeds, places: driver.angles}
    raise TypeError(f"driver {name!r}: a model file has no table for {type(driver).__name__}")


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
        return inline(vars(entry))
    if isinstance(entry, Member):
        return inline({name: one.name if isinstance(one, Material) else one for name, one in vars(entry).items()})
    if isinstance(entry, tuple | list):
        if entry and isinstance(entry[0], Member):
            return "[\n" + "".join(f"  {value(one)},\n" for one in entry) + "]"
        return "[" + ", ".join(value(one) for one in entry) + "]"
    if isinstance(entry, int):
        return str(entry)
    return repr(float(entry))


def inline(entries: Entries) -> str:
    """A table in one line."""
    return "{ " + ", ".join(assignments(entries)) + " }"


def quoted(text: str) -> str:
    """A basic string: JSON's escapes are TOML's, but for the one control character that JSON leaves."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def key(name: str) -> str:
    """A key, quoted if it has to be."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else quoted(name)


def dotted(*names: str) -> str:
    """Header of a table."""
    return ".".join(key(name) for name in names)
