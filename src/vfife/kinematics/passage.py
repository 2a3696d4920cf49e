"""The ideal mechanism through the motion that its drivers ask for: where it jams or splits, which joint opens, and which length would do."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.mechanism import Mechanism
from .initial import Motion, ideal_motion
from .nearest import nearest, sensitive, widest
from .opened import FELT, Parted, closing_joint
from .sweep import Follower, Passage
from .ways import TURN, Way, followed, ways_of

Array = NDArray[np.float64]


NEGLIGIBLE = 1e-6  # of the extent of the bodies: a gap that no workshop tells from a change point


@dataclass(frozen=True)
class Jam:
    """Where an ideal mechanism comes to its end: values of the drives (rad, m) and time (s), the joint that opens, how far at most (m), and where.

    ``lengths``: bodies or joints whose length alone, changed to so much (m), would let it through, the smallest change first. ``bodies`` and
    ``joints`` take part.
    """

    aims: tuple[float, ...]
    time: float
    joint: str
    gap: float
    widest: tuple[float, ...]
    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    lengths: tuple[tuple[str, float, float], ...] = ()


@dataclass(frozen=True)
class Singular:
    """A singular position that is passed: values of the drives (rad, m), time (s), the joints that take part."""

    aims: tuple[float, ...]
    time: float
    joints: tuple[str, ...]


def passage(mechanism: Mechanism, duration: float, motion: Motion | None = None, lengths: bool = True) -> tuple[Jam | None, tuple[Singular, ...]]:
    """Follows the ideal mechanism through what its drivers ask for within ``duration`` (s): the jam, if any, and singular positions passed.

    ``lengths``: also look for those that would do, which takes its time. Only where drivers determine all that joints feel, and of up to some 30
    bodies; nothing is said of others. AssemblyError where it cannot start.
    """
    motion = ideal_motion(mechanism) if motion is None else motion
    system = motion.system
    if not system.drives or closing_joint(system) is None:
        return None, ()
    start = motion.position * (1.0, motion.hand, motion.hand)
    follower = Follower.of(system, start)
    if follower is None:
        return None, ()
    passed: dict[tuple[float, ...], Singular] = {}
    for way in ways_of(mechanism, motion, duration):
        found = followed(follower, start, way)
        for place, stress in found.singular:
            one = Singular(told(motion, way.aims(place)), way.time(place), names(motion, stress))
            passed.setdefault(tuple(round(value % TURN, 3) for value in one.aims), one)
        if found.jammed and found.stressed is not None:
            joint = closing_joint(system, found.stressed)
            gap = None if joint is None else widest(follower, joint, way, found)
            if gap is not None and gap[0] <= NEGLIGIBLE * follower.extent:
                aims = told(motion, way.aims(found.reached))
                return None, (*passed.values(), Singular(aims, way.time(found.reached), names(motion, found.stressed)))
            return _jam(mechanism, motion, way, found, joint, gap, duration if lengths else 0.0), tuple(passed.values())
    return None, tuple(passed.values())


def told(motion: Motion, aims: Array) -> tuple[float, ...]:
    """Values of the drives in the mechanism, not in its mirror image."""
    return tuple(float(value) * (motion.hand if drive.turns else 1.0) for value, drive in zip(aims, motion.system.drives, strict=True))


def names(motion: Motion, stress: Array) -> tuple[str, ...]:
    """Joints that take part in a self-stress."""
    system = motion.system
    return tuple(one.name for k, one in enumerate(system.joints) if stress[system.rows(k)].max(initial=0.0) > FELT)


def _jam(
    mechanism: Mechanism,
    motion: Motion,
    way: Way,
    found: Passage,
    joint: int | None,
    widest_gap: tuple[float, float, Parted] | None,
    duration: float,
) -> Jam:
    system, stress = motion.system, np.zeros(0) if found.stressed is None else found.stressed
    part = names(motion, stress)
    bodies = {system.names[body] for one in system.joints if one.name in part for body in (one.body_a, one.body_b)} - {"ground"}
    here = told(motion, way.aims(found.reached))
    if joint is None or widest_gap is None:
        return Jam(here, way.time(found.reached), ", ".join(part), math.nan, here, tuple(sorted(bodies)), part)
    gap, place, opened = widest_gap
    jam = Jam(
        here, way.time(found.reached), system.joints[joint].name, gap, told(motion, way.aims(place)),
        tuple(name for name in mechanism.bodies if name in bodies), part,
    )  # fmt: skip
    if not duration:
        return jam
    lengths = sensitive(mechanism, motion.datum, motion.hand, joint, way.aims(place), opened, jam.bodies, jam.joints)
    return dataclasses.replace(jam, lengths=nearest(mechanism, lengths, gap, duration))
