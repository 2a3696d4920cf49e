"""The revolute joint with clearance."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from ...errors import Fault
from ...laws import Material, Pair
from ...schema import quantity
from ..drawing.strokes import Extent, JointView, Mark, Stroke, ground_symbol, ring
from ..rows import Touching
from .contact import Contact
from .ideal_revolute import IdealRevolute

MILLIMETRES = 100.0  # times the bearing radius (m): a clearance below it may be meant in mm
LARGE_BEARING = 0.03  # bearing radius, as a share of the drawing, from which its circle is drawn


@dataclass(frozen=True, kw_only=True)
class ClearanceRevolute(Contact):
    """A revolute joint with clearance: free flight, impact and continuous contact of journal and bearing (Eq.
    18-25).

    ``clearance`` c = R_B - R_J, ``bearing_radius`` R_B and ``axial_length`` are in m. ``friction_moment``:
    friction acts at the surfaces, with arms R_J - delta/2 and R_B + delta/2 (``mid-overlap``) or R_J and R_B
    (``surface``), or at the particles (``off``, presumably as in the paper; the sliding speed then excludes
    the rotation of the surfaces). ``landing_depth`` defaults to c/20.
    """

    kind = "clearance"
    builder = "clearance_joint"
    sample: ClassVar[dict[str, Any]] = {"clearance": 1e-3, "bearing_radius": 0.02}
    sizes = ("clearance", "bearing_radius")
    extent = ("bearing_radius", "the bearing's radius")
    refits = True
    keeps_profile = True

    clearance: float = quantity(
        "m", "radial: bearing radius less journal radius, half of the difference of the diameters", above=0.0
    )
    bearing_radius: float = quantity("m", "radius of the bearing", above=0.0)

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for a clearance that leaves no journal."""
        yield from super().conflicts()
        if None not in (self.clearance, self.bearing_radius) and self.clearance >= self.bearing_radius:
            limit = f"above 0 m and below bearing_radius = {self.bearing_radius:g} m"
            remedy = "check the units of both: clearance is bearing radius less journal radius"
            if self.clearance < MILLIMETRES * self.bearing_radius:
                remedy = f"{remedy}. Is it {self.clearance:g} mm? Numbers without units are metres"
            yield Fault(("clearance",), "as large as the bearing: the journal vanishes", "", limit, remedy)

    @property
    def nominal_size(self) -> float:
        """Nominal diameter (m) of bearing and journal."""
        return 2.0 * self.bearing_radius

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """Return the two surfaces; ``bearing`` and ``journal`` are the bodies' materials, used where the
        joint names none.
        """
        return Pair(
            self.bearing_radius,
            self.clearance,
            self.axial_length,
            self.bearing_material or bearing,
            self.journal_material or journal,
        )

    def touchings(self, turned: float) -> tuple[Touching, ...]:
        """Return the contact of the journal in its bearing."""
        return (
            Touching("bearing", self.clearance, (self.bearing_radius, self.bearing_radius - self.clearance)),
        )

    def ideal(self) -> IdealRevolute:
        """Return the ideal revolute joint."""
        return IdealRevolute(name=self.name, bearing=self.bearing, journal=self.journal)

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return a ring with a dot, or two circles if they are large enough to be seen, and the ground
        symbol.
        """
        strokes = ground_symbol(view)
        if self.bearing_radius * view.factor > LARGE_BEARING * view.size:
            strokes.append(ring(view.bearing, view.factor * self.bearing_radius, width=1.8, rank=4.0))
            strokes.append(
                ring(view.journal, view.factor * (self.bearing_radius - self.clearance), width=0.9, rank=4.0)
            )
            return [*strokes, Mark(None, "bearing", sign="bearing and journal")]
        return [
            *strokes,
            Mark(view.bearing, "ring", sign="joint with clearance"),
            Mark(view.bearing, "dot", sign="joint with clearance"),
        ]

    @property
    def drawn(self) -> Extent:
        """Extent of the bearing around its pin."""
        return Extent(bearing=self.bearing_radius)
