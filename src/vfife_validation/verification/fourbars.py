"""The four-bar of the clearance literature: ideal maxima, and maxima with one and with three clearance
joints.
"""

from __future__ import annotations

import math

import numpy as np

from vfife.laws import Ambrosio, LankaraniNikravesh
from vfife.model.bodies import LinkModel, Section
from vfife.model.mechanism import Mechanism

from .case import Nudge, Row, Rows, verified
from .case_motion import run

IDEAL = (
    "drag link of the VFIFE clearance paper (Table 1), maxima by rigid-body kinetics of an independent"
    " program"
)
CLEAR = (
    "independent Runge-Kutta of order 4 with located onsets, 3.2 million steps; maxima over the second turn"
)
LENGTHS = {"crank": 0.4, "coupler": 0.26, "follower": 0.46}


def four_bar(
    clear: str,
    speed: float,
    mass: float = 1.0,
    model: LinkModel = "rigid",
    play: float = 2e-4,
    restitution: float = 0.9,
) -> Mechanism:
    """Ground 0.15 m, 7.8 kg/m; the joints named in ``clear`` with clearance (m)."""
    m = Mechanism("four-bar")
    m.point("A", 0.0, 0.0)
    m.point("D", 0.15, 0.0)
    for (name, length), angle in zip(LENGTHS.items(), (0.0, 0.89, 0.454), strict=True):
        heavy = mass if name == "follower" else 1.0
        chosen: LinkModel = model if name != "crank" else "rigid"
        section = Section(1e-3, 1e-12) if name != "crank" else None
        m.link(name, length=length, mass=7.8 * length * heavy, angle=angle, model=chosen, section=section)
    m.revolute("A", "ground.A", "crank.start")
    law = LankaraniNikravesh(restitution=restitution, stiffness=6.6e10)
    sliding = Ambrosio(coefficient=0.1, v0=1e-4, v1=1e-2)
    for name, bearing, journal in (
        ("B", "crank.end", "coupler.start"),
        ("C", "coupler.end", "follower.end"),
        ("D", "ground.D", "follower.start"),
    ):
        if name in clear:
            m.clearance_joint(
                name, bearing, journal, clearance=play, bearing_radius=0.01, contact=law, friction=sliding
            )
        else:
            m.revolute(name, bearing, journal)
    m.drive("crank", speed=speed)
    return m


@verified("Four-bar with ideal joints", IDEAL, nudges={"mass": 1.005, "speed": 1.002})
def four_bar_ideal(nudge: Nudge) -> Rows:
    """Largest angular acceleration of the follower and joint forces over a turn: uniform rods at three
    speeds, two-particle links at 50π rad/s.
    """
    rods = {
        10: (912.642, 1577.0, 2613.5, 4538.6),
        20: (3650.57, 6308.1, 10454.1, 18154.4),
        50: (22816.05, 39425.3, 65338.1, 113464.7),
    }
    for factor, reference in rods.items():
        speed = factor * math.pi
        yield from _maxima(
            four_bar("", speed * nudge("speed"), nudge("mass")), f"{factor}π rad/s", reference, speed
        )
    speed = 50.0 * math.pi
    lumped = four_bar("", speed * nudge("speed"), nudge("mass"), "two-particle").ideal()
    lumped.bodies["crank"] = four_bar("", speed).bodies["crank"]
    yield from _maxima(lumped, "50π rad/s, masses at the ends", (22816.05, 61728.8, 89430.6, 135858.1), speed)


def _maxima(m: Mechanism, position: str, references: tuple[float, ...], speed: float) -> Rows:
    motion = run(m, turns=1.0, step=2.0 * math.pi / speed / 7200, outputs=7200)
    values = [
        float(motion.record.block("body_alpha_max")[:, motion.record.assembly.bodies["follower"].row].max())
    ]
    values += [float(np.sqrt(motion.ideal(joint, "force_squared_max").max())) for joint in "BCD"]
    names = (("follower acceleration", "rad/s²"), *((f"force of joint {joint}", "N") for joint in "BCD"))
    for (name, unit), reference, value in zip(names, references, values, strict=True):
        yield Row(f"largest {name} at {position}", unit, reference, value, 1e-3)


@verified(
    "Four-bar with one and with three clearance joints",
    CLEAR,
    nudges={"mass": 1.02, "clearance": 1.1, "restitution": 0.8},
    quick=False,
)
def four_bar_with_play(nudge: Nudge) -> Rows:
    """Uniform rods at 50π rad/s, 0.2 mm, friction 0.1: maxima over the second turn with a step of 0.25 µs."""
    for clear, alpha, force in (("C", 29201.05, 65794.78), ("BCD", 38153.31, 68842.16)):
        m = four_bar(
            clear,
            50.0 * math.pi,
            nudge("mass"),
            play=2e-4 * nudge("clearance"),
            restitution=0.9 * nudge("restitution"),
        )
        motion = run(m, turns=2.0, step=2.5e-7, outputs=720, force_step=True)
        second = motion.time > 0.04 + 1e-7
        largest = motion.record.block("body_alpha_max")[
            second, motion.record.assembly.bodies["follower"].row
        ].max()
        yield Row(f"largest follower acceleration, play in {clear}", "rad/s²", alpha, float(largest), 5e-3)
        yield Row(
            f"largest force of joint C, play in {clear}",
            "N",
            force,
            float(np.sqrt(motion.contact("C", "force_squared_max")[second].max())),
            1e-3,
        )
