"""Names of joints in a drawing: beside their signs, where they cover neither each other nor what is drawn."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.text import Annotation
from numpy.typing import NDArray

from .layout import fitting, width_of
from .sheet import Sheet
from .signs import named_places

Array = NDArray[np.float64]
SIZE, HIGH = 9.0, 12.0  # points: of the font, and of a line
AWAY = (9.0, 14.0, 20.0, 28.0, 38.0)  # points from a sign to the nearest edge of its name
LONGEST = 2.2  # inches of a name
EVERY = 4.0  # points between places of a line that a name should not cover
TAKEN, OUTSIDE, COVERED, FAR = 400.0, 4000.0, 3.0, 0.25  # what it costs: another name, the edge, a place of a line, a point of distance
LOWEST = 2.0  # zorder from which on a line should not be covered; what is faint lies below
BACK = {"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.75}


def place_names(sheet: Sheet) -> None:
    """Writes the names where they cover least of what is drawn. The axes have their place and limits."""
    ax = sheet.ax
    lines = [np.asarray(line.get_xydata(), dtype=float) for line in ax.lines if line.get_zorder() >= LOWEST]
    lines += [np.array([one.xy, one.get_position()], dtype=float) for one in ax.texts if isinstance(one, Annotation) and not one.get_text()]
    points = ax.figure.dpi / 72.0

    def seen(at: Array) -> Array:
        return np.asarray(ax.transData.transform(at), dtype=float) / points

    places = named_places(sheet)
    signs = np.array([seen(label.at) for label, _ in places]).reshape(-1, 2)
    covered = np.concatenate([signs, *(_along(seen(line[np.isfinite(line).all(axis=1)])) for line in lines if len(line))])
    box = ax.get_window_extent()
    corners = np.array([[box.x0, box.y0], [box.x1, box.y1]]) / points
    taken: list[Array] = []
    look: dict[str, Any] = {"ha": "center", "va": "center", "weight": "bold", "fontsize": SIZE, "bbox": BACK, "zorder": 9}
    for (label, names), sign in zip(places, signs, strict=True):
        text = fitting(ax.figure, ", ".join(names), LONGEST, SIZE, "bold")  # type: ignore[arg-type]
        half = np.array([0.5 * 72.0 * width_of(ax.figure, text, SIZE, "bold"), 0.5 * HIGH])  # type: ignore[arg-type]
        room = (corners[0] + half, np.maximum(corners[0] + half, corners[1] - half))
        centres = _candidates(np.clip(sign, *room) if label.fixed else sign, half, label.fixed)
        cost = np.array([_cost(centre, half, covered, taken, corners) for centre in centres])
        gap = np.linalg.norm(np.maximum(np.abs(centres - sign) - half, 0.0), axis=1)
        outward = (centres - sign) @ _unit(sign - corners.mean(axis=0)) / 60.0
        best = centres[int(np.argmin(cost + FAR * gap - outward - (8.0 * label.fixed * (np.arange(len(centres)) == 0))))]
        taken.append(np.stack([best - half, best + half]))
        ax.annotate(text, tuple(label.at), xytext=tuple(best - sign), textcoords="offset points", annotation_clip=False, **look)


def _candidates(sign: Array, half: Array, fixed: bool) -> Array:
    """Centres that a name may have: its own place first where it has one, then all around its sign."""
    turn = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    ways = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    around = [sign + ways * (half + away) for away in AWAY]
    return np.concatenate([[sign], *around] if fixed else around)


def _cost(centre: Array, half: Array, covered: Array, taken: list[Array], corners: Array) -> float:
    low, high = centre - half, centre + half
    cost = COVERED * float(((covered > low - 2.0) & (covered < high + 2.0)).all(axis=1).sum())
    cost += OUTSIDE * float(((low < corners[0]) | (high > corners[1])).any())
    return cost + TAKEN * sum(bool(((low < other[1]) & (high > other[0])).all()) for other in taken)


def _along(corners: Array) -> Array:
    """Places along a line, near each other."""
    found = [corners[:1]]
    for first, second in pairwise(corners):
        count = min(int(np.linalg.norm(second - first) / EVERY) + 1, 400)
        found.append(first + np.linspace(0.0, 1.0, count + 1)[1:, None] * (second - first))
    return np.concatenate(found)


def _unit(away: Array) -> Array:
    return away / (float(np.linalg.norm(away)) or 1.0)
