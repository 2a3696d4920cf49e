"""Maps, exponents and periods against mechanisms of which others know them: Duffing, a ball on a shaking table, a mass that meets a stop."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import vfife
from oracles import DRIVE, at_zero, doubled, doubling, duffing, duffing_multiplier, exact_hops, grazing, steady_part, with_a_stop
from vfife.study.maps import bifurcation

WELLS = (0.3, -1.0, 1.2)  # damping, stiffness and speed of the two wells


def test_uedas_exponent_is_the_published_one():
    """x'' + 0.05 x' + x^3 = 7.5 cos t: 0.100 to 0.103 a unit of time (Sprott, Chaos and Time-Series Analysis, 2003: 0.1034)."""
    found = bifurcation(
        duffing(7.5, 0.05, 0.0, 1.0), DRIVE, 7.499, 7.5, count=2, turns=300, dropped=50, series=["block.x"], step=2.0 * math.pi / 300
    )
    exponents = found.exponents[..., 0] / (2.0 * math.pi)
    assert exponents.mean() == pytest.approx(0.1017, abs=0.006)
    assert all(kind == "chaotic" for way in found.kinds for kind in way)


@pytest.mark.parametrize("drive, said", [(0.29, "period 4"), (0.37, "period 5")])
def test_the_two_wells_have_the_published_periods(drive, said):
    """x'' + 0.3 x' - x + x^3 = d cos 1.2 t: 4 and 5 (Jordan and Smith, Nonlinear Ordinary Differential Equations, 13.3)."""
    m = duffing(drive, *WELLS)
    found = bifurcation(m, DRIVE, drive - 1e-7, drive, count=2, turns=160, dropped=100, series=["block.x"], step=2.0 * math.pi / 1.2 / 300)
    assert found.kinds[0][1] == said


def test_the_two_wells_double_where_an_integration_of_its_own_says():
    """The exponent of the motion of one turn is the logarithm of its multiplier, up to the drive where that is -1."""
    given = {"turns": 60, "dropped": 40, "series": ["block.x"], "step": 2.0 * math.pi / 1.2 / 500}
    drives, start = (0.258, 0.262), np.array([0.4, 0.3])
    exact = []
    for drive in drives:
        start, multiplier = duffing_multiplier(drive, *WELLS, start)
        assert abs(multiplier.imag) < 1e-9 and multiplier.real < 0.0
        exact.append(math.log(-multiplier.real))
    first, _ = duffing_multiplier(drives[0], *WELLS, start)
    found = bifurcation(duffing(drives[0], *WELLS, start=tuple(first)), DRIVE, *drives, count=2, **given)
    assert found.exponents[0, :, 0] == pytest.approx(exact, abs=2e-3)
    assert at_zero(drives, found.exponents[0, :, 0]) == pytest.approx(at_zero(drives, exact), abs=5e-5)


# ------------------------------------------------------------------------------------- ball on a shaking table


@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.8])
def test_the_closed_form_of_the_doubling_is_that_of_the_exact_map(restitution):
    """Just below it a hard ball comes back to one height, just above it goes on high and low."""
    for share, apart in ((0.995, False), (1.005, True)):
        acceleration = share * doubling(restitution)
        phase = math.acos(steady_part(restitution) / acceleration)
        speeds = exact_hops(acceleration, restitution, 400, phase + 1e-3, math.pi)[:, 1]
        assert bool(abs(speeds[-1] - speeds[-2]) > 0.02) is apart
        assert abs(speeds[-1] - speeds[-3]) < 1e-3


def test_a_ball_on_a_shaking_table_doubles_at_its_closed_form():
    """Within the share of a hop that is contact; stiffer contacts come nearer, which the long tests see."""
    assert doubled(1e6, 6000) == pytest.approx(1.0, abs=0.016)
    assert abs(doubled(1e6, 6000, nudge=1.02) - 1.0) > 0.016, "of another restitution it would not be the closed form"


# --------------------------------------------------------------------------------------- a mass and a stop


def test_a_vibration_grazes_its_stop_where_it_is_as_large_as_the_gap():
    """To a ten-thousandth; below it the exponent is that of the free oscillator, -c T/2."""
    speed, damping = 0.8, 0.1
    force, delay = grazing(speed, damping)
    start = math.cos(delay) * 0.9999, speed * math.sin(delay) * 0.9999
    m = with_a_stop(0.9999 * force, speed, 1.0, 0.8, 1e5, damping, start)
    given = {"turns": 30, "dropped": 20, "step": 2.0 * math.pi / speed / 1000}
    found = bifurcation(m, DRIVE, 0.9999 * force, 1.0001 * force, count=2, series=["stop.penetration_max"], **given)
    deepest = found.points["stop.penetration_max"][0].max(axis=1)
    assert deepest[0] == 0.0 and deepest[1] > 0.0
    assert found.exponents[0, 0, 0] == pytest.approx(-0.5 * damping * 2.0 * math.pi / speed, rel=0.02)


def test_beyond_grazing_impacts_are_as_fast_as_the_root_of_how_far():
    """The first impact of a steady vibration: omega sqrt(X^2 - gap^2), Nordmark's root (J. Sound Vib. 145 (1991) 279-297)."""
    speed, damping = 0.8, 0.1
    force, delay = grazing(speed, damping)
    for beyond in (1e-4, 1e-3, 1e-2):
        size = 1.0 + beyond
        m = with_a_stop(size * force, speed, 1.0, 0.8, 1e5, damping, (size * math.cos(delay), size * speed * math.sin(delay)))
        m.joints["stop"] = dataclasses.replace(m.joints["stop"], impact_speed_floor=1e-6)
        result = vfife.simulate(m, turns=0.6, outputs=100, step=2.0 * math.pi / speed / 8000, companions=0, reference=False)
        assert result.measures["stop.approach_speed.max"] == pytest.approx(speed * math.sqrt(size**2 - 1.0), rel=0.01)
