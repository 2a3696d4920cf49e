"""Series and measures go by one name: what a measure is of is a series, and its largest value
is the measure.
"""

from __future__ import annotations

import numpy as np
import pytest

import vfife
from support import TURN, four_bar
from vfife.simulation.result import Result


@pytest.fixture(scope="module")
def result() -> Result:
    return vfife.simulate(four_bar("C"), step="2 us", turns=1, companions=0)


def test_a_measure_is_of_a_series(result: Result) -> None:
    """Of every largest value there is a series, which it bounds; that of its intervals, where kept, it is the
    largest value of.
    """
    named = [name.removesuffix(".max") for name in result.measures if name.endswith(".max")]
    of_a_turn = [name for name in named if not name.endswith(("landing_depth", "approach_speed"))]
    assert {"C.force", "C.penetration", "follower.angular_acceleration", "crank.torque"} <= set(of_a_turn)
    for name in of_a_turn:
        most = result.measures[f"{name}.max"]
        assert float(np.abs(result.series[name][1:]).max()) <= most * (1.0 + 1e-12), name
        if f"{name}_max" in result.series:
            assert float(result.series[f"{name}_max"][1:].max()) == pytest.approx(most, rel=1e-14), name
    assert float(result.series["C.impacts"][-1]) == result.measures["C.impacts"]


def test_a_series_is_a_channel_of_the_data(result: Result) -> None:
    force = result.series["C.force"]
    assert force.identical(result.data["joint_force"].sel(joint="C")) and force.identical(result["C.force"])
    assert force.units == "N" and force.time[-1] == pytest.approx(TURN)
    assert result.series["kinetic_energy"].identical(result.data["kinetic_energy"])
    assert len(result.series) == len(list(result.series)) > 50


def test_a_series_that_there_is_not_is_told(result: Result) -> None:
    with pytest.raises(KeyError, match="C.force"):
        result.series["C.forces"]


def test_names_follow_one_pattern(result: Result) -> None:
    for name in result.measures:
        who, what = name.split(".", 1)
        assert (
            who in {*"ABCD", "crank", "coupler", "follower", "ground", "mechanism"} and what.count(".") <= 1
        ), name


def test_what_never_was_a_measure_is_none(result: Result) -> None:
    assert (
        result.measures.get("lip.E.force") is None
        and "lip.E.force" not in result.measures
        and "deep" not in result.measures
    )
    with pytest.raises(KeyError, match="E.force.max"):
        result.measures["E.force.max"]
    assert dict(result.measures.of("crank")).keys() == {
        "angular_acceleration.max", "torque.max", "torque.mean", "torque.ripple", "torque.rms",
        "energy_fluctuation", "power.mean"
    }  # fmt: skip
