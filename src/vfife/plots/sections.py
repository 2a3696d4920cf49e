"""Poincaré sections: what a motion is once a turn, how its exponent converges, and where, when and how fast its contacts begin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .bifurcation import readable
from .style import BLUE, GREY, INK, VERMILION, heading, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..study.maps.sections import PoincareSection

MARK = 9.0  # area of a point
BOX = {"boxstyle": "square,pad=0.2", "fc": "white", "ec": "none"}


def section(found: PoincareSection) -> Figure:
    """Points once a turn (of one series over those a turn before), the running mean of the exponent, and below them the onsets of each joint."""
    rows = 1 + len(found.struck)
    figure, axes = panels(rows, 2, 4.7, 3.6)
    points(axes[0], found)
    converging(axes[1], found)
    for k, name in enumerate(found.struck, 1):
        strikes(axes[2 * k], axes[2 * k + 1], found, name)
    asked = found.asked
    told = f"{found.done:,} turns after {asked.dropped:,}, {asked.steps:,} steps a turn"
    heading(figure, f"{found.name}: {found.verdict.kind}; {told}; {found.laws}; no companions")
    return figure


def points(ax: Axes, found: PoincareSection) -> None:
    """The section at one phase of the crank: the second series over the first, or the only one over itself a turn before."""
    units = dict(zip(found.asked.series, found.asked.units, strict=True))
    names = list(found.points)[:2]
    x, y = found.points[names[0]], found.points[names[-1]]
    label = names[-1]
    if len(names) == 1:
        x, y, label = x[:-1], y[1:], f"{label} a turn later"
    (scale_x, unit_x), (scale_y, unit_y) = readable(x, units[names[0]]), readable(y, units[names[-1]])
    ax.scatter(scale_x * x, scale_y * y, s=MARK, c=BLUE, lw=0.0)
    ax.set_xlabel(f"{names[0]} ({unit_x})")
    ax.set_ylabel(f"{label} ({unit_y})")
    ax.set_title(f"once a turn, at {360.0 * found.asked.phase:g}° of it")
    ax.ticklabel_format(useOffset=False)


def converging(ax: Axes, found: PoincareSection) -> None:
    """The mean growth of a small difference up to each turn, with those of both halves."""
    exponent = found.exponent
    ax.axhline(0.0, color=GREY, lw=0.8)
    if exponent is not None:
        turns = found.asked.dropped + 1 + np.arange(len(exponent.running))
        ax.plot(turns, exponent.running, color=BLUE, lw=1.2)
        ax.axhspan(exponent.low, exponent.high, color=VERMILION, alpha=0.2, lw=0.0)
        told = f"{exponent.value:+.4g}; halves {exponent.low:+.4g}, {exponent.high:+.4g}"
        low = exponent.value > float(exponent.running.min()) * 0.5 + float(exponent.running.max()) * 0.5  # where the curve is not
        ax.text(0.98, 0.1 if low else 0.9, told, transform=ax.transAxes, ha="right", color=INK, fontsize=9.0, bbox=BOX)
    ax.set_title("largest exponent, as it converges")
    ax.set_xlabel("turn")
    ax.set_ylabel("mean growth (1/turn)")


def strikes(left: Axes, right: Axes, found: PoincareSection, name: str) -> None:
    """Onsets of a joint over the angle of the crank: where on the bearing, in the colours of their speed, and the speed itself."""
    one = found.struck[name]
    crank = np.degrees(np.mod(one["crank"], 2.0 * np.pi))
    scale, unit = readable(one["speed"], "m/s")
    place = np.degrees(one["place"])
    for ax, high in ((left, scale * one["speed"]), (right, scale * one["speed"])):
        ax.set_xlim(0.0, 360.0)
        ax.set_xticks(np.arange(0.0, 361.0, 90.0))
        ax.set_xlabel("angle of the crank (°)")
        if ax is right or not np.isfinite(place).any():
            ax.scatter(crank, high, s=MARK, c=BLUE, lw=0.0)
            ax.set_ylabel(f"speed of approach ({unit})")
    left.set_title(f"{name}: {len(crank):,} contact{'' if len(crank) == 1 else 's'} began")
    if np.isfinite(place).any():
        drawn = left.scatter(crank, place, s=MARK, c=scale * one["speed"], cmap="viridis", lw=0.0)
        left.set_ylim(0.0, 360.0)
        left.set_yticks(np.arange(0.0, 361.0, 90.0))
        left.set_ylabel("place round the bearing (°)")
        left.figure.colorbar(drawn, ax=left, label=f"speed of approach ({unit})")
