"""Checks of bodies: keys that go together, sections, the points of a bent link, the members of a frame."""

from __future__ import annotations

import math
from typing import Any

from ..errors import Path
from .checks import Checks, article, moves, sides
from .schema import MOST_ELEMENTS, body_kind
from .tables import IDLE_KEYS, Raw, amount, amounts, own_pins, table, text

SHAPES = ("square", "rectangle", "round", "tube")
ELASTIC = ("elastic", "two-particle")


def check_body(checks: Checks, name: str, body: Raw) -> None:
    """Keys that go together, and names of materials and pins."""
    path: Path = ("body", name)
    checks.material(path, body)
    for pin in table(body, "pins"):
        if pin in ("center", *own_pins(body)):
            checks.add((*path, "pins", pin), "the body has a pin of this name already", "call it otherwise")
    kind = body_kind(body)
    if isinstance(body.get("section"), dict):
        check_section(checks, (*path, "section"), body["section"])
    if kind == "<link>":
        check_link(checks, name, body, body.get("model", "rigid"))
        check_way(checks, path, body)
    elif kind == "<frame>":
        check_frame(checks, path, body)
    if moving(body.get("velocity")) and name in checks.turned:
        checks.add((*path, "velocity"), "a driven body has no initial velocity of its own", "remove it; the driver sets the velocity")


def check_link(checks: Checks, name: str, body: Raw, model: Any) -> None:
    """What the model of a link needs, and what it has no use for."""
    for key in IDLE_KEYS.get(model, ()) if isinstance(model, str) else ():
        if key in body:
            users = " or ".join(other for other, idle in IDLE_KEYS.items() if key not in idle)
            checks.add(("body", name, key), f"{article(model)} link has no use for this", f"remove it, or set model to {users}")
    if model in ELASTIC and "section" not in body:
        remedy = "add section = { area = ..., second_moment = ... } or { square = ... }"
        checks.add(("body", name, "section"), f"{article(model)} link needs a section, which is missing", remedy)
    elif "mass" not in body and "section" not in body:
        checks.add(("body", name, "mass"), "the link has neither a mass nor a section", "add one of the two")
    release, held = body.get("release", "none"), driven_end(checks, name)
    if model in ELASTIC and held and release in (held, "both"):
        remedy = f'set model = "rigid", or release the other end only: the driver turns {name}.{held}'
        checks.add(("body", name, "release"), "no driver can turn a link by an end that is released", remedy)


def driven_end(checks: Checks, name: str) -> str:
    """The end of a link that a driver turns, or nothing."""
    driver = checks.drivers.get(checks.turned.get(name, ""), {})
    if not moves(driver) or text(driver, "against", "ground") != "ground":
        return ""
    for joint in checks.pivots.get(name, [])[:1]:
        for side in sides(checks.joints[joint]):
            body, _, pin = side.partition(".")
            if body == name:
                return pin
    return ""


def check_section(checks: Checks, path: Path, section: Raw) -> None:
    """Area and second moment, or exactly one shape, and numbers that a section can have."""
    shapes = [key for key in SHAPES if key in section]
    both = {"area", "second_moment"} & set(section)
    if not ((len(shapes) == 1 and not both) or (not shapes and len(both) == 2)):
        what = "the section is described more than once" if shapes else "the section is not complete"
        limit = "area and second_moment together, or one of " + ", ".join(SHAPES)
        checks.add(path, what, "give one of these", limit)
        return
    if shapes and "extreme_fibre" in section:
        checks.add((*path, "extreme_fibre"), f"{article(shapes[0])} section knows its outermost fibre", "remove it")
    diameters = amounts(section.get("tube"), ("m", "m"))
    if diameters is not None and 0.0 < diameters[0] <= diameters[1]:
        what = "the inner diameter is not below the outer one: no wall is left"
        checks.add((*path, "tube"), what, "give the outer diameter first", f"inner below outer = {diameters[0]:g} m")
    area, bending, fibre = amount(section, "area", "m^2"), amount(section, "second_moment", "m^4"), amount(section, "extreme_fibre", "m")
    if area and bending and fibre and min(area, bending, fibre) > 0.0 and fibre < (1.0 - 1e-9) * math.sqrt(bending / area):
        limit = f"at least sqrt(second_moment/area) = {math.sqrt(bending / area):.4g} m"
        remedy = "check the units of all three: no fibre would be as far out as the mean"
        checks.add((*path, "extreme_fibre"), "below the section's radius of gyration", remedy, limit)


def check_way(checks: Checks, path: Path, body: Raw) -> None:
    """The points of a bent link differ from each other, and each piece has an element."""
    via, length = body.get("via"), amount(body, "length", "m")
    if not isinstance(via, list) or not via or length is None:
        return
    corners = [(0.0, 0.0), *(amounts(point, ("m", "m")) for point in via), (length, 0.0)]
    for k, (one, two) in enumerate(zip(corners, corners[1:], strict=False)):
        if one is not None and two is not None and coincide(one, two, length):
            ends = ["the start", *(f"via[{j}]" for j in range(len(via))), "the end"]
            checks.add((*path, "via"), f"{ends[k]} and {ends[k + 1]} coincide: a piece of the link has no length", "move or remove one")
    elements = body.get("elements", 4)
    if body.get("model") == "elastic" and isinstance(elements, int) and not isinstance(elements, bool) and 0 < elements < len(via) + 1:
        limit = f"at least {len(via) + 1}, one for each piece between start, via and end"
        checks.add((*path, "elements"), f"{elements} element{'s' * (elements > 1)} for {len(via) + 1} pieces", "raise it", limit)


def coincide(one: tuple[float, ...], two: tuple[float, ...], size: float) -> bool:
    """Whether two points are in one place, compared with a size."""
    return math.hypot(one[0] - two[0], one[1] - two[1]) <= 1e-9 * abs(size)


def check_frame(checks: Checks, path: Path, body: Raw) -> None:
    """Members join nodes that exist and differ, hold together, and are not too many."""
    nodes, members = table(body, "nodes"), body.get("members")
    places = {name: amounts(point, ("m", "m")) for name, point in nodes.items()}
    for name in table(body, "masses"):
        if name not in nodes:
            checks.add((*path, "masses", name), f"there is no node {name!r}", checks.near(name, nodes, "name a node"))
    if not isinstance(members, list):
        return
    if not members:
        checks.add((*path, "members"), "a frame has one member at least", 'add one, as in { start = "A", end = "B" }')
    known = [place for place in places.values() if place is not None]
    size = max((abs(part) for place in known for part in place), default=0.0)
    joined: dict[frozenset[str], int] = {}
    for k, member in enumerate(members):
        if isinstance(member, dict):
            check_member(checks, (*path, "members", k), member, body, places, size, joined)
    check_total(checks, path, members)
    loose = apart([one for one in joined if len(one) == 2], list(nodes))
    if loose and all(isinstance(one, dict) and {text(one, "start"), text(one, "end")} <= set(nodes) for one in members):
        listed = ", ".join(loose[:6]) + (", ..." if len(loose) > 6 else "")
        remedy = "add a member that leads there, remove the node, or make it a body of its own"
        checks.add((*path, "nodes"), f"the frame falls apart: no members lead from {next(iter(nodes))} to {listed}", remedy)


def check_member(
    checks: Checks,
    path: Path,
    member: Raw,
    frame: Raw,
    places: dict[str, tuple[float, ...] | None],
    size: float,
    joined: dict[frozenset[str], int],
) -> None:
    """A member joins two nodes in different places, has a section, and is no member's double."""
    checks.material(path, member)
    if isinstance(member.get("section"), dict):
        check_section(checks, (*path, "section"), member["section"])
    elif "section" not in member and "section" not in frame:
        checks.add((*path, "section"), "neither the member nor the frame has a section", "add section = { ... } to the frame")
    ends = [member.get(key) for key in ("start", "end")]
    for key, end in zip(("start", "end"), ends, strict=True):
        if isinstance(end, str) and end not in places:
            checks.add((*path, key), f"there is no node {end!r}", checks.near(end, places, "name a node, or add it"))
    start, end = ends
    if not (isinstance(start, str) and isinstance(end, str) and start in places and end in places):
        return
    one, two = places[start], places[end]
    if start == end or (one is not None and two is not None and coincide(one, two, size)):
        where = "at one node" if start == end else f"at nodes {start} and {end}, which are in one place"
        checks.add((*path, ""), f"the member has no length: it starts and ends {where}", "name another node, or move one")
    first = joined.setdefault(frozenset((start, end)), path[-1] if isinstance(path[-1], int) else 0)
    if first != path[-1]:
        checks.add((*path, ""), f"members[{first}] joins {start} and {end} already", "remove one of the two")


def check_total(checks: Checks, path: Path, members: list[Any]) -> None:
    """The elements of all members together are not too many."""
    counts = [member.get("elements", 1) for member in members if isinstance(member, dict)]
    total = sum(count for count in counts if isinstance(count, int) and 0 < count <= MOST_ELEMENTS)
    if total > MOST_ELEMENTS:
        what = f"{total:,} elements in all members together are too many"
        checks.add((*path, "members"), what, "take fewer elements in each", f"at most {MOST_ELEMENTS:,} in a body")


def apart(members: list[frozenset[str]], nodes: list[str]) -> list[str]:
    """Nodes that no members lead to from the first."""
    beside: dict[str, list[str]] = {node: [] for node in nodes}
    for pair in members:
        one, two = pair
        beside[one].append(two)
        beside[two].append(one)
    reached, waiting = set(nodes[:1]), nodes[:1]
    while waiting:
        for node in beside[waiting.pop()]:
            if node not in reached:
                reached.add(node)
                waiting.append(node)
    return [node for node in nodes if node not in reached]


def moving(velocity: Any) -> bool:
    """Whether a velocity has a part that is not zero."""
    parts = zip(velocity, ("m/s", "m/s", "rad/s"), strict=False) if isinstance(velocity, list) else ()
    return any(amount({"v": value}, "v", unit) for value, unit in parts)
