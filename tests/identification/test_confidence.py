"""Correlation of residuals and what it does to errors, in closed form."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vfife.identification.curve_sensitivity import CurveSensitivity
from vfife.identification.other_minima import Search, dispute_words, excess_of, other_minima
from vfife.identification.parameters import FitParameter
from vfife.identification.run_length import outputs_of
from vfife.identification.step_uncertainty import autocorrelation, cautions, confidence_of


def test_the_autocorrelation_of_a_line_is_known() -> None:
    """1 to 5 about 3: products of neighbours 2 + 0 + 0 + 2 over squares 4 + 1 + 0 + 1 + 4;
    whatever the size.
    """
    for size in (1.0, 1e-6, 1e6):
        assert autocorrelation([size * np.arange(1.0, 6.0)]) == pytest.approx(0.4, rel=1e-12)


def test_it_is_the_mean_of_the_curves_and_never_below_zero() -> None:
    line, turning, still = np.arange(1.0, 6.0), np.array([1.0, -1.0, 1.0, -1.0]), np.full(4, 3.0)
    assert autocorrelation([line, still]) == pytest.approx(0.2, rel=1e-12)
    assert autocorrelation([turning]) == 0.0 == autocorrelation([still])
    assert autocorrelation([line, turning]) == 0.0, "0.4 and -3/4"
    assert autocorrelation([np.arange(1e4)]) == 0.99


def test_errors_grow_with_what_residuals_follow_each_other() -> None:
    """A mean of n values with the deviation s: s/sqrt(n), times sqrt((1 + r)/(1 - r)) =
    sqrt(7/3) at r = 0.4.
    """
    left = np.arange(1.0, 6.0) - 3.0
    found = confidence_of(
        [left], [FitParameter("a", ("a",), "kg", 0.0, 1.0)], np.array([0.5]), np.ones((5, 1)), 1, 0.95
    )
    s = math.sqrt(10.0 / 4.0)
    assert found.errors[0] == pytest.approx(s / math.sqrt(5.0) * math.sqrt(7.0 / 3.0), rel=1e-12)
    assert found.variance == pytest.approx(
        10.0 / 4.0 * 7.0 / 3.0, rel=1e-12
    ) and found.autocorrelation == pytest.approx(0.4)
    low, high = found.limits[0]
    assert (high - low) / 2.0 == pytest.approx(2.7764451 * found.errors[0], rel=1e-7), (
        "Student's t of 4 degrees of freedom at 95 %"
    )


@pytest.mark.parametrize(
    ("change", "residual", "trusted"),
    [
        (0.05, 0.02, True),
        (0.07, 0.02, False),
        (0.09, 0.005, True),
        (0.11, 0.02, False),
        (0.3, 0.8, True),
        (0.45, 0.8, False),
        (0.4, 0.94, False),
        (0.09, 1.2, False),
    ],
)
def test_curves_are_trusted_while_they_change_by_less_than_noise_and_than_what_they_explain(
    change: float, residual: float, trusted: bool
) -> None:
    """A residual of 0.94 leaves 0.34 of the data explained: curves that change by 0.4 explain nothing."""
    nothing = np.zeros(1)
    assert CurveSensitivity(change, 0.0, residual, 1.0, 1.0, nothing).trusted is trusted
    assert CurveSensitivity(0.0, change, residual, 1.0, 1.0, nothing).trusted is trusted


@pytest.mark.parametrize("comparison", ["curve", "envelope", "spectrum"])
def test_only_a_comparison_of_curves_is_advised_to_take_envelopes_or_spectra(comparison: str) -> None:
    records = [SimpleNamespace(misfit=SimpleNamespace(comparison=comparison))]
    evaluations: Any = SimpleNamespace(share=0.1, points=[(1.0, (0.5,))], records=records)
    (text,) = cautions(evaluations, 0.0, CurveSensitivity(1.2, 0.0, 0.1, 1.0, 9.0, np.zeros(1)))
    assert "confidence is not known" in text and "measure fewer turns from a known start" in text
    assert ("compare envelopes or spectra" in text) is (comparison == "curve")


def test_limits_hold_where_residuals_are_largest_at_the_samples_that_count() -> None:
    """A slope from 200 samples, ten of which determine it and are ten times as noisy: limits of the mean
    square would contain it in 60 % of the draws.
    """
    source, held = np.random.default_rng(5), []
    places = np.where(np.arange(200) % 20 == 0, 10.0, 1.0)
    for _ in range(300):
        noise = places * source.standard_normal(200)
        error = float(noise @ places / (places @ places))
        found = confidence_of(
            [noise - error * places], [FitParameter("a", ("a",), "kg", 0.0, 1.0)], np.array([0.5]),
            places[:, None], 1, 0.95,
        )  # fmt: skip
        low, high = found.limits[0]
        held.append(low <= 0.5 - error <= high)
    assert 0.85 < np.mean(held) < 0.98


def excess(residuals: np.ndarray, data: np.ndarray, comparison: str = "curve") -> str:
    """What makes the residuals of one curve, in deviations of the data, more than noise."""
    curve = SimpleNamespace(channel="D.force")
    misfit = SimpleNamespace(
        comparison=comparison, columns=lambda values: values[:, None], data=data[:, None],
        weights=np.array([1.0 / data.std()]), measured=SimpleNamespace(curves=[curve]),
    )  # fmt: skip
    record: Any = SimpleNamespace(misfit=misfit, name="")
    outcome: Any = SimpleNamespace(fitted=[SimpleNamespace(residuals=residuals)])
    return excess_of([record], outcome)


def test_residuals_below_five_percent_are_more_than_noise_where_impacts_stand_out() -> None:
    """2 % noise over four turns of a curve; a strike that comes late adds to few samples of each turn, and
    leaves 3 % in all.
    """
    source, phase = np.random.default_rng(7), np.linspace(0.0, 8.0 * math.pi, 600)
    noise = 0.02 * source.standard_normal(600)
    data = np.sin(phase) + 0.02 * np.sin(phase).std() * source.standard_normal(600)
    late = np.where(np.arange(600) % 60 == 0, 0.15, 0.0)
    assert excess(noise, data) == ""
    assert 0.025 < (noise + late).std() < 0.04
    assert "times what most samples leave" in excess(noise + late, data)
    assert "misses 1 of 600 samples" in excess(noise + np.where(np.arange(600) == 9, 0.2, 0.0), data)
    assert "times the noise of its samples" in excess(2.5 * noise, data), "a model that is wrong everywhere"
    assert excess(noise + late, data, "envelope") == ""


def test_outputs_between_samples_are_as_dense_as_steps_allow() -> None:
    assert outputs_of(209, 368_000) == 16 * 209
    assert outputs_of(209, 8_000) == 1_000, "eight steps an output"
    assert outputs_of(209, 900) == 4 * 209
    assert outputs_of(1_000, 1e6) == 8_000 and outputs_of(4_000, 1e6) == 16_000


@pytest.mark.parametrize(("correlation", "disputed"), [(0.0, False), (0.1, False), (0.2, True), (-0.2, True)])
def test_a_dispute_spreads_to_what_it_moves_out_of_its_limits(correlation: float, disputed: bool) -> None:
    """A search ended eight half widths from the best value of a; b moves by the correlation times that."""
    parameters = [FitParameter(name, (name,), "kg", 0.0, 1.0) for name in "ab"]
    search, limits = Search([(1.0, (0.5, 0.5)), (1.2, (0.58, 0.5))]), [(0.49, 0.51), (0.499, 0.501)]
    pairs = np.array([[1.0, correlation], [correlation, 1.0]])
    work = (1.0, np.array([0.5, 0.5])), limits, pairs, False
    assert other_minima(parameters, search, *work).disputed == [True, disputed]
    search.ends.pop()
    assert other_minima(parameters, search, *work).disputed == [False] * 2


@pytest.mark.parametrize(
    ("ends", "is_rough", "confirmed"),
    [
        ([], True, True), ([0.5], True, False), ([0.5], False, True), ([0.5, 0.515], True, True),
        ([0.5, 0.53], True, False),
    ],
)  # fmt: skip
def test_with_contacts_two_searches_have_to_reach_a_point(
    ends: list[float], is_rough: bool, confirmed: bool
) -> None:
    """To within the width of its limits; without an end the fit was interrupted."""
    parameters = [FitParameter("a", ("a",), "kg", 0.0, 10.0)]
    search = Search([(1.0, (end,)) for end in ends])
    best = 1.0, np.array([0.05])
    minima = other_minima(parameters, search, best, [(0.49, 0.51)], np.ones((1, 1)), is_rough)
    assert minima.confirmed is confirmed
    said = any("no two searches" in text for text in dispute_words(parameters, minima, search, 1.0))
    assert said is not confirmed
