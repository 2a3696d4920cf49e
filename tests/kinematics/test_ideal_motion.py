"""The ideal motion of mechanisms with guides, gears, springs and drivers of every kind, against published
values and closed forms.
"""

import dataclasses
import math

import numpy as np
import pytest

from kinematics.turns import extremes
from vfife.assembly.prestress import prestress
from vfife.kinematics.drives import constraint_drivers, kinematic_drivers
from vfife.kinematics.initial import ideal_motion
from vfife.model.drivers import AngleTable, ConstantSpeed, Harmonic, Ramp, StepTo, Torque
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.results.continuation import start_from
from vfife.simulation.simulate import simulate


def slider_crank(
    crank=0.05,
    rod=0.12,
    masses=(0.30, 0.21, 0.14),
    inertias=(1e-4, 2.5e-4, 1e-4),
    gravity=0.0,
    angle=0.0,
    speed=None,
):
    m = Mechanism("slider-crank", gravity=(0.0, -gravity))
    m.point("O", 0.0, 0.0)
    m.link("crank", length=crank, mass=masses[0], inertia=inertias[0], angle=angle)
    m.link(
        "rod",
        length=rod,
        mass=masses[1],
        inertia=inertias[1],
        angle=-math.asin(crank / rod * math.sin(angle)),
    )
    m.rigid_body("slider", mass=masses[2], inertia=inertias[2])
    m.revolute("A", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "rod.start")
    m.revolute("C", "rod.end", "slider.center")
    m.slider("guide", "ground.O", "slider.center")
    if speed is not None:
        m.drive("crank", speed=speed)
    return m


def turn(m, speed):
    """Least and largest acceleration of the slider, forces in B and C, and torque over one turn."""

    def at(angle, guess):
        motion = ideal_motion(m, angle / speed, guess)
        size = [math.hypot(*motion.reaction[joint][:2]) for joint in "BC"]
        return [motion.of("slider")[2][0], *size, motion.torque["crank"]], motion.position

    return extremes(at).T


def test_slider_crank_of_the_clearance_literature():
    speed = 5000.0 * 2.0 * math.pi / 60.0
    a, crank_rod, rod_slider, torque = turn(slider_crank(speed=speed), speed)
    assert a == pytest.approx((-19419.4, 9695.9), rel=1e-5)
    assert rod_slider[1] == pytest.approx(2718.7, rel=1e-4)
    assert crank_rod[1] == pytest.approx(6197.1, rel=1e-4)
    assert torque == pytest.approx((-138.5, 138.5), rel=1e-3)


def test_slider_crank_of_flores_leine_and_glocker():
    m = slider_crank(0.1530, 0.3060, (0.038, 0.038, 0.076), (7.4e-5, 5.9e-4, 2.7e-6), 9.81, speed=150.0)
    a, crank_rod, rod_slider, torque = turn(m, 150.0)
    assert a == pytest.approx((-5163.75, 2612.59), rel=1e-5)
    assert rod_slider[1] == pytest.approx(392.4, rel=2e-4)
    assert crank_rod[1] == pytest.approx(556.0, rel=2e-4)
    assert torque == pytest.approx((-42.9, 43.0), rel=2e-3)


@pytest.mark.parametrize("angle", [0.3, 1.4, 3.0, 5.0])
def test_slider_crank_in_closed_form(angle):
    """x = r cos + sqrt(l^2 - r^2 sin^2), its derivatives, and the power that the driver supplies."""
    r, length, w = 0.05, 0.12, 40.0
    motion = ideal_motion(slider_crank(angle=angle, speed=w))
    s, c = math.sin(angle), math.cos(angle)
    root = math.sqrt(length**2 - r**2 * s**2)
    first = -r * s - r**2 * s * c / root
    second = -r * c - r**2 * (c**2 - s**2) / root - r**4 * s**2 * c**2 / root**3
    x, v, a = motion.of("slider")
    assert x == pytest.approx([r * c + root, 0.0, 0.0], abs=1e-14)
    assert v == pytest.approx([w * first, 0.0, 0.0], abs=1e-12)
    assert a == pytest.approx([w**2 * second, 0.0, 0.0], abs=1e-9)
    assert motion.reaction["guide"][1] == pytest.approx(-motion.reaction["C"][1], rel=1e-12)
    assert motion.reaction["guide"][0] == motion.reaction["C"][2] == 0.0
    power = 0.0
    for name, mass, inertia in (("crank", 0.30, 1e-4), ("rod", 0.21, 2.5e-4), ("slider", 0.14, 1e-4)):
        _, v, a = motion.of(name)
        power += mass * v[:2] @ a[:2] + inertia * v[2] * a[2]
    assert motion.torque["crank"] * w == pytest.approx(power, rel=1e-11)


def test_a_load_off_the_block_is_carried_by_the_guide():
    m = slider_crank(angle=0.7, speed=0.0)
    m.bodies["slider"] = dataclasses.replace(m.bodies["slider"], pins={"ear": (0.03, 0.01)})
    m.loads["p"] = PointForce(name="p", at="slider.ear", force=(0.0, -80.0), moment=0.5)
    motion = ideal_motion(m)
    assert motion.reaction["guide"][2] == pytest.approx(80.0 * 0.03 - 0.5, rel=1e-12)


def test_the_mirror_image_starts_from_the_same_bits():
    one, two = slider_crank(angle=0.7, speed=30.0), slider_crank(angle=-0.7, speed=-30.0)
    p, q = ideal_motion(one), ideal_motion(two)
    flip = np.array([1.0, -1.0, -1.0])
    assert np.array_equal(p.position * flip, q.position)
    assert np.array_equal(p.velocity * flip, q.velocity)
    assert np.array_equal(p.acceleration * flip, q.acceleration)
    for joint, (fx, fy, moment) in p.reaction.items():
        assert q.reaction[joint] == (fx, -fy, -moment)
    assert q.torque["crank"] == -p.torque["crank"]


# ---------------------------------------------------------------------------------------------------- drivers


@pytest.mark.parametrize(
    "driver",
    [
        Harmonic(slider="guide", amplitude=0.01, frequency=20.0, phase=0.4),
        StepTo(slider="guide", travel=-0.03, duration=0.05, begin=0.01),
        Ramp(point="slider.center", direction=(2.0, 0.0), speed=-1.0, duration=0.02),
        AngleTable(slider="guide", times=(0.0, 0.01, 0.02), values=(0.0, 0.004, -0.002)),
        ConstantSpeed(point="rod.end", speed=0.8),
    ],
)
def test_a_driven_slider_counts_from_the_start(driver):
    """Travel counts from the closed start; velocity and acceleration are its rates; the force's power is that
    of all bodies.
    """
    m = slider_crank(angle=0.7)
    start = ideal_motion(m).of("slider")[0][0]
    m.drivers["press"] = driver
    assert kinematic_drivers(m) == {}
    assert list(constraint_drivers(m)) == ["press"]
    h, time = 1e-4, 0.013
    x = []
    for k in (-2, -1, 0, 1, 2):
        motion = ideal_motion(m, time + k * h)
        x.append(motion.of("slider")[0][0])
        if k == 0:
            now = motion
    assert ideal_motion(m).of("slider")[0][0] == pytest.approx(start, abs=1e-12)
    _, v, a = now.of("slider")
    assert v[0] == pytest.approx((8 * (x[3] - x[1]) - x[4] + x[0]) / (12 * h), rel=1e-6, abs=1e-9)
    assert a[0] == pytest.approx(
        (16 * (x[3] + x[1]) - x[4] - x[0] - 30 * x[2]) / (12 * h * h), rel=1e-4, abs=1e-3
    )
    power = 0.0
    for name, mass, inertia in (("crank", 0.30, 1e-4), ("rod", 0.21, 2.5e-4), ("slider", 0.14, 1e-4)):
        _, u, b = now.of(name)
        power += mass * u[:2] @ b[:2] + inertia * u[2] * b[2]
    assert now.torque["press"] * v[0] == pytest.approx(power, rel=1e-9)


def test_a_driver_between_two_bodies():
    """A knee driven at constant speed while the thigh is held: the shank turns by it, and the thigh's driver
    takes the opposite torque.
    """
    m = Mechanism("leg", gravity=(0.0, -9.81))
    m.point("hip", 0.0, 0.0)
    m.link("thigh", length=0.4, mass=3.0, angle=-1.2)
    m.link("shank", length=0.4, mass=2.0, angle=-1.6)
    m.revolute("H", "ground.hip", "thigh.start")
    m.revolute("K", "thigh.end", "shank.start")
    m.drive("thigh", speed=2.0)
    m.drivers["knee"] = ConstantSpeed(body="shank", against="thigh", speed=-5.0)
    motion = ideal_motion(m, 0.1)
    assert motion.of("shank")[0][2] == pytest.approx(-1.6 + 0.1 * (2.0 - 5.0), abs=1e-14)
    assert motion.of("shank")[1][2] == pytest.approx(-3.0, abs=1e-13)
    power = 0.0
    for name, mass in (("thigh", 3.0), ("shank", 2.0)):
        _, v, a = motion.of(name)
        power += mass * (v[:2] @ a[:2] + 9.81 * v[1])
    assert motion.torque["thigh"] * 2.0 + motion.torque["knee"] * -5.0 == pytest.approx(power, rel=1e-11)


# ---------------------------------------------------------------------------------------------------- gears,
# springs, loads


def rod(**options):
    m = Mechanism("rod")
    m.point("O", 0.0, 0.0)
    m.point("S", 0.6, 0.8)
    m.link("rod", length=0.6, mass=2.0, angle=0.4, **options)
    m.revolute("A", "ground.O", "rod.start")
    return m


INERTIA = 2.0 * 0.6**2 / 3.0


def test_spring_and_damper_at_the_start():
    """The moment of k (l - l0) + c dl/dt about the pivot, dl/dt from the law of cosines."""
    m = rod(velocity=(0.0, 0.0, 3.0))
    m.spring("s", "rod.end", "ground.S", stiffness=500.0, damping=20.0, free_length=0.3)
    between = math.atan2(0.8, 0.6) - 0.4
    length = math.sqrt(0.36 + 1.0 - 1.2 * math.cos(between))
    rate = -1.2 * math.sin(between) * 3.0 / (2.0 * length)
    pull = 500.0 * (length - 0.3) + 20.0 * rate
    alpha = pull * 0.6 * math.sin(between) / length / INERTIA
    assert ideal_motion(m).of("rod")[2][2] == pytest.approx(alpha, rel=1e-11)
    m.springs.clear()
    m.spring("s", "rod.end", "ground.S", stiffness=500.0)
    assert ideal_motion(m).of("rod")[2][2] == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize(
    ("add", "moment"),
    [
        (
            lambda m: m.torsional_spring("t", "ground", "rod", stiffness=30.0, damping=2.0, free_angle=0.1),
            -30.0 * 0.3 - 2.0 * 3.0,
        ),
        (lambda m: m.torsional_spring("t", "ground", "rod", stiffness=30.0, damping=2.0), -2.0 * 3.0),
        (
            lambda m: m.stop("t", "ground", "rod", low=-1.0, high=0.3, stiffness=100.0, damping=1.0),
            -100.0 * 0.1 - 3.0,
        ),
        (
            lambda m: m.stop("t", "ground", "rod", low=0.5, high=0.9, stiffness=100.0, damping=1.0),
            100.0 * 0.1 - 3.0,
        ),
        (
            lambda m: m.stop("t", "ground", "rod", low=0.5, high=0.9, stiffness=20.0, damping=1.0),
            0.0,
        ),  # it would pull back
        (lambda m: m.stop("t", "ground", "rod", low=-1.0, high=1.0, stiffness=100.0, damping=1.0), 0.0),
        (
            lambda m: m.bushing(
                "t", "ground.O", "rod.start", stiffness=(1e3, 1e3, 50.0), damping=(9.0, 9.0, 4.0)
            ),
            -12.0,
        ),
        (lambda m: m.drivers.update(t=Torque(body="rod", value=(1.0, 5.0), speeds=(0.0, 4.0))), 4.0),
        (lambda m: m.drivers.update(t=Torque(body="rod", value=(1.0, 5.0), speeds=(0.0, 2.0))), 5.0),
        (lambda m: m.drivers.update(t=Torque(body="rod", value=(1.0, 5.0), angles=(-1.0, 1.0))), 3.0),
        (
            lambda m: m.drivers.update(t=Torque(body="", point="rod.end", direction=(0.0, 3.0), value=2.0)),
            2.0 * 0.6 * math.cos(0.4),
        ),
        (
            lambda m: m.loads.update(t=PointForce(name="t", at="rod.end", force=(1.0, 7.0), follow=True)),
            0.6 * 7.0,
        ),
    ],
)
def test_moments_at_the_start(add, moment):
    m = rod(velocity=(0.0, 0.0, 3.0))
    add(m)
    motion = ideal_motion(m)
    assert motion.of("rod")[1][2] == pytest.approx(3.0, rel=1e-13)
    assert motion.of("rod")[2][2] * INERTIA == pytest.approx(moment, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize(("damping", "moment"), [(0.1, -0.7), (1.0, 0.0)])
def test_a_stop_lets_go_of_what_leaves_it_fast(damping, moment):
    """Beyond the upper end by 0.1 rad and leaving at 3 rad/s: -10 0.1 + 3 c, and nothing where that would
    pull back.
    """
    m = rod(velocity=(0.0, 0.0, -3.0))
    m.stop("t", "ground", "rod", low=-1.0, high=0.3, stiffness=10.0, damping=damping)
    assert ideal_motion(m).of("rod")[2][2] * INERTIA == pytest.approx(moment, abs=1e-11)


def test_a_bushing_carries_a_displaced_body():
    """Two free bodies, pins apart: forces -K d in the first body's axes, equal and opposite, moments about
    the second pin's place.
    """
    m = Mechanism("bushing")
    m.rigid_body("a", mass=1.0, inertia=0.1, angle=0.5, pins={"p": (0.2, 0.0)}, position=(0.0, 0.0))
    m.rigid_body("b", mass=2.0, inertia=0.3, angle=1.5, pins={"q": (-0.1, 0.1)}, position=(0.5, 0.4))
    m.bushing("e", "a.p", "b.q", stiffness=(1000.0, 300.0, 9.0))
    motion = ideal_motion(m)
    ca, cb = np.exp(0.5j), np.exp(1.5j)
    p, q = 0.2 * ca, 0.5 + 0.4j + (-0.1 + 0.1j) * cb
    d = (q - p) / ca
    f = -(1000.0 * d.real + 300.0j * d.imag) * ca
    arm = q - (0.5 + 0.4j)
    assert complex(*motion.of("b")[2][:2]) == pytest.approx(f / 2.0, rel=1e-12)
    assert complex(*motion.of("a")[2][:2]) == pytest.approx(-f, rel=1e-12)
    assert motion.of("b")[2][2] == pytest.approx((np.conj(arm) * f).imag / 0.3, rel=1e-12)
    assert motion.of("a")[2][2] == pytest.approx(-(np.conj(q) * f).imag / 0.1, rel=1e-12)


def test_gears_between_links_share_a_torque():
    m = rod()
    m.point("P", 1.0, 0.0)
    m.link("wheel", length=0.3, mass=1.0, angle=2.0)
    m.revolute("B", "ground.P", "wheel.start")
    m.gear("teeth", "rod", "wheel", ratio=-2.0)
    m.drivers["rod"] = Torque(body="rod", value=6.0)
    motion = ideal_motion(m)
    other = 1.0 * 0.3**2 / 3.0
    alpha = 6.0 / (INERTIA + 4.0 * other)
    assert motion.of("rod")[0][2] == pytest.approx(0.4, abs=1e-14)
    assert [motion.of(name)[2][2] for name in ("rod", "wheel")] == pytest.approx(
        [alpha, -2.0 * alpha], rel=1e-12
    )
    assert motion.reaction["teeth"] == pytest.approx((0.0, 0.0, -2.0 * alpha * other), rel=1e-12)


def test_a_torque_against_another_body_acts_on_both():
    m = Mechanism("pair")
    m.rigid_body("a", mass=1.0, inertia=0.1)
    m.rigid_body("b", mass=1.0, inertia=0.4)
    m.drivers["motor"] = Torque(body="b", against="a", value=2.0)
    motion = ideal_motion(m)
    assert (motion.of("a")[2][2], motion.of("b")[2][2]) == pytest.approx((-20.0, 5.0), rel=1e-13)


def test_a_guide_of_no_length_is_refused():
    m = slider_crank()
    m.joints["guide"] = dataclasses.replace(m.joints["guide"], direction=(0.0, 0.0))
    with pytest.raises(ValueError, match="guide: the direction .* has no length"):
        ideal_motion(m)


def test_prestressed_link_carries_its_spring():
    """A still elastic rod between pivot and spring along it: the spring's pull is its axial force."""
    from support import SQUARE

    m = Mechanism("pulled")
    m.point("O", 0.0, 0.0)
    m.point("S", 1.0, 0.0)
    m.link("rod", length=0.5, mass=1.0, model="elastic", elements=3, section=SQUARE)
    m.revolute("A", "ground.O", "rod.start")
    m.spring("s", "rod.end", "ground.S", stiffness=2e4, free_length=0.2)
    shape = prestress(m, {}).shapes["rod"]
    assert shape.axial == pytest.approx(np.full(3, 2e4 * 0.3), rel=1e-3)


# ------------------------------------------------------------------------------------------------------------
# given starts


def four_bar(speed=10.0):
    m = Mechanism("four-bar")
    m.point("A", 0.0, 0.0)
    m.point("D", 0.15, 0.0)
    m.link("crank", length=0.4, mass=3.12)
    m.link("coupler", length=0.26, mass=2.028, angle=0.9)
    m.link("follower", length=0.46, mass=3.588, angle=0.45)
    for name, one, two in (("A", "ground.A", "crank.start"), ("B", "crank.end", "coupler.start"),
                           ("C", "coupler.end", "follower.end"),
                           ("D", "ground.D", "follower.start")):  # fmt: skip
        m.revolute(name, one, two)
    if speed is not None:
        m.drive("crank", speed=speed)
    return m


def test_a_start_from_a_former_run_goes_on_with_its_motion():
    result = simulate(four_bar(), duration=0.2, outputs=100, loop="interpreted", step=1e-3, reference=False)
    time = float(result.time[len(result.time) // 2])
    there = ideal_motion(four_bar(), time, ideal_motion(four_bar(), 0.1).position)
    motion = start_from(result, four_bar(), time)
    assert motion.position == pytest.approx(there.position, abs=1e-5)
    assert motion.velocity == pytest.approx(there.velocity, abs=1e-3)
    assert motion.of("crank")[0][2] == pytest.approx(10.0 * time, abs=1e-9)
    released = start_from(result, four_bar(None), time)  # without its driver it coasts at the speed it has
    assert released.velocity == pytest.approx(there.velocity, abs=1e-2)
    with pytest.raises(ValueError, match=r"there is no state at 9 s"):
        start_from(result, four_bar(), 9.0)


def test_a_start_by_name_is_closed_and_its_velocities_projected():
    m = four_bar(None)
    exact = ideal_motion(four_bar(), 0.08, ideal_motion(four_bar(), 0.04).position)
    state = {}
    for name in ("crank", "coupler", "follower"):
        p, v, _ = exact.of(name)
        half = 0.5 * m.bodies[name].length
        arm = half * np.array([math.cos(p[2]), math.sin(p[2])])
        state[name] = (
            (*(p[:2] - arm + 1e-3), p[2] - 2e-3),
            (*(v[:2] + v[2] * np.array([arm[1], -arm[0]])), v[2]),
        )
    motion = start_from(state, m)
    assert motion.position == pytest.approx(exact.position, abs=5e-3)
    ends = motion.of("crank")[0][:2] * 2.0
    assert np.hypot(*ends) == pytest.approx(0.4, abs=1e-12)
    assert motion.velocity[:, 2] == pytest.approx(exact.velocity[:, 2], rel=0.05)
    with pytest.raises(ValueError, match="bodies crank, wing"):
        start_from({"crank": (0, 0, 0), "wing": (0, 0, 0)}, m)
    with pytest.raises(ValueError, match=r"start of 'crank' must be \(x, y, angle\)"):
        start_from({"crank": (0, 0)}, m)


def test_a_given_start_leaves_journals_where_they_are():
    m = four_bar(None)
    from vfife.model.joints import ClearanceRevolute

    m.joints["C"] = ClearanceRevolute(
        name="C", bearing="coupler.end", journal="follower.end", clearance=5e-4, bearing_radius=0.01
    )
    exact = ideal_motion(four_bar(), 0.0)
    state = {}
    for name in ("crank", "coupler", "follower"):
        p = exact.of(name)[0]
        half = 0.5 * m.bodies[name].length
        turn = p[2] + (1e-3 if name == "follower" else 0.0)
        at = (
            (0.15, 0.0)
            if name == "follower"
            else (p[0] - half * math.cos(p[2]), p[1] - half * math.sin(p[2]))
        )
        state[name] = (*at, turn)
    motion = start_from(state, m)
    assert motion.of("follower")[0][2] - exact.of("follower")[0][2] == pytest.approx(1e-3, abs=1e-12)
    assert "C" not in motion.reaction
