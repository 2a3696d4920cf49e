"""Ranges are shown rounded outwards: what is shown contains the range, and is not much wider."""

import re
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vfife.measures.values import Measured
from vfife.numerics.outward import DOWN, UP, rounded, significant_range
from vfife.plots.style import peak_digits
from vfife.report.amounts import deviations, fixed_point, interval, percent, quantities
from vfife.report.design import rank_range
from vfife.report.design_words import effect_range
from vfife.report.digits import largest_text, range_text, sum_text, turns_text, wide_range
from vfife.report.run_tables import _wear_text as wear_text
from vfife.report.run_tables import force_text, influence_text, mean_text
from vfife.report.sensitivity import _range as comparison_range

PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9, "p": 1e-12}
sizes = st.floats(1e-8, 1e8)
shares = st.floats(1e-4, 0.9)


def ends_of(text: str, unit: str) -> list[float]:
    """The two numbers of a shown range, in the base unit."""
    found = re.findall(rf"([+-]?[\d.,]+(?:e[+-]\d+)?)(?: ([GMkmµn]?){unit}\b)?", text)
    (first, before), (last, behind) = found
    factors = [PREFIXES[one or behind] for one in (before, behind)]
    return [float(n.replace(",", "")) * factor for n, factor in zip((first, last), factors, strict=True)]


@pytest.mark.parametrize("prefix", [True, False])
@given(low=sizes, share=shares, digit=st.sampled_from([0.1, 1.0]))
def test_a_shown_interval_contains_the_range(prefix, low, share, digit):
    high = low * (1.0 + share)
    width = high - low
    first, last = ends_of(interval(low, high, "N", digit * width, prefix=prefix), "N")
    slack = 1e-12 * high  # prefixes of the test itself round
    assert first <= low + slack
    assert last >= high - slack
    if width > 1e-3 * high and (prefix or low > 1e-3):  # else the usual number of digits ends the text before
        assert last - first <= 3.1 * width


@given(low=sizes, share=shares)
def test_significant_digits_and_quantities_contain_the_range(low, share):
    high = low * (1.0 + share)
    for text in (significant_range(low, high, 3), repr(Measured(low, low, high)).split("(")[1]):
        first, last = (float(one) for one in text.rstrip(")").split(" to "))
        assert first <= low
        assert last >= high
    first, last = ends_of(quantities(low, high, "N").replace(" N", " N"), "N")
    assert first <= low * (1.0 + 1e-12)
    assert last >= high * (1.0 - 1e-12)


@given(value=sizes, below=st.floats(0.0, 0.5), above=st.floats(0.001, 3.0))
def test_deviations_contain_the_range(value, below, above):
    low, high = value * (1.0 - below), value * (1.0 + above)
    first, last = (float(one.replace(",", "")) for one in deviations(low, high, value)[:-2].split(" to "))
    assert first <= -100.0 * below + 1e-7
    assert last >= 100.0 * above - 1e-7


def test_ends_that_need_no_rounding_stay():
    assert interval(2.3, 2.5, "N", 0.2) == "2.3 to 2.5 N"
    assert interval(0.0023, 0.0025, "N", 0.0002) == "2.3 to 2.5 mN"
    assert interval(2312.0, 2488.0, "N", 176.0) == "2.3 to 2.5 kN"
    assert interval(2300.1, 2500.1, "N", 200.0) == "2.3 to 2.6 kN"
    assert interval(5.0, 5.0, "N", 0.0) == "5 to 5 N"


def test_both_ends_of_a_range_have_one_unit():
    assert interval(0.9998, 1.001, "m/s", 1e-4) == "0.9998 to 1.001 m/s"
    assert interval(0.0009, 1.23, "N", 0.1) == "0.0009 to 1.3 N"
    assert interval(-1200.0, 0.5, "N", 100.0) == "-1.2 to 0.0005 kN"
    assert interval(0.0, 0.5, "N", 0.1) == "0 to 500 mN"
    assert quantities(4e-6, 1.2e-3, "m") == "0.004 to 1.2 mm"
    assert quantities(0.0, 1.2, "rad/s") == "0 to 1.2 rad/s"
    assert quantities(0.1, 0.2, "1") == "0.1 to 0.2"
    assert quantities(9.999999999999999e-06, 3.7e-5, "m", exact=True) == "10 to 37 µm"


@pytest.mark.parametrize(
    ("low", "high", "unit", "text"),
    [
        (698.0, 2041.0, "N", "0.69 to 2.1 kN"),
        (45.0, 3049.0, "N", "0.045 to 3.1 kN"),
        (12.3, 113.5, "W", "12 to 120 W"),
        (941.0, 1051.0, "N", "0.94 to 1.06 kN"),
        (-8.6, 46.3, "%", "-8.6 to 47 %"),
        (3.0, 3049.0, "N", "0.003 to 3.1 kN"),
    ],
)
def test_a_wide_range_has_two_digits_however_uncertain_it_is(
    low: float, high: float, unit: str, text: str
) -> None:
    """In short and in long answers, which give a digit or two of the width; not of an end that is nothing."""
    width = high - low
    assert interval(low, high, unit, width) == interval(low, high, unit, 0.1 * width) == text


def test_decimals_of_other_ranges():
    assert significant_range(1.0 / 3.0, 2.0 / 3.0, 3) == "0.333 to 0.667"
    assert deviations(99.0, 102.0, 100.0) == "-1.0 to +2.0 %"


def test_rounding_to_tens_and_of_negative_numbers():
    assert rounded(123.0, -1, DOWN) == 120.0
    assert rounded(123.0, -1, UP) == 130.0
    assert rounded(-0.24, 1, UP) == -0.2
    assert str(rounded(-0.04, 1, UP)) == "0.0"
    assert rounded(float("inf"), 1, UP) == float("inf")


@pytest.mark.parametrize(
    ("value", "width", "text"),
    [
        (1841.61, 0.0, "1,842 %"),
        (150.46, 0.0, "150.5 %"),
        (13.204, 0.0, "13.20 %"),
        (1841.61, 30.0, "1,840 %"),
    ],
)
def test_a_percentage_has_four_digits_at_the_most_from_a_hundred_on(
    value: float, width: float, text: str
) -> None:
    assert percent(value, width) == text


@pytest.mark.parametrize(
    ("value", "low", "high", "text"),
    [
        (125.19, 119.1, 130.4, "119 to 131 %"),  # 130 % would lie at its upper end
        (539.0, 525.0, 550.0, "540 %"),
        (13.204, 13.19, 13.22, "13.20 %"),
        (1.246, 1.245, 1.2472, "1.25 %"),  # two decimals are enough
        (48.0, 30.0, 60.0, "30 to 60 %"),
    ],
)
def test_a_change_that_stands_alone_is_not_rounded_to_the_edge_of_its_range(
    value: float, low: float, high: float, text: str
) -> None:
    summary = {
        "lip": {"A.force": value}, "measures": {"A.force.lip": value}, "joints": {}, "not_estimated": [],
        "ranges": {"A.force.lip": {"low": low, "high": high}}, "turns": {},
    }  # fmt: skip
    assert influence_text(summary, "A.force") == text


# ------------------------------------------------------------------------------ every printer of a range

SIZES = [digit * 10.0**power for power in range(-15, 10) for digit in (1.0, 1.681, 9.996)]
WIDTHS = [1e-4, 3.3e-3, 0.09, 0.11, 0.7, 3.0]  # of a range, over its smaller end
USUAL = 1e-3  # last of the four digits that a number has at most, over the number
RANGE = re.compile(r"([+-]?[\d.,]+(?:e[+-]\d+)?) to ([+-]?[\d.,]+(?:e[+-]\d+)?) ?(.*)")


def summary_of(name: str, low: float, high: float) -> dict:
    return {
        "measures": {name: 0.5 * (low + high)}, "turns": {"motion": "not repeating"}, "joints": {},
        "ranges": {name: {"low": low, "high": high, "lowest": low, "highest": high}},
        "not_estimated": [], "trust": {"sensitive": True},
    }  # fmt: skip


def by_summary(name: str, unit: str, text):
    return lambda low, high: (text(summary_of(name, low, high), name, unit), unit)


def by_wear(unit: str):
    return lambda low, high: (wear_text(summary_of("pin.x", 1e-9 * low, 1e-9 * high), "pin.x", unit), unit)


def by_interval(unit: str, digit: float, prefix: bool):
    return lambda low, high: (interval(low, high, unit, digit * (high - low), prefix=prefix), unit)


def by_turns(summary: dict, name: str, unit: str) -> str:
    """Turns differ, and the range of their mean, which is not estimated, says nothing."""
    return turns_text({**summary, "not_estimated": [name]}, name, unit)


def by_effect(low: float, high: float) -> tuple[str, str]:
    design = SimpleNamespace(by_difference=True, unit="rad/s")
    text = effect_range(design, SimpleNamespace(low=low, high=high))
    return text.replace(" rad/s to ", " to "), "rad/s"


def by_effect_in_percent(low: float, high: float) -> tuple[str, str]:
    text = effect_range(SimpleNamespace(by_difference=False), SimpleNamespace(low=low, high=high))
    return text.replace(" % to ", " to "), "%"


def by_difference(low: float, high: float) -> tuple[str, str]:
    design = SimpleNamespace(by_difference=True, unit="m")
    return effect_range(design, SimpleNamespace(low=low, high=high)), "m"


PRINTERS = {
    **{
        f"interval {unit} {digit} {prefix}": by_interval(unit, digit, prefix)
        for unit in ("N", "m", "Pa", "W", "mm³", "rad/s²", "1/s", "nm")
        for digit in (0.1, 1.0)
        for prefix in (True, False)
    },
    "wear volume": by_wear("mm³"),
    "wear depth": by_wear("nm"),
    "wide range rad/s²": by_summary("a.x", "rad/s²", wide_range),
    "wide range 1/s": by_summary("a.x", "1/s", wide_range),
    "wide range Pa": by_summary("a.x", "Pa", wide_range),
    "sum W": by_summary("a.x", "W", lambda summary, name, unit: sum_text(summary, [name], unit)),
    "largest m/s": by_summary("a.x", "m/s", lambda summary, name, unit: largest_text(summary, [name], unit)),
    "mean W": by_summary("a.x", "W", lambda summary, name, unit: mean_text(summary, name, unit, 0.0)),
    "force": by_summary("a.x", "N", force_text),
    "measure": lambda low, high: (range_text(summary_of("a.x", low, high), "a.x"), ""),
    "turns": by_summary("a.x", "N m", by_turns),
    "quantities N": lambda low, high: (quantities(low, high, "N"), "N"),
    "quantities m": lambda low, high: (quantities(low, high, "m"), "m"),
    "quantities m^3": lambda low, high: (quantities(low, high, "m^3"), "m^3"),
    "quantities 1/s": lambda low, high: (quantities(low, high, "1/s"), "1/s"),
    "significant": lambda low, high: (significant_range(low, high, 4), ""),
    "effect": by_effect,
    "effect on a position": by_difference,
    "figure": lambda low, high: (peak_digits(Measured(low, low, high), 1.0), ""),
    "laws": lambda low, high: (comparison_range({"f": low, "f.low": low, "f.high": high}, "f", 1.0), ""),
}  # fmt: skip


@pytest.mark.parametrize("printer", PRINTERS)
def test_a_printed_range_contains_the_range_and_is_not_much_wider(printer: str) -> None:
    """Of all sizes, in units with and without prefixes; a printer may have one number for a narrow range,
    which other tests cover.
    """
    printed = 0
    for size in SIZES:
        for share in WIDTHS:
            for low, high in ((size, size * (1.0 + share)), (-size, share * size), (-size, -size / 2.0)):
                text, unit = PRINTERS[printer](low, high)
                if " to " not in text:
                    continue
                printed += 1
                begin, end, prefix = RANGE.fullmatch(text.removesuffix(unit)).groups()
                first, last = (float(one.replace(",", "")) * PREFIXES[prefix] for one in (begin, end))
                largest = max(abs(low), abs(high))
                assert first <= low + 1e-12 * largest, (low, high, text)
                assert last >= high - 1e-12 * largest, (low, high, text)
                assert last - first <= 3.1 * (high - low) + 2.0 * USUAL * largest, (low, high, text)
    assert printed > len(SIZES)


def test_small_ranges_without_prefix_have_powers_of_ten():
    """As single numbers have; an end that is nothing beside the other has the last digit of the width."""
    name = "C.bearing_wear.total"
    summary = summary_of(name, 1.681e-16, 1.9e-16)
    assert wear_text(summary, name, "mm³") == "1.68e-07 to 1.90e-07 mm³"
    assert interval(9.96e-8, 1.2e-7, "mm³", 1e-8, prefix=False) == "9.9e-08 to 1.20e-07 mm³"
    assert interval(0.0, 1e-7, "mm³", 1e-8, prefix=False) == "0 to 1.0e-07 mm³"
    assert interval(-1e-12, 2.0, "mm³", 0.2, prefix=False) == "-0.1 to 2.0 mm³"
    assert interval(1e-12, 2.0, "N", 0.2) == "0 to 2.0 N"
    assert interval(1.7e-7, 1.7e-7, "mm³", 0.0, prefix=False) == "1.700e-07 to 1.700e-07 mm³"


def test_effects_in_percent_and_ranks_are_rounded_outwards():
    assert by_effect_in_percent(0.001, 0.004)[0] == "0.00 to 0.01 %"
    assert by_effect_in_percent(-12.34, 13.31)[0] == "-20 to 20 %"
    assert rank_range(0.123, 0.128) == "+0.12 to +0.13"
    assert rank_range(-0.123, 0.121) == "-0.13 to +0.13"


def test_no_number_is_a_negative_zero():
    assert fixed_point(-0.001, 2) == "0.00"
    assert percent(-0.001) == "0.00 %"
