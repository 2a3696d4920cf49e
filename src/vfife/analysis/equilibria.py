"""The numbers of a static analysis: what each load factor came to, and the largest of them all."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import hypot
from ..solvers.record import Record
from .forces import joint_force, joint_moment, joint_rows
from .motion import is_free

Array = NDArray[np.float64]


def displacement(record: Record) -> Array:
    """Largest way of a free particle from its start (m), shape (outputs,)."""
    free = is_free(record)
    x, y = (record.block(f"particle_{axis}") - record.assembly.state[record.assembly.layout[f"particle_{axis}"]] for axis in ("x", "y"))
    return np.asarray(hypot(x, y)[:, free].max(axis=1, initial=0.0), dtype=float)


def equilibria(record: Record) -> list[dict[str, Any]]:
    """For each output: load factor, iterations, unbalanced force over the largest, displacement (m), reaction of each joint (N, N, N m)."""
    from .motion import times

    moved, force, moment = displacement(record), joint_force(record), joint_moment(record)
    found = []
    for k, factor in enumerate(times(record)):
        reactions = {
            name: {"force_x": float(force[k, j, 0]), "force_y": float(force[k, j, 1]), "moment": float(moment[k, j])}
            for j, name in enumerate(joint_rows(record))
        }
        found.append(
            {
                "load_factor": float(factor),
                "iterations": int(record.block("iterations")[k, 0]),
                "unbalanced": float(record.block("unbalanced")[k, 0]),
                "displacement": float(moved[k]),
                "reactions": reactions,
            }
        )
    return found


def static_measures(record: Record) -> dict[str, float]:
    """Largest absolute values over all load factors.

    ``displacement.max`` (m), ``<joint>.force.max`` (N), ``<joint>.moment.max`` (N m), ``<joint>.penetration.max`` (m), ``<driven
    body>.torque.max`` (N m), ``iterations`` of all factors, ``unbalanced.max`` (1), and the last ``load_factor`` that was reached.
    """
    from .motion import times

    found = {
        "load_factor": float(times(record)[-1]),
        "displacement.max": float(displacement(record).max()),
        "iterations": float(record.block("iterations").sum()),
        "unbalanced.max": float(record.block("unbalanced").max()),
    }
    force, moment = joint_force(record), np.abs(joint_moment(record))
    for k, name in enumerate(joint_rows(record)):
        found[f"{name}.force.max"] = float(hypot(force[:, k, 0], force[:, k, 1]).max())
        if moment[:, k].any():
            found[f"{name}.moment.max"] = float(moment[:, k].max())
    for k, name in enumerate(record.assembly.contacts):
        found[f"{name}.penetration.max"] = float(record.block("contact_penetration")[:, k].max())
    for body in record.assembly.bodies.values():
        if body.driven is not None:
            found[f"{body.name}.torque.max"] = float(np.abs(record.block("driven_torque")[:, body.driven]).max())
    return {name: value for name, value in found.items() if math.isfinite(value)}
