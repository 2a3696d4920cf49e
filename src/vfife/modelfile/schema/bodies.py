"""The tables of bodies: links, rigid bodies, particles, frames, and the sections of what is elastic."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag

from ...model.bodies import LinkModel, Release
from ...model.readers import Choice, Measure
from .kinds import (
    Angle,
    AngularSpeed,
    AttachedInertia,
    AttachedMass,
    Elements,
    Inertia,
    Length,
    Mass,
    Place,
    Positive,
    PositiveLength,
    Speed,
    Table,
)

LINK_MODELS = ("rigid", "elastic", "two-particle")


class SectionTable(Table):
    """Cross section: area and second_moment, or one of the shapes."""

    area: Annotated[float, Measure("m^2", above=0.0)] | None = Field(None, description="area")
    second_moment: Annotated[float, Measure("m^4", above=0.0)] | None = Field(None, description="second moment of area about the axis of bending")
    extreme_fibre: PositiveLength | None = Field(
        None, description="distance of the outermost fibre from the axis, for stresses; a shape knows its own"
    )
    square: Annotated[float, Measure("m^2", above=0.0)] | None = Field(None, description="area of a square")
    rectangle: tuple[PositiveLength, PositiveLength] | None = Field(None, description="width and height, bent across the height")
    round: PositiveLength | None = Field(None, description="diameter of a solid circle")
    tube: tuple[PositiveLength, PositiveLength] | None = Field(None, description="outer and inner diameter of a hollow circle")


class BodyTable(Table):
    """What every body has."""

    angle: Angle = Field(0.0, description="angle at the start: exact for a driven body, else approximate")
    position: Place | None = Field(None, description="approximate position of the body's origin at the start")
    velocity: tuple[Speed, Speed, AngularSpeed] = Field(
        (0.0, 0.0, 0.0), description="at the start, of a body that nothing drives: centre of mass, then angular"
    )
    material: str = Field("steel", description="name of a material")


class LinkTable(BodyTable):
    """[body.NAME] with a length: a link with the pins start and end."""

    model: Annotated[LinkModel, Choice(LINK_MODELS, ("particle", "frame"))] = Field(
        "rigid", description="rigid, elastic (frame elements) or two-particle (one element, half the mass at each end)"
    )
    length: PositiveLength = Field(description="distance from start to end")
    via: tuple[Place, ...] = Field((), description="points on the way from start to end, where the link is bent: along it, across it")
    mass: Mass | None = Field(None, description="mass without attached masses; from density and section if left out")
    inertia: Inertia | None = Field(None, description="inertia about the centre of mass; a uniform rod's if left out")
    center_at: Length | None = Field(None, description="centre of mass, from the start; the middle if left out")
    elements: Elements = Field(4, description="number of frame elements of an elastic link")
    section: SectionTable | None = Field(None, description="cross section")
    release: Annotated[Release, Choice(("none", "start", "end", "both"))] = Field(
        "none", description="ends that transmit no moment to the particle there"
    )
    stiffness_factor: Positive = Field(1.0, description="multiplies Young's modulus of this link")
    start_mass: AttachedMass = Field(0.0, description="mass attached at the start")
    end_mass: AttachedMass = Field(0.0, description="mass attached at the end")
    start_inertia: AttachedInertia = Field(0.0, description="rotary inertia attached at the start: a flywheel, a gear")
    end_inertia: AttachedInertia = Field(0.0, description="rotary inertia attached at the end")
    pins: dict[str, Place] = Field({}, description="further pins of a rigid link: along it, across it")


class RigidTable(BodyTable):
    """[body.NAME] without a length: a rigid body with its own pins."""

    model: Annotated[Literal["rigid"], Choice(("rigid",), ("elastic", "two-particle", "particle", "frame"))] = Field("rigid", description="rigid")
    mass: Mass = Field(description="mass")
    inertia: Inertia = Field(description="moment of inertia about the centre of mass")
    center: Place = Field((0.0, 0.0), description="centre of mass in the body's frame")
    pins: dict[str, Place] = Field({}, description="pins in the body's frame")


class ParticleTable(BodyTable):
    """[body.NAME] with model = "particle"."""

    model: Annotated[Literal["particle"], Choice(("particle",))] = Field(description="particle")
    mass: Mass = Field(description="mass")
    inertia: AttachedInertia = Field(0.0, description="rotary inertia")


class MemberTable(Table):
    """One of the members of a frame."""

    start: str = Field(description="node where it starts")
    end: str = Field(description="node where it ends")
    elements: Elements = Field(1, description="number of frame elements")
    section: SectionTable | None = Field(None, description="cross section; that of the frame if left out")
    material: str | None = Field(None, description="name of a material; that of the frame if left out")
    mass: Mass | None = Field(None, description="mass; from density, section and length if left out")


class FrameTable(BodyTable):
    """[body.NAME] with model = "frame": straight elastic members welded together at nodes, each of which is a pin."""

    model: Annotated[Literal["frame"], Choice(("frame",), (*LINK_MODELS, "particle"))] = Field(description="frame")
    nodes: dict[str, Place] = Field(description="nodes by name, in the body's frame")
    members: tuple[MemberTable, ...] = Field(description="members, each from one node to another")
    section: SectionTable | None = Field(None, description="cross section of members that name none")
    masses: dict[str, Mass] = Field({}, description="masses attached at nodes")


LINK_ONLY = frozenset(LinkTable.model_fields) - frozenset(RigidTable.model_fields)
RIGID_ONLY = frozenset(RigidTable.model_fields) - frozenset(LinkTable.model_fields)
FRAME_ONLY = frozenset({"nodes", "members", "masses"})
BODY_TABLES: dict[str, type[BodyTable]] = {"<link>": LinkTable, "<rigid>": RigidTable, "<particle>": ParticleTable, "<frame>": FrameTable}


def body_kind(table: Any) -> str:
    """Which table a [body.NAME] is, told by its model, its length, or by what only one kind of body has."""
    if not isinstance(table, dict):
        return "<link>"
    model = table.get("model")
    if model in ("particle", "frame"):
        return f"<{model}>"
    if model not in LINK_MODELS and "length" not in table and FRAME_ONLY & set(table):
        return "<frame>"
    own = table.get("model", "rigid") == "rigid" and not LINK_ONLY & set(table)
    return "<rigid>" if own and {"inertia", "pins", *RIGID_ONLY} & set(table) else "<link>"


AnyBody: TypeAlias = Annotated[
    Annotated[LinkTable, Tag("<link>")]
    | Annotated[RigidTable, Tag("<rigid>")]
    | Annotated[ParticleTable, Tag("<particle>")]
    | Annotated[FrameTable, Tag("<frame>")],
    Discriminator(body_kind),
]
