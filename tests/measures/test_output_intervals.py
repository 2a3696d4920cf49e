"""Measures that are taken at the outputs: their ranges hold the largest value between outputs too, or they
are not estimated.
"""

import math

import numpy as np
import pytest

import vfife
from vfife.measures.output_intervals import missed


def pendulum() -> vfife.Mechanism:
    """A rod of 1 m and 1 kg that falls from 30 degrees about an ideal pin, the only one on the ground."""
    m = vfife.Mechanism("pendulum", gravity=(0.0, -9.81))
    pin = m.point("p", 0.0, 0.0)
    rod = m.link("rod", length=1.0, mass=1.0, angle="30 deg")
    m.revolute("A", pin, rod.start)
    return m


def slider_crank() -> vfife.Mechanism:
    """A crank of 50 mm and a rod of 150 mm at 100 rad/s, all joints ideal."""
    m = vfife.Mechanism("slider-crank")
    o = m.point("O", 0.0, 0.0)
    crank = m.link("crank", length=0.05, mass=1.0)
    rod = m.link("rod", length=0.15, mass=0.5)
    block = m.rigid_body("block", mass=0.8, inertia=1e-3, position=(0.2, 0.0))
    m.revolute("a", o, crank.start)
    m.revolute("b", crank.end, rod.start)
    m.revolute("c", rod.end, block.pin())
    m.slider("g", o, block.pin())
    m.drive(crank, speed=100.0)
    return m


def fastest() -> float:
    """Largest speed (m/s) of the slider in closed form, over ten thousand angles."""
    angle = np.linspace(0.0, 2.0 * math.pi, 10_001)
    lever = 0.05 * np.sin(angle)
    return float(np.abs(100.0 * lever * (1.0 + 0.05 * np.cos(angle) / np.sqrt(0.15**2 - lever**2))).max())


@pytest.mark.parametrize("outputs", [12, 20, 36, 50, 720])
def test_the_force_on_the_ground_is_that_of_the_only_pin(outputs: int) -> None:
    """The pin's largest force is taken over all steps, that on the ground at the outputs."""
    measures = vfife.simulate(pendulum(), duration="10 s", outputs=outputs).measures
    pin, ground = measures["A.force.max"], measures["ground.shaking_force.max"]
    assert pin.estimated
    assert not ground.estimated or ground.low <= pin.value <= ground.high
    if outputs == 720:
        assert ground.estimated and ground.width < 0.01 * ground.value


@pytest.mark.parametrize("outputs", [12, 20, 36, 50, 720])
def test_the_largest_speed_of_a_slider_lies_in_its_range(outputs: int) -> None:
    """The range holds the truth in closed form, and becomes narrow with the outputs."""
    speed = vfife.simulate(slider_crank(), turns=3, outputs=outputs).measures["g.velocity.max"]
    assert not speed.estimated or speed.low <= fastest() <= speed.high
    if outputs >= 36:
        assert speed.estimated and speed.width < 0.03 * speed.value


def test_a_table_has_no_range_where_none_is_estimated() -> None:
    """Low and high are NaN there, and the ends of the range elsewhere."""
    measures = vfife.simulate(pendulum(), duration="10 s", outputs=20).measures
    heads, *rows = measures.table()
    table = {row[0]: dict(zip(heads, row, strict=True)) for row in rows}
    ground, pin = table["ground.shaking_force.max"], table["A.force.max"]
    assert not ground["estimated"] and math.isnan(ground["low"]) and math.isnan(ground["high"])
    assert pin["low"] == measures["A.force.max"].low and pin["high"] == measures["A.force.max"].high


@pytest.mark.parametrize("count", [5, 7, 12, 60])
@pytest.mark.parametrize("phase", [0.0, 0.1, 0.25, 0.5])
def test_a_sine_rises_between_outputs_by_no_more_than_is_said(count: int, phase: float) -> None:
    """Five outputs a period or more, wherever they lie in it."""
    curve = np.sin(2.0 * math.pi * (np.arange(6 * count) + phase) / count)
    assert 1.0 - curve.max() <= missed(curve)


@pytest.mark.parametrize("count", [2.1, 2.5, 3.0, 4.0])
def test_a_curve_that_outputs_do_not_resolve_is_not_estimated(count: float) -> None:
    """Two to four outputs a period."""
    assert missed(np.sin(2.0 * math.pi * np.arange(40) / count)) == math.inf


def test_a_constant_misses_nothing() -> None:
    """Neither does one with rounding; too few outputs tell nothing."""
    assert missed(np.full(20, 3.0)) == 0.0
    assert missed(3.0 + 1e-14 * np.arange(20)) == 0.0
    assert missed(np.array([0.0, 1.0, 0.0])) == math.inf


def test_a_moment_of_rounding_misses_nothing() -> None:
    """The only force of a pendulum on the ground passes through the origin."""
    measures = vfife.simulate(pendulum(), duration="1 s").measures
    moment = measures.get("ground.shaking_moment.max")
    assert moment is None or (moment.estimated and moment.high < 1e-9)
