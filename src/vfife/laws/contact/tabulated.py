"""A law as a table: measured force over penetration, loading and unloading."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...errors import Fault
from ...kernels.tabled import turned_slowness
from ...numerics import splines
from ...numerics.scalar import integer_power
from ...schema import Curve, FixedList, Measure, described
from ..law import ContactLaw, Pair, quantity

Array: TypeAlias = NDArray[np.float64]

POINTS = Curve(FixedList((Measure("m"), Measure("N"))), ("penetration (m)", "force (N)"))
# Noise over the largest force by which loading may fall, or unloading lie above it: what is accepted, and
# what is reported.
MEET = 0.05
NOISE = 1e-3
Points = tuple[tuple[float, float], ...]
MOST_PIECES = 24  # among which a step searches
SAME_PLACE = 1e-9  # distance of places that count as one, over the last penetration
CLOSE = 1e-4  # of the largest force: by how much a curve through fewer points may miss the others


@dataclass(frozen=True, kw_only=True)
class Tabulated(ContactLaw):
    """F_N = U + (L - U) s: ``loading`` L while the surfaces approach (s = 1), ``unloading`` U while they part
    (s = 0), each over the penetration.

    Points are joined by monotone cubics (Fritsch and Carlson 1980), which stay between neighbouring points;
    of a long table only as many points are used as the accuracy needs. Where the surfaces turn, s passes from
    1 to 0 in proportion to the rate, from ``transition`` times the impact speed to the opposite speed,
    wherever the turning point is. A contact that turns at a penetration d therefore loses the area between
    the branches up to d at any speed, except for about transition^2 of it, and gains no energy because U <=
    L; without ``unloading`` it loses nothing. At rest the force is the mean of the branches. Beyond its last
    penetration loading continues with its last slope, and unloading keeps its distance from it.
    """

    name = "table"
    source = (
        "measured; joined after Fritsch, Carlson: Monotone piecewise cubic interpolation. SIAM Journal on"
        " Numerical Analysis 17 (1980) 238-246"
    )
    formula = "F = U(d) + (L(d) - U(d)) (1 + x)/2, x = d'/(transition d'0) within -1 and 1"
    slots = ("inverse_transition",)
    slot_units: ClassVar[dict[str, str]] = {"inverse_transition": "1"}
    tabled = True

    loading: Points = described(
        POINTS,
        "penetration and force of each point while the surfaces approach, ascending; in a file also a CSV"
        " file",
    )
    unloading: Points | None = described(
        POINTS, "the same while they part, nowhere above loading; left out: the loading curve again", None
    )
    force_factor: float = quantity("1", "factor of all forces", 1.0, above=0.0)
    penetration_factor: float = quantity("1", "factor of all penetrations", 1.0, above=0.0)
    transition: float = quantity(
        "1",
        "share of the impact speed below which the force is between the branches, in proportion to the rate",
        0.05,
        low=1e-3,
        high=1.0,
    )

    def disagreements(self) -> Iterator[Fault]:
        """Yield the faults of curves, and of an unloading curve that would supply energy."""
        result = list(faults_of_points("loading", self.loading))
        result += faults_of_points("unloading", self.unloading) if self.unloading is not None else ()
        yield from result or faults_of_both(self.loading, self.unloading)

    @property
    def branches(self) -> Branches:
        """The curves as pieces, without the factors."""
        return joined(self.loading, self.unloading)

    @property
    def pieces(self) -> tuple[tuple[float, ...], ...]:
        """Where each piece begins (m), the coefficients of the branches' mean and of half their distance,
        constant first.
        """
        return self.branches.scaled(self.penetration_factor, self.force_factor)

    @property
    def end(self) -> float:
        """The last penetration (m) of the table."""
        return self.penetration_factor * self.branches.end

    def knots(self) -> tuple[tuple[float, ...], ...]:
        """Return the pieces of the curve."""
        return self.pieces

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """1/transition (1), then the pieces one after the other."""
        return (1.0 / self.transition, *(value for piece in self.pieces for value in piece))

    def derived(self, pair: Pair) -> dict[str, str]:
        """Return the slot that the fields do not show."""
        return {"inverse_transition": f"{1.0 / self.transition:.6g}"}

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N), the mean of the branches, and damping coefficient (N s/m), half their distance
        over the rate of ``slowness``.
        """
        piece = _piece(p, penetration)
        x = penetration - piece[0]
        _, m0, m1, m2, m3, h0, h1, h2, h3 = piece
        return m0 + x * (m1 + x * (m2 + x * m3)), slowness * (h0 + x * (h1 + x * (h2 + x * h3)))

    def slowness(self, speed: float, rate: float) -> float:
        """1/|rate| (s/m), at most that of the transition."""
        result: float = turned_slowness(1.0 / speed, 1.0 / self.transition, rate)
        return result

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """Energy (J) of the branches' mean: what is stored, where nothing is lost yet."""
        depth = np.maximum(np.asarray(penetration, dtype=float), 0.0)
        rows = np.array(p[1:]).reshape(-1, 9)
        powers = 1.0 / np.arange(1.0, 5.0)

        def work(k: Any, x: Any) -> Any:
            c = rows[k, 1:5] * powers
            return x * (c[..., 0] + x * (c[..., 1] + x * (c[..., 2] + x * c[..., 3])))

        starts = rows[:, 0]
        total = np.concatenate([[0.0], np.cumsum(work(np.arange(len(rows) - 1), np.diff(starts)))])
        at = np.maximum(np.searchsorted(starts, depth, side="right") - 1, 0)
        return total[at] + work(at, depth - starts[at])

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Return notes on the reduction of a long or noisy table, and on penetrations beyond the table."""
        result, curve = [], self.branches
        if curve.used < curve.available:
            missed = f"{100.0 * curve.missed:.2g} % of the largest force"
            result.append(
                f"{curve.used} of {curve.available} penetrations are used, the curve through which misses the"
                f" others by up to {missed}"
            )
        if curve.levelled > NOISE:
            moved = f"points were moved by up to {100.0 * curve.levelled:.2g} % of the largest force"
            result.append(f"{moved}, so that loading does not fall and unloading is not above it")
        if penetration is not None and penetration > self.end:
            deep = (
                f"penetrations of up to {penetration:.4g} m are beyond the table, which ends at"
                f" {self.end:.4g} m"
            )
            result.append(f"{deep}: the law continues there with its last slope")
        return tuple(result)


def _piece(p: tuple[float, ...], penetration: float) -> tuple[float, ...]:
    """Select the piece for a penetration from a flat tuple of parameters."""
    count = len(p) // 9
    at = 0
    for k in range(1, count):
        at = k if penetration >= p[1 + 9 * k] else at
    return p[1 + 9 * at : 10 + 9 * at]


def faults_of_points(name: str, points: Points) -> Iterator[Fault]:
    """Yield the faults of one measured curve."""
    if len(points) < 2:
        yield Fault(
            name, f"a table of {len(points)} points", "", "two points or more", "add points of the curve"
        )
        return
    for (previous, _), (place, _) in zip(points, points[1:], strict=False):
        if not place > previous:
            yield Fault(
                name,
                f"the penetration {place:g} m does not come after {previous:g} m",
                "",
                "ascending penetrations",
                "sort the points",
            )
            return
    first, force = points[0]
    if first < 0.0 or (force != 0.0 and first == 0.0):
        problem = (
            f"it begins before the surfaces touch, at {first:g} m"
            if first < 0.0
            else f"it begins with {force:g} N at no penetration"
        )
        yield Fault(name, problem, "", "0 N at 0 m", "take the offset off the measured values")
    elif min(force for _, force in points) < 0.0:
        yield Fault(
            name,
            "a force below 0 N",
            "",
            "surfaces that push",
            "take the offset off the measured values, or leave such points out",
        )
    elif max(force for _, force in points) == 0.0:
        yield Fault(name, "no force anywhere", "", "a force above 0 N", "check the columns")


def faults_of_both(loading: Points, unloading: Points | None) -> Iterator[Fault]:
    """Yield the fault of a falling loading curve, or of unloading above loading, by more than noise."""
    result = joined(loading, unloading).levelled
    if result > MEET:
        crossed = joined(loading, None).levelled <= MEET
        problem = (
            "it is above loading, where a contact would give energy"
            if crossed
            else "its force falls while the surfaces approach"
        )
        remedy = (
            "check which curve is which, and that both are of one specimen"
            if crossed
            else "smooth the curve, or fit a law to it (vfife fit)"
        )
        yield Fault(
            "unloading" if crossed else "loading",
            f"{problem}, by {100.0 * result:.3g} % of the largest",
            "",
            f"{100.0 * MEET:g} %",
            remedy,
        )


@dataclass(frozen=True)
class Branches:
    """Pieces as the kernels have them: begin (m), four coefficients of the branches' mean, four of half their
    distance, constant first.

    ``used`` of ``available`` places of both curves are knots; the curve through these misses a point by
    ``missed`` of the largest force. ``levelled``: by how much of it points were moved so that loading does
    not fall and unloading is not above it. ``end``: the last penetration (m).
    """

    pieces: tuple[tuple[float, ...], ...]
    used: int
    available: int
    missed: float
    levelled: float
    end: float

    def scaled(self, place: float, force: float) -> tuple[tuple[float, ...], ...]:
        """Scale the penetrations and forces of the pieces."""
        if place == force == 1.0:
            return self.pieces
        powers = tuple(force / integer_power(place, k) for k in range(4)) * 2
        return tuple(
            (place * piece[0], *(c * power for c, power in zip(piece[1:], powers, strict=True)))
            for piece in self.pieces
        )


@lru_cache(maxsize=256)
def joined(loading: Points, unloading: Points | None) -> Branches:
    """Build the pieces of two curves of ascending penetrations, each from zero force at zero
    penetration.

    Loading is interpolated by monotone cubics (Fritsch and Carlson), and so is its distance from unloading.
    Monotone cubics stay between their points, so the distance is never negative.
    """
    up, down = from_nothing(loading), from_nothing(unloading or loading)
    rising = not_falling(up[1])
    size = float(up[1].max())
    places = np.union1d(up[0], down[0])
    places = places[places <= up[0][-1]]
    places = places[
        np.diff(places, prepend=-1.0) > SAME_PLACE * places[-1]
    ]  # one micrometre written twice may differ in its last bit
    inside = np.minimum(places, down[0][-1])  # beyond its end unloading stays as far below loading
    load = _curve(up[0], rising)
    loss = load(inside) - _curve(*down)(inside)
    half = 0.5 * np.maximum(loss, 0.0) if unloading is not None else np.zeros(len(places))
    levelled = (
        max(
            float(np.abs(rising - up[1]).max()),
            float(-loss.min(initial=0.0)) if unloading is not None else 0.0,
        )
        / size
    )
    chosen, missed = chosen_among(places, np.array([load(places), half]), size)
    at = places[chosen]
    force, ahead = splines.monotone(at.tolist(), load(at).tolist()), float(at[-1] - at[-2])
    distance = splines.monotone(at.tolist(), half[chosen].tolist())
    mean = [
        [a - b for a, b in zip(total, half_distance, strict=True)]
        for total, half_distance in zip(force, distance, strict=True)
    ]
    pieces = [(float(begin), *m, *h) for begin, m, h in zip(at[:-1], mean, distance, strict=True)]
    _, rate, bend, third = force[-1]
    slope, last = rate + ahead * (2.0 * bend + ahead * 3.0 * third), float(half[chosen[-1]])
    if any(
        abs(c) > 0.0 for c in (pieces[-1][3], pieces[-1][4], *pieces[-1][6:])
    ):  # one that is straight goes on by itself
        pieces.append((float(at[-1]), float(load(at[-1:])[0]) - last, slope, 0.0, 0.0, last, 0.0, 0.0, 0.0))
    return Branches(tuple(pieces), len(at), len(places), missed, levelled, float(at[-1]))


def _curve(places: Array, values: Array) -> Callable[[Array], Array]:
    """Interpolate points by monotone cubics."""
    starts, rows = places.tolist(), splines.monotone(places.tolist(), values.tolist())
    return lambda at: np.array([splines.value_at(starts, rows, x) for x in at.tolist()])


def from_nothing(points: Points) -> tuple[Array, Array]:
    """Return penetrations (m) and forces (N), beginning with 0 N at 0 m."""
    place, force = np.array(points, dtype=float).T
    return (
        (place, force)
        if place[0] == 0.0
        else (np.concatenate([[0.0], place]), np.concatenate([[0.0], force]))
    )


def not_falling(values: Array) -> Array:
    """Return the nearest non-decreasing values in the sense of least squares (pool adjacent violators)."""
    blocks: list[list[float]] = []
    for value in values.tolist():
        blocks.append([value, 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (low, n), (high, m) = blocks[-2:]
            blocks[-2:] = [[(low * n + high * m) / (n + m), n + m]]
    return np.concatenate([np.full(int(count), value) for value, count in blocks])


def chosen_among(places: Array, curves: Array, size: float) -> tuple[NDArray[np.intp], float]:
    """Choose the points that the cubics interpolate, all of a short table, and return their indices and the
    largest deviation from the others, as a share of ``size``.
    """
    if len(places) <= MOST_PIECES + 1:
        return np.arange(len(places)), 0.0
    chosen = [0, len(places) - 1]
    while True:
        at = np.array(sorted(chosen))
        off = np.abs([_curve(places[at], curve[at])(places) - curve for curve in curves]).max(axis=0)
        worst = int(np.argmax(off))
        if off[worst] <= CLOSE * size or len(chosen) > MOST_PIECES:
            return at, float(off[worst] / size)
        chosen.append(worst)
