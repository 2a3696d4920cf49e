"""The crank-shaper: a crank pin in the slot of a rocker goes forth slowly and back quickly."""

from __future__ import annotations

import math

from ..model.mechanism import Mechanism, Settings
from ..numerics.scalar import atan2


def quick_return(
    *, crank: float = 0.10, distance: float = 0.25, rocker: float = 0.50, speed: float = 2.0 * math.pi, turns: float = 1.0
) -> Mechanism:
    """A crank (m) turns at ``distance`` (m) above the pivot of a slotted rocker (m), which moves a ram through a link; speed in rad/s.

    The guide moves: the slot is on the rocker. Times of stroke and return are as (pi + 2 asin(crank/distance)) to (pi - 2 asin(crank/distance)).
    """
    m = Mechanism("quick return", settings=Settings(turns=turns))
    m.point("P", 0.0, 0.0)
    m.point("O", 0.0, distance)
    m.point("guide", 0.0, 1.02 * rocker)
    m.link("crank", length=crank, mass=1.0)
    m.link("rocker", length=rocker, mass=3.0, angle=atan2(distance, crank))
    m.link("link", length=0.4 * rocker, mass=0.6, angle=math.pi)
    m.rigid_body("ram", mass=8.0, inertia=0.05, position=(-0.1 * rocker, 1.02 * rocker))
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("P", "ground.P", "rocker.start")
    m.slider("slot", "rocker.start", "crank.end", direction=(1.0, 0.0), turning=True)
    m.revolute("Q", "rocker.end", "link.start")
    m.revolute("R", "link.end", "ram.center")
    m.slider("guide", "ground.guide", "ram.center")
    m.drive("crank", speed=speed)
    return m
