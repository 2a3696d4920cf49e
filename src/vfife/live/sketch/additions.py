"""Operations that add parts to a mechanism: points, pins, links, joints, forces, drivers."""

from __future__ import annotations

import math
import statistics
import string
from typing import Any

from ...model.bodies import Link, RigidBody
from .edit import Edit, angle, finite, length_unit, refusal, resolution, unused
from .pose import Point, Side

MASS_PER_LENGTH = 1.0  # kg/m of a link in a mechanism that has no other
FORCE = 10.0  # N of a new force


def add_point(edit: Edit, x: float, y: float) -> None:
    """Add a point of the ground at (x, y) in m."""
    edit.raw.setdefault("ground", {})[letter(edit)] = edit.place(finite(x, y))


def add_pin(edit: Edit, body: str, x: float, y: float) -> None:
    """Add a pin to a rigid body at (x, y) in m, where the body is at the start."""
    entry, part = edit.entry("body", body), edit.mechanism.bodies[body]
    if not isinstance(part, RigidBody) and not (isinstance(part, Link) and part.model == "rigid"):
        raise refusal(f"{body} is not rigid and has no further pins", "add the pin to a rigid body")
    pins = entry.setdefault("pins", {})
    pins[unused("P", part.points)] = edit.place(edit.pose.local(body, finite(x, y)))


def add_bar(edit: Edit, start: Any, end: Any) -> None:
    """Add a link from ``start`` to ``end``, each a pin, to which an ideal joint holds it, or a place [x, y]
    in m, where it is free.

    The link has the mass per length of the other links.
    """
    ends = [_end(edit, start), _end(edit, end)]
    length = math.dist(ends[0][1], ends[1][1])
    if length < resolution(edit.pose.size):
        raise refusal("the link would have no length", "choose two different places")
    name = edit.name("body", "bar")
    (x, y), (tx, ty) = ends[0][1], ends[1][1]
    bar: dict[str, Any] = {"length": edit.length(length), "mass": _mass(edit, length)}
    if turned := math.atan2(ty - y, tx - x):
        bar["angle"] = angle(turned, None)
    sides = distinct_sides(ends[0][0], ends[1][0])
    if sides == [None, None]:
        bar["position"] = edit.place((x, y))
    edit.raw.setdefault("body", {})[name] = bar
    for side, pin in zip(sides, ("start", "end"), strict=True):
        if side is not None:
            _join(edit, side, (name, pin))


def add_joint(edit: Edit, first: str, second: str) -> None:
    """Join two pins by an ideal joint; pins that are apart come together."""
    clusters = [edit.pose.cluster(edit.side(pin)) for pin in (first, second)]
    if set(clusters[0]) & set(clusters[1]):
        raise refusal(f"{first} and {second} are joined already", "choose pins of different bodies")
    first_side, second_side = distinct_sides(*clusters)
    if first_side is not None and second_side is not None:
        _join(edit, *((second_side, first_side) if second_side[0] == "ground" else (first_side, second_side)))


def anchor(edit: Edit, point: str) -> None:
    """Hold a pin on the ground, where it is at the start, by an ideal joint."""
    side, name = _free_of_ground(edit, point), letter(edit)
    edit.raw.setdefault("ground", {})[name] = edit.place(edit.pose.place(side))
    _join(edit, ("ground", name), side, name)


def add_slider(edit: Edit, point: str) -> None:
    """Guide a pin horizontally through its place at the start. A body other than a link keeps its angle."""
    side, name = _free_of_ground(edit, point), letter(edit)
    edit.raw.setdefault("ground", {})[name] = edit.place(edit.pose.place(side))
    turning = {"turning": True} if isinstance(edit.mechanism.bodies[side[0]], Link) else {}
    _join(edit, ("ground", name), side, name, {"kind": "slider", **turning})


def add_load(edit: Edit, point: str) -> None:
    """Add a force of 10 N downwards at a pin of a body."""
    sides = [side for side in edit.pose.cluster(edit.side(point)) if side[0] != "ground"]
    if not sides:
        raise refusal("a force on the ground moves nothing", "choose a pin of a body")
    size = [0, f"{-FORCE:g} N"] if length_unit(edit.raw) else [0.0, -FORCE]
    load = {"at": ".".join(sides[0]), "force": size}
    edit.raw.setdefault("load", {})[edit.name("load", "force")] = load


def drive(edit: Edit, body: str) -> None:
    """Turn a body at 60 rpm against the ground."""
    edit.entry("body", body)
    name = edit.name("driver", body)
    driver = {"speed": "60 rpm"} if name == body else {"body": body, "speed": "60 rpm"}
    edit.raw.setdefault("driver", {})[name] = driver


# ------------------------------------------------------------------------------------------- names, ends


def letter(edit: Edit) -> str:
    """Return the first capital letter that names neither a joint nor a point of the ground."""
    names = {**edit.raw.get("joint", {}), **edit.raw.get("ground", {})}
    return next((capital for capital in string.ascii_uppercase if capital not in names), None) or unused(
        "P", names
    )


def distinct_sides(first: tuple[Side, ...], second: tuple[Side, ...]) -> list[Side | None]:
    """Return a pin of each of two clusters, of different bodies where possible and the ground first; None of
    an empty cluster.
    """
    first_sides, second_sides = (
        sorted(cluster, key=lambda side: side[0] != "ground") for cluster in (first, second)
    )
    pairs = ((a, b) for a in first_sides for b in second_sides if a[0] != b[0])
    return list(
        next(pairs, (first_sides[0] if first_sides else None, second_sides[0] if second_sides else None))
    )


def _end(edit: Edit, end: Any) -> tuple[tuple[Side, ...], Point]:
    """Return the pins that meet in an end of a new link, none in a free place, and the place (m)."""
    if isinstance(end, list) and len(end) == 2:
        x, y = finite(*end)
        return (), (x, y)
    side = edit.side(end)
    return edit.pose.cluster(side), edit.pose.place(side)


def _join(
    edit: Edit, bearing: Side, journal: Side, name: str = "", kind: dict[str, Any] | None = None
) -> None:
    joint = {**(kind or {}), "bearing": ".".join(bearing), "journal": ".".join(journal)}
    edit.raw.setdefault("joint", {})[name or letter(edit)] = joint


def _free_of_ground(edit: Edit, point: str) -> Side:
    """Return a pin that no joint holds on the ground. Raises ModelError."""
    cluster = edit.pose.cluster(edit.side(point))
    if any(body == "ground" for body, _ in cluster):
        raise refusal(f"{point} is on the ground already", "choose a pin that moves")
    return cluster[0]


def _mass(edit: Edit, length: float) -> Any:
    """Return the mass of a new link of a length (m), as it is written."""
    links = [body for body in edit.mechanism.bodies.values() if isinstance(body, Link)]
    masses_per_length = [link.own_mass / link.path_length for link in links if link.own_mass] or [
        MASS_PER_LENGTH
    ]
    value = float(f"{statistics.median(masses_per_length) * length:.2g}")
    return f"{value:g} kg" if length_unit(edit.raw) else value
