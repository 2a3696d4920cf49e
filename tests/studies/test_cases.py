"""A case of a study is what it is alone, to the bit, whatever was assembled before it."""

from __future__ import annotations

import dataclasses
import gc
import math
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from choice import default_cases
from vfife import load_model, simulate
from vfife.assembly import possible
from vfife.errors import VfifeError
from vfife.kinematics import initial, start
from vfife.kinematics.solve import close_all
from vfife.measures.catalogue import PEAKS, over_turn
from vfife.measures.repetition import turns
from vfife.measures.turns import last_turn
from vfife.model.mechanism import Mechanism
from vfife.modelfile import loads
from vfife.modelfile.parameter import Parameter
from vfife.simulation.start import comparable, expected_forces, ideal_of, reference_of
from vfife.solvers.streaming import stepped
from vfife.studies.engine import cases as engine
from vfife.studies.engine import lanes
from vfife.studies.engine.cases import CaseModel, Cases, Stepped, run_cases
from vfife.studies.spec.plan import CaseSpec

EXAMPLES = Path(__file__).parents[2] / "examples"
CASE_C = EXAMPLES / "four_bar_case_c.toml"
COUNT = 6
NUMBERS = {
    "body.follower.length": 0.46, "body.crank.length": 0.4, "body.coupler.mass": 2.0,
    "driver.crank.speed": 157.0, "body.crank.mass": 3.1, "joint.C.contact.stiffness": 6.6e10,
    "joint.B.contact.restitution": 0.85, "joint.D.clearance": 2e-4, "joint.C.friction.coefficient": 0.1,
    "joint.C.bearing_radius": 0.01, "ground.D.0": 0.15, "ground.D.1": 0.001, "body.coupler.start_mass": 0.3,
    "body.follower.end_inertia": 1e-3, "body.crank.angle": 0.2, "body.coupler.angle": 0.89,
    "joint.C.impact_speed_floor": 1e-3, "body.follower.center_at": 0.2,
}  # fmt: skip

SOME = (
    "body.follower.length",
    "body.crank.length",
    "body.coupler.mass",
    "driver.crank.speed",
    "joint.C.contact.stiffness",
    "joint.D.clearance",
)


def spread(path: str, count: int = COUNT) -> list[dict[str, float | str]]:
    """Cases around a number of case c."""
    return [{path: NUMBERS[path] * (1.0 + 0.004 * k)} for k in range(count)]


def made(base: Mechanism, numbers: list[dict[str, Any]], **wanted: Any) -> list[Any]:
    """What goes into lanes."""
    return list(
        Cases(base, CaseSpec(("C.force.max",), wanted.pop("turns", 2), **wanted)).prepare_each(numbers)
    )


def alone(base: Mechanism, numbers: dict[str, Any]) -> CaseModel | None:
    """A case for which no other left anything, read from its text."""
    cases = Cases(base, CaseSpec(("C.force.max",), 2))
    return Cases(loads(cases.text, set=list(numbers.items())), cases.wanted).make({})


def same(one: Any, other: Any) -> bool:
    """Whether two assemblies are one, to the bit."""
    ours, theirs = (dataclasses.replace(each.mechanism, source=None) for each in (one, other))
    bits = [each.state.tobytes() + each.tables.tobytes() for each in (one, other)]
    alike = [(each.topology, each.choice, each.bodies, each.mobility, each.shared) for each in (one, other)]
    return bits[0] == bits[1] and alike[0] == alike[1] and ours == theirs


@pytest.mark.parametrize(
    "path", default_cases(NUMBERS, lambda path: path in SOME, "assembles cases of every number")
)
def test_a_case_is_assembled_as_it_is_alone(path: str) -> None:
    base = load_model(CASE_C)
    found = made(base, spread(path))
    assert all(isinstance(one, Stepped) for one in found)
    for k, numbers in list(enumerate(spread(path)))[:: COUNT - 1]:
        own = alone(base, numbers)
        assert own is not None and same(found[k].assembly, own.assembly)
        assert found[k].reference == own.reference and found[k].assembly.choice.automatic
    assert len({one.assembly.state.tobytes() for one in found}) == COUNT


@pytest.mark.parametrize("path", ["body.coupler.mass", "body.follower.length", "body.crank.mass"])
def test_a_case_under_gravity_has_its_own_weight(path: str) -> None:
    base = dataclasses.replace(load_model(CASE_C), gravity=(3.0, -9.81))
    found = made(base, spread(path))
    for one, numbers in zip(found, spread(path), strict=True):
        own = alone(base, numbers)
        assert own is not None and same(one.assembly, own.assembly) and one.reference == own.reference
        inverse, x, y = (
            one.assembly.state[one.assembly.layout[f"particle_{name}"]]
            for name in ("inverse_mass", "load_x", "load_y")
        )
        free = inverse > 0.0
        assert (x * inverse)[free] == pytest.approx(3.0, rel=1e-12)
        assert (y * inverse)[free] == pytest.approx(-9.81, rel=1e-12)


@pytest.mark.parametrize("name", ["four_bar_case_c", "slider_crank_loose_pin", "compressor"])
def test_largest_ideal_values_are_those_of_a_whole_turn_output_by_output(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a lane a turn is one output; the ideal mechanism's own run has hundreds in it."""
    base, ends = load_model(EXAMPLES / f"{name}.toml"), []

    def watched(*arguments: Any, **options: Any) -> Iterator[Any]:
        for lane in stepped(*arguments, **options):
            ends.append(lane.record)
            yield lane

    monkeypatch.setattr(lanes, "stepped", watched)
    [found] = made(base, [{}])
    own = reference_of(base, 2.0)
    assert own is not None and own.record.steps[-1] == ends[0].steps[-1] and len(ends[0].steps) == 2
    assert found.reference == over_turn(own.record, last_turn(own.record), PEAKS)


@pytest.mark.parametrize("name", ["four_bar_case_c", "compressor"])
def test_expected_forces_are_those_among_all_measures_of_the_ideal_mechanism(name: str) -> None:
    reference = reference_of(load_model(EXAMPLES / f"{name}.toml"), 2.0)
    assert reference is not None
    forces = {f"{joint}.force.max": value for joint, value in expected_forces(reference).items()}
    measures = reference.measures
    assert len(forces) > 2 and forces == {
        one: measures[one] for one in measures if one.endswith(".force.max")
    }


def test_several_numbers_at_once_in_any_order() -> None:
    base = load_model(CASE_C)
    numbers = [
        {path: values[path] for path in SOME for values in spread(path, 5)[k : k + 1]} for k in range(5)
    ]
    found, turned = made(base, numbers), made(base, numbers[::-1])[::-1]
    assert all(
        same(one.assembly, other.assembly) and one.reference == other.reference
        for one, other in zip(found, turned, strict=True)
    )
    for k in (0, 4):
        own = alone(base, numbers[k])
        assert own is not None and same(found[k].assembly, own.assembly)


def test_the_start_of_a_case_and_of_its_ideal_mechanism_is_solved_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    closed: list[Any] = []

    def counted(*arguments: Any) -> Any:
        closed.append(arguments)
        return close_all(*arguments)

    monkeypatch.setattr(start, "close_all", counted)
    assert len(made(load_model(CASE_C), spread("body.follower.length"))) == COUNT
    assert [len(systems) for systems, *_ in closed] == [1, COUNT - 1], (
        "the first by itself, the others at once"
    )


@pytest.mark.parametrize(
    ("path", "value"),
    [("body.rod.length", 0.1), ("joint.big-end.clearance", 2e-5), ("joint.small-end.bearing_radius", 6.5e-3)],
)
def test_cases_with_seated_journals_are_solved_at_once_and_as_each_alone(
    path: str, value: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a journal starts seated follows from its clearance, so that this one is no number of a record."""
    base, closed = load_model(EXAMPLES / "compressor.toml"), []
    monkeypatch.setattr(start, "close_all", lambda *own: closed.append(len(own[0])) or close_all(*own))
    numbers = [{path: value * (1.0 + 0.004 * k)} for k in range(COUNT)]
    made_at_once = list(Cases(base, CaseSpec(("big-end.force.max",), 2)).prepare_each(numbers))
    assert max(closed) == COUNT - 1 and len(closed) <= 6, "the first, and all others at once"
    for one, own in zip(made_at_once, numbers, strict=True):
        cases = Cases(base, CaseSpec(("big-end.force.max",), 2))
        model = Cases(loads(cases.text, set=list(own.items())), cases.wanted).make({})
        assert isinstance(one, Stepped) and model is not None and same(one.assembly, model.assembly)
        assert one.reference == model.reference
    assert len({one.assembly.state.tobytes() for one in made_at_once}) == COUNT  # type: ignore[union-attr]


def test_a_turn_is_followed_for_the_first_case_only_while_neighbours_tell_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    followed: list[Any] = []
    monkeypatch.setattr(possible, "passage", lambda *arguments: followed.append(arguments) or (None, ()))
    for path in ("body.follower.length", "body.coupler.mass", "driver.crank.speed"):
        assert len(made(load_model(CASE_C), spread(path))) == COUNT and not followed
    made(load_model(EXAMPLES / "scotch_yoke.toml"), [{"body.yoke.mass": 1.0 + k} for k in range(3)])
    assert len(followed) <= 1, "masses do not change the positions that were followed"


def test_models_that_are_dropped_leave_memory_without_the_garbage_collector() -> None:
    """A cycle of references would keep all objects of a batch until a full collection."""
    cases = Cases(load_model(CASE_C), CaseSpec(("*",), 1))
    enabled = gc.isenabled()
    gc.disable()
    try:
        cases.prepare(spread("body.follower.length", 4))
        models = [weakref.ref(model.assembly.mechanism) for model in cases.models.values()]  # type: ignore[union-attr]
        assert len(models) == 4 and all(model() is not None for model in models)
        cases.models.clear()
        cases.neighbour = possible.Outlook()
        assert all(model() is None for model in models)
    finally:
        if enabled:
            gc.enable()


def test_the_start_of_cases_is_that_of_the_law_of_cosines() -> None:
    """Lengths of a four-bar with its crank along x: the follower's angle is that of a triangle of which three
    sides are known.
    """
    lengths = [0.45, 0.455, 0.46, 0.47, 0.48]
    found = made(load_model(CASE_C), [{"body.follower.length": length} for length in lengths])
    for length, one in zip(lengths, found, strict=True):
        particle = one.assembly.bodies["follower"].particles[0]
        angle = float(one.assembly.state[one.assembly.layout.row("particle_theta", particle)])
        base = 0.4 - 0.15  # from D to B
        assert angle == pytest.approx(
            math.acos((length**2 + base**2 - 0.26**2) / (2.0 * length * base)), abs=1e-12
        )


@pytest.mark.parametrize(
    "path", ["body.follower.length", "body.coupler.mass", "driver.crank.speed", "joint.C.contact.stiffness"]
)
def test_cases_are_their_own_runs(path: str) -> None:
    numbers = spread(path, 4)
    asked = CaseSpec(
        ("C.force.max", "C.force.lip", "crank.torque.max", "C.friction_energy.total"), 1, step=4e-6
    )
    found = dict(run_cases(load_model(CASE_C), numbers, asked))
    for k in (0, 3):
        alone = simulate(load_model(CASE_C, set=list(numbers[k].items())), turns=1, step=4e-6, companions=0)
        assert found[k].status == "complete", found[k].reason
        assert found[k].values == {name: float(alone.measures[name]) for name in asked.measures}


def test_a_case_that_cannot_close_is_told_and_the_others_are_made() -> None:
    lengths = [0.46, 0.461, 0.8, 0.462, 0.463, 0.464]
    numbers: list[dict[str, Any]] = [{"body.follower.length": length} for length in lengths]
    numbers += [{"body.follower.length": "-1 m"}, {"body.follower.length": "0.465 m"}]
    found = made(load_model(CASE_C), numbers)
    reasons = [getattr(one, "reason", None) for one in found]
    assert [reason is None for reason in reasons] == [True, True, False, True, True, True, False, True]
    assert (
        "joints stay open" in reasons[2] and "cannot reach" in reasons[2] and "this is negative" in reasons[6]
    )
    assert [one.number for one in found] == list(range(8))


def test_a_step_that_is_too_large_for_a_case_fails_that_one_alone() -> None:
    numbers = [{"joint.C.contact.stiffness": value} for value in (1e9, 2e9, 3e9, 1e14)]
    found = made(load_model(CASE_C), numbers, step=4e-6)
    assert [getattr(one, "reason", None) is None for one in found] == [True, True, True, False]
    assert "is too large: contact of joint C" in found[3].reason


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("four_bar_case_b", "body.coupler.mass"),
        ("slider_crank_loose_guide", "body.rod.mass"),
        ("compressor", "driver.crank.speed"),
        ("six_bar_press", "body.coupler.length"),
        ("scotch_yoke", "body.yoke.mass"),
    ],
)
def test_cases_of_all_sorts_are_assembled_as_they_are_alone(name: str, path: str) -> None:
    """Elastic links, guides with clearance, loads over a travel, slots, redundant joints."""
    base = load_model(EXAMPLES / f"{name}.toml")
    value = Parameter(base, path).get()
    numbers = [{path: value * (1.0 + 0.01 * k)} for k in range(4)]
    found = made(base, numbers)
    for k in (1, 3):
        own = alone(base, numbers[k])
        assert (
            own is None
            if not isinstance(found[k], Stepped)
            else own is not None and same(found[k].assembly, own.assembly)
        )


def test_a_start_that_is_handed_on_is_taken_only_where_it_is_the_own_one() -> None:
    base = load_model(CASE_C)
    other = Parameter(base, "body.follower.length").set(0.47)
    known = initial.ideal_motion(base)
    assert initial.ideal_motion(base.ideal(), motion=known) is known
    for mechanism in (
        base,
        other,
        Parameter(base, "driver.crank.speed").set(100.0),
        Parameter(base, "body.coupler.mass").set(2.0),
    ):
        found, own = (initial.ideal_motion(mechanism, motion=one) for one in (known, None))
        for name in ("position", "velocity", "acceleration"):
            assert getattr(found, name).tobytes() == getattr(own, name).tobytes()


def test_the_start_under_loads_is_taken_by_the_ideal_mechanism_but_not_by_another_load() -> None:
    base = load_model(EXAMPLES / "compressor.toml")
    known = initial.ideal_motion(base)
    assert initial.ideal_motion(base.ideal(), motion=known) is known
    [(name, load)] = base.loads.items()
    wider = dataclasses.replace(base, loads={name: dataclasses.replace(load, bore=2.0 * load.bore)})  # type: ignore[attr-defined,call-arg]
    found, own = (initial.ideal_motion(wider, motion=one) for one in (known, None))
    assert found.reaction == own.reaction != known.reaction


def test_cases_are_assembled_once_each_in_batches_of_1_16_and_64(monkeypatch: pytest.MonkeyPatch) -> None:
    """A case that comes twice shares its model, whether it can be assembled or not."""
    sizes: list[int] = []
    monkeypatch.setattr(engine, "BATCH", 64)

    def counted(self: Cases, numbers: list[Any]) -> list[Any]:
        sizes.append(len(numbers))
        return [
            VfifeError("no such length") if one["body.follower.length"] > 0.5 else None for one in numbers
        ]

    monkeypatch.setattr(Cases, "make_all", counted)
    numbers = [{"body.follower.length": 0.46 + 0.001 * (k // 2)} for k in range(2 * 150)]
    found = made(load_model(CASE_C), numbers)
    assert sizes == [1, 8, 32, 32, 32, 32, 13]
    assert [one.reason for one in found] == [
        None if one["body.follower.length"] <= 0.5 else "no such length" for one in numbers
    ]


def test_the_oldest_model_is_dropped_where_there_is_room_for_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """However recently a case used it; it is made again when one needs it."""
    anew: list[Any] = []
    monkeypatch.setattr(engine, "MOST_MODELS", 3)
    monkeypatch.setattr(Cases, "make_all", lambda self, numbers: anew.extend(numbers) or [None])
    cases = Cases(load_model(CASE_C), CaseSpec(("B.force.max",), 1))
    lengths = [{"body.follower.length": 0.46 + 0.01 * k} for k in range(4)]
    for k in (0, 1, 2, 0, 3, 1, 0):
        cases.model(lengths[k])
    assert anew == [lengths[k] for k in (0, 1, 2, 3, 0)]


def test_models_of_a_batch_are_not_dropped_for_its_new_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else each of them is made again, alone."""
    calls: list[int] = []
    monkeypatch.setattr(engine, "BATCH", 3)
    monkeypatch.setattr(engine, "MOST_MODELS", 3)

    def counted(self: Cases, numbers: list[Any]) -> list[Any]:
        calls.append(len(numbers))
        return [None for _ in numbers]

    monkeypatch.setattr(Cases, "make_all", counted)
    cases = Cases(load_model(CASE_C), CaseSpec(("B.force.max",), 1))
    lengths = [{"body.follower.length": 0.46 + 0.01 * k} for k in range(4)]
    cases.prepare(lengths[:3])
    cases.prepare([lengths[0], lengths[3]])
    assert [cases.model(one) for one in (lengths[0], lengths[3])] == [None, None]
    assert calls == [3, 1]


def test_a_mechanism_without_clearance_has_no_ideal_one_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """It would be compared with itself."""
    runs: list[str] = []
    monkeypatch.setattr(lanes, "stepped", lambda *_, **__: runs.append("ideal"))
    base = load_model(EXAMPLES / "four_bar_ideal.toml")
    found = list(Cases(base, CaseSpec(("B.force.max",), 1)).prepare_each([{"body.follower.length": 0.46}]))
    assert isinstance(found[0], Stepped) and found[0].reference is None and not runs
    assert not comparable(base) and ideal_of(base) is None and comparable(load_model(CASE_C))
    assert simulate(base, turns=1, companions=0).reference is None


GUIDED = """
[run]
turns = 1
[ground]
O = [0, 0]
[body.arm]
length = "0.5 m"
mass = "1 kg"
[body.bob]
model = "particle"
mass = "0.2 kg"
inertia = "1e-4 kg m^2"
[joint.O]
bearing = "ground.O"
journal = "arm.start"
[joint.guide]
kind = "slider"
bearing = "arm.start"
journal = "bob.center"
[load.gas]
kind = "guide"
slider = "guide"
travels = [0, 0.5]
pressure = [1e5, 2e5]
bore = 0.01
[driver.arm]
speed = "10 rad/s"
"""


def test_a_case_is_refused_for_the_number_of_a_body_that_a_load_depends_on() -> None:
    """A particle without inertia does not turn with its guide: the number is refused as its text is."""
    cases, number = Cases(loads(GUIDED), CaseSpec(("O.force.max",), 1)), {"body.bob.inertia": 0.0}
    with pytest.raises(VfifeError, match="what slides in it does not turn with it") as of_text:
        loads(GUIDED, set=list(number.items()))
    with pytest.raises(VfifeError, match="what slides in it does not turn with it") as of_case:
        cases.mechanism(number)
    assert of_case.type is of_text.type
    assert cases.mechanism({"body.bob.inertia": 2e-4}).bodies["bob"].inertia == 2e-4


TIGHT_YOKE = """
name = "yoke whose block has little play in its slot"
gravity = [0, "-9.81 m/s^2"]
[ground]
O = [0, 0]
G = [0, 0]
[body.crank]
length = "40 mm"
mass = "0.4 kg"
[body.block]
model = "particle"
mass = "0.1 kg"
inertia = "2e-5 kg m^2"
position = ["40 mm", 0]
[body.yoke]
mass = "1.5 kg"
inertia = "0.006 kg m^2"
position = ["40 mm", 0]
[body.yoke.pins]
slot = [0, 0]
rod = ["120 mm", 0]
[joint.O]
bearing = "ground.O"
journal = "crank.start"
[joint.pin]
kind = "clearance"
bearing = "block.center"
journal = "crank.end"
clearance = "0.05 mm"
bearing_radius = "8 mm"
axial_length = "15 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.6 }
friction = { law = "ambrosio", coefficient = 0.05, v0 = "1 mm/s", v1 = "10 mm/s" }
[joint.slot]
kind = "clearance-slider"
bearing = "yoke.slot"
journal = "block.center"
direction = [0, 1]
clearance = "0.04 mm"
length = "30 mm"
height = "24 mm"
axial_length = "15 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.6 }
friction = { law = "ambrosio", coefficient = 0.05, v0 = "1 mm/s", v1 = "10 mm/s" }
[joint.guide]
kind = "slider"
bearing = "ground.G"
journal = "yoke.rod"
[driver.crank]
speed = "900 rpm"
"""


@pytest.mark.parametrize("clearance", [5e-6, 1e-5, 1.5e-5])
def test_a_tight_guide_has_the_bits_of_its_run_over_the_same_turns(clearance: float) -> None:
    """The motion is one, to the bit. Where the turns of a run repeat, its measures are means over them,
    and those of a case over its ``last`` turns.
    """
    names = ("pin.force.max", "slot.force.max", "pin.penetration.max")
    numbers: list[dict[str, float | str]] = [{"joint.slot.clearance": size} for size in (4e-5, clearance)]
    base = loads(TIGHT_YOKE)

    def case(last: int) -> Any:
        return dict(run_cases(base, numbers, CaseSpec(names, 5, last=last)))[1]

    outcome = case(1)
    run = simulate(loads(TIGHT_YOKE, set=list(numbers[1].items())), turns=5, step=outcome.step, companions=0)
    assert outcome.values == {name: over_turn(run.record, last_turn(run.record))[name] for name in names}
    counted = turns(run.record)
    assert counted is not None and counted.has_several
    means = case(counted.last - counted.first + 1).values
    assert means == {name: float(run.measures[name]) for name in names}
    assert means != outcome.values
