"""Starts of a record: angles and angular velocities of bodies at its first sample, as numbers of a fit.

A model file gives each body a velocity of its own, and those of bodies that are joined have to agree. Here
only the rate of a body is given, ``start.BODY.angular_velocity``, and all other velocities follow from the
joints.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..kinematics.initial import Motion, ideal_motions
from ..kinematics.pins import centred
from ..model.functions import bodies_at_rest
from ..model.mechanism import Mechanism
from .measurements import Measured

Array = NDArray[np.float64]
PREFIX = "start."
ANGLE, RATE = ".angle", ".angular_velocity"
UNITS = {ANGLE: "rad", RATE: "rad/s"}
FIRST_SAMPLES = (5, 9, 15, 21)  # numbers of samples of the parabolas; that with the surest rate counts
# Half the interval of a start: this number of standard errors of the parabola, plus these shares of the
# largest angle and of the largest rate in the record.
ERRORS, LEAST_ANGLE, LEAST_RATE = 10.0, 0.02, 0.05


def unit_of_start(mechanism: Mechanism, path: str) -> str | None:
    """Return the unit of ``start.BODY.angle`` (rad) or ``start.BODY.angular_velocity`` (rad/s) for a body of
    the mechanism; None for any other path.
    """
    body, _, quantity = path.removeprefix(PREFIX).rpartition(".")
    body_there = path.startswith(PREFIX) and body in mechanism.bodies
    return UNITS.get(f".{quantity}") if body_there else None


def start_paths(mechanism: Mechanism) -> list[str]:
    """Return the paths of all start values of a mechanism."""
    return [f"{PREFIX}{body}{quantity}" for body in mechanism.bodies for quantity in UNITS]


def with_starts(
    mechanisms: Sequence[Mechanism | VfifeError], starts: Sequence[Mapping[str, float]]
) -> list[Mechanism | VfifeError]:
    """Mechanisms with the angles (rad) and angular velocities (rad/s) of their ``starts``, by path; a
    mechanism that cannot be assembled with its start is replaced by the error.
    """
    turned = [
        mechanism if isinstance(mechanism, VfifeError) else with_angles(mechanism, start)
        for mechanism, start in zip(mechanisms, starts, strict=True)
    ]
    moving = [
        k
        for k, (mechanism, start) in enumerate(zip(turned, starts, strict=True))
        if isinstance(mechanism, Mechanism) and any(path.endswith(RATE) for path in start)
    ]
    motions = ideal_motions([with_drivers(turned[k], starts[k]) for k in moving])  # type: ignore[arg-type]
    for k, motion in zip(moving, motions, strict=True):
        turned[k] = motion if isinstance(motion, VfifeError) else with_velocities(turned[k], motion)  # type: ignore[arg-type]
    return turned


def with_angles(mechanism: Mechanism, start: Mapping[str, float]) -> Mechanism:
    """Return the mechanism with the start angles of ``start``."""
    angles = dict(values_of(start, ANGLE))
    bodies = {
        name: dataclasses.replace(body, angle=angles[name]) if name in angles else body
        for name, body in mechanism.bodies.items()
    }
    return dataclasses.replace(mechanism, bodies=bodies, source=None) if angles else mechanism


def with_drivers(mechanism: Mechanism, start: Mapping[str, float]) -> Mechanism:
    """Return the mechanism with a driver for each start rate, whose ideal motion has the resulting
    velocities.
    """
    drivers = {name: driver for name, driver in mechanism.drivers.items() if driver.moves}
    bodies = bodies_at_rest(mechanism)
    result = dataclasses.replace(mechanism, bodies=bodies, springs={}, loads={}, drivers=drivers, source=None)
    for body, rate in values_of(start, RATE):
        result.drive(body, speed=rate)
    return result


def with_velocities(mechanism: Mechanism, motion: Motion) -> Mechanism:
    """Return the mechanism whose bodies start with the velocities of a motion."""
    bodies = {}
    for name, body in mechanism.bodies.items():
        position, velocity, _ = motion.of(name)
        pose = np.array([0.0, 0.0, position[2]])
        _, arm = centred(mechanism, name, pose, np.array([0.0, 0.0, velocity[2]]))
        x, y, rate = (velocity - [arm[0], arm[1], 0.0]).tolist()
        bodies[name] = dataclasses.replace(body, velocity=(x, y, rate))
    return dataclasses.replace(mechanism, bodies=bodies, source=None)


def values_of(start: Mapping[str, float], ending: str) -> Iterator[tuple[str, float]]:
    """Bodies and the values of their angles or rates."""
    for path, value in start.items():
        if path.endswith(ending):
            yield path.removeprefix(PREFIX).removesuffix(ending), value


def starts_of(data: Measured) -> dict[str, tuple[float, float]]:
    """Bounds (rad, rad/s) of the start of each body whose angle a record over time has: those of a
    parabola through the first samples, with its errors.
    """
    bounds: dict[str, tuple[float, float]] = {}
    for curve in data.curves:
        body, _, quantity = curve.channel.rpartition(".")
        if data.over != "time" or f".{quantity}" != ANGLE or curve.proportional:
            continue
        parabolas = [parabola(data.places[:count], curve.values[:count]) for count in FIRST_SAMPLES]
        solution, errors = min(parabolas, key=lambda estimate: estimate[1][1])
        reach = float(np.abs(curve.values - curve.values.mean()).max())
        fastest = float(np.abs(np.gradient(curve.values, data.places)).max())
        halves = {
            ANGLE: ERRORS * errors[0] + LEAST_ANGLE * reach, RATE: ERRORS * errors[1] + LEAST_RATE * fastest
        }  # fmt: skip
        for k, (ending, half) in enumerate(halves.items()):
            bounds[f"{PREFIX}{body}{ending}"] = (float(solution[k] - half), float(solution[k] + half))
    return bounds


def parabola(times: Array, values: Array) -> tuple[Array, Array]:
    """Value, rate and acceleration at the first of some samples, and their standard errors."""
    since = times - times[0]
    columns = np.stack([np.ones(len(since)), since, 0.5 * since * since], axis=1)
    solution, *_ = np.linalg.lstsq(columns, values, rcond=None)
    left = values - columns @ solution
    error = math.sqrt(float(left @ left) / max(len(since) - 3, 1))
    return solution, error * np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))


def split(numbers: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, float]]:
    """Numbers of a model by path, and those of its start."""
    start = {path: float(value) for path, value in numbers.items() if path.startswith(PREFIX)}
    return {path: value for path, value in numbers.items() if path not in start}, start
