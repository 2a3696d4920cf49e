"""The answer of a run without a crank of constant speed states the speed that a torque reaches."""

from __future__ import annotations

import math

import pytest

import vfife
from vfife.modelfile import loads

FLYWHEEL = """
[run]
duration = "2 s"
[ground]
O = [0, 0]
[body.wheel]
mass = "5 kg"
inertia = "0.1 kg m^2"
[body.wheel.pins]
c = [0, 0]
[joint.O]
bearing = "ground.O"
journal = "wheel.c"
[driver.wheel]
torque = [2, 0]
speeds = ["0 rad/s", "50 rad/s"]
interpolation = "linear"
"""


def test_a_flywheel_under_a_motor_curve() -> None:
    """Torque 2 N m (1 - w/w0) on an inertia I: w = w0 (1 - exp(-2 N m t/(I w0)))."""
    result = vfife.simulate(loads(FLYWHEEL))
    speed = 50.0 * (1.0 - math.exp(-2.0 * 2.0 / (0.1 * 50.0)))
    reached = result.summary["run"]["reached"]["wheel"]
    assert reached["end"] == reached["high"] == pytest.approx(speed, rel=1e-4) and reached["low"] == 0.0
    text = " ".join(str(result).split())
    assert f"Speed wheel {speed:.4g} rad/s ({30.0 * speed / math.pi:.4g} rpm) at the end" in text
    assert f"least 0 rad/s, largest {speed:.4g} rad/s (not estimated)" in text


def test_a_crank_of_constant_speed_has_none() -> None:
    result = vfife.simulate(vfife.gallery.scotch_yoke(), turns=1, companions=0)
    assert "reached" not in result.summary["run"]
