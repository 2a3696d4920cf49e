"""Positions, velocities and accelerations of particles, bodies, pins and sliders at the outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import BodyMap
from ..kinematics.drives import guide_of
from ..numerics.dense import times as weighted
from ..numerics.elementwise import atan2, hypot, sincos
from ..solvers.record import Record
from ..solvers.relaxation import extent
from .turns import Window, of_window

Array = NDArray[np.float64]
AXES = ("x", "u", "ax"), ("y", "v", "ay"), ("theta", "w", "aw")  # position, velocity, acceleration
ROUNDING = 1e-6  # degrees by which the angle of a run may be off after many turns
# Of the size of a mechanism, and rad: nothing moves that moves less. The start position closes to 1e-12 of
# the size; hanging chains drift by 1e-15 to 1e-13 in 30 s.
REST_DISTANCE = 1e-10


def times(record: Record) -> Array:
    """Return the times of the outputs (s), or load factors of a static analysis, shape (outputs,)."""
    if record.static:
        return np.array([0.0, *record.assembly.mechanism.settings.load_factors])[record.steps]
    return np.asarray(record.steps * record.assembly.choice.step, dtype=float)


def velocities(record: Record) -> dict[str, Array]:
    """Return the velocities u, v (m/s) and w (rad/s) of all particles at t_n, shape (outputs, particles).

    A record holds v_(n+1/2). The central difference with mass-proportional damping z = damping dt/2 is
    v_(n+1/2) - v_(n-1/2) = dt a_n - 2 z v_n with v_n the mean of both, hence v_n = (v_(n+1/2) - dt/2 a_n)/(1
    - z); the first step, which starts from v_0 itself, gives the same. Where the motion is prescribed the
      record holds the velocity
    at t_n already.
    """
    dt, z = half_damping(record)
    free = is_free(record)
    values = {}
    for _, rate, second in AXES:
        half = record.block(f"particle_{rate}")
        values[rate] = np.where(
            free, (half - 0.5 * dt * record.block(f"particle_{second}")) / (1.0 - z), half
        )
    return values


def accelerations(record: Record) -> dict[str, Array]:
    """Return the accelerations ax, ay (m/s^2) and aw (rad/s^2) of all particles at t_n, shape (outputs,
    particles): a record's, less damping times velocity.

    The record's are those of the forces without mass-proportional damping.
    """
    moving, free, rate = velocities(record), is_free(record), float(record.parameter("damping")[0])
    values = {}
    for _, first, second in AXES:
        rate_of_axis = record.block(f"particle_{second}")
        values[second] = (
            np.where(free, rate_of_axis - rate * moving[first], rate_of_axis) if rate else rate_of_axis
        )
    return values


def at_rest(record: Record) -> bool:
    """Return whether nothing moves in a run: particles stay where they are at its first output, by
    REST_DISTANCE of the size of the mechanism, or rad, and have no velocity that would take them farther
    until the next output.
    """
    if record.static or len(record.steps) < 2:
        return False
    choice, size = record.assembly.choice, extent(record.assembly, record.assembly.state)
    room = {"x": REST_DISTANCE * size, "y": REST_DISTANCE * size, "theta": REST_DISTANCE}
    # Most runs end elsewhere, or with a velocity: their other outputs need not be read.
    for outputs in ([0, -1], slice(None)):
        for place, rate, _ in AXES:
            places, rates = (record.block(f"particle_{name}")[outputs] for name in (place, rate))
            farthest = np.abs(rates).max(initial=0.0) * choice.outputs_every * choice.step
            if not max(np.abs(places - places[0]).max(initial=0.0), farthest) <= room[place]:
                return False
    return True


def half_damping(record: Record) -> tuple[float, float]:
    """Step dt (s), and z = damping dt/2 (1)."""
    dt = record.assembly.choice.step
    return dt, 0.5 * dt * float(record.parameter("damping")[0])


def is_free(record: Record) -> NDArray[np.bool_]:
    """Return which particles move by the forces on them, shape (particles,)."""
    topology = record.assembly.topology
    free = np.zeros(topology.particles, dtype=bool)
    free[list(topology.free)] = True
    return free


def body_motion(record: Record) -> dict[str, Array]:
    """Return the centre of mass x, y (m) and angle (rad) with its rate (rad/s) of each body, shape (outputs,
    bodies).

    A rigid body is where its particle carries it. An elastic link has the mean of its particles, weighted by
    their mass, and the angle of its chord from the first node to the last, made continuous from the angle it
    starts with.
    """
    position = {axis: record.block(f"particle_{axis}") for axis in ("x", "y", "theta")}
    velocity = velocities(record)
    bodies = record.assembly.bodies
    motions = {
        name: np.zeros((len(record.steps), len(bodies))) for name in ("x", "y", "angle", "angular_velocity")
    }
    for k, body in enumerate(bodies.values()):
        of = _chord if body.elements else _rigid_motion
        for name, values in zip(motions, of(record, body, position, velocity), strict=True):
            motions[name][:, k] = values
    return motions


def _rigid_motion(
    record: Record, body: BodyMap, position: dict[str, Array], velocity: dict[str, Array]
) -> tuple[Array, ...]:
    p = body.particles[0]
    rx, ry = np.subtract(body.center, body.reference)
    angle = position["theta"][:, p]
    s, c = sincos(angle)
    return (
        position["x"][:, p] + c * rx - s * ry,
        position["y"][:, p] + s * rx + c * ry,
        angle,
        velocity["w"][:, p],
    )


def _chord(
    record: Record, body: BodyMap, position: dict[str, Array], velocity: dict[str, Array]
) -> tuple[Array, ...]:
    nodes = list(body.particles)
    first, last = nodes[0], nodes[-1]
    dx, dy = (position[axis][:, last] - position[axis][:, first] for axis in ("x", "y"))
    du, dv = (velocity[axis][:, last] - velocity[axis][:, first] for axis in ("u", "v"))
    angle = np.unwrap(atan2(dy, dx))
    angle += 2.0 * np.pi * np.round((position["theta"][0, first] - angle[0]) / (2.0 * np.pi))
    mass = _node_mass(record, body)
    x, y = (weighted(position[axis][:, nodes], mass) / mass.sum() for axis in ("x", "y"))
    return x, y, angle, (dx * dv - dy * du) / (dx * dx + dy * dy)


def _node_mass(record: Record, body: BodyMap) -> Array:
    """Return the mass of an elastic link's particles (kg); one that is held has what the others leave of the
    body's mass.
    """
    inverse = record.parameter("particle_inverse_mass")[list(body.particles)]
    mass = np.where(inverse > 0.0, 1.0 / np.where(inverse > 0.0, inverse, 1.0), 0.0)
    is_fixed = inverse == 0.0
    if is_fixed.any():
        mass[is_fixed] = (body.mass - mass.sum()) / is_fixed.sum()
    return np.asarray(mass, dtype=float)


class Carrier(NamedTuple):
    """Particle that carries a pin, and the ``arm`` (m, m) from it to the pin in the axes of its body."""

    particle: int
    arm: tuple[float, float]


def carrier(body: BodyMap, pin: str) -> Carrier:
    """Find the carrier of a pin: a node of an elastic body, or the particle of a rigid one."""
    if body.elements:
        return Carrier(body.nodes[pin], (0.0, 0.0))
    x, y = np.subtract(body.pins[pin], body.reference)
    return Carrier(body.particles[0], (float(x), float(y)))


def crank_rotation(record: Record) -> Array | None:
    """Return the angle of the crank, the first driven body (degrees), over the outputs: it goes on from turn
    to turn; None without a crank.
    """
    driven = record.assembly.topology.driven
    return np.degrees(record.block("particle_theta")[:, driven[0]]) if driven else None


def within_turn(rotation: Array | float) -> Array:
    """Return crank angles as all outputs of vfife show them: the angle of the crank itself, from 0 to below
    360 degrees.

    This is the ``angle`` of the body in the model: of its own x axis from the global one, counterclockwise.
    An angle that rounding leaves just below a whole turn is 0.
    """
    return np.maximum(np.mod(np.asarray(rotation, dtype=float) + ROUNDING, 360.0) - ROUNDING, 0.0)


def pin_path(record: Record, body: str, pin: str) -> Array:
    """Return the path of a pin of a body, or of a point of the ground (m), shape (outputs, 2)."""
    assembly = record.assembly
    if body == "ground":
        return np.tile(np.asarray(assembly.mechanism.points[pin], dtype=float), (len(record.steps), 1))
    particle, (rx, ry) = carrier(assembly.bodies[body], pin)
    x, y, angle = (record.block(f"particle_{axis}")[:, particle] for axis in ("x", "y", "theta"))
    s, c = sincos(angle)
    return np.stack([x + c * rx - s * ry, y + s * rx + c * ry], axis=1)


def pin_places(record: Record, kind: str, side: str) -> Array:
    """Return where the pins on one ``side`` of all joints or springs of a ``kind`` are (m), shape (outputs,
    joints, 2).
    """
    particles = list(getattr(record.assembly.topology, f"{kind}_{side}"))
    x, y, angle = (record.block(f"particle_{axis}")[:, particles] for axis in ("x", "y", "theta"))
    px, py = (record.parameter(f"{kind}_{side}_{axis}") for axis in "xy")
    s, c = sincos(angle)
    return np.stack([x + c * px - s * py, y + s * px + c * py], axis=2)


def particle_names(record: Record) -> list[str]:
    """Names of the particles but the ground: that of the body, with the number of the node where a link has
    several.
    """
    names = {}
    for body in record.assembly.bodies.values():
        for k, p in enumerate(body.particles):
            names[p] = f"{body.name}.{k}" if len(body.particles) > 1 else body.name
    return [names[p] for p in range(1, record.assembly.topology.particles)]


def element_names(record: Record) -> list[str]:
    """Names of the elements: that of the link, with their number along it."""
    names = {
        e: f"{body.name}.{k}" for body in record.assembly.bodies.values() for k, e in enumerate(body.elements)
    }
    return [names[e] for e in range(len(record.assembly.topology.frame_nodes))]


def body_velocity(record: Record) -> Array:
    """Return the velocity of the centre of mass of each body (m/s), shape (outputs, bodies, 2)."""
    position = {axis: record.block(f"particle_{axis}") for axis in ("x", "y", "theta")}
    velocity = velocities(record)
    values = np.zeros((len(record.steps), len(record.assembly.bodies), 2))
    for k, body in enumerate(record.assembly.bodies.values()):
        nodes = list(body.particles)
        if body.elements:
            mass = _node_mass(record, body)
            values[:, k] = np.stack(
                [weighted(velocity[axis][:, nodes], mass) / mass.sum() for axis in ("u", "v")], axis=1
            )
            continue
        rx, ry = np.subtract(body.center, body.reference)
        angle, w = position["theta"][:, nodes[0]], velocity["w"][:, nodes[0]]
        s, c = sincos(angle)
        values[:, k, 0] = velocity["u"][:, nodes[0]] - w * (s * rx + c * ry)
        values[:, k, 1] = velocity["v"][:, nodes[0]] + w * (c * rx - s * ry)
    return values


class Motion(NamedTuple):
    """Position, velocity and acceleration along a line (m, m/s, m/s^2) or about an axis (rad, ...), shape
    (outputs,) each.
    """

    position: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class PointMotion:
    """A point at the outputs: ``position`` (m), ``velocity`` (m/s) and ``acceleration`` (m/s^2), global axes,
    shape (outputs, 2) each.
    """

    position: Array
    velocity: Array
    acceleration: Array

    def along(self, direction: tuple[float, float]) -> Motion:
        """Return the motion projected on a direction of any length above zero. Raises ValueError for length
        zero.
        """
        size = float(hypot(*direction))
        if not size > 0.0:
            raise ValueError(
                f"a direction of {direction} has no length: give two numbers that are not both zero"
            )
        unit = np.asarray(direction, dtype=float) / size
        return Motion(
            weighted(self.position, unit), weighted(self.velocity, unit), weighted(self.acceleration, unit)
        )


def rotation(record: Record, body: str) -> Motion:
    """Return the angle (rad), angular velocity and acceleration of the particle that represents a body; zeros
    for the ground.
    """
    if body == "ground":
        return Motion(*np.zeros((3, len(record.steps))))
    p = record.assembly.bodies[body].particles[0]
    return Motion(
        record.block("particle_theta")[:, p], velocities(record)["w"][:, p], accelerations(record)["aw"][:, p]
    )


def point_motion(record: Record, point: str) -> PointMotion:
    """Return the motion of ``body.pin`` or of ``ground.point``.

    r = c + q, v = v_c + w x q, a = a_c + alpha x q - w^2 q, of the particle that carries the pin. Raises
    ValueError with the names there are.
    """
    name, _, pin = point.partition(".")
    assembly = record.assembly
    if name == "ground" and pin in assembly.mechanism.points:
        zeros = np.zeros((len(record.steps), 2))
        return PointMotion(zeros + np.asarray(assembly.mechanism.points[pin], dtype=float), zeros, zeros)
    body = assembly.bodies.get(name)
    pins = {} if body is None else body.nodes if body.elements else body.pins
    if body is None or pin not in pins:
        names = (
            ", ".join(f"{name}.{label}" for label in pins)
            if pins
            else f"body.pin, with a body of {', '.join(assembly.bodies)}"
        )
        raise ValueError(f"there is no point {point!r}; there are {names}")
    p, (ox, oy) = carrier(body, pin)
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


def slider_motion(record: Record, name: str) -> Motion:
    """Return the motion of a slider's journal pin along its guide.

    Counted from the bearing's pin, seen in the frame of the bearing's body: with d the guide's direction, e
    across it and r from pin to pin, s = d r, s' = d r' + w e r, s'' = d r'' + 2 w e r' + (alpha e - w^2 d) r.
    """
    slider = guide_of(record.assembly.mechanism, name)
    if slider is None:
        raise ValueError(f"{name!r} is no slider; there are {', '.join(sliders(record)) or 'none'}")
    joint, guide = slider
    bearing, journal = (point_motion(record, side) for side in (joint.bearing, joint.journal))
    dx, dy = guide.unit()
    angle, w, alpha = (column[:, None] for column in rotation(record, joint.sides[0][0]))
    s, c = sincos(angle[:, 0])
    d = np.column_stack([c * dx - s * dy, s * dx + c * dy])
    e = np.column_stack([-d[:, 1], d[:, 0]])
    r, v, a = (
        getattr(journal, key) - getattr(bearing, key) for key in ("position", "velocity", "acceleration")
    )
    parts = (d * r, d * v + w * e * r, d * a + 2.0 * w * e * v + (alpha * e - w * w * d) * r)
    return Motion(*(part.sum(axis=1) for part in parts))


def largest_strokes(record: Record, window: Window) -> dict[str, float]:
    """Return the ends of each slider's stroke along its guide, and its largest velocity and acceleration, at
    the outputs.

    ``<slider>.position.low`` and ``.high`` (m), ``.velocity.max`` (m/s), ``.acceleration.max`` (m/s²): min s,
    max s, max|s'|, max|s''|.
    """
    part, inside = of_window(record, window)
    values: dict[str, float] = {}
    for name in sliders(record):
        motion = slider_motion(part, name)
        position, velocity, acceleration = (
            motion.position[inside],
            motion.velocity[inside],
            motion.acceleration[inside],
        )
        values |= {
            f"{name}.position.low": float(position.min()),
            f"{name}.position.high": float(position.max()),
        }
        values |= {
            f"{name}.velocity.max": float(np.abs(velocity).max()),
            f"{name}.acceleration.max": float(np.abs(acceleration).max()),
        }
    return values
