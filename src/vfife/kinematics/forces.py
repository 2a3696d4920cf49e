"""Forces that are known before the motion: weight, loads, torques, springs, dampers, stops and bushings, at one instant."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..model.drivers import Driver, Torque
from ..model.functions import clamped, torque_function
from ..model.lumping import rigid_properties
from ..model.mechanism import Mechanism
from ..model.springs import AnySpring, Bushing, Spring, TorsionalSpring
from .pins import world

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Datum:
    """What is counted from the start: places of driven travels and paths (m), by driver; distances (m) and relative angles (rad), by spring.

    ``angle`` has the angle (rad) of each body at the start: that from which driven angles and torques over an angle are counted.
    """

    travel: Mapping[str, float] = field(default_factory=dict)
    spring: Mapping[str, float] = field(default_factory=dict)
    angle: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Applied:
    """Force (N) on a body at its ``pin`` (or at a place in space, m, where there is none) and moment (N m)."""

    body: str
    pin: str
    at: tuple[float, float]
    force: tuple[float, float]
    moment: float = 0.0


@dataclass(frozen=True)
class Instant:
    """Bodies at one time (s): names with the ground first, positions and velocities (bodies + 1, 3)."""

    mechanism: Mechanism
    names: tuple[str, ...]
    position: Array
    velocity: Array
    time: float = 0.0

    def row(self, body: str) -> int:
        """Row of a body."""
        return self.names.index(body)

    def turn(self, first: str, second: str) -> tuple[float, float]:
        """Angle (rad) and angular velocity (rad/s) of the second body less those of the first."""
        a, b = self.row(first), self.row(second)
        return float(self.position[b, 2] - self.position[a, 2]), float(self.velocity[b, 2] - self.velocity[a, 2])

    def pin(self, text: str) -> tuple[str, str, Array, Array]:
        """Body, pin, place (m) and velocity (m/s) of ``body.pin``."""
        body, _, pin = text.partition(".")
        at, row = np.array(world(self.mechanism, self.position, self.names, (body, pin))), self.row(body)
        arm, w = at - self.position[row, :2], self.velocity[row, 2]
        return body, pin, at, self.velocity[row, :2] + w * np.array([-arm[1], arm[0]])


def applied(now: Instant, datum: Datum) -> list[Applied]:
    """Loads, torques and springs, each as forces on bodies; those on the ground are there too. Weight is not."""
    found = [*_loads(now), *_torques(now, datum)]
    for spring in now.mechanism.springs.values():
        found += _spring(spring, now, datum.spring.get(spring.name, 0.0))
    return found


def constant_forces(now: Instant, pushed: Iterable[Applied]) -> Array:
    """Weight and the applied forces on the centres of mass (N, N, N m), shape (bodies + 1, 3)."""
    force = np.zeros((len(now.names), 3))
    for name, body in now.mechanism.bodies.items():
        force[now.row(name), :2] += rigid_properties(body)[0] * np.array(now.mechanism.gravity)
    for one in pushed:
        row = now.row(one.body)
        x, y = np.subtract(one.at, now.position[row, :2])
        force[row] += np.array([*one.force, x * one.force[1] - y * one.force[0] + one.moment])
    force[0] = 0.0
    return force


def _loads(now: Instant) -> Iterator[Applied]:
    for load in now.mechanism.loads.values():
        body, pin, at, _ = now.pin(load.at)
        factor = 1.0 if load.times is None or load.factors is None else clamped(load.times, load.factors)(now.time)[0]
        fx, fy = load.force
        if load.follow:
            c, s = math.cos(now.position[now.row(body), 2]), math.sin(now.position[now.row(body), 2])
            fx, fy = c * fx - s * fy, s * fx + c * fy
        yield Applied(body, pin, (at[0], at[1]), (factor * fx, factor * fy), factor * load.moment)


def driven_body(name: str, driver: Driver) -> str:
    """The body that a driver turns; a driver without ``body``, ``slider`` and ``point`` is called by its body's name."""
    return driver.body or ("" if driver.slider or driver.point else name)


def _torques(now: Instant, datum: Datum) -> Iterator[Applied]:
    for name, driver in now.mechanism.drivers.items():
        if not isinstance(driver, Torque):
            continue
        body = driven_body(name, driver)
        function = torque_function(driver)
        if driver.point:
            moved, pin, at, speed = now.pin(driver.point)
            direction = np.array(driver.direction) / math.hypot(*driver.direction)
            x = float(direction @ speed) if driver.speeds else float(direction @ at) - datum.travel.get(name, 0.0) if driver.angles else now.time
            fx, fy = function(x)[0] * direction
            yield Applied(moved, pin, (at[0], at[1]), (float(fx), float(fy)))
            continue
        angle, rate = now.turn(driver.against, body)
        start = datum.angle.get(body, 0.0) - datum.angle.get(driver.against, 0.0)
        torque = function(rate if driver.speeds else angle - start if driver.angles else now.time)[0]
        yield from _couple(now, driver.against, body, torque)


def _couple(now: Instant, first: str, second: str, moment: float) -> Iterator[Applied]:
    """A moment on the second body, and its opposite on the first."""
    for body, value in ((second, moment), (first, -moment)):
        x, y = now.position[now.row(body), :2]
        yield Applied(body, "", (float(x), float(y)), (0.0, 0.0), value)


def _spring(spring: AnySpring, now: Instant, start: float) -> Iterator[Applied]:
    """Force of a massless element; ``start`` is its distance or angle at the start."""
    if isinstance(spring, Spring):
        first, second = now.pin(spring.first), now.pin(spring.second)
        apart = second[2] - first[2]
        length = float(np.hypot(*apart))
        if length > 0.0:
            along = apart / length
            free = start if spring.free_length is None else spring.free_length
            pull = spring.stiffness * (length - free) + spring.damping * float(along @ (second[3] - first[3]))
            for (body, pin, at, _), sign in ((first, 1.0), (second, -1.0)):
                yield Applied(body, pin, (at[0], at[1]), (sign * pull * along[0], sign * pull * along[1]))
    elif isinstance(spring, Bushing):
        yield from _bushing(spring, now, start)
    else:
        angle, rate = now.turn(spring.first, spring.second)
        if isinstance(spring, TorsionalSpring):
            moment = -spring.stiffness * (angle - (start if spring.free_angle is None else spring.free_angle)) - spring.damping * rate
        else:
            above = -spring.stiffness * (angle - spring.high) - spring.damping * rate
            below = -spring.stiffness * (angle - spring.low) - spring.damping * rate
            moment = min(above, 0.0) if angle > spring.high else max(below, 0.0) if angle < spring.low else 0.0
        yield from _couple(now, spring.first, spring.second, moment)


def _bushing(spring: Bushing, now: Instant, start: float) -> Iterator[Applied]:
    """-K d - C d' in the axes of the first body, d the second pin seen from the first; both forces act at the second pin's place."""
    first, second = now.pin(spring.first), now.pin(spring.second)
    row = now.row(first[0])
    c, s, w = math.cos(now.position[row, 2]), math.sin(now.position[row, 2]), now.velocity[row, 2]
    axes = np.array([[c, s], [-s, c]])
    apart = second[2] - first[2]
    d = axes @ apart
    rate = axes @ (second[3] - first[3] - w * np.array([-apart[1], apart[0]]))
    fx, fy = axes.T @ (-np.array(spring.stiffness[:2]) * d - np.array(spring.damping[:2]) * rate)
    angle, turning = now.turn(first[0], second[0])
    moment = -spring.stiffness[2] * (angle - start) - spring.damping[2] * turning
    at = (float(second[2][0]), float(second[2][1]))
    yield Applied(second[0], second[1], at, (float(fx), float(fy)), moment)
    yield Applied(first[0], first[1], at, (-float(fx), -float(fy)), -moment)
