"""A block with clearance in its guide: the force of its corners together is what moves the block, and its
largest value is that of every step.
"""

import numpy as np
import pytest

from vfife.assembly.assemble import assemble
from vfife.laws import Coulomb, LankaraniNikravesh
from vfife.measures.forces import joint_force, joint_force_max, joint_rows
from vfife.model.mechanism import Mechanism, Settings
from vfife.solvers.record import Record
from vfife.solvers.transient import run

MASS, WEIGHT = 0.5, 0.5 * 9.81


def rattling(outputs: int, loop: str) -> Record:
    """A block that turns and falls in its guide, which nothing else holds: 2000 steps."""
    m = Mechanism("block in its guide", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("block", mass=MASS, inertia=1e-4, velocity=(0.3, -0.3, 0.5), pins={"pin": (0.0, 0.0)})
    m.clearance_slider(
        "guide", "ground.O", "block.pin", clearance=2e-4, length=0.05, height=0.02,
        friction=Coulomb(coefficient=0.2),
        contact=LankaraniNikravesh(restitution=0.7, stiffness=1e7),
    )  # fmt: skip
    m.settings = Settings(parts=1)  # so that every step is an output
    return run(assemble(m, 2e-6, duration=4e-3, outputs=outputs), loop=loop)


@pytest.mark.parametrize("loop", ["generated", "data-driven"])
def test_the_largest_force_of_a_block_is_that_which_moves_it(loop: str) -> None:
    """Newton's law at every step: F = m (a - g), whose largest value between two outputs is what the loop has
    kept.
    """
    every, some = rattling(2000, loop), rattling(20, loop)
    index = list(joint_rows(every)).index("guide")
    pushed = MASS * np.hypot(every.block("particle_ax")[1:, -1], every.block("particle_ay")[1:, -1] + 9.81)
    assert (
        np.count_nonzero(np.count_nonzero(every.block("contact_normal_force") > 0.0, axis=1) > 1) > 10
    )  # two corners at once
    assert np.hypot(*joint_force(every)[1:, index].T) == pytest.approx(pushed, rel=1e-9, abs=1e-9)
    assert joint_force_max(some)[1:, index] == pytest.approx(
        pushed.reshape(20, 100).max(axis=1), rel=1e-9, abs=1e-9
    )


def test_a_block_that_falls_upright_presses_with_both_corners() -> None:
    """By symmetry each corner has half of what the guide has, and one that has fallen presses with more than
    its weight.
    """
    m = Mechanism("block falls upright", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("block", mass=MASS, inertia=1e-4, pins={"pin": (0.0, 0.0)})
    m.clearance_slider(
        "guide",
        "ground.O",
        "block.pin",
        clearance=2e-4,
        length=0.05,
        height=0.02,
        contact=LankaraniNikravesh(restitution=0.1, stiffness=1e8),
    )
    record = run(assemble(m, 2e-6, duration=2e-2, outputs=10))
    most = joint_force_max(record)[1:, list(joint_rows(record)).index("guide")]
    assert most.max() > WEIGHT
    assert most == pytest.approx(
        2.0 * np.sqrt(record.block("contact_force_squared_max")[1:].max(axis=1)), rel=1e-6
    )
