"""Oracles of chaos beside those of the verification suite: published periods, and closed forms against an exact map."""

from __future__ import annotations

import math

import pytest

from vfife.study.maps import bifurcation
from vfife.verification.chaotic import DRIVE, doubling, duffing, exact_hops, steady_part


@pytest.mark.parametrize("drive, said", [(0.29, "period 4"), (0.37, "period 5")])
def test_the_two_wells_have_the_published_periods(drive, said):
    """x'' + 0.3 x' - x + x^3 = d cos 1.2 t: 4 and 5 (Jordan and Smith, Nonlinear Ordinary Differential Equations, 13.3)."""
    m = duffing(drive, 0.3, -1.0, 1.2)
    found = bifurcation(m, DRIVE, drive - 1e-7, drive, count=2, turns=160, dropped=100, series=["block.x"], step=2.0 * math.pi / 1.2 / 300)
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
