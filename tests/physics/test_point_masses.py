"""Point masses on rigid arms that weigh nothing: pendulums, a dumb-bell, a coupler with one mass, against
closed forms.
"""

import math

import numpy as np
import pytest

from independent import circles
from support import go, particle, times
from vfife.kinematics.initial import ideal_motion
from vfife.model.bodies import Link, RigidBody, Section
from vfife.model.lumping import rigid_properties
from vfife.model.mechanism import Mechanism
from vfife.model.validation import validate
from vfife.modelfile import dump, loads

G = 9.81


def pendulum(kind: str) -> Mechanism:
    """1 kg at 1 m from its pin, at (-1, 0) at rest."""
    m = Mechanism("pendulum", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    if kind == "body":
        m.rigid_body(
            "arm", mass=1.0, inertia=0.0, center=(1.0, 0.0), pins={"start": (0.0, 0.0)}, angle=math.pi
        )
    elif kind == "masses":
        m.link("arm", length=1.0, mass=0.0, masses={"end": 1.0}, angle=math.pi)
    else:
        m.rigid_body(
            "arm",
            mass=0.0,
            inertia=0.0,
            pins={"start": (0.0, 0.0), "tip": (1.0, 0.0)},
            masses={"tip": 1.0},
            angle=math.pi,
        )
    m.revolute("O", "ground.O", "arm.start")
    return m


@pytest.mark.parametrize("kind", ["body", "masses", "tip"])
def test_a_point_mass_on_a_rigid_arm_swings_as_a_pendulum(kind):
    """Places after 1 and 5 s by elliptic functions; an inertia of a millionth is 5e-7 of the period."""
    m = pendulum(kind)
    validate(m)
    assert loads(dump(m)).bodies == m.bodies
    mass, _, inertia = rigid_properties(m.bodies["arm"])
    assert (mass, inertia) == (1.0, pytest.approx(1e-6))
    assert ideal_motion(m).of("arm")[2][2] == pytest.approx(G, rel=2e-6)
    bob = particle(go(m, 5e-5, duration=5.0, outputs=5), "arm")
    assert (bob["x"][1], bob["y"][1]) == pytest.approx((0.986291751, -0.165010853), abs=1e-5)
    assert (bob["x"][5], bob["y"][5]) == pytest.approx((-0.942305435, -0.334754338), abs=3e-5)


def test_a_dumb_bell_turns_about_its_centre():
    """Two masses on a link without mass: inertia m1 m2/(m1 + m2) l^2; thrown, both go round the centre that
    flies on.
    """
    m = Mechanism("dumb-bell")
    m.link(
        "bar",
        length=0.8,
        mass=0.0,
        masses={"start": 1.0, "end": 3.0},
        velocity=(0.5, 0.0, 6.0),
        position=(0.0, 0.0),
    )
    mass, center, inertia = rigid_properties(m.bodies["bar"])
    assert (mass, center, inertia) == (4.0, pytest.approx((0.6, 0.0)), pytest.approx(0.75 * 0.64))
    record = go(m, 1e-4, duration=0.5, outputs=5)
    bar, t = particle(record, "bar"), times(record)
    assert bar["theta"] == pytest.approx(6.0 * t, abs=1e-12)
    assert (bar["x"][-1], bar["y"][-1]) == pytest.approx((0.6 + 0.25, 3.6 * 0.5), abs=1e-10)


def test_masses_add_to_what_a_body_has():
    """Parallel axes: a rod of 2 kg with 1 kg at its end, and a plate with masses at two pins."""
    mass, center, inertia = rigid_properties(Link(name="rod", length=1.0, mass=2.0, masses={"end": 1.0}))
    assert (mass, center[0]) == (3.0, pytest.approx(2.0 / 3.0))
    assert inertia == pytest.approx(2.0 / 12.0 + 2.0 / 3.0 * 0.25)
    plate = RigidBody(
        name="plate",
        mass=2.0,
        inertia=0.1,
        center=(0.1, 0.0),
        pins={"a": (1.0, 0.0), "b": (0.0, 2.0)},
        masses={"a": 1.0, "b": 1.0},
    )
    at, weight = np.array([(0.1, 0.0), (1.0, 0.0), (0.0, 2.0)]), np.array([2.0, 1.0, 1.0])
    middle = weight @ at / 4.0
    mass, center, inertia = rigid_properties(plate)
    assert (mass, center) == (4.0, pytest.approx(tuple(middle)))
    assert inertia == pytest.approx(0.1 + weight @ ((at - middle) ** 2).sum(axis=1))


def test_masses_that_are_changed_in_place_count_at_once():
    """A body keeps what it weighs; what its tables hold is looked at each time."""
    rod = Link(name="rod", length=1.0, mass=2.0, pins={"tip": (1.0, 0.0)}, masses={"tip": 1.0})
    assert rigid_properties(rod)[:2] == (3.0, (pytest.approx(2.0 / 3.0), 0.0))
    rod.masses["tip"] = 4.0
    assert rigid_properties(rod)[:2] == (6.0, (pytest.approx(5.0 / 6.0), 0.0))
    rod.pins["tip"] = (2.0, 0.0)
    assert rigid_properties(rod)[:2] == (6.0, (pytest.approx(9.0 / 6.0), 0.0))
    rod.masses["start"] = 6.0
    assert rigid_properties(rod)[:2] == (12.0, (pytest.approx(0.75), 0.0))


def test_the_torque_that_a_mass_on_a_coupler_asks_for():
    """A crank at constant speed, a coupler without mass that carries 1.5 kg in its middle, a follower: T w =
    d/dt of their kinetic energy.
    """
    crank, coupler, follower, ground, speed, load, heavy = 0.1, 0.35, 0.25, 0.3, 20.0, 1.5, 2.0
    m = Mechanism("four-bar")
    m.point("A", 0.0, 0.0)
    m.point("D", ground, 0.0)
    m.link("crank", length=crank, mass=1.0)
    m.link(
        "coupler",
        length=coupler,
        mass=0.0,
        pins={"mid": (0.5 * coupler, 0.0)},
        masses={"mid": load},
        angle=math.radians(40.0),
    )
    m.link("follower", length=follower, mass=heavy, angle=math.radians(80.0))
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    m.revolute("C", "coupler.end", "follower.end")
    m.revolute("D", "ground.D", "follower.start")
    m.drive("crank", speed=speed)
    record = go(m, 3e-6, turns=0.5, outputs=24)

    def state(time: float) -> tuple[np.ndarray, float]:
        pin = crank * np.array([math.cos(speed * time), math.sin(speed * time)])
        knee = circles(pin, coupler, np.array([ground, 0.0]), follower, 1.0)
        return 0.5 * (pin + knee), math.atan2(knee[1], knee[0] - ground)

    def energy(time: float, h: float = 1e-4) -> float:
        (p, a), (q, b) = state(time - h), state(time + h)
        return (0.5 * load * ((q - p) @ (q - p)) + 0.5 * heavy * follower**2 / 3.0 * (b - a) ** 2) / (
            4.0 * h * h
        )

    at = times(record)[1:]
    expected = np.array([(energy(time + 1e-4) - energy(time - 1e-4)) / 2e-4 / speed for time in at])
    found = record.block("driven_torque")[1:, 0]
    assert found == pytest.approx(expected, abs=2e-4 * np.abs(expected).max())


def test_what_weighs_nothing_is_refused():
    for body, said in (
        (Link(name="b", length=1.0, mass=0.0), "has no mass"),
        (Link(name="b", length=1.0, mass=0.0, model="elastic", section=Section.square(1e-4)), "needs a mass"),
        (RigidBody(name="b", mass=1.0, inertia=0.0), "neither inertia"),
        (RigidBody(name="b", mass=1.0, inertia=0.1, masses={"nowhere": 1.0}), "no pin"),
    ):
        m = Mechanism("nothing")
        m.bodies["b"] = body
        with pytest.raises(ValueError, match=said):
            validate(m)
