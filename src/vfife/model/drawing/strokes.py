"""Drawings of joints, gears and springs as data: strokes in the plane of the drawing, rendered without
knowledge of kinds.

Positions and lengths are in units of the drawing; sizes of the model (m) are multiplied by ``factor``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

Colour = Literal["ink", "grey", "spring", "bearing", "journal"]
Shape = Literal["ring", "dot", "pin", "square", "bearing"]
COILS = 7
GROUND_DEPTH = 0.065  # of the sign for the ground, as a share of the drawing
BLOCK = (0.06, 0.036)  # length and height of an ideal slider's block, as shares of the drawing


@dataclass(frozen=True, eq=False)
class Curve:
    """A line through points (n, 2); ``sign`` is its entry in the legend."""

    points: Any
    colour: Colour = "ink"
    width: float = 1.2
    rank: float = 5.0
    dashes: Literal["-", "-.", ":"] = "-"
    fade: float = 1.0
    sign: str = ""


@dataclass(frozen=True, eq=False)
class Surface:
    """A straight surface, hatched to a ``depth`` on the side of ``inward``."""

    first: Array
    second: Array
    inward: Array
    depth: float


@dataclass(frozen=True, eq=False)
class Block:
    """A rectangle whose length is parallel to the unit vector ``direction``."""

    centre: Array
    direction: Array
    length: float
    height: float
    colour: Colour = "journal"
    sign: str = ""


@dataclass(frozen=True, eq=False)
class Mark:
    """A symbol of constant size at a place, or in the legend only."""

    at: Array | None
    shape: Shape
    colour: Colour = "ink"
    sign: str = ""


@dataclass(frozen=True, eq=False)
class Label:
    """Place of a name: exactly there if ``fixed``, else beside it, away from the middle of the drawing."""

    at: Array
    fixed: bool = False


Stroke = Curve | Surface | Block | Mark


class Extent(NamedTuple):
    """Space (m) that a drawing leaves for a joint: points in the bearing's frame from its pin, and radii
    around the two pins; None leaves one out.
    """

    points: tuple[tuple[float, float], ...] = ()
    bearing: float | None = 0.0
    journal: float = 0.0


@dataclass(frozen=True, eq=False)
class JointView:
    """A joint in a drawing: positions of its pins, present and start angles (rad) of its bodies, and which
    sides belong to the ``ground``.

    ``size`` is that of the drawing. ``way`` maps a direction (rad) in the bearing's frame to the least and
    largest travel of the journal along it during the run; ``leaving`` returns the one of the four axis
    directions in which a body leaves the ground.
    """

    bearing: Array
    journal: Array
    angles: tuple[float, float]
    start_angles: tuple[float, float]
    ground: tuple[bool, bool]
    factor: float
    size: float
    way: Callable[[float], tuple[float, float]]
    leaving: Callable[[], Array]

    def unit_vector(self, direction: tuple[float, float]) -> Array:
        """Return the unit vector, in the drawing, of a direction in the bearing's frame."""
        return facing(self.angles[0] + math.atan2(direction[1], direction[0]))

    def space(self, points: Any) -> Array:
        """Return points (n, 2) in m, in the bearing's frame from its pin, in units of the drawing."""
        x, y = self.factor * np.asarray(points, dtype=float).T
        c, s = facing(self.angles[0])
        return np.asarray(self.bearing + np.stack([c * x - s * y, s * x + c * y], axis=1), dtype=float)


@dataclass(frozen=True, eq=False)
class PairView:
    """A spring or gear in a drawing: positions of its two ends (of a body: its axis), angle (rad) of the
    first body, size of the drawing.
    """

    first: Array
    second: Array
    angle: float
    size: float


def facing(angle: float) -> Array:
    """Return the unit vector at an angle (rad)."""
    return np.array([math.cos(angle), math.sin(angle)])


def left_of(vector: Array) -> Array:
    """Return a vector turned anticlockwise by a right angle."""
    return np.array([-vector[1], vector[0]])


def ring(centre: Array, radius: float, **look: Any) -> Curve:
    """Return a circle."""
    turn = np.linspace(0.0, 2.0 * np.pi, 121)
    return Curve(centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1), **look)


def ground_symbol(view: JointView) -> list[Stroke]:
    """Return the symbol of the ground at a joint: a triangle on a hatched strip; nothing if neither side is
    ground.
    """
    if not any(view.ground):
        return []
    x, y = view.bearing if view.ground[0] else view.journal
    half, tall, deep = (part * view.size for part in (0.028, 0.045, GROUND_DEPTH))
    corners = [(x, y), (x - half, y - tall), (x + half, y - tall), (x, y)]
    strip = np.array([x - 1.6 * half, y - tall]), np.array([x + 1.6 * half, y - tall])
    return [Curve(corners, rank=2.0), Surface(*strip, np.array([0.0, -1.0]), deep - tall)]


def name_place(view: JointView) -> Label:
    """Return a place for the name of a pin: below the ground symbol, else beside the pin."""
    if not view.ground[0]:
        return Label(view.journal)
    return Label(view.bearing - np.array([0.0, (GROUND_DEPTH + 0.03) * view.size]), fixed=True)


def rails(view: JointView, direction: tuple[float, float], length: float, gap: float) -> list[Stroke]:
    """Return two rails along the travel of the journal, hatched outside if the guide belongs to the
    ground.
    """
    direction_vector = view.unit_vector(direction)
    across, reach = left_of(direction_vector), view.way(math.atan2(direction[1], direction[0]))
    ends = [
        view.bearing + (reach[0] - 0.8 * length) * direction_vector,
        view.bearing + (reach[1] + 0.8 * length) * direction_vector,
    ]
    strokes: list[Stroke] = []
    for side in (1.0, -1.0):
        rail = [end + side * gap * across for end in ends]
        if view.ground[0]:
            strokes.append(Surface(rail[0], rail[1], side * across, 0.02 * view.size))
        else:
            strokes.append(Curve(rail, "bearing", 1.6, 3.5))
    return strokes


def side_label(view: JointView, direction: tuple[float, float], gap: float) -> Label:
    """Return a place for the name of a guide: above its upper rail, or to the right of a vertical one."""
    across = left_of(view.unit_vector(direction))
    across = across * (1.0 if across[1] > 0.3 or (abs(across[1]) <= 0.3 and across[0] > 0.0) else -1.0)
    return Label(view.journal + (gap + (0.05 + 0.03 * abs(across[0])) * view.size) * across, fixed=True)


def zigzag(first: Array, second: Array, width: float) -> Array:
    """Return the corners of a spring between two points, shape (corners, 2), with a straight eighth at each
    end.
    """
    span = second - first
    across = left_of(span) / (np.linalg.norm(span) or 1.0) * width
    shares = np.concatenate([[0.0, 0.125], np.linspace(0.125, 0.875, 2 * COILS + 1)[1:-1], [0.875, 1.0]])
    sides = np.zeros(len(shares))
    sides[2:-2] = np.where(np.arange(len(shares) - 4) % 2 == 0, 1.0, -1.0)
    return np.asarray(first + shares[:, None] * span + sides[:, None] * across, dtype=float)


def tangent(first: tuple[Array, float], second: tuple[Array, float], side: float) -> Array:
    """Return the ends of the outer tangent of two circles on one side, shape (2, 2)."""
    (p, r), (q, s) = first, second
    axis = (q - p) / (np.linalg.norm(q - p) or 1.0)
    sine = (r - s) / (np.linalg.norm(q - p) or 1.0)
    n = sine * axis + np.sqrt(max(0.0, 1.0 - sine**2)) * side * left_of(axis)
    return np.array([p + r * n, q + s * n])
