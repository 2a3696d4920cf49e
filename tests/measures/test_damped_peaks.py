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
from vfife.measures.damped_peaks import damped_peaks, windows
from vfife.model.surfaces import surfaces
from vfife.modelfile import load
from vfife.report.damping_cautions import damping_cautions
from vfife.report.overview import certainty
from vfife.simulation.result import Result

JOINTS = ("big-end", "small-end", "cylinder")


def compressor(floor: str) -> Result:
    """Its big-end begins its contact with almost no speed, and is pressed by the gas later."""
    changes = [(f"joint.{name}.impact_speed_floor", floor) for name in JOINTS]
    return vfife.simulate(load("examples/compressor.toml", set=changes), turns=2, companions=0)


def impact(law: LankaraniNikravesh | Hertz) -> Result:
    return Result(
        go(journal_in_bearing(0.5, friction=Frictionless(), contact=law), 2e-7, duration=5e-3, outputs=100)
    )


def test_the_elastic_part_is_that_of_the_law() -> None:
    """By hand at the output of the largest force: F = K d^1.5 (1 + chi d'/v0), chi = 0.5625."""
    result = compressor("1e-5 m/s")
    record = result.record
    peak = damped_peaks(record, result.motion)["big-end"]
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
    assert peak.ratio == pytest.approx((peak.force / elastic - 1.0) / 0.5625, rel=1e-9)
    assert peak.onset == pytest.approx(1e-5, rel=1e-9)


def test_a_contact_that_began_slowly_is_damped_by_most_of_its_force() -> None:
    """The floor of the onset bounds it, as the caution says."""
    slow, fast = compressor("1e-5 m/s"), compressor("0.1 m/s")
    assert damped_peaks(slow.record, slow.motion)["big-end"].share > 0.6
    assert damped_peaks(fast.record, fast.motion)["big-end"].share < 0.1
    (said,) = damping_cautions(slow).values()
    assert said.startswith("Joint big-end: at least") and "is damping of the contact law" in said
    assert "began at 10 µm/s and was struck while closed" in said
    assert "impact_speed_floor (10 µm/s here), which bounds it" in said
    number = slow.summary["warnings"].index(said)
    assert slow.summary["law_dependent"]["big-end"] == number and "law" not in certainty(fast.summary)
    assert "force of big-end depends more on the contact law" in certainty(slow.summary)
    assert damping_cautions(fast) == {}


def test_a_free_impact_has_its_deepest_penetration_and_its_largest_force_together() -> None:
    """No energy is lost: all of the force is elastic, to what outputs apart leave."""
    result = impact(Hertz())
    assert damped_peaks(result.record, result.motion)["J"].share == pytest.approx(0.0, abs=1e-9)
    assert damping_cautions(result) == {}


def test_a_law_that_damps_nearly_all_of_an_impact_is_no_slow_onset() -> None:
    """With a restitution of 0.02 the rate is at most that of the onset, and the factor makes the share."""
    result = impact(Hertz(restitution=0.02, damping="gonthier-exact"))
    peak = damped_peaks(result.record, result.motion)["J"]
    assert peak.share > 0.5 and peak.ratio <= 1.1
    (said,) = damping_cautions(result).values()
    assert "follows from the restitution of 0.02" in said and "struck" not in said


def test_a_mean_over_turns_counts_each_turn() -> None:
    """Peaks of the turns that the measure is a mean of."""
    result = compressor("1e-3 m/s")
    outputs = result.record.assembly.mechanism.settings.outputs
    both = dataclasses.replace(result.motion, first=1, last=2)
    assert [rows.stop - rows.start for rows in windows(result.record, both)] == [outputs, outputs]
    k = result.record.assembly.contact_joints.index("big-end")
    peaks = [
        math.sqrt(result.record.block("contact_force_squared_max")[rows, k].max())
        for rows in windows(result.record, both)
    ]
    assert damped_peaks(result.record, both)["big-end"].force == pytest.approx(sum(peaks) / 2.0, rel=1e-14)
