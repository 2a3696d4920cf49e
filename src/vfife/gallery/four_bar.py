"""The four-bar of the VFIFE paper on clearance joints (its Table 1): a drag link, whose crank and follower both turn fully."""

from __future__ import annotations

import math
from typing import Any

from ..laws import Ambrosio, LankaraniNikravesh, Pereira
from ..model.bodies import Section
from ..model.mechanism import Mechanism, Settings

SPEED = 50.0 * math.pi  # rad/s, the paper's fastest
JOINTS = (("B", "crank.end", "coupler.start"), ("C", "coupler.end", "follower.end"), ("D", "ground.D", "follower.start"))


def four_bar(*, clearance: float = 0.2e-3, loose: str = "BCD", speed: float = SPEED, turns: float = 8.0) -> Mechanism:
    """Four-bar with play in the joints that ``loose`` names, two-particle bars, and the contact parameters inferred from the paper's Table 3.

    Joint C lies below the line of the ground's pivots. ``clearance`` in m, ``speed`` of the crank in rad/s.
    """
    joint = {
        "contact": Pereira(restitution=0.5),
        "friction": Ambrosio(coefficient=0.1, v0=0.01, v1=0.1),
        "axial_length": 0.005,
        "friction_moment": "off",
    }
    bar = {"model": "two-particle", "section": Section.square(1e-3), "stiffness_factor": 1000.0, "release": "both", "strain": "current"}
    return _linkage("four-bar, three clearance joints", loose, -1.0, speed, turns, {"clearance": clearance} | joint, bar)


def four_bar_ideal(*, speed: float = SPEED, turns: float = 2.0) -> Mechanism:
    """Four-bar with rigid links and ideal joints, joint C above the line of the ground's pivots."""
    return _linkage("four-bar, ideal", "", 1.0, speed, turns, {}, {})


def four_bar_case_b(*, clearance: float = 0.2e-3, speed: float = SPEED, turns: float = 2.0) -> Mechanism:
    """Four-bar with rigid links and one clearance joint, C: reference case b."""
    return _linkage("four-bar, case b", "C", 1.0, speed, turns, {"clearance": clearance} | _reference_laws(), {})


def four_bar_case_c(*, clearance: float = 0.2e-3, speed: float = SPEED, turns: float = 2.0) -> Mechanism:
    """Four-bar with rigid links and three clearance joints, B, C and D: reference case c."""
    return _linkage("four-bar, case c", "BCD", 1.0, speed, turns, {"clearance": clearance} | _reference_laws(), {})


def _reference_laws() -> dict[str, Any]:
    return {"contact": LankaraniNikravesh(restitution=0.9, stiffness=6.6e10), "friction": Ambrosio(coefficient=0.1, v0=1e-4, v1=1e-2)}


def _linkage(name: str, loose: str, side: float, speed: float, turns: float, play: dict[str, Any], bar: dict[str, Any]) -> Mechanism:
    m = Mechanism(name, settings=Settings(turns=turns))
    m.point("A", 0.0, 0.0)
    m.point("D", 0.150, 0.0)
    m.link("crank", length=0.400, mass=3.120)
    m.link("coupler", length=0.260, mass=2.028, angle=side * math.radians(51.0), **bar)
    m.link("follower", length=0.460, mass=3.588, angle=side * math.radians(26.0), **bar)
    m.revolute("A", "ground.A", "crank.start")
    for joint, bearing, journal in JOINTS:
        if joint in loose:
            m.clearance(joint, bearing, journal, bearing_radius=0.010, **play)
        else:
            m.revolute(joint, bearing, journal)
    m.drive("crank", speed=speed)
    return m
