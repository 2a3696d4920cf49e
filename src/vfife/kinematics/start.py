"""What a start is solved from: the mechanism, its rigid system and a first guess, known positions, and the
seats of its journals; the closed positions of its first guess.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..model.bodies import Point
from ..model.mechanism import Mechanism
from ..numerics.dense import norm, product
from ..numerics.elementwise import sincos
from .batch import Batch
from .drives import motor_angles, rigid_systems, spinless, with_angles
from .forces import Datum, Instant
from .guess import first_guesses
from .pins import centred
from .solve import close_all
from .system import RigidSystem, alike, mirrored

Array = NDArray[np.float64]
ROUND_OFF = 1e-9  # of the fastest velocity
MISFIT = 0.01  # of a given velocity, by which a run has to start with another one to be said so


@dataclass(frozen=True)
class Misfit:
    """The ``target`` that a model gives a ``body``, velocity of its origin (m/s, two numbers) or rate (rad/s,
    one), and the ``actual`` one with which a run starts.
    """

    body: str
    target: tuple[float, ...]
    actual: tuple[float, ...]

    @property
    def size(self) -> float:
        """Distance of the two (m/s or rad/s)."""
        return float(norm(np.subtract(self.actual, self.target)))

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of the given numbers."""
        columns = (2,) if len(self.target) == 1 else (0, 1)
        return tuple(f"body.{self.body}.velocity.{column}" for column in columns)

    @property
    def fact(self) -> str:
        """What differs, as in "rod starts with 4.2 rad/s instead of 6 rad/s"."""
        scale = ROUND_OFF * max(map(abs, (*self.target, *self.actual)))
        actual, target = (
            ", ".join(f"{value if abs(value) > scale else 0.0:.4g}" for value in values)
            for values in (self.actual, self.target)
        )
        if len(self.target) == 1:
            return f"{self.body} starts with {actual} rad/s instead of {target} rad/s"
        return f"the origin of {self.body} starts with ({actual}) m/s instead of ({target}) m/s"

    @property
    def text(self) -> str:
        """The caution, with a remedy."""
        remedy = (
            "joints, drivers and the velocities of other bodies (0 where none is given) do not permit it;"
            " give the bodies that it moves velocities that fit."
            if len(self.target) == 1
            else "joints and drivers do not permit that; give its origin the velocity of its pin."
        )
        return f"{self.fact[:1].upper() if len(self.target) > 1 else self.fact[:1]}{self.fact[1:]}: {remedy}"


# Of an angle (rad): a body so near its angle starts where the joints close, as angles of nine digits have it.
AT_ANGLE = 1e-7


@dataclass(frozen=True, eq=False)
class StartState:
    """A start from known positions and velocities of the centres of mass, shape (bodies + 1, 3); ``bodies``
    are those that are known.

    Bodies that are not known stand as the model's approximate start has them, at rest.
    """

    position: Array
    velocity: Array
    bodies: frozenset[str]

    def open_joints(self, mechanism: Mechanism) -> frozenset[str]:
        """Joints with clearance whose two bodies are known: they stay as they are, wherever in its bearing
        the journal is.
        """
        bodies = self.bodies | {"ground"}
        return frozenset(
            joint.name for joint in mechanism.contacts.values() if {side[0] for side in joint.sides} <= bodies
        )


@dataclass(frozen=True)
class Seat:
    """A journal pressed into its bearing: eccentricity in the bearing body's frame (m), depth (m) and force
    (N).
    """

    at: Point
    depth: float
    force: float


def handedness(guess: Array) -> float:
    """-1 if the first body that is not along x is turned clockwise, else 1: the mirror image has the opposite
    one.
    """
    for angle in guess[:, 2].tolist():
        if angle != 0.0:
            return -1.0 if angle < 0.0 else 1.0
    return 1.0


@dataclass(frozen=True)
class Start:
    """A mechanism with its ideal joints at one time (s), and a guess of the position [n, 3] from which it is
    closed.

    ``moving`` is the system of velocities, in which some joints may be open. ``inertial`` as in
    :func:`ideal_motion`; ``plain``: whether it is the start of the mechanism as it is. ``launched`` bodies
    have a velocity of their own in the model. ``motors``: bodies that torques turn, with the angles (rad) at
    which they start where the joints permit it.
    """

    mechanism: Mechanism
    time: float
    datum: Datum
    system: RigidSystem
    moving: RigidSystem
    guess: Array
    start_state: StartState | None = None
    inertial: Mapping[str, tuple[Array, Array, Array]] = field(default_factory=dict)
    plain: bool = False
    launched: Sequence[str] = ()
    motors: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def hand(self) -> float:
        """-1 where it is solved in its mirror image, so that that one starts from the same bits."""
        return handedness(self.guess)

    @cached_property
    def flip(self) -> Array:
        """Signs of x, y and angle in the image in which it is solved."""
        return np.array([1.0, self.hand, self.hand])

    @cached_property
    def images(self) -> tuple[RigidSystem, RigidSystem]:
        """The system and the moving one in the image in which they are solved."""
        if self.hand > 0.0:
            return self.system, self.moving
        image = mirrored(self.system)
        return image, image if self.moving is self.system else mirrored(self.moving)

    def wish(self, position: Array) -> Array:
        """Velocities [n, 3] from which those of joints and drives are to differ least, at its position [n,
        3].
        """
        result = np.zeros_like(position) if self.start_state is None else self.start_state.velocity
        for name in self.launched:
            row, velocity = self.system.names.index(name), np.array(self.mechanism.bodies[name].velocity)
            result[row] = centred(self.mechanism, name, position[row], velocity)[1]
        return result

    @cached_property
    def rates(self) -> dict[int, float]:
        """Given rates (rad/s) by row of their bodies. One of zero is none: it is the default."""
        points = spinless(self.mechanism) if self.launched else frozenset()
        return {
            self.system.names.index(name): rate
            for name in self.launched
            if (rate := self.mechanism.bodies[name].velocity[2]) and name not in points
        }

    def origin_velocity(self, name: str, position: Array, velocity: Array) -> Array:
        """Velocity (m/s) of a body's origin, shape (2,), from those of centres of mass [n, 3]."""
        row = self.system.names.index(name)
        turning = np.array([0.0, 0.0, velocity[row, 2]])
        return np.asarray(velocity[row, :2] - centred(self.mechanism, name, position[row], turning)[1][:2])

    def rates_to_keep(self, position: Array, velocity: Array) -> dict[int, float]:
        """Given rates that velocities [n, 3] do not have because joints move the origin of their body, with
        all other given ones; none where such a body has its rate.
        """
        fastest = float(np.abs(velocity).max(initial=0.0))
        for name in self.launched:
            row, target = self.system.names.index(name), self.mechanism.bodies[name].velocity
            off = norm(self.origin_velocity(name, position, velocity) - target[:2])
            if row in self.rates and off > ROUND_OFF * fastest:
                turning = max(float(np.abs(velocity[:, 2]).max()), abs(target[2]))
                if abs(velocity[row, 2] - target[2]) > ROUND_OFF * turning:
                    return self.rates
        return {}

    def misfits(self, position: Array, velocity: Array) -> tuple[Misfit, ...]:
        """Velocities that are given, but not those [n, 3] with which centres of mass start at a position [n,
        3].
        """
        result, floor = [], ROUND_OFF * float(np.abs(velocity).max(initial=0.0))
        for name in self.launched:
            row, (vx, vy, rate) = self.system.names.index(name), self.mechanism.bodies[name].velocity
            if row in self.rates:
                result.append(Misfit(name, (rate,), (float(velocity[row, 2]),)))
            if vx or vy:
                x, y = self.origin_velocity(name, position, velocity).tolist()
                result.append(Misfit(name, (vx, vy), (x, y)))
        return tuple(
            misfit for misfit in result if misfit.size > max(MISFIT * norm(np.array(misfit.target)), floor)
        )

    def add_inertial(self, instant: Instant, force: Array) -> None:
        """Add inertial forces to those on the centres of mass [n, 3]."""
        for name, (mass, local, extra) in self.inertial.items():
            row = instant.row(name)
            s, c = sincos(instant.position[row, 2])
            arm, push = product(local, np.array([[c, s], [-s, c]])), -mass[:, None] * extra[:, :2]
            force[row] += np.array(
                [*push.sum(axis=0), (arm[:, 0] * push[:, 1] - arm[:, 1] * push[:, 0]).sum()]
            )


def starts_of(
    batch: Batch,
    *,
    data: Sequence[Datum],
    seats: Sequence[Mapping[str, Seat]],
    plain: Sequence[bool],
    start_state: StartState | None = None,
    time: float = 0.0,
    guesses: Array | None = None,
) -> list[Start]:
    """Collect the equations and guesses from which the motions of mechanisms are solved. Raises VfifeError if
    one of them has none.
    """
    first = batch.first
    eccentric = [{name: seat.at for name, seat in journals.items()} for journals in seats]
    open_joints = frozenset() if start_state is None else start_state.open_joints(first)
    systems = moving = rigid_systems(batch, time=time, data=data, open_joints=open_joints, seats=eccentric)
    launched = [name for name, body in first.bodies.items() if any(body.velocity) and start_state is None]
    loose = open_joints | {
        j.name for j in first.contacts.values() if {side[0] for side in j.sides} & {*launched}
    }
    if loose != open_joints:
        moving = rigid_systems(batch, time=time, data=data, open_joints=loose, seats=eccentric)
    motors: list[Mapping[str, float]] = [{}] * len(batch)
    if guesses is None and start_state is None:
        motors = [motor_angles(mechanism) for mechanism in batch.mechanisms]
    if guesses is None:
        guesses = (
            first_guesses(batch) if start_state is None else np.array([start_state.position] * len(batch))
        )
    return [
        Start(
            mechanism,
            time,
            datum,
            system,
            moves,
            guess,
            start_state,
            plain=flag,
            launched=launched,
            motors=angles,
        )
        for mechanism, datum, system, moves, guess, flag, angles in zip(
            batch.mechanisms, data, systems, moving, guesses, plain, motors, strict=True
        )
    ]


def positions(
    systems: Sequence[RigidSystem], guesses: Sequence[Array], named: bool = True
) -> list[Array | VfifeError]:
    """Find the closed positions nearest to the guesses; the error of a system that stays open stands in its
    place. Systems of one structure are solved together.

    Each is solved in one of its two mirror images, so that the mirrored mechanism starts from the
    same bits.
    """
    result: dict[int, Array | VfifeError] = {}
    flips = [np.array([1.0, hand, hand]) for hand in map(handedness, guesses)]
    solved = [
        mirrored(system) if flip[1] < 0.0 else system for system, flip in zip(systems, flips, strict=True)
    ]
    for members in alike(solved):
        closures = close_all([solved[k] for k in members], [guesses[k] * flips[k] for k in members], named)
        result |= {
            k: closure if isinstance(closure, VfifeError) else closure.position * flips[k]
            for k, closure in zip(members, closures, strict=True)
        }
    return [result[k] for k in range(len(systems))]


def first_positions(
    systems: Sequence[RigidSystem],
    guesses: Sequence[Array],
    motors: Sequence[Mapping[str, float]],
    named: bool = True,
) -> list[Array | VfifeError]:
    """Find closed positions as :func:`positions`, in which bodies that ``motors`` turn keep their angles
    (rad) and the others move. Where these angles do not close, all bodies move.
    """
    result = positions(systems, guesses, named)
    off = [
        k
        for k, (place, angles) in enumerate(zip(result, motors, strict=True))
        if not isinstance(place, VfifeError)
        and any(
            abs(place[systems[k].names.index(body), 2] - angle) > AT_ANGLE for body, angle in angles.items()
        )
    ]
    exact = positions(
        [with_angles(systems[k], motors[k]) for k in off], [guesses[k] for k in off], named=False
    )
    for k, place in zip(off, exact, strict=True):
        result[k] = result[k] if isinstance(place, VfifeError) else place
    return result
