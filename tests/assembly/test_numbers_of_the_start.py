"""What bodies, joints and drivers become in the start state: masses, places, arms and offsets,
each by hand.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.assembly.fill import point_motion
from vfife.model.mechanism import Mechanism

G = (1.5, -9.0)  # m/s^2


def cranked() -> Assembly:
    """A driven body with its centre off the axis, a rod on it, and a block in a guide of the rod."""
    m = Mechanism("cranked", gravity=G)
    m.point("O", 0.5, -0.25)
    m.rigid_body(
        "crank",
        mass=2.0,
        inertia=0.3,
        angle=0.4,
        center=(0.1, 0.2),
        pins={"axis": (0.0, 0.0), "p": (0.3, -0.1)},
    )
    m.rigid_body(
        "rod",
        mass=0.5,
        inertia=0.02,
        angle=1.1,
        center=(0.05, -0.02),
        pins={"a": (0.0, 0.0), "b": (0.2, 0.1)},
    )
    m.rigid_body("block", mass=0.25, inertia=0.001, angle=1.1, position=(0.9, 0.0), pins={"c": (0.01, 0.03)})
    m.revolute("O", "ground.O", "crank.axis")
    m.revolute("P", "crank.p", "rod.a")
    m.slider("guide", "rod.b", "block.c", direction=(0.6, 0.8))
    m.spring("k", "ground.O", "block.center", stiffness=100.0)
    m.torsional_spring("t", "ground", "rod", stiffness=3.0)
    m.drive("crank", speed=20.0)
    return assemble(m, 1e-4, duration=0.01, force_step=True)


def numbers(assembly: Assembly, name: str) -> np.ndarray:
    return assembly.state[assembly.layout[name]]


def test_masses_weights_and_the_driven_body_by_hand() -> None:
    """About its pivot the crank has I + m r^2 and the moment m r; the weight of each body is m g at its
    particle.
    """
    assembly = cranked()
    names = list(assembly.bodies)
    at = {name: assembly.bodies[name].particles[0] for name in names}
    for name, mass, inertia in (("rod", 0.5, 0.02), ("block", 0.25, 0.001)):
        assert numbers(assembly, "particle_inverse_mass")[at[name]] == 1.0 / mass
        assert numbers(assembly, "particle_inverse_inertia")[at[name]] == 1.0 / inertia
        for axis, g in zip("xy", G, strict=True):
            assert numbers(assembly, f"particle_load_{axis}")[at[name]] == mass * g
    assert (
        numbers(assembly, "particle_inverse_mass")[at["crank"]]
        == 0.0
        == numbers(assembly, "particle_inverse_inertia")[at["crank"]]
    )
    assert numbers(assembly, "driven_inertia")[0] == pytest.approx(0.3 + 2.0 * (0.1**2 + 0.2**2), rel=1e-14)
    moment = [numbers(assembly, f"driven_moment_{axis}")[0] for axis in "xy"]
    assert moment == pytest.approx([0.2, 0.4], rel=1e-14)
    assert [numbers(assembly, f"driven_weight_{axis}")[0] for axis in "xy"] == list(G)
    assert (numbers(assembly, "driven_angle")[0], numbers(assembly, "driven_speed")[0]) == (0.4, 20.0)


def test_places_and_velocities_follow_the_crank() -> None:
    """The crank's particle is on its axis; the rod's first pin goes round with the crank's."""
    assembly = cranked()
    at = {name: assembly.bodies[name].particles[0] for name in assembly.bodies}
    x, y, theta, u, v, w = (
        numbers(assembly, f"particle_{name}") for name in ("x", "y", "theta", "u", "v", "w")
    )
    assert (x[at["crank"]], y[at["crank"]], theta[at["crank"]], w[at["crank"]]) == pytest.approx(
        (0.5, -0.25, 0.4, 20.0), rel=1e-12
    )
    c, s = math.cos(0.4), math.sin(0.4)
    arm = c * 0.3 + s * 0.1, s * 0.3 - c * 0.1
    k = at["rod"]
    off = [assembly.bodies["rod"].reference[j] - 0.0 for j in (0, 1)]
    rx = math.cos(theta[k]) * off[0] - math.sin(theta[k]) * off[1]
    ry = math.sin(theta[k]) * off[0] + math.cos(theta[k]) * off[1]
    assert (x[k] - rx, y[k] - ry) == pytest.approx((0.5 + arm[0], -0.25 + arm[1]), rel=1e-9)
    assert (u[k] + w[k] * ry, v[k] - w[k] * rx) == pytest.approx((-20.0 * arm[1], 20.0 * arm[0]), rel=1e-9)


def test_a_slider_keeps_what_its_start_has() -> None:
    """Its row is the turn between both bodies, and what lies across the guide; the start keeps both."""
    assembly = cranked()
    k = list(assembly.ideals).index("guide")
    direction = [numbers(assembly, f"joint_direction_{axis}")[k] for axis in "xy"]
    assert math.hypot(*direction) == pytest.approx(1.0) and abs(direction[0] * 0.6 + direction[1] * 0.8) in (
        pytest.approx(0.0, abs=1e-12), pytest.approx(1.0),
    )  # fmt: skip
    theta = numbers(assembly, "particle_theta")
    bearing, journal = assembly.topology.joint_bearing[k], assembly.topology.joint_journal[k]
    assert numbers(assembly, "joint_offset")[k] == pytest.approx(theta[journal] - theta[bearing], abs=1e-12)
    assert numbers(assembly, "joint_ratio")[k] == 1.0


def test_springs_without_a_free_length_are_slack_at_the_start() -> None:
    assembly = cranked()
    x, y, theta = (numbers(assembly, f"particle_{name}") for name in ("x", "y", "theta"))
    block, rod = (assembly.bodies[name].particles[0] for name in ("block", "rod"))
    free = [math.hypot(x[block] - 0.5, y[block] + 0.25), theta[rod]]
    assert numbers(assembly, "spring_free").tolist() == pytest.approx(free, rel=1e-9)


def test_the_size_is_the_longest_arm_of_an_ideal_joint() -> None:
    """A row of the system, by which gaps and turns are compared."""
    assembly = cranked()
    reference = {name: assembly.bodies[name].reference for name in assembly.bodies}
    arms = [
        math.dist(assembly.bodies[body].pins[pin], reference[body])
        for body, pin in (("crank", "p"), ("rod", "a"), ("rod", "b"), ("block", "c"))
    ]
    assert numbers(assembly, "size")[0] == pytest.approx(max(arms), rel=1e-12)


def test_points_of_a_rigid_body_are_carried_with_it() -> None:
    """At 30 degrees the arm (2, 1) is (sqrt 3 - 1/2, 1 + sqrt(3)/2); at w = 4 it moves by 4 across."""
    there, moving = point_motion((10.0, 20.0, math.pi / 6.0), (1.0, -2.0, 4.0), 2.0, 1.0)
    rx, ry = math.sqrt(3.0) - 0.5, 1.0 + 0.5 * math.sqrt(3.0)
    assert there == pytest.approx((10.0 + rx, 20.0 + ry, math.pi / 6.0), rel=1e-12)
    assert moving == pytest.approx((1.0 - 4.0 * ry, -2.0 + 4.0 * rx, 4.0), rel=1e-12)
