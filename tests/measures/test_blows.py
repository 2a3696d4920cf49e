"""Blows in closed contact: the journal is thrown across its bearing without losing contact, so that no impact
counts it, and the force rises above that of the ideal joint.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import vfife
from vfife import gallery
from vfife.measures.blows import blows, impact_rows
from vfife.report.amounts import interval
from vfife.report.front import conclusion
from vfife.report.overview import overview
from vfife.report.run_tables import blow_texts
from vfife.report.summary import run_summary
from vfife.report.terminal import as_text
from vfife.report.trust import over_several_turns
from vfife.results.run_data import RunData
from vfife.simulation.result import Result


@cache
def compressor() -> Result:
    """New parts: their small end has next to no knocks, and is struck in each turn where the gas pressure is
    gone.
    """
    return vfife.simulate(gallery.compressor(turns=4), companions=0)


def reference() -> RunData:
    found = compressor().reference
    assert found is not None
    return found


def test_a_blow_is_the_force_above_the_ideal_joint_where_no_contact_begins() -> None:
    result, ideal = compressor(), reference()
    found = blows(result.record, ideal.record, result.motion)["small-end"]
    force = result.data["joint_force_max"].sel(joint="small-end").values
    angle, onsets = result.crank_angle, result.record.block("contact_onsets")
    assert angle is not None
    k = list(result.record.assembly.contact_joints).index("small-end")
    assert onsets[found.row, k] == onsets[found.row - 1, k]
    assert 30.0 < angle[found.row] < 90.0  # after the gas pressure has gone
    near = np.abs(ideal.crank_angle - angle[found.row]) < 1.0  # type: ignore[operator]
    there = ideal.data["joint_force_max"].sel(joint="small-end").values[near]
    assert there.max() < 200.0 < found.excess
    assert force[found.row] - there.max() <= found.excess <= force[found.row] - there.min()


def test_a_joint_that_follows_the_reference_has_no_blow() -> None:
    """The last turn of a run, compared with itself, rises nowhere; compared with another one it does."""
    record = compressor().record
    alone = blows(record, record, None)
    assert alone and all(blow.excess == 0.0 for blow in alone.values())
    assert all(blow.excess > 0.0 for blow in blows(record, reference().record, None).values())


def test_the_answer_names_the_blow_beside_the_knocks() -> None:
    summary = run_summary(compressor())
    line = next(line for line in as_text(overview(summary), 200).splitlines() if line.startswith("Blow"))
    assert "small-end" in line and "above the ideal joint at" in line and "no knock; not estimated" in line
    summary["blows"] = {}
    assert "Blow" not in as_text(overview(summary), 200)


def pushed(**options: Any) -> dict[str, Any]:
    """Summary of a four-bar at 300 rpm, in which a journal slides along its bearing and is thrown across it
    once in each turn.
    """
    m = vfife.Mechanism("four-bar", gravity=(0.0, -9.81))
    m.point("A", 0.0, 0.0)
    m.point("D", 0.2, 0.0)
    links = (("crank", 0.06, 0.5, 0), ("coupler", 0.18, 0.8, 50), ("follower", 0.15, 0.7, 80))
    for name, length, mass, angle in links:
        m.link(name, length=length, mass=mass, angle=f"{angle} deg")
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    contact, friction = vfife.laws.LankaraniNikravesh(restitution=0.6), vfife.laws.Ambrosio(coefficient=0.08)
    m.clearance_joint(
        "C", "coupler.end", "follower.end", clearance=6e-5, bearing_radius=0.008, axial_length=0.016,
        contact=contact, friction=friction,
    )  # fmt: skip
    m.revolute("D", "ground.D", "follower.start")
    m.drive("crank", speed="300 rpm")
    return run_summary(vfife.simulate(m, companions=0, **options))


def test_the_answer_names_a_blow_that_makes_the_largest_force_of_a_joint_without_knocks() -> None:
    """The words "no knocks" alone would call the joint quiet."""
    summary = pushed(turns=6)
    lines = as_text(overview(summary), 200).splitlines()
    blow = next(line for line in lines if line.startswith("Blow"))
    assert any(line.startswith("Noise") and "no knocks" in line for line in lines)
    assert "C up to 1" in blow and "above the ideal joint at" in blow
    lowest, excess = (summary["blows"]["C"][key] for key in ("lowest", "excess"))
    text = f"(single turns {interval(lowest, excess, 'N', 0.1 * excess)})"
    assert (text in blow) == over_several_turns(summary["turns"]), "no range with the words not estimated"
    summary["turns"] |= {"motion": "not repeating", "count": 40, "first": 21, "last": 40}
    assert text in blow_texts(summary)["C"] and "C up to 1" in blow_texts(summary)["C"]
    assert "A blow in closed contact: C" in " ".join(conclusion(summary))
    summary["blows"]["C"]["excess"] = 0.1 * summary["measures"]["C.force.max"]
    assert "Blow" not in as_text(overview(summary), 200)


@pytest.mark.parametrize(("share", "named"), [(0.6, True), (0.4, False)])
def test_a_blow_beside_mild_knocks_is_named_where_it_makes_most_of_the_force(
    share: float, named: bool
) -> None:
    """The joint has a knock of 13 mm/s; its largest force rises by 1 / share of the blow."""
    summary = pushed(turns=6)
    summary["knocks"]["C"] |= {"count": 2, "speed": 0.013, "hardest": True}
    summary["measures"]["C.approach_speed.max"] = 0.013
    joint = summary["joints"]["C"]
    summary["blows"]["C"]["excess"] = share * (joint["force.max"] - joint["ideal_force.max"])
    text = as_text(overview(summary), 200)
    assert "no knocks" not in text and ("Blow" in text) == named


def test_a_step_that_does_not_divide_a_turn_leaves_blows_undetermined() -> None:
    summary = pushed(turns=6, step=0.71e-6)
    assert summary["blows"] == {}
    assert "Blow" in (text := as_text(overview(summary), 200)) and "not determined, because the step" in text


def test_without_an_ideal_mechanism_there_is_none() -> None:
    result = compressor()
    assert blows(result.record, None, result.motion) == {}


def test_a_rise_at_an_impact_is_no_blow() -> None:
    """Worn parts knock: their largest rise is that of an impact."""
    result = vfife.simulate(gallery.slider_crank_loose_pin(), turns=4, companions=0)
    ideal = result.reference
    assert ideal is not None
    (joint, blow), *_ = blows(result.record, ideal.record, result.motion).items()
    force = result.data["joint_force_max"].sel(joint=joint).values[result.last_turn]
    began = np.diff(result.record.block("contact_onsets")[:, 0], prepend=0.0) > 0.0
    row = int(np.flatnonzero(result.last_turn)[np.argmax(force)])
    assert began[row] and not began[blow.row]
    assert blow.excess < force.max() - ideal.measures[f"{joint}.force.max"]


def test_the_peak_of_a_counted_knock_is_no_blow_where_it_comes_outputs_after_its_onset() -> None:
    """The hardest knock of the loose pin begins between 6.5 and 7 degrees, flies free before and after it,
    and its force is largest between 7 and 7.5 degrees.
    """
    result = vfife.simulate(gallery.slider_crank_loose_pin(), companions=0)
    onsets, peak = (result.record.block(f"contact_{name}")[:, 0] for name in ("onsets", "force_squared_max"))
    row, away = int(peak.argmax()), result.record.block("contact_penetration")[:, 0]
    assert onsets[row] == onsets[row - 1] == onsets[row - 2] + 1.0 and away[row - 2] < 0.0 and away[row] < 0.0
    summary = run_summary(result)
    assert summary["blows"] and blow_texts(summary) == {}


def rows_in_impact(force: list[float], began: list[int], touching: list[int] | None = None) -> list[int]:
    flags = [np.isin(np.arange(len(force)), rows) for rows in (began, touching or [])]
    return np.flatnonzero(impact_rows(np.array(force), *flags)).tolist()


def test_an_impact_lasts_from_its_onset_until_the_force_falls_and_rises_again() -> None:
    steep = [0.0, 240.0, 910.0, 1677.0, 2438.0, 2438.0, 1929.0, 818.0, 30.0, 0.0]
    assert rows_in_impact([*steep, 0.0, 0.0], [1]) == list(range(1, 12))  # and in the flight after it
    assert rows_in_impact([*steep, 50.0, 800.0], [1]) == list(range(1, 10))
    landing = [0.0, 450.0, 440.0, 2470.0, 3300.0, 900.0]  # lands softly, and is thrown while it touches
    assert rows_in_impact(landing, [1]) == [1, 2]
    assert rows_in_impact([0.0, 563.0, 541.0, 576.0, 924.0, 1159.0], [1]) == [1, 2, 3, 4]
    assert rows_in_impact([100.0, 900.0, 100.0], []) == []
    assert rows_in_impact([500.0, 90.0, 500.0, 400.0, 90.0], [2]) == [2, 3, 4]


def test_the_force_of_the_contact_before_does_not_end_an_impact() -> None:
    """A contact of 900 N ends, and another begins, between the same two outputs."""
    force = [900.0, 850.0, 100.0, 300.0, 700.0, 200.0]
    assert rows_in_impact(force, [1], [0]) == [1, 2, 3, 4, 5]
    assert rows_in_impact(force, [1]) == [1, 2]
