"""The answer of a run on one screen: its length, its numbers, and what it calls sensitive."""

from __future__ import annotations

import copy
import dataclasses
import io
import math
import re
from functools import cache
from typing import Any

import pytest
from rich.console import Console

import vfife
from vfife import gallery
from vfife.model.mechanism import Mechanism
from vfife.model.wear import Wear
from vfife.report.amounts import prefixed
from vfife.report.digits import CERTAIN
from vfife.report.front import conclusion
from vfife.report.overview import (
    cautions,
    certainty,
    clearance_note,
    errors,
    joint_table,
    overview,
    uncertain,
)
from vfife.report.run import facts, tables
from vfife.report.run_tables import damped_joints
from vfife.report.terminal import write
from vfife.report.wear import wear_length
from vfife.units import in_rpm

SCREEN = 24 - 2  # lines of a terminal, without the two that name the folder and the next commands


@cache
def result() -> vfife.Result:
    return vfife.simulate(gallery.four_bar_case_c(), turns=1.0, step=2e-6, companions=3)


def text(summary: dict[str, Any], width: int = 100) -> str:
    console = Console(file=io.StringIO(), width=width)
    write(overview(summary), console)
    return console.file.getvalue()


def altered(name: str, low: float, high: float) -> dict[str, Any]:
    """The summary with the range of one measure, by its value, and all others certain."""
    summary = copy.deepcopy(result().summary)
    summary.pop("start_fall", None)
    for one, bounds in summary["ranges"].items():
        bounds["low"] = bounds["high"] = summary["measures"][one]
    value = summary["measures"][name]
    summary["ranges"][name] |= {"low": low * value, "high": high * value}
    summary["trust"] |= {"measure": name, "sensitive": True, "low": low * value, "high": high * value}
    return summary


@pytest.mark.parametrize("name", ["compressor", "four_bar_case_c", "jansen_leg", "scissor_lift"])
def test_it_fits_a_screen(name: str) -> None:
    mechanism: Mechanism = getattr(gallery, name)()
    lines = text(vfife.simulate(mechanism, companions=1).summary).splitlines()
    assert len(lines) <= SCREEN, "\n".join(lines)


def test_drivers_of_sliders_and_points_have_a_row() -> None:
    """Mean power and largest force, in both answers; the ideal force where there is clearance."""
    m = vfife.Mechanism("cart")
    m.point("W", -1.0, 0.0)
    car = m.rigid_body("car", mass=1.5, inertia=0.01)
    m.slider("rail", m.point("O", 0.0, 0.0), car.pin())
    m.spring("damper", "ground.W", "car.center", damping=10.0)
    m.harmonic(slider="rail", amplitude=0.03, frequency=2.0)
    run = vfife.simulate(m, duration=1.0)
    assert "Driver rail " in str(run) and "mean power 710.6 mW, largest force 8.044 N" in str(run)
    assert ("Driver", f"rail: mean power 710.6 mW, largest force 8.044 N ({run.measures.part})") in facts(
        run.summary
    )
    assert run.summary["actuators"]["rail"]["measure"] == "rail.actuator_force.max"
    assert run.measures["rail.actuator_force.max"].estimated


def test_a_driver_without_mean_power_has_the_reason() -> None:
    """Nothing of an ideal slider-crank takes energy up but what turns round; a damper does."""
    reason = "mean power about zero: nothing is lost, and loads return what they take up, largest torque"
    m = gallery.slider_crank()
    ideal = vfife.simulate(m.ideal(), turns=2)
    assert reason in " ".join(str(ideal).split())
    m.spring("brake", "ground.O", "block.center", damping=10.0)
    assert "about zero" not in str(vfife.simulate(m.ideal(), turns=2))


def test_moments_of_joints_are_on_the_first_screen() -> None:
    """Of gears and of a guide that holds a moment; no column where no joint has one."""
    gears = vfife.simulate(gallery.gear_train())
    table = joint_table(gears.summary)
    moments = {row[0]: row[table.headings.index("moment")] for row in table.rows}
    assert moments["first-stage"] == "3.626 N m" and moments["second-stage"] == "5.495 N m"
    assert moments["motor"] == "" and len(text(gears.summary).splitlines()) <= SCREEN
    yoke = joint_table(vfife.simulate(gallery.scotch_yoke(), turns=1).summary)
    assert [row[-1] for row in yoke.rows if row[0] == "guide"] == ["9.870 N m"]
    assert "moment" not in joint_table(vfife.simulate(gallery.slider_crank(), turns=1).summary).headings
    assert "moment" not in joint_table(result().summary).headings


def test_a_negligible_moment_is_not_on_the_first_screen() -> None:
    summary = copy.deepcopy(vfife.simulate(gallery.gear_train()).summary)
    summary["measures"]["first-stage.moment.max"] = 0.009 * summary["measures"]["second-stage.moment.max"]
    assert [row[-1] for row in joint_table(summary).rows if row[0] == "first-stage"] == [""]


def test_forces_between_teeth_are_not_modelled_and_the_answer_states_it() -> None:
    """The bearings of a geared shaft carry no force here; the moment of a gear acts on its second wheel: with
    the ratio it is the torque that the motor's shaft gives away.
    """
    run = vfife.simulate(gallery.gear_train())
    said = " ".join(text(run.summary).split())
    assert "Gears first-stage, second-stage couple angles by a moment M." in said
    assert "bearings of geared shafts lack them. Estimate: F = M / r" in said
    assert run.measures["motor.force.max"] == pytest.approx(0.0, abs=1e-9)
    mechanism = gallery.gear_train()
    (first, _), moment = mechanism.gears.values(), run.measures["first-stage.moment.max"]
    inertia = run.record.assembly.bodies["motor"].inertia
    torque = 2.0 - inertia * run.measures["motor.angular_acceleration.max"]  # N m at rest, from the file
    assert abs(first.ratio) * moment == pytest.approx(torque, rel=1e-3)
    assert "Gear" not in text(result().summary)


def test_fewer_than_two_turns_are_cautioned_about() -> None:
    """Turns that were never compared may differ. Cautions that come first are left out."""
    one = copy.deepcopy(result().summary)
    one |= {"warnings": []} | {key: {} for key in ("law_dependent", "law_shocks", "law_loads")}
    del one["start_fall"]
    assert "fewer than two turns" in text(one)
    one["run"]["turns"] = 2.0 - 1e-12
    assert "fewer than two turns" not in text(one)


def test_its_numbers_are_those_of_the_measures() -> None:
    said, measures = text(result().summary, 160), result().measures
    assert "four-bar, case c · 1,500 rpm · 1 turn · 3 joints with clearance" in said
    for joint in "BCD":
        row = next(line for line in said.splitlines() if line.startswith(f" {joint} 200 µm"))
        numbers = [float(one.replace(",", "")) for one in re.findall(r"([\d.,]+) k?N\b", row)]
        assert numbers[0] == pytest.approx(1e-3 * result().reference.measures[f"{joint}.force.max"], rel=5e-4)
        width = max(errors(result().summary)[f"{joint}.force.max"], 5e-4)
        assert numbers[-1] == pytest.approx(1e-3 * measures[f"{joint}.force.max"], rel=1.5 * width)
    hardest = max("BCD", key=lambda joint: measures[f"{joint}.approach_speed.max"])
    assert f"({hardest}, whole run)" in said
    assert str(result()).splitlines()[0] == said.splitlines()[0].rstrip()


@pytest.mark.parametrize("status", ["diverged", "energy", "not converged"])
def test_a_run_that_ended_badly_is_not_reliable(status: str) -> None:
    summary = copy.deepcopy(result().summary)
    summary["status"] = status
    assert "Reliable" not in text(summary) and "Quote no number" in text(summary) and uncertain(summary)


def test_only_forces_and_torques_make_a_run_sensitive() -> None:
    acceleration = altered("coupler.angular_acceleration.max", 0.5, 1.7)
    assert not uncertain(acceleration)
    said = certainty(acceleration)
    assert said.startswith("Reliable numerically: ") and "Less certain: coupler angular acceleration" in said
    force = altered("C.force.max", 0.9, 1.2)
    assert uncertain(force) and errors(force)["C.force.max"] == pytest.approx(0.2)
    given = certainty(force)
    assert given.startswith("Sensitive to the step size: C force") and "The step was given: ranges" in given
    assert "Reliable" not in given, "three companions beside one step do not bound what it has in common"
    said = certainty(force | {"trust": force["trust"] | {"automatic": True}})
    assert "the other forces and torques change by" in said and "The step was given" not in said
    assert not uncertain(altered("C.force.max", 1.0 - 0.5 * CERTAIN, 1.0 + 0.5 * CERTAIN))


def test_the_hardest_knock_has_its_range() -> None:
    summary = altered("C.approach_speed.max", 0.8, 1.5)
    speeds = {joint: f"{joint}.approach_speed.max" for joint in "BCD"}
    for one in speeds.values():  # nearly as fast, so that any of them may be the hardest
        summary["measures"][one] = 0.2
        summary["ranges"][one] |= {"low": 0.1, "high": 0.25}
    summary["measures"][speeds["C"]], summary["ranges"][speeds["C"]]["high"] = 0.21, 0.24
    assert "hardest knock 100 to 250 mm/s (B or C or D, whole run)" in text(summary)
    summary["ranges"][speeds["B"]] |= {"low": 0.05, "high": 0.09}
    summary["ranges"][speeds["D"]] |= {"low": 0.05, "high": 0.1}
    said = text(summary)
    assert "hardest knock 100 to 240 mm/s (C, whole run)" in said, "the range of another joint is not C's"
    summary["not_estimated"].append(speeds["C"])
    assert "hardest knock 200 mm/s (not estimated) (C, whole run)" in text(summary)


def test_the_power_of_knocks_names_joints_that_damp_in_closed_contact_only() -> None:
    """Of a joint without a knock the damping of the law is no power of knocks; a little is not mentioned."""
    summary = copy.deepcopy(result().summary)
    assert damped_joints(summary) == [] and "; knocks lose" in text(summary)
    for name, power in (("B", 0.2), ("C", 0.5), ("D", 0.001)):
        summary["measures"][f"{name}.impact_power.mean"] = power
    for name in ("B", "D"):
        summary["measures"][f"{name}.impacts"] = 0
        summary["knocks"].get(name, {})["count"] = 0
    summary["knocks"]["C"]["count"] = 3
    assert damped_joints(summary) == ["B"]
    assert "; damping in contact loses" in " ".join(text(summary, 300).split())
    (note,) = (table.note for table in tables(summary) if "power of the knocks" in table.headings)
    assert "The power is that of all damping in contact: B without a knock, in closed contact." in note
    del summary["knocks"]
    assert damped_joints(summary) == ["B"], "a former summary has the knocks of the whole run only"


def test_a_harder_knock_of_the_start_stands_beside_that_of_the_turns() -> None:
    """The table has the knock of the turns; the line names it and that of the whole run."""
    summary = copy.deepcopy(result().summary)
    for joint, speed in (("B", 0.05), ("C", 0.8), ("D", 0.3)):
        name = f"{joint}.approach_speed.max"
        summary["measures"][name] = speed
        summary["ranges"][name] |= {"low": 0.99 * speed, "high": 1.01 * speed}
        summary["knocks"][joint] = {
            "count": 2,
            "speed": 0.3 if joint == "D" else 0.04,
            "hardest": joint == "D",
        }
    said = " ".join(text(summary).split())
    line = "hardest knock 792 to 808 mm/s (C, whole run), 297.0 to 303.0 mm/s (D) in the turns of the table"
    assert line in said, said
    (noise,) = (table for table in tables(summary) if "hardest there" in table.headings)
    rows = {row[0]: row for row in noise.rows}
    assert rows["C"][4] == "40.0 mm/s (not estimated)" and rows["D"][2] == rows["D"][4]
    assert rows["D"][4] in said, "the report has the number of the short answer"


def knocking(**speeds: tuple[float, float, float, bool]) -> dict:
    """The summary with the knocks of the turns of the measures: speed, range (m/s), hardest of the run."""
    summary = copy.deepcopy(result().summary)
    for joint, (speed, low, high, hardest) in speeds.items():
        name = f"{joint}.approach_speed.max"
        summary["measures"][name] = speed if hardest else 0.5
        ends = {"low": low, "high": high} if hardest else {"low": 0.4, "high": 0.6}
        summary["ranges"][name] |= ends
        summary["knocks"][joint] = {"count": 2, "speed": speed, "hardest": hardest}
    return summary


def test_one_joint_knocks_hardest_only_where_no_range_of_another_reaches_it() -> None:
    summary = knocking(B=(0.15, 0.107, 0.188, True), C=(0.1, 0.058, 0.22, True), D=(0.04, 0.0, 0.0, False))
    said = " ".join(text(summary).split())
    assert "107 to 188 mm/s (B) or 58 to 220 mm/s (C) in the turns of the table" in said, said
    (knocks,) = [words for words in conclusion(summary) if "knocks hardest" in words]
    assert knocks.startswith(
        "Joint B or C knocks hardest: the surfaces of B meet at 107 to 188 mm/s in the hardest knock; C 58 to"
    )
    apart = knocking(B=(0.15, 0.107, 0.188, True), C=(0.1, 0.058, 0.1, True), D=(0.04, 0.0, 0.0, False))
    assert "107 to 188 mm/s (B) in the turns of the table" in " ".join(text(apart).split())
    (knocks,) = [words for words in conclusion(apart) if "knocks hardest" in words]
    assert knocks.startswith("Joint B knocks hardest: its surfaces meet at 107 to 188 mm/s in the hardest")


def test_a_range_that_reaches_a_speed_without_one_names_both_joints() -> None:
    summary = knocking(B=(0.22, 0.0, 0.0, False), C=(0.2, 0.13, 0.31, True), D=(0.04, 0.0, 0.0, False))
    said = " ".join(text(summary).split())
    assert "220 mm/s (B, not estimated) or 130 to 310 mm/s (C) in the turns of the table" in said, said
    (knocks,) = [words for words in conclusion(summary) if "knocks hardest" in words]
    assert knocks.startswith("Joint B or C knocks hardest: the surfaces of B meet at up to 220 mm/s (not")


def test_friction_of_an_ideal_joint_is_not_computed_where_others_have_some() -> None:
    summary = copy.deepcopy(result().summary)
    rows = {row[0].split()[0]: row for row in joint_table(summary).rows}
    ideal = [name for name in summary["joints"] if f"{name}.friction_power.mean" not in summary["measures"]]
    assert ideal == ["A"] and "not computed" in rows["A"]
    assert not any("not computed" in rows[name] for name in "BCD")
    for name in [name for name in summary["measures"] if name.endswith(".friction_power.mean")]:
        summary["measures"][name] = 0.0
    assert "not computed" not in text(summary)


def test_the_shaking_force_stands_beside_that_of_the_ideal_mechanism() -> None:
    summary, reference = result().summary, result().reference
    force = summary["model"]["ideal_shaking_force.max"]
    assert force == reference.measures["ground.shaking_force.max"] > 0.0
    line = next(line for line in text(summary).splitlines() if line.startswith("Shaking force"))
    assert f"(ideal {prefixed(force, 'N')})" in line
    assert any(f"(ideal {prefixed(force, 'N')})" in words for _, words in facts(summary))


def test_a_force_without_weight_does_not_lead() -> None:
    summary = altered("A.force.max", 0.2, 3.0)
    for one in ("measures", "ranges"):
        entry = summary[one]["A.force.max"]
        scaled = {key: 1e-4 * value for key, value in entry.items()} if one == "ranges" else 1e-4 * entry
        summary[one]["A.force.max"] = scaled
    assert not uncertain(summary)


def test_without_an_estimate_it_says_so() -> None:
    said = certainty(vfife.simulate(gallery.four_bar_case_c(), turns=1.0, step=1e-5, companions=0).summary)
    assert said.split(". ")[1].startswith("Errors are not estimated")


def test_speeds() -> None:
    assert in_rpm(2.0 * math.pi * 50.0) == "3,000 rpm"
    assert in_rpm(1.0) == "9.5493 rpm"


def test_the_hardest_knock_of_a_block_names_its_corner() -> None:
    said = text(vfife.simulate(gallery.slider_crank_loose_guide(), turns=0.3, companions=0).summary, 160)
    assert re.search(r"hardest knock [^(]*\(guide, corner [1-4], whole run\)", said), said


def test_an_interrupted_run_is_not_called_killed() -> None:
    from vfife.report.run_file import info
    from vfife.solvers.status import Status

    file = {
        "file": "run.sqlite", "bytes": 1, "model": "m", "source": None, "created": "now", "finished": None,
        "written_by": None, "step": None, "outputs": 1, "channels": [], "checkpoint": None,
        "reference": False, "wall_s": None, "versions": {}, "loop": "generated", "own_laws": [],
        "damage": [], "checked": True,
        "events": [], "summary": None, "laws": {}, "static": False,
    }  # fmt: skip
    interrupted, unfinished = (
        str(info({**file, "status": status}).parts) for status in (Status.INTERRUPTED, Status.UNFINISHED)
    )
    assert "vfife resume continues" in interrupted and "killed" not in interrupted
    assert "full disk" not in interrupted and "full disk" in unfinished


def test_the_torque_of_a_driver_has_one_range() -> None:
    summary = vfife.simulate(gallery.compressor(), turns=2, companions=1).summary
    name = "crank.torque.max"
    value = summary["measures"][name]
    summary["ranges"][name] = summary["ranges"][name] | {"low": 0.5 * value, "high": 1.5 * value}
    said = " ".join(text(summary).split())
    low, high = (end for end in re.search(r"crank torque (\S+) to (\S+) N m", said).groups())
    assert f"largest torque {low} to {high} N m (ideal" in said and "torque up to" not in said
    (long,) = [words for _, words in facts(summary) if "crank: largest torque" in words]
    assert f"largest torque {low} to {high} N m (" in long and "; ideal " in long, long


def test_turns_that_are_hardly_apart_are_not_said_not_to_repeat() -> None:
    summary = vfife.simulate(gallery.scotch_yoke(), turns=2, step=3e-4, companions=0).summary
    said = " ".join(cautions(summary))
    assert summary["turns"]["distance"] < 5e-5 and summary["turns"]["motion"] != "periodic"
    assert "do not repeat yet" not in said and "settle" not in said
    assert "less than 0.01 % from one before it; whether turns repeat shows in more: --turns 40." in said


def test_a_peak_of_torque_is_no_mean() -> None:
    """A motor is sized by mean power and mean torque, of which the peak is many times as large."""
    summary = copy.deepcopy(vfife.simulate(gallery.compressor(), turns=2, companions=1).summary)
    name, value = "crank.torque.max", summary["measures"]["crank.torque.max"]
    summary["turns"] |= {"motion": "not repeating", "count": 40}
    for spread in (0.0, 0.5):
        low, high = value * (1.0 - spread), value * (1.0 + spread)
        summary["ranges"][name] |= {"low": low, "high": high}
        summary["ranges"][name] |= {"lowest": 0.4 * value, "highest": 1.9 * value}
        summary["ranges"]["ground.shaking_force.max"] |= {"lowest": 10.0, "highest": 9000.0}
        said = " ".join(text(summary).split())
        power, torque = re.search(
            r"mean power ([\d.]+)(?: to [\d.]+)? W .*mean torque ([\d.]+) N m, large", said
        ).groups()
        speed = next(iter(summary["run"]["speeds"].values()))
        assert float(power) == pytest.approx(abs(speed) * float(torque), rel=0.01)
        assert re.search(r"largest torque [\d. to]+ N m, mean over turns \(single turns", said), said
        assert "on average" not in said


def test_a_clearance_is_called_radial_before_and_after_a_run_and_in_all_starters() -> None:
    """A drawing gives the difference of the diameters, which is twice as much."""
    from pathlib import Path

    import vfife.modelfile
    from vfife.report import check_page, front

    assert "joint (radial)" in text(result().summary)
    page = str(front.front_page(result().summary, None).parts)
    assert "radial: half of the difference of the diameters" in page and "radial) differs most" in page
    entries = [{"name": "A", "kind": "clearance", "bearing": "", "journal": "", "clearance": 1e-3}]
    table = list(check_page._joints([entry | {"expected_force": None} for entry in entries], None))
    assert "radial: half of the difference of the diameters" in str(table)
    for starter in Path(vfife.modelfile.__file__).parent.glob("templates/*.toml"):
        model = starter.read_text("utf-8")
        assert ('kind = "clearance"' in model) == ("# radial: half of the difference" in model), starter


def test_a_guide_has_no_radial_clearance() -> None:
    made = vfife.simulate(gallery.slider_crank_loose_guide(), turns=0.3, companions=0).summary
    assert "joint (each side)" in text(made) and "radial" not in text(made)
    assert "guide (500 µm on each side) differs most" in " ".join(conclusion(made))


def test_worn_surfaces_are_named_beside_the_clearance() -> None:
    """Their clearance is that without the wear: 200 µm here, and 2 + 1 µm at the deepest place."""
    model = gallery.four_bar_case_c()
    wear = Wear(bearing=1e-16, journal=1e-16, bearing_profile=(2e-6, 1e-6, 0.0))
    model.joints["C"] = dataclasses.replace(model.contacts["C"], wear=wear)
    made = vfife.simulate(model, turns=0.1, step=2e-6, companions=0).summary
    for said in (text(made), str(facts(made)), str(clearance_note(made))):
        assert "C up to 3 µm (bearing), in addition to the clearance" in said
    assert "C 200 µm, worn" in text(made) and "worn" not in text(result().summary).lower()


def test_a_mean_ratio_of_several_turns_is_no_amplitude() -> None:
    """The mean of (highest - lowest)/mean over turns, times the mean torque, is no torque of any turn."""
    summary = copy.deepcopy(result().summary)
    summary["measures"] |= {"crank.torque.mean": 1e4, "crank.torque.ripple": 15.08}
    assert "varying by 150.8 kN m" in str(facts(summary))
    several = summary | {"turns": summary["turns"] | {"first": 11, "last": 20}}
    assert "ripple 15.08 times the mean torque" in str(facts(several))
    assert "varying by" not in str(facts(several))


def test_a_driver_that_the_loads_drive_is_called_that() -> None:
    """A gas that pushes the other way: the mean power is negative. Not where its range contains 0."""
    sound = gallery.compressor(turns=1)
    gas = sound.loads["gas"]
    wrong = dataclasses.replace(
        sound, loads={**sound.loads, "gas": dataclasses.replace(gas, reverse=not gas.reverse)}
    )
    words = "the loads drive the motor"
    for m, said in ((sound, False), (wrong, True)):
        run = vfife.simulate(m, companions=0, reference=False, outputs=360, step=2e-6)
        assert (run.measures["crank.power.mean"] < 0.0) == said
        assert (words in text(run.summary, 300)) == said
        assert any(words in line for _, line in facts(run.summary)) == said
    summary = copy.deepcopy(run.summary)
    summary.setdefault("ranges", {})["crank.power.mean"] = {"low": -1e3, "high": 1.0}
    assert words not in text(summary, 300)


@pytest.mark.parametrize("gravity", [0.0, -9.81])
def test_a_run_without_joint_forces_has_an_answer(gravity: float) -> None:
    """A mass on a spring and a free fall: no measure decides whether they are reliable."""
    spring = Mechanism("mass on a spring", gravity=(gravity, 0))
    spring.point("O", 0, 0)
    spring.rigid_body("block", mass=1, inertia=1e-3, position=(0.1, 0))
    spring.slider("rail", "ground.O", "block.center")
    spring.spring("s", "ground.O", "block.center", stiffness=1000, damping=2, free_length=0.09)
    fall = Mechanism("free fall", gravity=(0, gravity))
    fall.point_mass("p", mass=1, position=(0, 1), velocity=(1, 0, 0))
    for model in (spring, fall):
        answer = vfife.simulate(model, duration=0.3)
        assert answer.summary["trust"]["measure"] == ""
        assert "Reliable numerically." in str(answer) and "Reliable numerically." in answer._repr_html_()
        assert not answer.summary["warnings"]


def test_wear_on_a_default_length_unlike_the_joint_names_it() -> None:
    """20 mm are unlike a piston of 65 mm, and the length that the file gives to a pin of 16 mm."""
    model = gallery.compressor()
    assert model.contacts["small-end"].axial_length == 0.02 and not wear_length(model, model.contacts)
    cylinder = dataclasses.replace(model.joints["cylinder"], axial_length=0.02)
    machine = dataclasses.replace(model, joints={**model.joints, "cylinder": cylinder})
    (text,) = wear_length(machine, machine.contacts)
    assert text == "Wear of cylinder: on 20 mm, the length of joints without axial_length."


def test_a_pressure_on_the_default_length_names_it() -> None:
    """The piston of the compressor has its length; without it the pressure is that on 20 mm."""
    model = gallery.compressor()
    texts = []
    for length in (0.065, 0.02):
        cylinder = dataclasses.replace(model.joints["cylinder"], axial_length=length)
        machine = dataclasses.replace(model, joints={**model.joints, "cylinder": cylinder})
        texts.append(
            joint_table(vfife.simulate(machine, turns=1, companions=0, reference=False).summary).note
        )
    assert "without axial_length" not in texts[0]
    assert "Pressure of cylinder: on 20 mm, the length of joints without axial_length." in texts[1]


@pytest.mark.parametrize("radius", [1e-5, 1e-3])
def test_an_overloaded_guide_names_its_corners(radius: float) -> None:
    """Corners of 10 µm are pressed in by more than a tenth of their radius."""
    model = gallery.slider_crank_loose_guide()
    (name, guide), *pins = ((name, joint) for name, joint in model.contacts.items())
    assert not pins
    sharp = dataclasses.replace(
        model, joints={**model.joints, name: dataclasses.replace(guide, corner_radius=radius)}
    )
    result = vfife.simulate(sharp, turns=0.2, companions=0, reference=False)
    (text,) = [text for text in result.summary["warnings"] if text.startswith("Beyond")] or [""]
    assert ("a larger corner_radius lowers both" in text) == (radius < 1e-4)
