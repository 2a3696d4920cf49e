"""A smooth run again with half its step: the error that is told, against the error there is."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import vfife
from support import with_settings
from vfife import gallery
from vfife.analysis.trust import trust
from vfife.model.mechanism import Mechanism
from vfife.result import Result


def pendulum() -> Mechanism:
    """A heavy rod, let go 2 rad from its rest."""
    m = Mechanism("rod", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=0.6, mass=1.5, angle=2.0 - 0.5 * math.pi)
    m.revolute("O", "ground.O", "rod.start")
    return with_settings(m, duration=2.0)


@pytest.mark.parametrize("make", [pendulum, gallery.double_pendulum, gallery.jansen_leg])
def test_the_order_is_two(make) -> None:
    estimate = vfife.simulate(with_settings(make(), step=4e-4)).record.estimate
    assert estimate is not None and estimate.order == pytest.approx(2.0, abs=0.05)


def test_the_error_of_a_pendulum() -> None:
    """The largest force at the pin is m g (1 + 3/2 (1 - cos a)) at the lowest point: energy and the centripetal acceleration of a rod."""
    result = vfife.simulate(pendulum(), step=4e-3)
    one = result.measures["O.force.max"]
    truth = 1.5 * 9.81 * (1.0 + 1.5 * (1.0 - math.cos(2.0)))
    assert abs(one - truth) > 1e-6 * truth
    assert one.low <= truth <= one.high


@pytest.mark.parametrize("make", [gallery.four_bar_ideal, gallery.six_bar_press, gallery.quick_return, gallery.jansen_leg])
def test_the_truth_lies_in_the_range(make) -> None:
    result = vfife.simulate(make(), reference=False)
    truth = vfife.simulate(make(), step=result.record.assembly.choice.step / 8.0, companions=0).measures
    turn, driven = result.record.assembly.choice.turn, result.crank
    assert turn is not None
    largest = result.measures["A.force.max" if "A.force.max" in result.measures else "O.force.max"]
    torque = result.measures[f"{driven}.torque.max"]  # whose mean over a turn without losses is zero, but for the step
    idle = {".power.mean": 1e-7 * 2.0 * math.pi / turn * torque, ".torque.mean": 1e-7 * torque}
    for name, one in result.measures.items():
        slack = 5e-5 * abs(one) + next((least for ending, least in idle.items() if name.endswith(ending)), 1e-9 * largest)
        assert one.low - slack <= truth[name] <= one.high + slack, name


def test_a_body_that_does_not_turn_is_no_doubt() -> None:
    """The yoke's angular acceleration is nothing but rounding."""
    said = trust(vfife.simulate(gallery.scotch_yoke()).record)
    assert said is not None and not said.sensitive and said.companions == 0


def test_a_coarse_step_is_told() -> None:
    result = vfife.simulate(pendulum(), step=0.05, outputs=20)
    assert result.summary["trust"]["sensitive"]
    assert re.match(r"The step is coarse: \S+\.max errs by some [1-9]", result.summary["warnings"][0])


def test_companions_turn_it_off_and_on() -> None:
    assert vfife.simulate(pendulum(), companions=0).record.estimate is None
    long = with_settings(pendulum(), duration=20000.0, step=1e-4, outputs=2)
    assert not _made(long)


def _made(mechanism: Mechanism) -> bool:
    from vfife.simulation import prepare
    from vfife.solvers.arguments import Asked

    return prepare(mechanism, Asked()).refined


def test_it_is_kept(tmp_path) -> None:
    result = vfife.simulate(pendulum())
    result.save(tmp_path / "run.sqlite")
    again = Result.load(tmp_path / "run.sqlite")
    assert again.record.estimate == result.record.estimate
    for name, one in result.measures.items():
        assert (again.measures[name].low, again.measures[name].high) == (one.low, one.high)


def test_two_lanes_and_two_runs_are_the_same(monkeypatch) -> None:
    from vfife.solvers import refinement

    alone = vfife.simulate(pendulum()).record.estimate
    monkeypatch.setattr(refinement, "WORTH_LANES", 0.0)
    assert vfife.simulate(pendulum()).record.estimate == alone
    assert alone is not None and np.isfinite(list(alone.errors.values())).all()
