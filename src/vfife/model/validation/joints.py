"""Checks of joints, gears and springs."""

from __future__ import annotations

from typing import Any

from ...errors import Path
from ...schema import Text, described_fields, value_of
from ..bodies import Frame, Link
from ..functions import carrier_of
from ..rows import Coincide
from .checks import Checks, bodies_of, ends, readable, rows_of, shown_name


def check_joints(checks: Checks) -> None:
    """Check every joint, and pairs of joints that constrain the same motion."""
    pairs: dict[frozenset[str], str] = {}
    pivots: dict[frozenset[str], str] = {}
    for name, joint in checks.joints.items():
        check_joint(checks, ("joint", name), joint, pairs)
        bodies = frozenset(bodies_of(joint))
        if (
            Coincide() not in rows_of(joint)
            or len(bodies) != 2
            or not all(rigid(checks, body) for body in bodies)
        ):
            continue
        pivot = pivots.setdefault(bodies, name)
        if pivot != name and set(ends(joint)) != set(ends(checks.joints[pivot])):
            first, second = sorted(bodies)
            problem = (
                f"joints {pivot} and {name} both hold {first} and {second}: together they weld the two bodies"
            )
            remedy = (
                'remove one of the joints, give one clearance (kind = "clearance"), or keep one alone with '
                "kind ="
                ' "weld"'
            )
            checks.add(("joint", name, ""), problem, remedy)


def rigid(checks: Checks, body: str) -> bool:
    """Return whether a body is rigid; a deformable body may be held by two joints."""
    item = checks.bodies.get(body)
    return body == "ground" or (
        item is not None
        and not isinstance(item, Frame)
        and not (isinstance(item, Link) and item.model != "rigid")
    )


def check_sides(checks: Checks, path: Path, joint: Any) -> None:
    """Check that bearing and journal are on different bodies."""
    if len(bodies_of(joint)) == 1:
        remedy = "name a pin of another body, or of the ground"
        checks.add((*path, "journal"), "bearing and journal are on the same body", remedy)


def check_joint(checks: Checks, path: Path, joint: Any, pairs: dict[frozenset[str], str]) -> None:
    """Check that both sides exist and differ, that no pair of pins is joined twice, and that sizes fit."""
    bearing, journal = joint.bearing, joint.journal
    checks.side((*path, "bearing"), bearing)
    checks.side((*path, "journal"), journal)
    if bearing is not None and journal is not None:
        check_sides(checks, path, joint)
        twin = pairs.setdefault(frozenset((bearing, journal)), str(path[1]))
        if twin != path[1]:
            checks.add(
                (*path, ""), f"joint {twin} connects the same two pins already", "remove one of the two"
            )
    checks.conflicts(path, joint)


def _carrier(checks: Checks, gear: Any) -> str:
    """Return the carrier of a gear; the ground if other faults prevent finding it."""
    try:
        return carrier_of(checks.mechanism, gear)
    except (AttributeError, KeyError, TypeError, ValueError):
        return "ground"


def check_ratio(checks: Checks, path: Path, gear: Any) -> None:
    """Check that the ratio of a gear is not zero."""
    if gear.ratio == 0.0:
        remedy = "give the teeth of the first over those of the second, negative for external gears"
        problem = "with a ratio of zero the second body would not turn at all"
        checks.add((*path, "ratio"), problem, remedy, "any number but 0")


def check_gears(checks: Checks) -> None:
    """Check that a gear couples two different bodies that turn, once, with a nonzero ratio."""
    pairs: dict[frozenset[str], str] = {}
    for name, gear in readable(checks.mechanism.gears):
        path: Path = ("gear", name)
        first, second = gear.first, gear.second
        check_ratio(checks, path, gear)
        exist = [checks.body((*path, key), body) for key, body in (("first", first), ("second", second))]
        if gear.carrier is not None:
            exist.append(checks.body((*path, "carrier"), gear.carrier))
        if not all(exist):
            continue
        if gear.carrier in (first, second) and gear.carrier != "ground":
            checks.add(
                (*path, "carrier"),
                f"{gear.carrier} is one of the two wheels",
                "name the body on which both of them turn, or leave it out",
            )
            continue
        if first == second:
            checks.add((*path, "second"), f"the gear couples {first} with itself", "name another body")
            continue
        if "ground" in (first, second) and _carrier(checks, gear) == "ground":
            remedy = "name two bodies that turn, or the carrier of a planet that rolls on a fixed wheel"
            checks.add((*path, ""), "a gear to the ground holds the body where it is", remedy)
        twin = pairs.setdefault(frozenset((first, second)), name)
        if twin != name:
            checks.add(
                (*path, ""), f"gear {twin} couples {first} and {second} already", "remove one of the two"
            )
        if first in checks.turned and second in checks.turned:
            drivers = f"{checks.turned[first]} and {checks.turned[second]}"
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
        first, second = ((end or "").partition(".")[0] for end in (spring.first, spring.second))
        # A spring may brace a body that deforms.
        if (
            first
            and first == second
            and (spring.axes != "linear" or spring.first == spring.second or rigid(checks, first))
        ):
            problem = (
                "both ends are on the ground"
                if first == "ground"
                else f"both ends are on {shown_name(first)}, so it has no effect"
            )
            checks.add((*path, "second"), problem, "name another body")
        check_strength(checks, path, spring)


def check_strength(checks: Checks, path: Path, spring: Any) -> None:
    """Check that a spring has stiffness or damping, and its limits."""
    strength = [spring.stiffness, spring.damping]
    if None not in strength and not any(
        any(value) if isinstance(value, tuple) else value for value in strength
    ):
        checks.add(
            (*path, ""),
            "neither a stiffness nor a damping: it does nothing",
            "give one of the two, or remove it",
        )
    checks.conflicts(path, spring)
