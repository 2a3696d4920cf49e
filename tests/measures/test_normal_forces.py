"""Hertz' pressure is that of the normal force: friction in the same contact does not change it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import vfife
from vfife.laws.friction import none, stribeck
from vfife.measures.contacts import pairs
from vfife.measures.normal_forces import largest_coefficient, met_shares, normal_shares, share_bounds
from vfife.measures.turns import last_turn
from vfife.modelfile import loads as model_of

LOAD = 100.0  # N, which presses a housing in its guide on the journal that turns in it
MODEL = """
name = "journal turned under a steady load"
[run]
turns = {turns}
outputs = {outputs}
[ground]
A = [0, 0]
[body.shaft]
mass = "2 kg"
inertia = "2e-3 kg m^2"
[body.shaft.pins]
c = [0, 0]
[body.housing]
mass = "1 kg"
inertia = "1e-3 kg m^2"
[body.housing.pins]
c = [0, 0]
[joint.A]
bearing = "ground.A"
journal = "shaft.c"
[joint.g]
kind = "slider"
bearing = "ground.A"
journal = "housing.c"
direction = [1, 0]
[joint.nip]
kind = "clearance"
bearing = "housing.c"
journal = "shaft.c"
clearance = "0.05 mm"
bearing_radius = "10 mm"
axial_length = "20 mm"
contact = {{ law = "lankarani-nikravesh", restitution = 0.7 }}
friction = {{ law = "coulomb", coefficient = {friction} }}
[load.press]
at = "housing.c"
force = ["100 N", 0]
[driver.shaft]
speed = "50 rad/s"
"""


def simulated(friction: float, turns: float = 5, outputs: int = 720):
    return vfife.simulate(model_of(MODEL.format(friction=friction, turns=turns, outputs=outputs)))


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5])
def test_the_line_pressure_of_a_sliding_journal_is_that_of_its_normal_force(friction: float) -> None:
    """p0 = sqrt(F_N E*/(pi L R)), a = sqrt(4 F_N R/(pi L E*)); the resultant is sqrt(1 + mu^2) times F_N."""
    result = simulated(friction)
    (pair,) = pairs(result.record)
    per_length, modulus, radius = LOAD / pair.axial_length, pair.composite_modulus, pair.relative_radius
    exact = {
        "contact_pressure": math.sqrt(per_length * modulus / (math.pi * radius)),
        "contact_half_width": math.sqrt(4.0 * per_length * radius / (math.pi * modulus)),
    }
    for kind, value in exact.items():
        measure = result.measures[f"nip.{kind}.max"]
        assert measure == pytest.approx(value, rel=2e-4)
        assert measure.low <= value <= measure.high and measure.width < 1e-3 * value
    force = result.measures["nip.force.max"]
    assert force == pytest.approx(LOAD * math.sqrt(1.0 + friction * friction), rel=2e-4)


def hertz(result: vfife.Result, friction: float) -> tuple[float, float]:
    """Pressure (Pa) and half-width (m) of the normal force in the largest force of the sliding journal."""
    (pair,) = pairs(result.record)
    per_length = result.measures["nip.force.max"].value / math.hypot(1.0, friction) / pair.axial_length
    modulus, radius = pair.composite_modulus, pair.relative_radius
    return (
        math.sqrt(per_length * modulus / (math.pi * radius)),
        math.sqrt(4.0 * per_length * radius / (math.pi * modulus)),
    )


@pytest.mark.parametrize("outputs", [40, 60, 90, 127, 180, 720])
@pytest.mark.parametrize("friction", [0.3, 0.5])
def test_pressure_is_of_the_normal_force_whether_an_output_meets_the_impact_or_not(
    outputs: int, friction: float
) -> None:
    """The journal slides at 0.5 m/s, so that friction is full at any moment of the contact."""
    result = simulated(friction, turns=0.1, outputs=outputs)
    pressure, width = (
        result.measures[f"nip.{kind}.max"] for kind in ("contact_pressure", "contact_half_width")
    )
    exact = hertz(result, friction)
    assert (pressure.value, width.value) == pytest.approx(exact, rel=1e-6)
    assert pressure.low <= exact[0] <= pressure.high and width.low <= exact[1] <= width.high


@pytest.mark.parametrize("outputs", [60, 720])
def test_a_run_that_outputs_miss_knows_its_friction_from_the_law_or_the_next_output(outputs: int) -> None:
    """Outputs 2 ms apart miss the impact, of which 0.17 ms apart meet it; no friction is possible, too."""
    result = simulated(0.5, turns=0.1, outputs=outputs)
    window, share = last_turn(result.record), 1.0 / math.sqrt(1.25)
    assert normal_shares(result.record, window) == pytest.approx([share], rel=1e-6)
    pressure = result.measures["nip.contact_pressure.max"]
    if outputs == 60:
        assert np.isnan(met_shares(result.record, window)).all()
        assert pressure.high == pytest.approx(pressure / math.sqrt(share), rel=1e-6)
    else:
        assert met_shares(result.record, window) == pytest.approx([share], rel=1e-6)
        assert pressure.high < pressure / math.sqrt(share)


def test_bounds_reach_from_full_friction_to_none() -> None:
    """An estimate of the share lies between both."""
    record = simulated(0.5, turns=0.1, outputs=60).record
    assert share_bounds(record, last_turn(record)) == {
        "nip": (pytest.approx(1.0, rel=1e-6), pytest.approx(math.sqrt(1.25), rel=1e-6))
    }
    record = simulated(0.5, turns=0.1, outputs=720).record
    assert share_bounds(record, last_turn(record)) == {}


def test_the_largest_coefficient_is_the_static_one() -> None:
    assert largest_coefficient(none.Frictionless()) == 0.0
    assert largest_coefficient(stribeck.Stribeck(coefficient=0.1, static_coefficient=0.3)) == 0.3
