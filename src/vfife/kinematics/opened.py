"""Which joint closes a loop, and by how far it opens where the loop does not close."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .gathered import Gathered
from .system import RigidSystem

Array = NDArray[np.float64]

FELT = 1e-3  # part of the largest self-stress from which a row takes part
HELD = 1e4  # weight of the joints that stay closed
STEPS = 200
FINEST = 1e-13  # of the extent: a step that is none


def closing_joint(system: RigidSystem, rows: Array | None = None) -> int | None:
    """The joint, by number, that closes the loop of the rows that take part (all, unless a self-stress [rows] says so).

    Bodies are hung from the ground on, those nearest to it first; it is the joint left over between the two furthest from it.
    """
    part = [k for k in range(len(system.joints)) if rows is None or rows[system.rows(k)].max(initial=0.0) > FELT]
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
    left = [k for k in part if k not in hung and system.joints[k].body_a in depth and system.joints[k].body_b in depth]
    return max(left, key=lambda k: depth[system.joints[k].body_a] + depth[system.joints[k].body_b], default=None)


def parted(gathered: Gathered, joint: int, aims: Array, guess: Array) -> tuple[Array, float]:
    """The position [n, 3] in which everything but a joint is closed and that one is open least, and by how much (m)."""
    system, kept = gathered.system, gathered.aimed(aims)
    here = system.rows(joint)
    weight = np.full(gathered.rows, HELD)
    weight[here] = 1.0
    scale, extent = gathered.reach[3:], float(system.reach[1:].max())
    position, damping = guess.copy(), 1e-3
    phi, jacobian = gathered.at(position, kept)
    for _ in range(STEPS):
        wanted = weight * phi
        stacked = np.vstack([weight[:, None] * jacobian, np.sqrt(damping) * np.eye(len(scale))])
        step = np.linalg.lstsq(stacked, -np.append(wanted, np.zeros(len(scale))), rcond=None)[0]
        step /= max(1.0, float(np.abs(step / scale)[2::3].max()) / 0.2)
        trial = position.copy()
        trial[1:] += (step / scale).reshape(-1, 3)
        tried, turned = gathered.at(trial, kept)
        if np.linalg.norm(weight * tried) < np.linalg.norm(wanted):
            gained = 1.0 - float(np.linalg.norm(weight * tried) / np.linalg.norm(wanted))
            position, phi, jacobian, damping = trial, tried, turned, max(damping / 5.0, 1e-12)
            if np.abs(step).max() <= 1e-9 * extent or gained < 1e-13:
                break
        elif np.abs(step).max() <= FINEST * extent or damping > 1e12:
            break
        else:
            damping *= 6.0
    return position, float(np.linalg.norm(phi[here]))
