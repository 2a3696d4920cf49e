"""Approximate positions of mechanisms, from which they are closed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..model.joints import Joint
from ..model.mechanism import Mechanism
from ..numerics.elementwise import sincos
from .batch import Batch, Side

Array = NDArray[np.float64]


def first_guess(mechanism: Mechanism) -> Array:
    """Return the approximate position of a mechanism [bodies + 1, 3], see :func:`first_guesses`."""
    return np.asarray(first_guesses(Batch([mechanism]))[0])


def first_guesses(batch: Batch) -> Array:
    """Return the approximate positions of a batch [cases, bodies + 1, 3], see :func:`_hung`."""
    return batch.recall("guess", lambda: _hung(batch))


def _hung(batch: Batch) -> Array:
    """Return approximate positions [cases, bodies + 1, 3]: bodies are hung, from the ground on, in the joints
    that hold them, each at its approximate angle.

    Pins come before guides, and guides before contacts; in a guide or contact the pins of both sides start in
    one place, or where the joint has the journal's first.
    """
    bodies = batch.first.bodies
    names = ("ground", *bodies)
    guess, placed = np.zeros((len(batch), len(names), 3)), {"ground"}

    def place(name: str, local: Array | float, target: Array) -> None:
        """Put a point of a body (m, in its frame) at a target in space (m)."""
        row, angle = names.index(name), batch.angle(name)
        s, c = sincos(angle)
        x, y = (batch.center(name) - local).T
        guess[:, row, 0], guess[:, row, 1] = target[:, 0] + c * x - s * y, target[:, 1] + s * x + c * y
        guess[:, row, 2] = angle
        placed.add(name)

    for name, body in bodies.items():
        if body.position is not None:
            place(name, 0.0, batch.body(name, "position", lambda body: body.position))
    waiting = sorted(batch.first.joints.values(), key=lambda joint: joint.rank)
    while True:
        reachable = next(
            (
                (joint, *sides)
                for joint in waiting
                for sides in _ways(joint)
                if sides[0][0] in placed and sides[1][0] not in placed
            ),
            None,
        )
        if reachable is None:
            break
        joint, standing, hung = reachable
        first = batch.column("joints", joint.name).numbers(lambda joint: joint.first_place)
        begins = standing == joint.sides[0]
        target = _world(batch, guess[:, names.index(standing[0])], standing, first if begins else 0.0)
        place(hung[0], batch.point(hung) + (0.0 if begins else first), target)
    for name in bodies:
        if name not in placed:
            place(name, 0.0, np.zeros((len(batch), 2)))
    return guess


def _ways(joint: Joint) -> Iterator[tuple[Side, Side]]:
    """From each side of a joint to the other."""
    bearing, journal = joint.sides
    yield bearing, journal
    yield journal, bearing


def _world(batch: Batch, position: Array, side: Side, offset: Array | float) -> Array:
    """Return the places in space (m) [cases, 2] of a pin, or of the place at an ``offset`` from it in the
    axes of its body, which is at ``position`` [cases, 3].
    """
    x, y = (batch.from_center(side) + offset).T
    s, c = sincos(position[:, 2])
    return np.column_stack([position[:, 0] + c * x - s * y, position[:, 1] + s * x + c * y])
