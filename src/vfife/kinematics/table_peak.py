"""Peaks of loads over the crank's angle against the dead centres of the slider on which they act.

A diagram counted from the other dead centre is a valid table. Only the place of its peak shows the mistake:
the pressure of a gas is largest near the dead centre at which its cylinder is smallest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.functions import crank_of
from ..model.loads import Load
from ..model.mechanism import Mechanism
from .batch import Batch
from .drives import guide_of
from .full_turn import FullTurn
from .initial import Motion
from .stroke import travels, vertex

Array = NDArray[np.float64]

TURN = 2.0 * math.pi
# Share of the peak: places with values from there on belong to its plateau, of which the nearest to the dead
# centre counts.
PLATEAU = 0.99
# A gas whose valves open early has its peak far before top dead centre, but keeps most of it up to there: a
# peak so far away (degrees), with less than half of it so near top dead centre, is that of a shifted table.
LARGEST_LAG, HALF, LEAST_REACH = 45.0, 0.5, 30.0
TOP, BOTTOM = "top dead centre", "bottom dead centre"
# Positions of a turn are 10 degrees apart; the parabola through three of them misses a dead centre by less
# than 0.05 degrees.
RESOLUTION = 0.1  # degrees


@dataclass(frozen=True)
class TablePeak:
    """Peak of a table over the crank's angle: its ``value`` (N, or Pa with the ambient pressure), the
    ``place`` in the table (degrees), the name of the nearest dead ``centre`` with its place in the table
    (``centre_place``, degrees), and the ``lag`` (degrees) of the peak behind it, less than 0 ahead of it.
    ``shifted``: the values around top dead centre are low.
    """

    value: float
    place: float
    centre: str
    centre_place: float
    lag: float
    shifted: bool = False

    @property
    def words(self) -> str:
        """Where the peak lies: "peak at 358°, 2° before top dead centre (0°)"."""
        degrees = round(abs(self.lag) / RESOLUTION) * RESOLUTION
        if not degrees:
            return f"peak at {self.place:.4g}°, which is {self.centre}"
        way = "before" if self.lag < 0.0 else "after"
        return f"peak at {self.place:.4g}°, {degrees:.4g}° {way} {self.centre} ({self.centre_place:.4g}°)"


def table_peak(mechanism: Mechanism, motion: Motion, turn: FullTurn, load: Load) -> TablePeak | None:
    """Return the peak of a load on a guide over the crank's angle; None of any other load, of one that keeps
    its value, and of a guide on a moving body.

    Top dead centre is the end of the stroke from which a positive value pushes the journal away.
    """
    guide = guide_of(mechanism, load.slider) if load.on_guide else None
    if guide is None or load.axis != "angles" or guide[0].sides[0][0] != "ground":
        return None
    crank = crank_of(mechanism, load.crank)
    if crank not in motion.names:
        return None
    low, high = load.bounds
    [values] = travels(Batch([mechanism]), [motion], [turn], load.slider)
    angles = turn.positions[:, motion.names.index(crank), 2] * motion.hand - load.zero_angle
    if not high > low or not np.ptp(values) > 0.0:
        return None
    sign = 1.0 if load.unit > 0.0 else -1.0  # a positive value pushes along the guide: the head is below
    stride = float(angles[1] - angles[0])
    centres = [float(angles[0]) + stride * vertex(way * values) for way in (-sign, sign)]
    place, distance = min(
        ((place, _wrapped(place - centres[0])) for place in _peaks(load)), key=lambda pair: abs(pair[1])
    )
    nearest = int(abs(_wrapped(place - centres[1])) < abs(distance))
    lag = _wrapped(place - centres[nearest]) * turn.direction * motion.hand
    at = math.degrees(centres[nearest]) % 360.0
    at = 0.0 if 360.0 - at < 0.5 * RESOLUTION else round(at / RESOLUTION) * RESOLUTION
    value, distance = high + load.ambient_pressure, abs(distance)
    reach = min(abs(_wrapped(place - centres[0])) for place in _peaks(load, HALF))
    shifted = distance > math.radians(LARGEST_LAG) and reach > math.radians(LEAST_REACH)
    return TablePeak(value, math.degrees(place), (TOP, BOTTOM)[nearest], at, math.degrees(lag), shifted)


def misplaced_peaks(mechanism: Mechanism, motion: Motion, turn: FullTurn) -> tuple[str, ...]:
    """Return a caution about each pressure that is largest where its cylinder is large, or low where it is
    smallest.
    """
    notes = []
    for name, load in mechanism.loads.items():
        peak = table_peak(mechanism, motion, turn, load)
        if peak is None or load.measured[0] != "Pa":
            continue
        if peak.centre == BOTTOM:
            notes.append(
                f"The pressure of load {name} has its {peak.words}, where the volume is largest. If the table"
                " counts from another dead centre, shift it with zero_angle."
            )
        elif peak.shifted:
            notes.append(
                f"The pressure of load {name} has its {peak.words}, but is low where the volume is least. If"
                " the table counts from top dead centre, zero_angle is the crank's angle there."
            )
    return tuple(notes)


def _peaks(load: Load, share: float = PLATEAU) -> list[float]:
    """Return the places (rad) of a table's values from a ``share`` of the largest on."""
    pieces = load.way(load.values, load.expression)
    if pieces is None:
        return [0.0]
    values = [row[0] for row in pieces.rows] + [pieces.ends[1]]
    low, high = min(values), max(values)
    places = zip((*pieces.starts, pieces.end), values, strict=True)
    return [place for place, value in places if value - low >= share * (high - low)]


def _wrapped(angle: float) -> float:
    """Return an angle between half a turn before and half a turn after 0 (rad)."""
    return (angle + math.pi) % TURN - math.pi
