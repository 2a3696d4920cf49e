"""What kinds of values the keys have: quantities with unit and limits, places, names."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict

from ...model.readers import Measure, Whole

MOST_ELEMENTS = 100_000

Scalar: TypeAlias = Annotated[float, Measure("1")]
Positive: TypeAlias = Annotated[float, Measure("1", above=0.0)]
Length: TypeAlias = Annotated[float, Measure("m")]
PositiveLength: TypeAlias = Annotated[float, Measure("m", above=0.0)]
Mass: TypeAlias = Annotated[float, Measure("kg", above=0.0)]
AttachedMass: TypeAlias = Annotated[float, Measure("kg", low=0.0)]
Inertia: TypeAlias = Annotated[float, Measure("kg m^2", above=0.0)]
AttachedInertia: TypeAlias = Annotated[float, Measure("kg m^2", low=0.0)]
Angle: TypeAlias = Annotated[float, Measure("rad")]
Speed: TypeAlias = Annotated[float, Measure("m/s")]
AngularSpeed: TypeAlias = Annotated[float, Measure("rad/s")]
Acceleration: TypeAlias = Annotated[float, Measure("m/s^2")]
Time: TypeAlias = Annotated[float, Measure("s")]
PositiveTime: TypeAlias = Annotated[float, Measure("s", above=0.0)]
Frequency: TypeAlias = Annotated[float, Measure("1/s", above=0.0)]
Force: TypeAlias = Annotated[float, Measure("N")]
Stiffness: TypeAlias = Annotated[float, Measure("N/m", low=0.0)]
Damping: TypeAlias = Annotated[float, Measure("N s/m", low=0.0)]
TorsionalStiffness: TypeAlias = Annotated[float, Measure("N m/rad", low=0.0)]
TorsionalDamping: TypeAlias = Annotated[float, Measure("N m s/rad", low=0.0)]
Elements: TypeAlias = Annotated[int, Whole(1, MOST_ELEMENTS)]
Place: TypeAlias = tuple[Length, Length]
Direction: TypeAlias = tuple[Scalar, Scalar]


class Table(BaseModel):
    """A table of the file: an unknown key is a fault."""

    model_config = ConfigDict(extra="forbid", frozen=True)
