"""A journal that strikes its bearing: the smallest impact there is."""

from __future__ import annotations

from ..laws import ContactLaw, Frictionless, LankaraniNikravesh
from ..model.mechanism import Mechanism, Settings


def journal_in_bearing(*, mass: float = 1.0, speed: float = 1.0, clearance: float = 0.5e-3, contact: ContactLaw | None = None) -> Mechanism:
    """A journal (kg) flies from the middle of its fixed bearing against the wall (m/s) and rebounds."""
    m = Mechanism("journal in bearing", settings=Settings(duration=2.0 * clearance / speed, outputs=1000))
    m.point("O", 0.0, 0.0)
    m.point_mass("journal", mass=mass, velocity=(speed, 0.0, 0.0))
    law = contact or LankaraniNikravesh(restitution=0.9, stiffness=6.6e10)
    m.clearance("O", "ground.O", "journal.center", clearance=clearance, bearing_radius=0.010, contact=law, friction=Frictionless())
    return m
