"""The numbers a run is judged by: windows, maxima, counts and influence parameters."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

import vfife
from support import (
    TURN,
    four_bar,
    go,
    journal_in_bearing,
    largest_alpha,
    largest_force,
    onsets,
    with_settings,
    within,
)
from vfife.measures import influence, last_turn, lip
from vfife.measures.catalogue import measures
from vfife.measures.forces import shares
from vfife.report.digits import plain_number

STEP = 2e-6


@pytest.fixture(scope="module")
def record():
    return go(four_bar(), STEP, turns=2.25)


def test_window_is_the_turn_before_the_end(record) -> None:
    assert np.array_equal(last_turn(record), within(record, 1.25 * TURN, 2.25 * TURN))
    assert last_turn(record).sum() * record.assembly.choice.outputs_every * STEP == pytest.approx(TURN)


def test_window_of_a_run_of_one_turn_leaves_the_start_out() -> None:
    exact = go(four_bar(), STEP, turns=1.0)
    assert last_turn(exact).sum() == len(exact.steps) - 1
    assert last_turn(go(four_bar(), STEP, turns=0.5)).all()


def test_window_without_a_crank_is_the_whole_run() -> None:
    assert last_turn(go(journal_in_bearing(), 1e-6, duration=1e-3)).all()


def test_maxima_are_those_of_the_extremes(record) -> None:
    found, window = measures(record), last_turn(record)
    for joint in "ABCD":
        assert found[f"{joint}.force.max"] == pytest.approx(largest_force(record, joint, window), rel=1e-14)
    assert found["follower.angular_acceleration.max"] == largest_alpha(record, "follower", window)
    samples = np.hypot(record.block("contact_normal_force"), record.block("contact_friction_force"))[
        window, 1
    ]
    assert found["C.force.max"] >= samples.max()
    assert found["crank.torque.max"] == record.block("driven_torque_max")[window].max()
    assert found["C.penetration.max"] == record.block("contact_penetration_max")[window, 1].max()
    assert found["crank.angular_acceleration.max"] == 0.0


def test_counts_and_shares_are_those_of_the_whole_run(record) -> None:
    found = measures(record)
    assert [found[f"{joint}.impacts"] for joint in "BCD"] == onsets(record)
    for joint in "BCD":
        parts = [found[f"{joint}.share.{mode}"] for mode in ("free_flight", "impact", "continuous_contact")]
        assert sum(parts) == pytest.approx(1.0)
        assert min(parts) >= 0.0
    steps = record.steps[-1] + 1
    assert found["C.share.impact"] == found["C.impacts"] / steps


def test_shares_count_every_step() -> None:
    """With an output at every step, the samples tell the same."""
    every = go(with_settings(journal_in_bearing(), parts=1), 1e-6, duration=1e-3, outputs=1000)
    touching = int((every.block("contact_penetration")[:, 0] > 0.0).sum())
    found = measures(every)
    count = len(every.steps)
    assert found["J.share.continuous_contact"] * count == pytest.approx(touching - found["J.impacts"])
    assert found["J.share.free_flight"] * count == pytest.approx(count - touching)


def test_influence_is_that_of_the_paper() -> None:
    assert lip(117.21, 100.0) == pytest.approx(17.21)
    own = {
        "C.force.max": 3.0,
        "f.angular_acceleration.max": 1.5,
        "crank.angular_acceleration.max": 0.0,
        "C.impacts": 4.0,
    }
    ideal = {"C.force.max": 2.0, "f.angular_acceleration.max": 2.0, "crank.angular_acceleration.max": 0.0}
    found = influence(own, ideal, ["crank"])
    assert found == {"C.force.lip": 50.0, "f.angular_acceleration.lip": -25.0}


def test_nothing_is_compared_with_nothing() -> None:
    ideal = {"A.force.max": 1e-13, "B.force.max": 1.0}
    assert influence({"A.force.max": 2.0, "B.force.max": 2.0}, ideal) == {"B.force.lip": 100.0}


def test_measures_of_numbers_that_blew_up_are_left_out(record) -> None:
    rows = record.rows.copy()
    rows[-1] = math.nan
    assert all(map(math.isfinite, measures(dataclasses.replace(record, source=rows)).values()))


def test_a_share_of_the_time_is_not_below_zero_by_rounding() -> None:
    blocks = {
        "contact_onsets": np.zeros((1, 1)),
        "contact_duration": np.array([[1000 * 1e-6 * (1.0 + 1e-12)]]),
    }
    held = SimpleNamespace(
        steps=np.array([999]),
        last=lambda name: blocks[name][-1],
        assembly=SimpleNamespace(choice=SimpleNamespace(step=1e-6)),
    )
    assert shares(held)["free_flight"] == 0.0


def test_contacts_that_began_are_told_whole() -> None:
    told = {
        "measures": {"C.impacts": 45.0, "C.force.max": 45.0},
        "ranges": {name: {"low": 40.0, "high": 52.0} for name in ("C.impacts", "C.force.max")},
    }
    assert (plain_number(told, "C.impacts"), plain_number(told, "C.force.max")) == ("45", "45")


def test_the_force_of_a_driven_slider_is_that_of_its_guide() -> None:
    """The driver of a slider has its name: 9.87 N along the guide, while the weight of 9.81 N rests on it."""
    m = vfife.Mechanism("shaker", gravity=(0, -9.81))
    m.point("O", 0, 0)
    m.rigid_body("block", mass=1, inertia=1e-3, position=(0.1, 0))
    m.slider("rail", "ground.O", "block.center")
    m.harmonic(slider="rail", amplitude=0.01, frequency=5)
    result = vfife.simulate(m, duration=0.4)
    assert result.measures["rail.force.max"] == pytest.approx(9.81, rel=1e-9)
    assert result.measures["rail.actuator_force.max"] == pytest.approx(0.01 * (10.0 * np.pi) ** 2, rel=1e-5)
