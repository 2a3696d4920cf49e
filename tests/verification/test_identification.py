"""The paper's four-bar gives three of its numbers back from noisy curves, in wide bounds."""

import numpy as np
import pytest

import vfife
from rigs import EXAMPLES, synthetic
from vfife.identification.batched_queries import Evaluations, Query
from vfife.identification.fit_task import plan_fit

pytestmark = pytest.mark.verify

TRUTH = {"joint.B.clearance": 3.1e-4, "joint.C.clearance": 1.5e-4, "driver.crank.speed": 150.0}
BOUNDS = {
    "joint.B.clearance": ("0.05 mm", "0.6 mm"),
    "joint.C.clearance": ("0.05 mm", "0.6 mm"),
    "driver.crank.speed": (130.0, 180.0),
}


@pytest.mark.parametrize(
    "seed", [1]
)  # of this one the first four searches end in a wrong place, 23 % and 45 % off
def test_three_numbers_of_the_papers_four_bar_come_back_within_3_per_cent(tmp_path, seed):
    """From a force, a torque and an acceleration over two turns with 2 % noise, measured at half the step,
    from somewhere in a turn on.
    """
    base = vfife.load(EXAMPLES / "four_bar.toml")
    path = synthetic(tmp_path / "rig.csv", base, TRUTH, 5e-7, turns=(3.37, 5.4), every=3, seed=seed)
    found = vfife.fit(base, path, BOUNDS, seed=seed)
    for name, value in TRUTH.items():
        assert found[name].value == pytest.approx(value, rel=0.03), name
        assert found[name].determined and not found[name].at_bound
    assert found.share == pytest.approx(0.02, rel=0.2) and found.undetermined == []


def test_derivatives_of_steps_are_those_of_runs(tmp_path):
    """Of the residuals at the true numbers: carried along the run, and as differences of runs; each column in
    direction and length.
    """
    base = vfife.load(EXAMPLES / "four_bar.toml")
    path = synthetic(tmp_path / "rig.csv", base, TRUTH, 5e-7, turns=(3.37, 4.4), every=3)
    near = {
        "joint.B.clearance": ("0.3 mm", "0.32 mm"),
        "joint.C.clearance": ("0.14 mm", "0.16 mm"),
        "driver.crank.speed": (149.0, 151.0),
    }
    task = plan_fit(
        base, path, near, columns=None, weights=None, offset=None, skip=3.0, compare="curve", width=None,
        step="1.4 us", screened=4, starts=1, confidence=0.95, derivatives="auto", seed=0,
    )  # fmt: skip
    looked = Evaluations(task.evaluated, task.parameters)
    shares = tuple(one.share(value) for one, value in zip(task.parameters, TRUTH.values(), strict=True))
    (seen,) = looked([Query(shares)])
    carried, differences = (looked.slopes(Query(shares, None, way), seen).jacobian for way in (True, False))
    lengths = [np.linalg.norm(one, axis=0) for one in (carried, differences)]
    assert lengths[0] == pytest.approx(lengths[1], rel=0.02)
    assert ((carried * differences).sum(axis=0) / lengths[0] / lengths[1] > 0.999).all()


def test_a_motion_that_does_not_repeat_is_called_not_known(tmp_path):
    """A loose pin that bounces for ever: 120 um of clearance are not found, and no confidence is claimed;
    what fits as well takes them in.
    """
    m = vfife.gallery.slider_crank_loose_pin(friction=0.0, clearance=2e-4, restitution=0.9)
    path = synthetic(
        tmp_path / "rig.csv",
        m,
        {"joint.pin.clearance": 1.2e-4},
        1.3e-6,
        turns=(4.37, 7.3),
        every=4,
        channels=("pin.force",),
    )
    found = vfife.fit(
        m, path, {"joint.pin.clearance": ("50 um", "250 um")}, step="2 us", screened=32, starts=2
    )
    one = found["joint.pin.clearance"]
    low, high = one.ends
    assert not one.known and not one.determined and low < 1.2e-4 < high and high - low > 5e-5
    assert any("so confidence is not known" in note for note in found.notes)
