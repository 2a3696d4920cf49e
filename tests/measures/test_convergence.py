"""Errors of step size, from values at several step sizes: of a known order, scattered, of counts, and of what
vanishes with the step.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from vfife.measures.extrapolation import (
    LANES_OF_MEANS,
    LEAST_ERROR,
    SAFETY,
    SCATTER,
    SCATTER_OF_MEANS,
    error_factor,
    error_of_mean,
    error_range,
    observed_order,
    student_quantile,
)

RATIOS = (1.0, 1.4, 1.7, 2.0)
LIMIT, ERROR = 10.0, 0.3


def of_order(order: float, ratios: tuple[float, ...] = RATIOS) -> list[float]:
    """Values whose errors are ERROR r^p."""
    return [LIMIT + ERROR * ratio**order for ratio in ratios]


@pytest.mark.parametrize("order", [0.3, 0.5, 1.0, 1.7, 2.0])
@pytest.mark.parametrize("ratios", [RATIOS, (1.0, 0.5, 0.7, 0.9), (2.0, 1.0, 1.4)])
def test_the_order_of_a_power_is_found(order: float, ratios: tuple[float, ...]) -> None:
    assert observed_order(ratios, of_order(order, ratios)) == pytest.approx(order, abs=1e-6)


@pytest.mark.parametrize("order", [0.5, 0.75, 1.0, 1.5, 2.0])
def test_the_limit_lies_in_the_range(order: float) -> None:
    """Beyond the finest value, by no more than the range reaches; without the factor of safety it would be at
    its end for orders up to one.
    """
    values = of_order(order)
    low, high = error_range("C.force.max", RATIOS, values)
    assert low < LIMIT < min(values) and high > max(values)
    width = values[-1] - values[0]
    assert min(values) - low == pytest.approx(
        max(1.0, SAFETY / (2.0 ** min(order, 1.0) - 1.0)) * width, rel=1e-6
    )
    assert min(values) - low >= width


def test_no_order_is_seen_in_values_that_scatter() -> None:
    values = [1.0, 1.2, 1.1, 1.3]
    assert observed_order(RATIOS, values) is None and error_factor(RATIOS, values) == SCATTER
    assert error_range("A.power.mean", RATIOS, values) == pytest.approx(
        (1.0 - SCATTER * 0.3, 1.3 + SCATTER * 0.3)
    )
    assert observed_order((1.0, 2.0), [1.0, 2.0]) is None and observed_order(RATIOS, [1.0] * 4) is None


def test_values_that_agree_are_known_to_four_digits() -> None:
    assert error_range("C.force.max", RATIOS, [100.0] * 4) == pytest.approx(
        (100.0 * (1.0 - LEAST_ERROR), 100.0 * (1.0 + LEAST_ERROR))
    )


def test_a_count_may_be_wrong_by_one() -> None:
    assert error_range("C.impacts", RATIOS, [20.0] * 4) == (19.0, 21.0)
    assert error_range("C.grazing", RATIOS, [0.0] * 4) == (0.0, 1.0)


def test_how_deep_a_contact_lands_goes_to_zero_with_the_step() -> None:
    low, high = error_range("C.landing_depth.max", RATIOS, [1e-6, 1.4e-6, 1.5e-6, 2e-6])
    assert low == 0.0 and high > 2e-6


def test_what_cannot_be_negative_has_no_range_below_zero() -> None:
    values = [0.1, 0.5, 0.2, 0.9]
    assert (
        error_range("C.force.max", RATIOS, values)[0] == 0.0
        and error_range("crank.power.mean", RATIOS, values)[0] < 0.0
    )
    assert math.isclose(error_range("C.force.max", RATIOS, values)[1], 0.9 + SCATTER * 0.8)


@pytest.mark.parametrize("name", ["impact_power.mean", "impact_energy.total", "bearing_wear.total"])
def test_impacts_and_wear_take_no_negative_energy_or_volume(name: str) -> None:
    """Damping takes energy in each direction of the penetration; a law of friction with memory may return
    some.
    """
    values = [0.1, 0.5, 0.2, 0.9]
    assert error_range(f"C.{name}", RATIOS, values) == pytest.approx((0.0, 0.9 + SCATTER * 0.8))
    assert error_range("C.friction_power.mean", RATIOS, values)[0] == pytest.approx(0.1 - SCATTER * 0.8)


def test_means_of_four_lanes_lie_within_their_range():
    """Of normal means 99 % do, by chance alone: 20,000 draws deviate from that share by less than 0.3 % with
    a probability of 1 - 1e-4.
    """
    values = np.random.default_rng(7).standard_normal((20_000, LANES_OF_MEANS))
    low, high = values.min(axis=1), values.max(axis=1)
    reach = SCATTER_OF_MEANS * (high - low)
    assert 0.985 < ((low - reach < 0.0) & (high + reach > 0.0)).mean() < 0.998


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.6])
def test_the_mean_over_turns_of_another_run_lies_within_the_error_of_sampling(correlation: float) -> None:
    """Ten turns of each of four lanes, and ten of another run; successive turns are correlated. Without the
    correlation, 87 % and 70 % of the means would lie inside instead of 94 %.
    """
    draws = np.random.default_rng(3).standard_normal((1500, 5, 110))
    turns = np.zeros_like(draws)
    for k in range(1, draws.shape[2]):
        turns[:, :, k] = correlation * turns[:, :, k - 1] + draws[:, :, k]
    turns = turns[:, :, -10:]
    inside = [abs(np.mean(run[4]) - np.mean(run[:4])) <= error_of_mean(run[:4].tolist()) for run in turns]
    assert 0.925 < np.mean(inside) < 0.975
    assert error_of_mean([[1.0, 1.0], [1.0, 1.0]]) == error_of_mean([[1.0], [2.0]]) == 0.0


def test_quantiles_of_student_need_no_library() -> None:
    from scipy.stats import t

    for freedom in (3.0, 4.5, 10.0, 39.0, 1e4):
        assert student_quantile(freedom) == pytest.approx(t.ppf(0.975, freedom), rel=0.01)
    for freedom in (1.0, 1.5, 2.0, 2.9):
        assert student_quantile(freedom) == pytest.approx(t.ppf(0.975, int(freedom)), rel=1e-5)
