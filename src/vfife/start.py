"""The motion a run starts from: positions closed from approximate angles, velocities and accelerations of the ideal mechanism."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .bodies import Body, Point
from .drivers import AngleTable, ConstantSpeed, Driver, Ramp, Torque
from .functions import angle_function
from .joints import ClearanceRevolute, Joint
from .kinematics import AssemblyError, Drive, Mobility, Pin, RigidSystem, accelerations, close, mobility, velocities
from .laws import Law, Material, Pair
from .lumping import rigid_properties
from .mechanism import Mechanism
from .stability import tangent

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """Ideal motion at one instant, bodies in the order of the mechanism, ground first.

    ``position``, ``velocity``, ``acceleration`` of centres of mass, shape (bodies + 1, 3); ``reaction`` of joint on the journal side (N).
    """

    names: tuple[str, ...]
    position: Array
    velocity: Array
    acceleration: Array
    reaction: dict[str, tuple[float, float]]
    torque: dict[str, float]
    mobility: Mobility

    def of(self, body: str) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration of a body's centre of mass."""
        k = self.names.index(body)
        return self.position[k], self.velocity[k], self.acceleration[k]


def kinematic_drivers(mechanism: Mechanism) -> dict[str, Driver]:
    """Drivers that prescribe an angle."""
    return {body: driver for body, driver in mechanism.drivers.items() if isinstance(driver, (ConstantSpeed, Ramp, AngleTable))}


def pivot_of(mechanism: Mechanism, body: str) -> Joint:
    """The ideal joint to the ground about which a driven body turns."""
    found = [
        joint
        for joint in mechanism.joints.values()
        if not isinstance(joint, ClearanceRevolute) and {body, "ground"} == {side[0] for side in joint.sides}
    ]
    if len(found) != 1:
        raise AssemblyError(
            f"the driver of body {body!r} needs exactly one ideal joint between {body!r} and the ground to turn it about; there are {len(found)}"
        )
    return found[0]


def local_point(mechanism: Mechanism, side: tuple[str, str]) -> Point:
    """A pin in its body's frame, or a point of the ground (m)."""
    body, pin = side
    points = mechanism.points if body == "ground" else mechanism.bodies[body].pins
    if pin not in points:
        raise AssemblyError(f"there is no pin {body}.{pin}; {body} has {', '.join(points) or 'none'}")
    return points[pin]


def surfaces(mechanism: Mechanism, joint: ClearanceRevolute) -> Pair:
    """The pair of surfaces of a joint, with the materials and the effective mass of its bodies; the ground does not move."""
    materials = [mechanism.bodies[side[0]].material if side[0] != "ground" else Material() for side in joint.sides]
    inverse = sum(1.0 / rigid_properties(mechanism.bodies[side[0]])[0] for side in joint.sides if side[0] != "ground")
    return dataclasses.replace(joint.pair(*materials), effective_mass=1.0 / inverse if inverse else None)


def cautions(mechanism: Mechanism, found: Mapping[str, tuple[float, float]] | None = None) -> tuple[str, ...]:
    """Sentences on where the laws of the joints leave their ranges; joints that say the same share one.

    Without ``found`` what is known before a run; with it, the deepest penetration (m) and the fastest impact (m/s) of each joint, what only
    the run could tell, of the worst of those joints that have the same laws and surfaces.
    """
    alike: dict[tuple[Law, Pair], list[str]] = {}
    for name, joint in mechanism.clearances.items():
        pair = dataclasses.replace(surfaces(mechanism, joint), effective_mass=None)
        laws: tuple[Law, ...] = (joint.contact, joint.friction)
        for law in laws:
            alike.setdefault((law, pair), []).append(name)
    said: dict[str, list[str]] = {}
    for (law, pair), names in alike.items():
        known = law.cautions(pair)
        if found is not None:
            depths, speeds = zip(*(found[name] for name in names), strict=True)
            known = tuple(one for one in law.cautions(pair, max(depths), max(speeds)) if one not in known)
        for sentence in known:
            said.setdefault(f"{law.name}, {sentence}.", []).extend(names)
    return tuple(f"Joint{'s' * (len(names) > 1)} {', '.join(names)}: {sentence}" for sentence, names in said.items())


@dataclass(frozen=True)
class Seat:
    """A journal pressed into its bearing: eccentricity in the bearing body's frame (m), depth (m) and force (N)."""

    at: Point
    depth: float
    force: float


def seated(mechanism: Mechanism) -> dict[str, Seat]:
    """Seats of the journals where the ideal reactions press them, if the start asks for it."""
    if mechanism.start.journals != "seated" or not mechanism.clearances:
        return {}
    motion = ideal_motion(mechanism)
    seats = {}
    for name, joint in mechanism.clearances.items():
        fx, fy = motion.reaction.get(name, (0.0, 0.0))
        force = float(np.hypot(fx, fy))
        if force <= 0.0:
            continue
        depth = tangent(joint.contact, joint.contact.parameters(surfaces(mechanism, joint)), force)[0]
        bearing = joint.sides[0][0]
        angle = 0.0 if bearing == "ground" else motion.of(bearing)[0][2]
        size = -(joint.clearance + depth) / force
        c, s = np.cos(angle), np.sin(angle)
        seats[name] = Seat((float(size * (c * fx + s * fy)), float(size * (c * fy - s * fx))), depth, force)
    return seats


def rigid_system(
    mechanism: Mechanism, time: float = 0.0, *, open_joints: frozenset[str] = frozenset(), seats: Mapping[str, Seat] | None = None
) -> RigidSystem:
    """The mechanism with every joint ideal and every link rigid, its drivers at ``time`` (s); seated journals beside their bearings' centres."""
    names = ("ground", *mechanism.bodies)
    properties = {name: rigid_properties(body) for name, body in mechanism.bodies.items()}
    pins = []
    for joint in mechanism.joints.values():
        if joint.name in open_joints:
            continue
        ends = []
        for side in joint.sides:
            x, y = local_point(mechanism, side)
            cx, cy = (0.0, 0.0) if side[0] == "ground" else properties[side[0]][1]
            if seats and joint.name in seats and side == joint.sides[0]:
                x, y = x + seats[joint.name].at[0], y + seats[joint.name].at[1]
            ends.append((names.index(side[0]), (x - cx, y - cy)))
        pins.append(Pin(joint.name, *ends[0], *ends[1]))
    drives = []
    for body, driver in kinematic_drivers(mechanism).items():
        value, rate, second = angle_function(driver, mechanism.bodies[body].angle)(time)
        drives.append(Drive(names.index(body), value, rate, second))
    mass = np.array([1.0, *(p[0] for p in properties.values())])
    inertia = np.array([1.0, *(p[2] if p[2] > 0.0 else 1e-6 * p[0] for p in properties.values())])
    return RigidSystem(names, mass, inertia, tuple(pins), tuple(drives))


def first_guess(mechanism: Mechanism) -> Array:
    """Approximate positions: bodies are hung, from the ground on, in the joints that hold them, each at its approximate angle."""
    names = ("ground", *mechanism.bodies)
    guess = np.zeros((len(names), 3))
    placed = {"ground"}
    for name, body in mechanism.bodies.items():
        if body.position is not None:
            _place(guess, names.index(name), body, (0.0, 0.0), body.position)
            placed.add(name)
    while True:
        reachable = [
            (here, there)
            for joint in mechanism.joints.values()
            for here, there in (joint.sides, joint.sides[::-1])
            if here[0] in placed and there[0] not in placed
        ]
        if not reachable:
            break
        here, there = reachable[0]
        target = _world(mechanism, guess, names, here)
        _place(guess, names.index(there[0]), mechanism.bodies[there[0]], local_point(mechanism, there), target)
        placed.add(there[0])
    for name, body in mechanism.bodies.items():
        if name not in placed:
            _place(guess, names.index(name), body, (0.0, 0.0), (0.0, 0.0))
    return guess


def _world(mechanism: Mechanism, guess: Array, names: tuple[str, ...], side: tuple[str, str]) -> Point:
    x, y = local_point(mechanism, side)
    if side[0] == "ground":
        return x, y
    cx, cy = rigid_properties(mechanism.bodies[side[0]])[1]
    px, py, angle = guess[names.index(side[0])]
    c, s = np.cos(angle), np.sin(angle)
    return px + c * (x - cx) - s * (y - cy), py + s * (x - cx) + c * (y - cy)


def _place(guess: Array, row: int, body: Body, local: Point, target: Point) -> None:
    cx, cy = rigid_properties(body)[1]
    c, s = np.cos(body.angle), np.sin(body.angle)
    x, y = cx - local[0], cy - local[1]
    guess[row] = target[0] + c * x - s * y, target[1] + s * x + c * y, body.angle


def constant_forces(mechanism: Mechanism, position: Array, names: tuple[str, ...]) -> Array:
    """Weight, loads at t = 0 and torques on the centres of mass, shape (bodies + 1, 3)."""
    force = np.zeros((len(names), 3))
    for name, body in mechanism.bodies.items():
        force[names.index(name), :2] += rigid_properties(body)[0] * np.array(mechanism.gravity)
    for load in mechanism.loads.values():
        body_name, _, pin = load.at.partition(".")
        factor = 1.0 if load.factors is None else load.factors[0]
        row = names.index(body_name)
        at = np.array(_world(mechanism, position, names, (body_name, pin))) - position[row, :2]
        fx, fy = load.force
        force[row] += factor * np.array([fx, fy, at[0] * fy - at[1] * fx + load.moment])
    for body_name, driver in mechanism.drivers.items():
        if isinstance(driver, Torque):
            first = driver.torque if isinstance(driver.torque, (int, float)) else driver.torque[0]
            force[names.index(body_name), 2] += first
    return force


def mirrored(system: RigidSystem) -> RigidSystem:
    """The system with y and every angle turned round."""
    pins = tuple(
        dataclasses.replace(pin, point_a=np.asarray(pin.point_a) * (1.0, -1.0), point_b=np.asarray(pin.point_b) * (1.0, -1.0))
        for pin in system.joints
    )
    drives = tuple(Drive(d.body, -d.angle, -d.speed, -d.acceleration) for d in system.drives)
    return RigidSystem(system.names, system.mass, system.inertia, pins, drives)


def handedness(guess: Array) -> float:
    """-1 if the first body that is not along x is turned clockwise, else 1: the mirror image has the opposite one."""
    turned = guess[:, 2][guess[:, 2] != 0.0]
    return -1.0 if len(turned) and turned[0] < 0.0 else 1.0


def ideal_motion(
    mechanism: Mechanism,
    time: float = 0.0,
    guess: Array | None = None,
    *,
    inertial: Mapping[str, tuple[Array, Array, Array]] | None = None,
    seats: Mapping[str, Seat] | None = None,
) -> Motion:
    """Position, velocity, acceleration and reactions of the ideal mechanism at ``time`` (s), on the branch nearest the guess.

    ``inertial``: accelerations of a body's particles beyond its rigid motion, as masses, places in its frame and accelerations.
    Joints with clearance whose body was given a velocity of its own are closed in position only. Raises AssemblyError where links cannot
    reach.
    """
    system = rigid_system(mechanism, time, seats=seats)
    guess = first_guess(mechanism) if guess is None else guess
    hand = handedness(guess)  # solved in one of the two mirror images, so that the other one starts from the same bits
    flip = np.array([1.0, hand, hand])
    reflect = mirrored if hand < 0.0 else lambda same: same
    position = close(reflect(system), guess * flip).position * flip
    own = {name for name, body in mechanism.bodies.items() if any(body.velocity)}
    loose = frozenset(j.name for j in mechanism.clearances.values() if {side[0] for side in j.sides} & own)
    moving = rigid_system(mechanism, time, open_joints=loose, seats=seats) if loose else system
    wish = np.zeros_like(position)
    for name in own:
        wish[system.names.index(name)] = mechanism.bodies[name].velocity
    velocity = velocities(reflect(moving), position * flip, wish * flip) * flip
    force = constant_forces(mechanism, position, system.names)
    for name, (mass, local, extra) in (inertial or {}).items():
        row = system.names.index(name)
        c, s = np.cos(position[row, 2]), np.sin(position[row, 2])
        arm, push = local @ np.array([[c, s], [-s, c]]), -mass[:, None] * extra[:, :2]
        force[row] += np.array([*push.sum(axis=0), (arm[:, 0] * push[:, 1] - arm[:, 1] * push[:, 0]).sum()])
    acceleration, reaction, torque = accelerations(reflect(moving), position * flip, velocity * flip, force * flip)
    acceleration, reaction, torque = acceleration * flip, reaction * flip[:2], torque * hand
    reactions: Mapping[str, Array] = {pin.name: value for pin, value in zip(moving.joints, reaction, strict=True)}
    return Motion(
        system.names,
        position,
        velocity,
        acceleration,
        {name: (float(value[0]), float(value[1])) for name, value in reactions.items()},
        {system.names[drive.body]: float(value) for drive, value in zip(moving.drives, torque, strict=True)},
        mobility(reflect(system), position * flip),
    )
