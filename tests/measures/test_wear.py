"""What joints with clearance lose, how their surfaces slide, press and strike: against the ledger, the step's
powers, and Johnson's closed forms.
"""

import math

import numpy as np
import pytest

from support import four_bar, go, journal_in_bearing
from vfife.gallery import slider_crank_loose_guide
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh, Pair
from vfife.measures import ledger
from vfife.measures.catalogue import measures
from vfife.measures.contacts import (
    around,
    contact_angle,
    impacts,
    line_pressure,
    mean_power,
    mean_pressure,
    sliding_speed,
    spent_energy,
)
from vfife.measures.motion import times


@pytest.fixture(scope="module")
def record():
    return go(four_bar(), 2e-6, turns=1.25)


@pytest.fixture(scope="module")
def guided():
    """31,416 steps a turn: the outputs of the last one begin where it does."""
    return go(slider_crank_loose_guide(friction=0.1), 0.02 * math.pi / 31416.0, turns=1.1)


@pytest.mark.parametrize("name", ["record", "guided"])
def test_losses_of_the_joints_are_those_of_the_ledger(name, request) -> None:
    record = request.getfixturevalue(name)
    terms, found = ledger(record).terms, measures(record)
    first = len(record.steps) - 1 - round(record.assembly.choice.turn / (times(record)[1] - times(record)[0]))
    for kind, term in (("friction", "friction_loss"), ("impact", "contact_loss")):
        over = terms[term][-1] - terms[term][first]
        joints = [value for key, value in found.items() if key.endswith(f".{kind}_energy.total")]
        assert len(joints) == len(record.assembly.mechanism.contacts)
        assert sum(joints) == pytest.approx(over, rel=1e-9)
        powers = [value for key, value in found.items() if key.endswith(f".{kind}_power.mean")]
        assert sum(powers) == pytest.approx(over / (times(record)[-1] - times(record)[first]), rel=1e-9)
        np.testing.assert_allclose(
            spent_energy(record, kind).sum(axis=1), terms[term], rtol=1e-12, atol=1e-12
        )
        summed = (mean_power(record, kind)[1:] * np.diff(times(record))[:, None]).sum()
        assert summed == pytest.approx(terms[term][-1], rel=1e-9)


@pytest.mark.parametrize("name", ["record", "guided"])
def test_friction_takes_force_times_sliding_velocity(name, request) -> None:
    """The step keeps friction's power from velocities that it solves itself; here they come from positions
    and rates of the bodies.
    """
    record = request.getfixturevalue(name)
    force, power = record.block("contact_friction_force"), record.block("contact_friction_power")
    pressed = np.abs(force) > 1e-3 * np.abs(force).max()
    assert pressed.sum() > 50
    speed = sliding_speed(record)
    np.testing.assert_allclose(
        (-force * speed)[pressed], power[pressed], rtol=2e-3, atol=2e-3 * np.abs(power).max()
    )


def test_a_journal_that_spins_in_place_slides_by_its_radius() -> None:
    m = journal_in_bearing(0.1, friction=Frictionless(), contact=LankaraniNikravesh(restitution=0.5))
    from vfife.model.bodies import RigidBody

    m.bodies["journal"] = RigidBody(name="journal", mass=1.0, inertia=1e-4, velocity=(0.1, 0.0, 50.0))
    record = go(m, 2e-6, duration=0.02, outputs=200)
    touching = record.block("contact_penetration")[:, 0] > 0.0
    assert touching.any()
    np.testing.assert_allclose(sliding_speed(record)[touching, 0], 50.0 * 0.0095, rtol=5e-3)


def test_line_pressure_is_hertz() -> None:
    """Johnson 1985, Eq. 4.43 to 4.45: P' = pi a p_0/2, p_0 = 2/pi times the mean; and a^2 = 4
    P' R/(pi E*).
    """
    pair, force = Pair(0.01, 5e-4, 0.02), np.array([0.0, 1e3, 4e4])
    modulus, radius = 207e9 / 2.0 / (1.0 - 0.09), 1.0 / (1.0 / 0.0095 - 1.0 / 0.01)
    pressure, half = line_pressure(pair, force)
    np.testing.assert_allclose(math.pi * half * pressure / 2.0, force / 0.02, rtol=1e-12)
    np.testing.assert_allclose(half**2, 4.0 * force / 0.02 * radius / (math.pi * modulus), rtol=1e-12)
    np.testing.assert_allclose(mean_pressure(pair, force), force / (0.019 * 0.02), rtol=1e-12)
    beside = Pair(math.inf, 0.0, 0.02, opposite_radius=0.01)
    np.testing.assert_allclose(
        mean_pressure(beside, force[1:]), math.pi / 4.0 * line_pressure(beside, force[1:])[0], rtol=1e-12
    )


def test_no_contact_is_wider_than_its_journal() -> None:
    """A snug pin whose pressure goes with the cosine bears F = integral of p cos = pi/4 p_0 d L."""
    pressure, half = line_pressure(Pair(0.01, 1e-5, 0.02), np.array([1e6]))
    assert half[0] == pytest.approx(0.00999)
    assert math.pi / 4.0 * pressure[0] * 2 * 0.00999 * 0.02 == pytest.approx(1e6)


def test_line_pressure_of_a_roller_on_a_plane() -> None:
    """A steel roller of 10 mm radius on a steel plane under 100 N/mm, E* = 113.7 GPa, by hand: 0.602 GPa and
    0.106 mm.
    """
    pair = Pair(math.inf, 0.0, 1.0, opposite_radius=0.01)
    pressure, half = line_pressure(pair, np.array(1e5))
    assert float(pressure) == pytest.approx(0.6017e9, rel=1e-3)
    assert float(half) == pytest.approx(0.1058e-3, rel=1e-3)


def test_measures_of_pressure_hold_the_outputs(record) -> None:
    from vfife.measures.contacts import pressures, sliding_speed
    from vfife.measures.turns import last_turn

    found, window = measures(record), last_turn(record)
    pressure, half, load = (one[window] for one in pressures(record))
    for k, name in enumerate("BCD"):
        assert pressure[:, k].max() <= found[f"{name}.contact_pressure.max"] <= 1.01 * pressure[:, k].max()
        assert half[:, k].max() <= found[f"{name}.contact_half_width.max"] <= 1.01 * half[:, k].max()
        product = load[:, k] * np.abs(sliding_speed(record))[window, k]
        assert found[f"{name}.pressure_velocity.max"] == product.max()
        assert found[f"{name}.pressure_velocity.mean"] == pytest.approx(product.mean(), rel=0.01)
    assert load.max() == pytest.approx(
        record.block("contact_normal_force")[window].max() / (2 * 0.0098 * 0.02), rel=1e-9
    )


# -----------------------------------------------------------------------------------------------------------
# impacts


@pytest.mark.parametrize("outputs", [720, 9])
def test_no_impact_is_missed_however_few_the_outputs(outputs) -> None:
    record = go(four_bar(), 2e-6, turns=0.5, outputs=outputs)
    found = impacts(record)
    assert found.count == int(record.block("contact_onsets")[-1].sum()) > 5
    assert found.before + sum(one.energy for one in found.entries) == pytest.approx(
        ledger(record).terms["contact_loss"][-1], rel=1e-9
    )
    deepest = record.block("contact_penetration_max").max(axis=0)
    for k, name in enumerate("BCD"):
        own = [one for one in found.entries if one.joint == name]
        assert sum(one.count for one in own) == int(record.block("contact_onsets")[-1, k])
        assert max(one.depth for one in own) == deepest[k]
        weighed = sum(one.count * one.speed for one in own)
        assert weighed == pytest.approx(record.block("contact_approach")[-1, k], rel=1e-12)
    if outputs == 720:
        assert found.alone == found.count
    else:
        assert found.alone < found.count
    assert all(
        one.since <= one.time and one.crank == pytest.approx(math.degrees(50.0 * math.pi * one.time))
        for one in found.entries
    )


def test_a_bouncing_journal_loses_its_restitution() -> None:
    """Struck at 0.7 m/s with e = 0.8: the next impact comes at 0.8 of the speed, and 1 - e^2 of the energy is
    lost.
    """
    from vfife.laws import Hertz

    law = Hertz(restitution=0.8, damping="gonthier-exact")
    record = go(
        journal_in_bearing(0.7, friction=Frictionless(), contact=law), 1e-6, duration=4e-3, outputs=400
    )
    first, second = impacts(record).entries[:2]
    assert first.speed == pytest.approx(0.7, rel=1e-4)
    assert first.since <= 5e-4 / 0.7 <= first.time
    assert second.speed / first.speed == pytest.approx(0.8, rel=2e-3)
    assert first.energy == pytest.approx(0.5 * 0.7**2 * (1.0 - 0.64), rel=5e-3)


def test_a_joint_that_never_strikes_has_no_entry() -> None:
    """Beside others that do, and alone: a journal at 0.5 m/s is still on its way across."""
    assert (
        impacts(go(journal_in_bearing(0.5, friction=Frictionless()), 1e-6, duration=1e-4, outputs=10)).entries
        == ()
    )
    record = go(slider_crank_loose_guide(), 2e-6, turns=0.1)  # two corners of its block have not struck yet
    struck = record.block("contact_onsets")[-1]
    assert 0 < np.count_nonzero(struck) < 4 and impacts(record).count == int(struck.sum())


def test_a_run_without_play_has_no_impacts() -> None:
    assert impacts(go(four_bar(""), 1e-4, turns=0.1)).entries == ()


# --------------------------------------------------------------------------------------------------- round
# the bearing


def test_all_that_happens_round_a_bearing_is_what_the_run_counted(record) -> None:
    for side in ("bearing", "journal"):
        found = around(record, side, bins=36)
        np.testing.assert_allclose(found.time.sum(axis=1), record.block("contact_duration")[-1], rtol=1e-12)
        np.testing.assert_allclose(
            found.friction.sum(axis=1), spent_energy(record, "friction")[-1], rtol=1e-12
        )
        assert found.time.shape == (3, 36) and found.middles[0] == pytest.approx(-math.pi * 35 / 36)
    with pytest.raises(ValueError, match='side = "crank"'):
        around(record, "crank")


def test_the_angle_is_that_of_the_bearings_own_frame(record) -> None:
    """B is carried by the crank, which turns: the same direction in space, less the crank's angle."""
    away = contact_angle(record)
    from vfife.measures.forces import eccentricity

    e, crank = eccentricity(record)[:, 0], 50.0 * math.pi * times(record)
    inside = np.linalg.norm(e, axis=1) > 1e-4
    turned = np.arctan2(e[:, 1], e[:, 0]) - crank - away[:, 0]
    np.testing.assert_allclose(np.cos(turned[inside]), 1.0, atol=1e-9)
    assert np.allclose(np.cos(np.arctan2(*contact_angle_of_ground(record)) - away[:, 2]), 1.0, atol=1e-9)


def contact_angle_of_ground(record):
    """D is the ground's: its angle is the global one."""
    from vfife.measures.forces import eccentricity

    e = eccentricity(record)[:, 2]
    return e[:, 1], e[:, 0]


def test_a_journal_pressed_down_touches_below() -> None:
    m = journal_in_bearing(0.0, friction=Ambrosio(coefficient=0.1))
    m.gravity = (0.0, -9.81)
    record = go(m, 2e-6, duration=0.1, outputs=500)
    found = around(record, bins=8)
    share = found.time[0] / found.time[0].sum()
    assert share[[1, 2]].sum() == pytest.approx(1.0)  # the bins on both sides of -90 degrees
