"""The model file as a whole, and its tables on the run, its start and materials."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...model.mechanism import Journals, StartMode
from ...model.readers import Choice, Measure, Whole
from .bodies import AnyBody
from .forces import AnyDriver, AnySpring, LoadTable
from .joints import AnyJoint, GearTable
from .kinds import Acceleration, Place, Positive, PositiveTime, Scalar, Table


class RunTable(Table):
    """[run]: how long, how fine, what is kept; or a static analysis."""

    turns: Positive | None = Field(None, description="length of the run in turns of the crank")
    duration: PositiveTime | None = Field(None, description="length of the run in time, instead of turns")
    step: Annotated[float | Literal["auto"], Measure("s", above=0.0, words=("auto",))] = Field(
        "auto", description='time step, or "auto" for the largest that is stable and accurate'
    )
    outputs: Annotated[int, Whole(1, 100_000_000)] = Field(720, description="outputs per turn; per run without a crank")
    damping: Annotated[float, Measure("1/s", low=0.0)] = Field(0.0, description="mass-proportional damping")
    path_unit: Annotated[int, Whole(1, 1_000_000)] = Field(1, description="steps in a path unit of the elements")
    analysis: Annotated[Literal["dynamic", "static"], Choice(("dynamic", "static"))] = Field(
        "dynamic", description="dynamic: motion over time; static: equilibrium under each of the load factors"
    )
    load_factors: tuple[Scalar, ...] = Field((1.0,), description="of a static analysis: they take the place of time in loads and drivers")
    residual: Annotated[float, Measure("1", above=0.0, high=0.1)] = Field(
        1e-6, description="of a static analysis: largest unbalanced force, as a share of the largest force"
    )
    kinetic_energy: Annotated[float, Measure("1", above=0.0, high=0.1)] = Field(
        1e-10, description="of a static analysis: largest kinetic energy left, as a share of the largest met"
    )
    iterations: Annotated[int, Whole(1, 1_000_000_000)] = Field(1_000_000, description="of a static analysis: most iterations for a load factor")


STATIC_ONLY = ("load_factors", "residual", "kinetic_energy", "iterations")


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
    gear: dict[str, GearTable] = Field({}, description="gears and belts by name")
    spring: dict[str, AnySpring] = Field({}, description="springs, dampers, stops and bushings by name")
    driver: dict[str, AnyDriver] = Field({}, description="drivers by name, which is that of the body unless body, slider or point is given")
    load: dict[str, LoadTable] = Field({}, description="loads by name")
