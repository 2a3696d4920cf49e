"""The slider with clearance."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from ...errors import Fault
from ...laws import Material, Pair
from ...numerics.scalar import acos, atan2, hypot, sincos
from ...schema import Direction, described, quantity
from ..drawing.strokes import Block, Extent, JointView, Label, Stroke, facing, rails, side_label
from ..rows import AcrossGuide, Touching
from .contact import Contact
from .joint import Point
from .slider import Slider


@dataclass(frozen=True, kw_only=True)
class ClearanceSlider(Contact):
    """A block with clearance in a straight guide: its four corners may touch the two walls.

    The centre line of the guide passes through the bearing's pin along ``direction`` (in the frame of the
    bearing's body); the journal's pin is the centre of the block. ``clearance`` (m) is the gap on each side
    of the centred block, ``length`` and ``height`` (m) are the sizes of the block along and across the guide,
    whose walls are ``height + 2 clearance`` apart. ``corner_radius`` (m) is the radius of the corners in the
    contact law. At the start the block is parallel to the guide. ``landing_depth`` defaults to c/20.
    """

    kind = "clearance-slider"
    words = "clearance slider"
    sample: ClassVar[dict[str, Any]] = {"clearance": 1e-3, "length": 0.1, "height": 0.05}
    sizes = ("clearance", "length", "height", "corner_radius")
    extent = ("height", "the block's height")
    is_guide = True

    clearance: float = quantity("m", "gap on each side of the centred block", above=0.0)
    length: float = quantity("m", "length of the block, along the guide", above=0.0)
    height: float = quantity("m", "height of the block, across the guide", above=0.0)
    direction: Point = described(
        Direction(), "direction of the guide in the frame of the bearing's body", (1.0, 0.0)
    )
    corner_radius: float = quantity("m", "radius of the block's corners", 1e-3, above=0.0)

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for corners larger than the block."""
        yield from super().conflicts()
        sizes, r = (self.length, self.height), self.corner_radius
        if None not in (*sizes, r) and r > 0.5 * min(sizes):
            problem = f"corners of {r:g} m do not fit on a block of {self.length:g} m by {self.height:g} m"
            limit = f"at most half of the smaller side, {0.5 * min(sizes):g} m"
            yield Fault(
                ("corner_radius",),
                problem,
                "",
                limit,
                "give a smaller radius, and check the units of all three",
            )

    @property
    def tilt(self) -> float:
        """Angle (rad) by which the block can turn from the middle; infinite if it can turn over.

        At the angle t rounded corners of radius r touch both walls:
        (l - 2r) sin t + (h - 2r) cos t = h + 2c - 2r.
        """
        length, height = self.length - 2.0 * self.corner_radius, self.height - 2.0 * self.corner_radius
        across = height + 2.0 * self.clearance
        diagonal = hypot(length, height)
        return atan2(length, height) - acos(across / diagonal) if across < diagonal else math.inf

    @property
    def nominal_size(self) -> float:
        """Nominal height (m) of block and guide."""
        return self.height

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """Return the surfaces: a rounded corner on a flat wall."""
        materials = (self.bearing_material or bearing, self.journal_material or journal)
        return Pair(
            math.inf, self.clearance, self.axial_length, *materials, opposite_radius=self.corner_radius
        )

    def facts(self) -> tuple[str, ...]:
        """Return what the block touches the walls with."""
        return (
            "the block touches the walls with its corners, whose radius of"
            f" {1e3 * self.corner_radius:.4g} mm (corner_radius) decides its pressures, wear and contact"
            " stiffness",
        )

    def touchings(self, turned: float) -> tuple[Touching, ...]:
        """Return the contacts of the four corners: rear and front at the wall to the left of the guide's
        direction, then at the wall to its right.
        """
        x, y = AcrossGuide(self.direction).unit()
        s, c = sincos(turned)
        ax, ay = c * x - s * y, s * x + c * y  # the guide in the frame of the block's body
        r, rise = self.corner_radius, 0.5 * self.height
        half, wall, touchings = 0.5 * self.length - r, rise + self.clearance, []
        for end, side in ((-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)):
            p, q = end * half, side * (rise - r)
            at = (p * ax - q * ay, p * ay + q * ax)
            touchings.append(Touching("line", wall - r, (wall, r), at, (-side * y, side * x)))
        return tuple(touchings)

    def ideal(self) -> Slider:
        """Return the ideal slider."""
        return Slider(name=self.name, bearing=self.bearing, journal=self.journal, direction=self.direction)

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return the walls, and the block at its angle between them."""
        length, height = view.factor * self.length, view.factor * self.height
        lies = (
            view.angles[1]
            - view.start_angles[1]
            + view.start_angles[0]
            + atan2(self.direction[1], self.direction[0])
        )
        block = Block(view.journal, facing(lies), length, height, sign="block with clearance")
        return [*rails(view, self.direction, length, 0.5 * height + view.factor * self.clearance), block]

    def label(self, view: JointView) -> Label:
        """Return a place beside the guide."""
        return side_label(view, self.direction, view.factor * (0.5 * self.height + self.clearance))

    @property
    def drawn(self) -> Extent:
        """Extent of the block and its walls around the journal's pin."""
        return Extent(journal=0.5 * hypot(self.length, self.height) + self.clearance)
