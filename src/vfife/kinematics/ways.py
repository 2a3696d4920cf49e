"""What drivers ask of a mechanism from the start of a run to its end, as ways that can be followed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.drivers import Driver
from ..model.mechanism import Mechanism
from .drives import constraint_drivers, kinematic_drivers
from .initial import Motion
from .sweep import PACE, Follower, Passage, follow

Array = NDArray[np.float64]

TURN = 2.0 * math.pi
LOOKS = 720  # times at which a driver is asked for its range
PARTS = 12  # a travel is followed in so many parts at least
MOST_TURNS = 4  # a mechanism may take several to come back
BACK = 1e-6  # of the extent: it has come back
MOST_STRIDES = 400  # of several drivers together


@dataclass(frozen=True, eq=False)
class Way:
    """A way of ``length`` from the start: the drives' values [d] (rad, m) by place on it, their rates, the longest stride, and the time (s) there.

    ``turning``: whether it is a turn after which a mechanism may be where it was.
    """

    aims: Callable[[float], Array]
    rates: Callable[[float], Array]
    length: float
    pace: float
    time: Callable[[float], float]
    turning: bool = False


def ways_of(mechanism: Mechanism, motion: Motion, duration: float) -> list[Way]:
    """The ways of all drivers that prescribe a motion within ``duration`` (s), in the system of a motion, which may be a mirror image.

    One driver alone goes from its start to its largest and to its smallest value, whichever comes first first; several go through time together.
    """
    drives = motion.system.drives
    by_name: dict[str, Driver] = {**kinematic_drivers(mechanism), **constraint_drivers(mechanism)}
    drivers = [by_name[drive.name] for drive in drives]
    signs = [motion.hand if drive.turns else 1.0 for drive in drives]
    start = np.array([drive.aim for drive in drives])
    size = float(motion.system.reach[1:].max())
    paces = np.array([PACE if drive.turns else size / PARTS for drive in drives])
    if len(drives) == 1:
        return _there_and_back(drivers[0], signs[0], start[0], duration, float(paces[0]), drives[0].turns)
    functions = [driver.motion(0.0) for driver in drivers]
    offsets = start - [sign * function(0.0)[0] for sign, function in zip(signs, functions, strict=True)]

    def sampled(place: float, which: int) -> Array:
        return np.array([sign * function(place)[which] for sign, function in zip(signs, functions, strict=True)])

    times = np.linspace(0.0, duration, LOOKS)
    fastest = max(float(np.abs(function.sampled(times)[:, 1]).max()) / pace for function, pace in zip(functions, paces, strict=True))
    if fastest == 0.0:
        return []
    return [Way(lambda t: offsets + sampled(t, 0), lambda t: sampled(t, 1), min(duration, MOST_STRIDES / fastest), 1.0 / fastest, lambda t: t)]


def _there_and_back(driver: Driver, sign: float, start: float, duration: float, pace: float, turns: bool) -> list[Way]:
    """The ways of one driver: to its largest and its smallest value, in the order of time."""
    function = driver.motion(0.0)
    times = np.linspace(0.0, min(duration, function.period or duration), LOOKS)
    values = sign * function.sampled(times)[:, 0]
    values = values - values[0]
    found = []
    for towards in (1.0, -1.0):
        reach = towards * values
        length = float(reach.max())
        if length <= 0.0:
            continue

        def when(place: float, reach: Array = reach) -> float:
            after = int(np.argmax(reach >= place * (1.0 - 1e-12)))
            before = max(after - 1, 0)
            step = reach[after] - reach[before]
            return float(times[before] + (times[after] - times[before]) * (place - reach[before]) / step) if step > 0.0 else float(times[after])

        one = Way(
            lambda s, towards=towards: np.array([start + towards * s]),  # type: ignore[misc]
            lambda s, towards=towards: np.array([towards]),  # type: ignore[misc]
            length, min(pace, max(length / 4.0, 1e-3 * pace)), when, turns,
        )  # fmt: skip
        found.append((float(np.argmax(reach > 0.5 * min(length, 1.0))), one))
    return [one for _, one in sorted(found, key=lambda pair: pair[0])]


def followed(follower: Follower, start: Array, way: Way) -> Passage:
    """A way to its end, or turn by turn until the mechanism has come back to where it was."""
    if not way.turning or way.length <= TURN:
        return follow(follower, start, way.aims, way.rates, way.length, way.pace)
    here, singular, done = start, [], 0.0
    for _ in range(MOST_TURNS):
        length = min(TURN, way.length - done)
        found = follow(follower, here, lambda s, done=done: way.aims(done + s), way.rates, length, way.pace)  # type: ignore[misc]
        singular += [(done + place, stress) for place, stress in found.singular]
        done, here = done + found.reached, found.position
        off = here - start
        off[:, 2] -= TURN * np.round(off[:, 2] / TURN)
        felt = np.zeros(off.size)
        felt[3 + follower.columns] = (off.ravel() * follower.gathered.reach)[3 + follower.columns]
        if found.reached < length or np.abs(felt).max() <= BACK * follower.extent or done >= way.length * (1.0 - 1e-12):
            return Passage(done, here, found.jammed, found.stressed, tuple(singular))
    return Passage(done, here, False, None, tuple(singular))
