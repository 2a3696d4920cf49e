"""Velocities, accelerations and reactions of ideal mechanisms, against published maxima, closed forms and
balances they do not use themselves.
"""

from dataclasses import replace

import numpy as np
import pytest

from kinematics.rods import (
    GRAVITY,
    along,
    at_angle,
    double_crank,
    driven,
    four_bar,
    rods,
    rough_guess,
    weight,
)
from kinematics.turns import extremes
from rigid import Drive, accelerations, velocities
from vfife.errors import AssemblyError
from vfife.kinematics.mobility import mobility
from vfife.kinematics.solve import close


def left_over(system, position, acceleration, force, reactions, torque):
    """Newton-Euler sum of every moving body [n-1,3], built from the reactions alone."""
    total = np.array(force)
    for pin, reaction in zip(system.joints, reactions, strict=True):
        for sign, body, point in ((-1.0, pin.body_a, pin.point_a), (1.0, pin.body_b, pin.point_b)):
            angle = position[body, 2]
            arm = np.exp(1j * angle) * complex(*point)
            total[body, :2] += sign * reaction[:2]
            total[body, 2] += sign * (arm.real * reaction[1] - arm.imag * reaction[0])
    for drive, moment in zip(system.drives, torque, strict=True):
        total[drive.body_b, 2] += moment
    inertial = np.column_stack([system.mass, system.mass, system.inertia]) * acceleration
    return (total - inertial)[1:]


@pytest.mark.parametrize(
    ("speed", "follower", "maxima"),
    [
        (10.0 * np.pi, 912.642, (1577.0, 2613.5, 4538.6)),
        (50.0 * np.pi, 22816.05, (39425.3, 65338.1, 113464.7)),
    ],
)
def test_four_bar_reaches_the_published_maxima(speed, follower, maxima):
    def at(angle, guess):
        system = driven(four_bar(), angle, speed)
        position = close(system, rough_guess() if guess is None else guess).position
        acceleration, reactions, _ = accelerations(
            system, position, velocities(system, position), np.zeros((4, 3))
        )
        return [acceleration[3, 2], *np.hypot(*reactions.T[:2])[1:]], position

    least, largest = extremes(at)
    turning = max(-least[0], largest[0])
    assert turning == pytest.approx(follower, rel=1e-6)
    assert turning == pytest.approx(0.924700 * speed**2, rel=1e-6)
    np.testing.assert_allclose(largest[1:], maxima, rtol=1e-5)


def test_four_bar_returns_to_its_start_on_the_same_branch():
    first = last = close(driven(four_bar(), 0.0), rough_guess()).position
    for angle in np.linspace(0.0, 2.0 * np.pi, 37)[1:]:
        last = close(driven(four_bar(), angle), last).position
    np.testing.assert_allclose(last[:, :2], first[:, :2], atol=1e-14)
    np.testing.assert_allclose(last[1:, 2] - first[1:, 2], 2.0 * np.pi, rtol=1e-14)


def test_mirror_image_has_mirrored_motion_and_opposite_torque():
    mirror = np.array([1.0, -1.0, -1.0])
    results = []
    for sign in (1.0, -1.0):
        system = driven(four_bar(), sign * 0.9, sign * 3.0, sign * 2.0)
        position = at_angle(sign * 0.9, sign)
        velocity = velocities(system, position)
        force = weight(system) * (1.0, sign, 1.0)
        results.append((position, velocity, *accelerations(system, position, velocity, force)))
    (p, v, a, r, t), (p2, v2, a2, r2, t2) = results
    for one, other in ((p, p2), (v, v2), (a, a2), (r, r2)):
        np.testing.assert_allclose(other, one * mirror[: one.shape[1]], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(t2, -t, rtol=1e-12)


@pytest.mark.parametrize(("angle", "speed"), [(-np.pi / 2.0, 0.0), (0.0, 2.0), (0.6, -5.0)])
def test_pendulum_reaction_is_the_closed_form(angle, speed):
    length, mass = 0.8, 1.7
    system = rods(("rod",), (length,), (mass,), (("P", 0, (0.3, 0.1), 1, -1.0),))
    axis, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    foot = np.array([0.3, 0.1])
    position = np.array([[0.0, 0.0, 0.0], along(foot, foot + length * axis)])
    velocity = np.zeros((2, 3))
    velocity[1] = [*(0.5 * length * speed * across), speed]
    acceleration, reactions, torque = accelerations(system, position, velocity, weight(system))
    expected = mass * (GRAVITY * np.sin(angle) - 0.5 * length * speed**2) * axis
    expected = expected + 0.25 * mass * GRAVITY * np.cos(angle) * across
    np.testing.assert_allclose(reactions[0], [*expected, 0.0], rtol=1e-13, atol=1e-13)
    assert acceleration[1, 2] == pytest.approx(-1.5 * GRAVITY * np.cos(angle) / length, rel=1e-13, abs=1e-14)
    assert torque.shape == (0,)


def test_held_pendulum_needs_the_torque_of_its_weight():
    system = driven(rods(("rod",), (0.8,), (1.7,), (("P", 0, (0.0, 0.0), 1, -1.0),)), 0.4)
    position = close(system, np.zeros((2, 3))).position
    acceleration, reactions, torque = accelerations(system, position, np.zeros((2, 3)), weight(system))
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-14)
    np.testing.assert_allclose(reactions, [[0.0, 1.7 * GRAVITY, 0.0]], atol=1e-13)
    np.testing.assert_allclose(torque, [1.7 * GRAVITY * 0.4 * np.cos(0.4)], rtol=1e-14)


def test_double_pendulum_obeys_lagranges_equations():
    (l1, l2), (m1, m2), (q1, q2), (w1, w2) = (0.5, 0.3), (1.2, 0.9), (-0.4, -1.9), (3.0, -7.0)
    system = rods(
        ("upper", "lower"), (l1, l2), (m1, m2), (("O", 0, (0.0, 0.0), 1, -1.0), ("K", 1, 1.0, 2, -1.0))
    )
    knee = l1 * np.array([np.cos(q1), np.sin(q1)])
    tip = knee + l2 * np.array([np.cos(q2), np.sin(q2)])
    position = np.array([[0.0, 0.0, 0.0], along((0.0, 0.0), knee), along(knee, tip)])
    tied = replace(system, drives=(Drive(1, q1, w1), Drive(2, q2, w2)))
    velocity = velocities(tied, position)
    cross = 0.5 * m2 * l1 * l2
    matrix = [
        [m1 * l1**2 / 3.0 + m2 * l1**2, cross * np.cos(q1 - q2)],
        [cross * np.cos(q1 - q2), m2 * l2**2 / 3.0],
    ]
    right = [
        -cross * np.sin(q1 - q2) * w2**2 - (0.5 * m1 + m2) * GRAVITY * l1 * np.cos(q1),
        cross * np.sin(q1 - q2) * w1**2 - 0.5 * m2 * GRAVITY * l2 * np.cos(q2),
    ]
    acceleration = accelerations(system, position, velocity, weight(system))[0]
    np.testing.assert_allclose(acceleration[1:, 2], np.linalg.solve(matrix, right), rtol=1e-13)
    assert mobility(tied, position).free == 2
    assert mobility(tied, position).after_drives == 0


def test_velocity_and_acceleration_are_the_time_derivatives_along_a_path():
    def state(time):
        angle, speed, rate = (
            0.8 + 0.5 * np.sin(3.0 * time),
            1.5 * np.cos(3.0 * time),
            -4.5 * np.sin(3.0 * time),
        )
        system = driven(four_bar(), angle, speed, rate)
        position = close(system, start).position
        velocity = velocities(system, position)
        return position, velocity, accelerations(system, position, velocity, np.zeros((4, 3)))[0]

    start, step, now = at_angle(1.0), 1e-3, 0.2
    _, velocity, acceleration = state(now)
    ahead, behind, far, back = (state(now + k * step) for k in (1, -1, 2, -2))
    for order, exact in ((0, velocity), (1, acceleration)):
        slope = (8.0 * (ahead[order] - behind[order]) - far[order] + back[order]) / (12.0 * step)
        np.testing.assert_allclose(slope, exact, rtol=1e-9, atol=1e-9)


def test_reactions_balance_every_body_and_the_drive_supplies_the_power():
    system = driven(four_bar(), 2.1, 9.0, 40.0)
    position = at_angle(2.1)
    velocity = velocities(system, position)
    force = weight(system)
    acceleration, reactions, torque = accelerations(system, position, velocity, force)
    np.testing.assert_allclose(
        left_over(system, position, acceleration, force, reactions, torque),
        0.0,
        atol=1e-12 * np.abs(reactions).max(),
    )
    inertial = np.column_stack([system.mass, system.mass, system.inertia]) * acceleration
    power = np.sum((inertial - force) * velocity)
    assert torque[0] * 9.0 == pytest.approx(power, rel=1e-12)


def test_a_caught_rod_keeps_its_angular_momentum_about_the_pin():
    length, mass = 0.8, 1.7
    system = rods(("rod",), (length,), (mass,), (("P", 0, (0.0, 0.0), 1, -1.0),))
    position = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]])
    flying = np.array([[9.0, 9.0, 9.0], [5.0, 2.0, -1.5]])
    speed = (mass * 0.4 * 2.0 - mass * length**2 / 12.0 * 1.5) / (mass * length**2 / 3.0)
    np.testing.assert_allclose(
        velocities(system, position, flying), [[0.0, 0.0, 0.0], [0.0, 0.4 * speed, speed]], atol=1e-14
    )
    np.testing.assert_array_equal(velocities(system, position), np.zeros((2, 3)))


def test_redundant_pins_share_the_load_without_self_stress():
    system, position, angle = double_crank()
    moving = driven(system, angle, 4.0, -6.0)
    velocity, force = velocities(moving, position), weight(system)
    acceleration, reactions, torque = accelerations(moving, position, velocity, force)
    largest = np.abs(reactions).max()
    np.testing.assert_allclose(
        left_over(moving, position, acceleration, force, reactions, torque), 0.0, atol=1e-13 * largest
    )
    self_stress = np.repeat([0.2, -0.5, 0.3], 2)[:, None] * [np.cos(angle), np.sin(angle)]
    # what a unit force would move in a pin by itself, along x and y; the driven crank gives way to nothing
    alone = []
    for k, (x, mass) in enumerate(zip((0.0, 0.3, 0.5), (1.0, 1.5, 0.7), strict=True)):
        crank = (
            np.zeros(2)
            if k == 0
            else 1.0 / mass + 12.0 / mass * 0.25 * np.array([np.sin(angle), np.cos(angle)]) ** 2
        )
        alone += [crank, crank + 0.5 + np.array([0.0, (x - 0.25) ** 2]) * 6.0 / 0.25]
    assert abs(np.sum(np.array(alone) * self_stress * reactions[:, :2])) < 1e-13 * largest * np.max(alone)


def dead_centre():
    """Crank and coupler in line; the follower, driven, cannot go on."""
    system = four_bar(0.40, 0.10, 0.35, 0.25)
    angle = np.arccos((0.40**2 + 0.45**2 - 0.25**2) / (2.0 * 0.40 * 0.45))
    axis = np.array([np.cos(angle), np.sin(angle)])
    rows = [along((0.0, 0.0), 0.1 * axis), along(0.1 * axis, 0.45 * axis), along((0.4, 0.0), 0.45 * axis)]
    return system, np.array([[0.0, 0.0, 0.0], *rows])


def test_a_driven_dead_centre_has_no_velocity():
    system, position = dead_centre()
    pushed = driven(system, position[3, 2], 1.0, body=3)
    with pytest.raises(AssemblyError, match=r"no velocity satisfies .*the drive of follower.*dead centre"):
        velocities(pushed, position)
    held = driven(system, position[3, 2], 0.0, body=3)
    np.testing.assert_array_equal(velocities(held, position), np.zeros((4, 3)))


def test_a_velocity_that_parts_redundant_pins_has_no_acceleration():
    system, position, _ = double_crank()
    velocity = np.zeros((5, 3))
    velocity[1:4, 2] = [4.0, 4.0, 5.0]
    with pytest.raises(AssemblyError, match="no acceleration satisfies") as info:
        accelerations(system, position, velocity, np.zeros((5, 3)))
    assert "B3" in info.value.joints


def test_a_loose_body_moves_as_its_force_says():
    system = rods(("rod",), (0.6,), (2.0,), ())
    position = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    assert close(system, position).iterations == 0
    assert mobility(system, position).free == 3
    np.testing.assert_allclose(velocities(system, position, position), position, rtol=1e-15)
    acceleration, reactions, _ = accelerations(
        system, position, position, np.array([[1.0, 1.0, 1.0], [4.0, 6.0, 0.3]])
    )
    np.testing.assert_allclose(acceleration, [[0.0, 0.0, 0.0], [2.0, 3.0, 5.0]], rtol=1e-14)
    assert reactions.shape == (0, 3)
