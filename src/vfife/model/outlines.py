"""What a drawing shows of bodies: their pins, the order in which an outline connects them, and the axes of
gears.

Results are names and orders; positions come from the caller.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from .bodies import Link
from .functions import carrier_of
from .joints import Contact, Gear

if TYPE_CHECKING:
    from .mechanism import Mechanism

Place = TypeVar("Place")
DOTTED_NODES = 30  # nodes of an elastic link that are still shown as dots
CENTER = "center"
COLLINEAR = 1e-9  # width over length below which points lie on a line


def attached(mechanism: Mechanism, name: str) -> set[str]:
    """Return the pins of a body to which a joint or spring is attached."""
    ends = [end for joint in mechanism.joints.values() for end in (joint.bearing, joint.journal)]
    ends += [end for spring in mechanism.springs.values() for end in (spring.first, spring.second)]
    return {pin for body, _, pin in (end.partition(".") for end in ends) if body == name}


def drawn_pins(mechanism: Mechanism, name: str) -> list[str]:
    """Return the pins of a rigid body to draw: its own and those with an attachment; of a body with one pin
    also the centre of mass.
    """
    body, attached_pins = mechanism.bodies[name], attached(mechanism, name)
    pins_of_body = (
        ["start", "end"] if isinstance(body, Link) else [pin for pin in body.points if pin != CENTER]
    )
    pins = list(dict.fromkeys([*pins_of_body, *(pin for pin in body.points if pin in attached_pins)]))
    if len(pins) == 1 and any(body.points[pins[0]]) and CENTER in body.points and pins != [CENTER]:
        pins.append(CENTER)
    return pins


def loose_pins(mechanism: Mechanism, name: str, elastic: bool) -> list[str]:
    """Return the pins of a body without attachment (feet, pens, ends), whose paths are worth drawing; of an
    ``elastic`` body only its ends.
    """
    body, attached_pins = mechanism.bodies[name], attached(mechanism, name)
    candidates = [pin for pin in ("start", "end") if pin in body.points] if elastic else body.points
    return [pin for pin in candidates if pin != CENTER and pin not in attached_pins]


def corners(points: NDArray[np.float64]) -> tuple[list[int], bool]:
    """Return the order in which an outline connects points, shape (points, 2), and whether it is closed: the
    convex hull, or a line if the points are collinear.
    """
    if len(points) < 3:
        return list(range(len(points))), False
    away = points - points.mean(axis=0)
    spread = np.linalg.svd(away, compute_uv=False)
    if spread[-1] <= COLLINEAR * spread[0]:
        position = away @ away[np.argmax(np.linalg.norm(away, axis=1))]
        return [int(k) for k in np.argsort(position)], False
    hull = _hull(points)
    return [*hull, hull[0]], True


def _hull(points: NDArray[np.float64]) -> list[int]:
    """Return the corners of the convex hull anticlockwise, by Andrew's monotone chain."""
    order = sorted(range(len(points)), key=lambda k: (float(points[k, 0]), float(points[k, 1])))

    def turn(a: int, b: int, c: int) -> float:
        (ux, uy), (vx, vy) = points[b] - points[a], points[c] - points[a]
        return float(ux * vy - uy * vx)

    def half(indices: list[int]) -> list[int]:
        chain: list[int] = []
        for k in indices:
            while len(chain) > 1 and turn(chain[-2], chain[-1], k) <= 0.0:
                chain.pop()
            chain.append(k)
        return chain[:-1]

    return half(order) + half(order[::-1])


def axis_between(mechanism: Mechanism, first: str, second: str) -> str | None:
    """Return the pin about which two bodies turn relative to each other: their common pin, else the ground
    pivot of the second, else any pin of the second, else None.
    """
    joints = mechanism.joints.values()
    for pair in ({first, second}, {"ground", second}):
        for joint in joints:
            if (
                joint.revolves
                and not isinstance(joint, Contact)
                and {joint.sides[0][0], joint.sides[1][0]} == pair
            ):
                return joint.bearing
    for joint in joints:
        for (body, _), end in zip(joint.sides, (joint.bearing, joint.journal), strict=True):
            if body == second:
                return end
    return None


def wheels_at(
    mechanism: Mechanism,
    gear: Gear,
    axis: Callable[[str, str], Place],
    coincident: Callable[[Place, Place], bool],
) -> tuple[Place, Place]:
    """Return the centres of the two wheels of a gear. ``axis`` maps two bodies to the position of their axis;
    ``coincident`` returns whether two positions coincide.
    """
    carrier = carrier_of(mechanism, gear)
    if carrier != "ground":
        first, second = (
            axis("ground", carrier) if wheel == "ground" else axis(carrier, wheel)
            for wheel in (gear.first, gear.second)
        )
        return first, second
    first, second = axis("ground", gear.first), axis(gear.first, gear.second)
    return (first, axis("ground", gear.second)) if coincident(first, second) else (first, second)
