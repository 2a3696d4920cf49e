"""Attractors: which motions of a grid of starts are the same, and whether a repetition with another step
reaches the same motion.

The onset of a contact lies elsewhere in its step each time, so the points of one motion differ a little from
start to start. Points are therefore compared with the range of the motion within a turn, not with the range
of all points: with a single attractor that is the scatter itself. How far they may differ is the error of the
step, which repetitions with other steps show.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .chaos import CHAOTIC, DIVERGED, Verdict
from .trend import EQUAL

Array = NDArray[np.float64]
# Largest share of the range of a motion within which the points of two motions are equal: the largest scatter
# of points due to the step with which a motion is still called periodic (measures.chaos.SCATTER). It is used
# where the error of the step is not known.
ALIKE_POINTS = 0.01
# Smallest such share: points of one motion repeat within it.
SMALLEST_SHARE = 1e-3
# Ratio of the share to the median change of the points with another step, or to their scatter. Differences of
# two starts were up to 2.5 times the median change in pendulums with a stop.
STEP_WIDTHS = 4.0
# A motion that comes to rest has no range: its points are compared with this share of the range of the points
# of all periodic motions, as points of one motion are with the range of its own.
REST_SHARE = 1e-3
# Motions that never count as a periodic one, wherever their points lie.
IRREGULAR_KINDS = (CHAOTIC, DIVERGED)


@dataclass(frozen=True)
class Attractor:
    """A motion that ``members`` reached: its ``kind``, its ``points`` if it is periodic, shape (period,
    coordinates), and the ``tolerance`` within which points of other motions equal them, shape (coordinates,).
    """

    kind: str
    points: Array
    members: tuple[int, ...]
    tolerance: Array | None = None

    def holds(self, points: Array, kind: str) -> bool:
        """Return whether ``points``, one a turn, of a ``kind`` of motion are those of this periodic one."""
        if kind in IRREGULAR_KINDS or not len(self.points) or self.tolerance is None:
            return False
        return deviation(points, self.points, self.tolerance) <= 1.0


def period_of(kind: str) -> int:
    """Return the period of a kind of motion in turns; 0 if it has none."""
    return int(kind.removeprefix("period ")) if kind.startswith("period ") else 0


def deviation(points: Array, orbit: Array, size: Array) -> float:
    """Return the largest difference (1, of ``size``) of ``points``, one a turn, shape (turns, coordinates),
    from the ``orbit``, the points of a periodic motion, shape (period, coordinates), in their order, from
    where in the period it is least.
    """
    turns = np.arange(len(points))
    return min(
        float((np.abs(points - orbit[(turns + shift) % len(orbit)]) / size).max())
        for shift in range(len(orbit))
    )


def step_share(changes: Sequence[float]) -> float:
    """Return the share of the range of a motion within which points are equal, from the ``changes`` of points
    with other steps (1, of that range); a repetition that reaches another motion does not decide it.
    """
    if not changes:
        return ALIKE_POINTS
    return min(ALIKE_POINTS, max(SMALLEST_SHARE, STEP_WIDTHS * float(np.median(changes))))


def change(first: tuple[str, Array], second: tuple[str, Array], ranges: Array) -> float | None:
    """Return the difference of two motions (1, of ``ranges``), each its kind and its points, shape (turns,
    coordinates); None if none of them is periodic, or one is chaotic or has diverged.
    """
    if first[0] in IRREGULAR_KINDS or second[0] in IRREGULAR_KINDS:
        return None
    size = tolerance_of(first[1], ranges, 1.0)
    return min(
        (
            deviation(points, orbit[-period:], size)
            for (kind, orbit), (_, points) in ((first, second), (second, first))
            if (period := period_of(kind))
        ),
        default=None,
    )


def tolerance_of(points: Array, ranges: Array, alike: float = ALIKE_POINTS) -> Array:
    """Return the difference below which points of two motions are equal, shape (coordinates,): the share
    ``alike`` of the range of the motion, or the rounding of its ``points``; NaN if they are not finite.
    ``ranges``: its range in a turn.
    """
    if not np.isfinite(points).all():
        return np.full(points.shape[1], np.nan)
    size = np.maximum(np.maximum(ranges, np.ptp(points, axis=0)), 1e-200)
    return np.asarray(np.maximum(alike * size, EQUAL * np.abs(points).max(axis=0)))


def same_motion(first: tuple[str, Array], second: tuple[str, Array], tolerance: Array) -> bool:
    """Return whether two motions, each its kind and its points, shape (turns, coordinates), are the same.

    One is periodic and all points of the other lie within ``tolerance`` of its points; or none is periodic
    and their kinds are the same.
    """
    periods = [period_of(kind) for kind, _ in (first, second)]
    if not any(periods):
        return first[0] == second[0]
    return any(
        period > 0
        and motion[0] not in IRREGULAR_KINDS
        and deviation(motion[1], orbit[-period:], tolerance) <= 1.0
        for period, (_, orbit), motion in zip(periods, (first, second), (second, first), strict=True)
    )


def attractors(
    points: Sequence[Array | None],
    verdicts: Sequence[Verdict | None],
    alike: float = ALIKE_POINTS,
    ranges: Sequence[Array | None] | None = None,
) -> list[Attractor]:
    """Group motions into attractors, the one with most members first; members without points belong to none.

    Periodic motions are one if their points are equal within ``alike`` of the range of the motion, wherever
    in the period they begin. ``ranges`` are those of the coordinates of each motion within a turn; unless
    given, the range of the points of all motions takes their place; points that scatter have four times
    their scatter, up to :data:`ALIKE_POINTS`. A motion of another period, or one that
    is not settled, not decided or quasi-periodic, belongs to a periodic motion if all its points lie within
    the same distance. All chaotic motions are one attractor here, and all others of one kind, because their
    points do not repeat.
    """
    motions = {
        k: (orbit, judgement)
        for k, (orbit, judgement) in enumerate(zip(points, verdicts, strict=True))
        if orbit is not None and judgement is not None
    }
    smallest = _least_tolerance(motions, alike, ranges is None)
    groups: list[Attractor] = []
    for k, (orbit, judgement) in motions.items():
        turn = orbit[-judgement.period :] if judgement.period else np.zeros((0, orbit.shape[1]))
        for g, group in enumerate(groups):
            if group.kind == judgement.kind and (not judgement.period or group.holds(turn, judgement.kind)):
                groups[g] = replace(group, members=(*group.members, k))
                break
        else:
            tolerance = smallest if judgement.period else None
            if judgement.period and ranges is not None and (motion_range := ranges[k]) is not None:
                scatter = STEP_WIDTHS * np.nan_to_num(judgement.scatter)
                share = alike if math.isinf(alike) else max(alike, min(ALIKE_POINTS, scatter))
                tolerance = np.maximum(tolerance_of(orbit, motion_range, share), smallest)
            groups.append(Attractor(judgement.kind, turn, (k,), tolerance))
    groups.sort(key=lambda group: -len(group.members))
    return groups if math.isinf(alike) else _merged(groups, motions)


def _least_tolerance(motions: dict[int, tuple[Array, Verdict]], alike: float, of_all: bool) -> Array:
    """Return the share of the range of all finite points, or of those of periodic motions, that is the least
    tolerance, shape (coordinates,).
    """
    counted = [
        orbit for orbit, motion in motions.values() if np.isfinite(orbit).all() and (of_all or motion.period)
    ]
    if not counted:
        return np.asarray(alike)
    share = alike if of_all else min(alike, REST_SHARE)
    return np.asarray(share * np.maximum(np.ptp(np.concatenate(counted), axis=0), 1e-200))


def is_attracting(motions: Sequence[Verdict]) -> bool:
    """Return whether a small difference decays over all turns of one of some ``motions``, or is not known in
    one. A difference that rotates need not decay in both halves of the turns.
    """
    exponents = [motion.exponent for motion in motions]
    return any(
        growth is None or math.isnan(growth.value) or growth.value < -growth.margin for growth in exponents
    )


def _merged(groups: list[Attractor], motions: dict[int, tuple[Array, Verdict]]) -> list[Attractor]:
    """Return the groups, without the members whose points all lie on the periodic motion of another group: of
    a larger one, if their own motion is periodic.

    A transient may repeat for some turns near an unstable periodic motion: one from which no small difference
    decays gets no further members.
    """
    orbits: list[Attractor] = []
    attracting = list[bool]()
    for group in sorted(groups, key=lambda group: not period_of(group.kind)):
        members = list[int]()
        for k in group.members:
            orbit, judgement = motions[k]
            homes = (
                g for g, home in enumerate(orbits) if attracting[g] and home.holds(orbit, judgement.kind)
            )
            if (place := next(homes, None)) is None:
                members.append(k)
            else:
                orbits[place] = replace(orbits[place], members=tuple(sorted((*orbits[place].members, k))))
        if members:
            orbits.append(replace(group, members=tuple(members)))
            attracting.append(is_attracting([motions[k][1] for k in members]))
    return sorted(orbits, key=lambda group: -len(group.members))
