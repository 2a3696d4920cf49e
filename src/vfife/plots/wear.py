"""Wear of joints: depths around bearings and journals in polar axes, clearance and force over turns."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from ..measures.turns import last_turn, of_window
from ..measures.wear import PLACES, SIDES, depths, is_round, wear_contacts
from ..model.surfaces import body_of, surface_words
from ..report.amounts import life_range_words
from .style import (
    BLUE,
    FAINT,
    GREY,
    INK,
    STYLE,
    VERMILION,
    NotebookFigure,
    digits,
    heading,
    length_unit,
    scale_of,
)

if TYPE_CHECKING:
    from ..results.run_data import RunData
    from ..tribology.wear_state import Worn

HOLLOW = 1.5  # radius of the surface as it was, in deepest depths
MOST_JOINTS = 6
STEEP = 0.4  # cosine of directions that are steep
# Over turns: unit and label
QUANTITIES = {"clearance": ("m", "clearance ({}),\nsmoothed profiles"), "force": ("N", "largest force\n({})")}
ANGLES = -math.pi + 2.0 * math.pi / PLACES * (np.arange(PLACES) + 0.5)
MOST_PROFILES, SIDE, HEIGHT = 6, 3.6, 4.3  # profiles of a surface that are drawn, inches of a panel


@rc_context(STYLE)
def wear_over_turns(wear: Worn) -> Figure:
    """Return a figure with a row for each joint: enlarged wear around each surface, and clearance and largest
    force over turns.
    """
    sides = max(sum(surface.joint == joint for surface in wear.surfaces) for joint in wear.joints)
    figure = NotebookFigure(
        figsize=(SIDE * (sides + 1.25), HEIGHT * len(wear.joints) + 0.4),
        layout=ConstrainedLayoutEngine(wspace=0.1, h_pad=0.12),
    )
    grid = figure.add_gridspec(2 * len(wear.joints), sides + 1, width_ratios=[1.0] * sides + [1.15])
    chosen = shown_points(wear)
    for row, joint in enumerate(wear.joints):
        places = [k for k, surface in enumerate(wear.surfaces) if surface.joint == joint]
        for column, place in enumerate(places):
            ax = figure.add_subplot(grid[2 * row : 2 * row + 2, column], projection="polar")
            lines = [(turns_words(wear.turns[point]), wear.depth[point, place]) for point in chosen]
            draw_profiles(ax, wear.surfaces[place].name, wear.surfaces[place].side, wear.angles, lines)
        for k, quantity in enumerate(QUANTITIES):
            draw_history(figure.add_subplot(grid[2 * row + k, sides]), wear, row, quantity)
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=MOST_PROFILES + 2,
        title="surfaces after turns",
        fontsize=9.0,
    )
    text = f"{turns_words(wear.turns[-1])} turns of the crank, {wear.simulated:,.0f} of them simulated"
    if wear.life_end:
        joint, by = wear.life_end["joint"], wear.life_end["by"]
        text += f"; life of joint {joint} ends after {life_turns(wear)} by its {by}"
    heading(figure, f"{wear.name}: wear after {text}", wear.progress)
    return fix_layout(figure)


def fix_layout(figure: Figure) -> Figure:
    """Apply the layout and fix it; polar axes need two passes."""
    for _ in range(2):
        figure.draw_without_rendering()
    figure.set_layout_engine("none")
    return figure


def wear_of_turn(result: RunData) -> Figure:
    """Return a figure of the wear around each surface in a million turns like the last one, or in the run if
    it has no turns.
    """
    record = result.record
    factor, period = 1.0, "the run"
    if record.assembly.choice.turn is not None:
        factor, period = 1e6, "a million turns like the last"
    part, _ = of_window(record, last_turn(record))
    shown = [
        (name, side, factor * depth)
        for name, contact in list(wear_contacts(record).items())[:MOST_JOINTS]
        if is_round(record, contact)
        for side, depth in zip(SIDES, depths(part, contact), strict=True)
        if depth.max() > 0.0
    ]
    columns = min(len(shown), 4)
    rows = -(-len(shown) // columns)
    figure = NotebookFigure(figsize=(SIDE * columns + 0.6, HEIGHT * rows), layout="constrained")
    for place, (name, side, depth) in enumerate(shown):
        ax = figure.add_subplot(rows, columns, place + 1, projection="polar")
        body = body_of(record.assembly.mechanism.contacts[name], side)
        title = f"{name}: {surface_words(body, side)}"
        draw_profiles(ax, title, side, ANGLES, [(f"lost in {period}", depth)])
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=9.0
    )
    heading(figure, f"{result.name}: wear by Archard's law in {period}")
    return fix_layout(figure)


def has_wear(result: RunData) -> bool:
    """Return whether a journal in a bearing has worn in the last turn."""
    measures = result.measures
    return any(value > 0.0 for name, value in measures.items() if name.endswith("_wear_depth.max"))


def shown_points(wear: Worn) -> list[int]:
    """Return the indices of the profiles that are drawn, evenly over the turns, always with the last."""
    places = np.linspace(0.0, wear.turns[-1], MOST_PROFILES + 1)[1:]
    return sorted({int(np.abs(wear.turns - turns).argmin()) for turns in places} | {len(wear.turns) - 1})


def draw_profiles(ax: Any, title: str, side: str, angles: Any, lines: list[tuple[str, Any]]) -> None:
    """Draw depths (m) of a surface, named in the title, with their labels, the last one filled: outwards from
    a bearing, inwards into a journal.
    """
    deepest = max(max(float(depth.max()) for _, depth in lines), 1e-15)
    factor, unit = length_unit(deepest)
    sign, last = 1.0 if side == "bearing" else -1.0, lines[-1][1]
    angle = np.append(angles, angles[0] + 2.0 * math.pi)
    circle = np.full_like(angle, HOLLOW)
    colors = colormaps["viridis_r"](np.linspace(0.12, 1.0, len(lines)) if len(lines) > 1 else [0.8])
    ax.fill_between(angle, circle, circle + sign * closed_curve(last) / deepest, color=FAINT, lw=0.0)
    for color, (label, depth) in zip(colors, lines, strict=True):
        ax.plot(angle, circle + sign * closed_curve(depth) / deepest, color=color, lw=1.1, label=label)
    ax.plot(angle, circle, color=INK, lw=1.0, label="new")
    marks = np.array([0.5, 1.0])
    ax.set_rticks(
        HOLLOW + sign * marks, [f"{digits(float(f'{factor * deepest * mark:.2g}'))} {unit}" for mark in marks]
    )
    ax.set_rlabel_position(shallow_direction(last, angles))
    ax.set_rlim(0.0, HOLLOW + (1.2 if sign > 0.0 else 0.15))
    ax.set_xlabel(f"{title}, up to {digits(float(f'{factor * deepest:.3g}'))} {unit}", fontweight="bold")
    ax.grid(color=FAINT, lw=0.6)
    ax.tick_params(axis="x", labelsize=8.0, pad=0.0)
    ax.tick_params(axis="y", labelsize=8.0)
    for label in ax.get_yticklabels():
        label.set_horizontalalignment("center")


def shallow_direction(depth: Any, angles: Any) -> float:
    """Return the direction (degrees), up or down, with the least wear within a sixth of the circle: the place
    of the radial numbers.
    """
    width = len(depth) // 6
    around_it = np.convolve(
        np.concatenate([depth[-width:], depth, depth[:width]]), np.ones(width) / width, mode="same"
    )[width:-width]
    return float(
        np.degrees(angles[int(np.argmin(np.where(np.abs(np.cos(angles)) < STEEP, around_it, np.inf)))])
    )


def closed_curve(depth: Any) -> Any:
    """Return the depths with the first one appended."""
    return np.append(depth, depth[0])


def draw_history(ax: Any, wear: Worn, row: int, quantity: str) -> None:
    """Draw clearance or largest force of a joint over turns, with its limit."""
    values, limit = getattr(wear, quantity)[:, row], getattr(wear.spec, quantity)
    si_unit, label = QUANTITIES[quantity]
    factor, unit = scale_of(max(float(values.max()), limit or 0.0), si_unit)
    million = wear.turns[-1] >= 1e5
    scale = 1e6 if million else 1.0
    ax.plot(wear.turns / scale, factor * values, color=BLUE, marker="o", ms=3.0)
    if limit is not None:
        ax.axhline(factor * limit, color=VERMILION, lw=1.0, ls=(0, (5, 1.6)), label="limit")
        ax.legend(loc="best", fontsize=8.0)
    if wear.life_end and wear.life_end["joint"] == wear.joints[row]:
        ax.axvline(wear.life_end["turns"] / scale, color=GREY, lw=0.8)
    ax.set_ylabel(label.format(unit))
    ax.set_xlim(left=0.0)
    if quantity == "force":
        ax.set_xlabel("million turns" if million else "turns")


def life_turns(wear: Worn) -> str:
    """Return the turns after which a life ended, or the range in which it ends where the model does not
    determine it.
    """
    limit = wear.spec.clearance
    if limit is not None and wear.life_end["by"] == "clearance":
        life = wear.life(wear.life_end["joint"], limit)
        if not life.determined:
            return life_range_words(life.shortest, life.longest, None).removesuffix(" turns")
    return turns_words(wear.life_end["turns"])


def turns_words(turns: float) -> str:
    """Return a number of turns in words of three digits."""
    return f"{turns:,.0f}" if turns < 1e5 else f"{turns / 1e6:.3g} million"
