"""Degrees of freedom, redundant constraints and singular positions of rigid bodies with ideal joints."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .kinematics import close
from .leastnorm import constrained, dependent_rows
from .rigidsystem import AssemblyError, RigidSystem, checked, equations, metric

Array = NDArray[np.float64]

ASIDE = 1e-2  # by how much of its reach, or rad, a mechanism is moved to see what holds nearby too


@dataclass(frozen=True)
class Mobility:
    """Degrees of freedom with the drives released (`free`) and at work, and the joints' redundant constraints, all at the instant.

    `redundant_joints` names the joints whose rows depend on those of the joints before them; `singular` those joints and drives among
    all whose rows do so here only, at a change point or a dead centre, and not beside it.
    """

    free: int
    after_drives: int
    redundant: int
    redundant_joints: tuple[str, ...]
    singular: tuple[str, ...] = ()


def mobility(system: RigidSystem, position: Array) -> Mobility:
    """Count the instantaneous freedoms and redundant constraints at a closed position [n,3] (m, m, rad).

    free = 3(n-1) - rank(G of the joints); after_drives takes the drives' rows in; redundant = rows - rank(G of the joints).
    A rank that is larger beside the position (along a free motion, drives released), or a free motion that leads nowhere, makes it singular.
    Raises ValueError on bad shapes.
    """
    position = checked(system, position, "position")
    columns = 3 * (len(system.names) - 1)
    stuck, all_stuck = _dependent(system, position)
    free, after = columns - (system.held - len(stuck)), columns - (system.starts[-1] - len(all_stuck))
    beside = _aside(system, position) if all_stuck and free else position
    still = [] if beside is None else all_stuck if beside is position else _dependent(system, beside)[1]
    singular: list[int] = []
    if len(still) < len(all_stuck):
        singular = [row for row in all_stuck if row not in still]
    return Mobility(free, after, len(stuck), _named(system, stuck), _named(system, singular))


def _dependent(system: RigidSystem, position: Array) -> tuple[list[int], list[int]]:
    """Rows that follow from those before them, of the joints alone and with the drives."""
    jacobian = equations(system, position, np.zeros_like(position)).jacobian
    rows = dependent_rows(jacobian)
    return [row for row in rows if row < system.held], rows


def _named(system: RigidSystem, rows: list[int]) -> tuple[str, ...]:
    """Joints and drives that rows belong to."""
    names = [*(joint.name for joint in system.joints), *(system.drive_name(drive) for drive in system.drives)]
    return tuple(dict.fromkeys(names[int(np.searchsorted(system.starts, row, side="right")) - 1] for row in rows))


def _aside(system: RigidSystem, position: Array) -> Array | None:
    """A closed position a little along a free motion, the drives released; None where that motion leads nowhere."""
    released = dataclasses.replace(system, drives=())
    jacobian = equations(released, position, np.zeros_like(position)).jacobian
    lengths = metric(system)[0]
    wish = np.cos(np.arange(1.0, len(lengths) + 1.0) ** 2) * np.repeat(system.reach[1:], 3)
    motion = constrained(jacobian, np.zeros(jacobian.shape[0]), np.ones_like(wish), wish)[0]
    size = max(np.abs(motion).max() / system.reach[1:].max(), np.abs((motion / lengths)[2::3]).max())
    step = np.vstack([np.zeros(3), (ASIDE / size * motion / lengths).reshape(-1, 3)])
    try:
        found = close(released, position + step).position
    except AssemblyError:
        return None
    scale = np.column_stack([np.ones_like(system.reach), np.ones_like(system.reach), system.reach])
    gone, wanted = np.linalg.norm((found - position) * scale), np.linalg.norm(step * scale)
    return found if gone > 0.1 * wanted else None
