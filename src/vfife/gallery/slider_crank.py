"""Slider-cranks with the dimensions of a much used benchmark: crank 50 mm, rod 120 mm, a light block."""

from __future__ import annotations

from typing import Any

from ..laws import Ambrosio, Frictionless, LankaraniNikravesh
from ..model.bodies import RigidBody
from ..model.mechanism import Mechanism, Settings

CRANK, ROD = 0.050, 0.120  # m


def slider_crank(*, speed: float = 100.0, turns: float = 1.0) -> Mechanism:
    """Slider-crank with ideal joints; speed of the crank in rad/s."""
    m = _crank_and_rod("slider-crank", speed, turns)
    m.revolute("pin", "rod.end", "block.center")
    m.slider("guide", "ground.O", "block.center")
    return m


def slider_crank_loose_pin(
    *, clearance: float = 0.5e-3, restitution: float = 0.9, friction: float = 0.0, speed: float = 100.0, turns: float = 0.5
) -> Mechanism:
    """Slider-crank whose pin between rod and block has play (m)."""
    m = _crank_and_rod("slider-crank with a loose pin", speed, turns)
    m.clearance("pin", "rod.end", "block.center", clearance=clearance, bearing_radius=0.010, **_surfaces(restitution, friction))
    m.slider("guide", "ground.O", "block.center")
    return m


def slider_crank_loose_guide(
    *, clearance: float = 0.5e-3, restitution: float = 0.9, friction: float = 0.0, speed: float = 100.0, turns: float = 0.5
) -> Mechanism:
    """Slider-crank whose block, 60 mm by 30 mm, has play (m, on each side) in its guide; the pin lies 10 mm behind the middle of the block."""
    m = _crank_and_rod("slider-crank with a loose guide", speed, turns)
    m.bodies["block"] = RigidBody(name="block", mass=0.14, inertia=1.0e-4, position=(CRANK + ROD + 0.010, 0.0), pins={"pin": (-0.010, 0.0)})
    m.revolute("pin", "rod.end", "block.pin")
    surfaces = _surfaces(restitution, friction)
    m.clearance_slider("guide", "ground.O", "block.center", clearance=clearance, length=0.060, height=0.030, **surfaces)
    return m


def _crank_and_rod(name: str, speed: float, turns: float) -> Mechanism:
    m = Mechanism(name, settings=Settings(turns=turns))
    m.point("O", 0.0, 0.0)
    m.link("crank", length=CRANK, mass=0.30, inertia=1.0e-4)
    m.link("rod", length=ROD, mass=0.21, inertia=2.5e-4)
    m.rigid_body("block", mass=0.14, inertia=1.0e-4, position=(CRANK + ROD, 0.0))
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("crankpin", "crank.end", "rod.start")
    m.drive("crank", speed=speed)
    return m


def _surfaces(restitution: float, friction: float) -> dict[str, Any]:
    rub = Ambrosio(coefficient=friction, v0=1e-4, v1=1e-2) if friction else Frictionless()
    return {"contact": LankaraniNikravesh(restitution=restitution), "friction": rub}
