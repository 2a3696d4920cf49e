"""Periods, exponents and the 0-1 test against maps whose answers are known."""

import dataclasses
import math

import numpy as np
import pytest

from vfife.measures.chaos import exponent, period, signed_range, verdict
from vfife.measures.trend import winding, zero_one


def logistic(r: float, count: int, dropped: int = 2000) -> tuple[np.ndarray, np.ndarray]:
    """x' = r x (1 - x): points, and logarithms of the growth of a small difference."""
    x, points, logs = 0.3, [], []
    for k in range(dropped + count):
        if k >= dropped:
            points.append(x)
            logs.append(math.log(max(abs(r * (1.0 - 2.0 * x)), 1e-300)))
        x = r * x * (1.0 - x)
    return np.array(points), np.array(logs)


def test_the_exponent_of_the_logistic_map_is_ln_2():
    """At r = 4 (Ott, Chaos in Dynamical Systems, 2.1)."""
    found = exponent(logistic(4.0, 200_000)[1])
    assert found.value == pytest.approx(math.log(2.0), abs=2e-3)
    assert found.halves[0] <= found.value <= found.halves[1]
    assert not found.estimated and math.isnan(found.low) and "step: not estimated" in found.words
    assert found.running[-1] == found.value and len(found.running) == 200_000


def test_a_range_of_the_exponent_holds_the_motion_with_half_the_step():
    """It is wider than the values on both sides, and than the halves."""
    coarse, fine = exponent([8.0, 8.4] * 20), exponent([6.7, 6.9] * 20)
    found = coarse.with_finer(fine)
    assert found.value == coarse.value and found.estimated
    turns = 0.2 / 40  # the sum of the logarithms swings by 0.2 about its slope in 40 turns
    assert found.low == pytest.approx(6.8 - 2.0 * 1.4 - turns)
    assert found.high == pytest.approx(8.2 + 2.0 * 1.4 + turns)
    assert signed_range(0.15378, 0.50888) == "+0.153 to +0.509", "outwards, in text and figure alike"
    assert signed_range(-0.71399, 0.8414, "and") == "-0.714 and +0.842"
    drift = exponent([4.0] * 20 + [6.0] * 20)
    assert drift.with_finer(drift).low == pytest.approx(2.0)
    assert "to" in found.words and "halves" not in found.words


@pytest.mark.parametrize("angle", [0.3, 1.2, 2.0])
def test_a_range_holds_the_multipliers_of_a_rotating_difference(angle):
    """Complex multipliers 0.5 exp(+-i angle), seen in a norm in which circles are ellipses of 1 : 6: the mean
    of the logarithms swings about ln 0.5 with the number of turns.
    """
    rotation = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    stretch = np.diag([6.0, 1.0])
    turn, tangent, logs = 0.5 * stretch @ rotation @ np.linalg.inv(stretch), np.array([0.8, 0.6]), []
    for _ in range(200):
        tangent = turn @ tangent
        logs.append(math.log(float(np.hypot(*tangent))))
        tangent /= np.hypot(*tangent)
    for turns in range(20, 140):
        found = exponent(logs[:turns])
        ranged = found.with_finer(found)
        assert ranged.low <= math.log(0.5) <= ranged.high
        assert ranged.high - ranged.low < 4.0 * math.log(6.0) / turns + 6.0 * (
            found.halves[1] - found.halves[0]
        )


def test_points_that_scatter_widen_the_range_by_the_scatter_of_turns() -> None:
    """Single turns of -0.06 and -0.04 a turn: the error of their mean is not that of halves, which agree."""
    growth = exponent([-0.06, -0.04] * 30)
    narrow = growth.with_finer(growth)
    points = 1.0 + 1e-4 * np.random.default_rng(1).uniform(size=60)
    found = verdict(points, narrow, ranges=lambda: np.array([1.0])).exponent
    assert found is not None and found.low == pytest.approx(narrow.low - 0.01)
    assert found.high == pytest.approx(narrow.high + 0.01) and found.value == growth.value
    assert growth.with_scatter() is growth, "its range is not estimated"


def test_an_exponent_whose_wide_range_has_both_signs_is_not_known() -> None:
    """A value of +0.821 inside -6.65 to +6.01 says nothing; that of a quasi-periodic motion is about zero."""
    wide = dataclasses.replace(exponent([0.821] * 40), low=-6.65, high=6.01)
    assert wide.words == "exponent not known, between -6.65 and +6.01 per turn"
    narrow = dataclasses.replace(wide, low=-0.03, high=0.05)
    assert narrow.words == "exponent +0.821 per turn (-0.03 to +0.05)"


def test_the_exponent_of_henon_is_0_419():
    """a = 1.4, b = 0.3, with the tangent renormalised at each step; 0.4192 (Wolf et al. 1985: 0.603 bits)."""
    x, y, tangent, logs = 0.1, 0.1, np.array([1.0, 0.0]), []
    for k in range(101_000):
        tangent = np.array([[-2.8 * x, 1.0], [0.3, 0.0]]) @ tangent
        x, y = 1.0 - 1.4 * x * x + y, 0.3 * x
        size = float(np.hypot(*tangent))
        tangent /= size
        if k >= 1000:
            logs.append(math.log(size))
    assert exponent(logs).value == pytest.approx(0.4192, abs=2e-3)


def doubling(times: int, low: float, high: float) -> float:
    """Where the period of the logistic map goes from 2^(times - 1) to 2^times: where the exponent of the
    orbit before touches zero.
    """

    def doubled(r: float) -> bool:
        points = logistic(r, 3 * 2**times, dropped=400_000)[0]
        found = period(points, tolerance=1e-6)
        return found is None or found >= 2**times

    while high - low > 2e-5:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if doubled(middle) else (middle, high)
    return 0.5 * (low + high)


@pytest.mark.parametrize("times, at", [(1, 3.0), (2, 1.0 + math.sqrt(6.0)), (3, 3.5440903)])
def test_feigenbaums_first_doublings(times, at):
    """3, 1 + sqrt(6), 3.54409 (Strogatz, Nonlinear Dynamics and Chaos, 10.2)."""
    assert doubling(times, at - 3e-4, at + 3e-4) == pytest.approx(at, abs=1e-4)


def test_the_0_1_test_tells_regular_from_chaotic():
    """Periods 1 and 4, quasi-periodic rotation, and r = 4."""
    assert zero_one(logistic(2.8, 1000)[0]) == 0.0
    assert abs(zero_one(logistic(3.5, 1000)[0])) < 0.1
    assert abs(zero_one(np.cos(2.0 * math.pi * 0.5 * (math.sqrt(5.0) - 1.0) * np.arange(1000)))) < 0.1
    assert zero_one(logistic(4.0, 1000)[0]) > 0.95


def test_motions_are_told_with_their_evidence():
    for r, said in (
        (2.8, "period 1"),
        (3.2, "period 2"),
        (3.5, "period 4"),
        (3.83, "period 3"),
        (3.9, "chaotic"),
    ):
        points, logs = logistic(r, 400, dropped=20_000)
        assert verdict(points, exponent(logs)).kind == said
    said = str(verdict(points, exponent(logs), dropped=200))
    assert said.startswith("chaotic within 600 turns: ")
    assert said.endswith("; a longer transient is possible: --turns 6000")
    # Too few points to repeat: no share of a range, and no shift that was not tried.
    assert "whether turns repeat is not known" in verdict(np.array([0.0, 1.0])).evidence
    assert verdict(logistic(3.9, 5)[0]).evidence.startswith("points a turn apart agree within")
    assert verdict(logistic(3.9, 9)[0]).evidence.startswith("points up to 3 turns apart agree within")
    assert not any("nan" in verdict(logistic(3.9, count)[0]).evidence for count in range(1, 12))
    turning = np.cos(2.0 * math.pi * 0.5 * (math.sqrt(5.0) - 1.0) * np.arange(400))
    assert verdict(turning, exponent(np.zeros(400))).kind == "quasi-periodic"


@pytest.mark.parametrize(
    ("share", "growth", "kind"),
    [
        (0.002, -0.02, "period 1"),
        (0.002, 0.0, "period 1"),
        (0.02, -0.02, "period 2"),
        (0.002, 0.3, "not decided"),
    ],
)
def test_a_longer_period_of_a_small_difference_is_not_told_from_the_step(
    share: float, growth: float, kind: str
) -> None:
    """Points that repeat exactly after two turns, and settled in the first half of the turns."""
    decay = np.exp(-0.1 * np.arange(200.0))
    points = 3.0 + (share + decay) * np.where(np.arange(200) % 2, 0.5, -0.5)
    said = verdict(points, exponent(np.full(200, growth)), ranges=lambda: np.array([1.0]))
    assert said.kind == kind
    assert ("repeat after 2" in said.evidence) == (kind == "period 1")


def test_a_longer_period_whose_points_are_further_apart_than_the_step_sets_them_is_not_decided() -> None:
    """0.7 % of the range after one turn, exactly alike after two, or after four within a small scatter."""
    turns = np.arange(200)
    for points, said in (
        (3.0 + 0.007 * np.where(turns % 2, 0.5, -0.5), "those 2 turns apart much closer"),
        (
            3.0 + np.resize([0.0, 0.002, 0.007, 0.003], 200) + 1e-4 * np.sin(17.0 * turns**2),
            "those 4 turns apart much closer",
        ),
    ):
        found = verdict(points, exponent(np.full(200, -0.2)), ranges=lambda: np.array([1.0]))
        assert found.kind == "not decided" and found.period is None and said in found.evidence
    noise = np.random.default_rng(1).uniform(-0.0035, 0.0035, 200)
    found = verdict(3.0 + noise, exponent(np.full(200, -0.2)), ranges=lambda: np.array([1.0]))
    assert found.kind == "period 1", "scatter that no multiple of the period explains is that of the step"


def test_one_point_that_is_further_off_makes_no_longer_period() -> None:
    """Scatter with one outlier in the first half: points a turn apart were taken for those that settle."""
    noise = np.random.default_rng(4).uniform(-1e-4, 1e-4, 30)
    noise[12:14] += 3e-4, -3e-4
    found = verdict(3.0 + noise, exponent(np.full(30, -0.5)), ranges=lambda: np.array([1.0]))
    assert found.kind == "period 1"


@pytest.mark.parametrize(
    ("r", "kind"),
    [(3.2, "period 2"), (3.5, "period 4"), (3.55, "period 8"), (3.566, "period 16"), (3.569, "period 32")],
)
def test_the_cascade_of_the_logistic_map_is_periodic(r: float, kind: str) -> None:
    points, logs = logistic(r, 200, dropped=20_000)
    assert verdict(points, exponent(logs)).kind == kind == verdict(points).kind


@pytest.mark.parametrize("count", [100, 200])
def test_a_period_too_long_to_be_seen_is_neither_chaotic_nor_quasi_periodic(count: int) -> None:
    """Period 64 (r = 3.5697) in up to 200 turns, with any evidence on the exponent that does not exclude 0.
    Scatter of the step lets its exponent appear a little above zero.
    """
    points, logs = logistic(3.5697, count, dropped=20_000)
    points = points + 1e-3 * np.random.default_rng(1).normal(size=count)
    above = exponent(np.full(count, 0.03) + 0.5 * np.sin(np.arange(count) * 0.4))
    ranged = dataclasses.replace(above, low=-0.06, high=0.12)
    for growth in (None, exponent(logs), exponent(np.zeros(count)), above, ranged):
        found = verdict(points, growth)
        assert found.kind in ("not decided", "not settled"), (growth, found)
    assert "a period of more than" in verdict(points, ranged).evidence


@pytest.mark.parametrize("r", [3.59, 3.6, 3.7, 4.0])
def test_chaos_in_bands_is_chaos(r: float) -> None:
    """Two and four bands in 200 turns look regular to the 0-1 test, but not every fourth point."""
    points, logs = logistic(r, 200)
    found = verdict(points, exponent(logs))
    assert found.kind == "chaotic" and found.zero_one > 0.3
    assert ("of every" in found.evidence) == (r < 3.6)


def test_a_range_of_the_exponent_over_zero_is_no_evidence_of_chaos() -> None:
    points, logs = logistic(3.9, 200)
    growth = exponent(logs)
    assert verdict(points, dataclasses.replace(growth, low=0.2, high=0.8)).kind == "chaotic"
    found = verdict(points, dataclasses.replace(growth, low=-0.01, high=1.2))
    assert found.kind == "not decided" and "the exponent may be zero by its range" in found.evidence
    assert "chaotic" not in str(verdict(points, exponent(np.zeros(200)))), "an exponent of zero"


def test_points_that_follow_a_folded_curve_are_quasi_periodic() -> None:
    """Two incommensurate frequencies, on a curve that crosses itself and does not go round its mean; a
    random order of the same points follows no curve.
    """
    phase = math.tau * 0.5 * (math.sqrt(5.0) - 1.0) * np.arange(200)
    points = np.column_stack(
        [np.cos(phase) + 0.6 * np.cos(2.0 * phase + 1.0), np.sin(2.0 * phase) + 0.4 * np.cos(3.0 * phase)]
    )
    found = verdict(points, exponent(np.zeros(200)))
    assert not found.rotation.closed and found.kind == "quasi-periodic"
    assert "one closed curve, gone round 0.3819 times a turn" in found.evidence
    assert math.isnan(winding(np.random.default_rng(1).permutation(points)))
    for r in (3.5, 3.55, 3.5697):
        assert math.isnan(winding(logistic(r, 200)[0][:, None])), "a long period is no curve"


def test_equal_points_are_not_said_to_differ_by_a_third_of_their_range() -> None:
    """They alternate by the error of the step, in the sixth digit, which is all of their range."""
    found = verdict(7.70354 + 1.2e-5 * (-1.0) ** np.arange(60))
    assert found.period == 1 and "within 0.00031 % of their size" in found.evidence
    assert "% of the range" not in found.evidence
    assert "of the range" in verdict(np.array([1.0, 2.0] * 30)).evidence
