"""Models whose chaos others have computed: Duffing's oscillator, a ball on a shaking table, a mass that meets
a stop; and what is known of them.

What is known shares nothing with the package: closed forms, an exact map, and the integration of Duffing's
equation with its derivatives.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vfife.laws import Frictionless, Gonthier
from vfife.model.drivers import Harmonic
from vfife.model.mechanism import Mechanism

from .lagrange import solved

Array = NDArray[np.float64]
G = 9.81
BALL, FREQUENCY = 0.01, 25.0  # kg, Hz
OMEGA = 2.0 * math.pi * FREQUENCY
DRIVE = "load.shaker.force.0"
RADIUS = 5e-3  # m


def turning(name: str, speed: float, gravity: float = 0.0) -> Mechanism:
    """Build a distant crank that turns by itself: it defines turns, and forces over its angle."""
    m = Mechanism(name, gravity=(0.0, -gravity))
    m.point("O", 0.0, 0.0)
    m.point("C", 0.0, -3.0)
    m.link("crank", length=0.1, mass=0.1, position=(0.0, -3.0))
    m.revolute("C", "ground.C", "crank.start")
    m.drive("crank", speed=speed)
    return m


# ---------------------------------------------------------------------------------------------------- Duffing


def duffing(
    drive: float,
    damping: float,
    linear: float,
    speed: float,
    cubic: float = 1.0,
    start: tuple[float, float] = (1.0, 0.0),
) -> Mechanism:
    """x'' + damping x' + linear x + cubic x^3 = drive cos(speed t): 1 kg in a guide, all forces as
    expressions.
    """
    m = turning("Duffing's oscillator", speed)
    m.rigid_body("block", mass=1.0, inertia=0.01, position=(start[0], 0.0), velocity=(start[1], 0.0, 0.0))
    m.slider("guide", "ground.O", "block.center")
    m.guide_force("spring", "guide", travels=(-6.0, 6.0), expression=f"-({linear!r}) * x - x^3")
    m.guide_force("damper", "guide", speeds=(-20.0, 20.0), expression=f"-{damping!r} * v")
    m.force("shaker", "block.center", force=(drive, 0.0), expression="cos(angle)")
    return m


def duffing_flow(
    drive: float, damping: float, linear: float, speed: float, start: Array, times: Array
) -> tuple[Array, Array]:
    """Places and velocities at ``times``, shape (times, 2), and the derivatives of the last by the start, by
    a Runge-Kutta of order 8.
    """

    def rates(t: float, y: Array) -> Array:
        x, v, a, b, c, d = y
        slope = -linear - 3.0 * x * x
        push = drive * math.cos(speed * t) - damping * v - linear * x - x**3
        return np.array([v, push, c, d, slope * a - damping * c, slope * b - damping * d])

    states = solved(rates, [float(start[0]), float(start[1]), 1.0, 0.0, 0.0, 1.0], times)
    return states[:, :2], states[-1, 2:].reshape(2, 2)


def duffing_multiplier(
    drive: float, damping: float, linear: float, speed: float, start: Array
) -> tuple[Array, complex]:
    """Find the periodic motion of one turn near ``start`` by Newton's method, with its largest multiplier."""
    turn = np.array([2.0 * math.pi / speed])
    for _ in range(20):
        ends, slope = duffing_flow(drive, damping, linear, speed, start, turn)
        change = np.linalg.solve(slope - np.eye(2), start - ends[-1])
        start = start + change
        if np.abs(change).max() < 1e-10:
            break
    multipliers = np.linalg.eigvals(slope)
    return start, complex(multipliers[np.argmax(np.abs(multipliers))])


# ----------------------------------------------------------------------------------------------------- what
# strikes


def damping_factor(restitution: float) -> float:
    """chi of F = K d^1.5 (1 + chi d'/v) that gives back so much of any speed v: chi (1 + e) = ln[(1 + chi)/(1
    - chi e)].
    """
    low, high = 1e-9, (1.0 - 1e-12) / restitution
    for _ in range(100):
        chi = 0.5 * (low + high)
        is_below = chi * (1.0 + restitution) > math.log((1.0 + chi) / (1.0 - chi * restitution))
        low, high = (chi, high) if is_below else (low, chi)
    return low


def striking(restitution: float, stiffness: float) -> Gonthier:
    """Return a contact law with this ``restitution`` at every speed; the law's own parameter differs: chi =
    (1 - c²)/c.
    """
    chi = damping_factor(restitution)
    return Gonthier(stiffness=stiffness, restitution=0.5 * (math.sqrt(chi * chi + 4.0) - chi))


# ------------------------------------------------------------------------------------- ball on a shaking
# table


def steady_part(restitution: float) -> float:
    """Velocity of the table (in g/omega) at the impacts of a ball that hops once a turn: pi (1 - e)/(1 +
    e).
    """
    return math.pi * (1.0 - restitution) / (1.0 + restitution)


def doubling(restitution: float) -> float:
    """Acceleration A omega^2/g of the table at which that ball begins to hop high and low in turn."""
    return math.hypot(steady_part(restitution), 2.0 * (1.0 + restitution**2) / (1.0 + restitution) ** 2)


def ball_on_a_table(acceleration: float, restitution: float, stiffness: float) -> Mechanism:
    """Build a ball that hops once a turn on a table that moves as A sin(omega t). It starts as the table
    rises through its middle.
    """
    turn = 1.0 / FREQUENCY
    size = acceleration * G / OMEGA**2
    phase = math.acos(steady_part(restitution) / acceleration)
    speed, flown = 0.5 * G * turn, turn - phase / OMEGA
    height = size * math.sin(phase) + speed * flown - 0.5 * G * flown**2
    m = turning("ball on a shaking table", OMEGA, G)
    m.rigid_body("table", mass=1.0, inertia=1.0)
    m.slider("guide", "ground.O", "table.center", direction=(0.0, 1.0))
    m.drivers["shaker"] = Harmonic(slider="guide", amplitude=size, frequency=FREQUENCY)
    m.point_mass("ball", mass=BALL, position=(0.0, RADIUS + height), velocity=(0.0, speed - G * flown, 0.0))
    law = striking(restitution, stiffness)
    m.external_contact(
        "J", "table.center", "ball.center", journal_radius=RADIUS, contact=law, friction=Frictionless()
    )
    return m


def exact_hops(acceleration: float, restitution: float, hops: int, phase: float, speed: float) -> Array:
    """Compute the hops of a hard ball on the same table, each impact from a fine grid and bisection: (phase,
    speed after it), shape (hops, 2).

    Units follow the table: times in 1/omega, speeds in g/omega, heights in g/omega².
    """
    landings, grid = [], np.arange(1, 2001) * 0.01
    for _ in range(hops):
        flown = acceleration * math.sin(phase) + speed * grid - 0.5 * grid**2
        high = float(grid[np.argmax(flown < acceleration * np.sin(phase + grid))])
        low = high - 0.01
        for _ in range(50):
            middle = 0.5 * (low + high)
            height = (
                acceleration * (math.sin(phase) - math.sin(phase + middle)) + speed * middle - 0.5 * middle**2
                > 0.0
            )
            low, high = (middle, high) if height else (low, middle)
        phase, landed = phase + low, speed - low
        speed = -restitution * landed + (1.0 + restitution) * acceleration * math.cos(phase)
        landings.append((phase, speed))
    return np.array(landings)


# --------------------------------------------------------------------------------------- a mass and a stop


def with_a_stop(
    force: float,
    speed: float,
    gap: float,
    restitution: float,
    stiffness: float,
    damping: float,
    start: tuple[float, float],
) -> Mechanism:
    """x'' + damping x' + x = force cos(speed t), 1 kg that meets a stop at x = gap."""
    m = turning("oscillator with a stop", speed)
    m.point("S", -10.0, 0.0)
    m.point("W", gap + 0.5, 0.0)
    m.point_mass("mass", mass=1.0, position=(start[0], 0.0), velocity=(start[1], 0.0, 0.0))
    m.spring("spring", "ground.S", "mass.center", stiffness=1.0, damping=damping, free_length=10.0)
    law = striking(restitution, stiffness)
    m.external_contact(
        "stop",
        "ground.W",
        "mass.center",
        journal_radius=0.5,
        direction=(0.0, 1.0),
        contact=law,
        friction=Frictionless(),
    )
    m.force("shaker", "mass.center", force=(force, 0.0), expression="cos(angle)")
    return m


def grazing(speed: float, damping: float) -> tuple[float, float]:
    """Force that makes the steady vibration 1 m large, and its delay (rad)."""
    return math.hypot(1.0 - speed**2, damping * speed), math.atan2(damping * speed, 1.0 - speed**2)


def rebounding(speed: float, restitution: float, turns: int) -> tuple[float, float, float]:
    """Compute the motion of an undamped mass that meets a hard stop at x = 0 from below once in ``turns``
    turns of the force cos(speed t) (N).

    Returns its place and velocity at time 0 and its impact speed (Shaw and Holmes, Journal of Sound and
    Vibration 90 (1983) 129-155, in the limit of a rigid stop). Between impacts x = A cos t + B sin t + g
    cos(speed t + p); x = 0 at both ends and v+ = -e v- give tan p.
    """
    interval, gain = 2.0 * math.pi * turns / speed, 1.0 / (1.0 - speed**2)
    half = math.tan(0.5 * interval)
    phase = math.atan(-(1.0 - restitution) / (1.0 + restitution) * half / speed)
    if gain * (math.cos(phase) * half - speed * math.sin(phase)) < 0.0:
        phase += math.pi  # it arrives going up
    a, b = -gain * math.cos(phase), -gain * math.cos(phase) * half
    t = (-phase % (2.0 * math.pi)) / speed
    x = a * math.cos(t) + b * math.sin(t) + gain
    v = b * math.cos(t) - a * math.sin(t)
    return x, v, gain * (math.cos(phase) * half - speed * math.sin(phase))
