"""Properties of a whole mechanism: motion of its drivers over time, its crank, the carriers of its gears."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

from ..errors import Fault
from .drivers import Driver
from .geometry.polynomials import Polynomials, moved, raised
from .joints import Gear

if TYPE_CHECKING:
    from .bodies import Body
    from .mechanism import Mechanism

NO_CRANK = "no crank turns at constant speed"
# Turns of the longest cycle that is looked for, and how exactly a ratio of speeds must be one of whole
# numbers: a run of 1000 turns is off by less than a millionth of a turn.
LONGEST_CYCLE, SAME_RATIO = 1000, 1e-9


def motion_function(driver: Driver, offset: float = 0.0, clock: float = 0.0) -> Polynomials:
    """Return the motion of a driver (rad or m) over the time of a run that begins at ``clock`` (s).

    The motion is ``offset`` at the beginning of the run. Raises TypeError for a driver that prescribes no
    motion.
    """
    if clock == 0.0:
        return driver.motion(offset)
    function = driver.motion(0.0)
    return raised(moved(function, -clock), offset - function(clock)[0])


def timed(function: Polynomials, clock: float) -> Polynomials:
    """Return a function of clock time as a function of the time since ``clock`` (s)."""
    return moved(function, -clock) if clock else function


def turning_speed(driver: Driver) -> float:
    """Return the largest speed (rad/s) of a driver that makes a body revolve; 0 for oscillating and linear
    drivers.
    """
    return driver.largest_speed if driver.revolves and not driver.slider and not driver.point else 0.0


def turn_of(mechanism: Mechanism) -> float | None:
    """Return the period (s) of a turn of the body that is driven fastest at a constant speed, or None.

    A table of angles has no turns: it may dwell, swing, or turn at any speed.
    """
    speeds = (turning_speed(driver) for driver in mechanism.drivers.values() if driver.has_turns)
    speed = max(speeds, default=0.0)
    return 2.0 * math.pi / speed if speed > 0.0 else None


def shortest_turn(mechanism: Mechanism) -> float | None:
    """Return the period (s) of a turn at the largest speed (rad/s) of any driven body, or None."""
    speed = max((turning_speed(driver) for driver in mechanism.drivers.values()), default=0.0)
    return 2.0 * math.pi / speed if speed > 0.0 else None


def repeats_each_turn(mechanism: Mechanism) -> bool:
    """Return whether all that drives and loads a mechanism is the same in each turn of its crank.

    It is not where a motion is not a constant speed, speeds or gears differ, a torque or a load depends on
    time, or a table over angles goes on, or closes after several turns.
    """
    drivers = mechanism.drivers.values()
    speeds = [driver.steady_speed for driver in drivers if driver.moves]
    travels = any(driver.steady_speed for driver in drivers if driver.moves and driver.is_linear)
    efforts = (driver for driver in drivers if not driver.moves)
    return (
        None not in speeds
        and not travels
        and len({abs(speed) for speed in speeds if speed}) <= 1
        and all(effort.steady and effort.argument != "angle" for effort in efforts)
        and all(load.repeats_each_turn for load in mechanism.loads.values())
        and all(abs(gear.ratio) == 1.0 for gear in mechanism.gears.values())
    )


def cycle_of(mechanism: Mechanism) -> dict[str, int]:
    """Return the bodies that drivers of constant speed and gears turn, each with the number of turns of the
    fastest driver in which it makes whole turns, and the loads that repeat, with the turns that make whole
    periods; none with a ratio of speeds that has no such number.
    """
    drivers = {
        driver.body or name: driver for name, driver in mechanism.drivers.items() if turning_speed(driver)
    }
    fastest = max(map(turning_speed, drivers.values()), default=0.0)
    rates = {"ground": Fraction(0)}
    for _ in range(len(drivers) + len(mechanism.gears)):
        for body, driver in drivers.items():
            speed = driver.steady_speed
            if speed is None:
                return {}
            if driver.against in rates:
                rates[body] = rates[driver.against] + _ratio(speed / fastest)
        for gear in mechanism.gears.values():
            ratio = _ratio(gear.ratio)  # Willis: second - carrier = ratio (first - carrier)
            factors = {gear.second: Fraction(1), gear.first: -ratio, carrier_of(mechanism, gear): ratio - 1}
            unknown = [body for body, factor in factors.items() if factor and body not in rates]
            if len(unknown) == 1:
                total = sum((factor * rates.get(body, 0) for body, factor in factors.items()), Fraction(0))
                rates[unknown[0]] = -total / factors[unknown[0]]
    turns = {body: rate.denominator for body, rate in rates.items()}
    for name, load in mechanism.loads.items() if fastest else ():
        if load.repeats:
            period, over_time = load.places[-1] - load.places[0], load.argument == "time"
            rate = _ratio(2.0 * math.pi / (period * fastest if over_time else period))
            cycle = (rate if over_time else rate * rates.get(load.crank or "", 0)).denominator
            turns |= {f"load {name}": cycle} if cycle <= LONGEST_CYCLE else {}
    return turns if math.lcm(*turns.values()) <= LONGEST_CYCLE else {}


def turns_of_cycles(mechanism: Mechanism, latest: int, count: int) -> int:
    """Return how many of the ``latest`` turns of ``count`` make whole cycles of drivers and gears, at least
    one; ``latest`` if all turns are fewer.
    """
    cycle = math.lcm(*cycle_of(mechanism).values())
    return max(latest // cycle, 1) * cycle if count >= cycle else latest


def _ratio(value: float) -> Fraction:
    """Return a ratio of whole numbers, of which the lower one exceeds the longest cycle if there is none."""
    ratio = Fraction(value).limit_denominator(LONGEST_CYCLE)
    return ratio if abs(ratio - Fraction(value)) <= SAME_RATIO * abs(ratio) else Fraction(value)


def without_ideal(mechanism: Mechanism) -> str:
    """Return why no ideal mechanism can be compared turn by turn with a mechanism; "" if there is one."""
    if not any(driver.moves for driver in mechanism.drivers.values()):
        return "no driver prescribes a motion, and with ideal joints the mechanism would move in another way"
    names = [name for name, joint in mechanism.joints.items() if joint.reference is None]
    return f"an ideal mechanism has no joint for {', '.join(names)}" if names else ""


def crank_faults(
    mechanism: Mechanism, consequence: str, remedy: str = "drive a body with a speed"
) -> list[Fault]:
    """Return a fault, with its ``consequence`` and ``remedy``, for a mechanism without a crank of constant
    speed.
    """
    if turn_of(mechanism) is not None:
        return []
    return [Fault("driver", f"{NO_CRANK}, so {consequence}", remedy=remedy)]


def bodies_at_rest(mechanism: Mechanism) -> dict[str, Body]:
    """Return the bodies with start velocities of zero, by name."""
    return {
        name: dataclasses.replace(body, velocity=(0.0, 0.0, 0.0)) for name, body in mechanism.bodies.items()
    }


def crank_of(mechanism: Mechanism, named: str = "") -> str:
    """Return the body whose angle a load depends on: the one ``named``, else the fastest driven one. Raises
    ValueError if no driver turns a body.
    """
    speeds = {
        (driver.body or name): turning_speed(driver)
        for name, driver in mechanism.drivers.items()
        if driver.moves
    }
    fastest = max(speeds, key=speeds.__getitem__, default="")
    if not named and not speeds.get(fastest):
        raise ValueError(
            "the load depends on the angle of a crank, and no driver turns a body; name the body, with crank"
        )
    return named or fastest


Place = tuple[str, str]


def carrier_of(mechanism: Mechanism, gear: Gear) -> str:
    """Return the body that carries both wheels of a gear, or ``"ground"``.

    A body carries a wheel that is pinned to it, and a wheel that turns on the ground about the same point as
    the body itself: the sun of a planetary train, or its ring. A wheel is not its own carrier.
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
    return (
        carriers[0]
        if carriers and not all("ground" in carriers_of_wheel for carriers_of_wheel in candidates)
        else "ground"
    )


def _pins(mechanism: Mechanism) -> Iterator[tuple[Place, Place]]:
    """Yield the two sides of each revolute joint, with or without clearance; ground points are named by
    position, so that coincident points count as one.
    """
    for joint in mechanism.joints.values():
        if joint.revolves:
            bearing, journal = (
                ("ground", f"{mechanism.points[pin]}") if body == "ground" else (body, pin)
                for body, pin in joint.sides
            )
            yield bearing, journal


def _carriers(pins: list[tuple[Place, Place]], wheel: str) -> list[str]:
    """Return the bodies that carry a wheel."""
    partners = [opposite for side, opposite in _both(pins) if side[0] == wheel]
    bodies = [body for body, _ in partners]
    axes = [place for place in partners if place[0] == "ground"]
    if wheel == "ground":  # a ring that stands: whatever turns on the ground may carry its planets
        return [body for (fixed, _), (body, _) in _both(pins) if fixed == "ground"]
    return bodies + [side[0] for side, opposite in _both(pins) if opposite in axes and side[0] != wheel]


def _both(pins: list[tuple[Place, Place]]) -> Iterator[tuple[Place, Place]]:
    """Yield each pair in both orders."""
    for bearing, journal in pins:
        yield bearing, journal
        yield journal, bearing
