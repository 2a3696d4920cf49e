"""Ranges of runs whose prescribed torque has a peak between two steps."""

from __future__ import annotations

import pytest

import vfife


@pytest.mark.parametrize("shape", [(1e-9, 1.0), (1.0, 1.0), (1.0, 1e-9)])
def test_the_range_contains_the_peak_of_a_torque_with_a_corner(shape: tuple[float, float]) -> None:
    """Acceleration = torque over inertia. The peak lies 0.03 of a step beside a step, which half and quarter
    steps do not come nearer to: their runs agree on a value that is too small.
    """
    step, inertia, ends = 1e-4, 1e-3, [2e-3 * side for side in shape]
    peak = 500.03 * step
    mechanism = vfife.Mechanism("rotor")
    mechanism.point("O", 0, 0)
    mechanism.rigid_body("rotor", mass=1.0, inertia=inertia)
    mechanism.revolute("shaft", "ground.O", "rotor.center")
    times = [0.0, peak - ends[0], peak, peak + ends[1], 1.0]
    mechanism.torque("rotor", value=[0.0, 0.0, 1.0, 0.0, 0.0], times=times, interpolation="linear")
    result = vfife.simulate(mechanism, duration=0.1, step=step)
    acceleration = result.measures["rotor.angular_acceleration.max"]
    assert acceleration.estimated
    assert acceleration.value < (1.0 - 1e-4) / inertia
    assert acceleration.high >= 1.0 / inertia
    assert acceleration.high < 1.1 / inertia
