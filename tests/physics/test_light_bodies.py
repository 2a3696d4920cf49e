"""Light bodies on long arms, flat arches, coarse steps and long distances: where a first correction of the
reactions is not enough, or too much.
"""

import math

import numpy as np
import pytest

from support import go, joint_gap
from vfife.gallery import jansen_leg
from vfife.model.drivers import Torque
from vfife.model.mechanism import Mechanism


def arm(gyration: float, gravity: float) -> Mechanism:
    """A body of 1 kg whose centre is 1 m from its pin."""
    m = Mechanism("arm", gravity=(0.0, -gravity))
    m.point("O", 0.0, 0.0)
    m.rigid_body("b", mass=1.0, inertia=gyration**2, center=(1.0, 0.0), pins={"pin": (0.0, 0.0)})
    m.revolute("J", "ground.O", "b.pin")
    return m


def test_a_body_two_hundred_radii_of_gyration_from_its_pin_falls_from_rest():
    """At the bottom w^2 = 2 g/(1 + k^2) and the pin carries 3 g: the automatic step, which knows no speed at
    the start, lost it at once.
    """
    record = go(arm(5e-3, 9.81), "auto", duration=4.0, outputs=2000)
    assert np.abs(record.block("particle_w")[:, 1]).max() == pytest.approx(math.sqrt(2.0 * 9.81), rel=1e-4)
    assert np.abs(record.block("joint_fy")).max() == pytest.approx(3.0 * 9.81, rel=1e-4)
    assert joint_gap(record, "J") < 2e-9


def test_a_motor_turns_a_body_of_little_inertia_on_its_arm():
    m = arm(0.1, 0.0)
    m.drivers["motor"] = Torque(body="b", value=2.0)
    record = go(m, "auto", duration=3.0, outputs=100)
    half = 0.5 * record.assembly.choice.step
    assert record.block("particle_w")[-1, 1] == pytest.approx(
        2.0 * (record.steps[-1] * 2.0 * half + half) / 1.01, rel=1e-5
    )
    assert joint_gap(record, "J") < 2e-9


@pytest.mark.parametrize("steps", [200, 500, 1000])
def test_the_jansen_leg_holds_at_coarse_steps(steps):
    record = go(jansen_leg(), 1.0 / steps, turns=2, outputs=100)
    assert max(joint_gap(record, joint) for joint in record.assembly.ideals) < 1e-9


def arch(spin: float) -> Mechanism:
    """Two bars of 5 kg over 2 m, 20 mm high, and a pendulum of 1 kg on a massless arm at their apex."""
    m = Mechanism("arch", gravity=(0.0, -9.81))
    length, angle = math.hypot(1.0, 0.02), math.atan2(0.02, 1.0)
    m.point("A", -1.0, 0.0)
    m.point("B", 1.0, 0.0)
    m.link("left", length=length, mass=5.0, angle=angle)
    m.link("right", length=length, mass=5.0, angle=math.pi - angle)
    m.rigid_body(
        "bob",
        mass=1.0,
        inertia=0.01,
        pins={"pin": (0.0, 0.3)},
        position=(0.0, -0.28),
        velocity=(0.3 * spin, 0.0, spin),
    )
    m.revolute("A", "ground.A", "left.start")
    m.revolute("C", "left.end", "right.end")
    m.revolute("B", "ground.B", "right.start")
    m.revolute("P", "left.end", "bob.pin")
    return m


@pytest.mark.parametrize("step", ["auto", 1e-3, 1e-5])
def test_a_flat_arch_stands_while_a_pendulum_turns_at_its_apex(step):
    """Its pivot is small and stays so: thrust is (half the weight of both bars and the pendulum's pull P_y) /
    (2 tan angle), less half of P_x.
    """
    record = go(arch(20.0), step, duration=0.5, outputs=200)
    assert np.abs(np.ptp(record.block("particle_theta")[:, 1:3], axis=0)).max() < 1e-9
    index = {name: k for k, name in enumerate(record.assembly.ideals)}
    px, py = (-record.block(f"joint_{axis}")[2:, index["P"]] for axis in ("fx", "fy"))
    thrust = record.block("joint_fx")[2:, index["A"]]
    assert thrust == pytest.approx(
        (5.0 * 9.81 - py) / (2.0 * 0.02) - 0.5 * px, rel=1e-5, abs=1e-5 * np.abs(thrust).max()
    )


def test_reactions_of_a_long_body_do_not_drown_in_rounding():
    """100 m at 20 us: at 1 km from the origin: closing positions gives a noise of eps x/dt^2, 3e-4 m/s^2 and
    more in each.
    """
    m = Mechanism("long", gravity=(0.0, -9.81))
    m.point("O", 1000.0, 500.0)
    m.link("rod", length=100.0, mass=1.0, angle=1.0)
    m.revolute("J", "ground.O", "rod.start")
    force = go(m, 2e-5, duration=0.1, outputs=1000).block("joint_fy")[10:, 0]
    assert np.abs(np.diff(force, 3)).max() < 3e-4
