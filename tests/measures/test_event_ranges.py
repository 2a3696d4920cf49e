"""Shares of time and friction energy change by whole impacts, and so do their ranges."""

from __future__ import annotations

import pytest

import vfife
from hanging_chain import CHAIN, variant
from vfife import gallery
from vfife.modelfile import loads

# Shares of free flight at a sixteenth of the step; at a thirty-second that of O is 0.03992 as well.
TRUTH = {"O": 0.0399161, "P": 0.0421189, "Q": 0.0504507}


def test_the_share_of_a_joint_that_bounces_to_rest_has_a_range_of_half_a_mean_flight() -> None:
    """Other steps have 11 or 12 impacts in O: a flight more is 9 % of the share. The truth is 2.6 % away."""
    measures = vfife.simulate(loads(CHAIN), reference=False).measures
    for name, truth in TRUTH.items():
        share = measures[f"{name}.share.free_flight"]
        assert share.low <= truth <= share.high, name
    share, impacts = measures["O.share.free_flight"], measures["O.impacts"]
    flight = share / impacts
    assert flight < share.width < 1.5 * flight
    other = measures["O.share.continuous_contact"]
    assert other.width >= 0.99 * flight and other.high <= 1.0


def test_all_step_sizes_may_miss_the_same_last_bounce() -> None:
    """Eleven impacts at four steps, twelve at a sixteenth of the step, where the share is 0.5 % larger."""
    measures = vfife.simulate(variant(15), reference=False).measures
    share = measures["O.share.free_flight"]
    assert share.low <= 0.06521 <= share.high
    assert share.width < 0.02 * share


def test_an_impact_that_does_not_decay_moves_the_share_by_its_steps() -> None:
    """A journal falls through its clearance: free flight is 1 - 0.15277 in closed form, and one impact."""
    result = vfife.simulate(vfife.load_model("examples/journal_in_bearing.toml"), reference=False)
    share = result.measures["O.share.free_flight"]
    assert share.low <= 1.0 - 0.15277 <= share.high
    assert share.width == pytest.approx(0.0, abs=1e-3)


def test_the_share_of_first_steps_vanishes_with_the_step() -> None:
    """It is the number of impacts times the step: its range contains zero, and the value at half the step."""
    result = vfife.simulate(gallery.four_bar_case_c(), turns=2, step=6e-6, reference=False)
    half = vfife.simulate(gallery.four_bar_case_c(), turns=2, step=5e-7, companions=0, reference=False)
    for joint in "BCD":
        share = result.measures[f"{joint}.share.impact"]
        assert share.low == 0.0 < share <= share.high
        assert half.measures[f"{joint}.share.impact"] <= share.high
