"""Journal paths inside their clearance circles (Fig. 15 of the VFIFE paper)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from ..analysis.forces import IMPACT
from .style import BLUE, GREY, ORANGE, SKY, VERMILION, heading, length_unit, one_legend, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.view import View

MOST_COLUMNS = 3


def orbits(result: View) -> Figure:
    """Path of each journal's centre seen from its bearing's centre, global axes, one panel a joint.

    The last crank turn is dark, what came before it is light (and cut off where it leaves the panel), onsets of
    contact in the last turn are dots; the circle of radius c is where the two surfaces touch.
    """
    names = journals(result)
    columns = min(len(names), MOST_COLUMNS)
    figure, axes = panels(math.ceil(len(names) / columns), columns, 3.9, 4.1, equal=True)
    places = list(result.record.assembly.contacts)
    for ax, name in zip(axes, names, strict=False):
        _panel(result, ax, places.index(name), name)
    for ax in axes[len(names) :]:
        ax.set_visible(False)
    one_legend(figure, axes)
    heading(figure, f"{result.name}: journal centres in their bearings")
    return figure


def journals(result: View) -> list[str]:
    """Revolute joints with clearance: those whose journal moves inside a circle."""
    return list(result.record.assembly.mechanism.clearances)


def _panel(result: View, ax: Axes, k: int, name: str) -> None:
    clearance = result.record.assembly.mechanism.clearances[name].clearance
    factor, unit = length_unit(clearance)
    x, y = (factor * result.channels[f"eccentricity_{axis}"].values[:, k] for axis in ("x", "y"))
    window = result.last_turn
    begin = max(int(np.argmax(window)) - 1, 0)
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    circle = factor * clearance * np.cos(turn), factor * clearance * np.sin(turn)
    ax.plot(*circle, color=GREY, lw=1.0, ls=(0, (5, 3)), label="clearance circle")
    if begin > 0:
        ax.plot(x[: begin + 1], y[: begin + 1], color=SKY, lw=0.7, alpha=0.8, label="before the last turn")
    ax.plot(x[begin:], y[begin:], color=BLUE, lw=1.2, label="last turn" if begin > 0 else "journal centre")
    began = window & (result.channels["mode"].values[:, k] == IMPACT)
    if began.any():
        ax.plot(x[began], y[began], color=VERMILION, ls="", marker="o", ms=3.5, label="a contact began")
    ax.plot(0.0, 0.0, color=ORANGE, ls="", marker="+", ms=9, mew=1.6, label="bearing centre")
    reach = 1.1 * max(factor * clearance, float(np.hypot(x[begin:], y[begin:]).max()))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    ax.set_aspect("equal")
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"joint {name}")
