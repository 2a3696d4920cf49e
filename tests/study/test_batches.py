"""Members that differ in numbers are assembled side by side, and each is what it is alone, to the bit."""

from __future__ import annotations

import dataclasses
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vfife import load_model, simulate
from vfife.analysis.measures import PEAKS, last_turn, over_turn
from vfife.assembly.together import MemberAssembly, Together
from vfife.fields.members import Alone, Differing, Members, members
from vfife.kinematics import initial
from vfife.kinematics.solve import close
from vfife.model.mechanism import Mechanism
from vfife.modelfile.parameter import numbers as numbers_of
from vfife.solvers.transient import run
from vfife.study import preparing
from vfife.study.columns import column, together
from vfife.study.engine import Wanted, run_members
from vfife.study.ideals import peaks_of
from vfife.study.member import Stepped
from vfife.study.preparing import Preparing

EXAMPLES = Path(__file__).parents[2] / "examples"
CASE_C = EXAMPLES / "four_bar_case_c.toml"
COUNT = 6
NUMBERS = {
    "body.follower.length": 0.46, "body.crank.length": 0.4, "body.coupler.mass": 2.0, "driver.crank.speed": 157.0, "body.crank.mass": 3.1,
    "joint.C.contact.stiffness": 6.6e10, "joint.B.contact.restitution": 0.85, "joint.D.clearance": 2e-4, "joint.C.friction.coefficient": 0.1,
    "joint.C.bearing_radius": 0.01, "ground.D.0": 0.15, "ground.D.1": 0.001, "body.coupler.start_mass": 0.3, "body.follower.end_inertia": 1e-3,
    "body.crank.angle": 0.2, "body.coupler.angle": 0.89, "joint.C.impact_speed_floor": 1e-3, "body.follower.center_at": 0.2,
}  # fmt: skip

SOME = ("body.follower.length", "body.crank.length", "body.coupler.mass", "driver.crank.speed", "joint.C.contact.stiffness", "joint.D.clearance")


@pytest.fixture(autouse=True)
def all_in_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of them as well, which would else be made one by one."""
    monkeypatch.setattr(preparing, "FIRST", 0)


def spread(path: str, count: int = COUNT) -> list[dict[str, float | str]]:
    """Members around a number of case c."""
    return [{path: NUMBERS[path] * (1.0 + 0.004 * k)} for k in range(count)]


def made(base: Mechanism, numbers: list[dict[str, Any]], **wanted: Any) -> list[Any]:
    """What goes into lanes."""
    return list(Preparing(base, Wanted(("C.force.max",), wanted.pop("turns", 2), **wanted)).each(numbers))


def same(one: Any, other: Any) -> bool:
    """Whether two assemblies are one, to the bit."""
    ours, theirs = (dataclasses.replace(each.mechanism, source=None) for each in (one, other))
    bits = [each.state.tobytes() + each.tables.tobytes() for each in (one, other)]
    alike = [(each.topology, each.choice, each.bodies, each.mobility, each.shared) for each in (one, other)]
    return bits[0] == bits[1] and alike[0] == alike[1] and ours == theirs


@pytest.mark.parametrize("path", NUMBERS)
def test_a_member_is_assembled_as_it_is_alone(path: str) -> None:
    base = load_model(CASE_C)
    found = made(base, spread(path))
    by_itself = Preparing(base, Wanted(("C.force.max",), 2))
    assert all(isinstance(one, Stepped) and isinstance(one.assembly, MemberAssembly) for one in found)
    for k, numbers in list(enumerate(spread(path)))[:: COUNT - 1]:
        alone = by_itself.make(numbers)
        assert alone is not None and same(found[k].assembly, alone.assembly)
        assert found[k].reference == alone.reference and found[k].assembly.choice.automatic
    assert len({one.assembly.state.tobytes() for one in found}) == COUNT


def test_several_numbers_at_once() -> None:
    base = load_model(CASE_C)
    numbers = [{path: values[path] for path in SOME for values in spread(path, 5)[k : k + 1]} for k in range(5)]
    found = made(base, numbers)
    by_itself = Preparing(base, Wanted(("C.force.max",), 2))
    for k in (0, 4):
        alone = by_itself.make(numbers[k])
        assert alone is not None and same(found[k].assembly, alone.assembly) and isinstance(found[k].assembly, MemberAssembly)


def test_the_first_of_a_study_are_made_one_by_one_and_are_what_they_are_in_a_batch(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that lanes begin soon; but where each has a number of its own that reaches the start there is nothing to win."""
    base, numbers = load_model(CASE_C), [{"joint.D.clearance": 2e-4 + 1e-6 * k} for k in range(COUNT)]
    monkeypatch.setattr(preparing, "FIRST", 3)
    found, batch = made(base, numbers), made(base, numbers[:3] * 2)
    assert [isinstance(one.assembly, MemberAssembly) for one in found] == [False] * 3 + [True] * 3
    assert all(same(found[k].assembly, batch[k + 3].assembly) and found[k].reference == batch[k + 3].reference for k in range(3))
    assert all(isinstance(one.assembly, MemberAssembly) for one in made(base, spread("body.crank.length")))


def test_one_ideal_run_of_many_tells_what_each_tells_alone() -> None:
    """The largest values of many turns are taken at once, from one record of their last rows."""
    base = load_model(CASE_C)
    ideals = [one.ideal for k in range(4) if (one := Preparing(base, Wanted((), 1)).make({"body.coupler.mass": 2.0 + k})) is not None]
    whole = [one for one in ideals if one is not None]
    alone = [over_turn(record, last_turn(record), PEAKS) for record in map(run, whole)]
    assert len(whole) == 4 and peaks_of(whole) == alone
    assert len({one["C.force.max"] for one in alone}) == 4 and not any(name.endswith("A.moment.max") for name in alone[0])


def test_what_a_batch_before_was_made_from_is_of_no_use_to_another_topology() -> None:
    """A link that bends stands for whatever members differ in kind; they are then made from their own first one."""
    base, other = load_model(CASE_C), Preparing(load_model(EXAMPLES / "four_bar_case_b.toml"), Wanted((), 1)).make({})
    by_itself = Preparing(base, Wanted(("C.force.max",), 2))
    batches = by_itself.batches()
    assert other is not None
    batches.models["body.coupler.mass",] = other
    for _ in range(2):
        found = batches.of(spread("body.coupler.mass"), 0)
        assert len(found) == COUNT and batches.models["body.coupler.mass",] is not other
    alone = by_itself.make(spread("body.coupler.mass")[4])
    assert alone is not None and same(found[4].assembly, alone.assembly)


def test_what_was_closed_for_some_members_is_not_closed_again_and_serves_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever their order, and whoever stood beside them then."""
    base, closed, lengths = load_model(CASE_C), [], np.array([0.45, 0.455, 0.46, 0.47, 0.48, 0.455])
    preparing_one = Preparing(base, Wanted((), 1))
    where = [column(preparing_one.base, preparing_one.raw, "body.follower.length")]

    def counted(system: Any, start: Any) -> Any:
        closed.append(len(start))
        return close(system, start)

    monkeypatch.setattr(initial, "close", counted)
    met: dict[Any, Any] = {}
    for which in ([4, 1], [0, 1, 2, 3, 4, 5], [5, 2]):
        nouns = together(base, where, lengths[which][:, None])[0]
        found, alone = (initial.driven_start(nouns, one) for one in (met, None))
        assert found.position.tobytes() == alone.position.tobytes() and found.velocity.tobytes() == alone.velocity.tobytes()
        assert isinstance(found.position, Members) and len(found.position) == len(which)
    assert closed == [2, 2, 3, 5, 2], "with what was met three are new the second time, and none the third"


def test_the_start_of_members_is_that_of_the_law_of_cosines() -> None:
    """Lengths of a four-bar with its crank along x: the follower's angle is that of a triangle of which three sides are known."""
    lengths = [0.45, 0.455, 0.46, 0.47, 0.48]
    found = made(load_model(CASE_C), [{"body.follower.length": length} for length in lengths])
    for length, one in zip(lengths, found, strict=True):
        particle = one.assembly.bodies["follower"].particles[0]
        angle = float(one.assembly.state[one.assembly.layout.row("particle_theta", particle)])
        base = 0.4 - 0.15  # from D to B
        assert angle == pytest.approx(math.acos((length**2 + base**2 - 0.26**2) / (2.0 * length * base)), abs=1e-12)


@pytest.mark.parametrize("path", ["body.follower.length", "body.coupler.mass", "driver.crank.speed", "joint.C.contact.stiffness"])
def test_members_are_their_own_runs(path: str) -> None:
    numbers = spread(path, 4)
    asked = Wanted(("C.force.max", "C.force.lip", "crank.torque.max", "C.friction_energy.total"), 1, step=4e-6)
    found = dict(run_members(load_model(CASE_C), numbers, asked))
    for k in (0, 3):
        alone = simulate(load_model(CASE_C, set=list(numbers[k].items())), turns=1, step=4e-6, companions=0)
        assert found[k].status == "complete", found[k].reason
        assert found[k].values == {name: float(alone.measures[name]) for name in asked.measures}


def test_a_member_that_cannot_close_is_told_and_the_others_are_made() -> None:
    lengths = [0.46, 0.461, 0.8, 0.462, 0.463, 0.464]
    numbers: list[dict[str, Any]] = [{"body.follower.length": length} for length in lengths]
    numbers += [{"body.follower.length": "-1 m"}, {"body.follower.length": "0.465 m"}]
    found = made(load_model(CASE_C), numbers)
    reasons = [getattr(one, "reason", None) for one in found]
    assert [reason is None for reason in reasons] == [True, True, False, True, True, True, False, True]
    assert "joints stay open" in reasons[2] and "cannot reach" in reasons[2] and "this is negative" in reasons[6]
    assert [one.number for one in found] == list(range(8))


def test_a_step_that_is_too_large_for_a_member_fails_that_one_alone() -> None:
    numbers = [{"joint.C.contact.stiffness": value} for value in (1e9, 2e9, 3e9, 1e14)]
    found = made(load_model(CASE_C), numbers, step=4e-6)
    assert [getattr(one, "reason", None) is None for one in found] == [True, True, True, False]
    assert "is too large: contact of joint C" in found[3].reason


@pytest.mark.parametrize(("name", "path"), [("four_bar_case_b", "body.coupler.mass"), ("slider_crank_loose_guide", "body.rod.mass"),
    ("compressor", "driver.crank.speed"), ("six_bar_press", "body.coupler.length"), ("scotch_yoke", "body.yoke.mass")])  # fmt: skip
def test_what_cannot_be_assembled_side_by_side_is_assembled_alone(name: str, path: str) -> None:
    """Elastic links, guides with play, loads over a travel, slots, redundant joints: the same members, whichever way they are made."""
    base = load_model(EXAMPLES / f"{name}.toml")
    value = numbers_of(base)[path]
    numbers = [{path: value * (1.0 + 0.01 * k)} for k in range(4)]
    found, by_itself = made(base, numbers), Preparing(base, Wanted(("C.force.max",), 2))
    for k in (1, 3):
        alone = by_itself.make(numbers[k])
        assert alone is None if not isinstance(found[k], Stepped) else alone is not None and same(found[k].assembly, alone.assembly)


def test_a_fault_that_nobody_foresaw_is_told_and_members_are_right_nevertheless(monkeypatch: pytest.MonkeyPatch) -> None:
    """An index out of its list says nothing about members: in tests it is an error."""

    def wrong(*words: Any, **more: Any) -> None:
        raise IndexError("list index out of range")

    base, path = load_model(CASE_C), "body.follower.length"
    monkeypatch.setattr(Together, "assembled", wrong)
    with pytest.raises(RuntimeWarning, match="a fault of vfife: IndexError"):
        made(base, spread(path, 3))
    with pytest.warns(RuntimeWarning, match="assembled one by one"), warnings.catch_warnings():
        warnings.simplefilter("always")
        found = made(base, spread(path, 3))
    alone = Preparing(base, Wanted(("C.force.max",), 2)).make(spread(path, 3)[2])
    assert alone is not None and same(found[2].assembly, alone.assembly)


def test_what_takes_a_plain_number_has_each_member_by_itself() -> None:
    for wrong in (float, int, math.cos, range):
        with pytest.raises(Alone):
            wrong(members([1.0, 2.0]))  # type: ignore[call-overload]
    assert float(members(0.5).reshape(())) == math.sqrt(members(0.25).reshape(())) == 0.5


def test_a_condition_that_differs_says_of_whom() -> None:
    with pytest.raises(Differing) as told:
        bool(members([1.0, -1.0, 2.0]) > 0.0)
    assert told.value.where.tolist() == [True, False, True]
    assert members([1.0, 2.0]) > 0.0 and not members([1.0, 2.0]) < 0.0
    assert (members([0.1, 0.3]) ** 2).tolist() == [0.1**2, 0.3**2]
    assert np.cos(members([0.5]))[0] == np.cos(0.5)
