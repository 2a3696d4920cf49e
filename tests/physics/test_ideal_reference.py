"""The ideal mechanism beside a run answers for the same turns as the run, also where turns differ."""

from __future__ import annotations

import math

import pytest

import vfife
from vfife.measures.blows import blows
from vfife.model.functions import repeats_each_turn
from vfife.studies import study

TURN = 0.1  # s
TURNS = 5


def slider_crank(clearance: bool, **load: object) -> vfife.Mechanism:
    """A slider-crank with a small clearance in its gudgeon pin, or none, and a load on its piston."""
    m = vfife.Mechanism("loaded", settings=vfife.Settings(turns=TURNS))
    m.point("O", 0, 0)
    m.link("crank", length=0.05, mass=0.3)
    m.link("rod", length=0.15, mass=0.4)
    m.rigid_body("piston", mass=0.5, inertia=1e-3, position=(0.2, 0))
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("pin", "crank.end", "rod.start")
    if clearance:
        m.clearance_joint(
            "P", "rod.end", "piston.center", clearance=1e-5, bearing_radius=0.01, axial_length=0.02
        )
    else:
        m.revolute("P", "rod.end", "piston.center")
    m.slider("guide", "ground.O", "piston.center")
    m.drive("crank", speed=2.0 * math.pi / TURN)
    if load:
        m.force("push", "piston.center", force=(-500.0, 0.0), **load)
    return m


LOADS = {
    "over time, from the third turn on": {"times": (0.0, 0.2, 0.22, 1.0), "factors": (0.0, 0.0, 1.0, 1.0)},
    "over angles, that goes on after a turn": {"angles": (0.0, 3.0, 6.0), "factors": (0.0, 0.1, 1.0)},
    "over angles, that closes after two turns": {
        "angles": tuple(math.pi * k for k in range(5)), "factors": (0.0, 1.0, 0.0, 3.0, 0.0),
    },
}  # fmt: skip


@pytest.mark.parametrize("name", LOADS)
def test_the_reference_has_the_load_of_the_turns_of_the_run(name: str) -> None:
    load = LOADS[name]
    loose, ideal = (vfife.simulate(slider_crank(clearance, **load)) for clearance in (True, False))
    for joint in ("O", "pin", "guide"):
        told, expected = loose.reference.measures[f"{joint}.force.max"], ideal.measures[f"{joint}.force.max"]
        assert told.value == pytest.approx(expected.value, rel=1e-3), joint


def test_a_load_of_every_second_turn_is_no_blow() -> None:
    """The force of the pin is compared with the ideal one of the same turn, not of the turn before."""
    angles = tuple(0.5 * math.pi * k for k in range(9))  # two turns, loaded in the first
    load = {"angles": angles, "factors": (0.0, 0.5, 1.0, 0.5) + (0.0,) * 5}
    result = vfife.simulate(slider_crank(True, **load), turns=12)
    found = blows(result.record, result.reference.record, result.motion)
    assert result.motion.has_several and found["P"].excess < 300.0


def test_one_turn_suffices_where_each_is_the_same() -> None:
    assert repeats_each_turn(slider_crank(True))
    whole = {"angles": (0.0, math.pi, 2.0 * math.pi), "factors": (0.0, 1.0, 0.0)}
    assert repeats_each_turn(slider_crank(True, **whole))
    assert not any(repeats_each_turn(slider_crank(True, **load)) for load in LOADS.values())
    result = vfife.simulate(slider_crank(True, **whole), turns=3)
    assert result.reference.record.assembly.choice.outputs == result.record.assembly.choice.outputs // 3


def test_a_free_part_is_followed_through_all_turns() -> None:
    """A mass on a weak spring beside the machine swings for much longer than a turn."""
    m = slider_crank(True)
    m.point("wall", 0.3, 0.5)
    m.rigid_body("weight", mass=1.0, inertia=1e-3, position=(0.35, 0.5))
    m.slider("rail", "ground.wall", "weight.center")
    m.spring("soft", "ground.wall", "weight.center", stiffness=20.0, free_length=0.1)
    result = vfife.simulate(m)
    assert result.reference.record.assembly.choice.outputs == result.record.assembly.choice.outputs


def test_a_case_of_a_study_has_the_same_reference() -> None:
    m = slider_crank(True, **LOADS["over time, from the third turn on"])
    alone = vfife.simulate(m, companions=0)
    case = study(m, {"body.piston.mass": [0.5]}, measures=["pin.force.max", "pin.force.lip"], turns=TURNS)
    for name in ("pin.force.max", "pin.force.lip"):
        assert float(case.to_dataframe()[name].iloc[0]) == pytest.approx(
            alone.measures[name].value, rel=1e-12
        )
