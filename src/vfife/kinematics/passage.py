"""The ideal mechanism through the motion that its drivers ask for: where it jams or splits, which joint
opens, which single length would do.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..model.bodies import Link
from ..model.mechanism import Mechanism
from ..model.rows import FixedDistance, place_row
from ..numerics.dense import dot
from ..numerics.scalar import integer_power, log10
from .descent import FELT, Parted, closing_joint, parted
from .drives import rigid_system
from .follower import TURN, Follower, Passage, Way, followed, ways_of
from .forces import Datum
from .guess import first_guess
from .initial import Motion, ideal_motion
from .linalg import DENSE
from .system import mirrored

Array = NDArray[np.float64]

FIRST = 5e-3  # of a stride: the first step in which the widest gap is looked for
NARROWINGS = 8
NARROW = 1e-4  # of what is left: the top has been found
TRIES, HALVINGS = 6, 8
NUDGE = 1e-4  # of a length, to see what it does to a gap
SHIFT = 1e-3  # of a length, from one with which a mechanism would start in a singular position
DIGITS = 4  # of a length that would do


def unclosed(
    mechanism: Mechanism, error: AssemblyError, duration: float
) -> tuple[tuple[str, float, float], ...]:
    """Lengths (name, now, then; m), each of which alone would close a start in which one joint stays open,
    and let it through what is asked for.
    """
    datum = Datum(angle={name: body.angle for name, body in mechanism.bodies.items()})
    system, guess = rigid_system(mechanism, datum=datum, travels=False), first_guess(mechanism)
    joint = next((k for k, row in enumerate(system.joints) if row.name in error.joints), None)
    if joint is None or len(error.gaps) != 1 or 3 * len(guess) > DENSE:
        return ()
    aims = system.aims
    opened = parted(system, joint, aims, guess)
    lengths = list(
        sensitive(
            mechanism, datum, 1.0, joint, aims, opened, tuple(mechanism.bodies), tuple(mechanism.joints)
        )
    )
    size = min((length for _, length, _ in lengths), default=0.0)
    return nearest(
        mechanism, lengths, opened.gap + SHIFT * size, duration
    )  # a little more, or the start is a singular position


def nearest(
    mechanism: Mechanism, lengths: Iterable[tuple[str, float, float]], gap: float, duration: float
) -> tuple[tuple[str, float, float], ...]:
    """Of lengths (name, m, change of the gap with it) those that would do: name, now and then (m), the
    smallest change first.
    """
    result = [
        (name, length, sufficient)
        for name, length, slope in lengths
        if (sufficient := would_do(mechanism, name, length, gap / -slope, duration)) is not None
    ]
    return tuple(sorted(result, key=lambda change: abs(change[2] / change[1] - 1.0)))


def widest(follower: Follower, joint: int, way: Way, result: Passage) -> tuple[float, float, Parted]:
    """Find the widest gap (m) of a joint on the rest of the path, up to the end of its first opening; returns
    gap, place and the opened position.
    """
    end = min(way.length, result.reached + TURN) if way.turning else way.length
    stride, samples = (
        FIRST * way.pace,
        [(0.0, result.reached, Parted(result.position, 0.0, np.zeros(follower.system.starts[-1])))],
    )

    def at(place: float) -> tuple[float, float, Parted]:
        opened = parted(follower.system, joint, way.aims(place), samples[-1][2].position)
        return opened.gap, place, opened

    while samples[-1][1] < end and (len(samples) < 3 or samples[-1][0] >= samples[-2][0]):
        samples.append(at(min(samples[-1][1] + stride, end)))
        stride = min(2.0 * stride, 2.0 * way.pace)
    top = max(range(len(samples)), key=lambda k: samples[k][0])
    if top in (0, len(samples) - 1):
        return samples[top]
    top_samples = samples[top - 1 : top + 2]
    for _ in range(NARROWINGS):  # the top of the parabola through three takes the place of the lowest
        (g, x, _), (g_1, x_1, _), (g_2, x_2, _) = sorted(top_samples, key=lambda sample: sample[1])
        if not x < x_1 < x_2:
            break
        slope, next_slope = (g_1 - g) / (x_1 - x), (g_2 - g_1) / (x_2 - x_1)
        if slope <= next_slope:
            break
        place = 0.5 * (x + x_1) + slope * 0.5 * (x_2 - x) / (slope - next_slope)
        if min(abs(place - abscissa) for abscissa in (x, x_1, x_2)) < NARROW * (x_2 - x):
            break
        top_samples = sorted([*top_samples, at(min(max(place, x), x_2))], key=lambda sample: sample[0])[1:]
    return max(top_samples, key=lambda sample: sample[0])


def sized(mechanism: Mechanism, name: str, length: float) -> Mechanism:
    """Return the mechanism with another length of a link, or of a joint that has a length."""
    if name in mechanism.bodies:
        body = dataclasses.replace(mechanism.bodies[name], length=length)  # type: ignore[call-arg]
        return dataclasses.replace(mechanism, bodies={**mechanism.bodies, name: body})
    joint = dataclasses.replace(mechanism.joints[name], length=length)  # type: ignore[call-arg]
    return dataclasses.replace(mechanism, joints={**mechanism.joints, name: joint})


def sensitive(
    mechanism: Mechanism,
    datum: Datum,
    hand: float,
    joint: int,
    aims: Array,
    opened: Parted,
    bodies: tuple[str, ...],
    joints: tuple[str, ...],
) -> Iterator[tuple[str, float, float]]:
    """Links and massless links that take part, their lengths (m), and by how much the widest gap changes with
    each.
    """
    lengths = {name: body.length for name in bodies if isinstance(body := mechanism.bodies[name], Link)}
    for name in joints:
        place = place_row(mechanism.joints[name].rows()) if name in mechanism.joints else None
        lengths |= {name: place.length} if isinstance(place, FixedDistance) else {}
    for name, length in lengths.items():
        systems = [
            rigid_system(sized(mechanism, name, length * (1.0 + part)), datum=datum) for part in (0.0, NUDGE)
        ]
        present, changed = (mirrored(system) if hand < 0.0 else system for system in systems)
        phi = present.dense_rows(opened.position, aims)[0]
        moved = changed.dense_rows(opened.position, aims)[0] - phi
        slope = dot(opened.pulls, moved) / (
            opened.gap * NUDGE * length
        )  # the least gap does not feel that the position would move too
        if abs(slope) > 0.1:
            yield name, length, slope


def would_do(
    mechanism: Mechanism, name: str, original: float, change: float, duration: float
) -> float | None:
    """Search the length (m) nearest to ``now`` with which the mechanism completes its motion, first at ``now
    + change``; None where none is found.
    """
    length, short = original + change, original
    for _ in range(TRIES):
        length = rounded(length, change)
        if not 0.2 < length / original < 5.0:
            return None
        missing = still_open(sized(mechanism, name, length), duration)
        if missing is None:
            return None
        if missing == 0.0:
            return _closer(mechanism, name, short, length, duration)
        short = length
        length += math.copysign(1.05 * missing + 0.1 * SHIFT * original, change)
    return None


def _closer(mechanism: Mechanism, name: str, short: float, sufficient: float, duration: float) -> float:
    """Bisect between a length (m) that jams and a length that does not, to four digits or a few halvings."""
    tried, first = short + 0.98 * (sufficient - short), True
    for _ in range(HALVINGS):
        tried = rounded(tried, sufficient - short)
        if tried in (short, sufficient):
            break
        if gets_through(sized(mechanism, name, tried), duration):
            sufficient = tried
        elif first:  # it goes in a straight line, as in a four-bar
            break
        else:
            short = tried
        tried, first = 0.5 * (short + sufficient), False
    return sufficient


def gets_through(mechanism: Mechanism, duration: float) -> bool:
    """Whether the mechanism closes at the start and all the way: by how much it would stay open takes longer
    to tell.
    """
    return _first_jam(mechanism, duration) == (True, None)


def still_open(mechanism: Mechanism, duration: float) -> float | None:
    """Return the widest gap (m) on the path, 0 where the mechanism completes it; None where it does not close
    at the start, or only just.
    """
    closes, jam = _first_jam(mechanism, duration)
    if jam is None:
        return 0.0 if closes else None
    follower, way, result = jam
    joint = closing_joint(follower.system, result.stressed)
    return None if joint is None else widest(follower, joint, way, result)[0]


def _first_jam(mechanism: Mechanism, duration: float) -> tuple[bool, tuple[Follower, Way, Passage] | None]:
    """Whether it closes at the start, by more than just; and where it jams first, if it does."""
    try:
        motion = ideal_motion(mechanism, named=False)
        start = motion.position * (1.0, motion.hand, motion.hand)
        follower = Follower.of(motion.system, start)
    except AssemblyError:
        follower = None
    if follower is None:
        return False, None
    for way in ways_of(mechanism, motion, duration):
        result = followed(follower, start, way)
        if result.jammed and result.stressed is not None:
            return True, (follower, way, result)
    return True, None


def rounded(length: float, change: float) -> float:
    """Round a length to four digits in the direction of the change, unless it has four digits already."""
    unit = integer_power(10.0, math.floor(log10(abs(length))) - DIGITS + 1) if length > 0.0 else 1.0
    parts = length / unit
    return (math.ceil(parts - 1e-3) if change > 0.0 else math.floor(parts + 1e-3)) * unit


NEGLIGIBLE = 1e-6  # of the extent of the bodies: a gap that no workshop tells from a change point


@dataclass(frozen=True)
class Jam:
    """Where an ideal mechanism comes to its end: values of the drives (rad, m) and time (s), the joint that
    opens, how far at most (m), and where.

    ``lengths``: bodies or joints whose length alone, changed to so much (m), would let it through, the
    smallest change first. ``bodies`` and ``joints`` take part.
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
    """A singular position that is passed: values of the drives (rad, m), time (s), joints that take part."""

    aims: tuple[float, ...]
    time: float
    joints: tuple[str, ...]


def passage(
    mechanism: Mechanism, duration: float, motion: Motion | None = None, lengths: bool = True
) -> tuple[Jam | None, tuple[Singular, ...]]:
    """Follows the ideal mechanism through what its drivers ask for within ``duration`` (s): the jam, if any,
    and singular positions passed.

    ``lengths``: also look for those that would do, which takes its time. Only where drivers determine all
    that joints feel, and of up to some 30 bodies; nothing is said of others. AssemblyError where it cannot
    start.
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
        result = followed(follower, start, way)
        for place, stress in result.singular:
            position = Singular(drive_values(motion, way.aims(place)), way.time(place), names(motion, stress))
            passed.setdefault(tuple(round(value % TURN, 3) for value in position.aims), position)
        if result.jammed and result.stressed is not None:
            joint = closing_joint(system, result.stressed)
            gap = None if joint is None else widest(follower, joint, way, result)
            if gap is not None and gap[0] <= NEGLIGIBLE * follower.extent:
                aims = drive_values(motion, way.aims(result.reached))
                return None, (
                    *passed.values(),
                    Singular(aims, way.time(result.reached), names(motion, result.stressed)),
                )
            return _jam(mechanism, motion, way, result, joint, gap, duration if lengths else 0.0), tuple(
                passed.values()
            )
    return None, tuple(passed.values())


def drive_values(motion: Motion, aims: Array) -> tuple[float, ...]:
    """Values of the drives in the mechanism, not in its mirror image."""
    return tuple(
        float(value) * (motion.hand if drive.turns else 1.0)
        for value, drive in zip(aims, motion.system.drives, strict=True)
    )


def names(motion: Motion, stress: Array) -> tuple[str, ...]:
    """Joints that take part in a self-stress."""
    system = motion.system
    return tuple(
        joint.name for k, joint in enumerate(system.joints) if stress[system.rows(k)].max(initial=0.0) > FELT
    )


def _jam(
    mechanism: Mechanism,
    motion: Motion,
    way: Way,
    result: Passage,
    joint: int | None,
    widest_gap: tuple[float, float, Parted] | None,
    duration: float,
) -> Jam:
    system, stress = motion.system, np.zeros(0) if result.stressed is None else result.stressed
    part = names(motion, stress)
    bodies = {
        system.names[body] for tie in system.joints if tie.name in part for body in (tie.body_a, tie.body_b)
    } - {"ground"}
    drives = drive_values(motion, way.aims(result.reached))
    if joint is None or widest_gap is None:
        return Jam(
            drives, way.time(result.reached), ", ".join(part), math.nan, drives, tuple(sorted(bodies)), part
        )
    gap, place, opened = widest_gap
    jam = Jam(
        drives, way.time(result.reached), system.joints[joint].name, gap,
        drive_values(motion, way.aims(place)), tuple(name for name in mechanism.bodies if name in bodies),
        part,
    )  # fmt: skip
    if not duration:
        return jam
    lengths = sensitive(
        mechanism, motion.datum, motion.hand, joint, way.aims(place), opened, jam.bodies, jam.joints
    )
    return dataclasses.replace(jam, lengths=nearest(mechanism, lengths, gap, duration))
