"""Runs whose drivers and gears turn bodies at several speeds: turns are those of the fastest driver, and what
turns slower repeats after several of them.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

import vfife
from vfife.model.functions import cycle_of
from vfife.simulation.result import Result
from vfife.solvers.repeating import within_gap

TURN = 2.0 * math.pi
OUTPUTS = 180


def geared(teeth: float, m: vfife.Mechanism | None = None) -> vfife.Mechanism:
    """A motor that turns the crank of a slider-crank through gears, ``teeth`` times as slow."""
    m = m or vfife.gallery.slider_crank()
    m.point("M", -0.2, 0.0)
    m.rigid_body("motor", mass=1.0, inertia=1e-3)
    m.revolute("M", "ground.M", "motor.center")
    m.gear("box", "motor", "crank", ratio=-1.0 / teeth)
    m.drivers.clear()
    m.drive("motor", speed=100.0)
    return m


def arm(ratio: float) -> vfife.Mechanism:
    """Two rods without a stop; the motor of the second rides on the first and is ``ratio`` times as fast."""
    m = vfife.Mechanism("arm")
    m.gravity = (0.0, -9.81)
    m.point("O", 0.0, 0.0)
    m.link("upper", length=0.3, mass=2.0)
    m.link("lower", length=0.25, mass=1.0, angle=0.7)
    m.revolute("O", "ground.O", "upper.start")
    m.revolute("elbow", "upper.end", "lower.start")
    m.drive("upper", speed=4.0 * math.pi)
    m.drivers["lower"] = vfife.drivers.ConstantSpeed(
        body="lower", speed=-4.0 * math.pi * ratio, against="upper"
    )
    return m


@cache
def run(teeth: int, turns: int) -> Result:
    return vfife.simulate(geared(teeth), turns=turns, outputs=OUTPUTS)


def test_bodies_repeat_after_the_turns_of_their_ratio() -> None:
    assert cycle_of(geared(10.0)) == {"ground": 1, "motor": 1, "crank": 10}
    assert cycle_of(geared(12.5)) == {"ground": 1, "motor": 1, "crank": 25}
    assert cycle_of(geared(0.1)) == {"ground": 1, "motor": 1, "crank": 1}
    assert cycle_of(geared(math.sqrt(2.0))) == {} == cycle_of(arm(math.pi))
    assert cycle_of(arm(2.0)) == {"ground": 1, "upper": 2, "lower": 2}
    assert cycle_of(arm(1.5)) == {"ground": 1, "upper": 3, "lower": 3}
    planetary = geared(1.0)
    planetary.gears.clear()
    planetary.gear("ring", "ground", "motor", ratio=-3.0, carrier="crank")
    assert cycle_of(planetary) == {"ground": 1, "motor": 1, "crank": 4}, "Willis: w - c = 3 c"


def test_a_geared_crank_repeats_after_its_own_turn() -> None:
    """Means are over whole turns of the crank, in which inertia takes no power; its stroke is that of the
    crank, not of a turn of the motor.
    """
    result = run(10, 25)
    said = result.motion
    assert said is not None and (said.motion, said.period) == ("periodic", 10)
    assert (said.last - said.first + 1) % 10 == 0
    power = result.measures["motor.power.mean"]
    assert power.low < 0.0 < power.high
    assert abs(power.value) < 1e-6 * 100.0 * result.measures["motor.torque.max"].highest
    text = " ".join(str(result).split())
    assert "Travel block" in text and "70.00 mm, 170.00 mm" in text and "Dead centres" not in text
    assert "crank repeats after 10 of them" in text and "ends of strokes are those of the machine" in text


def test_turns_fewer_than_two_cycles_are_not_called_without_a_period() -> None:
    result = run(10, 12)
    said = result.motion
    assert said is not None and (said.motion, said.first, said.last) == ("unsettled", 3, 12)
    assert "not repeating" not in str(result)


@pytest.mark.parametrize("turns", [4, 5])
def test_turns_that_do_not_repeat_yet_are_of_whole_cycles(turns: int) -> None:
    """A turn of the motor is a third of one of the crank, with a mean power of either sign, and other forces
    than the ideal mechanism has in a whole turn of the crank.
    """
    model = geared(3.0, vfife.gallery.slider_crank_loose_pin(clearance=2e-5))
    result = vfife.simulate(model, turns=turns, outputs=OUTPUTS)
    motion, measures = result.motion, result.measures
    assert motion is not None and motion.period is None and motion.last - motion.first == 2
    force, power = measures["pin.force.max"], measures["motor.power.mean"]
    assert abs(power.value) < 0.02 * 100.0 * measures["motor.torque.max"].highest
    assert force.highest > 1.1 * force.value, "turns of the motor have other forces"
    text = " ".join(str(result).split())
    assert "ends of strokes are those of the machine" in text
    assert "largest, mean" in text and "single turns" in text
    assert "forces and torques change" not in text or "means of forces and torques change" in text


def test_a_run_shorter_than_a_cycle_is_said_to_be_so() -> None:
    text = " ".join(str(run(10, 4)).split())
    assert "not those of the whole machine" in text and "--turns 20" in text


def test_a_mechanism_of_a_single_speed_has_no_caution() -> None:
    text = str(vfife.simulate(vfife.gallery.slider_crank(), turns=2, outputs=OUTPUTS))
    assert "fastest driver" not in text and "Dead centres block" in text


def test_bodies_that_are_half_a_turn_on_after_each_turn_repeat_in_pairs() -> None:
    """Their angle, but for whole turns, is that of two turns before; their speeds differ by rounding only."""
    result = vfife.simulate(arm(2.0), turns=12, outputs=OUTPUTS, settle=0.01)
    said = result.motion
    assert said is not None and (said.motion, said.period) == ("periodic", 2)
    power = result.measures["upper.power.mean"]
    assert power.low < 0.0 < power.high


def test_angles_are_cut_where_no_body_is() -> None:
    rounding = np.array([[0.0], [1e-9], [-1e-9], [2e-9]])
    angles = 1.3 + 0.5 * TURN * np.arange(4)[:, None] + rounding
    cut = within_gap(angles)
    assert np.ptp(cut) < TURN and np.abs(np.sin(0.5 * (cut - angles))).max() < 1e-12
    assert np.abs(cut[2:] - cut[:2]).max() < 1e-8 and np.abs(cut[1:] - cut[:-1]).min() == pytest.approx(
        math.pi
    )


def test_the_mean_over_turns_that_never_repeat_has_an_error_of_sampling() -> None:
    """A ratio of pi has no cycle. Gravity and inertia take no power in the long run; that of a few turns is a
    hundred times its error by the step.
    """
    result = vfife.simulate(arm(math.pi), turns=24, outputs=OUTPUTS)
    assert result.motion is not None and result.motion.motion == "not repeating"
    power = result.measures["upper.power.mean"]
    assert power.low < 0.0 < power.high
    last = vfife.simulate(arm(math.pi), turns=9, outputs=OUTPUTS).measures["upper.power.mean"]
    assert abs(power.value) > 100.0 * (last.high - last.low) * abs(power.value / last.value)


@pytest.mark.parametrize(("turns", "cycle"), [(12.0, 12), (4.5, 9)])
def test_loads_that_repeat_over_time_have_a_cycle(turns: float, cycle: int) -> None:
    """A period of 4.5 turns makes whole turns after 9; dead centres stay those of each turn."""
    m = vfife.gallery.slider_crank()
    (speed,) = (abs(driver.steady_speed or 0.0) for driver in m.drivers.values())
    period = turns * TURN / speed
    load = {"expression": f"cos({TURN / period!r}*t)", "times": [0.0, period], "repeat": True}
    m.force("pull", "block.center", force=(500.0, 0.0), **load)
    assert cycle_of(m)["load pull"] == cycle
    result = vfife.simulate(m, turns=2 * cycle + 2, outputs=OUTPUTS * (2 * cycle + 2), companions=0)
    assert result.motion.period == cycle and result.motion.motion == "periodic"
    assert f"load pull repeats after {cycle} of them" in " ".join(str(result).split())
    assert "Dead centres" in str(result)
    m.loads.clear()
    m.force(
        "pull", "block.center", force=(500.0, 0.0), **load | {"times": [0.0, 0.9 * period], "repeat": False}
    )
    assert "load pull" not in cycle_of(m)
