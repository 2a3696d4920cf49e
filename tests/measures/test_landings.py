"""Knocks of the turns of the measures, and contacts that never end under laws that remember their landing."""

from __future__ import annotations

import dataclasses

import pytest

import vfife
from vfife.laws import Hertz, KelvinVoigt, LankaraniNikravesh
from vfife.laws.law import ContactLaw
from vfife.measures.landings import lasting_landings, measured_knocks
from vfife.report.cautions import landing_cautions
from vfife.report.overview import joint_table
from vfife.report.run import document
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
