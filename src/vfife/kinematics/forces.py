"""Forces that are known before the motion: weight, loads, torques, springs, dampers, stops and bushings, at
one instant.

They are those of a step: its own functions, run as plain Python on records of two pins without mass, whose
velocities stand as they are.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..kernels.arrays import FUNCTION, LOAD, PARTICLE, SPRING
from ..kernels.central_difference import Central
from ..kernels.elementary import sincos
from ..kernels.spring import spring as spring_force
from ..kernels.step import argument, load
from ..kernels.topology import BUSHING, LINEAR, SLIDING, SPEED, STOP, TIME, TORSIONAL, TRAVEL, TURNED
from ..model.drivers import Driver
from ..model.functions import crank_of, timed
from ..model.geometry.polynomials import Polynomials
from ..model.joints import Joint
from ..model.loads.load import Load, Push
from ..model.mechanism import Mechanism
from ..model.rows import Guided, place_row
from ..model.springs import AnySpring
from ..numerics.elementwise import hypot
from .batch import Shared
from .pins import world

Array = NDArray[np.float64]
AXES = {"linear": LINEAR, "torsional": TORSIONAL, "stop": STOP, "bushing": BUSHING}
STANDING = Central(h=0.0, decay=1.0, gain=0.0, p=1.0)  # a step of no length: velocities are what they are
NO_BODIES = (TIME, "ground", "ground")  # of a function of time


@dataclass(frozen=True)
class Datum:
    """What is counted from the start: places of driven travels and paths (m), by driver; distances (m) and
    relative angles (rad), by spring.

    ``angle`` has the angle (rad) of each body at the start: that from which driven angles and torques over an
    angle are counted.
    """

    travel: Mapping[str, float] = field(default_factory=dict)
    spring: Mapping[str, float] = field(default_factory=dict)
    angle: Mapping[str, float] = field(default_factory=dict)


class Applied(NamedTuple):
    """Force (N) on a body at its ``pin`` (or a place in space, m, where there is none) and moment (N m)."""

    body: str
    pin: str
    at: tuple[float, float]
    force: tuple[float, float]
    moment: float = 0.0


@dataclass(frozen=True)
class Guide:
    """Along what a travel goes: pins of the two bodies, a direction of the first, and the gap (m) of a table
    with two ways.
    """

    pins: tuple[str, str]
    direction: tuple[float, float]
    gap: float = 0.0


@dataclass(frozen=True)
class Action:
    """Forces (N) and moments (N m) per unit of a function, as (body, pin, (fx, fy, m)) for each body that
    feels them; no pin is the body itself.

    ``argument``: what the function depends on, TIME, TURNED, SPEED, TRAVEL or SLIDING, and the two bodies
    between which the angle, the speed or the travel is; ``guide`` says along what they travel. ``follow``:
    whether the force turns with the body. ``steady``: whether it does not depend on time, so that a static
    analysis multiplies it. ``owner``: "load" or "driver", and its name.
    """

    owner: tuple[str, str]
    function: Polynomials
    argument: tuple[int, str, str]
    ends: tuple[tuple[str, str, tuple[float, float, float]], ...]
    follow: bool = False
    steady: bool = True
    guide: Guide | None = None


@dataclass(frozen=True)
class End:
    """A pin of a body at one time: place (m), angle of the body (rad), velocity (m/s, m/s, rad/s)."""

    body: str
    pin: str
    at: tuple[float, float]
    angle: float
    velocity: tuple[float, float, float]

    @cached_property
    def record(self) -> tuple[float, ...]:
        """The record of a particle at this pin, in the format of a step."""
        row = [0.0] * PARTICLE.SIZE
        row[PARTICLE.x], row[PARTICLE.y], row[PARTICLE.theta] = *self.at, self.angle
        row[PARTICLE.s], row[PARTICLE.c] = sincos(self.angle)
        row[PARTICLE.u], row[PARTICLE.v], row[PARTICLE.w] = self.velocity
        return tuple(row)

    def pushed(self, fx: float, fy: float, moment: float) -> Applied:
        """Return a force (N) and a moment (N m) that act on this end."""
        return Applied(self.body, self.pin, self.at, (fx, fy), moment)


@dataclass(frozen=True)
class Instant:
    """Bodies at one time (s): names with the ground first, positions and velocities (bodies + 1, 3).

    ``ends_by_pin`` are those that were computed, since several forces act on one pin.
    """

    mechanism: Mechanism
    names: tuple[str, ...]
    position: Array
    velocity: Array
    time: float = 0.0
    ends_by_pin: dict[tuple[str, str], End] = field(default_factory=dict)

    def row(self, body: str) -> int:
        """Row of a body."""
        return self.names.index(body)

    def end(self, body: str, pin: str = "") -> End:
        """Return a pin of a body with its position and velocity, or the centre of mass without ``pin``."""
        if (body, pin) not in self.ends_by_pin:
            self.ends_by_pin[body, pin] = self._end(body, pin)
        return self.ends_by_pin[body, pin]

    def _end(self, body: str, pin: str) -> End:
        row = self.row(body)
        x, y, angle = self.position[row].tolist()
        u, v, w = self.velocity[row].tolist()
        at = world(self.mechanism, self.position, self.names, (body, pin)) if pin else (x, y)
        return End(body, pin, at, angle, (u - w * (at[1] - y), v + w * (at[0] - x), w))

    def ends(self, spring: AnySpring) -> tuple[End, End]:
        """Return the two ends of a spring."""
        (first, _, first_pin), (second, _, second_pin) = (
            text.partition(".") for text in (spring.first, spring.second)
        )
        return self.end(first, first_pin), self.end(second, second_pin)


def applied(instant: Instant, datum: Datum, shared: Shared | None = None) -> list[Applied]:
    """Return loads, torques and springs as forces on bodies, including those on the ground, without
    weight; ``shared`` are results for mechanisms with the same objects.
    """
    result = [force for action in actions(instant.mechanism, shared) for force in _acting(action, instant)]
    for spring in instant.mechanism.springs.values():
        result += _pulling(spring, instant, datum.spring.get(spring.name, 0.0))
    return result


def constant_forces(instants: Sequence[Instant], pushed: Sequence[Sequence[Applied]], mass: Array) -> Array:
    """Return weight and the applied forces on the centres of mass (N, N, N m) [cases, bodies + 1, 3], for
    masses (kg) [cases, bodies + 1].
    """
    gravity = np.array([instant.mechanism.gravity for instant in instants], dtype=float)
    force = np.zeros((*mass.shape, 3))
    force[..., :2] += mass[..., None] * gravity[:, None]
    for case, (instant, acting) in enumerate(zip(instants, pushed, strict=True)):
        for push in acting:
            row, (fx, fy) = instant.row(push.body), push.force
            x, y = (at - place for at, place in zip(push.at, instant.position[row, :2].tolist(), strict=True))
            force[case, row] += (fx, fy, x * fy - y * fx + push.moment)
    force[:, 0] = 0.0
    return force


def driven_body(name: str, driver: Driver) -> str:
    """Return the body that a driver turns. A driver without ``body``, ``slider`` and ``point`` has its body's
    name.
    """
    return driver.body or ("" if driver.slider or driver.point else name)


def actions(mechanism: Mechanism, shared: Shared | None = None) -> list[Action]:
    """Return the loads at pins, and the torques or forces of drivers with their reactions. Raises ValueError
    for a force over a speed or an angle. ``shared`` are results for mechanisms with the same objects.
    """
    if shared is None:
        return _actions(mechanism)
    key = "actions", mechanism.clock, *[body.angle for body in mechanism.bodies.values()]
    parts = mechanism.loads, mechanism.drivers, mechanism.joints
    return shared.recall(key, parts, lambda: _actions(mechanism))


def _actions(mechanism: Mechanism) -> list[Action]:
    result = [action for name, load in mechanism.loads.items() for action in _loading(mechanism, name, load)]
    for name, driver in mechanism.drivers.items():
        if not driver.moves:
            body = driven_body(name, driver)
            function, depends = _effort(mechanism, driver, body)
            result.append(
                Action(("driver", name), function, depends, _sides(driver, body), steady=driver.steady)
            )
    return result


def _loading(mechanism: Mechanism, name: str, load: Load) -> Iterator[Action]:
    """Yield the actions of a load: one for the part fixed in space, one for the part that rotates with its
    bodies.
    """
    function, gap = load.course()
    function = timed(function, mechanism.clock) if load.argument == "time" else function
    argument, guide = _depends(mechanism, load, gap)
    pushes = load.pushes(mechanism.joints)
    for follow in (False, True):
        ends = tuple(
            (push.body, push.pin, _aligned(push, mechanism)) for push in pushes if push.follow == follow
        )
        if ends:
            yield Action(("load", name), function, argument, ends, follow, load.steady, guide)


def _depends(mechanism: Mechanism, load: Load, gap: float) -> tuple[tuple[int, str, str], Guide | None]:
    """Return the argument of a load's function, and the guide along which a travel is measured."""
    if load.argument == "time":
        return NO_BODIES, None
    if load.argument == "angle":
        return (TURNED, "ground", crank_of(mechanism, load.crank)), None
    joint = mechanism.joints[load.slider]
    (bearing, first), (journal, second) = joint.sides
    guide = Guide((first, second), guide_direction(joint), gap)
    return (TRAVEL if load.argument == "travel" else SLIDING, bearing, journal), guide


def guide_direction(joint: Joint) -> tuple[float, float]:
    """Direction of a joint's guide, in the frame of the bearing's body. ValueError where it has none."""
    guide = place_row(joint.rows())
    if not isinstance(guide, Guided):
        raise VfifeError(
            f"joint {joint.name!r} has no guide along which something could travel; name a slider"
        )
    return guide.unit()


def _model_angle(mechanism: Mechanism, body: str) -> float:
    """Return the angle (rad) of a body in the model; a run that continues another run counts from it too."""
    return 0.0 if body == "ground" else mechanism.bodies[body].angle


def _aligned(push: Push, mechanism: Mechanism) -> tuple[float, float, float]:
    """Force and moment in the frame of the body on which they act."""
    if not push.aligned:
        return push.acts
    s, c = sincos(_model_angle(mechanism, push.aligned) - _model_angle(mechanism, push.body))
    x, y, moment = push.acts
    return c * x - s * y, s * x + c * y, moment


def _sides(driver: Driver, body: str) -> tuple[tuple[str, str, tuple[float, float, float]], ...]:
    if driver.point:
        owner, _, pin = driver.point.partition(".")
        return ((owner, pin, (*unit(driver.direction), 0.0)),)
    opposite = () if driver.against == "ground" else ((driver.against, "", (0.0, 0.0, -1.0)),)
    return (body, "", (0.0, 0.0, 1.0)), *opposite


def _effort(mechanism: Mechanism, driver: Driver, body: str) -> tuple[Polynomials, tuple[int, str, str]]:
    """Return the function of a torque and its argument: time, the speed of the body, or its angle from the
    start position of the model.
    """
    function = driver.effort()
    if driver.argument == "time":
        return timed(function, mechanism.clock), NO_BODIES
    if driver.point:
        raise VfifeError(
            f"the force on {driver.point!r} cannot be a table over speeds or angles, which a body has; give"
            " it times, or use a spring"
        )
    if driver.argument == "speed":
        return function, (SPEED, driver.against, body)
    begin = _model_angle(mechanism, body) - _model_angle(mechanism, driver.against)
    shifted = dataclasses.replace(function, starts=tuple(start + begin for start in function.starts))
    return shifted, (TURNED, driver.against, body)


def unit(direction: tuple[float, float]) -> tuple[float, float]:
    """Return the direction with length 1. Raises ValueError for a direction without length."""
    size = float(hypot(*direction))
    if not size > 0.0:
        raise VfifeError(f"a direction of {direction} has no length: give two numbers that are not both zero")
    return direction[0] / size, direction[1] / size


def kind_of_spring(spring: AnySpring) -> int:
    """Its axes."""
    return AXES[spring.axes]


def spring_fields(spring: AnySpring, start: float) -> dict[str, tuple[float, ...]]:
    """Parameters of a spring in the kernels' record; ``start`` is its distance (m) or angle (rad) at the
    start, where it is free unless said.
    """
    numbers = spring.numbers(start)
    return {
        "stiffness": numbers.stiffness,
        "damping": numbers.damping,
        "free": (numbers.free,),
        "high": (numbers.high,),
    }


def _records(ends: Sequence[End], extra: int) -> list[float]:
    """Return the records of these pins, and ``extra`` zeros after them."""
    return [number for end in ends for number in end.record] + [0.0] * extra


def _acting(action: Action, instant: Instant) -> Iterator[Applied]:
    """Yield the forces of an action at this instant."""
    kind, *bodies = action.argument
    guide, function = action.guide or Guide(("", ""), (1.0, 0.0)), 2 * PARTICLE.SIZE
    records = _records(
        [instant.end(body, pin) for body, pin in zip(bodies, guide.pins, strict=True)], FUNCTION.SIZE
    )
    for name, number in zip(("along_x", "along_y", "gap"), (*guide.direction, guide.gap), strict=True):
        records[function + getattr(FUNCTION, name)] = number
    value = action.function(argument(records, kind, 0, PARTICLE.SIZE, function, instant.time, 0.0))[0]
    for body, pin, (fx, fy, moment) in action.ends:
        end = instant.end(body, pin)
        rows = _records([end], LOAD.SIZE)
        for name, per_unit in (("fx", fx), ("fy", fy), ("m", moment)):
            rows[PARTICLE.SIZE + getattr(LOAD, name)] = per_unit
        yield end.pushed(*load(rows, PARTICLE.SIZE, 0, int(action.follow), value))


def _pulling(spring: AnySpring, instant: Instant, start: float) -> Iterator[Applied]:
    """Force of a massless element on its two ends; ``start`` is its distance or angle at the start."""
    ends = instant.ends(spring)
    for end, force in zip(ends, pull(spring, start, ends), strict=True):
        yield end.pushed(*force)


def pull(spring: AnySpring, start: float, ends: Sequence[End]) -> list[tuple[float, float, float]]:
    """Force (N, N) and moment (N m) of a massless element on each of its two pins; ``start`` is its distance
    or angle at the start.
    """
    element = 2 * PARTICLE.SIZE
    rows = _records(ends, SPRING.SIZE)
    for name, values in spring_fields(spring, start).items():
        first = element + getattr(SPRING, name)
        rows[first : first + len(values)] = values
    spring_force(rows, element, 0, PARTICLE.SIZE, kind_of_spring(spring), STANDING)
    return [
        (rows[base + PARTICLE.fx], rows[base + PARTICLE.fy], rows[base + PARTICLE.mz])
        for base in (0, PARTICLE.SIZE)
    ]
