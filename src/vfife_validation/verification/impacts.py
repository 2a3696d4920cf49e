"""Contacts: restitution, contact time and depth, sliding and rolling, a redundant chain."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from vfife.laws import Ambrosio, Frictionless, Hertz, HuntCrossley, LankaraniNikravesh
from vfife.model.mechanism import Mechanism

from .case import Nudge, Row, Rows, verified
from .case_motion import CaseMotion, run
from .lagrange import solved

HERTZ = (
    "Hertz: closed form δ = (5 m v²/4K)^(2/5), 2.94 δ/v; restitution e solves χ(1 + e) = ln[(1 + χ)/(1 - χe)]"
)
K = 6.6e10  # N/m^1.5


def delivered(chi: float) -> float:
    """Restitution that a damping factor really gives, by bisection of chi (1 + e) = ln((1 + chi)/(1 - chi
    e)).
    """
    low, high = 0.0, 1.0
    for _ in range(80):
        e = 0.5 * (low + high)
        low, high = (e, high) if chi * (1.0 + e) > math.log((1.0 + chi) / (1.0 - chi * e)) else (low, e)
    return 0.5 * (low + high)


def contact_time(motion: CaseMotion, joint: str) -> float:
    """Time (s) of the first contact."""
    return float(motion.contact(joint, "duration")[-1])


@verified(
    "Journal against its bearing",
    HERTZ + "; numbers for 1 kg at 1 m/s, Lankarani-Nikravesh, 0.9",
    nudges={"stiffness": 1.02, "restitution": 0.98},
)
def journal_impact(nudge: Nudge) -> Rows:
    """Contact time, depth, peak force and rebound of 1 kg at 1 m/s."""
    m = Mechanism("journal in bearing")
    m.point("O", 0.0, 0.0)
    m.point_mass("journal", mass=1.0, velocity=(1.0, 0.0, 0.0))
    law = LankaraniNikravesh(restitution=0.9 * nudge("restitution"), stiffness=K * nudge("stiffness"))
    m.clearance_joint(
        "J",
        "ground.O",
        "journal.center",
        clearance=5e-4,
        bearing_radius=0.01,
        contact=law,
        friction=Frictionless(),
    )
    motion = run(m, step=5e-8, duration=8e-4, outputs=1600)
    force = np.sqrt(motion.contact("J", "force_squared_max").max())
    yield Row("contact time", "s", 1.5277e-4, contact_time(motion, "J"), 1e-3)
    yield Row("depth", "m", 4.9585e-5, float(motion.contact("J", "penetration_max").max()), 1e-3)
    yield Row("peak force", "N", 2.3221e4, float(force), 1e-3)
    yield Row("rebound", "m/s", -0.913177, float(motion.speed("journal", "u")[-1]), 1e-3)


@verified(
    "Ball on a plate and ball on ball",
    HERTZ,
    nudges={"stiffness": 1.02, "restitution": 0.95, "damping": 10.0},
)
def ball_bounce(nudge: Nudge) -> Rows:
    """External contacts: an elastic bounce, one with Hunt-Crossley 0.5, and two balls of 1 and 3 kg that
    meet.
    """
    k = 1e9 * nudge("stiffness")
    laws = {
        "elastic": Hertz(stiffness=k),
        "lossy": HuntCrossley(restitution=0.5 * nudge("restitution"), stiffness=k),
    }
    for name, law in laws.items():
        m = Mechanism("ball on a plate")
        m.point("O", 0.0, 0.0)
        m.point_mass("ball", mass=0.5, position=(0.0, 0.0205), velocity=(0.0, -2.0, 0.0))
        m.external_contact(
            "J", "ground.O", "ball.center", journal_radius=0.02, contact=law, friction=Frictionless()
        )
        m.settings = dataclasses.replace(m.settings, damping=nudge("damping", 0.0))
        motion = run(m, step=1e-7, duration=2e-3, outputs=2000)
        deepest = (5.0 * 0.5 * 4.0 / (4.0 * 1e9)) ** 0.4
        chi = 0.75 if name == "lossy" else 0.0
        yield Row(
            f"rebound, {name}",
            "m/s",
            2.0 * (delivered(chi) if chi else 1.0),
            float(motion.speed("ball", "v")[-1]),
            1e-3,
        )
        if not chi:
            yield Row("depth", "m", deepest, float(motion.contact("J", "penetration_max").max()), 1e-3)
            yield Row("contact time", "s", 2.9432751 * deepest / 2.0, contact_time(motion, "J"), 1e-3)
    m = Mechanism("ball on ball")
    m.point_mass("a", mass=1.0, position=(0.0, 0.0), velocity=(3.0, 0.0, 0.0))
    m.point_mass("b", mass=3.0, position=(0.0505, 0.0))
    m.external_contact(
        "J",
        "a.center",
        "b.center",
        bearing_radius=0.03,
        journal_radius=0.02,
        contact=laws["lossy"],
        friction=Frictionless(),
    )
    motion = run(m, step=1e-7, duration=2e-3, outputs=2000)
    e = delivered(0.75)
    yield Row(
        "speed of the 1 kg ball",
        "m/s",
        3.0 * (1.0 - 3.0 * e) / 4.0,
        float(motion.speed("a", "u")[-1]),
        2e-3,
        3.0,
    )
    yield Row("speed of the 3 kg ball", "m/s", 3.0 * (1.0 + e) / 4.0, float(motion.speed("b", "u")[-1]), 2e-3)


def incline(angle: float, friction: float, inertia: float) -> tuple[CaseMotion, float]:
    """Run a cylinder of 2 kg and radius 50 mm on a slope, placed at the penetration of its weight; returns
    the motion and the distance (m) after 0.5 s.
    """
    mass, r, g = 2.0, 0.05, 9.81
    m = Mechanism("incline", gravity=(0.0, -g))
    m.point("O", 0.0, 0.0)
    c, s = math.cos(angle), math.sin(angle)
    high = r - (mass * g * c / 1e9) ** (2.0 / 3.0)
    m.rigid_body("round", mass=mass, inertia=inertia, position=(high * s, high * c))
    law, rough = (
        HuntCrossley(restitution=0.5, stiffness=1e9),
        Ambrosio(coefficient=friction, v0=1e-6, v1=1e-4),
    )
    m.external_contact(
        "J", "ground.O", "round.center", journal_radius=r, direction=(c, -s), contact=law, friction=rough
    )
    motion = run(m, step=5e-6, duration=0.5, outputs=500)
    way = (motion.body("round", "x") - high * s) * c - (motion.body("round", "y") - high * c) * s
    return motion, float(way[-1])


@verified(
    "Round on an incline",
    "closed form: g (sin α - μ cos α) sliding, g sin α/(1 + I/m r²) rolling",
    nudges={"friction": 1.02, "inertia": 1.01},
)
def round_on_an_incline(nudge: Nudge) -> Rows:
    """Compare a cylinder on an incline: it slides where friction is too small for rolling (its spin grows by
    μ g cos α m r/I), and rolls where it is not.
    """
    angle, mu, g, mass, r = 0.5, 0.1, 9.81, 2.0, 0.05
    inertia = 0.5 * mass * r * r
    motion, way = incline(angle, mu * nudge("friction"), inertia * nudge("inertia"))
    yield Row(
        "way of the one that slides in 0.5 s",
        "m",
        0.125 * g * (math.sin(angle) - mu * math.cos(angle)),
        way,
        1e-3,
    )
    spun = -0.125 * mu * mass * g * math.cos(angle) * r / inertia
    yield Row("turn of the one that slides", "rad", spun, float(motion.body("round")[-1]), 2e-3)
    motion, way = incline(angle, 0.6, inertia * nudge("inertia"))
    yield Row("way of the one that rolls in 0.5 s", "m", 0.125 * g * math.sin(angle) / 1.5, way, 1e-3)
    yield Row(
        "turn of the one that rolls",
        "rad",
        -0.125 * g * math.sin(angle) / 1.5 / r,
        float(motion.body("round")[-1]),
        1e-3,
    )


@verified(
    "Parallelogram with a redundant crank",
    "closed form: pendulum of three rods and a beam; forces by Newton's law",
    nudges={"mass": 1.01},
)
def redundant_parallelogram(nudge: Nudge) -> Rows:
    """Three equal cranks carry a beam, one more than it needs: angle, and the sum of the forces on the beam,
    which redundancy cannot change.
    """
    g, l, rod, beam = 9.81, 0.5, 1.0, 4.0
    m = Mechanism("parallelogram with three cranks", gravity=(0.0, -g))
    points = {f"p{k}": (0.4 * k, 0.0) for k in range(3)}
    start = -1.0
    m.rigid_body(
        "beam",
        mass=beam * nudge("mass"),
        inertia=0.3,
        pins=points,
        center=(0.3, 0.1),
        position=(l * math.cos(start), l * math.sin(start)),
    )
    for k in range(3):
        m.point(f"O{k}", 0.4 * k, 0.0)
        m.link(f"crank{k}", length=l, mass=rod, angle=start, position=(0.4 * k, 0.0))
        m.revolute(f"A{k}", f"ground.O{k}", f"crank{k}.start")
        m.revolute(f"B{k}", f"crank{k}.end", f"beam.p{k}")
    motion = run(m, step=1e-4, duration=0.6, outputs=600)
    inertia, weight = 3.0 * rod * l * l / 3.0 + beam * l * l, g * l * (1.5 * rod + beam)
    ((angle, speed),) = solved(
        lambda t, y: np.array([y[1], -weight * math.cos(y[0]) / inertia]), [start, 0.0], np.array([0.6])
    )
    yield Row("angle at 0.6 s", "rad", angle, float(motion.body("crank1")[-1]), 1e-4)
    alpha = -weight * math.cos(angle) / inertia
    pulls = (
        -l * (alpha * math.sin(angle) + speed**2 * math.cos(angle)),
        l * (alpha * math.cos(angle) - speed**2 * math.sin(angle)) + g,
    )
    for axis, pull in zip("xy", pulls, strict=True):
        total = sum(float(motion.ideal(f"B{k}", f"f{axis}")[-1]) for k in range(3))
        yield Row(f"sum of the forces on the beam in {axis} at 0.6 s", "N", beam * pull, total, 1e-3)
