"""Joints that hold more than there is to hold, and positions where they hold less: reactions by closed forms, change points of coupled cranks."""

import math

import numpy as np
import pytest

from mechanisms import geared_ring
from support import go, joint_gap
from vfife.model.mechanism import Mechanism


def test_moments_of_gears_in_a_ring_do_not_drift():
    """Nothing is accelerated, so no moment is right; extrapolated reactions came to 587 and 1467 N m within 20 s."""
    record = go(geared_ring(), "auto", duration=20.0, outputs=200)
    assert np.abs(record.block("joint_moment")).max() < 1e-5


def beam(cranks: int, speed: float, radius: float = 0.1, start: float = 0.7) -> Mechanism:
    """A beam of 3 kg on cranks 0.3 m apart, the first one driven."""
    m = Mechanism("coupled wheels")
    names = [f"crank{k}" for k in range(cranks)]
    pins = {f"p{k}": (0.3 * k, 0.0) for k in range(cranks)}
    at = (radius * math.cos(start), radius * math.sin(start))
    m.rigid_body("beam", mass=3.0, inertia=0.1, pins=pins, center=(0.15 * (cranks - 1), 0.0), position=at)
    for k, name in enumerate(names):
        m.point(f"O{k}", 0.3 * k, 0.0)
        m.link(name, length=radius, mass=1.0, angle=start)
        m.revolute(f"O{k}", f"ground.O{k}", f"{name}.start")
        m.revolute(f"B{k}", f"{name}.end", f"beam.p{k}")
    m.drive(names[0], speed=speed)
    return m


@pytest.mark.parametrize("start", [0.7, -0.3])
@pytest.mark.parametrize("step", [1e-3, 1e-4, 2e-5])
def test_a_beam_on_three_cranks_passes_its_change_points(step, start):
    """Twice a turn all cranks are in line with the beam and any of them could turn back; they go on, and the beam's weight in w^2 r is carried."""
    speed, radius = 20.0, 0.1
    record = go(beam(3, speed, radius, start), step, duration=min(3.0, 4e4 * step), outputs=400)
    assert record.status == "complete"
    turn = record.block("particle_theta")
    assert max(np.abs(turn[:, 3:5] - turn[:, 2:3]).max(), np.abs(turn[:, 1]).max()) < 100.0 * step**2 + 1e-7
    assert max(joint_gap(record, joint) for joint in ("B0", "B1", "B2")) < 1e-6 * (step / 1e-3) + 1e-11
    names = record.assembly.ideals
    total = sum(record.block(f"joint_{axis}")[1:, names.index(f"B{k}")] * part for k in range(3) for axis, part in (("fx", 1.0), ("fy", 1j)))
    wanted = -3.0 * speed**2 * radius * np.exp(1j * turn[1:, 2])
    assert np.abs(total - wanted).max() < (0.1 * step / 1e-3 + 1e-4) * np.abs(wanted).max()
