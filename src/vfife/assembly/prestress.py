"""A start without ringing: elastic links bent and stretched as the forces of the ideal motion want them,
moving as these forces change.

A link is a chain of particles, so its element forces follow from equilibrium with the ideal accelerations
(d'Alembert), element by element. They deform it; the mechanism is closed again with the deformed links, until
nothing changes. Velocities and accelerations come from the same shapes a moment before and after: what is
left out is of the order of the square of crank speed over natural frequency, twice over.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kernels import frame
from ..kinematics.drives import kinematic_drivers, pivot_of
from ..kinematics.forces import Datum
from ..kinematics.initial import Motion, datum_of, ideal_motion
from ..kinematics.start import Seat
from ..model.bodies import Body, Link, RigidBody
from ..model.functions import shortest_turn
from ..model.lumping import Mesh, mesh
from ..model.mechanism import Mechanism
from ..numerics.elementwise import atan2, cos, hypot, sin, sincos

Array = NDArray[np.float64]

PASSES = 4
MOMENT = 2e-3  # rad of the crank between two shapes of a path


@dataclass(frozen=True)
class Shape:
    """A deformed link: particles in its frame (k + 1, 3: m, m, rad), and axial force (N) and end moments (N
    m) of its elements.
    """

    local: Array
    axial: Array
    moment_1: Array
    moment_2: Array


@dataclass(frozen=True)
class PrestressedState:
    """Particles of every body in space: position and velocity (k + 1, 3), and shapes of the elastic links."""

    position: dict[str, Array]
    velocity: dict[str, Array]
    shapes: dict[str, Shape]


def elastic_links(mechanism: Mechanism) -> dict[str, Link]:
    """Straight links that deform; bent ones and frames start as they are."""
    return {
        name: body
        for name, body in mechanism.bodies.items()
        if isinstance(body, Link) and body.element_count and not body.via
    }


def is_prestressed(mechanism: Mechanism) -> bool:
    """Whether the start is to be prestressed: elastic links, a consistent start, and joints that press from
    the beginning.
    """
    pressed = not mechanism.contacts or mechanism.start.journals == "seated"
    moving = mechanism.settings.analysis == "dynamic"
    return moving and bool(elastic_links(mechanism)) and mechanism.start.mode == "consistent" and pressed


def as_rigid(link: Link, shape: Shape) -> RigidBody:
    """Replace the deformed link by a rigid body of its shape, with the same particles and end pins."""
    lumps = mesh(link)
    mass = float(lumps.mass.sum())
    center = [(lumps.mass * shape.local[:, axis]).sum() / mass for axis in (0, 1)]
    x, y = shape.local[:, 0] - center[0], shape.local[:, 1] - center[1]
    inertia = float((lumps.mass * (x * x + y * y)).sum() + _turning(link, lumps).sum())
    pins = {
        "start": (float(shape.local[0, 0]), float(shape.local[0, 1])),
        "end": (float(shape.local[-1, 0]), float(shape.local[-1, 1])),
    }
    return RigidBody(
        name=link.name, angle=link.angle, position=link.position, material=link.material,
        velocity=link.velocity,
        mass=mass, inertia=inertia, center=(float(center[0]), float(center[1])), pins=pins,
    )  # fmt: skip


def _turning(link: Link, lumps: Mesh) -> Array:
    """Rotary inertia that turns with the link: none where the ends are released from it."""
    turning = lumps.inertia.copy()
    if link.release in ("start", "both"):
        turning[0] = 0.0
    if link.release in ("end", "both"):
        turning[-1] = 0.0
    return turning


def end_forces(mechanism: Mechanism, motion: Motion, link: str) -> dict[str, Array]:
    """Return the forces (N) and moments (N m) of joints, loads and driver on the ends of a link,
    (3,) each.
    """
    force = {pin: np.zeros(3) for pin in ("start", "end")}
    for joint in mechanism.joints.values():
        for sign, (body, pin) in zip((-1.0, 1.0), joint.sides, strict=True):
            if body == link and joint.name in motion.reaction:
                force[pin] += sign * np.array(motion.reaction[joint.name])
    for force_of in motion.applied:
        if force_of.body == link:
            force[force_of.pin or "start"] += np.array([*force_of.force, force_of.moment])
    if link in motion.torque and link in kinematic_drivers(mechanism):
        pin = next(side[1] for side in pivot_of(mechanism, link).sides if side[0] == link)
        force[pin][2] += motion.torque[link]
    return force


def columns(*values: Array) -> Array:
    """Stack arrays (length,) into (length, columns), in Fortran order: each column is contiguous, because a
    frame of 100,000 elements is traversed some hundred times.
    """
    return np.stack(values).T


def particle_motion(motion: Motion, body: RigidBody, shape: Shape) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration (k + 1, 3) of the particles of a link held in its shape."""
    position, velocity, acceleration = motion.of(body.name)
    s, c = sincos(position[2])
    w, alpha = velocity[2], acceleration[2]
    ahead, across = shape.local[:, 0] - body.center[0], shape.local[:, 1] - body.center[1]
    x, y = c * ahead - s * across, s * ahead + c * across
    row = np.ones(len(x))
    return (
        columns(position[0] + x, position[1] + y, position[2] + shape.local[:, 2]),
        columns(velocity[0] - w * y, velocity[1] + w * x, w * row),
        columns(
            acceleration[0] - alpha * y - w * w * x, acceleration[1] + alpha * x - w * w * y, alpha * row
        ),
    )


def deformed(
    mechanism: Mechanism, link: Link, motion: Motion, rigid: RigidBody, shape: Shape, extra: Array
) -> Shape:
    """Element forces in equilibrium with the motion, ``extra`` (k + 1, 3) acceleration added, and the shape
    that they make.
    """
    lumps = mesh(link)
    position, _, acceleration = particle_motion(motion, rigid, shape)
    acceleration = acceleration + extra
    ends = end_forces(mechanism, motion, link.name)
    need = lumps.mass[:, None] * (acceleration[:, :2] - np.array(mechanism.gravity))
    need[0] -= ends["start"][:2]
    force = np.cumsum(need, axis=0)[:-1]
    chord = np.diff(position[:, :2], axis=0)
    direction = chord / hypot(chord[:, 0], chord[:, 1])[:, None]
    axial = force[:, 0] * direction[:, 0] + force[:, 1] * direction[:, 1]
    shear = force[:, 1] * direction[:, 0] - force[:, 0] * direction[:, 1]
    k, size = link.element_count, link.length / link.element_count
    twist = _turning(link, lumps) * acceleration[:, 2]
    # one after the other: m1 = before - twist, m2 = -(size shear + m1), and -m2 is what the next element has
    # before
    sums = np.cumsum(
        np.concatenate([ends["start"][2:], np.column_stack([-twist[:-1], size * shear]).reshape(-1)])
    )
    m1, m2 = sums[1::2].copy(), -sums[2::2]
    if link.release == "both" and k == 1:
        m1[:], m2[:] = 0.0, 0.0
    longer = axial / frame.stiffness(1.0 / size, 1.0 / size, lumps.axial, lumps.bending)[0]
    shape = _shape(size + longer, axial, m1, m2, frame.end_rotations(m1, m2, 1.0 / size, lumps.bending))
    if link.name not in kinematic_drivers(mechanism):
        return _turned(shape, atan2(shape.local[-1, 1], shape.local[-1, 0]))
    pin = next(side[1] for side in pivot_of(mechanism, link.name).sides if side[0] == link.name)
    return _turned(shape, shape.local[0 if pin == "start" else -1, 2])


def _shape(length: Array, axial: Array, m1: Array, m2: Array, rotations: tuple[Array, Array]) -> Shape:
    """Place the elements one after the other from the start of the chain, with their lengths (m) and end
    rotations (rad).
    """
    first, second = rotations
    # from an element to its second end, and on to the next element: the directions of both in turns
    turns = np.cumsum(
        np.concatenate([[0.0], np.column_stack([second, np.append(-first[1:], 0.0)]).reshape(-1)])
    )
    direction = turns[:-1:2]
    local = np.zeros((3, len(axial) + 1)).T
    local[1:, 0], local[1:, 1] = np.cumsum(length * cos(direction)), np.cumsum(length * sin(direction))
    local[:, 2] = np.append(first[0], turns[1::2])
    return Shape(local, axial, m1, m2)


def _turned(shape: Shape, angle: float) -> Shape:
    """Rotate a shape into its body's frame: the chord lies along x, or the driven particle has the body's
    angle.
    """
    s, c = sincos(angle)
    x, y, theta = shape.local.T
    return dataclasses.replace(shape, local=columns(c * x + s * y, c * y - s * x, theta - angle))


def straight(link: Link) -> Shape:
    """Return the shape of the unloaded link."""
    k = link.element_count
    zeros = np.zeros(k)
    return Shape(columns(*mesh(link).position.T, np.zeros(k + 1)), zeros, zeros, zeros)


def settle(
    mechanism: Mechanism,
    time: float,
    shapes: dict[str, Shape],
    extra: dict[str, Array],
    seats: Mapping[str, Seat],
    datum: Datum,
) -> tuple[Motion, dict[str, Shape], Mechanism]:
    """Shapes and motion at ``time`` that agree with each other."""
    links = elastic_links(mechanism)
    guess = None
    for _ in range(PASSES):
        bodies: dict[str, Body] = {
            **mechanism.bodies,
            **{name: as_rigid(link, shapes[name]) for name, link in links.items()},
        }
        rigid = dataclasses.replace(mechanism, bodies=bodies)
        motion = ideal_motion(
            rigid, time, guess, inertial=_inertial(rigid, links, shapes, extra), seats=seats, datum=datum
        )
        guess = motion.position
        bent = {
            name: deformed(mechanism, link, motion, bodies[name], shapes[name], extra[name])  # type: ignore[arg-type]
            for name, link in links.items()
        }
        # the last motion is closed with the shapes it was found for: the least gap in a joint would be a blow
        # at the first step
        closed = {name: dataclasses.replace(bent[name], local=shapes[name].local) for name in links}
        shapes = bent
    return motion, closed, rigid


def _inertial(
    rigid: Mechanism, links: dict[str, Link], shapes: dict[str, Shape], extra: dict[str, Array]
) -> dict[str, tuple[Array, Array, Array]]:
    """Return what the deformation adds to the inertia forces of a rigid motion: for each link the masses
    (kg), local points (m) and additional accelerations (m/s²).
    """
    return {
        name: (
            mesh(link).mass,
            shapes[name].local[:, :2] - np.array(rigid.bodies[name].points["center"]),
            extra[name],
        )
        for name, link in links.items()
    }


def placed(
    mechanism: Mechanism, motion: Motion, rigid: Mechanism, shapes: dict[str, Shape]
) -> dict[str, Array]:
    """Positions of the particles of the elastic links, and of the centres of mass of the other bodies."""
    result = {}
    for name in mechanism.bodies:
        if name in shapes:
            result[name] = particle_motion(motion, rigid.bodies[name], shapes[name])[0]  # type: ignore[arg-type]
        else:
            result[name] = motion.of(name)[0][None, :]
    return result


def prestress(mechanism: Mechanism, seats: Mapping[str, Seat]) -> PrestressedState:
    """PrestressedState of a mechanism with elastic links: positions, velocities and element forces that go on
    smoothly.

    Without a driver the motion before and after is not known; the velocities are then those of the rigid
    mechanism.
    """
    links = elastic_links(mechanism)
    zeros = {name: np.zeros((link.element_count + 1, 3)) for name, link in links.items()}
    datum = datum_of(mechanism)
    motion, shapes, rigid = settle(
        mechanism, 0.0, {name: straight(link) for name, link in links.items()}, zeros, seats, datum
    )
    turn = shortest_turn(mechanism)
    if not kinematic_drivers(mechanism) or turn is None:
        velocity = {
            name: (
                particle_motion(motion, rigid.bodies[name], shapes[name])[1]  # type: ignore[arg-type]
                if name in shapes
                else motion.of(name)[1][None, :]
            )
            for name in mechanism.bodies
        }
        return PrestressedState(placed(mechanism, motion, rigid, shapes), velocity, shapes)
    h = MOMENT * turn / (2.0 * np.pi)
    extra = zeros
    for _ in range(2):
        path = []
        for k in (-2, -1, 0, 1, 2):
            moved, bent, fixed = settle(mechanism, k * h, shapes, extra, seats, datum)
            path.append((placed(mechanism, moved, fixed, bent), moved, fixed, bent))
        velocity, extra = _differences(path, h, links)
    position, _, _, shapes = path[2]
    return PrestressedState(position, velocity, shapes)


def _differences(
    path: list[tuple[dict[str, Array], Motion, Mechanism, dict[str, Shape]]], h: float, links: dict[str, Link]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Velocities, and what the accelerations of the links' particles have beyond those of a rigid motion;
    fourth order in h.
    """
    earliest, earlier, present, later, latest = (entry[0] for entry in path)
    velocity = {
        name: (8.0 * (later[name] - earlier[name]) - (latest[name] - earliest[name])) / (12.0 * h)
        for name in present
    }
    _, motion, rigid_links, shapes = path[2]
    extra = {}
    for name in links:
        second = (
            16.0 * (later[name] + earlier[name]) - latest[name] - earliest[name] - 30.0 * present[name]
        ) / (12.0 * h * h)
        rigid: Array = particle_motion(motion, rigid_links.bodies[name], shapes[name])[2]  # type: ignore[arg-type]
        extra[name] = np.subtract(second, rigid)
    return velocity, extra
