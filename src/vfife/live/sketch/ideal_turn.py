"""The ideal motion of a mechanism as a list of positions, for drawing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...kinematics.drives import kinematic_drivers
from ...kinematics.follower import TURN, Follower, Way, follow, ways_of
from ...kinematics.full_turn import full_turns
from ...kinematics.initial import Motion
from ...model.functions import turn_of
from ...model.mechanism import Mechanism

Array = NDArray[np.float64]
STRIDES = 36  # between positions, on a way


def ideal_positions(mechanism: Mechanism, motion: Motion) -> tuple[Array, bool, str]:
    """Return positions of the centres of mass through the ideal motion, shape (k, bodies + 1, 3), whether the
    last leads to the first, and the sentence that says where the mechanism jams; "" if it does not.

    One position if drivers do not determine the motion. Positions are evenly spaced over the crank angle, or
    over the way of the driver.
    """
    start = motion.position[None]
    moving = [driver for driver in mechanism.drivers.values() if driver.moves]
    if len(moving) == 1 and (speed := moving[0].steady_speed):
        [turn] = full_turns([motion], [speed])
        if turn is not None:
            return turn.positions[:-1] * (1.0, motion.hand, motion.hand), True, ""
    follower = Follower.of(motion.system, motion.position * (1.0, motion.hand, motion.hand))
    duration = turn_of(mechanism) or mechanism.settings.duration or 0.0
    if follower is None or not moving or not duration:
        return start, False, ""
    ways = ways_of(mechanism, motion, duration)
    positions, jammed = [motion.position * (1.0, motion.hand, motion.hand)], ""
    for way in ways[:1]:
        way = replace(way, length=min(way.length, TURN)) if way.turning else way
        for _ in range(STRIDES):
            result = _stride(follower, positions[-1], way, (len(positions) - 1) / STRIDES)
            if result is None:
                jammed = _jam(mechanism, way, (len(positions) - 1) / STRIDES)
                break
            positions.append(result)
    return np.array(positions) * (1.0, motion.hand, motion.hand), False, jammed


def _stride(follower: Follower, position: Array, way: Way, share: float) -> Array | None:
    """Return the position a stride further on a way; None if the mechanism jams before."""
    begin, length = share * way.length, way.length / STRIDES
    passage = follow(
        follower, position, lambda s: way.aims(begin + s), lambda s: way.rates(begin + s), length, way.pace
    )
    return None if passage.jammed or passage.reached < length * (1.0 - 1e-9) else passage.position


def _jam(mechanism: Mechanism, way: Way, share: float) -> str:
    time = way.time(share * way.length)
    driven = ", ".join(kinematic_drivers(mechanism)) or "the driver"
    turned = (
        f" {math.degrees(share * way.length):.0f}° from the start" if way.turning else f" after {time:.3g} s"
    )
    return f"With ideal joints it jams{turned} of {driven}: change a length, or let the driver stay clear."
