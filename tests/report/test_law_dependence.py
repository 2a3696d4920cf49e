"""The caution on forces that the contact law decides: the same at neighbouring clearances, confirmed by
another law, and absent where shocks do not make the largest force.
"""

import dataclasses
import math
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import vfife
from vfife.gallery import load as gallery_model
from vfife.laws import ContactLaw, Hertz, LankaraniNikravesh
from vfife.measures.forces import joint_force_max, joint_rows
from vfife.measures.turn_peaks import (
    RAISED,
    RaisedPeaks,
    contact_laws,
    damped_peaks,
    peak_columns,
    raised_peaks,
    shock_loads,
    turn_lanes,
)
from vfife.model.drivers import Torque
from vfife.modelfile import load, loads
from vfife.report.damping_cautions import (
    certain_shocks,
    comparison,
    damping_cautions,
    law_change,
    law_words,
    load_words,
    raised_loads,
    shock_cautions,
)
from vfife.report.document import Table
from vfife.report.overview import certainty
from vfife.report.sensitivity import comparison as law_comparison
from vfife.simulation.result import Result
from vfife.studies.methods.compare import Comparison, row_of

MODEL = "examples/compressor.toml"
PINS = ("big-end", "small-end")
JOINTS = (*PINS, "cylinder")
# A small compressor at 2,850 rpm whose pins are worn: the gas throws its big-end across the bearing in every
# turn, and the contact may keep the speed of a landing for many turns.
SMALL = {
    "body.crank.length": "15 mm", "body.crank.mass": "0.8 kg", "body.crank.inertia": "0.002 kg m^2",
    "body.rod.length": "68 mm", "body.rod.mass": "90 g", "body.rod.inertia": "6e-5 kg m^2",
    "body.rod.center_at": "22 mm", "body.piston.mass": "85 g", "body.piston.inertia": "2e-5 kg m^2",
    "body.piston.position": [0.053, 0.0], "joint.big-end.bearing_radius": "8 mm",
    "joint.big-end.axial_length": "14 mm", "joint.small-end.bearing_radius": "5.5 mm",
    "joint.small-end.axial_length": "14 mm", "joint.cylinder.clearance": "30 um",
    "joint.cylinder.length": "32 mm", "joint.cylinder.height": "38 mm", "driver.crank.speed": "2850 rpm",
    "load.gas.bore": "38 mm", "load.gas.zero_travel": "83 mm",
}  # fmt: skip


@cache
def small(clearance: str, law: str = "lankarani-nikravesh") -> Result:
    travels = [travel * 30.0 / 46.0 for travel in load(MODEL).loads["gas"].travels]
    changes = [*SMALL.items(), ("load.gas.travels", travels)]
    changes += [(f"joint.{name}.clearance", clearance) for name in PINS]
    changes += [(f"joint.{name}.contact.law", law) for name in JOINTS]
    return vfife.simulate(load(MODEL, set=changes), turns=12)


@cache
def press(law: str = "lankarani-nikravesh", floor: str = "20 mm/s") -> Result:
    """The press of the gallery at work, with worn pins E and F of its rod: both are struck while closed."""
    text = Path("examples/six_bar_press.toml").read_text(encoding="utf-8").replace("#~ ", "")
    changes: list[tuple[str, Any]] = [("load.work.force", ["0 N", "0 N", "-20 kN", "-20 kN", "0 N", "0 N"])]
    for name in ("E", "F"):
        changes += [(f"joint.{name}.clearance", "0.15 mm"), (f"joint.{name}.contact.law", law)]
        changes += [(f"joint.{name}.impact_speed_floor", floor)]
    return vfife.simulate(loads(text, set=changes), turns=3)


def warnings_of(result: Result) -> dict[str, str]:
    """Return the warning about each joint whose force depends on the law."""
    damped = damping_cautions(result)
    return damped | shock_cautions(result, damped)


def test_a_neighbouring_clearance_has_the_same_caution() -> None:
    """Of the run alone, less than half and more than 80 % of the mean peak are damping at least; turns of all
    lanes agree.
    """
    shares = []
    for clearance in ("33 um", "34 um"):
        result = small(clearance)
        (run, *companions) = damped_peaks(result.record, result.motion)["big-end"].lanes
        assert len(run) == 6 and len(companions) == 3
        elastic = math.fsum(min(peak.elastic, peak.force) for peak in run)
        shares.append(1.0 - elastic / math.fsum(peak.force for peak in run))
        assert list(result.summary["law_dependent"]) == ["big-end"]
        assert "The force of big-end depends more on the contact law" in certainty(result.summary)
        assert set(warnings_of(result)) == set(JOINTS)
        (text,) = {warnings_of(result)[name] for name in ("small-end", "cylinder")}
        assert (
            text in result.summary["warnings"]
            and "Joints small-end (in " in text
            and "), cylinder: shocks (knocks, or blows in closed contact) make" in text
        )
    assert shares[0] < 0.5 < 0.8 < shares[1]


def test_a_law_without_damping_is_as_decisive_and_moves_the_force_beyond_its_range() -> None:
    undamped, damped = small("33 um", "hertz"), small("33 um")
    assert damping_cautions(undamped) == {}
    (text,) = set(shock_cautions(undamped, ()).values())
    assert text.startswith(
        "Joints big-end, small-end, cylinder: shocks (knocks, or blows in closed contact) make the"
    )
    assert "the contact law (hertz without damping)" in text
    assert "without damping" not in warnings_of(damped)["cylinder"]
    for name in ("big-end", "cylinder"):
        low, high = (run.measures[f"{name}.force.max"] for run in (damped, undamped))
        assert high.low > low.high


PASSED_ON = ["A", "B", "C", "D", "guide", "torque of crank", "shaking force", "shaking moment"]
LOADS = [f"{name}.force.max" for name in ("A", "B", "C", "D", "guide")] + ["crank.torque.max"]


def test_all_that_a_shock_loads_is_named_with_it() -> None:
    """Joints without clearance, the guide and the driver have the shock of E and F in their largest loads."""
    summary = press().summary
    assert list(summary["law_dependent"]) == ["E", "F"] and summary["law_shocks"] == {}
    assert set(LOADS) | {"guide.moment.max"} <= set(summary["law_loads"])
    passed = ", ".join(PASSED_ON)
    assert (
        "The forces of E, F depend more on the contact law than on the step, and so does all that they load"
        f" ({passed}): see cautions 1, 2 and 3." in certainty(summary)
    )
    (number,) = set(summary["law_loads"].values())
    text = summary["warnings"][number]
    assert text.startswith("Shocks in E, F make the largest values") and f"too: {passed}." in text


def test_another_law_moves_what_is_named_beyond_its_range() -> None:
    one, other = press().measures, press("gonthier").measures
    for name in ("E.force.max", "F.force.max", *LOADS):
        assert other[name].low > 1.2 * one[name].high, name


def test_a_comparison_of_laws_lists_all_loads_that_they_change() -> None:
    """Not of the joints alone whose laws are compared."""
    laws, results = ("lankarani-nikravesh", "gonthier"), [press(), press("gonthier")]
    rows = [row_of(result, ("E", "F")) for result in results]
    compared = Comparison("press", ("E", "F"), rows, results, planned=2)
    document = law_comparison(compared)
    (table,) = (part for part in document.parts if isinstance(part, Table) and part.headings[0] == "load")
    assert table.headings[1:] == tuple(f"{law} ambrosio" for law in laws) + ("change",)
    assert {*LOADS, "E.force.max", "F.force.max"} <= {row[0] for row in table.rows}
    torques = document.data["loads"]["crank.torque.max"]
    assert torques == [float(result.measures["crank.torque.max"]) for result in results]
    same = Comparison("press", ("E", "F"), rows, [press(), press()], planned=2)
    assert not any(isinstance(p, Table) and p.headings[0] == "load" for p in law_comparison(same).parts)


def test_a_floor_of_the_impact_speed_leaves_a_caution_on_the_law() -> None:
    """The floor bounds the damping, and other laws still give forces that are far larger."""
    result = press(floor="70 mm/s")
    assert damping_cautions(result) == {} and result.measures["F.force.max"].width < 0.01 * 40e3
    assert list(result.summary["law_dependent"]) == ["E", "F"]
    assert set(LOADS) <= set(result.summary["law_loads"])
    assert "shocks (knocks, or blows in closed contact)" in result.summary["warnings"][0]
    assert press("gonthier").measures["F.force.max"].low > 1.5 * result.measures["F.force.max"].high


def test_a_load_of_another_moment_or_near_its_ideal_value_is_not_of_the_shock() -> None:
    result = press()
    ideal = dict(result.reference.measures)
    counts = shock_loads(result.record, ideal, result.motion, ["E", "F"])
    assert counts["D.force.max"].raised == counts["D.force.max"].turns > 0
    assert "E.force.max" not in counts
    ideal["D.force.max"] = float(result.measures["D.force.max"]) / 1.05
    assert shock_loads(result.record, ideal, result.motion, ["E", "F"])["D.force.max"].raised == 0
    columns = peak_columns(result.record)
    columns = {name: np.roll(column, 5 * (name == "D.force.max")) for name, column in columns.items()}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vfife.measures.turn_peaks.peak_columns", lambda record: columns)
        run = dataclasses.replace(result.record, companions=None)
        moved = shock_loads(run, result.reference.measures, result.motion, ["E", "F"])
    assert moved["D.force.max"].raised == 0 and moved["A.force.max"].raised > 0


def test_words_of_loads_name_a_joint_once() -> None:
    loads = ["A.force.max", "A.moment.max", "B.moment.max", "crank.torque.max", "ground.shaking_force.max"]
    assert load_words(loads) == ["A", "moment of B", "torque of crank", "shaking force"]


def test_forces_that_step_and_law_decide_are_named_with_what_they_load() -> None:
    """A law without damping has no caution on damping: the first line names its shocks all the same."""
    summary = small("33 um", "hertz").summary
    assert list(summary["law_shocks"]) == [*JOINTS] and summary["law_dependent"] == {}
    loaded = "main, torque of crank, shaking force, shaking moment"
    assert (
        "The contact law decides the forces of big-end, small-end, cylinder and all that they load"
        f" ({loaded}), too: see caution" in certainty(summary)
    )
    mixed = certainty({**summary, "law_dependent": {"small-end": summary["law_shocks"]["small-end"]}})
    assert "than on the step, and so do those of big-end" in mixed
    lone = {**summary, "law_shocks": {"big-end": summary["law_shocks"]["big-end"]}, "law_loads": {}}
    assert "The contact law decides the force of big-end, too: see caution" in certainty(lone)


ROCKER = """
gravity = [0, "-9.81 m/s^2"]
ground = { A = [0, 0], D = ["300 mm", 0] }
driver = { crank = { speed = "400 rpm" } }
[body]
crank = { length = "80 mm", mass = "0.8 kg" }
coupler = { length = "250 mm", mass = "1.5 kg", angle = "40 deg" }
rocker = { length = "200 mm", mass = "2 kg", angle = "100 deg" }
[joint]
A = { bearing = "ground.A", journal = "crank.start" }
D = { bearing = "ground.D", journal = "rocker.start" }
"""
PIN = """
[joint.%s]
kind = "clearance"
bearing = "coupler.%s"
journal = "%s.end"
clearance = "20 um"
bearing_radius = "10 mm"
axial_length = "20 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.7 }
friction = { law = "ambrosio", coefficient = 0.08, v0 = "1 mm/s", v1 = "10 mm/s" }
"""


@cache
def rocker(journals: str = "centred", clearance: str = "20 um") -> Result:
    """A crank-rocker whose pins B and C never leave their bearings once they have landed."""
    text = ROCKER + PIN % ("B", "start", "crank") + PIN % ("C", "end", "rocker")
    changes = [("start.journals", journals), *((f"joint.{name}.clearance", clearance) for name in "BC")]
    return vfife.simulate(loads(text, set=changes), turns=8)


def test_a_driven_run_without_an_ideal_mechanism_says_why_and_names_no_loads() -> None:
    m = gallery_model("four_bar_case_b")
    ideal = vfife.simulate(dataclasses.replace(m, settings=dataclasses.replace(m.settings, turns=0.05)))
    assert ideal.summary["run"]["without_ideal"] == "" and "no comparison" not in str(
        ideal.summary["warnings"]
    )
    m.drivers["crank"] = Torque(body="crank", value=100.0)
    m.settings = dataclasses.replace(m.settings, turns=None, duration=2e-3)
    summary = vfife.simulate(m).summary
    assert summary["run"]["without_ideal"].startswith("no driver prescribes a motion")
    [text] = [text for text in summary["warnings"] if text.startswith("There is no comparison")]
    assert "vfife compare MODEL --contact lankarani-nikravesh" in text
    lead = "The force of C depends more on the contact law than on the step"
    assert law_words(["C"], [], []) == lead
    end = "; which other loads do is not known without an ideal mechanism"
    assert law_words(["C"], [], [], compared=False) == lead + end


def test_loads_far_above_the_ideal_ones_are_named_where_contacts_never_end() -> None:
    """The start moves the torque by 15 %, although no shock of B or C coincides with it."""
    result, seated = rocker(), rocker("seated")
    summary, torque = result.summary, result.measures["crank.torque.max"]
    assert summary["law_dependent"] == {"B": 0, "C": 0} and summary["law_loads"] == {"crank.torque.max": 0}
    assert "exceeds its ideal value by more than a tenth: torque of crank." in summary["warnings"][0]
    assert "all that they load (torque of crank): see caution 1." in certainty(summary)
    assert seated.measures["crank.torque.max"].high < 0.9 * torque.low


def test_each_load_of_contacts_that_never_end_is_named_by_its_size() -> None:
    """A, whose force is 8 % above the ideal one, is none of them; nothing is without the ideal mechanism."""
    result = rocker(clearance="50 um")
    assert set(result.summary["law_loads"]) == {
        "D.force.max", "crank.torque.max", "ground.shaking_moment.max"
    }  # fmt: skip
    alone = SimpleNamespace(record=result.record, reference=None, measures=result.measures)
    assert raised_loads(alone) == []


def test_counts_are_those_of_the_forces_of_each_turn() -> None:
    result = small("33 um")
    reference = result.reference.measures
    counts = raised_peaks(result.record, reference, result.motion)
    for name in JOINTS:
        limit = 1.25 * reference[f"{name}.force.max"]
        peaks = [
            joint_force_max(part)[rows, list(joint_rows(part)).index(name)].max()
            for _, part, turns in turn_lanes(result.record, result.motion)
            for rows in turns
        ]
        assert counts[name] == RaisedPeaks(sum(peak > limit for peak in peaks), 24)
    assert 0 < counts["small-end"].raised < 24


def test_a_force_that_follows_the_ideal_mechanism_has_no_caution() -> None:
    """The compressor of the gallery is sensitive, and every damped law gives its forces within 2 %."""
    result = vfife.simulate(gallery_model("compressor"), turns=2)
    assert result.summary["trust"]["sensitive"]
    assert warnings_of(result) == {}


def test_a_periodic_motion_has_no_caution_where_blows_are_a_small_part_of_its_forces() -> None:
    """They raise the force by a third, and other laws with damping change it by less than 4 %."""
    result = vfife.simulate(gallery_model("four_bar"))
    counts = raised_peaks(result.record, result.reference.measures, result.motion)
    assert counts["B"].raised == counts["B"].turns == 24
    assert shock_cautions(result, ()) == {}


@pytest.mark.parametrize(("raised", "cautioned"), [(0, False), (3, False), (4, True), (40, True)])
def test_a_tenth_of_the_turns_decides(monkeypatch, raised, cautioned) -> None:
    counts = {"big-end": RaisedPeaks(raised, 40)}
    monkeypatch.setattr("vfife.report.damping_cautions.raised_peaks", lambda *of: counts)
    found = shock_cautions(small("33 um"), ())
    assert ("big-end" in found) == cautioned
    assert not cautioned or (f"big-end (in {raised} of 40 turns of the run" in found["big-end"]) == (
        raised < 40
    )
    assert shock_cautions(small("33 um"), ["big-end"]) == {}


@pytest.mark.parametrize(
    ("motion", "width", "estimated", "cautioned"),
    [
        ("not repeating", 0.01, True, True),
        ("periodic", 0.01, True, False),
        ("unsettled", 0.2, True, True),
        ("unsettled", 0.2, False, False),
    ],
)
def test_a_motion_that_does_not_repeat_or_a_wide_range_is_sensitive(
    monkeypatch, motion, width, estimated, cautioned
) -> None:
    """Others have a caution only where shocks are a third of the force or more."""
    harder = [RaisedPeaks(0, 40)]
    monkeypatch.setattr(
        "vfife.report.damping_cautions.raised_peaks",
        lambda record, reference, motion, ratio: dict.fromkeys(
            JOINTS, RaisedPeaks(40, 40) if ratio == RAISED else harder[0]
        ),
    )
    result = small("33 um")
    force = SimpleNamespace(value=1000.0, width=1000.0 * width, estimated=estimated)
    changed = SimpleNamespace(
        record=result.record,
        reference=result.reference,
        motion=dataclasses.replace(result.motion, motion=motion),
        measures={f"{name}.force.max": force for name in JOINTS},
    )
    assert bool(shock_cautions(changed, ())) == cautioned
    harder[0] = RaisedPeaks(40, 40)
    assert set(shock_cautions(changed, ())) == set(JOINTS)
    assert certain_shocks(changed, JOINTS) == ([] if cautioned else list(JOINTS))


NUMBERS = {
    "stiffness": 1e8, "damping_coefficient": 100.0, "exponent": 1.5, "full_damping_depth": 1e-5,
}  # fmt: skip


def loss(law: ContactLaw, mechanism: vfife.Mechanism) -> float:
    """Return the damping coefficient (N s/m) of a law at 2 µm after an impact at 0.1 m/s."""
    joint = dataclasses.replace(mechanism.joints["small-end"], contact=law)
    changed = dataclasses.replace(mechanism, joints={**mechanism.joints, "small-end": joint})
    result = SimpleNamespace(assembly=SimpleNamespace(mechanism=changed))
    found, p = contact_laws(result)["small-end"]
    return float(found.force(2e-6, 10.0, p)[1])


@pytest.mark.parametrize(
    "name", sorted(name for name, law in ContactLaw.registry.items() if not law.film and not law.tabled)
)
def test_the_change_that_a_caution_names_is_accepted_and_changes_the_loss(name: str, tmp_path) -> None:
    law_class = ContactLaw.registry[name]
    names = [one.name for one in dataclasses.fields(law_class)]
    values = {key: value for key, value in NUMBERS.items() if key in names}
    values |= {"restitution": 0.6} if "restitution" in names else {}
    base = gallery_model("compressor")
    law = law_class(**values)
    joint = dataclasses.replace(base.joints["small-end"], contact=law)
    mechanism = dataclasses.replace(base, joints={**base.joints, "small-end": joint})
    path = tmp_path / "model.toml"
    vfife.save_model(mechanism, path)
    key, value = law_change(law).split("=")
    changed = load(path, set=[(f"joint.small-end.contact.{key}", value)]).joints["small-end"].contact
    before, after = loss(law, mechanism), loss(changed, mechanism)
    assert abs(after - before) > 0.5 * max(before, after)


def test_a_comparison_names_each_law_once_and_other_contacts_by_their_changes() -> None:
    base = gallery_model("compressor")
    command = comparison(base, PINS)
    assert command.startswith(
        "vfife compare MODEL --contact lankarani-nikravesh,hertz,gonthier --companions 3"
    )
    joint = dataclasses.replace(base.joints["cylinder"], contact=Hertz(damping="gonthier-exact"))
    both = dataclasses.replace(base, joints={**base.joints, "cylinder": joint})
    assert comparison(both, ["cylinder"]) == "run it again with --set joint.cylinder.contact.damping=none"
    assert law_change(Hertz()) == "damping=gonthier" and law_change(LankaraniNikravesh()) == "law=hertz"
