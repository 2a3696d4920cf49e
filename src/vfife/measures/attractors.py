"""Attractors: motions from several starts, grouped by their kind and their points once a turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .chaos import Verdict

Array = NDArray[np.float64]
ALIKE_POINTS = 0.01  # share of the range of all points within which two periodic motions are one


@dataclass(frozen=True)
class Attractor:
    """A motion that ``members`` reached: its ``kind``, and its ``points`` if it is periodic, shape (period,
    coordinates).
    """

    kind: str
    points: Array
    members: tuple[int, ...]


def attractors(
    points: Sequence[Array | None], verdicts: Sequence[Verdict | None], alike: float = ALIKE_POINTS
) -> list[Attractor]:
    """Group motions into attractors, the one with most members first; members without points belong to none.

    Periodic motions are one if their points are equal within ``alike`` of the range of all points, wherever
    in the period they begin. All chaotic motions are one attractor here, and all quasi-periodic ones, because
    their points do not repeat.
    """
    classified = [
        (k, points_of_start, judgement)
        for k, (points_of_start, judgement) in enumerate(zip(points, verdicts, strict=True))
        if points_of_start is not None and judgement is not None
    ]
    finite = [orbit for _, orbit, _ in classified if np.isfinite(orbit).all()]
    size = alike * np.maximum(np.ptp(np.concatenate(finite), axis=0), 1e-300) if finite else np.ones(1)
    groups: list[Attractor] = []
    for k, orbit, judgement in classified:
        turn = orbit[-judgement.period :] if judgement.period else np.zeros((0, orbit.shape[1]))
        for g, group in enumerate(groups):
            if group.kind == judgement.kind and (
                judgement.period is None or equal_periods(group.points, turn, size)
            ):
                groups[g] = Attractor(group.kind, group.points, (*group.members, k))
                break
        else:
            groups.append(Attractor(judgement.kind, turn, (k,)))
    return sorted(groups, key=lambda group: -len(group.members))


def equal_periods(first: Array, second: Array, size: Array) -> bool:
    """Return whether two periods have the same points, wherever they begin."""
    return any((np.abs(np.roll(second, shift, axis=0) - first) <= size).all() for shift in range(len(first)))
