"""Strokes as a page draws them: each point with the pin that carries it, the body that turns it, and its
position there.

Joints and springs give their strokes for one position of their pins (``model.strokes``). The points are
affine functions of the positions of both pins, of the size of the drawing and of the travel of a journal in
its guide, so their coefficients follow from differences: the strokes are computed again with each of these
inputs changed. No kind of joint or spring needs to be known here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...model.drawing.strokes import Block, Curve, JointView, Mark, PairView, Stroke, Surface, facing

Array = NDArray[np.float64]
STEP = 0.25  # m or rad, of the differences; exact for affine functions
GROWTH = 1e-6  # of the size, relative
FIRST_PIN, SECOND_PIN, BOTH_PINS = range(3)  # carrier of a point: the first pin, the second, both
GLOBAL, FIRST_TURNS, SECOND_TURNS = range(3)  # frame of its coordinates


@dataclass(frozen=True)
class Inputs:
    """Positions (m) and angles (rad) of two pins, size of the drawing (m), and least and largest travel of a
    journal in its guide (m).
    """

    first: tuple[float, float]
    second: tuple[float, float]
    angles: tuple[float, float]
    size: float
    travel: tuple[float, float] = (0.0, 0.0)

    def changed(self) -> dict[str, Inputs]:
        """Return the inputs with one of them changed, by its name."""
        changes: dict[str, dict[str, Any]] = {
            "first": {"first": (self.first[0] + STEP, self.first[1])},
            "second": {"second": (self.second[0] + STEP, self.second[1])},
            "turn_first": {"angles": (self.angles[0] + STEP, self.angles[1])},
            "turn_second": {"angles": (self.angles[0], self.angles[1] + STEP)},
            "size": {"size": self.size * (1.0 + GROWTH)},
            "least_travel": {"travel": (-STEP, 0.0)},
            "largest_travel": {"travel": (0.0, STEP)},
        }
        return {name: replace(self, **change) for name, change in changes.items()}


Strokes: TypeAlias = Callable[[Inputs], list[Stroke]]


def joint_strokes(
    joint: Any, inputs: Inputs, start: tuple[float, float], ground: tuple[bool, bool]
) -> tuple[list[dict[str, Any]], float]:
    """Return the strokes of a joint as data, and the direction of its guide (rad, in the bearing's frame).

    ``start`` are the start angles of its bodies (rad); ``ground`` tells which of them is the ground.
    """
    directions = [0.0]
    entries = _attached(lambda changed: strokes_of(joint, changed, start, ground, directions), inputs)
    return entries, directions[-1]


def strokes_of(
    joint: Any, inputs: Inputs, start: tuple[float, float], ground: tuple[bool, bool], directions: list[float]
) -> list[Stroke]:
    """Return the strokes of a joint; the direction of its guide is appended to ``directions``."""

    def travel(direction: float) -> tuple[float, float]:
        directions.append(direction)
        return inputs.travel

    leaving = np.array([1.0, 0.0])  # a clamp is drawn to the left of what it holds
    first, second = np.array(inputs.first), np.array(inputs.second)
    view = JointView(first, second, inputs.angles, start, ground, 1.0, inputs.size, travel, lambda: leaving)
    return list(joint.strokes(view))


def pair_strokes(item: Any, inputs: Inputs) -> list[dict[str, Any]]:
    """Return the strokes of a spring or gear as data."""
    return _attached(
        lambda changed: list(
            item.strokes(
                PairView(np.array(changed.first), np.array(changed.second), changed.angles[0], changed.size)
            )
        ),
        inputs,
    )


def _attached(strokes_of: Strokes, inputs: Inputs) -> list[dict[str, Any]]:
    """Return every stroke with its look and points, each as [carrier, frame, x, y, x and y by size, by least
    travel, by largest travel].
    """
    strokes = strokes_of(inputs)
    changed = {name: strokes_of(changed_inputs) for name, changed_inputs in inputs.changed().items()}
    entries = []
    for k, stroke in enumerate(strokes):
        if len(points := points_of(stroke)):
            moved = {
                name: points_of(changed_strokes[k])
                for name, changed_strokes in changed.items()
                if len(changed_strokes) == len(strokes)
            }
            rows = [
                _coefficients(inputs, point, {name: at[i] for name, at in moved.items()})
                for i, point in enumerate(points)
            ]
            entries.append(look_of(stroke) | {"points": rows})
    return entries


def points_of(stroke: Stroke) -> Array:
    """Return the points of a stroke, shape (points, 2): of a surface, the outline of its hatching; of a
    block, its corners.
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
        direction = np.asarray(stroke.direction)
        across = np.array([-direction[1], direction[0]])
        corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        return np.array(
            [stroke.centre + i * stroke.length * direction + j * stroke.height * across for i, j in corners],
            dtype=float,
        )
    return np.zeros((0, 2)) if stroke.at is None else np.asarray(stroke.at, dtype=float).reshape(1, 2)


def look_of(stroke: Stroke) -> dict[str, Any]:
    """Return kind, colour and line style of a stroke."""
    if isinstance(stroke, Curve):
        return {
            "is": "curve",
            "colour": stroke.colour,
            "width": stroke.width,
            "dashes": stroke.dashes,
            "fade": stroke.fade,
        }
    if isinstance(stroke, Surface):
        return {"is": "surface"}
    kind = {"is": "mark", "shape": stroke.shape} if isinstance(stroke, Mark) else {"is": "block"}
    return kind | {"colour": stroke.colour}


def _coefficients(inputs: Inputs, point: Array, changed: dict[str, Array]) -> list[float]:
    """Return carrier, frame and coefficients of a point, from its positions with changed inputs."""
    first, second = np.array(inputs.first), np.array(inputs.second)

    def by(name: str, step: float = STEP) -> Array:
        return (changed[name] - point) / step if name in changed else np.zeros(2)

    share = float(by("first")[0])
    frame = (
        FIRST_TURNS
        if np.hypot(*by("turn_first")) > 1e-9
        else SECOND_TURNS
        if np.hypot(*by("turn_second")) > 1e-9
        else GLOBAL
    )
    angle = (0.0, *inputs.angles)[frame]
    size, least_travel, largest_travel = (
        by("size", GROWTH * inputs.size),
        by("least_travel", -STEP),
        by("largest_travel"),
    )
    separation = second - first
    if (
        frame == GLOBAL
        and (abs(float(by("first")[1])) > 1e-9 or 1e-9 < share < 1.0 - 1e-9)
        and np.hypot(*separation) > 1e-12
    ):
        # A point of a spring follows both pins: its coordinates are along the line between them, as a share
        # of its length, and across it.
        length = math.hypot(*separation)
        direction = separation / length
        across = np.array([-direction[1], direction[0]])
        values = [
            float((point - first) @ direction) / length,
            float((point - first) @ across),
            0.0,
            float(size @ across),
            0.0,
            0.0,
            0.0,
            0.0,
        ]
        values[1] -= inputs.size * values[3]  # the part that does not grow with the drawing
        return [BOTH_PINS, GLOBAL, *(round(value, 12) for value in values)]
    carrier = FIRST_PIN if share > 0.5 else SECOND_PIN
    away = point - (first if carrier == FIRST_PIN else second) - inputs.size * size
    c, s = facing(-angle)
    turned = [
        number
        for x, y in (away, size, least_travel, largest_travel)
        for number in (c * x - s * y, s * x + c * y)
    ]
    return [carrier, frame, *(round(float(number), 12) for number in turned)]
