"""Wear of joints: depths around bearings and journals in polar axes, with play and force over turns beside them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .style import BLUE, FAINT, GREY, INK, VERMILION, digits, heading, length_unit, scale_of

if TYPE_CHECKING:
    from ..study.worn import Worn

HOLLOW = 1.5  # radius of the surface as it was, in deepest depths
MOST, SIDE, HEIGHT = 6, 3.6, 4.3  # profiles of a surface that are drawn, inches of a panel


def worn(found: Worn) -> Figure:
    """One row a joint: each surface around itself, drawn far larger than its wear is small, and over turns the play and the largest force."""
    sides = max(sum(one.joint == joint for one in found.surfaces) for joint in found.joints)
    figure = Figure(figsize=(SIDE * (sides + 1.25), HEIGHT * len(found.joints) + 0.4), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2 * len(found.joints), sides + 1, width_ratios=[1.0] * sides + [1.15])
    chosen = choice(found)
    for row, joint in enumerate(found.joints):
        own = [k for k, one in enumerate(found.surfaces) if one.joint == joint]
        for column, place in enumerate(own):
            ax = figure.add_subplot(grid[2 * row : 2 * row + 2, column], projection="polar")
            around(ax, found, place, chosen)
        over_turns(figure.add_subplot(grid[2 * row, sides]), found, row, "play")
        over_turns(figure.add_subplot(grid[2 * row + 1, sides]), found, row, "force")
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=MOST + 2, title="surfaces after turns", fontsize=9.0
    )
    told = f"{counted(found.turns[-1])} turns of the crank, {found.simulated:,.0f} of them simulated"
    if found.ended:
        told += f"; life of joint {found.ended['joint']} ends after {counted(found.ended['turns'])} by its {found.ended['by']}"
    heading(figure, f"{found.name}: wear after {told}")
    return figure


def choice(found: Worn) -> list[int]:
    """Points that are drawn, evenly among their turns, the last of them always."""
    wanted = np.linspace(0.0, found.turns[-1], MOST + 1)[1:]
    return sorted({int(np.abs(found.turns - turns).argmin()) for turns in wanted} | {len(found.turns) - 1})


def around(ax: Any, found: Worn, place: int, chosen: list[int]) -> None:
    """Depths of one surface: outwards from a bearing, inwards into a journal."""
    surface, deepest = found.surfaces[place], max(float(found.depth[:, place].max()), 1e-15)
    factor, unit = length_unit(deepest)
    sign = 1.0 if surface.side == "bearing" else -1.0
    angle = np.append(found.angles, found.angles[0] + 2.0 * math.pi)
    circle = np.full_like(angle, HOLLOW)
    colors = colormaps["viridis_r"](np.linspace(0.12, 1.0, len(chosen)))
    ax.fill_between(angle, circle, circle + sign * closed(found.depth[-1, place]) / deepest, color=FAINT, lw=0.0)
    for color, point in zip(colors, chosen, strict=True):
        ax.plot(angle, circle + sign * closed(found.depth[point, place]) / deepest, color=color, lw=1.1, label=counted(found.turns[point]))
    ax.plot(angle, circle, color=INK, lw=1.0, label="new")
    marks = np.array([0.5, 1.0])
    ax.set_rticks(HOLLOW + sign * marks, [f"{digits(float(f'{factor * deepest * mark:.2g}'))} {unit}" for mark in marks])
    ax.set_rlabel_position(shallow(found.depth[-1, place], found.angles))
    ax.set_rlim(0.0, HOLLOW + (1.2 if sign > 0.0 else 0.15))
    ax.set_xlabel(f"{surface.joint}: {surface.side}, up to {digits(float(f'{factor * deepest:.3g}'))} {unit}", fontweight="bold")
    ax.grid(color=FAINT, lw=0.6)
    ax.tick_params(axis="x", labelsize=8.0, pad=0.0)
    ax.tick_params(axis="y", labelsize=8.0)
    for label in ax.get_yticklabels():
        label.set_horizontalalignment("center")


def shallow(depth: Any, angles: Any) -> float:
    """Where least is worn within a sixth of the way around (degrees): there is room for figures."""
    width = len(depth) // 6
    around_it = np.convolve(np.concatenate([depth[-width:], depth, depth[:width]]), np.ones(width) / width, mode="same")[width:-width]
    return float(np.degrees(angles[int(np.argmin(around_it))]))


def closed(depth: Any) -> Any:
    """Depths with the first again behind the last."""
    return np.append(depth, depth[0])


def over_turns(ax: Any, found: Worn, row: int, what: str) -> None:
    """Play or largest force of a joint at the points, with its limit."""
    values = (found.play if what == "play" else found.force)[:, row]
    limit = found.asked.clearance if what == "play" else found.asked.force
    size = max(float(values.max()), limit or 0.0)
    factor, unit = length_unit(size) if what == "play" else scale_of(size, "N")
    million = found.turns[-1] >= 1e5
    turns = found.turns / (1e6 if million else 1.0)
    ax.plot(turns, factor * values, color=BLUE, marker="o", ms=3.0)
    if limit is not None:
        ax.axhline(factor * limit, color=VERMILION, lw=1.0, ls=(0, (5, 1.6)), label="limit")
        ax.legend(loc="best", fontsize=8.0)
    if found.ended and found.ended["joint"] == found.joints[row]:
        ax.axvline(found.ended["turns"] / (1e6 if million else 1.0), color=GREY, lw=0.8)
    ax.set_ylabel(f"play ({unit}),\ndeepest places" if what == "play" else f"largest force\n({unit})")
    ax.set_xlim(left=0.0)
    if what == "force":
        ax.set_xlabel("million turns" if million else "turns")


def counted(turns: float) -> str:
    """A number of turns in words of three digits."""
    return f"{turns:,.0f}" if turns < 1e5 else f"{turns / 1e6:.3g} million"
