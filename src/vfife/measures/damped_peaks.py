"""Share of damping in the largest forces of contacts, turn by turn.

A hysteresis law damps in proportion to the rate of penetration over the speed at which the contact began. A
contact that began slowly and is struck while it is closed has a force far beyond its elastic one. The step
does not record the parts of the largest force, but between two outputs it keeps the largest force and the
deepest penetration. The elastic force never exceeds that at the deepest penetration, so the rest of the
largest force is damping at least. Of the earlier turns of a companion that bound uses the deepest penetration
of the turn.

Turns that do not repeat have other shares, and a single turn represents none of the others. All turns of the
measures are therefore counted, of the run and of its companions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..laws import ContactLaw
from ..model.surfaces import surfaces
from ..solvers.record import Record
from .repetition import Turns
from .turn_lanes import turn_lanes

Array = NDArray[np.float64]

# Share of a largest force from which on it is called mostly damping.
MOSTLY = 0.5


class Peak(NamedTuple):
    """The largest ``force`` (N) of a contact in a turn, the ``elastic`` force (N) that it has at most, and
    the ``onset`` (m/s), the speed at which the contact began; NaN where it is not recorded or the contact
    began between the same outputs.
    """

    force: float
    elastic: float
    onset: float

    @property
    def share(self) -> float:
        """The least share of the force that is damping (1)."""
        return max(1.0 - self.elastic / self.force, 0.0) if self.force > 0.0 else 0.0


@dataclass(frozen=True)
class DampedPeaks:
    """The largest forces of a joint: the peaks of the turns of each of ``lanes``, the run first.
    ``factor``: the damping factor (1) of a hysteresis law; NaN for laws that divide by no speed.
    """

    lanes: tuple[tuple[Peak, ...], ...]
    factor: float

    @property
    def turns(self) -> int:
        """Number of turns of all lanes."""
        return sum(len(lane) for lane in self.lanes)

    @property
    def damped(self) -> int:
        """Number of turns of all lanes whose largest force is mostly damping."""
        return sum(_damped(lane) for lane in self.lanes)

    @property
    def frequency(self) -> float:
        """Share of turns (1) whose largest force is mostly damping, of the lane with most of them: a contact
        may keep the speed of its onset for many turns, in one lane and not in another.
        """
        return max(_damped(lane) / len(lane) for lane in self.lanes)

    @property
    def largest(self) -> Peak:
        """The peak with the largest share of damping."""
        return max((peak for lane in self.lanes for peak in lane), key=lambda peak: peak.share)

    @property
    def ratio(self) -> float:
        """The least rate (1) in :attr:`largest` over the speed of the onset; NaN where unknown."""
        force, elastic, _ = self.largest
        known = elastic > 0.0 and self.factor > 0.0
        return (force / elastic - 1.0) / self.factor if known else math.nan


class Extremes(NamedTuple):
    """Recorded values of all contacts, shape (outputs, contacts) each: ``squares`` of the largest forces
    (N^2), largest penetrations ``depths`` (m), ``slowness`` of the last onset (s/m), number of ``onsets``;
    None where they are not recorded.
    """

    squares: Array
    depths: Array
    slowness: Array | None
    onsets: Array | None


BLOCKS = "contact_force_squared_max", "contact_penetration_max"
ONSET_BLOCKS = "contact_slowness", "contact_onsets"


def damped_peaks(record: Record, motion: Turns | None) -> dict[str, DampedPeaks]:
    """Return the largest forces of each joint with clearance in each turn of the run and of its companions;
    none of oil films and tables, whose forces have other parts.
    """
    if record.static or not record.assembly.contacts or not all(record.keeps(block) for block in BLOCKS):
        return {}
    lanes: dict[str, dict[int, list[Peak]]] = {}
    laws = contact_laws(record)
    for lane, part, turns in turn_lanes(record, motion):
        extremes = _extremes(part)
        for rows in turns:
            largest: dict[str, Peak] = {}
            for k, name in enumerate(record.assembly.contact_joints):
                if name in laws:
                    peak = _peak(extremes, k, rows, *laws[name])
                    largest[name] = max(largest.get(name, peak), peak, key=lambda one: one.force)
            for name, peak in largest.items():
                lanes.setdefault(name, {}).setdefault(lane, []).append(peak)
    return {
        name: DampedPeaks(
            tuple(map(tuple, peaks.values())), float(getattr(laws[name][0], "damping_factor", math.nan))
        )
        for name, peaks in lanes.items()
    }


def _damped(lane: tuple[Peak, ...]) -> int:
    return sum(peak.share > MOSTLY for peak in lane)


def contact_laws(record: Record) -> dict[str, tuple[ContactLaw, tuple[float, ...]]]:
    """Return the law of each joint with clearance and the numbers of its slots, without films and tables."""
    mechanism = record.assembly.mechanism
    return {
        name: (joint.contact, joint.contact.parameters(surfaces(mechanism, joint)))
        for name, joint in mechanism.contacts.items()
        if not joint.contact.film and not joint.contact.tabled
    }


def _extremes(record: Record) -> Extremes:
    """Read the blocks of a record once: a long run has millions of numbers, and a turn needs a few."""
    squares, depths = (record.block(block) for block in BLOCKS)
    return Extremes(
        squares, depths, *(record.block(block) if record.keeps(block) else None for block in ONSET_BLOCKS)
    )


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
