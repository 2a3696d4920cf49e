"""What is open in an ideal joint is closed by a share in each step, and at once by a coarse one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vfife import Mechanism
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.runner import Runner

OPEN = 1e-7  # m


def gaps(step: float, steps: int, loop: str, coarse: int = 0) -> list[float]:
    """Distance (m) of the two pins of a bar on a pin at rest, without gravity, that starts open."""
    mechanism = Mechanism("bar", gravity=(0.0, 0.0))
    mechanism.point("A", 0.0, 0.0)
    mechanism.rigid_body("bar", mass=2.0, inertia=0.3, pins={"P": (-0.4, 0.1)})
    mechanism.revolute("A", "ground.A", "bar.P")
    assembly = assemble(mechanism, step, duration=200.0 * step, force_step=True)
    layout, state = assembly.layout, assembly.state.copy()
    rows = [layout.row(f"particle_{axis}", 1) for axis in ("x", "y", "theta")]
    state[rows[0]] += OPEN
    runner = Runner(
        assembly.topology.corrected(coarse),
        state[:, None],
        assembly.tables[None],
        loop,
        np.array(rows, dtype=np.uint32),
    )
    places = runner.advance(1, steps)[:, :, 0]
    return [
        math.hypot(x - 0.4 * math.cos(a) - 0.1 * math.sin(a), y - 0.4 * math.sin(a) + 0.1 * math.cos(a))
        for x, y, a in places.tolist()
    ]


@pytest.mark.parametrize("loop", ["generated", "interpreted"])
def test_a_step_closes_a_sixteenth_of_what_is_open(loop: str) -> None:
    found = gaps(1e-4, 40, loop)
    assert found[0] == pytest.approx(OPEN, rel=1e-6)
    for before, after in zip(found[:20], found[1:], strict=False):
        assert after / before == pytest.approx(15.0 / 16.0, rel=1e-6)


@pytest.mark.parametrize("coarse", [1, 2, 3])
def test_a_coarse_step_closes_all_that_is_open(coarse: int) -> None:
    found = gaps(1e-4, 3, "generated", coarse)
    assert found[0] == pytest.approx(OPEN, rel=1e-6) and max(found[1:]) < 1e-6 * OPEN
