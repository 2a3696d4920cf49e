"""Turns whose largest force is made by a blow.

The largest force of a joint without play follows from the motion of the ideal mechanism, and no contact law
changes it. Clearance adds blows. Where one raises the largest force of a turn far above that of the ideal
joint, the law decides the force: its stiffness how hard the blow is, its damping how fast the next one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..solvers.record import Record
from .damped_peaks import BLOCKS
from .forces import joint_force_max, joint_rows
from .repetition import Turns
from .turn_lanes import turn_lanes

# Times the largest force of the ideal joint. Models of the gallery whose forces depend on damped laws by less
# than a few per cent stay below 1.13.
RAISED = 1.25


@dataclass(frozen=True)
class RaisedPeaks:
    """Number of ``turns`` of the run and its companions, and of those whose force is ``raised``."""

    raised: int
    turns: int


def raised_peaks(
    record: Record, reference: Mapping[str, float], motion: Turns | None
) -> dict[str, RaisedPeaks]:
    """Count the turns in which the largest force of a joint with clearance exceeds :data:`RAISED` times that
    of the ideal joint, one of the measures ``reference``; joints that the ideal mechanism lacks are left out.
    """
    if record.static or not record.assembly.contacts or not all(record.keeps(block) for block in BLOCKS):
        return {}
    raised, turns = dict[str, int](), 0
    for _, part, windows in turn_lanes(record, motion):
        forces, turns = joint_force_max(part), turns + len(windows)
        for k, (name, (block, _)) in enumerate(joint_rows(part).items()):
            ideal = reference.get(f"{name}.force.max")
            if block == "contact" and ideal is not None:
                above = sum(float(forces[rows, k].max()) > RAISED * ideal for rows in windows)
                raised[name] = raised.get(name, 0) + above
    return {name: RaisedPeaks(count, turns) for name, count in raised.items()}
