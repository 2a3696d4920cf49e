"""Bodies as a page draws them: where their pins are, and which of them the line of a body runs through."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..assembly.assembled import Assembly, BodyMap
from ..model.joints import Gear
from ..model.outlines import FEW, axis_between, corners, drawn_pins, wheels_at
from ..model.springs import AnySpring

Pin = list[float]  # particle, x and y (m) in its frame


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
    """Where two bodies turn against each other: at a pin, else at the centre of mass of the second."""
    end = axis_between(assembly.mechanism, first, second)
    return centre_of(assembly, second) if end is None else pin_of(assembly, end)


def ends_of(assembly: Assembly, spring: AnySpring) -> tuple[Pin, Pin]:
    """The pins of a spring, or twice the axis about which its bodies turn."""
    if spring.between_pins:
        return pin_of(assembly, spring.first), pin_of(assembly, spring.second)
    axis = axis_of(assembly, spring.first, spring.second)
    return axis, axis


def axes_of(assembly: Assembly, gear: Gear) -> tuple[Pin, Pin]:
    """Where the two wheels of a gear turn."""

    def same(one: Pin, two: Pin) -> bool:
        return bool(np.allclose(place(assembly, one), place(assembly, two)))

    return wheels_at(assembly.mechanism, gear, lambda first, second: axis_of(assembly, first, second), same)


def place(assembly: Assembly, pin: Pin) -> tuple[float, float]:
    """Where a pin is at the start (m)."""
    particle, x, y = int(pin[0]), pin[1], pin[2]
    px, py, angle = (float(assembly.state[assembly.layout.row(f"particle_{axis}", particle)]) for axis in ("x", "y", "theta"))
    c, s = np.cos(angle), np.sin(angle)
    return float(px + c * x - s * y), float(py + s * x + c * y)


def drawn(assembly: Assembly, body: BodyMap) -> dict[str, Any]:
    """The line of a body as pins, one list for each piece that hangs together; whether it is a plate, and has nodes to show."""
    if body.model == "frame":
        pairs = [assembly.topology.frame_nodes[e][:2] for e in body.elements]
        return {"pieces": [[[first, 0.0, 0.0], [second, 0.0, 0.0]] for first, second in pairs], "plate": False, "dots": False}
    if body.elements:
        return {"pieces": [[[p, 0.0, 0.0] for p in body.particles]], "plate": False, "dots": len(body.particles) <= FEW}
    pins = drawn_pins(assembly.mechanism, body.name)
    at = np.array([body.pins[pin] for pin in pins] or [body.center], dtype=float)
    order, plate = corners(at)
    points = at[order] - np.asarray(body.reference)
    return {"pieces": [[[body.particles[0], float(x), float(y)] for x, y in points]], "plate": plate, "dots": False}
