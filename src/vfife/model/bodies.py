"""Bodies of a planar mechanism: rigid bodies, links (rigid, elastic or two-particle) and point masses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

from ..errors import Fault, ModelError, shown, suggestion
from ..laws.law import Material
from ..numerics.scalar import distance, integer_power
from ..schema import (
    PLACE,
    Choice,
    FixedList,
    FreeList,
    Inner,
    Integer,
    Measure,
    Named,
    Names,
    Text,
    Value,
    described,
    quantity,
)

Point = tuple[float, float]
LinkModel = Literal["rigid", "elastic", "two-particle"]
Release = Literal["none", "start", "end", "both"]
Strain = Literal["reference", "current"]
MOST_ELEMENTS, MOST_IN_ALL = 100_000, 200_000  # of a body, and of all bodies
LINK_MODELS = ("rigid", "elastic", "two-particle")
ELASTIC = ("elastic", "two-particle")
DIAMETER = Measure("m", above=0.0)
MASSES = Names(Measure("kg", above=0.0))  # by pin or node
STRAINS = (
    Choice(("reference", "current")),
    "length to which E A and E I refer: reference (without forces, as in beam codes) or current (as"
    " in the VFIFE paper)",
    "reference",
)


class Pin(str):
    """Name of a pin, ``body.pin``, or of a point of the ground, ``ground.point``: a text that can be passed
    wherever a pin is expected.
    """

    __slots__ = ()

    @property
    def body(self) -> str:
        """Name of the body, or ``ground``."""
        return self.partition(".")[0]

    @property
    def name(self) -> str:
        """Name within the body."""
        return self.partition(".")[2]


@dataclass(frozen=True)
class Section:
    """Cross section of an elastic link: area (m^2) and second moment of area about the bending axis (m^4).

    ``extreme_fibre`` (m) is the distance of the outermost fibre from that axis; stresses N/A + M e/I require
    it.
    """

    # Alternatives of a model file; the method of the same name computes the section.
    shapes: ClassVar[dict[str, tuple[Value, str]]] = {
        "square": (Measure("m^2", above=0.0), "area of a square"),
        "rectangle": (FixedList((DIAMETER, DIAMETER)), "width and height, bent across the height"),
        "round": (DIAMETER, "diameter of a solid circle"),
        "tube": (FixedList((DIAMETER, DIAMETER)), "outer and inner diameter of a hollow circle"),
    }

    area: float = quantity("m^2", "area", above=0.0)
    second_moment: float = quantity("m^4", "second moment of area about the axis of bending", above=0.0)
    extreme_fibre: float | None = quantity(
        "m",
        "distance of the outermost fibre from the axis, for stresses; a shape has its own",
        None,
        above=0.0,
    )

    @classmethod
    def rectangle(cls, width: float, height: float) -> Section:
        """Return a rectangle of ``width`` and ``height`` (m), bent across its height."""
        return cls(width * height, width * (height * height * height) / 12.0, 0.5 * height)

    @classmethod
    def square(cls, area: float) -> Section:
        """Return a square of an ``area`` (m^2): I = A^2/12."""
        return cls(area, area * area / 12.0, 0.5 * math.sqrt(area))

    @classmethod
    def round(cls, diameter: float) -> Section:
        """Return a solid circle of a ``diameter`` (m)."""
        return cls(
            math.pi * (diameter * diameter) / 4.0, math.pi * integer_power(diameter, 4) / 64.0, 0.5 * diameter
        )

    @classmethod
    def tube(cls, outer: float, inner: float) -> Section:
        """Return a hollow circle of ``outer`` and ``inner`` diameter (m)."""
        return cls(
            math.pi * (outer * outer - inner * inner) / 4.0,
            math.pi * (integer_power(outer, 4) - integer_power(inner, 4)) / 64.0,
            0.5 * outer,
        )


@dataclass(frozen=True, kw_only=True)
class Body:
    """Base of all bodies: a name, and the approximate angle (rad) and position of the frame's origin (m) from
    which the mechanism is closed.

    ``velocity`` (m/s, m/s, rad/s) is the start velocity of the frame's origin and the angular velocity of a
    body that no driver moves; joints with clearance do not constrain it. Where joints move the origin, a
    given rate other than zero holds, and the origin follows; a caution names velocities that do not hold.
    """

    own_points: ClassVar[tuple[str, ...]] = ("center",)  # points that every body of the kind has

    name: str
    angle: float = quantity(
        "rad",
        "angle at the start: exact for a driven body, and where the joints permit it for one that a torque"
        " turns against the ground, else approximate",
        0.0,
    )
    position: Point | None = described(PLACE, "approximate position of the body's origin at the start", None)
    velocity: tuple[float, float, float] = described(
        FixedList((Measure("m/s"), Measure("m/s"), Measure("rad/s"))),
        "initial velocity of a body that is not driven: of its origin, then angular; where joints move the"
        " origin, a given rate holds and the origin follows",
        (0.0, 0.0, 0.0),
    )
    material: Material = described(Named(Material), "name of a material", factory=Material)

    @property
    def points(self) -> dict[str, Point]:
        """Named points in the body's frame (m): those common to its class, and its pins."""
        raise NotImplementedError

    @property
    def model(self) -> str:
        """Name of the body's model."""
        raise NotImplementedError

    def pin(self, name: str = "center") -> Pin:
        """Return a pin for joints, springs and loads: ``plate.pin("eye")``. Raises ModelError if the body has
        none of this name.
        """
        if name not in self.points:
            remedy = suggestion(str(name), self.points, "name one that is there, or add it")
            raise ModelError(
                [Fault(("body", self.name, "pins"), f"{self.name} has no pin {shown(name)}", remedy=remedy)],
                f"{self.name}.pin()",
            )
        return Pin(f"{self.name}.{name}")


@dataclass(frozen=True, kw_only=True)
class RigidBody(Body):
    """A rigid body with mass (kg), moment of inertia about the centre of mass (kg m^2), centre of mass and
    pins (m, in the body's frame).

    Mass, inertia and centre exclude the ``masses`` (kg) attached at pins. A body without any inertia (one
    mass on a rigid arm) is given a millionth of its mass times the square of its largest radius.
    """

    model = "rigid"

    mass: float = quantity("kg", "mass without attached masses", low=0.0)
    inertia: float = quantity(
        "kg m^2", "moment of inertia about the centre of mass, without attached masses", low=0.0
    )
    center: Point = described(PLACE, "centre of mass in the body's frame", (0.0, 0.0))
    pins: dict[str, Point] = described(Names(PLACE), "pins in the body's frame", factory=dict)
    masses: dict[str, float] = described(MASSES, "point masses attached at pins", factory=dict)

    @property
    def points(self) -> dict[str, Point]:
        """The pins, and ``center``."""
        return {"center": self.center, **self.pins}


@dataclass(frozen=True, kw_only=True)
class Link(Body):
    """A link from ``start`` (0, 0) to ``end`` (length, 0): straight, or bent at the points ``via`` (m, in the
    link's frame).

    Models: ``rigid`` has the exact mass, centre and inertia: those of a uniform rod, unless ``inertia`` (kg
    m^2, about the centre of mass) and ``center_at`` (m from the start) are given. ``elastic`` is divided into
    ``elements`` frame elements of its section and material, with masses lumped by Eq. 2 (k elements give a
    uniform rod the inertia (m l^2/12)(1 + 2/k^2)). ``two-particle`` is one stiff element with half the mass
    at each end, as in the VFIFE paper; with ``release = "both"`` it is a bar. ``mass`` is that of the link
    alone; attached masses (kg) and rotary inertias (kg m^2, such as a flywheel on the pin) are at its ends.
    The elements of a bent link are distributed over its straight pieces by length, at least one to each.
    """

    own_points: ClassVar[tuple[str, ...]] = ("start", "end")

    selected_by: ClassVar[str] = "model"  # the field that says which others are of use

    length: float = quantity("m", "distance from start to end", above=0.0)
    mass: float | None = quantity(
        "kg", "mass without attached masses; from density and section if left out", None, low=0.0
    )
    model: LinkModel = described(
        Choice(LINK_MODELS, ("particle", "frame")),
        "rigid, elastic (frame elements) or two-particle (one element, half the mass at each end)",
        "rigid",
    )
    inertia: float | None = quantity(
        "kg m^2",
        "inertia about the centre of mass; a uniform rod's if left out",
        None,
        above=0.0,
        only=("rigid",),
    )
    center_at: float | None = quantity(
        "m", "centre of mass, from the start; the middle if left out", None, only=("rigid",)
    )
    elements: int = described(
        Integer(1, MOST_ELEMENTS), "number of frame elements of an elastic link", 4, only=("elastic",)
    )
    section: Section | None = described(Inner(Section), "cross section", None)
    release: Release = described(
        Choice(("none", "start", "end", "both")),
        "ends that transmit no moment to the particle there",
        "none",
        only=ELASTIC,
    )
    stiffness_factor: float = quantity(
        "1", "multiplies Young's modulus of this link", 1.0, above=0.0, only=ELASTIC
    )
    strain: Strain = described(*STRAINS, only=ELASTIC)
    start_mass: float = quantity("kg", "mass attached at the start", 0.0, low=0.0)
    end_mass: float = quantity("kg", "mass attached at the end", 0.0, low=0.0)
    start_inertia: float = quantity(
        "kg m^2", "rotary inertia attached at the start: a flywheel, a gear", 0.0, low=0.0
    )
    end_inertia: float = quantity("kg m^2", "rotary inertia attached at the end", 0.0, low=0.0)
    via: tuple[Point, ...] = described(
        FreeList(PLACE),
        "points on the way from start to end, where the link is bent: along it, across it",
        (),
        only=("rigid", "elastic"),
    )
    pins: dict[str, Point] = described(
        Names(PLACE), "further pins of a rigid link: along it, across it", factory=dict, only=("rigid",)
    )
    masses: dict[str, float] = described(
        MASSES,
        "point masses attached at pins of a rigid link, its ends among them",
        factory=dict,
        only=("rigid",),
    )

    @property
    def start(self) -> Pin:
        """The pin at its start."""
        return self.pin("start")

    @property
    def end(self) -> Pin:
        """The pin at its end."""
        return self.pin("end")

    @property
    def points(self) -> dict[str, Point]:
        """``start``, ``end`` and, for a rigid link, its further pins."""
        return {"start": (0.0, 0.0), "end": (self.length, 0.0), **self.pins}

    @property
    def own_mass(self) -> float:
        """Mass (kg) as given, else density times area times length. Raises ValueError without mass and
        section.
        """
        if self.mass is not None:
            return self.mass
        if self.section is None:
            raise ValueError(f"link {self.name!r} has neither a mass nor a section")
        return self.material.density * self.section.area * self.path_length

    @property
    def corners(self) -> tuple[Point, ...]:
        """Start, ``via`` points and end (m)."""
        return ((0.0, 0.0), *self.via, (self.length, 0.0))

    @property
    def path_length(self) -> float:
        """Length (m) along the corners."""
        return sum(distance(a, b) for a, b in zip(self.corners, self.corners[1:], strict=False))

    @property
    def element_count(self) -> int:
        """Number of frame elements; 0 for a rigid link."""
        return {"rigid": 0, "two-particle": 1, "elastic": self.elements}[self.model]


@dataclass(frozen=True, kw_only=True)
class PointMass(Body):
    """A particle: mass (kg), rotary inertia (kg m^2) and one pin, ``center``."""

    model = "particle"

    mass: float = quantity("kg", "mass", above=0.0)
    inertia: float = quantity("kg m^2", "rotary inertia", 0.0, low=0.0)

    @property
    def points(self) -> dict[str, Point]:
        """``center``."""
        return {"center": (0.0, 0.0)}


@dataclass(frozen=True)
class Member:
    """A straight piece of a frame from node ``start`` to node ``end``, divided into ``elements``. Section and
    material default to those of the frame.
    """

    start: str = described(Text(), "node where it starts")
    end: str = described(Text(), "node where it ends")
    elements: int = described(Integer(1, MOST_ELEMENTS), "number of frame elements", 1)
    section: Section | None = described(Inner(Section), "cross section; that of the frame if left out", None)
    material: Material | None = described(
        Named(Material), "name of a material; that of the frame if left out", None
    )
    mass: float | None = quantity("kg", "mass; from density, section and length if left out", None, above=0.0)


@dataclass(frozen=True, kw_only=True)
class Frame(Body):
    """A structure of straight members that are welded together at its nodes (m, in the body's frame); every
    node is a pin.

    ``masses`` (kg) are attached at nodes. A member has its own ``mass``, else density times area times
    length.
    """

    model = "frame"
    own_points: ClassVar[tuple[str, ...]] = ()

    nodes: dict[str, Point] = described(Names(PLACE), "nodes by name, in the body's frame")
    members: tuple[Member, ...] = described(FreeList(Inner(Member)), "members, each from one node to another")
    section: Section | None = described(Inner(Section), "cross section of members that name none", None)
    masses: dict[str, float] = described(MASSES, "masses attached at nodes", factory=dict)
    strain: Strain = described(*STRAINS)

    @property
    def points(self) -> dict[str, Point]:
        """The nodes."""
        return self.nodes
