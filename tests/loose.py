"""Mechanisms with clearance, drawn and made up: what is said of a run's range is checked on them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from support import four_bar as reference_case
from support import with_settings
from vfife import gallery
from vfife.laws import Ambrosio, Coulomb, Frictionless, LankaraniNikravesh
from vfife.model.mechanism import Mechanism
from vfife_validation.paper.mechanisms import Parameters
from vfife_validation.paper.mechanisms import four_bar as paper_four_bar

INFERRED = {"first": Parameters(), "second": Parameters(axial_length=6e-3, v0=0.05, v1=0.5)}
SMOOTH = LankaraniNikravesh(restitution=0.9)
RUB = Ambrosio(coefficient=0.1, v0=1e-3, v1=1e-2)


def loosened(m: Mechanism, joint: str, clearance: float, **options: Any) -> Mechanism:
    """The mechanism with clearance in one of its revolutes."""
    ideal = m.joints.pop(joint)
    options = {"bearing_radius": 0.01, "contact": SMOOTH, "friction": RUB} | options
    m.clearance_joint(joint, ideal.bearing, ideal.journal, clearance=clearance, **options)
    return m


def of_the_gallery() -> dict[str, Callable[[], Mechanism]]:
    """Twelve: those with clearance, and others that lose an ideal joint."""
    return {
        "block on an incline": gallery.block_on_incline,
        "four-bar": lambda: with_settings(gallery.four_bar(), turns=3.0),
        "case b": gallery.four_bar_case_b,
        "case c": gallery.four_bar_case_c,
        "journal": gallery.journal_in_bearing,
        "loose guide": gallery.slider_crank_loose_guide,
        "loose pin": gallery.slider_crank_loose_pin,
        "loose guide, friction": lambda: gallery.slider_crank_loose_guide(friction=0.1),
        "loose pin, friction": lambda: gallery.slider_crank_loose_pin(friction=0.1),
        "four-bar, ideal": lambda: loosened(gallery.four_bar_ideal(), "C", 1e-4),
        "slider-crank": lambda: loosened(gallery.slider_crank(), "crankpin", 2e-4),
        "jansen leg": lambda: loosened(gallery.jansen_leg(), list(gallery.jansen_leg().joints)[1], 1e-4),
    }


def known() -> dict[str, Callable[[], Mechanism]]:
    """Cases b and c, their sensitive neighbours, and the paper's four-bar with both inferred sets."""
    found: dict[str, Callable[[], Mechanism]] = {
        "b": lambda: reference_case("C"),
        "c": lambda: reference_case("BCD"),
    }
    for name, one in INFERRED.items():
        for clearance in (1e-4, 2e-4, 5e-4):
            made = dataclasses.replace(one)
            found[f"{name} set, {1e3 * clearance:g} mm"] = lambda p=made, c=clearance: with_settings(
                paper_four_bar(p, c), turns=3.0, parts=8
            )
    return found


def made_up(seed: int) -> Mechanism:
    """A mechanism with contact that nobody drew."""
    draw = np.random.default_rng(seed)
    return (_four_bar, _slider_crank, _pendulum, _bouncing)[seed % 4](draw)


def _laws(draw: np.random.Generator) -> dict[str, Any]:
    friction = (
        Frictionless(),
        Ambrosio(coefficient=float(draw.uniform(0.02, 0.2)), v0=1e-3, v1=2e-2),
        Coulomb(coefficient=float(draw.uniform(0.02, 0.2))),
    )
    return {
        "contact": LankaraniNikravesh(restitution=float(draw.uniform(0.5, 0.95))),
        "friction": friction[draw.integers(3)],
    }


def _four_bar(draw: np.random.Generator) -> Mechanism:
    """A crank-rocker with one to three loose joints."""
    crank = float(draw.uniform(0.05, 0.12))
    ground, coupler, rocker = 0.4, float(draw.uniform(0.3, 0.42)), float(draw.uniform(0.28, 0.4))
    m = Mechanism("made up four-bar", gravity=(0.0, -9.81))
    m.point("A", 0.0, 0.0)
    m.point("D", ground, 0.0)
    apart = ground - crank
    bend = math.acos((coupler**2 + apart**2 - rocker**2) / (2.0 * coupler * apart))
    end = np.array([crank + coupler * math.cos(bend), coupler * math.sin(bend)])
    m.link("crank", length=crank, mass=0.5)
    m.link("coupler", length=coupler, mass=float(draw.uniform(0.3, 1.5)), angle=bend)
    m.link(
        "rocker", length=rocker, mass=float(draw.uniform(0.3, 1.5)), angle=math.atan2(end[1], end[0] - ground)
    )
    for name, bearing, journal in (
        ("A", "ground.A", "crank.start"),
        ("B", "crank.end", "coupler.start"),
        ("C", "coupler.end", "rocker.end"),
        ("D", "ground.D", "rocker.start"),
    ):
        m.revolute(name, bearing, journal)
    loose = ("B", "C", "D", "BC", "CD", "BD", "BCD")[draw.integers(7)]
    for joint in loose:
        loosened(m, joint, float(draw.uniform(5e-5, 4e-4)), **_laws(draw))
    m.drive("crank", speed=float(draw.uniform(20.0, 120.0)))
    return with_settings(m, turns=2.0)


def _slider_crank(draw: np.random.Generator) -> Mechanism:
    options = {
        "clearance": float(draw.uniform(1e-4, 6e-4)),
        "restitution": float(draw.uniform(0.6, 0.95)),
        "friction": float(draw.choice([0.0, 0.05, 0.15])),
    }
    made = (gallery.slider_crank_loose_pin, gallery.slider_crank_loose_guide)[draw.integers(2)]
    return made(speed=float(draw.uniform(30.0, 150.0)), turns=1.0, **options)


def _pendulum(draw: np.random.Generator) -> Mechanism:
    """A rod that swings in a loose bearing."""
    m = Mechanism("made up pendulum", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link(
        "rod",
        length=float(draw.uniform(0.1, 0.5)),
        mass=float(draw.uniform(0.2, 2.0)),
        angle=float(draw.uniform(-2.5, -0.5)),
    )
    m.revolute("O", "ground.O", "rod.start")
    loosened(m, "O", float(draw.uniform(1e-4, 5e-4)), **_laws(draw))
    return with_settings(m, duration=0.3)


def _bouncing(draw: np.random.Generator) -> Mechanism:
    """A spinning disc that is thrown on a slope."""
    m = Mechanism("made up throw", gravity=(0.0, -9.81))
    slope = float(draw.uniform(-0.4, 0.4))
    m.point("floor", 0.0, 0.0)
    m.rigid_body(
        "disc",
        mass=1.0,
        inertia=8e-4,
        position=(0.0, float(draw.uniform(0.06, 0.15))),
        velocity=(float(draw.uniform(-1, 1)), -0.5, float(draw.uniform(-20, 20))),
    )
    m.external_contact(
        "floor",
        "ground.floor",
        "disc.center",
        journal_radius=0.04,
        direction=(math.cos(slope), math.sin(slope)),
        **_laws(draw),
    )
    return with_settings(m, duration=0.25)
