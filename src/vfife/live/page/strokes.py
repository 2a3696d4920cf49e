"""Strokes as a page draws them: each point with the pin that carries it, the body that turns it, and its
place there.

Nouns say how they are drawn for one place of their pins (``model.strokes``). What they say is affine in the
places of the two pins, in the size of the drawing and in the way of a journal in its guide; so asking them
again with each of these moved a little tells what each point hangs on, and no kind of joint or spring needs
to be known.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model.drawing.strokes import Block, Curve, JointSeen, Mark, PairSeen, Stroke, Surface, facing

Array = NDArray[np.float64]
MOVED = 0.25  # by what is asked again: m, rad, or times the size
FIRST, SECOND, BETWEEN = range(3)  # what carries a point: the first pin, the second, both
GLOBAL, FIRST_TURNS, SECOND_TURNS = range(3)  # what turns it


@dataclass(frozen=True)
class Asked:
    """What a noun is asked with: places and angles of its two pins, size of the drawing, way of the journal."""

    first: tuple[float, float]
    second: tuple[float, float]
    angles: tuple[float, float]
    size: float
    way: tuple[float, float] = (0.0, 0.0)

    def moved(self, what: str) -> Asked:
        """The same with one of them moved."""
        changes: dict[str, dict[str, Any]] = {
            "first": {"first": (self.first[0] + MOVED, self.first[1])},
            "second": {"second": (self.second[0] + MOVED, self.second[1])},
            "turn_first": {"angles": (self.angles[0] + MOVED, self.angles[1])},
            "turn_second": {"angles": (self.angles[0], self.angles[1] + MOVED)},
            "size": {"size": self.size * (1.0 + 1e-6)},
            "low": {"way": (-MOVED, 0.0)},
            "high": {"way": (0.0, MOVED)},
        }
        return replace(self, **changes[what])


Drawn = Callable[[Asked], list[Stroke]]


def of_joint(
    joint: Any, at: Asked, start: tuple[float, float], ground: tuple[bool, bool]
) -> tuple[list[dict[str, Any]], float]:
    """The strokes of a joint as data, and the direction (rad, in the bearing's frame) of its guide, along
    which a way counts.
    """
    tilts = [0.0]
    found = attached(lambda asked: strokes_of(joint, asked, start, ground, tilts), at)
    return found, tilts[-1]


def strokes_of(
    joint: Any, asked: Asked, start: tuple[float, float], ground: tuple[bool, bool], tilts: list[float]
) -> list[Stroke]:
    """What a joint says; the direction of a guide whose way it asks for goes into ``tilts``."""

    def way(angle: float) -> tuple[float, float]:
        tilts.append(angle)
        return asked.way

    leaving = np.array([1.0, 0.0])  # a clamp is drawn to the left of what it holds
    first, second = np.array(asked.first), np.array(asked.second)
    return list(
        joint.strokes(
            JointSeen(first, second, asked.angles, start, ground, 1.0, asked.size, way, lambda: leaving)
        )
    )


def of_pair(noun: Any, at: Asked) -> list[dict[str, Any]]:
    """The strokes of a spring or gear as data."""
    return attached(
        lambda asked: list(
            noun.strokes(PairSeen(np.array(asked.first), np.array(asked.second), asked.angles[0], asked.size))
        ),
        at,
    )


def attached(drawn: Drawn, at: Asked) -> list[dict[str, Any]]:
    """Every stroke with its look and its points, each as [carrier, turner, x, y, x and y by size, by the
    least way, by the largest].
    """
    strokes = drawn(at)
    moved = {
        what: drawn(at.moved(what))
        for what in ("first", "second", "turn_first", "turn_second", "size", "low", "high")
    }
    found = []
    for k, stroke in enumerate(strokes):
        points = points_of(stroke)
        if not len(points):
            continue
        others = {what: points_of(ones[k]) for what, ones in moved.items() if len(ones) == len(strokes)}
        found.append(
            look(stroke)
            | {
                "points": [
                    _attached(at, p, {what: o[i] for what, o in others.items()}) for i, p in enumerate(points)
                ]
            }
        )
    return found


def points_of(stroke: Stroke) -> Array:
    """What a stroke goes through, shape (points, 2): of a surface the strip of its material, of a block its
    corners.
    """
    if isinstance(stroke, Curve):
        return np.asarray(stroke.points, dtype=float).reshape(-1, 2)
    if isinstance(stroke, Surface):
        deep = stroke.depth * np.asarray(stroke.inward)
        return np.array(
            [stroke.first, stroke.second, np.asarray(stroke.second) + deep, np.asarray(stroke.first) + deep],
            dtype=float,
        )
    if isinstance(stroke, Block):
        along, across = np.asarray(stroke.along), np.array([-stroke.along[1], stroke.along[0]])
        corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        return np.array(
            [stroke.centre + i * stroke.length * along + j * stroke.height * across for i, j in corners],
            dtype=float,
        )
    return np.zeros((0, 2)) if stroke.at is None else np.asarray(stroke.at, dtype=float).reshape(1, 2)


def look(stroke: Stroke) -> dict[str, Any]:
    """How a stroke looks."""
    if isinstance(stroke, Curve):
        look = {
            "is": "curve",
            "colour": stroke.colour,
            "width": stroke.width,
            "dashes": stroke.dashes,
            "fade": stroke.fade,
        }
    elif isinstance(stroke, Surface):
        look = {"is": "surface"}
    elif isinstance(stroke, Block):
        look = {"is": "block", "colour": stroke.colour}
    elif isinstance(stroke, Mark):
        look = {"is": "mark", "colour": stroke.colour, "shape": stroke.shape}
    return look


def _attached(at: Asked, point: Array, moved: dict[str, Array]) -> list[float]:
    first, second = np.array(at.first), np.array(at.second)

    def by(what: str, change: float = MOVED) -> Array:
        return (moved[what] - point) / change if what in moved else np.zeros(2)

    share = float(by("first")[0])
    turner = (
        FIRST_TURNS
        if np.hypot(*by("turn_first")) > 1e-9
        else SECOND_TURNS
        if np.hypot(*by("turn_second")) > 1e-9
        else GLOBAL
    )
    angle = (0.0, *at.angles)[turner]
    size, low, high = by("size", 1e-6 * at.size), by("low", -MOVED), by("high")
    apart = second - first
    if (
        turner == GLOBAL
        and (abs(float(by("first")[1])) > 1e-9 or 1e-9 < share < 1.0 - 1e-9)
        and np.hypot(*apart) > 1e-12
    ):
        length = math.hypot(*apart)
        along = apart / length
        across = np.array([-along[1], along[0]])
        values = [
            float((point - first) @ along) / length,
            float((point - first) @ across),
            0.0,
            float(size @ across),
            0.0,
            0.0,
            0.0,
            0.0,
        ]
        values[1] -= at.size * values[3]  # what does not grow with the drawing
        return [BETWEEN, GLOBAL, *(round(value, 12) for value in values)]
    carrier = FIRST if share > 0.5 else SECOND
    away = point - (first if carrier == FIRST else second) - at.size * size
    c, s = facing(-angle)
    turned = [number for x, y in (away, size, low, high) for number in (c * x - s * y, s * x + c * y)]
    return [carrier, turner, *(round(float(number), 12) for number in turned)]
