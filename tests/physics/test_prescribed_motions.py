"""Motions prescribed between two bodies: the automatic step resolves them, whatever the rest of the run would
do with.
"""

from __future__ import annotations

import cmath
import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

from differential import constrained as plain
from support import go, order, times
from vfife.assembly.assemble import assemble
from vfife.assembly.input_functions import RESOLVED
from vfife.measures.forces import joint_force, joint_moment, joint_rows
from vfife.model.drivers import AngleTable, ConstantSpeed, Harmonic, StepTo, Torque
from vfife.model.mechanism import Mechanism

T = 0.005  # s, of a step from rest to rest
LONG = 1.0  # s, of runs whose automatic step is asked for: their first milliseconds are compared
Made = tuple[Mechanism, plain.System, float]


def smooth_step(travel: float, long: float) -> plain.Law:
    def law(t: float) -> tuple[float, float, float]:
        s = min(t / long, 1.0)
        rate, second = 30.0 * s**2 * (1.0 - s) ** 2, 60.0 * s - 180.0 * s**2 + 120.0 * s**3
        return (
            travel * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5),
            travel * rate / long,
            travel * second / long**2,
        )

    return law


def arm_on_a_swing() -> Made:
    """A body that swings about a pin, with an arm that is turned against it."""
    m = Mechanism("arm on a swing", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    shoulder = cmath.rect(1.0, -0.3) * complex(-0.2, -0.1)
    m.rigid_body(
        "base", mass=2.0, inertia=0.05, position=(0.3, -0.2), pins={"o": (-0.3, 0.2), "a": (0.1, 0.1)}
    )
    m.rigid_body(
        "arm",
        mass=0.7,
        inertia=0.02,
        position=(0.6, 0.0),
        angle=0.3,
        pins={"a": (shoulder.real, shoulder.imag)},
    )
    m.revolute("O", "ground.O", "base.o")
    m.revolute("A", "base.a", "arm.a")
    m.drivers["motor"] = StepTo(body="arm", against="base", travel=0.8, duration=T)
    s = plain.System(
        [(1.0, 1.0), (2.0, 0.05), (0.7, 0.02)], [(0.0, 0.0, 0.0), (0.3, -0.2, 0.0), (0.6, 0.0, 0.3)]
    )
    s.forces.append(plain.weight(s.mass, -9.81j))
    s.constraints += [plain.Pin("O", 0, 0j, 1, -0.3 + 0.2j), plain.Pin("A", 1, 0.1 + 0.1j, 2, shoulder)]
    s.constraints += [plain.Turn("motor", 1, 2, 1.0, smooth_step(0.8, T))]
    s.breaks = [T]
    return m, s, 1.5 * T


def block_on_a_rail() -> Made:
    """A block that travels on a rail, which hangs on a pin."""
    m = Mechanism("block on a rail", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body(
        "rail", mass=1.5, inertia=0.04, position=(0.2, 0.0), pins={"o": (-0.2, 0.0), "g": (0.0, 0.05)}
    )
    m.rigid_body("block", mass=0.8, inertia=0.01, position=(0.2, 0.05), pins={"p": (0.0, 0.0)})
    m.revolute("O", "ground.O", "rail.o")
    m.slider("S", "rail.g", "block.p", direction=(2.0, 1.0))
    m.drivers["feed"] = StepTo(slider="S", travel=0.15, duration=T)
    way = complex(2.0, 1.0) / abs(complex(2.0, 1.0))
    s = plain.System(
        [(1.0, 1.0), (1.5, 0.04), (0.8, 0.01)], [(0.0, 0.0, 0.0), (0.2, 0.0, 0.0), (0.2, 0.05, 0.0)]
    )
    s.forces.append(plain.weight(s.mass, -9.81j))
    s.constraints += [
        plain.Pin("O", 0, 0j, 1, -0.2 + 0j),
        plain.Guide("S", 1, 0.05j, 2, 0j, 1j * way),
        plain.Turn("turn", 1, 2),
    ]
    s.constraints += [plain.Guide("feed", 1, 0.05j, 2, 0j, way, smooth_step(0.15, T))]
    s.breaks = [T]
    return m, s, 1.5 * T


def beaten_tail() -> Made:
    """A hull and a tail without anything else in the world, the tail beaten to and fro."""
    size, hertz, phase = 0.3, 200.0, 0.4
    m = Mechanism("beaten tail")
    m.rigid_body("hull", mass=3.0, inertia=0.1, position=(0.0, 0.0), pins={"a": (0.2, 0.1)})
    m.rigid_body("tail", mass=0.5, inertia=0.01, position=(0.4, 0.1), pins={"a": (-0.2, 0.0)})
    m.revolute("A", "hull.a", "tail.a")
    m.drivers["motor"] = Harmonic(body="tail", against="hull", amplitude=size, frequency=hertz, phase=phase)
    s = plain.System(
        [(1.0, 1.0), (3.0, 0.1), (0.5, 0.01)], [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.4, 0.1, 0.0)]
    )
    w = 2.0 * math.pi * hertz
    law = lambda t: (  # noqa: E731
        0.0,
        size * w * math.cos(w * t + phase),
        -size * w * w * math.sin(w * t + phase),
    )
    s.constraints += [plain.Pin("A", 1, 0.2 + 0.1j, 2, -0.2 + 0j), plain.Turn("motor", 1, 2, 1.0, law)]
    return m, s, 3.0 / hertz


def errors(
    made: Callable[[], Made], step: float | None, monkeypatch: pytest.MonkeyPatch, peaks: bool = False
) -> dict[str, float]:
    """Of each joint's reaction, the largest error over the run, or that of the largest value, of the largest
    value.
    """
    monkeypatch.setattr(plain, "FASTEST", math.inf)
    m, s, duration = made()
    record = go(m, step or assemble(m, duration=LONG).choice.step, duration=duration, outputs=60)
    names, force, moment = list(joint_rows(record)), joint_force(record)[1:], joint_moment(record)[1:]
    multipliers: dict[str, list[np.ndarray]] = {}
    at = list(times(record)[1:])
    for t, (q, v) in zip(at, s.advance(s.projected(np.zeros((len(s.mass) - 1, 3))), at), strict=True):
        for name, one in s.solved(t, q, v)[2].items():
            multipliers.setdefault(name, []).append(one)
    found = {}
    for name, rows in multipliers.items():
        if name not in names:  # the row of a slider's turn
            continue
        exact, k = np.array(rows), names.index(name)
        along = len(rows[0]) == 1 and force[:, k].any()
        got = (
            np.hypot(*force[:, k].T)[:, None]
            if along
            else moment[:, k, None]
            if len(rows[0]) == 1
            else force[:, k]
        )
        exact = np.abs(exact) if along else exact
        error = abs(np.abs(got).max() - np.abs(exact).max()) if peaks else np.abs(got - exact).max()
        found[name] = float(error / np.abs(exact).max())
    return found


@pytest.mark.parametrize("made", [arm_on_a_swing, block_on_a_rail, beaten_tail])
def test_reactions_at_the_automatic_step(made: Callable[[], Made], monkeypatch: pytest.MonkeyPatch) -> None:
    """They were off by a tenth where the rest of the run would do with longer steps."""
    found = errors(made, None, monkeypatch)
    assert len(found) >= 2
    assert max(found.values()) < 1e-3


@pytest.mark.parametrize("made", [arm_on_a_swing, block_on_a_rail])
def test_largest_reactions_are_of_second_order(
    made: Callable[[], Made], monkeypatch: pytest.MonkeyPatch
) -> None:
    told = [errors(made, T / steps, monkeypatch, peaks=True) for steps in (60, 120, 240)]
    for name in ("O", "A", "S"):
        if name in told[0]:
            assert all(1.7 < one < 2.4 for one in order([one[name] for one in told])), (name, told)


def test_two_free_bodies_turn_as_their_inertias_say() -> None:
    """Pinned at both centres of mass: the moment between them is the reduced inertia times what is
    prescribed.
    """
    m = Mechanism("two discs")
    for name, inertia in (("one", 0.3), ("two", 0.1)):
        m.rigid_body(name, mass=1.0, inertia=inertia, position=(0.0, 0.0), pins={"o": (0.0, 0.0)})
    m.revolute("O", "one.o", "two.o")
    m.drivers["motor"] = StepTo(body="two", against="one", travel=1.0, duration=T)
    record = go(m, assemble(m, duration=LONG).choice.step, duration=T, outputs=100)
    moment = joint_moment(record)[:, list(joint_rows(record)).index("motor")]
    s = np.minimum(times(record) / T, 1.0)
    exact = 0.3 * 0.1 / 0.4 * (60.0 * s - 180.0 * s**2 + 120.0 * s**3) / T**2
    assert np.abs(moment - exact).max() < 1e-3 * np.abs(exact).max()


def turned(**driver: object) -> Mechanism:
    m = Mechanism("turned", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("arm", length=0.5, mass=1.0)
    m.revolute("O", "ground.O", "arm.start")
    m.drivers["motor"] = StepTo(body="arm", **{"travel": 0.2, "duration": T} | driver)  # type: ignore[arg-type]
    return m


def test_the_law_is_named_and_its_step_is_that_of_its_kinks() -> None:
    """A jump J of the third derivative is met by a node to J dt/6 of the second; that of 10 s^3 - 15 s^4 + 6
    s^5 is 60/T^3 beside 5.77/T^2.
    """
    choice = assemble(turned(), duration=LONG).choice
    assert choice.culprit == "the motion law of arm"
    assert choice.step == pytest.approx(RESOLVED * 6.0 * 10.0 / math.sqrt(3.0) / 60.0 * T, rel=0.05)
    assert assemble(block_on_a_rail()[0], duration=LONG).choice.culprit == "the motion law of joint S"


def test_what_a_run_does_not_come_to_costs_nothing() -> None:
    assert "law" not in assemble(turned(begin=2.0 * LONG), duration=LONG).choice.culprit


def test_a_fine_table_of_a_smooth_motion_is_as_cheap_as_the_motion() -> None:
    """For dt^2 w^2/12 of the largest; a coarse table has kinks of its third derivative, and costs more."""
    w = 2.0 * math.pi / T
    steps = {}
    for points in (20, 2000):
        t = np.linspace(0.0, 20.0 * T, points * 20 + 1)
        m = turned()
        m.drivers["motor"] = AngleTable(body="arm", times=tuple(t), values=tuple(0.001 * np.sin(w * t)))
        steps[points] = assemble(m, duration=10.0 * T, outputs=5).choice.step
    assert steps[2000] == pytest.approx(math.sqrt(12.0 * RESOLVED) / w, rel=0.05)
    assert steps[20] < 0.5 * steps[2000]


def test_a_table_of_a_constant_speed_prescribes_nothing_to_resolve() -> None:
    m, table = turned(), turned()
    m.drivers["motor"] = ConstantSpeed(body="arm", speed=3.0)
    t = np.linspace(0.0, 1.0, 2001)
    table.drivers["motor"] = AngleTable(body="arm", times=tuple(t), values=tuple(3.0 * t))
    steps = [assemble(model, duration=LONG, outputs=10).choice.step for model in (table, m)]
    assert steps[0] == pytest.approx(steps[1], rel=0.01)  # both divide outputs, of a run and of a turn


def test_torques_over_an_angle_count_with_the_speed_of_turning() -> None:
    """A torque of 100 waves a turn on a body that turns 10 times a second: 1 kHz."""
    m, speed = turned(), 20.0 * math.pi
    a = np.linspace(0.0, 2.0 * math.pi, 10001)
    m.drivers["motor"] = Torque(
        body="arm", value=tuple(np.sin(100.0 * a)), angles=tuple(a), interpolation="spline"
    )
    m.bodies["arm"] = dataclasses.replace(m.bodies["arm"], velocity=(0.0, 0.0, speed))
    choice = assemble(m, duration=0.1).choice
    assert choice.culprit == "the torque on arm"
    assert choice.step == pytest.approx(math.sqrt(12.0 * RESOLVED) / (100.0 * speed), rel=0.1)


def test_a_step_that_is_too_coarse_for_a_law_is_told() -> None:
    told = assemble(turned(), 1e-3, duration=LONG).notes
    assert any("too coarse for the motion law of arm" in note for note in told)
    assert not assemble(turned(), 2e-5, duration=LONG).notes
    assert not assemble(turned(), duration=LONG).notes
