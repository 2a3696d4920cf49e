"""Gears, motors, torques over speed and angle, following forces, driven points."""

from __future__ import annotations

import math

import numpy as np

from vfife.model.drivers import Harmonic, Ramp, StepTo, Torque
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism

from .case import Nudge, Row, Rows, verified
from .case_motion import run

CLOSED = "closed form"


def wheel(m: Mechanism, name: str, inertia: float, x: float = 0.0, speed: float = 0.0) -> None:
    """Add a disc on a pivot at (x, 0) (m)."""
    m.point(name, x, 0.0)
    m.rigid_body(name, mass=1.0, inertia=inertia, position=(x, 0.0), velocity=(0.0, 0.0, speed))
    m.revolute(f"pivot {name}", f"ground.{name}", f"{name}.center")


@verified(
    "Gear pair with a torque",
    "closed form: α = T/(I₁ + r² I₂), moment of the gear r I₂ α",
    nudges={"inertia": 1.01, "ratio": 1.01},
)
def gear_pair(nudge: Nudge) -> Rows:
    """2 N m on a wheel that turns another backwards at 0.4 of its speed."""
    i1, i2, r, torque = 0.02, 0.3, -0.4, 2.0
    m = Mechanism("gear pair")
    wheel(m, "first", i1)
    wheel(m, "second", i2 * nudge("inertia"), 0.5)
    m.gear("gear", "first", "second", ratio=r * nudge("ratio"))
    m.drivers["first"] = Torque(body="first", value=torque)
    motion = run(m, step=1e-4, duration=0.5, outputs=50)
    alpha = torque / (i1 + r * r * i2)
    yield Row("angle of the first at 0.5 s", "rad", 0.125 * alpha, float(motion.body("first")[-1]), 1e-4)
    yield Row(
        "angle of the second at 0.5 s", "rad", 0.125 * r * alpha, float(motion.body("second")[-1]), 1e-4
    )
    yield Row(
        "moment of the gear on the second",
        "N m",
        r * i2 * alpha,
        float(motion.ideal("gear", "moment")[-1]),
        1e-4,
    )


@verified("Planetary train", "closed form from the energy of the train (Willis)", nudges={"inertia": 1.1})
def planetary_train(nudge: Nudge) -> Rows:
    """Compare a planet on an arm that rolls on a fixed sun of its size: it turns twice as fast as the arm,
    whose torque accelerates I_arm + m l² + 4 I_planet.
    """
    arm, l, mass, planet, torque = 0.05, 0.2, 1.0, 0.004, 0.7
    m = Mechanism("planetary train")
    m.point("O", 0.0, 0.0)
    m.rigid_body("arm", mass=1.0, inertia=arm, pins={"end": (l, 0.0)})
    m.revolute("O", "ground.O", "arm.center")
    m.rigid_body("planet", mass=mass, inertia=planet * nudge("inertia"), position=(l, 0.0))
    m.revolute("P", "arm.end", "planet.center")
    m.gear("mesh", "arm", "planet", ratio=2.0)
    m.drivers["arm"] = Torque(body="arm", value=torque)
    motion = run(m, step=1e-4, duration=1.0, outputs=100)
    alpha = torque / (arm + mass * l * l + 4.0 * planet)
    yield Row("angle of the arm at 1 s", "rad", 0.5 * alpha, float(motion.body("arm")[-1]), 1e-4)
    yield Row("angle of the planet at 1 s", "rad", alpha, float(motion.body("planet")[-1]), 1e-4)
    pull = mass * l * (alpha * 1.0) ** 2
    direction = np.cos(motion.body("arm")), np.sin(motion.body("arm"))
    inward = -(motion.ideal("P", "fx") * direction[0] + motion.ideal("P", "fy") * direction[1])
    yield Row("force towards the middle in the planet's pin at 1 s", "N", pull, float(inward[-1]), 1e-3)


@verified(
    "Motor with a falling torque", "closed form: ω = ω₀ [1 - exp(-T₀ t/(I ω₀))]", nudges={"inertia": 1.01}
)
def motor_curve(nudge: Nudge) -> Rows:
    """5 N m at rest that falls to nothing at 100 rad/s."""
    m = Mechanism("motor")
    wheel(m, "rotor", 0.05 * nudge("inertia"))
    m.drivers["rotor"] = Torque(body="rotor", value=(5.0, 0.0), speeds=(0.0, 100.0))
    motion = run(m, step=1e-4, duration=1.5, outputs=150)
    for time in (0.5, 1.0, 1.5):
        yield Row(
            f"speed at {time:g} s",
            "rad/s",
            100.0 * (1.0 - math.exp(-time)),
            motion.at(time, motion.speed("rotor", "w")),
            1e-3,
        )


@verified("Torque over the angle", "closed form: θ = ω₀ sin(pt)/p, p² = k/I", nudges={"inertia": 1.02})
def torque_over_angle(nudge: Nudge) -> Rows:
    """Compare a torque that decreases with the angle like a spring's, counted from a start angle of
    0.7 rad.
    """
    m = Mechanism("torque over angle")
    m.point("O", 0.0, 0.0)
    m.rigid_body("rotor", mass=1.0, inertia=0.05 * nudge("inertia"), angle=0.7, velocity=(0.0, 0.0, 6.0))
    m.revolute("O", "ground.O", "rotor.center")
    m.drivers["rotor"] = Torque(body="rotor", value=(10.0, -10.0), angles=(-1.0, 1.0))
    motion = run(m, step=1e-4, duration=1.0, outputs=500)
    p = math.sqrt(10.0 / 0.05)
    for time in (0.1, 0.9):
        yield Row(
            f"angle at {time:g} s",
            "rad",
            6.0 / p * math.sin(p * time),
            motion.at(time, motion.body("rotor") - 0.7),
            1e-3,
            6.0 / p,
        )


@verified("Following force", "closed form", nudges={"force": 1.01})
def following_force(nudge: Nudge) -> Rows:
    """Compare a force that turns with a spinning body, at its centre, and one across the end of a pivoted
    rod, which accelerates the rod.
    """
    m = Mechanism("following forces")
    m.rigid_body("disc", mass=2.0, inertia=0.1, velocity=(0.0, 0.0, 8.0))
    m.loads["a"] = PointForce(name="a", at="disc.center", force=(5.0 * nudge("force"), 0.0), follow=True)
    m.point("O", 5.0, 0.0)
    m.link("rod", length=0.5, mass=1.2, angle=0.4, position=(5.0, 0.0))
    m.revolute("O", "ground.O", "rod.start")
    m.loads["b"] = PointForce(name="b", at="rod.end", force=(3.0, 4.0 * nudge("force")), follow=True)
    motion = run(m, step=1e-4, duration=1.0, outputs=200)
    a, w = 2.5, 8.0
    yield Row(
        "x of the disc at 1 s", "m", a / w**2 * (1.0 - math.cos(w)), float(motion.body("disc", "x")[-1]), 1e-3
    )
    yield Row(
        "y of the disc at 1 s",
        "m",
        a / w * (1.0 - math.sin(w) / w),
        float(motion.body("disc", "y")[-1]),
        1e-3,
    )
    yield Row(
        "turn of the rod at 1 s",
        "rad",
        0.5 * 4.0 * 0.5 / (1.2 * 0.25 / 3.0),
        float(motion.body("rod")[-1] - 0.4),
        1e-3,
    )


@verified(
    "Driven point",
    "closed form: reaction m a, work ½ m v²",
    nudges={"mass": 1.01, "gravity": 1.01, "amplitude": 1.001},
)
def driven_point(nudge: Nudge) -> Rows:
    """Compare the driver's force for a mass moved to and fro along an inclined line, free across it, with
    gravity.
    """
    amplitude, f, mass, g = 0.02, 5.0, 3.0, 9.81
    m = Mechanism("driven point", gravity=(0.0, -g * nudge("gravity")))
    m.point_mass("mass", mass=mass * nudge("mass"))
    c, s = math.cos(0.6), math.sin(0.6)
    m.drivers["shaker"] = Harmonic(
        point="mass.center",
        direction=(2.0 * c, 2.0 * s),
        amplitude=amplitude * nudge("amplitude"),
        frequency=f,
    )
    motion = run(m, step=2e-5, duration=0.4, outputs=400)
    w = 2.0 * math.pi * f
    for time in (0.07, 0.33):
        force = motion.ideal("shaker", "fx") * c + motion.ideal("shaker", "fy") * s
        reference = -mass * amplitude * w * w * math.sin(w * time) + mass * g * s
        yield Row(f"force at {time:g} s", "N", reference, motion.at(time, force), 1e-3)
    across = -motion.body("mass", "x") * s + motion.body("mass", "y") * c
    yield Row("free fall across the line in 0.4 s", "m", -0.5 * g * c * 0.16, float(across[-1]), 1e-3)
    distance = motion.body("mass", "x") * c + motion.body("mass", "y") * s
    yield Row(
        "place along the line at 0.33 s", "m", amplitude * math.sin(w * 0.33), motion.at(0.33, distance), 1e-4
    )


@verified(
    "Turns of a body after a given function of time",
    "closed form: fifth-order steps",
    nudges={"travel": 1.001},
)
def imposed_turns(nudge: Nudge) -> Rows:
    """Compare angle, speed and torque of a ramp to a speed, and of a step by an angle."""
    m = Mechanism("prescribed turns")
    wheel(m, "ramp", 0.2)
    wheel(m, "step", 0.2, 1.0)
    m.drivers["ramp"] = Ramp(body="ramp", speed=10.0 * nudge("travel"), duration=0.4)
    m.drivers["step"] = StepTo(body="step", travel=2.0 * nudge("travel"), duration=0.4, begin=0.1)
    motion = run(m, step=1e-4, duration=1.0, outputs=1000)
    yield Row(
        "angle of the ramp at 1 s", "rad", 10.0 * (1.0 - 0.2), motion.at(1.0, motion.body("ramp")), 1e-6
    )
    yield Row(
        "torque in the middle of the ramp",
        "N m",
        0.2 * 10.0 * 1.875 / 0.4,
        motion.at(0.2, motion.driven("ramp", "torque")),
        1e-4,
    )
    yield Row("angle of the step at 0.3 s", "rad", 1.0, motion.at(0.3, motion.body("step")), 1e-6)
    s = 0.25
    second = 60.0 * s - 180.0 * s * s + 120.0 * s**3
    yield Row(
        "torque of the step at its quarter",
        "N m",
        0.2 * 2.0 * second / 0.16,
        motion.at(0.2, motion.driven("step", "torque")),
        1e-4,
    )
