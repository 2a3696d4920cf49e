"""Positions in which a single joint of a closed loop is open, and which joint that is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics import dense
from ..numerics.products import norm, product, times
from .system import RigidSystem

Array = NDArray[np.float64]

FELT = 1e-3  # part of the largest self-stress from which a row takes part
HELD = 10.0  # weight of the joints that stay closed
LARGEST_TURN = 0.3  # rad in a step
CLOSE = 1e-10  # of the extent
ROUNDS, STEPS = 8, 40
FINEST = 1e-9  # of the extent: a step that is none


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
    for _ in range(STEPS):
        error = weight * (phi + shift)
        weighted = weight[:, None] * jacobian
        step = dense.solve(
            product(weighted.T, weighted) + damping * np.eye(len(scale)), -times(weighted.T, error)
        )
        step /= max(1.0, float(np.abs(step / scale)[2::3].max()) / LARGEST_TURN)
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
