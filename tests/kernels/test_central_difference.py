"""Velocities kept at half steps are algebraically the paper's Eq. 3-5, which keep positions alone; the two
agree to rounding.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support import often, particle, with_settings
from vfife.assembly.assemble import assemble
from vfife.kernels.central_difference import coefficients
from vfife.model.bodies import Section
from vfife.model.mechanism import Mechanism
from vfife.solvers.transient import run


def positions_only(count, dt, damping, acceleration, d0, v0):
    """Eq. 3-5 of the paper as printed (Eq. 5 with the whole mass): d_(n+1) = c1 dt^2 a + 2 c1 d_n - c2
    d_(n-1).
    """
    c1 = 1.0 / (1.0 + damping * dt / 2.0)
    c2 = c1 * (1.0 - damping * dt / 2.0)
    now = np.array(d0)
    a = acceleration(now)
    # d_(-1) = d_0 - dt v_0 + dt^2/2 (second derivative, which damping takes part in)
    before = now - dt * np.array(v0) + 0.5 * dt**2 * (a - damping * np.array(v0))
    path = [now]
    for _ in range(count):
        now, before = c1 * dt**2 * a + 2.0 * c1 * now - c2 * before, now
        a = acceleration(now)
        path.append(now)
    return np.array(path)


def half_steps(count, dt, damping, acceleration, d0, v0):
    """The form of the kernels."""
    d, v, path = np.array(d0), np.array(v0), [np.array(d0)]
    for n in range(count):
        _, b, k, _ = coefficients(n == 0, dt, damping)
        v = b * v + k * acceleration(d)
        d = d + dt * v
        path.append(d)
    return np.array(path)


@settings(deadline=None, max_examples=often(100))
@given(
    st.floats(0.01, 1.5), st.floats(0.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0),
)  # fmt: skip
def test_half_steps_are_the_papers_equations(turn, damping, d0, v0):
    """A duffing oscillator, w dt and zeta dt at random; differences of positions lose digits as 1/(w dt)^2,
    half steps do not.
    """
    args = (100, 1.0, damping, lambda d: -(turn**2) * (d - 0.1 * d**3), [d0], [v0 * turn])
    assert half_steps(*args) == pytest.approx(positions_only(*args), rel=0, abs=1e-10 / turn**2)


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_the_velocity_at_a_step_is_the_central_one(damping):
    """v_n = p (v_(n-1/2) + h a) is (d_(n+1) - d_(n-1))/(2 dt), Eq. 3, with damping too."""
    dt, d, v, before = 0.01, 1.0, 0.3, None
    for n in range(50):
        h, b, k, p = coefficients(n == 0, dt, damping)
        a = -40.0 * d
        now = p * (v + h * a)
        v = b * v + k * a
        after = d + dt * v
        if before is not None:
            assert now == pytest.approx((after - before) / (2 * dt), rel=0, abs=1e-12)
        else:
            assert now == 0.3
        before, d = d, after


LENGTH, AREA, MASS = 0.5, 1e-4, 2.0


def bar(damping: float) -> Mechanism:
    """A two-particle link whose ends fly apart: an oscillator."""
    m = Mechanism("bar")
    m.link(
        "bar",
        length=LENGTH,
        mass=MASS,
        model="two-particle",
        section=Section.square(AREA),
        release="both",
        strain="current",
    )
    return with_settings(m, damping=damping)


@pytest.mark.parametrize("damping", [0.0, 400.0])
def test_a_run_keeps_to_the_papers_equations(damping):
    """The loop itself, element and all, beside Eq. 5 with the same incremental axial force; the start Eq. 4
    included.
    """
    dt, count, speed = 2e-6, 2000, 0.8
    a = assemble(bar(damping), dt, duration=count * dt, outputs=count, force_step=True)
    a.state[a.layout["particle_u"][1:]] = -speed, speed
    record = run(a, loop="data-driven")
    ea = 207e9 * AREA
    seen = {"length": LENGTH, "force": 0.0}

    def acceleration(x):
        length = x[1] - x[0]
        seen["force"] += ea * (length - seen["length"]) / seen["length"]
        seen["length"] = length
        return np.array([seen["force"], -seen["force"]]) / (MASS / 2)

    ours = np.stack([particle(record, "bar", k)["x"] for k in (0, 1)], axis=1)
    papers = positions_only(count, dt, damping, acceleration, [0.0, LENGTH], [-speed, speed])
    swing = np.abs(ours - ours[0]).max()
    assert swing > 1e-5 and record.status == "complete"
    assert np.abs(ours - papers).max() < 1e-7 * swing


def test_the_oscillator_swings_at_the_shifted_frequency():
    """Central difference swings at sin(w' dt/2) = w dt/2: closed form of its own error."""
    dt, speed = 5e-6, 0.05
    a = assemble(bar(0.0), dt, duration=4000 * dt, outputs=4000, force_step=True)
    a.state[a.layout["particle_u"][1:]] = -speed, speed
    record = run(a, loop="data-driven")
    stretch = particle(record, "bar", 1)["x"] - particle(record, "bar", 0)["x"] - LENGTH
    w = math.sqrt(2 * 207e9 * AREA / LENGTH / (MASS / 2))
    shifted = 2 / dt * math.asin(w * dt / 2)
    t = record.steps * dt
    amplitude = 2 * speed / (w * math.sqrt(1 - (w * dt / 2) ** 2))
    expected = amplitude * np.sin(shifted * t)
    assert (
        np.abs(stretch - expected).max() < 2e-4 * amplitude
    )  # the bar stretches by 2e-5, which changes its frequency by as much
    plain = amplitude * np.sin(w * t)
    assert np.abs(stretch - plain).max() > 1e-2 * amplitude
