"""Where pins are: in their bodies' frames and in space."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..model.bodies import Point
from ..model.lumping import rigid_properties
from ..model.mechanism import Mechanism
from ..numerics.elementwise import sincos

Array = NDArray[np.float64]


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


def world(mechanism: Mechanism, position: Any, names: tuple[str, ...], side: tuple[str, str]) -> Point:
    """Return a pin in space (m).

    position: of the bodies, (bodies + 1, 3) (m, m, rad)
    """
    x, y = from_center(mechanism, side)
    px, py, angle = position[names.index(side[0])] if side[0] != "ground" else (0.0, 0.0, 0.0)
    s, c = sincos(angle)
    return float(px + c * x - s * y), float(py + s * x + c * y)
