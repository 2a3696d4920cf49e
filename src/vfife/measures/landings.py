"""Landings: those of the turns of the measures, those of the fall at the start, whose blow may be the largest
force, and contacts that never end, whose law remembers the speed of a landing of long ago.

A hysteresis factor divides by the speed at the onset of a contact until it ends. Where a journal never leaves
its bearing in the turns of the measures, that speed belongs to the start of the run.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..model.surfaces import surfaces
from ..solvers.record import Record
from ..solvers.repeating import turn_grid
from .catalogue import FORCES, UNITS, over_turn
from .contacts import knock_speeds
from .repetition import Turns
from .turns import last_turn, of_window

# Share of an interval of outputs that a lasting contact may miss by rounding.
ROUNDING = 1e-6
SLOW, FAST = 0.01, 1.0  # impact speeds (m/s) at which the damping of a law is compared
FREE = 0.5  # of a clearance: a journal that starts further from every surface falls
REBOUNDS = 10  # times the time of the fall, in which its blows and those of rebounds lie
LONGEST_FALL = 0.25  # of the run, in which the fall ends; forces of its second half are compared
SHORTEST_FALL = 3  # times the time of the fall, which it may last in a short run
SMALL = 0.01  # of the largest value of the same kind: smaller ones decide nothing
FORCE_ENDINGS = tuple(f".{ending}" for ending, unit in UNITS.items() if unit in ("N", "N m"))
RAISED = 1.05  # times the forces of later and of the ideal mechanism: a blow of the fall is larger


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


@dataclass(frozen=True)
class Fall:
    """Largest forces and torques of a run that are those of its start: the ``joints`` whose journals fall
    onto their bearings, the ``time`` (s) up to which these values occur, and their names, ``measures``.
    """

    joints: tuple[str, ...]
    time: float
    measures: tuple[str, ...]


def start_fall(record: Record, ideal: Mapping[str, float], motion: Turns | None = None) -> Fall | None:
    """Return the fall of the journals at the start of a run, if it makes the largest forces and torques of
    its measures; None for others, and for one body in its bearing, whose fall is what is simulated.

    A journal falls if it starts free, further than half the clearance from every surface. Its blows are those
    until ten times the time in which the last journal lands, in the first quarter of the run. They are the
    largest if they exceed the ``ideal`` values, those before any journal lands, and those of the second half
    of the run.
    """
    mechanism, blocks = record.assembly.mechanism, ("contact_onsets", "contact_penetration")
    if record.static or not all(map(record.keeps, blocks)):
        return None
    alone = len(mechanism.bodies) == 1 and not mechanism.drivers
    if len(record.steps) < 2 or record.steps[0] != 0 or alone or (motion is not None and motion.has_several):
        return None
    falling = _falling(record)
    count = _outputs_of_fall(record, falling) if falling else 0
    if not count or not last_turn(record)[1]:
        return None
    outputs = np.arange(len(record.steps))
    of_run, fall = over_turn(record, outputs > 0, FORCES), _forces_until(record, count)
    free = (record.block("contact_onsets") == 0.0).all(axis=1)
    usual = over_turn(record, free | (outputs > max(0.5 * outputs[-1], count)), FORCES)
    names = [
        name for name, value in fall.items()
        if value >= of_run[name] and value > RAISED * max(usual.get(name, 0.0), ideal.get(name) or 0.0)
        if value > SMALL * max(size for key, size in of_run.items() if _alike(name, key))
    ]  # fmt: skip
    if not names:
        return None
    ends = range(1, count + 1)
    last = ends[bisect_left(ends, True, key=lambda end: _reaches(_forces_until(record, end), fall, names))]
    return Fall(tuple(falling), float(record.steps[last] * record.assembly.choice.step), tuple(names))


def _forces_until(record: Record, end: int) -> dict[str, float]:
    """Return the largest forces and torques up to the output ``end``."""
    window = (np.arange(len(record.steps)) > 0) & (np.arange(len(record.steps)) <= end)
    forces = over_turn(record, window, FORCES)
    return {name: value for name, value in forces.items() if name.endswith(FORCE_ENDINGS)}


def _alike(name: str, key: str) -> bool:
    """Return whether two names are those of measures with one ending of FORCE_ENDINGS."""
    return any(name.endswith(ending) and key.endswith(ending) for ending in FORCE_ENDINGS)


def _reaches(values: Mapping[str, float], largest: Mapping[str, float], names: Sequence[str]) -> bool:
    return all(values.get(name, 0.0) >= largest[name] for name in names)


def _falling(record: Record) -> list[str]:
    """Return the joints whose journals start free and land in the run."""
    contacts, joints = record.assembly.contacts, record.assembly.contact_joints
    mechanism, names = record.assembly.mechanism, list[str]()
    depths, onsets = record.block("contact_penetration")[0], record.block("contact_onsets")[-1]
    for name in dict.fromkeys(joints):
        clearance = getattr(mechanism.contacts[name], "clearance", None)
        touches = [k for k in range(len(contacts)) if joints[k] == name]
        free = clearance is not None and max(depths[k] for k in touches) < -FREE * clearance
        if free and max(onsets[k] for k in touches) > 0.0:
            names.append(name)
    return names


def _outputs_of_fall(record: Record, falling: Sequence[str]) -> int:
    """Return the number of outputs after the start in which journals fall and rebound."""
    joints, onsets = record.assembly.contact_joints, record.block("contact_onsets")
    # A block in a guide lands with any of its corners.
    landed = [
        (onsets[:, [k for k, joint in enumerate(joints) if joint == name]] > 0.0).any(axis=1)
        for name in falling
    ]
    outputs, first = len(onsets), int(np.flatnonzero(np.all(landed, axis=0))[0])
    return int(min(REBOUNDS * first, max(LONGEST_FALL * outputs, SHORTEST_FALL * first), outputs - 1))


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
    """Return the joints in contact all the last turn, without a landing in it, by a law that depends on the
    speed of the landing; that of a journal that starts seated is the floor of its impact speed.
    """
    assembly = record.assembly
    if not assembly.contacts or not (record.keeps("contact_onsets") and record.keeps("contact_duration")):
        return []
    part = of_window(record, last_turn(record)).record
    if len(part.steps) < 2:
        return []
    onsets = part.block("contact_onsets")
    stays = onsets[-1] == onsets[0]
    interval = np.diff(part.steps)[:, None] * assembly.choice.step
    lasts = (np.diff(part.block("contact_duration"), axis=0) >= (1.0 - ROUNDING) * interval).all(axis=0)
    names = zip(assembly.contact_joints, stays & lasts, strict=True)
    return [
        name for name in dict.fromkeys(name for name, closed in names if closed) if remembers(record, name)
    ]


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
