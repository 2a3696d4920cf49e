"""A fast check whether mechanisms make a full turn of their single crank far from singular positions, from
positions at many angles at once.

The follower (:mod:`vfife.kinematics.follower`) closes some forty positions of a turn one after the other.
Here all of them are closed side by side, for all cases of a batch. A positive answer is certain; in all other
cases the follower decides. Evidence for one smooth motion is that the determinant keeps its sign and stays
away from zero, that positions follow from the velocities at both ends of each stride, and that the last
position is the first one (:meth:`_Corrector.sure`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numerics.dense import Solved, solve_with_determinant
from .initial import Motion
from .linalg import DENSE
from .system import alike, flat, metrics, of_bodies, rows_of

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

POSITIONS_PER_TURN = 36  # as far apart as the longest strides of the follower
LONG_STRIDE = 2  # predict every second position, and each one if that fails
# Smallest determinant of a turn, of its largest: a determinant that stays above it is taken not to change its
# sign between two angles.
DETERMINANT_MARGIN = 0.03
PREDICTION_TOLERANCE = 0.3  # of a stride: largest distance of a position from the one predicted by velocities
LAST_CORRECTION = 1e-5  # of the extent: the square of so small a correction is round-off
CLOSURE_TOLERANCE = 1e-6  # of the extent: distance of the position after a turn from the start
CORRECTIONS = 6
NARROW_STRIDE = 0.1  # of the distance of two positions of a turn: that of positions around an extreme


@dataclass(frozen=True, eq=False)
class FullTurn:
    """Positions [k, n, 3] of a mechanism at evenly spaced angles of its crank through a whole turn from the
    start, turning in ``direction`` (1 or -1).
    """

    direction: float
    positions: Array


def full_turns(
    motions: Sequence[Motion], speeds: Sequence[float], neighbour: FullTurn | None = None
) -> list[FullTurn | None]:
    """Return the full turn of each mechanism with a single crank, driven with a speed (rad/s, of which the
    sign matters), if it is certain; None leaves the question open.

    ``neighbour`` is the turn of a mechanism with slightly different lengths: Newton's steps from its
    positions close all positions at once. Without one, or if that fails, positions are predicted in strides
    along velocity and curvature, with one correction each, and then closed at once.
    """
    result: list[FullTurn | None] = [None] * len(motions)
    for members in alike([motion.system for motion in motions]):
        system = motions[members[0]].system
        columns = 3 * len(system.names) - 3
        one_crank = len(system.drives) == 1 and system.drives[0].turns and system.drives[0].body_a == 0
        if not one_crank or system.starts[-1] != columns or columns > DENSE:
            continue
        directions = {k: math.copysign(1.0, speeds[k]) * motions[k].hand for k in members}
        for direction in (1.0, -1.0):
            cases = [k for k in members if directions[k] == direction]
            turns = _turned([motions[k] for k in cases], direction, neighbour) if cases else []
            for k, turn in zip(cases, turns, strict=True):
                result[k] = turn
    return result


def positions_around(motions: Sequence[Motion], turns: Sequence[FullTurn], places: Array) -> Array:
    """Return closed positions [3, cases, n, 3] of mechanisms of one structure a degree before, at and after
    each case's angle ``places`` [cases] (rad) of its crank from the start; infinite or NaN where they
    do not close.
    """
    corrector = _Corrector(motions, 1.0)
    directions = np.array([turn.direction for turn in turns])
    places = places % (2.0 * math.pi)
    nearest = np.rint(places / corrector.stride).astype(np.intp)
    corrector.aim = corrector.aim + directions * places
    guesses = np.array([turn.positions[k] for turn, k in zip(turns, nearest, strict=True)])
    positions = np.repeat(guesses[None], 3, axis=0)
    offsets = NARROW_STRIDE * corrector.stride * np.array([-1.0, 0.0, 1.0])
    with np.errstate(all="ignore"):
        for _ in range(CORRECTIONS):
            positions = positions - corrector.of_bodies(corrector.step(positions, offsets)[0][..., 0])
    return positions


def _turned(motions: Sequence[Motion], direction: float, neighbour: FullTurn | None) -> list[FullTurn | None]:
    """Return the turns of mechanisms of one structure, by the cheapest guess that succeeds."""
    result: list[FullTurn | None] = [None] * len(motions)
    shape = motions[0].position.shape
    if neighbour is not None and neighbour.direction == direction and neighbour.positions.shape[1:] == shape:
        corrector = _Corrector(motions, direction)
        result = corrector.closed(corrector.prediction(neighbour.positions))
    for stride in (LONG_STRIDE, 1):
        if left := [k for k, turn in enumerate(result) if turn is None]:
            corrector = _Corrector([motions[k] for k in left], direction)
            for k, turn in zip(left, corrector.closed(corrector.walked(stride)), strict=True):
                result[k] = turn
    return result


class _Corrector:
    """Newton's method for determined mechanisms of one structure with one crank; positions are [angles,
    cases, n, 3].
    """

    def __init__(self, motions: Sequence[Motion], direction: float) -> None:
        systems = [motion.system for motion in motions]
        self.direction, self.rows, self.reach = direction, rows_of(systems), metrics(systems)[0]
        self.drive = len(systems[0].joints)
        self.aim = np.array([system.drives[0].aim for system in systems])
        self.rate = direction * np.array([system.drive_lengths[0] for system in systems])
        self.start = np.array(
            [motion.position * np.array([1.0, motion.hand, motion.hand]) for motion in motions]
        )
        self.extent = np.maximum(
            [system.reach[1:].max() for system in systems], np.abs(self.start[..., :2]).max(axis=(-2, -1))
        )
        self.stride = 2.0 * math.pi / POSITIONS_PER_TURN
        self.angles: Array = self.stride * np.arange(POSITIONS_PER_TURN + 1, dtype=np.float64)

    def closed(self, positions: Array) -> list[FullTurn | None]:
        """Close all positions from these guesses; return the turn of each case, None if its positions do not
        close or are not certainly those of one motion.
        """
        turns: list[FullTurn | None] = [None] * len(self.start)
        corrector, cases, positions = self, np.arange(len(turns)), positions.copy()
        # All angles of all cases take one Newton step at once. A case leaves the arrays after its last
        # correction, or at a singular matrix.
        for _ in range(CORRECTIONS):
            step, determinant = corrector.step(positions, self.angles)
            going = (determinant != 0.0).all(axis=0) & np.isfinite(step).all(axis=(0, 2, 3))
            correction = np.where(going[:, None], step[..., 0], 0.0)
            positions -= corrector.of_bodies(correction)
            last = going & (np.abs(correction).max(axis=(0, 2)) <= LAST_CORRECTION * corrector.extent)
            if last.any():
                closed = positions[:, last]
                sure = corrector.select(last).sure(closed, step[..., 1][:, last], determinant[:, last])
                for k in np.flatnonzero(sure).tolist():
                    turns[cases[last][k]] = FullTurn(self.direction, closed[:, k].copy())
            going &= ~last
            if not going.any():
                break
            if not going.all():
                corrector, cases, positions = corrector.select(going), cases[going], positions[:, going]
        return turns

    def select(self, chosen: Mask) -> _Corrector:
        """Select some of the cases."""
        result = copy(self)
        for name in ("reach", "aim", "rate", "start", "extent"):
            setattr(result, name, getattr(self, name)[chosen])
        result.rows = self.rows.select(chosen)
        return result

    def of_bodies(self, step: Array) -> Array:
        """Return steps (..., cases, 3(n-1)) in (x, y, l theta) as changes of positions (..., cases, n, 3)."""
        return of_bodies(step / self.reach)

    def at(self, positions: Array, angles: Array) -> tuple[Array, Array]:
        """Return phi and the entries of G [k, cases, ...] at ``angles`` (rad) from the start."""
        aims = (self.aim + self.direction * angles[:, None])[..., None]
        return self.rows.at(positions, self.rows.aimed(self.drive, aims))

    def step(self, positions: Array, angles: Array) -> Solved:
        """Return Newton's steps and velocities [k, cases, 3(n-1), 2] at ``angles`` (rad) from the start, and
        determinants [k, cases]: one elimination gives all three.
        """
        phi, entries = self.at(positions, angles)
        rate = np.zeros_like(phi)
        rate[..., -1] = self.rate
        return solve_with_determinant(self.rows.dense(entries), np.stack([phi, rate], axis=-1))

    def prediction(self, positions: Array) -> Array:
        """Return positions predicted from those of a similar mechanism [k, n, 3]: one Newton step of all
        cases, with the matrices of the first one.

        The error is of second order in the difference, as with own matrices, and the next steps remove it.
        """
        phi, entries = self.at(positions[:, None], self.angles)
        step = solve_with_determinant(self.rows.dense(entries[:, 0]), np.swapaxes(phi, 1, 2)).x
        return positions[:, None] - self.of_bodies(np.swapaxes(step, 1, 2))

    def walked(self, stride: int) -> Array:
        """Return positions predicted over ``stride`` angles at a time, each corrected once, with cubic
        polynomials through positions and velocities in between.
        """
        position, previous, angle = self.start[None].copy(), None, stride * self.stride
        positions, velocities = [], []
        for aim in self.angles[::stride]:
            step, _ = self.step(position, np.array([aim]))
            position = position - self.of_bodies(step[..., 0])
            going = self.of_bodies(angle * step[..., 1])
            positions.append(position[0])
            velocities.append(going[0])
            position = position + going + (0.0 if previous is None else 0.5 * (going - previous))
            previous = going
        y, v = np.array(positions), np.array(velocities)
        t = np.arange(stride).reshape(-1, 1, 1, 1) / stride
        rise, bend = y[1:] - y[:-1] - v[:-1], v[1:] - v[:-1]
        curve = y[:-1] + t[:, None] * (
            v[:-1] + t[:, None] * (3.0 * rise - bend + t[:, None] * (bend - 2.0 * rise))
        )
        return np.concatenate([np.moveaxis(curve, 0, 1).reshape(-1, *y.shape[1:]), y[-1:]])

    def sure(self, positions: Array, velocity: Array, determinant: Array) -> Mask:
        """Return whether closed positions are certainly one motion from the start and back, far from singular
        positions [cases].
        """
        size = np.abs(determinant)
        far = (np.sign(determinant) == np.sign(determinant[0])).all(axis=0) & (
            size.min(axis=0) > DETERMINANT_MARGIN * size.max(axis=0)
        )
        gap = positions[-1] - positions[0]
        gap[..., 2] -= 2.0 * math.pi * np.round(gap[..., 2] / (2.0 * math.pi))
        ends = np.abs(self.lengths(np.stack([gap, positions[0] - self.start]))).max(axis=(0, 2))
        moved = np.diff(self.lengths(positions), axis=0)
        start_rise, end_rise = self.stride * velocity[:-1], self.stride * velocity[1:]
        previous_rise, next_rise = np.roll(start_rise, 1, axis=0), np.roll(end_rise, -1, axis=0)
        # Each position is compared with the prediction from both ends of its stride. Between two angles the
        # mechanism might pass two singular positions, with the same sign of the determinant on both sides;
        # the velocities at the ends of such a stride do not fit its displacement.
        ahead = np.abs(moved - start_rise - 0.5 * (start_rise - previous_rise)).max(
            axis=-1
        ) <= PREDICTION_TOLERANCE * np.abs(start_rise).max(axis=-1)
        back = np.abs(moved - end_rise + 0.5 * (next_rise - end_rise)).max(
            axis=-1
        ) <= PREDICTION_TOLERANCE * np.abs(end_rise).max(axis=-1)
        return np.asarray(
            far & ahead.all(axis=0) & back.all(axis=0) & (ends <= CLOSURE_TOLERANCE * self.extent)
        )

    def lengths(self, positions: Array) -> Array:
        """Return positions (..., cases, n, 3) in (x, y, l theta), (..., cases, 3(n-1))."""
        return np.asarray(flat(positions) * self.reach)
