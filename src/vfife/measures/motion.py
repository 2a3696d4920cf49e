"""How particles, bodies and pins move: positions, velocities and accelerations at the times of the outputs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import BodyMap
from ..numerics.elementwise import atan2, sincos
from ..numerics.products import times as weighted
from ..solvers.record import Record

Array = NDArray[np.float64]
AXES = (
    ("x", "u", "ax"),
    ("y", "v", "ay"),
    ("theta", "w", "aw"),
)  # position, velocity and acceleration of each axis


def times(record: Record) -> Array:
    """Times of the outputs (s), or load factors of a static analysis, shape (outputs,)."""
    if record.static:
        return np.array([0.0, *record.assembly.mechanism.settings.load_factors])[record.steps]
    return np.asarray(record.steps * record.assembly.choice.step, dtype=float)


def velocities(record: Record) -> dict[str, Array]:
    """Velocities u, v (m/s) and w (rad/s) of all particles at t_n, shape (outputs, particles).

    A record holds v_(n+1/2). The central difference with mass-proportional damping z = damping dt/2 is
    v_(n+1/2) - v_(n-1/2) = dt a_n - 2 z v_n with v_n the mean of both, hence v_n = (v_(n+1/2) - dt/2 a_n)/(1
    - z); the first step, which starts from v_0 itself, gives the same. Where the motion is prescribed the
      record holds the velocity
    at t_n already.
    """
    dt, z = half_damping(record)
    free = is_free(record)
    found = {}
    for _, rate, second in AXES:
        half = record.block(f"particle_{rate}")
        found[rate] = np.where(free, (half - 0.5 * dt * record.block(f"particle_{second}")) / (1.0 - z), half)
    return found


def accelerations(record: Record) -> dict[str, Array]:
    """Accelerations ax, ay (m/s^2) and aw (rad/s^2) of all particles at t_n, shape (outputs, particles): a
    record's, less damping times velocity.

    The record's are those of the forces without mass-proportional damping.
    """
    moving, free, rate = velocities(record), is_free(record), float(record.parameter("damping")[0])
    found = {}
    for _, first, second in AXES:
        own = record.block(f"particle_{second}")
        found[second] = np.where(free, own - rate * moving[first], own) if rate else own
    return found


def half_damping(record: Record) -> tuple[float, float]:
    """Step dt (s), and z = damping dt/2 (1)."""
    dt = record.assembly.choice.step
    return dt, 0.5 * dt * float(record.parameter("damping")[0])


def is_free(record: Record) -> NDArray[np.bool_]:
    """Which particles move by the forces on them, shape (particles,)."""
    topology = record.assembly.topology
    free = np.zeros(topology.particles, dtype=bool)
    free[list(topology.free)] = True
    return free


def body_motion(record: Record) -> dict[str, Array]:
    """Centre of mass x, y (m) and angle (rad) with its rate (rad/s) of each body, shape (outputs, bodies).

    A rigid body is where its particle carries it. An elastic link has the mean of its particles, weighted by
    their mass, and the angle of its chord from the first node to the last, made continuous from the angle it
    starts with.
    """
    position = {axis: record.block(f"particle_{axis}") for axis in ("x", "y", "theta")}
    velocity = velocities(record)
    bodies = record.assembly.bodies
    found = {
        name: np.zeros((len(record.steps), len(bodies))) for name in ("x", "y", "angle", "angular_velocity")
    }
    for k, body in enumerate(bodies.values()):
        of = _chord if body.elements else _carried
        for name, values in zip(found, of(record, body, position, velocity), strict=True):
            found[name][:, k] = values
    return found


def _carried(
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
    """Mass of an elastic link's particles (kg); one that is held has what the others leave of the body's
    mass.
    """
    inverse = record.parameter("particle_inverse_mass")[list(body.particles)]
    mass = np.where(inverse > 0.0, 1.0 / np.where(inverse > 0.0, inverse, 1.0), 0.0)
    held = inverse == 0.0
    if held.any():
        mass[held] = (body.mass - mass.sum()) / held.sum()
    return np.asarray(mass, dtype=float)


def pin_path(record: Record, body: str, pin: str) -> Array:
    """Path of a pin of a body, or of a point of the ground (m), shape (outputs, 2)."""
    assembly = record.assembly
    if body == "ground":
        return np.tile(np.asarray(assembly.mechanism.points[pin], dtype=float), (len(record.steps), 1))
    where = assembly.bodies[body]
    if where.elements:
        node = where.nodes[pin]
        return np.stack([record.block("particle_x")[:, node], record.block("particle_y")[:, node]], axis=1)
    rx, ry = np.subtract(where.pins[pin], where.reference)
    x, y, angle = (record.block(f"particle_{axis}")[:, where.particles[0]] for axis in ("x", "y", "theta"))
    s, c = sincos(angle)
    return np.stack([x + c * rx - s * ry, y + s * rx + c * ry], axis=1)


def seen(record: Record, kind: str, side: str) -> Array:
    """Where the pins on one ``side`` of all joints or springs of a ``kind`` are (m), shape (outputs, joints,
    2).
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
    """Velocity of the centre of mass of each body (m/s), shape (outputs, bodies, 2)."""
    position, velocity = (
        {axis: record.block(f"particle_{axis}") for axis in ("x", "y", "theta")},
        velocities(record),
    )
    found = np.zeros((len(record.steps), len(record.assembly.bodies), 2))
    for k, body in enumerate(record.assembly.bodies.values()):
        nodes = list(body.particles)
        if body.elements:
            mass = _node_mass(record, body)
            found[:, k] = np.stack(
                [weighted(velocity[axis][:, nodes], mass) / mass.sum() for axis in ("u", "v")], axis=1
            )
            continue
        rx, ry = np.subtract(body.center, body.reference)
        angle, w = position["theta"][:, nodes[0]], velocity["w"][:, nodes[0]]
        s, c = sincos(angle)
        found[:, k, 0] = velocity["u"][:, nodes[0]] - w * (s * rx + c * ry)
        found[:, k, 1] = velocity["v"][:, nodes[0]] + w * (c * rx - s * ry)
    return found
