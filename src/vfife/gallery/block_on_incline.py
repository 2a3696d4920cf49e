"""A block slides down an incline on two round feet."""

from __future__ import annotations

import math

from ..laws import Coulomb, FrictionLaw
from ..model.mechanism import Mechanism, Settings
from ..numerics.scalar import sincos


def block_on_incline(
    *, slope: float = math.radians(30.0), friction: float = 0.3, mass: float = 2.0, duration: float = 0.5, law: FrictionLaw | None = None
) -> Mechanism:
    """From rest it slides g (sin(slope) - friction cos(slope)) t^2/2, or stays where the friction is larger than tan(slope)."""
    m = Mechanism("block on an incline", gravity=(0.0, -9.81), settings=Settings(duration=duration, outputs=250))
    s, c = sincos(slope)
    radius, foot, height = 0.01, 0.06, 0.04
    rise = radius + height  # of the centre of mass over the surface
    m.point("incline", 0.0, 0.0)
    m.rigid_body(
        "block", mass=mass, inertia=mass * 0.004, angle=slope, position=(-s * rise, c * rise),
        pins={"lower": (-foot, -height), "upper": (foot, -height)},
    )  # fmt: skip
    for name in ("lower", "upper"):
        m.external_contact(
            name, "ground.incline", f"block.{name}", journal_radius=radius, direction=(c, s), friction=law or Coulomb(coefficient=friction)
        )
    return m
