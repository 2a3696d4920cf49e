"""What drivers prescribe, as functions, and how fast they turn a mechanism."""

from __future__ import annotations

import math

from .drivers import Driver
from .mechanism import Mechanism
from .polynomials import Polynomials, clamped, constant, moved, raised, spline


def motion_function(driver: Driver, offset: float = 0.0, clock: float = 0.0) -> Polynomials:
    """What a driver prescribes (rad or m) over the time of a run that begins at ``clock`` (s): what it adds from there on to ``offset``.

    TypeError for a driver that prescribes no motion.
    """
    if clock == 0.0:
        return driver.motion(offset)
    function = driver.motion(0.0)
    return raised(moved(function, -clock), offset - function(clock)[0])


def timed(function: Polynomials, clock: float) -> Polynomials:
    """A function of the clock over the time of a run that begins at ``clock`` (s)."""
    return moved(function, -clock) if clock else function


def torque_function(driver: Driver) -> Polynomials:
    """Torque (N m) or force (N): over time (s), speed (rad/s) or angle (rad), whichever the driver has; else constant."""
    return driver.effort()


def largest_speed(driver: Driver) -> float:
    """Largest speed (rad/s or m/s) that a driver asks for."""
    return driver.largest_speed


def turning_speed(driver: Driver) -> float:
    """Speed (rad/s) at which a driver turns a body round and round; 0 for those that move it to and fro, or along a line."""
    return driver.largest_speed if driver.revolves and not driver.slider and not driver.point else 0.0


def turn_of(mechanism: Mechanism) -> float | None:
    """Period (s) of a turn of the fastest driven body, or None."""
    speed = max((turning_speed(driver) for driver in mechanism.drivers.values()), default=0.0)
    return 2.0 * math.pi / speed if speed > 0.0 else None


def crank_of(mechanism: Mechanism, named: str = "") -> str:
    """The body on whose angle a load depends: the one that is ``named``, else the fastest that a driver turns. ValueError where there is none."""
    found = {(driver.body or name): turning_speed(driver) for name, driver in mechanism.drivers.items() if driver.moves}
    fastest = max(found, key=found.__getitem__, default="")
    if not named and not found.get(fastest):
        raise ValueError("a load goes by the angle of a crank, and no driver turns a body; name the body, with crank")
    return named or fastest


__all__ = [
    "Polynomials", "clamped", "constant", "crank_of", "largest_speed", "motion_function", "spline", "torque_function", "turn_of", "turning_speed",
]  # fmt: skip
