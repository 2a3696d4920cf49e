"""Constraints between rigid bodies, written short: what the nouns of joints and drivers hold, between bodies
by number.
"""

from __future__ import annotations

import numpy as np

from vfife.kinematics import solve
from vfife.kinematics.constraints import Constraint
from vfife.model.rows import AcrossGuide, AlongGuide, Coincide, OnPath, Turn


def Pin(name, body_a, point_a, body_b, point_b):
    return Constraint(name, body_a, body_b, (Coincide(),), point_a, point_b)


def Weld(name, body_a, point_a, body_b, point_b, offset=0.0):
    return Constraint(name, body_a, body_b, (Coincide(), Turn()), point_a, point_b, offset)


def Slide(name, body_a, point_a, axis_a, body_b, point_b, turning=False, offset=0.0):
    axis = tuple(float(value) for value in axis_a)
    return Constraint(
        name,
        body_a,
        body_b,
        (AcrossGuide(axis),) if turning else (AcrossGuide(axis), Turn()),
        point_a,
        point_b,
        0.0 if turning else offset,
    )


def Slot(name, body_a, point_a, path, body_b, point_b):
    return Constraint(name, body_a, body_b, (OnPath(path),), point_a, point_b)


def Gear(name, body_a, body_b, ratio=1.0, offset=0.0):
    return Constraint(name, body_a, body_b, (Turn(ratio),), aim=offset)


def Drive(body, angle, speed=0.0, acceleration=0.0, against=0, name=""):
    return Constraint(
        name, against, body, (Turn(),), aim=angle, speed=speed, acceleration=acceleration, driven=True
    )


def Travel(name, body_a, point_a, axis_a, body_b, point_b, value=0.0, speed=0.0, acceleration=0.0):
    axis = tuple(float(number) for number in axis_a)
    return Constraint(
        name, body_a, body_b, (AlongGuide(axis),), point_a, point_b, value, speed, acceleration, driven=True
    )


def velocities(system, position, wish=None):
    """The velocity [n, 3] of one system; raises its fault."""
    closed = solve.ClosedSystems.of([system], still(position)[None])
    found = solve.velocities(closed, still(np.zeros_like(position) if wish is None else wish)[None])
    if found.faults[0]:
        raise found.faults[0]
    return found.velocity[0]


def accelerations(system, position, velocity, force):
    """Acceleration [n, 3], reactions of joints [j, 3] and of drives [d] of one system; raises its fault."""
    closed = solve.ClosedSystems.of([system], still(position)[None])
    found = solve.accelerations(closed, still(velocity)[None], still(force)[None])
    if found.faults[0]:
        raise found.faults[0]
    return found.acceleration[0], found.reaction[0], found.driving[0]


def still(motion):
    """A motion [n, 3] with the ground at rest."""
    found = np.array(motion, dtype=float)
    found[0] = 0.0
    return found
