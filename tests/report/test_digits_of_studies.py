"""Digits of the tables of studies: cases that differ are printed as different, and no digit is finer than the
error.
"""

from __future__ import annotations

import pytest

from vfife.report.amounts import Digits, quantities, quantity, quantity_of_digits


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
