"""Dry-friction whirl: friction drives a journal around its bearing, against its rotation."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import hypot
from ..solvers.record import Record
from ..solvers.repeating import outputs_of_a_turn
from .forces import KINDS, eccentricity, relative_velocity
from .motion import velocities

# A load that turns with the crank moves the contact about as fast as the journal turns; rolling is faster.
FAST = 5.0
ONE_WAY = 0.5  # mean rotation over the mean of its size: a journal that swings to and fro has less
CONTACT_SHARE = 0.9  # of the outputs at which the journal must be near the bearing's surface
SURFACE = 0.95  # of the clearance: an eccentricity near the surface
CERTAIN = 3.0  # standard errors of a mean over the outputs, which it must exceed
FEWEST = 20  # outputs of a mean
TURNS_AROUND = 2.0  # around the bearing, which a swing between two places of contact does not make
PARTS, SUSTAINED = 4, 0.2  # of the time, in each of which the mean rate is at least this share of that of all


class Whirl(NamedTuple):
    """Mean rate (rad/s) at which a journal goes round its bearing, and at which it turns in it."""

    rate: float
    spin: float


def backward_whirls(record: Record) -> dict[str, Whirl]:
    """Return the whirl of each joint whose journal went round backward over the second half of the run.

    Joints are left out if their journals leave the surface, or do not go round whole turns: a journal that
    crosses its bearing where the load changes its side is fast for a moment and returns. The rate is the mean
    over the outputs of the relative velocity of the centres across the eccentricity. Angles of the
    eccentricity would need outputs that are closer than a turn around the bearing.

    Friction pushes a journal that turns and slides in its bearing against its rotation. If that push
    exceeds what damps the motion around the bearing, the journal speeds up until it rolls. With rotation W
    and radius r of the journal its centre then moves at W r, and goes round a clearance c at W r/c, many
    times as fast as it turns, as far as the stiffness of the joints allows. Source: H. F. Black,
    Interaction of a whirling rotor with a vibrating stator across a clearance annulus, J. Mech. Eng. Sci.
    10 (1968).
    """
    assembly, half = record.assembly, len(record.steps) // 2
    if not assembly.contacts or len(record.steps) - half < FEWEST:
        return {}
    part = dataclasses.replace(record, steps=record.steps[half:], source=record.rows[half:], companions=None)
    topology, turning = assembly.topology, velocities(part)["w"]
    away, speed = eccentricity(part), relative_velocity(part)
    # Turns that repeat are no more samples than one of them.
    samples = min(len(part.steps), outputs_of_a_turn(assembly) or len(part.steps))
    duration = float(part.steps[-1] - part.steps[0]) * assembly.choice.step
    result: dict[str, Whirl] = {}
    for k, name in enumerate(assembly.contacts):
        if topology.contact_kind[k] != KINDS.index("bearing"):
            continue
        joint: Any = assembly.mechanism.contacts[name]
        (x, y), (u, v) = away[:, k].T, speed[:, k].T
        bearing, journal = (
            turning[:, side[k]] for side in (topology.contact_bearing, topology.contact_journal)
        )
        near = hypot(x, y) >= SURFACE * joint.clearance
        rates = np.where(near, (x * v - y * u) / np.where(near, x * x + y * y, 1.0) - bearing, 0.0)
        rate, error = float(np.mean(rates)), float(np.std(rates)) / math.sqrt(samples)
        spin, size = float(np.mean(journal - bearing)), float(np.mean(np.abs(journal - bearing)))
        backward = rate * spin < 0.0 and abs(rate) > FAST * size and abs(spin) > ONE_WAY * size
        certain = abs(rate) > CERTAIN * error and _goes_round(rates, rate, duration)
        if np.mean(near) >= CONTACT_SHARE and backward and certain:
            result[name] = Whirl(rate, spin)
    return result


def _goes_round(rates: NDArray[np.float64], mean: float, duration: float) -> bool:
    """Return whether ``rates`` (rad/s) with this ``mean`` over a ``duration`` (s) make whole turns, and last:
    in each part of the time.
    """
    parts = [float(np.mean(part)) * math.copysign(1.0, mean) for part in np.array_split(rates, PARTS)]
    return abs(mean) * duration >= TURNS_AROUND * 2.0 * math.pi and min(parts) >= SUSTAINED * abs(mean)
