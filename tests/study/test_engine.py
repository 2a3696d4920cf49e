"""Members of a study are what their own runs are, to the bit; one that fails says why and stops no other."""

from __future__ import annotations

from pathlib import Path

import pytest

from vfife import load_model, simulate
from vfife.study.engine import Wanted, run_members

BASE = Path(__file__).parents[2] / "examples" / "four_bar_case_b.toml"


def test_outcomes_are_those_of_the_members_own_runs() -> None:
    base = load_model(BASE)
    numbers = [{"joint.C.clearance": 1e-4}, {"joint.C.clearance": "0.3 mm", "driver.crank.speed": "1000 rpm"}]
    found = dict(run_members(base, numbers, Wanted(("C.force.max", "C.impacts", "follower.angular_acceleration.lip"), 1, step=5e-6)))
    for k, set_ in enumerate(numbers):
        own = simulate(load_model(BASE, set=list(set_.items())), turns=1, step=5e-6, companions=0)
        assert found[k].values == {name: float(own.measures[name]) for name in found[k].values}
        assert len(found[k].values) == 3
        assert found[k].status == "complete"


@pytest.mark.parametrize("bad", [{"joint.C.clearance": -1.0}, {"joint.nowhere.clearance": 1e-4}])
def test_member_that_fails_says_why_and_stops_no_other(bad: dict[str, float]) -> None:
    found = dict(run_members(load_model(BASE), [bad, {}], Wanted(("C.force.max",), 1, step=1e-5)))
    assert found[0].status == "failed"
    assert found[0].reason is not None
    assert "joint" in found[0].reason
    assert found[0].values == {}
    assert found[1].status == "complete"
