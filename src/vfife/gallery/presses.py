"""Presses: a six-bar with a ram, and a toggle that a small force closes against a stiff work piece."""

from __future__ import annotations

import math

from ..model.loads import PointForce
from ..model.mechanism import Mechanism, Settings
from ..numerics.scalar import cos


def six_bar_press(*, speed: float = 2.0 * math.pi, turns: float = 1.0) -> Mechanism:
    """A crank-rocker whose hanging rocker, lengthened beyond its coupler pin, pushes a ram to and fro by a rod; speed of the crank in rad/s."""
    m = Mechanism("six-bar press", gravity=(0.0, -9.81), settings=Settings(turns=turns))
    m.point("A", 0.0, 0.0)
    m.point("D", 0.35, 0.05)
    m.point("guide", 0.70, -0.22)
    m.link("crank", length=0.08, mass=1.2)
    m.link("coupler", length=0.32, mass=3.0, angle=math.radians(-30.0))
    m.link("rocker", length=0.30, mass=5.0, angle=math.radians(-100.0), pins={"pin": (0.22, 0.0)})
    m.link("rod", length=0.45, mass=4.0, angle=0.0)
    m.rigid_body("ram", mass=20.0, inertia=0.1, position=(0.70, -0.22))
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    m.revolute("C", "coupler.end", "rocker.pin")
    m.revolute("D", "ground.D", "rocker.start")
    m.revolute("E", "rocker.end", "rod.start")
    m.revolute("F", "rod.end", "ram.center")
    m.slider("guide", "ground.guide", "ram.center")
    m.drive("crank", speed=speed)
    return m


def toggle_press(*, arm: float = 0.20, angle: float = math.radians(20.0), force: float = 400.0, stiffness: float = 2e5) -> Mechanism:
    """Two equal arms (m), bent by ``angle`` (rad) from their line, closed by a ``force`` (N) at the knee; the ram presses a work piece (N/m).

    A static analysis under a quarter, a half and the whole of the force.
    """
    m = Mechanism("toggle press", settings=Settings(analysis="static", load_factors=(0.25, 0.5, 0.75, 1.0)))
    reach = 2.0 * arm * cos(angle)
    m.point("top", 0.0, 0.0)
    m.point("guide", 0.0, -1.6 * arm)
    m.point("table", 0.0, -2.5 * arm)
    m.link("upper", length=arm, mass=2.0, angle=-0.5 * math.pi - angle)
    m.link("lower", length=arm, mass=2.0, angle=-0.5 * math.pi + angle)
    m.rigid_body("ram", mass=5.0, inertia=0.02, position=(0.0, -reach))
    m.revolute("top", "ground.top", "upper.start")
    m.revolute("knee", "upper.end", "lower.start")
    m.revolute("wrist", "lower.end", "ram.center")
    m.slider("guide", "ground.guide", "ram.center", direction=(0.0, 1.0))
    m.spring("work-piece", "ground.table", "ram.center", stiffness=stiffness)
    m.loads["hand"] = PointForce(name="hand", at="upper.end", force=(force, 0.0))
    return m
