"""Which of many motions are one and the same: periodic ones by their points, others by what they are in a word."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .verdict import Verdict

Array = NDArray[np.float64]
ALIKE = 0.01  # of the range of all points, within which two periodic motions are one


@dataclass(frozen=True)
class Attractor:
    """A motion to which ``members`` came: its ``kind`` in a word, and where it is periodic its ``points``, shape (period, coordinates)."""

    kind: str
    points: Array
    members: tuple[int, ...]


def attractors(points: Sequence[Array | None], verdicts: Sequence[Verdict | None], alike: float = ALIKE) -> list[Attractor]:
    """The motions that there are, that of most members first; members without points belong to none.

    Periodic motions are one where their points are, wherever in the period they are begun: within a share of the range of all points. What is not
    periodic has no points that come back, so all chaotic motions are one here, and all quasi-periodic ones.
    """
    known = [(k, one, told) for k, (one, told) in enumerate(zip(points, verdicts, strict=True)) if one is not None and told is not None]
    ends = [one for _, one, told in known if np.isfinite(one).all()]
    size = alike * np.maximum(np.ptp(np.concatenate(ends), axis=0), 1e-300) if ends else np.ones(1)
    found: list[tuple[str, Array, list[int]]] = []
    for k, own, told in known:
        turn = own[-told.period :] if told.period else np.zeros((0, own.shape[1]))
        same = next((one for one in found if one[0] == told.kind and (told.period is None or _same(one[1], turn, size))), None)
        if same is None:
            found.append((told.kind, turn, [k]))
        else:
            same[2].append(k)
    return [Attractor(kind, turn, tuple(members)) for kind, turn, members in sorted(found, key=lambda one: -len(one[2]))]


def _same(one: Array, other: Array, size: Array) -> bool:
    """Whether two periods have the same points, begun anywhere."""
    return any((np.abs(np.roll(other, shift, axis=0) - one) <= size).all() for shift in range(len(one)))
