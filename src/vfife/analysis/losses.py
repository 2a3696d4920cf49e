"""What each joint with play turns into heat: energy and mean power of friction and of impacts."""

from __future__ import annotations

import dataclasses

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


def of_window(record: Record, window: NDArray[np.bool_]) -> tuple[Record, slice]:
    """The outputs of a window with the one before it, as a record of their own, and which of them are the window's: what a measure of a turn
    needs is then as long as that turn, however long the run.
    """
    inside = np.flatnonzero(window)
    first, last = max(int(inside[0]) - 1, 0), int(inside[-1]) + 1
    part = dataclasses.replace(record, steps=record.steps[first:last], source=record.rows[first:last], companions=None)
    return part, slice(int(inside[0]) - first, None)


def per_joint(record: Record, values: Array) -> dict[str, Array]:
    """Sums over the contacts of each joint, ``values`` having them along its last axis; a block in a guide has four."""
    found: dict[str, Array] = {}
    for k, name in enumerate(record.assembly.contact_joints):
        found[name] = found.get(name, 0.0) + values[..., k]
    return found


def losses(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<joint>.friction_energy.total``, ``.impact_energy.total`` (J) over the window, ``.friction_power.mean``, ``.impact_power.mean`` (W)."""
    found: dict[str, float] = {}
    if not record.assembly.contacts or not record.keeps("contact_friction_work"):
        return found
    part, _ = of_window(record, window)
    length = float(times(part)[-1] - times(part)[0])
    for kind in KINDS:
        work = lost(part, kind)
        for name, energy in per_joint(record, work[-1] - work[0]).items():
            found[f"{name}.{kind}_energy.total"] = float(energy)
            if length > 0.0:
                found[f"{name}.{kind}_power.mean"] = float(energy) / length
    return found
