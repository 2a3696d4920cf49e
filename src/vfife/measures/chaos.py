"""What a motion is, from its points once a turn: periods, exponents, the 0-1 test, the verdict in a word, and
which of many motions are one.

All of it takes numbers of any map or section; the oracles of the tests are maps whose answers are known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import atan2, hypot, sincos

Array = NDArray[np.float64]

ALIKE = 1e-5  # of their size, within which two points are one whatever the range of all is
LONGEST = 16  # points of a period that is looked for
ANGLES = 100  # of the 0-1 test
SHARE = 10  # the 0-1 test looks at displacements over up to a tenth of the series


@dataclass(frozen=True)
class Exponent:
    """Largest Lyapunov exponent: mean logarithm of the growth of a small difference in one turn (1/turn),
    with ``low`` and ``high`` of its halves.

    ``running``: the mean after each turn, by which its convergence is seen.
    """

    value: float
    low: float
    high: float
    running: Array


def exponent(growth: Sequence[float] | Array) -> Exponent:
    """From the logarithms of the growth of a tangent in each turn, renormalised after it (Benettin et al.
    1980).
    """
    logs = np.asarray(growth, dtype=float)
    running = np.cumsum(logs) / np.arange(1, len(logs) + 1)
    half = len(logs) // 2
    parts = [float(part.mean()) for part in (logs[:half], logs[half:]) if len(part)]
    return Exponent(float(running[-1]), min(parts), max(parts), running)


def period(points: Array, tolerance: float = 1e-3, longest: int = LONGEST) -> int | None:
    """The least number of points after which they repeat, None where they do not within ``longest``.

    ``points``: shape (points,) or (points, coordinates); two are the same that lie within ``tolerance`` of
    the range of all of them, or
    :data:`ALIKE` of their size: what comes to rest has no range, and the largest force of a turn is known no
    better. A period has to be seen three times.
    """
    points = np.asarray(points, dtype=float).reshape(len(points), -1)
    size = np.maximum(tolerance * np.ptp(points, axis=0), least(points))
    for one in range(1, min(longest, len(points) // 3) + 1):
        if (between(points, one) <= size).all():
            return one
    return None


def least(points: Array) -> Array:
    """By how much coordinates may differ that are the same, shape (coordinates,)."""
    found: Array = ALIKE * np.abs(points).max(axis=0) + 1e-300
    return found


def between(points: Array, shift: int) -> Array:
    """Largest difference of points so many apart among the last three times as many, shape (coordinates,)."""
    last = points[-3 * shift :]
    found: Array = np.abs(last[shift:] - last[:-shift]).max(axis=0)
    return found


def apart(points: Array, shift: int | None = None, longest: int = LONGEST) -> float:
    """How far points so many apart lie from each other, as a share of the range of all; without ``shift`` the
    least of all up to ``longest``.
    """
    points = np.asarray(points, dtype=float).reshape(len(points), -1)
    size = np.maximum(np.ptp(points, axis=0), least(points))
    shifts = range(1, min(longest, len(points) // 3) + 1) if shift is None else (shift,)
    return min((float((between(points, one) / size).max()) for one in shifts), default=float("nan"))


def zero_one(series: Array, seed: int = 0) -> float:
    """The 0-1 test for chaos (Gottwald and Melbourne 2009): near 0 for a regular series, near 1 for a chaotic
    one; shape (points,).

    Of a hundred angles c the median correlation of the mean square displacement of (sum phi cos jc, sum phi
    sin jc) with time, phi being the series less its mean, which would make that displacement oscillate. The
    series has to be sampled so seldom that its points look unrelated: once a turn, not a hundred times.
    """
    phi = np.asarray(series, dtype=float)
    if np.ptp(phi) <= 1e-9 * np.abs(phi).max(initial=0.0):
        return 0.0
    phi = (phi - phi.mean()) / np.ptp(
        phi
    )  # a mean far above what varies would hide it: the oscillating part is its square
    count, most = len(phi), max(2, len(phi) // SHARE)
    j, shifts = np.arange(1, count + 1), np.arange(1, most + 1)
    found = []
    for c in math.pi / 5.0 + 3.0 * math.pi / 5.0 * np.random.default_rng(seed).random(ANGLES):
        s, e = sincos(c * j)
        p, q = np.cumsum(phi * e), np.cumsum(phi * s)
        square = np.array([_ways(p, n, count - most) + _ways(q, n, count - most) for n in range(1, most + 1)])
        found.append(correlation(shifts.astype(float), square))
    return float(np.median(found))


def _ways(series: Array, shift: int, count: int) -> float:
    """Mean square of so many differences of a series over a shift."""
    way = (series[shift:] - series[:-shift])[:count]
    return float((way * way).mean())


def correlation(first: Array, other: Array) -> float:
    """Correlation of two series; 0 where one does not change."""
    a, b = first - first.mean(), other - other.mean()
    size = math.sqrt(float((a * a).sum()) * float((b * b).sum()))
    return float((a * b).sum()) / size if size > 0.0 else 0.0


QUASI, CHAOTIC, UNSETTLED, DIVERGED = "quasi-periodic", "chaotic", "not settled", "diverged"
UNDECIDED = "not decided"  # points repeat although a small difference grows: the one excludes the other
ENOUGH = 100  # points from which the 0-1 test is asked
REGULAR, IRREGULAR = 0.3, 0.7  # what it says of a motion without and with chaos
AGREEING = 2.0  # largest over smallest exponent of two halves of fewer points than that
CURVED = 5.0  # to and fro of the radius along a closed curve, in parts of twice its range
ORDERED = 0.95  # of neighbours along a closed curve whose next points are neighbours in the same sense


@dataclass(frozen=True)
class Rotation:
    """How points go round their middle: ``number`` (turns for each), how much to and fro there is in the
    radius along angles (``rough``: about 1 for a closed curve, a share of the number of points for a cloud),
    and the share of neighbours whose next points are in the same ``order``.
    """

    number: float
    rough: float
    order: float

    @property
    def closed(self) -> bool:
        """Whether the points lie on one closed curve around their middle and go round it in order, as no
        chaotic motion does.
        """
        return self.rough <= CURVED and self.order >= ORDERED


@dataclass(frozen=True)
class Verdict:
    """A motion in a word, ``kind``, and what says so.

    ``distance``: how far points a ``period`` apart are from each other, as a share of the range of all (of
    the best period where none is within the tolerance). ``exponent``: the largest Lyapunov exponent (1/turn);
    ``zero_one``: the 0-1 test, of at least 100 points; ``rotation``: where points go round a middle. None is
    what was not asked.
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
        said = [
            (
                f"points {turns} apart lie {within}"
                if self.period
                else f"points come back {within} at best, up to 16 turns on"
            )
        ]
        if self.kind == UNDECIDED:
            said = [
                f"points come back {within}, as those of a periodic motion do, although a small difference"
                " grows: try a smaller step"
            ]
        if self.exponent is not None:
            said.append(
                f"exponent {self.exponent.value:+.3g} per turn ({self.exponent.low:+.3g} and"
                f" {self.exponent.high:+.3g} in its halves)"
            )
        if self.zero_one is not None:
            said.append(f"0-1 test {self.zero_one:.2f}")
        if self.rotation is not None and self.rotation.closed:
            said.append(f"one closed curve, gone round {self.rotation.number:.4f} times a turn")
        return ", ".join(said)


def rotation(points: Array) -> Rotation | None:
    """How points go round their mean, shape (points,) or (points, coordinates): by the first two coordinates,
    or each and the one after it.

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
    """What a motion is whose ``points`` are these, shape (points,) or (points, coordinates), with the
    exponent, where it is known.

    A period is told where points repeat within ``tolerance`` of their range, three times over, unless a small
    difference grows more than e-fold in each half of the turns: then nothing is decided. What has no period
    is chaotic where a difference grows so (of fewer than 100 points, about as fast in both halves), not
    settled where it dies as fast or the halves do not agree; in between, the 0-1 test decides, or, of fewer
    than 100 points, whether they lie on a closed curve.
    """
    points = np.asarray(points, dtype=float)
    points = points.reshape(len(points), -1)
    if not np.isfinite(points).all():
        return Verdict(DIVERGED, None, float("nan"), found)
    repeats = period(points, tolerance)
    distance = apart(points, repeats)
    # The exponent of a motion that neither attracts nor repels converges to zero as ln(n)/n, so one below 2/n
    # is not known to be positive.
    margin = 0.0 if found is None else 2.0 / max(len(found.running), 2)
    grows = found is not None and found.low > margin
    if repeats is not None:
        return (
            Verdict(UNDECIDED, None, distance, found)
            if grows
            else Verdict(f"period {repeats}", repeats, distance, found)
        )
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


ALIKE_POINTS = 0.01  # of the range of all points, within which two periodic motions are one


@dataclass(frozen=True)
class Attractor:
    """A motion to which ``members`` came: its ``kind`` in a word, and where it is periodic its ``points``,
    shape (period, coordinates).
    """

    kind: str
    points: Array
    members: tuple[int, ...]


def attractors(
    points: Sequence[Array | None], verdicts: Sequence[Verdict | None], alike: float = ALIKE_POINTS
) -> list[Attractor]:
    """The motions that there are, that of most members first; members without points belong to none.

    Periodic motions are one where their points are, wherever in the period they are begun: within a share of
    the range of all points. What is not periodic has no points that come back, so all chaotic motions are one
    here, and all quasi-periodic ones.
    """
    known = [
        (k, one, told)
        for k, (one, told) in enumerate(zip(points, verdicts, strict=True))
        if one is not None and told is not None
    ]
    ends = [one for _, one, told in known if np.isfinite(one).all()]
    size = alike * np.maximum(np.ptp(np.concatenate(ends), axis=0), 1e-300) if ends else np.ones(1)
    found: list[tuple[str, Array, list[int]]] = []
    for k, own, told in known:
        turn = own[-told.period :] if told.period else np.zeros((0, own.shape[1]))
        same = next(
            (
                one
                for one in found
                if one[0] == told.kind and (told.period is None or _same(one[1], turn, size))
            ),
            None,
        )
        if same is None:
            found.append((told.kind, turn, [k]))
        else:
            same[2].append(k)
    return [
        Attractor(kind, turn, tuple(members))
        for kind, turn, members in sorted(found, key=lambda one: -len(one[2]))
    ]


def _same(one: Array, other: Array, size: Array) -> bool:
    """Whether two periods have the same points, begun anywhere."""
    return any((np.abs(np.roll(other, shift, axis=0) - one) <= size).all() for shift in range(len(one)))
