"""Pendulums: two rigid rods, and a rod of soft rubber."""

from __future__ import annotations

import math

from ..laws import Material
from ..model.bodies import Section
from ..model.mechanism import Mechanism, Settings, StartSettings

GRAVITY = (0.0, -9.81)


def double_pendulum(
    *,
    lengths: tuple[float, float] = (0.5, 0.4),
    masses: tuple[float, float] = (1.0, 0.6),
    angles: tuple[float, float] = (0.0, math.radians(45.0)),
    duration: float = 2.0,
) -> Mechanism:
    """Two uniform rods (m, kg), let go at rest; angles in rad from the horizontal."""
    m = Mechanism("double pendulum", gravity=GRAVITY, settings=Settings(duration=duration, step=1e-4, outputs=400))
    m.point("O", 0.0, 0.0)
    for name, length, mass, angle in zip(("upper", "lower"), lengths, masses, angles, strict=True):
        m.link(name, length=length, mass=mass, angle=angle)
    m.revolute("O", "ground.O", "upper.start")
    m.revolute("elbow", "upper.end", "lower.start")
    return m


def elastic_pendulum(
    *,
    length: float = 1.2,
    diameter: float = 0.04,
    youngs_modulus: float = 0.7e6,
    density: float = 1100.0,
    elements: int = 12,
    duration: float = 0.8,
) -> Mechanism:
    """A round rod of soft rubber (m, Pa, kg/m^3), let go at rest from the horizontal."""
    m = Mechanism("elastic pendulum", gravity=GRAVITY, settings=Settings(duration=duration, outputs=400))
    m.point("O", 0.0, 0.0)
    rubber = Material(youngs_modulus=youngs_modulus, poissons_ratio=0.49, density=density)
    m.link("rod", length=length, model="elastic", elements=elements, section=Section.round(diameter), material=rubber)
    m.revolute("O", "ground.O", "rod.start")
    m.start = StartSettings(mode="rough")
    return m
