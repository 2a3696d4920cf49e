"""Springs, dampers, bushings, stops and mass-proportional damping against closed forms."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from vfife.model.mechanism import Mechanism, Settings

from .case import Nudge, Row, Rows, verified
from .case_motion import run

CLOSED = "closed form"


def damped(time: float, stiffness: float, damping: float, inertia: float, x: float, v: float) -> float:
    """Free vibration below critical damping from x and v."""
    w0, z = math.sqrt(stiffness / inertia), damping / (2.0 * inertia)
    w = math.sqrt(w0 * w0 - z * z)
    return math.exp(-z * time) * (x * math.cos(w * time) + (v + z * x) / w * math.sin(w * time))


@verified("Mass on a spring and damper", CLOSED, nudges={"stiffness": 1.01, "damping": 1.3})
def spring_mass_damper(nudge: Nudge) -> Rows:
    """2 kg, 800 N/m, 4 N s/m, 0.1 m from rest: place at four times, energy lost in the damper."""
    m = Mechanism("spring, mass and damper")
    m.point("O", 0.0, 0.0)
    m.point_mass("mass", mass=2.0, position=(1.1, 0.0))
    m.spring(
        "s",
        "ground.O",
        "mass.center",
        stiffness=800.0 * nudge("stiffness"),
        damping=4.0 * nudge("damping"),
        free_length=1.0,
    )
    motion = run(m, step=1e-4, duration=1.0, outputs=1000)
    for time in (0.05, 0.2, 0.5, 1.0):
        yield Row(
            f"place at {time:g} s",
            "m",
            damped(time, 800.0, 4.0, 2.0, 0.1, 0.0),
            motion.at(time, motion.body("mass", "x") - 1.0),
            1e-3,
            0.1,
        )
    z, w0 = 1.0, 20.0
    x, v = (
        damped(1.0, 800.0, 4.0, 2.0, 0.1, 0.0),
        -0.1 * w0 * w0 / math.sqrt(w0 * w0 - z * z) * math.exp(-z) * math.sin(math.sqrt(w0 * w0 - z * z)),
    )
    yield Row(
        "energy lost by 1 s",
        "J",
        4.0 - 400.0 * x * x - v * v,
        float(motion.ledger.terms["spring_loss"][-1]),
        1e-3,
    )


@verified("Stiff damper", "closed form: rest after m v/c", nudges={"damping": 30.0})
def stiff_damper(nudge: Nudge) -> Rows:
    """Compare the stopping distance m v/c of a damped mass, also with a step of forty time constants of the
    damper.
    """
    m = Mechanism(
        "stiff damper", settings=Settings(energy_limit=10.0)
    )  # so long a step loses more than there was
    m.point("O", 0.0, 0.0)
    m.point_mass("mass", mass=1.0, position=(1.0, 0.0), velocity=(1.0, 0.0, 0.0))
    m.spring("s", "ground.O", "mass.center", damping=4e4 * nudge("damping"))
    fine, coarse = run(m, step=1e-7, duration=4e-4, outputs=400), run(m, step=1e-3, duration=0.1, outputs=100)
    yield Row("way to rest", "m", 1.0 / 4e4, float(fine.body("mass", "x")[-1] - 1.0), 1e-3)
    yield Row(
        "speed left after 0.1 s with a step of 1 ms",
        "m/s",
        0.0,
        float(coarse.speed("mass", "u")[-1]),
        1e-3,
        1.0,
    )


@verified("Torsional spring and damper", CLOSED, nudges={"stiffness": 1.01, "damping": 1.3})
def torsional_oscillator(nudge: Nudge) -> Rows:
    """Compare a uniform rod on its pivot with 3 N m/rad and 0.02 N m s/rad, from rest at 0.5 rad beyond the
    free angle.
    """
    m = Mechanism("torsional oscillator")
    m.point("O", 0.0, 0.0)
    m.link("rod", length=0.6, mass=1.0, angle=0.8)
    m.revolute("O", "ground.O", "rod.start")
    m.torsional_spring(
        "s",
        "ground",
        "rod",
        stiffness=3.0 * nudge("stiffness"),
        damping=0.02 * nudge("damping"),
        free_angle=0.3,
    )
    motion = run(m, step=1e-4, duration=2.0, outputs=2000)
    for time in (0.2, 1.0, 2.0):
        yield Row(
            f"angle at {time:g} s",
            "rad",
            damped(time, 3.0, 0.02, 0.12, 0.5, 0.0),
            motion.at(time, motion.body("rod") - 0.3),
            1e-3,
            0.5,
        )


@verified("Body on a bushing", CLOSED, nudges={"x": 1.01, "y": 1.01, "turn": 1.01})
def bushing_oscillator(nudge: Nudge) -> Rows:
    """Three uncoupled vibrations of a body held at its centre of mass, each with a stiffness and a damping of
    its own.
    """
    m = Mechanism("bushing")
    m.point("O", 0.0, 0.0)
    m.rigid_body("body", mass=2.0, inertia=0.01, velocity=(0.3, -0.2, 4.0))
    stiffness = (5e3 * nudge("x"), 2e4 * nudge("y"), 60.0 * nudge("turn"))
    m.bushing("b", "ground.O", "body.center", stiffness=stiffness, damping=(10.0, 20.0, 0.05))
    motion = run(m, step=2e-5, duration=0.5, outputs=2500)
    axes = (("x", 5e3, 10.0, 2.0, 0.3), ("y", 2e4, 20.0, 2.0, -0.2), ("angle", 60.0, 0.05, 0.01, 4.0))
    for axis, stiff, damping, inertia, v in axes:
        for time in (0.11, 0.5):
            reference = damped(time, stiff, damping, inertia, 0.0, v)
            unit = "rad" if axis == "angle" else "m"
            yield Row(
                f"{axis} at {time:g} s",
                unit,
                reference,
                motion.at(time, motion.body("body", axis)),
                1e-3,
                abs(v) / math.sqrt(stiff / inertia),
            )


@verified(
    "Rebound from a rotational stop",
    "closed form of a spring and damper that never pull",
    nudges={"stiffness": 1.02, "damping": 1.05, "loss": 0.1},
)
def stop_rebound(nudge: Nudge) -> Rows:
    """Compare a disc that meets its stop at 10 rad/s: rebound, deepest angle, and time of contact without
    damping.
    """
    inertia, k, w = 0.01, 400.0, 10.0

    def disc(c: float) -> Mechanism:
        m = Mechanism("stop")
        m.point("O", 0.0, 0.0)
        m.rigid_body("disc", mass=1.0, inertia=inertia, velocity=(0.0, 0.0, w))
        m.revolute("O", "ground.O", "disc.center")
        m.stop("s", "ground", "disc", low=-1.0, high=0.05, stiffness=k * nudge("stiffness"), damping=c)
        return m

    free = run(disc(nudge("loss", 0.0)), step=2e-6, duration=0.03, outputs=3000)
    yield Row("rebound without damping", "rad/s", -w, float(free.speed("disc", "w")[-1]), 1e-3)
    yield Row(
        "deepest turn without damping",
        "rad",
        w * math.sqrt(inertia / k),
        float(free.body("disc").max() - 0.05),
        1e-3,
    )
    inside = free.body("disc") > 0.05
    yield Row(
        "time of contact",
        "s",
        math.pi * math.sqrt(inertia / k),
        float(free.time[inside][-1] - free.time[inside][0]) + 1e-5,
        1e-3,
    )
    c = 0.8
    z = c / (2.0 * inertia)
    v = math.sqrt(k / inertia - z * z)
    end = (math.pi - math.atan2(c * v, k - c * z)) / v
    left = w * math.exp(-z * end) * (math.cos(v * end) - z / v * math.sin(v * end))
    lossy = run(disc(c * nudge("damping")), step=2e-6, duration=0.03, outputs=3000)
    yield Row("rebound with damping", "rad/s", left, float(lossy.speed("disc", "w")[-1]), 1e-3)


@verified(
    "Mass-proportional damping",
    "closed form: v = v0 exp(-ζt), and a damped spring",
    nudges={"damping": 1.02, "step": 30.0},
)
def mass_proportional_damping(nudge: Nudge) -> Rows:
    """Compare the decay of a free particle's speed, a body's rotation and an oscillation on a spring."""
    zeta = 3.0
    m = Mechanism("mass-proportional damping")
    m.point("O", 0.0, 0.0)
    m.rigid_body("free", mass=2.0, inertia=0.1, velocity=(1.0, 0.0, 5.0))
    m.point_mass("hung", mass=1.0, position=(0.0, 1.1))
    m.spring("s", "ground.O", "hung.center", stiffness=100.0, free_length=1.0)
    m.settings = dataclasses.replace(m.settings, damping=zeta * nudge("damping"))
    motion = run(m, step=1e-4 * nudge("step"), duration=1.0, outputs=1000)
    far = (1.0 - math.exp(-zeta)) / zeta
    yield Row("way of the particle in 1 s", "m", far, float(motion.body("free", "x")[-1]), 1e-3)
    yield Row("turn of the body in 1 s", "rad", 5.0 * far, float(motion.body("free")[-1]), 1e-3)
    yield Row(
        "place on the spring at 0.3 s",
        "m",
        damped(0.3, 100.0, zeta, 1.0, 0.1, 0.0),
        motion.at(0.3, motion.body("hung", "y") - 1.0),
        1e-3,
        0.03,
    )
    dissipated = 0.5 * (2.0 + 0.1 * 25.0) * (1.0 - math.exp(-2.0 * zeta))
    x = damped(1.0, 100.0, zeta, 1.0, 0.1, 0.0)
    w = math.sqrt(100.0 - 2.25)
    v = -0.1 * 100.0 / w * math.exp(-1.5) * math.sin(w)
    yield Row(
        "energy lost",
        "J",
        dissipated + 0.5 - 50.0 * x * x - 0.5 * v * v,
        float(motion.ledger.terms["damping_loss"][-1]),
        2e-4,
    )
    yield Row("residual of the ledger", "J", 0.0, float(np.abs(motion.ledger.residual).max()), 1e-5, 1.0)
