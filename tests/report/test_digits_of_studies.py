"""Digits of the tables of studies: cases that differ are printed as different, and no digit is finer than the
error.
"""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from vfife.numerics.outward import DOWN, NEAREST, UP
from vfife.report.amounts import (
    Digits,
    limit_digits,
    limit_quantity,
    quantities,
    quantity,
    quantity_of_digits,
)
from vfife.report.searches import allocation
from vfife.report.study import spread_digits
from vfife.studies.methods.tolerance import Spread
from vfife.studies.spec.limits import Bound, Estimate


@pytest.mark.parametrize(
    ("values", "unit", "error", "texts"),
    [
        ((0.239_71, 0.239_83, 0.239_88), "m", 0.0, ("239.71 mm", "239.83 mm", "239.88 mm")),
        ((0.239_71, 0.239_83, 0.239_88), "m", 6e-5, ("239.71 mm", "239.83 mm", "239.88 mm")),
        ((0.239_71, 0.239_83, 0.239_88), "m", 2e-4, ("239.7 mm", "239.8 mm", "239.9 mm")),
        ((1234.5, 1984.1), "N", 30.0, ("1.23 kN", "1.98 kN")),
        ((41_234.0, 49_876.0), "rad/s^2", 1500.0, ("41000 rad/s²", "50000 rad/s²")),
        ((348.7, 212.3), "N", 150.0, ("350 N", "210 N")),
        ((12.0, 45.0), "1", 0.0, ("12", "45")),
        ((2.0, 2.0), "N", 0.0, ("2 N", "2 N")),
    ],
)
def test_numbers_have_the_digits_that_are_known(
    values: tuple[float, ...], unit: str, error: float, texts: tuple[str, ...]
) -> None:
    digits = Digits(max(values) - min(values), error)
    assert tuple(quantity_of_digits(value, unit, digits) for value in values) == texts


def test_the_usual_four_digits_hide_what_differs() -> None:
    pair = [quantity_of_digits(value, "m", Digits()) for value in (0.239_71, 0.239_74)]
    assert pair == ["239.7 mm"] * 2
    differing = [quantity_of_digits(value, "m", Digits(3e-5)) for value in (0.239_71, 0.239_74)]
    assert differing == ["239.71 mm", "239.74 mm"]


def test_speeds_of_knocks_have_prefixes_and_four_digits() -> None:
    """As in the answer of a run, which has mm/s."""
    assert quantity(0.118_423, "m/s") == "118.4 mm/s"
    assert quantities(0.056716, 0.36972, "m/s") == "56.71 to 369.8 mm/s"


DIGITS_BY_LIMIT = [  # limit (SI), another value, unit, how both are printed
    (0.11579, 0.1157897, "m", ("115.79 mm", "115.7897 mm")),
    (0.11575, 0.11577, "m", ("115.75 mm", "115.77 mm")),
    (0.00079, 0.0007856, "m", ("790 µm", "785.6 µm")),
    (2600.0, 2363.6, "N", ("2.6 kN", "2.364 kN")),
    (2600.0, 2599.93, "N", ("2.6 kN", "2.59993 kN")),
    (0.04, 0.05155, "m/s", ("40 mm/s", "51.55 mm/s")),
    (2.50321, 2.5032, "rad", ("2.50321 rad", "2.5032 rad")),
]


@pytest.mark.parametrize(("limit", "value", "unit", "texts"), DIGITS_BY_LIMIT)
def test_a_limit_keeps_its_digits_and_differs_from_a_value(limit, value, unit, texts) -> None:
    digits = limit_digits(limit, [value])
    assert tuple(limit_quantity(number, unit, digits) for number in (limit, value)) == texts


def test_digits_beside_a_limit_do_not_depend_on_the_zero() -> None:
    for zero in (0.0, 0.1, 0.3):
        limit, value = zero + 0.00079, zero + 0.00078564
        digits = limit_digits(limit, [value, zero + 0.0007], written=False)
        text = limit_quantity(value, "m", digits).split()
        assert float(text[0]) * {"mm": 1e-3, "µm": 1e-6}[text[1]] == pytest.approx(value, abs=1e-7)


def test_numbers_of_all_machines_differ_from_the_limit() -> None:
    at = Estimate(0.1157897, 0.1157886, 0.1157931)
    spread = Spread(
        "guide.position.high", "m", 60, 60, 0.1157701, 7e-6, {0.95: at},
        Bound("guide.position.high", high=0.11579), None, at, None,
    )  # fmt: skip
    digits = spread_digits(spread)
    ways = zip((at.value, at.low, at.high), (NEAREST, DOWN, UP), strict=True)
    texts = [limit_quantity(value, "m", digits, way) for value, way in ways]
    assert texts == ["115.7897 mm", "115.7886 mm", "115.7931 mm"]
    assert "0.11579 m" in spread.bound.words("m")


def test_an_allocation_shows_the_quantile_and_the_limit_as_different() -> None:
    name = "guide.position.high"
    table = SimpleNamespace(measure=name, share=0.95, confidence=0.95)
    task = SimpleNamespace(table=table, bound=Bound(name, high=0.11579), parameters=(), chosen=())
    request = {"wanted": {"last": 1}, "raw": {"method": "search"}}
    answer = SimpleNamespace(
        study=SimpleNamespace(
            path="a.study", measures={name: "m"}, request=request, outcomes={}, errors={}, sensitive=(0, 0),
            has_former_measures=False, done=(), repeats={},
        ),
        task=task, fits={}, cost=9.0,
        choice=SimpleNamespace(options=(), cost=9.0), failures=0, machines=59, rejected=(),
        quantile=Estimate(0.1157856, 0.1157, 0.1158),
    )  # fmt: skip
    text = next(part.text for part in allocation(answer).parts if "quantile" in getattr(part, "text", ""))
    assert "95 % quantile of guide.position.high: 115.7856 mm, limit 115.79 mm;" in text
