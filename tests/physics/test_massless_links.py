"""Massless links: pendulums, trusses and a four-bar whose coupler weighs nothing, against closed forms and
Lagrange's equations.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from independent import circles
from support import go, particle, times
from vfife import simulate
from vfife.kinematics.initial import ideal_motion
from vfife.measures import ledger
from vfife.measures.motion import body_motion
from vfife.model.joints import Distance
from vfife.model.mechanism import Mechanism

G = 9.81


def pendulum(length: float = 1.0, angle: float = math.pi) -> Mechanism:
    """A point mass of 1 kg on a massless link from the origin."""
    m = Mechanism("pendulum", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    m.point_mass("bob", mass=1.0)
    m.distance("rod", "ground.O", "bob.center", length=length, angle=angle)
    return m


def test_a_pendulum_is_where_the_rigid_one_is():
    """1 kg at 1 m from (-1, 0) at rest: place after 1 and 5 s, by elliptic functions."""
    record = go(pendulum(), 1e-4, duration=5.0, outputs=5)
    bob = particle(record, "bob")
    assert (bob["x"][1], bob["y"][1]) == pytest.approx((0.986291751, -0.165010853), abs=2e-7)
    assert (bob["x"][5], bob["y"][5]) == pytest.approx((-0.942305435, -0.334754338), abs=1e-6)
    assert np.hypot(bob["x"], bob["y"]) == pytest.approx(1.0, abs=1e-11)


def test_the_pull_of_a_pendulum():
    """m (g cos + v^2/l) on the way down from the level: 3 m g sin(depth angle), along the link and towards
    its pin.
    """
    record = go(pendulum(angle=0.0), 1e-4, duration=1.0, outputs=50)
    bob = particle(record, "bob")
    force = np.stack([record.block("joint_fx")[:, 0], record.block("joint_fy")[:, 0]])
    place = np.stack([bob["x"], bob["y"]])
    assert force == pytest.approx(3.0 * G * place[1] * place, abs=2e-5)
    assert ledger(record).error < 1e-7


def test_the_error_is_of_second_order():
    def end(step):
        return particle(go(pendulum(), step, duration=1.0, outputs=1), "bob")["y"][-1] + 0.165010853

    assert math.log2(end(4e-3) / end(2e-3)) == pytest.approx(2.0, abs=0.1)


def test_a_double_pendulum_of_point_masses():
    """Masses 1 and 2 kg on links of 0.6 and 0.4 m: Lagrange's equations in the two angles."""
    a, b, m1, m2 = 0.6, 0.4, 1.0, 2.0
    m = Mechanism("double pendulum", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    m.point_mass("first", mass=m1)
    m.point_mass("second", mass=m2)
    m.distance("upper", "ground.O", "first.center", length=a, angle=0.3)
    m.distance("lower", "first.center", "second.center", length=b, angle=-0.5)
    record = go(m, 2e-5, duration=1.0, outputs=1)

    def rates(t, y):
        p, q, u, v = y
        off = m2 * a * b
        matrix = [[(m1 + m2) * a * a, off * math.cos(p - q)], [off * math.cos(p - q), m2 * b * b]]
        right = [
            -off * math.sin(p - q) * v * v - (m1 + m2) * G * a * math.cos(p),
            off * math.sin(p - q) * u * u - m2 * G * b * math.cos(q),
        ]
        return [u, v, *np.linalg.solve(matrix, right)]

    p, q = solve_ivp(rates, (0.0, 1.0), [0.3, -0.5, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y[
        :2, -1
    ]
    end = particle(record, "second")
    assert (end["x"][-1], end["y"][-1]) == pytest.approx(
        (a * math.cos(p) + b * math.cos(q), a * math.sin(p) + b * math.sin(q)), abs=1e-6
    )


# ------------------------------------------------------------------------------------------------------- a
# coupler without mass

CRANK, COUPLER, FOLLOWER, GROUND, SPEED, MASS = 0.1, 0.35, 0.25, 0.3, 40.0, 2.0


def four_bar(coupler: float = 0.0) -> Mechanism:
    """A crank at constant speed turns a follower by a coupler without mass, or of ``coupler`` (kg)."""
    m = Mechanism("four-bar")
    m.point("A", 0.0, 0.0)
    m.point("D", GROUND, 0.0)
    m.link("crank", length=CRANK, mass=1.0)
    m.link("follower", length=FOLLOWER, mass=MASS, angle=math.radians(80.0))
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("D", "ground.D", "follower.start")
    if coupler:
        m.link("coupler", length=COUPLER, mass=coupler, angle=math.radians(40.0))
        m.revolute("B", "crank.end", "coupler.start")
        m.revolute("C", "coupler.end", "follower.end")
    else:
        m.distance("BC", "crank.end", "follower.end", length=COUPLER)
    m.drive("crank", speed=SPEED)
    return m


def angle(time: float) -> float:
    """Angle (rad) of the follower, from two circles."""
    pin = CRANK * np.array([math.cos(SPEED * time), math.sin(SPEED * time)])
    knee = circles(pin, COUPLER, np.array([GROUND, 0.0]), FOLLOWER, 1.0) - np.array([GROUND, 0.0])
    return math.atan2(knee[1], knee[0])


def second(time: float, h: float = 1e-4) -> float:
    """Angular acceleration of the follower, by differences of fourth order."""
    values = [angle(time + k * h) for k in (-2, -1, 0, 1, 2)]
    return float(np.dot([-1.0, 16.0, -30.0, 16.0, -1.0], values)) / (12.0 * h * h)


def test_a_four_bar_whose_coupler_weighs_nothing():
    """The follower's angle and acceleration are those of the circles; the link's force is the follower's
    moment over its lever.
    """
    record = go(four_bar(), 1e-5, turns=1.0, outputs=40)
    body, link = list(record.assembly.bodies).index("follower"), record.assembly.ideals.index("BC")
    at = times(record)[1:]  # at the start forces are known to first order in the step
    expected = np.array([angle(time) for time in at])
    assert body_motion(record)["angle"][1:, body] == pytest.approx(expected, abs=1e-7)
    alpha = np.array([second(time) for time in at])
    assert record.block("body_alpha")[1:, body] == pytest.approx(
        alpha, rel=1e-4, abs=1e-4 * np.abs(alpha).max()
    )
    pin = CRANK * np.stack([np.cos(SPEED * at), np.sin(SPEED * at)], axis=1)
    arm = FOLLOWER * np.stack([np.cos(expected), np.sin(expected)], axis=1)
    along = (arm + [GROUND, 0.0] - pin) / COUPLER
    lever = arm[:, 0] * along[:, 1] - arm[:, 1] * along[:, 0]
    push = MASS * FOLLOWER**2 / 3.0 * alpha / lever
    force = np.stack([record.block(f"joint_{axis}")[1:, link] for axis in ("fx", "fy")], axis=1)
    assert force == pytest.approx(push[:, None] * along, abs=2e-4 * np.abs(push).max())


def test_a_light_coupler_comes_to_the_same():
    light, none = (go(four_bar(mass), 1e-5, turns=0.5, outputs=20) for mass in (1e-4, 0.0))
    torques = [record.block("driven_torque")[:, 0] for record in (light, none)]
    assert torques[0] == pytest.approx(torques[1], abs=3e-4 * np.abs(torques[1]).max())


def test_the_start_knows_accelerations_and_forces():
    """The ideal mechanism: gamma of the row from the kernel's own text, by Taylor numbers."""
    motion = ideal_motion(four_bar(), 0.013)
    assert motion.of("follower")[0][2] == pytest.approx(angle(0.013), abs=1e-12)
    assert motion.of("follower")[2][2] == pytest.approx(second(0.013), rel=1e-6)


# ----------------------------------------------------------------------------------------------------------
# trusses and starts


def truss(diagonals: int) -> Mechanism:
    """A square of four point masses, free in space, with links along its sides and its diagonals."""
    m = Mechanism("truss")
    corners = {"a": (0.0, 0.0), "b": (1.0, 0.0), "c": (1.0, 1.0), "d": (0.0, 1.0)}
    for name, at in corners.items():
        m.point_mass(name, mass=1.0, position=at)
    for k, (first, other) in enumerate(
        [("a", "b"), ("b", "c"), ("c", "d"), ("d", "a"), ("a", "c"), ("b", "d")][: 4 + diagonals]
    ):
        m.distance(
            f"s{k}", f"{first}.center", f"{other}.center", length=math.dist(corners[first], corners[other])
        )
    return m


@pytest.mark.parametrize(("diagonals", "free", "redundant"), [(0, 4, 0), (1, 3, 0), (2, 3, 1)])
def test_mobility_of_a_truss(diagonals, free, redundant):
    """Maxwell's count: 2 n - links, three of them of the whole; turns of the four points are free beside."""
    mobility = ideal_motion(truss(diagonals)).mobility
    assert (mobility.free - 4, mobility.redundant) == (free, redundant)
    assert mobility.redundant_joints == (("s5",) if redundant else ())


def test_a_truss_tumbles_as_a_rigid_body():
    """Spun about its centre, each corner of the braced square goes round at constant speed; the links pull m
    v^2/r between them.
    """
    m = truss(1)
    for name, body in m.bodies.items():
        x, y = body.position
        m.bodies[name] = dataclasses.replace(body, velocity=(-5.0 * (y - 0.5), 5.0 * (x - 0.5), 0.0))
    record = go(m, 1e-4, duration=0.4, outputs=4)
    at = times(record)
    for name, begin in (("a", 1.25), ("c", 0.25)):
        turned = begin * math.pi + 5.0 * at
        corner = particle(record, name)
        assert corner["x"] == pytest.approx(0.5 + math.sqrt(0.5) * np.cos(turned), abs=1e-6)
        assert corner["y"] == pytest.approx(0.5 + math.sqrt(0.5) * np.sin(turned), abs=1e-6)
    force = np.hypot(record.block("joint_fx"), record.block("joint_fy"))
    assert force[1:, :4] == pytest.approx(
        12.5, rel=1e-4
    )  # each corner wants 25 sqrt(1/2) N inwards, half the way from either side
    assert force[1:, 4] == pytest.approx(0.0, abs=1e-3)


def test_two_pins_in_one_place_find_their_distance():
    m = pendulum()
    m.bodies["bob"] = dataclasses.replace(m.bodies["bob"], position=(0.0, 0.0))
    x, y, _ = ideal_motion(m).of("bob")[0]
    assert math.hypot(x, y) == pytest.approx(1.0, abs=1e-12)


def test_a_link_that_cannot_reach_is_named():
    m = Mechanism("apart")
    m.point("A", 0.0, 0.0)
    m.point("B", 3.0, 0.0)
    m.link("arm", length=1.0, mass=1.0)
    m.revolute("A", "ground.A", "arm.start")
    m.distance("tie", "ground.B", "arm.end", length=0.5)
    with pytest.raises(ValueError, match="tie"):
        ideal_motion(m)


def test_a_link_stands_on_its_length():
    """Static: a weight on two links of 5 and 5 at a span of 6 pulls each by W/2 5/4."""
    m = Mechanism("derrick", gravity=(0.0, -10.0))
    m.settings = dataclasses.replace(m.settings, analysis="static")
    m.point("A", -3.0, 0.0)
    m.point("B", 3.0, 0.0)
    m.point_mass("weight", mass=8.0, position=(0.0, -4.0))
    m.distance("left", "ground.A", "weight.center", length=5.0)
    m.distance("right", "ground.B", "weight.center", length=5.0)
    record = simulate(m).record
    force = np.hypot(record.block("joint_fx")[-1], record.block("joint_fy")[-1])
    assert force == pytest.approx(50.0, rel=1e-8)


def test_a_length_is_needed():
    with pytest.raises(TypeError):
        Distance(name="d", bearing="ground.O", journal="bob.center")  # type: ignore[call-arg]
