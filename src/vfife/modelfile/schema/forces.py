"""The tables of springs, drivers and loads."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import Discriminator, Field, StrictBool, Tag

from ...model.readers import Choice, Measure
from .kinds import (
    Angle,
    AngularSpeed,
    Damping,
    Direction,
    Force,
    Frequency,
    Length,
    PositiveTime,
    Scalar,
    Speed,
    Stiffness,
    Table,
    Time,
    TorsionalDamping,
    TorsionalStiffness,
)

SPRING_KINDS = ("linear", "torsional", "stop", "bushing")


def is_kind(kind: str) -> Choice:
    """A kind of spring, messages naming the others too."""
    return Choice((kind,), tuple(other for other in SPRING_KINDS if other != kind))


class LinearSpringTable(Table):
    """[spring.NAME]: a spring and damper along the line between two pins."""

    kind: Annotated[str, is_kind("linear")] = Field("linear", description="linear")
    first: str = Field(description='one end, "body.pin" or "ground.point"')
    second: str = Field(description='the other end, "body.pin" or "ground.point"')
    stiffness: Stiffness = Field(0.0, description="stiffness")
    damping: Damping = Field(0.0, description="damping")
    free_length: Annotated[float, Measure("m", low=0.0)] | None = Field(None, description="length without force; that of the start if left out")


class TorsionalSpringTable(Table):
    """[spring.NAME] with kind = "torsional": a spring and damper about the axis of the plane, between two bodies."""

    kind: Annotated[str, is_kind("torsional")] = Field(description="torsional")
    first: str = Field(description="a body, or ground")
    second: str = Field(description="another body, or ground")
    stiffness: TorsionalStiffness = Field(0.0, description="stiffness")
    damping: TorsionalDamping = Field(0.0, description="damping")
    free_angle: Angle | None = Field(None, description="angle of the second less that of the first without moment; that of the start if left out")


class StopTable(Table):
    """[spring.NAME] with kind = "stop": the angle between two bodies stays between two limits."""

    kind: Annotated[str, is_kind("stop")] = Field(description="stop")
    first: str = Field(description="a body, or ground")
    second: str = Field(description="another body, or ground")
    low: Angle = Field(description="least angle of the second body less that of the first")
    high: Angle = Field(description="largest angle of the second body less that of the first")
    stiffness: Annotated[float, Measure("N m/rad", above=0.0)] = Field(description="stiffness beyond the limits")
    damping: TorsionalDamping = Field(0.0, description="damping beyond the limits")


class BushingTable(Table):
    """[spring.NAME] with kind = "bushing": an elastic bearing between two pins."""

    kind: Annotated[str, is_kind("bushing")] = Field(description="bushing")
    first: str = Field(description='one pin, "body.pin" or "ground.point"; its body holds the axes')
    second: str = Field(description='the other pin, "body.pin" or "ground.point"')
    stiffness: tuple[Stiffness, Stiffness, TorsionalStiffness] = Field(description="stiffness in x, in y, about the axis")
    damping: tuple[Damping, Damping, TorsionalDamping] = Field((0.0, 0.0, 0.0), description="damping in x, in y, about the axis")


SPRING_TABLES: dict[str, type[Table]] = {
    "linear": LinearSpringTable,
    "torsional": TorsionalSpringTable,
    "stop": StopTable,
    "bushing": BushingTable,
}


def spring_kind(table: Any) -> str:
    """Which table a [spring.NAME] is: told by its kind, or by what only one kind has."""
    kind = table.get("kind") if isinstance(table, dict) else None
    if isinstance(kind, str) and kind in SPRING_TABLES:
        return f"<{kind}>"
    if isinstance(table, dict):
        if {"low", "high"} & set(table):
            return "<stop>"
        if isinstance(table.get("stiffness"), list):
            return "<bushing>"
        if "free_angle" in table:
            return "<torsional>"
    return "<linear>"


AnySpring: TypeAlias = Annotated[
    Annotated[LinearSpringTable, Tag("<linear>")]
    | Annotated[TorsionalSpringTable, Tag("<torsional>")]
    | Annotated[StopTable, Tag("<stop>")]
    | Annotated[BushingTable, Tag("<bushing>")],
    Discriminator(spring_kind),
]


class DriverTable(Table):
    """What all drivers have."""

    ramp: PositiveTime | None = Field(None, description="time of a smooth ramp from rest to the speed")
    duration: PositiveTime | None = Field(None, description="time that the travel takes")
    begin: Time | None = Field(None, description="when the travel begins; 0 if left out")
    frequency: Frequency | None = Field(None, description="frequency of the amplitude")
    phase: Angle | None = Field(None, description="phase of the amplitude; 0 if left out")
    times: tuple[Time, ...] | None = Field(None, description="times of the values of a table, ascending")


class TurningTable(DriverTable):
    """[driver.NAME] of a body: a speed, a travel, an amplitude, a table of angles, or a torque."""

    body: str | None = Field(None, description="the body; the name of the table if left out")
    against: str = Field("ground", description="body against which the angle counts, or on which the opposite torque acts")
    speed: AngularSpeed | None = Field(None, description="angular velocity")
    travel: Angle | None = Field(None, description="angle turned from rest to rest within the duration")
    amplitude: Angle | None = Field(None, description="of amplitude [sin(2 pi frequency t + phase) - sin(phase)]")
    angles: tuple[Angle, ...] | None = Field(None, description="angles from the start angle: at the times, or of the torques")
    speeds: tuple[AngularSpeed, ...] | None = Field(None, description="angular velocities of the torques, ascending: a motor's curve")
    torque: Annotated[float | tuple[float, ...], Measure("N m", series=True)] | None = Field(
        None, description="torque: one, or one for each of the times, speeds or angles"
    )


class MovingTable(DriverTable):
    """What drivers along a line have."""

    speed: Speed | None = Field(None, description="velocity")
    travel: Length | None = Field(None, description="way from rest to rest within the duration")
    amplitude: Length | None = Field(None, description="of amplitude [sin(2 pi frequency t + phase) - sin(phase)]")
    travels: tuple[Length, ...] | None = Field(None, description="ways from the start: at the times, or of the forces")


class SliderDriverTable(MovingTable):
    """[driver.NAME] of a slider: a speed, a travel, an amplitude, or a table of travels."""

    slider: str = Field(description='a joint of kind "slider"')


class PointDriverTable(MovingTable):
    """[driver.NAME] of a pin: its motion along a direction that is fixed in space, or a force on it."""

    point: str = Field(description='the pin, "body.pin"')
    direction: Direction = Field((1.0, 0.0), description="direction, fixed in space")
    speeds: tuple[Speed, ...] | None = Field(None, description="velocities of the forces, ascending")
    force: Annotated[float | tuple[float, ...], Measure("N", series=True)] | None = Field(
        None, description="force: one, or one for each of the times, speeds or travels"
    )


DRIVER_TABLES: dict[str, type[DriverTable]] = {"<body>": TurningTable, "<slider>": SliderDriverTable, "<point>": PointDriverTable}


def driver_kind(table: Any) -> str:
    """Which table a [driver.NAME] is, told by what it drives."""
    if isinstance(table, dict):
        for kind in ("slider", "point"):
            if kind in table:
                return f"<{kind}>"
    return "<body>"


AnyDriver: TypeAlias = Annotated[
    Annotated[TurningTable, Tag("<body>")] | Annotated[SliderDriverTable, Tag("<slider>")] | Annotated[PointDriverTable, Tag("<point>")],
    Discriminator(driver_kind),
]


class LoadTable(Table):
    """[load.NAME]: a force and a moment at a pin."""

    at: str = Field(description='where it acts, "body.pin"')
    force: tuple[Force, Force] = Field((0.0, 0.0), description="force")
    moment: Annotated[float, Measure("N m")] = Field(0.0, description="moment")
    follow: StrictBool = Field(False, description="true: the force turns with the body; false: it is fixed in space")
    times: tuple[Time, ...] | None = Field(None, description="times of the factors, ascending")
    factors: tuple[Scalar, ...] | None = Field(None, description="what multiplies force and moment, at the times")
