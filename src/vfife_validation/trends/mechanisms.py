"""Mechanisms of the trends: slider-crank of the clearance literature, four-bar of the source paper."""

from __future__ import annotations

import math

from vfife import Mechanism
from vfife.laws import Ambrosio, FrictionLaw, Frictionless, Hertz, LankaraniNikravesh
from vfife.model.wear import Wear

from ..paper.mechanisms import Parameters, four_bar

CRANK, ROD, CRANK_MASS, ROD_MASS, BLOCK_MASS = 0.05, 0.12, 0.30, 0.21, 0.14  # m, m, kg, kg, kg
CRANK_INERTIA, ROD_INERTIA = 1.0e-4, 2.5e-4  # kg m2
BEARING_RADIUS, AXIAL_LENGTH = 10e-3, 20e-3  # m
DAMPING = "gonthier-exact"  # rebounds with the restitution, which Lankarani's and Nikravesh's does not
WEAR = 1e-15  # 1/Pa, of the bearing; wear is proportional to it
FRICTION, RESTITUTION = 0.1, 0.9
V0, V1 = 1e-3, 1e-2  # m/s, between which friction sets in
STIFFNESS = 6.6e10  # N/m^1.5, Sect. 4.1 of the paper
RPM = math.pi / 30.0  # rad/s


def friction_law(coefficient: float) -> FrictionLaw:
    """Coulomb friction that sets in between two speeds, or none."""
    return Ambrosio(coefficient=coefficient, v0=V0, v1=V1) if coefficient else Frictionless()


def slider_crank(
    clearance: float = 0.0, speed: float = 5000.0 * RPM, friction: float = FRICTION,
    restitution: float = RESTITUTION, load: float = 0.0,
) -> Mechanism:  # fmt: skip
    """Build the slider-crank with a clearance (m) between rod and block, or with an ideal pin for 0. ``load``
    (N) presses the block towards the crank.
    """
    m = Mechanism("slider-crank")
    m.point("O", 0.0, 0.0)
    m.link("crank", length=CRANK, mass=CRANK_MASS, inertia=CRANK_INERTIA)
    m.link("rod", length=ROD, mass=ROD_MASS, inertia=ROD_INERTIA)
    m.rigid_body("block", mass=BLOCK_MASS, inertia=1e-4, position=(CRANK + ROD, 0.0))
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("crankpin", "crank.end", "rod.start")
    if clearance:
        m.clearance_joint(
            "pin", "rod.end", "block.center", clearance=clearance, bearing_radius=BEARING_RADIUS,
            axial_length=AXIAL_LENGTH, contact=Hertz(restitution=restitution, damping=DAMPING),
            friction=friction_law(friction), wear=Wear(bearing=WEAR),
        )  # fmt: skip
    else:
        m.revolute("pin", "rod.end", "block.center")
    m.slider("guide", "ground.O", "block.center")
    if load:
        m.force("load", "block.center", force=(-load, 0.0))
    m.drive("crank", speed=speed)
    return m


def chain(loose: str, clearance: float, speed: float) -> Mechanism:
    """Build the four-bar of the paper with uniform rods and clearance (m) in the joints that ``loose`` names:
    B crank-coupler, C coupler-follower, D follower-ground.
    """
    parameters = Parameters(
        contact=LankaraniNikravesh(restitution=RESTITUTION, stiffness=STIFFNESS), axial_length=AXIAL_LENGTH,
        v0=1e-4, v1=V1, friction=FRICTION, link="uniform rods", friction_moment="mid-overlap",
    )  # fmt: skip
    return four_bar(parameters, clearance, speed, loose)
