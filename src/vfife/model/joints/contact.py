"""Base of all joints with clearance."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal

from ...errors import Fault
from ...laws import Ambrosio, ContactLaw, FrictionLaw, LankaraniNikravesh, Material, Pair
from ...schema import Choice, Chosen, Inner, Named, described, quantity
from ..rows import Touching
from ..wear import Wear
from .joint import Joint

FrictionMoment = Literal["mid-overlap", "surface", "off"]


@dataclass(frozen=True, kw_only=True)
class Contact(Joint):
    """Base of all joints with clearance: surfaces, laws, and the depth from which a first contact counts as
    deep.

    ``impact_speed_floor`` (m/s) is the lower bound of the impact speed in the damping term. A first contact
    deeper than ``landing_depth`` (m) is counted, and shortens an automatic step. Friction acts in the middle
    of the overlap, at both surfaces or, with ``friction_moment = "off"``, at the journal's centre (of a
    block: at the centres of its corners), where it exerts no moment on the round.
    """

    axial_length: float = quantity("m", "length of the surfaces along the axis", 0.02, above=0.0)
    contact: ContactLaw = described(
        Chosen(ContactLaw, "contact"),
        "contact law: law = name, and its parameters",
        factory=LankaraniNikravesh,
    )
    friction: FrictionLaw = described(
        Chosen(FrictionLaw, "friction"), "friction law: law = name, and its parameters", factory=Ambrosio
    )
    friction_moment: FrictionMoment = described(
        Choice(("mid-overlap", "surface", "off")),
        "where friction acts: in the overlap, at both surfaces, or without moment",
        "mid-overlap",
    )
    impact_speed_floor: float = quantity("m/s", "least impact speed for damping", 1e-3, above=0.0)
    landing_depth: float | None = quantity(
        "m",
        "depth of a first contact beyond which it is counted as deep; clearance/20, or journal_radius/1000,"
        " if left out",
        None,
        above=0.0,
    )
    bearing_material: Material | None = described(
        Named(Material), "material of the bearing; its body's if left out", None
    )
    journal_material: Material | None = described(
        Named(Material), "material of the journal; its body's if left out", None
    )

    wear: Wear | None = described(
        Inner(Wear),
        "wear coefficients and present wear of the surfaces; wear is not computed if left out",
        None,
    )

    sizes: ClassVar[tuple[str, ...]] = ()  # fields of its own that a description of the joint lists
    # Field with the size (m) that no contact of a sound run penetrates, and its description.
    extent: ClassVar[tuple[str, str]] = ("", "")

    is_guide: ClassVar[bool] = False  # whether its clearance is the gap on each side, not a radial one
    keeps_profile: ClassVar[bool] = False  # whether its surfaces may have a worn profile

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for wear of a film, wear without friction moment, and a profile that the joint cannot
        have.
        """
        if self.wear is None:
            return
        yield from self.wear.conflicts()
        if getattr(self.contact, "film", False):  # a law that was refused is None here
            remedy = f'take another contact law than "{self.contact.name}", or remove wear'
            yield Fault(
                ("wear",),
                "a film keeps the surfaces apart, so that its load does not wear them",
                remedy=remedy,
            )
        if self.friction_moment == "off":
            remedy = 'set friction_moment = "mid-overlap" or "surface", or remove wear'
            yield Fault(
                ("wear",),
                "with friction_moment off the sliding due to rotation is ignored, and so would be its wear",
                remedy=remedy,
            )
        if any(self.wear.harmonics) and not self.keeps_profile:
            remedy = "remove the profiles; wear volumes are computed for any joint with clearance"
            yield Fault(("wear",), "only a journal in a bearing can have a worn profile", remedy=remedy)

    @property
    def tilt(self) -> float:
        """Angle (rad) by which a block can turn in its guide from the middle; 0 for other joints."""
        return 0.0

    @property
    def nominal_size(self) -> float | None:
        """Nominal size (m) of a fit of the joint: a diameter, or the height of a block; None without."""
        return None

    def facts(self) -> tuple[str, ...]:
        """Return sentences on the surfaces that a reader of pressures and wear must know."""
        return ()

    @property
    def landing(self) -> float:
        """Depth (m) of a first contact from which it counts as deep."""
        return self.landing_depth if self.landing_depth is not None else self.usual_landing

    @property
    def usual_landing(self) -> float:
        """Default of ``landing_depth`` (m): clearance/20."""
        return float(getattr(self, "clearance")) / 20.0  # noqa: B009 - of all but external contacts

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """Return the two surfaces; ``bearing`` and ``journal`` are the bodies' materials, used where the
        joint names none.
        """
        raise NotImplementedError

    def touchings(self, turned: float) -> tuple[Touching, ...]:
        """Return the places of contact; ``turned`` (rad) is the start angle of the bearing's body minus that
        of the journal's.
        """
        raise NotImplementedError

    @property
    def reach(self) -> float:
        """Depth (m) that no contact of a sound run reaches."""
        return float(getattr(self, self.extent[0]))

    @property
    def deepest_start(self) -> tuple[float, str]:
        """Largest depth (m) at the start for which contact laws are valid, and its description."""
        return 0.5 * self.reach, f"half {self.extent[1]} of {self.reach:g} m"
