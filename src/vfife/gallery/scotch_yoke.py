"""The Scotch yoke: a crank pin in a straight slot moves a slide harmonically."""

from __future__ import annotations

import math

from ..model.mechanism import Mechanism, Settings


def scotch_yoke(*, crank: float = 0.05, mass: float = 2.0, speed: float = 20.0 * math.pi, turns: float = 1.0) -> Mechanism:
    """x = crank cos(speed t): crank in m, mass of the yoke in kg, speed in rad/s. The crank's torque is -m r^2 w^2 sin(2 w t)/2."""
    m = Mechanism("Scotch yoke", settings=Settings(turns=turns))
    m.point("O", 0.0, 0.0)
    m.link("crank", length=crank, mass=0.5)
    half, arm = 1.3 * crank, 3.0 * crank
    ends = {"slot": (0.0, 0.0), "top": (0.0, half), "bottom": (0.0, -half), "rod": (arm, 0.0)}
    m.rigid_body("yoke", mass=mass, inertia=0.01, position=(crank, 0.0), pins=ends)
    m.revolute("O", "ground.O", "crank.start")
    m.slider("slot", "yoke.slot", "crank.end", direction=(0.0, 1.0), turning=True)
    m.slider("guide", "ground.O", "yoke.rod")
    m.drive("crank", speed=speed)
    return m
