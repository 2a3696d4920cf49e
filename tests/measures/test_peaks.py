"""Largest values of many turns at once."""

from __future__ import annotations

import numpy as np

import vfife
from vfife import gallery
from vfife.measures.catalogue import PEAKS, over_turn, peaks_by_output


def test_peaks_of_each_output_are_those_of_a_window_with_one_output() -> None:
    record = vfife.simulate(gallery.compressor(), turns=1, outputs=12, companions=0).record
    outputs = np.arange(len(record.steps))
    assert peaks_by_output(record) == [over_turn(record, outputs == k, PEAKS) for k in outputs]
    assert len({peaks["cylinder.force.max"] for peaks in peaks_by_output(record)}) > 5


def test_peaks_have_the_moments_of_joints_that_keep_an_angle() -> None:
    record = vfife.simulate(gallery.scotch_yoke().ideal(), turns=1, outputs=12).record
    peaks = peaks_by_output(record)
    assert peaks[-1]["guide.moment.max"] > 0.0
    assert "slot.moment.max" not in peaks[-1]
    outputs = np.arange(len(record.steps))
    assert peaks == [over_turn(record, outputs == k, PEAKS) for k in outputs]
