"""Sliders: on the ground, on moving bodies, as slots, with clearance."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from vfife.laws import Ambrosio, LankaraniNikravesh
from vfife.model.drivers import ConstantSpeed
from vfife.model.mechanism import Mechanism

from .case import Nudge, Row, Rows, verified
from .case_motion import CaseMotion, run
from .chaotic import striking
from .lagrange import solved

MEMORY = (
    "slider-crank of the clearance literature (5000 rpm; data from memory), ideal values by rigid-body"
    " kinetics"
)
FLORES = (
    "Flores, Leine, Glocker: Modeling and analysis of planar rigid multibody systems with translational"
    " clearance joints based on the non-smooth dynamics approach. Multibody Syst. Dyn. 23 (2010) 165-190"
)
CLOSED = "closed form"


def slider_crank(
    crank: tuple[float, float, float],
    rod: tuple[float, float, float],
    block: tuple[float, float],
    g: float = 0.0,
) -> Mechanism:
    """Length, mass and inertia of crank and rod; mass and inertia of the block, which runs along x through
    the crank's pivot.
    """
    m = Mechanism("slider-crank", gravity=(0.0, -g))
    m.point("O", 0.0, 0.0)
    for name, (length, mass, inertia) in (("crank", crank), ("rod", rod)):
        m.link(name, length=length, mass=mass, inertia=inertia)
    m.rigid_body("block", mass=block[0], inertia=block[1], position=(crank[0] + rod[0], 0.0))
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "rod.start")
    m.revolute("C", "rod.end", "block.center")
    return m


def ideal_values(nudge: Nudge, m: Mechanism, speed: float, references: dict[str, float]) -> Rows:
    """Extremes over one turn at constant speed."""
    m.slider("S", "ground.O", "block.center")
    m.drive("crank", speed=speed * nudge("speed"))
    motion = run(m, turns=1.0, step=2.0 * math.pi / speed / 7200, outputs=3600)
    a, torque = motion.particle("particle_ax", "block"), motion.driven("crank", "torque")
    force = {
        joint: float(np.hypot(motion.ideal(joint, "fx"), motion.ideal(joint, "fy")).max()) for joint in "BC"
    }
    values = {
        "least slider acceleration": (float(a.min()), "m/s²"),
        "largest slider acceleration": (float(a.max()), "m/s²"),
        "largest force rod-slider": (force["C"], "N"), "largest force crank-rod": (force["B"], "N"),
        "least crank torque": (float(torque.min()), "N m"), "largest crank torque": (float(torque.max()),
        "N m"),
    }  # fmt: skip
    for quantity, reference in references.items():
        value, unit = values[quantity]
        yield Row(quantity, unit, reference, value, 1e-3 if "torque" not in quantity else 5e-3)


@verified("Slider-crank at 5000 rpm", MEMORY, nudges={"speed": 1.005})
def slider_crank_ideal(nudge: Nudge) -> Rows:
    """Extremes over a turn with ideal joints."""
    m = slider_crank((0.05, 0.30, 1e-4), (0.12, 0.21, 2.5e-4), (0.14, 1e-4))
    references = {
        "least slider acceleration": -19419.4, "largest slider acceleration": 9695.9,
        "largest force rod-slider": 2718.7,
        "largest force crank-rod": 6197.1, "least crank torque": -138.5, "largest crank torque": 138.5,
    }  # fmt: skip
    yield from ideal_values(nudge, m, 5000.0 * math.pi / 30.0, references)


def flores(g: float = 9.81) -> Mechanism:
    """Build the slider-crank of Flores, Leine and Glocker, without its guide."""
    return slider_crank((0.1530, 0.038, 7.4e-5), (0.3060, 0.038, 5.9e-4), (0.076, 2.7e-6), g)


@verified(
    "Slider-crank at 150 rad/s", FLORES + "; ideal values by rigid-body kinetics", nudges={"speed": 1.005}
)
def guide_ideal(nudge: Nudge) -> Rows:
    """Extremes over a turn at constant speed with an ideal guide."""
    references = {
        "least slider acceleration": -5163.75, "largest slider acceleration": 2612.59,
        "largest force rod-slider": 392.4,
        "largest force crank-rod": 556.0, "least crank torque": -42.9, "largest crank torque": 43.0,
    }  # fmt: skip
    yield from ideal_values(nudge, flores(), 150.0, references)


@verified(
    "Block with clearance in a guide until it meets a wall",
    FLORES + " (data); independent integration of the free flight",
    nudges={"clearance": 1.02, "crank": 0.9},
)
def guide_with_play(nudge: Nudge) -> Rows:
    """Compare the first flight of the block, started at zero angles with 150 and -75 rad/s: time and corner
    of its first contact, and the share of energy that remains.
    """
    c = 1e-3
    m = flores()
    spin = 150.0 * nudge("crank")
    speeds = {
        "crank": (0.0, 0.0, spin),
        "rod": (0.0, 0.1530 * spin, -75.0),
        "block": (0.0, 0.1530 * (spin - 150.0), 0.0),
    }
    for name, velocity in speeds.items():
        m.bodies[name] = dataclasses.replace(m.bodies[name], velocity=velocity)
    friction = Ambrosio(coefficient=0.01, v0=1e-4, v1=1e-2)
    law = LankaraniNikravesh(restitution=0.4)
    m.clearance_slider(
        "S",
        "ground.O",
        "block.center",
        clearance=c * nudge("clearance"),
        length=0.1,
        height=0.05,
        contact=law,
        friction=friction,
        corner_radius=1e-4,
    )
    motion = run(m, step=5e-7, duration=0.02, outputs=4000)
    time, corner = first_contact(c)
    depths = np.stack([motion.contact(f"S.{k}", "penetration") for k in (1, 2, 3, 4)], axis=1)
    first = int(np.argmax((depths > 0.0).any(axis=1)))
    yield Row("time of the first contact", "s", time, float(motion.time[first]), 5e-3)
    yield Row(
        "first corner (1 and 2 at the left wall, 3 and 4 at the right)",
        "1",
        float(corner),
        float(np.argmax(depths[first]) + 1),
        0.0,
    )


@verified(
    "Block with clearance in its guide, by a program of rigid contacts",
    FLORES + "; reference result of the program Siconos (examples/Mechanics/SliderCrank, steps of 0.1 ms,"
    " restitution 0.4, friction 0.01)",
    nudges={"restitution": 1.6, "crank": 0.75},
)
def guide_against_rigid_contacts(nudge: Nudge) -> Rows:
    """Compare the turns of the crank, released with 150 rad/s, and the times at which the block reaches each
    wall, over three quarters of a turn.

    The reference has the first impact 0.1 ms, one step, later than an integration without contacts, and it
    merges impacts that follow in ever shorter time. Therefore turns are compared within one per cent and
    times within half a millisecond.
    """
    motion = let_go(150.0 * nudge("crank"), 0.4 * nudge("restitution"), 0.05)
    turned = (motion.body("crank") - motion.body("crank")[0]) / (2.0 * math.pi)
    for time, turns in ((0.005, 0.09196), (0.01, 0.15162), (0.02, 0.25892), (0.05, 0.77039)):
        yield Row(f"turns of the crank after {1e3 * time:g} ms", "1", turns, motion.at(time, turned), 0.01)
    height = motion.body("block", "y")
    for begin, wall, time in ((0.0, 1.0, 0.0028), (0.015, -1.0, 0.0259), (0.035, 1.0, 0.0394)):
        first = int(np.argmax((motion.time > begin) & (wall * height > 1e-3)))
        yield Row(
            f"time of the first impact after {1e3 * begin:g} ms",
            "s",
            time,
            float(motion.time[first]),
            0.01,
            0.05,
        )


def let_go(spin: float, restitution: float, duration: float) -> CaseMotion:
    """Run the mechanism of Flores, Leine and Glocker with clearance in its guide, its crank released with
    ``spin`` (rad/s).
    """
    m = flores()
    for name, velocity in {
        "crank": (0.0, 0.0, spin),
        "rod": (0.0, 0.1530 * spin, -0.5 * spin),
        "block": (0.0, 0.0, 0.0),
    }.items():
        m.bodies[name] = dataclasses.replace(m.bodies[name], velocity=velocity)
    m.clearance_slider(
        "S", "ground.O", "block.center", clearance=1e-3, length=0.1, height=0.05,
        contact=striking(restitution, 1e8),
        friction=Ambrosio(coefficient=0.01, v0=1e-4, v1=1e-2), corner_radius=1e-4,
    )  # fmt: skip
    return run(m, step=1e-6, duration=duration, outputs=round(2e5 * duration))


def first_contact(clearance: float) -> tuple[float, int]:
    """Time (s) and number of the corner that meets a wall first: by Lagrange's equations for the two
    angles.
    """
    l1, l2, m1, m2, m3, j1, j2, g = 0.1530, 0.3060, 0.038, 0.038, 0.076, 7.4e-5, 5.9e-4, 9.81
    a11, a22, a12 = (
        j1 + 0.25 * m1 * l1**2 + (m2 + m3) * l1**2,
        j2 + 0.25 * m2 * l2**2 + m3 * l2**2,
        l1 * l2 * (0.5 * m2 + m3),
    )

    def rates(time: float, y: np.ndarray) -> np.ndarray:
        p, q, v, w = y
        c, s = math.cos(p - q), math.sin(p - q)
        matrix = np.array([[a11, a12 * c], [a12 * c, a22]])
        right = [
            -a12 * s * w * w - g * l1 * (0.5 * m1 + m2 + m3) * math.cos(p),
            a12 * s * v * v - g * l2 * (0.5 * m2 + m3) * math.cos(q),
        ]
        return np.array([v, w, *np.linalg.solve(matrix, right)])

    times = np.linspace(0.0, 0.05, 50001)
    path = solved(rates, [0.0, 0.0, 150.0, -75.0], times)
    # Pinned at its centre of mass without moments the block keeps its angle, so both corners of a side meet
    # the wall at once.
    height = l1 * np.sin(path[:, 0]) + l2 * np.sin(path[:, 1])
    first = int(np.argmax(np.abs(height) > clearance))
    return float(times[first]), 1 if height[first] > 0.0 else 3


def _block_on_arm(name: str, mass: float, distance: float, speed: float) -> Mechanism:
    """Build a block (kg) that slides along an arm, which turns at a constant speed (rad/s)."""
    m = Mechanism(name)
    m.point("O", 0.0, 0.0)
    m.rigid_body("arm", mass=1.0, inertia=0.2)
    m.revolute("O", "ground.O", "arm.center")
    m.rigid_body("block", mass=mass, inertia=1e-3, position=(distance, 0.0))
    m.slider("S", "arm.center", "block.center")
    m.drive("arm", speed=speed)
    return m


@verified(
    "Slider on a rotating arm",
    "closed form: r = r₀ cosh ωt, N = 2 m ω r', torque N r",
    nudges={"speed": 1.005, "mass": 1.02},
)
def slider_on_rotating_arm(nudge: Nudge) -> Rows:
    """Compare a block free along an arm that turns at constant speed: distance, force of the guide
    (Coriolis), torque of the driver.
    """
    w, r0, mass = 8.0, 0.1, 0.7
    m = _block_on_arm("slider on an arm", mass * nudge("mass"), r0, w * nudge("speed"))
    time = 0.3
    motion = run(m, duration=time, step=1e-5, outputs=5000)
    r = np.hypot(motion.body("block", "x"), motion.body("block", "y"))
    force = np.hypot(motion.ideal("S", "fx"), motion.ideal("S", "fy"))
    coriolis = 2.0 * mass * w * r0 * w * math.sinh(w * time)
    yield Row("distance at 0.3 s", "m", r0 * math.cosh(w * time), motion.at(time, r), 1e-4)
    yield Row("force of the guide at 0.3 s", "N", coriolis, motion.at(time, force), 1e-3)
    yield Row(
        "torque of the driver at 0.3 s",
        "N m",
        coriolis * r0 * math.cosh(w * time),
        motion.at(time, motion.driven("arm", "torque")),
        1e-3,
    )


@verified(
    "Bead on a free rod",
    "conservation of angular momentum and energy",
    nudges={"inertia": 1.02, "damping": 0.01},
)
def bead_on_free_rod(nudge: Nudge) -> Rows:
    """Compare a rod that turns freely in space while a bead slides outwards in its slot: momentum, angular
    momentum, energy, angular speed at a distance.
    """
    m = Mechanism("bead on a free rod")
    m.rigid_body(
        "rod", mass=1.0, inertia=0.02 * nudge("inertia"), position=(0.0, 0.0), velocity=(0.2, -0.1, 10.0)
    )
    m.point_mass("bead", mass=0.3, position=(0.05, 0.0), velocity=(0.2, -0.1 + 0.5, 0.0))
    m.slider("S", "rod.center", "bead.center", turning=True)
    m.settings = dataclasses.replace(m.settings, damping=nudge("damping", 0.0))
    motion = run(m, step=1e-5, duration=0.5, outputs=500)
    u = {body: (motion.speed(body, "u"), motion.speed(body, "v")) for body in ("rod", "bead")}
    total = 1.0 * u["rod"][1] + 0.3 * u["bead"][1]
    yield Row("change of momentum in y", "N s", 0.0, float(np.abs(total - total[0]).max()), 1e-10, 1.0)
    energy = (
        sum(0.5 * mass * (u[b][0] ** 2 + u[b][1] ** 2) for b, mass in (("rod", 1.0), ("bead", 0.3)))
        + 0.01 * motion.speed("rod", "w") ** 2
    )
    yield Row("change of energy", "J", 0.0, float(np.abs(energy - energy[0]).max()), 1e-6, float(energy[0]))
    reduced = 0.3 / 1.3
    distance = np.hypot(
        motion.body("bead", "x") - motion.body("rod", "x"), motion.body("bead", "y") - motion.body("rod", "y")
    )
    spin0 = 0.02 + reduced * 0.05**2
    yield Row(
        "angular speed at the end",
        "rad/s",
        10.0 * spin0 / (0.02 + reduced * float(distance[-1]) ** 2),
        float(motion.speed("rod", "w")[-1]),
        1e-5,
    )


@verified("Scotch yoke", "closed form: x = r cos ωt", nudges={"mass": 1.005, "radius": 1.001})
def scotch_yoke(nudge: Nudge) -> Rows:
    """Compare the crank's pin in an upright slot of a block that slides along x: place, force in the slot,
    torque.
    """
    r, w, mass = 0.08, 30.0, 1.4
    m = Mechanism("Scotch yoke")
    m.point("O", 0.0, 0.0)
    m.rigid_body("crank", mass=0.3, inertia=1e-3, pins={"pin": (r * nudge("radius"), 0.0)})
    m.revolute("O", "ground.O", "crank.center")
    m.rigid_body("yoke", mass=mass * nudge("mass"), inertia=1e-2, position=(r, 0.0))
    m.slider("guide", "ground.O", "yoke.center")
    m.slider("slot", "yoke.center", "crank.pin", direction=(0.0, 1.0), turning=True)
    m.drive("crank", speed=w)
    motion = run(m, turns=1.0, step=2.0 * math.pi / w / 7200, outputs=7200)
    for time in (0.04, 0.15):
        yield Row(
            f"place of the yoke at {time:g} s",
            "m",
            r * math.cos(w * time),
            motion.at(time, motion.body("yoke", "x")),
            1e-4,
            r,
        )
        push = mass * r * w * w * math.cos(w * time)
        yield Row(
            f"force of the slot on the pin at {time:g} s",
            "N",
            push,
            motion.at(time, motion.ideal("slot", "fx")),
            1e-3,
            mass * r * w * w,
        )
        torque = 0.5 * mass * r * r * w * w * math.sin(2.0 * w * time)
        yield Row(
            f"torque at {time:g} s",
            "N m",
            torque,
            motion.at(time, motion.driven("crank", "torque")),
            1e-3,
            mass * r * r * w * w,
        )


@verified(
    "Slotted arm driven by a pin (quick return)",
    "closed form: tan ψ = r sin θ/(d + r cos θ)",
    nudges={"inertia": 1.005, "radius": 1.001},
)
def quick_return(nudge: Nudge) -> Rows:
    """Compare the crank's pin in the slot of an arm on another pivot, as in a Geneva drive: angle of the arm,
    force in the slot.
    """
    r, d, w, inertia = 0.1, 0.25, 20.0, 0.03
    m = Mechanism("quick return")
    m.point("A", 0.0, 0.0)
    m.point("B", -d, 0.0)
    m.rigid_body("crank", mass=0.3, inertia=1e-3, pins={"pin": (r * nudge("radius"), 0.0)})
    m.rigid_body("arm", mass=1.0, inertia=inertia * nudge("inertia"), position=(-d, 0.0))
    m.revolute("A", "ground.A", "crank.center")
    m.revolute("B", "ground.B", "arm.center")
    m.slider("slot", "arm.center", "crank.pin", turning=True)
    m.drive("crank", speed=w)
    motion = run(m, turns=1.0, step=2.0 * math.pi / w / 7200, outputs=7200)
    p = r / d
    for time in (0.06, 0.13):
        a = w * time
        denominator = 1.0 + p * p + 2.0 * p * math.cos(a)
        alpha = w * w * p * (p * p - 1.0) * math.sin(a) / denominator**2
        yield Row(
            f"angle of the arm at {time:g} s",
            "rad",
            math.atan2(r * math.sin(a), d + r * math.cos(a)),
            motion.at(time, motion.body("arm")),
            1e-4,
        )
        force = np.hypot(motion.ideal("slot", "fx"), motion.ideal("slot", "fy"))
        yield Row(
            f"force in the slot at {time:g} s",
            "N",
            abs(inertia * alpha) / (d * math.sqrt(denominator)),
            motion.at(time, force),
            1e-3,
        )


@verified("Driven travel of a slider", "closed form", nudges={"speed": 1.001, "mass": 1.005})
def driven_travel(nudge: Nudge) -> Rows:
    """Compare a block pushed along a turning arm at constant speed: path and force of the driver, m r ω²."""
    w, v, r0, mass = 6.0, 0.4, 0.2, 0.5
    m = _block_on_arm("driven travel", mass * nudge("mass"), r0, w)
    m.drivers["push"] = ConstantSpeed(slider="S", speed=v * nudge("speed"))
    motion = run(m, duration=0.5, step=2e-5, outputs=5000)
    r = np.hypot(motion.body("block", "x"), motion.body("block", "y"))
    yield Row("distance at 0.5 s", "m", r0 + 0.5 * v, motion.at(0.5, r), 1e-4)
    c, s = np.cos(motion.body("arm")), np.sin(motion.body("arm"))
    push = motion.ideal("push", "fx") * c + motion.ideal("push", "fy") * s
    yield Row(
        "force of the driver along the arm at 0.5 s",
        "N",
        -mass * w * w * (r0 + 0.5 * v),
        motion.at(0.5, push),
        1e-3,
    )
    yield Row(
        "torque at 0.5 s",
        "N m",
        2.0 * mass * w * v * (r0 + 0.5 * v),
        motion.at(0.5, motion.driven("arm", "torque")),
        1e-3,
    )
