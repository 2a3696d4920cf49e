"""Gravity, forces, torques, drivers and damping against closed forms and independent integrations."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from support import SQUARE, four_bar, go, largest_force, particle, pin, times, with_settings, within
from vfife.model.drivers import AngleTable, Ramp, Torque
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism


def free_body(**motion) -> Mechanism:
    """A rigid body without joints, its centre of mass and its pin off the origin of its frame."""
    m = Mechanism("body")
    m.rigid_body(
        "b", mass=2.0, inertia=0.03, center=(0.1, -0.05), pins={"eye": (0.3, 0.2)}, angle=0.6, **motion
    )
    return m


def moving_body(u: float, v: float, w: float) -> Mechanism:
    """The free body whose centre of mass moves at (u, v); a velocity is that of the body's origin."""
    rx, ry = 0.1 * math.cos(0.6) + 0.05 * math.sin(0.6), 0.1 * math.sin(0.6) - 0.05 * math.cos(0.6)
    return free_body(velocity=(u + w * ry, v - w * rx, w))


def turning_link(mass: float = 2.0, length: float = 0.6, angle: float = 0.0, gravity=(0.0, 0.0)) -> Mechanism:
    """A link that turns about a point of the ground; inertia about it m l^2/3."""
    m = Mechanism("link", gravity=gravity)
    m.point("O", 0.2, -0.1)
    m.link("rod", length=length, mass=mass, angle=angle)
    m.revolute("A", "ground.O", "rod.start")
    return m


INERTIA = 2.0 * 0.6**2 / 3.0  # of the link about its pivot, kg m^2


# -----------------------------------------------------------------------------------------------------
# damping and gravity


@pytest.mark.parametrize("damping", [0.5, 8.0])
def test_mass_proportional_damping_of_a_free_body(damping):
    """Every velocity decays as exp(-zeta t), turning too; places follow; the ledger holds what is lost."""
    m = with_settings(moving_body(3.0, -2.0, 12.0), damping=damping)
    step = 1e-4
    record = go(m, step, duration=0.5, outputs=50)
    t, p = times(record), particle(record, "b")
    decay = np.exp(-damping * t)
    half = np.exp(-damping * (t + step / 2))
    for name, start in (("u", 3.0), ("v", -2.0), ("w", 12.0)):
        assert p[name] == pytest.approx(start * half, rel=1e-6)
    for name, start in (("x", 3.0), ("y", -2.0), ("theta", 12.0)):
        assert p[name] - p[name][0] == pytest.approx(start * (1 - decay) / damping, rel=1e-6, abs=1e-9)
    energy = 0.5 * 2.0 * 13.0 + 0.5 * 0.03 * 144.0
    assert record.block("damping_work")[-1, 0] == pytest.approx(energy * (1 - half[-1] ** 2), rel=1e-6)


def test_terminal_velocity():
    """Falling in gravity with damping: v = -(g/zeta)(1 - exp(-zeta t)) from rest, and g/zeta in the end."""
    m = with_settings(free_body(), damping=5.0)
    m.gravity = (0.0, -9.81)
    record = go(m, 1e-4, duration=3.0, outputs=30)
    half = times(record) + 5e-5
    assert particle(record, "b")["v"] == pytest.approx(
        -9.81 / 5 * (1 - np.exp(-5 * half)), rel=1e-6, abs=1e-7
    )
    assert particle(record, "b")["v"][-1] == pytest.approx(-9.81 / 5, rel=1e-6)


def test_free_fall_is_exact():
    m = moving_body(1.0, 2.0, 3.0)
    m.gravity = (0.5, -9.81)
    record = go(m, 1e-3, duration=1.0, outputs=10)
    t, p = times(record), particle(record, "b")
    assert p["x"] - p["x"][0] == pytest.approx(t + 0.25 * t**2, abs=1e-12)
    assert p["y"] - p["y"][0] == pytest.approx(2 * t - 9.81 / 2 * t**2, abs=1e-12)
    assert p["theta"] == pytest.approx(0.6 + 3 * t, abs=1e-12)


# --------------------------------------------------------------------------------------------------------
# forces and torques


def test_a_point_force_at_a_pin():
    """Fixed in space, off the centre of mass, over time, with a moment: the body's three equations integrated
    by SciPy.
    """
    force, moment, knots, factors = np.array([15.0, -4.0]), 0.4, (0.0, 0.1, 0.25, 0.4), (1.0, -0.5, 2.0, 0.3)
    m = free_body()
    m.loads["p"] = PointForce(
        name="p",
        at="b.eye",
        force=tuple(force),
        moment=moment,
        times=knots,
        factors=factors,
        interpolation="spline",
    )
    record = go(m, 2e-5, duration=0.4, outputs=40)
    factor = CubicSpline(knots, factors, bc_type="natural")
    arm = np.array([0.2, 0.25])

    def motion(t, y):
        c, s = math.cos(y[2]), math.sin(y[2])
        rx, ry = c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]
        fx, fy = factor(t) * force
        return [*y[3:], fx / 2.0, fy / 2.0, (rx * fy - ry * fx + factor(t) * moment) / 0.03]

    p = particle(record, "b")
    start = [p["x"][0], p["y"][0], 0.6, 0.0, 0.0, 0.0]
    solved = solve_ivp(motion, (0, 0.4), start, method="DOP853", rtol=1e-11, atol=1e-12, t_eval=times(record))
    for axis, values in zip(("x", "y", "theta"), solved.y[:3], strict=True):
        assert p[axis] == pytest.approx(values, abs=2e-8 * np.ptp(values) + 1e-9)
    assert np.ptp(p["theta"]) > 1.0
    u, v, w = solved.y[3:]
    kinetic = (u * u + v * v) + 0.015 * w * w  # at t_n; the ledger reaches to t_(n + 1/2)
    power = record.block("external_power")[:, 0]
    assert record.block("external_work")[:, 0] - 1e-5 * power == pytest.approx(
        kinetic, abs=1e-4 * kinetic.max()
    )


def test_a_constant_torque():
    """theta = T t^2/(2 I): gravity-free link on a pivot; the reaction of the pivot is the rod's centripetal
    and tangential force.
    """
    m = turning_link()
    m.drivers["rod"] = Torque(body="rod", value=1.5)
    record = go(m, 1e-4, duration=0.5, outputs=50)
    t, alpha = times(record), 1.5 / INERTIA
    assert particle(record, "rod")["theta"] == pytest.approx(alpha * t**2 / 2, abs=1e-6)
    assert record.block("body_alpha")[1:, 0] == pytest.approx(np.full(50, alpha), rel=1e-6)
    f = np.hypot(record.block("joint_fx")[:, 0], record.block("joint_fy")[:, 0])
    assert f[1:] == pytest.approx(2.0 * 0.3 * np.sqrt(alpha**2 + (alpha * t[1:]) ** 4), rel=1e-4)
    assert record.block("external_work")[-1, 0] == pytest.approx(
        0.5 * INERTIA * (alpha * (0.5 + 5e-5)) ** 2, rel=1e-4
    )


def test_a_torque_over_time():
    """Rising evenly, T = 40 t: theta = 40 t^3/(6 I)."""
    m = turning_link()
    m.drivers["rod"] = Torque(body="rod", value=(0.0, 8.0), times=(0.0, 0.2))
    record = go(m, 5e-5, duration=0.2, outputs=20)
    t = times(record)
    assert particle(record, "rod")["theta"] == pytest.approx(40 * t**3 / (6 * INERTIA), abs=1e-7)


def test_a_torque_against_gravity():
    """Torque m g l/2 cos(angle) holds a link where it is; a tenth more does not."""
    holds = 2.0 * 9.81 * 0.3 * math.cos(0.7)
    for factor in (1.0, 1.1):
        m = turning_link(angle=0.7, gravity=(0.0, -9.81))
        m.drivers["rod"] = Torque(body="rod", value=factor * holds)
        record = go(m, 1e-4, duration=0.1, outputs=10)
        moved = np.ptp(particle(record, "rod")["theta"])
        assert (moved < 1e-10) == (factor == 1.0)
    assert moved == pytest.approx(0.1 * holds / INERTIA * 0.005, rel=0.02)


# ---------------------------------------------------------------------------------------------------- drivers


def test_constant_speed_holds_an_unbalanced_link():
    """Angle w t; torque -m r x g; ground force m (a - g) with a = -w^2 r, at every output."""
    gx, gy = 3.0, -9.81
    m = turning_link(angle=0.3, gravity=(gx, gy))
    m.drive("rod", speed=20.0)
    record = go(m, 1e-4, duration=0.4, outputs=40)
    t = times(record)
    theta = 0.3 + 20 * t
    assert particle(record, "rod")["theta"] == pytest.approx(theta, abs=1e-13)
    assert record.block("driven_torque")[:, 0] == pytest.approx(
        2.0 * 0.3 * (np.sin(theta) * gx - np.cos(theta) * gy), abs=1e-10
    )
    assert record.block("driven_fx")[:, 0] == pytest.approx(-2.0 * (400 * 0.3 * np.cos(theta) + gx), abs=1e-9)
    assert record.block("driven_fy")[:, 0] == pytest.approx(-2.0 * (400 * 0.3 * np.sin(theta) + gy), abs=1e-9)
    assert pin(record, "rod", "end") == pytest.approx(
        np.stack([0.2 + 0.6 * np.cos(theta), -0.1 + 0.6 * np.sin(theta)], axis=1), abs=1e-12
    )
    window = within(record, 0.0, 0.4)
    assert largest_force(record, "A", window) == pytest.approx(
        2.0 * (400 * 0.3 + math.hypot(gx, gy)), rel=1e-4
    )


def test_ramp():
    """Speed w (10 s^3 - 15 s^4 + 6 s^5), s = t/T, then w; angle its integral; torque I times its derivative;
    work 1/2 I w^2.
    """
    m = turning_link(angle=0.5)
    m.drivers["rod"] = Ramp(body="rod", speed=30.0, duration=0.2)
    record = go(m, 1e-4, duration=0.3, outputs=60)
    t = times(record)
    s = np.minimum(t / 0.2, 1.0)
    angle = 0.5 + 30 * 0.2 * (2.5 * s**4 - 3 * s**5 + s**6) + 30 * np.maximum(t - 0.2, 0.0)
    p = particle(record, "rod")
    assert p["theta"] == pytest.approx(angle, abs=1e-12)
    assert p["w"] == pytest.approx(30 * (10 * s**3 - 15 * s**4 + 6 * s**5), abs=1e-10)
    assert record.block("driven_torque")[:, 0] == pytest.approx(
        INERTIA * 30 / 0.2 * 30 * s**2 * (1 - s) ** 2, abs=1e-9
    )
    assert record.block("driven_work")[-1, 0] == pytest.approx(0.5 * INERTIA * 900, rel=1e-6)


def test_angle_table():
    """A natural cubic spline through the angles, counted from the start angle; torque from its second
    derivative.
    """
    knots, angles = (0.0, 0.1, 0.2, 0.35), (0.0, 0.4, -0.3, 1.0)
    m = turning_link(angle=0.25)
    m.drivers["rod"] = AngleTable(body="rod", times=knots, values=angles)
    record = go(m, 1e-4, duration=0.35, outputs=35)
    spline = CubicSpline(knots, angles, bc_type="natural")
    t, p = times(record), particle(record, "rod")
    assert p["theta"] == pytest.approx(0.25 + spline(t), abs=1e-12)
    assert p["w"] == pytest.approx(spline(t, 1), abs=1e-10)
    assert record.block("driven_torque")[:, 0] == pytest.approx(INERTIA * spline(t, 2), abs=1e-8)


def test_a_ramp_carries_what_hangs_on_it():
    """Four-bar ramped up to speed within half a turn: places are those that the crank's angle demands, the
    next turn is the steady one.
    """
    m = four_bar("", speed=0.0)
    m.drivers["crank"] = Ramp(body="crank", speed=50 * math.pi, duration=0.04)
    record = go(m, 2e-6, duration=0.1, outputs=500)
    steady = go(four_bar(""), 2e-6, turns=1)
    late = within(record, 0.05, 0.09)
    for joint in "BCD":
        assert largest_force(record, joint, late) == pytest.approx(
            largest_force(steady, joint, within(steady, 0, 1)), rel=1e-4
        )
    crank = particle(record, "crank")["theta"]
    tip = pin(record, "follower", "end")
    b = np.stack([0.4 * np.cos(crank), 0.4 * np.sin(crank)], axis=1)
    assert np.hypot(*(tip - b).T) == pytest.approx(np.full(len(b), 0.26), abs=1e-11)
    assert np.hypot(*(tip - [0.15, 0.0]).T) == pytest.approx(np.full(len(b), 0.46), abs=1e-11)


def test_work_of_the_driver_goes_into_the_links():
    """Ideal four-bar at constant speed: over any time the driver's work is the change of kinetic energy."""
    record = go(four_bar(""), 1e-6, turns=1)
    kinetic = 0.0
    for name, mass, length in (("coupler", 2.028, 0.26), ("follower", 3.588, 0.46)):
        p = particle(record, name)
        kinetic = kinetic + 0.5 * mass * (p["u"] ** 2 + p["v"] ** 2) + mass * length**2 / 24 * p["w"] ** 2
    work = record.block("driven_work")[:, 0]
    assert work - work[0] == pytest.approx(kinetic - kinetic[0], abs=2e-5 * np.ptp(kinetic))
    assert np.ptp(kinetic) > 1e3


def test_damping_of_elastic_links_is_that_of_rigid_ones():
    """Mass-proportional damping acts on particles: a falling elastic link and a rigid one fall alike."""
    falls = []
    for options in ({"model": "rigid"}, {"model": "elastic", "elements": 3, "section": SQUARE}):
        m = Mechanism("falling", gravity=(0.0, -9.81))
        m.link("rod", length=0.5, mass=3.9, velocity=(1.0, 0.0, 0.0), **options)
        record = go(with_settings(m, damping=4.0), 2e-6, duration=0.02, outputs=20)
        falls.append(0.5 * (pin(record, "rod", "start") + pin(record, "rod", "end")))
    assert falls[1] == pytest.approx(falls[0], abs=1e-9)
