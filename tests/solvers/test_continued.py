"""A run that goes on where another ended is one run: to the order of the step for its first step, which
starts from v_0 itself.
"""

import numpy as np
import pytest

import vfife
from support import SQUARE, four_bar
from vfife.model.bodies import Section
from vfife.model.mechanism import Mechanism

SPEED = 20.0


def slider_crank(elastic: bool, clearance: bool) -> Mechanism:
    m = Mechanism("slider-crank", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    options = {"model": "elastic", "elements": 2, "section": Section.square(1e-4)} if elastic else {}
    m.link("crank", length=0.05, mass=0.3)
    m.link("rod", length=0.15, mass=0.3, **options)
    m.rigid_body("block", mass=0.2, inertia=1e-4, position=(0.2, 0.0))
    m.revolute("A", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "rod.start")
    if clearance:
        m.clearance_joint("C", "rod.end", "block.center", clearance=2e-4, bearing_radius=5e-3)
    else:
        m.revolute("C", "rod.end", "block.center")
    m.slider("D", "ground.O", "block.center")
    m.drive("crank", speed=SPEED)
    return m


@pytest.mark.parametrize("elastic", [False, True], ids=["rigid", "elastic"])
@pytest.mark.parametrize("clearance", [False, True], ids=["ideal", "clearance"])
def test_two_parts_are_one(elastic, clearance):
    """Second half of a turn after the first: same motion as one run of the whole turn, the crank's angle
    going on.
    """
    m = slider_crank(elastic, clearance)
    turn = 2 * np.pi / SPEED
    step = turn / (200_000 if elastic and clearance else 100_000)  # within 0.9 of the largest stable one
    whole = vfife.simulate(m, duration=0.1 * turn, step=step, outputs=100, reference=False)
    first = vfife.simulate(m, duration=0.05 * turn, step=step, outputs=100, reference=False)
    second = vfife.simulate(m, duration=0.05 * turn, step=step, outputs=100, reference=False, start=first)
    end, there = (result.record.block("particle_x")[-1] for result in (whole, second))
    travel = np.abs(whole.record.block("particle_x")[-1] - whole.record.block("particle_x")[0]).max()
    assert np.abs(end - there).max() < 2e-6 * travel
    assert second.record.block("particle_theta")[0, 1] == pytest.approx(
        first.record.block("particle_theta")[-1, 1], abs=1e-15
    )
    if elastic:
        axial = "frame_axial_force"
        assert second.record.block(axial)[0] == pytest.approx(first.record.block(axial)[-1], rel=1e-12)


def test_from_a_folder_and_from_names(tmp_path):
    """A run file goes on like the run itself; states by name start a mechanism that is cut otherwise."""
    m = slider_crank(False, True)
    first = vfife.simulate(m, duration=0.01, step=2e-6, outputs=10, reference=False)
    first.save(tmp_path / "run.vfife")
    options = {"duration": 0.002, "step": 2e-6, "outputs": 10, "reference": False}
    one, other = (vfife.simulate(m, start=start, **options) for start in (first, tmp_path / "run.vfife"))
    assert np.abs(one.record.rows - other.record.rows)[:, :6].max() < 1e-6
    bar = four_bar("", "elastic", elements=2, section=SQUARE)
    crank = next(iter(bar.bodies))
    begun = vfife.simulate(bar, start={crank: (0.0, 0.0, 0.5)}, duration=1e-4, outputs=5, reference=False)
    assert begun.record.block("particle_theta")[0, begun.record.assembly.topology.driven[0]] == pytest.approx(
        0.5
    )
