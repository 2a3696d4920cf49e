"""The mechanism as rigid bodies with ideal joints, and its drivers as prescribed motions at one time."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError
from ..model.bodies import PointMass
from ..model.drivers import AngleTable, Driver, Torque
from ..model.functions import motion_function
from ..model.joints import ExternalContact, IdealRevolute, Joint
from ..model.joints import Slider as SliderNoun
from ..model.joints import Weld as WeldNoun
from ..model.lumping import rigid_properties
from ..model.mechanism import Mechanism, idealised
from .constraints import AnyDrive, AnyJoint, Drive, Gear, Pin, Slide, Travel, Weld
from .forces import Datum, driven_body
from .pins import from_center
from .system import RigidSystem

Array = NDArray[np.float64]


def kinematic_drivers(mechanism: Mechanism) -> dict[str, Driver]:
    """Drivers that turn a body about its ideal pivot on the ground, by body. AssemblyError where two turn the same one."""
    found: dict[str, Driver] = {}
    for name, driver in mechanism.drivers.items():
        body = driven_body(name, driver)
        if isinstance(driver, Torque) or not body or driver.against != "ground":
            continue
        if body in found:
            raise AssemblyError(f"driver {name!r} turns body {body!r}, which another driver turns already; remove one of them")
        found[body] = driver
    return found


def constraint_drivers(mechanism: Mechanism) -> dict[str, Driver]:
    """All other drivers that prescribe a motion, by name: against another body, along a slider, or of a point along a direction."""
    return {
        name: driver
        for name, driver in mechanism.drivers.items()
        if not isinstance(driver, Torque) and (driver.against != "ground" or not driven_body(name, driver))
    }


def standing(mechanism: Mechanism) -> Mechanism:
    """What a static analysis starts from: driven bodies held at their angles at time 0, no travels or paths, no loads and no springs.

    The mechanism itself where the analysis is dynamic.
    """
    if mechanism.settings.analysis == "dynamic":
        return mechanism
    drivers: dict[str, Driver] = {}
    for body, driver in kinematic_drivers(mechanism).items():
        angle = motion_function(driver, 0.0)(0.0)[0]
        drivers[body] = AngleTable(body=body, times=(0.0, 1.0), values=(angle, angle))
    bodies = {name: dataclasses.replace(body, velocity=(0.0, 0.0, 0.0)) for name, body in mechanism.bodies.items()}
    return dataclasses.replace(mechanism, bodies=bodies, drivers=drivers, loads={}, springs={})


def pivot_of(mechanism: Mechanism, body: str) -> Joint:
    """The ideal revolute to the ground about which a driven body turns."""
    found = [
        joint for joint in mechanism.joints.values() if isinstance(joint, IdealRevolute) and {body, "ground"} == {side[0] for side in joint.sides}
    ]
    if len(found) != 1:
        raise AssemblyError(
            f"the driver of body {body!r} needs exactly one ideal joint between {body!r} and the ground to turn it about; there are {len(found)}"
        )
    return found[0]


def rigid_system(
    mechanism: Mechanism,
    time: float = 0.0,
    *,
    datum: Datum | None = None,
    open_joints: frozenset[str] = frozenset(),
    seats: Mapping[str, tuple[float, float]] | None = None,
    travels: bool = True,
) -> RigidSystem:
    """The mechanism with every joint ideal and every link rigid, its drivers at ``time`` (s); external contacts are left out.

    Weld, slider and gear keep the relative angle that the bodies' approximate angles have. ``datum``: where driven angles and travels count from
    (angles: the approximate ones unless given). ``seats``: eccentricities (m, in the bearing body's frame) of seated journals. Without
    ``travels`` only driven angles are held.
    """
    datum = Datum() if datum is None else datum
    names = ("ground", *mechanism.bodies)
    properties = {name: rigid_properties(body) for name, body in mechanism.bodies.items()}
    joints: list[AnyJoint] = []
    for joint in mechanism.joints.values():
        if joint.name not in open_joints and not isinstance(joint, ExternalContact):
            joints.append(_joint(mechanism, names, joint, (seats or {}).get(joint.name, (0.0, 0.0))))
    for gear in mechanism.gears.values():
        offset = _angle(mechanism, gear.second) - gear.ratio * _angle(mechanism, gear.first)
        joints.append(Gear(gear.name, names.index(gear.first), names.index(gear.second), gear.ratio, offset))
    drives = [_drive(mechanism, names, body, driver, time, datum) for body, driver in kinematic_drivers(mechanism).items()]
    for name, driver in constraint_drivers(mechanism).items():
        if travels or driven_body(name, driver):
            drives.append(_drive(mechanism, names, name, driver, time, datum))
    mass = np.array([1.0, *(p[0] for p in properties.values())])
    inertia = np.array([1.0, *(p[2] if p[2] > 0.0 else 1e-6 * p[0] for p in properties.values())])
    return RigidSystem(names, mass, inertia, tuple(joints), tuple(drives))


def _angle(mechanism: Mechanism, body: str) -> float:
    """Approximate angle of a body (rad)."""
    return 0.0 if body == "ground" else mechanism.bodies[body].angle


def _joint(mechanism: Mechanism, names: tuple[str, ...], joint: Joint, seat: tuple[float, float]) -> AnyJoint:
    (a, pin_a), (b, pin_b) = joint.sides
    point_a = tuple(np.add(from_center(mechanism, (a, pin_a)), seat))
    first, second = (names.index(a), point_a), (names.index(b), from_center(mechanism, (b, pin_b)))
    offset = _angle(mechanism, b) - _angle(mechanism, a)
    ideal = idealised(joint)
    if isinstance(ideal, WeldNoun):
        return Weld(joint.name, *first, *second, offset)
    if isinstance(ideal, SliderNoun):
        return Slide(joint.name, *first, ideal.direction, *second, ideal.turning, offset)
    return Pin(joint.name, *first, *second)


def _drive(mechanism: Mechanism, names: tuple[str, ...], name: str, driver: Driver, time: float, datum: Datum) -> AnyDrive:
    """A driver's constraint; what it prescribes counts from the datum."""
    body = driven_body(name, driver)
    if body:
        start = datum.angle.get(body, _angle(mechanism, body)) - datum.angle.get(driver.against, _angle(mechanism, driver.against))
        angle, rate, second = motion_function(driver, start)(time)
        return Drive(names.index(body), angle, rate, second, names.index(driver.against), name)
    value, rate, second = motion_function(driver, datum.travel.get(name, 0.0))(time)
    return travel_of(mechanism, names, name, driver, value, rate, second)


def travel_of(
    mechanism: Mechanism, names: tuple[str, ...], name: str, driver: Driver, value: float = 0.0, rate: float = 0.0, second: float = 0.0
) -> Travel:
    """The place of a slider along its guide, or of a point along a direction of space, as a constraint."""
    if driver.slider:
        joint = mechanism.joints.get(driver.slider)
        ideal = None if joint is None else idealised(joint)
        if not isinstance(ideal, SliderNoun):
            sliders = ", ".join(key for key, one in mechanism.joints.items() if isinstance(idealised(one), SliderNoun)) or "none"
            raise AssemblyError(f"driver {name!r}: {driver.slider!r} is no slider; there are {sliders}")
        (a, pin_a), (b, pin_b) = ideal.sides
        first, second_side = from_center(mechanism, (a, pin_a)), from_center(mechanism, (b, pin_b))
        return Travel(name, names.index(a), first, ideal.direction, names.index(b), second_side, value, rate, second)
    body, _, pin = driver.point.partition(".")
    if body not in mechanism.bodies:
        raise AssemblyError(f"driver {name!r} moves {driver.point!r}, which is no pin of a body; give it body.pin")
    if math.hypot(*driver.direction) == 0.0:
        raise ValueError(f"driver {name!r}: its direction (0, 0) has no length; give two numbers (x, y) that are not both zero")
    return Travel(name, 0, (0.0, 0.0), driver.direction, names.index(body), from_center(mechanism, (body, pin)), value, rate, second)


def spinless(mechanism: Mechanism) -> frozenset[str]:
    """Particles without rotary inertia whose angle nothing prescribes: they have none."""
    driven = kinematic_drivers(mechanism)
    return frozenset(
        name for name, body in mechanism.bodies.items() if isinstance(body, PointMass) and not body.inertia > 0.0 and name not in driven
    )
