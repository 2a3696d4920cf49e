"""Cautions about magnitudes out of scale: lengths and inertias in mm, speeds in mm/s, gravity, moduli and
densities in the units of another program.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import combinations
from statistics import median
from typing import TYPE_CHECKING, Any

from ...laws import Material
from ...numerics.scalar import distance, hypot
from ...schema import FixedList, FreeList, Measure, Names, described_fields, key_of, value_of
from ..bodies import Frame, Link, RigidBody, Section
from .checks import connections

if TYPE_CHECKING:
    from ...schema import Value
    from ..joints import Contact
    from ..mechanism import Mechanism

# A length this many times the median of the others is cautioned about; millimetres taken for metres: 1000.
OUT_OF_SCALE = 100.0
HUGE = 50.0  # m, longer than the links of machines
LONG = 5.0  # m, longer than the links of most machines
SLENDER = 300.0  # times a bearing's radius or the height of a block: links of machines are below 50
# Ratios of radius of gyration and size between which nothing is cautioned about: of bodies between moving
# joints, whose size is the largest distance of two points (a uniform rod has 0.29, a mass at each end 0.5),
# of those on the ground, among them masses on long arms and cranks with flywheels, and of driven ones, whose
# inertia may be that of a motor and its gears. The radius of a body on the ground or with a single place is
# compared with the size of the mechanism too.
GYRATION_BETWEEN_JOINTS = 0.05, 1.0
GYRATION, GYRATION_OF_DRIVEN, GYRATION_OF_SINGLE = (1.0 / 80.0, 8.0), 50.0, 2.0
ROD = 1.0 / math.sqrt(12.0)  # radius of gyration of a uniform rod of length 1
# A length of one table is cautioned about if it exceeds the largest of all bodies and of the ground this many
# times: of two of them or more, of a single one, and where only the position of a body is compared with it.
OUT_OF_REACH, OUT_OF_REACH_OF_ONE, DISTANT = 30.0, 100.0, 300.0
FLAT = 300.0  # times that length, radii of slots and rounds that are nearly straight
LONG_AXIS = 100.0  # times a bearing's radius, or the height of a block
COINCIDENT = 1e-6  # of the size of the mechanism: places closer together are one
# Numbers that are no places or sizes of the parts: another rule compares them.
OTHER_LENGTHS = "clearance", "axial_length", "landing_depth", "bearing_radius", "radius", "centre"
SLIM = 20_000.0  # times the radius of gyration of a section, lengths of links; wires have 1,000
# Times the root of the area, radii of gyration; a tube with a wall of a thousandth of its diameter has 6.
HOLLOW = 10.0
DEEP = 20.0  # times that radius, the distance of the outermost fibre: a rectangle has 1.7
SHALLOW = 0.9  # times that radius; no section has less than 1
SUNK = 0.1  # of the radius of a bearing, the last penetration of a measured law
SLOW = 0.5  # m/s, above which no friction law has its peak or ramp, and every impact is an impact
FASTEST = 60.0  # m/s; pistons of racing engines have 45

STRONGEST_GRAVITY = 30.0  # m/s^2: Jupiter has 24.8
SOFTEST = 5e5  # Pa: rubbers have 1 to 100 MPa, steel in MPa without a unit is 2.1e5
STIFFEST = 2e12  # Pa: diamond has 1.2e12
GIGA = 1e3  # moduli below may be numbers of GPa, others of MPa
LIGHTEST, DENSEST = 15.0, 25_000.0  # kg/m^3: foams and osmium; metals in g/cm^3 have 1.7 to 22.6
TONNES = 1e-6  # kg/m^3: densities below may be numbers of t/mm^3


def suspect_constants(mechanism: Mechanism) -> Iterator[str]:
    """Yield cautions about gravity and materials beyond any that exist, with the unit that is probably
    meant.
    """
    gravity = hypot(*mechanism.gravity)
    if gravity > STRONGEST_GRAVITY:
        yield (
            f"gravity is {gravity:.6g} m/s^2, {gravity / 9.81:,.0f} times that of the Earth: is it"
            f" {gravity:.6g} mm/s^2? Numbers without a unit are m/s^2."
        )
    for material in dict.fromkeys(materials_of(mechanism)):
        yield from _suspect_material(material)


def materials_of(mechanism: Mechanism) -> Iterator[Material]:
    """Yield the materials that matter: those of sections, and of the surfaces of contacts."""
    for body in mechanism.bodies.values():
        if isinstance(body, Link | Frame) and body.section is not None:
            yield body.material
        if isinstance(body, Frame):
            yield from (member.material for member in body.members if member.material is not None)
    for joint in mechanism.contacts.values():
        for side, (owner, _) in zip(
            (joint.bearing_material, joint.journal_material), joint.sides, strict=True
        ):
            if side is not None:
                yield side
            elif owner != "ground":
                yield mechanism.bodies[owner].material


def _suspect_material(material: Material) -> Iterator[str]:
    modulus, density = material.youngs_modulus, material.density
    name = f"material {material.name}" if material.name else "the material"
    if modulus < SOFTEST:
        unit = "GPa" if modulus < GIGA else "MPa"
        yield (
            f"The Young's modulus of {name} is {modulus:.6g} Pa, below that of rubber: is it"
            f" {modulus:.6g} {unit}? Numbers without a unit are Pa."
        )
    elif modulus > STIFFEST:
        yield (
            f"The Young's modulus of {name} is {modulus:.4g} Pa, above that of diamond: check its unit."
            " Numbers without a unit are Pa."
        )
    if density < LIGHTEST:
        unit = "t/mm^3" if density < TONNES else "g/cm^3"
        yield (
            f"The density of {name} is {density:.6g} kg/m^3, below that of foams: is it {density:.6g} {unit}?"
            " Numbers without a unit are kg/m^3."
        )
    elif density > DENSEST:
        yield (
            f"The density of {name} is {density:.6g} kg/m^3, above that of any metal: check its unit. Numbers"
            " without a unit are kg/m^3."
        )


def suspect_lengths(mechanism: Mechanism) -> Iterator[str]:
    """Yield cautions about lengths, places and sections that are out of scale."""
    links = tuple(_lengths(mechanism))
    yield from links
    yield from _spring_lengths(mechanism)
    if not links:
        yield from _out_of_reach(mechanism)
    yield from _sections(mechanism)
    for name, joint in mechanism.contacts.items():
        yield from _suspect_contact(name, joint)


def _out_of_reach(mechanism: Mechanism) -> Iterator[str]:
    """Caution about lengths and places of one table that are far beyond those of all bodies and of the ground
    in other tables.
    """
    largest = _largest_lengths(mechanism)
    reach = {
        table: size for table, (size, path) in largest.items()
        if table.startswith(("body.", "ground.")) and not path.endswith(".position")
    }  # fmt: skip
    order = sorted(reach, key=lambda table: -reach[table])
    for table, (size, path) in largest.items():
        count = len(reach) - (table in reach)
        if not count:
            continue
        longest = reach[order[table == order[0]]]
        limit = OUT_OF_REACH if count > 1 else DISTANT if table.endswith(".position") else OUT_OF_REACH_OF_ONE
        if size > limit * longest:
            yield (
                f"{path} is {size:.6g} m, and the largest length of other bodies and the ground is"
                f" {1e3 * longest:.4g} mm: is it {size:.6g} mm? Numbers without a unit are metres."
            )
    if order:
        yield from _flat_rounds(mechanism, reach[order[0]])


def _flat_rounds(mechanism: Mechanism, reach: float) -> Iterator[str]:
    """Caution about radii of slots and rounds that are hundreds of times the ``reach`` (m) of the bodies."""
    for name, joint in mechanism.joints.items():
        for key in ("radius", "bearing_radius"):
            radius = getattr(joint, key, None) or 0.0
            if radius > FLAT * reach and name not in mechanism.clearances:
                yield (
                    f"joint.{name}.{key} is {radius:.6g} m, and the largest length of bodies and the ground"
                    f" is {1e3 * reach:.4g} mm: is it {radius:.6g} mm? Numbers without a unit are metres."
                )


def _largest_lengths(mechanism: Mechanism) -> dict[str, tuple[float, str]]:
    """Return the largest length (m) of each body, joint, driver and load that is not zero, and its path; also
    of each node of a frame, point of the ground and position of a body.
    """
    sections: dict[str, Mapping[str, Any]] = {
        "body": mechanism.bodies, "joint": mechanism.joints, "driver": mechanism.drivers,
        "load": mechanism.loads,
    }  # fmt: skip
    largest = {
        f"ground.{name}": (hypot(*place), f"ground.{name}") for name, place in mechanism.points.items()
    }
    for section, entries in sections.items():
        for name, entry in entries.items():
            kind: Any = type(entry)
            for field, key in _length_fields(kind, bool(getattr(entry, "is_linear", False))):
                table, value = f"{section}.{name}", getattr(entry, field)
                path = f"{table}.{key}"
                if key == "nodes":
                    largest |= {
                        f"{path}.{node}": (hypot(*at), f"{path}.{node}") for node, at in value.items()
                    }
                    continue
                size = max(map(abs, _flat(value)), default=0.0)
                table = path if key == "position" else table
                largest[table] = max(largest.get(table, (0.0, path)), (size, path))
    return {table: entry for table, entry in largest.items() if entry[0]}


@cache
def _length_fields(kind: Any, linear: bool) -> tuple[tuple[str, str], ...]:
    """Return the names and keys of the fields of a class that contain lengths or places (m)."""
    return tuple(
        (field.name, key_of(field, linear))
        for field in described_fields(kind)
        if _unit_of(value_of(field, linear)) == "m" and field.name not in OTHER_LENGTHS
    )


def _unit_of(value: Value) -> str:
    """Return the unit of a number, or of the first of a list."""
    while isinstance(value, FixedList | FreeList | Names):
        value = value.parts[0] if isinstance(value, FixedList) else value.part
    return value.unit if isinstance(value, Measure) else ""


def _flat(value: Any) -> Iterator[float]:
    """Yield the numbers of a number, list or table."""
    if isinstance(value, int | float):
        yield value
    elif isinstance(value, tuple | list | dict):
        for part in value.values() if isinstance(value, dict) else value:
            yield from _flat(part)


def _suspect_contact(name: str, joint: Contact) -> Iterator[str]:
    """Caution about lengths along the axis, depths of penetration and speeds of laws beyond any contact's."""
    reach = joint.reach
    depth = getattr(joint.contact, "full_damping_depth", None) or 0.0
    loading = getattr(joint.contact, "loading", None) or ((0.0, 0.0),)
    lengths = {
        "axial_length": (joint.axial_length, LONG_AXIS * reach),
        "contact.loading": (loading[-1][0] * getattr(joint.contact, "penetration_factor", 1.0), SUNK * reach),
        "landing_depth": (joint.landing_depth or 0.0, getattr(joint, "clearance", reach)),
        "contact.full_damping_depth": (depth, reach),
    }
    for key, (length, limit) in lengths.items():
        if length > limit:
            yield (
                f"joint.{name}.{key} is {length:.6g} m, {length / reach:,.3g} times {joint.extent[1]}: is it"
                f" {length:.6g} mm? Numbers without a unit are metres."
            )
    speeds = {"impact_speed_floor": joint.impact_speed_floor}
    for key, law in (("friction", joint.friction), ("contact", joint.contact)):
        for field in dataclasses.fields(law):
            if field.metadata.get("unit") == "m/s":
                speeds[f"{key}.{field.name}"] = getattr(law, field.name) or 0.0
    for key, speed in speeds.items():
        if speed > SLOW:
            yield (
                f"joint.{name}.{key} is {speed:.6g} m/s, and speeds of this kind are mm/s: is it"
                f" {speed:.6g} mm/s? Numbers without a unit are m/s."
            )


def suspect_velocities(mechanism: Mechanism) -> Iterator[str]:
    """Yield cautions about speeds along a line that no machine has."""
    speeds = {
        f"body.{name}.velocity": hypot(*body.velocity[:2]) for name, body in mechanism.bodies.items()
    } | {
        f"driver.{name}.speed": abs(getattr(driver, "speed", None) or 0.0)
        for name, driver in mechanism.drivers.items() if driver.is_linear
    }  # fmt: skip
    for path, speed in speeds.items():
        if speed > FASTEST:
            yield (
                f"{path} is {speed:.6g} m/s, faster than the parts of most machines: is it {speed:.6g} mm/s?"
                " Numbers without a unit are m/s."
            )


def _sections(mechanism: Mechanism) -> Iterator[str]:
    """Caution about sections that are deeper than their link is long, or thinner than a wire, and about an
    outermost fibre that does not belong to the second moment of area.
    """
    for name, body in mechanism.bodies.items():
        if isinstance(body, Link) and body.section is not None:
            yield from _suspect_section(f"body.{name}.section", body.section, body.path_length)
        if isinstance(body, Frame):
            length = extent(body)
            sections = [body.section, *(member.section for member in body.members)]
            for section in dict.fromkeys(section for section in sections if section is not None):
                yield from _suspect_section(f"body.{name}.section", section, length)


def _suspect_section(path: str, section: Section, length: float) -> Iterator[str]:
    gyration, fibre = math.sqrt(section.second_moment / section.area), section.extreme_fibre
    width = max(math.sqrt(section.area), gyration)
    if length and width > length:
        yield (
            f"{path} is {width:.4g} m wide or deep, and its body is {1e3 * length:.4g} mm long: check the"
            " units of the section. Numbers without a unit are metres."
        )
    elif gyration > HOLLOW * math.sqrt(section.area):
        yield (
            f"{path}: area and second moment make a radius of gyration of {1e3 * gyration:.4g} mm,"
            f" {gyration / math.sqrt(section.area):.3g} times the root of the area, and of thin tubes it is"
            " below 6: check the units of both."
        )
    elif length > SLIM * gyration:
        yield (
            f"{path} has a radius of gyration of {1e3 * gyration:.4g} mm, and its body is {length:.6g} m"
            " long: check the units of both."
        )
    elif fibre and not SHALLOW * gyration <= fibre <= DEEP * gyration:
        yield (
            f"{path}.extreme_fibre is {1e3 * fibre:.4g} mm, which area and second moment exclude: their"
            f" radius of gyration is {1e3 * gyration:.4g} mm, and the outermost fibre of a rectangle is at"
            " 1.7 times it. Check the units."
        )


def _sizes(mechanism: Mechanism) -> dict[str, float]:
    """Return the lengths (m) of links, joints and places of the ground, by path."""
    sizes = {
        f"body.{name}.length": body.length
        for name, body in mechanism.bodies.items()
        if isinstance(body, Link)
    }
    sizes |= {
        f"joint.{name}.length": length
        for name, joint in mechanism.joints.items()
        if (length := getattr(joint, "length", None))
    }
    for name, (x, y) in mechanism.points.items():
        sizes |= {f"ground.{name}": hypot(x, y)} if x or y else {}
    return sizes


def _spring_lengths(mechanism: Mechanism) -> Iterator[str]:
    """Caution about free lengths of springs a hundred times the other lengths, or longer than any machine; a
    short one, or none, is usual.
    """
    sizes = list(_sizes(mechanism).values())
    for body in mechanism.bodies.values():
        pins = body.pins.values() if isinstance(body, RigidBody) else ()
        sizes += [size for pin in pins if (size := hypot(*pin))]
    usual = median(sizes) if sizes else 0.0
    for name, spring in mechanism.springs.items():
        length = getattr(spring, "free_length", None) or 0.0
        if length > (OUT_OF_SCALE * usual or HUGE):
            ratio = f", {length / usual:,.0f} times the other lengths" if usual else ""
            yield (
                f"spring.{name}.free_length is {length:.6g} m{ratio}: is it {length:.6g} mm? Numbers without"
                " a unit are metres."
            )


def _lengths(mechanism: Mechanism) -> Iterator[str]:
    """Caution about lengths a hundred times larger or smaller than the others, or larger than any machine."""
    sizes = _sizes(mechanism)
    if _links_in_metres(mechanism):
        yield _in_metres({path: size for path, size in sizes.items() if size > LONG})
        return
    cautioned, lengths = False, sizes.values()
    # Medians take long: none is needed if no two lengths are so far apart.
    disparity = len(sizes) > 2 and not min(lengths) / max(lengths) >= 1.0 / OUT_OF_SCALE
    for path, size in sizes.items() if disparity else ():
        ratio = size / median(value for key, value in sizes.items() if key != path)
        if ratio > OUT_OF_SCALE:
            cautioned = True
            yield (
                f"{path} is {size:.6g} m, {ratio:,.0f} times the others: is it {size:.6g} mm? Numbers"
                " without a unit are metres."
            )
        elif ratio < 1.0 / OUT_OF_SCALE:
            cautioned = True
            yield (
                f"{path} is {1e3 * size:.4g} mm, {1.0 / ratio:,.0f} times smaller than the others: check its"
                " unit."
            )
    largest = max(sizes, key=lambda key: sizes[key], default="")
    if largest and not cautioned and sizes[largest] > HUGE and mechanism.settings.analysis != "static":
        yield (
            f"{largest} is {sizes[largest]:.6g} m long. Numbers without a unit are metres: is this meant, and"
            " not mm?"
        )


def _links_in_metres(mechanism: Mechanism) -> dict[str, float]:
    """Return the lengths (m) of links that are probably in mm, by body: all links are longer than most
    machines, and they are whole numbers of metres or out of proportion to a bearing.
    """
    links = {name: body.length for name, body in mechanism.bodies.items() if isinstance(body, Link)}
    if not links or min(links.values()) <= LONG or mechanism.settings.analysis == "static":
        return {}
    radii = [getattr(joint, joint.extent[0], None) or 0.0 for joint in mechanism.contacts.values()]
    slender = any(0.0 < SLENDER * radius < min(links.values()) for radius in radii)
    return links if slender or all(length == round(length) for length in links.values()) else {}


def _in_metres(lengths: Mapping[str, float]) -> str:
    """Return a caution about ``lengths`` (m), by path, that are probably in mm."""
    sizes = ", ".join(f"{path} is {length:.6g} m" for path, length in lengths.items())
    millimetres = ", ".join(f"{length:.6g} mm" for length in lengths.values())
    verb = "is it" if len(lengths) == 1 else "are they"
    return f"{sizes}: {verb} {millimetres}? Numbers without a unit are metres."


def suspect_radii(mechanism: Mechanism) -> Iterator[str]:
    """Caution about bearings that are larger than each body of the mechanism and its ground, or than the
    links of machines if these have no size.
    """
    sizes = {name: joint.bearing_radius for name, joint in mechanism.clearances.items()}
    largest = max(extents_of(mechanism), default=0.0) if sizes else 0.0
    for name, size in sizes.items():
        if size > (largest or LONG):
            bodies = f"the largest distance of two points of a body, {1e3 * largest:.4g} mm"
            yield (
                f"joint.{name}.bearing_radius is {size:.4g} m, more than"
                f" {bodies if largest else 'links of most machines'}: is it {size:.4g} mm? Numbers without a"
                " unit are metres."
            )


def extents_of(mechanism: Mechanism) -> Iterator[float]:
    """Yield the diagonals (m) of the rectangles around the points of each body, and of the ground."""
    for points in (mechanism.points, *(body.points for body in mechanism.bodies.values())):
        if len(points) > 1:
            yield hypot(*(max(places) - min(places) for places in zip(*points.values(), strict=True)))


def suspect_inertias(mechanism: Mechanism) -> Iterator[str]:
    """Caution about radii of gyration, (I/m)^(1/2), that contradict the size of the body: kg mm^2 for kg m^2
    is a factor of a thousand, pounds for kilograms one of two.
    """
    ends = ({end.partition(".")[0] for end in pair} for pair in connections(mechanism))
    hung = {name for pair in ends if "ground" in pair for name in pair}
    highest = dict.fromkeys(hung, GYRATION[1]) | dict.fromkeys(mechanism.drivers, GYRATION_OF_DRIVEN)
    too_long, largest = _links_in_metres(mechanism), max(extents_of(mechanism), default=0.0)
    for name, body in mechanism.bodies.items():
        if not isinstance(body, Link | RigidBody) or name in too_long:
            continue
        if body.mass and body.inertia:
            path, size = f"body.{name}.inertia", _gyration_size(body, name in highest)
            limits = GYRATION_BETWEEN_JOINTS
            if size > COINCIDENT * largest and name in highest:
                limits = (GYRATION[0], max(highest[name], GYRATION_OF_SINGLE * largest / size))
            elif size <= COINCIDENT * largest:
                size, limits = largest, (0.0, highest.get(name, GYRATION_OF_SINGLE))
            yield from _suspect_inertia(path, body.inertia, body.mass, size, limits)
        for end in ("start", "end") if isinstance(body, Link) else ():
            inertia = getattr(body, f"{end}_inertia")
            mass = (body.mass or 0.0) + getattr(body, f"{end}_mass")
            path, size = f"body.{name}.{end}_inertia", extent(body)
            yield from _suspect_inertia(path, inertia, mass, size, (0.0, GYRATION_OF_DRIVEN)) if mass else ()


def _gyration_size(body: Link | RigidBody, on_ground: bool) -> float:
    """Return the size (m) with which a radius of gyration is compared; 0 of a body with a single place."""
    size = extent(body)
    if size and not on_ground:
        return size
    return body.length if isinstance(body, Link) else max(map(_radius, body.pins.values()), default=0.0)


def _suspect_inertia(
    path: str, inertia: float, mass: float, size: float, limits: tuple[float, float]
) -> Iterator[str]:
    radius, (low, high) = math.sqrt(inertia / mass), limits
    if size and not low <= radius / size <= high * (1.0 + 1e-9):
        yield (
            f"{path} is {inertia:.4g} kg m^2 with a mass of {mass:.4g} kg, a radius of gyration of"
            f" {1e3 * radius:.4g} mm for a body of {1e3 * size:.4g} mm (a uniform rod has"
            f" {1e3 * ROD * size:.3g} mm): check its unit and that of the mass."
        )


def extent(body: Link | RigidBody | Frame) -> float:
    """Return the largest distance between two points of a body (m), 0 of one with a single point."""
    if isinstance(body, Link):
        return body.length
    places = list((body.nodes if isinstance(body, Frame) else body.pins).values())
    return max((distance(*pair) for pair in combinations(places, 2)), default=0.0)


def _radius(place: tuple[float, float]) -> float:
    """Return the distance of a place from the centre of its body (m)."""
    return hypot(*place)
