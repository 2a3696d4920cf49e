"""A crank that follows a table of angles has no turns: measures are of the whole run, dwells included."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import vfife
from vfife.assembly.assemble import assemble
from vfife.errors import ModelError

TIMES = (0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.4)  # s
ANGLES = (0.0, 5.0, 25.0, 55.0, 80.0, 89.0, 90.0, 90.0, 90.0)  # deg
RADIUS, MASS = 0.06, 0.9  # m, kg


def yoke(angles: tuple[float, ...] = ANGLES, times: tuple[float, ...] = TIMES, **settings) -> vfife.Mechanism:
    """A crank of little mass with a heavy point at its end."""
    m = vfife.Mechanism("indexing crank", settings=vfife.Settings(outputs=4000, **settings))
    m.point("O", 0, 0)
    m.rigid_body("crank", mass=MASS, inertia=1e-6, position=(RADIUS, 0), pins={"O": (-RADIUS, 0)})
    m.revolute("O", "ground.O", "crank.O")
    m.motion("crank", times=times, values=tuple(math.radians(angle) for angle in angles))
    return m


def test_the_largest_force_before_a_dwell_is_that_of_the_whole_run() -> None:
    """The force of a point that goes round the table's angle: m r sqrt(w^4 + a^2), of a natural spline."""
    spline = CubicSpline(TIMES, np.radians(ANGLES), bc_type="natural")
    time = np.linspace(0.0, TIMES[-1], 40_001)
    force = MASS * RADIUS * np.hypot(spline(time, 1) ** 2, spline(time, 2))
    result = vfife.simulate(yoke())
    assert result.record.assembly.choice.turn is None
    assert result.record.steps[-1] * result.record.assembly.choice.step == pytest.approx(TIMES[-1])
    assert result.measures["O.force.max"].value == pytest.approx(force.max(), rel=2e-3)


def test_a_table_has_no_turns_to_count() -> None:
    with pytest.raises(ModelError, match="turns = 2: no crank turns at constant speed"):
        vfife.simulate(yoke(), turns=2)


def test_a_run_past_its_table_has_a_caution() -> None:
    assert not any("The table of driver crank" in note for note in assemble(yoke()).notes)
    notes = assemble(yoke(), duration=0.5).notes
    assert any("The table of driver crank ends at 0.4 s, and the run at 0.5 s" in note for note in notes)


@pytest.mark.parametrize(("angles", "has_mean"), [((0.0, 40.0, 80.0), True), ((0.0, 40.0, 0.02), False)])
def test_a_crank_that_turns_back_has_no_mean_torque(angles: tuple[float, ...], has_mean: bool) -> None:
    """Work over what is left of the angle would be many times the largest torque."""
    measures = vfife.simulate(yoke(angles, (0.0, 0.1, 0.2))).measures
    assert ("crank.torque.mean" in measures) is has_mean and "crank.power.mean" in measures
