"""Checks of joints and gears: what they connect, what they hold twice, and sizes that go together."""

from __future__ import annotations

from typing import Any

from ...errors import Path
from ..bodies import Frame, Link
from ..joints import ClearanceRevolute, ClearanceSlider, ExternalContact, IdealRevolute, Weld
from .checks import Checks, ends, held_by, known

HOLDING = (IdealRevolute, Weld)  # two of these between two rigid bodies leave them no motion


def check_joints(checks: Checks) -> None:
    """All joints, and which of them hold the same thing twice."""
    pairs: dict[frozenset[str], str] = {}
    held: dict[frozenset[str], str] = {}
    for name, joint in checks.joints.items():
        check_joint(checks, ("joint", name), joint, pairs)
        bodies = frozenset(held_by(joint))
        if not isinstance(joint, HOLDING) or len(bodies) != 2 or not all(rigid(checks, body) for body in bodies):
            continue
        other = held.setdefault(bodies, name)
        if other != name and set(ends(joint)) != set(ends(checks.joints[other])):
            one, two = sorted(bodies)
            what = f"joints {other} and {name} both hold {one} and {two}: together they weld the two bodies"
            remedy = 'remove one of the joints, give one play (kind = "clearance"), or keep one alone with kind = "weld"'
            checks.add(("joint", name, ""), what, remedy)


def rigid(checks: Checks, body: str) -> bool:
    """Whether a body does not deform; one that does may well be held twice."""
    noun = checks.bodies.get(body)
    return body == "ground" or (noun is not None and not isinstance(noun, Frame) and not (isinstance(noun, Link) and noun.model != "rigid"))


def check_joint(checks: Checks, path: Path, joint: Any, pairs: dict[frozenset[str], str]) -> None:
    """Both sides exist and differ, no pair is joined twice, sizes fit."""
    bearing, journal = joint.bearing, joint.journal
    checks.side((*path, "bearing"), bearing)
    checks.side((*path, "journal"), journal)
    if bearing is not None and journal is not None:
        if bearing.partition(".")[0] == journal.partition(".")[0]:
            checks.add((*path, "journal"), "bearing and journal are on the same body", "name a pin of another body, or of the ground")
        other = pairs.setdefault(frozenset((bearing, journal)), str(path[1]))
        if other != path[1]:
            checks.add((*path, ""), f"joint {other} connects the same two pins already", "remove one of the two")
    check_sizes(checks, path, joint)


def check_sizes(checks: Checks, path: Path, joint: Any) -> None:
    """The journal is smaller than its bearing and something of it remains; corners fit on the block; a round has no direction."""
    if isinstance(joint, ClearanceRevolute) and None not in (joint.clearance, joint.bearing_radius) and joint.clearance >= joint.bearing_radius:
        limit = f"above 0 m and below bearing_radius = {joint.bearing_radius:g} m"
        remedy = "check the units of both: clearance is bearing radius less journal radius"
        checks.add((*path, "clearance"), "as large as the bearing: no journal is left", remedy, limit)
    block: Any = (joint.length, joint.height, joint.corner_radius) if isinstance(joint, ClearanceSlider) else (None,)
    if None not in block and joint.corner_radius > 0.5 * min(block[:2]):
        what = f"corners of {joint.corner_radius:g} m do not fit on a block of {joint.length:g} m by {joint.height:g} m"
        limit = f"at most half of the smaller side, {0.5 * min(block[:2]):g} m"
        checks.add((*path, "corner_radius"), what, "give a smaller radius, and check the units of all three", limit)
    if isinstance(joint, ExternalContact) and joint.bearing_radius is not None and joint.direction not in (None, (1.0, 0.0)):
        checks.add((*path, "direction"), "a round has no direction", "remove it, or remove bearing_radius for a straight line")


def check_gears(checks: Checks) -> None:
    """A gear couples two different bodies that turn, once, and its ratio is not zero."""
    pairs: dict[frozenset[str], str] = {}
    for name, gear in known(checks.mechanism.gears):
        path: Path = ("gear", name)
        one, two = gear.first, gear.second
        if gear.ratio == 0.0:
            remedy = "give the teeth of the first over those of the second, negative for external gears"
            checks.add((*path, "ratio"), "with a ratio of zero the second body would not turn at all", remedy, "any number but 0")
        found = [checks.body((*path, key), body) for key, body in (("first", one), ("second", two))]
        if not all(found):
            continue
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
