"""Tables as piecewise polynomials, against SciPy's interpolants and what their names promise."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from vfife.model.geometry.polynomials import Polynomials, moved
from vfife.model.geometry.tabulated import closes, extended, full_turns, repeated, table, two_ways

PLACES, VALUES = (0.0, 0.1, 0.3, 0.35, 0.6), (0.0, 2.0, 2.1, 9.0, 0.0)
INTERPOLANTS = {
    "linear": lambda x: np.interp(x, PLACES, VALUES),
    "monotone": PchipInterpolator(PLACES, VALUES),
    "spline": CubicSpline(PLACES, VALUES, bc_type="natural"),
}


@pytest.mark.parametrize("how", INTERPOLANTS)
def test_a_table_is_the_interpolant_and_keeps_its_end_values(how):
    function, x = extended(table(PLACES, VALUES, how)), np.linspace(-0.5, 1.1, 321)
    wanted = np.where((x < 0.0) | (x > 0.6), 0.0, INTERPOLANTS[how](np.clip(x, 0.0, 0.6)))
    assert function.sampled(x)[:, 0] == pytest.approx(wanted, abs=1e-12)
    assert function.kinks == (), "a force with a bend is summed to second order without an event"


def test_a_monotone_table_never_leaves_its_values_and_a_spline_does():
    x = np.linspace(0.0, 0.6, 2001)
    monotone, spline = (
        extended(table(PLACES, VALUES, how)).sampled(x)[:, 0] for how in ("monotone", "spline")
    )
    assert monotone.min() >= 0.0 and monotone.max() <= 9.0 + 1e-12
    assert spline.max() > 9.1 or spline.min() < -0.1
    rising = monotone[x <= 0.35]
    assert (np.diff(rising) >= -1e-12).all(), "it rises where the values do"


@pytest.mark.parametrize("how", INTERPOLANTS)
@pytest.mark.parametrize("begin", [0.0, -7.3, 2.1])
def test_a_repeated_table_is_periodic_wherever_it_begins(how, begin):
    """Its pieces begin in [0, period) as the kernels want, and it meets itself as it does inside."""
    function = repeated(table([begin + p for p in PLACES], VALUES, how, repeated=True))
    assert min(function.starts) == 0.0 and max(function.starts) < function.period == pytest.approx(0.6)
    x = begin + np.linspace(0.0, 0.6, 97)[:-1]
    one = function.sampled(x)[:, 0]
    assert function.sampled(x + 1.2)[:, 0] == pytest.approx(one, abs=1e-10)
    assert one[[0]] == pytest.approx([0.0], abs=1e-12)
    around = np.array([-0.6, 0.0, 0.6])[:, None] + PLACES[:-1]
    places, values = np.append(around.ravel(), 1.2), np.append(np.tile(VALUES[:-1], 3), 0.0)
    if how == "spline":
        wanted = CubicSpline(PLACES, VALUES, bc_type="periodic")(x - begin)
    else:
        wanted = (
            PchipInterpolator(places, values)
            if how == "monotone"
            else lambda at: np.interp(at, places, values)
        )(x - begin)
    assert one == pytest.approx(wanted, abs=1e-11)


def test_a_moved_function_is_the_function_moved():
    wave = Polynomials((0.0, 0.2, 0.5), ((1.0, 2.0, -3.0), (0.5, -1.0), (2.0, 0.0, 0.0, 4.0)), 0.8)
    x = 1e-4 * math.pi + np.linspace(-2.0, 3.0, 411)
    for by in (0.0, 0.3, -0.1, 11.17, 0.8):
        assert moved(wave, by).sampled(x) == pytest.approx(wave.sampled(x - by), abs=1e-9)
    once = extended(table(PLACES, VALUES))
    assert moved(once, 0.25).sampled(x) == pytest.approx(once.sampled(x - 0.25), abs=1e-9)


def test_two_ways_lie_a_gap_apart_with_a_kink_between_them():
    out, back = (1.0, 3.0, 10.0), (1.0, 2.0, 10.0)
    function, gap = two_ways(table((0.1, 0.2, 0.3), out), table((0.1, 0.2, 0.3), back))
    x = np.linspace(-0.5, 1.0, 151)
    for values, by in ((out, 0.0), (back, -gap)):
        wanted = PchipInterpolator((0.1, 0.2, 0.3), values)(np.clip(x, 0.1, 0.3))
        assert function.sampled(x + by)[:, 0] == pytest.approx(wanted, abs=1e-9)
    assert len(function.kinks) == 1 and 1.0 - gap < function.kinks[0] < -0.5


def test_what_closes_and_what_goes_round():
    assert closes((1.0, 5.0, 1.0 + 1e-12)) and not closes((1.0, 5.0, 1.1))
    assert (
        full_turns((0.5, 1.0, 0.5 + 4.0 * math.pi))
        and not full_turns((0.0, 3.0))
        and not full_turns((0.0, 6.0))
    )


def test_a_long_table_is_as_one_through_few_points_of_it():
    """Of 20,000 places, which are looked at once each: a search through all of them for each would take
    minutes.
    """
    places = np.linspace(0.0, 1.0, 20_001)
    function = extended(table(places.tolist(), np.sin(3.0 * places).tolist()))
    assert function(0.37)[0] == pytest.approx(math.sin(1.11), abs=1e-8) and function.kinks == ()
