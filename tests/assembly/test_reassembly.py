"""Other numbers of clearance joints in an assembly: which rows change, and how the stable step goes with the
stiffness, in closed form.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from vfife import gallery
from vfife.assembly.assemble import assemble
from vfife.assembly.reassemble import Reassembler, reassembled
from vfife.assembly.timestep import StepRequest

FORCES = {"B": 300.0, "C": 200.0, "D": 250.0}


def stiffer(joint: Any, factor: float) -> Any:
    """A joint whose law has a coefficient (N/m^1.5) that is so many times larger."""
    law = dataclasses.replace(joint.contact, stiffness=2e10 * factor)
    return dataclasses.replace(joint, contact=law)


def test_numbers_of_one_joint_leave_the_rows_of_the_others() -> None:
    base = assemble(gallery.four_bar_case_c())
    joint = dataclasses.replace(base.mechanism.contacts["C"], clearance=3.5e-4)
    ours = reassembled(base, {"C": joint})
    size, changed = base.layout["contact_size"], np.flatnonzero(ours.state != base.state)
    assert ours.state[size].tolist() == [
        3.5e-4 if one == "C" else base.mechanism.contacts[one].clearance for one in base.contacts
    ]
    own = base.contacts.index("C")
    records = [base.layout.record("contact", k) for k in range(len(base.contacts))]
    assert records[own] <= changed.min() and changed.max() < (*records, len(base.state))[own + 1]
    assert ours.choice is base.choice and ours.topology is base.topology


@pytest.mark.parametrize("factor", [0.25, 3.0, 40.0])
def test_stable_step_goes_with_the_cube_root_of_the_stiffness(factor: float) -> None:
    """F = K d^1.5 under a given force has the slope 1.5 K^(2/3) F^(1/3), and 2/w goes with its root."""
    mechanism = gallery.four_bar_case_c()
    soft = dataclasses.replace(
        mechanism, joints={n: stiffer(j, 1.0) if n in FORCES else j for n, j in mechanism.joints.items()}
    )
    request = StepRequest("auto", turns=2.0)
    base = assemble(soft, "auto", expected=FORCES, turns=2.0)
    hard = Reassembler(base, request, FORCES).with_joints(
        {name: stiffer(soft.contacts[name], factor) for name in FORCES}
    )
    assert hard is not None
    before, after = dict(base.choice.limits), dict(hard.choice.limits)
    for name in FORCES:
        key = f"contact of joint {name}"
        assert after[key] / before[key] == pytest.approx(factor ** (-1.0 / 3.0), rel=1e-9)
    assert hard.choice.step < base.choice.step if factor > 1.0 else hard.choice.step > base.choice.step
    assert hard.state[hard.layout["step"]].tolist() == [hard.choice.step]
