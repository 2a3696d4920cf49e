"""Shares of time and friction energy change by whole impacts, and so do their ranges."""

from __future__ import annotations

import pytest

import vfife
from hanging_chain import CHAIN, variant
from vfife import gallery
from vfife.laws import Coulomb
from vfife.laws.law import LAWS
from vfife.laws.stored import RecordedFriction
from vfife.measures.event_ranges import friction_losses
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


def test_a_loss_by_friction_is_not_negative_but_for_bristles() -> None:
    """Coulomb friction takes energy at every moment; a bent bristle returns what it stored."""
    result = vfife.simulate(gallery.slider_crank_free(), reference=False)
    power, energy = (result.measures[f"guide.friction_{kind}"] for kind in ("power.mean", "energy.total"))
    assert power.low == energy.low == 0.0
    assert 0.0 < power < power.high and power.width > power  # without the law it begins below zero
    assert friction_losses(result.record) == {"guide.friction_power.mean", "guide.friction_energy.total"}


@pytest.mark.parametrize(
    ("law", "dissipative"),
    [("coulomb", True), ("brown-mcphee", True), ("lugre", False), ("dahl", False), ("gonthier", False)],
)
def test_laws_with_bristles_store_energy(law: str, dissipative: bool) -> None:
    assert LAWS["friction"].registry[law]().dissipative is dissipative


def test_of_a_law_of_ones_own_nothing_is_known() -> None:
    """Neither as it is loaded nor as a run file has it."""

    class Mine(Coulomb, register=False):
        """A copy."""

    assert Coulomb().dissipative
    assert not Mine().dissipative and not RecordedFriction().dissipative
