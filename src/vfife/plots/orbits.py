"""Journal paths inside their clearance circles (Fig. 15 of the VFIFE paper)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .style import BLUE, GREY, ORANGE, SKY, VERMILION, length_unit, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..result import Result

MOST_COLUMNS = 3


def orbits(result: Result) -> Figure:
    """Path of each journal's centre seen from its bearing's centre, global axes, one panel a joint.

    The last crank turn is dark, what came before it is light, onsets of contact in the last turn are dots; the circle of radius c is where
    the two surfaces touch.
    """
    names = list(result.record.assembly.clearances)
    columns = min(len(names), MOST_COLUMNS)
    figure, axes = panels(math.ceil(len(names) / columns), columns, 3.9, 4.1)
    for k, (ax, name) in enumerate(zip(axes, names, strict=False)):
        _panel(result, ax, k, name)
    for ax in axes[len(names) :]:
        ax.set_visible(False)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    figure.suptitle(f"{result.name}: journal centres in their bearings")
    return figure


def _panel(result: Result, ax: Axes, k: int, name: str) -> None:
    clearance = result.record.assembly.mechanism.clearances[name].clearance
    factor, unit = length_unit(clearance)
    x, y = (factor * result.channels[f"eccentricity_{axis}"].values[:, k] for axis in ("x", "y"))
    window = result.last_turn
    begin = max(int(np.argmax(window)) - 1, 0)
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    ax.plot(factor * clearance * np.cos(turn), factor * clearance * np.sin(turn), color=GREY, lw=1.0, ls=(0, (5, 3)), label="clearance circle")
    if begin > 0:
        ax.plot(x[: begin + 1], y[: begin + 1], color=SKY, lw=0.8, alpha=0.8, label="before the last turn")
    ax.plot(x[begin:], y[begin:], color=BLUE, lw=1.2, label="last turn" if begin > 0 else "journal centre")
    began = window & (result.channels["mode"].values[:, k] == 1)
    marks = {"color": VERMILION, "ls": "", "marker": "o", "ms": 3.5}
    ax.plot(x[began], y[began], label="a contact began", **marks)
    ax.plot(0.0, 0.0, color=ORANGE, ls="", marker="+", ms=9, mew=1.6, label="bearing centre")
    ax.set_aspect("equal")
    reach = 1.08 * max(factor * clearance, float(np.hypot(x, y).max()))
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"joint {name}")
