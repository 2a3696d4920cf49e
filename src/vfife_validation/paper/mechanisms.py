"""The paper's mechanisms: a journal in a fixed bearing (Sect. 4.1) and the four-bar of Table 1 with one or
three loose joints.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from vfife.laws import Ambrosio, ContactLaw, FrictionLaw, Frictionless, Pereira
from vfife.model.bodies import Section
from vfife.model.joints import ClearanceRevolute, FrictionMoment
from vfife.model.lumping import rigidified
from vfife.model.mechanism import Mechanism, Settings

GROUND, CRANK, COUPLER, FOLLOWER = 0.150, 0.400, 0.260, 0.460  # m, Table 1
MASSES = {"crank": 3.120, "coupler": 2.028, "follower": 3.588}  # kg, Table 1
BEARING_RADIUS, JOURNAL_RADIUS = 10e-3, 9.5e-3  # m, Sect. 4.1
STIFFNESS = 6.6e10  # N/m^1.5, Sect. 4.1
FRICTION = 0.1  # Sect. 5
CLEARANCES = (0.1e-3, 0.2e-3, 0.5e-3)  # m, Sect. 5.1
SPEEDS = (10.0 * math.pi, 20.0 * math.pi, 50.0 * math.pi)  # rad/s, Sect. 5.2
FASTEST = SPEEDS[-1]
CLEARANCE = CLEARANCES[1]  # m, of Sect. 5.2
SECTION = Section.square(
    1e-3
)  # m^2: what 7.8 kg/m of Table 1 are in steel; the shape of the section is a choice
JOINTS = {"B": "joint 1", "C": "joint 2", "D": "joint 3"}  # the paper's names

# Link models: what an elastic or two-particle link is made of beside its length and mass.
LINKS: dict[str, dict[str, Any]] = {
    "stiff bars": {
        "model": "two-particle",
        "section": SECTION,
        "strain": "current",
        "release": "both",
        "stiffness_factor": 1000.0,
    },
    "bars": {"model": "two-particle", "section": SECTION, "strain": "current", "release": "both"},
    "rigid bars": {"model": "two-particle", "section": SECTION, "strain": "current", "release": "both"},
    "uniform rods": {"model": "rigid"},
    "frames of 2": {"model": "elastic", "section": SECTION, "strain": "current", "elements": 2},
    "frames of 4": {"model": "elastic", "section": SECTION, "strain": "current", "elements": 4},
    "frames of 8": {"model": "elastic", "section": SECTION, "strain": "current", "elements": 8},
}
LINK_WORDS = {
    "stiff bars": (
        "two particles and one bar a link (Fig. 1, release at both nodes), EA = 2.07e11 N: a thousand times"
        " that of the steel section"
    ),
    "bars": "two particles and one bar a link, EA = 2.07e8 N as of a steel section of 1e-3 m²",
    "rigid bars": "two particles a link, rigidly joined",
    "uniform rods": "rigid uniform rods",
    "frames of 2": "2 frame elements a link, the real section (square, 1e-3 m²)",
    "frames of 4": "4 frame elements a link, the real section (square, 1e-3 m²)",
    "frames of 8": "8 frame elements a link, the real section (square, 1e-3 m²)",
}


@dataclass(frozen=True)
class Parameters:
    """What the lost Table 2 and Fig. 11 would have told: everything but lengths, masses, clearance, crank
    speed and the friction coefficient.

    ``below``: joint C starts, and stays, on the side of line B-D that lies below it at crank angle zero.
    ``crank_angle`` (rad) is that of the start. SI units.
    """

    contact: ContactLaw = field(default_factory=lambda: Pereira(restitution=0.5))
    axial_length: float = 5e-3
    v0: float = 0.01
    v1: float = 0.1
    friction: float = FRICTION
    link: str = "stiff bars"
    friction_moment: FrictionMoment = "off"
    bearing_radius: float = BEARING_RADIUS
    below: bool = True
    crank_angle: float = 0.0

    @property
    def friction_law(self) -> FrictionLaw:
        """The paper's modified Coulomb law."""
        return (
            Ambrosio(coefficient=self.friction, v0=self.v0, v1=self.v1) if self.friction else Frictionless()
        )


def directions(crank_angle: float, is_below: bool) -> tuple[float, float]:
    """Angles (rad) of coupler and follower at a crank angle, on one of the two branches of the linkage."""
    bx, by = CRANK * math.cos(crank_angle), CRANK * math.sin(crank_angle)
    dx, dy = GROUND - bx, -by
    distance = math.hypot(dx, dy)
    projection = (COUPLER**2 - FOLLOWER**2 + distance**2) / (2.0 * distance)
    across = math.sqrt(COUPLER**2 - projection**2) * (1.0 if is_below else -1.0)
    cx = bx + (projection * dx - across * dy) / distance
    cy = by + (projection * dy + across * dx) / distance
    return math.atan2(cy - by, cx - bx), math.atan2(cy, cx - GROUND)


def four_bar(p: Parameters, clearance: float, speed: float = FASTEST, loose: str = "BCD") -> Mechanism:
    """Build the four-bar of Table 1 with clearance (m) in the joints that ``loose`` names and a crank at
    ``speed`` (rad/s).

    Steps are never divided, as in the paper.
    """
    m = Mechanism("four-bar of the paper", settings=Settings(parts=1))
    m.point("A", 0.0, 0.0)
    m.point("D", GROUND, 0.0)
    coupler, follower = directions(p.crank_angle, p.below)
    m.link("crank", length=CRANK, mass=MASSES["crank"], angle=p.crank_angle)
    m.link("coupler", length=COUPLER, mass=MASSES["coupler"], angle=coupler, **LINKS[p.link])
    m.link("follower", length=FOLLOWER, mass=MASSES["follower"], angle=follower, **LINKS[p.link])
    if p.link == "rigid bars":
        m.bodies.update({name: rigidified(body) for name, body in m.bodies.items()})
    m.revolute("A", "ground.A", "crank.start")
    for name, bearing, journal in (
        ("B", "crank.end", "coupler.start"),
        ("C", "coupler.end", "follower.end"),
        ("D", "ground.D", "follower.start"),
    ):
        m.revolute(name, bearing, journal)
    m.joints.update({name: joint for name, joint in loosened(p, m, clearance).items() if name in loose})
    m.drive("crank", speed=speed)
    return m


def loosened(p: Parameters, mechanism: Mechanism, clearance: float) -> dict[str, Any]:
    """Joints B, C and D with clearance (m)."""
    return {
        name: ClearanceRevolute(
            name=name, bearing=mechanism.joints[name].bearing, journal=mechanism.joints[name].journal,
            clearance=clearance,
            bearing_radius=p.bearing_radius, axial_length=p.axial_length, contact=p.contact,
            friction=p.friction_law,
            friction_moment=p.friction_moment,
        )
        for name in JOINTS
    }  # fmt: skip


def journal(
    contact: ContactLaw, *, axial_length: float = 0.02, mass: float = 1.0, speed: float = 1.0
) -> Mechanism:
    """Build a journal that leaves the centre of a fixed bearing at ``speed`` (m/s), with the radii of Sect.
    4.1, without gravity and friction.
    """
    m = Mechanism("journal in a fixed bearing")
    m.point("O", 0.0, 0.0)
    m.point_mass("journal", mass=mass, velocity=(speed, 0.0, 0.0))
    m.clearance_joint(
        "O", "ground.O", "journal.center", clearance=BEARING_RADIUS - JOURNAL_RADIUS,
        bearing_radius=BEARING_RADIUS,
        axial_length=axial_length, contact=contact, friction=Frictionless(),
    )  # fmt: skip
    return m
