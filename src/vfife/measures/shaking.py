"""Shaking force between outputs.

The force of a mechanism on the ground is known at the outputs. Between them each joint has its largest force
alone, without its direction, so that only the sum of all these bounds the force on the ground, although most
of them cancel: the main bearing of a compressor carries the gas that pushes its head away. The estimate here
adds to the force at the outputs by how much each joint on the ground exceeds in the interval what it has at
both ends. That is the truth for peaks that do not turn the force of a joint round within an interval.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import hypot
from ..solvers.record import Record
from .damped_peaks import windows
from .forces import ground_joints, ground_load, joint_force, joint_force_max, joint_rows
from .turns import Turns

Array = NDArray[np.float64]


def shaking_estimate(record: Record, motion: Turns | None) -> float:
    """Return the largest force on the ground (N) with the peaks of joints between outputs; the mean over the
    turns of the measures.
    """
    force = hypot(*ground_load(record)[:, :2].T)
    on_ground = set(ground_joints(record))
    places = [k for k, name in enumerate(joint_rows(record)) if name in on_ground]
    at_outputs = joint_force(record)[:, places]
    sizes = hypot(at_outputs[..., 0], at_outputs[..., 1])
    excess = np.maximum(joint_force_max(record)[1:, places] - _larger_end(sizes), 0.0).sum(axis=1)
    between = np.concatenate([force[:1], _larger_end(force) + excess])
    return float(np.mean([between[part].max() for part in windows(record, motion)]))


def _larger_end(values: Array) -> Array:
    """Return the larger value at the two ends of each interval between outputs."""
    return np.maximum(values[1:], values[:-1])
