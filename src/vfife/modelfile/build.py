"""Checked tables -> the nouns of a mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..bodies import Body, Link, PointMass, RigidBody, Section
from ..drivers import AngleTable, ConstantSpeed, Driver, Ramp, Torque
from ..joints import ClearanceRevolute, IdealRevolute, Joint
from ..laws import MATERIALS, Material
from ..loads import PointForce
from ..mechanism import Mechanism, Settings, Start
from ..schema import (
    BodyTable,
    ClearanceTable,
    DriverTable,
    IdealTable,
    LinkTable,
    LoadTable,
    ModelFile,
    ParticleTable,
    RigidTable,
    SectionTable,
)
from .faults import Fault, place
from .lawtables import law_or_default, senseless

Materials = Mapping[str, Material]


def build(model: ModelFile, source: str | None = None) -> Mechanism:
    """The mechanism that a model file without faults describes."""
    materials = dict(MATERIALS)
    materials |= {name: Material(name, **fields(entry)) for name, entry in model.material.items()}
    return Mechanism(
        name=model.name,
        note=model.note,
        gravity=model.gravity,
        points=dict(model.ground),
        bodies={name: body(name, entry, materials) for name, entry in model.body.items()},
        joints={name: joint(name, entry, materials) for name, entry in model.joint.items()},
        drivers={name: driver(name, entry) for name, entry in model.driver.items()},
        loads={name: load(name, entry) for name, entry in model.load.items()},
        start=Start(**fields(model.start)),
        settings=Settings(**fields(model.run)),
        source=source,
    )


def fields(table: Any) -> dict[str, Any]:
    """Values of a table by key."""
    return {name: getattr(table, name) for name in type(table).model_fields}


def section(table: SectionTable) -> Section:
    """Area and second moment of area of the shape that is given."""
    if table.square is not None:
        return Section.square(table.square)
    if table.rectangle is not None:
        return Section.rectangle(*table.rectangle)
    if table.round is not None:
        return Section.round(table.round)
    return Section(area=table.area or 0.0, second_moment=table.second_moment or 0.0)


def body(name: str, table: BodyTable, materials: Materials) -> Body:
    """A body of the kind its table is."""
    values = fields(table) | {"name": name, "material": materials[table.material]}
    model, points = values.pop("model"), values.pop("pins", {})
    if isinstance(table, LinkTable):
        values["section"] = section(table.section) if table.section is not None else None
        return Link(**values, link_model=model, extra_points=dict(points))
    if isinstance(table, RigidTable):
        return RigidBody(**values, points=dict(points))
    if isinstance(table, ParticleTable):
        return PointMass(**values)
    raise TypeError(f"{type(table).__name__} is no table of a body")


def joint(name: str, table: IdealTable, materials: Materials) -> Joint:
    """An ideal joint, or one with clearance and its laws."""
    values = fields(table) | {"name": name}
    values.pop("kind")
    if not isinstance(table, ClearanceTable):
        return IdealRevolute(**values)
    for side in ("bearing", "journal"):
        named = values[f"{side}_material"]
        # A body brings its own material; the ground is of steel, also where the file says what steel is.
        if named is None and values[side].startswith("ground.") and materials["steel"] != Material():
            named = "steel"
        values[f"{side}_material"] = materials[named] if named is not None else None
    for kind in ("contact", "friction"):
        values[kind] = law_or_default(kind, values[kind])
    return ClearanceRevolute(**values)


def driver(name: str, table: DriverTable) -> Driver:
    """The driver that the keys tell."""
    if table.torque is not None:
        return Torque(body=name, torque=table.torque, times=table.times)
    if table.speed is not None:
        if table.ramp is not None:
            return Ramp(body=name, speed=table.speed, duration=table.ramp)
        return ConstantSpeed(body=name, speed=table.speed)
    return AngleTable(body=name, times=table.times or (), angles=table.angles or ())


def load(name: str, table: LoadTable) -> PointForce:
    """A force and a moment at a pin."""
    return PointForce(name=name, **fields(table))


def unsuited(mechanism: Mechanism) -> list[Fault]:
    """Laws that make no sense for the surfaces they are given, which only the law itself can tell."""
    faults = []
    for name, joint in mechanism.clearances.items():
        sides = [mechanism.bodies[side].material if side != "ground" else Material() for side, _ in joint.sides]
        for kind in ("contact", "friction"):
            what = senseless(getattr(joint, kind), joint.pair(*sides))
            if what:
                size = f"{joint.clearance:g} m"
                remedy = "check clearance, bearing_radius, axial_length and materials, or take another law"
                faults.append(Fault(place(("joint", name, kind)), f"{what} (clearance {size})", "", "", remedy))
    return faults
