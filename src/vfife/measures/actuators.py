"""Force, power and work of actuators: drivers that move a slider or a point, or turn a body against another.

A driver that turns a body on its pivot prescribes the motion of that body, and its torque follows from the
balance of moments (``kernels/step.py``, ``observe_driver``). An actuator is a constraint, and its force is
the reaction along it. It often has the name of the joint that it moves, whose force is another one, so that
its measures name the actuator.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..kernels.topology import FREE
from ..solvers.record import Record
from .motion import times
from .turns import Window, of_turn, of_window

Array = NDArray[np.float64]


def actuators(record: Record) -> dict[str, bool]:
    """Return the names of the actuators in the order of their records, and whether each acts along a line."""
    topology, ideals = record.assembly.topology, record.assembly.ideals
    turns = [turn for _, turn in topology.held]
    return {ideals[k]: turns[k] == FREE for k, index in enumerate(topology.joint_actuator) if index >= 0}


def quantity_of(linear: bool) -> tuple[str, str]:
    """Return the name of what an actuator exerts, and its unit."""
    return ("actuator_force", "N") if linear else ("actuator_torque", "N m")


def largest_actuator_forces(record: Record, window: Window) -> dict[str, float]:
    """Return ``<driver>.actuator_force.max`` (N), or ``.actuator_torque.max`` (N m): largest sizes over all
    steps.
    """
    return named_forces(record, record.block("actuator_force_max")[window].max(axis=0).tolist())


def named_forces(record: Record, largest: Sequence[float]) -> dict[str, float]:
    """Return the ``largest`` forces and torques of the actuators, one for each, by the names of measures."""
    names = actuators(record).items()
    return {
        f"{name}.{quantity_of(linear)[0]}.max": value
        for (name, linear), value in zip(names, largest, strict=True)
    }


def actuator_powers(record: Record, window: Window) -> dict[str, float]:
    """Return ``<driver>.actuator_power.mean`` (W) over the window: work/time, where the work is that of every
    step.
    """
    names = actuators(record)
    if not names:
        return {}
    part, _ = of_window(record, window)
    turn = of_turn(record, window, part)
    half, time = 0.5 * part.assembly.choice.step, times(turn)
    if len(time) < 2:
        return {}
    work = turn.block("actuator_work") - half * turn.block("actuator_power")
    means = (work[-1] - work[0]) / (time[-1] - time[0])
    return {f"{name}.actuator_power.mean": float(means[k]) for k, name in enumerate(names)}
