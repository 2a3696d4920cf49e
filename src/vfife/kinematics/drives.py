"""The mechanism as rigid bodies with ideal joints, and its drivers as prescribed motions at one time."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError, VfifeError
from ..kernels.constraint import relative_turn
from ..model.bodies import PointMass
from ..model.drivers import AngleTable, Driver
from ..model.functions import carrier_of, motion_function
from ..model.joints import Contact, Gear, Joint
from ..model.lumping import rigid_properties
from ..model.mechanism import Mechanism
from ..model.rows import AcrossGuide, AlongGuide, Guided, Turn, place_row, turn_row
from ..numerics.scalar import hypot
from .constraints import Constraint
from .forces import Datum, driven_body
from .pins import from_center
from .system import RigidSystem

Array = NDArray[np.float64]


def kinematic_drivers(mechanism: Mechanism) -> dict[str, Driver]:
    """Drivers that turn a body about its ideal pivot on the ground, by body. AssemblyError where two turn the
    same one.
    """
    result: dict[str, Driver] = {}
    for name, driver in mechanism.drivers.items():
        body = driven_body(name, driver)
        if not driver.moves or not body or driver.against != "ground":
            continue
        if body in result:
            raise AssemblyError(
                f"driver {name!r} turns body {body!r}, which another driver turns already; remove one of them"
            )
        result[body] = driver
    return result


def constraint_drivers(mechanism: Mechanism) -> dict[str, Driver]:
    """All other drivers that prescribe a motion, by name: against another body, along a slider, or of a point
    along a direction.
    """
    return {
        name: driver
        for name, driver in mechanism.drivers.items()
        if driver.moves and (driver.against != "ground" or not driven_body(name, driver))
    }


def standing(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism from which a static analysis starts: driven bodies at their angles at time 0,
    without travels, paths, loads and springs.

    A mechanism with a dynamic analysis is returned as it is.
    """
    if mechanism.settings.analysis == "dynamic":
        return mechanism
    drivers: dict[str, Driver] = {}
    for body, driver in kinematic_drivers(mechanism).items():
        angle = driver.motion(0.0)(0.0)[0]
        drivers[body] = AngleTable(body=body, times=(0.0, 1.0), values=(angle, angle))
    bodies = {
        name: dataclasses.replace(body, velocity=(0.0, 0.0, 0.0)) for name, body in mechanism.bodies.items()
    }
    return dataclasses.replace(mechanism, bodies=bodies, drivers=drivers, loads={}, springs={})


def pivot_of(mechanism: Mechanism, body: str) -> Joint:
    """Return the ideal revolute joint to the ground about which a driven body turns."""
    result = [
        joint
        for joint in mechanism.joints.values()
        if joint.revolves
        and not isinstance(joint, Contact)
        and {body, "ground"} == {side[0] for side in joint.sides}
    ]
    if len(result) != 1:
        raise AssemblyError(
            f"the driver of body {body!r} needs exactly one ideal joint between {body!r} and the ground to"
            f" turn it about; there are {len(result)}"
        )
    return result[0]


def rigid_system(
    mechanism: Mechanism,
    time: float = 0.0,
    *,
    datum: Datum | None = None,
    open_joints: frozenset[str] = frozenset(),
    seats: Mapping[str, tuple[float, float]] | None = None,
    travels: bool = True,
) -> RigidSystem:
    """Model the mechanism with every joint ideal and every link rigid, its drivers at ``time`` (s); external
    contacts are omitted.

    Welds, sliders and gears keep the relative angle of the bodies' approximate angles.

    datum: origin of driven angles and travels; angles default to the approximate ones
    open_joints: names of the joints to omit
    seats: eccentricities (m, in the frame of the bearing's body) of seated journals
    travels: False to prescribe driven angles only
    """
    datum = Datum() if datum is None else datum
    names = ("ground", *mechanism.bodies)
    properties = {name: rigid_properties(body) for name, body in mechanism.bodies.items()}
    joints: list[Constraint] = []
    for joint in mechanism.joints.values():
        if joint.name not in open_joints and joint.rows():
            joints.append(_joint(mechanism, names, joint, (seats or {}).get(joint.name, (0.0, 0.0))))
    joints += [_gear(mechanism, names, gear) for gear in mechanism.gears.values()]
    drives = [
        _drive(mechanism, names, body, driver, time, datum)
        for body, driver in kinematic_drivers(mechanism).items()
    ]
    for name, driver in constraint_drivers(mechanism).items():
        if travels or driven_body(name, driver):
            drives.append(_drive(mechanism, names, name, driver, time, datum))
    mass = np.array([1.0, *(p[0] for p in properties.values())])
    inertia = np.array([1.0, *(p[2] if p[2] > 0.0 else 1e-6 * p[0] for p in properties.values())])
    return RigidSystem(names, mass, inertia, tuple(joints), tuple(drives))


def _angle(mechanism: Mechanism, body: str) -> float:
    """Approximate angle of a body (rad)."""
    return 0.0 if body == "ground" else mechanism.bodies[body].angle


def _joint(
    mechanism: Mechanism, names: tuple[str, ...], joint: Joint, seat: tuple[float, float]
) -> Constraint:
    """Return the constraint of a joint without clearance; rotation rows keep the approximate angle between
    the bodies.
    """
    (a, pin_a), (b, pin_b) = joint.sides
    (x, y), point_b = from_center(mechanism, (a, pin_a)), from_center(mechanism, (b, pin_b))
    point_a = x + seat[0], y + seat[1]
    rows = joint.rows()
    turn = turn_row(rows)
    offset = 0.0 if turn is None else _angle(mechanism, b) - turn.ratio * _angle(mechanism, a)
    return Constraint(joint.name, names.index(a), names.index(b), rows, point_a, point_b, offset)


def _gear(mechanism: Mechanism, names: tuple[str, ...], gear: Gear) -> Constraint:
    carrier = carrier_of(mechanism, gear)
    first, second = (_angle(mechanism, body) for body in (gear.first, gear.second))
    offset = relative_turn(first, second, gear.ratio, _angle(mechanism, carrier))
    ends = names.index(gear.first), names.index(gear.second)
    return Constraint(gear.name, *ends, gear.rows(), aim=offset, body_c=names.index(carrier))


def _drive(
    mechanism: Mechanism, names: tuple[str, ...], name: str, driver: Driver, time: float, datum: Datum
) -> Constraint:
    """Return the constraint of a driver; its value counts from the datum."""
    body = driven_body(name, driver)
    if body:
        start = datum.angle.get(body, _angle(mechanism, body)) - datum.angle.get(
            driver.against, _angle(mechanism, driver.against)
        )
        steady = driver.steady_speed if time == 0.0 and mechanism.clock == 0.0 else None
        angle, rate, second = (
            motion_function(driver, start, mechanism.clock)(time) if steady is None else (start, steady, 0.0)
        )
        return Constraint(
            name,
            names.index(driver.against),
            names.index(body),
            (Turn(),),
            aim=angle,
            speed=rate,
            acceleration=second,
            driven=True,
        )
    return travel_of(
        mechanism,
        names,
        name,
        driver,
        *motion_function(driver, datum.travel.get(name, 0.0), mechanism.clock)(time),
    )


def guide_of(mechanism: Mechanism, slider: str) -> tuple[Joint, Guided] | None:
    """Return a joint whose journal moves along a straight guide, with that guide; None for any
    other joint.
    """
    joint = mechanism.joints.get(slider)
    held = None if joint is None else place_row(joint.rows())
    return (joint, held) if joint is not None and isinstance(held, AcrossGuide) else None


def travel_of(
    mechanism: Mechanism,
    names: tuple[str, ...],
    name: str,
    driver: Driver,
    value: float = 0.0,
    rate: float = 0.0,
    second: float = 0.0,
) -> Constraint:
    """Return the constraint on the place of a slider along its guide, or of a point along a direction of
    space.

    value, rate, second: prescribed travel (m), speed (m/s) and acceleration (m/s²)
    """
    if driver.slider:
        result = guide_of(mechanism, driver.slider)
        if result is None:
            sliders = ", ".join(key for key in mechanism.joints if guide_of(mechanism, key)) or "none"
            raise AssemblyError(f"driver {name!r}: {driver.slider!r} is no slider; there are {sliders}")
        joint, guide = result
        (a, pin_a), (b, pin_b) = joint.sides
        ends = (
            names.index(a),
            names.index(b),
            (AlongGuide(guide.direction),),
            from_center(mechanism, (a, pin_a)),
            from_center(mechanism, (b, pin_b)),
        )
        return Constraint(name, *ends, value, rate, second, driven=True)
    body, _, pin = driver.point.partition(".")
    if body not in mechanism.bodies:
        raise AssemblyError(
            f"driver {name!r} moves {driver.point!r}, which is no pin of a body; give it body.pin"
        )
    if hypot(*driver.direction) == 0.0:
        raise VfifeError(
            f"driver {name!r}: its direction (0, 0) has no length; give two numbers (x, y) that are not both"
            " zero"
        )
    to = (
        0,
        names.index(body),
        (AlongGuide(driver.direction),),
        (0.0, 0.0),
        from_center(mechanism, (body, pin)),
    )
    return Constraint(name, *to, value, rate, second, driven=True)


def spinless(mechanism: Mechanism) -> frozenset[str]:
    """Particles without rotary inertia whose angle nothing prescribes: they have none."""
    driven = kinematic_drivers(mechanism)
    return frozenset(
        name
        for name, body in mechanism.bodies.items()
        if isinstance(body, PointMass) and not body.inertia > 0.0 and name not in driven
    )
