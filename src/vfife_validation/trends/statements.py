"""Statements of the literature on trends, judged by medians over start angles, and their sources."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..paper.contents import Verdict
from .grid import Axis, Grid, steps

Array = NDArray[np.float64]
MEASURED_CHAIN = "Advances in Mechanical Engineering 2021, doi 10.1177/16878140211012541, measured"
FOUR_BAR_WEAR = "Advances in Mechanical Engineering 2022, doi 10.1177/16878132221125043"
WANG = "Wang, arXiv:2606.25208, for a leg"
FARAHANCHI = "Farahanchi, thesis, Michigan State University 1991, for a loose guide"
FLORES = "Flores, Mechanism and Machine Theory 44 (2009) 1211-1222"
MA = "Ma and co-workers, as cited in doi 10.1007/s11044-020-09769-3"
EARLES = "Earles and Wu, as used by Grant and Fawcett, Mechanism and Machine Theory 14 (1979)"
SURE = 0.25  # of all cases, by which two counts must differ


def growth(statement: str, source: str, grid: Grid, name: str, axis: Axis, remark: str = "") -> Verdict:
    """Judge whether a measure grows along an axis: false if its median decreases anywhere beyond its
    interval.
    """
    change = steps(grid, name, axis)
    return Verdict(f"{statement} ({source})", change.holds, change.text + remark)


def reversal(grid: Grid, name: str) -> Verdict:
    """Single starts order neighbouring clearances otherwise than the medians do."""
    single = np.sign(np.diff(grid.values[name], axis=1))
    count = int((single != np.sign(np.diff(grid.median(name), axis=0))).sum())
    statement = "a single start can reverse the order of two designs, so many must be compared"
    return Verdict(
        f"{statement} ({WANG})", count > 0, f"in {count} of {single.size} pairs of neighbouring clearances"
    )


def largest_effect(joint: str, statement: str, source: str, effects: dict[str, Array]) -> Verdict:
    """One ``joint`` has the largest effect at all points; ``effects`` (1) by joint, same shape each."""
    stack = np.stack(list(effects.values()))
    wins = int((stack.argmax(axis=0) == list(effects).index(joint)).sum())
    ranges = ", ".join(
        f"{name} {100.0 * effect.min():.3g} to {100.0 * effect.max():.3g} %"
        for name, effect in effects.items()
    )
    return Verdict(
        f"{statement} ({source})", wins == stack[0].size,
        f"{joint} in {wins} of {stack[0].size} points; above the follower's ideal acceleration: {ranges}",
    )  # fmt: skip


def further_joints(joint: str, single: Grid, all_loose: Grid) -> Verdict:
    """Further loose joints raise the peak force of a joint."""
    name = f"{joint}.force.max"
    (low, high), (single_low, single_high) = all_loose.interval(name), single.interval(name)
    rises, falls = int((low > single_high).sum()), int((high < single_low).sum())
    ratio = all_loose.median(name) / single.median(name)
    holds = False if falls else True if 2 * rises > low.size else None
    return Verdict(
        f"further loose joints raise the peak force of {joint} ({WANG})", holds,
        f"surely higher at {rises}, surely lower at {falls} of {low.size} points;"
        f" {ratio.min():.3g} to {ratio.max():.3g} times",
    )  # fmt: skip


def larger_count(statement: str, source: str, first: int, second: int, size: int, numbers: str) -> Verdict:
    """Judge whether a first count of ``size`` cases exceeds a second one; open if they differ by less than a
    quarter.
    """
    difference = (first - second) / size
    holds = None if abs(difference) < SURE else difference > 0.0
    return Verdict(f"{statement} ({source})", holds, numbers)
