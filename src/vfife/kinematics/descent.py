"""Close positions of mechanisms, and open a position that cannot be closed at a single joint.

**Closing.** The problem is min |W phi(q)|^2, where phi are the open distances of joints and drives. It is
solved by damped Newton steps dq = -(G^T G + mu)^-1 G^T phi, of least norm in (x, y, l theta). The damping mu
vanishes with phi^2, so that steps converge quadratically, and redundant joints and free motions are both
permitted (Levenberg-Marquardt; Fan and Yuan, Computing 74 (2005) 23-39). A step that does not reduce |W phi|
is refused: the case stays where it is, and its damping grows, which shortens and turns the next step.
Refusals in a row have no limit of their own. Newton's method without damping would fail at redundant joints
and jump to another branch near dead centres.

**Batches.** All cases of a batch take their steps side by side. A case leaves the batch when it is closed,
when its step is round-off, when it is at the minimum of an open position, or after ``STEPS`` steps, refused
ones included. The caller decides whether a remaining distance is an error. Cases do not affect each other,
because every operation is elementwise or on one matrix at a time.

**Opening.** A position that cannot be closed is opened at the joint that closes its loop, by the method of
multipliers (:func:`parted`): the gap at that joint is what a user can interpret.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics import dense
from ..numerics.dense import dot, norm, product, times
from .linalg import DENSE, RANK_TOLERANCE, DampedStep
from .rows import ConstraintRows
from .system import RigidSystem, rows_of

Array = NDArray[np.float64]

# A displacement -> the function to be minimised there, a squared length, and its gradient.
Slopes = Callable[[Array], tuple[float, Array]]

# Limits of :func:`bottom`, which gives up after the first.
NEWTON_STEPS = 12  # largest number of steps to a minimum; those of a whole descent are STEPS
DIFFERENCE = 1e-6  # of the extent: distance of the gradients whose difference is a second derivative
ZERO_STEP = 1e-9  # of the extent: a step that is zero
ROUND = 1e-8  # of the largest curvature: smaller ones are rounding, or a free motion
LEVEL_SLOPE = 1e-6  # of the root of the function: a gradient there (largest component) that is zero
OTHER_MINIMUM = 0.2  # of the extent: a minimum further away is another one
# A minimum with less than this share of the first value is none to stop at: the descent still progresses.
LEAST_LEFT = 0.5


def bottom(slopes: Slopes, extent: float, count: int) -> Array | None:
    """Return the displacement [count] to the minimum near a place, or None if there is no such minimum.

    ``slopes`` returns the function and its gradient at a displacement; ``extent`` is a length to which
    displacements are compared. Newton's method with second derivatives by differences finds the minimum in a
    few steps. It must be curved upwards, be nearer than FAR, have a slope below LEVEL_SLOPE, and leave at
    least LEAST_LEFT of the function.
    """
    displacement, (cost, slope) = np.zeros(count), slopes(np.zeros(count))
    left = cost
    for _ in range(NEWTON_STEPS):
        curvature = np.column_stack(
            [slopes(displacement + change)[1] - slope for change in DIFFERENCE * extent * np.eye(count)]
        ) / (DIFFERENCE * extent)
        # Steps along directions without curvature (free motions) are left out.
        size, directions = dense.eigh(0.5 * (curvature + curvature.T))
        if size[0] < -ROUND * size[-1]:
            return None
        curved = size > ROUND * size[-1]
        step = -times(directions[:, curved] / size[curved], times(directions[:, curved].T, slope))
        displacement = displacement + step
        left, slope = slopes(displacement)
        if left < LEAST_LEFT * cost or np.abs(displacement).max() > OTHER_MINIMUM * extent:
            return None
        if np.abs(step).max() <= ZERO_STEP * extent:
            return (
                displacement
                if left <= cost and np.abs(slope).max() <= LEVEL_SLOPE * math.sqrt(left)
                else None
            )
    return None


LARGEST_TURN = 0.1  # rad that a body may turn in one step: longer steps can jump to another branch
# Weight of drives: a loop that cannot close must show its gap at the joints, not as a wrong driven angle.
DRIVE_WEIGHT = 30.0
STEPS = 400  # largest number of steps of a descent, refused ones included
# Numbers of steps, below STEPS, after which a case is checked for a minimum of an open position. Few cases
# need it, and the check costs second derivatives.
LOOKS = (12, 20, 30, 45, 70, 100, 150, 200, 300)
# A gap of an open position, of the extent; a case whose |phi|^2 fell by more than this factor since the last
# check still progresses.
OPEN, SLOW = 1e-6, 0.5


@dataclass(frozen=True, eq=False)
class Closure:
    """The end of a descent: the ``position`` [n, 3] (m, m, rad), its largest open distance ``residual`` (m),
    and the number of steps.
    """

    position: Array
    residual: float
    iterations: int


def descend(systems: Sequence[RigidSystem], starts: Array) -> list[Closure]:
    """Reduce |phi| of systems of one structure from positions [cases, n, 3] until it is round-off or does not
    decrease any more; return the position of each case, which may still be open.
    """
    if 3 * len(systems[0].names) - 3 > DENSE and len(systems) > 1:
        return [descend([system], start[None])[0] for system, start in zip(systems, starts, strict=True)]
    result: list[Closure | None] = [None] * len(systems)
    descent = _Descent.of(systems, starts)
    for steps in range(STEPS + 1):
        descent = descent.without(
            descent.closed if steps < STEPS else np.ones(len(descent.number), dtype=bool), steps, result
        )
        if not len(descent.number):
            break
        step = descent.step()
        standing = np.abs(step * descent.lengths).max(axis=-1) <= descent.finest
        descent, step = descent.without(standing, steps, result), step[~standing]
        if not len(descent.number):
            break
        descent.advance(step)
        if steps + 1 in LOOKS:
            descent = descent.without(descent.at_the_bottom(systems), steps + 1, result)
    return [closure for closure in result if closure is not None]


@dataclass(eq=False)
class _Descent:
    """The cases that have not ended, by ``number``: their positions, open distances, and the state of the
    method.

    ``finest`` is the largest step (m) that counts as zero; ``closed``: whether a case is closed to that.
    ``error`` is phi with drives limited to ``limit``: drives advance no faster than the joints can follow.
    ``damping`` is mu as a multiple of |error|^2 / scale^2. ``refused`` is the position of a refused last
    step, NaN if it was taken. ``cost`` is |W phi|^2 at the last check for a minimum. ``solver`` solves the
    damped equations; ``lengths`` are l in (x, y, l theta), ``scale`` (m) the extent.
    """

    rows: ConstraintRows
    weight: Array
    number: NDArray[np.intp]
    position: Array
    lengths: Array
    scale: Array
    finest: Array
    limit: Array
    phi: Array
    jacobian: Any  # [cases, r, 3(n-1)], or an array of one sparse matrix
    damping: Array
    error: Array
    closed: NDArray[np.bool_]
    refused: Array
    cost: Array
    solver: DampedStep

    @classmethod
    def of(cls, systems: Sequence[RigidSystem], starts: Array) -> _Descent:
        """Return all cases at their starts."""
        first, count, rows = systems[0], len(systems), rows_of(systems)
        lengths = np.array([system.metric[0] for system in systems])
        scale = np.array([system.reach[1:].max(initial=0.0) for system in systems])
        pace = [LARGEST_TURN * (rows.reach[:, d.body_b] if d.turns else scale) for d in first.drives]
        limit = np.concatenate(
            [np.full((count, first.joint_rows), np.inf), *(limits[:, None] for limits in pace)], axis=1
        )
        phi, entries = rows.at(starts)
        jacobian = rows.matrices(entries)
        weight = np.repeat([1.0, DRIVE_WEIGHT], [first.joint_rows, len(first.drives)])
        error, finest = np.clip(phi, -limit, limit), np.finfo(float).eps * scale
        result = cls(
            rows, weight, np.arange(count), starts.copy(), lengths, scale, finest, limit, phi, jacobian,
            np.full(count, 0.1), error, _within(error, finest),
            np.full_like(starts, np.nan), np.full(count, np.inf), DampedStep.empty(jacobian),
        )  # fmt: skip
        result.solver.update(~result.closed, weight, jacobian, result.error)
        return result

    def without(self, leaving: NDArray[np.bool_], steps: int, result: list[Closure | None]) -> _Descent:
        """Return the cases without those that are ``leaving`` after ``steps`` steps, whose ends are put into
        ``result``.
        """
        if not leaving.any():
            return self
        residuals = np.abs(self.phi).max(axis=-1, initial=0.0).tolist()
        for k, number in zip(np.flatnonzero(leaving).tolist(), self.number[leaving].tolist(), strict=True):
            result[number] = Closure(self.position[k], residuals[k], steps)
        stay = ~leaving
        names = {attribute.name for attribute in fields(self)} - {"rows", "weight", "solver"}
        arrays = {name: getattr(self, name)[stay] for name in names}
        return replace(self, rows=self.rows.select(stay), solver=self.solver.select(stay), **arrays)

    def step(self) -> Array:
        """Return the steps -(G^T G + damping)^-1 G^T error in (x, y, theta) [cases, 3(n-1)], with limited
        turns.

        A step that is somewhat too long is shortened, which keeps its joints together. A step that is ten
        times too long comes from a dead centre nearby: shortened, it would be nothing but that direction.
        Its damping grows instead, until the other directions have their share.
        """
        damping = self.damping * dot(self.error, self.error) / (self.scale * self.scale)
        while True:
            step = -self.solver(damping) / self.lengths
            excess = np.abs(step[:, 2::3]).max(axis=-1) / LARGEST_TURN
            if (excess < 10.0).all():
                return np.asarray(step / np.maximum(1.0, excess)[:, None])
            damping = np.where(
                excess < 10.0, damping, np.maximum(4.0 * damping, RANK_TOLERANCE * RANK_TOLERANCE)
            )

    def advance(self, step: Array) -> None:
        """Take the step in each case in which it reduces the error; increase the damping of the others."""
        trial = self.position.copy()
        trial[:, 1:] += step.reshape(len(trial), -1, 3)
        # Near round-off the damping grows for many steps before it changes the position: the same position is
        # then refused again without computing its rows. The shortcut needs all cases, but gives each the same
        # result as below.
        if (trial == self.refused).all():
            self.damping = self.damping * 8.0
            return
        phi, entries = self.rows.at(trial)
        # The gain is judged by the error of this step, not by all of phi: the large distance of a drive from
        # its aim, which decreases by its limit only, would hide that joints open.
        left, weighed = self.weight * (phi - self.phi + self.error), self.weight * self.error
        better = np.sqrt(dot(left, left)) < np.sqrt(dot(weighed, weighed))
        self.damping = np.where(better, np.maximum(self.damping / 4.0, 1e-6), self.damping * 8.0)
        self.refused = np.where(better[:, None, None], np.nan, trial)
        if better.any():
            self.position = np.where(better[:, None, None], trial, self.position)
            self.phi = np.where(better[:, None], phi, self.phi)
            self.jacobian[better] = self.rows.matrices(entries)[better]
            self.error = np.clip(self.phi, -self.limit, self.limit)
            self.closed = _within(self.error, self.finest)
            self.solver.update(better & ~self.closed, self.weight, self.jacobian, self.error)

    def at_the_bottom(self, systems: Sequence[RigidSystem]) -> NDArray[np.bool_]:
        """Return which cases are at the minimum of an open position, and move them there.

        Near such a minimum G^T phi vanishes while phi does not, so that damping stays large, and steps would
        go to and fro across it.
        """
        previous_cost, self.cost = self.cost, dot(self.weight * self.weight, self.phi * self.phi)
        size = np.abs(self.phi)
        hindered = (
            (size > self.limit).any(axis=-1)
            | (size.max(axis=-1) <= OPEN * self.scale)
            | (self.cost < SLOW * previous_cost)
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
        """Return the position [n, 3] of the minimum near an open position, or None."""
        square, rows = self.weight * self.weight, system.constraint_rows

        def moved(change: Array) -> Array:
            position: Array = start.copy()
            position[1:] += (change / lengths).reshape(-1, 3)
            return position

        def slopes(change: Array) -> tuple[float, Array]:
            phi, entries = rows.at(moved(change))
            return dot(square, phi * phi), times(rows.dense(entries).T, 2.0 * (square * phi))

        result = bottom(slopes, scale, len(lengths))
        return None if result is None else moved(result)


def _within(error: Array, finest: Array) -> NDArray[np.bool_]:
    """Return in which cases no error [cases, r] is larger than ``finest`` [cases]."""
    return np.asarray(np.abs(error).max(axis=-1, initial=0.0) <= finest)


FELT = 1e-3  # share of the largest self-stress from which a row takes part in a loop
CLOSED_WEIGHT = 10.0  # weight of the joints that stay closed, relative to the one that opens
OPENING_TURN = 0.3  # rad that a body may turn in a step of the opening
CLOSE = 1e-10  # of the extent: a closed joint
ROUNDS, OPENING_STEPS = 8, 40  # largest numbers of updates of the multipliers, and of steps in each
FINEST = 1e-9  # of the extent: a step of the opening that is zero


def closing_joint(system: RigidSystem, rows: Array | None = None) -> int | None:
    """Return the number of the joint that closes the loop of the rows that take part: all rows, or those with
    a self-stress in ``rows`` [rows]; None without a loop.

    Bodies are joined to the ground in breadth-first order. The result is, among the joints that are left
    over, the one between the two bodies farthest from the ground.
    """
    part = [
        k for k in range(len(system.joints)) if rows is None or rows[system.rows(k)].max(initial=0.0) > FELT
    ]
    depth, hung, waiting = {0: 0}, set(), [0]
    while waiting:
        body = waiting.pop(0)
        for k in part:
            link = system.joints[k]
            neighbour = link.body_b if link.body_a == body else link.body_a
            if body in (link.body_a, link.body_b) and neighbour not in depth:
                depth[neighbour] = depth[body] + 1
                hung.add(k)
                waiting.append(neighbour)
    left = [
        k
        for k in part
        if k not in hung and system.joints[k].body_a in depth and system.joints[k].body_b in depth
    ]
    return max(
        left, key=lambda k: depth[system.joints[k].body_a] + depth[system.joints[k].body_b], default=None
    )


class Parted(NamedTuple):
    """A position [n, 3] in which all joints except one are closed, and that one is open by the smallest
    possible ``gap`` (m).

    ``pulls`` [rows] (m) are the multipliers: a change d phi of the rows, at this position, changes the gap by
    pulls . d phi / gap.
    """

    position: Array
    gap: float
    pulls: Array


def parted(system: RigidSystem, joint: int, aims: Array, guess: Array) -> Parted:
    """Open a joint by as little as its loop allows, near a guess [n, 3]; ``aims`` are the values of drives.

    The method of multipliers (augmented Lagrangian) minimises the gap subject to all other rows. Their
    distances after each minimisation are added to ``shift``, until they vanish. A penalty alone would have to
    be very large, and then the problem is ill-conditioned.
    """
    opened, extent, count = system.rows(joint), float(system.reach[1:].max()), system.starts[-1]
    weight, shift, position = np.full(count, CLOSED_WEIGHT), np.zeros(count), guess
    weight[opened] = 1.0
    for _ in range(ROUNDS):
        position, phi = _least(system, aims, weight, shift, position)
        shift += phi
        shift[opened] = 0.0
        if np.abs(np.delete(phi, np.arange(opened.start, opened.stop))).max(initial=0.0) <= CLOSE * extent:
            break
    pulls = CLOSED_WEIGHT * CLOSED_WEIGHT * shift
    pulls[opened] = phi[opened]
    return Parted(position, norm(phi[opened]), pulls)


def _least(
    system: RigidSystem, aims: Array, weight: Array, shift: Array, position: Array
) -> tuple[Array, Array]:
    """Return the position with the least |weight (phi + shift)|, found by damped Gauss-Newton steps, and phi
    there.
    """
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
