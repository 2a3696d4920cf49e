"""Means over turns that begin and end between two outputs, against numbers not made here: energy that a conservative
machine gives back, power of a viscous load, and the ledger.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest

import vfife
from vfife import gallery
from vfife.measures.turns import last_turn, of_turn, of_window

SPEED = 2.0 * math.pi * 10.0  # rad/s, of the Scotch yoke
TURN = 2.0 * math.pi / SPEED
RADIUS, DAMPING = 0.05, 40.0  # m, N s/m


def yoke() -> vfife.Mechanism:
    """A Scotch yoke whose slide, x = r cos(w t), moves a dashpot along its way: the power is c (r w sin(w t))^2."""
    m = gallery.scotch_yoke()
    m.gravity = (0.0, 0.0)
    m.point("far", 1.0, 0.0)
    m.spring("dashpot", "ground.far", "yoke.rod", stiffness=0.0, damping=DAMPING, free_length=0.5)
    return m


@pytest.mark.parametrize("share", [0.31, 0.5, 0.77])
@pytest.mark.parametrize("length", [{"turns": 1}, {"turns": 5}, {"duration": 2.37 * TURN}])
def test_the_mean_power_of_a_viscous_load(share: float, length: dict[str, Any]) -> None:
    """c (r w)^2/2, and the torque is that over the speed, whatever part of an output a turn is longer."""
    step = TURN / (200.0 + share) / 20.0
    result = vfife.simulate(yoke(), step=step, outputs=200, **length)
    power = DAMPING * (RADIUS * SPEED) ** 2 / 2.0
    measured, torque = result.measures["crank.power.mean"], result.measures["crank.torque.mean"]
    assert measured.estimated and measured.low <= power <= measured.high
    assert measured == pytest.approx(power, rel=2e-5) and torque == pytest.approx(power / SPEED, rel=2e-5)
    assert measured.width < 2e-3 * power
    (note,) = [note for note in result.summary["run"]["notes"] if "interpolated at its ends" in note]
    assert "mean powers and torques" in note


def test_the_cut_at_an_output_would_be_wrong() -> None:
    """The same run, with the outputs nearest to the ends of the turn, misses by more than a tenth."""
    result = vfife.simulate(yoke(), step=TURN / 200.5 / 20.0, outputs=200, turns=1, companions=0)
    record, window = result.record, last_turn(result.record)
    exact, cut = of_turn(record, window), of_window(record, window).record

    def mean(part: Any) -> float:
        work = part.block("driven_work")[:, 0] - 0.5 * part.assembly.choice.step * part.block("driven_power")[:, 0]
        return float(work[-1] - work[0]) / (float(part.steps[-1] - part.steps[0]) * part.assembly.choice.step)

    power = DAMPING * (RADIUS * SPEED) ** 2 / 2.0
    assert mean(exact) == pytest.approx(power, rel=2e-5)
    assert abs(mean(cut) - power) > 2e-3 * power


@pytest.mark.parametrize(("speed", "step"), [("61 rpm", 5e-4), ("60 rpm", 3e-4), ("60 rpm", 7e-4)])
def test_a_conservative_press_takes_no_power(speed: str, step: float) -> None:
    m = gallery.six_bar_press()
    m.drivers["crank"] = dataclasses.replace(m.drivers["crank"], speed=speed)
    result = vfife.simulate(m, step=step)
    power, torque = result.measures["crank.power.mean"], result.measures["crank.torque.max"]
    assert power.low <= 0.0 <= power.high
    assert abs(power) < 1e-6 * torque * 2.0 * math.pi and power.width < 1e-4 * torque * 2.0 * math.pi
