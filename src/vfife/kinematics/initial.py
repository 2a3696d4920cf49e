"""The motion a run starts from: positions closed from approximate angles, velocities and accelerations of the
ideal mechanism.
"""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..laws.elasticity import tangent
from ..model.drivers import Driver
from ..model.joints import Joint
from ..model.mechanism import Mechanism
from ..model.surfaces import surfaces
from ..numerics.elementwise import hypot, sincos
from .batch import Batch, Shared, Structures
from .drives import motor_angles, rigid_systems, travel_of
from .forces import Applied, Datum, Instant, applied, constant_forces, driven_body
from .guess import first_guesses
from .mobility import Mobility, mobility
from .rows import measured
from .solve import Accelerations, ClosedSystems, Velocities, accelerations, velocities, with_rates
from .start import Misfit, Seat, Start, StartState, first_positions, starts_of
from .system import RigidSystem, alike

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
    ``independent``: whether no row of its constraints is known to depend on others; ``finite``: whether all
    of its places, velocities and accelerations are known to be finite. ``misfits``: velocities given in the
    model that are not those of the motion.
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
    independent: bool = False
    finite: bool = False
    misfits: tuple[Misfit, ...] = ()

    def solves(self, start: Start) -> bool:
        """Whether equations, first guess (in the solved mirror image) and angles of motors are those that
        this motion was solved from, number by number.
        """
        mine, system, guess = self.system, start.images[0], start.guess * start.flip
        return (
            self.guess is not None
            and self.mechanism is not None
            and motor_angles(self.mechanism) == start.motors
            and mine.names == system.names
            and [constraint.content for constraint in mine.constraints]
            == [constraint.content for constraint in system.constraints]
            and np.array_equal(mine.mass, system.mass)
            and np.array_equal(mine.inertia, system.inertia)
            and np.array_equal(self.guess, guess)
        )

    @cached_property
    def mobility(self) -> Mobility:
        """Degrees of freedom, redundant and singular joints."""
        if self.independent:
            columns, system = 3 * len(self.names) - 3, self.system
            return Mobility(columns - system.joint_rows, columns - system.starts[-1], 0, ())
        return mobility(self.system, self.position * (1.0, self.hand, self.hand))

    def of(self, body: str) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration of a body's centre of mass."""
        k = self.names.index(body)
        return self.position[k], self.velocity[k], self.acceleration[k]


def seats_of(mechanism: Mechanism, motion: Motion) -> dict[str, Seat]:
    """Return the seats of journals where the reactions of the ideal ``motion`` press them."""
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


def datum_of(mechanism: Mechanism, start_state: StartState | None = None) -> Datum:
    """Where travels, distances and angles count from: the start, closed without the drivers of travels and
    paths.

    Travels, paths and driven angles count from the position of ``start_state``, if there is one; free lengths
    are those of the model's own start.
    """
    [result] = datums([mechanism], start_state, Structures())
    if isinstance(result, VfifeError):
        raise result
    return result


def datums(
    mechanisms: Sequence[Mechanism], start_state: StartState | None, structures: Structures
) -> list[Datum | VfifeError]:
    """Compute the datum of each of many mechanisms; the error of one whose links cannot reach stands in its
    place.
    """
    travels = [
        {name: driver for name, driver in mechanism.drivers.items() if not driven_body(name, driver)}
        for mechanism in mechanisms
    ]
    closed = [
        k
        for k, mechanism in enumerate(mechanisms)
        if mechanism.springs or (travels[k] and start_state is None)
    ]
    free = in_batches([mechanisms[k] for k in closed], _without_travels, structures)
    solutions: dict[int, Any] = dict(zip(closed, free, strict=True))
    sound = [k for k in closed if not isinstance(solutions[k], VfifeError)]
    systems, guesses = [solutions[k][0] for k in sound], [solutions[k][1] for k in sound]
    motors = [motor_angles(mechanisms[k]) for k in sound]
    solutions |= dict(zip(sound, first_positions(systems, guesses, motors), strict=True))
    return [
        _datum(mechanism, travels[k], solutions.get(k), start_state) for k, mechanism in enumerate(mechanisms)
    ]


def _without_travels(batch: Batch, indices: Sequence[int]) -> list[tuple[RigidSystem, Array]]:
    """Return the systems in which travels and paths are free, and first guesses."""
    seats: list[dict[str, tuple[float, float]]] = [{}] * len(indices)
    systems = rigid_systems(batch, data=[Datum()] * len(indices), seats=seats, travels=False)
    return list(zip(systems, first_guesses(batch), strict=True))


Answer = TypeVar("Answer")


def attempt(function: Callable[..., Answer], *arguments: Any, **options: Any) -> Answer | VfifeError:
    """Call a function and return its result, or the error that it raises."""
    try:
        return function(*arguments, **options)
    except VfifeError as error:
        return error
    except ValueError as error:  # numbers beyond all bounds in linear algebra
        return VfifeError(str(error))


def in_batches(
    mechanisms: Sequence[Mechanism],
    function: Callable[[Batch, Sequence[int]], Sequence[Answer]],
    structures: Structures,
) -> list[Answer | VfifeError]:
    """Call a function with each batch of mechanisms of one structure and their indices; return its result for
    each mechanism, or the error of that one.
    """
    result: dict[int, Answer | VfifeError] = {}
    for indices in structures.groups(mechanisms):
        answers = attempt(function, structures.batch([mechanisms[k] for k in indices]), indices)
        if not isinstance(answers, VfifeError):
            result |= dict(zip(indices, answers, strict=True))
        elif len(indices) == 1:
            result[indices[0]] = answers
        else:  # each by itself, as the others have no fault
            alone = {k: attempt(function, structures.batch([mechanisms[k]]), [k]) for k in indices}
            result |= {
                k: answer if isinstance(answer, VfifeError) else answer[0] for k, answer in alone.items()
            }
    return [result[k] for k in range(len(mechanisms))]


def _datum(
    mechanism: Mechanism,
    travels: Mapping[str, Driver],
    closed: Array | VfifeError | None,
    start_state: StartState | None,
) -> Datum | VfifeError:
    """Return the datum that follows from a closed position ``own``, or from the start state."""
    if isinstance(closed, VfifeError):
        return closed
    names, origin = ("ground", *mechanism.bodies), start_state.position if start_state is not None else closed
    travel = (
        {}
        if origin is None
        else {
            name: measured(travel_of(mechanism, names, name, driver), origin)
            for name, driver in travels.items()
        }
    )
    angle = (
        {name: float(start_state.position[k, 2]) for k, name in enumerate(names)}
        if start_state is not None
        else {}
    )
    angle = {name: body.angle for name, body in mechanism.bodies.items()} | angle
    spring = {} if closed is None else _at_rest(Instant(mechanism, names, closed, np.zeros_like(closed)))
    return Datum(travel, spring, angle)


def _at_rest(instant: Instant) -> dict[str, float]:
    """Distance (m) or relative angle (rad) of every spring at the start."""
    result = {}
    for name, spring in instant.mechanism.springs.items():
        first, second = instant.ends(spring)
        if spring.axes == "linear":
            result[name] = float(hypot(*np.subtract(second.at, first.at)))
        else:
            result[name] = second.angle - first.angle
    return result


def _starts_alike(former: Mechanism | None, mechanism: Mechanism, shared: Shared) -> bool:
    """Whether the same bodies, drivers, springs and loads are tied by joints of the same rows, as in a
    mechanism and its ideal reference.
    """
    if former is None or len(former.bodies) != len(mechanism.bodies):
        return False
    bodies = former.bodies.values(), mechanism.bodies.values()
    if any(any(body.velocity) for body in bodies[0]) or not all(map(operator.is_, *bodies)):
        return False
    parts = (
        (m.points, m.drivers, m.springs, m.loads, m.gears, m.gravity, m.clock, m.settings.analysis)
        for m in (former, mechanism)
    )
    return (
        [*former.bodies] == [*mechanism.bodies]
        and operator.eq(*parts)
        and shared(_tie_alike, former.joints, mechanism.joints)
    )


def _tie_alike(*joints: Mapping[str, Joint]) -> bool:
    """Whether the joints of two mechanisms have the same names, sides and rows."""
    first, second = (
        [(name, j.sides, j.rows(), j.rank, j.first_place) for name, j in group.items()] for group in joints
    )
    return first == second


def ideal_motion(
    mechanism: Mechanism,
    time: float = 0.0,
    guess: Array | None = None,
    *,
    inertial: Mapping[str, tuple[Array, Array, Array]] | None = None,
    seats: Mapping[str, Seat] | None = None,
    datum: Datum | None = None,
    start_state: StartState | None = None,
    named: bool = True,
    motion: Motion | None = None,
) -> Motion:
    """Position, velocity, acceleration and reactions of the ideal mechanism at ``time`` (s), on the branch
    nearest the guess.

    ``inertial``: accelerations of a body's particles beyond its rigid motion, as masses, places in its frame
    and accelerations. ``datum``: where travels and springs count from, :func:`datum_of` unless given.
    ``start_state``: a start from known positions and velocities. ``motion``: a motion solved before. It is
    taken where it is that of this mechanism or of its ideal reference, and its position wherever that follows
    from the same numbers; so it never changes the result. Joints with clearance whose body was given a
    velocity of its own are closed in position only; those between bodies of a given start are left as they
    are. Raises AssemblyError where links cannot reach, which says what stays open by how much where that is
    to be ``named``.
    """
    plain = not (time or seats or inertial) and guess is None and datum is None and start_state is None
    if plain and motion is not None and _is_start_of(motion, mechanism, Shared()):
        return motion
    datum = datum_of(mechanism, start_state) if datum is None else datum
    [start] = starts_of(
        Batch([mechanism]),
        data=[datum],
        seats=[seats or {}],
        plain=[plain],
        start_state=start_state,
        time=time,
        guesses=None if guess is None else guess[None],
    )
    if inertial:
        start = dataclasses.replace(start, inertial=inertial)
    [result] = solve_starts([start], [motion], named, shared=Shared())
    if isinstance(result, VfifeError):
        raise result
    return result


def ideal_motions(
    mechanisms: Sequence[Mechanism],
    *,
    seats: Sequence[Mapping[str, Seat]] | None = None,
    former: Sequence[Motion | None] | None = None,
    start_state: StartState | None = None,
    structures: Structures | None = None,
) -> list[Motion | VfifeError]:
    """Solve the start of each of many mechanisms, bit for bit as :func:`ideal_motion`; the error of one
    without a start stands in its place.

    Mechanisms of one structure are solved together, which takes a tenth of the time.

    seats: seats of the journals of each mechanism
    former: an earlier motion of each mechanism, or None
    structures: of mechanisms and objects that are known already
    """
    seats, former = seats or [{}] * len(mechanisms), former or [None] * len(mechanisms)
    structures = structures or Structures()
    plain = [not mechanism_seats and start_state is None for mechanism_seats in seats]
    result: dict[int, Motion | VfifeError] = {
        k: motion
        for k, motion in enumerate(former)
        if motion is not None and plain[k] and _is_start_of(motion, mechanisms[k], structures.shared)
    }
    unknown = [k for k in range(len(mechanisms)) if k not in result]
    data: dict[int, Any] = dict(
        zip(unknown, datums([mechanisms[k] for k in unknown], start_state, structures), strict=True)
    )
    result |= {k: datum for k, datum in data.items() if isinstance(datum, VfifeError)}
    unknown = [k for k in unknown if k not in result]

    def collected(batch: Batch, indices: Sequence[int]) -> list[Start]:
        cases = [unknown[i] for i in indices]
        return starts_of(
            batch, data=[data[k] for k in cases], seats=[seats[k] for k in cases],
            plain=[plain[k] for k in cases], start_state=start_state,
        )  # fmt: skip

    starts: dict[int, Start] = {}
    group = in_batches([mechanisms[k] for k in unknown], collected, structures)
    for k, start in zip(unknown, group, strict=True):
        (starts if isinstance(start, Start) else result)[k] = start  # type: ignore[assignment]
    solve = partial(solve_starts, shared=structures.shared)
    answers = attempt(solve, list(starts.values()), [former[k] for k in starts])
    if isinstance(answers, VfifeError):  # numbers of one case have left all bounds
        alone = {k: attempt(solve, [start], [former[k]]) for k, start in starts.items()}
        answers = [answer if isinstance(answer, VfifeError) else answer[0] for answer in alone.values()]
    result |= dict(zip(starts, answers, strict=True))
    return [result[k] for k in range(len(mechanisms))]


def _is_start_of(motion: Motion, mechanism: Mechanism, shared: Shared) -> bool:
    """Whether a motion is the start of a mechanism, or of one whose start has the same numbers."""
    return motion.mechanism is mechanism or _starts_alike(motion.mechanism, mechanism, shared)


def solve_starts(
    starts: Sequence[Start], former: Sequence[Motion | None], named: bool = True, *, shared: Shared
) -> list[Motion | VfifeError]:
    """Solve the motions of these starts; the position of a ``former`` motion with the same equations is
    reused. ``shared``: results for mechanisms with the same objects.
    """
    places: dict[int, Array | VfifeError] = {
        k: motion.position
        for k, (start, motion) in enumerate(zip(starts, former, strict=True))
        if motion is not None and motion.solves(start)
    }
    unknown = [k for k in range(len(starts)) if k not in places]
    open_starts = [starts[k] for k in unknown]
    systems, guesses = [start.system for start in open_starts], [start.guess for start in open_starts]
    closed = first_positions(systems, guesses, [start.motors for start in open_starts], named)
    places |= dict(zip(unknown, closed, strict=True))
    return motions(starts, [places[k] for k in range(len(starts))], shared)


def motions(
    starts: Sequence[Start], places: Sequence[Array | VfifeError], shared: Shared
) -> list[Motion | VfifeError]:
    """Velocities, accelerations and reactions at closed positions [n, 3]; a fault stands in the place of a
    motion.
    """
    result: list[Any] = list(places)
    closed = [k for k, place in enumerate(places) if not isinstance(place, VfifeError)]
    moved = [starts[k].images[1] for k in closed]
    for members in alike(moved):
        group = [starts[closed[k]] for k in members]
        systems = [moved[k] for k in members]
        position = [result[closed[k]] for k in members]
        flip = np.array([start.flip for start in group])[:, None]
        place = flip * position
        wish = flip * [start.wish(at) for start, at in zip(group, position, strict=True)]
        closed_systems = ClosedSystems.of(systems, place)
        moving = velocities(closed_systems, wish)
        moving = _with_rates(group, closed_systems, position, moving)
        speeds = moving.velocity * flip
        instants = [
            Instant(start.mechanism, start.system.names, at, speed, start.time)
            for start, at, speed in zip(group, position, speeds, strict=True)
        ]
        pushed = [
            tuple(applied(instant, start.datum, shared))
            for instant, start in zip(instants, group, strict=True)
        ]
        force = constant_forces(instants, pushed, np.array([system.mass for system in systems]))
        for start, instant, acting in zip(group, instants, force, strict=True):
            start.add_inertial(instant, acting)
        solved = accelerations(closed_systems, moving.velocity, flip * force)
        solved = solved._replace(acceleration=solved.acceleration * flip, reaction=solved.reaction * flip)
        numbers = np.isfinite(place) & np.isfinite(moving.velocity) & np.isfinite(solved.acceleration)
        finite = numbers.all(axis=(1, 2)).tolist()
        for i, k in enumerate(members):
            fault = moving.faults[i] or solved.faults[i]
            result[closed[k]] = fault or _motion(group[i], instants[i], pushed[i], solved, i, finite[i])
    return result


def _with_rates(
    group: Sequence[Start], closed: ClosedSystems, position: Sequence[Array], nearest: Velocities
) -> Velocities:
    """Return the ``nearest`` velocities, with given rates where joints move the origins of their bodies;
    ``position`` [n, 3] of each is not mirrored.
    """
    rates: list[dict[int, float]] = []
    for start, at, velocity in zip(group, position, nearest.velocity, strict=True):
        targets = start.rates_to_keep(at, velocity * start.flip) if start.rates else {}
        rates.append({row: start.hand * rate for row, rate in targets.items()})
    return with_rates(closed, nearest, rates) if any(rates) else nearest


def _motion(
    start: Start, instant: Instant, pushed: tuple[Applied, ...], solved: Accelerations, i: int, finite: bool
) -> Motion:
    """Return the motion of a start from case ``i`` of a batch."""
    reaction = {
        joint.name: tuple(row)
        for joint, row in zip(start.moving.joints, solved.reaction[i].tolist(), strict=True)
    }
    torque = {
        d.name: value * (start.hand if d.turns else 1.0)
        for d, value in zip(start.moving.drives, solved.driving[i].tolist(), strict=True)
    }
    return Motion(
        instant.names, instant.position, instant.velocity, solved.acceleration[i], reaction,
        torque, start.datum, pushed, start.images[0], start.hand,
        start.mechanism if start.plain else None, start.guess * start.flip if start.plain else None,
        bool(solved.independent[i]) and start.moving is start.system, finite,
        start.misfits(instant.position, instant.velocity),
    )  # fmt: skip
