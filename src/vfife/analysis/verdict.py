"""What a motion is, seen once a turn: periodic, quasi-periodic or chaotic, with the evidence for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import atan2, hypot
from .chaos import Exponent, apart, period, zero_one

Array = NDArray[np.float64]

QUASI, CHAOTIC, UNSETTLED, DIVERGED = "quasi-periodic", "chaotic", "not settled", "diverged"
UNDECIDED = "not decided"  # points repeat although a small difference grows: the one excludes the other
ENOUGH = 100  # points from which the 0-1 test is asked
REGULAR, IRREGULAR = 0.3, 0.7  # what it says of a motion without and with chaos
AGREEING = 2.0  # largest over smallest exponent of two halves of fewer points than that
CURVED = 5.0  # to and fro of the radius along a closed curve, in parts of twice its range
ORDERED = 0.95  # of neighbours along a closed curve whose next points are neighbours in the same sense


@dataclass(frozen=True)
class Rotation:
    """How points go round their middle: ``number`` (turns for each), how much to and fro there is in the radius along angles (``rough``: about 1
    for a closed curve, a share of the number of points for a cloud), and the share of neighbours whose next points are in the same ``order``."""

    number: float
    rough: float
    order: float

    @property
    def closed(self) -> bool:
        """Whether the points lie on one closed curve around their middle and go round it in order, as no chaotic motion does."""
        return self.rough <= CURVED and self.order >= ORDERED


@dataclass(frozen=True)
class Verdict:
    """A motion in a word, ``kind``, and what says so.

    ``distance``: how far points a ``period`` apart are from each other, as a share of the range of all (of the best period where none is within the
    tolerance). ``exponent``: the largest Lyapunov exponent (1/turn); ``zero_one``: the 0-1 test, of at least 100 points; ``rotation``: where points
    go round a middle. None is what was not asked.
    """

    kind: str
    period: int | None
    distance: float
    exponent: Exponent | None = None
    zero_one: float | None = None
    rotation: Rotation | None = None

    @property
    def evidence(self) -> str:
        """What says so, in words."""
        within = f"within {100.0 * self.distance:.2g} % of the range"
        turns = "a turn" if self.period == 1 else f"{self.period} turns"
        said = [f"points {turns} apart lie {within}" if self.period else f"points come back {within} at best, up to 16 turns on"]
        if self.kind == UNDECIDED:
            said = [f"points come back {within}, as those of a periodic motion do, although a small difference grows: try a smaller step"]
        if self.exponent is not None:
            said.append(f"exponent {self.exponent.value:+.3g} per turn ({self.exponent.low:+.3g} and {self.exponent.high:+.3g} in its halves)")
        if self.zero_one is not None:
            said.append(f"0-1 test {self.zero_one:.2f}")
        if self.rotation is not None and self.rotation.closed:
            said.append(f"one closed curve, gone round {self.rotation.number:.4f} times a turn")
        return ", ".join(said)


def rotation(points: Array) -> Rotation | None:
    """How points go round their mean, shape (points,) or (points, coordinates): by the first two coordinates, or each and the one after it.

    None for fewer than eight.
    """
    points = np.asarray(points, dtype=float)
    points = points.reshape(len(points), -1)
    plane = points[:, :2] if points.shape[1] > 1 else np.column_stack([points[:-1, 0], points[1:, 0]])
    size = np.ptp(plane, axis=0)
    if len(plane) < 8 or not (size > 0.0).all():
        return None
    around = (plane - plane.mean(axis=0)) / size
    angle, radius = atan2(around[:, 1], around[:, 0]), hypot(around[:, 0], around[:, 1])
    turned = 2.0 * np.pi
    along, after = radius[np.argsort(angle, kind="stable")], angle[1:][np.argsort(angle[:-1], kind="stable")]
    swing = max(float(np.ptp(along)), 1e-3 * float(along.mean()))
    rough = float(np.abs(np.diff(along)).sum()) / (2.0 * swing)
    order = float((np.mod(np.diff(after), turned) < np.pi).mean())
    return Rotation(float(np.mod(np.diff(angle), turned).mean()) / turned, rough, order)


def verdict(points: Array, found: Exponent | None = None, tolerance: float = 1e-3) -> Verdict:
    """What a motion is whose ``points`` are these, shape (points,) or (points, coordinates), with the exponent, where it is known.

    A period is told where points repeat within ``tolerance`` of their range, three times over, unless a small difference grows more than e-fold in
    each half of the turns: then nothing is decided. What has no period is chaotic where a difference grows so (of fewer than 100 points, about as
    fast in both halves), not settled where it dies as fast or the halves do not agree; in between, the 0-1 test decides, or, of fewer than 100
    points, whether they lie on a closed curve.
    """
    points = np.asarray(points, dtype=float)
    points = points.reshape(len(points), -1)
    if not np.isfinite(points).all():
        return Verdict(DIVERGED, None, float("nan"), found)
    repeats = period(points, tolerance)
    distance = apart(points, repeats)
    # The exponent of a motion that neither attracts nor repels converges to zero as ln(n)/n, so one below 2/n is not known to be positive.
    margin = 0.0 if found is None else 2.0 / max(len(found.running), 2)
    grows = found is not None and found.low > margin
    if repeats is not None:
        return Verdict(UNDECIDED, None, distance, found) if grows else Verdict(f"period {repeats}", repeats, distance, found)
    test = zero_one(points[:, 0]) if len(points) >= ENOUGH else None
    turning = rotation(points)
    if found is not None and grows and (len(points) >= ENOUGH or found.high <= AGREEING * found.low):
        kind = CHAOTIC
    elif found is not None and not (found.high >= -margin and found.low >= -margin and found.value <= margin):
        kind = UNSETTLED
    elif test is None:
        kind = QUASI if turning is not None and turning.closed else UNSETTLED
    else:
        kind = QUASI if test < REGULAR else CHAOTIC if test > IRREGULAR else UNSETTLED
    return Verdict(kind, None, distance, found, test, turning)
