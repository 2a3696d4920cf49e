"""Rounding of positions, which shows in accelerations if the step is very small.

An ideal joint keeps two points together: the force of a step closes the gap that they would have after it. A
coordinate x is known to u x, u = 2**-53, and a gap of that size is closed by an acceleration of u x/h^2. The
shorter the step h, the larger this noise, while the accelerations of the motion stay as they are. The angular
acceleration of a body whose pins lie an arm r from its centre has this noise over r.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..numerics.elementwise import hypot
from ..solvers.record import Record
from .motion import at_rest

UNIT = 2.0**-53  # half the distance from 1 to the next number
# Largest noise of a run, in u x/(r h^2): 0.2 to 0.5 in the four-bar, the six-bar press and Jansen's leg with
# ideal joints, and 2 to 6 in some steps of Jansen's leg with clearance.
NOISE = 8.0
# Share of the largest angular acceleration from which the noise is reported: the tolerance of the automatic
# step, which promises no more digits. Noise of 0.67 % in Jansen's leg was estimated as 0.63 %.
LARGE = 0.005
# A body turns little if its angular acceleration is less than this share of the largest of all, or of the
# square of the fastest angular velocity.
LITTLE = 1e-3


class RoundingNoise(NamedTuple):
    """Body whose angular acceleration has the largest ``share`` (1) of rounding noise, and the ``step`` (s)
    from which on the share is negligible.
    """

    body: str
    share: float
    step: float


def rounding_noise(record: Record, measures: Mapping[str, float]) -> RoundingNoise | None:
    """Return the noise that rounding adds to the ``measures`` of angular accelerations; None if it is
    negligible, no body turns on ideal joints, or nothing moves.
    """
    assembly = record.assembly
    if at_rest(record):
        return None
    topology, step = assembly.topology, assembly.choice.step
    largest = {name: measures.get(f"{name}.angular_acceleration.max", 0.0) for name in assembly.bodies}
    spin = float(np.abs(record.last("particle_w")).max(initial=0.0))
    threshold = LITTLE * max(max(largest.values(), default=0.0), spin * spin)
    joined = {*topology.joint_bearing, *topology.joint_journal}
    size = max(float(np.abs(record.last(f"particle_{axis}")).max(initial=0.0)) for axis in "xy")
    shares: dict[str, float] = {}
    for name, body in assembly.bodies.items():
        pins = np.array(list(assembly.mechanism.bodies[name].points.values())).reshape(-1, 2)
        arm = float(hypot(*(pins - pins.mean(axis=0)).T).max()) if len(pins) > 1 else 0.0
        if body.driven is None and arm > 0.0 and joined & {*body.particles} and largest[name] > threshold:
            shares[name] = NOISE * UNIT * (size + arm) / (arm * step * step) / largest[name]
    worst = max(shares, key=shares.__getitem__, default=None)
    if worst is None or shares[worst] < LARGE:
        return None
    return RoundingNoise(worst, shares[worst], step * math.sqrt(shares[worst] / LARGE))
