"""Pendulums and closed chains of rigid bodies under gravity."""

from __future__ import annotations

import math

import numpy as np

from vfife.model.drivers import Harmonic
from vfife.model.mechanism import Mechanism

from .case import Nudge, Row, Rows, verified
from .case_motion import run
from .lagrange import Pin, integrate, solved

G = 9.81
A01 = "IFToMM library of computational benchmark problems, A01; closed form by elliptic functions"
A02 = (
    "IFToMM library of computational benchmark problems, A02 (two four-bars); integration of its one equation"
    " while it stays a parallelogram"
)


def pendulum(length: float = 1.0) -> Mechanism:
    """1 kg at the end of a massless rod, horizontal at rest."""
    m = Mechanism("simple pendulum", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    m.rigid_body(
        "bob", mass=1.0, inertia=1e-5, center=(length, 0.0), pins={"pivot": (0.0, 0.0)}, angle=math.pi
    )
    m.revolute("O", "ground.O", "bob.pivot")
    return m


@verified("Simple pendulum from the horizontal", A01, nudges={"length": 1.001})
def simple_pendulum(nudge: Nudge) -> Rows:
    """1 kg at 1 m from (-1, 0): places at 1 and 5 s, and the period."""
    motion = run(pendulum(nudge("length")), step=1e-4, duration=5.0, outputs=2500)
    for time, x, y in ((1.0, 0.986291751, -0.165010853), (5.0, -0.942305435, -0.334754338)):
        yield Row(f"x at {time:g} s", "m", x, motion.at(time, motion.body("bob", "x")), 1e-4)
        yield Row(f"y at {time:g} s", "m", y, motion.at(time, motion.body("bob", "y")), 1e-3)
    speed = motion.body("bob", "angular_velocity")
    turns = np.flatnonzero(speed[1:-1] * speed[2:] < 0.0) + 1
    zeros = [
        motion.time[k] - speed[k] * (motion.time[k + 1] - motion.time[k]) / (speed[k + 1] - speed[k])
        for k in turns
    ]
    yield Row("period", "s", 2.36784194758, float(zeros[1]), 1e-5)


def rods(*angles: float, factor: float = 1.0) -> Mechanism:
    """Build a chain of uniform rods of 0.5 m and 1 kg that hangs from the origin; ``factor`` scales the last
    mass.
    """
    m = Mechanism("chain", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    at = "ground.O"
    for k, angle in enumerate(angles, start=1):
        m.link(f"rod{k}", length=0.5, mass=1.0 if k < len(angles) else factor, angle=angle)
        m.revolute(f"J{k}", at, f"rod{k}.start")
        at = f"rod{k}.end"
    return m


def placed(angles: list[float]) -> np.ndarray:
    """Centres and angles of rods of 0.5 m, one after the other."""
    at, places = np.zeros(2), []
    for angle in angles:
        half_rod = 0.5 * np.array([math.cos(angle), math.sin(angle)])
        places.append([*(at + 0.5 * half_rod), angle])
        at = at + half_rod
    return np.array(places)


def weight(*masses: float):  # type: ignore[no-untyped-def]
    """Return the forces of gravity as a function of time, positions and velocities."""
    return lambda time, q, v: np.array([[0.0, -m * G, 0.0] for m in masses])


@verified(
    "Double pendulum",
    "independent integration of Lagrange's equations (order 8, relative tolerance 1e-12)",
    nudges={"mass": 1.01},
)
def double_pendulum(nudge: Nudge) -> Rows:
    """Two uniform rods from rest at 0.3 and 0.9 rad: angles after 1.5 s, energy."""
    angles, inertia = [0.3, 0.9], 0.25 / 12.0
    pins = [Pin(0, (-0.25, 0.0), -1, (0.0, 0.0)), Pin(1, (-0.25, 0.0), 0, (0.25, 0.0))]
    ours = run(rods(*angles, factor=nudge("mass")), step=1e-4, duration=1.5, outputs=150)
    theirs = integrate(
        [1.0, 1.0],
        [inertia] * 2,
        pins,
        weight(1.0, 1.0),
        placed(angles),
        np.zeros((2, 3)),
        np.array([0.75, 1.5]),
    )
    for k, time in enumerate((0.75, 1.5)):
        for body in (0, 1):
            value = ours.at(time, ours.body(f"rod{body + 1}"))
            yield Row(f"angle of rod {body + 1} at {time:g} s", "rad", theirs[k, 0, body, 2], value, 1e-4)


@verified(
    "Closed chain",
    "independent integration of Lagrange's equations (order 8, relative tolerance 1e-12)",
    nudges={"mass": 1.05},
)
def closed_chain(nudge: Nudge) -> Rows:
    """Compare a four-bar of three rods that falls freely: angles after 0.8 s, largest force of its last
    joint.
    """
    angles = [1.9, 0.4, -1.2]
    start = placed(angles)
    end = start[-1, :2] + 0.25 * np.array([math.cos(angles[-1]), math.sin(angles[-1])])
    m = rods(*angles, factor=nudge("mass"))
    m.point("E", float(end[0]), float(end[1]))
    m.revolute("E", "ground.E", "rod3.end")
    ours = run(m, step=5e-5, duration=0.8, outputs=400)
    inertia = 0.25 / 12.0
    pins = [
        Pin(0, (-0.25, 0.0), -1, (0.0, 0.0)),
        Pin(1, (-0.25, 0.0), 0, (0.25, 0.0)),
        Pin(2, (-0.25, 0.0), 1, (0.25, 0.0)),
    ]
    pins.append(Pin(2, (0.25, 0.0), -1, (float(end[0]), float(end[1]))))
    theirs = integrate(
        [1.0] * 3, [inertia] * 3, pins, weight(1.0, 1.0, 1.0), start, np.zeros((3, 3)), np.array([0.4, 0.8])
    )
    for k, time in enumerate((0.4, 0.8)):
        for body in range(3):
            reference = float(theirs[k, 0, body, 2])
            yield Row(
                f"angle of rod {body + 1} at {time:g} s",
                "rad",
                reference,
                ours.at(time, ours.body(f"rod{body + 1}")),
                2e-4,
            )


def double_four_bar(mass: float = 1.0) -> Mechanism:
    """Three upright bars side by side and two that join their tops, each of 1 m and 1 kg; the tops move at 1
    m/s.
    """
    m = Mechanism("double four-bar", gravity=(0.0, -G))
    for k in range(3):
        m.point(f"A{k}", float(k), 0.0)
        m.link(f"bar{k}", length=1.0, mass=1.0, angle=0.5 * math.pi, velocity=(0.0, 0.0, -1.0))
        m.revolute(f"A{k}", f"ground.A{k}", f"bar{k}.start")
    for k in range(2):
        m.link(f"top{k}", length=1.0, mass=mass, position=(float(k), 1.0), velocity=(1.0, 0.0, 0.0))
        m.revolute(f"B{k}", f"bar{k}.end", f"top{k}.start")
        m.revolute(f"C{k}", f"top{k}.end", f"bar{k + 1}.end")
    return m


@verified("Double four-bar through its singular positions", A02, nudges={"mass": 1.01}, quick=False)
def double_four_bar_turns(nudge: Nudge) -> Rows:
    """3 m l^2/3 + 2 m l^2 = 3 kg m^2 turned by its weight for 10 s: place of the first top joint, drift of
    energy.
    """
    ours = run(double_four_bar(nudge("mass")), step=1e-4, duration=10.0, outputs=1000)
    theirs = solved(
        lambda time, y: np.array([y[1], -3.5 * G * math.cos(y[0]) / 3.0]),
        [0.5 * math.pi, -1.0],
        np.array([5.0, 10.0]),
    )
    top = ours.pin("bar0", "end")
    for time, (angle, _) in zip((5.0, 10.0), theirs, strict=True):
        for axis, (name, of) in enumerate((("x", math.cos), ("y", math.sin))):
            yield Row(f"{name} of B0 at {time:g} s", "m", of(angle), ours.at(time, top[:, axis]), 1e-3, 1.0)
    kinetic = 1.5 * ours.body("bar0", "angular_velocity") ** 2
    energy = kinetic + 3.5 * G * top[:, 1]
    yield Row("largest drift of energy", "J", 0.0, float(np.abs(energy - energy[0]).max()), 1e-3, 3.5 * G)


@verified(
    "Motor between two rods",
    "independent integration of the one equation that is left",
    nudges={"amplitude": 1.01},
)
def motor_between_two_rods(nudge: Nudge) -> Rows:
    """Compare a double pendulum whose relative angle oscillates as prescribed."""
    a, f = 0.6, 1.5
    m = rods(-1.2, -0.7)
    m.drivers["motor"] = Harmonic(body="rod2", against="rod1", amplitude=a * nudge("amplitude"), frequency=f)
    ours = run(m, step=5e-5, duration=1.0, outputs=400)
    w, l, small, mixed = 2.0 * math.pi * f, 0.5, 0.25 / 12.0 + 1.0 / 16.0, 0.125

    def rates(time: float, y: np.ndarray) -> np.ndarray:
        p, v = y
        phi, rate, second = (
            0.5 + a * math.sin(w * time),
            a * w * math.cos(w * time),
            -a * w * w * math.sin(w * time),
        )
        c, s, q = math.cos(phi), math.sin(phi), v + rate
        m11, m12, m22 = small + l * l, mixed * c, small
        push = mixed * s * (q * q - v * v) - 1.5 * l * G * math.cos(p) - 0.5 * l * G * math.cos(p + phi)
        return np.array([v, (push - (m12 + m22) * second) / (m11 + 2.0 * m12 + m22)])

    # At the start the driver turns already: what the joints and the driver leave free takes up its impulse.
    speed = float(ours.speed("rod1", "w")[0])
    for time, (angle, _) in zip((0.4, 0.9), solved(rates, [-1.2, speed], np.array([0.4, 0.9])), strict=True):
        yield Row(f"angle of rod 1 at {time:g} s", "rad", angle, ours.at(time, ours.body("rod1")), 1e-3)
        turned = 0.5 + a * math.sin(w * time)
        yield Row(
            f"angle between the rods at {time:g} s",
            "rad",
            turned,
            ours.at(time, ours.body("rod2") - ours.body("rod1")),
            1e-5,
        )


@verified(
    "Convergence in the step",
    "order 2 of the central difference; independent integration of Lagrange's equations",
    nudges={"coarse": 1.25},
)
def convergence_in_steps(nudge: Nudge) -> Rows:
    """Order from the errors of a double pendulum's angles after 0.5 s with 1 ms and half of it."""
    angles, inertia = [0.3, 0.9], 0.25 / 12.0
    pins = [Pin(0, (-0.25, 0.0), -1, (0.0, 0.0)), Pin(1, (-0.25, 0.0), 0, (0.25, 0.0))]
    theirs = integrate(
        [1.0, 1.0], [inertia] * 2, pins, weight(1.0, 1.0), placed(angles), np.zeros((2, 3)), np.array([0.5])
    )[0, 0, :, 2]
    errors = []
    for step in (1e-3 * nudge("coarse"), 5e-4):
        motion = run(rods(*angles), step=step, duration=0.5, outputs=100)
        errors.append([abs(motion.at(0.5, motion.body(f"rod{k + 1}")) - theirs[k]) for k in (0, 1)])
    for k in (0, 1):
        yield Row(
            f"order of the angle of rod {k + 1}", "1", 2.0, math.log2(errors[0][k] / errors[1][k]), 1e-2
        )
