"""Work, power, torque and speed of drivers that apply a torque or a force, from the outputs.

The step keeps one sum of the works of all such drivers and loads. A torque that is a function of time, speed
or angle is known at each output, so that the work of each driver is the integral of torque over angle. What
the outputs miss:

- Of integrals, the trapezoidal rule is computed with every other output too. The sum of the differences over
  all pairs of intervals, without sign, is six times the error of a smooth curve, and no less than that of a
  jump.
- Of speeds, half of the largest second difference, as of a curve whose slope jumps between two outputs.
- A largest torque is that of all places of its table between the least and the largest argument; it misses
  what the table has beyond both, as far as the argument may go there.

A table that has two places between two outputs may rise and fall there: then errors are not known (None).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple, TypedDict

import numpy as np
from numpy.typing import NDArray

from ..kernels.topology import SPEED, TIME
from ..kinematics.forces import Action, actions
from ..model.drivers import Driver
from ..solvers.record import Record
from .energy import driver_work, kinetic
from .motion import point_motion, rotation, times

Array = NDArray[np.float64]
CURVE_MARGIN = 0.01  # of the length of a curve over speed, by which a motor may leave it without a caution
# Rise of the kinetic energy over turns, as a share of the work of the drivers in them, up to which the
# machine neither speeds up nor slows down: the mean power is that of loads and losses within this share.
STEADY = 0.01
LAST_PART = 0.1  # of the outputs, in which a body that stands turns by less than
STANDS = 1e-3  # of its path in the whole run: creep of regularised friction
BLOCKS = tuple(f"particle_{name}" for name in ("x", "y", "theta", "u", "v", "w", "ax", "ay", "aw"))


class Estimate(TypedDict):
    """A value, and by how much the outputs may miss it; None where that is not known."""

    value: float
    missed: float | None


class Span(NamedTuple):
    """Outputs ``first`` to the last: the last ``turns`` of a ``body``, or without a body half of the run, in
    which the kinetic energy rises by ``rise`` (J).
    """

    first: int
    turns: int
    body: str
    rise: float


class Effort(TypedDict):
    """Figures of a driver: ``work`` (J) of the whole run; from the time ``begin`` on to ``end`` (s), which
    are the last ``turns`` of a ``body`` if there is one, mean ``power`` (W), ``rms`` and ``largest`` torque
    (N m) or force (N), and the least and largest speed ``low`` and ``high`` (rad/s or m/s) in the direction
    in which it goes on the whole; ``start`` is that speed at the first output. ``rise``: mean power (W) that
    goes into the kinetic energy of the machine; ``rest``: what it leaves of the power of the only driver,
    None beside other drivers. ``linear``: whether it acts
    along a line; ``curve``: whether it is a function of speed, as that of a motor. ``stands``: whether what
    it turns has come to rest; ``parts``: shares of a turn (1) that bodies on gears are on at the end of the
    run, of those that are less than one.
    """

    linear: bool
    curve: bool
    start: float
    begin: float
    end: float
    turns: int
    body: str
    work: Estimate
    power: Estimate
    rms: Estimate
    largest: Estimate
    low: Estimate
    high: Estimate
    rise: Estimate
    rest: Estimate | None
    stands: bool
    parts: dict[str, float]


def efforts(record: Record) -> dict[str, Effort]:
    """Return the figures of each driver that applies a torque or force, by name; none for one whose body is
    elastic, and none of a run with fewer than three outputs.
    """
    mechanism = record.assembly.mechanism
    if record.static or len(record.steps) < 3 or not all(map(record.keeps, BLOCKS)):
        return {}
    figures, span = {}, None
    for action in actions(mechanism):
        kind, name = action.owner
        if kind == "driver" and _is_rigid(record, action):
            span = working_span(record) if span is None else span
            figures[name] = _figures(record, action, mechanism.drivers[name], span)
    return figures


class Excess(NamedTuple):
    """Speed (rad/s) of a ``driver`` beyond the ``end`` of its curve, which keeps its last ``value`` there."""

    driver: str
    speed: float
    end: float
    value: float


def excess_speeds(record: Record) -> Iterator[Excess]:
    """Yield by how much the outputs of a run leave the curves of drivers over speed, of rigid bodies."""
    mechanism, bodies = record.assembly.mechanism, record.assembly.bodies
    if not all(map(record.keeps, BLOCKS)):
        return
    for action in actions(mechanism):
        kind, name = action.owner
        if kind != "driver" or action.argument[0] != SPEED or bodies[action.argument[2]].elements:
            continue
        speed = _argument(record, action)
        curve: tuple[float, ...] = getattr(mechanism.drivers[name], "speeds", ())
        margin = CURVE_MARGIN * (curve[-1] - curve[0])
        for peak, end, way in ((float(speed.min()), curve[0], -1.0), (float(speed.max()), curve[-1], 1.0)):
            if way * (peak - end) > margin:
                yield Excess(name, peak, end, action.function(end)[0])


def work_of_drivers(record: Record, figures: dict[str, Effort]) -> Estimate | None:
    """Return the work of all drivers (J) at the end of a run; None where that of one is not known.

    ``figures``: of :func:`efforts`. Without them it is part of the same sum as the work of loads, and so is
    that of a driver of a slider or point in files that were written before there were actuators.
    """
    topology, drivers = record.assembly.topology, record.assembly.mechanism.drivers
    is_former = not topology.joint_actuator and any(index >= 0 for index in topology.joint_function)
    if is_former or any(not driver.moves and name not in figures for name, driver in drivers.items()):
        return None
    works = [figure["work"] for figure in figures.values()]
    missed = [work["missed"] for work in works if work["missed"] is not None]
    return Estimate(
        value=float(driver_work(record)[-1]) + sum(work["value"] for work in works),
        missed=sum(missed) if len(missed) == len(works) else None,
    )


def working_span(record: Record) -> Span:
    """Return the last whole turns of the body that goes round slowest, because a cycle of a geared machine is
    one of its turns: those within half of the run, or one turn if it is longer; only those in which the
    machine neither speeds up nor slows down, if there are some. Half of the run where no body goes round.
    """
    half, energy, paths = len(record.steps) // 2, kinetic(record), {}
    for name, body in record.assembly.bodies.items():
        angle = record.block("particle_theta")[:, body.particles[0]]
        path = np.abs(angle[-1] - angle)
        if not body.elements and path[0] >= 2.0 * math.pi:
            paths[name] = path
    if not paths:
        return Span(half, 0, "", float(energy[-1] - energy[half]))
    slowest = min(paths, key=lambda name: float(paths[name][0]))
    largest = max(1, math.floor(float(paths[slowest][half]) / (2.0 * math.pi)))
    work = _work_of_efforts(record)

    def span(turns: int) -> Span:
        first = int(np.flatnonzero(paths[slowest] >= 2.0 * math.pi * turns)[-1])
        return Span(first, turns, slowest, float(energy[-1] - energy[first]))

    spans = map(span, range(largest, 0, -1))
    steady = (part for part in spans if abs(part.rise) <= STEADY * abs(float(work[-1] - work[part.first])))
    return next(steady, span(largest))


def _work_of_efforts(record: Record) -> Array:
    """Return the work (J) of all drivers that apply a torque or force, up to each output."""
    work = np.zeros(len(record.steps))
    for action in actions(record.assembly.mechanism):
        if action.owner[0] == "driver" and _is_rigid(record, action):
            torque = action.function.sampled(_argument(record, action))[:, 0]
            rises = np.diff(_motion(record, action)[0])
            work[1:] += (0.5 * (torque[1:] + torque[:-1]) * rises).cumsum()
    return work


def _is_rigid(record: Record, action: Action) -> bool:
    """Return whether no body that a driver acts on is elastic."""
    bodies = record.assembly.bodies
    return not any(bodies[body].elements for body, *_ in action.ends if body != "ground")


def _parts(record: Record) -> dict[str, float]:
    """Return the shares of a turn (1) that bodies on gears are on at the end, of those less than one."""
    gears = record.assembly.mechanism.gears.values()
    parts = dict[str, float]()
    for body in dict.fromkeys(name for gear in gears for name in (gear.first, gear.second)):
        angle = rotation(record, body).position
        share = abs(float(angle[-1] - angle[0])) / (2.0 * math.pi)
        parts |= {body: share} if share < 1.0 and body != "ground" else {}
    return parts


def _figures(record: Record, action: Action, driver: Driver, span: Span) -> Effort:
    """Return the figures of one driver."""
    part, (place, speed) = slice(span.first, None), _motion(record, action)
    argument, time = _argument(record, action), times(record)
    torque, length = action.function.sampled(argument)[:, 0], float(time[-1] - time[span.first])
    is_resolved = _is_resolved(action, argument)
    square = _integral(torque[part] * torque[part], time[part], is_resolved, length)
    rms, missed = math.sqrt(square["value"]), square["missed"]
    way = -1.0 if place[-1] < place[span.first] else 1.0
    bend = _bend(speed[part])
    power = _integral(torque[part], place[part], is_resolved, length)
    rise, alone = span.rise / length, len(record.assembly.mechanism.drivers) == 1
    late = place[-max(3, math.ceil(LAST_PART * len(place))) :]
    return Effort(
        linear=driver.is_linear,
        curve=action.argument[0] == SPEED,
        start=float(way * speed[0]),
        begin=float(time[span.first]),
        end=float(time[-1]),
        turns=span.turns,
        body=span.body,
        work=_integral(torque, place, is_resolved),
        power=power,
        rms=Estimate(value=rms, missed=None if missed is None else math.sqrt(square["value"] + missed) - rms),
        largest=_largest(action, driver, argument[part]),
        low=Estimate(value=float((way * speed[part]).min()), missed=bend),
        high=Estimate(value=float((way * speed[part]).max()), missed=bend),
        rise=Estimate(value=rise, missed=0.0),
        rest=Estimate(value=power["value"] - rise, missed=power["missed"]) if alone else None,
        stands=bool(np.ptp(late) <= STANDS * np.ptp(place)),
        parts=_parts(record),
    )


def _motion(record: Record, action: Action) -> tuple[Array, Array]:
    """Return the place (rad or m) and the speed whose products with the function are its work and power."""
    place, speed = np.zeros((2, len(record.steps)))
    for body, pin, (fx, fy, moment) in action.ends:
        if pin:
            motion = point_motion(record, f"{body}.{pin}")
            place += fx * motion.position[:, 0] + fy * motion.position[:, 1]
            speed += fx * motion.velocity[:, 0] + fy * motion.velocity[:, 1]
        else:
            turning = rotation(record, body)
            place += moment * turning.position
            speed += moment * turning.velocity
    return place, speed


def _argument(record: Record, action: Action) -> Array:
    """Return the argument of the function of a driver (s, rad/s or rad)."""
    kind, base, body = action.argument
    if kind == TIME:
        return times(record)
    first, second = rotation(record, base), rotation(record, body)
    return second.velocity - first.velocity if kind == SPEED else second.position - first.position


def _is_resolved(action: Action, argument: Array) -> bool:
    """Return whether no two places of the table lie between two outputs."""
    pieces = np.searchsorted(np.array(action.function.starts), argument, side="right")
    return int(np.abs(np.diff(pieces)).max()) <= 1


def _integral(values: Array, places: Array, is_resolved: bool, length: float = 1.0) -> Estimate:
    """Return the integral of values over places by the trapezoidal rule, over a ``length``."""
    rises = np.diff(places)
    single = 0.5 * (values[1:] + values[:-1]) * rises
    double = 0.5 * (values[2:] + values[:-2]) * (rises[1:] + rises[:-1])
    missed = float(np.abs(double - single[1:] - single[:-1]).sum())
    return Estimate(value=float(single.sum()) / length, missed=missed / length if is_resolved else None)


def _bend(curve: Array) -> float:
    """Return half of the largest second difference."""
    return 0.5 * float(np.abs(np.diff(curve, 2)).max(initial=0.0))


def _largest(action: Action, driver: Driver, argument: Array) -> Estimate:
    """Return the largest size of a torque or force in a range of its argument.

    Between two places of a table it is largest at one of them, but for a spline, which may overshoot.
    """
    low, high = float(argument.min()), float(argument.max())
    margin = 0.0 if action.argument[0] == TIME else _bend(argument)
    starts = np.array(action.function.starts)

    def size(low: float, high: float) -> float:
        ends = np.array([low, high, *starts[(starts > low) & (starts < high)]])
        return float(np.abs(action.function.sampled(ends)[:, 0]).max())

    largest = max(size(low, high), float(np.abs(action.function.sampled(argument)[:, 0]).max()))
    overshoots = len(starts) > 1 and getattr(driver, "interpolation", "") == "spline"
    missed = max(0.0, size(low - margin, high + margin) - largest)
    return Estimate(value=largest, missed=None if overshoots else missed)
