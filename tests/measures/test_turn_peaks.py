"""Share of damping in the largest forces: none in a free impact on a nearly elastic law, most of it where a
contact began slowly and is struck while closed; the run says so, and what bounds it.
"""

import dataclasses
import math

import numpy as np
import pytest

import vfife
from support import go, journal_in_bearing
from vfife.laws import Frictionless, Hertz, LankaraniNikravesh
from vfife.measures.turn_peaks import DampedPeaks, Peak, RaisedPeaks, damped_peaks, turn_lanes, windows
from vfife.model.surfaces import surfaces
from vfife.modelfile import load
from vfife.report.damping_cautions import damping_cautions
from vfife.report.overview import certainty
from vfife.simulation.result import Result

JOINTS = ("big-end", "small-end", "cylinder")


def compressor(floor: str, turns: int = 2, companions: int = 0) -> Result:
    """Its big-end begins its contact with almost no speed, and is pressed by the gas later."""
    changes = [(f"joint.{name}.impact_speed_floor", floor) for name in JOINTS]
    return vfife.simulate(load("examples/compressor.toml", set=changes), turns=turns, companions=companions)


def impact(law: LankaraniNikravesh | Hertz) -> Result:
    return Result(
        go(journal_in_bearing(0.5, friction=Frictionless(), contact=law), 2e-7, duration=5e-3, outputs=100)
    )


def test_the_elastic_part_is_that_of_the_law() -> None:
    """By hand at the output of the largest force: F = K d^1.5 (1 + chi d'/v0), chi = 0.5625."""
    result = compressor("1e-5 m/s")
    record = result.record
    peaks = damped_peaks(record, result.motion)["big-end"]
    ((peak,),) = peaks.lanes
    joint = record.assembly.mechanism.contacts["big-end"]
    k = record.assembly.contact_joints.index("big-end")
    (rows,) = windows(record, result.motion)
    squares = record.block("contact_force_squared_max")[rows, k]
    row = rows.start + int(np.argmax(squares))
    stiffness = surfaces(record.assembly.mechanism, joint).hertz_stiffness
    elastic = stiffness * record.block("contact_penetration_max")[row, k] ** 1.5
    assert peak.force == pytest.approx(math.sqrt(squares.max()), rel=1e-14)
    assert peak.force == pytest.approx(result.measures["big-end.force.max"], rel=1e-12)
    assert peak.share == pytest.approx(1.0 - elastic / peak.force, rel=1e-9)
    assert peak.onset == pytest.approx(1e-5, rel=1e-9)
    assert peaks.ratio == pytest.approx((peak.force / elastic - 1.0) / 0.5625, rel=1e-9)


def test_a_contact_that_began_slowly_is_damped_by_most_of_its_force() -> None:
    """The floor of the onset bounds it, as the caution says; the law comes first."""
    slow, fast = compressor("1e-5 m/s"), compressor("0.1 m/s")
    assert damped_peaks(slow.record, slow.motion)["big-end"].largest.share > 0.6
    assert damped_peaks(fast.record, fast.motion)["big-end"].largest.share < 0.1
    (said,) = damping_cautions(slow).values()
    assert said.startswith("Joint big-end: at least") and "is damping of the contact law" in said
    assert "began at 10 µm/s was struck while closed" in said
    assert said.index("--contact lankarani-nikravesh,hertz,gonthier") < said.index("impact_speed_floor (10")
    number = slow.summary["warnings"].index(said)
    assert slow.summary["law_dependent"]["big-end"] == number and "law" not in certainty(fast.summary)
    assert "force of big-end depends more on the contact law" in certainty(slow.summary)
    assert damping_cautions(fast) == {}


def test_a_free_impact_has_its_deepest_penetration_and_its_largest_force_together() -> None:
    """No energy is lost: all of the force is elastic, to what outputs apart leave."""
    result = impact(Hertz())
    peaks = damped_peaks(result.record, result.motion)["J"]
    assert peaks.largest.share == pytest.approx(0.0, abs=1e-9)
    assert damping_cautions(result) == {}


def test_a_law_that_damps_nearly_all_of_an_impact_is_no_slow_onset() -> None:
    """With a restitution of 0.02 the rate is at most that of the onset, and the factor makes the share."""
    result = impact(Hertz(restitution=0.02, damping="gonthier-exact"))
    peaks = damped_peaks(result.record, result.motion)["J"]
    assert peaks.largest.share > 0.5 and peaks.ratio <= 1.1
    (said,) = damping_cautions(result).values()
    assert "follows from the restitution of 0.02" in said and "struck" not in said


def test_each_turn_of_the_measures_counts() -> None:
    """Two turns have two peaks, each the largest force of its turn."""
    result = compressor("1e-3 m/s")
    outputs = result.record.assembly.mechanism.settings.outputs
    both = dataclasses.replace(result.motion, first=1, last=2)
    assert [rows.stop - rows.start for rows in windows(result.record, both)] == [outputs, outputs]
    k = result.record.assembly.contact_joints.index("big-end")
    forces = [
        math.sqrt(result.record.block("contact_force_squared_max")[rows, k].max())
        for rows in windows(result.record, both)
    ]
    (lane,) = damped_peaks(result.record, both)["big-end"].lanes
    assert [peak.force for peak in lane] == pytest.approx(forces, rel=1e-14)


def test_turns_of_companions_count_with_the_least_share_that_they_show() -> None:
    """Of its last turn a companion has all outputs, as the run has; of others the extremes, which bound the
    share from below.
    """
    result = compressor("1e-4 m/s", turns=2, companions=2)
    both = dataclasses.replace(result.motion, first=1, last=2)
    peaks = damped_peaks(result.record, both)["big-end"]
    assert [len(lane) for lane in peaks.lanes] == [2, 2, 2] and peaks.turns == 6
    only = damped_peaks(result.record, result.motion)["big-end"]
    assert [len(lane) for lane in only.lanes] == [1, 1, 1]
    for (run, *others), (former, *lanes) in ((only.lanes, peaks.lanes),):
        assert run == former[1:]
        for last, lane in zip(others, lanes, strict=True):
            assert last[0] in lane  # that of the outputs, not the bound of the whole turn
            assert last[0].force == pytest.approx(run[0].force, rel=0.1)
            assert last[0].share == pytest.approx(run[0].share, abs=0.1)
    k = result.record.assembly.contact_joints.index("big-end")
    rows = [(part, turns) for lane, part, turns in turn_lanes(result.record, both) if lane == 1]
    (turn,) = (part for part, turns in rows if len(part.steps) == 1)
    joint = result.record.assembly.mechanism.contacts["big-end"]
    stiffness = surfaces(result.record.assembly.mechanism, joint).hertz_stiffness
    elastic = stiffness * turn.block("contact_penetration_max")[0, k] ** 1.5
    force = math.sqrt(turn.block("contact_force_squared_max")[0, k])
    assert min(peak.share for peak in peaks.lanes[1]) == pytest.approx(1.0 - elastic / force, rel=1e-9)


def made(*lanes: str) -> DampedPeaks:
    """Peaks of 1 N, of which ``+`` is damped and ``-`` is not."""
    elastic = {"+": 0.2, "-": 0.9}
    return DampedPeaks(
        tuple(tuple(Peak(1.0, elastic[turn], math.nan) for turn in lane) for lane in lanes), 0.5
    )


def test_frequency_is_that_of_the_lane_with_most_damped_turns() -> None:
    peaks = made("----------", "-+-+------", "---------+")
    assert (peaks.damped, peaks.turns, peaks.frequency) == (3, 30, 0.2)
    assert peaks.largest.share == pytest.approx(0.8) and peaks.ratio == pytest.approx(8.0)
    assert made("--", "--").frequency == 0.0


@pytest.mark.parametrize(
    ("lanes", "said"),
    [
        (("----------", "----------"), None),
        (("-" * 19 + "+", "-" * 20), None),  # one of twenty
        (("-" * 18 + "++", "-" * 20), "in at least 2 of 40 turns"),
        (("----------", "---------+"), "in at least 1 of 20 turns"),  # in a companion alone
        (("++", "++"), "Joint big-end: at least 80 % of its largest force is damping"),
    ],
)
def test_the_share_of_turns_decides_not_the_blow_that_holds_the_peak(monkeypatch, lanes, said) -> None:
    result = compressor("1e-3 m/s")
    peaks = {"big-end": made(*lanes)}
    monkeypatch.setattr("vfife.report.damping_cautions.damped_peaks", lambda record, motion: peaks)
    found = damping_cautions(result)
    assert list(found) == ([] if said is None else ["big-end"])
    assert said is None or said in found["big-end"]


def test_one_turn_of_one_lane_suffices_only_where_no_blow_is_cautioned_about(monkeypatch) -> None:
    result, peaks = compressor("1e-3 m/s"), made("----------", "---------+", "----------")
    monkeypatch.setattr(
        "vfife.report.damping_cautions.damped_peaks", lambda record, motion: {"big-end": peaks}
    )
    assert list(damping_cautions(result)) == ["big-end"]
    shocks = {"big-end": RaisedPeaks(30, 30)}
    monkeypatch.setattr("vfife.report.damping_cautions._shock_counts", lambda run: shocks)
    assert damping_cautions(result) == {}
