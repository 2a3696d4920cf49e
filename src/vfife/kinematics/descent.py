"""Damped Newton steps to a closed position."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


@dataclass(frozen=True, eq=False)
class Closure:
    """A closed position [n,3] (m, m, rad), its largest open distance `residual` (m) and the steps it took."""

    position: Array
    residual: float
    iterations: int


def opened(system: RigidSystem, position: Array) -> tuple[Array, Matrix]:
    """phi and G at a position."""
    rows = equations(system, position)
    return rows.phi, rows.jacobian


def descend(system: RigidSystem, start: Array) -> Closure:
    """Reduce |phi| from a position [n,3] until it is round-off or falls no more; the result may still be open."""
    return _Descent(system, start).run()


class _Descent:
    """A position on its way, its damping, and the position that the last step was refused for."""

    def __init__(self, system: RigidSystem, start: Array) -> None:
        self.system, self.position, self.lengths = system, np.array(start), metric(system)[0]
        reach, joints = system.reach, system.held
        self.scale = reach[1:].max(initial=0.0)
        self.finest = np.finfo(float).eps * self.scale
        self.weight = np.repeat([1.0, DRIVE_WEIGHT], [joints, len(system.drives)])
        pace = [LARGEST_TURN * (reach[d.body_b] if d.turns else self.scale) for d in system.drives]
        self.limit = np.concatenate([np.full(joints, np.inf), pace])
        self.phi, self.jacobian = opened(system, self.position)
        self.damping, self.taken, self.going, self.seen = 0.1, 0, True, np.inf
        self.refused: Array | None = None
        self.look()

    def run(self) -> Closure:
        """Steps until the end."""
        while self.going:
            self.step()
            self.look_down()
        return Closure(self.position, float(np.abs(self.phi).max(initial=0.0)), self.taken)

    def look_down(self) -> None:
        """Ends at the bottom, where that is near and open: steps would only go to and fro across it."""
        if not self.going or self.taken not in LOOKS:
            return
        phi, before = self.phi, self.seen
        self.seen = dot(self.weight * self.weight, phi * phi)
        hindered = (np.abs(phi) > self.limit).any()
        if hindered or not isinstance(self.jacobian, np.ndarray) or np.abs(phi).max() <= OPEN * self.scale or self.seen < SLOW * before:
            return
        start, square = self.position, self.weight * self.weight

        def moved(change: Array) -> Array:
            there: Array = start.copy()
            there[1:] += (change / self.lengths).reshape(-1, 3)
            return there

        def slopes(change: Array) -> tuple[float, Array]:
            phi, jacobian = opened(self.system, moved(change))
            return dot(square, phi * phi), times(jacobian.T, 2.0 * (square * phi))

        found = bottom(slopes, float(self.scale), len(self.lengths))
        if found is not None:
            self.position = moved(found)
            self.phi, self.jacobian = opened(self.system, self.position)
            self.going = False

    def look(self) -> None:
        """What follows from phi: the error of this step, whose drives advance no faster than the joints can follow, and the least step."""
        self.error = np.clip(self.phi, -self.limit, self.limit)
        weighed = self.weight * self.error
        self.square, self.merit = dot(self.error, self.error), math.sqrt(dot(weighed, weighed))
        self.closed = np.abs(self.error).max(initial=0.0) <= self.finest
        self.least: DampedStep | None = None

    def step(self) -> None:
        """One more step, unless it is closed."""
        if self.closed:
            self.going = False
            return
        if self.least is None:
            self.least = DampedStep(weighted(self.weight, self.jacobian), self.weight * self.error)
        step = self.limited(self.least, self.damping * self.square / (self.scale * self.scale))
        if np.abs(step * self.lengths).max() <= self.finest:
            self.going = False
            return
        self.taken += 1
        trial = self.position.copy()
        trial[1:] += step.reshape(-1, 3)
        if self.refused is not None and (trial == self.refused).all():  # near round-off the damping grows for long before a position feels it
            self.damping *= 8.0
        else:
            self.take(trial)
        self.going = self.taken < STEPS

    def take(self, trial: Array) -> None:
        """Goes there where it is better."""
        phi, jacobian = opened(self.system, trial)
        left = self.weight * (phi - self.phi + self.error)
        if math.sqrt(dot(left, left)) < self.merit:
            self.position, self.phi, self.jacobian = trial, phi, jacobian
            self.damping, self.refused = max(self.damping / 4.0, 1e-6), None
            self.look()
        else:
            self.damping *= 8.0
            self.refused = trial

    def limited(self, least: DampedStep, damping: float) -> Array:
        """-(G^T G + damping)^-1 G^T error as a step in (x, y, theta), its turns limited.

        A step somewhat too long is shortened, for that keeps its joints together; one far too long comes from a dead
        centre nearby, and is damped until the other directions get their part.
        """
        while True:
            step: Array = -least(damping) / self.lengths
            excess = float(np.abs(step[2::3]).max()) / LARGEST_TURN
            if excess < 10.0:
                return step / max(1.0, excess)
            damping = max(4.0 * damping, RANK_TOLERANCE * RANK_TOLERANCE)
