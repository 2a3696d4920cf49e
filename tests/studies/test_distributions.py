"""Distributions against closed forms, scipy.stats and sampled pairs of parts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from vfife.errors import Fault
from vfife.studies.spec.distributions import Normal, Truncated, Uniform, of_fit, of_tolerance, of_zone

U = np.array([1e-6, 0.01, 0.3, 0.5, 0.77, 0.99, 1 - 1e-6])
MIDDLES = (np.arange(2000) + 0.5) / 2000


@pytest.mark.parametrize(
    ("one", "oracle"),
    [
        (Uniform(-1.0, 3.0), stats.uniform(-1.0, 4.0)),
        (Normal(2.0, 0.5), stats.norm(2.0, 0.5)),
        (Truncated(2.0, 0.5, 1.8, 2.9), stats.truncnorm(-0.4, 1.8, 2.0, 0.5)),
        (Truncated(2.0, 0.5, 4.0, 4.2), stats.truncnorm(4.0, 4.4, 2.0, 0.5)),
        (Truncated(2.0, 0.5, -1.0, 0.0), stats.truncnorm(-6.0, -4.0, 2.0, 0.5)),
        (of_tolerance(0.1, -2e-5, 4e-5), stats.truncnorm(-3, 3, 0.10001, 1e-5)),
        (of_zone("h7", 0.02), stats.truncnorm(-3, 3, 0.0199895, 3.5e-6)),
    ],
)
def test_quantiles_are_those_of_scipy(one: Truncated, oracle: stats.rv_continuous) -> None:
    assert one.quantile(U) == pytest.approx(oracle.ppf(U), rel=1e-8)
    assert one.limits == pytest.approx(oracle.support())


def test_the_clearance_of_a_fit_is_that_of_pairs_of_parts() -> None:
    """Quantiles of half the difference of two truncated normals, against 100 000 pairs: within four standard
    errors, k(n) by the binomial.
    """
    found, rng, count = of_fit("H8/f7", 0.02), np.random.default_rng(3), 100_000
    hole = stats.truncnorm(-3, 3, 16.5e-6, 5.5e-6).rvs(count, random_state=rng)
    shaft = stats.truncnorm(-3, 3, -30.5e-6, 3.5e-6).rvs(count, random_state=rng)
    play = 0.5 * (hole - shaft)
    for u in (0.001, 0.05, 0.5, 0.9, 0.999):
        below = np.mean(play <= found.quantile(u))
        assert below == pytest.approx(u, abs=4 * math.sqrt(u * (1 - u) / count))
    assert found.limits == pytest.approx((10e-6, 37e-6))
    assert found.quantile(0.5) == pytest.approx(23.5e-6, rel=1e-9)
    assert found.without == 0.0


@pytest.mark.parametrize("name", ["H8/f7", "H7/g6", "H11/c11", "H7/k6"])
def test_the_probability_below_a_quantile_is_its_share(name: str) -> None:
    """Quantiles have ten digits, so that probabilities have nine."""
    found, u = of_fit(name, 0.02, cut=True), np.array([1e-4, 0.03, 0.2, 0.5, 0.7, 0.95, 0.9999])
    below = found._cumulative(2.0 * found.quantile(u))
    assert below == pytest.approx(found.without + u * (1.0 - found.without), abs=2e-9)


def test_two_alike_parts_with_little_cut_are_nearly_a_normal_one() -> None:
    """The variance of a difference is the sum of the variances, each (1 - 6 φ(3)/(2 Φ(3) - 1)) σ²; quantiles
    show it.
    """
    found = of_fit("H7/f7", 0.02)
    u = MIDDLES
    kept = 1 - 6 * stats.norm.pdf(3) / (2 * stats.norm.cdf(3) - 1)
    assert np.var(found.quantile(u)) == pytest.approx(0.25 * 2 * kept * 3.5e-6**2, rel=4e-4)
    assert found.quantile(u) + found.quantile(1 - u) == pytest.approx(2 * found.quantile(0.5), rel=1e-8)


def test_a_transition_fit_is_refused_or_cut() -> None:
    with pytest.raises(Fault, match="31 % of the pairs have no clearance") as error:
        of_fit("H7/k6", 0.02)
    assert "-15 to 19 µm" in error.value.value
    found, rng, count = of_fit("H7/k6", 0.02, cut=True), np.random.default_rng(4), 100_000
    hole, shaft = stats.truncnorm(-3, 3, 10.5e-6, 3.5e-6), stats.truncnorm(-3, 3, 8.5e-6, 13e-6 / 6)
    play = 0.5 * (hole.rvs(count, random_state=rng) - shaft.rvs(count, random_state=rng))
    assert found.without == pytest.approx(np.mean(play <= 0), abs=4e-3)
    assert np.mean(found.quantile(MIDDLES)) == pytest.approx(np.mean(play[play > 0]), rel=0.01)
    assert found.quantile(0.5) == pytest.approx(np.median(play[play > 0]), rel=0.02)
    assert np.all(found.quantile(U) > 0)
    for tight in ("H7/p6", "H7/p5"):
        with pytest.raises(Fault, match="interference"):
            of_fit(tight, 0.02, cut=True)


def test_quantiles_of_any_shape_rise() -> None:
    for one in (
        Uniform(0, 1),
        Normal(0, 1),
        of_fit("H11/c11", 0.1),
        of_fit("H8/h4", 0.1),
        of_fit("H4/h8", 0.1),
    ):
        u = np.linspace(0.0005, 0.9995, 300).reshape(3, 100)
        values = one.quantile(u)
        assert values.shape == u.shape
        assert np.all(np.diff(values.ravel()) > 0)
        assert np.all((values >= one.limits[0]) & (values <= one.limits[1]))


def test_values_have_ten_digits() -> None:
    values = Normal(1 / 3, 0.1).quantile(U)
    assert all(float(f"{value:.9e}") == value for value in values)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Uniform(2, 1),
        lambda: Normal(0, 0),
        lambda: Normal(0, math.nan),
        lambda: Truncated(0, 1, 5, 6),
        lambda: of_tolerance(1, 2, 2),
        lambda: of_zone("h7", 2),
    ],
)
def test_what_is_no_distribution_is_refused(wrong: object) -> None:
    with pytest.raises(Fault):
        wrong()  # type: ignore[operator]
