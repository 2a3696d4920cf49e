"""Bodies as a page draws them: where their pins are, and which of them the line of a body runs through."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, BodyMap
from ..model.bodies import Link
from ..model.carriers import carrier_of
from ..model.joints import Contact, Gear
from ..model.springs import AnySpring

Array = NDArray[np.float64]
Pin = list[float]  # particle, x and y (m) in its frame
CENTER = "center"
FEW = 30  # nodes of an elastic link that are still shown as dots


def pin_of(assembly: Assembly, end: str) -> Pin:
    """Where ``body.pin`` or ``ground.point`` is found."""
    body, _, pin = end.partition(".")
    if body == "ground":
        return [0, *assembly.mechanism.points[pin]]
    where = assembly.bodies[body]
    if where.elements:
        return [where.nodes[pin], 0.0, 0.0]
    return [where.particles[0], *map(float, np.subtract(where.pins[pin], where.reference))]


def centre_of(assembly: Assembly, body: str) -> Pin:
    """The centre of mass of a rigid body; of others their middle node."""
    where = assembly.bodies[body]
    if where.elements:
        return [where.particles[len(where.particles) // 2], 0.0, 0.0]
    return [where.particles[0], *map(float, np.subtract(where.center, where.reference))]


def axis_of(assembly: Assembly, first: str, second: str) -> Pin:
    """Where two bodies turn against each other: their common pin, else a pin of the second, else its centre of mass."""
    joints = assembly.mechanism.joints.values()
    for wanted in ({first, second}, {"ground", second}):
        for joint in joints:
            if joint.revolves and not isinstance(joint, Contact) and {joint.sides[0][0], joint.sides[1][0]} == wanted:
                return pin_of(assembly, joint.bearing)
    for joint in joints:
        for (body, _), end in zip(joint.sides, (joint.bearing, joint.journal), strict=True):
            if body == second:
                return pin_of(assembly, end)
    return centre_of(assembly, second)


def ends_of(assembly: Assembly, spring: AnySpring) -> tuple[Pin, Pin]:
    """The pins of a spring, or twice the axis about which its bodies turn."""
    if spring.between_pins:
        return pin_of(assembly, spring.first), pin_of(assembly, spring.second)
    axis = axis_of(assembly, spring.first, spring.second)
    return axis, axis


def axes_of(assembly: Assembly, gear: Gear) -> tuple[Pin, Pin]:
    """Where the two wheels of a gear turn."""
    carrier = carrier_of(assembly.mechanism, gear)
    if carrier != "ground":
        one, two = (
            axis_of(assembly, "ground", carrier) if wheel == "ground" else axis_of(assembly, carrier, wheel) for wheel in (gear.first, gear.second)
        )
        return one, two
    one, two = axis_of(assembly, "ground", gear.first), axis_of(assembly, gear.first, gear.second)
    return (one, axis_of(assembly, "ground", gear.second)) if place(assembly, one) == place(assembly, two) else (one, two)


def place(assembly: Assembly, pin: Pin) -> tuple[float, float]:
    """Where a pin is at the start (m)."""
    particle, x, y = int(pin[0]), pin[1], pin[2]
    px, py, angle = (float(assembly.state[assembly.layout.row(f"particle_{axis}", particle)]) for axis in ("x", "y", "theta"))
    c, s = np.cos(angle), np.sin(angle)
    return float(px + c * x - s * y), float(py + s * x + c * y)


def attached(assembly: Assembly, name: str) -> set[str]:
    """Pins of a body that a joint or spring takes hold of."""
    mechanism = assembly.mechanism
    ends = [end for joint in mechanism.joints.values() for end in (joint.bearing, joint.journal)]
    ends += [end for spring in mechanism.springs.values() for end in (spring.first, spring.second)]
    return {pin for body, _, pin in (end.partition(".") for end in ends) if body == name}


def drawn(assembly: Assembly, body: BodyMap) -> dict[str, Any]:
    """The line of a body as pins, one list for each piece that hangs together; whether it is a plate, and has nodes to show."""
    if body.model == "frame":
        pairs = [assembly.topology.frame_nodes[e][:2] for e in body.elements]
        return {"pieces": [[[first, 0.0, 0.0], [second, 0.0, 0.0]] for first, second in pairs], "plate": False, "dots": False}
    if body.elements:
        return {"pieces": [[[p, 0.0, 0.0] for p in body.particles]], "plate": False, "dots": len(body.particles) <= FEW}
    pins = _own_pins(assembly, body)
    at = np.array([body.pins[pin] for pin in pins] or [body.center], dtype=float)
    plate = False
    if len(at) > 2:
        away = at - at.mean(axis=0)
        spread = np.linalg.svd(away, compute_uv=False)
        plate = bool(spread[-1] > 1e-9 * spread[0])
        order = _hull(at) if plate else list(np.argsort(away @ away[np.argmax(np.linalg.norm(away, axis=1))]))
        at = at[[*order, order[0]] if plate else order]
    points = at - np.asarray(body.reference)
    return {"pieces": [[[body.particles[0], float(x), float(y)] for x, y in points]], "plate": plate, "dots": False}


def _own_pins(assembly: Assembly, body: BodyMap) -> list[str]:
    """Pins that are drawn: its own, and those that something is fixed to; the centre of mass where there is but one pin."""
    noun = assembly.mechanism.bodies[body.name]
    held = attached(assembly, body.name)
    own = ["start", "end"] if isinstance(noun, Link) else [pin for pin in noun.points if pin != CENTER]
    pins = list(dict.fromkeys([*own, *(pin for pin in noun.points if pin in held)]))
    if len(pins) == 1 and np.any(noun.points[pins[0]]) and CENTER in noun.points and pins != [CENTER]:
        pins.append(CENTER)
    return pins


def _hull(points: Array) -> list[int]:
    """Corners of the convex hull, by turning on to the next one that leaves all others on its left."""
    start = int(np.lexsort((points[:, 1], points[:, 0]))[0])
    corners, here = [start], start
    for _ in range(len(points)):
        there = next(k for k in range(len(points)) if k != here)
        for k in range(len(points)):
            (ax, ay), (bx, by) = points[there] - points[here], points[k] - points[here]
            turn = ax * by - ay * bx
            if k != here and (turn < 0.0 or (turn == 0.0 and bx * bx + by * by > ax * ax + ay * ay)):
                there = k
        if there == start:
            break
        corners.append(there)
        here = there
    return corners
