"""Impacts of rows that a test writes; points that are nearly alike; pressures of contacts; memories at their
start.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from made_records import STEP, made_record
from support import four_bar, journal_in_bearing
from vfife.laws import Coulomb, LuGre, Pair
from vfife.measures.chaos import Verdict, exponent, verdict
from vfife.measures.contacts import impacts, largest_pressures, line_pressure, mean_pressure
from vfife.measures.forces import normals
from vfife.measures.impact import initial_memory, presliding
from vfife.measures.trend import EQUAL, period, recurrence_distance, rotation, zero_one
from vfife.model.mechanism import Mechanism
from vfife.model.wear import Wear

STEPS = np.arange(0, 60, 10)


def struck(
    onsets: list[float], approach: list[float], work: list[float], depth: list[float], **more: np.ndarray
):
    """A record of one contact with these counts, sums of speeds (m/s), works lost (J) and depths (m) at its
    outputs.
    """
    blocks = {
        "contact_onsets": onsets,
        "contact_approach": approach,
        "contact_damping_work": work,
        "contact_penetration_max": depth,
    }
    return made_record(journal_in_bearing(), blocks | more, STEPS)


def test_each_contact_that_began_has_its_speed_loss_and_depth() -> None:
    """One by 0.2 m/s before output 2, two of a mean of 0.35 m/s before output 4; 0.01 J went before any."""
    record = struck(
        [0, 0, 1, 1, 3, 3],
        [0, 0, 0.2, 0.2, 0.9, 0.9],
        [0, 0.01, 0.05, 0.06, 0.16, 0.2],
        [-1, -1, 2e-6, 5e-6, 1e-6, -1],
    )
    found = impacts(record)
    first, second = found.entries
    assert (first.count, second.count, found.count, found.alone) == (1, 2, 3, 1)
    assert (first.since, first.time) == pytest.approx((10 * STEP, 20 * STEP)) and (
        second.since,
        second.time,
    ) == pytest.approx((30 * STEP, 40 * STEP))
    assert (first.speed, second.speed) == pytest.approx((0.2, 0.35))
    assert (found.before, first.energy, second.energy) == pytest.approx((0.01, 0.05, 0.14))
    assert (first.depth, second.depth) == (5e-6, 1e-6) and first.crank is None
    assert found.hardest(1) == (second,)


def test_a_contact_that_has_begun_at_the_start_and_one_that_never_does() -> None:
    at_once = impacts(struck([2, 2, 2, 2, 2, 2], [0.5] * 6, [0.0, 0.1, 0.2, 0.2, 0.2, 0.2], [3e-6] * 6))
    (one,) = at_once.entries
    assert (
        (one.count, one.since, one.time, one.speed) == (2, 0.0, 0.0, 0.25)
        and one.energy == pytest.approx(0.2)
        and at_once.before == 0.0
    )
    soon = impacts(struck([0, 1, 1, 1, 1, 1], [0] + [0.5] * 5, [0.02, 0.1, 0.2, 0.2, 0.2, 0.2], [3e-6] * 6))
    assert soon.before == pytest.approx(0.02) and soon.entries[0].energy == pytest.approx(0.18), (
        "a part of a run begins with what was lost"
    )
    never = impacts(struck([0] * 6, [0] * 6, [0.0, 0.0, 0.1, 0.2, 0.2, 0.3], [-1] * 6))
    assert never.entries == () and never.before == pytest.approx(0.3) and never.count == never.alone == 0
    assert impacts(made_record(four_bar(""), {}, STEPS)).entries == ()


def test_points_at_rest_are_alike_within_a_hundred_thousandth_of_their_size() -> None:
    for share, found in ((0.9, 1), (1.2, 2)):
        assert period(2.0 * (1.0 + share * EQUAL * (np.arange(12) % 2)), tolerance=1e-9) == found
    assert EQUAL == 1e-5 and recurrence_distance(np.array([1.0, 2.0] * 6)) == 0.0
    assert recurrence_distance(np.array([1.0, 2.0] * 6), 1) == 1.0
    assert period(np.arange(30.0)) is None and period(np.array([1.0, 2.0] * 2)) is None, (
        "a period has to be seen three times"
    )


@pytest.mark.parametrize(
    ("value", "kind"),
    [(0.29, "not decided"), (0.31, "not settled"), (0.69, "not settled"), (0.71, "chaotic")],
)
def test_the_0_1_test_decides_where_nothing_else_does(
    value: float, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Below 0.3 a motion is regular, but these points follow no curve; above 0.7 it is chaotic, of a hundred
    points and more.
    """
    monkeypatch.setattr("vfife.measures.trend.zero_one", lambda _: value)
    noise = np.random.default_rng(1).uniform(size=120)
    assert verdict(noise).kind == kind and verdict(noise[:100]).zero_one == value
    assert verdict(noise[:99]).zero_one is None and verdict(noise[:99]).kind == "not settled"


def test_a_curve_of_four_lobes_is_gone_round_in_order() -> None:
    """r = 1 + 0.2 cos 4 phi, by the golden share of a turn each time: four times to and fro of the radius, in
    parts of twice its range.
    """
    turn = 0.5 * (math.sqrt(5.0) - 1.0)
    phi = math.tau * turn * np.arange(610)
    found = rotation(
        np.column_stack(
            [(1.0 + 0.2 * np.cos(4.0 * phi)) * np.cos(phi), (1.0 + 0.2 * np.cos(4.0 * phi)) * np.sin(phi)]
        )
    )
    assert found is not None and found.closed and found.order == 1.0
    assert found.number == pytest.approx(turn, abs=1e-3) and found.rough == pytest.approx(4.0, rel=0.02)
    assert rotation(np.ones((20, 2))) is None and rotation(phi[:7]) is None


def test_exponents_are_means_of_the_whole_and_of_its_halves() -> None:
    found = exponent([1.0, 3.0, 0.0, 0.0, 1.0])
    assert (found.value, *found.halves) == pytest.approx((1.0, 1.0 / 3.0, 2.0))
    assert found.running.tolist() == pytest.approx([1.0, 2.0, 4.0 / 3.0, 1.0, 1.0])


def test_what_hardly_moves_is_regular() -> None:
    """A ripple of 1e-10 of the size is rounding; one of 1e-8 is a series, here a random one, whatever its
    mean.
    """
    noise = np.random.default_rng(3).uniform(-1.0, 1.0, 400)
    assert zero_one(1.0 + 1e-10 * noise) == 0.0 and zero_one(1e6 + 1e-4 * noise) == 0.0
    assert zero_one(np.zeros(50)) == 0.0
    for share in (1e-8, 1e-3, 1.0):
        assert (
            zero_one(1.0 + share * noise) == pytest.approx(zero_one(noise), abs=1e-4)
            and zero_one(1.0 + share * noise) > 0.99
        )
        assert abs(zero_one(1.0 + share * np.cos((math.sqrt(5.0) - 1.0) * math.pi * np.arange(400)))) < 0.1


def test_worn_surfaces_lean_by_their_slope_over_the_eccentricity() -> None:
    """h = h_0 + a cos + b sin around the bearing: n leans by h'/e, e the eccentricity or half of the
    clearance where that is less.
    """
    mean, a, b, clearance = 4e-6, 3e-6, -2e-6, 5e-4
    m = Mechanism("worn", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.rigid_body("journal", mass=1.0, inertia=1e-4)
    wear = Wear(bearing=1e-15, bearing_profile=(mean, a, b))
    m.clearance_joint(
        "J",
        "ground.O",
        "journal.center",
        clearance=clearance,
        bearing_radius=0.01,
        axial_length=0.02,
        wear=wear,
    )
    angle = np.array([0.3, 2.0, -1.1, 0.3])
    away = clearance * np.array([0.7, 0.6, 0.9, 0.2])
    x, y = away * np.cos(angle), away * np.sin(angle)
    record = made_record(
        m,
        {"particle_x": np.stack([0.0 * x, x], axis=1), "particle_y": np.stack([0.0 * y, y], axis=1)},
        STEPS[:4],
    )
    lean = (-a * np.sin(angle) + b * np.cos(angle)) / np.maximum(away, 0.5 * clearance)
    n, t = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    assert pytest.approx((n - lean * t) / np.sqrt(1.0 + lean**2), rel=1e-9) == normals(record)[:, 0].T


def test_line_contact_of_hertz_and_its_limit() -> None:
    """R_B 10 mm, R_J 9.8 mm: R = 0.49 m; p_0 = 2 F/(pi a L) with a = sqrt(4 F R/(pi L E*)), and 4 F/(pi d L)
    once a is the journal's radius.
    """
    pair, radius = Pair(0.01, 2e-4, 0.02), 0.01 * 0.0098 / 2e-4
    for force in (10.0, 1e3):
        (pressure,), (half,) = line_pressure(pair, np.array([force]))
        wide = math.sqrt(4.0 * force * radius / (math.pi * 0.02 * pair.composite_modulus))
        assert half == pytest.approx(wide, rel=1e-12) and pressure == pytest.approx(
            2.0 * force / (math.pi * wide * 0.02), rel=1e-12
        )
    (pressure,), (half,) = line_pressure(pair, np.array([1e8]))
    assert half == pair.journal_radius and pressure == pytest.approx(
        4e8 / (math.pi * 2.0 * 0.0098 * 0.02), rel=1e-12
    )
    assert mean_pressure(pair, np.array([196.0, -5.0])) == pytest.approx([196.0 / (2.0 * 0.0098 * 0.02), 0.0])


def test_memory_is_zero_at_the_start_in_as_many_numbers_as_there_are() -> None:
    memories = [
        initial_memory(SimpleNamespace(memory=names)) for names in ((), ("z",), ("z", "v"), ("z", "v", "w"))
    ]  # type: ignore[arg-type]
    assert memories == [0.0, 0.0, (0.0, 0.0), (0.0, 0.0, 0.0)]


def test_strokes_go_to_and_fro_about_the_start() -> None:
    """One out, then twice the amplitude each way; Coulomb friction is against them, mu N."""
    place, force = presliding(Coulomb(coefficient=0.2), Pair(0.01, 2e-4, 0.02), 50.0, 1e-6)
    assert len(place) == 1 + 400 * 9 and place[0] == force[0] == 0.0
    assert [place[400 * k] for k in (1, 3, 5, 7, 9)] == pytest.approx([1e-6, -1e-6, 1e-6, -1e-6, 1e-6])
    assert force[1:] == pytest.approx(-10.0 * np.sign(np.diff(place)))
    law, pair = LuGre(), Pair(0.01, 2e-4, 0.02)
    assert (
        presliding(law, pair, 50.0, 1e-6)[1].tolist() == presliding(law, pair, 50.0, 1e-6, 1e-4)[1].tolist()
    ), "0.1 mm/s unless said"


def test_pressure_and_sliding_of_a_single_output_have_no_mean() -> None:
    found = largest_pressures(made_record(journal_in_bearing(), {}, [0]), np.ones(1, dtype=bool))
    assert "J.pressure_velocity.max" in found and "J.pressure_velocity.mean" not in found


def test_an_exponent_that_is_no_number_is_not_shown_as_one() -> None:
    """A strongly attracted difference becomes zero, which has no logarithm: then the reason is told."""
    growth = exponent(np.array([0.5, 0.25, np.nan, np.nan]))
    found = Verdict("period 1", 1, 1e-4, growth)
    assert "nan" not in found.evidence and "exponent not estimated, because" in found.evidence
