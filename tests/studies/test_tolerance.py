"""Spreads of samples that are written here: mean, deviation, limits."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from vfife.studies.methods import tolerance
from vfife.studies.spec.limits import Bound


def outcome(value: float) -> dict[str, object]:
    return {"status": "complete", "measures": {"C.force.max": value}}


def spread_of(
    values: list[float], monkeypatch: pytest.MonkeyPatch, bound: Bound | None = None
) -> tolerance.Spread:
    """The spread of one measure over machines with these values."""
    found = SimpleNamespace(measures={"C.force.max": "N"}, path=None, errors={})
    monkeypatch.setattr(tolerance, "check_sample", lambda _: None)
    monkeypatch.setattr(tolerance, "machines", lambda _: ([outcome(one) for one in values], len(values)))
    (one,) = tolerance.spreads(found, () if bound is None else (bound,))  # type: ignore[arg-type]
    return one


def test_the_deviation_is_over_one_less_than_the_machines(monkeypatch: pytest.MonkeyPatch) -> None:
    """1 to n: the sum of squares about the mean is n (n^2 - 1)/12, so the variance of the sample is n (n +
    1)/12.
    """
    for n in (2, 3, 10):
        one = spread_of([float(k) for k in range(1, n + 1)], monkeypatch)
        assert (one.machines, one.count, one.mean) == (n, n, 0.5 * (n + 1))
        assert one.deviation == pytest.approx(math.sqrt(n * (n + 1) / 12), rel=1e-14)


def test_one_value_has_no_deviation_and_none_no_mean(monkeypatch: pytest.MonkeyPatch) -> None:
    one = spread_of([3.0, math.nan], monkeypatch)
    assert (one.machines, one.count, one.mean) == (2, 1, 3.0) and math.isnan(one.deviation)
    none = spread_of([math.nan, math.nan], monkeypatch)
    assert none.count == 0 and math.isnan(none.mean) and math.isnan(none.deviation)
    with pytest.raises(tolerance.VfifeError, match="1 of 1 machines"):
        spread_of([3.0], monkeypatch)


def test_a_machine_on_its_limit_keeps_it_and_one_without_a_value_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one = spread_of([1.0, 2.0, 3.0, math.nan], monkeypatch, Bound("C.force.max", high=2.0))
    assert one.failing is not None and one.failing.value == 0.5
