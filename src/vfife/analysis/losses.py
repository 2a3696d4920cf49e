"""What each joint with play turns into heat: energy and mean power of friction and of impacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Record
from .motion import times

Array = NDArray[np.float64]
KINDS = {"friction": "contact_friction", "impact": "contact_damping"}  # blocks of work and power by what is lost; impacts lose in normal damping


def lost(record: Record, kind: str) -> Array:
    """Energy (J) that each contact has lost to ``friction`` or ``impact`` since the start, shape (outputs, contacts).

    The step sums up span * power up to t_(n+1/2); at t_n that is the sum less dt/2 power. Over all contacts it is the ledger's loss.
    """
    half, name = 0.5 * record.assembly.choice.step, KINDS[kind]
    return np.asarray(record.block(f"{name}_work") - half * record.block(f"{name}_power"), dtype=float)


def mean_power(record: Record, kind: str) -> Array:
    """Power (W) lost in each contact, the mean since the output before, so that nothing between outputs is missed; (outputs, contacts)."""
    return between(lost(record, kind), times(record))


def between(work: Array, time: Array) -> Array:
    """Mean rate of what was summed up, over the interval that ends with each output; 0 at the first one."""
    found = np.zeros_like(work)
    np.divide(np.diff(work, axis=0), np.diff(time)[:, None], out=found[1:])
    return found


def span(window: NDArray[np.bool_]) -> tuple[int, int]:
    """First and last output of a window of intervals, each of which begins at the output before its own."""
    inside = np.flatnonzero(window)
    return max(int(inside[0]) - 1, 0), int(inside[-1])


def per_joint(record: Record, values: Array) -> dict[str, Array]:
    """Sums over the contacts of each joint, ``values`` having them along its last axis; a block in a guide has four."""
    found: dict[str, Array] = {}
    for k, name in enumerate(record.assembly.contact_joints):
        found[name] = found.get(name, 0.0) + values[..., k]
    return found


def measures_of_losses(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<joint>.friction.energy``, ``<joint>.impact.energy`` (J) over the window, and ``.power`` (W), the mean over it."""
    found: dict[str, float] = {}
    if not record.assembly.contacts or not record.keeps("contact_friction_work"):
        return found
    first, last = span(window)
    time = times(record)
    for kind in KINDS:
        work = lost(record, kind)
        for name, energy in per_joint(record, work[last] - work[first]).items():
            found[f"{name}.{kind}.energy"] = float(energy)
            if last > first:
                found[f"{name}.{kind}.power"] = float(energy / (time[last] - time[first]))
    return found
