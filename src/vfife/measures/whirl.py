"""Backward whirl of a journal: dry friction drives it around its bearing, against its own rotation.

Friction pushes a journal that turns and slides in its bearing against its rotation. If that push exceeds what
damps the motion around the bearing, the journal speeds up until it rolls. With rotation W and radius r of the
journal its centre then moves at W r, and goes round a clearance c at W r/c, many times as fast as it turns,
as far as the stiffness of the joints allows. Source: H. F. Black, Interaction of a whirling rotor with a
vibrating stator across a clearance annulus, J. Mech. Eng. Sci. 10 (1968).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..numerics.elementwise import atan2, hypot
from ..solvers.record import Record
from .forces import KINDS, eccentricity
from .motion import velocities

# A load that turns with the crank moves the contact about as fast as the journal turns; rolling is faster.
FAST = 5.0
ONE_WAY = 0.5  # mean rotation over the mean of its size: a journal that swings to and fro has less
CONTACT_SHARE = 0.9  # of the outputs at which the journal must be near the bearing's surface
SURFACE = 0.95  # of the clearance: an eccentricity near the surface
# Larger angles from one output to the next may be whole turns more or less.
RESOLVED, RESOLVED_SHARE = 0.5 * np.pi, 0.95


class Whirl(NamedTuple):
    """Mean rate (rad/s) at which a journal goes round its bearing, and at which it turns in it."""

    rate: float
    spin: float


def backward_whirls(record: Record) -> dict[str, Whirl]:
    """Return the whirl of each joint whose journal went round backward over the second half of the run.

    Joints are left out if their journals leave the surface, or move too far from one output to the next to
    follow them.
    """
    assembly, half = record.assembly, len(record.steps) // 2
    time = float(record.steps[-1] - record.steps[half]) * assembly.choice.step if half else 0.0
    if not assembly.contacts or not time > 0.0:
        return {}
    topology, away, turning = assembly.topology, eccentricity(record)[half:], velocities(record)["w"][half:]
    result: dict[str, Whirl] = {}
    for k, name in enumerate(assembly.contacts):
        if topology.contact_kind[k] != KINDS.index("bearing"):
            continue
        joint: Any = assembly.mechanism.contacts[name]
        x, y = away[:, k, 0], away[:, k, 1]
        steps = np.diff(np.unwrap(atan2(y, x)))
        bearing, journal = (
            turning[:, side[k]] for side in (topology.contact_bearing, topology.contact_journal)
        )
        rate = float(np.sum(steps)) / time - float(np.mean(bearing))
        spin, size = float(np.mean(journal - bearing)), float(np.mean(np.abs(journal - bearing)))
        near = np.mean(hypot(x, y) >= SURFACE * joint.clearance) >= CONTACT_SHARE
        followed = np.mean(np.abs(steps) < RESOLVED) >= RESOLVED_SHARE
        backward = rate * spin < 0.0 and abs(rate) > FAST * size and abs(spin) > ONE_WAY * size
        if near and followed and backward:
            result[name] = Whirl(rate, spin)
    return result
