"""Whether the drivers lead a mechanism to a position that it cannot pass, and which one that is."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..kinematics.drives import constraint_drivers, kinematic_drivers
from ..kinematics.forces import driven_body
from ..kinematics.initial import Datum, datum_of, ideal_motion
from ..model.drivers import Driver
from ..model.functions import motion_function
from ..model.mechanism import Mechanism
from ..solvers.record import Record

Array = NDArray[np.float64]

HALVINGS = 30  # of the time between a position that closes and one that does not
LEAST = 50  # positions on the way


def end_of_reach(record: Record, until: float) -> str:
    """The position at which the ideal mechanism ceases to close before ``until`` (s), in words; empty where it closes all the way.

    Only where drivers alone decide the motion; elastic links are held rigid, and play is left out.
    """
    assembly = record.assembly
    if assembly.mobility is None or assembly.mobility.after_drives > 0:
        return ""
    mechanism = assembly.mechanism.ideal()
    try:
        datum = datum_of(mechanism)
        found = _last(mechanism, until, datum, max(LEAST, 2 * len(record.steps)))
    except AssemblyError:
        return ""
    if found is None:
        return ""
    time, joints = found
    where = "; ".join(_place(mechanism, name, driver, datum, time) for name, driver in _moving(mechanism).items())
    held = f", where {', '.join(joints)} cannot stay closed" if joints else ""
    return f"at {time:.6g} s {where}: a dead centre, or the end of the links' reach{held}"


def _last(mechanism: Mechanism, until: float, datum: Datum, count: int) -> tuple[float, tuple[str, ...]] | None:
    """Time of the last position that closes, and the joints that do not beyond it; None where all close."""
    guess, closed = ideal_motion(mechanism, datum=datum).position, 0.0
    open_at: list[tuple[float, Array]] = []  # times at which it did not close, and the positions it came from
    for time in np.linspace(0.0, until, count + 1)[1:].tolist():
        try:
            guess, closed = ideal_motion(mechanism, time, guess, datum=datum, named=False).position, time
        except AssemblyError:
            beyond = time
            open_at.append((time, guess))
            break
    else:
        return None
    for _ in range(HALVINGS):
        middle = 0.5 * (closed + beyond)
        try:
            guess, closed = ideal_motion(mechanism, middle, guess, datum=datum, named=False).position, middle
        except AssemblyError:
            beyond = middle
            open_at.append((middle, guess))
    return closed, next((names for names in (_open(mechanism, *one, datum) for one in reversed(open_at)) if names), ())


def _open(mechanism: Mechanism, time: float, guess: Array, datum: Datum) -> tuple[str, ...]:
    """Joints that do not close at a time (s), from a position before."""
    try:
        ideal_motion(mechanism, time, guess, datum=datum)
    except AssemblyError as error:
        return error.joints
    return ()


def _moving(mechanism: Mechanism) -> dict[str, Driver]:
    """All drivers that prescribe a motion."""
    return {**kinematic_drivers(mechanism), **constraint_drivers(mechanism)}


def _place(mechanism: Mechanism, name: str, driver: Driver, datum: Datum, time: float) -> str:
    """Where a driver has what it moves."""
    body = driven_body(name, driver)
    if body:
        start = datum.angle.get(body, mechanism.bodies[body].angle)
        start -= 0.0 if driver.against == "ground" else datum.angle.get(driver.against, mechanism.bodies[driver.against].angle)
        return f"driver {name} has {body} at {math.degrees(motion_function(driver, start, mechanism.clock)(time)[0]):.6g} degrees"
    begin = datum.travel.get(name, 0.0)
    value = motion_function(driver, begin, mechanism.clock)(time)[0]
    along = f"joint {driver.slider} at {value:.6g} m along its guide" if driver.slider else f"{driver.point} at {value:.6g} m along its direction"
    return f"driver {name} has {along}, {abs(value - begin):.6g} m from where it began"
