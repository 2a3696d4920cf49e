"""A machine as a whole over its turns: torque and power of its drivers, its efficiency."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Record
from .energy import LOST, ledger
from .losses import span
from .motion import times

IDLE = 1e-3  # of what is given off and lost together: a machine that gives off less does no work
STILL = 1e-6  # of the torque's range: a mean below it is none


def measures_of_drivers(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``<driven body>.torque.mean`` (N m), work over angle; ``.torque.ripple`` (1), highest less lowest at the outputs over the size of the mean;
    ``.power.mean`` (W). The work is that of every step.
    """
    found: dict[str, float] = {}
    if not record.keeps("driven_work") or not record.keeps("particle_theta"):
        return found
    first, last = span(window)
    half, time = 0.5 * record.assembly.choice.step, times(record)
    for name, body in record.assembly.bodies.items():
        if body.driven is None or last == first:
            continue
        p, k = record.assembly.topology.driven[body.driven], body.driven
        work = record.block("driven_work")[:, k] - half * record.block("driven_power")[:, k]
        torque, angle = record.block("driven_torque")[window, k], record.block("particle_theta")[:, p]
        found[f"{name}.power.mean"] = float((work[last] - work[first]) / (time[last] - time[first]))
        if abs(angle[last] - angle[first]) > 1e-9:
            mean = float((work[last] - work[first]) / (angle[last] - angle[first]))
            found[f"{name}.torque.mean"] = mean
            if abs(mean) > STILL * (reach := float(torque.max() - torque.min())):
                found[f"{name}.torque.ripple"] = reach / abs(mean)
    return found


def measures_of_efficiency(record: Record, window: NDArray[np.bool_]) -> dict[str, float]:
    """``efficiency`` (1) over a full turn: work given off over the same and all losses; nothing for a machine that gives off none.

    Drivers and loads (weight with them) each put in what they do in all over the window, or take it: a press is driven and its load takes,
    an engine's gas drives and its driver takes. In a motion that repeats, given off + lost = put in.
    """
    turn, (first, last) = record.assembly.choice.turn, span(window)
    time = times(record)
    if turn is None or not record.keeps("driven_work") or time[last] - time[first] < (1.0 - 1e-9) * turn:
        return {}
    terms = ledger(record).terms
    done = {name: float(values[last] - values[first]) for name, values in terms.items()}
    given, lost = sum(max(-done[name], 0.0) for name in ("driver", "external")), sum(done[name] for name in LOST)
    if not given > IDLE * (given + lost) or lost < 0.0:
        return {}
    return {"efficiency": given / (given + lost)}
