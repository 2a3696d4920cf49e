"""Chaos and its beginnings: exponents, period doublings, grazing, against published numbers, closed forms and
an integration of its own.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from vfife.dynamics.bifurcation import bifurcation

from .case import Nudge, Row, Rows, verified
from .case_motion import run
from .chaotic import (
    DRIVE,
    FREQUENCY,
    OMEGA,
    Array,
    G,
    ball_on_a_table,
    doubling,
    duffing,
    duffing_multiplier,
    grazing,
    rebounding,
    steady_part,
    with_a_stop,
)  # fmt: skip

WELLS = (0.3, -1.0, 1.2)  # damping, stiffness and speed of Duffing's oscillator with two wells


@verified(
    "Duffing's oscillator with two wells",
    "independent integration with derivatives, and Newton's method",
    nudges={"damping": 1.02},
)
def duffing_two_wells(nudge: Nudge) -> Rows:
    """x'' + 0.3 x' - x + x^3 = d cos 1.2 t: exponents of the motion that repeats each turn, and the drive at
    which its multiplier is -1.
    """
    drives, start, exact = (0.258, 0.262), np.array([0.4, 0.3]), []
    for drive in drives:
        start, multiplier = duffing_multiplier(drive, *WELLS, start)
        exact.append(math.log(-multiplier.real))
    first, _ = duffing_multiplier(drives[0], *WELLS, start)
    options = {"turns": 60, "dropped": 40, "series": ["block.x"], "step": 2.0 * math.pi / 1.2 / 500}
    m = duffing(drives[0], WELLS[0] * nudge("damping"), *WELLS[1:], start=(float(first[0]), float(first[1])))
    diagram = bifurcation(m, DRIVE, *drives, count=2, **options)  # type: ignore[arg-type]
    for drive, reference, value in zip(drives, exact, diagram.exponents[0, :, 0], strict=True):
        yield Row(f"exponent at a drive of {drive:g} N", "1/turn", reference, float(value), 2e-3, 1.0)
    yield Row(
        "drive where the period doubles",
        "N",
        at_zero(drives, exact),
        at_zero(drives, diagram.exponents[0, :, 0]),
        2e-4,
    )


@verified(
    "Ball on a shaking table",
    "closed form for a hard ball: (A ω²/g)² = [π(1 - e)/(1 + e)]² + [2(1 + e²)/(1 + e)²]², from the Jacobian"
    " of its map",
    nudges={"restitution": 1.05},
    quick=False,
)
def ball_on_a_shaking_table(nudge: Nudge) -> Rows:
    """Acceleration of the table at which a ball that hops once a turn begins to hop high and low,
    extrapolated to a contact that takes no time.
    """
    soft, stiff = (
        doubled(stiffness, steps, nudge=nudge("restitution"))
        for stiffness, steps in ((1e6, 6000), (1e7, 20000))
    )
    yield Row(
        "acceleration where the period doubles",
        "g",
        doubling(0.5),
        doubling(0.5) * (stiff + (stiff - soft) / (10.0**0.4 - 1.0)),
        0.01,
    )


@verified(
    "Vibration that grazes a stop",
    "closed form: gap = F/|k - m ω² + icω|, -cT/2m, ω √(X² - gap²) (Nordmark 1991)",
    nudges={"damping": 1.05, "gap": 1.001},
)
def grazing_a_stop(nudge: Nudge) -> Rows:
    """Exponent below grazing, force at which the stop is met, and how fast it is met beyond, which goes with
    the root of how far.
    """
    speed, damping, gap = 0.8, 0.1 * nudge("damping"), 1.0 * nudge("gap")
    force, delay = grazing(speed, 0.1)
    turn = 2.0 * math.pi / speed
    start = math.cos(delay) * 0.9999, speed * math.sin(delay) * 0.9999
    m = with_a_stop(0.9999 * force, speed, gap, 0.8, 1e5, damping, start)
    diagram = bifurcation(
        m,
        DRIVE,
        0.9999 * force,
        1.0001 * force,
        count=2,
        turns=30,
        dropped=20,
        series=["stop.penetration_max"],
        step=turn / 1000,
    )
    deepest = diagram.points["stop.penetration_max"][0].max(axis=1)
    yield Row("exponent before it", "1/turn", -0.05 * turn, float(diagram.exponents[0, 0, 0]), 0.01)
    met = [value for value, depth in zip(diagram.spec.values, deepest, strict=True) if depth > 0.0]
    yield Row("force at which it is met", "N", force, met[0] if met else math.inf, 1.5e-4)
    for excess in (1e-4, 1e-3, 1e-2):
        size = 1.0 + excess
        m = with_a_stop(
            size * force,
            speed,
            gap,
            0.8,
            1e5,
            damping,
            (size * math.cos(delay), size * speed * math.sin(delay)),
        )
        m.joints["stop"] = dataclasses.replace(m.joints["stop"], impact_speed_floor=1e-6)  # type: ignore[call-arg]
        motion = run(m, turns=0.6, outputs=100, step=turn / 8000)
        value = float(motion.contact("stop", "fastest").max())
        yield Row(
            f"speed of the impact, {excess:g} beyond it", "m/s", speed * math.sqrt(size**2 - 1.0), value, 0.01
        )


@verified(
    "Mass that rebounds from a stop",
    "Shaw and Holmes: A periodically forced piecewise linear oscillator. J. Sound Vib. 90 (1983) 129-155;"
    " closed form for a rigid stop",
    nudges={"restitution": 0.7},
    quick=False,
)
def rebounding_mass(nudge: Nudge) -> Rows:
    """One impact in a turn, and one in two: the place at the turn's end, extrapolated to a contact that takes
    no time.
    """
    for speed, turns in ((2.3, 1), (4.3, 2)):
        x, v, _ = rebounding(speed, 0.8, turns)
        places = []
        for stiffness in (1e6, 1e7):
            m = with_a_stop(1.0, speed, 0.0, 0.8 * nudge("restitution"), stiffness, 0.0, (x, v))
            motion = run(m, turns=40.0 * turns, outputs=1, step=2.0 * math.pi / speed / 4000)
            places.append(float(motion.body("mass", "x")[-1]))
        hard = places[1] + (places[1] - places[0]) / (10.0**0.4 - 1.0)
        yield Row(f"place with one impact in {turns} turns", "m", x, hard, 0.01, 1.0)


def at_zero(places: tuple[float, ...] | Array, values: list[float] | Array) -> float:
    """Where a straight line through two points has its zero."""
    return float(places[0] - values[0] * (places[1] - places[0]) / (values[1] - values[0]))


def doubled(stiffness: float, steps: int, restitution: float = 0.5, nudge: float = 1.0) -> float:
    """Acceleration at which the model's ball doubles its period, as a share of the closed form of a hard one.

    The product of both multipliers is e^2, so exponents of two motions below give their sums, which go down
    in proportion to the table's acceleration at the impact to -(1 + e^2), where one of them is -1.
    """
    shares, hard = np.array([0.95, 0.965]), doubling(restitution)
    low, high = (G / OMEGA**2) * hard * shares
    diagram = bifurcation(
        ball_on_a_table(float(shares[0] * hard), restitution * nudge, stiffness), "driver.shaker.amplitude",
        float(low), float(high),
        count=2, turns=50, dropped=35, series=["ball.y"], step=1.0 / FREQUENCY / steps,
    )  # fmt: skip
    sums = -np.exp(diagram.exponents[0, :, 0]) - restitution**2 * np.exp(-diagram.exponents[0, :, 0])
    across = np.sqrt((shares * hard) ** 2 - steady_part(restitution) ** 2)
    return math.hypot(at_zero(across, sums + 1.0 + restitution**2), steady_part(restitution)) / hard
