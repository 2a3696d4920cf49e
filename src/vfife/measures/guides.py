"""How points and sliders move: position, velocity and acceleration of any pin, and of a slider along its
guide.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kinematics.drives import guide_of
from ..numerics.elementwise import hypot, sincos
from ..numerics.products import times
from ..solvers.record import Record
from .contacts import of_window
from .motion import accelerations, velocities

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PointMotion:
    """A point at the outputs: ``position`` (m), ``velocity`` (m/s) and ``acceleration`` (m/s^2), global axes,
    shape (outputs, 2) each.
    """

    position: Array
    velocity: Array
    acceleration: Array

    def along(self, direction: tuple[float, float]) -> tuple[Array, Array, Array]:
        """The three along a direction of space, which need not have length 1, shape (outputs,) each. Raises
        ValueError where it has none.
        """
        size = float(hypot(*direction))
        if not size > 0.0:
            raise ValueError(
                f"a direction of {direction} has no length: give two numbers that are not both zero"
            )
        unit = np.asarray(direction, dtype=float) / size
        return times(self.position, unit), times(self.velocity, unit), times(self.acceleration, unit)


def turning(record: Record, body: str) -> tuple[Array, Array, Array]:
    """Angle (rad), angular velocity and acceleration of the particle that stands for a body; zeros for the
    ground.
    """
    if body == "ground":
        none = np.zeros(len(record.steps))
        return none, none, none
    p = record.assembly.bodies[body].particles[0]
    return (
        record.block("particle_theta")[:, p],
        velocities(record)["w"][:, p],
        accelerations(record)["aw"][:, p],
    )


def point_motion(record: Record, point: str) -> PointMotion:
    """Motion of ``body.pin`` or of ``ground.point``.

    r = c + q, v = v_c + w x q, a = a_c + alpha x q - w^2 q, of the particle that carries the pin. Raises
    ValueError with the names there are.
    """
    body, _, pin = point.partition(".")
    assembly = record.assembly
    if body == "ground" and pin in assembly.mechanism.points:
        still = np.zeros((len(record.steps), 2))
        return PointMotion(still + np.asarray(assembly.mechanism.points[pin], dtype=float), still, still)
    pins = (
        {}
        if body not in assembly.bodies
        else assembly.bodies[body].nodes
        if assembly.bodies[body].elements
        else assembly.bodies[body].pins
    )
    if pin not in pins:
        known = (
            ", ".join(f"{body}.{name}" for name in pins)
            if pins
            else f"body.pin, with a body of {', '.join(assembly.bodies)}"
        )
        raise ValueError(f"there is no point {point!r}; there are {known}")
    where = assembly.bodies[body]
    p = where.nodes[pin] if where.elements else where.particles[0]
    ox, oy = (0.0, 0.0) if where.elements else np.subtract(where.pins[pin], where.reference)
    moving, angle = velocities(record), record.block("particle_theta")[:, p]
    s, c = sincos(angle)
    qx, qy = c * ox - s * oy, s * ox + c * oy
    pushed = accelerations(record)
    w, alpha, ax, ay = moving["w"][:, p], *(pushed[name][:, p] for name in ("aw", "ax", "ay"))
    x, y = (record.block(f"particle_{axis}")[:, p] for axis in "xy")
    return PointMotion(
        np.column_stack([x + qx, y + qy]),
        np.column_stack([moving["u"][:, p] - w * qy, moving["v"][:, p] + w * qx]),
        np.column_stack([ax - alpha * qy - w * w * qx, ay + alpha * qx - w * w * qy]),
    )


def sliders(record: Record) -> list[str]:
    """Joints whose journal goes along a straight guide, with play or without."""
    mechanism = record.assembly.mechanism
    return [name for name in mechanism.joints if guide_of(mechanism, name)]


def slider_motion(record: Record, name: str) -> tuple[Array, Array, Array]:
    """Position (m), velocity (m/s) and acceleration (m/s^2) of a slider's journal pin along its guide,
    (outputs,) each.

    Counted from the bearing's pin, seen in the frame of the bearing's body: with d the guide's direction, e
    across it and r from pin to pin, s = d r, s' = d r' + w e r, s'' = d r'' + 2 w e r' + (alpha e - w^2 d) r.
    """
    found = guide_of(record.assembly.mechanism, name)
    if found is None:
        raise ValueError(f"{name!r} is no slider; there are {', '.join(sliders(record)) or 'none'}")
    joint, guide = found
    bearing, journal = (point_motion(record, side) for side in (joint.bearing, joint.journal))
    dx, dy = guide.unit()
    angle, w, alpha = (one[:, None] for one in turning(record, joint.sides[0][0]))
    s, c = sincos(angle[:, 0])
    d = np.column_stack([c * dx - s * dy, s * dx + c * dy])
    e = np.column_stack([-d[:, 1], d[:, 0]])
    r, v, a = (
        getattr(journal, key) - getattr(bearing, key) for key in ("position", "velocity", "acceleration")
    )
    parts = (d * r, d * v + w * e * r, d * a + 2.0 * w * e * v + (alpha * e - w * w * d) * r)
    position, velocity, acceleration = (part.sum(axis=1) for part in parts)
    return position, velocity, acceleration


def largest_strokes(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<slider>.position.low`` and ``.high`` (m, their difference is the stroke), ``.velocity.max`` (m/s)
    and ``.acceleration.max`` (m/s^2), largest sizes at the outputs, along the guide.
    """
    found: dict[str, float] = {}
    names = sliders(record) if record.keeps("particle_u") else []
    if not names:
        return found
    part, inside = of_window(record, window)
    for name in names:
        position, velocity, acceleration = (one[inside] for one in slider_motion(part, name))
        found |= {
            f"{name}.position.low": float(position.min()),
            f"{name}.position.high": float(position.max()),
        }
        found |= {
            f"{name}.velocity.max": float(np.abs(velocity).max()),
            f"{name}.acceleration.max": float(np.abs(acceleration).max()),
        }
    return found
