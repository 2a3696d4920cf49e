"""Checked tables -> the nouns of a mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import Fault, place
from ..laws import MATERIALS, Material
from ..model import joints, springs
from ..model.bodies import Body, Frame, Link, Member, PointMass, RigidBody, Section
from ..model.drivers import AngleTable, ConstantSpeed, Driver, Harmonic, Ramp, StepTo, Torque
from ..model.loads import PointForce
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..model.surfaces import surfaces
from .lawtables import law_or_default, senseless
from .schema import (
    BodyTable,
    ContactTable,
    DriverTable,
    FrameTable,
    JointTable,
    LinkTable,
    LoadTable,
    ModelFile,
    ParticleTable,
    PointDriverTable,
    RigidTable,
    SectionTable,
    SliderDriverTable,
    Table,
)

Materials = Mapping[str, Material]

JOINTS: dict[str, type[joints.Joint]] = {
    "ideal": joints.IdealRevolute,
    "slider": joints.Slider,
    "weld": joints.Weld,
    "clearance": joints.ClearanceRevolute,
    "clearance-slider": joints.ClearanceSlider,
    "contact": joints.ExternalContact,
}
SPRINGS: dict[str, type[springs.AnySpring]] = {
    "linear": springs.Spring,
    "torsional": springs.TorsionalSpring,
    "stop": springs.Stop,
    "bushing": springs.Bushing,
}


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
        gears={name: joints.Gear(name=name, **fields(entry)) for name, entry in model.gear.items()},
        springs={name: spring(name, entry) for name, entry in model.spring.items()},
        drivers={name: driver(name, entry) for name, entry in model.driver.items()},
        loads={name: load(name, entry) for name, entry in model.load.items()},
        start=StartSettings(**fields(model.start)),
        settings=Settings(**fields(model.run)),
        source=source,
    )


def fields(table: Any) -> dict[str, Any]:
    """Values of a table by key."""
    return {name: getattr(table, name) for name in type(table).model_fields}


def section(table: SectionTable | None) -> Section | None:
    """Area and second moment of area of the shape that is given."""
    if table is None:
        return None
    if table.square is not None:
        return Section.square(table.square)
    if table.rectangle is not None:
        return Section.rectangle(*table.rectangle)
    if table.round is not None:
        return Section.round(table.round)
    if table.tube is not None:
        return Section.tube(*table.tube)
    return Section(area=table.area or 0.0, second_moment=table.second_moment or 0.0, extreme_fibre=table.extreme_fibre)


def body(name: str, table: BodyTable, materials: Materials) -> Body:
    """A body of the kind its table is."""
    values = fields(table) | {"name": name, "material": materials[table.material]}
    model, points = values.pop("model"), values.pop("pins", {})
    if isinstance(table, LinkTable):
        return Link(**values | {"section": section(table.section)}, model=model, pins=dict(points))
    if isinstance(table, RigidTable):
        return RigidBody(**values, pins=dict(points))
    if isinstance(table, ParticleTable):
        return PointMass(**values)
    if isinstance(table, FrameTable):
        members = tuple(
            Member(**fields(one) | {"section": section(one.section), "material": materials[one.material] if one.material is not None else None})
            for one in table.members
        )
        return Frame(**values | {"section": section(table.section), "members": members})
    raise TypeError(f"{type(table).__name__} is no table of a body")


def joint(name: str, table: JointTable, materials: Materials) -> joints.Joint:
    """A joint of the kind its table is; one with play has its laws."""
    values = fields(table) | {"name": name}
    noun = JOINTS[values.pop("kind")]
    if not isinstance(table, ContactTable):
        return noun(**values)
    for side in ("bearing", "journal"):
        named = values[f"{side}_material"]
        # A body brings its own material; the ground is of steel, also where the file says what steel is.
        if named is None and values[side].startswith("ground.") and materials["steel"] != Material():
            named = "steel"
        values[f"{side}_material"] = materials[named] if named is not None else None
    for kind in ("contact", "friction"):
        values[kind] = law_or_default(kind, values[kind])
    return noun(**values)


def spring(name: str, table: Table) -> springs.AnySpring:
    """A spring of the kind its table is."""
    values = fields(table) | {"name": name}
    return SPRINGS[values.pop("kind")](**values)


def target(name: str, table: DriverTable) -> dict[str, Any]:
    """What is driven: a slider, a point, or a body, by default that of the table's name."""
    if isinstance(table, SliderDriverTable):
        return {"slider": table.slider}
    if isinstance(table, PointDriverTable):
        return {"point": table.point, "direction": table.direction}
    given: dict[str, Any] = fields(table)
    return {"body": given["body"] if given["body"] is not None else name, "against": given["against"]}


def driver(name: str, table: DriverTable) -> Driver:
    """The driver that the keys tell."""
    driven, given = target(name, table), fields(table)
    places = given.get("angles") or given.get("travels")
    effort = given.get("torque") if given.get("torque") is not None else given.get("force")
    if effort is not None:
        return Torque(**driven, value=effort, times=table.times, speeds=given.get("speeds"), angles=places)
    if given["travel"] is not None:
        return StepTo(**driven, travel=given["travel"], duration=given["duration"], begin=given["begin"] if given["begin"] is not None else 0.0)
    if given["amplitude"] is not None:
        return Harmonic(
            **driven, amplitude=given["amplitude"], frequency=given["frequency"], phase=given["phase"] if given["phase"] is not None else 0.0
        )
    if given["speed"] is not None:
        if table.ramp is not None:
            return Ramp(**driven, speed=given["speed"], duration=table.ramp)
        return ConstantSpeed(**driven, speed=given["speed"])
    return AngleTable(**driven, times=table.times or (), values=places or ())


def load(name: str, table: LoadTable) -> PointForce:
    """A force and a moment at a pin."""
    return PointForce(name=name, **fields(table))


def unsuited(mechanism: Mechanism) -> list[Fault]:
    """Laws that make no sense for the surfaces they are given, which only the law itself can tell."""
    faults = []
    for name, joint in mechanism.clearances.items():
        for kind in ("contact", "friction"):
            what = senseless(getattr(joint, kind), surfaces(mechanism, joint))
            if what:
                size = f"{joint.clearance:g} m"
                remedy = "check clearance, bearing_radius, axial_length and materials, or take another law"
                faults.append(Fault(place(("joint", name, kind)), f"{what} (clearance {size})", "", "", remedy))
    return faults
