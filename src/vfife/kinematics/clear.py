"""Whether members surely get through a turn of their crank: a quick look at all of them side by side, which leaves doubtful ones to others."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..fields.members import Members
from ..numerics.elementwise import sincos
from .initial import Motion
from .system import RigidSystem, equations

Array = NDArray[np.float64]

LOOKS = 24  # positions in a turn
WELL = 0.03  # of the largest determinant of a turn: what never falls below changes no sign between two looks
ASTRAY = 0.3  # of a stride, by which a predicted position may be off
BACK = 1e-6  # of the extent: it has come back
CLOSER = 3  # corrections at the end


def clear(motion: Motion, speed: Array) -> NDArray[np.bool_]:
    """Which members of :func:`~vfife.kinematics.initial.driven_start` go through a turn of their one crank, (rad/s), far from singular positions.

    Of others nothing is said. The turn is walked in strides along velocity and curvature, with a correction at each.
    """
    system, drives = motion.system, motion.system.drives
    count = len(speed)
    nobody = np.zeros(count, dtype=bool)
    if len(drives) != 1 or not drives[0].turns or drives[0].body_a != 0 or motion.position.ndim < 3:
        return nobody
    start = np.asarray(motion.position) * np.array([1.0, motion.hand, motion.hand])
    towards, stride = np.sign(speed) * motion.hand, 2.0 * math.pi / LOOKS
    scale = np.broadcast_to(np.asarray(system.lengths[len(system.joints)]), (count,))
    reach = np.where(np.arange(3 * len(system.names) - 3) % 3 == 2, np.repeat(np.asarray(system.reach)[..., 1:], 3, axis=-1), 1.0)
    extent = np.maximum(np.asarray(system.reach)[..., 1:].max(axis=-1), np.abs(start[..., :2]).max(axis=(1, 2)))
    here, sound, before = start.copy(), ~nobody, None
    least, most, first = np.full(count, np.inf), np.zeros(count), np.zeros(count)
    for k in range(LOOKS + 1 + CLOSER):
        angle = min(k, LOOKS) * stride
        step, going, determinant = _corrected(system, here, towards * angle * scale, towards * scale)
        first = np.sign(determinant) if k == 0 else first
        sound &= np.sign(determinant) == first
        least, most = np.minimum(least, np.abs(determinant)), np.maximum(most, np.abs(determinant))
        sound &= np.abs(step).max(axis=1) <= ASTRAY * np.maximum(stride * np.abs(going).max(axis=1), 1e-9 * extent)
        here[:, 1:] -= (step / reach).reshape(count, -1, 3)
        if k < LOOKS:
            bend = 0.0 if before is None else 0.5 * stride * (going - before)
            here[:, 1:] += ((stride * going + bend) / reach).reshape(count, -1, 3)
        before = going
    off = here - start
    off[:, :, 2] -= 2.0 * math.pi * np.round(off[:, :, 2] / (2.0 * math.pi))
    back = np.abs(off[:, 1:].reshape(count, -1) * reach).max(axis=1) <= BACK * extent
    return np.asarray(sound & back & (least > WELL * most))


def _corrected(system: RigidSystem, position: Array, ahead: Array, rate: Array) -> tuple[Array, Array, Array]:
    """Newton's step to where the drive is ``ahead`` (its row times its length), velocity by its ``rate``, both (members, c); the determinant."""
    s, c = sincos(position[..., 2])
    facing = [(1.0, 0.0), *((c[:, k].view(Members), s[:, k].view(Members)) for k in range(1, len(system.names)))]
    rows = equations(system, position.view(Members), facing=facing)
    size = system.starts[-1]
    whole = np.empty((size, size + 2, len(position)))
    whole[:, :size] = np.moveaxis(np.asarray(rows.jacobian), 0, -1)
    whole[:, size], whole[:, size + 1] = np.asarray(rows.phi).T, 0.0
    whole[-1, size] -= ahead
    whole[-1, size + 1] = rate
    return _solved(whole)


def _solved(whole: Array) -> tuple[Array, Array, Array]:
    """Gauss' elimination of (rows, columns and two right sides, members), pivots in the order that suits the first of them."""
    size, determinant = len(whole), np.ones(whole.shape[-1])
    order: list[int] = []
    with np.errstate(all="ignore"):
        for k in range(size):
            own = np.abs(whole[k:, :size, 0])
            own[:, order] = 0.0
            row, column = divmod(int(np.argmax(own)), size)
            order.append(column)
            if row:
                whole[[k, k + row]] = whole[[k + row, k]]
                determinant = -determinant
            pivot = whole[k, column].copy()
            determinant *= pivot
            whole[k] /= pivot
            others = [j for j in range(size) if j != k and whole[j, column].any()]
            whole[others] -= whole[others, column][:, None] * whole[k]
    turned = sum(order[i] > order[j] for i in range(size) for j in range(i + 1, size))
    determinant = -determinant if turned % 2 else determinant
    answer = np.empty((2, whole.shape[-1], size))
    answer[0][:, order], answer[1][:, order] = whole[:, size].T, whole[:, size + 1].T
    return answer[0], answer[1], determinant
