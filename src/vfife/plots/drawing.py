"""The mechanism drawn: where it starts, faint positions over a turn, joints, springs, ground and names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..model.outlines import loose_pins
from .jointsigns import joint_names, joint_signs, seen
from .outlines import Outline, outline
from .sheet import Sheet
from .springsigns import gear_seen, gear_signs, load_signs, spring_signs, tails
from .style import BODIES, heading, length_unit, panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.view import View

Array = NDArray[np.float64]
POSITIONS = 12  # faint ones over a turn
MOST_NAMED = 12  # bodies that the legend names


def drawing(result: View) -> Figure:
    """Bodies at the start of the run (a static analysis: at its end), other positions faint behind them, joints with their names."""
    mechanism = result.record.assembly.mechanism
    outlines = {name: outline(result, name) for name in result.record.assembly.bodies}
    colours = {name: BODIES[k % len(BODIES)] for k, name in enumerate(outlines)}
    low, high = extent(result, outlines)
    size = float(np.max(high - low)) or 1.0
    factor, unit = length_unit(size)
    width, height = np.maximum((high - low) / size, 0.35) * 5.6
    figure, (ax,) = panels(1, 1, width + 2.9, height + 1.0, equal=True)
    shown = len(result.record.steps) - 1 if result.record.static else 0
    sheet = Sheet(ax, result, factor, factor * size, shown, colours)
    later = _later(result, shown)
    for name, one in outlines.items():
        for k in later:
            sheet.line(factor * one.path[k], color=colours[name], lw=1.0, alpha=0.28, zorder=1)
        elastic = bool(result.record.assembly.bodies[name].elements)
        for pin in loose_pins(mechanism, name, elastic) if not result.record.static else ():
            sheet.line(sheet.path(name, pin), color=colours[name], lw=1.1, ls=(0, (1, 1.5)), zorder=2.5)
    signs(sheet, outlines)
    middle = np.nanmean(np.concatenate([factor * one.path[shown] for one in outlines.values()]), axis=0)
    joint_names(sheet, middle)
    handles, labels = ax.get_legend_handles_labels()
    if len(labels) > MOST_NAMED:
        labels = [*labels[: MOST_NAMED - 1], f"… and {len(labels) - MOST_NAMED + 1} more bodies"]
        handles = handles[:MOST_NAMED]
    figure.legend([*handles, *sheet.signs.values()], [*labels, *sheet.signs], loc="outside right center")
    ax.set_aspect("equal")
    ax.set(xlim=factor * np.array([low[0], high[0]]), ylim=factor * np.array([low[1], high[1]]))
    ax.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})")
    heading(figure, f"{mechanism.name} {_when(result, shown, bool(later))}")
    return figure


def signs(sheet: Sheet, outlines: dict[str, Outline]) -> None:
    """Bodies, gears, joints, springs and loads as they are at the output that is shown."""
    for name, one in outlines.items():
        body_sign(sheet, name, one)
    gear_signs(sheet)
    joint_signs(sheet)
    spring_signs(sheet)
    load_signs(sheet)


def _when(result: View, shown: int, faint: bool) -> str:
    if result.record.static:
        return f"at load factor {result.time[shown]:.4g}" + (" (faint: at the others)" if faint else "")
    return "at the start" + ("" if not faint else " (faint: over the last turn)" if result.crank is not None else " (faint: later)")


def extent(result: View, outlines: dict[str, Outline]) -> tuple[Array, Array]:
    """Lower left and upper right corner (m) of what is drawn, with a margin that holds the signs for the ground."""
    mechanism = result.record.assembly.mechanism
    points = [one.path.reshape(-1, 2) for one in outlines.values()]
    shown = len(result.record.steps) - 1 if result.record.static else 0
    sheet = Sheet(None, result, 1.0, 1.0, shown, {})  # type: ignore[arg-type]  # measures only
    for joint in mechanism.joints.values():
        around, *reaches = joint.drawn
        for reach, side in zip(reaches, joint.sides, strict=True):
            path = sheet.path(*side)
            points += [] if reach is None else [path - reach, path + reach]
        points += [seen(sheet, joint).space(around)] if around else []
    for gear in mechanism.gears.values():
        for centre, radius in gear.wheels(gear_seen(sheet, gear)):
            points.append(np.stack([centre - radius, centre + radius]))
    for spring in mechanism.springs.values():
        points += [sheet.at(end)[None, :] for end in (spring.first, spring.second) if "." in end]
    everything = np.concatenate(points)
    everything = everything[np.isfinite(everything).all(axis=1)]
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.08 * (float(np.max(high - low)) or 1.0)
    for end, tail in tails(sheet, 0.15 * float(np.max(high - low))):
        low, high = np.minimum(low, tail), np.maximum(high, tail)
        low, high = np.minimum(low, end), np.maximum(high, end)
    return low - margin * np.array([1.2, 1.7]), high + 1.2 * margin


def _later(result: View, shown: int) -> list[int]:
    """Outputs at which the mechanism is drawn faintly."""
    if result.record.static:
        return [k for k in range(len(result.record.steps)) if k != shown]
    chosen = np.flatnonzero(result.last_turn)
    if len(chosen) < 2:
        return []
    return [int(k) for k in chosen[np.linspace(0, len(chosen) - 1, POSITIONS + 1).astype(int)][:-1]]


def body_sign(sheet: Sheet, name: str, one: Outline) -> None:
    """A body as a line, a plate or a point."""
    ax, path, colour = sheet.ax, sheet.factor * one.path[sheet.shown], sheet.colours[name]
    if len(path) == 1:
        ax.plot(*path.T, color=colour, ls="", marker="o", ms=10, label=name, zorder=3)
    elif one.plate:
        ax.fill(*path.T, facecolor=colour, alpha=0.25, edgecolor="none", zorder=3)
        ax.plot(*path.T, color=colour, lw=2.5, label=name, zorder=3)
    else:
        ax.plot(*path.T, color=colour, lw=4.0, label=name, zorder=3)
        if one.dots:
            ax.plot(*path[1:-1].T, ls="", marker="o", ms=3, color="white", zorder=4)  # nodes of an elastic link
