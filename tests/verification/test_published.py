"""vfife beside published studies: a small part checks what they rest on, the long one their statements."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from vfife.cli.app import app
from vfife_validation.published import free_guide, items, jansen, phases, rigid


def statements(item):
    """What an item says of each statement, by its first words."""
    return {one.statement: one.holds for one in item.verdicts}


def test_the_command_lists_what_it_compares():
    answer = CliRunner().invoke(app, ["verify", "published", "--list", "--json"])
    assert json.loads(answer.stdout)["items"] == list(items.ITEMS)
    assert CliRunner().invoke(app, ["verify", "published", "loose-guides"]).exit_code != 0


def test_rigid_contacts_only_take_energy():
    """Between contacts the energy stays, in the middle of a first flight; contacts lower it."""
    times, angles, rates = rigid.motion(0.02, 1e-4)
    energy = rigid.energy(angles, rates)
    flight = times < 0.0025
    assert np.ptp(energy[flight]) < 2e-4 * energy[0]
    assert np.diff(energy).max() < 2e-5 * energy[0] and energy[-1] < 0.999 * energy[0]
    assert np.abs(angles[:, 0]).max() > 0.25 * 2.0 * math.pi


@pytest.mark.slow("compiles a step")
def test_the_loose_guide_moves_as_rigid_contacts_have_it():
    """Within 0.1 %; twice the friction, which is small, moves it further away."""
    ours, other = free_guide.simulate(), free_guide.rigid_motion()
    assert ours.after(1.0) == pytest.approx(other.after(1.0), rel=1e-3)
    assert ours.after(2.0) == pytest.approx(other.after(2.0), rel=1e-3)
    wrong = free_guide.simulate({"joint.guide.friction.coefficient": 0.02})
    assert wrong.after(2.0) > 1.003 * other.after(2.0)


@pytest.mark.verify
def test_the_loose_guide_disagrees_with_the_motion_whose_energy_grows():
    found = list(statements(free_guide.item()).values())
    assert found == [True, False, False, True]


def test_the_ideal_leg_carries_what_the_abstract_states():
    assert jansen.ideal_peak(jansen.BASE) == pytest.approx(jansen.IDEAL, rel=1e-3)


def test_confidence_of_a_mean_and_pairs_that_are_reversed():
    """Half width 2.365 s/sqrt(8); of 4 pairs, one is ordered otherwise than the means are."""
    values = np.arange(8.0)
    assert phases.Scatter(values).error == pytest.approx(2.365 * math.sqrt(6.0 / 8.0), rel=1e-3)
    assert jansen.reversals(np.array([1.0, 4.0]), np.array([3.0, 5.0])) == 0.25
    assert jansen.half_arc(np.array([8.0, *np.ones(35)])) == 15 * 10.0


@pytest.mark.verify
def test_one_loose_pin_of_jansens_leg_multiplies_the_peak():
    """Five times with our numbers, and little else with a larger step; a tenth of the stiffness halves it."""
    found = phases.scatters(jansen.leg("C"), [jansen.BASE], [jansen.PEAK])
    assert found.of(jansen.PEAK).mean / jansen.IDEAL == pytest.approx(5.5, rel=0.1)
    assert abs(found.step_change(jansen.PEAK)) < 0.05
    soft = {**jansen.BASE, "material.bush.youngs_modulus": 3e8}
    other = phases.scatters(jansen.leg("C"), [soft], [jansen.PEAK], count=jansen.FEW)
    assert other.of(jansen.PEAK).mean / jansen.IDEAL == pytest.approx(2.6, rel=0.1)


@pytest.mark.verify
def test_wear_of_jansens_leg_has_two_arcs():
    """The worst 10 degrees take about a fifth, far from the 36 times of one such arc."""
    share = jansen.wear_around().mean(axis=0)
    assert 5.0 < jansen.BINS * share.max() / share.sum() < 12.0
