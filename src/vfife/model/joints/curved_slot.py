"""A pin in a curved slot, ideal and with clearance. The slot is a circle or a polyline with rounded corners,
fixed in the frame of the bearing's body.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...errors import Fault
from ...laws import Material, Pair
from ...numerics.scalar import hypot
from ...schema import PLACE, FreeList, described, quantity
from ..drawing.strokes import Curve, Extent, JointView, Label, Mark, Stroke, left_of, ring
from ..geometry.path import Path, circle, polyline
from ..rows import OnPath, Row, Touching
from .contact import Contact
from .joint import Joint, Point

WIDTH = 0.02  # of an ideal slot, as a share of the drawing
LABEL = 0.06  # height of the name above the pin, as a share of the drawing
CENTRE = "centre of a round slot, from the bearing's pin in the frame of its body"
RADIUS = "radius of a round slot; leave it out for one along points"
POINTS = "points of a slot along a polyline, from the bearing's pin in the frame of its body"
FILLET = "radius of the arcs that round the corners of a polyline"


class Slot:
    """Base of slots with and without clearance: a path, at whose beginning the journal's pin is
    first placed.
    """

    @property
    def half_width(self) -> float:
        """Half the distance of its walls (m); 0 without clearance."""
        return 0.0

    @property
    def path(self) -> Path:
        """Centre line of the slot. Raises Fault if its sizes make no path, or leave no wall inside an arc."""
        slot: Any = self
        for fault in no_path(slot, self.half_width):
            raise fault.at(("joint", slot.name, *fault.path))
        return geometry_of(slot)

    @property
    def first_place(self) -> Point:
        """First guess of the journal's pin (m), from the bearing's pin."""
        return self.path.pieces[0].begin

    def label(self, view: JointView) -> Label:
        """Return a place above the pin."""
        return Label(view.journal + (0.0, LABEL * view.size), fixed=True)

    @property
    def drawn(self) -> Extent:
        """Extent of the path, which the bearing's pin may be far from."""
        return Extent(tuple(self.path.points()), None, self.half_width)


@dataclass(frozen=True, kw_only=True)
class CurvedSlot(Slot, Joint):
    """A pin that stays on a path fixed in the bearing's body, while its own body turns freely.

    The path is a circle of ``radius`` (m) about ``centre``, or connects ``points`` with corners rounded to
    arcs of radius ``fillet`` (m), so that it has a tangent everywhere; its first and last piece continue
    beyond their ends. Centre and points (m) are measured from the bearing's pin, in the frame of its body.
    Where a straight piece meets an arc the curvature jumps, and with it the force m v^2/R, without an impact.
    """

    kind = "curved-slot"
    words = "pin in a curved slot"
    sample: ClassVar[dict[str, Any]] = {"points": ((0.0, 0.0), (0.2, -0.1), (0.4, 0.0)), "fillet": 0.1}

    centre: Point = described(PLACE, CENTRE, (0.0, 0.0))
    radius: float | None = quantity("m", RADIUS, None, above=0.0)
    points: tuple[Point, ...] = described(FreeList(PLACE), POINTS, ())
    fillet: float = quantity("m", FILLET, 0.0, low=0.0)

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault if the sizes make no path."""
        yield from no_path(self, 0.0)

    def rows(self) -> tuple[Row, ...]:
        """Return the row of a pin on a path."""
        return (OnPath(self.path),)

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return the two walls, and the pin between them."""
        return [
            *walls(view, self.path, 0.5 * WIDTH * view.size),
            Mark(view.journal, "pin", "journal", "pin in a curved slot"),
        ]


@dataclass(frozen=True, kw_only=True)
class ClearanceCurvedSlot(Slot, Contact):
    """A round pin of ``journal_radius`` (m) between the two walls of a curved slot, which are ``2
    (journal_radius + clearance)`` apart.

    The slot is that of :class:`CurvedSlot`; its walls are offset from its centre line by journal_radius +
    ``clearance`` (m), so its arcs must have a larger radius. The contact law treats the wall as flat.
    ``landing_depth`` defaults to c/20.
    """

    kind = "clearance-curved-slot"
    words = "pin with clearance in a curved slot"
    sample: ClassVar[dict[str, Any]] = {"clearance": 1e-3, "journal_radius": 0.01, "radius": 0.3}
    sizes = ("clearance", "journal_radius", "radius", "fillet")
    extent = ("journal_radius", "the pin's radius")
    is_guide = True

    clearance: float = quantity("m", "gap on each side of the centred pin", above=0.0)
    journal_radius: float = quantity("m", "radius of the pin", above=0.0)
    centre: Point = described(PLACE, CENTRE, (0.0, 0.0))
    radius: float | None = quantity("m", RADIUS, None, above=0.0)
    points: tuple[Point, ...] = described(FreeList(PLACE), POINTS, ())
    fillet: float = quantity("m", FILLET, 0.0, low=0.0)

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault if the sizes make no path, or leave no room for the inner wall."""
        yield from super().conflicts()
        if None not in (self.journal_radius, self.clearance):
            yield from no_path(self, self.half_width)

    @property
    def half_width(self) -> float:
        """Half the distance of its walls (m)."""
        return self.journal_radius + self.clearance

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """Return the surfaces: a round pin on a flat wall."""
        materials = (self.bearing_material or bearing, self.journal_material or journal)
        return Pair(
            math.inf, self.clearance, self.axial_length, *materials, opposite_radius=self.journal_radius
        )

    def touchings(self, turned: float) -> tuple[Touching, ...]:
        """Return the contact of the pin with either wall; it can touch one at a time."""
        r = self.journal_radius
        return (Touching("slot", self.clearance, (self.half_width, r), path=self.path),)

    def ideal(self) -> CurvedSlot:
        """Return the ideal slot."""
        slot = {"centre": self.centre, "radius": self.radius, "points": self.points, "fillet": self.fillet}
        return CurvedSlot(name=self.name, bearing=self.bearing, journal=self.journal, **slot)  # type: ignore[arg-type]

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return the two walls, and the pin between them."""
        pin = ring(
            view.journal,
            view.factor * self.journal_radius,
            colour="journal",
            width=1.6,
            sign="pin with clearance in a curved slot",
        )
        return [*walls(view, self.path, view.factor * self.half_width), pin]


def geometry_of(slot: CurvedSlot | ClearanceCurvedSlot) -> Path:
    """Return the path of a slot without checks. Raises ValueError if its sizes make none."""
    return polyline(slot.points, slot.fillet) if slot.radius is None else circle(slot.centre, slot.radius)


def no_path(slot: CurvedSlot | ClearanceCurvedSlot, half: float) -> Iterator[Fault]:
    """Yield the fault for which the sizes of a slot make no path, or leave no inner wall at a half width
    ``half`` (m).
    """
    if None in (slot.points, slot.fillet, slot.centre):
        return
    if (slot.radius is None) == (not slot.points):
        yield Fault(
            ("",), "a slot is round or runs along a polyline", remedy="give a radius or points, and not both"
        )
        return
    try:
        sharpest = geometry_of(slot).sharpest
    except ValueError as error:
        problem, _, remedy = str(error).rpartition("; ")
        yield Fault(("points",), problem, remedy=remedy)
        return
    if not sharpest > half:
        problem = (
            f"an arc of radius {sharpest:.4g} m leaves no inner wall for a slot of half width {half:.4g} m"
            " (journal_radius + clearance)"
        )
        yield Fault(
            ("fillet" if slot.radius is None else "radius",),
            problem,
            remedy="take a larger radius or fillet, or a thinner pin",
        )


def walls(view: JointView, path: Path, gap: float) -> list[Stroke]:
    """Return the two walls of a slot at the distance ``gap`` from its centre line, in units of the
    drawing.
    """
    strokes: list[Stroke] = []
    for side in (1.0, -1.0):
        wall = []
        for piece in path.pieces:
            middle = view.space(piece.points())
            ways = np.diff(middle, axis=0, append=2.0 * middle[-1:] - middle[-2:-1])
            ways[1:] += np.roll(ways, 1, axis=0)[1:]
            across = np.array([left_of(way / hypot(*way)) for way in ways])
            wall.append(middle + side * gap * across)
        strokes.append(Curve(np.concatenate(wall), "bearing", 1.6, 3.5))
    return strokes
