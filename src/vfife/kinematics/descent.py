"""Closing positions, and opening them at a single joint.

Positions are closed by damped Newton steps of all cases of a batch side by side, each of which goes its own
way. Solved is min |W phi(q)|^2 by dq = -(G^T G + mu)^-1 G^T phi, of least norm in (x, y, l theta). The
damping mu vanishes with phi^2, so that steps converge quadratically, and redundant joints and free motions
are both allowed (Levenberg-Marquardt; Fan and Yuan, Computing 74 (2005) 23-39). A step that does not reduce
|W phi| is not taken: the case stays where it is, and its damping grows, which shortens and turns the next
step. Refusals in a row have no limit of their own. A case leaves the batch when it is closed, when its step
is round-off, when it is at the bottom of an open position, or after ``STEPS`` steps, refused ones included;
whether what is left open is an error is for the caller to say. Until then no case sees another one, since
every operation is elementwise or on one matrix at a time.

A position that cannot be closed is opened at the joint that closes its loop, by the method of multipliers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics import dense
from ..numerics.products import dot, norm, product, times
from .linalg import DENSE, RANK_TOLERANCE, DampedStep
from .rows import ConstraintRows
from .system import RigidSystem, rows_of

Array = NDArray[np.float64]

Slopes = Callable[[Array], tuple[float, Array]]  # a place -> what is to be least, and its derivatives

NEWTON = 12  # steps to a bottom at most
DIFFERENCE = 1e-6  # of the extent, of places whose slopes make a second derivative
THERE = 1e-9  # of the extent: a step that is none
ROUND = 1e-8  # of the largest curvature: less is rounding, or a free motion
LEVEL = 1e-6  # of the root of what is left: a slope that is none
FAR = 0.2  # of the extent: further away it is another bottom
MOST = 0.5  # of what is there now is left at the bottom, or more: else the way down has not come to an end


def bottom(slopes: Slopes, extent: float, count: int) -> Array | None:
    """How far the bottom lies from here, [count], where it is one: curved upwards, near, and no more than
    half as deep again; None where not.
    """
    here, (now, slope) = np.zeros(count), slopes(np.zeros(count))
    left = now
    for _ in range(NEWTON):
        curvature = np.column_stack(
            [slopes(here + change)[1] - slope for change in DIFFERENCE * extent * np.eye(count)]
        ) / (DIFFERENCE * extent)
        size, along = dense.eigh(0.5 * (curvature + curvature.T))
        if size[0] < -ROUND * size[-1]:
            return None
        curved = size > ROUND * size[-1]
        step = -times(along[:, curved] / size[curved], times(along[:, curved].T, slope))
        here = here + step
        left, slope = slopes(here)
        if left < MOST * now or np.abs(here).max() > FAR * extent:
            return None
        if np.abs(step).max() <= THERE * extent:
            return here if left <= now and np.abs(slope).max() <= LEVEL * math.sqrt(left) else None
    return None


LARGEST_TURN = 0.1  # rad a body may turn in one step: longer steps can jump to the other branch
DRIVE_WEIGHT = 30.0  # a loop that cannot close must show its gap at the joints, not as a false driven angle
STEPS = 400  # at most, taken and refused ones
LOOKS = (12, 20, 30, 45, 70, 100, 150, 200, 300)  # steps after which it is looked whether this is the bottom
OPEN, SLOW = 1e-6, 0.5  # of the extent: a gap; of |phi|^2 at the look before: less is a good way down


@dataclass(frozen=True, eq=False)
class Closure:
    """A closed position [n,3] (m, m, rad), its largest open distance `residual` (m) and the steps it took."""

    position: Array
    residual: float
    iterations: int


def descend(systems: Sequence[RigidSystem], starts: Array) -> list[Closure]:
    """Reduce |phi| of systems of one structure from positions [cases, n, 3] until it is round-off or falls no
    more; a position may still be open then.
    """
    if 3 * len(systems[0].names) - 3 > DENSE and len(systems) > 1:
        return [descend([system], start[None])[0] for system, start in zip(systems, starts, strict=True)]
    result: list[Closure | None] = [None] * len(systems)
    now = _Descent.of(systems, starts)
    for steps in range(STEPS + 1):
        now = now.without(
            now.closed() if steps < STEPS else np.ones(len(now.number), dtype=bool), steps, result
        )
        if not len(now.number):
            break
        step = now.step()
        none = np.abs(step * now.lengths).max(axis=-1) <= now.finest
        now, step = now.without(none, steps, result), step[~none]
        if not len(now.number):
            break
        now.advance(step)
        if steps + 1 in LOOKS:
            now = now.without(now.at_the_bottom(systems), steps + 1, result)
    return [one for one in result if one is not None]


@dataclass(eq=False)
class _Descent:
    """Cases on their way, by ``number``: where they are, what is open there, the error of the next step, and
    the place their last step was refused.

    ``error`` is phi, the drives advancing no faster than the joints can follow: no more than ``limit`` in a
    step. ``damping`` is mu as a multiple of |error|^2 / scale^2. ``refused`` is NaN where the last step was
    taken. ``cost``: |W phi|^2 at the last look for a bottom.
    """

    rows: ConstraintRows
    weight: Array
    number: NDArray[np.intp]
    position: Array
    lengths: Array
    scale: Array
    limit: Array
    phi: Array
    jacobian: Any  # [cases, r, 3(n-1)], or an array of one sparse matrix
    damping: Array
    error: Array
    refused: Array
    cost: Array
    least: DampedStep

    @classmethod
    def of(cls, systems: Sequence[RigidSystem], starts: Array) -> _Descent:
        """At the start."""
        first, count, rows = systems[0], len(systems), rows_of(systems)
        lengths, scale = (
            np.array([one.metric[0] for one in systems]),
            np.array([one.reach[1:].max(initial=0.0) for one in systems]),
        )
        pace = [LARGEST_TURN * (rows.reach[:, d.body_b] if d.turns else scale) for d in first.drives]
        limit = np.concatenate(
            [np.full((count, first.held), np.inf), *(one[:, None] for one in pace)], axis=1
        )
        phi, entries = rows.at(starts)
        jacobian, weight = (
            rows.matrices(entries),
            np.repeat([1.0, DRIVE_WEIGHT], [first.held, len(first.drives)]),
        )
        result = cls(
            rows, weight, np.arange(count), starts.copy(), lengths, scale, limit, phi, jacobian,
            np.full(count, 0.1), np.clip(phi, -limit, limit),
            np.full_like(starts, np.nan), np.full(count, np.inf), DampedStep.empty(jacobian),
        )  # fmt: skip
        result.least.update(~result.closed(), weight, jacobian, result.error)
        return result

    @property
    def finest(self) -> Array:
        """A step (m) that is none [cases]."""
        return np.finfo(float).eps * self.scale

    def closed(self) -> NDArray[np.bool_]:
        """Which are closed to round-off."""
        return np.asarray(np.abs(self.error).max(axis=-1, initial=0.0) <= self.finest)

    def without(self, leaving: NDArray[np.bool_], steps: int, result: list[Closure | None]) -> _Descent:
        """The cases that go on; those that have ended after so many steps are found."""
        if not leaving.any():
            return self
        for k in np.flatnonzero(leaving).tolist():
            result[self.number[k]] = Closure(
                self.position[k], float(np.abs(self.phi[k]).max(initial=0.0)), steps
            )
        parts = {
            one.name: getattr(self, one.name)
            for one in fields(self)
            if one.name not in ("rows", "weight", "least")
        }
        return replace(
            self,
            rows=self.rows.select(~leaving),
            least=self.least.select(~leaving),
            **{name: value[~leaving] for name, value in parts.items()},
        )

    def step(self) -> Array:
        """-(G^T G + damping)^-1 G^T error as steps in (x, y, theta) [cases, 3(n-1)], their turns limited.

        A step somewhat too long is shortened, for that keeps its joints together; one far too long comes from
        a dead centre nearby, and is damped until the other directions get their part.
        """
        damping = self.damping * dot(self.error, self.error) / (self.scale * self.scale)
        while True:
            step = -self.least(damping) / self.lengths
            excess = np.abs(step[:, 2::3]).max(axis=-1) / LARGEST_TURN
            if (excess < 10.0).all():
                return np.asarray(step / np.maximum(1.0, excess)[:, None])
            damping = np.where(
                excess < 10.0, damping, np.maximum(4.0 * damping, RANK_TOLERANCE * RANK_TOLERANCE)
            )

    def advance(self, step: Array) -> None:
        """Each case goes where it is better there; where not, its damping grows."""
        trial = self.position.copy()
        trial[:, 1:] += step.reshape(len(trial), -1, 3)
        # Near round-off the damping grows for long before a position feels it: what was refused is refused
        # again, without its rows being computed. This asks for all cases, but gives each what it gets below.
        if (trial == self.refused).all():
            self.damping = self.damping * 8.0
            return
        phi, entries = self.rows.at(trial)
        # The gain is judged by the error of this step, not by all of phi: a drive far from its aim advances
        # by its limit only, and would hide what the joints lose meanwhile.
        left, weighed = self.weight * (phi - self.phi + self.error), self.weight * self.error
        better = np.sqrt(dot(left, left)) < np.sqrt(dot(weighed, weighed))
        self.damping = np.where(better, np.maximum(self.damping / 4.0, 1e-6), self.damping * 8.0)
        self.refused = np.where(better[:, None, None], np.nan, trial)
        if better.any():
            self.position, self.phi = (
                np.where(better[:, None, None], trial, self.position),
                np.where(better[:, None], phi, self.phi),
            )
            self.jacobian[better] = self.rows.matrices(entries)[better]
            self.error = np.clip(self.phi, -self.limit, self.limit)
            self.least.update(better & ~self.closed(), self.weight, self.jacobian, self.error)

    def at_the_bottom(self, systems: Sequence[RigidSystem]) -> NDArray[np.bool_]:
        """Which are at the bottom, where that is near and open: steps would only go to and fro across it.
        They go there.
        """
        before, self.cost = self.cost, dot(self.weight * self.weight, self.phi * self.phi)
        size = np.abs(self.phi)
        hindered = (
            (size > self.limit).any(axis=-1)
            | (size.max(axis=-1) <= OPEN * self.scale)
            | (self.cost < SLOW * before)
        )
        leaving = np.zeros(len(hindered), dtype=bool)
        for k in np.flatnonzero(~hindered).tolist() if self.rows.columns <= DENSE else ():
            result = self._bottom(
                systems[self.number[k]], self.position[k], self.lengths[k], float(self.scale[k])
            )
            if result is not None:
                self.position[k], leaving[k] = result, True
                self.phi[k] = systems[self.number[k]].constraint_rows.at(result)[0]
        return leaving

    def _bottom(self, system: RigidSystem, start: Array, lengths: Array, scale: float) -> Array | None:
        """The position at the bottom near an open one [n, 3]; None where it is none."""
        square, rows = self.weight * self.weight, system.constraint_rows

        def moved(change: Array) -> Array:
            there: Array = start.copy()
            there[1:] += (change / lengths).reshape(-1, 3)
            return there

        def slopes(change: Array) -> tuple[float, Array]:
            phi, entries = rows.at(moved(change))
            return dot(square, phi * phi), times(rows.dense(entries).T, 2.0 * (square * phi))

        result = bottom(slopes, scale, len(lengths))
        return None if result is None else moved(result)


FELT = 1e-3  # part of the largest self-stress from which a row takes part
HELD = 10.0  # weight of the joints that stay closed
OPENING_TURN = 0.3  # rad in a step
CLOSE = 1e-10  # of the extent
ROUNDS, OPENING_STEPS = 8, 40  # at most: of the method of multipliers, and steps in each
FINEST = 1e-9  # of the extent: a step of the opening that is none; the descent has its own, down to round-off


def closing_joint(system: RigidSystem, rows: Array | None = None) -> int | None:
    """The joint, by number, that closes the loop of the rows that take part (all, unless a self-stress [rows]
    says so).

    Bodies are hung from the ground on, those nearest to it first; it is the joint left over between the two
    furthest from it.
    """
    part = [
        k for k in range(len(system.joints)) if rows is None or rows[system.rows(k)].max(initial=0.0) > FELT
    ]
    depth, hung, waiting = {0: 0}, set(), [0]
    while waiting:
        body = waiting.pop(0)
        for k in part:
            one = system.joints[k]
            other = one.body_b if one.body_a == body else one.body_a
            if body in (one.body_a, one.body_b) and other not in depth:
                depth[other] = depth[body] + 1
                hung.add(k)
                waiting.append(other)
    left = [
        k
        for k in part
        if k not in hung and system.joints[k].body_a in depth and system.joints[k].body_b in depth
    ]
    return max(
        left, key=lambda k: depth[system.joints[k].body_a] + depth[system.joints[k].body_b], default=None
    )


class Parted(NamedTuple):
    """A position [n, 3] in which everything but a joint is closed and that one is open least, by ``gap`` (m).

    ``pulls`` [rows] (m): d gap = pulls . d phi / gap, at a given position, of what changes the rows.
    """

    position: Array
    gap: float
    pulls: Array


def parted(system: RigidSystem, joint: int, aims: Array, guess: Array) -> Parted:
    """Opens a joint by as little as its loop allows, near a guess [n, 3], by the method of multipliers."""
    here, extent, count = system.rows(joint), float(system.reach[1:].max()), system.starts[-1]
    weight, shift, position = np.full(count, HELD), np.zeros(count), guess
    weight[here] = 1.0
    for _ in range(ROUNDS):
        position, phi = _least(system, aims, weight, shift, position)
        shift += phi
        shift[here] = 0.0
        if np.abs(np.delete(phi, np.arange(here.start, here.stop))).max(initial=0.0) <= CLOSE * extent:
            break
    pulls = HELD * HELD * shift
    pulls[here] = phi[here]
    return Parted(position, norm(phi[here]), pulls)


def _least(
    system: RigidSystem, aims: Array, weight: Array, shift: Array, position: Array
) -> tuple[Array, Array]:
    """The position with the least |weight (phi + shift)|, by damped Gauss-Newton steps, and phi there."""
    scale, extent = system.metric[0], float(system.reach[1:].max())
    (phi, jacobian), damping = system.dense_rows(position, aims), 1e-2
    for _ in range(OPENING_STEPS):
        error = weight * (phi + shift)
        weighted = weight[:, None] * jacobian
        step = dense.solve(
            product(weighted.T, weighted) + damping * np.eye(len(scale)), -times(weighted.T, error)
        )
        step /= max(1.0, float(np.abs(step / scale)[2::3].max()) / OPENING_TURN)
        if np.abs(step).max() <= FINEST * extent or damping > 1e9:
            break
        trial = position.copy()
        trial[1:] += (step / scale).reshape(-1, 3)
        tried, turned = system.dense_rows(trial, aims)
        if norm(weight * (tried + shift)) < norm(error):
            position, phi, jacobian, damping = trial, tried, turned, max(damping / 3.0, 1e-9)
        else:
            damping *= 4.0
    return position, phi
