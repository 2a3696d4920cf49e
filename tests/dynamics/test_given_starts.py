"""Start velocities on the axes of basins and in sections: runs start with them, or answer and figure say with
what.
"""

import math

import numpy as np
import pytest

from kinematics.test_given_velocities import on_yoke
from vfife.dynamics import load_map
from vfife.dynamics.basins import basins
from vfife.dynamics.sections import poincare_section
from vfife.dynamics.start_states import StartStates

SHORT = {"turns": 3, "dropped": 1, "step": "2 ms", "companions": 0, "exponents": False}


def title(figure):
    return " ".join(figure.get_suptitle().split())


@pytest.mark.parametrize("rate", [-6.0, 0.0, 6.0])
def test_a_start_has_the_rate_on_the_axis(rate):
    """Zero is a rate like any other there."""
    states = StartStates(on_yoke(), 1000)
    assembly = states.at({"body.rod.angle": -math.pi / 3.0, "body.rod.velocity.2": rate})
    [particle] = assembly.bodies["rod"].particles
    start = [assembly.state[assembly.layout[f"particle_{key}"]][particle] for key in "uvw"]
    hinge, x, y = 0.3, 0.125 * 0.5, -0.125 * math.sqrt(0.75)
    assert start == pytest.approx([hinge - rate * y, rate * x, rate], abs=1e-9)


def test_basins_over_a_rate_need_no_caution():
    axes = ("body.rod.angle", "-120 deg", "-60 deg"), ("body.rod.velocity.2", -6.0, 6.0)
    found = basins(on_yoke(), *axes, count=(2, 3), **SHORT)
    assert found.misfit is None and "instead of" not in str(found) + title(found.plot())


def test_basins_over_a_velocity_that_joints_hold_say_so(tmp_path):
    axes = ("body.rod.angle", "-120 deg", "-60 deg"), ("body.rod.velocity.0", -1.0, 0.5)
    found = basins(on_yoke(), *axes, count=(2, 2), file=tmp_path / "a.map", **SHORT)
    text = "the origin of rod starts with (0.3, 0) m/s instead of (-1, 0) m/s"
    for result in (found, load_map(tmp_path / "a.map")):
        assert text in " ".join(str(result).split()).replace("The origin", "the origin")
        assert text in title(result.plot())


def test_a_misfit_below_a_hundredth_of_the_axis_is_not_said():
    axes = ("body.rod.angle", "-120 deg", "-60 deg"), ("body.rod.velocity.0", 0.2, 0.4)
    assert basins(on_yoke(), *axes, count=2, **SHORT).misfit is not None
    narrow = ("body.rod.angle", "-120 deg", "-60 deg"), ("body.rod.velocity.0", 0.2999, 0.3001)
    assert basins(on_yoke(), *narrow, count=2, **SHORT).misfit is None


def test_a_misfit_is_that_of_the_turned_crank():
    """At a quarter turn the yoke rests."""
    states = StartStates(on_yoke(), 1000)
    [misfit] = states.misfits({"start.crank": math.pi / 2.0, "body.rod.velocity.0": 0.3})
    assert np.abs(misfit.actual).max() < 1e-9 and misfit.target == (0.3, 0.0)
    assert states.misfits({"start.crank": 0.0, "body.rod.velocity.0": 0.3}) == ()


def test_a_section_says_it():
    given = {"turns": 4, "dropped": 1, "step": "2 ms"}
    found = poincare_section(on_yoke(velocity=(0.5, 0.0, -6.0)), **given)
    text = "origin of rod starts with (0.3, 0) m/s instead of (0.5, 0) m/s"
    assert text in " ".join(str(found).split()) and text in title(found.plot())
    right = poincare_section(on_yoke(velocity=(0.0, 0.0, -6.0)), **given)
    assert "instead of" not in str(right) + title(right.plot())
