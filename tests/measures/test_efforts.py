"""Power, torque, speed and work of drivers that apply a torque or force, against closed forms."""

from __future__ import annotations

import json
import math

import pytest

import vfife
from model_texts import FALLING, FLYWHEEL
from vfife.modelfile import loads
from vfife.report.run import document
from vfife.report.terminal import as_text


def wheel(driver: str, outputs: int) -> str:
    """Return a model of a wheel that is driven for 1 s."""
    return FLYWHEEL.format(driver=driver, run=f'duration = "1 s"\noutputs = {outputs}')


def summary_of(driver: str, outputs: int = 100) -> dict:
    return vfife.simulate(loads(wheel(driver, outputs))).summary


@pytest.mark.parametrize("outputs", [20, 100, 500])
def test_a_motor_whose_torque_falls_with_speed(outputs: int) -> None:
    """Torque 2 N m (1 - w/w0) on an inertia I: w = w0 (1 - exp(-t/T)), with T = I w0/(2 N m) = 2.5 s."""
    effort = summary_of(FALLING, outputs)["efforts"]["wheel"]
    begin, end = effort["begin"], effort["end"]

    def speed(time: float) -> float:
        return 50.0 * (1.0 - math.exp(-0.4 * time))

    def energy(time: float) -> float:
        return 0.05 * speed(time) ** 2

    # It turns by 9.1 rad within 1 s: its last turn is within the second half.
    assert (effort["turns"], effort["body"]) == (1, "wheel") and 0.5 <= begin < 0.52 and end == 1.0
    square = 4.0 * (math.exp(-0.8 * begin) - math.exp(-0.8 * end)) / 0.8 / (end - begin)
    exact = {
        "work": energy(1.0),
        "power": (energy(end) - energy(begin)) / (end - begin),
        "rms": math.sqrt(square),
        "largest": 2.0 - 2.0 * speed(begin) / 50.0,
        "low": speed(begin),
        "high": speed(end),
    }
    for name, value in exact.items():
        assert abs(effort[name]["value"] - value) <= effort[name]["missed"] < 1e-2 * value, name


def test_a_constant_torque_has_the_work_of_its_angle() -> None:
    """0.4 N m on 0.1 kg m^2: 4 rad/s^2, 2 rad in 1 s, which is no turn: figures are of the second half."""
    effort = summary_of('torque = "0.4 N m"')["efforts"]["wheel"]
    assert (effort["turns"], effort["begin"]) == (0, 0.5)
    assert effort["work"]["value"] == pytest.approx(0.8, rel=1e-9) and effort["work"]["missed"] < 1e-12
    assert effort["power"]["value"] == pytest.approx(0.4 * 1.5 / 0.5, rel=1e-9)
    assert effort["largest"] == {"value": 0.4, "missed": 0.0}


def test_a_torque_over_the_angle() -> None:
    """M = 2 N m (1 - angle/3 rad): w' = 20 - 20/3 angle, an oscillation about 3 rad."""
    effort = summary_of('torque = [2, 0]\nangles = ["0 rad", "3 rad"]', 400)["efforts"]["wheel"]
    angle = 3.0 * (1.0 - math.cos(math.sqrt(20.0 / 3.0)))
    # Beyond 3 rad the torque stays 0, from when on the wheel turns evenly: its work is that of the table.
    assert angle > 3.0
    assert abs(effort["work"]["value"] - 3.0) <= effort["work"]["missed"] + 1e-6 < 1e-3


def test_a_pulse_between_two_outputs_is_not_estimated() -> None:
    """A torque that rises and falls within an output interval shows at no output."""
    pulse = 'torque = [0, 0, 5, 0, 0]\ntimes = ["0 s", "0.302 s", "0.304 s", "0.306 s", "1 s"]'
    summary = summary_of(pulse)
    assert summary["efforts"]["wheel"]["work"]["missed"] is None
    text = as_text(document(summary), 300)
    assert "what outputs miss: mean power not estimated, rms torque not estimated, largest" in text
    wide = summary_of(pulse, 1000)["efforts"]["wheel"]["work"]
    # 0.01 N m s turn 0.1 kg m^2 at 0.1 rad/s: 0.5 mJ.
    assert abs(wide["value"] - 5e-4) <= wide["missed"] < 5e-4


def test_a_largest_torque_between_two_outputs_is_that_of_the_table() -> None:
    summary = summary_of('torque = [0, 5, 0]\ntimes = ["0 s", "0.803 s", "1 s"]')
    assert summary["efforts"]["wheel"]["largest"] == {"value": pytest.approx(5.0), "missed": 0.0}


def test_work_of_a_motor_is_not_that_of_the_loads() -> None:
    """A constant torque that turns a wheel against a brake: the answer names the work of each."""
    brake = FALLING + '\n[load.brake]\nat = "wheel.c"\nmoment = "-0.5 N m"'
    summary = summary_of(brake)
    # Torque 1.5 N m - 2 N m w/w0: speed 37.5 rad/s (1 - exp(-0.4 t)).
    angle = 37.5 * (1.0 - (1.0 - math.exp(-0.4)) / 0.4)
    motion = 0.05 * (37.5 * (1.0 - math.exp(-0.4))) ** 2
    drivers = summary["energy"]["drivers"]
    assert abs(drivers["value"] - (motion + 0.5 * angle)) <= drivers["missed"] < 0.01
    text = " ".join(as_text(document(summary), 300).split())
    assert f"of loads and weight {-0.5 * angle:.3f}" in text and f"together {motion:.3f}" in text
    assert json.dumps(summary["efforts"])


BRAKE = FALLING + '\n[load.brake]\nat = "wheel.c"\nmoment = "-0.5 N m"'


def test_power_into_kinetic_energy_is_named_with_what_it_leaves() -> None:
    """Torque 1.5 N m - 2 N m w/w0: speed 37.5 rad/s (1 - exp(-0.4 t)); the brake takes 0.5 N m times it."""
    summary = summary_of(BRAKE, 500)
    effort = summary["efforts"]["wheel"]
    begin, length = effort["begin"], 1.0 - effort["begin"]
    speeds = [37.5 * (1.0 - math.exp(-0.4 * time)) for time in (begin, 1.0)]
    angle = 37.5 * (length + (math.exp(-0.4) - math.exp(-0.4 * begin)) / 0.4)
    assert effort["rise"]["value"] == pytest.approx(0.05 * (speeds[1] ** 2 - speeds[0] ** 2) / length, 1e-4)
    assert effort["rest"]["value"] == pytest.approx(0.5 * angle / length, rel=2e-4)
    text = " ".join(as_text(document(summary), 300).split())
    assert f"takes {effort['rise']['value']:.4g} W, which leaves {effort['rest']['value']:.2f}" in text


def test_figures_are_of_the_steady_turns_that_a_run_reaches() -> None:
    """From 10 s on 1.3 % of the work raise the kinetic energy; a later turn has less, and is stated alone."""
    text = FLYWHEEL.format(driver=BRAKE, run='duration = "20 s"\noutputs = 4000')
    summary = vfife.simulate(loads(text)).summary
    effort = summary["efforts"]["wheel"]
    assert 10.5 < effort["begin"] < 14.0
    assert effort["power"]["value"] == pytest.approx(0.5 * 37.5, rel=0.01)
    assert abs(effort["rise"]["value"]) < 0.01 * effort["power"]["value"]
    assert "kinetic energy takes" not in as_text(document(summary), 300)


def test_of_two_drivers_what_the_kinetic_energy_leaves_is_not_known() -> None:
    second = BRAKE + '\n[driver.other]\nbody = "wheel"\ntorque = "0.1 N m"'
    summary = summary_of(second)
    assert summary["efforts"]["other"]["rest"] is None
    text = " ".join(as_text(document(summary), 300).split())
    assert "while kinetic energy takes" in text and "which leaves" not in text


SLOW = """
[body.slow]
mass = "1 kg"
inertia = "1e-6 kg m^2"
[body.slow.pins]
c = [0, 0]
[joint.P]
bearing = "ground.P"
journal = "slow.c"
[gear.reduction]
first = "wheel"
second = "slow"
ratio = {ratio}
"""


@pytest.mark.parametrize(
    ("gear", "body", "turns"),
    [("", "wheel", 11), (-0.2, "slow", 2), (-0.07, "slow", 1), (-0.01, "wheel", 11)],
)
def test_figures_are_of_whole_turns_of_the_slowest_body(gear: float | str, body: str, turns: int) -> None:
    """20 N m on 0.1 kg m^2 turn it by 100 rad in 1 s, by 75 rad in the second half."""
    text = wheel('torque = "20 N m"', 1000)
    if gear:
        text = text.replace("[ground]\n", "[ground]\nP = [1, 0]\n")
        text += SLOW.format(ratio=gear)
    effort = vfife.simulate(loads(text)).summary["efforts"]["wheel"]
    assert (effort["turns"], effort["body"]) == (turns, body)
    path = 2.0 * math.pi * turns / abs(gear or 1.0) if body == "slow" else 2.0 * math.pi * turns
    assert effort["begin"] == pytest.approx(math.sqrt(1.0 - path / 100.0), abs=1.1e-3)


CART = """
[run]
duration = "1 s"
[ground]
O = [0, 0]
[body.c]
mass = "2 kg"
inertia = "0.1 kg m^2"
[joint.g]
kind = "slider"
bearing = "ground.O"
journal = "c.center"
direction = [1, 0]
[driver.push]
point = "c.center"
direction = [-2, 0]
force = ["0 N", "4 N", "0 N"]
times = ["0 s", "0.5 s", "1 s"]
interpolation = "linear"
"""


def test_a_force_along_a_line() -> None:
    """A triangle of 4 N moves 2 kg: 0.5 m/s at its top and 1 m/s at its end."""
    summary = vfife.simulate(loads(CART)).summary
    effort = summary["efforts"]["push"]
    exact = {"work": 1.0, "power": 1.5, "rms": 4.0 / math.sqrt(3.0), "low": 0.5, "high": 1.0}
    for name, value in exact.items():
        assert abs(effort[name]["value"] - value) <= effort[name]["missed"] + 1e-9 < 1e-4, name
    assert "largest force 4 N" in as_text(document(summary), 300) and effort["linear"]


def test_works_without_error_state_none() -> None:
    text = as_text(document(summary_of('torque = "0.4 N m"')), 300)
    assert "work of drivers 0.8000 J, lost" in text and "rms torque rounding, largest torque rounding" in text
