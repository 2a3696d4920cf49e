"""What bristles solve inside a step: Dahl's, LuGre's and Gonthier's, against their own equations and against
independent integrations.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import odeint, solve_ivp

from support import often, order
from vfife.laws import Dahl, GonthierFriction, LuGre, Pair

PAIR = Pair(0.01, 2e-4, 0.02)
positive = st.floats(1e-3, 1e6)


@settings(deadline=None, max_examples=often(1000))
@given(
    normal=positive, mobility=st.floats(1e-10, 1e-4), free=st.floats(-1.0, 1.0), last=st.floats(-1.0, 1.0),
    before=st.floats(-1.0, 1.0),
    bent=st.floats(-1.5, 1.5).filter(lambda w: w == 0.0 or abs(w) > 1e-200), dt=st.floats(1e-8, 1e-3),
)  # fmt: skip
def test_bristles_solve_their_relation(normal, mobility, free, last, before, bent, dt):
    """The step of the deflection as told, the velocity that the force leaves, and the force at both."""
    mu, s0, s1, s2 = 0.15, 2e4, 20.0, 0.1
    law = LuGre(
        coefficient=mu,
        static_coefficient=mu,
        stribeck_speed=1e-3,
        bristle_stiffness=s0,
        bristle_damping=s1,
        viscous=s2,
    )
    z = bent * mu / s0
    force, (after, v, kept) = law.force(normal, free, mobility, (z, last, before), dt, law.parameters(PAIR))
    y = abs(1.5 * last - 0.5 * before) * dt * s0 / mu
    fade, most = 1 / (1 + y + y * y / 2), max(abs(z), mu / s0)
    told = z * fade + 0.5 * (v + last) * dt * (1 + y / 2) * fade
    assert kept == last
    assert after == pytest.approx(min(max(told, -most), most), rel=0, abs=1e-11 * (abs(told) + mu / s0))
    terms = [s0 * after, s1 * (after - z) / dt, s2 * v]
    size = sum(map(abs, terms)) + mu + s1 * most / dt
    assert force == pytest.approx(-normal * sum(terms), rel=0, abs=1e-13 * normal * size)
    size = abs(free) + abs(last) + mobility * normal * size
    assert free + mobility * force == pytest.approx(v, rel=0, abs=1e-13 * size)


@pytest.mark.parametrize("v", [3e-4, 0.02, 4.0])
def test_bristles_bend_as_they_should_at_constant_velocity(v):
    """z from nothing to steady sliding: second order to the closed solution, never past it, and the right end
    in steps of any size.
    """
    law, g = LuGre(), 0.1 + 0.05 * math.exp(-((v / 1e-3) ** 2))
    p, time, errors = law.parameters(PAIR), g / (1e4 * v), []
    for n in (8, 16, 32, 64):
        memory, worst = (0.0, v, v), 0.0
        for k in range(2 * n):
            _, memory = law.force(500.0, v, 0.0, memory, time / n, p)
            assert memory[0] <= g / 1e4
            worst = max(worst, abs(memory[0] * 1e4 / g + math.expm1(-(k + 1) / n)))
        errors.append(worst)
    assert errors[-1] < 3e-5 and order(errors)[-1] == pytest.approx(2.0, abs=0.1)
    for dt in (time, 1e3 * time, 1e8 * time, 3.0 * time):
        for _ in range(60):
            _, memory = law.force(500.0, v, 0.0, memory, dt, p)
        assert memory[0] == pytest.approx(g / 1e4, rel=1e-12)


@pytest.mark.parametrize(
    "law",
    [Dahl(coefficient=0.2, bristle_stiffness=3e4), LuGre(bristle_stiffness=3e4, bristle_damping=0.0)],
    ids=lambda law: law.name,
)
def test_presliding_is_a_spring(law):
    """Slow and short: force over displacement is the bristles' stiffness times the normal force, and it gives
    back what it took.
    """
    dt, memory, way, work = 1e-4, tuple(0.0 for _ in law.memory), 0.0, 0.0
    for k in range(2000):
        v = 1e-9 * math.cos(math.pi * k / 1000) * math.pi / (1000 * dt)
        force, memory = law.force(700.0, v, 0.0, memory, dt, law.parameters(PAIR))
        way += v * dt
        work -= force * v * dt
        if k == 500:
            assert -force / way == pytest.approx(700.0 * 3e4, rel=5e-3)
    assert abs(work) < 0.05 * 700.0 * 3e4 * 1e-18


def oscillation(law, dt, end=0.2):
    """Deflections under a prescribed to and fro, in steps."""
    memory, found = tuple(0.0 for _ in law.memory), []
    for n in range(1, round(end / dt) + 1):
        force, memory = law.force(
            100.0, 0.01 * math.sin(40.0 * n * dt), 0.0, memory, dt, law.parameters(PAIR)
        )
        found.append((memory[0], force))
    return np.array(found)


@pytest.mark.parametrize(
    "law",
    [
        Dahl(),
        LuGre(),
        LuGre(
            coefficient=0.1,
            static_coefficient=0.3,
            stribeck_speed=0.004,
            bristle_stiffness=5e3,
            bristle_damping=10.0,
            viscous=0.2,
        ),
    ],
    ids=["dahl", "lugre", "lugre steep"],
)
def test_bristles_follow_their_differential_equation(law):
    """SciPy's solution of dz/dt = v - sigma_0 |v| z/g: the deflection converges with the second order."""
    p = [
        getattr(law, name, 0.0)
        for name in ("coefficient", "static_coefficient", "stribeck_speed", "bristle_stiffness")
    ]
    p[1] = max(p[1], p[0])

    def rate(t, z):
        v = 0.01 * math.sin(40.0 * t)
        g = p[0] + (p[1] - p[0]) * math.exp(-((v / p[2]) ** 2)) if p[2] else p[0]
        return v - p[3] * abs(v) * z / g

    exact = solve_ivp(
        rate,
        (0, 0.2),
        [0.0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-18,
        max_step=2e-3,
        t_eval=np.arange(1, 21) * 0.01,
    ).y[0]
    errors = []
    for dt in (1e-4, 5e-5, 2.5e-5):
        every = round(0.01 / dt)
        errors.append(np.abs(oscillation(law, dt)[every - 1 :: every, 0] - exact).max() / np.abs(exact).max())
    assert errors[-1] < 1e-4
    assert order(errors)[-1] == pytest.approx(2.0, abs=0.3)


def pulled(law, dt, end):
    """Positions at steps of 1 kg on a plane (10 N) pulled by a spring of 2 N/m whose end moves at 0.1 m/s,
    central differences.
    """
    p, x, v, memory, places = law.parameters(PAIR), 0.0, 0.0, (0.0, 0.0, 0.0), [0.0]
    for n in range(round(end / dt)):
        half, gain = (0.5 * dt, dt) if n else (0.0, 0.5 * dt)
        push = 2.0 * (0.1 * n * dt - x)
        force, memory = law.force(10.0, v + half * push, half, memory, dt, p)
        v += gain * (push + force)
        x += dt * v
        places.append(x)
    return np.array(places)


@pytest.mark.system("integrates a stiff law with SciPy")
def test_lugre_stick_slip_is_that_of_scipy():
    """The example of the 1995 paper (mass, spring, speed and parameters are its own): four slips in 40 s,
    stiff for SciPy, not for us.
    """
    law, end = (
        LuGre(
            coefficient=0.1,
            static_coefficient=0.15,
            stribeck_speed=1e-3,
            bristle_stiffness=1e4,
            bristle_damping=math.sqrt(1e5) / 10,
            viscous=0.04,
        ),
        40.0,
    )

    def rate(t, y):
        x, v, z = y
        g = 1.0 + 0.5 * math.exp(-((v / 1e-3) ** 2))
        dz = v - 1e5 * abs(v) * z / g
        return [v, 2.0 * (0.1 * t - x) - 1e5 * z - math.sqrt(1e5) * dz - 0.4 * v, dz]

    times = np.linspace(0.0, end, 401)
    exact = odeint(rate, [0.0, 0.0, 0.0], times, tfirst=True, rtol=1e-8, atol=1e-13, mxstep=100_000)[:, 0]
    place = pulled(law, 2e-4, end)[::500]
    slips = (np.diff(exact) > 0.01) & ~np.concatenate([[False], np.diff(exact)[:-1] > 0.01])
    assert slips.sum() >= 3
    assert np.abs(place - exact).max() < 2e-3
    stretch = 0.1 * times - exact
    ours = 0.1 * times - place
    late = times > 15.0
    assert np.ptp(ours[late]) == pytest.approx(np.ptp(stretch[late]), rel=2e-3)


# --------------------------------------------------------------------------------------------------- Gonthier

DWELLING = GonthierFriction(
    coefficient=0.1,
    static_coefficient=0.25,
    stribeck_speed=0.004,
    bristle_stiffness=5e3,
    bristle_damping=10.0,
    viscous=0.2,
    dwell_time=0.02,
)
STIFF = GonthierFriction(
    coefficient=0.1,
    static_coefficient=0.25,
    stribeck_speed=0.004,
    bristle_stiffness=5e5,
    bristle_damping=100.0,
    viscous=0.2,
    dwell_time=0.02,
)


def gonthier(v, z, dwelt):
    """Force per normal force and rates of deflection and dwell, as printed."""
    law = DWELLING
    s = math.exp(-((v / law.stribeck_speed) ** 2))
    rate = s * v + (1 - s) * (
        law.coefficient * math.copysign(1.0, v) / law.bristle_damping
        - law.bristle_stiffness / law.bristle_damping * z
    )
    most = law.coefficient + (law.static_coefficient - law.coefficient) * dwelt
    bristles = min(max(law.bristle_stiffness * z + law.bristle_damping * rate, -most), most)
    tau = law.dwell_time if s >= dwelt else law.bristle_damping / law.bristle_stiffness
    return bristles + law.viscous * v, rate, (s - dwelt) / tau


def test_gonthier_follows_its_differential_equation():
    """A prescribed to and fro through v_S: deflection, dwell and force converge to SciPy's with the first
    order.
    """

    def velocity(t):
        return 0.01 * math.sin(40.0 * t)

    times = np.arange(1, 41) * 0.005
    exact = solve_ivp(
        lambda t, y: gonthier(velocity(t), *y)[1:],
        (0, 0.2),
        [0.0, 0.0],
        rtol=1e-10,
        atol=1e-14,
        max_step=1e-4,
        t_eval=times,
        method="LSODA",
    ).y.T
    forces = np.array([gonthier(velocity(t), *y)[0] for t, y in zip(times, exact, strict=True)])
    errors = []
    for n in (50, 100, 200):
        dt, memory, found = 0.005 / n, (0.0, 0.0), []
        for k in range(1, 40 * n + 1):
            force, memory = DWELLING.force(
                100.0, velocity(k * dt), 0.0, memory, dt, DWELLING.parameters(PAIR)
            )
            if k % n == 0:
                found.append((*memory, -force / 100.0))
        wanted = np.column_stack([exact, forces])
        errors.append((np.abs(np.array(found) - wanted) / np.abs(wanted).max(axis=0)).max())
    assert errors[-1] < 1e-2
    assert order(errors)[-1] == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("rest", [0.0, 0.01, 0.1])
def test_gonthier_breaks_away_the_harder_the_longer_it_stood(rest):
    """The largest force after a rest of so long: mu_c + (mu_s - mu_c)(1 - exp(-rest/tau_dw)), and a little
    for the break-away itself.
    """
    dt, memory, peak, p = 1e-5, (0.0, 0.0), 0.0, STIFF.parameters(PAIR)
    for _ in range(round(rest / dt)):
        _, memory = STIFF.force(100.0, 0.0, 0.0, memory, dt, p)
    for k in range(600):
        v = 0.02 * k / 600
        force, memory = STIFF.force(100.0, v, 0.0, memory, dt, p)
        peak = max(peak, -force / 100.0 - 0.2 * v)
    assert peak == pytest.approx(0.1 - 0.15 * math.expm1(-rest / 0.02), abs=0.01)


def test_gonthier_sticks_and_slips_as_scipy_says():
    """1 kg on a plane pulled by a spring whose end moves: the positions of SciPy's stiff solution, first
    order in the step.
    """
    push, stiff, normal = 0.02, 300.0, 20.0

    def rate(t, y):
        x, v, z, dwelt = y
        force, *rates = gonthier(v, z, dwelt)
        return [v, stiff * (push * t - x) - normal * force, *rates]

    times = np.linspace(0.0, 1.0, 101)
    exact = odeint(rate, [0.0] * 4, times, tfirst=True, rtol=1e-9, atol=1e-12, hmax=1e-3, mxstep=100_000)[
        :, 0
    ]
    errors, p = [], DWELLING.parameters(PAIR)
    for dt in (2e-4, 1e-4, 5e-5):
        x, v, memory, every, places = 0.0, 0.0, (0.0, 0.0), round(0.01 / dt), []
        for n in range(round(1.0 / dt) + 1):
            if n % every == 0:
                places.append(x)
            half, gain = (0.5 * dt, dt) if n else (0.0, 0.5 * dt)
            pull = stiff * (push * n * dt - x)
            force, memory = DWELLING.force(normal, v + half * pull, half, memory, dt, p)
            v += gain * (pull + force)
            x += dt * v
        errors.append(np.abs(np.array(places) - exact).max())
    assert np.diff(exact).max() > 5 * np.median(np.diff(exact))  # it slips
    assert errors[-1] < 1e-4
    assert 0.7 < order(errors)[-1] < 2.5
