"""Landings: those of the turns of the measures, and contacts that never end, whose law remembers the speed
of a landing of long ago.

A hysteresis factor divides by the speed at the onset of a contact until it ends. Where a journal never leaves
its bearing in the turns of the measures, that speed belongs to the start of the run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model.surfaces import surfaces
from ..solvers.record import Record
from ..solvers.repeating import turn_grid
from .contacts import knock_speeds
from .repetition import Turns
from .turns import last_turn, of_window

# Share of an interval of outputs that a lasting contact may miss by rounding.
ROUNDING = 1e-6
SLOW, FAST = 0.01, 1.0  # impact speeds (m/s) at which the damping of a law is compared


@dataclass(frozen=True)
class Knocks:
    """Contacts that began in the turns of the measures: their ``count``, the ``speed`` (m/s) of the hardest,
    and whether it is ``hardest`` of the whole run. Else the speed is a mean over those between two outputs.
    ``overlap``: one that began before these turns ended in them.
    """

    count: int
    speed: float
    hardest: bool
    overlap: bool = False


def measured_knocks(record: Record, motion: Turns | None) -> dict[str, Knocks]:
    """Return the knocks of each contact in the turns that measures are of; nothing where runs lack them."""
    blocks = ("contact_onsets", "contact_approach", "contact_fastest")
    if record.static or not record.assembly.contacts or not all(record.keeps(block) for block in blocks):
        return {}
    grid = turn_grid(record.assembly)
    if motion is not None and motion.has_several and grid is not None:
        begin = grid.end(motion.first - 1)
    else:
        begin = max(int(np.flatnonzero(last_turn(record))[0]) - 1, 0)
    window = np.arange(len(record.steps)) > (begin if begin else -1)
    onsets, (speeds, hardest) = record.block("contact_onsets"), knock_speeds(of_window(record, window).record)
    result = {}
    for k, name in enumerate(record.assembly.contacts):
        count = int(onsets[-1, k] - (onsets[begin, k] if begin else 0.0))
        overlap = bool(begin) and overlaps(record, k, begin)
        result[name] = Knocks(count, float(speeds[k]), bool(hardest[k]), overlap)
    return result


def overlaps(record: Record, contact: int, begin: int) -> bool:
    """Return whether a contact is closed at an output and open at a later one; False where that is not
    recorded.
    """
    if not record.keeps("contact_penetration"):
        return False
    depths = record.block("contact_penetration")[begin:, contact]
    return bool(depths[0] > 0.0 >= depths.min())


def lasting_landings(record: Record) -> list[str]:
    """Return the joints that landed once and are in contact all the last turn, by a law that depends on the
    speed of the landing.
    """
    assembly = record.assembly
    if not assembly.contacts or not (record.keeps("contact_onsets") and record.keeps("contact_duration")):
        return []
    part = of_window(record, last_turn(record)).record
    if len(part.steps) < 2:
        return []
    onsets = part.block("contact_onsets")
    landed = (onsets[-1] > 0.0) & (onsets[-1] == onsets[0])
    interval = np.diff(part.steps)[:, None] * assembly.choice.step
    lasts = (np.diff(part.block("contact_duration"), axis=0) >= (1.0 - ROUNDING) * interval).all(axis=0)
    names = zip(assembly.contact_joints, landed & lasts, strict=True)
    return [name for name in dict.fromkeys(name for name, stays in names if stays) if remembers(record, name)]


def remembers(record: Record, name: str) -> bool:
    """Return whether the damping of a joint's contact law depends on the speed of the landing."""
    mechanism = record.assembly.mechanism
    joint = mechanism.contacts[name]
    law = joint.contact
    if law.tabled:  # its damping is a factor over the speed too
        return True
    pair = surfaces(mechanism, joint)
    p, depth = law.parameters(pair), float(record.block("contact_penetration_max").max())
    slow, fast = (law.force(max(depth, 1e-9), law.slowness(speed, 0.0), p)[1] for speed in (SLOW, FAST))
    return slow != fast
