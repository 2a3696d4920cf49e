"""What follows from a whole mechanism: functions of its drivers over time, its crank, the carriers of its
gears.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from .drivers import Driver
from .geometry.polynomials import Polynomials, moved, raised
from .joints import Gear

if TYPE_CHECKING:
    from .mechanism import Mechanism


def motion_function(driver: Driver, offset: float = 0.0, clock: float = 0.0) -> Polynomials:
    """What a driver prescribes (rad or m) over the time of a run that begins at ``clock`` (s): what it adds
    from there on to ``offset``.

    TypeError for a driver that prescribes no motion.
    """
    if clock == 0.0:
        return driver.motion(offset)
    function = driver.motion(0.0)
    return raised(moved(function, -clock), offset - function(clock)[0])


def timed(function: Polynomials, clock: float) -> Polynomials:
    """A function of the clock over the time of a run that begins at ``clock`` (s)."""
    return moved(function, -clock) if clock else function


def turning_speed(driver: Driver) -> float:
    """Speed (rad/s) at which a driver turns a body round and round; 0 for those that move it to and fro, or
    along a line.
    """
    return driver.largest_speed if driver.revolves and not driver.slider and not driver.point else 0.0


def turn_of(mechanism: Mechanism) -> float | None:
    """Period (s) of a turn of the fastest driven body, or None."""
    speed = max((turning_speed(driver) for driver in mechanism.drivers.values()), default=0.0)
    return 2.0 * math.pi / speed if speed > 0.0 else None


def crank_of(mechanism: Mechanism, named: str = "") -> str:
    """The body on whose angle a load depends: the one that is ``named``, else the fastest that a driver
    turns. ValueError where there is none.
    """
    speeds = {
        (driver.body or name): turning_speed(driver)
        for name, driver in mechanism.drivers.items()
        if driver.moves
    }
    fastest = max(speeds, key=speeds.__getitem__, default="")
    if not named and not speeds.get(fastest):
        raise ValueError(
            "a load goes by the angle of a crank, and no driver turns a body; name the body, with crank"
        )
    return named or fastest


Place = tuple[str, str]


def carrier_of(mechanism: Mechanism, gear: Gear) -> str:
    """The body on which both wheels of a gear turn, ``"ground"`` where they do so on the ground.

    A body carries a wheel that is pinned to it, and one that turns on the ground about the very point about
    which the carrier does: the sun of a planetary train, or its ring. Nothing carries a wheel that it is.
    """
    if gear.carrier is not None:
        return gear.carrier
    pins = list(_pins(mechanism))
    candidates = [_carriers(pins, wheel) for wheel in (gear.first, gear.second)]
    carriers = [
        body
        for body in candidates[0]
        if body in candidates[1] and body not in (gear.first, gear.second, "ground")
    ]
    return carriers[0] if carriers and not all("ground" in one for one in candidates) else "ground"


def _pins(mechanism: Mechanism) -> Iterator[tuple[Place, Place]]:
    """The two sides of each revolute, with play or without; points of the ground by where they are."""
    for joint in mechanism.joints.values():
        if joint.revolves:
            one, two = (
                ("ground", f"{mechanism.points[pin]}") if body == "ground" else (body, pin)
                for body, pin in joint.sides
            )
            yield one, two


def _carriers(pins: list[tuple[Place, Place]], wheel: str) -> list[str]:
    """Bodies that carry a wheel."""
    own = [other for side, other in _both(pins) if side[0] == wheel]
    bodies = [body for body, _ in own]
    axes = [place for place in own if place[0] == "ground"]
    if wheel == "ground":  # a ring that stands: whatever turns on the ground may carry its planets
        return [body for (here, _), (body, _) in _both(pins) if here == "ground"]
    return bodies + [side[0] for side, other in _both(pins) if other in axes and side[0] != wheel]


def _both(pins: list[tuple[Place, Place]]) -> Iterator[tuple[Place, Place]]:
    """Each pin from either side."""
    for one, other in pins:
        yield one, other
        yield other, one
