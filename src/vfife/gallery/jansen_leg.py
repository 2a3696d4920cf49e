"""Theo Jansen's leg: eleven numbers that make a foot walk in a nearly straight line."""

from __future__ import annotations

import math

from ..model.mechanism import Mechanism, Settings
from ..numerics.scalar import distance

# Jansen's "eleven holy numbers", a to k, with the height l of the crank's axis over the frame's pivot and the crank m.
HOLY = {
    "a": 38.0, "b": 41.5, "c": 39.3, "d": 40.1, "e": 55.8, "f": 39.4, "g": 36.7, "h": 65.7, "i": 49.0, "j": 50.0, "k": 61.9, "l": 7.8, "m": 15.0,
}  # fmt: skip


def jansen_leg(*, unit: float = 0.01, speed: float = 2.0 * math.pi, turns: float = 1.0, density: float = 0.5) -> Mechanism:
    """One leg: rods of ``density`` (kg/m), plates of the same density along their edges; ``unit`` (m) is that of the holy numbers, speed in rad/s.

    Source: T. Jansen, The Great Pretender, 010 Publishers, Rotterdam 2007.
    """
    n = {name: unit * size for name, size in HOLY.items()}
    m = Mechanism("Jansen leg", gravity=(0.0, -9.81), settings=Settings(turns=turns))
    m.point("crank", 0.0, 0.0)
    m.point("frame", -n["a"], -n["l"])
    m.link("crank", length=n["m"], mass=density * n["m"])
    for name, letter, angle in (("upper-rod", "j", 141.0), ("lower-rod", "k", -133.0), ("strut", "c", -74.0), ("tie", "f", -67.0)):
        m.link(name, length=n[letter], mass=density * n[letter], angle=math.radians(angle))
    frame, knee = (-n["a"], -n["l"]), (-27.0 * unit, -45.5 * unit)
    _plate(m, "shoulder", (n["b"], n["d"], n["e"]), frame, math.radians(70.0), density)
    _plate(m, "foot", (n["g"], n["i"], n["h"]), knee, math.radians(152.0), density)
    for name, bearing, journal in (
        ("O", "ground.crank", "crank.start"), ("J", "crank.end", "upper-rod.start"), ("K", "crank.end", "lower-rod.start"),
        ("B", "upper-rod.end", "shoulder.second"), ("D", "ground.frame", "shoulder.first"), ("C", "ground.frame", "strut.start"),
        ("F", "shoulder.third", "tie.start"), ("G", "lower-rod.end", "strut.end"), ("H", "strut.end", "foot.first"),
        ("I", "tie.end", "foot.second"),
    ):  # fmt: skip
        m.revolute(name, bearing, journal)
    m.drive("crank", speed=speed)
    return m


def _plate(m: Mechanism, name: str, sides: tuple[float, float, float], at: tuple[float, float], angle: float, density: float) -> None:
    """A triangle of rods, corners anticlockwise: first to second, first to third, second to third (m); mass, centre and inertia are exact."""
    base, left, right = sides
    x = (base * base + left * left - right * right) / (2.0 * base)
    corners = {"first": (0.0, 0.0), "second": (base, 0.0), "third": (x, math.sqrt(left * left - x * x))}
    edges = [
        (density * distance(corners[i], corners[j]), corners[i], corners[j])
        for i, j in (("first", "second"), ("first", "third"), ("second", "third"))
    ]
    mass = sum(edge[0] for edge in edges)
    cx, cy = (sum(m * 0.5 * (a[k] + b[k]) for m, a, b in edges) / mass for k in (0, 1))
    inertia = 0.0
    for weight, a, b in edges:
        length, x, y = distance(a, b), 0.5 * (a[0] + b[0]) - cx, 0.5 * (a[1] + b[1]) - cy
        inertia += weight * (length * length / 12.0 + x * x + y * y)
    m.rigid_body(name, mass=mass, inertia=inertia, center=(cx, cy), position=at, angle=angle, pins=corners)
