"""Follow the ideal mechanism through a driven motion: how far it goes, and which singular positions it
passes.

Positions are predicted along velocity and curvature and closed by Newton's method. A stride that does not
close, leads far from its prediction, or changes the sign of the determinant of all rows, is halved. A change
of sign that remains at the smallest stride is a singular position (Gosselin and Angeles, IEEE Transactions on
Robotics and Automation 6 (1990) 281-290, singularities of the second kind: drivers are held and something
still moves). If the mechanism closes a little beyond it, two branches cross there and the motion continues;
if not, it ends: the mechanism jams.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.drivers import Driver
from ..model.mechanism import Mechanism
from ..numerics import dense
from ..numerics.elementwise import cos
from .drives import constraint_drivers, kinematic_drivers
from .initial import Motion
from .linalg import DENSE, dependent_rows
from .rank_loss import Visit, singular_between, visit
from .system import RigidSystem, of_bodies

Array = NDArray[np.float64]

Aims = Callable[[float], Array]

PACE = math.radians(10.0)  # largest stride (rad; for travels see ways_of)
# Smallest strides (rad, or of a body's reach): towards the end of a motion, and towards a change of sign.
FINE = 1e-5
SINGULAR = 1e-4
# Stride across a singular position. A mechanism that closes on both sides of a shorter gap is as good as one
# that closes in between.
HOP = 4e-3
CLOSED = 1e-9  # of the extent of the bodies: an open distance that is zero
# An open distance (of the extent) below QUICK is squared by one more step; its result is used without a check
# if the step is shorter than SHORT_STEP.
QUICK = 1e-5
SHORT_STEP = 1e-4
ASTRAY = 0.3  # of a stride: a position farther from its prediction is on another branch
NEWTON = 6  # largest number of Newton's steps
MOST_SINGULAR = 12  # singular positions on a way
MOST_STRIDES = 3000


@dataclass(frozen=True, eq=False)
class Passage:
    """The result of following a way: the place ``reached`` (rad, m or s), the ``position`` [n, 3] there, and
    the ``singular`` positions passed, each with its place and self-stress.

    ``jammed``: the mechanism goes no further; ``stressed`` [rows] is the self-stress there.
    """

    reached: float
    position: Array
    jammed: bool
    stressed: Array | None
    singular: tuple[tuple[float, Array], ...]


@dataclass(eq=False)
class Follower:
    """A system whose drives and joints determine every motion: the ``rows`` and ``columns`` of its square
    matrix, and the ``extent`` (m) of its bodies.
    """

    system: RigidSystem
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    extent: float
    picked: Any  # of the matrix of all rows and columns

    @classmethod
    def of(cls, system: RigidSystem, position: Array) -> Follower | None:
        """Return the follower of a system at a closed position [n, 3]; None if drives and joints do not
        determine every motion that a joint feels, or if drives are redundant.
        """
        if not system.drives or position.size > DENSE:
            return None
        aside = position + 0.1 * cos(np.arange(position.size)).reshape(position.shape) * np.array(
            [1.0, 1.0, 1.0]
        )
        felt = np.flatnonzero(np.abs(system.dense_rows(aside, system.aims)[1]).max(axis=0) > 0.0)
        jacobian = system.dense_rows(position, system.aims)[1][:, felt]
        rows = np.arange(system.starts[-1])
        if len(rows) > len(felt):
            dependent = dependent_rows(jacobian)
            if any(row >= system.joint_rows for row in dependent):
                return None
            rows = np.setdiff1d(rows, dependent)
        if len(rows) != len(felt) or dense.singular_values(jacobian[rows])[-1] < 1e-6:
            return None
        square = len(rows) == system.starts[-1] and len(felt) == position.size - 3
        picked = (slice(None), slice(None)) if square else np.ix_(rows, felt)
        return cls(
            system,
            rows,
            felt,
            max(float(system.reach[1:].max()), float(np.abs(position[:, :2]).max())),
            picked,
        )

    @property
    def redundant(self) -> bool:
        """Whether some rows depend on the others."""
        return len(self.rows) < self.system.starts[-1]

    def closed(self, guess: Array, aims: Array, quick: bool = False) -> tuple[Array, Array] | None:
        """Return the closed position near a guess and its square matrix; None if Newton's method does not
        close it. ``quick``: the matrix may be that of a position next to it, which saves one evaluation.
        """
        position, best = guess, math.inf
        for _ in range(NEWTON):
            phi, jacobian = self.system.dense_rows(position, aims)
            size, square = float(np.abs(phi[self.rows]).max()), jacobian[self.picked]
            if size <= CLOSED * self.extent:
                return (position, square) if np.abs(phi).max() <= 1e3 * CLOSED * self.extent else None
            if size > 4.0 * best:
                return None
            best = min(best, size)
            step = self.solved(square, phi[self.rows])
            if step is None:
                return None
            position = position - step
            if (
                quick
                and size <= QUICK * self.extent
                and len(self.rows) == self.system.starts[-1]
                and self.moved(step) <= SHORT_STEP * self.extent
            ):
                return position, square  # squared by this step; the matrix is as near as the position was
        return None

    def solved(self, square: Array, right: Array) -> Array | None:
        """Return J^-1 right as a change of position [n, 3]; None if a body would turn by half a turn or
        more.
        """
        step = self.solved_freely(square, right)
        return (
            step
            if step is not None and np.isfinite(step).all() and np.abs(step.ravel()[2::3]).max() < math.pi
            else None
        )

    def moved(self, step: Array) -> float:
        """Return the size (m) of a step: its largest coordinate in (x, y, l theta)."""
        return float(np.abs(step[1:].ravel() * self.system.metric[0]).max())

    def velocity(self, square: Array, rate: Array) -> Array | None:
        """Return dq/ds [n, 3] for drives that move at ``rate`` [d]; None at a singular position."""
        right = np.zeros(self.system.starts[-1])
        right[self.system.joint_rows :] = self.system.drive_lengths * rate
        return self.solved_freely(square, right[self.rows])

    def solved_freely(self, square: Array, right: Array) -> Array | None:
        """Return J^-1 right like :meth:`solved`, of any size; None for a singular matrix."""
        try:
            answer = dense.solve(square, right)
        except np.linalg.LinAlgError:
            return None
        step = np.zeros(len(self.system.metric[0]))
        step[self.columns] = answer
        return of_bodies(step / self.system.metric[0])

    def stress(self, square: Array) -> Array:
        """Return the self-stress [rows] of a nearly singular matrix: absolute multipliers that load the
        bodies least, the largest being 1. Rows with a part in it belong to the loop that jams.
        """
        left = dense.svd(square)[0][:, -1]
        stress = np.zeros(self.system.starts[-1])
        stress[self.rows] = np.abs(left) / np.abs(left).max()
        return stress


def follow(
    follower: Follower, position: Array, aims: Aims, rates: Aims, length: float, pace: float = PACE
) -> Passage:
    """Follow a way of ``length`` from a closed position [n, 3]; ``aims`` and ``rates`` return the drives'
    values and rates [d] at a place on the way, ``pace`` is the largest stride.
    """
    visits: list[Visit] = []
    result = _follow(follower, position, aims, rates, length, pace, visits)
    losses = singular_between(follower, visits, aims)
    if not losses:
        return result
    singular = sorted([*result.singular, *losses], key=lambda pair: pair[0])[:MOST_SINGULAR]
    return replace(result, singular=tuple(singular))


def _follow(
    follower: Follower,
    position: Array,
    aims: Aims,
    rates: Aims,
    length: float,
    pace: float,
    visits: list[Visit],
) -> Passage:
    """Follow a way; add the positions of a mechanism with redundant joints to ``visits``."""
    start = follower.closed(position, aims(0.0))
    if start is None:
        return Passage(0.0, position, False, None, ())
    (position_there, square), at = start, 0.0
    result: list[tuple[float, Array]] = []
    sign = dense.determinant_sign(square)
    going, bend, stride = (
        follower.velocity(square, rates(0.0)),
        np.zeros_like(position),
        0.382 * pace,
    )  # a change point lies at a round angle
    for _ in range(MOST_STRIDES):
        if at >= length * (1.0 - 1e-12):
            break
        if going is None:
            return Passage(at, position_there, True, follower.stress(square), tuple(result))
        if follower.redundant and (not visits or at > visits[-1].place):
            visits.append(visit(follower, at, position_there, going, aims(at)))
        stride = min(stride, length - at)
        guess = position_there + stride * going + 0.5 * (stride * stride) * bend
        tried = follower.closed(
            guess, aims(at + stride), quick=stride > 0.2 * pace
        )  # in small steps lies what is singular
        if (
            tried is not None
            and follower.moved(tried[0] - guess)
            > ASTRAY * follower.moved(tried[0] - position_there) + 1e-9 * follower.extent
        ):
            tried = None
        turned = tried is not None and dense.determinant_sign(tried[1]) != sign
        if tried is not None and not turned:
            previous = going
            position_there, square = tried
            at += stride
            going = follower.velocity(square, rates(at))
            bend = (going - previous) / stride if going is not None else bend
            stride = min(2.0 * stride, pace, max(length - at, 1e-12))
        elif stride > (SINGULAR if turned else FINE):
            stride *= 0.5
        else:
            landing = _hopped(follower, position_there, going, bend, at, aims, length)
            if landing is None or len(result) == MOST_SINGULAR:
                return Passage(at, position_there, landing is None, follower.stress(square), tuple(result))
            result.append((at, follower.stress(square)))
            (position_there, square), at = landing
            sign, going = dense.determinant_sign(square), follower.velocity(square, rates(at))
            bend, stride = np.zeros_like(position_there), 0.382 * pace
    return Passage(at, position_there, False, None, tuple(result))


def _hopped(
    follower: Follower, position: Array, going: Array, bend: Array, at: float, aims: Aims, length: float
) -> tuple[tuple[Array, Array], float] | None:
    """Return position, matrix and place beyond a singular position, straight on; None if the mechanism does
    not close there or leaves the prediction.
    """
    if follower.moved(going) > 0.1 / HOP * follower.extent:  # so fast it only goes where it comes to its end
        return None
    hop = min(HOP, length - at)
    guess = position + hop * going + 0.5 * (hop * hop) * bend
    tried = follower.closed(guess, aims(at + hop))
    if (
        tried is None
        or follower.moved(tried[0] - guess) > ASTRAY * follower.moved(hop * going) + 1e-6 * follower.extent
    ):
        return None
    return tried, at + hop


TURN = 2.0 * math.pi
LOOKS = 720  # times at which a driver is sampled for its range
PARTS = 12  # least number of strides of a travel over the size of the mechanism
MOST_TURNS = 4  # a mechanism may take several turns to return to its start
RETURN_DISTANCE = 1e-6  # of the extent: distance from the start after a return
MOST_WAY_STRIDES = 400  # of several drivers together


@dataclass(frozen=True, eq=False)
class Way:
    """A way of ``length`` from the start: functions of the place on it for the drives' values ``aims`` [d]
    (rad, m), their ``rates`` [d] and the ``time`` (s), and the largest stride, ``pace``.

    ``turning``: the way is a rotation, after whole turns of which the mechanism may be at its start again.
    """

    aims: Callable[[float], Array]
    rates: Callable[[float], Array]
    length: float
    pace: float
    time: Callable[[float], float]
    turning: bool = False


def ways_of(mechanism: Mechanism, motion: Motion, duration: float) -> list[Way]:
    """Return the ways of all drivers that prescribe a motion within ``duration`` (s), in the system of
    ``motion``, which may be a mirror image.

    A single driver has two ways, from its start to its largest and to its smallest value, in the order of
    time: positions do not depend on its speed. Several drivers have one way, through time together.
    """
    drives = motion.system.drives
    by_name: dict[str, Driver] = {**kinematic_drivers(mechanism), **constraint_drivers(mechanism)}
    drivers = [by_name[drive.name] for drive in drives]
    signs = [motion.hand if drive.turns else 1.0 for drive in drives]
    start = np.array([drive.aim for drive in drives])
    size = float(motion.system.reach[1:].max())
    paces = np.array([PACE if drive.turns else size / PARTS for drive in drives])
    if len(drives) == 1:
        return _there_and_back(drivers[0], signs[0], start[0], duration, float(paces[0]), drives[0].turns)
    functions = [driver.motion(0.0) for driver in drivers]
    offsets = start - [sign * function(0.0)[0] for sign, function in zip(signs, functions, strict=True)]

    def sampled(place: float, derivative: int) -> Array:
        return np.array(
            [sign * function(place)[derivative] for sign, function in zip(signs, functions, strict=True)]
        )

    times = np.linspace(0.0, duration, LOOKS)
    fastest = max(
        float(np.abs(function.sampled(times)[:, 1]).max()) / pace
        for function, pace in zip(functions, paces, strict=True)
    )
    if fastest == 0.0:
        return []
    return [
        Way(
            lambda t: offsets + sampled(t, 0),
            lambda t: sampled(t, 1),
            min(duration, MOST_WAY_STRIDES / fastest),
            1.0 / fastest,
            lambda t: t,
        )
    ]


def _there_and_back(
    driver: Driver, sign: float, start: float, duration: float, pace: float, turns: bool
) -> list[Way]:
    """Return the ways of a single driver to its largest and its smallest value, in the order of time."""
    function = driver.motion(0.0)
    times = np.linspace(0.0, min(duration, function.period or duration), LOOKS)
    values = sign * function.sampled(times)[:, 0]
    values = values - values[0]
    result = []
    for towards in (1.0, -1.0):
        reach = towards * values
        length = float(reach.max())
        if length <= 0.0:
            continue

        def when(place: float, reach: Array = reach) -> float:
            end = int(np.argmax(reach >= place * (1.0 - 1e-12)))
            begin = max(end - 1, 0)
            step = reach[end] - reach[begin]
            return (
                float(times[begin] + (times[end] - times[begin]) * (place - reach[begin]) / step)
                if step > 0.0
                else float(times[end])
            )

        way = Way(
            lambda s, towards=towards: np.array([start + towards * s]),  # type: ignore[misc]
            lambda s, towards=towards: np.array([towards]),  # type: ignore[misc]
            length, min(pace, max(length / 4.0, 1e-3 * pace)), when, turns,
        )  # fmt: skip
        result.append((float(np.argmax(reach > 0.5 * min(length, 1.0))), way))
    return [way for _, way in sorted(result, key=lambda pair: pair[0])]


def followed(follower: Follower, start: Array, way: Way) -> Passage:
    """Follow a way to its end; a rotation turn by turn until the mechanism is at its start again, because
    nothing new can follow.
    """
    if not way.turning or way.length <= TURN:
        return follow(follower, start, way.aims, way.rates, way.length, way.pace)
    position, singular, done = start, [], 0.0
    for _ in range(MOST_TURNS):
        length = min(TURN, way.length - done)

        def aims(place: float, done: float = done) -> Array:
            return way.aims(done + place)

        result = follow(follower, position, aims, way.rates, length, way.pace)
        singular += [(done + place, stress) for place, stress in result.singular]
        done, position = done + result.reached, result.position
        off = position - start
        off[:, 2] -= TURN * np.round(off[:, 2] / TURN)
        felt = (off[1:].ravel() * follower.system.metric[0])[follower.columns]
        if (
            result.reached < length
            or np.abs(felt).max(initial=0.0) <= RETURN_DISTANCE * follower.extent
            or done >= way.length * (1.0 - 1e-12)
        ):
            return Passage(done, position, result.jammed, result.stressed, tuple(singular))
    return Passage(done, position, False, None, tuple(singular))
