"""A journal of 1 kg thrown against its bearing at 1 m/s: published numbers, an independent integration, and
the order of convergence.
"""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from support import go, journal_in_bearing, onsets, order, particle, times, with_settings
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh

STIFFNESS, RESTITUTION, CLEARANCE = 6.6e10, 0.9, 5e-4
# method.md, section 3: contact time (s), depth (m), peak force (N), rebound speed (m/s).
PUBLISHED = (1.5277e-4, 4.9585e-5, 2.3221e4, 0.913177)
NAMES = ("contact time", "depth", "peak", "rebound")
SPEED, SPIN, INERTIA, V0, V1 = 1.0, 50.0, 4e-5, 0.05, 0.5  # of the slanting impact: m/s, rad/s, kg m^2, m/s


@cache
def run(step: float, parts: int = 8):
    m = journal_in_bearing(
        contact=LankaraniNikravesh(restitution=RESTITUTION, stiffness=STIFFNESS),
        friction=Frictionless(),
        clearance=CLEARANCE,
    )
    duration = CLEARANCE + 2.2e-4
    m = with_settings(m, parts=parts)
    return go(m, step, duration=duration, outputs=round(duration / step))


def measured(step: float) -> tuple[float, float, float, float]:
    """Contact time, depth, peak and rebound; before and after the contact the flight is straight and gives
    the instants exactly.
    """
    record = run(step)
    assert onsets(record) == [1]
    depth, speed = record.block("contact_penetration")[:, 0], particle(record, "journal")["u"]
    after = np.flatnonzero((depth[1:] <= 0) & (depth[:-1] > 0))[0] + 1
    parted = times(record)[after] - depth[after] / speed[after]
    peak = math.sqrt(record.block("contact_force_squared_max").max())
    return parted - CLEARANCE, record.block("contact_penetration_max").max(), peak, -speed[-1]


@cache
def independent() -> tuple[float, float, float, float]:
    """The same four numbers of d'' = -K d^1.5 (1 + chi d'), integrated by SciPy."""
    chi = 0.75 * (1 - RESTITUTION**2)

    def force(y):
        return STIFFNESS * np.maximum(y[0], 0.0) ** 1.5 * (1 + chi * y[1])

    def parted(t, y):
        return y[0]

    parted.terminal, parted.direction = True, -1.0
    solved = solve_ivp(
        lambda t, y: [y[1], -force(y)],
        (0, 1),
        [0.0, 1.0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-18,
        events=parted,
        first_step=1e-9,
        max_step=1e-6,
        dense_output=True,
    )
    fine = solved.sol(np.linspace(0, solved.t[-1], 200001))
    return solved.t[-1], fine[0].max(), force(fine).max(), -solved.y[1, -1]


@pytest.mark.parametrize("which", range(4), ids=NAMES)
def test_published_numbers(which):
    assert measured(1e-7)[which] == pytest.approx(PUBLISHED[which], rel=1e-4)


@pytest.mark.parametrize("which", range(4), ids=NAMES)
def test_an_independent_integration(which):
    assert measured(1e-7)[which] == pytest.approx(independent()[which], rel=1e-6)


def test_the_impact_speed_is_located_inside_the_step():
    """1 m/s whatever part of a step the contact begins at, without smaller steps."""
    for step in (1.03e-7, 3.3e-7, 1.7e-6):
        record = run(step, parts=1)
        slowness = record.block("contact_slowness")[:, 0]
        assert slowness[slowness > 0] == pytest.approx(1.0, rel=1e-12)


def test_an_onset_slower_than_the_floor_is_counted_and_held_at_it():
    """0.2 mm/s against a floor of 1 mm/s: damping is that of an impact at the floor, weaker than at the true
    speed.
    """
    m = journal_in_bearing(
        2e-4,
        contact=LankaraniNikravesh(restitution=RESTITUTION, stiffness=STIFFNESS),
        friction=Frictionless(),
        clearance=1e-6,
    )
    record = go(m, 5e-7, duration=7e-3, outputs=700)
    assert onsets(record) == [1] and record.block("contact_grazing")[-1].tolist() == [1.0]
    slowness = record.block("contact_slowness")[:, 0]
    assert slowness[slowness > 0] == pytest.approx(1e3, rel=1e-12)
    chi = 0.75 * (1 - RESTITUTION**2) * 2e-4 / 1e-3
    expected = brentq(
        lambda e: chi * (1 + e) - math.log((1 + chi) / (1 - chi * e)), 0.1, 1.0
    )  # the oracle for the weaker damping
    assert -particle(record, "journal")["u"][-1] / 2e-4 == pytest.approx(expected, rel=1e-4)
    assert run(1e-7).block("contact_grazing")[-1].tolist() == [0.0]


@pytest.mark.parametrize(("landing", "counted"), [(6e-6, 1.0), (2e-5, 0.0)])
def test_a_first_landing_deeper_than_allowed_is_counted(landing, counted):
    """1 m/s in steps of 13 us, taken as they are: the first step in contact lies 7 um deep, whatever the
    depth allowed.
    """
    m = journal_in_bearing(
        contact=LankaraniNikravesh(restitution=RESTITUTION, stiffness=STIFFNESS),
        friction=Frictionless(),
        clearance=CLEARANCE,
        landing_depth=landing,
    )
    record = go(with_settings(m, parts=1), 1.3e-5, duration=39 * 1.3e-5, outputs=39)
    assert onsets(record) == [1]
    assert record.block("contact_deep")[-1, 0] == counted
    assert record.block("contact_deepest")[-1, 0] == pytest.approx(39 * 1.3e-5 - CLEARANCE, rel=1e-9)


def test_modes_are_counted():
    """Eq. 19: a step with penetration after one without is an impact, one after another is continuous
    contact.
    """
    record = run(4e-7, parts=1)
    touching = record.block("contact_penetration")[:, 0] > 0
    impacts = np.concatenate([[0], np.cumsum(touching[1:] & ~touching[:-1])])
    assert (record.block("contact_onsets")[:, 0] == impacts).all()
    assert record.block("contact_duration")[:, 0] == pytest.approx(
        4e-7 * (np.cumsum(touching) - impacts), rel=1e-12
    )
    assert impacts[-1] == 1 and touching.sum() > 300


def test_contact_converges_with_the_second_order():
    """Honestly measured: the contact's length at 2.00, its rebound at 1.9 to 4 (what is left of it is already
    below 1e-7).
    """
    steps = (4e-7, 2e-7, 1e-7, 5e-8)
    errors = [np.abs(np.subtract(measured(step), independent())) for step in steps]
    assert order([e[0] for e in errors]) == pytest.approx([2.0] * 3, abs=0.05)
    assert math.log2(errors[0][3] / errors[-1][3]) / 3 > 1.7


def test_energy_is_lost_in_damping_alone():
    """What the ledger of the joint says is lost is what the journal has lost."""
    record = run(1e-7)
    lost = 0.5 * (1 - particle(record, "journal")["u"][-1] ** 2)
    assert record.block("contact_damping_work")[-1, 0] == pytest.approx(lost, rel=3e-6)
    assert record.block("contact_friction_work")[-1, 0] == 0.0


def test_the_ledger_holds_during_the_contact():
    """Kinetic, elastic and lost energy add up at every step of the impact, not only after it."""
    record, step = run(1e-7), 1e-7
    depth, speed = record.block("contact_penetration")[:, 0], particle(record, "journal")["u"]
    inside = np.flatnonzero(depth > 0)[1:-1]
    elastic = 0.4 * STIFFNESS * depth[inside] ** 2.5
    kinetic = 0.5 * ((speed[inside] + speed[inside - 1]) / 2) ** 2  # at step n; the ledger reaches to n + 1/2
    lost = (
        record.block("contact_damping_work")[inside, 0]
        - 0.5 * step * record.block("contact_damping_power")[inside, 0]
    )
    assert elastic.max() > 0.4 and lost.max() > 0.05
    assert kinetic + elastic + lost == pytest.approx(np.full(len(inside), 0.5), abs=1e-5)


def slanting(moment: str) -> np.ndarray:
    """A turning journal thrown against the wall, the laws as printed, integrated by SciPy to the end of the
    contact: u, v, w.
    """
    chi, radius = 0.75 * (1 - RESTITUTION**2), 0.01 - CLEARANCE

    def motion(t, y):
        e = math.hypot(y[0], y[1])
        depth = max(e - CLEARANCE, 0.0)
        n, t_ = np.array(y[:2]) / e, np.array([-y[1], y[0]]) / e
        arm = {"mid-overlap": radius - depth / 2, "surface": radius, "off": 0.0}[moment]
        rate, slip = n @ y[3:5], t_ @ y[3:5] + arm * y[5]
        normal = max(STIFFNESS * depth**1.5 * (1 + chi * rate / SPEED), 0.0)
        share = min(max((abs(slip) - V0) / (V1 - V0), 0.0), 1.0)
        friction = -math.copysign(0.3 * share * normal, slip)
        force = -normal * n + friction * t_
        return [*y[3:], *force, arm * friction / INERTIA]

    def parted(t, y):
        return math.hypot(y[0], y[1]) - CLEARANCE

    parted.terminal, parted.direction = True, -1.0
    start = [CLEARANCE * (1 + 1e-14), 0.0, 0.0, SPEED, 0.0, SPIN]
    solved = solve_ivp(
        motion,
        (0, 1),
        start,
        method="DOP853",
        rtol=1e-11,
        atol=1e-16,
        events=parted,
        first_step=1e-10,
        max_step=2e-7,
    )
    return solved.y[3:, -1]


@pytest.mark.parametrize("moment", ["mid-overlap", "surface", "off"])
def test_friction_pushes_and_turns(moment):
    """The journal rolls off sideways: its friction passes from sliding into the ramp, with and without
    moments at the surfaces.
    """
    contact, friction = (
        LankaraniNikravesh(restitution=RESTITUTION, stiffness=STIFFNESS),
        Ambrosio(coefficient=0.3, v0=V0, v1=V1),
    )
    m = journal_in_bearing(contact=contact, friction=friction, clearance=CLEARANCE, friction_moment=moment)
    m.bodies["journal"] = replace(m.bodies["journal"], inertia=INERTIA, velocity=(SPEED, 0.0, SPIN))
    record = go(m, 5e-8, duration=CLEARANCE + 1.7e-4, outputs=100)
    p = particle(record, "journal")
    assert onsets(record) == [1] and record.block("contact_penetration")[-1, 0] < 0
    expected = slanting(moment)
    assert [p["u"][-1], p["v"][-1], p["w"][-1]] == pytest.approx(list(expected), rel=1e-5, abs=1e-6)
    assert (abs(expected[1]) > 0.05) == (moment != "off")
