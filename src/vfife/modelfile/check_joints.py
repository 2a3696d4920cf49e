"""Checks of joints, gears and springs: what they connect, and numbers that go together."""

from __future__ import annotations

from ..errors import Path
from .checks import Checks, shown_name, sides
from .lawtables import read_law
from .schema import JOINT_TABLES, ContactTable, body_kind, joint_kind, spring_kind
from .tables import Raw, amount, amounts, entries, table, text

HOLDING = ("ideal", "weld")  # two of these between two rigid bodies leave them no motion


def check_joints(checks: Checks) -> None:
    """All joints, and which of them hold the same thing twice."""
    pairs: dict[frozenset[str], str] = {}
    held: dict[frozenset[str], str] = {}
    for name, joint in checks.joints.items():
        check_joint(checks, name, joint, pairs)
        bodies = frozenset(side.partition(".")[0] for side in sides(joint))
        if kind_of(joint) not in HOLDING or len(bodies) != 2 or not all(rigid(checks, body) for body in bodies):
            continue
        other = held.setdefault(bodies, name)
        if other != name and set(sides(joint)) != set(sides(checks.joints[other])):
            one, two = sorted(bodies)
            what = f"joints {other} and {name} both hold {one} and {two}: together they weld the two bodies"
            remedy = 'remove one of the joints, give one play (kind = "clearance"), or keep one alone with kind = "weld"'
            checks.add(("joint", name, ""), what, remedy)


def kind_of(joint: Raw) -> str:
    """Kind of a joint as it will be read."""
    return joint_kind(joint).strip("<>")


def rigid(checks: Checks, body: str) -> bool:
    """Whether a body does not deform; one that does may well be held twice."""
    holder = table(checks.raw, "body", body)
    kind = body_kind(holder)
    return body == "ground" or (body in checks.bodies and kind != "<frame>" and (kind != "<link>" or holder.get("model", "rigid") == "rigid"))


def check_joint(checks: Checks, name: str, joint: Raw, pairs: dict[frozenset[str], str]) -> None:
    """Both sides exist and differ, no pair is joined twice, sizes fit, laws are known."""
    path: Path = ("joint", name)
    bearing, journal = joint.get("bearing"), joint.get("journal")
    checks.side((*path, "bearing"), bearing)
    checks.side((*path, "journal"), journal)
    if isinstance(bearing, str) and isinstance(journal, str):
        if bearing.partition(".")[0] == journal.partition(".")[0]:
            checks.add((*path, "journal"), "bearing and journal are on the same body", "name a pin of another body, or of the ground")
        other = pairs.setdefault(frozenset((bearing, journal)), name)
        if other != name:
            checks.add((*path, ""), f"joint {other} connects the same two pins already", "remove one of the two")
    checks.direction(path, joint)
    check_sizes(checks, path, joint)
    if not issubclass(JOINT_TABLES[kind_of(joint)], ContactTable):
        return
    checks.material(path, joint, "bearing_material")
    checks.material(path, joint, "journal_material")
    for kind in ("contact", "friction"):
        if isinstance(joint.get(kind), dict):
            checks.faults += read_law(kind, joint[kind], (*path, kind), checks.given)[1]


def check_sizes(checks: Checks, path: Path, joint: Raw) -> None:
    """The journal is smaller than its bearing and something of it remains; corners fit on the block; a round has no direction."""
    kind = kind_of(joint)
    size, radius = amount(joint, "clearance", "m"), amount(joint, "bearing_radius", "m")
    if kind == "clearance" and size is not None and radius is not None and radius > 0.0 and size >= radius:
        limit = f"above 0 m and below bearing_radius = {radius:g} m"
        remedy = "check the units of both: clearance is bearing radius less journal radius"
        checks.add((*path, "clearance"), "as large as the bearing: no journal is left", remedy, limit)
    block = [amount(joint, key, "m") or 0.0 for key in ("length", "height")]
    corner = amount({"corner_radius": 1e-3} | joint, "corner_radius", "m")
    if kind == "clearance-slider" and corner is not None and min(block) > 0.0 and corner > 0.5 * min(block):
        what = f"corners of {corner:g} m do not fit on a block of {block[0]:g} m by {block[1]:g} m"
        limit = f"at most half of the smaller side, {0.5 * min(block):g} m"
        checks.add((*path, "corner_radius"), what, "give a smaller radius, and check the units of all three", limit)
    if kind == "contact" and "bearing_radius" in joint and "direction" in joint:
        checks.add((*path, "direction"), "a round has no direction", "remove it, or remove bearing_radius for a straight line")


def check_gears(checks: Checks) -> None:
    """A gear couples two different bodies that turn, once, and its ratio is not zero."""
    pairs: dict[frozenset[str], str] = {}
    for name, gear in entries(checks.raw, "gear"):
        path: Path = ("gear", name)
        bodies = [gear.get(key) for key in ("first", "second")]
        there = [checks.body((*path, key), body) for key, body in zip(("first", "second"), bodies, strict=True)]
        if amount(gear, "ratio", "1") == 0.0:
            remedy = "give the teeth of the first over those of the second, negative for external gears"
            checks.add((*path, "ratio"), "with a ratio of zero the second body would not turn at all", remedy, "any number but 0")
        if not all(there):
            continue
        one, two = (str(body) for body in bodies)
        if one == two:
            checks.add((*path, "second"), f"the gear couples {one} with itself", "name another body")
            continue
        if "ground" in (one, two):
            checks.add((*path, ""), "a gear to the ground holds the body where it is", "name two bodies that turn")
        other = pairs.setdefault(frozenset((one, two)), name)
        if other != name:
            checks.add((*path, ""), f"gear {other} couples {one} and {two} already", "remove one of the two")
        if one in checks.turned and two in checks.turned:
            drivers = f"{checks.turned[one]} and {checks.turned[two]}"
            checks.add((*path, ""), f"drivers {drivers} turn both bodies, which the gear couples", "remove one of the two drivers, or the gear")


def check_springs(checks: Checks) -> None:
    """Springs connect two different things, and do something."""
    for name, spring in entries(checks.raw, "spring"):
        path: Path = ("spring", name)
        kind = spring_kind(spring).strip("<>")
        first, second = spring.get("first"), spring.get("second")
        for key, end in (("first", first), ("second", second)):
            if kind in ("linear", "bushing"):
                checks.side((*path, key), end)
            else:
                checks.body((*path, key), end)
        one, two = (text(spring, key).partition(".")[0] for key in ("first", "second"))
        # A spring may brace a body that deforms.
        if one and one == two and (kind != "linear" or first == second or rigid(checks, one)):
            what = "both ends are on the ground" if one == "ground" else f"both ends are on {shown_name(one)}, and do nothing there"
            checks.add((*path, "second"), what, "name another body")
        check_strength(checks, path, spring, kind)


def check_strength(checks: Checks, path: Path, spring: Raw, kind: str) -> None:
    """A spring has a stiffness or a damping; a stop has room between its limits."""
    units = {"linear": ("N/m", "N s/m"), "torsional": ("N m/rad", "N m s/rad")}.get(kind)
    if units is not None:
        stiffness, damping = (amount({key: 0.0} | spring, key, unit) for key, unit in zip(("stiffness", "damping"), units, strict=True))
    else:
        axes = (
            amounts(spring.get("stiffness"), ("N/m", "N/m", "N m/rad")),
            amounts(spring.get("damping", [0, 0, 0]), ("N s/m", "N s/m", "N m s/rad")),
        )
        stiffness, damping = (max(one) if one is not None else None for one in axes)
    if kind != "stop" and stiffness == 0.0 and damping == 0.0:
        checks.add((*path, ""), "neither a stiffness nor a damping: it does nothing", "give one of the two, or remove it")
    low, high = amount(spring, "low", "rad"), amount(spring, "high", "rad")
    if kind == "stop" and low is not None and high is not None and low >= high:
        checks.add((*path, "low"), "no room between the limits", "exchange them, or move them apart", f"below high = {high:g} rad")
