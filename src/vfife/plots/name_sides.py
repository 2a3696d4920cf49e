"""Sides of their symbols on which the names of joints stand in a film, chosen once for all of its frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from .style import Array
from .symbols import Outline, Sheet, label_places, name_reach

Side = Callable[[Array], Array]  # of the position of a symbol: a unit vector
SIDES, LOOKS = 12, 24  # places for a name around its symbol; frames that are looked at
PIN_WEIGHT = 60  # points of a body that a pin counts for
ROUND = 0.5  # least distance from the centre of its path, as a share of the largest, of a pin that goes round
PLACE_SPACING = 6.0  # points of the paper from one place of a body to the next that a name should not cover
LETTER, HIGH = 3.4, 9.0  # half of the width of a letter and of the height of a line (points)


def name_sides(
    sheet: Sheet, outlines: Sequence[Outline], frames: int, scale: float, farther: float
) -> dict[str, Side]:
    """Choose the side of its symbol on which each name covers least of bodies and pins during a film: a fixed
    side, or the outer side of a pin on a closed path.

    scale: points of the paper per unit of the drawing
    farther: distance (points) of names from their symbols beyond the usual one
    """
    looks: list[tuple[dict[str, Array], Array]] = []
    for k in np.unique(np.linspace(0, frames - 1, LOOKS).astype(int)):
        sheet.shown = int(k)
        symbols = {", ".join(names): label.at for label, names in label_places(sheet)}
        pins = [sheet.at(joint.bearing) for joint in sheet.mechanism.joints.values()]
        covered = [
            points_between(sheet.factor * outline.path[k], PLACE_SPACING / scale) for outline in outlines
        ]
        covered += [np.repeat(at[None], PIN_WEIGHT, axis=0) for at in pins]
        looks.append((symbols, scale * np.concatenate(covered)))
    chosen: dict[str, Side] = {}
    for text in dict.fromkeys(text for symbols, _ in looks for text in symbols):
        shown = [(symbols[text], points) for symbols, points in looks if text in symbols]
        choices = [*fixed_sides(), *outer_side(np.array([at for at, _ in shown]))]
        half, reach = np.array([LETTER * len(text), HIGH]), name_reach(text, farther)
        cost = np.zeros(len(choices))
        for at, points in shown:
            centres = scale * at + reach * np.array([side(at) for side in choices])
            cost += (np.abs(points[None] - centres[:, None]) < half).all(axis=2).sum(axis=1)
        chosen[text] = choices[int(np.argmin(cost))]
    return chosen


def fixed_sides() -> list[Side]:
    """Sides that stay, the upper one first."""
    angles = np.linspace(0.5 * np.pi, 2.5 * np.pi, SIDES, endpoint=False)
    return [partial(_fixed, np.array([np.cos(angle), np.sin(angle)])) for angle in angles]


def outer_side(path: Array) -> list[Side]:
    """Return the outer side of a pin whose ``path`` (moments, 2) encircles its centre; an empty list for
    other pins.
    """
    centre = 0.5 * (path.min(axis=0) + path.max(axis=0))
    distances = np.linalg.norm(path - centre, axis=1)
    goes_round = distances.max() > 0.0 and distances.min() > ROUND * distances.max()
    return [partial(_outer, centre)] if goes_round else []


def _fixed(side: Array, at: Any) -> Array:
    return side


def _outer(centre: Array, at: Array) -> Array:
    away = at - centre
    return np.asarray(away / (np.linalg.norm(away) or 1.0))


def points_between(line: Array, gap: float) -> Array:
    """Points along a line, no farther apart than ``gap``, shape (points, 2)."""
    line = line[np.isfinite(line).all(axis=1)]
    lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    at = np.linspace(0.0, lengths[-1], min(int(lengths[-1] / gap) + 2, 400))
    return np.stack([np.interp(at, lengths, line[:, axis]) for axis in (0, 1)], axis=1)
