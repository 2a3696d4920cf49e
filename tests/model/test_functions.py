"""InputFunction motions as piecewise polynomials, against the functions they stand for."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from vfife.compiler.runtime.native import compiled
from vfife.compiler.trace.source import Gathered
from vfife.kernels.polynomial import polynomial
from vfife.model.drivers import AngleTable, ConstantSpeed, Harmonic, Ramp, StepTo, Torque
from vfife.model.functions import motion_function, turning_speed
from vfife.model.geometry.polynomials import Polynomials, sine, spline


def clamped(places, values):
    """The spline through the points, constant beyond its ends."""
    inside = spline(places, values)
    starts = (places[0] - 1.0, *inside.starts, places[-1])
    return Polynomials(starts, ((values[0],), *inside.coefficients, (values[-1],)))


def test_many_times_at_once_are_those_of_one():
    """Before the first piece, after the last, and over periods."""
    t = np.linspace(-0.3, 1.7, 97)
    for function in (
        StepTo(travel=0.3, duration=0.2, begin=0.1).motion(0.7),
        sine(0.3, 2.0, 0.4, 0.1),
        clamped((0.0, 0.3, 0.7), (1.0, 2.0, 0.0)),
    ):
        assert (function.sampled(t) == np.array([function(one) for one in t])).all()
    assert clamped((0.0, 0.3, 0.7), (1.0, 2.0, 0.0)).kinks == (0.0, 0.7)
    assert sine(0.3, 2.0, 0.4).kinks == ()


@pytest.mark.parametrize("phase", [0.0, 0.7, -2.0])
@pytest.mark.parametrize("frequency", [0.3, 50.0])
def test_harmonic(phase, frequency):
    function = motion_function(Harmonic(body="b", amplitude=0.02, frequency=frequency, phase=phase), 0.5)
    w = 2.0 * math.pi * frequency
    times = np.concatenate([np.linspace(-1.5, 4.0, 3000), 1e3 + np.linspace(0.0, 1.0, 50)]) / frequency
    for time in times:
        value, rate, second = function(time)
        late = 1.0 + abs(w * time)  # round-off of the angle itself
        assert value == pytest.approx(
            0.5 + 0.02 * (math.sin(w * time + phase) - math.sin(phase)), abs=1e-15 * late
        )
        assert rate == pytest.approx(0.02 * w * math.cos(w * time + phase), abs=0.02 * w * 1e-12 * late)
        assert second == pytest.approx(
            -0.02 * w * w * math.sin(w * time + phase), abs=0.02 * w * w * 2e-11 * late
        )
    assert function(0.0)[0] == 0.5
    assert function.table()[0] < 0.0


def test_harmonic_is_smooth_where_pieces_meet():
    function = motion_function(Harmonic(body="b", amplitude=1.0, frequency=1.0 / (2.0 * math.pi)))
    for start in (*function.starts, function.period):
        before, after = function(start - 1e-13), function(start + 1e-13)
        assert before == pytest.approx(after, abs=2e-11)


def test_a_step_is_the_fifth_order_polynomial_and_rests_else():
    driver = StepTo(body="b", travel=-0.3, duration=0.4, begin=0.1)
    function = motion_function(driver, 2.0)
    for time in np.linspace(-1.0, 1.0, 401):
        s = min(max((time - 0.1) / 0.4, 0.0), 1.0)
        assert function(time)[0] == pytest.approx(2.0 - 0.3 * (10 * s**3 - 15 * s**4 + 6 * s**5), abs=1e-14)
        assert function(time)[2] == pytest.approx(-0.3 * (60 * s - 180 * s**2 + 120 * s**3) / 0.16, abs=1e-11)
    assert max(abs(function(time)[1]) for time in np.linspace(0.0, 0.6, 601)) == pytest.approx(
        driver.largest_speed, rel=1e-9
    )


def test_a_torque_keeps_its_end_values():
    speeds, values = (-3.0, 0.0, 2.0, 5.0), (9.0, 7.0, 4.0, -1.0)
    function = Torque(body="b", value=values, speeds=speeds, interpolation="spline").effort()
    fit = CubicSpline(speeds, values, bc_type="natural")
    for x in np.linspace(-9.0, 9.0, 181):
        assert function(x)[0] == pytest.approx(float(fit(min(max(x, -3.0), 5.0))), abs=1e-12)
    assert clamped((0.0, 1.0), (2.0, 4.0))(0.25)[0] == 2.5


def test_periodic_tables_repeat_and_others_do_not():
    saw = Polynomials((0.0, 0.25), ((0.0, 1.0), (0.25, -1.0)), 0.5)
    for time in (0.1, 0.3, -0.4, 7.1, 100.3):
        x = time % 0.5
        assert saw(time)[0] == pytest.approx(x if x < 0.25 else 0.5 - x, abs=1e-13)
    assert Polynomials((0.0, 0.25), ((0.0, 1.0), (0.25, -1.0)))(0.75)[0] == -0.25


def test_kinks_are_counted_where_value_slope_or_curvature_jumps():
    """A saw has two a period, a table that keeps its end values two, a spline, a smooth ramp and a harmonic
    none.
    """
    saw = Polynomials((0.0, 0.25), ((0.0, 1.0), (0.25, -1.0)), 0.5).table()
    assert [polynomial(saw, 0, time)[3] for time in (-0.1, 0.1, 0.3, 0.6, 0.8, 5.1)] == [
        -1.0,
        0.0,
        1.0,
        2.0,
        3.0,
        20.0,
    ]
    held = clamped((0.0, 1.0), (2.0, 4.0)).table()
    assert [polynomial(held, 0, x)[3] for x in (-0.5, 0.5, 1.5)] == [0.0, 1.0, 2.0]
    fit = AngleTable(body="b", times=(0.0, 1.0, 2.0), values=(0.0, 1.0, 0.0))
    for smooth in (
        Harmonic(body="b", amplitude=0.7, frequency=3.3, phase=0.1),
        Ramp(body="b", speed=4.0, duration=0.3),
        fit,
    ):
        table = motion_function(smooth).table()
        assert {polynomial(table, 0, time)[3] for time in np.linspace(0.01, 1.99, 100)} == {0.0}


def test_compiled_as_interpreted():
    gathered = Gathered()
    gathered.add(polynomial)
    asked = (
        "def ask(table, start, time, out):\n    out[0], out[1], out[2], out[3] = polynomial(table, start,"
        " time)\n    return 0\n"
    )
    ask, out = compiled(f"{gathered.text()}\n\n{asked}", "ask", "f1 i d f1"), np.zeros(4)
    functions = [
        motion_function(Harmonic(body="b", amplitude=0.7, frequency=3.3, phase=0.1), 0.2),
        motion_function(Ramp(body="b", speed=4.0, duration=0.3)),
        motion_function(StepTo(body="b", travel=1.0, duration=0.3)),
    ]
    for function in functions:
        table = np.concatenate([[7.0, 7.0], function.table()])
        for time in np.random.default_rng(2).uniform(-2.0, 50.0, 300):
            ask(table, 2, time, out)
            assert tuple(out) == polynomial(table, 2, time)


def test_only_turning_drivers_make_turns():
    assert turning_speed(ConstantSpeed(body="b", speed=-3.0)) == 3.0
    assert turning_speed(ConstantSpeed(slider="s", speed=-3.0)) == 0.0
    assert turning_speed(Harmonic(body="b", amplitude=1.0, frequency=1.0)) == 0.0
    assert Harmonic(body="b", amplitude=0.5, frequency=2.0).largest_speed == pytest.approx(2.0 * math.pi)
    assert AngleTable(body="b", times=(0.0, 2.0), values=(0.0, 5.0)).largest_speed == 2.5
    with pytest.raises(TypeError, match="Torque prescribes no motion"):
        motion_function(Torque(body="b", value=1.0))
