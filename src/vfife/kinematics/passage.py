"""The ideal mechanism through the motion that its drivers ask for: where it jams or splits, which joint opens, and which length would do."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..model.bodies import Link
from ..model.joints import Distance
from ..model.mechanism import Mechanism
from .initial import Motion, ideal_motion
from .opened import FELT, closing_joint, parted
from .sweep import Follower, Passage, follow
from .ways import TURN, Way, ways_of

Array = NDArray[np.float64]

MOST_TURNS = 4  # a mechanism may take several to come back
BACK = 1e-6  # of the extent: it has come back
FIRST = 5e-3  # of a stride: the first step in which the widest gap is looked for
NARROWINGS = 8
NARROW = 1e-4  # of what is left: the top has been found
TRIES = 6
NUDGE = 1e-4  # of a length, to see what it does to a gap
DIGITS = 4  # of a length that would do


@dataclass(frozen=True)
class Jam:
    """Where an ideal mechanism comes to its end: values of the drives (rad, m) and time (s), the joint that opens, and how far at most (m), and where.

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


def passage(mechanism: Mechanism, duration: float, motion: Motion | None = None) -> tuple[Jam | None, tuple[Singular, ...]]:
    """Follows the ideal mechanism through what its drivers ask for within ``duration`` (s): the jam, if there is one, and singular positions passed.

    Only where drivers determine all that joints feel, and of up to some 30 bodies; nothing is said of others. AssemblyError where it cannot start.
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
        if found.jammed:
            return _jam(mechanism, motion, follower, way, found, duration), tuple(passed.values())
    return None, tuple(passed.values())


def followed(follower: Follower, start: Array, way: Way) -> Passage:
    """A way to its end, or turn by turn until the mechanism has come back to where it was."""
    if not way.turning or way.length <= TURN:
        return follow(follower, start, way.aims, way.rates, way.length, way.pace)
    here, singular, done = start, [], 0.0
    for _ in range(MOST_TURNS):
        length = min(TURN, way.length - done)
        found = follow(follower, here, lambda s, done=done: way.aims(done + s), way.rates, length, way.pace)  # type: ignore[misc]
        singular += [(done + place, stress) for place, stress in found.singular]
        done, here = done + found.reached, found.position
        off = here - start
        off[:, 2] -= TURN * np.round(off[:, 2] / TURN)
        felt = np.zeros(off.size)
        felt[3 + follower.columns] = (off.ravel() * follower.gathered.reach)[3 + follower.columns]
        if found.reached < length or np.abs(felt).max() <= BACK * follower.extent or done >= way.length * (1.0 - 1e-12):
            return Passage(done, here, found.jammed, found.stressed, tuple(singular))
    return Passage(done, here, False, None, tuple(singular))


def told(motion: Motion, aims: Array) -> tuple[float, ...]:
    """Values of the drives in the mechanism, not in its mirror image."""
    return tuple(float(value) * (motion.hand if drive.turns else 1.0) for value, drive in zip(aims, motion.system.drives, strict=True))


def names(motion: Motion, stress: Array) -> tuple[str, ...]:
    """Joints that take part in a self-stress."""
    system = motion.system
    return tuple(one.name for k, one in enumerate(system.joints) if stress[system.rows(k)].max(initial=0.0) > FELT)


def _jam(mechanism: Mechanism, motion: Motion, follower: Follower, way: Way, found: Passage, duration: float) -> Jam:
    system, stress = motion.system, np.zeros(0) if found.stressed is None else found.stressed
    joint = closing_joint(system, stress)
    part = names(motion, stress)
    bodies = {system.names[body] for one in system.joints if one.name in part for body in (one.body_a, one.body_b)} - {"ground"}
    here = told(motion, way.aims(found.reached))
    if joint is None:
        return Jam(here, way.time(found.reached), ", ".join(part), math.nan, here, tuple(sorted(bodies)), part)
    gap, place, position = widest(follower, joint, way, found)
    jam = Jam(
        here, way.time(found.reached), system.joints[joint].name, gap, told(motion, way.aims(place)),
        tuple(name for name in mechanism.bodies if name in bodies), part,
    )  # fmt: skip
    lengths = [
        (name, now, then)
        for name, now, slope in sensitive(mechanism, motion, joint, way.aims(place), position, gap, jam)
        if (then := would_do(mechanism, name, now, gap / -slope, duration)) is not None
    ]
    return dataclasses.replace(jam, lengths=tuple(sorted(lengths, key=lambda one: abs(one[2] / one[1] - 1.0))))


def widest(follower: Follower, joint: int, way: Way, found: Passage) -> tuple[float, float, Array]:
    """The widest gap (m) of a joint on the rest of a way, as far as it opens at once; its place, and the position there."""
    end = min(way.length, found.reached + TURN) if way.turning else way.length
    stride, seen = FIRST * way.pace, [(0.0, found.reached, found.position)]

    def at(place: float) -> tuple[float, float, Array]:
        position, gap = parted(follower.gathered, joint, way.aims(place), seen[-1][2])
        return gap, place, position

    while seen[-1][1] < end and (len(seen) < 3 or seen[-1][0] >= seen[-2][0]):
        seen.append(at(min(seen[-1][1] + stride, end)))
        stride = min(2.0 * stride, 2.0 * way.pace)
    top = max(range(len(seen)), key=lambda k: seen[k][0])
    if top in (0, len(seen) - 1):
        return seen[top]
    three = seen[top - 1 : top + 2]
    for _ in range(NARROWINGS):  # the top of the parabola through three takes the place of the lowest
        (g, x, _), (g_1, x_1, _), (g_2, x_2, _) = sorted(three, key=lambda one: one[1])
        if not x < x_1 < x_2:
            break
        one, two = (g_1 - g) / (x_1 - x), (g_2 - g_1) / (x_2 - x_1)
        if one <= two:
            break
        place = 0.5 * (x + x_1) + one * 0.5 * (x_2 - x) / (one - two)
        if min(abs(place - known) for known in (x, x_1, x_2)) < NARROW * (x_2 - x):
            break
        three = sorted([*three, at(min(max(place, x), x_2))], key=lambda one: one[0])[1:]
    return max(three, key=lambda one: one[0])


def sized(mechanism: Mechanism, name: str, length: float) -> Mechanism:
    """The mechanism with another length of a link, or of a joint that has one."""
    if name in mechanism.bodies:
        return dataclasses.replace(mechanism, bodies={**mechanism.bodies, name: dataclasses.replace(mechanism.bodies[name], length=length)})  # type: ignore[call-arg]
    return dataclasses.replace(mechanism, joints={**mechanism.joints, name: dataclasses.replace(mechanism.joints[name], length=length)})  # type: ignore[call-arg]


def sensitive(
    mechanism: Mechanism, motion: Motion, joint: int, aims: Array, position: Array, gap: float, jam: Jam
) -> Iterator[tuple[str, float, float]]:
    """Links and massless links that take part, their lengths (m), and by how much the widest gap changes with each."""
    from .drives import rigid_system
    from .gathered import Gathered
    from .system import mirrored

    lengths = {name: body.length for name in jam.bodies if isinstance(body := mechanism.bodies[name], Link)}
    lengths |= {name: one.length for name in jam.joints if isinstance(one := mechanism.joints.get(name), Distance)}
    for name, length in lengths.items():
        changed = rigid_system(sized(mechanism, name, length * (1.0 + NUDGE)), datum=motion.datum)
        gathered = Gathered(mirrored(changed) if motion.hand < 0.0 else changed)
        slope = (parted(gathered, joint, aims, position)[1] - gap) / (NUDGE * length)
        if abs(slope) > 0.1:
            yield name, length, slope


def would_do(mechanism: Mechanism, name: str, now: float, change: float, duration: float) -> float | None:
    """The length (m) next to ``now`` with which the mechanism goes through, first tried at ``now + change``; None where none is found."""
    length = now + change
    for _ in range(TRIES):
        length = rounded(length, change)
        if not 0.2 < length / now < 5.0:
            return None
        other = sized(mechanism, name, length)
        try:
            motion = ideal_motion(other)
        except AssemblyError:
            return None
        start = motion.position * (1.0, motion.hand, motion.hand)
        follower = Follower.of(motion.system, start)
        if follower is None:
            return None
        stuck = None
        for way in ways_of(other, motion, duration):
            found = followed(follower, start, way)
            if found.jammed and found.stressed is not None:
                stuck = way, found
                break
        if stuck is None:
            return length
        joint = closing_joint(motion.system, stuck[1].stressed)
        if joint is None:
            return None
        length += math.copysign(1.05 * widest(follower, joint, *stuck)[0] + 1e-4 * now, change)
    return None


def rounded(length: float, change: float) -> float:
    """The length to four digits, away from where it came from, unless it is as good as those already."""
    unit = 10.0 ** (math.floor(math.log10(abs(length))) - DIGITS + 1) if length > 0.0 else 1.0
    parts = length / unit
    return (math.ceil(parts - 1e-3) if change > 0.0 else math.floor(parts + 1e-3)) * unit
