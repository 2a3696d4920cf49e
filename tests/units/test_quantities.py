"""Quantities with units: exact factors, dimensions, and what is refused."""

from __future__ import annotations

import contextlib
import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vfife.errors import Fault
from vfife.units import DIMENSIONS, UNITS, dimension_of, ends_of, number, unit_fault

EVERYDAY = [
    ("0.5 mm", "m", 5e-4),
    ("0.2mm", "m", 2e-4),
    ("-3 cm", "m", -0.03),
    ("12 um", "m", 12e-6),
    ("12 µm", "m", 12e-6),  # micro sign
    ("12 μm", "m", 12e-6),  # Greek mu
    ("1 in", "m", 0.0254),
    ("250 g", "kg", 0.25),
    ("20 ms", "s", 0.02),
    ("1 us", "s", 1e-6),
    ("1500 rpm", "rad/s", 50 * math.pi),
    ("180 deg", "rad", math.pi),
    ("30 °", "rad", math.pi / 6),
    ("50 Hz", "1/s", 50.0),
    ("2 kN", "N", 2000.0),
    ("207 GPa", "Pa", 207e9),
    ("-5 N m", "N m", -5.0),
    ("3 kN mm", "N m", 3.0),
    ("12 g cm^2", "kg m^2", 1.2e-6),
    ("5 kg·m²", "kg m^2", 5.0),
    ("5 kg*m**2", "kg m^2", 5.0),
    ("7.8 kg/m", "kg/m", 7.8),
    ("-9.81 m/s^2", "m/s^2", -9.81),
    ("10 mm/s", "m/s", 0.01),
    ("6.6e10 N/m^1.5", "N/m^1.5", 6.6e10),
    ("2 kN/m^1.5", "N/m^1.5", 2000.0),
    ("5 N/(mm s)", "N/m/s", 5000.0),
    ("90 %", "1", 0.9),
    ("0.9", "1", 0.9),
    ("0.15", "m", 0.15),
    ("  2   mm ", "m", 0.002),
]


@pytest.mark.parametrize(("text", "unit", "expected"), EVERYDAY)
def test_everyday_units_are_exact(text: str, unit: str, expected: float) -> None:
    assert number(text, unit) == expected


def test_everyday_units_need_no_pint() -> None:
    code = (
        f"import sys\nfrom vfife.units import number\nfor text, unit, _ in {EVERYDAY!r}: number(text,"
        " unit)\nsys.exit('pint' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], timeout=60, check=False).returncode == 0


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("1 psi", "Pa", 6894.757293168362),
        ("2 lbf", "N", 8.8964432305210),
        ("3 yard", "m", 2.7432),
        ("5 mrad", "rad", 0.005),
        ("1 hour", "s", 3600.0),
        ("4 lbf/yard", "N/m", 4 * 4.4482216152605 / 0.9144),
    ],
)
def test_other_units_come_from_pint(text: str, unit: str, expected: float) -> None:
    assert number(text, unit) == pytest.approx(expected, rel=1e-12)


def test_bare_numbers_are_si() -> None:
    assert number(3, "m") == 3.0
    assert isinstance(number(3, "m"), float)
    assert number(-0.25, "rad/s") == -0.25


def test_a_dimension_can_be_named() -> None:
    assert number("0.5 mm", "length") == 5e-4
    assert number("1500 rpm", "angular velocity") == 50 * math.pi
    with pytest.raises(Fault):
        number("1 s", "length")


def test_both_dimensions_are_named() -> None:
    with pytest.raises(Fault) as caught:
        number("5 kg", "m")
    assert str(caught.value) == '"5 kg": a mass; allowed: a length. For example "0.5 mm".'


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        ("25 Hz", "rad/s", "a frequency"),  # 25 turns or 25 radians a second? Nobody knows
        ("157 rad/s", "1/s", "an angular velocity"),
        ("5 deg", "1", "an angle"),
        ("1 mm^0.5", "m", "mm^0.5"),
        ("5 mn", "m", 'did you mean "min"'),
        ("5 furlongz", "m", "unknown"),
        ("35 gr", "kg", 'did you mean "g"?'),
        ("2 ton", "kg", 'did you mean "t", 1000 kg?'),
        ("3 Mg", "kg", 'did you mean "mg"?'),
        ("0.5 Mm", "m", 'did you mean "mm"?'),
        ("2 kN/Mm", "N/m", 'did you mean "mm"?'),
        ("0.5 mil", "m", 'did you mean "thou"'),
        ("30 grad", "rad", 'did you mean "deg"?'),
        ("5 Ms", "s", 'did you mean "ms"?'),
        ("300 mPa", "Pa", 'did you mean "MPa"?'),
        ("5 degC", "m", "no length, mass, time or angle"),
        ("5 m2", "m^2", "cannot be read"),
        ("5 m^^2", "m", "cannot be read"),
        ("5 m^2^9^9", "m", "cannot be read"),
        ("5 m^999", "m", "cannot be read"),
        ("0,5 mm", "m", "decimal point"),
        ("1.2.3 mm", "m", "cannot be read"),
        ("mm", "m", "does not begin with a number"),
        ("", "m", "does not begin with a number"),
        ("1" * 101, "m", "too long"),
        ("nan", "m", "not a finite number"),
        ("-inf mm", "m", "not a finite number"),
        (math.nan, "m", "not a finite number"),
        (math.inf, "m", "not a finite number"),
        ("1e999 m", "m", "too large"),
        (10**400, "m", "too large"),
        pytest.param(10**5000, "m", "too large", id="thousands of digits"),
        (True, "m", "true or false"),
        ([1.0], "m", "a list"),
        (None, "m", "None"),
        ("__import__('os').getcwd()", "m", "does not begin with a number"),
        ("5 __import__", "m", "cannot be read"),
        ("5 m; import os", "m", "cannot be read"),
        ("5 m\x00", "m", "cannot be read"),
    ],
)
def test_what_is_refused(value: object, unit: str, words: str) -> None:
    with pytest.raises(Fault) as caught:
        number(value, unit)
    assert words in str(caught.value)


def test_errors_carry_value_limit_and_remedy() -> None:
    with pytest.raises(Fault) as caught:
        number("5 kg", "Pa")
    error = caught.value
    assert (error.value, error.what, error.limit, error.remedy) == (
        '"5 kg"',
        "a mass",
        "a pressure",
        'for example "207 GPa"',
    )


@pytest.mark.parametrize(("words", "unit", "example"), DIMENSIONS, ids=[words for words, _, _ in DIMENSIONS])
def test_every_example_is_of_its_dimension(words: str, unit: str, example: str) -> None:
    assert dimension_of(unit)[0] == words
    assert math.isfinite(number(example, unit))


@pytest.mark.parametrize("unit", [unit for unit in UNITS if unit not in ("1", "%", "°", "rpm", "Nm", "rev")])
def test_the_table_agrees_with_pint(unit: str) -> None:
    from vfife.units import _measure, _through_pint

    (exact, rough, pi), exponents = _measure(unit)
    (_, factor, _), same = _through_pint(unit)
    assert exponents == same
    assert float(exact) * rough * math.pi**pi == pytest.approx(factor, rel=1e-14)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_float_survives_its_text(value: float) -> None:
    assert number(repr(value), "m") == value
    assert number(f"{value!r} m", "m") == value


@given(st.text(max_size=40))
def test_no_text_raises_anything_else(text: str) -> None:
    for candidate in (text, f"1 {text}"):
        with contextlib.suppress(Fault):
            assert math.isfinite(number(candidate, "m"))


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["m", "kN", "deg", "lbf", "s^2", "m^1.5", "kg^-3", "(N m)", "GPa^99"]),
            st.sampled_from("* /"),
        ),
        min_size=1,
        max_size=6,
    )
)
def test_no_unit_raises_anything_else(parts: list[tuple[str, str]]) -> None:
    text = "1e300 " + "".join(unit + mark for unit, mark in parts)[:-1]
    with contextlib.suppress(Fault):
        assert math.isfinite(number(text, "m"))


@pytest.mark.parametrize(("text", "ends"), [
    ("0.1..1 mm", ("0.1 mm", "1 mm")),
    ("-1e-3..2.5um", ("-1e-3 um", "2.5um")),
    ("10 um .. 1mm", ("10 um", "1mm")),
    ("0.2..0.3", ("0.2", "0.3")),
    ("2..8 kHz", ("2 kHz", "8 kHz")),
    ("..1 mm", None), ("1 mm", None), ("1 mm..", None), ("", None),
])  # fmt: skip
def test_a_range_names_its_unit_once(text: str, ends: tuple[str, str] | None) -> None:
    found = ends_of(text)
    assert (None if found is None else tuple(one.replace(" ", "") for one in found)) == (
        None if ends is None else tuple(one.replace(" ", "") for one in ends)
    )


def test_the_former_name_works_with_a_warning() -> None:
    with pytest.warns(DeprecationWarning, match="Fault"):
        from vfife.errors import QuantityError  # type: ignore[attr-defined]
    assert QuantityError is Fault


def test_units_that_people_write_and_that_mean_something_else_get_advice() -> None:
    from vfife.errors import Fault
    from vfife.units import number, unit_written

    with pytest.raises(Fault, match="absolute values"):
        number("2 barg", "Pa")
    with pytest.raises(Fault, match='"rpm"'):
        number("3000 U/min", "rad/s")
    assert unit_written([1.0, "1500 rpm"], "rad/s") == "rpm"
    assert unit_written(["5 %", "12"], "m") == ""


@pytest.mark.parametrize(("text", "rpm"), [("3000 1/min", "3000"), ("50 Hz", "3000"), ("0.5 kHz", "30000")])
def test_a_frequency_in_place_of_a_speed_is_answered_with_its_turns(text, rpm):
    with pytest.raises(Fault, match=f'a frequency.*"{rpm} rpm" if turns are meant'):
        number(text, "rad/s")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("35 grain", "kg", 35 * 64.79891e-6),
        ("30 gon", "rad", 30 * math.pi / 200.0),
        ("1 thou", "m", 25.4e-6),
        ("2000 lb", "kg", 907.18474),
        ("20 mPa s", "Pa s", 0.02),
    ],
)
def test_what_is_written_for_a_unit_that_is_easily_mistaken(text: str, unit: str, value: float) -> None:
    assert number(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "size", "remedy"),
    [
        ("1.3", "N", 1174.0, 'write "1.3 kN", or "1.3 N" if that is meant'),
        ("34", "m", 17e-6, 'write "34 um", or "34 m" if that is meant'),
        ("0.034", "m", 17e-6, 'write "0.034 mm", or "0.034 m" if that is meant'),
        ("1.3e13", "N", 1174.0, 'write "1.3e13 N"'),
    ],
)
def test_a_bare_number_far_from_what_it_limits_is_questioned(text, unit, size, remedy) -> None:
    fault = unit_fault("limit", text, unit, size, "the force")
    assert fault is not None and fault.remedy == remedy and f"without a unit are in {unit}" in fault.what


@pytest.mark.parametrize(
    ("text", "unit", "size"),
    [
        ("1.3 N", "N", 1174.0),  # a unit is meant
        (1.3, "N", 1174.0),  # Python's numbers are in SI units
        ("1300", "N", 1174.0),
        ("3.4e-5", "m", 17e-6),
        ("0", "N", 1174.0),
        ("1", "1", 900.0),
        ("1.3", "N", None),
    ],
)
def test_a_number_with_a_unit_or_near_what_it_limits_is_taken(text, unit, size) -> None:
    assert unit_fault("limit", text, unit, size, "the force") is None
