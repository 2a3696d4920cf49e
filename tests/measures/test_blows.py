"""Blows in closed contact: the journal is thrown across its bearing without losing contact, so that no impact
counts it, and the force rises above that of the ideal joint.
"""

from __future__ import annotations

from functools import cache

import numpy as np

import vfife
from vfife import gallery
from vfife.measures.blows import blows
from vfife.report.overview import overview
from vfife.report.summary import run_summary
from vfife.report.terminal import as_text
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
