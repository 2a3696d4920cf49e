"""Blows in closed contact: how far the force of a joint rises above that of the ideal joint while no contact
begins.

An impact is a contact that begins. A journal that slides along the wall of its bearing may be thrown against
the other side without losing contact: the force rises as in an impact, but no impact counts it. The force of
an impact may be largest some outputs after its contact began: that rise, and the fall after it, are no blow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Record
from ..solvers.repeating import outputs_of_a_turn
from .forces import joint_force_max, joint_rows
from .repetition import Turns
from .turn_peaks import windows

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# An impact is over where the force of its contact falls below this share of its largest since the onset, and
# then rises to so many times the smallest since: the journal lands, and is thrown while it touches.
FALL, RISE = 0.99, 2.0


@dataclass(frozen=True)
class Blow:
    """The largest rise of a joint's force above that of the ideal joint between two outputs in which none of
    its contacts began, and whose largest force is not that of an impact before: ``excess`` (N), the largest
    of the turns of the measures; ``lowest`` (N), the smallest of the largest of each turn; ``row``, the
    output at its end.
    """

    excess: float
    lowest: float
    row: int


def blows(record: Record, reference: Record | None, motion: Turns | None) -> dict[str, Blow]:
    """Return the blow of each joint with clearance; none without turns, or without the ideal mechanism.

    The ideal force is the largest of three intervals between outputs, so that a steep force that comes a
    little earlier or later is no blow.
    """
    rows, outputs = joint_rows(record), outputs_of_a_turn(record.assembly)
    ideal = None if reference is None else _ideal_turns(reference, outputs)
    if ideal is None or outputs is None or record.static or not record.keeps("contact_onsets"):
        return {}
    forces, onsets = joint_force_max(record), record.block("contact_onsets")
    began = np.diff(onsets, axis=0, prepend=0.0) > 0.0
    joints = dict[str, Blow]()
    for k, (name, (block, places)) in enumerate(rows.items()):
        if block != "contact" or name not in ideal:
            continue
        force, quiet = ideal[name], ~began[:, places].any(axis=1) & ~_in_impact(record, began, places)
        around = np.maximum(force, np.maximum(np.roll(force, 1), np.roll(force, -1)))
        excess = np.where(quiet, forces[:, k] - around[(np.arange(len(forces)) - 1) % len(around)], 0.0)
        turns = [part.start + int(np.argmax(excess[part])) for part in windows(record, motion)]
        row = max(turns, key=excess.__getitem__)
        joints[name] = Blow(float(excess[row]), float(min(excess[turn] for turn in turns)), row)
    return joints


def _in_impact(record: Record, began: Mask, places: list[int]) -> Mask:
    """Return whether the contact of a joint with the largest force up to each output is still in the impact
    with which it began, shape (outputs,).
    """
    forces = np.sqrt(record.block("contact_force_squared_max")[:, places])
    touching = record.block("contact_penetration")[:, places] > 0.0
    impacts = [impact_rows(forces[:, k], began[:, place], touching[:, k]) for k, place in enumerate(places)]
    return np.asarray(np.stack(impacts)[forces.argmax(axis=1), np.arange(len(forces))], dtype=bool)


def impact_rows(force: Array, began: Mask, touching: Mask) -> Mask:
    """Return at which outputs a contact is in an impact, shape (outputs,): from each onset until the largest
    ``force`` (N) of an interval falls and rises again (:data:`FALL`, :data:`RISE`).

    The force up to the output after an onset may be of the contact before, where the surfaces were
    ``touching`` at the output before.
    """
    rows, inside = np.flatnonzero(began).tolist(), began.copy()
    for start, end in zip(rows, [*rows, len(force)][1:], strict=True):
        course = force[start:end].copy()
        if start > 0 and touching[start - 1]:
            course[0] = 0.0
        fallen = course < FALL * np.maximum.accumulate(course)
        first = int(fallen.argmax()) if fallen.any() else len(course)
        low = np.minimum.accumulate(course[first:])
        risen = (course[first:] > 0.0) & (course[first:] >= RISE * low)
        inside[start : start + first + (int(risen.argmax()) if risen.any() else len(low))] = True
    return inside


def _ideal_turns(reference: Record, outputs: int | None) -> dict[str, Array] | None:
    """Return the largest force (N) of each ideal joint between the ``outputs`` of all full turns of the ideal
    mechanism: of one, which repeats, or of those of the run. None where it has other outputs, or no turn.
    """
    if outputs is None or reference.static or outputs_of_a_turn(reference.assembly) != outputs:
        return None
    turns = (len(reference.steps) - 1) // outputs
    if turns == 0:
        return None
    forces = joint_force_max(reference)[1 : turns * outputs + 1]
    return {name: forces[:, k] for k, name in enumerate(joint_rows(reference))}
