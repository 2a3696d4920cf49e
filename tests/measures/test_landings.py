"""Knocks of the turns of the measures, and contacts that never end under laws that remember their landing."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

import vfife
from loose import loosened
from vfife import gallery
from vfife.laws import Hertz, KelvinVoigt, LankaraniNikravesh
from vfife.laws.law import ContactLaw
from vfife.measures.forces import joint_force_max, joint_rows
from vfife.measures.landings import lasting_landings, measured_knocks, start_fall
from vfife.report.cautions import landing_cautions
from vfife.report.fall_cautions import SEATED, fall_remark, falling_journals
from vfife.report.front import conclusion
from vfife.report.overview import certainty, joint_table
from vfife.report.run import document
from vfife.report.run_file import side_by_side
from vfife.report.sensitivity import comparison, sensitivity
from vfife.simulation.result import Result

MEMORY = "remembers the speed of the last landing"


def machine(law: ContactLaw | None = None, free_length: float | None = 0.14) -> vfife.Mechanism:
    """A slow offset slider-crank with a loose pin, pressed into contact by weight and a spring."""
    m = vfife.Mechanism("slow", gravity=(0.0, -9.81))
    o, g, s = m.point("O", 0.0, 0.0), m.point("G", 0.0, 0.02), m.point("S", 0.35, 0.02)
    crank = m.link("crank", length=0.05, mass=1.0)
    rod = m.link("rod", length=0.16, mass=0.5)
    block = m.rigid_body("block", mass=0.8, inertia=1e-3, position=(0.2, 0.02))
    m.revolute("main", o, crank.start)
    m.revolute("crankpin", crank.end, rod.start)
    options = {} if law is None else {"contact": law}
    m.clearance_joint("pin", rod.end, block.pin(), clearance=1e-4, bearing_radius=8e-3, **options)
    m.slider("guide", g, block.pin())
    m.spring("return", block.pin(), s, stiffness=2000.0, damping=5.0, free_length=free_length)
    m.drive(crank, speed=31.4)
    return m


@pytest.fixture(scope="module")
def settled() -> Result:
    """Until turns repeat: the journal lands after its start in the middle and never leaves its bearing."""
    return vfife.simulate(machine(), turns=20, settle="1 %", reference=False, companions=1)


def test_knocks_of_the_start_are_not_those_of_the_turns(settled: Result) -> None:
    """All contacts begin in the first turn: the table has none, and that of the whole run stands beside."""
    knocks = measured_knocks(settled.record, settled.motion)["pin"]
    assert settled.measures["pin.impacts"] > 0 and settled.impacts.entries[-1].time < 0.2
    assert (knocks.count, knocks.speed, knocks.hardest) == (0, 0.0, False)
    assert settled.summary["knocks"]["pin"] == dataclasses.asdict(knocks)
    table = joint_table(settled.summary)
    (row,) = (one for one in table.rows if str(one[0]).startswith("pin"))
    assert "none" in row
    text = str(settled)
    assert "no knocks in the turns of the table; in the whole run" in text
    assert document(settled.summary) is not None


def test_knocks_of_a_single_turn_are_those_of_the_run() -> None:
    """Nothing comes before: count and speed are those that the run has."""
    result = vfife.simulate(machine(), turns=1, reference=False, companions=0)
    knocks = measured_knocks(result.record, result.motion)["pin"]
    assert knocks.hardest and knocks.count == result.measures["pin.impacts"]
    assert knocks.speed == result.measures["pin.approach_speed.max"]
    assert "whole run" in str(result)


def test_a_lasting_contact_is_cautioned_about_where_its_law_remembers(settled: Result) -> None:
    """The default law divides by the speed of the landing."""
    assert lasting_landings(settled.record) == ["pin"]
    ((joint, caution),) = landing_cautions(settled).items()
    assert (
        joint == "pin"
        and MEMORY in caution
        and caution.startswith("Joint pin")
        and "lankarani-nikravesh" in caution
    )
    assert caution in settled.summary["warnings"]


def test_a_journal_that_starts_seated_never_lands_and_has_the_caution() -> None:
    """Its damping is divided by the floor of the impact speed, which no number of the run shows."""
    m = machine()
    m.start = dataclasses.replace(m.start, journals="seated")
    result = vfife.simulate(m, turns=6, reference=False, companions=0)
    assert result.measures["pin.impacts"] == 0 and lasting_landings(result.record) == ["pin"]
    assert any(MEMORY in text and "impact_speed_floor" in text for text in result.summary["warnings"])


@pytest.mark.parametrize(
    "law", [KelvinVoigt(stiffness=1e8, damping_coefficient=2e3), LankaraniNikravesh(restitution=1.0)]
)
def test_a_law_without_memory_needs_no_caution(law: ContactLaw) -> None:
    """Kelvin-Voigt's damping is the same after each landing, and without loss there is none to remember."""
    result = vfife.simulate(machine(law), turns=6, reference=False, companions=0)
    assert lasting_landings(result.record) == []
    assert not any(MEMORY in one for one in result.summary["warnings"])


def test_a_start_that_matters_is_seen_in_the_numbers(settled: Result) -> None:
    """The two starts differ by more than their ranges, which is why the caution is given."""
    m = machine()
    m.start = dataclasses.replace(m.start, journals="seated")
    seated = vfife.simulate(m, turns=20, settle="1 %", reference=False, companions=1)
    one, other = (run.measures["rod.angular_acceleration.max"] for run in (settled, seated))
    assert other.low > one.high or other.high < one.low


def test_a_free_length_that_is_left_to_the_start_is_cautioned_about() -> None:
    """With a clearance; not with a free length, and not without clearance."""
    assert any("spring.return.free_length" in one for one in machine(free_length=None).check().notes)
    assert not any("free_length" in one for one in machine().check().notes)


def test_a_position_inside_a_clearance_is_cautioned_about() -> None:
    """The run begins where start.journals puts the ball; in the middle the position is that of the run."""

    def ball(x: float) -> vfife.Mechanism:
        m = vfife.Mechanism("ball")
        point = m.point("O", 0.0, 0.0)
        mass = m.point_mass("ball", mass=0.5, position=(x, 0.0))
        m.clearance_joint("j", point, mass.pin(), clearance=1e-3, bearing_radius=1e-2)
        return m

    (note,) = (one for one in ball(4e-4).check().notes if "body.ball.position" in one)
    assert "0.4 mm off the middle" in note and '{"ball": (x, y, angle)}' in note
    assert not any("position" in one for one in ball(0.0).check().notes)
    began = vfife.simulate(ball(4e-4), duration=1e-3, start={"ball": (4e-4, 3e-4, 0.0)})
    assert began.series["ball.x"].values[0] == pytest.approx(4e-4)


def test_outputs_that_shorten_the_step_are_told() -> None:
    """Seven hundred outputs a turn are none that do; two millions are."""
    law = Hertz()
    for outputs, told in ((720, False), (2_000_000, True)):
        m = machine(law)
        m.settings = dataclasses.replace(m.settings, outputs=outputs)
        result = vfife.simulate(m, turns=0.02, reference=False, companions=0)
        assert any("number of outputs" in one for one in result.summary["warnings"]) is told
        assert ("number of outputs" in m.check().set_by) is told


def lift(clearance: float = 1e-4, journals: str = "centred") -> vfife.Mechanism:
    """The scissor lift with clearance in its fixed foot and the right pin of its lower stage."""
    m = loosened(loosened(gallery.scissor_lift(), "foot", clearance), "right", clearance)
    settings = dataclasses.replace(m.settings, step="auto", companions=1)
    start = dataclasses.replace(m.start, journals=journals)
    return dataclasses.replace(m, settings=settings, start=start)


@pytest.mark.parametrize("clearance", [2e-5, 1e-4])
def test_forces_of_the_fall_at_the_start_are_called_that(clearance: float) -> None:
    """A lift whose journals start in the middle drops on its pins: forces of several times the ideal ones in
    the first 20 ms, and less than 5 % more than these with seated journals.
    """
    fallen = vfife.simulate(lift(clearance), duration=0.5, outputs=400)
    fall = fallen.summary["start_fall"]
    assert fall["joints"] == ("foot", "right") and 0.005 < fall["time"] < 0.03
    assert {"foot.force.max", "cross-1.force.max", "actuator.actuator_force.max"} <= set(fall["measures"])
    ideal = fallen.reference.measures
    assert all(fallen.measures[name] > 1.05 * ideal[name] for name in fall["measures"])
    text = fallen.summary["warnings"][fall["index"]]
    assert 'start.journals = "seated" starts without this fall' in text and "actuator" in text
    first = "The largest forces are those of the journals' fall at the start"
    assert certainty(fallen.summary).startswith(first) and certainty(fallen.summary).count("caution 1") == 1
    assert conclusion(fallen.summary)[0].startswith(first)
    long = str(document(fallen.summary))
    assert long.index("has no such blow") < long.index("Bodies") and long.count(text[:40]) == 1
    seated = vfife.simulate(lift(clearance, "seated"), duration=0.5, outputs=400)
    assert "start_fall" not in seated.summary and certainty(seated.summary).startswith("Reliable")
    assert seated.measures["foot.force.max"] < 1.05 * ideal["foot.force.max"]


@pytest.mark.parametrize("example", [gallery.slider_crank_loose_pin, gallery.four_bar_case_b])
def test_forces_of_a_first_turn_are_those_of_the_fall_if_the_second_has_less(
    example: Callable[..., vfife.Mechanism],
) -> None:
    """What the caution names is less in the second turn by a twentieth or more, and has no caution there."""
    one, two = (vfife.simulate(example(), turns=turns, companions=0) for turns in (1, 2))
    fall = start_fall(one.record, one.reference.measures, one.motion)
    assert fall is not None and fall.time < 0.05 * one.time[-1]
    assert all(one.measures[name] > 1.05 * two.measures[name] for name in fall.measures)
    assert "start_fall" not in two.summary and "two turns or more" in one.summary["warnings"][0]


def test_no_fall_is_named_where_it_is_the_experiment_or_nothing_falls() -> None:
    """One body in its bearing falls on purpose; a guide has no seat, and its block falls with seated pins."""
    journal = vfife.simulate(gallery.journal_in_bearing(), companions=0)
    assert "start_fall" not in journal.summary
    free = vfife.simulate(gallery.slider_crank_free(), companions=0)
    forces = joint_force_max(free.record)[:, list(joint_rows(free.record)).index("O")]
    landed = int(np.flatnonzero(free.record.block("contact_onsets").any(axis=1))[0])
    assert forces[: landed + 1].max() == free.measures["O.force.max"], "inertia, before anything lands"
    assert "start_fall" not in free.summary
    guide = gallery.slider_crank_loose_guide()
    assert falling_journals(guide) == ["guide"] and "cannot start seated" in fall_remark(guide, turns=True)
    seated = dataclasses.replace(guide, start=dataclasses.replace(guide.start, journals="seated"))
    assert falling_journals(seated) == ["guide"] and SEATED not in fall_remark(seated, turns=False)
    assert fall_remark(gallery.slider_crank(), turns=True) == ""


def test_a_seated_start_without_reaction_is_advised_to_go_on_from_the_run() -> None:
    """From rest without weight nothing presses journals: they fall, but not in the next run."""
    model = gallery.load("four_bar_case_b", {"driver.crank.ramp": "0.1 s", "driver.crank.speed": "300 rpm"})
    model = dataclasses.replace(model, start=dataclasses.replace(model.start, journals="seated"))
    first = vfife.simulate(model, turns=1, companions=0)
    text = first.summary["warnings"][first.summary["start_fall"]["index"]]
    assert "starts without this fall" not in text and "no direction for C" in text and "--start-from" in text
    following = vfife.simulate(model, turns=1, companions=0, start=first)
    assert "start_fall" not in following.summary


def test_a_comparison_of_laws_names_the_fall() -> None:
    result = vfife.compare(gallery.slider_crank_loose_pin(), contact=["hertz"], turns=1, companions=0)
    assert "those of the first" in str(comparison(result))


def test_derivatives_of_the_blow_of_the_fall_are_called_that() -> None:
    """Those of a first turn are of the fall; those of the second are not."""
    options = {"of": "pin.force.max", "to": "body.block.mass", "companions": 0, "runs": 1}
    one, two = (vfife.sensitivity(gallery.slider_crank_loose_pin(), turns=n, **options) for n in (1, 2))
    assert "pin.force.max: the value is that of the first" in str(sensitivity(one))
    fall = sensitivity(one).data["start_fall"]
    assert fall["measures"] == ["pin.force.max"] and fall["joints"] == ("pin",) and fall["time"] > 0.0
    assert "fall" not in str(sensitivity(two)) and "start_fall" not in sensitivity(two).data


def test_runs_side_by_side_name_the_fall() -> None:
    runs = {n: vfife.simulate(gallery.slider_crank_loose_pin(), turns=n, companions=0) for n in (1, 2)}
    told = side_by_side({f"run-{n}": result.summary for n, result in runs.items()})
    assert "the journals' fall at the start" in str(told).replace("\n", " ")
    assert "pin.force.max" in told.data["runs"]["run-1"]["start_fall"]["measures"]
    assert "start_fall" not in told.data["runs"]["run-2"]
