"""Largest forces of contacts turn by turn: how much of them is damping, and whether a shock makes them.

A hysteresis law damps in proportion to the rate of penetration over the speed at which the contact began. A
contact that began slowly and is struck while it is closed has a force far beyond its elastic one. The step
does not record the parts of the largest force, but between two outputs it keeps the largest force and the
deepest penetration. The elastic force never exceeds that at the deepest penetration, so the rest of the
largest force is damping at least. Of the earlier turns of a companion that bound uses the deepest penetration
of the turn.

The largest force of a joint without play follows from the motion of the ideal mechanism, and no contact law
changes it. Clearance adds shocks: knocks, which begin a contact, and blows in closed contact. Where one
raises the largest force of a turn far above that of the ideal joint, the law decides the force: its stiffness
how hard the shock is, its damping how fast the next one. The mechanism passes the shock on: to other joints,
and to the driver. Their largest loads lie in the same interval between two outputs as the shock.

Turns that do not repeat have other forces, and a single turn represents none of the others. All turns of the
measures are therefore counted, of the run and of its companions.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..laws import ContactLaw
from ..model.surfaces import surfaces
from ..solvers.record import Record
from ..solvers.repeating import turn_grid
from .error_ranges import sound_companions
from .forces import joint_force_max, joint_rows
from .repetition import Turns
from .turns import last_turn, record_of_companion

Array = NDArray[np.float64]

# Share of a largest force from which on it is called mostly damping.
MOSTLY = 0.5
# Times the largest force of the ideal joint. Models of the gallery whose forces depend on damped laws by less
# than a few per cent stay below 1.13.
RAISED = 1.25
# Times the largest ideal force of a joint with shocks from which on its force is part of one, and times the
# ideal value from which on such a shock makes a load.
SHOCK_RATIO, LOAD_RATIO = 1.05, 1.1
# Share of the largest force, or of the largest moment or torque, below which another is left out.
LEAST_LOAD = 1e-3
BLOCKS = "contact_force_squared_max", "contact_penetration_max"
ONSET_BLOCKS = "contact_slowness", "contact_onsets"


class TurnLane(NamedTuple):
    """Outputs of ``turns`` of a run (``lane`` 0) or of a companion, in a ``record``."""

    lane: int
    record: Record
    turns: tuple[slice, ...]


def windows(record: Record, motion: Turns | None) -> Iterator[slice]:
    """Yield the outputs of each turn that measures are of."""
    grid = turn_grid(record.assembly)
    if motion is not None and motion.has_several and grid is not None:
        for turn in range(motion.first, motion.last + 1):
            yield slice(grid.end(turn - 1) + 1, grid.end(turn) + 1)
    else:
        rows = np.flatnonzero(last_turn(record))
        yield slice(int(rows[0]), int(rows[-1]) + 1)


def turn_lanes(record: Record, motion: Turns | None) -> Iterator[TurnLane]:
    """Yield the turns of the run and then those of its companions with finite numbers.

    A companion keeps the outputs of its last turn. Of each turn before it keeps one row with the largest
    value of every extreme; these need not belong to the same moment.
    """
    yield TurnLane(0, record, tuple(windows(record, motion)))
    for lane, k in enumerate(sound_companions(record), 1):
        last = record_of_companion(record, k)
        outputs = slice(1, len(last.steps))
        if record.companions is None or motion is None or not motion.has_several:
            yield TurnLane(lane, last, (outputs,))
            continue
        rows = record.companions.turns[motion.first - 1 : motion.last, :, k]
        if _ends_with(record, motion.last):
            rows = rows[:-1]
            yield TurnLane(lane, last, (outputs,))
        steps = np.arange(len(rows), dtype=np.int64)
        turns = dataclasses.replace(last, steps=steps, source=rows, final=None)
        yield TurnLane(lane, turns, tuple(slice(turn, turn + 1) for turn in range(len(rows))))


def _ends_with(record: Record, turn: int) -> bool:
    """Return whether a run ends with the end of a turn."""
    grid = turn_grid(record.assembly)
    return grid is not None and grid.end(turn) == len(record.steps) - 1


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
        if not (elastic > 0.0 and self.factor > 0.0):
            return math.nan
        return (force / elastic - 1.0) / self.factor


class Extremes(NamedTuple):
    """Recorded values of all contacts, shape (outputs, contacts) each: ``squares`` of the largest forces
    (N^2), largest penetrations ``depths`` (m), ``slowness`` of the last onset (s/m), number of ``onsets``;
    None where they are not recorded.
    """

    squares: Array
    depths: Array
    slowness: Array | None
    onsets: Array | None


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
                    largest[name] = max(largest.get(name, peak), peak, key=lambda p: p.force)
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


@dataclass(frozen=True)
class RaisedPeaks:
    """Number of ``turns`` of the run and its companions, and of those whose force is ``raised``."""

    raised: int
    turns: int


def raised_peaks(
    record: Record, reference: Mapping[str, float], motion: Turns | None, ratio: float = RAISED
) -> dict[str, RaisedPeaks]:
    """Count the turns in which the largest force of a joint with clearance exceeds ``ratio`` times that of
    the ideal joint, one of the measures ``reference``; joints that the ideal mechanism lacks are left out.
    """
    if record.static or not record.assembly.contacts or not all(record.keeps(block) for block in BLOCKS):
        return {}
    raised, turns = dict[str, int](), 0
    for _, part, windows in turn_lanes(record, motion):
        forces, turns = joint_force_max(part), turns + len(windows)
        for k, (name, (block, _)) in enumerate(joint_rows(part).items()):
            ideal = reference.get(f"{name}.force.max")
            if block == "contact" and ideal is not None:
                count = sum(float(forces[rows, k].max()) > ratio * ideal for rows in windows)
                raised[name] = raised.get(name, 0) + count
    return {name: RaisedPeaks(count, turns) for name, count in raised.items()}


def shock_loads(
    record: Record, reference: Mapping[str, float], motion: Turns | None, sources: Collection[str]
) -> dict[str, RaisedPeaks]:
    """Count for each largest load (``.force.max``, ``.moment.max`` and ``.torque.max``) but the forces of
    ``sources`` the turns in which a shock in one of these joints makes it.

    That is a turn in which the load exceeds :data:`LOAD_RATIO` times its ideal value, one of the measures
    ``reference``, in the same interval between outputs as a shock in a source, or in the one next to it.
    There, the force of the source exceeds :data:`SHOCK_RATIO` times its ideal value, or is the largest of the
    turn. Turns of companions without outputs are not counted. Loads below :data:`LEAST_LOAD` of the largest
    of their kind are left out.
    """
    raised, turns = dict[str, int](), 0
    for _, part, windows in turn_lanes(record, motion):
        loads = peak_columns(part)
        for rows in windows:
            if rows.stop - rows.start < 2:
                continue
            turns += 1
            shocks = _shock_intervals(loads, reference, [f"{name}.force.max" for name in sources], rows)
            floors = _floors(loads, rows)
            for name, column in loads.items():
                if name.removesuffix(".force.max") in sources:
                    continue
                row = int(np.argmax(column[rows]))
                peak, limit = float(column[rows][row]), LOAD_RATIO * reference.get(name, 0.0)
                raised[name] = raised.get(name, 0) + bool(peak > max(limit, floors[name]) and shocks[row])
    return {name: RaisedPeaks(count, turns) for name, count in raised.items()}


def peak_columns(record: Record) -> dict[str, Array]:
    """Return the largest forces of joints (N), moments of ideal joints and torques of driven bodies (N m) in
    the interval up to each output, shape (outputs,) each, by the name of the measure.
    """
    forces = joint_force_max(record)
    columns = {f"{name}.force.max": forces[:, k] for k, name in enumerate(joint_rows(record))}
    moments, torques = record.block("joint_moment_max"), record.block("driven_torque_max")
    columns |= {f"{name}.moment.max": moments[:, k] for k, name in enumerate(record.assembly.ideals)}
    bodies = record.assembly.bodies.items()
    driven = {name: body.driven for name, body in bodies if body.driven is not None}
    return columns | {f"{name}.torque.max": torques[:, k] for name, k in driven.items()}


def _floors(loads: Mapping[str, Array], rows: slice) -> dict[str, float]:
    """Return the value of each load in a turn below which it is nothing beside others of its unit."""
    peaks = {name: float(column[rows].max()) for name, column in loads.items()}
    largest = {
        kind: max((peak for name, peak in peaks.items() if name.endswith(".force.max") == kind), default=0.0)
        for kind in (True, False)
    }
    return {name: LEAST_LOAD * largest[name.endswith(".force.max")] for name in peaks}


def _shock_intervals(
    loads: Mapping[str, Array], reference: Mapping[str, float], sources: Iterable[str], rows: slice
) -> NDArray[np.bool_]:
    """Return the intervals of a turn with a shock in one of the ``sources``, or next to one with it."""
    shocks = np.zeros(rows.stop - rows.start, dtype=bool)
    for name in sources:
        force = loads[name][rows]
        shocks |= force >= min(SHOCK_RATIO * reference.get(name, 0.0), float(force.max()))
    around = np.pad(shocks, 1)
    return np.asarray(shocks | around[:-2] | around[2:], dtype=bool)
