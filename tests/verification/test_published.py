"""vfife beside published studies: a small part checks what they rest on, the long one their statements."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from vfife.cli.app import app
from vfife_validation.published import free_guide, items, rigid


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
