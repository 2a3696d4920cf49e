"""Residuals between the curves of a model and measured ones, and their derivatives by the parameters.

Unknowns that need no new run are fitted for each set of parameters: the offset of trigger or phase by a
one-dimensional search, the factor and level of a proportional curve in closed form. The variables of the main
search are then the parameters only, and its valleys are straight (variable projection: Golub and Pereyra,
SIAM Journal on Numerical Analysis 10 (1973) 413-432). Searching parameters and offset together would follow
curved valleys and stop in the local minima of the phase.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..solvers.tangents import Neighbours, comparable, tangents
from .curves import Curves, Trace
from .measurements import Measured
from .parameters import FitParameter, Numbers, numbers_at
from .run_length import Offset

Array = NDArray[np.float64]
Comparison = Literal["curve", "envelope", "spectrum"]
# The first search along the offset compares this many samples at most, at one offset for a few outputs.
COARSE_SAMPLES = 400
OUTPUTS_AN_OFFSET, MOST_OFFSETS = 4, 2000
# Later searches stay within this share of the range around the last offset.
OFFSET_REACH = 0.02
# Difference along the offset for Gauss-Newton steps, as a share of the range, and the number of steps.
OFFSET_SIDE = 1e-3
NEWTON_STEPS = 3
# Residual, in deviations of the data, of each sample of a case without a motion.
NO_MOTION = 10.0


@dataclass(frozen=True)
class Fitted:
    """The curves of a case at the samples: ``values``, shape (samples, curves), at the best ``offset`` (s or
    rad) and with the best ``gains``, factor and level of each curve, shape (2, curves).

    ``residuals``, shape (samples * curves,). ``curvature``: the squared norm of their derivative by the
    offset, 0 if the offset is fixed.
    """

    offset: float
    gains: Array
    values: Array
    residuals: Array
    curvature: float = 0.0

    @property
    def cost(self) -> float:
        """Half the sum of squares."""
        return 0.5 * float(self.residuals @ self.residuals)


class Misfit:
    """Compare traces with the curves ``measured``, as themselves, envelopes or spectra (``comparison``).

    ``skip``: turns (s without a turn) of a run that are not compared if the offset is free; ``width`` (s or
    rad) of an envelope's window.
    """

    def __init__(
        self,
        measured: Measured,
        offset: Offset,
        skip: float,
        comparison: Comparison = "curve",
        width: float = 0.0,
    ) -> None:
        self.measured, self.offset, self.skip, self.comparison = measured, offset, skip, comparison
        self.window = max(3, round(width / measured.spacing)) if comparison == "envelope" else 0
        self.data = np.stack([curve.values for curve in measured.curves], axis=1)
        self.proportional = np.array([curve.proportional for curve in measured.curves])
        self.target = self.compared(self.data)
        spread = (
            self.target.std(axis=0) if comparison != "spectrum" else np.sqrt((self.target**2).mean(axis=0))
        )
        self.scale = np.where(spread > 0.0, spread, 1.0)
        self.weights = np.array([curve.weight for curve in measured.curves]) / self.scale

    @property
    def count(self) -> int:
        """Number of residuals."""
        return self.target.size

    @property
    def unknown_turn(self) -> bool:
        """Whether it is unknown in which turn of the motion the data begin: the offset is free, or angles are
        known only up to whole turns.
        """
        return self.offset.free or self.measured.over == "angle"

    @property
    def penalty(self) -> Array:
        """Residuals of a case without a motion, shape (residuals,)."""
        return np.full(self.count, NO_MOTION)

    def compared(self, values: Array) -> Array:
        """Return the quantities that are compared: the curves themselves, their moving root mean square, or
        the amplitudes of their spectrum.
        """
        if self.comparison == "envelope":
            kernel = np.ones(self.window) / self.window
            mean = values - values.mean(axis=0)
            squares: Array = np.stack(
                [np.convolve(column * column, kernel, "valid") for column in mean.T], axis=1
            )
            return np.asarray(np.sqrt(np.maximum(squares, 0.0)), dtype=float)
        if self.comparison == "spectrum":
            uniform_places = np.linspace(self.measured.places[0], self.measured.places[-1], len(values))
            resampled = np.stack(
                [
                    np.interp(uniform_places, self.measured.places, column)
                    for column in (values - values.mean(axis=0)).T
                ],
                axis=1,
            )
            window = np.hanning(len(values))[:, None]
            return np.asarray(np.abs(np.fft.rfft(resampled * window, axis=0))[1:] * (2.0 / window.sum()))
        return values

    def places(self) -> tuple[str, Array]:
        """Return name and values of the abscissa of the compared quantities: times (s) or angles (rad); for
        spectra frequencies (Hz) or orders (1).
        """
        data, count = self.measured, len(self.target)
        if self.comparison == "spectrum":
            lines = np.arange(1, count + 1) * (len(data.places) - 1) / (len(data.places) * data.span)
            return ("order", 2.0 * math.pi * lines) if data.over == "angle" else ("frequency", lines)
        return data.over, data.places[self.window // 2 :][:count]

    def origin(self, trace: Trace) -> float:
        """Return the place (s or rad) in a run from which offsets are counted: the end of the skipped turns,
        or the first sample if the offset is given.
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
        """Return the smallest and the largest offset (s or rad): the given ones, or a whole turn."""
        if not self.offset.free:
            return self.offset.low, self.offset.high
        return 0.0, 2.0 * math.pi if self.measured.over == "angle" else (trace.turn or self.offset.high)

    def __call__(self, trace: Trace, guess: float | None = None) -> Fitted:
        """Compare a trace at its best offset, which is searched near a known one or in the whole range.

        A coarse search finds the valley, a bounded search its bottom, and Gauss-Newton steps the last digits.
        """
        low, high = self.range(trace)
        if self.offset.fixed:
            return self.at_offset(trace, low)
        from scipy.optimize import minimize_scalar

        if guess is None:
            middle, reach = self.search(trace, low, high)
        else:
            middle, reach = guess, OFFSET_REACH * (high - low)
        ends = (middle - reach, middle + reach)
        if not self.offset.free:
            ends = max(ends[0], low), min(ends[1], high)
        minimum = minimize_scalar(
            lambda at: self.at_offset(trace, at).cost,
            bounds=ends,
            method="bounded",
            options={"xatol": 1e-4 * (high - low)},
        )
        return self.polished(trace, float(minimum.x), ends)

    def polished(self, trace: Trace, at: float, ends: tuple[float, float]) -> Fitted:
        """Refine the offset by Gauss-Newton steps, because residuals at it are differentiated: a minimum
        known to 1e-4 would leave that error, divided by a small difference, in the derivatives.
        """
        side = OFFSET_SIDE * (ends[1] - ends[0])
        best, curvature = self.at_offset(trace, at), 0.0
        for _ in range(NEWTON_STEPS):
            slope = (
                self.at_offset(trace, at + side).residuals - self.at_offset(trace, at - side).residuals
            ) / (2.0 * side)
            curvature = float(slope @ slope)
            if not curvature > 0.0:
                break
            next_offset = min(max(at - float(slope @ best.residuals) / curvature, ends[0]), ends[1])
            next_fit = self.at_offset(trace, next_offset)
            if next_fit.cost > best.cost:
                break
            at, best = next_offset, next_fit
        return replace(best, curvature=curvature)

    def search(self, trace: Trace, low: float, high: float) -> tuple[float, float]:
        """Return the best of evenly spread offsets, compared at some of the samples, and the distance within
        which a better one may lie.
        """
        step = float(np.median(np.diff(trace.places)))
        count = int(np.clip(math.ceil((high - low) / (OUTPUTS_AN_OFFSET * step)), 40, MOST_OFFSETS))
        stride = max(1, len(self.data) // COARSE_SAMPLES)
        places = (self.measured.places - self.measured.places[0])[::stride]
        data, origin = self.data[::stride], self.origin(trace)
        offsets = low + (high - low) * (np.arange(count) + 0.5) / count
        at, costs = origin + offsets[:, None] + places, np.zeros(count)
        for k, (simulated, curve) in enumerate(zip(trace.values.T, data.T, strict=True)):
            values = np.interp(at, trace.places, simulated)
            if self.proportional[k]:  # the residual with the best factor and level
                centred, target = values - values.mean(axis=1, keepdims=True), curve - curve.mean()
                explained = (centred @ target) ** 2 / np.maximum((centred * centred).sum(axis=1), 1e-300)
                costs += (float(target @ target) - explained) / self.deviations[k] ** 2
            else:
                costs += ((values - curve) ** 2).sum(axis=1) / self.deviations[k] ** 2
        return float(offsets[int(np.argmin(costs))]), 1.5 * (high - low) / count

    @property
    def deviations(self) -> Array:
        """Standard deviation of each curve."""
        return np.asarray(np.maximum(self.data.std(axis=0), 1e-300), dtype=float)

    def with_gains(self, values: Array, data: Array) -> tuple[Array, Array]:
        """Return values with the best factor and level of proportional curves, and both, shape (2, curves):
        a linear regression of the data on the values.
        """
        gains = np.stack([np.ones(values.shape[1]), np.zeros(values.shape[1])])
        for k in np.flatnonzero(self.proportional):
            mean, target = values[:, k].mean(), data[:, k].mean()
            centred = values[:, k] - mean
            square = float(centred @ centred)
            gains[0, k] = float(centred @ (data[:, k] - target)) / square if square > 0.0 else 0.0
            gains[1, k] = target - gains[0, k] * mean
        return values * gains[0] + gains[1], gains

    def at_offset(self, trace: Trace, offset: float) -> Fitted:
        """Compare a trace at an offset."""
        places = self.origin(trace) + offset + (self.measured.places - self.measured.places[0])
        raw = self.compared(interpolated(places, trace))
        values, gains = self.with_gains(raw, self.target)
        return Fitted(offset, gains, values, self.residuals(values))

    def residuals(self, values: Array) -> Array:
        """Return the differences of values from the data, over the deviations, curve after curve, shape
        (residuals,).
        """
        return np.asarray(((values - self.target) * self.weights).T.reshape(-1), dtype=float)

    def unsettled(self, trace: Trace) -> float:
        """Return the root mean square difference between two turns after the skipped ones, over the data's
        deviations; 0 if the offset is not free.

        Proportional curves are left out, because their factor is unknown.
        """
        if not self.offset.free:
            return 0.0
        turn = 2.0 * math.pi if self.measured.over == "angle" else (trace.turn or 0.0)
        first = self.origin(trace)
        places = first + turn * np.linspace(0.0, 1.0, 200)
        if places[-1] + turn > trace.places[-1] + 1e-9 * turn:
            return 0.0
        change = (
            (interpolated(places + turn, trace) - interpolated(places, trace))
            * np.where(self.proportional, 0.0, 1.0)
            / self.deviations
        )
        return float(np.sqrt((change**2).mean()))

    def columns(self, residuals: Array) -> Array:
        """Return residuals by curve, shape (samples, curves)."""
        return residuals.reshape(len(self.measured.curves), -1).T


def interpolated(places: Array, trace: Trace) -> Array:
    """Return the values of a trace at ``places`` between its outputs, by cubic Hermite interpolation."""
    x, values = trace.places, trace.values
    at = np.clip(np.searchsorted(x, places, side="right") - 1, 0, len(x) - 2)
    slopes = trace.slopes
    width = (x[at + 1] - x[at])[:, None]
    u = ((np.clip(places, x[0], x[-1]) - x[at])[:, None]) / width
    first, last = values[at], values[at + 1]
    rise = last - first
    a, b = slopes[at] * width - rise, rise - slopes[at + 1] * width
    values_between: Array = first + u * rise + u * (1.0 - u) * (a * (1.0 - u) + b * u)
    return values_between


# ------------------------------------------------------------------------------------------------ derivatives

# Distances to both sides of a parameter, as shares of its bounds: for differences of runs, which average over
# kinks from impacts that begin or end, and for the two models whose difference starts a tangent.
SIDE, TANGENT_SIDE = 2e-3, 1e-6
# Columns of two Jacobians agree if their cosine is at least the first number and their lengths differ by at
# most the second; columns shorter than the third, as a share of the longest, are not compared.
SAME_DIRECTION, SAME_LENGTH, NEGLIGIBLE = 0.98, 0.2, 1e-6


@dataclass(frozen=True)
class FitRecord:
    """A measured record as a fit compares it: what computes its curves, the parameters that act on it, its
    misfit.

    ``indices``: those of its parameters among all of the fit. ``key`` tells its rows in a fit file from those
    of other records.
    """

    curves: Curves
    parameters: Sequence[FitParameter]
    misfit: Misfit
    indices: tuple[int, ...] = ()
    name: str = ""
    key: str = ""

    def places(self) -> list[int]:
        """Places of its parameters among all of the fit: in their order unless told otherwise."""
        return list(self.indices) or list(range(len(self.parameters)))

    def numbers(self, shares: Sequence[float]) -> Numbers:
        """Values of its parameters by path."""
        return numbers_at(self.parameters, np.array(shares))


@dataclass(frozen=True)
class RunRequest:
    """A run of a record at ``shares`` of the ways between the bounds of its parameters; with ``tangents`` the
    traces to both sides of each parameter instead.
    """

    record: FitRecord
    shares: tuple[float, ...]
    tangents: bool = False


def traces_of(requests: Sequence[RunRequest]) -> list[Any]:
    """Return the traces of runs that are computed side by side in lanes; for a run with tangents a list of
    pairs of traces, or the VfifeError that prevents them.
    """
    plain = [
        (request.record.curves, request.record.numbers(request.shares))
        for request in requests
        if not request.tangents
    ]
    answers = iter(plain[0][0].case_traces(plain) if plain else ())
    return [
        tangent_traces(request.record, request.shares) if request.tangents else next(answers)
        for request in requests
    ]


def tangent_traces(record: FitRecord, shares: tuple[float, ...]) -> list[tuple[Trace, Trace]] | VfifeError:
    """Return traces ``SIDE`` to both sides of each parameter, extrapolated along the tangents of one run, or
    the error that prevents them.
    """
    curves, parameters = record.curves, record.parameters
    try:
        assembly = curves.cases.assembled(record.numbers(shares))
        variants = [neighbours(record, shares, k) for k in range(len(parameters))]
        for parameter, pair in zip(parameters, variants, strict=True):
            if not comparable(assembly, pair):
                raise VfifeError(f"{parameter.name} changes how many steps or pieces there are")
        records = tangents(assembly, variants)
    except VfifeError as error:
        return error
    return [
        extrapolated(curves, pairs[0], variant.distance)
        for pairs, variant in zip(records, variants, strict=True)
    ]


def neighbours(record: FitRecord, shares: tuple[float, ...], k: int) -> Neighbours:
    """Return the assemblies with parameter k increased and decreased by TANGENT_SIDE, within its bounds."""
    ends = np.clip([shares[k] + TANGENT_SIDE, shares[k] - TANGENT_SIDE], 0.0, 1.0)
    up, down = (
        record.curves.cases.assembled(record.numbers((*shares[:k], float(end), *shares[k + 1 :])))
        for end in ends
    )
    return Neighbours(up, down, float(ends[0] - ends[1]))


def extrapolated(curves: Curves, pair: tuple[Any, Any], distance: float) -> tuple[Trace, Trace]:
    """Return traces ``SIDE`` to both sides, extrapolated linearly from two records whose parameters differ by
    ``distance``.
    """
    up, down = (curves.trace(record) for record in pair)
    ratio = 2.0 * SIDE / distance

    def moved(first: Any, second: Any, sign: float) -> Any:
        return 0.5 * (first + second) + sign * ratio * (first - second)

    turn = up.turn is not None and down.turn is not None
    upper, lower = (
        Trace(
            moved(up.places, down.places, sign),
            moved(up.values, down.values, sign),
            moved(up.turn, down.turn, sign) if turn else None,
        )
        for sign in (0.5, -0.5)
    )
    return upper, lower


@dataclass(frozen=True)
class Slopes:
    """Derivatives by shares of the intervals between the bounds: ``jacobian`` of the residuals, shape
    (residuals, parameters), and ``offsets``, those of the best offset, shape (parameters,).
    """

    jacobian: Array
    offsets: Array

    @staticmethod
    def of(
        traces: Sequence[Any], misfit: Misfit, shares: tuple[float, ...], offset: float, by_tangents: bool
    ) -> Slopes:
        """Return the derivatives from the traces of :func:`derivative_runs`. Offset, factor and level are
        fitted on each side anew, which makes this the derivative of the projected residuals.
        """
        pairs = (
            [(*pair, 2.0 * SIDE) for pair in traces[0]] if by_tangents else list(differences(traces, shares))
        )
        columns, offsets = [], []
        for up, down, distance in pairs:
            if isinstance(up, str) or isinstance(down, str):  # a side without a motion
                columns.append(np.zeros(misfit.count))
                offsets.append(0.0)
                continue
            upper, lower = misfit(up, offset), misfit(down, offset)
            columns.append((upper.residuals - lower.residuals) / distance)
            offsets.append((upper.offset - lower.offset) / distance)
        return Slopes(np.stack(columns, axis=1), np.array(offsets))


def derivative_runs(record: FitRecord, shares: tuple[float, ...], by_tangents: bool) -> list[RunRequest]:
    """Return the runs that the derivatives at a point need: one with tangents, or two for each parameter."""
    if by_tangents:
        return [RunRequest(record, shares, True)]
    return [
        RunRequest(record, (*shares[:k], end, *shares[k + 1 :]))
        for k, share in enumerate(shares)
        for end in side_shares(share)
    ]


def side_shares(share: float) -> tuple[float, float]:
    """Return ``share`` plus and minus SIDE, within the bounds."""
    return min(share + SIDE, 1.0), max(share - SIDE, 0.0)


def differences(traces: Sequence[Any], shares: tuple[float, ...]) -> Iterator[tuple[Any, Any, float]]:
    """Yield the traces to both sides of each parameter and the distance of their shares."""
    for k, share in enumerate(shares):
        high, low = side_shares(share)
        yield traces[2 * k], traces[2 * k + 1], high - low


def columns_agree(first: Slopes, second: Slopes) -> bool:
    """Return whether the columns of two Jacobians agree in direction and length."""
    sizes, references = (np.linalg.norm(slopes.jacobian, axis=0) for slopes in (first, second))
    largest = max(float(references.max(initial=0.0)), 1e-300)
    for k, (size, reference) in enumerate(zip(sizes, references, strict=True)):
        if reference <= NEGLIGIBLE * largest:
            continue
        direction = float(first.jacobian[:, k] @ second.jacobian[:, k]) / max(float(size * reference), 1e-300)
        if not (direction >= SAME_DIRECTION and abs(size / reference - 1.0) <= SAME_LENGTH):
            return False
    return True
