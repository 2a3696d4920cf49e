"""Where pins are: in their bodies' frames, in space, and roughly at the start, before the mechanism is
closed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..model.bodies import Body, Point
from ..model.joints import Joint
from ..model.lumping import rigid_properties
from ..model.mechanism import Mechanism
from ..numerics.elementwise import sincos

Array = NDArray[np.float64]
Places: TypeAlias = list[tuple[Any, Any, Any]]  # (x, y, angle) of bodies


def local_point(mechanism: Mechanism, side: tuple[str, str]) -> Point:
    """Return a pin in its body's frame, or a point of the ground (m)."""
    body, pin = side
    points = mechanism.points if body == "ground" else mechanism.bodies[body].points
    if pin not in points:
        raise AssemblyError(f"there is no pin {body}.{pin}; {body} has {', '.join(points) or 'none'}")
    return points[pin]


def from_center(mechanism: Mechanism, side: tuple[str, str]) -> Point:
    """Return a pin from the centre of mass in the body's axes (m), or a point of the ground from
    the origin.
    """
    x, y = local_point(mechanism, side)
    if side[0] == "ground":
        return x, y
    cx, cy = rigid_properties(mechanism.bodies[side[0]])[1]
    return x - cx, y - cy


def centred(mechanism: Mechanism, name: str, position: Array, velocity: Array) -> tuple[Array, Array]:
    """Motion of a body's centre of mass from that of its frame's origin: (x, y, angle) and its rate, each
    (3,).
    """
    x, y = rigid_properties(mechanism.bodies[name])[1]
    s, c = sincos(position[2])
    r = np.array([c * x - s * y, s * x + c * y, 0.0])
    return position + r, velocity + velocity[2] * np.array([-r[1], r[0], 0.0])


def world(
    mechanism: Mechanism,
    position: Places | Array,
    names: tuple[str, ...],
    side: tuple[str, str],
    beyond: Point = (0.0, 0.0),
) -> Point:
    """Return a pin in space (m), or the place ``beyond`` it in the axes of its body.

    position: of the bodies, (bodies + 1, 3) (m, m, rad)
    """
    x, y = (a + b for a, b in zip(from_center(mechanism, side), beyond, strict=True))
    px, py, angle = position[names.index(side[0])] if side[0] != "ground" else (0.0, 0.0, 0.0)
    s, c = sincos(angle)
    return float(px + c * x - s * y), float(py + s * x + c * y)


def first_guess(mechanism: Mechanism) -> Array:
    """Approximate positions: bodies are hung, from the ground on, in the joints that hold them, each at its
    approximate angle.

    Pins come before guides, and guides before contacts; in a guide or contact the pins of both sides start in
    one place, or where the joint has the journal's first.
    """
    names = ("ground", *mechanism.bodies)
    guess: Places = [(0.0, 0.0, 0.0)] * len(names)
    placed = {"ground"}
    for name, body in mechanism.bodies.items():
        if body.position is not None:
            _place(guess, names.index(name), body, (0.0, 0.0), body.position)
            placed.add(name)
    waiting = sorted(mechanism.joints.values(), key=lambda joint: joint.rank)
    while True:
        reachable = next(
            (
                (here, there, begin, end)
                for joint in waiting
                for here, there, begin, end in _ways(joint)
                if here[0] in placed and there[0] not in placed
            ),
            None,
        )
        if reachable is None:
            break
        here, there, begin, end = reachable
        x, y = (a + b for a, b in zip(local_point(mechanism, there), end, strict=True))
        _place(
            guess,
            names.index(there[0]),
            mechanism.bodies[there[0]],
            (x, y),
            world(mechanism, guess, names, here, begin),
        )
        placed.add(there[0])
    for name, body in mechanism.bodies.items():
        if name not in placed:
            _place(guess, names.index(name), body, (0.0, 0.0), (0.0, 0.0))
    return np.array(guess, dtype=float)


def _ways(joint: Joint) -> Iterator[tuple[tuple[str, str], tuple[str, str], Point, Point]]:
    """From each side of a joint to the other: the sides, and which place beyond the pin of each meets that of
    the other.
    """
    (bearing, journal), first, pin = joint.sides, joint.first_place, (0.0, 0.0)
    yield bearing, journal, first, pin
    yield journal, bearing, pin, first


def _place(guess: Places, row: int, body: Body, local: Point, target: Point) -> None:
    cx, cy = rigid_properties(body)[1]
    s, c = sincos(body.angle)
    x, y = cx - local[0], cy - local[1]
    guess[row] = target[0] + c * x - s * y, target[1] + s * x + c * y, body.angle
