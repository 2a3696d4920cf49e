"""Contacts at stops: no impacts, but counted where the outputs show them, as in a motion in closed form."""

import json
import math

import pytest
from typer.testing import CliRunner

import vfife
from vfife.cli.app import app

INERTIA, SPEED, STIFFNESS, LIMIT = 0.02, 10.0, 2e3, 0.5  # kg m^2, rad/s, N m/rad, rad


@pytest.fixture(scope="module")
def bouncing():
    """A rotor that turns freely between two stops without damping."""
    m = vfife.Mechanism("bouncing rotor", gravity=(0.0, 0.0))
    rotor = m.rigid_body("rotor", mass=1.0, inertia=INERTIA, velocity=(0.0, 0.0, SPEED))
    m.revolute("hinge", m.point("O", 0.0, 0.0), rotor.pin())
    m.stop("wall", "ground", "rotor", low=-LIMIT, high=LIMIT, stiffness=STIFFNESS)
    return vfife.simulate(m, duration=1.95, step=2e-5, outputs=2000, companions=0)


def test_contacts_at_a_stop_are_counted_at_the_outputs(bouncing) -> None:
    """From one limit to the other the rotor takes 2 LIMIT/SPEED; a contact is half a period of the stop."""
    contact, free = math.pi * math.sqrt(INERTIA / STIFFNESS), 2.0 * LIMIT / SPEED
    expected = 1 + math.floor((1.95 - 0.5 * free) / (contact + free))
    assert bouncing.impacts.stops == {"wall": expected} and expected == 18
    assert bouncing.impacts.count == 0 and "Contacts at stops (wall) are not listed" in repr(bouncing.impacts)


def test_answers_state_that_contacts_at_stops_are_not_listed(bouncing, tmp_path) -> None:
    sentence = "Contacts at stops (wall) are not listed as impacts; the outputs, 1 ms apart, show 18 of them"
    bouncing.save(tmp_path / "run.sqlite")
    for command in (["impacts"], ["info"], ["impacts", "--json"]):
        answer = CliRunner().invoke(app, [command[0], str(tmp_path), *command[1:]])
        assert answer.exit_code == 0
        assert sentence in " ".join(answer.stdout.split())
    assert json.loads(answer.stdout)["count"] == 0
    assert sentence in " ".join(str(bouncing).split())


def test_a_model_without_stops_has_no_such_sentence() -> None:
    result = vfife.simulate(vfife.gallery.four_bar_ideal(), turns=1, companions=0)
    assert result.impacts.stops == {} and "stop" not in repr(result.impacts)


def test_the_answer_states_the_interval_beneath_which_contacts_are_missed() -> None:
    """A contact of half a period of the stop, 10 ms, is seen by outputs 5 ms apart and missed by those 130 ms
    apart: the sentence names the interval of both.
    """
    m = vfife.Mechanism("bouncing rotor", gravity=(0.0, 0.0))
    rotor = m.rigid_body("rotor", mass=1.0, inertia=INERTIA, velocity=(0.0, 0.0, SPEED))
    m.revolute("hinge", m.point("O", 0.0, 0.0), rotor.pin())
    m.stop("wall", "ground", "rotor", low=-LIMIT, high=LIMIT, stiffness=STIFFNESS)
    counts = {}
    for outputs in (15, 390):
        impacts = vfife.simulate(m, duration=1.95, step=2e-5, outputs=outputs, companions=0).impacts
        assert impacts.interval == pytest.approx(1.95 / outputs, rel=1e-3)
        assert f"the outputs, {1e3 * impacts.interval:.3g} ms apart, show" in repr(impacts)
        counts[outputs] = impacts.stops["wall"]
    assert counts[390] == 18 > counts[15]
