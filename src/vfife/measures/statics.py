"""Measures of a static analysis, and their errors by mesh and residual, from analyses with other numbers of
elements.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import hypot
from ..solvers.record import Estimate, Record
from ..solvers.refinement import DOUBLE, FOURFOLD, HALF
from ..solvers.relaxation import extent
from .energy import named_forces
from .forces import joint_force, joint_moment, joint_rows
from .motion import is_free, times
from .turns import named
from .values import Measured

Array = NDArray[np.float64]
MOMENT = ".moment.max"

# Roache's grid convergence index: with two meshes three times an error of second order, which is four times
# the difference to the finer mesh; with three meshes 1.25 times the error that they show.
TWO_MESHES = 4.0
THREE_MESHES = 1.25
# Ratio of a difference to the one before it, from one halving to the next: second order, and hardly any
# convergence.
FASTEST, SLOWEST = 0.25, 0.75
# Share of the largest relative error below which none is taken to be: two meshes may agree by chance.
FLOOR = 0.1
# Values below this share of the largest of their kind are compared with that share.
LEAST_SHARE = 0.1
# A joint carries nothing if its force is below this multiple of the unbalanced force.
IDLE = 100.0
EXACT = ("load_factor", "iterations", "unbalanced.max")  # these describe the analysis and have no error
MOVED = "displacement.max"
KINDS = (MOVED, "force.max", "moment.max", "torque.max", "penetration.max")
# Rounding of the difference of two positions over their size. On cantilevers of 10 to 40 elements under 1 µN
# to 10 kN, reactions miss the load by at most a quarter of the sum (tests/solvers/test_meshes.py).
POSITION_ROUNDING = 2.0 * 2.2e-16
LOADS = (".force.max", ".moment.max", ".torque.max")
TURNING = (".moment.max", ".torque.max")


# Displacement of a load step per load over that of the step before: a limit load was passed; after a step of
# many times the load, which has a share of the path before the limit, it may have been.
SNAP, SNAP_OF_COARSE = 20.0, 3.0
TINY = 1e-12  # of a step: less before it is rounding
LARGE = 0.05  # of the largest displacement: smaller steps are no leaps


class Leap(NamedTuple):
    """A step of the displacement (m) to a load factor, and its ratio to the step before per load."""

    load_factor: float
    size: float
    by_load: float


def first_leap(record: Record) -> Leap | None:
    """Return the first step of the displacement that is much larger per load than the one before, or None.

    The load of a step is that of the load or drive that changes most beside the step before: a linear
    structure moves in proportion to them. Gravity, and drives at constant speed, have the load factor.
    """
    moved, factors = displacement(record), times(record)
    loads = record.block("function_value").T
    if any(record.assembly.mechanism.gravity) or not loads.any():
        loads = np.vstack([factors, loads])
    steps, changes = np.diff(moved), np.abs(np.diff(loads, axis=1))
    for k in range(1, len(steps)):
        growth = max(
            (change / former if former > 0.0 else math.inf)
            for former, change in changes[:, k - 1 : k + 1].tolist()
            if change > 0.0 or former > 0.0
        ) if changes[:, k - 1 : k + 1].any() else 1.0  # fmt: skip
        if not 0.0 < growth < math.inf or steps[k] <= LARGE * moved.max():
            continue
        ratio = float(steps[k]) / max(abs(float(steps[k - 1])), TINY * float(steps[k]))
        if ratio > SNAP * growth or (ratio > SNAP and ratio > SNAP_OF_COARSE * growth):
            return Leap(float(factors[k + 1]), float(steps[k]), ratio / growth)
    return None


def displacement(record: Record) -> Array:
    """Return the largest distance of a free particle from its start (m), shape (outputs,)."""
    free = is_free(record)
    x, y = (
        record.block(f"particle_{axis}") - record.assembly.state[record.assembly.layout[f"particle_{axis}"]]
        for axis in "xy"
    )
    return np.asarray(hypot(x, y)[:, free].max(axis=1, initial=0.0), dtype=float)


def equilibria(record: Record) -> list[dict[str, Any]]:
    """Return for each output: load factor, whether its equilibrium is unstable (None if not examined),
    iterations, unbalanced force over the largest, displacement (m), joint reactions (N, N, N m).
    """
    moved = displacement(record)
    force = joint_force(record)
    moment = joint_moment(record)
    factors = times(record)
    examined = [state for _, state in record.unstable]
    return [
        {
            "load_factor": float(factors[k]),
            "unstable": examined[k] if k < len(examined) else None,
            "iterations": int(record.block("iterations")[k, 0]),
            "unbalanced": float(record.block("unbalanced")[k, 0]),
            "displacement": float(moved[k]),
            "reactions": {
                name: {
                    "force_x": float(force[k, j, 0]),
                    "force_y": float(force[k, j, 1]),
                    "moment": float(moment[k, j]),
                }
                for j, name in enumerate(joint_rows(record))
            },
        }
        for k in range(len(factors))
    ]


def static_measures(record: Record) -> dict[str, float]:
    """Compute the largest absolute values over all load factors.

    ``displacement.max`` (m), ``<joint>.force.max`` (N), ``<joint>.moment.max`` (N m),
    ``<contact>.penetration.max`` (m), ``<driven body>.torque.max`` (N m), ``<driver>.actuator_force.max``
    (N) or ``.actuator_torque.max`` (N m), ``iterations`` of all factors, ``unbalanced.max`` (1), and the last
    ``load_factor`` that was reached.
    """
    values = {
        "load_factor": float(times(record)[-1]),
        MOVED: float(displacement(record).max()),
        "iterations": float(record.block("iterations").sum()),
        "unbalanced.max": float(record.block("unbalanced").max()),
    }
    force, moment = joint_force(record), np.abs(joint_moment(record))
    for k, name in enumerate(joint_rows(record)):
        values[f"{name}.force.max"] = float(hypot(force[:, k, 0], force[:, k, 1]).max())
        if moment[:, k].any():
            values[f"{name}{MOMENT}"] = float(moment[:, k].max())
    values |= named(
        record.assembly.contacts, {"penetration.max": record.block("contact_penetration").max(axis=0)}
    )
    driven = {body.name: body.driven for body in record.assembly.bodies.values() if body.driven is not None}
    torques = np.abs(record.block("driven_torque")).max(axis=0)
    values |= named(driven, {"torque.max": torques[list(driven.values())]})
    sizes = np.abs(record.block("actuator_force"))
    values |= named_forces(record, sizes.max(axis=0).tolist())
    return {name: value for name, value in values.items() if math.isfinite(value)}


# --------------------------------------------------------------------------------------------- errors by mesh


def mesh_estimate(record: Record, by_share: Mapping[float, Record]) -> Estimate | None:
    """Estimate the errors of static measures from those on other meshes; None without the one of twice the
    elements.

    ``others``: by their share of the elements, see :func:`~vfife.solvers.refinement.other_meshes`. No error
    is taken to be smaller than the unbalanced forces (:func:`unbalanced`) allow, nor than FLOOR times that of
    the value with the largest relative error.
    """
    if DOUBLE not in by_share:
        return None
    values = static_measures(record)
    on_meshes = {share: static_measures(record_of_share) for share, record_of_share in by_share.items()}
    # A moment of zero has no measure, so a moment may be missing on one of the meshes.
    names = [name for name in values if name in on_meshes[DOUBLE] or name.endswith(MOMENT)]
    errors = {
        name: error_of(
            values[name], {share: mesh_values.get(name, 0.0) for share, mesh_values in on_meshes.items()}
        )
        for name in names
    }
    # The largest displacement may lie between nodes, which two meshes may miss alike.
    errors[MOVED] = max(errors[MOVED], TWO_MESHES * abs(values[MOVED] - on_meshes[DOUBLE][MOVED]))
    size = sizes(record, values)
    floor = FLOOR * max((errors[name] / value for name, value in size.items() if name in errors), default=0.0)
    lever = extent(record.assembly, record.assembly.state)
    load = largest_load(values, lever)
    force = unbalanced(record, load, lever)
    for name, error in errors.items():
        if name.endswith(LOADS):
            left = force * (lever if name.endswith(TURNING) else 1.0)
        else:  # what a load moves or presses changes about in proportion to it
            left = abs(values[name]) * (force / load if load > 0.0 else 0.0)
        errors[name] = 0.0 if name in EXACT else max(error, floor * size.get(name, abs(values[name])), left)
    return Estimate(None, errors)


def unbalanced(record: Record, load: float, size: float) -> float:
    """Return the largest sum of unbalanced forces (N) that an equilibrium may leave: at each free particle
    the residual of the largest ``load`` (N), and the rounding of positions of ``size`` (m) times its
    stiffness.

    The sum counts, because a support carries the unbalanced forces of all particles, which the slowest motion
    leaves with one sign.
    """
    free, final = np.flatnonzero(is_free(record)), record.final
    allowed = record.assembly.mechanism.settings.residual * load * len(free)
    if final is None:
        return allowed
    inverse_masses = final[record.assembly.layout["particle_inverse_mass"]][free]
    masses = [1.0 / inverse for inverse in inverse_masses.tolist() if inverse > 0.0]
    return allowed + POSITION_ROUNDING * size * math.fsum(masses)


def error_of(value: float, by_share: Mapping[float, float]) -> float:
    """Return the error of a value from those with other shares of the elements, twice as many among them.

    Differences continue as a geometric series whose ratio is that of the two, between FASTEST and SLOWEST. A
    second difference that is small by chance is replaced by what the first one predicts.
    """
    change = abs(value - by_share[DOUBLE])
    if HALF in by_share:
        first, second, distance = abs(by_share[HALF] - value), change, 0.0
        expected = first * FASTEST / (1.0 - FASTEST)
    elif FOURFOLD in by_share:
        first = change
        second = abs(by_share[DOUBLE] - by_share[FOURFOLD])
        distance = abs(value - by_share[FOURFOLD])
        expected = first / (1.0 - FASTEST)
    else:
        return TWO_MESHES * change
    ratio = min(max(second / first if first > 0.0 else SLOWEST, FASTEST), SLOWEST)
    left = second / (1.0 - ratio) if HALF in by_share else distance + second * ratio / (1.0 - ratio)
    return THREE_MESHES * max(left, expected)


def largest_load(values: Mapping[str, float], lever: float) -> float:
    """Return the largest force (N) of the joints, with moments over a ``lever`` (m)."""
    moments = max((value for name, value in values.items() if name.endswith(TURNING)), default=0.0)
    return max(
        moments / lever, *(value for name, value in values.items() if name.endswith(".force.max")), 0.0
    )


def sizes(record: Record, values: Mapping[str, float]) -> dict[str, float]:
    """Return the size with which the error of each largest value is compared: the value, or a tenth of the
    largest of its kind. A joint without load has none.
    """
    lever = extent(record.assembly, record.assembly.state)
    idle = IDLE * record.assembly.mechanism.settings.residual * largest_load(values, lever)
    limits = {"force.max": idle, "moment.max": idle * lever, "torque.max": idle * lever}
    result = {}
    for kind in KINDS:
        of_kind = {name: value for name, value in values.items() if name == kind or name.endswith(f".{kind}")}
        floor = LEAST_SHARE * max(of_kind.values(), default=0.0)
        result.update(
            {name: max(value, floor) for name, value in of_kind.items() if value > limits.get(kind, 0.0)}
        )
    return result


def spreads(record: Record, measures: Mapping[str, Measured]) -> dict[str, float]:
    """Return the width of the range of each largest value over its size (1), by name."""
    size = sizes(record, {name: measure.value for name, measure in measures.items()})
    return {name: measures[name].width / value for name, value in size.items() if measures[name].estimated}
