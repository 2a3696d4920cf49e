"""The numbers a run is judged by, as one flat map of names to floats."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from ..model.bodies import PointMass
from ..solvers.record import Record
from .deflection import measures_of_deflection
from .equilibria import static_measures
from .forces import joint_force_max, joint_rows, shares
from .ground import measures_of_ground
from .guides import measures_of_sliders
from .influence import influence
from .losses import measures_of_losses
from .machine import measures_of_drivers, measures_of_efficiency
from .pressure import measures_of_pressure
from .sliding import measures_of_sliding
from .stress import measures_of_stress

# Families of measures, each a function of a record and a window of its outputs.
FAMILIES: tuple[Callable[[Record, NDArray[np.bool_]], dict[str, float]], ...] = (
    measures_of_losses, measures_of_sliding, measures_of_pressure, measures_of_sliders, measures_of_ground, measures_of_drivers,
    measures_of_efficiency, measures_of_stress, measures_of_deflection,
)  # fmt: skip


def last_turn(record: Record) -> NDArray[np.bool_]:
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


def measures(record: Record, reference: Mapping[str, float] | None = None) -> dict[str, float]:
    """Largest absolute values over the last full crank turn, from the extremes within the output intervals; counts of
    the whole run.

    ``<joint>.force.max`` (N), ``<joint>.moment.max`` (N m; of sliders, welds, gears and drivers), ``<joint>.penetration.max`` (m),
    ``<joint>.impacts``, ``.grazing``, ``.deep`` (1),
    ``<joint>.deepest`` (m), ``.fastest`` (m/s), ``<joint>.share.free_flight``, ``.impact``, ``.continuous_contact`` (1),
    ``<body>.angular_acceleration.max`` (rad/s^2), ``<driven body>.torque.max`` (N m); what each of ``FAMILIES`` tells; with the measures of a
    ``reference`` also ``lip.<joint>.force`` and ``lip.<body>.angular_acceleration`` (per cent).
    """
    if record.static:
        return static_measures(record)
    window = last_turn(record)
    found: dict[str, float] = {}
    forces = joint_force_max(record)[window]
    for k, name in enumerate(joint_rows(record)):
        found[f"{name}.force.max"] = float(forces[:, k].max())
    for index, name in enumerate(record.assembly.ideals):
        if (moment := record.block("joint_moment_max")[window, index].max()) > 0.0:
            found[f"{name}.moment.max"] = float(moment)
    found |= _clearances(record, window) | _bodies(record, window)
    for family in FAMILIES:
        found |= family(record, window)
    if reference is not None:
        driven = [body.name for body in record.assembly.bodies.values() if body.driven is not None]
        found |= influence(found, reference, driven)
    return {name: value for name, value in found.items() if math.isfinite(value)}


def _clearances(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    found: dict[str, float] = {}
    if not record.assembly.contacts:
        return found
    depth = record.block("contact_penetration_max")[window]
    counts = {"impacts": "onsets", "grazing": "grazing", "deep": "deep", "deepest": "deepest", "fastest": "fastest"}
    totals = {name: record.block(f"contact_{row}")[-1] for name, row in counts.items() if record.keeps(f"contact_{row}")}
    parts = shares(record)
    for k, name in enumerate(record.assembly.contacts):
        found[f"{name}.penetration.max"] = float(depth[:, k].max())
        found |= {f"{name}.{kind}": float(values[k]) for kind, values in totals.items()}
        found |= {f"{name}.share.{mode}": float(values[k]) for mode, values in parts.items()}
    return found


def _bodies(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    found: dict[str, float] = {}
    turning = record.block("body_alpha_max")[window]
    for name, body in record.assembly.bodies.items():
        noun = record.assembly.mechanism.bodies[name]
        if not (isinstance(noun, PointMass) and noun.inertia == 0.0):
            found[f"{name}.angular_acceleration.max"] = float(turning[:, body.row].max())
        if body.driven is not None:
            found[f"{name}.torque.max"] = float(record.block("driven_torque_max")[window, body.driven].max())
    return found
