"""A run that goes on from a former one's end goes on by its clock: two parts give what one run gives."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

import vfife
from support import four_bar, particle, with_settings
from vfife.model.drivers import Harmonic, Ramp, Torque
from vfife.model.loads import GuideForce, PointForce
from vfife.model.mechanism import Mechanism
from vfife.modelfile import dump, loads


def pushed() -> Mechanism:
    """A disc under a force that grows with time, as the issue has it: after T seconds w = r F
    T^2/(2 J T1).
    """
    m = Mechanism("pushed")
    m.point("O", 0.0, 0.0)
    m.rigid_body("disc", mass=2.0, inertia=0.05, pins={"rim": (0.1, 0.0)})
    m.revolute("A", "ground.O", "disc.center")
    m.loads["ramp"] = PointForce(
        name="ramp", at="disc.rim", force=(0.0, 1.0), follow=True, times=(0.0, 1.0), factors=(0.0, 1.0)
    )
    return m


def busy() -> Mechanism:
    """What counts from a clock or a start: motions, torques over time and angle, springs without a free
    length, a gas with two ways.
    """
    m = Mechanism("busy", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.point("P", 0.5, 0.1)
    m.link("crank", length=0.05, mass=0.5, angle=0.3)
    m.link("rod", length=0.2, mass=0.4, angle=-0.1)
    m.rigid_body("piston", mass=0.6, inertia=1e-3, position=(0.25, 0.0), angle=0.2)
    m.link("arm", length=0.2, mass=0.3, angle=-1.4)
    m.revolute("A", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "rod.start")
    m.revolute("C", "rod.end", "piston.center")
    m.slider("guide", "ground.O", "piston.center")
    m.revolute("P", "ground.P", "arm.start")
    m.drivers["crank"] = Ramp(body="crank", speed=20.0 * math.pi, duration=0.08)
    m.drivers["arm"] = Torque(body="arm", value=(0.1, -0.2, 0.3), angles=(-0.5, 0.0, 0.5))
    m.drivers["shaker"] = Torque(body="arm", value=(0.0, 0.1, -0.1), times=(0.0, 0.05, 0.1))
    m.spring("s", "arm.end", "ground.O", stiffness=50.0)
    m.torsional_spring("t", "ground", "arm", stiffness=0.5)
    m.loads["gas"] = GuideForce(
        name="gas",
        slider="guide",
        bore=0.05,
        reverse=True,
        travels=(0.15, 0.2, 0.25),
        pressure=(1e5, 3e5, 6e5),
        pressure_back=(1e5, 2e5, 6e5),
    )
    angles = tuple(np.linspace(0.0, 2.0 * math.pi, 5))
    m.loads["tooth"] = PointForce(
        name="tooth", at="rod.end", force=(5.0, 3.0), angles=angles, factors=(0.0, 1.0, 0.0, -1.0, 0.0)
    )
    return m


def swung() -> Mechanism:
    """A slider that is led to and fro, and a hung link that it shakes."""
    m = Mechanism("swung", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("block", mass=1.0, inertia=0.01)
    m.link("rod", length=0.3, mass=0.4, angle=-1.2)
    m.slider("guide", "ground.O", "block.center")
    m.revolute("P", "block.center", "rod.start")
    m.drivers["way"] = Harmonic(slider="guide", amplitude=0.05, frequency=7.0, phase=0.6)
    return m


def ends(mechanism: Mechanism, duration: float, start: object = None) -> tuple[vfife.Result, np.ndarray]:
    """A run, and its positions and velocities at the end."""
    result = vfife.simulate(
        mechanism,
        duration=duration,
        outputs=10,
        step=1e-5,
        start=start,
        companions=0,
        reference=False,
        loop="data-driven",
    )
    assert result.record.status == "complete"
    bodies = [particle(result.record, name) for name in mechanism.bodies]
    return result, np.array([[p[axis][-1] for axis in ("x", "y", "theta", "u", "v", "w")] for p in bodies])


@pytest.mark.parametrize("make", [pushed, busy, swung], ids=lambda make: make.__name__)
def test_two_parts_and_three_are_one(make) -> None:
    whole = ends(make(), 0.12)[1]
    first, _ = ends(make(), 0.05)
    second, two = ends(make(), 0.07, first)
    assert two == pytest.approx(whole, rel=1e-7, abs=1e-8)
    third, _ = ends(make(), 0.03, first)
    last, three = ends(make(), 0.04, third)
    assert three == pytest.approx(whole, rel=1e-7, abs=1e-8)
    clocks = [result.record.assembly.mechanism.clock for result in (first, second, third, last)]
    assert clocks == pytest.approx([0.0, 0.05, 0.05, 0.08])
    assert make is not pushed or whole[0, 5] == pytest.approx(0.1 * 0.12**2 / (2.0 * 0.05), rel=1e-3)


def test_a_clock_that_is_set_begins_there(tmp_path: Path) -> None:
    """Anew at 0, or at any time, also without a former run; a file holds it."""
    first, _ = ends(pushed(), 0.5)
    anew = dataclasses.replace(pushed(), start=dataclasses.replace(pushed().start, time=0.0))
    _, again = ends(anew, 0.1, first)
    assert again[0, 5] == pytest.approx(0.25 + 0.01, rel=1e-3), (
        "0.25 rad/s after half a second, and a tenth of a second from no force on"
    )
    later = loads(dump(dataclasses.replace(pushed(), start=dataclasses.replace(pushed().start, time=0.4))))
    assert later.clock == 0.4 and "time = 0.4" in dump(later)
    assert ends(later, 0.1)[1][0, 5] == pytest.approx(0.25 - 0.16, rel=1e-3)


def test_a_run_file_goes_on_and_knows_its_clock(tmp_path: Path) -> None:
    first, _ = ends(busy(), 0.05)
    first.save(tmp_path / "first.sqlite")
    from_file, there = ends(busy(), 0.02, tmp_path / "first.sqlite")
    assert (there == ends(busy(), 0.02, first)[1]).all()
    from_file.save(tmp_path / "second.sqlite")
    assert vfife.load_result(tmp_path / "second.sqlite").record.assembly.mechanism.clock == pytest.approx(
        0.05
    )


def test_the_step_stays_what_it_was() -> None:
    """One that was halved, or set by hand, is kept where nothing is said; one that is said, or too large by
    now, is not.
    """
    m = with_settings(four_bar("C"), companions=0)
    own = vfife.simulate(m, duration=1e-3, reference=False).record.assembly.choice.step
    first = vfife.simulate(m, duration=1e-3, step=0.5 * own, reference=False)
    second = vfife.simulate(m, duration=1e-3, start=first, reference=False)
    assert second.record.assembly.choice.step == first.record.assembly.choice.step != own
    assert second.record.assembly.choice.culprit == "the run that it continues"
    anew = vfife.simulate(m, duration=1e-3, start=first, step="auto", reference=False).record.assembly.choice
    assert anew.culprit != "the run that it continues" and anew.step != 0.5 * own
    stiff = dataclasses.replace(
        m.joints["C"], contact=vfife.laws.LankaraniNikravesh(restitution=0.9, stiffness=6.6e13)
    )
    stiffer = dataclasses.replace(m, joints={**m.joints, "C": stiff})
    assert (
        vfife.simulate(stiffer, duration=1e-4, start=first, reference=False).record.assembly.choice.step
        < first.record.assembly.choice.step
    )
