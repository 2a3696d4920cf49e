"""Motions in a word with their evidence, against maps whose answers are known."""

import math

import numpy as np
import pytest

from vfife.measures.chaos import exponent, period, rotation, verdict

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def standard(k: float, turn: float, count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Chirikov's standard map: points (angle, momentum) and logarithms of the growth of a tangent."""
    angle, p, tangent, points, logs = 0.0, turn, np.array([1.0, 0.0]), [], []
    for _ in range(count):
        slope = k * math.cos(angle)
        p += k * math.sin(angle)
        angle += p
        tangent = np.array([[1.0 + slope, 1.0], [slope, 1.0]]) @ tangent
        size = float(np.hypot(*tangent))
        tangent /= size
        points.append((angle, p))
        logs.append(math.log(size))
    return np.array(points), np.array(logs)


@pytest.mark.parametrize("turn", [GOLDEN, math.sqrt(2.0) - 1.0, 1.0 / math.pi])
def test_points_on_a_curve_give_their_rotation_number(turn):
    """A rotation by a known share of a turn, on a curve that is no circle; one coordinate is enough."""
    angle = 2.0 * math.pi * turn * np.arange(300)
    plane = np.column_stack([3.0 + np.cos(angle), 0.2 * np.sin(angle) + 0.03 * np.cos(2.0 * angle)])
    for points in (plane, plane[:, 0]):
        found = rotation(points)
        assert found.closed and min(abs(found.number - turn), abs(1.0 - found.number - turn)) < 2e-3
    said = verdict(plane, exponent(np.zeros(300)))
    assert (
        said.kind == "quasi-periodic" and "one closed curve" in said.evidence and "0-1 test" in said.evidence
    )


def test_few_points_on_a_curve_are_enough():
    angle = 2.0 * math.pi * GOLDEN * np.arange(40)
    assert (
        verdict(np.column_stack([np.cos(angle), np.sin(angle)]), exponent(np.zeros(40))).kind
        == "quasi-periodic"
    )


def test_the_standard_map_is_quasi_periodic_below_and_chaotic_above_its_last_curve():
    """The golden curve is there at k = 0.5 and gone at 2 (Greene 1979: it breaks at 0.9716); its exponent
    above is near ln(k / 2) for large k.
    """
    points, logs = standard(0.3, 2.0 * math.pi * GOLDEN, 600)
    seen = np.column_stack([np.cos(points[:, 0]), np.sin(points[:, 0])]) * (
        1.0 + 0.1 * (points[:, 1:] - points[0, 1])
    )
    found = verdict(seen, exponent(logs[200:]))  # a sheared difference grows as the turns do at first
    assert found.kind == "quasi-periodic" and found.zero_one < 0.3 and found.rotation.closed
    points, logs = standard(8.0, 2.0 * math.pi * GOLDEN)
    found = verdict(np.column_stack([np.cos(points[:, 0]), np.sin(points[:, 0])]), exponent(logs))
    assert found.kind == "chaotic" and found.exponent.value == pytest.approx(math.log(4.0), rel=0.1)
    assert found.zero_one > 0.9 and not found.rotation.closed


def test_the_evidence_of_a_period_is_how_far_its_points_are_apart():
    points = np.resize([1.0, 3.0], 40) + 1e-5 * np.sin(np.arange(40.0))
    found = verdict(points, exponent(np.full(40, -0.5)))
    assert found.kind == "period 2" and found.period == 2 and 1e-7 < found.distance < 2e-5
    assert "2 turns apart" in found.evidence and "-0.5 per turn" in found.evidence


def test_what_is_still_coming_to_rest_is_not_settled():
    """A difference dies while points still move: neither a period nor chaos is told. What left all numbers
    has diverged.
    """
    points = np.exp(-0.02 * np.arange(60.0))
    assert verdict(points, exponent(np.full(60, -0.02 * 60 / 20))).kind == "not settled"
    assert verdict(np.array([1.0, np.nan])).kind == "diverged"


def test_halves_that_do_not_agree_tell_no_chaos():
    logs = np.concatenate([np.full(50, 0.4), np.full(50, -0.4)])
    assert verdict(np.random.default_rng(1).uniform(size=100), exponent(logs)).kind == "not settled"


def test_few_turns_tell_chaos_only_where_their_halves_agree():
    """Of six turns one half may grow by chance four times as fast as the other: a hundred are asked before
    that is passed over.
    """
    points = np.random.default_rng(2).uniform(size=6)
    assert verdict(points, exponent(np.repeat([0.9, 3.6], 3))).kind == "not settled"
    assert verdict(points, exponent(np.repeat([0.9, 1.2], 3))).kind == "chaotic"
    assert (
        verdict(np.random.default_rng(2).uniform(size=120), exponent(np.repeat([0.9, 3.6], 60))).kind
        == "chaotic"
    )


def test_what_repeats_but_for_rounding_has_period_one():
    """A largest force that is known to some millionths of itself, as where a peak falls between steps, beside
    a place that is known better.
    """
    for seed in range(6):
        noise = np.random.default_rng(seed).uniform(-1.0, 1.0, (50, 2))
        assert verdict(np.array([1.4e-6, 152.0]) * (1.0 + np.array([1e-8, 2e-6]) * noise)).kind == "period 1"


@pytest.mark.parametrize("turns", [30, 200])
def test_no_period_is_told_beside_a_positive_exponent(turns):
    """Points of period 3 while a small difference grows e-fold every other turn: one of the two is wrong, so
    neither is told.
    """
    points = np.resize([1.0, 3.0, 2.0], turns)
    found = verdict(points, exponent(np.full(turns, 0.5)))
    assert found.kind == "not decided" and found.period is None
    assert "+0.5 per turn" in found.evidence and "a small difference grows" in found.evidence


def test_a_sheared_difference_grows_and_leaves_a_period():
    """A difference that grows as the turns do, not exponentially: its exponent ln(n)/n is positive, and zero
    within its uncertainty.
    """
    logs = np.log1p(1.0 / np.arange(1.0, 61.0))
    found = verdict(np.resize([1.0, 3.0], 60), exponent(logs))
    assert found.exponent.halves[0] > 0.0 and found.kind == "period 2"


@pytest.mark.parametrize("multiplier", [-0.844, -0.95])
def test_points_that_alternate_about_their_limit_are_not_of_period_two(multiplier):
    """The deviation from a motion of period 1 changes its sign every turn: points come back in pairs before
    they come back at once. A run has the same criterion.
    """
    size = 0.06 if multiplier > -0.9 else 5e-5
    points = 1.0 + size * multiplier ** np.arange(38.0)
    logs = np.full(38, math.log(-multiplier))
    assert period(points) == 2
    found = verdict(points, exponent(logs))
    assert (found.kind, found.period) == ("not settled", None)
    assert f"approach each other by {100.0 * (1.0 + multiplier):.2g} % a turn" in found.evidence
    turns = np.arange(20.0)
    decaying = 1.0 + 0.06 * 0.91**turns + 1e-6 * 0.5**turns  # in order on a thin closed curve
    assert verdict(decaying, exponent(np.full(20, math.log(0.91)))).kind == "not settled"
    ends = points + 0.05 * (-1.0) ** np.arange(38)
    assert verdict(ends, exponent(logs)).kind == "period 2"
