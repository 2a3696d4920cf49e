"""Checks of bodies: masses, sections, the points of bent links, the members of frames."""

from __future__ import annotations

import math
from typing import Any

from ...errors import Path, article
from ...numerics.scalar import hypot
from ..bodies import ELASTIC, MOST_ELEMENTS, MOST_IN_ALL, Frame, Link, RigidBody, Section
from ..lumping import rigid_properties
from .checks import Checks, ends, entries_of, neighbours_of, reached, readable


def check_bodies(checks: Checks) -> None:
    """Check every body."""
    if "ground" in checks.bodies:
        checks.add(
            ("body", "ground"), '"ground" is reserved for the fixed frame', "choose another name for the body"
        )
    check_all(checks)
    for name, body in readable(checks.bodies):
        path: Path = ("body", name)
        for pin in entries_of(body, "pins"):
            if pin in ("center", *body.own_points):
                checks.add(
                    (*path, "pins", pin), "the body has a pin of this name already", "choose another name"
                )
        if isinstance(body, Link | RigidBody):
            check_masses(checks, path, body)
        if isinstance(body, Link):
            check_section(checks, (*path, "section"), body.section)
            check_link(checks, name, body)
            check_way(checks, path, body)
        elif isinstance(body, Frame):
            check_section(checks, (*path, "section"), body.section)
            check_frame(checks, path, body)
        driver = checks.drivers.get(checks.turned.get(name, ""))
        if (
            any(body.velocity or ()) and driver is not None and driver.against == "ground"
        ):  # against another body only their difference is set
            checks.add(
                (*path, "velocity"),
                "a driven body has no initial velocity of its own",
                "remove it; the driver sets the velocity",
            )


def check_masses(checks: Checks, path: Path, body: Any) -> None:
    """Check that attached masses are at pins, and that the body has a mass and an inertia or an arm."""
    points = (
        {"center", *body.own_points, *entries_of(body, "pins")}
        if isinstance(body, RigidBody)
        else {"start", "end", *entries_of(body, "pins")}
    )
    for pin in body.masses or ():
        if pin not in points:
            checks.add(
                (*path, "masses", pin),
                f"there is no pin {pin!r}",
                checks.name_hint(pin, points, "name a pin"),
            )
            return
    if body.mass != 0.0 and not (isinstance(body, RigidBody) and body.inertia == 0.0):
        return
    if isinstance(body, Link) and body.model in ELASTIC:
        checks.add(
            (*path, "mass"),
            f"{article(body.model)} link needs a mass",
            "give it one, or leave it out for that of its section",
        )
        return
    try:
        rigid_properties(body)
    except ValueError as error:
        problem, _, remedy = str(error).partition(": ")
        checks.add((*path, "mass"), problem, remedy)
    except TypeError:  # a field that it needs is invalid, which has its own fault
        return


def check_link(checks: Checks, name: str, body: Any) -> None:
    """Check that a link has what its model needs."""
    path: Path = ("body", name)
    no_section = body.section is None and not checks.fails((*path, "section"))
    if body.model in ELASTIC and no_section:
        remedy = "add section = { area = ..., second_moment = ... } or { square = ... }"
        checks.add(
            (*path, "section"), f"{article(body.model)} link needs a section, which is missing", remedy
        )
    elif body.mass is None and no_section and not checks.fails((*path, "mass")):
        checks.add((*path, "mass"), "the link has neither a mass nor a section", "add one of the two")
    end = driven_end(checks, name) if body.model in ELASTIC else ""
    if end and body.release in (end, "both"):
        remedy = f'set model = "rigid", or release the other end only: the driver turns {name}.{end}'
        checks.add((*path, "release"), "no driver can turn a link by an end that is released", remedy)


def driven_end(checks: Checks, name: str) -> str:
    """Return the end of a link that a driver turns, or ""."""
    driver = checks.drivers.get(checks.turned.get(name, ""))
    if driver is None or driver.against != "ground":
        return ""
    for joint in checks.pivots.get(name, [])[:1]:
        for side in ends(checks.joints[joint]):
            body, _, pin = side.partition(".")
            if body == name:
                return pin
    return ""


def check_section(checks: Checks, path: Path, section: Section | None) -> None:
    """Check that the outermost fibre is not inside the radius of gyration."""
    if section is None or None in (section.area, section.second_moment, section.extreme_fibre):
        return
    reach, fibre = math.sqrt(section.second_moment / section.area), section.extreme_fibre
    if fibre is not None and fibre < (1.0 - 1e-9) * reach:
        limit = f"at least sqrt(second_moment/area) = {reach:.4g} m"
        remedy = "check the units of all three: no fibre would be as far out as the mean"
        checks.add((*path, "extreme_fibre"), "below the section's radius of gyration", remedy, limit)


def check_way(checks: Checks, path: Path, body: Any) -> None:
    """Check that the points of a bent link differ and that each piece has an element."""
    if not body.via or body.length is None:
        return
    corners, pieces = body.corners, len(body.via) + 1
    for k, (first, second) in enumerate(zip(corners, corners[1:], strict=False)):
        if coincide(first, second, body.length):
            names = ["the start", *(f"via[{j}]" for j in range(len(body.via))), "the end"]
            checks.add(
                (*path, "via"),
                f"{names[k]} and {names[k + 1]} coincide: a piece of the link has no length",
                "move or remove one",
            )
    if body.model == "elastic" and body.elements is not None and body.elements < pieces:
        limit = f"at least {pieces}, one for each piece between start, via and end"
        checks.add(
            (*path, "elements"),
            f"{body.elements} element{'s' * (body.elements > 1)} for {pieces} pieces",
            "raise it",
            limit,
        )


def coincide(first: Any, second: Any, size: float) -> bool:
    """Return whether the distance of two points is negligible compared with ``size``."""
    return hypot(first[0] - second[0], first[1] - second[1]) <= 1e-9 * abs(size)


def check_frame(checks: Checks, path: Path, body: Any) -> None:
    """Check that members connect different nodes that exist, form one structure, and are not too many."""
    nodes: dict[str, Any] = body.nodes or {}
    for name in body.masses or ():
        if body.nodes is not None and name not in nodes:
            checks.add(
                (*path, "masses", name),
                f"there is no node {name!r}",
                checks.name_hint(name, nodes, "name a node"),
            )
    if body.members is None:
        return
    if not body.members:
        checks.add(
            (*path, "members"), "a frame has one member at least", 'add one, as in { start = "A", end = "B" }'
        )
    size = max((abs(part) for place in nodes.values() if place is not None for part in place), default=0.0)
    joined: dict[frozenset[str], int] = {}
    for k, member in enumerate(body.members):
        if member is not None:
            check_member(checks, (*path, "members", k), member, body, size, joined)
    check_total(checks, path, body.members)
    loose = unreached([pair for pair in joined if len(pair) == 2], list(nodes))
    if loose and all(
        member is not None and {member.start, member.end} <= set(nodes) for member in body.members
    ):
        listed = ", ".join(loose[:6]) + (", ..." if len(loose) > 6 else "")
        remedy = "add a member that leads there, remove the node, or make it a body of its own"
        checks.add(
            (*path, "nodes"),
            f"the frame is not connected: no members lead from {next(iter(nodes))} to {listed}",
            remedy,
        )


def check_member(
    checks: Checks, path: Path, member: Any, frame: Any, size: float, joined: dict[frozenset[str], int]
) -> None:
    """Check that a member has a length and a section, and is not a duplicate; ``joined`` has the pairs of
    nodes so far.
    """
    check_section(checks, (*path, "section"), member.section)
    if (
        member.section is None
        and frame.section is None
        and not (checks.fails((*path, "section")) or checks.fails((*path[:2], "section")))
    ):
        checks.add(
            (*path, "section"),
            "neither the member nor the frame has a section",
            "add section = { ... } to the frame",
        )
    nodes: dict[str, Any] = frame.nodes or {}
    for key, end in (("start", member.start), ("end", member.end)):
        if end is not None and frame.nodes is not None and end not in nodes:
            checks.add(
                (*path, key),
                f"there is no node {end!r}",
                checks.name_hint(end, nodes, "name a node, or add it"),
            )
    start, end = member.start, member.end
    if start not in nodes or end not in nodes:
        return
    first_point, second_point = nodes[start], nodes[end]
    if start == end or (
        first_point is not None and second_point is not None and coincide(first_point, second_point, size)
    ):
        ends_text = "at one node" if start == end else f"at nodes {start} and {end}, which are in one place"
        checks.add(
            (*path, ""),
            f"the member has no length: it starts and ends {ends_text}",
            "name another node, or move one",
        )
    k = int(path[-1])
    first = joined.setdefault(frozenset((start, end)), k)
    if first != k:
        checks.add((*path, ""), f"members[{first}] joins {start} and {end} already", "remove one of the two")


def check_all(checks: Checks) -> None:
    """Check the number of elements of all bodies."""
    counts = {name: elements_of(body) for name, body in readable(checks.bodies)}
    total = sum(counts.values())
    if total > MOST_IN_ALL and max(counts.values()) <= MOST_ELEMENTS:
        name = max(counts, key=lambda body: counts[body])
        remedy = "take fewer elements in each, or a rigid body where none is needed"
        checks.add(
            ("body", name),
            f"{total:,} elements in all bodies together are too many",
            remedy,
            f"at most {MOST_IN_ALL:,}",
        )


def elements_of(body: Any) -> int:
    """Return the number of elements of a body, which may be known in part."""
    if isinstance(body, Frame):
        members: Any = body.members or ()
        counts: list[int] = [member.elements or 0 for member in members if member is not None]
        return sum(counts)
    return int(body.elements or 0) if isinstance(body, Link) and body.model == "elastic" else 0


def check_total(checks: Checks, path: Path, members: Any) -> None:
    """Check the number of elements of all members of a frame."""
    total = sum(member.elements or 0 for member in members if member is not None)
    if total > MOST_ELEMENTS:
        problem = f"{total:,} elements in all members together are too many"
        checks.add(
            (*path, "members"), problem, "take fewer elements in each", f"at most {MOST_ELEMENTS:,} in a body"
        )


def unreached(members: list[frozenset[str]], nodes: list[str]) -> list[str]:
    """Return the nodes that no sequence of members connects with the first."""
    connected = reached(neighbours_of(nodes, members), nodes[0]) if nodes else set()
    return [node for node in nodes if node not in connected]
