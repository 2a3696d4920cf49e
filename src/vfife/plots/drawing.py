"""Drawings of a mechanism: one position with faint others behind it, and a strip of positions; names are
placed where they cover least.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.text import Annotation

from ..model.outlines import loose_pins
from ..results.run_data import RunData
from .layout import Panels, cut_text, width_of
from .style import TEXT_BOX, Array
from .symbols import (
    Outline,
    Sheet,
    arrows,
    draw_gears,
    draw_joints,
    draw_loads,
    draw_springs,
    gear_view,
    joint_view,
    label_places,
    outline_of,
)
from .turn import shown_span, shown_turn

POSITIONS = 12  # faint ones over a turn
STRIP = 8  # moments of a strip
SMALLER = 0.38  # drawings in a strip
SIZE = 5.8  # inches of the longer side
MOST_NAMED = 12  # bodies that the legend names
VISIBLE_SHARE = 0.6  # share of a body that is seen, with which the start is drawn
COVERING = 0.015  # distance from another body's line at which a point is covered, as a share of the drawing
SAMPLES = 12  # points of each side of a body that are looked at


def drawing(result: RunData, shown: int | None = None, pose: str = "") -> Figure:
    """Draw the mechanism at an output, by default the first that shows every body, of a static analysis the
    last; other positions faint behind it. ``pose``: words for the position in the title, by default its
    output.
    """
    mechanism = result.record.assembly.mechanism
    outlines = outlines_of(result)
    low, high = extent(result, outlines)
    panels = Panels([sides(high - low)], 1)
    at = clearest_output(result, outlines) if shown is None else shown
    sheet = Sheet.for_area(panels.axes[0], result, at, low, high)
    faint = _other_outputs(result, at)
    for name, outline in outlines.items():
        for k in faint:
            sheet.line(
                sheet.factor * outline.path[k], color=sheet.colours[name], lw=1.0, alpha=0.28, zorder=1
            )
        elastic = bool(result.record.assembly.bodies[name].elements)
        for pin in loose_pins(mechanism, name, elastic) if not result.record.static else ():
            sheet.line(sheet.path(name, pin), color=sheet.colours[name], lw=1.1, ls=(0, (1, 1.5)), zorder=2.5)
    draw_symbols(sheet, outlines)
    panels.entries = legend(sheet, outlines) | sheet.symbols
    position = f" {pose}" if pose else _position(result, at, bool(faint))
    figure = panels.close(f"{mechanism.name}{position}")
    place_names(sheet)
    return figure


def outlines_of(result: RunData) -> dict[str, Outline]:
    """Return the outline of each body."""
    return {name: outline_of(result, name) for name in result.record.assembly.bodies}


def shows_every_body(result: RunData) -> bool:
    """Return whether no body hides most of another at the first output."""
    return least_visible(outlines_of(result), 0) > VISIBLE_SHARE


def clearest_output(result: RunData, outlines: dict[str, Outline]) -> int:
    """Return the output at which a mechanism is drawn: the first one if no body hides most of another there,
    as a rod hides the crank at a dead centre; else one where little is hidden, high above the signs of the
    ground.
    """
    if result.record.static:
        return len(result.record.steps) - 1
    places = [0, *_other_outputs(result, 0)]
    shares = [least_visible(outlines, k) for k in places]
    if shares[0] > VISIBLE_SHARE:
        return 0
    heights = [np.mean([np.nanmean(outline.path[k, :, 1]) for outline in outlines.values()]) for k in places]
    best = [k for k, share in enumerate(shares) if share > max(shares) - 0.05]
    return places[max(best, key=lambda k: heights[k])]


def least_visible(outlines: dict[str, Outline], k: int) -> float:
    """Return the share of the body that is seen least at an output: the part that no body drawn after it
    covers.
    """
    paths = [outline.path[k] for outline in outlines.values()]
    paths = [path[np.isfinite(path).all(axis=1)] for path in paths]
    lines = [path for path in paths if len(path) > 1]
    if not lines:
        return 1.0
    corners = np.concatenate(lines)
    distance = COVERING * float(np.max(np.ptp(corners, axis=0)))
    smallest = 1.0
    for place, path in enumerate(lines):
        middle = np.linspace(0.0, 1.0, SAMPLES + 2)[1:-1, None]
        points = np.concatenate([a + middle * (b - a) for a, b in pairwise(path)])
        covered = np.zeros(len(points), dtype=bool)
        for later_path in lines[place + 1 :]:
            for first, second in pairwise(later_path):
                covered |= _distances(points, first, second) < distance
        smallest = min(smallest, 1.0 - float(covered.mean()))
    return smallest


def _distances(points: Array, first: Array, second: Array) -> Array:
    """Return the distances of points from the line between two others."""
    way = second - first
    share = np.clip((points - first) @ way / (float(way @ way) or 1.0), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - first - share[:, None] * way, axis=1))


def strip(result: RunData) -> Figure:
    """Draw the mechanism at several outputs of the last turn, or of the whole run, side by side."""
    outlines = outlines_of(result)
    low, high = extent(result, outlines)
    width, height = sides(high - low)
    span = shown_span(result)
    closed = span.full_turn  # the last output repeats the first
    moments = np.linspace(span.first, span.last, min(STRIP + closed, span.last - span.first + 1)).astype(int)[
        : STRIP if closed else None
    ]
    panels = Panels([(SMALLER * width, SMALLER * height)] * len(moments), 4, across=0.3, down=0.4)
    for ax, k in zip(panels.axes, moments, strict=True):
        sheet = Sheet.for_area(ax, result, int(k), low, high)
        draw_symbols(sheet, outlines)
        ax.set_title(moment(result, int(k)), fontsize=9, fontweight="normal")
        ax.set(xlabel="", ylabel="", xticks=[], yticks=[])
        for spine in ax.spines.values():
            spine.set_visible(False)
    panels.entries = legend(sheet, outlines)
    part = ": load factors" if result.record.static else shown_turn(result, span)
    return panels.close(f"{result.name}{part}")


def moment(result: RunData, k: int) -> str:
    """Return the crank angle with its unit, the time with its unit, or the load factor of an output."""
    if result.record.static:
        return f"{result.time[k]:.4g}"
    angles = result.crank_angle
    return f"{1e3 * result.time[k]:.4g} ms" if angles is None else f"{round(float(angles[k])) % 360}°"


def sides(span: Array) -> tuple[float, float]:
    """Return the width and height (inches) of a drawing of this extent."""
    wide, tall = np.asarray(span / (float(np.max(span)) or 1.0)) * SIZE
    return float(wide), float(tall)


def legend(sheet: Sheet, outlines: dict[str, Outline]) -> dict[str, Any]:
    """Return the legend entries of the first bodies."""
    entries: dict[str, Any] = {}
    for name, outline in list(outlines.items())[: MOST_NAMED - (len(outlines) > MOST_NAMED)]:
        dot = {"ls": "", "marker": "o", "ms": 8} if outline.path.shape[1] == 1 else {"lw": 4.0}
        parts = [Line2D([], [], color=sheet.colours[name], **dot)]
        parts += [Line2D([], [], color="white", lw=1.4)] if name in sheet.striped else []
        entries[name] = tuple(parts)
    if len(outlines) > MOST_NAMED:
        entries[f"… and {len(outlines) - MOST_NAMED + 1} more bodies"] = Line2D([], [], color="none")
    return entries


def draw_symbols(sheet: Sheet, outlines: dict[str, Outline]) -> None:
    """Draw bodies, gears, joints, springs and loads at the output of the sheet."""
    for name, outline in outlines.items():
        _draw_body(sheet, name, outline)
    for draw in (draw_gears, draw_joints, draw_springs, draw_loads):
        draw(sheet)


def _position(result: RunData, shown: int, faint: bool) -> str:
    """Return which position is drawn, and which faint ones."""
    if result.record.static:
        return f" at load factor {result.time[shown]:.4g}" + (" (faint: at the others)" if faint else "")
    if shown > 0:
        angles = result.crank_angle
        angle = "" if angles is None else f"{result.crank} at {angles[shown]:.4g}°, "
        return f", {angle}{1e3 * result.time[shown]:.4g} ms" + (
            " (faint: over the last turn)" if faint and result.crank is not None else ""
        )
    return " at the start" + (
        "" if not faint else " (faint: over the last turn)" if result.crank is not None else " (faint: later)"
    )


def extent(result: RunData, outlines: dict[str, Outline]) -> tuple[Array, Array]:
    """Return the lower left and upper right corner (m) of a drawing, with a margin for the symbols of the
    ground.
    """
    mechanism = result.record.assembly.mechanism
    points = [outline.path.reshape(-1, 2) for outline in outlines.values()]
    shown = len(result.record.steps) - 1 if result.record.static else 0
    sheet = Sheet(None, result, 1.0, 1.0, shown, {})  # type: ignore[arg-type]  # for positions only
    for joint in mechanism.joints.values():
        around, *reaches = joint.drawn
        for reach, side in zip(reaches, joint.sides, strict=True):
            path = sheet.path(*side)
            points += [] if reach is None else [path - reach, path + reach]
        points += [joint_view(sheet, joint).space(around)] if around else []
    for gear in mechanism.gears.values():
        for centre, radius in gear.wheels(gear_view(sheet, gear)):
            points.append(np.stack([centre - radius, centre + radius]))
    for spring in mechanism.springs.values():
        points += [sheet.at(end)[None, :] for end in (spring.first, spring.second) if "." in end]
    corners = np.concatenate(points)
    corners = corners[np.isfinite(corners).all(axis=1)]
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.08 * (float(np.max(high - low)) or 1.0)
    for end, tail in arrows(sheet, 0.15 * float(np.max(high - low))):
        low, high = np.minimum.reduce([low, end, tail]), np.maximum.reduce([high, end, tail])
    return low - margin * np.array([1.2, 1.7]), high + 1.2 * margin


def _other_outputs(result: RunData, shown: int) -> list[int]:
    """Return the outputs at which the mechanism is drawn faintly."""
    if result.record.static:
        return [k for k in range(len(result.record.steps)) if k != shown]
    chosen = np.flatnonzero(result.last_turn)
    if len(chosen) < 2:
        return []
    return [int(k) for k in chosen[np.linspace(0, len(chosen) - 1, POSITIONS + 1).astype(int)][:-1]]


def _draw_body(sheet: Sheet, name: str, outline: Outline) -> None:
    """Draw a body as a line, a plate or a point."""
    ax, path, colour = sheet.ax, sheet.factor * outline.path[sheet.shown], sheet.colours[name]
    if len(path) == 1:
        ax.plot(*path.T, color=colour, ls="", marker="o", ms=10, label=name, zorder=3)
        return
    if outline.plate:
        ax.fill(*path.T, facecolor=colour, alpha=0.25, edgecolor="none", zorder=3)
    ax.plot(*path.T, color=colour, lw=2.5 if outline.plate else 4.0, label=name, zorder=3)
    if name in sheet.striped:
        ax.plot(*path.T, color="white", lw=0.8 if outline.plate else 1.4, zorder=3.1)
    if outline.dots and not outline.plate:
        ax.plot(*path[1:-1].T, ls="", marker="o", ms=3, color="white", zorder=4)  # nodes of an elastic link


NAME_SIZE, HIGH = 9.0, 12.0  # points: of the font, and of a line
NAME_DISTANCES = (9.0, 14.0, 20.0, 28.0, 38.0)  # points from a sign to the nearest edge of its name
LONGEST = 2.2  # inches of a name
SPACING = 4.0  # points between places of a line that a name should not cover
# Costs: another name, the edge, a covered place of a line, a point of distance
OVERLAP, OUTSIDE, COVERED, DISTANCE = (400.0, 4000.0, 3.0, 0.25)
LOWEST = 2.0  # zorder from which on a line should not be covered; what is faint lies below


def place_names(sheet: Sheet) -> None:
    """Write the names of joints where they cover least of the drawing; the axes have their final position and
    limits.
    """
    # Each name in turn takes the cheapest of its candidate places: around its symbol at five distances in 16
    # directions. An optimum over all names at once would cost a combinatorial search and gain little, because
    # names are few and small beside the drawing.
    ax = sheet.ax
    lines = [np.asarray(line.get_xydata(), dtype=float) for line in ax.lines if line.get_zorder() >= LOWEST]
    lines += [
        np.array([text.xy, text.get_position()], dtype=float)
        for text in ax.texts
        if isinstance(text, Annotation) and not text.get_text()
    ]
    ground = [patch for patch in ax.patches if isinstance(patch, Polygon) and patch.get_hatch()]
    lines += [np.asarray(patch.get_xy(), dtype=float) for patch in ground]
    points = ax.figure.dpi / 72.0

    def to_points(at: Array) -> Array:
        return np.asarray(ax.transData.transform(at), dtype=float) / points

    places = label_places(sheet)
    centres_of_symbols = np.array([to_points(label.at) for label, _ in places]).reshape(-1, 2)
    lines = [line[np.isfinite(line).all(axis=1)] for line in lines if len(line)]
    covered = np.concatenate([centres_of_symbols, *(_points_along(to_points(line)) for line in lines)])
    box = ax.get_window_extent()
    corners = np.array([[box.x0, box.y0], [box.x1, box.y1]]) / points
    boxes: list[Array] = []
    look = TEXT_BOX | {"fontsize": NAME_SIZE}
    for (label, names), symbol in zip(places, centres_of_symbols, strict=True):
        text = cut_text(ax.figure, ", ".join(names), LONGEST, NAME_SIZE, "bold")  # type: ignore[arg-type]
        half = np.array([0.5 * 72.0 * width_of(ax.figure, text, NAME_SIZE, "bold"), 0.5 * HIGH])  # type: ignore[arg-type]
        room = (corners[0] + half, np.maximum(corners[0] + half, corners[1] - half))
        centres = _candidates(np.clip(symbol, *room) if label.fixed else symbol, half, label.fixed)
        cost = np.array([_cost(centre, half, covered, boxes, corners) for centre in centres])
        cost += DISTANCE * np.linalg.norm(np.maximum(np.abs(centres - symbol) - half, 0.0), axis=1)
        from_middle = symbol - corners.mean(axis=0)
        cost -= (centres - symbol) @ from_middle / (float(np.linalg.norm(from_middle)) or 1.0) / 60.0
        cost[0] -= 8.0 * label.fixed  # a name with a place of its own stays there if it can
        best = centres[int(np.argmin(cost))]
        boxes.append(np.stack([best - half, best + half]))
        offset = tuple(best - symbol)
        ax.annotate(text, tuple(label.at), offset, textcoords="offset points", annotation_clip=False, **look)


def _candidates(symbol: Array, half: Array, fixed: bool) -> Array:
    """Return the possible centres of a name: its own place first where it has one, then all around its
    symbol.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    ways = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    around = [symbol + ways * (half + away) for away in NAME_DISTANCES]
    return np.concatenate([[symbol], *around] if fixed else around)


def _cost(centre: Array, half: Array, covered: Array, boxes: list[Array], corners: Array) -> float:
    low, high = centre - half, centre + half
    cost = COVERED * float(((covered > low - 2.0) & (covered < high + 2.0)).all(axis=1).sum())
    cost += OUTSIDE * float(((low < corners[0]) | (high > corners[1])).any())
    return cost + OVERLAP * sum(bool(((low < box[1]) & (high > box[0])).all()) for box in boxes)


def _points_along(corners: Array) -> Array:
    """Return the points along a line, ``SPACING`` from each other."""
    points = [corners[:1]]
    for first, second in pairwise(corners):
        count = min(int(np.linalg.norm(second - first) / SPACING) + 1, 400)
        points.append(first + np.linspace(0.0, 1.0, count + 1)[1:, None] * (second - first))
    return np.concatenate(points)
