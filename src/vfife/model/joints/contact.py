"""What joints with play share."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

from ...laws import Ambrosio, ContactLaw, FrictionLaw, LankaraniNikravesh, Material, Pair
from ..touching import Touching
from .joint import Joint

FrictionMoment = Literal["mid-overlap", "surface", "off"]


@dataclass(frozen=True, kw_only=True)
class Contact(Joint):
    """What all contacts with play share: surfaces, laws, and when a first contact counts as deep.

    ``impact_speed_floor`` (m/s) bounds the impact speed from below; a first contact that lands deeper than ``landing_depth`` (m) is counted, and
    shortens an automatic step. Friction acts in the middle of the overlap, at both surfaces, or, with ``friction_moment`` off, at the journal's
    centre (of a block, at those of its corners), so that it does not turn the round.
    """

    axial_length: float = 0.02
    contact: ContactLaw = field(default_factory=LankaraniNikravesh)
    friction: FrictionLaw = field(default_factory=Ambrosio)
    friction_moment: FrictionMoment = "mid-overlap"
    impact_speed_floor: float = 1e-3
    landing_depth: float | None = None
    bearing_material: Material | None = None
    journal_material: Material | None = None

    sizes: ClassVar[tuple[str, ...]] = ()  # fields of its own that a description of the joint lists

    @property
    def landing(self) -> float:
        """Depth (m) at which a first contact may land."""
        raise NotImplementedError

    def pair(self, bearing: Material, journal: Material) -> Pair:
        """The two surfaces, with the bodies' materials where the joint names none."""
        raise NotImplementedError

    def touchings(self, turned: float) -> tuple[Touching, ...]:
        """Where the surfaces can touch; ``turned`` (rad) is the angle of the bearing's body less that of the journal's, at the start."""
        raise NotImplementedError

    @property
    def reach(self) -> float:
        """Depth (m) that no contact has in a sound run."""
        raise NotImplementedError

    @property
    def deepest_start(self) -> tuple[float, str]:
        """Depth (m) at the start beyond which no contact law has a meaning, and what it is."""
        raise NotImplementedError
