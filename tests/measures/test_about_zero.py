"""Quantities that are zero but for rounding or a remainder: they decide neither sensitivity, nor steps, nor
whether turns repeat, and are told as about zero.
"""

from __future__ import annotations

import pytest

import vfife
from vfife import gallery
from vfife.measures.zero_limits import scales_of_run
from vfife.modelfile import loads as model_of
from vfife.report.overview import certainty
from vfife.report.run import document
from vfife.report.summary import run_summary, summary_text
from vfife.report.terminal import as_text
from vfife.solvers.scales import NEGLIGIBLE, scales

PARALLELOGRAM = """
name = "parallelogram"
gravity = [0, "-9.81 m/s^2"]
[run]
duration = "0.02 s"
outputs = 35
[ground]
A = [0, 0]
B = ["100 mm", 0]
[body.p]
length = "80 mm"
mass = "0.2 kg"
angle = "60 deg"
[body.q]
length = "80 mm"
mass = "0.2 kg"
angle = "60 deg"
[body.bar]
mass = "1 kg"
inertia = "8e-3 kg m^2"
center = ["125 mm", 0]
position = ["40 mm", "69.282 mm"]
[body.bar.pins]
a = [0, 0]
b = ["100 mm", 0]
[joint.A]
bearing = "ground.A"
journal = "p.start"
[joint.B]
bearing = "ground.B"
journal = "q.start"
[joint.a]
bearing = "p.end"
journal = "bar.a"
[joint.b]
bearing = "q.end"
journal = "bar.b"
[driver.p]
speed = "30 rad/s"
"""
# A driven roller of 20 mm presses against a wheel of 60 mm and brings it up from rest: after 37 ms it rolls.
FRICTION_DRIVE = """
name = "friction drive"
[run]
duration = "0.6 s"
outputs = 1200
[ground]
A = [0, "-100 mm"]
B = ["80 mm", 0]
[body.arm]
length = "100 mm"
mass = "0.1 kg"
angle = "90 deg"
[body.wheel]
mass = "2 kg"
inertia = "2e-3 kg m^2"
[body.wheel.pins]
c = [0, 0]
[body.roller]
mass = "0.5 kg"
inertia = "1e-4 kg m^2"
position = ["80 mm", 0]
[body.roller.pins]
c = [0, 0]
[joint.A]
bearing = "ground.A"
journal = "arm.start"
[joint.hub]
bearing = "arm.end"
journal = "wheel.c"
[joint.B]
bearing = "ground.B"
journal = "roller.c"
[joint.nip]
kind = "contact"
bearing = "wheel.c"
journal = "roller.c"
bearing_radius = "60 mm"
journal_radius = "20 mm"
contact = { law = "kelvin-voigt", stiffness = "1e7 N/m", damping_coefficient = "100 N s/m" }
friction = { law = "coulomb", coefficient = 0.3 }
[load.press]
at = "wheel.c"
force = ["50 N", 0]
[driver.roller]
speed = "50 rad/s"
"""


@pytest.fixture(scope="module")
def parallelogram():
    return vfife.simulate(model_of(PARALLELOGRAM))


@pytest.fixture(scope="module")
def drive():
    return vfife.simulate(model_of(FRICTION_DRIVE))


def test_scales_are_those_of_the_mechanism(parallelogram, drive) -> None:
    """m r w^2 = 1.4 kg 0.08 m (30 rad/s)^2; the load of 50 N on the arm, 0.1 kg (0.1 m)^2/12; w^2."""
    mechanism = scales(parallelogram.record.assembly)
    assert mechanism.force == pytest.approx(1.4 * 0.08 * 900.0)
    assert mechanism.accelerations["q"] == pytest.approx(mechanism.force * 0.04 / (0.2 * 0.08**2 / 12.0))
    drive_scales = scales(drive.record.assembly)
    assert drive_scales.force == 50.0
    assert drive_scales.accelerations["wheel"] == pytest.approx(2500.0)
    assert drive_scales.accelerations["arm"] == pytest.approx(50.0 * 0.05 / (0.1 * 0.1**2 / 12.0))
    assert drive_scales.of("B.force.max") == 50.0 and drive_scales.of("nip.penetration.max") == 0.0


def test_an_angular_acceleration_that_is_zero_makes_no_run_sensitive(parallelogram) -> None:
    """Steps of 200 to 10 us all give 10.3095 N and 82.975 N; the links do turn at constant speed."""
    summary = run_summary(parallelogram)
    assert not summary["trust"]["sensitive"] and not summary["trust"]["tried"]
    for name, exact in (("A", 10.30950), ("B", 82.97550)):
        force = parallelogram.measures[f"{name}.force.max"]
        assert force.low <= exact <= force.high and force.width < 0.01 * force
    zero = parallelogram.measures["q.angular_acceleration.max"]
    limit = NEGLIGIBLE * scales(parallelogram.record.assembly).accelerations["q"]
    assert summary["about_zero"]["q.angular_acceleration.max"] == limit
    assert 0.0 < zero <= limit and (zero.low, zero.high) == (0.0, limit)
    assert "q angular acceleration" not in certainty(summary)
    assert certainty(summary).startswith("Reliable")


def test_a_remainder_does_not_keep_the_turns_of_a_steady_drive_apart(drive) -> None:
    """The contact force is within 0.2 % from turn 3 on; the remaining acceleration falls 20-fold a turn."""
    assert drive.motion.motion == "settling" and drive.motion.distance < 0.03
    longer = vfife.simulate(model_of(FRICTION_DRIVE), settle=0.01, duration=6.0)
    assert longer.motion.motion == "periodic" and longer.motion.count <= 6


def test_text_and_data_tell_the_same_zeros(drive) -> None:
    """No 0.0 to 0.1 N m on the screen, and no digits of 3e-12 N m."""
    summary = run_summary(drive)
    zeros = summary["about_zero"]
    for name in ("A.force.max", "roller.torque.max", "roller.power.mean", "nip.approach_speed.max"):
        bounds = summary["ranges"][name]
        assert abs(summary["measures"][name]) <= bounds["high"] == zeros[name]
    assert "B.force.max" not in zeros
    text = summary_text(drive)
    assert "torque about 0" in text and "no knocks" in text and "Reliable" in text
    assert "nN" not in text and "µN" not in text
    assert "below 5e-05 N" in as_text(document(summary))


def test_a_quantity_above_the_limit_is_none_of_them(parallelogram) -> None:
    """A slower mechanism has smaller scales: its small accelerations are real."""
    summary = run_summary(parallelogram)
    assert set(summary["about_zero"]) <= {"q.angular_acceleration.max", "bar.angular_acceleration.max"}
    assert "p.torque.max" not in summary["about_zero"]


@pytest.mark.parametrize("speed", [20.5, None])
def test_an_idle_crank_has_no_mean_torque_and_no_power(speed: float | None) -> None:
    """At 20.5 rad/s the piston slides without knocks and friction: 2e-9 W of damping beside 0.3 N m of
    torque. At full speed it knocks, and 11 W are real.
    """
    result = vfife.simulate(gallery.piston_slap(speed=speed), reference=False)
    zeros = run_summary(result)["about_zero"]
    names = {"crank.torque.mean", "crank.power.mean"}
    assert names & set(zeros) == (set() if speed is None else names)
    torque, power = (result.measures[name] for name in sorted(names, reverse=True))
    if speed is not None:
        assert zeros["crank.torque.mean"] == pytest.approx(
            1e-6 * result.measures["crank.torque.max"], rel=1e-3
        )
        assert zeros["crank.power.mean"] == pytest.approx(speed * zeros["crank.torque.mean"], rel=1e-3)
        assert torque.high == -torque.low == pytest.approx(zeros["crank.torque.mean"], rel=1e-3)
        assert power.high == -power.low == pytest.approx(zeros["crank.power.mean"], rel=1e-3)
    else:
        assert power.low > 10.0


def geared_rotors(ratio: float) -> vfife.Mechanism:
    """Two rotors on shafts through their centres of mass, a gear and a torsional spring, without gravity."""
    m = vfife.Mechanism("gears")
    m.point("O", 0, 0)
    m.point("Q", 0.1, 0)
    m.rigid_body("a", mass=0.5, inertia=2e-4, velocity=(0, 0, 5))
    m.rigid_body("b", mass=0.5, inertia=2e-4, position=(0.1, 0), velocity=(0, 0, 5 * ratio))
    m.revolute("s", "ground.O", "a.center")
    m.revolute("q", "ground.Q", "b.center")
    m.gear("g", "a", "b", ratio=ratio)
    m.torsional_spring("t", "ground", "b", stiffness=0.1)
    return m


@pytest.mark.parametrize("ratio", [-1.0, -0.5, 2.0])
def test_shafts_through_centres_of_mass_carry_nothing(ratio: float) -> None:
    result = vfife.simulate(geared_rotors(ratio), duration=0.2)
    summary = result.summary
    forces = {name: summary["measures"][f"{name}.force.max"] for name in "sq"}
    assert all(force < 1e-9 for force in forces.values())
    assert {name for name, force in forces.items() if force > 0.0} <= {
        name.split(".")[0] for name in summary["about_zero"]
    }
    assert certainty(summary).startswith("Reliable") and "N m" in str(result)
    assert not summary["trust"]["tried"]


def test_a_model_without_loads_has_the_scale_of_its_springs_and_its_start() -> None:
    """5 rad/s on 2e-4 kg m² and 0.1 m; a spring of 1000 N/m that starts 10 mm long."""
    record = vfife.simulate(geared_rotors(-1.0), duration=0.01).record
    assert scales(record.assembly).force == 0.0
    assert scales_of_run(record).force == pytest.approx(2e-4 * 25.0 / 0.1, rel=1e-3)
    m = vfife.Mechanism("mass on a spring")
    m.point("O", 0, 0)
    m.rigid_body("block", mass=1, inertia=1e-3, position=(0.1, 0))
    m.slider("rail", "ground.O", "block.center")
    m.spring("s", "ground.O", "block.center", stiffness=1000, free_length=0.09)
    record = vfife.simulate(m, duration=0.5).record
    assert scales_of_run(record).force == pytest.approx(10.0, rel=1e-3)


def test_a_rod_that_turns_evenly_has_a_certain_force() -> None:
    """1 kg at 0.1 m and 3 rad/s press with 0.9 N; its angular acceleration vanishes with the step, and its
    relative error, which does not, is none of the force.
    """
    m = vfife.Mechanism("rod")
    m.point("O", 0.3, 0.1)
    m.link("rod", length=0.2, mass=1, angle="20 deg", velocity=(0, 0, 3))
    m.revolute("O", "ground.O", "rod.start")
    result = vfife.simulate(m, duration=0.5)
    force = result.measures["O.force.max"]
    assert force.low < 0.9 < force.high and force.high - force.low < 1e-4
    assert 0.0 < result.measures["rod.angular_acceleration.max"] < 27.0 * result.step
    assert not result.summary["trust"]["tried"] and not result.summary["trust"]["sensitive"]
