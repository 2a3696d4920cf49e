"""The motion a run starts from: positions closed from approximate angles, velocities and accelerations of the
ideal mechanism.
"""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..laws.elasticity import tangent
from ..model.bodies import Point
from ..model.mechanism import Mechanism
from ..model.surfaces import surfaces
from ..numerics.elementwise import hypot, sincos
from ..numerics.products import product
from .drives import constraint_drivers, kinematic_drivers, pivot_of, rigid_system, travel_of
from .forces import Applied, Datum, Instant, applied, constant_forces, driven_body
from .mobility import Mobility, mobility
from .pins import centred, first_guess, local_point
from .solve import accelerations, close, velocities
from .system import RigidSystem, mirrored

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """Ideal motion at one instant, bodies in the order of the mechanism, ground first.

    ``position``, ``velocity``, ``acceleration`` of centres of mass, shape (bodies + 1, 3). ``reaction`` of a
    joint or gear: force (N) on the journal's body at the journal's pin and moment (N m) on it (of a gear: on
    ``second``); the bearing's body has the opposite at the same place. ``torque`` (N m), or force (N) along a
    driven travel or path, that each driver applies: by body where it turns a body against the ground, else by
    the driver's name. ``datum``: where travels and springs count from; ``applied``: loads, torques and
    springs at work. ``system`` is in the mirror image in which it was solved, as is the ``guess``.
    """

    names: tuple[str, ...]
    position: Array
    velocity: Array
    acceleration: Array
    reaction: dict[str, tuple[float, float, float]]
    torque: dict[str, float]
    datum: Datum
    applied: tuple[Applied, ...]
    system: RigidSystem
    hand: float
    mechanism: Mechanism | None = None
    guess: Array | None = None

    def solves(self, system: RigidSystem, guess: Array) -> bool:
        """Whether equations and first guess (in the solved mirror image) are those that this motion was
        solved from, number by number.
        """
        mine = self.system
        return (
            self.guess is not None
            and mine.names == system.names
            and [one.content for one in mine.constraints] == [one.content for one in system.constraints]
            and np.array_equal(mine.mass, system.mass) and np.array_equal(mine.inertia, system.inertia) and np.array_equal(self.guess, guess)
        )  # fmt: skip

    @cached_property
    def mobility(self) -> Mobility:
        """Degrees of freedom, redundant and singular joints."""
        return mobility(self.system, self.position * (1.0, self.hand, self.hand))

    def of(self, body: str) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration of a body's centre of mass."""
        k = self.names.index(body)
        return self.position[k], self.velocity[k], self.acceleration[k]


@dataclass(frozen=True, eq=False)
class Given:
    """A start from known positions and velocities of the centres of mass, shape (bodies + 1, 3); ``bodies``
    are those that are known.

    Bodies that are not known stand as the model's approximate start has them, at rest.
    """

    position: Array
    velocity: Array
    bodies: frozenset[str]

    def apart(self, mechanism: Mechanism) -> frozenset[str]:
        """Joints with play whose two bodies are known: they stay as they are, wherever in its bearing the
        journal is.
        """
        known = self.bodies | {"ground"}
        return frozenset(
            joint.name for joint in mechanism.contacts.values() if {side[0] for side in joint.sides} <= known
        )


@dataclass(frozen=True)
class Seat:
    """A journal pressed into its bearing: eccentricity in the bearing body's frame (m), depth (m) and force
    (N).
    """

    at: Point
    depth: float
    force: float


def seated(mechanism: Mechanism, known: Motion | None = None) -> dict[str, Seat]:
    """Seats of the journals where the ideal reactions press them, if the start asks for it."""
    if mechanism.start.journals != "seated" or not mechanism.clearances:
        return {}
    motion = ideal_motion(mechanism, known=known)
    seats = {}
    for name, joint in mechanism.clearances.items():
        fx, fy, _ = motion.reaction.get(name, (0.0, 0.0, 0.0))
        force = float(hypot(fx, fy))
        if force <= 0.0:
            continue
        depth = tangent(joint.contact, joint.contact.parameters(surfaces(mechanism, joint)), force)[0]
        bearing = joint.sides[0][0]
        angle = 0.0 if bearing == "ground" else motion.of(bearing)[0][2]
        size = -(joint.clearance + depth) / force
        s, c = sincos(angle)
        seats[name] = Seat((float(size * (c * fx + s * fy)), float(size * (c * fy - s * fx))), depth, force)
    return seats


def handedness(guess: Array) -> float:
    """-1 if the first body that is not along x is turned clockwise, else 1: the mirror image has the opposite
    one.
    """
    for angle in guess[:, 2].tolist():
        if angle != 0.0:
            return -1.0 if angle < 0.0 else 1.0
    return 1.0


def datum_of(mechanism: Mechanism, given: Given | None = None) -> Datum:
    """Where travels, distances and angles count from: the start, closed without the drivers of travels and
    paths.

    Travels, paths and driven angles count from the position ``given``, if there is one; free lengths are
    those of the model's own start.
    """
    travels = {name: driver for name, driver in mechanism.drivers.items() if not driven_body(name, driver)}
    names, own = ("ground", *mechanism.bodies), None
    if mechanism.springs or (travels and given is None):
        own = _closed(mechanism, rigid_system(mechanism, travels=False), first_guess(mechanism))
    here = given.position if given is not None else own
    travel = (
        {}
        if here is None
        else {name: travel_of(mechanism, names, name, driver).at(here) for name, driver in travels.items()}
    )
    angle = {name: float(given.position[k, 2]) for k, name in enumerate(names)} if given is not None else {}
    angle = {name: body.angle for name, body in mechanism.bodies.items()} | angle
    spring = {} if own is None else _at_rest(Instant(mechanism, names, own, np.zeros_like(own)))
    return Datum(travel, spring, angle)


def _at_rest(now: Instant) -> dict[str, float]:
    """Distance (m) or relative angle (rad) of every spring at the start."""
    found = {}
    for name, spring in now.mechanism.springs.items():
        first, second = now.ends(spring)
        if spring.axes == "linear":
            found[name] = float(hypot(*np.subtract(second.at, first.at)))
        else:
            found[name] = second.angle - first.angle
    return found


def _closed(mechanism: Mechanism, system: RigidSystem, guess: Array) -> Array:
    """The closed position nearest the guess, solved in one of the two mirror images, so that the other one
    starts from the same bits.
    """
    hand = handedness(guess)
    flip = np.array([1.0, hand, hand])
    position: Array = close(mirrored(system) if hand < 0.0 else system, guess * flip).position * flip
    return position


def _starts_alike(one: Mechanism | None, other: Mechanism) -> bool:
    """Whether the same bodies, drivers and springs are tied by joints of the same rows, as in a mechanism and
    its ideal reference.
    """
    if one is None or len(one.bodies) != len(other.bodies):
        return False
    bodies = one.bodies.values(), other.bodies.values()
    if (
        any(any(body.velocity) for body in bodies[0])
        or not all(map(operator.is_, *bodies))
        or one.loads
        or other.loads
    ):
        return False
    parts = (
        (m.points, m.drivers, m.springs, m.gears, m.gravity, m.clock, m.settings.analysis)
        for m in (one, other)
    )
    joints = ([(j.sides, j.rows(), j.rank, j.first_place) for j in m.joints.values()] for m in (one, other))
    return (
        [*one.bodies, *one.joints] == [*other.bodies, *other.joints]
        and operator.eq(*parts)
        and operator.eq(*joints)
    )


def ideal_motion(
    mechanism: Mechanism,
    time: float = 0.0,
    guess: Array | None = None,
    *,
    inertial: Mapping[str, tuple[Array, Array, Array]] | None = None,
    seats: Mapping[str, Seat] | None = None,
    datum: Datum | None = None,
    given: Given | None = None,
    named: bool = True,
    known: Motion | None = None,
) -> Motion:
    """Position, velocity, acceleration and reactions of the ideal mechanism at ``time`` (s), on the branch
    nearest the guess.

    ``inertial``: accelerations of a body's particles beyond its rigid motion, as masses, places in its frame
    and accelerations. ``datum``: where travels and springs count from, :func:`datum_of` unless given.
    ``given``: a start from known positions and velocities. ``known``: a motion solved before. It is taken
    where it is that of this mechanism or of its ideal reference, and its position wherever that follows from
    the same numbers; so it never changes the result. Joints with clearance whose body was given a velocity of
    its own are closed in position only; those between bodies of a given start are left as they are. Raises
    AssemblyError where links cannot reach, which says what stays open by how much where that is to be
    ``named``.
    """
    plain = not (time or seats or inertial) and guess is None and datum is None and given is None
    if (
        plain
        and known is not None
        and (known.mechanism is mechanism or _starts_alike(known.mechanism, mechanism))
    ):
        return known
    datum = datum_of(mechanism, given) if datum is None else datum
    eccentric = {name: seat.at for name, seat in (seats or {}).items()}
    apart = frozenset() if given is None else given.apart(mechanism)
    system = rigid_system(mechanism, time, datum=datum, open_joints=apart, seats=eccentric)
    guess = (first_guess(mechanism) if given is None else given.position) if guess is None else guess
    hand = handedness(
        guess
    )  # solved in one of the two mirror images, so that the other one starts from the same bits
    flip = np.array([1.0, hand, hand])
    solved = mirrored(system) if hand < 0.0 else system
    if known is not None and known.solves(solved, guess * flip):
        position = known.position
    else:
        position = close(solved, guess * flip, named).position * flip
    own = {name for name, body in mechanism.bodies.items() if any(body.velocity)} if given is None else set()
    loose = apart | {j.name for j in mechanism.contacts.values() if {side[0] for side in j.sides} & own}
    moving, moved = system, solved
    if loose != apart:
        moving = rigid_system(mechanism, time, datum=datum, open_joints=loose, seats=eccentric)
        moved = mirrored(moving) if hand < 0.0 else moving
    wish = np.zeros_like(position) if given is None else given.velocity
    for name in own:
        row = system.names.index(name)
        wish[row] = centred(mechanism, name, position[row], np.array(mechanism.bodies[name].velocity))[1]
    velocity = velocities(moved, position * flip, wish * flip) * flip
    now = Instant(mechanism, system.names, position, velocity, time)
    pushed = tuple(applied(now, datum))
    force = constant_forces(now, pushed)
    for name, (mass, local, extra) in (inertial or {}).items():
        row = system.names.index(name)
        s, c = sincos(position[row, 2])
        arm, push = product(local, np.array([[c, s], [-s, c]])), -mass[:, None] * extra[:, :2]
        force[row] += np.array([*push.sum(axis=0), (arm[:, 0] * push[:, 1] - arm[:, 1] * push[:, 0]).sum()])
    acceleration, reaction, driving = accelerations(moved, position * flip, velocity * flip, force * flip)
    reactions = {
        one.name: (float(x), float(y), float(m))
        for one, (x, y, m) in zip(moving.joints, reaction * flip, strict=True)
    }
    torque = {
        d.name: float(value) * (hand if d.turns else 1.0)
        for d, value in zip(moving.drives, driving, strict=True)
    }
    found = Motion(
        system.names, position, velocity, acceleration * flip, reactions, torque, datum, pushed, solved, hand
    )
    return dataclasses.replace(found, mechanism=mechanism, guess=guess * flip) if plain else found


__all__ = [
    "AssemblyError", "Datum", "Given", "Motion", "Seat", "constraint_drivers", "datum_of", "first_guess", "ideal_motion", "kinematic_drivers",
    "local_point", "pivot_of", "rigid_system", "seated",
]  # fmt: skip
