"""A mechanism stepped from outside: the bits of a run while nothing is set, closed forms for what is set, and
the energy that it brings.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import vfife
from vfife.model.loads import Load
from vfife.simulation.cosimulation import Table

STEP = 1e-5


def rotor(**drivers: Any) -> vfife.Mechanism:
    """A rotor of 0.02 kg m^2 on its pivot, in 10 ms."""
    m = vfife.Mechanism("rotor", settings=vfife.Settings(duration=0.01))
    m.point("O", 0, 0)
    m.rigid_body("rotor", mass=1.0, inertia=0.02, pins={"rim": (0.1, 0.0)})
    m.revolute("shaft", "ground.O", "rotor.center")
    m.drivers |= drivers
    return m


def stepped(m: vfife.Mechanism, step: float = STEP, **more: Any) -> vfife.Simulation:
    """It, stepped by the loop that all tests share."""
    return vfife.Simulation(m, step=step, loop="data-driven", **more)


TORQUE = {"motor": vfife.drivers.Torque(body="rotor", value=0.0)}
CHANNELS = [
    "C.force",
    "C.penetration",
    "C.impacts",
    "coupler.angular_velocity",
    "crank.angular_velocity",
    "crank.angle",
    "follower.x",
]
CHANNELS += [
    "follower.angular_acceleration",
    "crank.torque",
    "B.friction_force",
    "B.eccentricity_y",
    "kinetic_energy",
    "energy_residual",
]


@pytest.mark.parametrize("loop", ["data-driven", "generated"])
def test_it_has_the_bits_of_a_run_while_nothing_is_set(loop: Any) -> None:
    m = vfife.gallery.four_bar_case_c()
    result = vfife.simulate(m, step=1e-6, duration=2e-3, outputs=20, loop=loop, companions=0, reference=False)
    simulation = vfife.Simulation(m, step=1e-6, loop=loop)
    for k, time in enumerate(result.time):
        for between in (time - 37e-6, time - 1e-6, time):  # cut as nobody would
            if between > simulation.time:
                simulation.advance(between)
        assert simulation.time == time
        assert {name: simulation.read(name) for name in CHANNELS} == {
            name: float(result.series[name][k]) for name in CHANNELS
        }


@pytest.mark.parametrize(
    "make", ["slider_crank_loose_pin", "gear_train", "quick_return", "block_on_incline", "six_bar_press"]
)
def test_so_it_has_of_other_mechanisms(make: str) -> None:
    m = getattr(vfife.gallery, make)()
    step = 1e-6 if m.contacts else 1e-5
    result = vfife.simulate(
        m, step=step, duration=100 * step, outputs=1, loop="data-driven", companions=0, reference=False
    )
    simulation = stepped(m, step)
    simulation.advance(result.time[-1])
    assert simulation.time == result.time[-1]
    assert {name: simulation.read(name) for name in result.series if "_max" not in name} == pytest.approx(
        {name: float(values[-1]) for name, values in result.series.items() if "_max" not in name},
        abs=0.0,
        rel=0.0,
        nan_ok=True,
    )


def test_a_torque_acts_from_half_a_step_later_and_stays() -> None:
    simulation = stepped(rotor(**TORQUE))
    simulation.advance(20 * STEP)
    assert simulation.read("rotor.angular_velocity") == 0.0
    simulation.set("motor", "0.4 N m")
    simulation.advance(100 * STEP)
    alpha = 0.4 / 0.02
    assert simulation.read("rotor.angular_velocity") == pytest.approx(alpha * (80 - 0.5) * STEP, rel=1e-12)
    simulation.set("motor", 0)
    simulation.advance(200 * STEP)
    assert simulation.read("rotor.angular_velocity") == pytest.approx(alpha * 80 * STEP, rel=1e-12)


def test_what_torques_bring_is_in_the_ledger() -> None:
    """The work is the sum of torque times the angle that it is felt over, from half a step before to half a
    step after.
    """
    simulation, draw = stepped(rotor(**TORQUE)), np.random.default_rng(3)
    torques, angles = [0.0], [0.0]
    for k in range(1, 200):
        torques.append(float(draw.normal(0.5)))
        simulation.set("motor", torques[-1])
        simulation.advance(k * STEP)
        angles.append(simulation.read("rotor.angle"))
    simulation.set("motor", 0.0)  # so that half steps on both sides are alike
    simulation.advance(200 * STEP)
    simulation.advance(201 * STEP)
    kinetic, supplied = simulation.read("kinetic_energy"), simulation.read("external_work")
    angles.append(0.0)
    felt = [0.5 * (after - before) for before, after in zip(angles[:-2], angles[2:], strict=True)]
    felt[-1] = felt_last(simulation, angles)
    assert supplied == pytest.approx(
        math.fsum(m * a for m, a in zip(torques[1:], felt, strict=True)), rel=1e-9
    )
    assert supplied == pytest.approx(kinetic, rel=1e-12) and kinetic > 1e-6
    assert simulation.read("energy_residual") == pytest.approx(0.0, abs=1e-12 * kinetic)


def felt_last(simulation: vfife.Simulation, angles: list[float]) -> float:
    """Half of the angle from one step before the last torque to one step after it; two steps more were made
    since, at constant speed.
    """
    after = simulation.read("rotor.angle") - simulation.read("rotor.angular_velocity") * STEP
    return 0.5 * (after - angles[-3])


def test_a_torque_over_time_or_speed_gives_way_to_what_is_set() -> None:
    tables = {
        "motor": vfife.drivers.Torque(body="rotor", value=(1.0, 0.0), speeds=(0.0, 100.0)),
        "pulse": vfife.drivers.Torque(body="rotor", value=(0.0, 3.0, 0.0), times=(0.0, 1e-3, 2e-3)),
    }
    simulation = stepped(rotor(**tables))
    simulation.set("motor", 0.0)
    simulation.set("pulse", 0.0)
    simulation.advance(1e-3)
    assert simulation.read("rotor.angular_velocity") == pytest.approx(
        0.0, abs=1e-3
    )  # of the start, which was before
    speed = simulation.read("rotor.angular_velocity")
    simulation.advance(2e-3)
    assert simulation.read("rotor.angular_velocity") == speed


def test_a_load_is_multiplied() -> None:
    m = rotor()
    m.loads["push"] = vfife.loads.PointForce(name="push", at="rotor.rim", force=(0.0, 2.0), follow=True)
    simulation = stepped(m)
    simulation.advance(10 * STEP)
    simulation.set("push", -1.0)
    simulation.advance(20 * STEP)
    alpha = 2.0 * 0.1 / 0.02
    assert simulation.read("rotor.angular_velocity") == pytest.approx(alpha * (10.5 - 9.5) * STEP, rel=1e-9)


@pytest.mark.parametrize("kind", Load.registry)
def test_a_load_of_any_kind_ends_where_it_is_set_to_nothing(kind: str) -> None:
    """What pushes a free block along a guide, fixed in space or with it; half a step later nothing does."""
    m = vfife.Mechanism("block", settings=vfife.Settings(duration=0.01))
    m.point("O", 0, 0)
    m.rigid_body("block", mass=1.0, inertia=0.01)
    m.slider("guide", "ground.O", "block.center")
    noun = Load.registry[kind]
    aim = {"slider": "guide"} if noun.on_guide else {"at": "block.center"}
    m.loads["push"] = noun(name="push", **{**noun.sample, **aim})
    simulation = stepped(m)
    simulation.advance(10 * STEP)
    before = simulation.read("kinetic_energy")
    simulation.set("push", 0.0)
    simulation.advance(12 * STEP)
    after = simulation.read("kinetic_energy")
    simulation.advance(50 * STEP)
    assert 0.0 < before < after == pytest.approx(simulation.read("kinetic_energy"), rel=1e-12)
    assert simulation.inputs["push"] == (
        "force of the load along its guide (N)" if noun.on_guide else "what multiplies the load (1)"
    )


def test_a_load_and_a_driver_of_one_name_are_told_apart() -> None:
    m = rotor(**TORQUE)
    m.loads["motor"] = vfife.loads.PointForce(name="motor", at="rotor.rim", force=(0.0, 1.0))
    assert list(stepped(m).inputs) == ["motor", "driver.motor"]


def test_a_driver_goes_evenly_to_its_new_speed() -> None:
    simulation = stepped(rotor(rotor=vfife.drivers.ConstantSpeed(body="rotor", speed=10.0)), steered="rotor")
    simulation.advance(1e-3)
    simulation.set("rotor", "30 rad/s", within=2e-3)
    simulation.advance(2e-3)
    assert simulation.read("rotor.angular_velocity") == pytest.approx(20.0, rel=1e-12)
    assert simulation.read("rotor.torque") == pytest.approx(0.02 * 20.0 / 2e-3, rel=1e-9)
    assert simulation.read("rotor.angle") == pytest.approx(0.01 + 10.0 * 1e-3 + 0.5 * 1e4 * 1e-6, rel=1e-12)
    simulation.advance(5e-3)
    assert simulation.read("rotor.angular_velocity") == pytest.approx(30.0, rel=1e-12)
    assert simulation.read("rotor.angle") == pytest.approx(0.01 + 0.02 * 2.0 + 0.03 * 2.0, rel=1e-12)
    assert simulation.read("rotor.torque") == pytest.approx(0.0, abs=1e-9)
    assert simulation.read("energy_residual") == pytest.approx(
        0.0, abs=1e-3 * simulation.read("kinetic_energy")
    )


@pytest.mark.parametrize(
    "driver",
    [
        vfife.drivers.Ramp(slider="guide", speed=0.5, duration=1e-3),
        vfife.drivers.Harmonic(slider="guide", amplitude=0.01, frequency=100.0),
        vfife.drivers.ConstantSpeed(slider="guide", speed=0.5),
    ],
    ids=lambda one: type(one).__name__,
)
def test_so_does_a_slider_whatever_it_did_before(driver: Any) -> None:
    m = vfife.Mechanism("slide", settings=vfife.Settings(duration=0.01))
    m.point("O", 0, 0)
    m.rigid_body("block", mass=1.0, inertia=0.01)
    m.slider("guide", "ground.O", "block.center")
    m.drivers["push"] = driver
    simulation = stepped(m, steered=("push",))
    simulation.advance(3e-3)
    before = simulation.read("block.x")
    simulation.set("push", -0.2, within=1e-4)
    simulation.advance(4e-3)
    first = simulation.read("block.x")
    simulation.advance(5e-3)
    assert simulation.read("block.x") - first == pytest.approx(-0.2e-3, rel=1e-9)
    assert first < before + 1e-3


def test_a_table_is_the_polynomial_that_it_says() -> None:
    from vfife.kernels.polynomial import polynomial
    from vfife.model.geometry.polynomials import sine

    for function in (sine(1.0, 50.0, 0.3), vfife.drivers.Ramp(body="a", speed=3.0, duration=0.1).motion()):
        numbers = function.table()
        at, rate, _, kinks = polynomial(numbers, 0, 0.07)
        Table(memoryview(numbers), 0).go(0.07, 5.0, 0.01)
        for time, wanted in (
            (0.07, at),
            (0.075, at + 0.5 * (rate + 0.5 * (rate + 5.0)) * 0.005),
            (0.09, at + 0.5 * (rate + 5.0) * 0.01 + 0.05),
        ):
            assert polynomial(numbers, 0, time)[0] == pytest.approx(wanted, rel=1e-12, abs=1e-12)
        assert polynomial(numbers, 0, 0.071)[3] > kinks and polynomial(numbers, 0, 0.085)[3] > kinks + 1


def test_it_goes_on_from_a_former_run_to_the_bit() -> None:
    m = rotor(motor=vfife.drivers.Torque(body="rotor", value=0.3))
    former = vfife.simulate(m, duration=1e-3, step=STEP, outputs=2, loop="data-driven", companions=0)
    on, whole = stepped(m, start=former), stepped(m)
    on.advance(1e-3)
    whole.advance(2e-3)
    assert on.read("rotor.angle") == whole.read("rotor.angle") and on.time == pytest.approx(1e-3)


MISTAKES: dict[str, tuple[Callable[[vfife.Simulation], Any], tuple[str, ...]]] = {
    "a misspelt channel": (lambda s: s.read("rotor.angel"), ("no channel", 'mean "rotor.angle"')),
    "a misspelt input": (lambda s: s.set("moter", 1.0), ("no such input", 'mean "motor"')),
    "no number": (lambda s: s.set("motor", math.nan), ("motor", "not a finite number")),
    "another unit": (lambda s: s.set("motor", "3 kg"), ("motor", "a text", "N m")),
    "a list": (lambda s: s.set("motor", [1.0]), ("motor", "a list", "N m")),  # type: ignore[arg-type]
    "back in time": (lambda s: (s.advance(2e-4), s.advance(1e-4)), ("has passed", "does not go back")),
    "a text for a time": (lambda s: s.advance("1 ms"), ("a text", "a time in s")),  # type: ignore[arg-type]
    "a time that is no number": (
        lambda s: s.advance(math.nan),
        ("to = nan", "not a finite number", "a time in s"),
    ),
    "a torque within a time": (lambda s: s.set("motor", 1.0, within=1.0), ("within", "Leave it out")),
    "no room for the change": (lambda s: s.set("arm", 1.0), ("arm", "one piece")),
    "a speed that is not steered": (lambda s: s.set("wheel", 1.0), ("wheel", "constant", "steered=")),
    "a misspelt driver": (lambda s: stepped(s.mechanism, steered=("weel",)), ("steered", 'mean "wheel"')),
    "no time for it": (lambda s: s.set("arm", 1.0, within=0.0), ("within", "above 0 s")),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told(mistake: str) -> None:
    m = rotor(**TORQUE)
    m.point("P", 1, 0)
    m.link("arm", length=0.1, mass=0.1)
    m.revolute("hinge", "ground.P", "arm.start")
    m.point("Q", 2, 0)
    m.link("wheel", length=0.1, mass=0.1)
    m.revolute("axle", "ground.Q", "wheel.start")
    m.drive("wheel", speed=1.0)
    m.drivers["arm"] = vfife.drivers.AngleTable(body="arm", times=(0.0, 1.0), values=(0.0, 1.0))
    act, words = MISTAKES[mistake]
    with pytest.raises(vfife.VfifeError) as told:
        act(stepped(m))
    assert all(word in str(told.value) for word in words), str(told.value)


def test_numbers_that_leave_all_bounds_are_told() -> None:
    simulation = stepped(rotor(**TORQUE))
    simulation.set("motor", 1e300)
    with pytest.raises(vfife.VfifeError, match="grew without bound"):
        for k in range(1, 300):
            simulation.set("motor", 1e300 * k)
            simulation.advance(100 * k * STEP)


def test_a_file_is_no_mechanism_and_statics_have_no_steps() -> None:
    with pytest.raises(vfife.VfifeError, match=r"vfife\.load\(path\)"):
        vfife.Simulation("rotor.toml")  # type: ignore[arg-type]
    m = rotor(**TORQUE)
    m.settings = vfife.Settings(analysis="static")
    with pytest.raises(vfife.VfifeError, match="static analysis"):
        stepped(m)
