"""Equilibria of beams and frames under large displacements."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from vfife.laws import Material
from vfife.model.bodies import Member, Section
from vfife.model.drivers import AngleTable
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism

from .case import Nudge, Row, Rows, verified
from .case_motion import run
from .lagrange import solved

Array = NDArray[np.float64]

SLENDER = 4.8e5  # E A L^2/(E I)
ELASTICA = (
    "inextensible elastica by elliptic integrals (Bisshopp, Drucker: Large deflection of cantilever beams. Q."
    " Appl. Math. 3 (1945) 272-275)"
)
WILLIAMS = (
    "Williams: An approach to the non-linear behaviour of the members of a rigid jointed plane framework. Q."
    " J. Mech. Appl. Math. 17 (1964) 451-469; limit loads of the discrete frame from an independent program"
)
INCH, POUND = 0.0254, 4.4482216152605


def static(m: Mechanism, *factors: float) -> Mechanism:
    """Set a static analysis with these load factors."""
    m.settings = dataclasses.replace(m.settings, analysis="static", load_factors=factors, residual=1e-7)
    return m


def cantilever(stiffness: float = 1.0, elements: int = 20, **load: object) -> Mechanism:
    """Beam along x of 1 m with E I = 1 N m^2 that barely stretches, clamped at the origin, with a load at its
    end.
    """
    m = Mechanism("cantilever")
    m.point("O", 0.0, 0.0)
    material = Material("flexible", SLENDER * stiffness, 0.3, 1000.0)
    m.link(
        "beam",
        length=1.0,
        model="elastic",
        elements=elements,
        section=Section(1.0, 1.0 / SLENDER),
        material=material,
        mass=1.0,
    )
    m.weld("O", "ground.O", "beam.start")
    m.loads["load"] = PointForce(name="load", at="beam.end", **load)  # type: ignore[arg-type]
    return m


@verified("Cantilever under a dead tip load", ELASTICA, nudges={"stiffness": 1.02}, quick=False)
def elastica(nudge: Nudge) -> Rows:
    """1 - x/L and y/L of the tip at P L^2/(E I) = 0.5, 1, 2, 5, 10."""
    table = {
        0.5: (0.015919, 0.162144), 1.0: (0.056433, 0.301721), 2.0: (0.160642, 0.493457), 5.0: (0.387628,
        0.713792), 10.0: (0.554996, 0.810609),
    }  # fmt: skip
    motion = run(static(cantilever(nudge("stiffness"), force=(0.0, 1.0)), *table))
    tip = motion.pin("beam", "end")
    for k, (load, (x, y)) in enumerate(table.items(), start=1):
        yield Row(f"1 - x/L at P L²/EI = {load:g}", "1", x, float(1.0 - tip[k, 0]), 1e-3)
        yield Row(f"y/L at P L²/EI = {load:g}", "1", y, float(tip[k, 1]), 1e-3)


@verified(
    "Cantilever bent to a circle by an end moment",
    "closed form: x/L = sin(2πq)/(2πq), y/L = (1 - cos 2πq)/(2πq)", nudges={"stiffness": 1.02},
    quick=False,
)  # fmt: skip
def closed_circle(nudge: Nudge) -> Rows:
    """M = 2πq E I/L: tip at q = 1/4, 1/2, 1; at 1 it comes back to the clamp."""
    shares = (0.25, 0.5, 1.0)
    motion = run(static(cantilever(nudge("stiffness"), moment=2.0 * math.pi), *shares))
    tip, turn = motion.pin("beam", "end"), motion.turn("beam", "end")
    for k, q in enumerate(shares, start=1):
        a = 2.0 * math.pi * q
        yield Row(f"x/L at q = {q:g}", "1", math.sin(a) / a, float(tip[k, 0]), 1e-3, 1.0)
        yield Row(f"y/L at q = {q:g}", "1", (1.0 - math.cos(a)) / a, float(tip[k, 1]), 1e-3, 1.0)
        yield Row(f"rotation of the tip at q = {q:g}", "rad", a, float(turn[k]), 1e-3)


def toggle(elements: int, stiffness: float = 1.0) -> Mechanism:
    """Williams' toggle, its apex pushed down; the load factor is the drop in inches."""
    m = Mechanism(f"Williams toggle, {elements} elements a side")
    half, rise = 12.943 * INCH, 0.386 * INCH
    m.point("L", -half, 0.0)
    m.point("R", half, 0.0)
    section = Section.rectangle(0.753 * INCH, 0.243 * INCH)
    material = Material("aluminium", 1.03e7 * POUND / INCH**2 * stiffness, 0.3, 2700.0)
    legs = (Member("left", "apex", elements), Member("apex", "right", elements))
    nodes = {"left": (-half, 0.0), "apex": (0.0, rise), "right": (half, 0.0)}
    m.frame("toggle", nodes=nodes, members=legs, section=section, material=material)
    m.weld("L", "ground.L", "toggle.left")
    m.weld("R", "ground.R", "toggle.right")
    m.drivers["push"] = AngleTable(
        point="toggle.apex", direction=(0.0, -1.0), times=(0.0, 1.0), values=(0.0, INCH)
    )
    return m


def limits(elements: int, stiffness: float) -> tuple[float, float]:
    """Upper and lower limit load (lb): extremes of parabolas through the loads at drops around them."""
    drops = (0.213, 0.233, 0.253, 0.372, 0.392, 0.412)
    motion = run(static(toggle(elements, stiffness), *drops))
    load = -motion.ideal("push", "fy")[1:] / POUND
    sign = 1.0 if load[0] > 0.0 else -1.0
    extremes = []
    for part in (slice(0, 3), slice(3, 6)):
        a, b, c = np.polyfit(np.array(drops[part]) - drops[part.start + 1], sign * load[part], 2)
        extremes.append(float(c - b * b / (4.0 * a)))
    return extremes[0], extremes[1]


@verified("Williams' toggle frame", WILLIAMS, nudges={"stiffness": 1.005}, quick=False)
def williams_toggle(nudge: Nudge) -> Rows:
    """Both limit loads, with 20 and with 4 elements a side."""
    for elements, upper, lower in ((4, 35.66, 32.91), (20, 33.94, 31.35)):
        extremes = limits(elements, nudge("stiffness"))
        yield Row(f"limit load, {elements} elements a side", "lb", upper, extremes[0], 1e-3)
        yield Row(f"lower limit load, {elements} elements a side", "lb", lower, extremes[1], 1e-3)


def follower_shape(load: float) -> tuple[float, float, float]:
    """Tip x, y and rotation of a right-angled frame of two legs of 1 m, E I = 1: inextensible, by integration
    from the tip inwards.

    In the tip's frame a follower force P across the second leg is fixed, so moment and angle follow from the
    tip on: M' = P cos(angle).
    """
    x = y = angle = moment = 0.0
    for corner in (0.5 * math.pi, 0.0):

        def rates(s: float, state: Array) -> Array:
            _, _, a, bend = state
            # Outwards the direction is (cos a, sin a); inwards x and y go back, and so does the angle.
            return np.array([-math.cos(a), -math.sin(a), -bend, load * math.cos(a)])

        x, y, angle, moment = solved(rates, [x, y, angle, moment], np.array([1.0]))[-1]
        angle += corner
    # The clamp stands upright: turn the picture so that the first leg's start points along y, and count from
    # there.
    turn = 0.5 * math.pi - angle
    c, s = math.cos(turn), math.sin(turn)
    return -(c * x - s * y), -(s * x + c * y), turn


def right_angle(load: float, stiffness: float = 1.0, elements: int = 20) -> Mechanism:
    """Build a column of 1 m with a beam of 1 m on it, E I = 1, and a force across the beam's end that turns
    with it.
    """
    m = Mechanism("right-angled frame")
    m.point("O", 0.0, 0.0)
    material = Material("flexible", SLENDER * stiffness, 0.3, 1.0)
    nodes = {"foot": (0.0, 0.0), "corner": (0.0, 1.0), "tip": (1.0, 1.0)}
    members = (Member("foot", "corner", elements), Member("corner", "tip", elements))
    m.frame("frame", nodes=nodes, members=members, section=Section(1.0, 1.0 / SLENDER), material=material)
    m.weld("O", "ground.O", "frame.foot")
    m.loads["push"] = PointForce(name="push", at="frame.tip", force=(0.0, load), follow=True)
    return m


@verified(
    "Two-bar frame under a follower load",
    "inextensible elastica integrated from the tip inwards (order 8)",
    nudges={"stiffness": 1.01},
    quick=False,
)
def follower_frame(nudge: Nudge) -> Rows:
    """P L²/EI = 0.5: place and rotation of the tip."""
    load = 0.5
    x, y, turned = follower_shape(load)
    motion = run(static(right_angle(load, nudge("stiffness")), 1.0))
    tip, turn = motion.pin("frame", "tip")[-1], motion.turn("frame", "tip")
    yield Row("movement of the tip in x", "m", x - 1.0, float(tip[0] - 1.0), 1e-3)
    yield Row("movement of the tip in y", "m", y - 1.0, float(tip[1] - 1.0), 1e-3)
    yield Row("rotation of the tip", "rad", turned, float(turn[-1] - turn[0]), 1e-3)


@verified(
    "Rigid arm welded to the end of a cantilever",
    "closed form: P L³/3EI + P a L²/2EI, P L²/2EI + P a L/EI",
    nudges={"stiffness": 1.005, "load": 1.005},
    quick=False,
)
def welded_arm(nudge: Nudge) -> Rows:
    """Compare a small force at the end of a rigid arm of 0.5 m beyond the tip: deflection, rotation, moment
    and force of the clamp and of the weld.
    """
    p, arm = 1e-3, 0.5
    m = cantilever(nudge("stiffness"))
    m.rigid_body(
        "arm", mass=1.0, inertia=0.1, pins={"root": (-0.25, 0.0), "end": (0.25, 0.0)}, position=(1.25, 0.0)
    )
    m.weld("tip", "beam.end", "arm.root")
    m.loads["load"] = PointForce(name="load", at="arm.end", force=(0.0, p * nudge("load")))
    motion = run(static(m, 1.0))
    yield Row(
        "deflection of the tip", "m", p / 3.0 + 0.5 * p * arm, float(motion.pin("beam", "end")[-1, 1]), 1e-3
    )
    yield Row("rotation of the arm", "rad", 0.5 * p + p * arm, float(motion.body("arm")[-1]), 1e-3)
    yield Row(
        "moment of the weld on the arm", "N m", -p * arm, float(motion.ideal("tip", "moment")[-1]), 1e-3
    )
    yield Row(
        "moment of the clamp on the beam",
        "N m",
        -p * (1.0 + arm),
        float(motion.ideal("O", "moment")[-1]),
        1e-3,
    )


@verified(
    "Guide on the end of a cantilever",
    "closed form: P L³/3EI + P a L²/2EI",
    nudges={"stiffness": 1.005, "load": 1.005},
    quick=False,
)
def elastic_guide(nudge: Nudge) -> Rows:
    """Compare a block in a guide that an elastic beam carries, held along it by a spring: the beam's
    deflection under a force across the guide, and the guide's moment.
    """
    p, away = 1e-3, 0.2
    m = cantilever(nudge("stiffness"))
    m.rigid_body("block", mass=1.0, inertia=0.1, position=(1.0 + away, 0.0))
    m.slider("guide", "beam.end", "block.center")
    m.point("far", 2.0, 0.0)
    m.spring("hold", "ground.far", "block.center", stiffness=1.0)
    m.loads["load"] = PointForce(name="load", at="block.center", force=(0.0, p * nudge("load")))
    motion = run(static(m, 1.0))
    yield Row(
        "deflection of the tip", "m", p / 3.0 + 0.5 * p * away, float(motion.pin("beam", "end")[-1, 1]), 1e-3
    )
    yield Row("rotation of the block", "rad", 0.5 * p + p * away, float(motion.body("block")[-1]), 1e-3)
    yield Row("force of the guide on the block", "N", -p, float(motion.ideal("guide", "fy")[-1]), 1e-3)
