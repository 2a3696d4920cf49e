"""How far the curves of a model are from measured ones, wherever these begin and however loud they are.

What no run has to be made for is fitted for each set of parameters anew: the offset of the trigger or of the
phase, by a search along it, and the factor and level of a curve that is only proportional to its channel, in
closed form (variable projection: Golub and Pereyra, SIAM Journal on Numerical Analysis 10 (1973) 413-432).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..solvers.tangents import Neighbours, comparable, tangents
from .curves import Curves, Trace
from .measurements import Measured
from .sought import Sought, numbers_at

Array = NDArray[np.float64]
How = Literal["curve", "envelope", "spectrum"]
LOOKED_AT = 400  # samples of the first search along the offset
PLACES, MOST_PLACES = 4, 2000  # of that search for each output of a turn's fortieth part, and in all
OFFSET_REACH = 0.02  # of the range, within which a later search stays
OFFSET_SIDE, STEPS = 1e-3, 3  # of the range that is looked through, for the slope along it; steps
LOST = 10.0  # deviations by which a member without a motion misses every sample


@dataclass(frozen=True)
class Offset:
    """Where the first sample lies in the model's run: between ``low`` and ``high`` (s or rad) after its
    ``origin``; fixed where they are one.
    """

    low: float
    high: float
    free: bool = False

    @property
    def fixed(self) -> bool:
        """Whether there is nothing to look for."""
        return self.low == self.high and not self.free


@dataclass(frozen=True)
class Fitted:
    """The curves of one member laid on the samples, shape (samples, curves): ``offset``, and of each curve
    its factor and level.

    ``along``: the square of the residuals' slope along the offset, 0 where that is fixed.
    """

    offset: float
    gains: Array
    values: Array
    residuals: Array
    along: float = 0.0

    @property
    def cost(self) -> float:
        """Half the sum of squares."""
        return 0.5 * float(self.residuals @ self.residuals)


class Misfit:
    """Lays traces on what was measured. ``skip``: turns (or s, without a turn) of the run that are left out
    where the offset is free.
    """

    def __init__(
        self, measured: Measured, offset: Offset, skip: float, how: How = "curve", width: float = 0.0
    ) -> None:
        self.measured, self.offset, self.skip, self.how = measured, offset, skip, how
        self.window = max(3, round(width / measured.spacing)) if how == "envelope" else 0
        self.data = np.stack([one.values for one in measured.curves], axis=1)
        self.proportional = np.array([one.proportional for one in measured.curves])
        self.wanted = self.seen(self.data)
        spread = self.wanted.std(axis=0) if how != "spectrum" else np.sqrt((self.wanted**2).mean(axis=0))
        self.scale = np.where(spread > 0.0, spread, 1.0)
        self.weights = np.array([one.weight for one in measured.curves]) / self.scale

    @property
    def count(self) -> int:
        """Residuals."""
        return self.wanted.size

    @property
    def any_turn(self) -> bool:
        """Whether nobody knows in which turn of the motion the data begin: an offset that is free, an angle
        that is known to whole turns.
        """
        return self.offset.free or self.measured.over == "angle"

    @property
    def lost(self) -> Array:
        """Residuals of a member that has no curves."""
        return np.full(self.count, LOST)

    def seen(self, values: Array) -> Array:
        """What is compared of curves: they themselves, their moving root mean square, or the amplitudes of
        their spectrum.
        """
        if self.how == "envelope":
            kernel = np.ones(self.window) / self.window
            mean = values - values.mean(axis=0)
            squares: Array = np.stack([np.convolve(one * one, kernel, "valid") for one in mean.T], axis=1)
            return np.asarray(np.sqrt(np.maximum(squares, 0.0)), dtype=float)
        if self.how == "spectrum":
            even = np.linspace(self.measured.places[0], self.measured.places[-1], len(values))
            resampled = np.stack(
                [np.interp(even, self.measured.places, one) for one in (values - values.mean(axis=0)).T],
                axis=1,
            )
            window = np.hanning(len(values))[:, None]
            return np.asarray(np.abs(np.fft.rfft(resampled * window, axis=0))[1:] * (2.0 / window.sum()))
        return values

    def places(self) -> tuple[str, Array]:
        """What the places of what is compared are, and where: times (s), angles (rad); of spectra frequencies
        (Hz), orders (cycles a turn).
        """
        seen, count = self.measured, len(self.wanted)
        if self.how == "spectrum":
            lines = np.arange(1, count + 1) * (len(seen.places) - 1) / (len(seen.places) * seen.span)
            return ("order", 2.0 * math.pi * lines) if seen.over == "angle" else ("frequency", lines)
        return seen.over, seen.places[self.window // 2 :][:count]

    def origin(self, trace: Trace) -> float:
        """Where a run's samples may begin: after what is skipped, in whole turns; a fixed offset counts from
        the begin.
        """
        if not self.offset.free:
            first = self.measured.places[0]
            if self.measured.over == "angle":  # an angle is known to whole turns
                turns = math.ceil((trace.places[0] - first) / (2.0 * math.pi) - 1e-9 + self.skip)
                return float(first + 2.0 * math.pi * turns)
            return float(first)
        if self.measured.over == "angle":
            return float(trace.places[0] + 2.0 * math.pi * self.skip)
        return float(trace.places[0] + self.skip * (trace.turn or 1.0))

    def range(self, trace: Trace) -> tuple[float, float]:
        """Least and most offset: as it is told, or a whole turn."""
        if not self.offset.free:
            return self.offset.low, self.offset.high
        return 0.0, 2.0 * math.pi if self.measured.over == "angle" else (trace.turn or self.offset.high)

    def __call__(self, trace: Trace, near: float | None = None) -> Fitted:
        """The best place of the samples in a trace, near an offset that is known, or in all of its range."""
        low, high = self.range(trace)
        if self.offset.fixed:
            return self.laid(trace, low)
        from scipy.optimize import minimize_scalar

        if near is None:
            near, reach = self.search(trace, low, high)
        else:
            reach = OFFSET_REACH * (high - low)
        ends = (near - reach, near + reach)
        if not self.offset.free:
            ends = max(ends[0], low), min(ends[1], high)
        found = minimize_scalar(
            lambda at: self.laid(trace, at).cost,
            bounds=ends,
            method="bounded",
            options={"xatol": 1e-4 * (high - low)},
        )
        return self.polished(trace, float(found.x), ends)

    def polished(self, trace: Trace, at: float, ends: tuple[float, float]) -> Fitted:
        """The offset to many digits, by Gauss and Newton's steps along it: derivatives are taken of it."""
        side = OFFSET_SIDE * (ends[1] - ends[0])
        here, along = self.laid(trace, at), 0.0
        for _ in range(STEPS):
            slope = (self.laid(trace, at + side).residuals - self.laid(trace, at - side).residuals) / (
                2.0 * side
            )
            along = float(slope @ slope)
            if not along > 0.0:
                break
            after = min(max(at - float(slope @ here.residuals) / along, ends[0]), ends[1])
            there = self.laid(trace, after)
            if there.cost > here.cost:
                break
            at, here = after, there
        return replace(here, along=along)

    def search(self, trace: Trace, low: float, high: float) -> tuple[float, float]:
        """The best of offsets that lie evenly between two, and how far they are apart; at some of the samples
        only.
        """
        step = float(np.median(np.diff(trace.places)))
        count = int(np.clip(math.ceil((high - low) / (PLACES * step)), 40, MOST_PLACES))
        every = max(1, len(self.data) // LOOKED_AT)
        places = (self.measured.places - self.measured.places[0])[::every]
        data, origin = self.data[::every], self.origin(trace)
        offsets = low + (high - low) * (np.arange(count) + 0.5) / count
        at, costs = origin + offsets[:, None] + places, np.zeros(count)
        for k, (one, wanted) in enumerate(zip(trace.values.T, data.T, strict=True)):
            values = np.interp(at, trace.places, one)
            if self.proportional[k]:  # what is left beside the best factor and level
                apart, left = values - values.mean(axis=1, keepdims=True), wanted - wanted.mean()
                share = (apart @ left) ** 2 / np.maximum((apart * apart).sum(axis=1), 1e-300)
                costs += (float(left @ left) - share) / self.scale_of_data[k] ** 2
            else:
                costs += ((values - wanted) ** 2).sum(axis=1) / self.scale_of_data[k] ** 2
        return float(offsets[int(np.argmin(costs))]), 1.5 * (high - low) / count

    @property
    def scale_of_data(self) -> Array:
        """Standard deviation of each curve."""
        return np.asarray(np.maximum(self.data.std(axis=0), 1e-300), dtype=float)

    def levelled(self, values: Array, data: Array) -> tuple[Array, Array]:
        """Values with the factor and level that suit the data best, of curves that are proportional, and
        both, shape (2, curves).
        """
        gains = np.stack([np.ones(values.shape[1]), np.zeros(values.shape[1])])
        for k in np.flatnonzero(self.proportional):
            mean, wanted = values[:, k].mean(), data[:, k].mean()
            apart = values[:, k] - mean
            square = float(apart @ apart)
            gains[0, k] = float(apart @ (data[:, k] - wanted)) / square if square > 0.0 else 0.0
            gains[1, k] = wanted - gains[0, k] * mean
        return values * gains[0] + gains[1], gains

    def laid(self, trace: Trace, offset: float) -> Fitted:
        """A trace on the samples at an offset."""
        places = self.origin(trace) + offset + (self.measured.places - self.measured.places[0])
        raw = self.seen(between(places, trace))
        values, gains = self.levelled(raw, self.wanted)
        return Fitted(offset, gains, values, self.residuals(values))

    def residuals(self, values: Array) -> Array:
        """What values miss the data by, over the deviations, one curve after the other."""
        return np.asarray(((values - self.wanted) * self.weights).T.reshape(-1), dtype=float)

    def unsettled(self, trace: Trace) -> float:
        """By how much the turn after those that are skipped differs from the next, over the deviations of the
        measured curves; 0 where no turns are skipped.
        """
        if not self.offset.free:
            return 0.0
        turn = 2.0 * math.pi if self.measured.over == "angle" else (trace.turn or 0.0)
        first = self.origin(trace)
        places = first + turn * np.linspace(0.0, 1.0, 200)
        if places[-1] + turn > trace.places[-1] + 1e-9 * turn:
            return 0.0
        apart = (
            (between(places + turn, trace) - between(places, trace)) * self.levelled_by / self.scale_of_data
        )
        return float(np.sqrt((apart**2).mean()))

    @property
    def levelled_by(self) -> Array:
        """1 for each curve; of one that is only proportional nothing is known beforehand."""
        return np.where(self.proportional, 0.0, 1.0)

    def columns(self, residuals: Array) -> Array:
        """Residuals by curve, shape (samples, curves)."""
        return residuals.reshape(len(self.measured.curves), -1).T


def between(places: Array, trace: Trace) -> Array:
    """Values between outputs, by cubics with the slopes of their neighbours."""
    x, values = trace.places, trace.values
    at = np.clip(np.searchsorted(x, places, side="right") - 1, 0, len(x) - 2)
    slopes = trace.slopes
    width = (x[at + 1] - x[at])[:, None]
    u = ((np.clip(places, x[0], x[-1]) - x[at])[:, None]) / width
    first, last = values[at], values[at + 1]
    rise = last - first
    a, b = slopes[at] * width - rise, rise - slopes[at + 1] * width
    found: Array = first + u * rise + u * (1.0 - u) * (a * (1.0 - u) + b * u)
    return found


SIDE = 2e-3  # of the way between the bounds, to each side: differences
NEAR = 1e-6  # the same, of the start from which steps carry their derivatives along
ALIKE, SIZED = 0.98, 0.2  # direction of two columns that agree, and by how much their lengths may differ
NOTHING = 1e-6  # of the longest column: what is shorter is not compared


@dataclass(frozen=True)
class Point:
    """Shares of the ways between the bounds; ``sides``: not the trace there, but those to both sides of each
    parameter, by derivatives.
    """

    shares: tuple[float, ...]
    sides: bool = False


Ask = Callable[[Sequence[Point]], list[Any]]


def answers(curves: Curves, sought: Sequence[Sought], points: Sequence[Point]) -> list[Any]:
    """Traces of points, all that can be together in lanes; an error for those that have no derivatives."""
    plain = [numbers_at(sought, np.array(one.shares)) for one in points if not one.sides]
    traces = iter(curves.each(plain) if plain else ())
    return [tried(curves, sought, np.array(one.shares)) if one.sides else next(traces) for one in points]


def tried(curves: Curves, sought: Sequence[Sought], shares: Array) -> list[tuple[Trace, Trace]] | VfifeError:
    """Traces to both sides, or why there are none."""
    try:
        return carried(curves, sought, shares)
    except VfifeError as error:
        return error


def carried(curves: Curves, sought: Sequence[Sought], shares: Array) -> list[tuple[Trace, Trace]]:
    """Traces to both sides of each parameter, ``SIDE`` away, as far as first derivatives tell them. Raises
    VfifeError where there are none.
    """
    here = curves.cases.assembled(numbers_at(sought, shares))
    every = [neighbours(curves, sought, shares, k) for k in range(len(sought))]
    for one, near in zip(sought, every, strict=True):
        if not comparable(here, near):
            raise VfifeError(f"{one.name} changes how many steps or pieces there are")
    return [
        stretched(curves, pairs[0], near.apart)
        for pairs, near in zip(tangents(here, every), every, strict=True)
    ]


def neighbours(curves: Curves, sought: Sequence[Sought], shares: Array, k: int) -> Neighbours:
    """Assemblies with one parameter a little larger and a little smaller."""
    found: list[Assembly] = []
    for sign in (1.0, -1.0):
        beside = shares.copy()
        beside[k] = np.clip(shares[k] + sign * NEAR, 0.0, 1.0)
        found.append(curves.cases.assembled(numbers_at(sought, beside)))
    ends = np.clip([shares[k] + NEAR, shares[k] - NEAR], 0.0, 1.0)
    return Neighbours(found[0], found[1], float(ends[0] - ends[1]))


def stretched(curves: Curves, pair: tuple[Any, Any], apart: float) -> tuple[Trace, Trace]:
    """Traces ``SIDE`` to both sides of the middle of two that are so far ``apart``."""
    up, down = (curves.trace(one) for one in pair)
    ratio = 2.0 * SIDE / apart
    sides = []
    for sign in (0.5, -0.5):
        places = 0.5 * (up.places + down.places) + sign * ratio * (up.places - down.places)
        values = 0.5 * (up.values + down.values) + sign * ratio * (up.values - down.values)
        turn = (
            None
            if up.turn is None or down.turn is None
            else 0.5 * (up.turn + down.turn) + sign * ratio * (up.turn - down.turn)
        )
        sides.append(Trace(places, values, turn))
    return sides[0], sides[1]


@dataclass(frozen=True)
class Slopes:
    """Derivatives by shares of the ways between the bounds: of the residuals, shape (residuals, parameters),
    and of the offset, (parameters,).
    """

    jacobian: Array
    offsets: Array

    @staticmethod
    def of(found: Sequence[Any], misfit: Misfit, shares: Array, offset: float, by_steps: bool) -> Slopes:
        """Those of what was asked for; offset, factor and level follow each side, as in variable projection."""
        pairs = [(*sides, 2.0 * SIDE) for sides in found[0]] if by_steps else list(differences(found, shares))
        columns, offsets = [], []
        for up, down, apart in pairs:
            if isinstance(up, str) or isinstance(down, str):
                columns.append(np.zeros(misfit.count))
                offsets.append(0.0)
                continue
            above, below = misfit(up, offset), misfit(down, offset)
            columns.append((above.residuals - below.residuals) / apart)
            offsets.append((above.offset - below.offset) / apart)
        return Slopes(np.stack(columns, axis=1), np.array(offsets))


def questions(shares: Array, by_steps: bool) -> list[Point]:
    """What is asked for derivatives at a point."""
    if by_steps:
        return [Point(tuple(shares), True)]
    return [
        Point(tuple(np.where(np.arange(len(shares)) == k, end, shares)))
        for k in range(len(shares))
        for end in sides(float(shares[k]))
    ]


def sides(share: float) -> tuple[float, float]:
    """A little more and a little less, within the bounds."""
    return min(share + SIDE, 1.0), max(share - SIDE, 0.0)


def differences(traces: Sequence[Any], shares: Array) -> Iterator[tuple[Any, Any, float]]:
    """Traces to both sides of each parameter, and how far these are apart."""
    for k, share in enumerate(shares):
        high, low = sides(float(share))
        yield traces[2 * k], traces[2 * k + 1], high - low


def compared(one: Slopes, other: Slopes) -> bool:
    """Whether two Jacobians say the same: each column in direction and length."""
    sizes, others = (np.linalg.norm(each.jacobian, axis=0) for each in (one, other))
    largest = max(float(others.max(initial=0.0)), 1e-300)
    for k, (size, beside) in enumerate(zip(sizes, others, strict=True)):
        if beside <= NOTHING * largest:
            continue
        direction = float(one.jacobian[:, k] @ other.jacobian[:, k]) / max(float(size * beside), 1e-300)
        if not (direction >= ALIKE and abs(size / beside - 1.0) <= SIZED):
            return False
    return True
