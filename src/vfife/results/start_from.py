"""A start from a former run, or from positions and velocities by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..analysis.motion import body_motion, body_velocity
from ..kinematics.initial import Given, Motion, ideal_motion
from ..kinematics.pins import centred, first_guess
from ..model.mechanism import Mechanism
from ..numerics.scalar import sincos
from .view import View

Array = NDArray[np.float64]
States: TypeAlias = Mapping[str, Sequence[float] | tuple[Sequence[float], Sequence[float]]]


def start_from(source: View | States, mechanism: Mechanism, time: float | None = None) -> Motion:
    """The motion that starts where a former run was at ``time`` (s; its last output unless given), or from states by name.

    A mapping has, for each body, (x, y, angle) of its frame's origin (m, m, rad), or that and its velocity (m/s, m/s, rad/s); bodies that it
    leaves out stand as the model has them. Positions are closed from there on the nearest branch; velocities are the nearest (in kinetic
    energy) that joints and drivers allow. Joints with play between bodies that are given stay as they are. Driven angles and travels go on
    from here, by the clock on which the former run was; free lengths and angles of torques count from where the model has its bodies. Raises
    ValueError where names, numbers or the time do not fit, AssemblyError where the joints cannot close.
    """
    return ideal_motion(on_clock(mechanism, source, time), given=initial_state(source, mechanism, time))


def on_clock(mechanism: Mechanism, source: View | States, time: float | None = None) -> Mechanism:
    """The mechanism with its clock where that of a former run stands at ``time`` (s; its last output unless given).

    One that says itself where it stands (``start.time``) is left as it is. States by name and load factors have no clock: there it begins at 0.
    """
    if isinstance(source, Mapping) or source.record.static or mechanism.start.time is not None:
        return mechanism
    passed = source.time[-1 if time is None else int(np.argmin(np.abs(source.time - time)))]
    clock = source.record.assembly.mechanism.clock + float(passed)
    return dataclasses.replace(mechanism, start=dataclasses.replace(mechanism.start, time=clock))


def initial_state(source: View | States, mechanism: Mechanism, time: float | None = None) -> Given:
    """Positions and velocities of the centres of mass that a run or a mapping gives."""
    said, states = ("the start", source) if isinstance(source, Mapping) else (f"the run of {source.name!r}", _states(source, time))
    if time is not None and isinstance(source, Mapping):
        raise ValueError(f"the start is given by name and has no times, so it cannot be taken at {time:g} s; leave the time out")
    names = ("ground", *mechanism.bodies)
    unknown = [name for name in states if name not in mechanism.bodies]
    if unknown or not states:
        raise ValueError(f"{said} has the bodies {', '.join(states) or 'none'}; {mechanism.name!r} has {', '.join(mechanism.bodies)}")
    position, velocity = first_guess(mechanism), np.zeros((len(names), 3))
    for name, state in states.items():
        row = names.index(name)
        position[row], velocity[row] = centred(mechanism, name, *_two(name, state))
    return Given(position, velocity, frozenset(states))


def _two(name: str, state: Any) -> tuple[Array, Array]:
    """Position and velocity of a state, each (3,)."""
    try:
        numbers = np.array(state, dtype=float)
    except (TypeError, ValueError):
        numbers = np.full(1, np.nan)
    if numbers.shape not in ((3,), (2, 3)) or not np.isfinite(numbers).all():
        raise ValueError(f"start of {name!r} must be (x, y, angle), or that and its velocity, in m, rad and s; not {state!r}")
    return (numbers, np.zeros(3)) if numbers.ndim == 1 else (numbers[0], numbers[1])


def _states(result: View, time: float | None) -> dict[str, tuple[Array, Array]]:
    """(x, y, angle) of each body's frame and its velocity at the output nearest ``time``."""
    times = result.time
    span = 0.5 * (times[-1] - times[0]) / max(len(times) - 1, 1)
    if time is not None and not times[0] - span <= time <= times[-1] + span:
        raise ValueError(f"the run of {result.name!r} lasts from {times[0]:g} to {times[-1]:g} s; there is no state at {time:g} s")
    k = len(times) - 1 if time is None else int(np.argmin(np.abs(times - time)))
    moved, speeds = body_motion(result.record), body_velocity(result.record)
    found = {}
    for row, (name, body) in enumerate(result.record.assembly.bodies.items()):
        x, y, angle, w = (float(moved[key][k, row]) for key in ("x", "y", "angle", "angular_velocity"))
        s, c = sincos(angle)
        r = np.array([c * body.center[0] - s * body.center[1], s * body.center[0] + c * body.center[1]])
        u, v = (float(value) for value in speeds[k, row])
        found[name] = np.array([x - r[0], y - r[1], angle]), np.array([u + w * r[1], v - w * r[0], w])
    return found
