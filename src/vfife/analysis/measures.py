"""The numbers a run is judged by, as one flat map of names to floats: ``<joint or body>.<quantity>.<statistic>``.

A measure is a function from a record and a window, a choice of its outputs, to numbers by name. Those of a turn are taken turn by turn, of the run
and of its companions; those of a run are counted over all of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..model.bodies import PointMass
from ..solvers.record import Record
from .deflection import largest_deflections
from .equilibria import static_measures
from .forces import joint_force_max, joint_rows, shares
from .ground import largest_shaking
from .guides import largest_strokes
from .influence import influence
from .losses import losses
from .machine import driving, efficiency
from .pressure import largest_pressures
from .sliding import largest_sliding
from .stress import largest_stresses
from .wear import worn_depths, worn_volumes

Window: TypeAlias = NDArray[np.bool_]
Measure: TypeAlias = Callable[[Record, Window], dict[str, float]]
Values: TypeAlias = NDArray[np.float64]
MOMENT = ".moment.max"
COUNTS = {
    "impacts": "onsets", "grazing": "grazing", "deep_landings": "deep", "landing_depth.max": "deepest", "approach_speed.max": "fastest"
}  # fmt: skip


def last_turn(record: Record) -> Window:
    """Outputs whose intervals make up the last full crank turn, shape (outputs,): the turn that ends with the run.

    All outputs where there is no crank, or where the run is shorter than a turn.
    """
    turn = record.assembly.choice.turn
    steps = record.steps
    if turn is None or len(steps) < 2:
        return np.ones(len(steps), dtype=bool)
    begin = steps[-1] - turn / record.assembly.choice.step
    if begin < -0.5:
        return np.ones(len(steps), dtype=bool)
    chosen = np.zeros(len(steps), dtype=bool)
    chosen[1:] = steps[:-1] > begin - 0.5
    return chosen


def measures(record: Record, reference: Mapping[str, float] | None = None, every: tuple[Measure, ...] | None = None) -> dict[str, float]:
    """Largest absolute values over the last full crank turn, from the extremes within the output intervals; counts of
    the whole run.

    ``<joint>.force.max`` (N), ``<joint>.moment.max`` (N m; of sliders, welds, gears and drivers), ``<joint>.penetration.max`` (m),
    ``<body>.angular_acceleration.max`` (rad/s^2), ``<driven body>.torque.max`` (N m); of the whole run
    ``<joint>.impacts``, ``.grazing``, ``.deep_landings`` (1), ``<joint>.landing_depth.max`` (m), ``.approach_speed.max`` (m/s),
    ``<joint>.share.free_flight``, ``.impact``, ``.continuous_contact`` (1); with the measures of a
    ``reference`` also ``<joint>.force.lip`` and ``<body>.angular_acceleration.lip`` (per cent).
    """
    if record.static:
        return static_measures(record)
    found = over_turn(record, last_turn(record), every)
    return found | compared(record, found, reference) | over_run(record)


def over_turn(record: Record, window: Window, every: tuple[Measure, ...] | None = None) -> dict[str, float]:
    """The measures of a turn, or ``every`` one of some of them."""
    return taken(OVER_TURN if every is None else every, record, window)


def over_run(record: Record) -> dict[str, float]:
    """The measures of a whole run, up to its last output."""
    return taken(OVER_RUN, record, np.ones(len(record.steps), dtype=bool))


def taken(every: tuple[Measure, ...], record: Record, window: Window) -> dict[str, float]:
    """Measures over a window; what is not finite is left out."""
    found: dict[str, float] = {}
    for measure in every:
        found |= measure(record, window)
    return {name: value for name, value in found.items() if math.isfinite(value)}


def compared(record: Record, found: Mapping[str, float], reference: Mapping[str, float] | None) -> dict[str, float]:
    """Local influence parameters of measures of a turn against those of the ideal mechanism; nothing without any."""
    if reference is None:
        return {}
    driven = [body.name for body in record.assembly.bodies.values() if body.driven is not None]
    return influence(found, reference, driven)


def largest_loads(record: Record, window: Window) -> dict[str, float]:
    """Largest force of each joint (N), and largest moment (N m) of those that have one."""
    return highest(loads(record), window)


def deepest_penetrations(record: Record, window: Window) -> dict[str, float]:
    """Deepest penetration of each contact (m)."""
    return highest(depths(record), window)


def largest_accelerations(record: Record, window: Window) -> dict[str, float]:
    """Largest angular acceleration of each body (rad/s^2), and largest torque of each driver (N m)."""
    return highest(turnings(record), window)


def highest(every: Mapping[str, Values], window: Window) -> dict[str, float]:
    """The largest within a window of what stands in the rows of a record; a moment of nothing is none."""
    found = {name: float(values[window].max()) for name, values in every.items()}
    return {name: value for name, value in found.items() if value > 0.0 or not name.endswith(MOMENT)}


def highest_of_each(record: Record) -> list[dict[str, float]]:
    """Measures of a turn's extremes of many simulations of one mechanism but for its numbers, whose last rows stand as outputs in one record."""
    every = {name: values.tolist() for rows in (loads, depths, turnings) for name, values in rows(record).items()}
    return [
        {name: own for name, values in every.items() if math.isfinite(own := values[k]) and (own > 0.0 or not name.endswith(MOMENT))}
        for k in range(len(record.steps))
    ]


def loads(record: Record) -> dict[str, Values]:
    """Largest force of each joint (N) and moment of each ideal one (N m) up to each output, shape (outputs,)."""
    forces, found = joint_force_max(record), {}
    for k, name in enumerate(joint_rows(record)):
        found[f"{name}.force.max"] = forces[:, k]
    if record.assembly.ideals:
        moments = record.block("joint_moment_max")
        found |= {f"{name}{MOMENT}": moments[:, k] for k, name in enumerate(record.assembly.ideals)}
    return found


def depths(record: Record) -> dict[str, Values]:
    """Deepest penetration of each contact (m) up to each output, shape (outputs,)."""
    if not record.assembly.contacts:
        return {}
    depth = record.block("contact_penetration_max")
    return {f"{name}.penetration.max": depth[:, k] for k, name in enumerate(record.assembly.contacts)}


def turnings(record: Record) -> dict[str, Values]:
    """Largest angular acceleration of each body (rad/s^2) and torque of each driver (N m) up to each output, shape (outputs,)."""
    found: dict[str, Values] = {}
    turning = record.block("body_alpha_max")
    for name, body in record.assembly.bodies.items():
        noun = record.assembly.mechanism.bodies[name]
        if not (isinstance(noun, PointMass) and noun.inertia == 0.0):
            found[f"{name}.angular_acceleration.max"] = turning[:, body.row]
        if body.driven is not None:
            found[f"{name}.torque.max"] = record.block("driven_torque_max")[:, body.driven]
    return found


def contact_counts(record: Record, window: Window) -> dict[str, float]:
    """How often contacts began, and how: counts of the whole run, and the shares of its time in each mode."""
    found: dict[str, float] = {}
    if not record.assembly.contacts:
        return found
    totals = {name: record.block(f"contact_{row}")[-1] for name, row in COUNTS.items() if record.keeps(f"contact_{row}")}
    parts = shares(record)
    for k, name in enumerate(record.assembly.contacts):
        found |= {f"{name}.{kind}": float(values[k]) for kind, values in totals.items()}
        found |= {f"{name}.share.{mode}": float(values[k]) for mode, values in parts.items()}
    return found


PEAKS: tuple[Measure, ...] = (largest_loads, deepest_penetrations, largest_accelerations)  # of extremes; a step is judged by them
OVER_TURN: tuple[Measure, ...] = (
    *PEAKS, driving, losses, largest_sliding, largest_pressures, largest_strokes,
    largest_shaking, largest_stresses, largest_deflections, efficiency, worn_volumes, worn_depths,
)  # fmt: skip
OVER_RUN: tuple[Measure, ...] = (contact_counts,)
