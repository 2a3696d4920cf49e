"""The tables of a model file as pydantic models: keys, defaults, units, limits and what each key means."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

from .bodies import LinkModel, Release
from .joints import FrictionMoment
from .mechanism import Journals, StartMode
from .readers import Choice, Measure, Whole

Scalar: TypeAlias = Annotated[float, Measure("1")]
Positive: TypeAlias = Annotated[float, Measure("1", above=0.0)]
Length: TypeAlias = Annotated[float, Measure("m")]
PositiveLength: TypeAlias = Annotated[float, Measure("m", above=0.0)]
Mass: TypeAlias = Annotated[float, Measure("kg", above=0.0)]
AttachedMass: TypeAlias = Annotated[float, Measure("kg", low=0.0)]
Inertia: TypeAlias = Annotated[float, Measure("kg m^2", above=0.0)]
Angle: TypeAlias = Annotated[float, Measure("rad")]
Speed: TypeAlias = Annotated[float, Measure("m/s")]
AngularSpeed: TypeAlias = Annotated[float, Measure("rad/s")]
Acceleration: TypeAlias = Annotated[float, Measure("m/s^2")]
Time: TypeAlias = Annotated[float, Measure("s")]
PositiveTime: TypeAlias = Annotated[float, Measure("s", above=0.0)]
JointKind: TypeAlias = Annotated[Literal["ideal", "clearance"], Choice(("ideal", "clearance"))]
Force: TypeAlias = Annotated[float, Measure("N")]
Place: TypeAlias = tuple[Length, Length]


class Table(BaseModel):
    """A table of the file: an unknown key is a fault."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class RunTable(Table):
    """[run]: how long, how fine, what is kept."""

    turns: Positive | None = Field(None, description="length of the run in turns of the crank")
    duration: PositiveTime | None = Field(None, description="length of the run in time, instead of turns")
    step: Annotated[float | Literal["auto"], Measure("s", above=0.0, words=("auto",))] = Field(
        "auto", description='time step, or "auto" for the largest that is stable and accurate'
    )
    outputs: Annotated[int, Whole(1, 100_000_000)] = Field(720, description="outputs per turn; per run without a crank")
    damping: Annotated[float, Measure("1/s", low=0.0)] = Field(0.0, description="mass-proportional damping")
    path_unit: Annotated[int, Whole(1, 1_000_000)] = Field(1, description="steps in a path unit of the elements")


class StartTable(Table):
    """[start]: how the run starts."""

    mode: Annotated[StartMode, Choice(("consistent", "rough"))] = Field(
        "consistent",
        description="consistent: ideal velocities and accelerations, links loaded to match; rough: not loaded",
    )
    journals: Annotated[Journals, Choice(("centred", "seated"))] = Field(
        "centred", description="journals centred in their bearings, or seated where the ideal reaction presses them"
    )


class MaterialTable(Table):
    """[material.NAME]: elastic constants and density."""

    youngs_modulus: Annotated[float, Measure("Pa", above=0.0)] = Field(description="Young's modulus")
    poissons_ratio: Annotated[float, Measure("1", above=-1.0, high=0.5)] = Field(description="Poisson's ratio")
    density: Annotated[float, Measure("kg/m^3", above=0.0)] = Field(description="density")


class SectionTable(Table):
    """Cross section of a link: area and second_moment, or one of the shapes."""

    area: Annotated[float, Measure("m^2", above=0.0)] | None = Field(None, description="area")
    second_moment: Annotated[float, Measure("m^4", above=0.0)] | None = Field(None, description="second moment of area about the axis of bending")
    square: Annotated[float, Measure("m^2", above=0.0)] | None = Field(None, description="area of a square")
    rectangle: tuple[PositiveLength, PositiveLength] | None = Field(None, description="width and height, bent across it")
    round: PositiveLength | None = Field(None, description="diameter of a solid circle")


class BodyTable(Table):
    """What every body has."""

    angle: Angle = Field(0.0, description="angle at the start: exact for a driven body, else approximate")
    position: Place | None = Field(None, description="approximate position of the body's origin at the start")
    velocity: tuple[Speed, Speed, AngularSpeed] = Field(
        (0.0, 0.0, 0.0), description="at the start, of a body that nothing drives: centre of mass, then angular"
    )
    material: str = Field("steel", description="name of a material")


class LinkTable(BodyTable):
    """[body.NAME] with a length: a straight link with the pins start and end."""

    model: Annotated[LinkModel, Choice(("rigid", "elastic", "two-particle"), ("particle",))] = Field(
        "rigid", description="rigid, elastic (frame elements) or two-particle (one element, half the mass at each end)"
    )
    length: PositiveLength = Field(description="distance from start to end")
    mass: Mass | None = Field(None, description="mass without attached masses; from density and section if left out")
    inertia: Inertia | None = Field(None, description="inertia about the centre of mass; a uniform rod's if left out")
    center_at: Length | None = Field(None, description="centre of mass, from the start; the middle if left out")
    elements: Annotated[int, Whole(1, 100_000)] = Field(4, description="number of frame elements of an elastic link")
    section: SectionTable | None = Field(None, description="cross section")
    release: Annotated[Release, Choice(("none", "start", "end", "both"))] = Field(
        "none", description="ends that transmit no moment to the particle there"
    )
    stiffness_factor: Positive = Field(1.0, description="multiplies Young's modulus of this link")
    start_mass: AttachedMass = Field(0.0, description="mass attached at the start")
    end_mass: AttachedMass = Field(0.0, description="mass attached at the end")
    pins: dict[str, Place] = Field({}, description="further pins of a rigid link: along it, across it")


class RigidTable(BodyTable):
    """[body.NAME] without a length: a rigid body with its own pins."""

    model: Annotated[Literal["rigid"], Choice(("rigid",), ("elastic", "two-particle", "particle"))] = Field("rigid", description="rigid")
    mass: Mass = Field(description="mass")
    inertia: Inertia = Field(description="moment of inertia about the centre of mass")
    center: Place = Field((0.0, 0.0), description="centre of mass in the body's frame")
    pins: dict[str, Place] = Field({}, description="pins in the body's frame")


class ParticleTable(BodyTable):
    """[body.NAME] with model = "particle"."""

    model: Annotated[Literal["particle"], Choice(("particle",))] = Field(description="particle")
    mass: Mass = Field(description="mass")
    inertia: Annotated[float, Measure("kg m^2", low=0.0)] = Field(0.0, description="rotary inertia")


class IdealTable(Table):
    """[joint.NAME]: an ideal revolute joint."""

    kind: JointKind = Field("ideal", description="ideal or clearance")
    bearing: str = Field(description='the bearing side, "body.pin" or "ground.point"')
    journal: str = Field(description='the journal side, "body.pin" or "ground.point"')


class ClearanceTable(IdealTable):
    """[joint.NAME] with kind = "clearance"."""

    kind: JointKind = Field(description="clearance")
    clearance: PositiveLength = Field(description="bearing radius less journal radius")
    bearing_radius: PositiveLength = Field(description="radius of the bearing")
    axial_length: PositiveLength = Field(0.02, description="length of the bearing along its axis")
    friction_moment: Annotated[FrictionMoment, Choice(("mid-overlap", "surface", "off"))] = Field(
        "mid-overlap", description="where friction acts: in the overlap, at both surfaces, or without moment"
    )
    impact_speed_floor: Annotated[float, Measure("m/s", above=0.0)] = Field(1e-3, description="least impact speed for damping")
    landing_depth: PositiveLength | None = Field(None, description="depth of a first contact; clearance/20 if left out")
    bearing_material: str | None = Field(None, description="material of the bearing; its body's if left out")
    journal_material: str | None = Field(None, description="material of the journal; its body's if left out")
    contact: dict[str, Any] = Field({}, description="contact law: law = name, and its parameters")
    friction: dict[str, Any] = Field({}, description="friction law: law = name, and its parameters")


class DriverTable(Table):
    """[driver.BODY]: a speed (with a ramp to it), a table of angles, or a torque (constant, or over times)."""

    speed: AngularSpeed | None = Field(None, description="angular velocity")
    ramp: PositiveTime | None = Field(None, description="time of a smooth ramp from rest to the speed")
    times: tuple[Time, ...] | None = Field(None, description="times of the angles or torques, ascending")
    angles: tuple[Angle, ...] | None = Field(None, description="angles from the start angle, at the times")
    torque: Annotated[float | tuple[float, ...], Measure("N m", series=True)] | None = Field(
        None, description="torque: one, or one for each of the times"
    )


class LoadTable(Table):
    """[load.NAME]: a force and a moment at a pin."""

    at: str = Field(description='where it acts, "body.pin"')
    force: tuple[Force, Force] = Field((0.0, 0.0), description="force")
    moment: Annotated[float, Measure("N m")] = Field(0.0, description="moment")
    times: tuple[Time, ...] | None = Field(None, description="times of the factors, ascending")
    factors: tuple[Scalar, ...] | None = Field(None, description="what multiplies force and moment, at the times")


LINK_ONLY = frozenset(LinkTable.model_fields) - frozenset(RigidTable.model_fields)
RIGID_ONLY = frozenset(RigidTable.model_fields) - frozenset(LinkTable.model_fields)
CLEARANCE_ONLY = frozenset(ClearanceTable.model_fields) - frozenset(IdealTable.model_fields)


def body_kind(table: Any) -> str:
    """Which table a [body.NAME] is, told by its model, its length, or by what only a rigid body of its own has."""
    if not isinstance(table, dict):
        return "<link>"
    if table.get("model") == "particle":
        return "<particle>"
    own = table.get("model", "rigid") == "rigid" and not LINK_ONLY & set(table)
    return "<rigid>" if own and {"inertia", "pins", *RIGID_ONLY} & set(table) else "<link>"


def joint_kind(table: Any) -> str:
    """Which table a [joint.NAME] is: told by its kind, or by keys that only a clearance has."""
    if not isinstance(table, dict) or table.get("kind") == "ideal":
        return "<ideal>"
    return "<clearance>" if table.get("kind") == "clearance" or CLEARANCE_ONLY & set(table) else "<ideal>"


AnyBody: TypeAlias = Annotated[
    Annotated[LinkTable, Tag("<link>")] | Annotated[RigidTable, Tag("<rigid>")] | Annotated[ParticleTable, Tag("<particle>")],
    Discriminator(body_kind),
]
AnyJoint: TypeAlias = Annotated[Annotated[IdealTable, Tag("<ideal>")] | Annotated[ClearanceTable, Tag("<clearance>")], Discriminator(joint_kind)]


class ModelFile(Table):
    """A model file."""

    name: str = Field("mechanism", description="name of the model")
    note: str = Field("", description="what a reader should know")
    gravity: tuple[Acceleration, Acceleration] = Field((0.0, 0.0), description="acceleration of gravity")
    run: RunTable = Field(RunTable(), description="defaults of a run")
    start: StartTable = Field(StartTable(), description="how a run starts")
    material: dict[str, MaterialTable] = Field({}, description="materials by name, beside those of `vfife materials`")
    ground: dict[str, Place] = Field({}, description="points of the ground")
    body: dict[str, AnyBody] = Field({}, description="bodies by name")
    joint: dict[str, AnyJoint] = Field({}, description="joints by name")
    driver: dict[str, DriverTable] = Field({}, description="drivers, by the body they drive")
    load: dict[str, LoadTable] = Field({}, description="loads by name")
