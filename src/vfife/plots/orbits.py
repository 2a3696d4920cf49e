"""Journal paths inside their clearance circles (Fig. 15 of the VFIFE paper)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..analysis.forces import IMPACT, eccentricity
from ..analysis.guides import turning
from .layout import Panels
from .style import BLUE, GREY, INK, SKY, VERMILION, length_unit
from .turn import said_shortly, span

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.view import View

Array = NDArray[np.float64]
MOST, MOST_COLUMNS = 12, 3
SIDE = 3.0  # inches
ALIKE = 6.0  # the largest panel over the smallest, up to which all have one scale
MOST_DOTS = 20_000


def orbits(result: View) -> Figure:
    """Path of each journal's centre seen from its bearing's centre, in the frame of the bearing's body, one panel a joint and one scale.

    The last turn is a line, what came before it dots, onsets of contact in the last turn are marked; in the circle of radius c surfaces are apart.
    """
    names = journals(result)[:MOST]
    over, reach = span(result), {name: _reach(result, name) for name in names}
    same = max(reach.values()) <= ALIKE * min(reach.values())
    panels = Panels([(SIDE, SIDE)] * len(names), 2 if len(names) == 4 else MOST_COLUMNS, across=0.95, down=0.95)
    for ax, name in zip(panels.axes, names, strict=True):
        half = max(reach.values()) if same else reach[name]
        factor, unit = length_unit(max(result.record.assembly.mechanism.clearances[one].clearance for one in (names if same else [name])))
        _journal(ax, result, name, factor, over.first)
        square(ax, factor * half)
        ax.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"joint {name}")
    scales = "" if same or len(names) < 2 else ", scales differ"
    return panels.close(f"{result.name}: journal centres in their bearings{said_shortly(result, over)}{scales}")


def journals(result: View) -> list[str]:
    """Revolute joints with clearance: those whose journal moves inside a circle."""
    return list(result.record.assembly.mechanism.clearances)


def seen_from_bearing(result: View, name: str) -> Array:
    """Centre of a journal from that of its bearing (m), in the frame of the bearing's body, shape (outputs, 2)."""
    record = result.record
    away = eccentricity(record)[:, list(record.assembly.contacts).index(name)]
    angle = turning(record, record.assembly.mechanism.joints[name].sides[0][0])[0]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]], axis=1)


def _reach(result: View, name: str) -> float:
    away = seen_from_bearing(result, name)
    return 1.08 * max(result.record.assembly.mechanism.clearances[name].clearance, float(np.hypot(*away.T).max()))


def _journal(ax: Axes, result: View, name: str, factor: float, first: int) -> None:
    record = result.record
    x, y = factor * seen_from_bearing(result, name).T
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    radius = factor * record.assembly.mechanism.clearances[name].clearance
    ax.plot(radius * np.cos(turn), radius * np.sin(turn), color=INK, lw=0.9, ls=(0, (5, 3)), label="clearance circle", zorder=5)
    if first > 0:
        dots = np.unique(np.linspace(0, first, min(first + 1, MOST_DOTS)).astype(int))
        ax.plot(x[dots], y[dots], color=SKY, ls="", marker=".", ms=2.2, mew=0.0, alpha=0.8, label="before", zorder=2, rasterized=True)
    ax.plot(x[first:], y[first:], color=BLUE, lw=0.9, label="journal centre", zorder=3)
    if not record.static:
        modes = result.channels["mode"].values[:, list(record.assembly.contacts).index(name)]
        began = (np.arange(len(x)) > first) & (modes == IMPACT)
        if began.any():
            ax.plot(x[began], y[began], color=VERMILION, ls="", marker="o", ms=3.2, mew=0.0, label="a contact began", zorder=4)
    ax.plot(0.0, 0.0, color=GREY, ls="", marker="+", ms=8, mew=1.2, label="bearing centre", zorder=4)


def square(ax: Axes, half: float) -> None:
    """Equal scales to both sides of the origin, with few round ticks."""
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    ax.set(xlim=(-half, half), ylim=(-half, half))
    ax.set_aspect("equal")
