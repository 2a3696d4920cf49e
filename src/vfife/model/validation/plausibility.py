"""Cautions about improbable models: angles, speeds, pressures and masses in another unit, unconnected parts,
masses that contradict sections.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from statistics import median
from typing import TYPE_CHECKING, Any

from ...numerics.scalar import cos, distance, hypot, sin
from ...units import in_rpm
from ..bodies import Frame, Link, PointMass, RigidBody
from .checks import connections, neighbours_of, reached, used_pins
from .loads import FAST, FULL_TURN, suspect_tables
from .magnitudes import (
    OUT_OF_SCALE,
    extent,
    extents_of,
    suspect_constants,
    suspect_inertias,
    suspect_lengths,
    suspect_radii,
    suspect_velocities,
)

if TYPE_CHECKING:
    from ..loads import Load
    from ..mechanism import Mechanism

ANGLES = (
    "angle",
    "zero_angle",
    "amplitude",
    "phase",
    "low",
    "high",
)  # keys of angles that a turn is enough for
LEAST_OFFSET = 1e-6  # of a clearance: less is rounding of a place in the middle
HIGH_FRICTION = 2.0  # rubber on dry concrete has about 1
OTHER_BORE = 0.02  # of a bore: pistons are smaller by less
VACUUM = 0.2  # of the ambient pressure
NEAR_VACUUM = 0.01  # of the ambient pressure: 10 mbar, which no piston reaches
ATMOSPHERE = 0.9e5, 1.05e5  # Pa, absolute pressures at the suction of compressors and engines
FAINT = 1e3  # Pa, below all pressures of machines; numbers of bar and MPa are
SEVERE_WEAR = 3e-11  # 1/Pa: K = 7e-3 over 0.3 GPa; numbers of mm^3/(N m) are above
# Times what accelerates masses to the highest speed of a motor's curve within a radian and moves all loads:
# more torque reaches that speed within a degree. One in N mm taken for N m is a factor of a thousand.
STRONG = 30.0
HEAVY = 300.0  # times the median of the other masses; grams taken for kilograms: 1000
LOOSE = 0.1  # of the bearing's radius, or of the block's height: clearances of machines are below 0.05
MOST_TILT = math.radians(5.0)  # of a block in its guide; those of machines turn by 1 degree or less
USUAL_SPEED = 314.0  # rad/s, of a motor whose torque has no speeds: 3,000 rpm


def suspects(mechanism: Mechanism) -> tuple[str, ...]:
    """Return cautions about the numbers of a valid mechanism, with the likely cause."""
    return (
        *suspect_lengths(mechanism),
        *suspect_inertias(mechanism),
        *_angles(mechanism),
        *suspect_surfaces(mechanism),
        *clearances_at_rest(mechanism),
        *_tilts(mechanism),
        *_speeds(mechanism),
        *suspect_tables(mechanism),
        *_free_lengths(mechanism),
        *_positions(mechanism),
        *_frictions(mechanism),
        *_pressures(mechanism),
        *_bores(mechanism),
        *_wears(mechanism),
        *_torques(mechanism),
        *_masses(mechanism),
        *suspect_velocities(mechanism),
        *suspect_constants(mechanism),
        *_idle(mechanism),
    )


def suspect_surfaces(mechanism: Mechanism) -> tuple[str, ...]:
    """Return cautions about radii and clearances of joints, which decide every force."""
    return (*suspect_radii(mechanism), *_clearances(mechanism))


def unconnected(mechanism: Mechanism) -> tuple[str, ...]:
    """Return cautions about joints that are missing by what is connected alone."""
    return (*_loose(mechanism), *_open(mechanism))


def _free_lengths(mechanism: Mechanism) -> Iterator[str]:
    """Caution about springs whose free length is that of the start, which clearances and the place of the
    journals at the start change.
    """
    if not any(getattr(joint, "clearance", None) for joint in mechanism.contacts.values()):
        return
    for name, spring in mechanism.springs.items():
        ends = {end.partition(".")[0] for end in (spring.first, spring.second)} - {"ground"}
        fixed = mechanism.settings.analysis == "static" or not ends - set(mechanism.drivers)
        stiffness, free = getattr(spring, "stiffness", 0.0), getattr(spring, "free_length", 0.0)
        if stiffness and free is None and not fixed:
            yield (
                f"spring.{name}.free_length is left to the start, where clearances and start.journals move"
                " its ends: its preload varies with them. Give a free_length to compare clearances or starts."
            )


def _positions(mechanism: Mechanism) -> Iterator[str]:
    """Caution about positions inside a clearance, which the run ignores: it begins where start.journals puts
    the journal.
    """
    for name, joint in mechanism.clearances.items():
        ground, point = joint.bearing.split(".", 1)
        owner, pin = joint.journal.split(".", 1)
        body = mechanism.bodies.get(owner)
        if body is None or body.position is None or ground != "ground":
            continue
        pairs = [pair for pair in connections(mechanism) if owner in {end.partition(".")[0] for end in pair}]
        if len(pairs) != 1:
            continue
        x, y = body.points[pin]
        c, s = cos(body.angle), sin(body.angle)
        place = (body.position[0] + c * x - s * y, body.position[1] + s * x + c * y)
        away = distance(place, mechanism.points[point])
        if LEAST_OFFSET * joint.clearance < away <= joint.clearance:
            yield (
                f"body.{owner}.position puts its journal {1e3 * away:.4g} mm off the middle of the bearing of"
                f" {name}, but a run begins where start.journals puts it. To start there, give the run"
                f' its state: simulate(start={{"{owner}": (x, y, angle)}}) in m and rad, or --start-from.'
            )


def _idle(mechanism: Mechanism) -> Iterator[str]:
    """Caution about loads without a force and a moment, which a model may have by oversight."""
    for name, load in mechanism.loads.items():
        if not any(value for push in load.pushes(mechanism.joints) for value in push.acts):
            yield f"load.{name} has neither a force nor a moment: it changes nothing."


def _frictions(mechanism: Mechanism) -> Iterator[str]:
    """Caution about friction coefficients of no dry pair."""
    for name, joint in mechanism.contacts.items():
        coefficient = getattr(getattr(joint, "friction", None), "coefficient", None) or 0.0
        if coefficient > HIGH_FRICTION:
            yield (
                f"joint.{name}.friction.coefficient is {coefficient:.3g}, more than of any dry pair: is it in"
                " per cent?"
            )


def _pressures(mechanism: Mechanism) -> Iterator[str]:
    """Caution about pressures that do not fit the ambient one."""
    for name, load in mechanism.loads.items():
        pressed = getattr(load, "pressed", False)
        lowest, highest = _pressure_bounds(load) if pressed else (0.0, 0.0)
        largest = max(highest, -lowest)
        if 0.0 < largest < FAINT and load.ambient_pressure < FAINT:
            yield (
                f"The pressure of load.{name} never exceeds {largest:.4g} Pa, below the pressures of"
                f" machines: is it {largest:.4g} bar? Numbers without a unit are Pa."
            )
        elif not load.ambient_pressure and ATMOSPHERE[0] <= lowest <= ATMOSPHERE[1] < 0.5 * highest:
            yield (
                f"The pressure of load.{name} falls to {1e-5 * lowest:.3g} bar, like that of a cylinder open"
                " to the air, and no ambient pressure is subtracted: is it absolute? Then set ambient."
            )
        elif load.ambient_pressure > 0.0:
            yield from _suspect_pressure(name, load.ambient_pressure, lowest, highest)


def _bores(mechanism: Mechanism) -> Iterator[str]:
    """Caution about pistons that do not have the diameter of their cylinder."""
    for name, load in mechanism.loads.items():
        bore = getattr(load, "bore", None)
        slider = getattr(load, "slider", "")
        height = getattr(mechanism.joints.get(slider), "height", None)
        if bore and height and abs(height - bore) > OTHER_BORE * bore:
            yield (
                f"load.{name}.bore is {1e3 * bore:.4g} mm, and joint.{slider}.height {1e3 * height:.4g} mm: a"
                " piston has the diameter of its cylinder, so one may still be that of another machine. A"
                " crosshead has a height of its own."
            )


def _pressure_bounds(load: Load) -> tuple[float, float]:
    """Return the lowest and highest pressure (Pa) of both strokes of a load, before the ambient one is
    subtracted.
    """
    tables = [getattr(load, key, None) for key in ("pressure", "pressure_back")]
    values = [
        value for entry in tables if entry is not None
        for value in (entry if isinstance(entry, tuple) else (entry,))
    ]  # fmt: skip
    if values:
        return min(values), max(values)
    lowest, highest = load.bounds
    return lowest + load.ambient_pressure, highest + load.ambient_pressure


def _suspect_pressure(name: str, ambient: float, lowest: float, highest: float) -> Iterator[str]:
    """Caution about pressures of a load between ``lowest`` and ``highest`` (Pa) that all stay far below the
    ``ambient`` one, as of kPa taken for bar, about an ambient one in bar, and about gauge pressures, from
    which none is to be subtracted.
    """
    if ambient < FAINT:
        yield (
            f"load.{name}.ambient is {ambient:.4g} Pa, below the pressures of machines: is it {ambient:.4g}"
            " bar? Numbers without a unit are Pa."
        )
    elif 0.0 <= highest < VACUUM * ambient:
        yield (
            f"The pressure of load.{name} never exceeds {highest:.4g} Pa, far below the ambient"
            f" {ambient:.4g} Pa: check its unit, or whether it is a gauge pressure."
        )
    elif lowest < NEAR_VACUUM * ambient:
        yield (
            f"The pressure of load.{name} falls to {1e-5 * lowest:.3g} bar,"
            f" {'below' if lowest < 0.0 else 'nearly'} a vacuum, and looks like gauge pressure: its ambient,"
            f" {1e-5 * ambient:.4g} bar, is subtracted from absolute pressures. For gauge pressure set"
            ' ambient = "0 bar".'
        )


def _wears(mechanism: Mechanism) -> Iterator[str]:
    """Caution about wear coefficients of no pair of materials: numbers in mm^3/(N m)."""
    for name, joint in mechanism.contacts.items():
        for side in ("bearing", "journal"):
            coefficient = getattr(joint.wear, side, 0.0)
            if isinstance(coefficient, float) and coefficient > SEVERE_WEAR:
                yield (
                    f"joint.{name}.wear.{side} is {coefficient:.4g} 1/Pa, more than of any pair (dry mild"
                    f" steel has 6e-12): is it {coefficient:.4g} mm^3/(N m)? Numbers without a unit"
                    " are 1/Pa."
                )


def _torques(mechanism: Mechanism) -> Iterator[str]:
    """Caution about torques of motors that are far too strong for masses, weights, loads and springs: torques
    in N mm. Ratios of gears and masses of frames are not known here.
    """
    if mechanism.gears or any(isinstance(body, Frame) for body in mechanism.bodies.values()):
        return
    for name, driver in mechanism.drivers.items():
        speeds = getattr(driver, "speeds", None)
        if driver.is_linear or driver.moves:
            continue
        values = _flat(getattr(driver, "value", 0.0))
        torque, speed = max(map(abs, values)), max(map(abs, speeds or (USUAL_SPEED,)))
        usual = _usual_torque(mechanism, driver.body or name, speed)
        if usual > 0.0 and torque > STRONG * usual:
            yield (
                f"driver.{name}.torque reaches {torque:.6g} N m, {torque / usual:,.0f} times what accelerates"
                f" the masses to {speed:.4g} rad/s within a radian, with all loads: is it {torque:.6g} N mm?"
                " Numbers without a unit are N m."
            )


def _usual_torque(mechanism: Mechanism, driven: str, speed: float) -> float:
    """Return the torque (N m) on the ``driven`` body that accelerates the masses at its radius to ``speed``
    (rad/s) within a radian, against their weight, loads and springs; 0 without a radius.
    """
    size = max(extents_of(mechanism), default=0.0)
    crank = mechanism.bodies[driven]
    radius = (extent(crank) if isinstance(crank, Link | RigidBody) else 0.0) or size
    mass = inertia = 0.0
    for body in mechanism.bodies.values():
        body_mass = body.own_mass if isinstance(body, Link) else getattr(body, "mass", None)
        mass += (body_mass or 0.0) + sum(getattr(body, f"{end}_mass", 0.0) for end in ("start", "end"))
        keys = "inertia", "start_inertia", "end_inertia"
        inertia += sum(getattr(body, key, None) or 0.0 for key in keys)
    torque = (inertia + mass * radius * radius) * speed * speed + mass * hypot(*mechanism.gravity) * radius
    for load in mechanism.loads.values():
        largest = max(map(abs, load.bounds))
        for push in load.pushes(mechanism.joints):
            torque += largest * (hypot(*push.acts[:2]) * size + abs(push.acts[2]))
    for spring in mechanism.springs.values():
        stiffness = max(_flat(getattr(spring, "stiffness", 0.0)))
        damping = max(_flat(getattr(spring, "damping", 0.0)))
        if hasattr(spring, "free_length"):
            torque += stiffness * size * radius + damping * speed * radius * radius
        else:
            torque += FULL_TURN * stiffness + damping * speed
    return torque if size else 0.0


def _flat(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def _masses(mechanism: Mechanism) -> Iterator[str]:
    """Caution about a moving mass far larger than the others: grams taken for kilograms."""
    masses = {
        name: mass
        for name, body in mechanism.bodies.items()
        if (mass := getattr(body, "mass", None)) and name not in mechanism.drivers
    }
    at_pins = {
        f"{name}.masses.{pin}": mass
        for name, body in mechanism.bodies.items()
        for pin, mass in (getattr(body, "masses", None) or {}).items()
    }
    for name, mass in (masses | at_pins).items():
        lighter = [value for body, value in masses.items() if body != name]
        if lighter and mass > HEAVY * median(lighter):
            yield (
                f"body.{name}{'' if name in at_pins else '.mass'} is {mass:.4g} kg,"
                f" {mass / median(lighter):,.0f} times the others that are not driven: is it {mass:.4g} g?"
                " Numbers without a unit are kilograms."
            )


def _angles(mechanism: Mechanism) -> Iterator[str]:
    """Caution about angles of more than a turn, which may be in degrees."""
    sections: dict[str, Mapping[str, Any]] = {
        "body": mechanism.bodies, "joint": mechanism.joints, "driver": mechanism.drivers,
        "load": mechanism.loads, "spring": mechanism.springs,
    }  # fmt: skip
    values = {
        f"{section}.{name}.{key}": value
        for section, entries in sections.items()
        for name, entry in entries.items()
        for key in ANGLES if isinstance(value := getattr(entry, key, None), int | float)
        if not (key == "amplitude" and getattr(entry, "is_linear", False))
    }  # fmt: skip
    for path, value in values.items():
        if abs(value) > FULL_TURN * (1.0 + 1e-9):
            turns = f"{abs(value) / FULL_TURN:.3g} turns"
            yield (
                f"{path} is {value:.6g} rad, which is {turns}: is it {value:.6g} deg? Numbers without a unit"
                f' are radians: write "{value:.6g} deg", in Python too.'
            )


def clearances_at_rest(mechanism: Mechanism) -> Iterator[str]:
    """Caution about clearances in a static analysis, in which nothing moves from one side to the other."""
    names = [name for name, joint in mechanism.contacts.items() if getattr(joint, "clearance", None)]
    if names and mechanism.settings.analysis == "static":
        yield (
            f"{', '.join(names)}: in a static analysis a clearance changes positions and forces. Knocks, fits"
            ' and life need a moving model: analysis = "dynamic" with a driver that has a speed, as in'
            " vfife new six_bar_press. Displacements include the way on which clearance is taken up."
        )


def _clearances(mechanism: Mechanism) -> Iterator[str]:
    """Caution about clearances that are a large share of the pin or of the block."""
    for name, joint in mechanism.contacts.items():
        clearance, size = (getattr(joint, key, None) or 0.0 for key in ("clearance", joint.extent[0]))
        if size and clearance > LOOSE * size:
            yield (
                f"joint.{name}.clearance is {1e3 * clearance:.4g} mm, {100.0 * clearance / size:.3g} % of"
                f" {joint.extent[1]}: is it {clearance:.4g} mm? Numbers without a unit are metres."
            )


def _tilts(mechanism: Mechanism) -> Iterator[str]:
    """Caution about blocks that are so short that they turn far, or over, in their guides."""
    for name, joint in mechanism.contacts.items():
        if (tilt := joint.tilt) > MOST_TILT and joint.reach <= OUT_OF_SCALE * getattr(joint, "length", 0.0):
            keys = "length", "height", "clearance"
            sizes = ", ".join(f"{key} {1e3 * getattr(joint, key):.4g} mm" for key in keys)
            extent = "over" if math.isinf(tilt) else f"by {math.degrees(tilt):.3g} deg"
            yield (
                f"The block of joint.{name} ({sizes}) can turn {extent} in its guide: is it meant that short?"
                " length is along the guide."
            )


def _speeds(mechanism: Mechanism) -> Iterator[str]:
    """Caution about high speeds of drivers that look like revolutions per minute."""
    for name, driver in mechanism.drivers.items():
        speed = getattr(driver, "speed", None)
        if speed is not None and not driver.is_linear and abs(speed) >= FAST and speed == round(speed):
            yield (
                f"driver.{name}.speed is {speed:,.0f} rad/s, which is {in_rpm(speed)}: is it"
                f" {speed:.0f} rpm? Numbers without a unit are rad/s."
            )
    for name, body in mechanism.bodies.items():
        turning = abs(body.velocity[2])
        if turning >= FAST and turning == round(turning):
            yield (
                f"body.{name}.velocity turns at {turning:,.0f} rad/s, which is {in_rpm(turning)}: is it"
                f" {turning:.0f} rpm? Numbers without a unit are rad/s."
            )


def _loose(mechanism: Mechanism) -> Iterator[str]:
    """Caution about bodies without connection, and groups of bodies without connection to the ground."""
    ends = ((first.partition(".")[0], second.partition(".")[0]) for first, second in connections(mechanism))
    neighbours = neighbours_of(("ground", *mechanism.bodies), ends)
    pushed = {load.place.partition(".")[0] for load in mechanism.loads.values()} | set(mechanism.drivers)
    pushed |= {(driver.body or driver.point.partition(".")[0]) for driver in mechanism.drivers.values()}
    connected = reached(neighbours, "ground")
    multiple_bodies = len(mechanism.bodies) > 1
    for name, body in mechanism.bodies.items():
        if name in connected:
            continue
        group = reached(neighbours, name)
        connected |= group
        if any(
            any(mechanism.bodies[member].velocity) or member in pushed or isinstance(body, PointMass)
            for member in group
        ):
            continue
        listed = ", ".join(body_name for body_name in mechanism.bodies if body_name in group)
        if len(group) > 1:
            yield (
                f"Nothing connects {listed} to the ground: they are joined only to each other. Is a pivot"
                " missing?"
            )
        elif multiple_bodies or mechanism.points:
            yield (
                f"Body {name} is not connected: no joint, spring or gear holds it. Add one, or remove the"
                " body."
            )


def _open(mechanism: Mechanism) -> Iterator[str]:
    """Caution about chains with a free end, if a point of the ground or another end is free too; not about
    two bodies that are both joined to the ground, such as a pendulum and the crank that is its clock.
    """
    used = used_pins(mechanism)
    pairs = [{pin.partition(".")[0] for pin in pair} for pair in connections(mechanism)]
    grounded = {name for pair in pairs if "ground" in pair for name in pair}
    bodies = {pin.partition(".")[0] for pin in used}
    ends = [
        f"{name}.{end}"
        for name, body in mechanism.bodies.items()
        if isinstance(body, Link) and name in bodies
        for end in ("start", "end")
        if f"{name}.{end}" not in used and not getattr(body, f"{end}_mass")
    ]
    driven = any(driver.moves for driver in mechanism.drivers.values())
    points = [f"ground.{name}" for name in mechanism.points if f"ground.{name}" not in used]
    chained = any(end.partition(".")[0] not in grounded for end in ends)
    if ends and (points or (driven and chained and len(ends) > 1)):
        waiting = f", and {' and '.join(points)} by nothing used" if points else ""
        partner = points[0] if points else ends[1]
        yield (
            f"The chain is open: {' and '.join(ends)} {'is' if len(ends) == 1 else 'are'} joined to"
            f" nothing{waiting}. Is a joint between {partner} and {ends[0]} forgotten?"
        )


MASS_TOLERANCE = 0.1  # of the section's mass, by which a given one may differ without a remark


def contradictions(mechanism: Mechanism) -> tuple[str, ...]:
    """Return a sentence on each link whose given mass differs by more than a tenth from density times area
    times length.
    """
    return tuple(
        f"{name}: its mass is given as {own_mass:.4g} kg, its section and density make {section_mass:.4g} kg;"
        " the given one counts for inertia, the section for stiffness and stress. Leave the mass out, or"
        " check units and section."
        for name, own_mass, section_mass in _weighed(mechanism)
        if abs(own_mass - section_mass) > MASS_TOLERANCE * section_mass
    )


def _weighed(mechanism: Mechanism) -> Iterator[tuple[str, float, float]]:
    """Yield name, given mass (kg) and mass (kg) of the section, for all links that have both."""
    for name, body in mechanism.bodies.items():
        if isinstance(body, Link) and body.mass is not None and body.section is not None:
            yield f"Link {name}", body.mass, body.material.density * body.section.area * body.path_length
        if not isinstance(body, Frame):
            continue
        for member in body.members:
            section, material = member.section or body.section, member.material or body.material
            if member.mass is not None and section is not None:
                length = distance(body.nodes[member.start], body.nodes[member.end])
                yield (
                    f"Member {member.start}-{member.end} of {name}",
                    member.mass,
                    material.density * section.area * length,
                )
