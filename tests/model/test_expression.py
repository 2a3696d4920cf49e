"""Expressions: the grammar against Python's own arithmetic, what is refused, and how far polynomials miss
them.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support import often
from vfife.errors import Fault
from vfife.model.geometry.expression import FUNCTIONS, parse
from vfife.model.geometry.tabulated import ApproximationError, extended, sampled

X = np.array([-1.7, -0.3, 0.2, 0.9, 2.5])
PYTHON = {name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "abs")}
PYTHON |= {"min": np.minimum, "max": np.maximum, "step": lambda a: np.where(a < 0, 0.0, 1.0), "pi": math.pi}


def python(text: str, x: np.ndarray) -> np.ndarray:
    """What Python makes of the text."""
    with np.errstate(all="ignore"):
        return (
            eval(text.replace("^", "**").replace("[kN]", "e3"), {"__builtins__": {}}, PYTHON | {"x": x})
            + 0.0 * x
        )


def atoms():
    """Numbers, the variable, and a function of it."""
    numbers = st.floats(0.01, 9.0).map(lambda value: f"{value:.3g}")
    return (
        numbers
        | st.sampled_from(["x", "pi"])
        | st.sampled_from(sorted(set(FUNCTIONS) - {"min", "max"})).map(lambda name: f"{name}(x)")
    )


def grown(part):
    """Sums, products, powers, signs, parentheses, functions of two."""
    both = st.tuples(part, part).map(lambda two: f"max({two[0]}, {two[1]})")
    pair = st.tuples(part, st.sampled_from([" + ", " - ", "*", "/", "^"]), part).map("".join)
    return pair | part.map(lambda one: f"({one})") | part.map(lambda one: f"-{one}") | both


@settings(max_examples=often(300), deadline=None)
@given(st.recursive(atoms(), grown, max_leaves=12))
def test_it_means_what_python_means(text):
    found, wanted = parse(text)(X), python(text, X)
    wanted = np.where(
        np.isreal(wanted), np.real(wanted), np.nan
    )  # Python goes on with complex numbers: (-1)^0.5
    assert found == pytest.approx(wanted, rel=1e-12, nan_ok=True)


@settings(max_examples=often(400), deadline=None)
@given(st.text("0123456789.+-*/^()[],eE txvanglesiprkNm_$\"'\\\n", max_size=40))
def test_any_text_is_read_or_refused_with_its_place(text):
    try:
        parse(text)
    except Fault as error:
        assert 1 <= int(error.where.removeprefix("column ")) <= len(text) + 1 and error.what and error.remedy


def test_units_and_precedence():
    assert parse("2.5[kN] + 30[N]").constant == 2530.0
    assert parse("90 [deg]").constant == pytest.approx(math.pi / 2)
    assert (
        parse("-2^2").constant == -4.0 and parse("2^3^2").constant == 512.0 and parse("2^-1").constant == 0.5
    )
    assert parse("1[bar]*(0.1/(0.1 + x))^1.4").variable == "x" and parse("3").variable == ""


REFUSED = {
    "2*sine(t)": (3, 'there is no "sine"'), "3 4": (3, "an operator should"),
    "sin(t": (6, "missing at the end"), "t + x": (5, "x and t in one"),
    "2[kQ]": (1, "kQ"), "min(t)": (1, "has 1 argument"), "": (1, "missing at the end"), "t $ 3": (3, '"$"'),
    "sin": (1, "no argument"),
    "3[kN": (1, "not closed"), "2 t": (3, '"t" stands where an operator'), "(" * 90: (42, "parentheses"),
    "-" * 90 + "1": (42, "signs or powers"),
    "2^" * 60 + "1": (83, "signs or powers"), "__import__('os')": (1, "there is no"), "t.real": (2, '"."'),
    "1+" * 600 + "1": (1000, "1201 characters"),
}  # fmt: skip


@pytest.mark.parametrize("text", REFUSED, ids=lambda text: text[:12])
def test_what_is_none_is_refused_where_it_goes_wrong(text):
    with pytest.raises(Fault) as told:
        parse(text)
    assert (told.value.where, REFUSED[text][1] in told.value.what) == (f"column {REFUSED[text][0]}", True), (
        told.value
    )


@pytest.mark.parametrize(
    ("text", "kinks"),
    [
        ("2[kN]*sin(x)^2", ()),
        ("1e5*(0.1/(0.1 + x))^1.4", ()),
        ("max(0, sin(30*x))", ()),
        ("sqrt(x)", ()),
        ("x^3 - x", ()),
        ("abs(x - 0.3)^0.5", ()),
        ("exp(-((x - 0.74)/2e-4)^2)", ()),  # between all places of a piece as long as the range
        ("step(x - 0.1)*exp(-(x - 0.1)/0.05)", (0.1,)),
        ("min(x, 0.4) + 3*step(x - 0.7)", (0.7,)),
        ("7", ()),
    ],
)
def test_pieces_are_right_to_a_billionth_of_the_largest_value(text, kinks):
    function, x = (
        extended(sampled(text, 0.0, 2.0)),
        np.append(np.random.default_rng(3).uniform(0.0, 2.0, 5000), 0.74),
    )
    wanted = python(text, x)
    assert np.abs(function.sampled(x)[:, 0] - wanted).max() <= 3e-9 * np.abs(wanted).max()
    assert function.kinks == pytest.approx(kinks, abs=1e-15), "it leaps there, and nowhere else"
    assert len(function.starts) < 250


@pytest.mark.parametrize("text", ["1/(x - 0.3)", "tan(x)", "log(x)", "sqrt(x - 1)", "sin(1e5*x)", "x/0"])
def test_what_cannot_be_followed_is_told_with_its_place(text):
    with pytest.raises(ApproximationError, match="x ="):
        sampled(text, 0.0, 2.0)


def test_a_power_of_python_and_a_name_that_is_none_are_told_once() -> None:
    with pytest.raises(Fault) as power:
        parse("x**2")
    assert "write ^ for a power" in power.value.remedy
    with pytest.raises(Fault) as name:
        parse("qqq(x)")
    assert name.value.remedy.count("there are") == 1 and "a unit goes in brackets" in name.value.remedy
    with pytest.raises(Fault) as near:
        parse("sqr(x)")
    assert 'did you mean "sqrt"' in near.value.remedy
