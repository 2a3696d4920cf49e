"""Springs, loads and torques before the motion: they are those of a step, from the same text."""

import math

import numpy as np
import pytest

from vfife.assembly.assemble import assemble
from vfife.compiler.trace.tables import tables
from vfife.kernels import spring as springs_of_a_step
from vfife.kernels import step as loop
from vfife.kinematics import forces
from vfife.kinematics.forces import constant_forces
from vfife.kinematics.initial import Motion, ideal_motion
from vfife.model.drivers import Torque
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.springs import Bushing, Spring, Stop, TorsionalSpring


def two_bodies() -> Mechanism:
    """Two bodies in flight, turned and turning, their pins off their centres of mass, and a point of the
    ground.
    """
    m = Mechanism("in flight")
    m.point("O", 0.1, -0.3)
    for name, at, angle, velocity in (
        ("a", (0.2, 0.1), 0.4, (1.0, -2.0, 3.0)),
        ("b", (0.7, 0.5), -0.9, (-0.5, 0.3, -4.0)),
    ):
        m.rigid_body(
            name,
            mass=2.0,
            inertia=0.03,
            center=(0.05, -0.02),
            pins={"eye": (0.3, 0.2)},
            position=at,
            angle=angle,
            velocity=velocity,
        )
    return m


def add(kind: str) -> Mechanism:
    """The two bodies with one thing that pushes them."""
    m = two_bodies()
    ends = {"name": kind, "first": "a.eye", "second": "b.eye"}
    turning = {"name": kind, "first": "a", "second": "b"}
    things = {
        "spring": Spring(**ends, stiffness=400.0, damping=7.0, free_length=0.2),
        "spring to the ground": Spring(
            **{**ends, "second": "ground.O"}, stiffness=400.0, damping=7.0, free_length=0.2
        ),
        "torsional spring": TorsionalSpring(**turning, stiffness=5.0, damping=0.3, free_angle=0.1),
        "stop that pushes": Stop(**turning, low=-0.5, high=0.5, stiffness=9.0, damping=0.1),
        "stop that rests": Stop(**turning, low=-2.0, high=0.5, stiffness=9.0, damping=0.1),
        "bushing": Bushing(**ends, stiffness=(300.0, 200.0, 4.0), damping=(5.0, 3.0, 0.2)),
        "load": PointForce(name=kind, at="a.eye", force=(15.0, -4.0), moment=0.4),
        "following load": PointForce(
            name=kind,
            at="a.eye",
            force=(15.0, -4.0),
            follow=True,
            times=(0.0, 1.0, 2.0),
            factors=(0.7, -0.5, 2.0),
        ),
        "torque": Torque(body="a", against="b", value=1.5),
        "torque over a speed": Torque(body="a", against="b", value=(1.0, -2.0, 5.0), speeds=(-5.0, 0.0, 9.0)),
        "torque over an angle": Torque(body="a", value=(1.0, -2.0, 5.0), angles=(-1.0, 0.0, 1.0)),
        "force along a line": Torque(point="b.eye", direction=(3.0, 4.0), value=10.0),
    }
    thing = things[kind]
    {PointForce: m.loads, Torque: m.drivers}.get(type(thing), m.springs)[kind] = thing
    return m


KINDS = (
    "spring", "spring to the ground", "torsional spring", "stop that pushes", "stop that rests", "bushing",
    "load", "following load", "torque", "torque over a speed", "torque over an angle", "force along a line",
)  # fmt: skip


def ideal(m: Mechanism) -> np.ndarray:
    """Forces and moments (3) on both bodies, as the ideal motion has them."""
    motion: Motion = ideal_motion(m)
    now = forces.Instant(m, motion.names, motion.position, motion.velocity)
    return constant_forces([now], [motion.applied], motion.system.mass[None])[0, 1:]


def stepped(m: Mechanism) -> np.ndarray:
    """The same from the first step, run as plain Python up to its joints."""
    a = assemble(m, 1e-6, duration=1e-5, force_step=True)
    integers, layout, rows = tables(a.topology)
    S, I = np.zeros(rows), [int(value) for value in integers]
    S[: len(a.state)] = a.state
    S[layout["c"]] = 1.0
    loop.functions(S, a.tables, I, 0)
    loop.move(S, I, 0.0, 0.0)
    loop.loads(S, I)
    loop.springs(S, I, 0.0, forces.STANDING)
    return np.array([[S[layout.row(axis, p)] for axis in ("fx", "fy", "mz")] for p in (1, 2)])


@pytest.mark.parametrize("kind", KINDS)
def test_forces_are_those_of_the_first_step(kind):
    found = ideal(add(kind))
    assert found == pytest.approx(stepped(add(kind)), rel=1e-12, abs=1e-12)
    assert np.abs(found).max() > (1.0 if kind != "stop that rests" else -1.0)
    assert kind != "stop that rests" or not found.any()


def test_a_spring_and_its_damper():
    """k (l - l0) + c dl/dt along the line between the pins, both from the bodies' places and velocities."""
    m = add("spring")
    place, rate = [], []
    for body in m.bodies.values():
        c, s = math.cos(body.angle), math.sin(body.angle)
        (x, y), (u, v, w), (ex, ey) = body.position, body.velocity, (0.3, 0.2)
        rx, ry = c * ex - s * ey, s * ex + c * ey
        place.append(np.array([x + rx, y + ry]))
        rate.append(np.array([u - w * ry, v + w * rx]))
    apart = place[1] - place[0]
    size = np.hypot(*apart)
    pull = 400.0 * (size - 0.2) + 7.0 * apart @ (rate[1] - rate[0]) / size
    assert ideal(m)[0, :2] == pytest.approx(pull * apart / size, rel=1e-12)
    assert ideal(m)[1, :2] == pytest.approx(-pull * apart / size, rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_there_is_one_text(kind, monkeypatch):
    """A nudge of the step's function is felt by the ideal motion."""
    before = ideal(add(kind))
    resist, load, argument = springs_of_a_step.resist, loop.load, loop.argument

    def harder(*given):
        force, elastic, rate = resist(*given)
        return 1.01 * force, elastic, rate

    monkeypatch.setattr(springs_of_a_step, "resist", harder)
    monkeypatch.setattr(forces, "load", lambda *given: tuple(1.01 * value for value in load(*given)))
    after = ideal(add(kind))
    assert after == pytest.approx(1.01 * before, rel=1e-12)
    assert forces.load is not load and forces.argument is argument
    if "over" in kind:
        monkeypatch.setattr(forces, "argument", lambda *given: argument(*given) + 0.1)
        assert np.abs(ideal(add(kind)) - after).max() > 1e-3
