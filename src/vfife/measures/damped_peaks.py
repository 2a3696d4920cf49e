"""Share of damping in the largest forces of contacts.

A hysteresis law damps in proportion to the rate of penetration over the speed at which the contact began. A
contact that began slowly and is struck while it is closed has a force far beyond its elastic one. The step
does not record the parts of the largest force, but between two outputs it keeps the largest force and the
deepest penetration. The elastic force never exceeds that at the deepest penetration, so the rest of the
largest force is damping at least.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..laws import ContactLaw
from ..model.surfaces import surfaces
from ..solvers.record import Record
from ..solvers.repeating import turn_grid
from .repetition import Turns
from .turns import last_turn

Array = NDArray[np.float64]


class Peak(NamedTuple):
    """The largest ``force`` (N) of a contact in a turn, the ``elastic`` force (N) that it has at most, and
    the ``onset`` (m/s), the speed at which the contact began; NaN where it began between the same outputs.
    """

    force: float
    elastic: float
    onset: float


@dataclass(frozen=True)
class DampedPeak:
    """The largest force of a joint, as the mean over the turns of the measures: ``force`` (N), the least
    ``share`` of it that is damping (1), and of the largest of these peaks the least ``ratio`` of its rate to
    the speed of the onset (1), and that speed ``onset`` (m/s); NaN where unknown.
    """

    force: float
    share: float
    ratio: float
    onset: float


class Extremes(NamedTuple):
    """Recorded values of all contacts, shape (outputs, contacts) each: ``squares`` of the largest forces
    (N^2), largest penetrations ``depths`` (m), ``slowness`` of the last onset (s/m), number of ``onsets``;
    None where they are not recorded.
    """

    squares: Array
    depths: Array
    slowness: Array | None
    onsets: Array | None


ONSET_BLOCKS = "contact_slowness", "contact_onsets"


def damped_peaks(record: Record, motion: Turns | None) -> dict[str, DampedPeak]:
    """Return the share of damping in the largest force of each joint with clearance; none of oil films and
    tables, whose forces have other parts.
    """
    blocks = ("contact_force_squared_max", "contact_penetration_max")
    if record.static or not record.assembly.contacts or not all(record.keeps(block) for block in blocks):
        return {}
    largest: dict[str, DampedPeak] = {}
    # Read once: a block of a long run has millions of numbers, and a turn of each contact needs a few.
    extremes = Extremes(
        *(record.block(block) for block in blocks),
        *(record.block(block) if record.keeps(block) else None for block in ONSET_BLOCKS),
    )
    for k, name in enumerate(record.assembly.contact_joints):
        joint = record.assembly.mechanism.contacts[name]
        law = joint.contact
        if law.film or law.tabled:
            continue
        p = law.parameters(surfaces(record.assembly.mechanism, joint))
        peak = _mean([_peak(extremes, k, rows, law, p) for rows in windows(record, motion)], law, p)
        if name not in largest or peak.force > largest[name].force:
            largest[name] = peak
    return largest


def windows(record: Record, motion: Turns | None) -> Iterator[slice]:
    """Yield the outputs of each turn that measures are of."""
    grid = turn_grid(record.assembly)
    if motion is not None and motion.has_several and grid is not None:
        for turn in range(motion.first, motion.last + 1):
            yield slice(grid.end(turn - 1) + 1, grid.end(turn) + 1)
    else:
        rows = np.flatnonzero(last_turn(record))
        yield slice(int(rows[0]), int(rows[-1]) + 1)


def _peak(extremes: Extremes, k: int, rows: slice, law: ContactLaw, p: tuple[float, ...]) -> Peak:
    squares = extremes.squares[rows, k]
    row = rows.start + int(np.argmax(squares))
    depth = float(extremes.depths[row, k])
    elastic = law.force(depth, 0.0, p)[0] if depth > 0.0 else 0.0
    return Peak(math.sqrt(float(squares.max())), float(elastic), _onset(extremes, row, k))


def _onset(extremes: Extremes, row: int, k: int) -> float:
    """Return the speed (m/s) at which the contact began that lasted from the output before to this one; NaN
    without such a contact.
    """
    if row == 0 or extremes.slowness is None or extremes.onsets is None:
        return math.nan
    slowness = float(extremes.slowness[row - 1, k])
    onsets = extremes.onsets[row - 1 : row + 1, k]
    return 1.0 / slowness if slowness > 0.0 and onsets[0] == onsets[1] else math.nan


def _mean(peaks: list[Peak], law: ContactLaw, p: tuple[float, ...]) -> DampedPeak:
    force = math.fsum(peak.force for peak in peaks) / len(peaks)
    elastic = math.fsum(min(peak.elastic, peak.force) for peak in peaks) / len(peaks)
    top = max(peaks, key=lambda peak: peak.force)
    factor = float(getattr(law, "damping_factor", math.nan))  # of hysteresis laws; others divide by no speed
    ratio = (top.force / top.elastic - 1.0) / factor if top.elastic > 0.0 and factor > 0.0 else math.nan
    return DampedPeak(force, 1.0 - elastic / force if force > 0.0 else 0.0, ratio, top.onset)
