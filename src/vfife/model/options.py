"""What the adders of a mechanism take beside what they need: the fields of the nouns that have a default, for type checkers and completion.

A test compares them with the nouns.
"""

from __future__ import annotations

from typing import TypedDict

from ..laws import ContactLaw, FrictionLaw, Material
from .bodies import LinkModel, Point, Release, Section, Strain
from .joints import FrictionMoment


class BodyOptions(TypedDict, total=False):
    """Of every body."""

    angle: float
    position: Point | None
    velocity: tuple[float, float, float]
    material: Material


class LinkOptions(BodyOptions, total=False):
    """Of a link."""

    mass: float | None
    model: LinkModel
    inertia: float | None
    center_at: float | None
    elements: int
    section: Section | None
    release: Release
    stiffness_factor: float
    strain: Strain
    start_mass: float
    end_mass: float
    start_inertia: float
    end_inertia: float
    via: tuple[Point, ...]
    pins: dict[str, Point]
    masses: dict[str, float]


class RigidBodyOptions(BodyOptions, total=False):
    """Of a rigid body."""

    center: Point
    pins: dict[str, Point]
    masses: dict[str, float]


class PointMassOptions(BodyOptions, total=False):
    """Of a particle."""

    inertia: float


class FrameOptions(BodyOptions, total=False):
    """Of a frame."""

    section: Section | None
    masses: dict[str, float]
    strain: Strain


class SliderOptions(TypedDict, total=False):
    """Of an ideal slider."""

    direction: Point
    turning: bool


class DistanceOptions(TypedDict, total=False):
    """Of a massless link."""

    angle: float


class ContactOptions(TypedDict, total=False):
    """Of every joint with play."""

    axial_length: float
    contact: ContactLaw
    friction: FrictionLaw
    friction_moment: FrictionMoment
    impact_speed_floor: float
    landing_depth: float | None
    bearing_material: Material | None
    journal_material: Material | None


class ClearanceSliderOptions(ContactOptions, total=False):
    """Of a block with play in a guide."""

    direction: Point
    corner_radius: float


class ExternalContactOptions(ContactOptions, total=False):
    """Of a round pin beside a line or another round."""

    bearing_radius: float | None
    direction: Point
