"""Whether a mechanism makes a turn of its one crank far from singular positions, seen from positions at many
angles at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numerics.dense import Solved, solve_with_determinant
from .gathered import Gathered
from .initial import Motion
from .linalg import DENSE

Array = NDArray[np.float64]

ANGLES = 36  # in a turn, as far apart as the longest strides of the follower
WELL = 0.03  # of the largest determinant of a turn: what never falls below changes no sign between two angles
ASTRAY = 0.3  # of a stride, by which a position may be off the one predicted from velocities
QUICK = 1e-5  # of the extent: a correction this small squares to round-off
BACK = 1e-6  # of the extent: it has come back
CORRECTIONS = 6


@dataclass(frozen=True, eq=False)
class FullTurn:
    """Positions [k, n, 3] of a mechanism at evenly spaced angles of its crank, from the start through a whole
    turn.
    """

    towards: float
    positions: Array


def full_turn(motion: Motion, speed: float, neighbour: FullTurn | None = None) -> FullTurn | None:
    """The turn of the one crank of a mechanism, driven with ``speed`` (rad/s, its sign matters), if it surely
    gets through; None says nothing.

    A ``neighbour`` is the turn of a mechanism with slightly other lengths: Newton's steps from its positions
    close all positions at once. Without one, or where these do not close, the turn is walked in strides along
    velocity and curvature, with a correction at each.
    """
    system, drives = motion.system, motion.system.drives
    columns = 3 * len(system.names) - 3
    if (
        len(drives) != 1
        or not drives[0].turns
        or drives[0].body_a != 0
        or system.starts[-1] != columns
        or columns > DENSE
    ):
        return None
    corrector = _Corrector(motion, math.copysign(1.0, speed) * motion.hand)
    found = None
    if (
        neighbour is not None
        and neighbour.towards == corrector.towards
        and neighbour.positions.shape == corrector.shape
    ):
        found = corrector.closed(neighbour.positions)
    return corrector.closed(corrector.walked()) if found is None else found


class _Corrector:
    """Newton's steps of a determined mechanism with one crank."""

    def __init__(self, motion: Motion, towards: float) -> None:
        system = motion.system
        self.towards, self.gathered = towards, Gathered(system)
        self.start = motion.position * np.array([1.0, motion.hand, motion.hand])
        self.aim, self.stride = system.drives[0].aim, 2.0 * math.pi / ANGLES
        self.angles: Array = self.stride * np.arange(ANGLES + 1, dtype=np.float64)
        self.shape = (len(self.angles), *self.start.shape)
        self.reach = self.gathered.reach[3:]
        self.extent = max(float(system.reach[1:].max()), float(np.abs(self.start[:, :2]).max()))

    def closed(self, positions: Array) -> FullTurn | None:
        """The turn whose positions are near these; None where they do not close, or are not surely those of
        one motion.
        """
        positions = positions.copy()
        for _ in range(CORRECTIONS):
            step, determinant = self.step(positions, self.angles)
            if not determinant.all() or not np.isfinite(step).all():
                return None
            positions[:, 1:] -= self.turned_back(step[..., 0])
            if float(np.abs(step[..., 0]).max()) <= QUICK * self.extent:
                return (
                    FullTurn(self.towards, positions)
                    if self.sure(positions, step[..., 1], determinant)
                    else None
                )
        return None

    def turned_back(self, step: Array) -> Array:
        """Steps [k, 3(n-1)] in (x, y, l theta) as changes of positions [k, n-1, 3]."""
        return (step / self.reach).reshape(len(step), -1, 3)

    def step(self, positions: Array, angles: Array) -> Solved:
        """Newton's steps and velocities [k, 3(n-1), 2] at so many angles (rad) from the start, and
        determinants [k].
        """
        phi, jacobian = self.gathered.at(
            positions, self.gathered.aimed((self.aim + self.towards * angles)[:, None])
        )
        rate = np.zeros_like(phi)
        rate[:, -1] = self.towards * self.gathered.scale[0]
        return solve_with_determinant(jacobian, np.stack([phi, rate], axis=-1))

    def walked(self) -> Array:
        """Positions predicted from one angle to the next, each corrected once."""
        here, found = self.start[None].copy(), []
        before = None
        for angle in self.angles:
            step, _ = self.step(here, np.array([angle]))
            here[:, 1:] -= self.turned_back(step[..., 0])
            found.append(here[0].copy())
            going = step[..., 1]
            bend = 0.0 if before is None else 0.5 * self.stride * (going - before)
            here[:, 1:] += self.turned_back(self.stride * going + bend)
            before = going
        return np.array(found)

    def sure(self, positions: Array, velocity: Array, determinant: Array) -> bool:
        """Whether closed positions are one motion from the start and back, far from where a determinant
        vanishes.
        """
        if (
            not (np.sign(determinant) == np.sign(determinant[0])).all()
            or not np.abs(determinant).min() > WELL * np.abs(determinant).max()
        ):
            return False
        apart = positions[-1] - positions[0]
        apart[:, 2] -= 2.0 * math.pi * np.round(apart[:, 2] / (2.0 * math.pi))
        ends = np.abs(np.stack([apart, positions[0] - self.start])[:, 1:].reshape(2, -1) * self.reach).max()
        moved = np.diff(positions[:, 1:].reshape(len(positions), -1) * self.reach, axis=0)
        here, there = self.stride * velocity[:-1], self.stride * velocity[1:]
        before, beyond = np.roll(here, 1, axis=0), np.roll(there, -1, axis=0)
        # Positions are predicted from both ends of a stride: between two singular positions, where it does
        # not close, velocities turn round.
        ahead = np.abs(moved - here - 0.5 * (here - before)).max(axis=1) <= ASTRAY * np.abs(here).max(axis=1)
        back = np.abs(moved - there + 0.5 * (beyond - there)).max(axis=1) <= ASTRAY * np.abs(there).max(
            axis=1
        )
        return bool(ahead.all() and back.all() and ends <= BACK * self.extent)
