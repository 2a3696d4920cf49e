"""Sensitivities against closed forms: Ishigami's function, linear ones, a product."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vfife.errors import VfifeError
from vfife.studies.methods import sensitivity_indices
from vfife.studies.methods.sensitivity_indices import morris_effects, sobol_indices
from vfife.studies.spec.distributions import Normal, Uniform, places, points

pytest.importorskip("SALib")


def test_sobol_indices_of_ishigamis_function() -> None:
    """sin x1 + 7 sin² x2 + 0.1 x3⁴ sin x1 over ±π: variances 1/2 (1 + 0.1 π⁴/5)², 49/8 and, of x1 with x3,
    0.01 π⁸ (1/18 - 1/50).
    """
    x = points([Uniform(-math.pi, math.pi)] * 3, "saltelli", 1024, 3)
    y = np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    alone, second = 0.5 * (1 + 0.1 * math.pi**4 / 5) ** 2, 49 / 8
    together = 0.01 * math.pi**8 * (1 / 18 - 1 / 50)
    whole = alone + second + together
    found, left_out = sobol_indices(["a", "b", "c"], y)
    assert left_out == 0
    assert [one.parameter for one in found] == ["a", "b", "c"]
    assert [one.first for one in found] == pytest.approx([alone / whole, second / whole, 0.0], abs=0.03)
    assert [one.total for one in found] == pytest.approx(
        [(alone + together) / whole, second / whole, together / whole], abs=0.03
    )
    assert all(0 < one.total_margin < 0.2 for one in found)


def test_groups_with_a_case_that_failed_are_left_out() -> None:
    """y = 2 x1 + x2 of standard deviations 1 and 1: indices 0.8 and 0.2, with holes as without."""
    x = points([Normal(0, 1), Normal(5, 1)], "saltelli", 512, 1)
    y = 2 * x[:, 0] + x[:, 1]
    y[[5, 6, 900]] = math.nan
    found, left_out = sobol_indices(["a", "b"], y)
    assert left_out == 2
    assert [one.first for one in found] == pytest.approx([0.8, 0.2], abs=0.03)
    assert [one.total for one in found] == pytest.approx([0.8, 0.2], abs=0.03)


def test_effects_of_a_linear_function_are_its_coefficients() -> None:
    """Over half the range of a uniform number: 3 · 2/2, -4 · 1/2 and 0, without deviation."""
    ranges = [Uniform(0, 2), Uniform(7, 8), Uniform(-1, 1)]
    x, unit = points(ranges, "morris", 10, 2), places("morris", 10, 3, 2)
    found, _ = morris_effects(["a", "b", "c"], unit, 3 * x[:, 0] - 4 * x[:, 1] + 100)
    assert [one.mean for one in found] == pytest.approx([3.0, -2.0, 0.0], abs=1e-7)
    assert [one.size for one in found] == pytest.approx([3.0, 2.0, 0.0], abs=1e-7)
    assert [one.deviation for one in found] == pytest.approx([0.0, 0.0, 0.0], abs=1e-7)


def test_a_curve_has_effects_that_deviate() -> None:
    """(x - 1/2)² over the unit interval: half the range moves it by ±(3/8)² - (1/8)² = ±1/8, as often up as
    down in the mean.
    """
    unit = places("morris", 400, 1, 4)
    found, _ = morris_effects(["a"], unit, (unit[:, 0] - 0.5) ** 2)
    assert found[0].size == pytest.approx(1 / 8)
    assert abs(found[0].mean) < 0.02
    assert found[0].deviation == pytest.approx(1 / 8, rel=0.02)


def test_trajectories_move_every_number_once_and_stay_on_the_grid() -> None:
    unit = places("morris", 50, 6, 9).reshape(50, 7, 6)
    assert set(np.unique(unit)) == {0.125, 0.375, 0.625, 0.875}
    moved = np.diff(unit, axis=1)
    assert np.all(np.sum(moved != 0, axis=1) == 1)
    assert np.all(np.sum(moved != 0, axis=2) == 1)
    assert set(np.abs(moved[moved != 0])) == {0.5}


def test_what_has_no_sensitivity_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(VfifeError, match="only 3 groups of 4"):
        sobol_indices(["a", "b"], np.arange(12.0))
    with pytest.raises(VfifeError, match="2 in every case"):
        sobol_indices(["a", "b"], np.full(64, 2.0))
    monkeypatch.setitem(__import__("sys").modules, "SALib.analyze.morris", None)
    with pytest.raises(VfifeError, match=r"vfife\[sensitivity\]"):
        sensitivity_indices.salib()
