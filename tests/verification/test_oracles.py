"""Oracles of chaos at length: what the quick tests see at one stiffness or step comes nearer with each finer
one.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import vfife
from vfife_validation.verification.chaos import doubled
from vfife_validation.verification.chaotic import (
    DRIVE,
    FREQUENCY,
    OMEGA,
    RADIUS,
    G,
    ball_on_a_table,
    doubling,
    duffing,
    duffing_flow,
    exact_hops,
    rebounding,
    steady_part,
    with_a_stop,
)  # fmt: skip

pytestmark = pytest.mark.verify


def test_duffings_motion_is_that_of_an_integration_of_its_own():
    """Ueda's oscillator over a turn and a half, before chaos makes much of little: second
    order in the step.
    """
    turn = 2.0 * math.pi
    times = np.linspace(0.0, 1.5 * turn, 16)
    exact, _ = duffing_flow(7.5, 0.05, 0.0, 1.0, np.array([1.0, 0.0]), times)
    errors = []
    for steps in (500, 1000):
        result = vfife.simulate(
            duffing(7.5, 0.05, 0.0, 1.0),
            turns=1.5,
            outputs=10,
            step=turn / steps,
            companions=0,
            reference=False,
        )
        errors.append(np.abs(result.series["block.x"].values - exact[:, 0]).max())
    assert errors[1] < 2e-3 and 3.0 < errors[0] / errors[1] < 5.0


def test_uedas_exponent_converges_to_the_published_one():
    """x'' + 0.05 x' + x^3 = 7.5 cos t over 6000 turns: 0.1034 a unit of time (Sprott, Chaos and Time-Series
    Analysis, 2003).
    """
    given = {"turns": 3000, "dropped": 50, "series": ["block.x"], "step": 2.0 * math.pi / 600}
    found = vfife.bifurcation(duffing(7.5, 0.05, 0.0, 1.0), DRIVE, 7.4999, 7.5, count=2, **given)
    assert found.exponents[..., 0].mean() / (2.0 * math.pi) == pytest.approx(0.1034, abs=0.003)


@pytest.mark.parametrize(
    "drive, said",
    [
        (0.20, "period 1"),
        (0.28, "period 2"),
        (0.29, "period 4"),
        (0.37, "period 5"),
        (0.50, "chaotic"),
        (0.65, "period 2"),
    ],
)
def test_the_two_wells_have_the_published_periods(drive, said):
    """x'' + 0.3 x' - x + x^3 = d cos 1.2 t: 1, 2, 4, 5, chaos and 2 (Jordan and Smith, Nonlinear Ordinary
    Differential Equations, 13.3).
    """
    given = {"turns": 400, "dropped": 200, "series": ["block.x"], "step": 2.0 * math.pi / 1.2 / 500}
    found = vfife.bifurcation(duffing(drive, 0.3, -1.0, 1.2), DRIVE, drive - 1e-7, drive, count=2, **given)
    assert found.kinds[0][1] == said


def test_a_ball_on_a_shaking_table_doubles_at_its_closed_form():
    """The stiffer the contact the nearer, 2.5 times with each tenfold stiffness, as the time of contact."""
    away = [
        1.0 - doubled(stiffness, steps) for stiffness, steps in ((1e6, 12000), (1e7, 50000), (1e8, 200000))
    ]
    assert all(1.5 < far / near < 3.5 for far, near in zip(away, away[1:], strict=False))


def test_a_ball_hops_high_and_low_as_the_exact_map_does():
    """Five per cent above, where the table goes up through the middle; the difference goes with the time of
    contact, stiffness^-0.4.
    """
    restitution = 0.5
    acceleration = 1.05 * doubling(restitution)
    hops = exact_hops(
        acceleration, restitution, 300, math.acos(steady_part(restitution) / acceleration), math.pi
    )[-2:]
    unit = G / OMEGA**2
    flown = -hops[:, 0] % (2.0 * math.pi)
    exact = np.sort(unit * (acceleration * np.sin(hops[:, 0]) + hops[:, 1] * flown - 0.5 * flown**2))
    errors = []
    for stiffness, steps in ((1e6, 4000), (1e7, 10000), (1e8, 25000)):
        m = ball_on_a_table(acceleration, restitution, stiffness)
        result = vfife.simulate(
            m, turns=80, outputs=1, step=1.0 / FREQUENCY / steps, companions=0, reference=False
        )
        seen = np.sort(result.series["ball.y"].values[-2:]) - RADIUS
        errors.append(float(np.abs(seen - exact).max()) / unit)
    assert all(2.0 < soft / stiff < 2.7 for soft, stiff in zip(errors, errors[1:], strict=False)), errors
    hard = errors[2] - (errors[1] - errors[2]) / (
        10.0**0.4 - 1.0
    )  # what is left where the contact takes no time
    assert abs(hard) < 0.02


@pytest.mark.parametrize("speed, turns", [(2.3, 1), (4.3, 2)])
def test_a_mass_rebounds_from_its_stop_as_the_closed_form_says(speed, turns):
    """Once in one turn and once in two: what is missing is the time of contact, 2.5 times less of it where it
    is ten times stiffer.
    """
    x, v, _ = rebounding(speed, 0.8, turns)
    errors = []
    for stiffness, steps in ((1e5, 4000), (1e6, 8000), (1e7, 16000)):  # the stiffest needs as many
        m = with_a_stop(1.0, speed, 0.0, 0.8, stiffness, 0.0, (x, v))
        result = vfife.simulate(
            m, turns=60 * turns, outputs=1, step=2.0 * math.pi / speed / steps, companions=0, reference=False
        )
        errors.append(abs(result.series["mass.x"].values[-1] - x))
        assert result.measures["stop.impacts"] == 60
    assert errors[2] < 0.05 * abs(x) + 2e-2
    assert 2.3 < errors[0] / errors[1] < 2.7 and 2.3 < errors[1] / errors[2] < 2.7
