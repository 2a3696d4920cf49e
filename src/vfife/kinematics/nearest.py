"""Which single length, next to the one it has, would let a mechanism through that jams or does not close."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..model.bodies import Link
from ..model.joints import Distance
from ..model.mechanism import Mechanism
from .drives import rigid_system
from .forces import Datum
from .gathered import Gathered
from .initial import ideal_motion
from .linalg import DENSE
from .opened import closing_joint, parted
from .pins import first_guess
from .sweep import Follower, Passage
from .system import mirrored
from .ways import TURN, Way, followed, ways_of

Array = NDArray[np.float64]

FIRST = 5e-3  # of a stride: the first step in which the widest gap is looked for
NARROWINGS = 8
NARROW = 1e-4  # of what is left: the top has been found
TRIES = 6
NUDGE = 1e-4  # of a length, to see what it does to a gap
ASIDE = 1e-3  # of a length, from one with which a mechanism would start in a singular position
DIGITS = 4  # of a length that would do


def unclosed(mechanism: Mechanism, error: AssemblyError, duration: float) -> tuple[tuple[str, float, float], ...]:
    """Lengths (name, now, then; m), each of which alone would close a start in which one joint stays open, and let it through what is asked for."""
    datum = Datum(angle={name: body.angle for name, body in mechanism.bodies.items()})
    system, guess = rigid_system(mechanism, datum=datum, travels=False), first_guess(mechanism)
    joint = next((k for k, one in enumerate(system.joints) if one.name in error.joints), None)
    if joint is None or len(error.gaps) != 1 or 3 * len(guess) > DENSE:
        return ()
    aims = np.array([drive.aim for drive in system.drives])
    position, gap = parted(Gathered(system), joint, aims, guess)
    lengths = sensitive(mechanism, datum, 1.0, joint, aims, position, gap, tuple(mechanism.bodies), tuple(mechanism.joints))
    return nearest(mechanism, lengths, gap, duration)


def nearest(mechanism: Mechanism, lengths: Iterator[tuple[str, float, float]], gap: float, duration: float) -> tuple[tuple[str, float, float], ...]:
    """Of lengths (name, m, change of the gap with it) those that would do: name, now and then (m), the smallest change first."""
    found = [(name, now, then) for name, now, slope in lengths if (then := would_do(mechanism, name, now, gap / -slope, duration)) is not None]
    return tuple(sorted(found, key=lambda one: abs(one[2] / one[1] - 1.0)))


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
    mechanism: Mechanism,
    datum: Datum,
    hand: float,
    joint: int,
    aims: Array,
    position: Array,
    gap: float,
    bodies: tuple[str, ...],
    joints: tuple[str, ...],
) -> Iterator[tuple[str, float, float]]:
    """Links and massless links that take part, their lengths (m), and by how much the widest gap changes with each."""
    lengths = {name: body.length for name in bodies if isinstance(body := mechanism.bodies[name], Link)}
    lengths |= {name: one.length for name in joints if isinstance(one := mechanism.joints.get(name), Distance)}
    for name, length in lengths.items():
        changed = rigid_system(sized(mechanism, name, length * (1.0 + NUDGE)), datum=datum)
        gathered = Gathered(mirrored(changed) if hand < 0.0 else changed)
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
            start = motion.position * (1.0, motion.hand, motion.hand)
            follower = Follower.of(motion.system, start)
        except AssemblyError:
            follower = None
        if follower is None:  # it only just closes at the start, or not yet
            length += math.copysign(ASIDE * now, change)
            continue
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
