"""Cases of a study are what their own runs are, to the bit, whatever they share lanes and threads with; one
that fails stops no other.
"""

from __future__ import annotations

import dataclasses
import math
import random
import threading
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fake_card import FakeDriver, in_this_machine
from vfife import Mechanism, gallery, load_model, simulate, study
from vfife.assembly.assemble import assemble
from vfife.errors import ModelError
from vfife.report.document import Caution
from vfife.report.study import document
from vfife.results.study import Study
from vfife.solvers.repeating import outputs_of_a_turn
from vfife.studies.engine import cases as engine
from vfife.studies.engine.cases import Cases, run_cases
from vfife.studies.engine.lanes import Stepped
from vfife.studies.engine.outcome import Outcome
from vfife.studies.spec.plan import CaseSpec

BASE = Path(__file__).parents[2] / "examples" / "four_bar_case_b.toml"
NUMBERS: list[dict[str, float | str]] = [
    {"joint.C.clearance": 1e-4},
    {"joint.C.clearance": "0.3 mm", "joint.C.contact.restitution": 0.7},
    {"joint.C.friction.coefficient": 0.05, "joint.C.contact.stiffness": "2e10 N/m^1.5"},
    {"joint.C.clearance": 2e-4, "driver.crank.speed": "1000 rpm"},
    {"body.coupler.mass": "3 kg"},
    {},
    {"joint.C.bearing_radius": "15 mm", "driver.crank.speed": "1000 rpm"},
]
SOME = (
    "C.force.max",
    "follower.angular_acceleration.max",
    "C.force.lip",
    "C.impacts",
    "C.friction_energy.total",
    "crank.torque.max",
)
SHORT = {"turns": 2, "step": 8e-6}


def own(numbers: dict[str, Any], turns: int, step: float | None = None, **options: Any) -> Any:
    """The case's own run."""
    return simulate(
        load_model(BASE, set=list(numbers.items())), turns=turns, step=step, companions=0, **options
    )


def bits(found: dict[int, Outcome]) -> dict[int, Any]:
    """Outcomes as they can be compared."""
    return {
        k: (dict(sorted(one.values.items())), one.turns, one.settled, one.status, one.step, one.steps)
        for k, one in found.items()
    }


def cases(
    numbers: list[dict[str, Any]] = NUMBERS, wanted: CaseSpec | None = None, **options: Any
) -> dict[int, Outcome]:
    """All outcomes, by number."""
    return dict(run_cases(load_model(BASE), numbers, wanted or CaseSpec(SOME, **SHORT), **options))


@pytest.fixture
def in_lanes(monkeypatch: pytest.MonkeyPatch) -> None:
    """No case is left to a run of its own."""

    def none(*_: Any) -> Outcome:
        raise AssertionError("a case ran by itself")

    monkeypatch.setattr(engine, "single", none)


@pytest.fixture(scope="module")
def reference() -> dict[int, Any]:
    """What every case's own run gives."""
    found = {}
    for k, numbers in enumerate(NUMBERS):
        result = own(numbers, **SHORT)
        values = {name: float(result.measures[name]) for name in SOME}
        choice = result.record.assembly.choice
        found[k] = (dict(sorted(values.items())), 2, None, "complete", choice.step, choice.steps)
    return found


@pytest.mark.parametrize(("lanes", "workers"), [(1, 2), (2, 3), (4, 1), (4, 4), (8, 2)])
@pytest.mark.usefixtures("in_lanes")
def test_cases_are_their_own_runs_whatever_is_beside_them(
    reference: dict[int, Any], lanes: int, workers: int
) -> None:
    assert bits(cases(lanes=lanes, workers=workers)) == reference


@pytest.mark.usefixtures("in_lanes")
def test_cases_on_a_card_are_their_own_runs(reference: dict[int, Any]) -> None:
    with in_this_machine(
        FakeDriver(assemble(load_model(BASE), 8e-6, turns=1.0, force_step=True).topology)
    ) as driver:
        assert bits(cases(device="cuda")) == reference
    assert driver.threads and not driver.given


@pytest.mark.usefixtures("in_lanes")
def test_order_does_not_matter(reference: dict[int, Any]) -> None:
    order = [*range(len(NUMBERS)), 0, 3]
    random.Random(3).shuffle(order)
    found = bits(cases([NUMBERS[k] for k in order]))
    assert [found[at] for at in range(len(order))] == [reference[k] for k in order]


@pytest.mark.usefixtures("in_lanes")
def test_all_measures_over_two_turns_are_means_of_those_of_each() -> None:
    """Every measure there is, from all outputs of the last turns."""
    found = cases(NUMBERS[:1], CaseSpec((), 3, step=8e-6, last=2))[0].values
    every = [dict(own(NUMBERS[0], turns, step=8e-6).measures) for turns in (2, 3)]
    assert found.keys() == every[1].keys()
    for name, value in found.items():
        counted = (
            name.endswith(
                (".impacts", ".grazing", ".deep_landings", "landing_depth.max", "approach_speed.max")
            )
            or ".share." in name
        )
        assert value == (every[1][name] if counted else (every[0][name] + every[1][name]) / 2.0), name


@pytest.mark.slow("turns with many knocks")
@pytest.mark.parametrize("last", [1, 2])
def test_contacts_of_the_last_turns_are_those_of_a_run_less_those_before(last: int) -> None:
    """In a lane, and in a run of its own."""
    model, pin = gallery.slider_crank_loose_pin(friction=0.0, clearance=2e-4, restitution=0.9), "pin"
    whole, before = (simulate(model, turns=turns, companions=0) for turns in (3, 3 - last))
    assert whole.measures[f"{pin}.impacts"] > before.measures[f"{pin}.impacts"] > 0.0
    wanted = {
        name: whole.measures[f"{pin}.{name}"] - before.measures[f"{pin}.{name}"]
        for name in ("impacts", "grazing", "deep_landings")
    }
    wanted["landing_depth.max"] = whole.measures[f"{pin}.landing_depth.max"]
    wanted["approach_speed.max"] = hardest_knock(whole, pin, last)
    assert wanted["approach_speed.max"] <= whole.measures[f"{pin}.approach_speed.max"]
    ends = [int(result.record.steps[-1]) for result in (whole, before)]
    for mode in ("free_flight", "impact", "continuous_contact"):
        shares = [result.measures[f"{pin}.share.{mode}"] for result in (whole, before)]
        steps = [share * (end + 1) for share, end in zip(shares, ends, strict=True)]
        wanted[f"share.{mode}"] = (steps[0] - steps[1]) / (ends[0] - ends[1])
    spec = CaseSpec((), 3, last=last, counts="last")
    lane, alone = dict(run_cases(model, [{}], spec))[0], engine.single(Cases(model, spec), {})
    assert lane.values == alone.values
    found = {name: lane.values[f"{pin}.{name}"] for name in wanted}
    assert found == pytest.approx(wanted, rel=1e-6, abs=1e-9)


def hardest_knock(result: Any, joint: str, last: int) -> float:
    """Largest approach speed (m/s) of the last turns of a run: of all of it if that grows in them, otherwise
    of the entries of its impacts.
    """
    record = result.record
    begin = len(record.steps) - 1 - last * (outputs_of_a_turn(record.assembly) or 1)
    fastest = record.block("contact_fastest")[:, list(record.assembly.contacts).index(joint)]
    if fastest[-1] > fastest[begin]:
        return float(fastest[-1])
    time = record.steps[begin] * record.assembly.choice.step
    entries = [entry for entry in result.impacts.entries if entry.joint == joint]
    return max(entry.speed for entry in entries if entry.since > time - 1e-9)


def test_a_study_file_has_the_default_of_counts_as_former_versions_do() -> None:
    for counts in ("case", "last"):
        spec = CaseSpec(SOME, 2, counts=counts)
        assert CaseSpec.of(spec.fields) == spec and ("counts" in spec.fields) == (counts == "last")


def test_a_case_of_a_single_turn_has_all_contacts_from_its_start_on() -> None:
    whole, last = (cases(NUMBERS[:1], CaseSpec((), 1, step=8e-6, counts=how))[0] for how in ("case", "last"))
    assert whole.values == last.values


@pytest.mark.usefixtures("in_lanes")
def test_a_case_ends_where_its_own_run_does_because_turns_repeat() -> None:
    numbers = [{"joint.C.clearance": 5e-5, "joint.C.contact.restitution": 0.1}, {"joint.C.clearance": 4e-4}]
    found = cases(numbers, CaseSpec(SOME[:1], 6, settle=0.02, step=1e-5))
    for k, one in enumerate(numbers):
        record = own(one, 6, step=1e-5, settle=0.02).record
        assert found[k].steps == record.steps[-1]
        assert found[k].turns == (len(record.steps) - 1) // (outputs_of_a_turn(record.assembly) or 1)
    assert found[0].settled == found[0].turns < found[1].turns < 6


@pytest.mark.parametrize("streaming", [True, False])
def test_means_of_a_case_that_settles_leave_out_its_start(monkeypatch, streaming: bool) -> None:
    """Four turns: the second differs from the first, and the last three repeat."""
    if not streaming:
        monkeypatch.setattr(engine, "streams", lambda *_: False)
    numbers = {"joint.C.clearance": 5e-5, "joint.C.contact.restitution": 0.1}
    found = cases([numbers], CaseSpec(SOME[:1], 6, settle=0.02, step=1e-5, last=6))[0]
    turns = [
        own(numbers, turn, step=1e-5).measures["C.force.max"].value for turn in range(1, found.turns + 1)
    ]
    assert found.settled == found.turns == 4
    assert found.values["C.force.max"] == pytest.approx(np.mean(turns[1:]), rel=1e-9)
    assert abs(np.mean(turns) / np.mean(turns[1:]) - 1.0) > 1e-3


ALTERNATING = {"joint.C.clearance": [2e-4, 2.5e-4]}  # m: with the first turns repeat, with the second pairs
POWER = ("C.force.max", "crank.power.mean")


def pairing(clearance: str = "0.2 mm") -> Mechanism:
    """A four-bar whose turns repeat in pairs where its joint has the second clearance."""
    mechanism = Mechanism("four-bar")
    left, right = mechanism.point("A", 0.0, 0.0), mechanism.point("D", 0.3, 0.0)
    crank = mechanism.link("crank", length=0.1, mass=0.5)
    coupler = mechanism.link("coupler", length=0.25, mass=1.0, angle="50 deg")
    rocker = mechanism.link("rocker", length=0.2, mass=0.8, angle="110 deg")
    mechanism.revolute("A", left, crank.start)
    mechanism.revolute("B", crank.end, coupler.start)
    mechanism.clearance_joint("C", coupler.end, rocker.end, clearance=clearance, bearing_radius="10 mm")
    mechanism.revolute("D", right, rocker.start)
    mechanism.drive(crank, speed="600 rpm")
    return mechanism


def warnings_of(one: Study) -> list[str]:
    """The cautions of the answer, without those that cases have as runs."""
    texts = [part.text for part in document(one).parts if isinstance(part, Caution)]
    return [text for text in texts if "examined cases" not in text]


@pytest.mark.parametrize("streaming", [True, False])
def test_a_case_whose_turns_repeat_in_pairs_is_measured_over_pairs(monkeypatch, streaming: bool) -> None:
    """As its own run; a case whose turns repeat one by one keeps the values of one turn, to the bit."""
    if not streaming:
        monkeypatch.setattr(engine, "streams", lambda *_: False)
    numbers = [{"joint.C.clearance": value} for value in ALTERNATING["joint.C.clearance"]]
    spec = CaseSpec(POWER, 40, settle=0.01, period_means=True)
    found = dict(run_cases(pairing(), numbers, spec))
    assert [(found[k].period, found[k].measured_turns) for k in (0, 1)] == [(1, 1), (2, 2)]
    run = simulate(pairing("0.25 mm"), turns=40, settle=0.01, companions=0)
    for name in POWER:
        assert found[1].values[name] == run.measures[name].value
    single = dict(run_cases(pairing(), numbers, dataclasses.replace(spec, period_means=False)))
    assert single[0].values == found[0].values and not found[0].ranges
    # Single turns: 1176 and 1368 N, -0.7 and 7.2 W.
    assert abs(single[1].values["C.force.max"] / found[1].values["C.force.max"] - 1.0) > 0.05
    for one in (single[1], found[1]):
        assert one.ranges["C.force.max"] == pytest.approx(190.0, rel=0.02)
    power, alone = (each[1].values["crank.power.mean"] for each in (found, single))
    assert abs(alone - power) == pytest.approx(0.5 * found[1].ranges["crank.power.mean"])


def test_a_study_names_the_cases_whose_turns_alternate() -> None:
    one = study(pairing(), ALTERNATING, POWER, turns=40, settle="1 %")
    said, data = document(one), document(one).data
    assert "measures are of the last turn, or of whole periods (means)" in str(said)
    (remark,) = data["remarks"]
    assert remark.startswith("Turns alternate in 1 of 2 cases (1 of period 2)") and "in case 1" in remark
    assert data["periods"] == {"1": 1, "2": 1} and data["different_turns"] == 1 and not warnings_of(one)
    assert one.to_dataframe()["period"].tolist() == [1, 2] == [row["period"] for row in one.rows()]
    assert one.data["period"].values.tolist() == [1.0, 2.0]


def test_one_turn_of_a_pair_has_an_error_as_large_as_turns_differ() -> None:
    one = study(pairing(), ALTERNATING, POWER, turns=40, settle="1 %", last=1)
    frame = one.to_dataframe()
    assert frame["C.force.max.error"][0] < 10.0 < 185.0 < frame["C.force.max.error"][1] < 195.0
    assert frame["crank.power.mean.error"][1] > 7.5 and one.errors["crank.power.mean"].most > 7.5
    (caution,) = warnings_of(one)
    assert caution.startswith("Not whole periods: turns alternate in 1 of 2 cases, and last = 1")
    # Four turns are whole periods.
    whole = study(pairing(), ALTERNATING, POWER, turns=40, settle="1 %", last=4)
    assert not warnings_of(whole) and max(whole.to_dataframe()["crank.power.mean.error"]) < 0.1


def test_cases_whose_turns_do_not_repeat_in_time_are_named() -> None:
    one = study(pairing(), ALTERNATING, POWER, turns=6, settle="0.1 %")
    (caution,) = warnings_of(one)
    assert caution.startswith("Not settled: turns of 1 of 2 cases do not repeat within 6 turns")
    assert document(one).data["periods"] == {"1": 1, "none": 1}
    assert one.to_dataframe()["crank.power.mean.error"][1] > 7.0


def test_a_number_of_turns_tells_where_the_last_turns_differ() -> None:
    one = study(pairing(), ALTERNATING, POWER, turns=12)
    (caution,) = warnings_of(one)
    assert caution.startswith("Turns differ: in 1 of 2 cases a measure differs between the last turns")
    assert "in case 1, in crank.power.mean by 7.9" in caution
    assert document(one).data["periods"] is None and "Turns were not compared" not in str(document(one))
    assert not warnings_of(study(pairing(), ALTERNATING, POWER, turns=12, last=4))


@pytest.mark.usefixtures("in_lanes")
def test_the_automatic_step_is_that_of_the_own_run_halved_where_first_contacts_land_too_deep() -> None:
    numbers = [{"joint.C.landing_depth": 1e-8}, {"joint.C.contact.stiffness": 2e10}]
    found = cases(numbers, CaseSpec(SOME[:1], 1))
    tried = []
    for k, one in enumerate(numbers):
        choice = own(one, 1).record.assembly.choice
        assert (found[k].step, found[k].steps) == (choice.step, choice.steps)
        tried.append(len(choice.tried))
    assert tried[0] > tried[1]


PLAY = {
    "clearance": 3e-4, "bearing_radius": "20 mm", "axial_length": 0.03, "impact_speed_floor": 2e-3,
    "landing_depth": 2e-5, "contact.stiffness": 3e10, "contact.restitution": 0.4, "friction.coefficient": 0.2,
    "friction.v0": 2e-4, "friction.v1": 2e-2,
}  # fmt: skip


@pytest.mark.parametrize("key", PLAY)
def test_numbers_of_play_reach_what_assembly_says(key: str) -> None:
    """Made from an assembly of other numbers, and assembled anew: every bit of state and tables, the step,
    the topology.
    """
    cases, numbers = Cases(load_model(BASE), CaseSpec((), 2)), {f"joint.C.{key}": PLAY[key]}
    made, again = cases.model({}), cases.make(numbers)
    assert made is not None and again is not None
    sooner = cases.reassembled(made, numbers)
    assert sooner is not None
    late = again.reassembler.assembly
    assert (sooner.state.view(np.uint64) == late.state.view(np.uint64)).all()
    assert (sooner.state != made.reassembler.assembly.state).any() or key == "axial_length"
    assert (sooner.tables == late.tables).all()
    assert sooner.topology == late.topology
    assert sooner.choice == late.choice
    assert sooner.mechanism == dataclasses.replace(late.mechanism, source=sooner.mechanism.source)


ALONE = (0, 1, 16, 17, 62, 63, 64, 65, 66, 80, 81, 129)  # on both sides of a border of batches


def length_of_case(number: int) -> dict[str, float | str]:
    """Return what a case of a series of lengths changes."""
    return {"body.coupler.length": 0.26 + 1e-5 * number}


@cache
def case_by_itself(number: int) -> object:
    """Return a case of the series, prepared by itself; its bits do not depend on the length of the series."""
    return Cases(load_model(BASE), CaseSpec(("C.force.max",), 1)).case(number, length_of_case(number))


@pytest.mark.parametrize("count", [63, 64, 65, 66, 130])
def test_cases_on_both_sides_of_a_border_of_batches_have_their_own_bits(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lengths, assembled 1, 16, 64, 64, ... at once and each by itself."""
    monkeypatch.setattr(engine, "BATCH", 64)
    base, spec = load_model(BASE), CaseSpec(("C.force.max",), 1)
    sizes, prepare = list[int](), Cases.prepare
    monkeypatch.setattr(Cases, "prepare", lambda self, own: (sizes.append(len(own)), prepare(self, own)))
    made = list(Cases(base, spec).prepare_each([length_of_case(k) for k in range(count)]))
    assert sizes[:3] == [1, 16, min(64, count - 17)] and sum(sizes) == count == len(made)
    for k in (k for k in ALONE if k < count):
        own, one = case_by_itself(k), made[k]
        assert isinstance(own, Stepped) and isinstance(one, Stepped) and one.number == k
        assert one.assembly.state.tobytes() == own.assembly.state.tobytes()
        assert one.assembly.choice == own.assembly.choice and one.reference == own.reference
        assert one.assembly.topology == own.assembly.topology


@pytest.mark.parametrize(
    "bad",
    [
        {"joint.C.clearance": -1.0},
        {"joint.C.clearance": 0.5},
        {"joint.nowhere.clearance": 1e-4},
        {"joint.C.clearance": "3 kg"},
        {"body.coupler.length": "5 m"},
    ],
)
def test_case_that_fails_says_why_and_stops_no_other(bad: dict[str, Any], reference: dict[int, Any]) -> None:
    found = cases([bad, NUMBERS[0]])
    assert found[0].status == "failed"
    assert found[0].reason is not None
    assert len(found[0].reason) > 20
    assert found[0].values == {}
    assert bits(found)[1] == reference[0]


def test_case_that_diverges_is_told_as_its_own_run() -> None:
    """A journal that goes through its soft bearing; a step that is too large for one case is
    told before.
    """
    soft = {"joint.C.contact.stiffness": 1e5}
    found = cases([soft, {}, {"joint.C.contact.stiffness": 1e16}], CaseSpec(SOME[:1], 1, step=5e-6))
    record = own(soft, 1, step=5e-6).record
    assert found[0].status == str(record.status) == "diverged"
    assert found[0].steps == record.steps[-1]
    assert found[0].reason is not None
    assert (
        "penetration of joint C reached 10.03 mm" in found[0].reason
    )  # a fault of the contact, not of the step
    assert found[1].status == "complete"
    assert found[2].status == "failed"
    assert "too large" in str(found[2].reason)


def test_stopped_cases_are_left_out() -> None:
    stop = threading.Event()
    found = []
    for k, _ in run_cases(
        load_model(BASE), NUMBERS * 20, CaseSpec(SOME[:1], 1, step=8e-6), workers=1, lanes=2, stop=stop
    ):
        found.append(k)
        stop.set()
    assert 1 <= len(found) < 100


def test_cases_with_a_duration_need_no_crank() -> None:
    """A journal that falls into its bearing: each case is its own run, and a sample of them is repeated."""
    model = load_model(BASE.with_name("journal_in_bearing.toml"))
    values = {"joint.O.clearance": ["0.4 mm", "0.5 mm"]}
    keys: dict[str, Any] = {"measures": ["O.force.max"], "duration": "1 ms", "step": 1e-6}
    found = study(model, values, **keys)
    for value, force in zip(values["joint.O.clearance"], found.values("O.force.max"), strict=True):
        changed = load_model(model.source, set=[("joint.O.clearance", value)])
        alone = simulate(changed, duration=1e-3, step=1e-6, companions=0)
        assert force == alone.measures["O.force.max"] > 0.0
    assert found.errors["O.force.max"].count == 2
    assert "1 ms; measures are of the whole run" in str(document(found).parts)


@pytest.mark.parametrize("step", ["auto", 7e-6])
def test_cases_that_end_within_a_turn_measure_what_a_run_does(step: float | str) -> None:
    """The last 360 degrees of 1.3 turns of each speed, with the steps of the case and of its repetitions."""
    model = load_model(BASE)
    speeds = [1.0 * float(model.drivers["crank"].speed), 1.1 * float(model.drivers["crank"].speed)]
    duration = 1.3 * 2.0 * math.pi / speeds[0]
    keys: dict[str, Any] = {"duration": duration, "step": step}
    found = study(model, {"driver.crank.speed": speeds}, ["C.force.max"], **keys)
    for speed, force in zip(speeds, found.values("C.force.max"), strict=True):
        changed = load_model(BASE, set=[("driver.crank.speed", speed)])
        alone = simulate(changed, duration=duration, step=step, companions=0)
        assert force == alone.measures["C.force.max"]
        assert alone.record.steps[-1] * alone.record.assembly.choice.step > 1.2 * duration / 1.3
    assert found.errors["C.force.max"].count == 2
    turn = 2.0 * math.pi / np.array(speeds)
    for number, repeat in found.repeats.items():
        exact = turn[number] / repeat["step"]
        assert step != "auto" or abs(exact - round(exact)) < 1e-6


def test_turns_without_a_crank_are_refused_with_the_remedy() -> None:
    model = load_model(BASE.with_name("journal_in_bearing.toml"))
    with pytest.raises(ModelError, match='duration = "0.5 s"'):
        study(model, {"joint.O.clearance": [1e-4]}, ["O.force.max"])
    with pytest.raises(ModelError, match="settle.*a case with a duration has no turns"):
        study(model, {"joint.O.clearance": [1e-4]}, ["O.force.max"], duration=0.1, settle=0.01)


def test_a_study_of_a_version_without_durations_goes_on() -> None:
    wanted = {"measures": ["C.force.max"], "turns": 2, "settle": None, "last": 1, "step": None}
    assert CaseSpec.of(wanted) == CaseSpec(("C.force.max",), 2)
