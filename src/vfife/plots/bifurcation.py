"""A bifurcation diagram: what a motion is like once a turn over a number, reached from both sides or from starts, and the exponent by which
motions part."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .style import BODIES, GREY, VERMILION, heading, length_unit, panels, scale_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..study.maps.bifurcation import Bifurcation

MARKERS = (("o", 1.6), ("x", 2.6), ("^", 2.6), ("s", 1.6), ("+", 4.0), ("v", 2.6))  # with the area of each
NAMES = {"up": "way up", "down": "way down"}


def readable(values: Any, unit: str) -> tuple[float, str]:
    """Factor and unit in which numbers of a unit read well."""
    size = float(np.nanmax(np.abs(values), initial=0.0))
    return length_unit(size) if unit == "m" else scale_of(size, unit)


def diagram(found: Bifurcation) -> Figure:
    """Points of each series, each way or start in a mark of its own, and below them the largest Lyapunov exponent, above zero of chaos.

    Rings are round values where companions with other steps are told to be something else.
    """
    rows = len(found.points) + 1
    figure, axes = panels(rows, 1, 9.0, 2.7, sharex=True)
    values = np.array(found.asked.values)
    scale, unit_x = readable(values, found.asked.unit)
    x = scale * values
    for ax, (name, points) in zip(axes, found.points.items(), strict=False):
        factor, unit = readable(points, dict(zip(found.asked.series, found.asked.units, strict=False)).get(name, "SI"))
        for k, (way, chain) in enumerate(zip(found.asked.ways, points, strict=True)):
            marker, area = MARKERS[k % len(MARKERS)]
            across, color, width = np.repeat(x, chain.shape[1]), BODIES[k % len(BODIES)], 0.5 if marker in "x+" else 0.0
            ax.scatter(across, factor * chain.ravel(), s=area, c=color, marker=marker, lw=width, label=NAMES.get(way, way), rasterized=True)
        ax.set_ylabel(f"{name}\n({unit}), once a turn")
        ax.margins(x=0.01)
    last = axes[-1]
    for k, chain in enumerate(found.exponents):
        color = BODIES[k % len(BODIES)]
        last.fill_between(x, chain[:, 1], chain[:, 2], color=color, alpha=0.25, lw=0.0)
        last.plot(x, chain[:, 0], color=color, lw=1.0, marker=MARKERS[k % len(MARKERS)][0], ms=2.0)
    differ = [one for one in found.companions if one.kind != found.kinds[one.way][one.number]]
    if differ:
        at = np.array([(x[one.number], found.exponents[one.way, one.number, 0]) for one in differ])
        last.scatter(
            at[:, 0], at[:, 1], s=70.0, facecolors="none", edgecolors=VERMILION, lw=1.2, label="another motion with other steps", zorder=4.0
        )
        last.legend(loc="lower right")
    last.axhline(0.0, color=GREY, lw=0.8)
    last.set_ylabel("largest exponent\n(1/turn)")
    last.set_xlabel(f"{found.asked.path} ({unit_x})")
    if len(found.asked.ways) > 1:
        axes[0].legend(loc="upper left", markerscale=4.0, ncols=3)
    told = f"{found.asked.turns - found.asked.dropped} turns at each value after {found.asked.dropped}, {found.asked.steps:,} steps a turn"
    heading(figure, f"{found.name}: {told}; {found.laws}; {found.alike}")
    return figure
