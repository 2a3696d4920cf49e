"""Quantiles and shares of a sample against the binomial formula, written out, and published numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vfife.studies.spec.limits import allowed_failures, mean, needed, quantile, share


def at_most(k: int, n: int, p: float) -> float:
    return math.fsum(math.comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(k + 1))


@pytest.mark.parametrize(
    ("n", "q", "confidence"),
    [(20, 0.5, 0.95), (100, 0.9, 0.95), (400, 0.99, 0.9), (700, 0.99, 0.95), (50, 0.05, 0.9)],
)
def test_limits_are_the_nearest_values_that_hold_the_quantile(n: int, q: float, confidence: float) -> None:
    """Ranks r < s: of n draws at least r and fewer than s lie below the quantile with the confidence, and no
    rank nearer does on its side.
    """
    found, half = quantile(np.arange(1.0, n + 1), q, confidence), 0.5 * (1 - confidence)
    r, s = int(found.low) if found.low > 0 else 0, int(found.high) if found.high < math.inf else n + 1
    assert r < n * q < s
    assert r == 0 or at_most(r - 1, n, q) <= half < at_most(r, n, q)
    assert (s == n + 1 or 1 - at_most(s - 1, n, q) <= half) and 1 - at_most(s - 2, n, q) > half
    assert found.value == pytest.approx(1 + q * (n - 1))


def test_the_median_of_ten_lies_between_the_second_and_the_ninth() -> None:
    """97.9 % for ranks 2 and 9, the textbook's table; 89 % for 3 and 8 would be too little."""
    found = quantile(np.arange(1.0, 11.0), 0.5, 0.95)
    assert (found.low, found.high) == (2.0, 9.0)


def test_a_small_sample_has_no_upper_limit() -> None:
    assert quantile(np.arange(300.0), 0.99).high == math.inf
    assert quantile(np.arange(400.0), 0.99).high == 399.0
    assert math.isnan(quantile(np.empty(0), 0.5).value)


def test_limits_hold_the_quantile_as_often_as_they_say() -> None:
    """Of 1000 samples of 60 uniform draws, 95 % or some more hold 0.8 between the limits."""
    draws = np.random.default_rng(1).random((1000, 60))
    held = [one.low <= 0.8 <= one.high for one in (quantile(row, 0.8) for row in draws)]
    assert 0.94 < np.mean(held) < 0.985


def test_shares_are_those_of_published_tables() -> None:
    """Clopper and Pearson's limits in Newcombe (1998), table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29."""
    for count, of, low, high in (
        (81, 263, 0.2527, 0.3676),
        (15, 148, 0.0578, 0.1617),
        (0, 20, 0.0, 0.1684),
        (1, 29, 0.0009, 0.1776),
    ):
        limits = share(count, of)
        assert (limits.low, limits.high) == pytest.approx((low, high), abs=6e-5)
    assert share(20, 20).high == 1.0
    assert math.isnan(share(0, 0).value)


@pytest.mark.parametrize("n", [40, 300])
def test_limits_hold_rare_shares_as_often_as_they_say(n: int) -> None:
    """Of a share of 0.18/n, one such machine in n is drawn with 15 %: Wilson's lower limit is above the share
    then.
    """
    for p in (0.18 / n, 1.0 / n, 5.0 / n, 0.5):
        weights = [math.comb(n, k) * p**k * (1 - p) ** (n - k) for k in range(n + 1)]
        limits = [share(k, n) for k in range(n + 1)]
        held = math.fsum(weight for weight, at in zip(weights, limits, strict=True) if at.low <= p <= at.high)
        assert held >= 0.95


def test_limits_of_the_mean_of_four_are_those_of_student() -> None:
    """t of three degrees of freedom is 3.182 at 95 % (tables), against 1.960 of a known deviation."""
    limits = mean(np.array([1.0, 2.0, 3.0, 4.0]))
    assert limits.high - limits.value == pytest.approx(3.1824 * math.sqrt(5.0 / 3.0) / 2.0, rel=1e-4)
    assert limits.value - limits.low == pytest.approx(limits.high - limits.value)


def test_failures_that_are_allowed() -> None:
    """299 without a failure show 99 % at 95 % confidence, 473 with one, 628 with two (tables of one-sided
    tolerance limits).
    """
    assert needed(0.01) == 299
    assert [allowed_failures(of, 0.01) for of in (298, 299, 472, 473, 627, 628, 772, 773)] == [
        -1,
        0,
        0,
        1,
        1,
        2,
        2,
        3,
    ]
    for of, failing, confidence in ((300, 0.01, 0.95), (1000, 0.05, 0.9)):
        k = allowed_failures(of, failing, confidence)
        assert at_most(k, of, failing) <= 1 - confidence < at_most(k + 1, of, failing)
