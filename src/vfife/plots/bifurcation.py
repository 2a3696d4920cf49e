"""A bifurcation diagram: what a motion is like once a turn over a number that is swept up and down, with the exponent by which motions part."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .style import BLUE, GREY, VERMILION, heading, length_unit, panels, scale_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..study.maps import Bifurcation

WAYS = (("way up", BLUE, "o", 1.6), ("way down", VERMILION, "x", 2.6))


def readable(values: Any, unit: str) -> tuple[float, str]:
    """Factor and unit in which numbers of a unit read well."""
    size = float(np.nanmax(np.abs(values), initial=0.0))
    return length_unit(size) if unit == "m" else scale_of(size, unit)


def diagram(found: Bifurcation) -> Figure:
    """Points of each series, the way up as dots and the way down as crosses, and below them the largest Lyapunov exponent, above zero of chaos."""
    rows = len(found.points) + 1
    figure, axes = panels(rows, 1, 9.0, 2.7, sharex=True)
    values = np.array(found.asked.values)
    scale, unit_x = readable(values, found.asked.unit)
    x = scale * values
    for ax, (name, points) in zip(axes, found.points.items(), strict=False):
        factor, unit = readable(points, dict(zip(found.asked.series, found.asked.units, strict=False)).get(name, "SI"))
        for (label, color, marker, area), chain in zip(WAYS, points, strict=True):
            across = np.repeat(x, chain.shape[1])
            ax.scatter(
                across, factor * chain.ravel(), s=area, c=color, marker=marker, lw=0.5 if marker == "x" else 0.0, label=label, rasterized=True
            )
        ax.set_ylabel(f"{name}\n({unit}), once a turn")
        ax.margins(x=0.01)
    last = axes[-1]
    for (_, color, marker, _), chain in zip(WAYS, found.exponents, strict=True):
        last.fill_between(x, chain[:, 1], chain[:, 2], color=color, alpha=0.25, lw=0.0)
        last.plot(x, chain[:, 0], color=color, lw=1.0, marker=marker, ms=2.0)
    last.axhline(0.0, color=GREY, lw=0.8)
    last.set_ylabel("largest exponent\n(1/turn)")
    last.set_xlabel(f"{found.asked.path} ({unit_x})")
    axes[0].legend(loc="upper left", markerscale=4.0, ncols=2)
    told = f"{found.asked.turns - found.asked.dropped} turns at each value after {found.asked.dropped}, {found.asked.steps:,} steps a turn"
    heading(figure, f"{found.name}: {told}")
    return figure
