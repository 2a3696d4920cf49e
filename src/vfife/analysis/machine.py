"""A machine as a whole over its turns: torque and power of its drivers, its efficiency."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Record
from .energy import LOST, ledger
from .losses import of_window
from .motion import times

IDLE = 1e-3  # of what is given off and lost together: a machine that gives off less does no work
OPEN = 1e-5  # of the largest energy: what a turn leaves over that only goes to and fro
STILL = 1e-6  # of the torque's range: a mean below it is none


def driving(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<driven body>.torque.mean`` (N m), work over angle; ``.torque.ripple`` (1), highest less lowest at the outputs over the size of the mean;
    ``.power.mean`` (W). The work is that of every step.
    """
    found: dict[str, float] = {}
    if not record.assembly.topology.driven or not record.keeps("driven_work") or not record.keeps("particle_theta"):
        return found
    torque_kept = record.keeps("driven_torque")  # not of companions
    part, inside = of_window(record, window)
    half, time = 0.5 * part.assembly.choice.step, times(part)
    for name, body in record.assembly.bodies.items():
        if body.driven is None or len(time) < 2:
            continue
        work = part.block("driven_work")[:, body.driven] - half * part.block("driven_power")[:, body.driven]
        torque = part.block("driven_torque")[inside, body.driven] if torque_kept else np.zeros(1)
        angle = part.block("particle_theta")[:, part.assembly.topology.driven[body.driven]]
        found[f"{name}.power.mean"] = float((work[-1] - work[0]) / (time[-1] - time[0]))
        if abs(turned := float(angle[-1] - angle[0])) > 1e-9:
            mean = found[f"{name}.torque.mean"] = float(work[-1] - work[0]) / turned
            if torque_kept and abs(mean) > STILL * (reach := float(torque.max() - torque.min())):
                found[f"{name}.torque.ripple"] = reach / abs(mean)
    return found


def efficiency(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``mechanism.efficiency`` (1) over a full turn: work given off over the same and all losses; nothing for a machine that gives off none.

    Drivers and loads (weight with them) each put in what they do in all over the window, or take it: a press is driven and its load takes,
    an engine's gas drives and its driver takes. In a motion that repeats, given off + lost = put in.
    """
    turn = record.assembly.choice.turn
    if turn is None or not record.keeps("driven_work") or not record.keeps("particle_x"):
        return {}
    part, _ = of_window(record, window)
    time = times(part)
    if time[-1] - time[0] < (1.0 - 1e-9) * turn:
        return {}
    kept = ledger(part)
    done = {name: float(values[-1] - values[0]) for name, values in kept.terms.items()}
    given, lost = sum(max(-done[name], 0.0) for name in ("driver", "external")), sum(done[name] for name in LOST)
    if not given > max(IDLE * (given + lost), OPEN * kept.largest) or lost < 0.0:
        return {}
    return {"mechanism.efficiency": given / (given + lost)}
