"""The mechanism as rigid bodies with ideal joints, and its drivers as prescribed motions at one time."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import AssemblyError, VfifeError
from ..kernels.constraint import relative_turn
from ..model.bodies import PointMass
from ..model.drivers import AngleTable, Driver
from ..model.functions import bodies_at_rest, carrier_of, motion_function
from ..model.joints import Contact, Gear, Joint
from ..model.mechanism import Mechanism
from ..model.rows import AcrossGuide, AlongGuide, Guided, Turn, place_row, turn_row
from ..numerics.scalar import hypot
from .batch import Batch
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


def motor_angles(mechanism: Mechanism, relative: bool = False) -> dict[str, float]:
    """Return the angle (rad) that the model gives each body that a torque turns against the ground and no
    driver moves; ``relative``: also of those that a torque turns against another body.
    """
    motors = [
        driven_body(name, driver)
        for name, driver in mechanism.drivers.items()
        if not driver.moves and (relative or driver.against == "ground")
    ]
    if not any(motors):
        return {}
    moved = kinematic_drivers(mechanism)
    return {body: mechanism.bodies[body].angle for body in motors if body and body not in moved}


def with_angles(system: RigidSystem, angles: Mapping[str, float]) -> RigidSystem:
    """Return a system in which these bodies are held at their angles (rad)."""
    locks = [
        Constraint(body, 0, system.names.index(body), (Turn(),), aim=angle, driven=True)
        for body, angle in angles.items()
    ]
    return RigidSystem(system.names, system.mass, system.inertia, system.joints, (*system.drives, *locks))


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
    bodies = bodies_at_rest(mechanism)
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


def rigid_system(mechanism: Mechanism, **options: Any) -> RigidSystem:
    """Model a mechanism with every joint ideal and every link rigid; options as in :func:`rigid_systems`."""
    datum = options.pop("datum", None)
    seats = options.pop("seats", None)
    [system] = rigid_systems(Batch([mechanism]), data=[datum or Datum()], seats=[seats or {}], **options)
    return system


def rigid_systems(
    batch: Batch,
    *,
    data: Sequence[Datum],
    seats: Sequence[Mapping[str, tuple[float, float]]],
    time: float = 0.0,
    open_joints: frozenset[str] = frozenset(),
    travels: bool = True,
) -> list[RigidSystem]:
    """Model mechanisms with every joint ideal and every link rigid, their drivers at ``time`` (s); external
    contacts are omitted.

    Welds, sliders and gears keep the relative angle of the bodies' approximate angles. Raises VfifeError if
    one of the mechanisms cannot be modelled.

    data: origins of driven angles and travels; angles default to the approximate ones
    seats: eccentricities (m, in the frame of the bearing's body) of seated journals
    open_joints: names of the joints to omit
    travels: False to prescribe driven angles only
    """
    first = batch.first
    names = ("ground", *first.bodies)
    joints: list[Sequence[Constraint]] = []
    for name, joint in first.joints.items():
        if joint.name not in open_joints and joint.rows():
            places = [journals.get(joint.name, NO_SEAT) for journals in seats]
            joints.append(_joints(batch, names, name, places))
    joints += [
        [_gear(mechanism, names, mechanism.gears[name]) for mechanism in batch.mechanisms]
        for name in first.gears
    ]
    driven = [(body, _key(first, driver)) for body, driver in kinematic_drivers(first).items()]
    for name, driver in constraint_drivers(first).items():
        if travels or driven_body(name, driver):
            driven.append((name, name))
    cache: dict[Any, Constraint] = {}
    drives: list[Sequence[Constraint]] = [
        [
            _drive(mechanism, names, name, mechanism.drivers[key], time, datum, cache)
            for mechanism, datum in zip(batch.mechanisms, data, strict=True)
        ]
        for name, key in driven
    ]
    count, weights = len(batch), batch.recall("weights", lambda: _weights(batch))
    return RigidSystem.batch(names, weights, _cases(joints, count), _cases(drives, count))


def _weights(batch: Batch) -> Array:
    """Return masses (kg) and inertias (kg m²) of the bodies, the ground first [2, cases, bodies + 1];
    particles get a small inertia.
    """
    weights = np.ones((2, len(batch), len(batch.first.bodies) + 1))
    for row, name in enumerate(batch.first.bodies, start=1):
        mass, inertia = batch.mass(name).T
        weights[:, :, row] = mass, np.where(inertia > 0.0, inertia, 1e-6 * mass)
    return weights


NO_SEAT = (0.0, 0.0)


def _key(mechanism: Mechanism, driver: Driver) -> str:
    """Return the name of a driver."""
    return next(name for name, item in mechanism.drivers.items() if item is driver)


def _cases(constraints: Sequence[Sequence[Constraint]], count: int) -> list[tuple[Constraint, ...]]:
    """Return the constraints of each case, from those of each joint."""
    return list(zip(*constraints, strict=True)) if constraints else [()] * count


def _angle(mechanism: Mechanism, body: str) -> float:
    """Approximate angle of a body (rad)."""
    return 0.0 if body == "ground" else mechanism.bodies[body].angle


def _joints(
    batch: Batch, names: tuple[str, ...], name: str, seats: Sequence[tuple[float, float]]
) -> Sequence[Constraint]:
    """Return the constraints of a joint without clearance; rotation rows keep the approximate angle between
    the bodies. Those without a seat are kept in the batch.
    """
    unseated = batch.recall(("constraints", name), lambda: _unseated(batch, names, name))
    if all(seat is NO_SEAT for seat in seats):
        return unseated
    return [
        constraint.moved([at + off for at, off in zip(constraint.point_a, seat, strict=True)])
        for constraint, seat in zip(unseated, seats, strict=True)
    ]


def _unseated(batch: Batch, names: tuple[str, ...], name: str) -> Sequence[Constraint]:
    """Return the constraints of a joint whose journal starts centred, one object for all cases that share its
    bodies, points and joint.
    """
    joint = batch.first.joints[name]
    (a, _), (b, _) = joint.sides
    column, turn = batch.column("joints", name), turn_row(joint.rows())
    offset = np.zeros(len(batch))
    if turn is not None:
        offset = batch.angle(b) - column.numbers(_ratio) * batch.angle(a)
    owners = [
        batch.column("points", pin) if body == "ground" else batch.column("bodies", body)
        for body, pin in joint.sides
    ]
    shared = all(owner.index is None for owner in (column, *owners))
    count = 1 if shared else len(batch)
    numbers = (values[:count].tolist() for values in (*map(batch.from_center, joint.sides), offset))
    result: list[Constraint] = []
    for k, (point_a, point_b, aim) in enumerate(zip(*numbers, strict=True)):
        rows = batch.mechanisms[k].joints[name].rows()
        if result and rows == result[0].rows:
            result.append(result[0].moved(point_a, point_b, aim))
        else:
            result.append(Constraint(joint.name, names.index(a), names.index(b), rows, point_a, point_b, aim))
    return result * len(batch) if shared else result


def _ratio(joint: Joint) -> float:
    turn = turn_row(joint.rows())
    return 1.0 if turn is None else turn.ratio


def _gear(mechanism: Mechanism, names: tuple[str, ...], gear: Gear) -> Constraint:
    carrier = carrier_of(mechanism, gear)
    first, second = (_angle(mechanism, body) for body in (gear.first, gear.second))
    offset = relative_turn(first, second, gear.ratio, _angle(mechanism, carrier))
    ends = names.index(gear.first), names.index(gear.second)
    return Constraint(gear.name, *ends, gear.rows(), aim=offset, body_c=names.index(carrier))


def _drive(
    mechanism: Mechanism,
    names: tuple[str, ...],
    name: str,
    driver: Driver,
    time: float,
    datum: Datum,
    cache: dict[Any, Constraint],
) -> Constraint:
    """Return the constraint of a driver; its value counts from the datum. Equal ones are one object, which is
    ``cache``.
    """
    body = driven_body(name, driver)
    if body:
        start = datum.angle.get(body, _angle(mechanism, body)) - datum.angle.get(
            driver.against, _angle(mechanism, driver.against)
        )
        key = id(driver), start, mechanism.clock
        if key in cache:
            return cache[key]
        steady = driver.steady_speed if time == 0.0 and mechanism.clock == 0.0 else None
        angle, rate, second = (
            motion_function(driver, start, mechanism.clock)(time) if steady is None else (start, steady, 0.0)
        )
        ends = names.index(driver.against), names.index(body)
        cache[key] = Constraint(
            name, *ends, (Turn(),), aim=angle, speed=rate, acceleration=second, driven=True
        )
        return cache[key]
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
    row = None if joint is None else place_row(joint.rows())
    return (joint, row) if joint is not None and isinstance(row, AcrossGuide) else None


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
