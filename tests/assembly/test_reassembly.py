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
from vfife.assembly.reassemble import Reassembler, is_reassemblable, reassembled
from vfife.assembly.timestep import StepRequest
from vfife.kinematics.start import StartState
from vfife.laws import BrownMcPhee, HuntCrossley, LankaraniNikravesh, Tabulated
from vfife.model.wear import Wear

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


@pytest.mark.parametrize("share", [1e-3, 0.5, 40.0])
def test_any_clearance_smaller_than_the_bearing_is_written_into_the_rows(share: float) -> None:
    """However much it differs from the one before: the state has the bits of an assembly of its own."""
    base = assemble(gallery.four_bar_case_c(), 1e-6, force_step=True)
    joint = base.mechanism.contacts["C"]
    other = dataclasses.replace(joint, clearance=share * joint.clearance)
    ours = Reassembler(base, None).with_joints({"C": other})
    changed = dataclasses.replace(base.mechanism, joints={**base.mechanism.joints, "C": other})
    assert ours is not None
    assert ours.state.tobytes() == assemble(changed, 1e-6, force_step=True).state.tobytes()


@pytest.mark.parametrize(
    "numbers",
    [
        {"contact": HuntCrossley(restitution=0.9, stiffness=6.6e10)},
        {"friction": BrownMcPhee(coefficient=0.1)},
        {"wear": Wear(bearing=1e-15)},
        {"bearing": "coupler.start"},
        {"clearance": 0.01},
    ],
    ids=["law", "friction", "wear", "pin", "the journal vanishes"],
)
def test_a_joint_that_changes_more_than_its_rows_is_assembled_anew(numbers: dict[str, Any]) -> None:
    base = assemble(gallery.four_bar_case_c(), 1e-6, force_step=True)
    joint = base.mechanism.contacts["C"]
    reassembler = Reassembler(base, None)
    assert reassembler.with_joints({"C": joint}) is not None
    assert reassembler.with_joints({"C": dataclasses.replace(joint, **numbers)}) is None


def test_a_clearance_of_which_the_stiffness_overflows_is_assembled_anew() -> None:
    """The stiffness follows from the radii: it contains 1/clearance."""
    mechanism = gallery.four_bar_case_c()
    joint = dataclasses.replace(mechanism.contacts["C"], contact=LankaraniNikravesh(restitution=0.9))
    reassembler = Reassembler(
        assemble(
            dataclasses.replace(mechanism, joints={**mechanism.joints, "C": joint}), 1e-6, force_step=True
        ),
        None,
    )
    assert reassembler.with_joints({"C": dataclasses.replace(joint, clearance=1e-9)}) is not None
    assert reassembler.with_joints({"C": dataclasses.replace(joint, clearance=5e-324)}) is None


def test_a_journal_that_would_start_deep_in_its_bearing_is_assembled_anew() -> None:
    """It starts 7 mm beside the middle of a bearing of 10 mm: 4.9 mm deep with a clearance of 2.1 mm."""
    mechanism = gallery.journal_in_bearing(clearance=9e-3)
    joint = mechanism.contacts["O"]
    at = np.array([(0.0, 0.0, 0.0), (7e-3, 0.0, 0.0)])
    start = StartState(at, np.zeros((2, 3)), frozenset({"journal"}))
    base = assemble(mechanism, 1e-6, force_step=True, start_state=start)
    for clearance, reassembles in ((2.1e-3, True), (1.9e-3, False)):
        other = {"O": dataclasses.replace(joint, clearance=clearance)}
        assert (Reassembler(base, None).with_joints(other) is not None) is reassembles


def test_a_law_with_a_table_or_another_kind_of_joint_is_assembled_anew() -> None:
    table = Tabulated(loading=((0.0, 0.0), (1e-4, 1e4)))
    mechanism = gallery.four_bar_case_c()
    joints = {**mechanism.joints, "C": dataclasses.replace(mechanism.contacts["C"], contact=table)}
    for one in (dataclasses.replace(mechanism, joints=joints), gallery.slider_crank_loose_guide()):
        base = assemble(one)
        assert not is_reassemblable(one)
        assert Reassembler(base, None).with_joints(base.mechanism.contacts) is None


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
