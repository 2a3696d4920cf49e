"""Damped Newton steps to a closed position, of one mechanism or of many members side by side, none of which knows of the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..fields.members import Differing, Members, chosen, several
from ..numerics.products import dot, times
from .bottom import bottom
from .linalg import RANK_TOLERANCE, DampedStep, Matrix, weighted
from .system import RigidSystem, equations, metric

Array = NDArray[np.float64]

LARGEST_TURN = 0.1  # rad a body may turn in one step: longer steps can jump to the other branch
DRIVE_WEIGHT = 30.0  # a loop that cannot close must show its gap at the joints, not as a false driven angle
STEPS = 400
LOOKS = (12, 20, 30, 45, 70, 100, 150, 200, 300)  # steps after which it is looked whether this is the bottom
OPEN, SLOW = 1e-6, 0.5  # of the extent: a gap; of |phi|^2 at the look before: less is a good way down
FEWER = 0.7  # of the members that go on: so few leave the others behind


@dataclass(frozen=True, eq=False)
class Closure:
    """A closed position [n,3] (m, m, rad), its largest open distance `residual` (m) and the steps it took."""

    position: Array
    residual: Any
    iterations: Any


def opened(system: RigidSystem, position: Array) -> tuple[Array, Matrix]:
    """phi and G at a position."""
    rows = equations(system, position)
    return rows.phi, rows.jacobian


def descend(system: RigidSystem, start: Array) -> Closure:
    """Reduce |phi| from a position [n,3] until it is round-off or falls no more; the result may still be open. Of members from (members, n, 3)."""
    many = bool(several(start))
    position = np.array(start).reshape(-1, *start.shape[-2:])
    descent = _Descent(system, position, many)
    return descent.run()


class _Descent:
    """Members on their way: each its position, damping, and the position that its last step was refused for."""

    def __init__(self, system: RigidSystem, position: Array, many: bool) -> None:
        self.system, self.position, self.many = system, position, many
        reach, count, joints = np.asarray(system.reach).reshape(-1, len(system.names)), len(position), system.held
        self.lengths = np.asarray(metric(system)[0]).reshape(len(reach), -1)
        self.scale = reach[:, 1:].max(axis=-1, initial=0.0)
        self.finest = np.finfo(float).eps * self.scale
        self.weight = np.repeat([1.0, DRIVE_WEIGHT], [joints, len(system.drives)])
        pace = [LARGEST_TURN * (reach[:, d.body_b] if d.turns else self.scale) for d in system.drives]
        self.limit = np.column_stack([np.full((len(reach), joints), np.inf), *pace])
        self.phi, self.jacobian = self.opened(position)
        self.damping, self.taken = np.full(count, 0.1), np.zeros(count, dtype=int)
        self.going, self.fresh = np.ones(count, dtype=bool), np.ones(count, dtype=bool)
        self.seen = np.inf
        self.refused, self.least, self.changed = np.full_like(position, np.nan), DampedStep(), True

    def closure(self) -> Closure:
        """Where they are."""
        residual = np.abs(self.phi).max(axis=-1, initial=0.0)
        if self.many:
            return Closure(self.position.view(Members), residual.view(Members), self.taken)
        return Closure(self.position[0], float(residual[0]), int(self.taken[0]))

    def compact(self) -> Closure:
        """The rest of the way of those that still go on, without the others."""
        which = np.flatnonzero(self.going)
        rest = _Descent(chosen(self.system, which), self.position[which], True)
        for name in ("phi", "jacobian", "damping", "taken", "fresh", "refused"):
            setattr(rest, name, getattr(self, name)[which])
        rest.least = self.least.some(which)
        try:
            found = rest.run()
        except Differing as apart:
            where = np.ones(len(self.going), dtype=bool)
            where[which] = apart.where
            raise Differing(where) from None
        end = self.closure()
        for mine, theirs in ((end.position, found.position), (end.residual, found.residual), (end.iterations, found.iterations)):
            mine[which] = theirs
        return end

    def run(self) -> Closure:
        """Steps until none goes on."""
        while self.going.any():
            if self.many and self.going.sum() < FEWER * len(self.going):
                return self.compact()
            self.step()
            if not self.many and self.going[0] and int(self.taken[0]) in LOOKS:
                self.look_down()
        return self.closure()

    def look_down(self) -> None:
        """Ends at the bottom, where that is near and open: steps would only go to and fro across it."""
        phi, before = self.phi[0], self.seen
        self.seen = dot(self.weight * self.weight, phi * phi)
        hindered = (np.abs(phi) > self.limit[0]).any()
        if hindered or not isinstance(self.jacobian, np.ndarray) or np.abs(phi).max() <= OPEN * self.scale[0] or self.seen < SLOW * before:
            return
        start, lengths, square = self.position[0], self.lengths[0], self.weight * self.weight

        def moved(change: Array) -> Array:
            there: Array = start.copy()
            there[1:] += (change / lengths).reshape(-1, 3)
            return there

        def slopes(change: Array) -> tuple[float, Array]:
            phi, jacobian = opened(self.system, moved(change))
            return dot(square, phi * phi), times(jacobian.T, 2.0 * (square * phi))

        found = bottom(slopes, float(self.scale[0]), len(lengths))
        if found is not None:
            self.position = moved(found)[None]
            self.phi, self.jacobian = self.opened(self.position)
            self.going[:] = False

    def opened(self, position: Array) -> tuple[Array, Matrix]:
        """phi [members, r] and G."""
        if self.many:
            phi, jacobian = opened(self.system, position.view(Members))
            return np.asarray(phi), np.asarray(jacobian)
        phi, jacobian = opened(self.system, position[0])
        return phi[None], jacobian[None] if isinstance(jacobian, np.ndarray) else jacobian

    def look(self) -> None:
        """What follows from phi: the error of this step, whose drives advance no faster than the joints can follow, and whose is round-off."""
        self.error = np.clip(self.phi, -self.limit, self.limit)
        self.square, self.merit = _square(self.error), np.sqrt(_square(self.weight * self.error))
        self.closed = np.abs(self.error).max(axis=-1, initial=0.0) <= self.finest
        self.changed = False

    def step(self) -> None:
        """One more of each that goes on."""
        if self.changed:
            self.look()
        self.going &= ~self.closed
        if not self.going.any():
            return
        fresh = self.fresh & self.going
        if fresh.any():
            self.least.take(fresh, weighted(self.weight, self.jacobian), self.weight * self.error)
            self.fresh &= ~fresh
        step = self.limited(self.damping * self.square / (self.scale * self.scale))
        self.going &= ~(np.abs(step * self.lengths).max(axis=-1) <= self.finest)
        self.taken += self.going
        trial = self.position.copy()
        trial[:, 1:] += step.reshape(len(trial), -1, 3)
        again = self.going & (trial == self.refused).all(axis=(1, 2))  # near round-off the damping grows for long before a position feels it
        self.damping[again] *= 8.0
        looked = self.going & ~again
        if looked.any():
            self._take(looked, trial)
        self.going &= self.taken < STEPS

    def _take(self, looked: NDArray[np.bool_], trial: Array) -> None:
        """Goes there where it is better."""
        phi, jacobian = self.opened(trial)
        better = looked & (np.sqrt(_square(self.weight * (phi - self.phi + self.error))) < self.merit)
        worse = looked & ~better
        if better.any():
            self.position[better], self.phi[better] = trial[better], phi[better]
            self.jacobian = jacobian if better.all() else np.where(better[:, None, None], jacobian, self.jacobian)
            self.damping[better] = np.maximum(self.damping[better] / 4.0, 1e-6)
            self.refused[better] = np.nan
            self.fresh |= better
            self.changed = True
        self.damping[worse] *= 8.0
        self.refused[worse] = trial[worse]

    def limited(self, damping: Array) -> Array:
        """-(G^T G + damping)^-1 G^T error as a step in (x, y, theta), its turns limited.

        A step somewhat too long is shortened, for that keeps its joints together; one far too long comes from a dead
        centre nearby, and is damped until the other directions get their part.
        """
        while True:
            step: Array = -self.least(damping) / self.lengths
            excess = np.abs(step[:, 2::3]).max(axis=-1) / LARGEST_TURN
            far = ~(excess < 10.0) & self.going
            if not far.any():
                break
            damping = np.where(far, np.maximum(4.0 * damping, RANK_TOLERANCE * RANK_TOLERANCE), damping)
        return np.asarray(step / np.maximum(1.0, excess)[:, None])


def _square(vectors: Array) -> Any:
    """Sum of squares of each."""
    return dot(vectors, vectors)
