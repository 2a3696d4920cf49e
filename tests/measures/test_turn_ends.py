"""Means over turns that begin and end between two outputs, against numbers not made here: energy that a
conservative machine gives back, power of a viscous load, and what friction and knocks take.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest

import vfife
from vfife import gallery
from vfife.measures.turns import last_turn, of_turn, of_window
from vfife.modelfile import loads

SPEED = 2.0 * math.pi * 10.0  # rad/s, of the Scotch yoke
TURN = 2.0 * math.pi / SPEED
RADIUS, DAMPING = 0.05, 1.0  # m, N s/m
POWER = DAMPING * (RADIUS * SPEED) ** 2 / 2.0  # W, the mean of c (r w sin(w t))^2


def yoke() -> vfife.Mechanism:
    """A Scotch yoke whose slide moves a dashpot along its way, x = r cos(w t)."""
    m = gallery.scotch_yoke()
    m.gravity = (0.0, 0.0)
    m.point("far", 1.0, 0.0)
    m.spring("dashpot", "ground.far", "yoke.rod", stiffness=0.0, damping=DAMPING, free_length=0.5)
    return m


@pytest.mark.parametrize("share", [0.31, 0.47, 0.77])
@pytest.mark.parametrize("length", [{"turns": 1}, {"turns": 5}, {"duration": 2.37 * TURN}])
def test_the_mean_power_of_a_viscous_load(share: float, length: dict[str, Any]) -> None:
    """The mean torque is the power over the speed, whatever part of an output a turn is longer."""
    result = vfife.simulate(yoke(), step=TURN / (200.0 + share) / 20.0, outputs=200, **length)
    measured, torque = result.measures["crank.power.mean"], result.measures["crank.torque.mean"]
    assert measured.estimated and measured.low <= POWER <= measured.high
    assert measured == pytest.approx(POWER, rel=2e-4) and torque == pytest.approx(POWER / SPEED, rel=2e-4)
    assert measured.width < 5e-3 * POWER
    (note,) = [note for note in result.summary["run"]["notes"] if "interpolated at its ends" in note]
    assert "mean powers and torques" in note


def test_the_cut_at_outputs_would_be_wrong() -> None:
    """The same run from the outputs inside the turn alone misses by more than one per cent."""
    step = TURN / 200.47 / 20.0
    result = vfife.simulate(yoke(), step=step, outputs=200, duration=2.37 * TURN, companions=0)
    record, window = result.record, last_turn(result.record)
    means = []
    for part in (of_turn(record, window), of_window(record, window).record):
        work = (part.block("driven_work") - 0.5 * step * part.block("driven_power"))[:, 0]
        means.append(float((work[-1] - work[0]) / ((part.steps[-1] - part.steps[0]) * step)))
    assert means[0] == pytest.approx(POWER, rel=2e-4)
    assert abs(means[1] - POWER) > 1e-2 * POWER


@pytest.mark.parametrize(("speed", "step"), [(61.0, 5e-4), (60.0, 3e-4), (60.0, 7e-4)])
def test_a_conservative_press_takes_no_power(speed: float, step: float) -> None:
    m = gallery.six_bar_press()
    m.drivers["crank"] = dataclasses.replace(m.drivers["crank"], speed=speed * math.pi / 30.0)
    result = vfife.simulate(m, step=step)
    power, torque = result.measures["crank.power.mean"], result.measures["crank.torque.max"]
    assert power.low <= 0.0 <= power.high
    assert abs(power) < 1e-6 * torque * 2.0 * math.pi and power.width < 1e-4 * torque * 2.0 * math.pi


SIX_BAR = """
[run]
turns = 3
[ground]
A = [0, 0]
D = ["0.30 m", 0]
G = ["0.62 m", "-0.02 m"]
[body.crank]
length = "80 mm"
mass = "0.6 kg"
[body.coupler]
length = "280 mm"
mass = "1.4 kg"
angle = "40 deg"
[body.rocker]
length = "200 mm"
mass = "1.5 kg"
angle = "100 deg"
pins = { e = ["120 mm", "-40 mm"] }
[body.rod]
length = "260 mm"
mass = "1.1 kg"
angle = "10 deg"
[body.lever]
length = "170 mm"
mass = "1.0 kg"
angle = "85 deg"
[joint.A]
bearing = "ground.A"
journal = "crank.start"
[joint.B]
bearing = "crank.end"
journal = "coupler.start"
[joint.C]
kind = "clearance"
bearing = "coupler.end"
journal = "rocker.end"
clearance = "0.1 mm"
bearing_radius = "10 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.8 }
friction = { law = "ambrosio", coefficient = 0.08, v0 = "1 mm/s", v1 = "10 mm/s" }
[joint.D]
bearing = "ground.D"
journal = "rocker.start"
[joint.E]
bearing = "rocker.e"
journal = "rod.start"
[joint.F]
bearing = "rod.end"
journal = "lever.end"
[joint.G]
bearing = "ground.G"
journal = "lever.start"
[driver.crank]
speed = "300 rpm"
"""


@pytest.mark.parametrize(("speed", "turns"), [(301, 3), (303, 6), (311, 3)])
def test_the_driver_pays_what_friction_and_knocks_take(speed: float, turns: int) -> None:
    """A loose six-bar, whose torque swings by 40 N m about 20 mN m; a step of 1 us divides no turn."""
    m = loads(SIX_BAR.replace("300 rpm", f"{speed} rpm"))
    measures = vfife.simulate(m, step=1e-6, turns=turns, companions=3, reference=False).measures
    lost = measures["C.friction_power.mean"] + measures["C.impact_power.mean"]
    power = measures["crank.power.mean"]
    assert power.estimated and power.low <= lost <= power.high and power.width < 1e-2 * power
    assert measures["crank.torque.mean"] * speed * math.pi / 30.0 == pytest.approx(power, rel=1e-9)
