"""The tables of joints and gears."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import Discriminator, Field, StrictBool, Tag

from ...model.joints import FrictionMoment
from ...model.readers import Choice, Measure
from .kinds import Direction, PositiveLength, Scalar, Table

JOINT_KINDS = ("ideal", "slider", "weld", "clearance", "clearance-slider", "contact")


def is_kind(kind: str) -> Choice:
    """A kind of joint, messages naming the others too."""
    return Choice((kind,), tuple(other for other in JOINT_KINDS if other != kind))


class JointTable(Table):
    """What every joint has."""

    bearing: str = Field(description='the bearing side, "body.pin" or "ground.point"')
    journal: str = Field(description='the journal side, "body.pin" or "ground.point"')


class IdealTable(JointTable):
    """[joint.NAME]: an ideal revolute joint."""

    kind: Annotated[str, is_kind("ideal")] = Field("ideal", description="ideal: a pin without play")


class SliderTable(JointTable):
    """[joint.NAME] with kind = "slider": the journal's pin moves along a straight guide through the bearing's pin."""

    kind: Annotated[str, is_kind("slider")] = Field(description="slider")
    direction: Direction = Field((1.0, 0.0), description="direction of the guide in the frame of the bearing's body")
    turning: StrictBool = Field(False, description="true: a pin in a slot, free to turn; false: the bodies keep their relative angle")


class WeldTable(JointTable):
    """[joint.NAME] with kind = "weld": one place and one relative angle; with the ground, a clamp."""

    kind: Annotated[str, is_kind("weld")] = Field(description="weld")


class ContactTable(JointTable):
    """What every joint with play has."""

    axial_length: PositiveLength = Field(0.02, description="length of the surfaces along the axis")
    friction_moment: Annotated[FrictionMoment, Choice(("mid-overlap", "surface", "off"))] = Field(
        "mid-overlap", description="where friction acts: in the overlap, at both surfaces, or without moment"
    )
    impact_speed_floor: Annotated[float, Measure("m/s", above=0.0)] = Field(1e-3, description="least impact speed for damping")
    landing_depth: PositiveLength | None = Field(
        None, description="depth of a first contact beyond which it is counted as deep; clearance/20, or journal_radius/1000, if left out"
    )
    bearing_material: str | None = Field(None, description="material of the bearing; its body's if left out")
    journal_material: str | None = Field(None, description="material of the journal; its body's if left out")
    contact: dict[str, Any] = Field({}, description="contact law: law = name, and its parameters")
    friction: dict[str, Any] = Field({}, description="friction law: law = name, and its parameters")


class ClearanceTable(ContactTable):
    """[joint.NAME] with kind = "clearance": a journal with play in its bearing."""

    kind: Annotated[str, is_kind("clearance")] = Field(description="clearance")
    clearance: PositiveLength = Field(description="bearing radius less journal radius")
    bearing_radius: PositiveLength = Field(description="radius of the bearing")


class ClearanceSliderTable(ContactTable):
    """[joint.NAME] with kind = "clearance-slider": a block with play in a straight guide."""

    kind: Annotated[str, is_kind("clearance-slider")] = Field(description="clearance-slider")
    clearance: PositiveLength = Field(description="gap on each side of the centred block")
    length: PositiveLength = Field(description="length of the block, along the guide")
    height: PositiveLength = Field(description="height of the block, across the guide")
    direction: Direction = Field((1.0, 0.0), description="direction of the guide in the frame of the bearing's body")
    corner_radius: PositiveLength = Field(1e-3, description="radius of the block's corners")


class ExternalTable(ContactTable):
    """[joint.NAME] with kind = "contact": a round pin beside a straight line, or beside another round."""

    kind: Annotated[str, is_kind("contact")] = Field(description="contact")
    journal_radius: PositiveLength = Field(description="radius of the round at the journal")
    bearing_radius: PositiveLength | None = Field(None, description="radius of the round at the bearing; a straight line if left out")
    direction: Direction = Field((1.0, 0.0), description="direction of the line in the frame of the bearing's body; the journal is on its left")


class GearTable(Table):
    """[gear.NAME]: couples the angles of two bodies."""

    first: str = Field(description="a body")
    second: str = Field(description="another body, which turns by ratio times the angle of the first")
    ratio: Scalar = Field(description="negative for external gears (- teeth of the first / teeth of the second), positive for belts")


CLEARANCE_ONLY = frozenset({*ContactTable.model_fields, "clearance", "bearing_radius"}) - frozenset(JointTable.model_fields)
JOINT_TABLES: dict[str, type[JointTable]] = {
    "ideal": IdealTable,
    "slider": SliderTable,
    "weld": WeldTable,
    "clearance": ClearanceTable,
    "clearance-slider": ClearanceSliderTable,
    "contact": ExternalTable,
}


def joint_kind(table: Any) -> str:
    """Which table a [joint.NAME] is: told by its kind, or by keys that only a clearance has."""
    kind = table.get("kind") if isinstance(table, dict) else None
    if isinstance(kind, str) and kind in JOINT_TABLES:
        return f"<{kind}>"
    return "<clearance>" if isinstance(table, dict) and CLEARANCE_ONLY & set(table) else "<ideal>"


AnyJoint: TypeAlias = Annotated[
    Annotated[IdealTable, Tag("<ideal>")]
    | Annotated[SliderTable, Tag("<slider>")]
    | Annotated[WeldTable, Tag("<weld>")]
    | Annotated[ClearanceTable, Tag("<clearance>")]
    | Annotated[ClearanceSliderTable, Tag("<clearance-slider>")]
    | Annotated[ExternalTable, Tag("<contact>")],
    Discriminator(joint_kind),
]
