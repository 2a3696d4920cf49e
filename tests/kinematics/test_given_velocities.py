"""Start velocities that are given but do not fit the joints: a rate holds and the origin follows, or a
caution says what a run starts with.
"""

import dataclasses
import math

import numpy as np
import pytest

import vfife
from vfife.kinematics.initial import ideal_motion, ideal_motions

LENGTH, STROKE, SPEED = 0.25, 0.03, 10.0


def on_yoke(angle=-90.0, velocity=(0.0, 0.0, 0.0), mirror=1.0):
    """A pendulum whose hinge moves with 0.03 m * 10 rad/s at the start; its mirror image at the x axis has
    ``mirror`` = -1.
    """
    m = vfife.Mechanism("pendulum on a yoke", gravity=(0.0, -9.81 * mirror))
    ground = m.point("O", 0.0, 0.0)
    crank = m.link("crank", length=STROKE, mass=0.1, angle=math.radians(-90.0) * mirror)
    car = m.rigid_body("car", mass=1.0, inertia=0.01, position=(0.0, 0.0))
    rod = m.link("rod", length=LENGTH, mass=0.4, angle=math.radians(angle) * mirror, velocity=velocity)
    m.revolute("shaft", ground, crank.start)
    m.slider("slot", car.pin(), crank.end, direction=(0, 1), turning=True)
    m.slider("rail", ground, car.pin())
    m.revolute("hinge", car.pin(), rod.start)
    m.drive(crank, speed=SPEED * mirror)
    return m


@pytest.mark.parametrize("angle", [-90.0, -60.0, -137.0, 20.0])
@pytest.mark.parametrize("rate", [-6.0, 0.5, 6.0])
def test_a_given_rate_holds_and_the_centre_moves_with_the_hinge(angle, rate):
    """Closed form: the centre has u + w x r, with the velocity u of the hinge."""
    motion = ideal_motion(on_yoke(angle, (0.0, 0.0, rate)))
    theta, hinge = math.radians(angle), STROKE * SPEED
    x, y = 0.5 * LENGTH * math.cos(theta), 0.5 * LENGTH * math.sin(theta)
    assert motion.of("rod")[1] == pytest.approx([hinge - rate * y, rate * x, rate], rel=1e-12, abs=1e-12)
    assert motion.of("car")[1] == pytest.approx([hinge, 0.0, 0.0], abs=1e-12)
    assert not motion.misfits


def test_a_run_starts_with_the_given_rate_without_a_caution():
    m = on_yoke(velocity=(0.0, 0.0, -6.0))
    run = vfife.simulate(m, turns=0.1, companions=0, reference=False)
    assert run["rod.angular_velocity"].values[0] == pytest.approx(-6.0, rel=1e-9)
    assert "instead of" not in str(run) + str(m.check())


def test_velocities_that_fit_and_defaults_keep_their_bits(monkeypatch):
    """Neither is changed by what holds rates."""
    fitting = (STROKE * SPEED, 0.0, -6.0)
    found = [ideal_motion(on_yoke(velocity=velocity)).velocity for velocity in (fitting, (0.0, 0.0, 0.0))]
    monkeypatch.setattr("vfife.kinematics.initial.with_rates", lambda *_: pytest.fail("nothing to hold"))
    again = [ideal_motion(on_yoke(velocity=velocity)).velocity for velocity in (fitting, (0.0, 0.0, 0.0))]
    assert all(map(np.array_equal, found, again))
    assert found[0][3, 2] == pytest.approx(-6.0) and found[1][3, 2] == pytest.approx(-1.8)


def test_bits_are_the_same_in_a_batch_and_in_the_mirror():
    rates = (-6.0, 0.0, 2.0)
    models = [on_yoke(-60.0, (0.0, 0.0, rate)) for rate in rates]
    for model, motion in zip(models, ideal_motions(models), strict=True):
        assert np.array_equal(motion.velocity, ideal_motion(model).velocity)
    image = ideal_motion(on_yoke(-60.0, (0.0, 0.0, 6.0), mirror=-1.0))
    assert np.array_equal(image.velocity * (1.0, -1.0, -1.0), ideal_motion(models[0]).velocity)


def double(first, second):
    """The pendulum with a second rod at its end."""
    m = on_yoke(-70.0, (0.0, 0.0, first))
    lower = m.link("lower", length=0.2, mass=0.3, angle=math.radians(-110.0), velocity=(0.0, 0.0, second))
    m.revolute("knee", m.bodies["rod"].end, lower.start)
    return m


def test_rates_of_several_bodies_hold_together():
    motion = ideal_motion(double(-3.0, 5.0))
    assert motion.of("rod")[1][2] == pytest.approx(-3.0) and motion.of("lower")[1][2] == pytest.approx(5.0)
    assert not motion.misfits
    upper, lower = motion.of("rod"), motion.of("lower")
    tip = upper[1][:2] - 3.0 * 0.5 * LENGTH * np.array([-math.sin(upper[0][2]), math.cos(upper[0][2])])
    arm = 5.0 * 0.1 * np.array([-math.sin(lower[0][2]), math.cos(lower[0][2])])
    assert lower[1][:2] == pytest.approx(tip + arm, abs=1e-12)


def test_of_rates_that_contradict_each_other_the_first_holds_and_the_other_has_a_caution():
    m = double(-3.0, 5.0)
    del m.joints["knee"]
    m.weld("stiff", "rod.end", "lower.start")
    motion = ideal_motion(m)
    assert [motion.of(name)[1][2] for name in ("rod", "lower")] == pytest.approx([-3.0, -3.0])
    text = "lower starts with -3 rad/s instead of 5 rad/s"
    assert [misfit.fact for misfit in motion.misfits] == [text] and text in str(m.check())


def test_a_velocity_that_joints_do_not_permit_has_a_caution_in_check_and_run():
    m = on_yoke(velocity=(0.5, 0.0, -6.0))
    run = vfife.simulate(m, turns=0.1, companions=0, reference=False)
    text = "origin of rod starts with (0.3, 0) m/s instead of (0.5, 0) m/s"
    for answer in (str(m.check()), str(run)):
        words = " ".join(answer.split())
        assert text in words and "give its origin the velocity of its pin" in words
    near = dataclasses.replace(m.bodies["rod"], velocity=(0.302, 0.0, -6.0))  # within 1 %
    m.bodies["rod"] = near
    assert "instead of" not in str(m.check())


def test_a_rate_shared_with_a_body_at_rest_has_a_caution():
    """The wheel of a gear pair, whose other wheel is given none: its origin rests, so this is an impulse."""
    m = vfife.Mechanism("gears")
    wheel = m.rigid_body("wheel", mass=1.0, inertia=0.02, position=(0.0, 0.0), velocity=(0.0, 0.0, 9.0))
    pinion = m.rigid_body("pinion", mass=0.5, inertia=0.004, position=(1.0, 0.0))
    m.revolute("A", m.point("A", 0.0, 0.0), wheel.pin())
    m.revolute("B", m.point("B", 1.0, 0.0), pinion.pin())
    m.gear("mesh", "wheel", "pinion", ratio=-2.5)
    rate = 9.0 * 0.02 / (0.02 + 0.004 * 2.5**2)
    assert ideal_motion(m).of("wheel")[1][2] == pytest.approx(rate)
    run = vfife.simulate(m, duration=0.01)
    assert "wheel starts with 4 rad/s instead of 9 rad/s" in " ".join(str(run).split())
    m.bodies["pinion"] = dataclasses.replace(pinion, velocity=(0.0, 0.0, -22.5))
    assert not ideal_motion(m).misfits
