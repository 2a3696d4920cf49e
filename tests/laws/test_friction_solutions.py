"""What a law of friction without bristles solves inside a step, against its own equation and against
independent integrations.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from support import often, order
from vfife.kernels.elementary import approach
from vfife.laws import BengisuAkay, BrownMcPhee, Coulomb, Karnopp, Pair, Stribeck, Threlfall

PAIR = Pair(0.01, 2e-4, 0.02)
positive = st.floats(1e-3, 1e6)


# ------------------------------------------------------------------------------------------------- elementary


@pytest.mark.parametrize(
    "x", [0.0, 1e-300, 1e-8, 0.3, *np.linspace(0.55, 0.65, 21), 1.0, 7.3, 39.9, 40.0, 1e3, 1e300]
)
def test_approach(x):
    assert approach(x) == pytest.approx(-math.expm1(-x), rel=1e-14, abs=0)


# ------------------------------------------------------------------------------------------------- set-valued


@settings(deadline=None, max_examples=often(500))
@given(
    mu=st.floats(1e-6, 2.0) | st.just(0.0),
    normal=positive,
    free=st.floats(-5.0, 5.0),
    mobility=st.floats(1e-9, 1e-2),
)
def test_coulomb_sticks_or_slides(mu, normal, free, mobility):
    force, _ = Coulomb.force(normal, free, mobility, 0.0, 1e-6, (mu,))
    if abs(free) <= mobility * mu * normal:
        assert free + mobility * force == pytest.approx(0.0, abs=1e-15 * abs(free))
    else:
        assert force == pytest.approx(-math.copysign(mu * normal, free), rel=1e-15, abs=0)


@settings(deadline=None, max_examples=often(500))
@given(
    normal=positive, free=st.floats(-0.1, 0.1), mobility=st.floats(1e-9, 1e-3), band=st.floats(0.0, 1e-2),
    last=st.just(0.0) | st.floats(-0.1, 0.1), before=st.just(0.0) | st.floats(-0.1, 0.1),
)  # fmt: skip
def test_karnopp_slides_outside_its_band_and_stops_inside(normal, free, mobility, band, last, before):
    """Kinetic friction resists what slid the same way beyond the band for two steps, static friction the
    rest; what either would leave in the band is stopped.
    """
    law = Karnopp(coefficient=0.2, static_coefficient=0.3, band=band)
    force, (kept, shifted) = law.force(normal, free, mobility, (last, before), 1e-6, law.parameters(PAIR))
    left = free + mobility * force
    slid = all(v * free > 0.0 and abs(v) > band for v in (last, before))
    limit = (0.2 if slid else 0.3) * normal
    assert shifted == last
    if abs(free) - mobility * limit > band:
        assert force == pytest.approx(-math.copysign(limit, free), rel=1e-15)
        assert kept == left and abs(left) > band * (1 - 1e-12)
    else:
        assert kept == 0.0 and abs(force) <= 0.3 * normal
        assert abs(left) <= 1e-15 * abs(free) or abs(force) == pytest.approx(0.3 * normal, rel=1e-15)


@settings(deadline=None, max_examples=often(500))
@given(
    normal=positive, free=st.floats(-0.1, 0.1), mobility=st.floats(1e-9, 1e-3), last=st.floats(-0.01, 0.01),
    before=st.floats(-0.01, 0.01),
    shape=st.floats(0.5, 3.0), viscous=st.floats(0.0, 10.0),
)  # fmt: skip
def test_stribeck_solves_its_relation(normal, free, mobility, last, before, shape, viscous):
    """Static and kinetic part at the extrapolated speed, sign and viscous part at the speed that is left;
    static friction for what stopped or turned round.
    """
    law = Stribeck(coefficient=0.1, static_coefficient=0.2, stribeck_speed=2e-3, shape=shape, viscous=viscous)
    force, (left, kept) = law.force(normal, free, mobility, (last, before), 1e-6, law.parameters(PAIR))
    way = math.copysign(1.0, free - mobility * 0.5 * viscous * normal * last)
    ahead = max(way * (1.5 * last - 0.5 * before), 0.0) if way * last > 0.0 else 0.0
    limit = 0.1 + 0.1 * math.exp(-((ahead / 2e-3) ** shape))
    rest = force / normal + viscous * 0.5 * (last + left)
    assert kept == last
    size = limit + viscous * (abs(last) + abs(left)) + abs(free) / (mobility * normal)
    assert free + mobility * force == pytest.approx(
        left, rel=0, abs=1e-14 * (abs(free) + mobility * normal * size)
    )
    if left == 0.0:
        assert abs(rest) <= limit + 1e-14 * size
    else:
        assert rest == pytest.approx(-math.copysign(limit, left), rel=0, abs=1e-13 * size)


def block(law, steps, dt, speed, push, normal=9.81, sliding=False):
    """Velocities at half steps of a block of 1 kg on a plane: one mass, kicked as the loop does by a constant
    push (N).
    """
    p, v, memory, speeds = (
        law.parameters(PAIR),
        speed,
        tuple(speed if sliding else 0.0 for _ in law.memory),
        [speed],
    )
    for n in range(steps):
        gain = dt if n else 0.5 * dt
        force, memory = law.force(normal, v + gain * push, gain, memory or 0.0, dt, p)
        memory = memory or ()
        v = v + gain * (push + force)
        speeds.append(v)
    return np.array(speeds)


@pytest.mark.parametrize(
    "law",
    [
        Coulomb(coefficient=0.3),
        Karnopp(coefficient=0.2, static_coefficient=0.3, band=1e-4),
        Stribeck(coefficient=0.2, static_coefficient=0.3),
    ],
    ids=lambda law: law.name,
)
def test_block_on_an_incline_stays_to_rounding(law):
    """Below the friction angle: 5e4 steps later it has moved by less than an atom's nucleus."""
    angle = math.atan(0.299)
    speeds = block(law, 50_000, 1e-5, 0.0, 9.81 * math.sin(angle), 9.81 * math.cos(angle))
    assert np.abs(speeds).max() < 1e-18
    assert abs(speeds.sum() * 1e-5) < 1e-18


def test_block_on_an_incline_slides_above_the_friction_angle():
    angle, dt, steps = math.atan(0.301), 1e-5, 20_000
    speeds = block(Coulomb(coefficient=0.3), steps, dt, 0.0, 9.81 * math.sin(angle), 9.81 * math.cos(angle))
    assert speeds[-1] == pytest.approx(
        (steps - 0.5) * dt * 9.81 * (math.sin(angle) - 0.3 * math.cos(angle)), rel=1e-11
    )


@pytest.mark.parametrize(
    "law",
    [Coulomb(coefficient=0.3), Karnopp(coefficient=0.3, static_coefficient=0.3, band=0.0)],
    ids=lambda law: law.name,
)
def test_a_block_that_slides_stops_and_rests(law):
    """After v^2/(2 mu g), to half a step's path, and then at exactly no speed."""
    dt = 4e-6
    speeds = block(law, 100_000, dt, 1.0, 0.0)
    way = dt * speeds[1:].sum()
    assert way == pytest.approx(1.0 / (2 * 0.3 * 9.81), abs=0.5 * dt)
    assert speeds[-1] == 0.0 and (speeds >= 0.0).all()


HOLDING = [
    *(Karnopp(coefficient=0.1, static_coefficient=0.15, band=band) for band in (0.0, 1e-9, 1e-4, 1e-3)),
    *(Stribeck(coefficient=0.1, static_coefficient=0.15, stribeck_speed=v) for v in (1e-6, 1e-4, 1e-3)),
]


@pytest.mark.parametrize("law", HOLDING, ids=lambda law: f"{law.name} {law.parameters(PAIR)[2]:.2g}")
@pytest.mark.parametrize("dt", [1e-3, 1e-5])
@pytest.mark.parametrize("start", [0.0, 0.1, 0.10173])
def test_static_friction_holds_for_any_band_and_step(law, dt, start):
    """A push between kinetic and static friction moves nothing at rest and does not drag back what it stops;
    a push beyond static friction moves it, against kinetic friction.
    """
    speeds = block(law, 1000 if dt > 1e-4 else 20_000, dt, start, -1.4, normal=10.0, sliding=start > 0.0)
    assert np.abs(speeds[-100:]).max() < 1e-15 and speeds.min() > -1e-15
    speeds = block(law, 100, 1e-2, 0.0, -1.6, normal=10.0)
    assert np.diff(speeds)[4:] == pytest.approx(-0.6 * 1e-2, rel=1e-9)


@pytest.mark.parametrize("band", [0.0, 1e-6, 1e-4, 1e-2])
def test_karnopp_block_on_a_belt_sticks_and_slips(band):
    """Static friction acts until the speed leaves the band, kinetic friction until the block has the belt's
    speed again: swing about the place where kinetic friction balances the spring.
    """
    normal, belt, stiffness = 981.0, 1.0, 1e4
    law = Karnopp(coefficient=0.2, static_coefficient=0.3, band=band)
    root, lead = math.sqrt(stiffness), 1.0 - band / belt
    start = 0.3 * normal / stiffness + belt / root * math.sqrt(1.0 - lead * lead)
    middle = 0.2 * normal / stiffness
    swing = math.hypot(start - middle, (belt - band) / root)
    for dt in (4e-5, 1e-5):
        p, v, memory, place, places = law.parameters(PAIR), 0.0, (0.0, 0.0), 0.0, []
        for _ in range(round(0.3 / dt)):
            pull = -stiffness * place
            force, memory = law.force(normal, v - belt + dt * pull, dt, memory, dt, p)
            v += dt * (pull + force)
            place += dt * v
            places.append(place)
        late = np.array(places)[round(0.1 / dt) :]
        assert late.max() == pytest.approx(middle + swing, abs=3.0 * belt * dt)
        assert late.min() == pytest.approx(middle - swing, abs=3.0 * belt * dt)


def test_stribeck_curve_converges_to_its_differential_equation():
    """A block slowed down through the Stribeck curve: second order, while an implicit half-step value would
    have the first.
    """
    law = Stribeck(coefficient=0.1, static_coefficient=0.3, stribeck_speed=0.02, shape=2.0, viscous=0.5)

    def rate(t, v):
        return -9.81 * (0.1 + 0.2 * np.exp(-((v / 0.02) ** 2)) + 0.5 * v)

    exact = solve_ivp(rate, (0, 0.03), [0.05], method="DOP853", rtol=1e-13, atol=1e-16).y[0, -1]
    assert 0.0 < exact < 0.02
    errors = []
    for n in (300, 600, 1200, 2400):
        speeds = block(law, n + 1, 0.03 / n, 0.05, 0.0, sliding=True)
        errors.append(abs(0.5 * (speeds[-1] + speeds[-2]) - exact))
    assert errors[-1] < 1e-6
    assert order(errors)[-1] == pytest.approx(2.0, abs=0.4)


@pytest.mark.parametrize(("share", "coefficient"), [(0.0, 0.0), (0.99, 0.3), (1.01, 0.2), (50.0, 0.2)])
def test_karnopp_band_ends_at_its_speed(share, coefficient):
    """Nothing moves (mobility 0): static friction inside, kinetic friction outside."""
    law = Karnopp(coefficient=0.2, static_coefficient=0.3, band=1e-3)
    for sign in (1.0, -1.0):
        speed = sign * share * 1e-3
        force, _ = law.force(500.0, speed, 0.0, (speed, speed), 1e-6, law.parameters(PAIR))
        assert force == pytest.approx(-sign * coefficient * 500.0, rel=1e-15)


# ---------------------------------------------------------------------------------------------------- curves
# of the speed


def threlfall(law, v):
    return (
        law.coefficient * (1 - math.exp(-3 * v / law.v1)) / (1 - math.exp(-3))
        if v < law.v1
        else law.coefficient
    )


def bengisu_akay(law, v):
    kinetic, static = law.coefficient, law.static_coefficient
    return (
        static - static / law.v0**2 * (v - law.v0) ** 2
        if v < law.v0
        else kinetic + (static - kinetic) * math.exp(-law.decay * (v - law.v0))
    )


def brown_mcphee(law, v):
    x = v / law.transition_speed
    return (
        law.coefficient * math.tanh(4 * x)
        + (law.static_coefficient - law.coefficient) * x / (x * x / 4 + 0.75) ** 2
    )


CURVES = [
    (Threlfall(coefficient=0.3, v1=0.05), threlfall),
    (BengisuAkay(coefficient=0.2, static_coefficient=0.3, v0=0.02, decay=40.0), bengisu_akay),
    (BrownMcPhee(coefficient=0.2, static_coefficient=0.3, transition_speed=0.02), brown_mcphee),
]
each_curve = pytest.mark.parametrize(("law", "curve"), CURVES, ids=[type(law).name for law, _ in CURVES])
any_state = {
    "normal": positive,
    "mobility": st.floats(1e-9, 1e-3),
    "free": st.floats(1e-9, 1.0) | st.floats(-1e-1, -1e-9),
    "last": st.floats(-1.0, 1.0) | st.floats(-1e-2, 1e-2),
    "before": st.floats(-1.0, 1.0) | st.floats(-1e-2, 1e-2),
}


@each_curve
@settings(deadline=None, max_examples=often(500))
@given(**any_state)
def test_a_curve_opposes_whatever_it_remembers(law, curve, normal, mobility, free, last, before):
    """Bounded by static friction and never turning the sliding round, in any step from any past."""
    force, (left, kept) = law.force(normal, free, mobility, (last, before), 1e-6, law.parameters(PAIR))
    top = max(getattr(law, "static_coefficient", 0.0), law.coefficient)
    assert kept == last and force * free <= 0.0 and abs(force) <= top * normal * (1 + 1e-14)
    assert left == free + mobility * force and left * math.copysign(1.0, free) >= -1e-14 * abs(free)


@each_curve
@settings(deadline=None, max_examples=often(500))
@given(
    normal=positive,
    mobility=any_state["mobility"],
    v=st.floats(1e-7, 1.0) | st.floats(1e-4, 5e-2),
    sign=st.sampled_from([1.0, -1.0]),
)
def test_steady_sliding_is_exact(law, curve, normal, mobility, v, sign):
    """The free velocity that the printed curve leaves at v, found by last and before at v, gives that curve's
    force: at any steepness.
    """
    exact = normal * curve(law, v)
    force, (left, _) = law.force(
        normal, sign * (v + mobility * exact), mobility, (sign * v, sign * v), 1e-6, law.parameters(PAIR)
    )
    assert force == pytest.approx(-sign * exact, rel=1e-9)
    assert left == pytest.approx(sign * v, rel=1e-9, abs=1e-9 * mobility * exact)


@each_curve
def test_a_steep_curve_creeps_to_the_speed_that_holds(law, curve):
    """A push below the peak, and steps in which the curve would change the speed by 400 of its own: one
    solution, found in a few steps.
    """
    p, memory, normal, push = law.parameters(PAIR), (0.0, 0.0), 1e4, 0.6 * 0.2 * 1e4
    v, mobility = 0.0, 5e-3
    for _ in range(60):
        free = v + mobility * push
        force, memory = law.force(normal, free, mobility, memory, 1e-6, p)
        v = free + mobility * force
    exact = brentq(lambda v: normal * curve(law, v) - push, 0.0, 0.015)
    assert v == pytest.approx(exact, rel=1e-6)


@each_curve
@pytest.mark.parametrize("start", [0.06, 0.012], ids=["over the peak", "below it"])
def test_a_curve_converges_to_its_differential_equation(law, curve, start):
    """1 kg pushed and braked, SciPy's velocity: second order, through kinks and falling parts as well."""

    def push(t):
        return 3.0 * 0.2 * math.sin(60.0 * t)

    def rate(t, y):
        return push(t) - 9.81 * math.copysign(curve(law, abs(y[0])), y[0])

    exact = solve_ivp(rate, (0, 0.04), [start], method="DOP853", rtol=1e-12, atol=1e-15, max_step=5e-5).y[
        0, -1
    ]
    errors, p = [], law.parameters(PAIR)
    for n in (800, 1600, 3200):
        dt, v, memory = 0.04 / n, start, (start, start)
        for k in range(n + 1):  # half steps as the loop makes them
            half, gain = (0.5 * dt, dt) if k else (0.0, 0.5 * dt)
            force, memory = law.force(9.81, v + half * push(k * dt), half, memory, dt, p)
            if k == n:
                errors.append(abs(memory[0] - exact))
            v += gain * (push(k * dt) + force)
    assert errors[-1] < 2e-8 * start
    assert np.mean(order(errors)) == pytest.approx(2.0, abs=0.1)


def test_threlfall_is_whole_without_a_jump():
    law = Threlfall(coefficient=0.3, v1=0.05)
    forces = [
        law.force(100.0, v, 0.0, (0.0, 0.0), 1e-6, law.parameters(PAIR))[0]
        for v in (0.05 * (1 - 1e-12), 0.05 * (1 + 1e-12), 3.0)
    ]
    assert forces == pytest.approx([-30.0] * 3, rel=1e-11)
