"""vfife beside published studies: a small part checks what they rest on, the long one their statements."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from vfife.cli.app import app
from vfife.errors import VfifeError
from vfife.studies.methods.sensitivity_indices import salib
from vfife_validation.paper.contents import Item
from vfife_validation.published import (
    four_bar_chaos,
    free_guide,
    items,
    jansen,
    loose_chain,
    lubricated,
    phases,
    rigid,
    slap,
)


def statements(item):
    """What an item says of each statement, by its first words."""
    return {one.statement: one.holds for one in item.verdicts}


def test_the_command_lists_what_it_compares():
    answer = CliRunner().invoke(app, ["verify", "published", "--list", "--json"])
    assert json.loads(answer.stdout)["items"] == list(items.ITEMS)
    assert CliRunner().invoke(app, ["verify", "published", "loose-guides"]).exit_code != 0


def test_an_item_without_its_library_is_named_first_and_left_out(tmp_path, monkeypatch):
    """The others are computed; answer, page and JSON name the item. Alone it is refused."""

    def missing():
        raise VfifeError("SALib is not installed here")

    monkeypatch.setattr(items, "LIBRARIES", {"jansen-sobol": missing})
    monkeypatch.setattr(items, "ITEMS", {name: lambda name=name: Item(name, name) for name in items.ITEMS})
    command = ["verify", "published", "loose-guide", "jansen-sobol", "--json", "-o", str(tmp_path / "page")]
    answer = CliRunner().invoke(app, command)
    assert answer.exit_code == 0, answer.stderr
    assert answer.stderr.index("jansen-sobol is omitted: SALib") < answer.stderr.index("forecast")
    assert json.loads(answer.stdout)["left_out"] == {"jansen-sobol": "SALib is not installed here"}
    page = (tmp_path / "page" / "index.html").read_text(encoding="utf-8")
    assert 'id="loose-guide"' in page and "jansen-sobol is omitted:</strong> SALib" in page
    alone = CliRunner().invoke(app, ["verify", "published", "jansen-sobol", "-o", str(tmp_path / "none")])
    assert alone.exit_code == 2 and "omitted" in alone.stderr and not (tmp_path / "none").exists()


def test_the_item_on_sobol_indices_needs_salib():
    assert items.LIBRARIES["jansen-sobol"] is salib


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
    assert ours.time_of(1.0) == pytest.approx(other.time_of(1.0), rel=1e-3)
    assert ours.time_of(2.0) == pytest.approx(other.time_of(2.0), rel=1e-3)
    wrong = free_guide.simulate({"joint.guide.friction.coefficient": 0.02})
    assert wrong.time_of(2.0) > 1.003 * other.time_of(2.0)


@pytest.mark.verify
def test_the_loose_guide_disagrees_with_the_motion_whose_energy_grows():
    found = list(statements(free_guide.item()).values())
    assert found == [True, False, True, True, False, True]


def test_a_step_of_siconos_has_the_mass_matrix_of_its_end():
    """Within 0.1 % of the change of the crank's rate; with that of the middle 1.8 % are missing."""
    assert free_guide.flight_error(free_guide.END) < 1e-3
    assert free_guide.flight_error(0.5) == pytest.approx(0.0181, rel=0.02)


@pytest.mark.slow("compiles a step")
def test_the_loose_chain_moves_as_the_reference_file_has_it():
    """Angles within 2 mrad; without friction, which is stated, contact forces are far away."""
    theirs = loose_chain.reference()
    ours = loose_chain.simulate().at(theirs.times)
    direction, force, angle = loose_chain.deviations(ours, theirs)
    assert direction < 12.0 and force < 0.2 and angle < 2e-3
    smooth = loose_chain.simulate({"joint.B.friction.coefficient": 0.0}).at(theirs.times)
    assert loose_chain.deviations(smooth, theirs)[1] > 0.5


def test_a_transient_shakes_the_crank_of_the_reference_file():
    """At four of twenty times; where the file's torque and contact force fit its rates, so do ours."""
    theirs = loose_chain.crank()
    assert theirs.times[~theirs.smooth].tolist() == [0.05, 0.15, 0.5, 0.55]
    assert np.abs(theirs.accelerations - theirs.slopes)[theirs.smooth].max() < 6.0


@pytest.mark.verify
def test_the_loose_chain_agrees_but_for_forces_and_torque():
    found = list(statements(loose_chain.item()).values())
    assert found == [True, True, True, False, False, False, True, True]


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
    other = phases.scatters(jansen.leg("C"), [soft], [jansen.PEAK], count=jansen.SCALE_ANGLES)
    assert other.of(jansen.PEAK).mean / jansen.IDEAL == pytest.approx(2.6, rel=0.1)


@pytest.mark.verify
def test_wear_of_jansens_leg_has_two_arcs():
    """The worst 10 degrees take about a fifth, far from the 36 times of one such arc."""
    share = jansen.wear_around().mean(axis=0)
    assert 5.0 < jansen.BINS * share.max() / share.sum() < 12.0


@pytest.mark.slow("compiles a step")
def test_a_thinner_oil_has_a_thinner_film():
    """The film carries the pin without contact; a quarter of the viscosity costs 40 % of its thickness."""
    thick, thin = lubricated.film(), lubricated.film(viscosity=0.1)
    assert thin.film == pytest.approx(0.59 * thick.film, rel=0.05) and thin.film > 0.0
    assert thin.acceleration > 1.4 * thick.acceleration


@pytest.mark.verify
def test_friction_decides_whether_compliance_lowers_peaks():
    found = list(statements(lubricated.item()).values())
    assert found == [True, False, True, None, False, True, True, True, True, True]


@pytest.mark.slow("follows 30 turns of two motions")
def test_a_block_slaps_in_chaos_or_with_the_period_of_the_crank():
    """Its impacts then spread over the turn, or return to the same crank angles."""
    periodic, chaotic = slap.impacts(3000.0, 0.5, 30), slap.impacts(3000.0, 0.9, 30)
    assert periodic.kind == "period 1" and np.ptp(periodic.height) < 1e-3
    assert chaotic.kind == slap.CHAOTIC and np.ptp(chaotic.height) > 1.0
    assert chaotic.spread > 2.0 * periodic.spread


def test_impacts_of_one_bin_do_not_spread():
    one = slap.Impacts("period 1", np.zeros(1), np.zeros(1), np.full(5, 12.0), np.ones(5))
    assert one.spread == 1.0
    every = one._replace(crank=np.arange(5.0, 360.0, 10.0))
    assert every.spread == pytest.approx(36.0)


@pytest.mark.verify
def test_piston_slap_is_as_the_thesis_has_it_but_for_friction():
    found = list(statements(slap.item()).values())
    assert found == [True, True, False, True, True, True, None]


@pytest.mark.verify
def test_speed_decides_the_peak_of_jansens_leg_more_than_any_other_open_number():
    """Its Sobol' index is the largest; the crank angle at the start alone makes little."""
    data = jansen.sobol_item(16).data
    assert max(data, key=lambda name: data[name][1]) == "speed"
    assert data["crank angle at the start"][0] < 0.2


@pytest.mark.system("follows 40 turns of four motions")
def test_a_four_bar_without_friction_is_chaotic_at_some_clearances(monkeypatch):
    """Periodic at 0.1 mm, chaotic at 0.8 mm; friction of 0.1 makes the latter periodic."""
    monkeypatch.setattr(four_bar_chaos, "LARGEST_CLEARANCE", 0.8e-3)
    monkeypatch.setattr(four_bar_chaos, "TURNS", 40)
    smooth, rough = (four_bar_chaos.diagram(friction, 300.0, 2) for friction in (0.0, 0.1))
    assert smooth.kinds[0] == ("period 1", "chaotic") and four_bar_chaos.regular(smooth) == 1e-4
    assert rough.kinds[0] == ("period 1", "period 1")


@pytest.mark.verify
def test_clearances_of_a_four_bar_with_order_and_chaos():
    found = list(statements(four_bar_chaos.item()).values())
    assert found == [True, None, True, True]
