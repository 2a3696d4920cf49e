"""Oracles of chaos beside those of the verification suite: published periods, and closed forms against an
exact map.
"""

from __future__ import annotations

import math

import pytest

from vfife.dynamics.bifurcation import bifurcation
from vfife_validation.verification.chaotic import DRIVE, doubling, duffing, exact_hops, steady_part


def test_uedas_exponent_is_the_published_one():
    """x'' + 0.05 x' + x^3 = 7.5 cos t: 0.1034 a unit of time (Sprott, Chaos and Time-Series
    Analysis, 2003).
    """
    given = {"turns": 300, "dropped": 50, "series": ["block.x"], "step": 2.0 * math.pi / 300, "companions": 0}
    found = bifurcation(duffing(7.5, 0.05, 0.0, 1.0), DRIVE, 7.499, 7.5, count=2, **given)
    assert found.exponents[..., 0].mean() / (2.0 * math.pi) == pytest.approx(0.1034, rel=0.05)
    assert all(kind == "chaotic" for way in found.kinds for kind in way)


@pytest.mark.parametrize("drive, said", [(0.29, "period 4"), (0.37, "period 5")])
def test_the_two_wells_have_the_published_periods(drive, said):
    """x'' + 0.3 x' - x + x^3 = d cos 1.2 t: 4 and 5 (Jordan and Smith, Nonlinear Ordinary Differential
    Equations, 13.3).
    """
    m = duffing(drive, 0.3, -1.0, 1.2)
    given = {
        "turns": 160,
        "dropped": 100,
        "series": ["block.x"],
        "step": 2.0 * math.pi / 1.2 / 300,
        "companions": 0,
    }
    found = bifurcation(m, DRIVE, drive - 1e-7, drive, count=2, **given)
    assert found.kinds[0][1] == said


@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.8])
def test_the_closed_form_of_the_doubling_is_that_of_the_exact_map(restitution):
    """Just below it a hard ball comes back to one height, just above it goes on high and low."""
    for share, apart in ((0.995, False), (1.005, True)):
        acceleration = share * doubling(restitution)
        phase = math.acos(steady_part(restitution) / acceleration)
        speeds = exact_hops(acceleration, restitution, 400, phase + 1e-3, math.pi)[:, 1]
        assert bool(abs(speeds[-1] - speeds[-2]) > 0.02) is apart
        assert abs(speeds[-1] - speeds[-3]) < 1e-3
