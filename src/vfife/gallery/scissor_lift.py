"""A scissor lift, free of redundant constraints: one fixed and one rolling foot below, one fixed and one rolling head above."""

from __future__ import annotations

import math

from ..model.drivers import StepTo
from ..model.mechanism import Mechanism, Settings
from ..numerics.scalar import cos, sin


def scissor_lift(
    *, arm: float = 1.0, angle: float = math.radians(20.0), travel: float = -0.3, duration: float = 2.0, load: float = 200.0, mass: float = 5.0
) -> Mechanism:
    """Two stages of crossed arms (m, kg each) lift a platform (kg) while an actuator pulls the rolling foot in by ``travel`` (m) within s."""
    m = Mechanism("scissor lift", gravity=(0.0, -9.81), settings=Settings(duration=duration, outputs=400, step=2e-4))
    wide, tall = arm * cos(angle), arm * sin(angle)
    m.point("fixed", 0.0, 0.0)
    m.point("track", 0.0, 0.0)
    middle = {"middle": (0.5 * arm, 0.0)}
    for name, side in (("rising-1", 1.0), ("falling-1", -1.0), ("rising-2", 1.0), ("falling-2", -1.0)):
        m.link(name, length=arm, mass=mass, angle=side * angle, pins=middle)
    m.rigid_body(
        "platform", mass=load, inertia=20.0, center=(0.5 * wide, 0.1), position=(0.0, 2.0 * tall), pins={"fixed": (0.0, 0.0), "edge": (arm, 0.0)}
    )
    m.revolute("foot", "ground.fixed", "rising-1.start")
    m.slider("roller", "ground.track", "falling-1.end", turning=True)
    m.revolute("cross-1", "rising-1.middle", "falling-1.middle")
    m.revolute("left", "falling-1.start", "rising-2.start")
    m.revolute("right", "rising-1.end", "falling-2.end")
    m.revolute("cross-2", "rising-2.middle", "falling-2.middle")
    m.revolute("head", "platform.fixed", "falling-2.start")
    m.slider("head-roller", "platform.fixed", "rising-2.end", turning=True)
    m.drivers["actuator"] = StepTo(slider="roller", travel=travel, duration=duration)
    return m
