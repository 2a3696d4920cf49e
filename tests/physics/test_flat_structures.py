"""Three-hinged arches so flat that a pivot of their equations is small, and none of them vanishes: statics
and motion, by closed forms.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from physics.test_redundant_joints import beam
from support import go, times, with_settings
from vfife.kinematics.initial import ideal_motion
from vfife.measures.forces import joint_force, joint_rows
from vfife.model.mechanism import Mechanism
from vfife.simulation.simulate import simulate
from vfife.solvers.record import Record

HALF, BAR, G = 1.0, 11.0, 9.81  # m, kg, m/s^2
LENGTH, BOB, START = 0.3, 1.0, -1.2  # m, kg, rad: of a uniform rod that hangs at the apex


def arch(rise: float, *, bob: bool = False, spin: float = 0.0) -> Mechanism:
    """Two bars of 1 m span each that meet in a hinge at the apex, under gravity."""
    m = Mechanism("arch", gravity=(0.0, -G))
    m.point("A", 0.0, 0.0)
    m.point("B", 2.0 * HALF, 0.0)
    length, angle = math.hypot(HALF, rise), math.atan2(rise, HALF)
    m.link("left", length=length, mass=BAR, angle=angle)
    m.link("right", length=length, mass=BAR, angle=-angle)
    m.revolute("A", "ground.A", "left.start")
    m.revolute("C", "left.end", "right.start")
    m.revolute("B", "right.end", "ground.B")
    if bob:
        m.link("bob", length=LENGTH, mass=BOB, angle=START)
        m.bodies["bob"] = dataclasses.replace(m.bodies["bob"], velocity=(0.0, 0.0, spin))
        m.revolute("P", "left.end", "bob.start")
    return m


def force(record: Record, joint: str) -> np.ndarray:
    return joint_force(record)[:, list(joint_rows(record)).index(joint)]


@pytest.mark.parametrize("bob", [False, True])
@pytest.mark.parametrize("rise", [0.5, 0.02, 0.002, 2e-4, 2e-5])
def test_the_thrust_of_an_arch_at_rest(rise: float, bob: bool) -> None:
    """W L/(8 h) of the bars, 2697.75 N at a rise of 20 mm, and P L/(4 h) of what hangs at the apex."""
    result = simulate(with_settings(arch(rise, bob=bob), analysis="static"))
    assert result.record.status == "complete"
    thrust = (BAR + bob * BOB) * G * HALF / (2.0 * rise)
    assert force(result.record, "A")[-1] == pytest.approx((thrust, (BAR + 0.5 * bob * BOB) * G), rel=1e-6)
    if rise == 0.02 and not bob:
        assert thrust == pytest.approx(2697.75)


def test_an_arch_that_comes_apart_is_tried_again_with_smaller_iterations() -> None:
    """Two micrometres of rise: the first iterations move the apex by more."""
    result = simulate(with_settings(arch(2e-6), analysis="static"))
    assert result.record.status == "complete"
    assert force(result.record, "A")[-1, 0] == pytest.approx(BAR * G * HALF / 4e-6, rel=1e-4)


@pytest.mark.parametrize("bob", [False, True])
def test_links_in_line_are_told(bob: bool) -> None:
    """No rise: no force along the bars holds anything across them. They gave way by a tenth of a micrometre,
    and 240 kN were told.
    """
    result = simulate(with_settings(arch(0.0, bob=bob), analysis="static"))
    assert result.record.status == "diverged"
    assert "links lie almost on a line" in result.record.message


def test_links_in_line_carry_what_acts_along_them() -> None:
    """Both supports together bear the weight; the hinge would give way, but nothing pushes it."""
    m = dataclasses.replace(arch(0.0), gravity=(G, 0.0))
    result = simulate(with_settings(m, analysis="static"))
    assert result.record.status == "complete"
    assert force(result.record, "A")[-1] - force(result.record, "B")[-1] == pytest.approx(
        (-2.0 * BAR * G, 0.0), abs=1e-6
    )
    assert not result.measures["A.force.max"].unique


@pytest.mark.parametrize(
    ("rise", "bob", "blocked"),
    [(0.0, False, True), (0.0, True, True), (2e-5, False, False), (2e-5, True, False)],
)
def test_what_vanishes_is_told_from_what_is_small(rise: float, bob: bool, blocked: bool) -> None:
    assert ideal_motion(arch(rise, bob=bob)).mobility.blocked == blocked


def test_a_mechanism_that_branches_or_is_redundant_is_not_blocked() -> None:
    """A parallelogram with all links in line goes on in two ways, and on three cranks it just goes on."""
    for mechanism in (beam(2, 20.0, start=0.0), beam(3, 20.0, start=0.0), beam(3, 20.0)):
        mechanism.drivers.clear()
        assert not ideal_motion(mechanism).mobility.blocked


def test_a_beam_on_three_cranks_rests_on_a_spring() -> None:
    """Redundant joints at rest: a torque holds the crank, as virtual work has it."""
    m = dataclasses.replace(beam(3, 20.0), gravity=(0.0, -G))
    m.drivers.clear()
    m.torsional_spring("hold", "ground", "crank1", stiffness=200.0, free_angle=0.7)
    result = simulate(with_settings(m, analysis="static", residual=1e-9))
    assert result.record.status == "complete"
    a = result.record.block("particle_theta")[-1, 3]
    assert 200.0 * (0.7 - a) == pytest.approx((3.0 + 1.5) * G * 0.1 * math.cos(a), rel=1e-6)


def test_what_is_loose_is_told() -> None:
    """A rod with a tail that hangs in nothing, beside an arch that stands."""
    m = arch(0.02)
    m.rigid_body("rod", mass=1.0, inertia=0.1, position=(3.0, 0.0), pins={"end": (0.1, 0.0)})
    m.link("tail", length=0.5, mass=0.2, angle=-0.2)
    m.revolute("T", "rod.end", "tail.start")
    result = simulate(with_settings(m, analysis="static"))
    assert result.record.status == "diverged"
    assert "nothing holds it against the loads. It has 4 free motions" in result.record.message


def thrust(t: np.ndarray, rise: float, spin: float) -> np.ndarray:
    """Horizontal force (N) on the left support's journal while the rod at the apex swings: it swings as about
    a fixed pin.
    """
    swung = solve_ivp(
        lambda _, y: [y[1], -1.5 * G / LENGTH * math.cos(y[0])],
        (0.0, t[-1]),
        [START, spin],
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
        t_eval=t,
    )
    a, w = swung.y
    alpha, r = -1.5 * G / LENGTH * np.cos(a), 0.5 * LENGTH
    px, py = (
        BOB * r * (-np.sin(a) * alpha - np.cos(a) * w**2),
        BOB * (r * (np.cos(a) * alpha - np.sin(a) * w**2) + G),
    )
    slope = math.atan2(rise, HALF)
    return 0.5 * ((BAR * G + py) / math.tan(slope) + px)


@pytest.mark.parametrize("spin", [0.0, 12.0])
@pytest.mark.parametrize(
    ("rise", "step"), [(0.02, "auto"), (0.02, 1e-3), (0.002, "auto"), (0.002, 1e-3), (2e-5, "auto")]
)
def test_a_pendulum_swings_at_the_apex(rise: float, step: float | str, spin: float) -> None:
    """To and fro, or round and round."""
    record = go(arch(rise, bob=True, spin=spin), step, duration=1.0, outputs=50)  # type: ignore[arg-type]
    exact = thrust(times(record), rise, spin)
    error = np.abs(force(record, "A")[1:, 0] - exact[1:]).max()
    assert error < (1e-4 if step == 1e-3 else 2e-5) * np.abs(exact).max()
