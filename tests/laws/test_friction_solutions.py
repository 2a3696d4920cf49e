"""What a friction law solves inside a step, against its own equation and against independent integrations."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from support import order
from vfife.kernels.elementary import approach, relaxed
from vfife.laws import BrownMcPhee, Coulomb, Dahl, Karnopp, LuGre, Pair, Stribeck

PAIR = Pair(0.01, 2e-4, 0.02)
positive = st.floats(1e-3, 1e6)

# ------------------------------------------------------------------------------------------------------------- elementary


@pytest.mark.parametrize("x", [0.0, 1e-300, 1e-8, 0.3, *np.linspace(0.55, 0.65, 21), 1.0, 7.3, 39.9, 40.0, 1e3, 1e300])
def test_approach(x):
    assert approach(x) == pytest.approx(-math.expm1(-x), rel=1e-14, abs=0)


@settings(deadline=None, max_examples=2000)
@given(st.floats(-0.5, 100.0) | st.floats(1e-12, 1.0), st.floats(1e-9, 1e3))
def test_relaxed_solves_its_equation(beta, share):
    for rho in (share, share * max(abs(beta), 1e-100)):
        y = relaxed(beta, rho)
        assert y >= 0.0 and abs(y - beta * math.expm1(-y) - rho) <= 1e-12 * rho


# ------------------------------------------------------------------------------------------------------------- set-valued


@settings(deadline=None, max_examples=500)
@given(mu=st.floats(1e-6, 2.0) | st.just(0.0), normal=positive, free=st.floats(-5.0, 5.0), mobility=st.floats(1e-9, 1e-2))
def test_coulomb_sticks_or_slides(mu, normal, free, mobility):
    force, _ = Coulomb.force(normal, free, mobility, 0.0, 1e-6, (mu,))
    if abs(free) <= mobility * mu * normal:
        assert free + mobility * force == pytest.approx(0.0, abs=1e-15 * abs(free))
    else:
        assert force == pytest.approx(-math.copysign(mu * normal, free), rel=1e-15, abs=0)


@settings(deadline=None, max_examples=500)
@given(normal=positive, free=st.floats(-0.1, 0.1), mobility=st.floats(1e-9, 1e-3), band=st.floats(0.0, 1e-2))
def test_karnopp_slides_outside_its_band_and_stops_inside(normal, free, mobility, band):
    law = Karnopp(0.2, 0.3, band)
    force, _ = law.force(normal, free, mobility, 0.0, 1e-6, law.parameters(PAIR))
    left = free + mobility * force
    if abs(force) == pytest.approx(0.2 * normal, rel=1e-15) and abs(left) > band * (1 - 1e-12):
        assert force * free < 0.0
    else:
        assert abs(force) <= 0.3 * normal
        assert abs(left) <= 1e-15 * abs(free) or abs(force) == pytest.approx(0.3 * normal, rel=1e-15)


@settings(deadline=None, max_examples=500)
@given(
    normal=positive, free=st.floats(-0.1, 0.1), mobility=st.floats(1e-9, 1e-3), last=st.floats(-0.01, 0.01), before=st.floats(-0.01, 0.01),
    shape=st.floats(0.5, 3.0), viscous=st.floats(0.0, 10.0),
)  # fmt: skip
def test_stribeck_solves_its_relation(normal, free, mobility, last, before, shape, viscous):
    """Static and kinetic part at the extrapolated speed, sign and viscous part at the speed that is left."""
    law = Stribeck(0.1, 0.2, 2e-3, shape, viscous)
    force, (left, kept) = law.force(normal, free, mobility, (last, before), 1e-6, law.parameters(PAIR))
    limit = 0.1 + 0.1 * math.exp(-((abs(1.5 * last - 0.5 * before) / 2e-3) ** shape))
    rest = force / normal + viscous * 0.5 * (last + left)
    assert kept == last
    size = limit + viscous * (abs(last) + abs(left)) + abs(free) / (mobility * normal)
    assert free + mobility * force == pytest.approx(left, rel=0, abs=1e-14 * (abs(free) + mobility * normal * size))
    if left == 0.0:
        assert abs(rest) <= limit + 1e-14 * size
    else:
        assert rest == pytest.approx(-math.copysign(limit, left), rel=0, abs=1e-13 * size)


def block(law, steps, dt, speed, push, normal=9.81, sliding=False):
    """Velocities at half steps of a block of 1 kg on a plane: one mass, kicked as the loop does by a constant push (N)."""
    p, v, memory, speeds = law.parameters(PAIR), speed, tuple(speed if sliding else 0.0 for _ in law.memory), [speed]
    for n in range(steps):
        gain = dt if n else 0.5 * dt
        force, memory = law.force(normal, v + gain * push, gain, memory or 0.0, dt, p)
        memory = memory or ()
        v = v + gain * (push + force)
        speeds.append(v)
    return np.array(speeds)


@pytest.mark.parametrize("law", [Coulomb(0.3), Karnopp(0.2, 0.3, 1e-4), Stribeck(0.2, 0.3)], ids=lambda law: law.name)
def test_block_on_an_incline_stays_to_rounding(law):
    """Below the friction angle: 2e5 steps later it has moved by less than an atom's nucleus."""
    angle = math.atan(0.299)
    speeds = block(law, 200_000, 1e-5, 0.0, 9.81 * math.sin(angle), 9.81 * math.cos(angle))
    assert np.abs(speeds).max() < 1e-18
    assert abs(speeds.sum() * 1e-5) < 1e-18


def test_block_on_an_incline_slides_above_the_friction_angle():
    angle, dt, steps = math.atan(0.301), 1e-5, 20_000
    speeds = block(Coulomb(0.3), steps, dt, 0.0, 9.81 * math.sin(angle), 9.81 * math.cos(angle))
    assert speeds[-1] == pytest.approx((steps - 0.5) * dt * 9.81 * (math.sin(angle) - 0.3 * math.cos(angle)), rel=1e-11)


@pytest.mark.parametrize("law", [Coulomb(0.3), Karnopp(0.3, 0.3, 0.0)], ids=lambda law: law.name)
def test_a_block_that_slides_stops_and_rests(law):
    """After v^2/(2 mu g), to half a step's path, and then at exactly no speed."""
    dt = 1e-6
    speeds = block(law, 400_000, dt, 1.0, 0.0)
    way = dt * speeds[1:].sum()
    assert way == pytest.approx(1.0 / (2 * 0.3 * 9.81), abs=0.5 * dt)
    assert speeds[-1] == 0.0 and (speeds >= 0.0).all()


def test_stribeck_curve_converges_to_its_differential_equation():
    """A block slowed down through the Stribeck curve: second order, while an implicit half-step value would have the first."""
    law = Stribeck(0.1, 0.3, 0.02, 2.0, 0.5)

    def rate(t, v):
        return -9.81 * (0.1 + 0.2 * np.exp(-((v / 0.02) ** 2)) + 0.5 * v)

    exact = solve_ivp(rate, (0, 0.03), [0.05], rtol=1e-13, atol=1e-16).y[0, -1]
    assert 0.0 < exact < 0.02
    errors = []
    for n in (300, 600, 1200, 2400):
        speeds = block(law, n + 1, 0.03 / n, 0.05, 0.0, sliding=True)
        errors.append(abs(0.5 * (speeds[-1] + speeds[-2]) - exact))
    assert errors[-1] < 1e-6
    assert order(errors)[-1] == pytest.approx(2.0, abs=0.4)


# ---------------------------------------------------------------------------------------------------------- Brown, McPhee


@settings(deadline=None, max_examples=1000)
@given(
    normal=positive, mobility=st.floats(1e-9, 1e-3), free=st.floats(1e-9, 1.0) | st.floats(-1e-3, -1e-9), kinetic=st.floats(0.0, 0.5),
    excess=st.floats(0.0, 0.5), speed=st.floats(1e-5, 1.0),
)  # fmt: skip
def test_brown_mcphee_solves_its_relation(normal, mobility, free, kinetic, excess, speed):
    """The force put back, wherever the relation has one solution in a step and is not 1000 times steeper than the body is slow."""
    law = BrownMcPhee(kinetic, kinetic + excess, speed)
    unit = mobility * normal / speed
    force, _ = law.force(normal, free, mobility, 0.0, 1e-6, law.parameters(PAIR))
    assert abs(force) <= normal * (kinetic + excess) * (1 + 1e-14)
    if unit * excess > 2.0 or unit * kinetic > 500.0:
        return
    x = abs(free + mobility * force) / speed

    def left(x):
        return x + unit * (kinetic * math.tanh(4 * x) + excess * x / (x * x / 4 + 0.75) ** 2) - abs(free) / speed

    assert abs(left(x)) <= 1e-10 * abs(free) / speed
    exact = brentq(left, 0.0, abs(free) / speed, xtol=1e-15 * abs(free) / speed, rtol=1e-14)
    assert x == pytest.approx(exact, rel=1e-9, abs=1e-10 * abs(free) / speed)


# ---------------------------------------------------------------------------------------------------------------- bristles


@settings(deadline=None, max_examples=1000)
@given(
    normal=positive, mobility=st.floats(1e-10, 1e-4), free=st.floats(-1.0, 1.0), last=st.floats(-1.0, 1.0),
    bent=st.floats(-1.0, 1.0).filter(lambda w: w == 0.0 or abs(w) > 1e-200), dt=st.floats(1e-8, 1e-3),
)  # fmt: skip
def test_bristles_solve_their_relation(normal, mobility, free, last, bent, dt):
    """The exact step of the deflection at the mean velocity, and the force that causes this velocity."""
    mu, s0, s1, s2 = 0.15, 2e4, 20.0, 0.1
    law = LuGre(mu, mu, 1e-3, s0, s1, s2)
    z = bent * mu / s0
    force, (after, v, kept) = law.force(normal, free, mobility, (z, last, 0.0), dt, law.parameters(PAIR))
    mean = 0.5 * (v + last)
    steady, faded = math.copysign(mu / s0, mean), -math.expm1(-s0 * abs(mean) * dt / mu)
    assert kept == last
    assert after == pytest.approx(z + (steady - z) * faded, rel=0, abs=1e-12 * mu / s0)
    terms = [s0 * after, s1 * (steady - z) * faded / dt, s2 * v]
    assert force == pytest.approx(-normal * sum(terms), rel=0, abs=1e-10 * normal * (mu + sum(map(abs, terms))))
    if mobility * normal * (s0 * dt + s1) < 100.0:
        size = abs(free) + abs(last) + mobility * normal * sum(map(abs, terms))
        assert free + mobility * force == pytest.approx(v, rel=0, abs=1e-11 * size)


@pytest.mark.parametrize("v", [3e-4, 0.02, 4.0])
def test_bristles_take_any_step_at_constant_velocity(v):
    """z from nothing to steady sliding in steps of all sizes: the closed solution of the linear equation."""
    law, t, memory = LuGre(), 0.0, (0.0, v, v)
    g = 0.1 + 0.05 * math.exp(-((v / 1e-3) ** 2))
    for dt in (1e-7, 1e-5, 1e-6, 1e-3, 1e-4, 1e-2):
        _, memory = law.force(500.0, v, 0.0, memory, dt, law.parameters(PAIR))
        t += dt
        assert memory[0] == pytest.approx(g / 1e4 * -math.expm1(-1e4 * v * t / g), rel=1e-12)


@pytest.mark.parametrize("law", [Dahl(0.2, 3e4), LuGre(bristle_stiffness=3e4, bristle_damping=0.0)], ids=lambda law: law.name)
def test_presliding_is_a_spring(law):
    """Slow and short: force over displacement is the bristles' stiffness times the normal force, and it gives back what it took."""
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
        force, memory = law.force(100.0, 0.01 * math.sin(40.0 * n * dt), 0.0, memory, dt, law.parameters(PAIR))
        found.append((memory[0], force))
    return np.array(found)


@pytest.mark.parametrize("law", [Dahl(), LuGre(), LuGre(0.1, 0.3, 0.004, 5e3, 10.0, 0.2)], ids=["dahl", "lugre", "lugre steep"])
def test_bristles_follow_their_differential_equation(law):
    """SciPy's solution of dz/dt = v - sigma_0 |v| z/g: the deflection converges with the second order."""
    p = [getattr(law, name, 0.0) for name in ("coefficient", "static_coefficient", "stribeck_speed", "bristle_stiffness")]
    p[1] = max(p[1], p[0])

    def rate(t, z):
        v = 0.01 * math.sin(40.0 * t)
        g = p[0] + (p[1] - p[0]) * math.exp(-((v / p[2]) ** 2)) if p[2] else p[0]
        return v - p[3] * abs(v) * z / g

    exact = solve_ivp(rate, (0, 0.2), [0.0], rtol=1e-12, atol=1e-18, max_step=2e-4, t_eval=np.arange(1, 21) * 0.01).y[0]
    errors = []
    for dt in (1e-4, 5e-5, 2.5e-5):
        every = round(0.01 / dt)
        errors.append(np.abs(oscillation(law, dt)[every - 1 :: every, 0] - exact).max() / np.abs(exact).max())
    assert errors[-1] < 1e-4
    assert order(errors)[-1] == pytest.approx(2.0, abs=0.3)


def pulled(law, dt, end):
    """Positions at steps of 1 kg on a plane (10 N) pulled by a spring of 2 N/m whose end moves at 0.1 m/s, central differences."""
    p, x, v, memory, places = law.parameters(PAIR), 0.0, 0.0, (0.0, 0.0, 0.0), [0.0]
    for n in range(round(end / dt)):
        half, gain = (0.5 * dt, dt) if n else (0.0, 0.5 * dt)
        push = 2.0 * (0.1 * n * dt - x)
        force, memory = law.force(10.0, v + half * push, half, memory, dt, p)
        v += gain * (push + force)
        x += dt * v
        places.append(x)
    return np.array(places)


def test_lugre_stick_slip_is_that_of_scipy():
    """The example of the 1995 paper (mass, spring, speed and parameters are its own): four slips in 40 s, stiff for SciPy, not for us."""
    law, end = LuGre(0.1, 0.15, 1e-3, 1e4, math.sqrt(1e5) / 10, 0.04), 40.0

    def rate(t, y):
        x, v, z = y
        g = 1.0 + 0.5 * math.exp(-((v / 1e-3) ** 2))
        dz = v - 1e5 * abs(v) * z / g
        return [v, 2.0 * (0.1 * t - x) - 1e5 * z - math.sqrt(1e5) * dz - 0.4 * v, dz]

    times = np.linspace(0.0, end, 401)
    exact = solve_ivp(rate, (0, end), [0.0, 0.0, 0.0], method="Radau", rtol=1e-9, atol=1e-13, t_eval=times).y[0]
    errors = []
    for dt in (4e-4, 2e-4):
        ours = pulled(law, dt, end)[:: round(0.1 / dt)]
        errors.append(np.abs(ours - exact).max())
    slips = (np.diff(exact) > 0.01) & ~np.concatenate([[False], np.diff(exact)[:-1] > 0.01])
    assert slips.sum() >= 3
    assert errors[-1] < 2e-3
    stretch = 0.1 * times - exact
    ours = 0.1 * times - pulled(law, 2e-4, end)[::500]
    late = times > 15.0
    assert np.ptp(ours[late]) == pytest.approx(np.ptp(stretch[late]), rel=2e-3)


@pytest.mark.parametrize(("share", "coefficient"), [(0.0, 0.0), (0.99, 0.3), (1.01, 0.2), (50.0, 0.2)])
def test_karnopp_band_ends_at_its_speed(share, coefficient):
    """Nothing moves (mobility 0): static friction inside, kinetic friction outside."""
    law = Karnopp(0.2, 0.3, 1e-3)
    for sign in (1.0, -1.0):
        force, _ = law.force(500.0, sign * share * 1e-3, 0.0, 0.0, 1e-6, law.parameters(PAIR))
        assert force == pytest.approx(-sign * coefficient * 500.0, rel=1e-15)


def test_brown_mcphee_converges_from_flat_to_steep():
    """A grid over all that has one solution: mobility times force up to 500 speeds, from nothing to far beyond the peak."""
    worst = 0.0
    for kinetic in np.geomspace(1e-4, 500.0, 30):
        for peak in {0.0, 0.3 * min(kinetic, 6.0), min(kinetic, 2.0)}:
            law = BrownMcPhee(float(kinetic), float(kinetic + peak), 1.0)
            for rho in [*np.linspace(0.02, 1.6, 80) * (kinetic + peak), *np.geomspace(1e-6, 1e3, 20)]:
                force, _ = law.force(1.0, float(rho), 1.0, 0.0, 1e-6, law.parameters(PAIR))
                x = rho + force
                curve = kinetic * math.tanh(4 * x) + peak * x / (x * x / 4 + 0.75) ** 2
                worst = max(worst, abs(x + curve - rho) / rho)
    assert worst < 1e-10
