"""Checks of joints, gears and springs."""

from __future__ import annotations

from typing import Any

from ...errors import Path
from ...schema import Text, described_fields, value_of
from ..bodies import Frame, Link
from ..functions import carrier_of
from ..rows import Coincide
from .checks import Checks, ends, held_by, readable, rows_of, shown_name


def check_joints(checks: Checks) -> None:
    """Check every joint, and pairs of joints that constrain the same motion."""
    pairs: dict[frozenset[str], str] = {}
    held: dict[frozenset[str], str] = {}
    for name, joint in checks.joints.items():
        check_joint(checks, ("joint", name), joint, pairs)
        bodies = frozenset(held_by(joint))
        if (
            Coincide() not in rows_of(joint)
            or len(bodies) != 2
            or not all(rigid(checks, body) for body in bodies)
        ):
            continue
        other = held.setdefault(bodies, name)
        if other != name and set(ends(joint)) != set(ends(checks.joints[other])):
            one, two = sorted(bodies)
            what = f"joints {other} and {name} both hold {one} and {two}: together they weld the two bodies"
            remedy = (
                'remove one of the joints, give one clearance (kind = "clearance"), or keep one alone with '
                "kind ="
                ' "weld"'
            )
            checks.add(("joint", name, ""), what, remedy)


def rigid(checks: Checks, body: str) -> bool:
    """Return whether a body is rigid; a deformable body may be held by two joints."""
    noun = checks.bodies.get(body)
    return body == "ground" or (
        noun is not None
        and not isinstance(noun, Frame)
        and not (isinstance(noun, Link) and noun.model != "rigid")
    )


def check_joint(checks: Checks, path: Path, joint: Any, pairs: dict[frozenset[str], str]) -> None:
    """Check that both sides exist and differ, that no pair of pins is joined twice, and that sizes fit."""
    bearing, journal = joint.bearing, joint.journal
    checks.side((*path, "bearing"), bearing)
    checks.side((*path, "journal"), journal)
    if bearing is not None and journal is not None:
        if bearing.partition(".")[0] == journal.partition(".")[0]:
            checks.add(
                (*path, "journal"),
                "bearing and journal are on the same body",
                "name a pin of another body, or of the ground",
            )
        other = pairs.setdefault(frozenset((bearing, journal)), str(path[1]))
        if other != path[1]:
            checks.add(
                (*path, ""), f"joint {other} connects the same two pins already", "remove one of the two"
            )
    for conflict in joint.conflicts():
        checks.take(path, conflict)


def _carrier(checks: Checks, gear: Any) -> str:
    """Return the carrier of a gear; the ground if other faults prevent finding it."""
    try:
        return carrier_of(checks.mechanism, gear)
    except (AttributeError, KeyError, TypeError, ValueError):
        return "ground"


def check_gears(checks: Checks) -> None:
    """Check that a gear couples two different bodies that turn, once, with a nonzero ratio."""
    pairs: dict[frozenset[str], str] = {}
    for name, gear in readable(checks.mechanism.gears):
        path: Path = ("gear", name)
        one, two = gear.first, gear.second
        if gear.ratio == 0.0:
            remedy = "give the teeth of the first over those of the second, negative for external gears"
            checks.add(
                (*path, "ratio"),
                "with a ratio of zero the second body would not turn at all",
                remedy,
                "any number but 0",
            )
        exist = [checks.body((*path, key), body) for key, body in (("first", one), ("second", two))]
        if gear.carrier is not None and (not checks.body((*path, "carrier"), gear.carrier) or not all(exist)):
            continue
        if not all(exist):
            continue
        if gear.carrier in (one, two) and gear.carrier != "ground":
            checks.add(
                (*path, "carrier"),
                f"{gear.carrier} is one of the two wheels",
                "name the body on which both of them turn, or leave it out",
            )
            continue
        if one == two:
            checks.add((*path, "second"), f"the gear couples {one} with itself", "name another body")
            continue
        if "ground" in (one, two) and _carrier(checks, gear) == "ground":
            remedy = "name two bodies that turn, or the carrier of a planet that rolls on a fixed wheel"
            checks.add((*path, ""), "a gear to the ground holds the body where it is", remedy)
        other = pairs.setdefault(frozenset((one, two)), name)
        if other != name:
            checks.add((*path, ""), f"gear {other} couples {one} and {two} already", "remove one of the two")
        if one in checks.turned and two in checks.turned:
            drivers = f"{checks.turned[one]} and {checks.turned[two]}"
            checks.add(
                (*path, ""),
                f"drivers {drivers} turn both bodies, which the gear couples",
                "remove one of the two drivers, or the gear",
            )


def check_springs(checks: Checks) -> None:
    """Check every spring."""
    for name, spring in readable(checks.mechanism.springs):
        path: Path = ("spring", name)
        for field in described_fields(type(spring)):
            value = value_of(field)
            if isinstance(value, Text) and value.refers:
                (checks.side if value.refers == "pin" else checks.body)(
                    (*path, field.name), getattr(spring, field.name)
                )
        one, two = ((end or "").partition(".")[0] for end in (spring.first, spring.second))
        # A spring may brace a body that deforms.
        if (
            one
            and one == two
            and (spring.axes != "linear" or spring.first == spring.second or rigid(checks, one))
        ):
            what = (
                "both ends are on the ground"
                if one == "ground"
                else f"both ends are on {shown_name(one)}, and do nothing there"
            )
            checks.add((*path, "second"), what, "name another body")
        check_strength(checks, path, spring)


def check_strength(checks: Checks, path: Path, spring: Any) -> None:
    """Check that a spring has stiffness or damping, and its limits."""
    strength = [spring.stiffness, spring.damping]
    if None not in strength and not any(any(one) if isinstance(one, tuple) else one for one in strength):
        checks.add(
            (*path, ""),
            "neither a stiffness nor a damping: it does nothing",
            "give one of the two, or remove it",
        )
    for conflict in spring.conflicts():
        checks.take(path, conflict)
