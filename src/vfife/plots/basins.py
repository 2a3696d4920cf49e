"""Basins as a map: each start in the colour of the motion to which it comes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from .bifurcation import readable
from .style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, PURPLE, SKY, VERMILION, heading, panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..study.maps.basins import Basins

PERIODIC = (BLUE, ORANGE, GREEN, SKY, PURPLE, "#F0E442", "#5B4B3A")
OTHERS = {"chaotic": VERMILION, "quasi-periodic": "#44AA99", "not settled": GREY, "not decided": "#DDAA33", "diverged": INK}


def colours(found: Basins) -> list[str]:
    """A colour for each attractor."""
    left = iter(PERIODIC * (1 + len(found.attractors) // len(PERIODIC)))
    return [OTHERS.get(one.kind) or next(left) for one in found.attractors]


def basins(found: Basins) -> Figure:
    """The grid, with the share of each attractor among all starts; white is what is no start, crosses where companions are told otherwise."""
    asked = found.asked
    figure, (ax,) = panels(1, 1, 8.0, 7.0)
    scales = [readable(np.degrees(values) if unit == "rad" else np.array(values), "°" if unit == "rad" else unit) for values, unit in
              ((asked.x, asked.units[0]), (asked.y, asked.units[1]))]  # fmt: skip
    x, y = (
        np.array(values) * scale * (180.0 / np.pi if unit == "rad" else 1.0)
        for values, unit, (scale, _) in zip((asked.x, asked.y), asked.units, scales, strict=True)
    )
    colour = colours(found)
    if colour:
        mesh = np.ma.masked_invalid(found.labels)
        norm = BoundaryNorm(np.arange(len(colour) + 1) - 0.5, len(colour)) if len(colour) > 1 else None
        ax.pcolormesh(x, y, mesh, cmap=ListedColormap(colour), norm=norm, shading="nearest", rasterized=True)
    crosses = []
    differ = [one for one in found.companions if one.number in found.verdicts and one.kind != found.verdicts[one.number].kind]
    if differ:
        columns, rows = np.array([(one.number % len(x), one.number // len(x)) for one in differ]).T
        crosses.append(ax.scatter(x[columns], y[rows], marker="x", c=INK, s=50.0, label="another with another step"))
    ax.set_xlabel(f"{asked.paths[0]} ({scales[0][1]})")
    ax.set_ylabel(f"{asked.paths[1]} ({scales[1][1]})")
    ax.grid(visible=False)
    ax.set_facecolor("white")
    of_all = max(len(found.verdicts), 1)
    told = [f"{one.kind}: {100.0 * len(one.members) / of_all:.3g} %" for one in found.attractors]
    shares = [Patch(fc=own, ec=FAINT, label=words) for own, words in zip(colour, told, strict=True)]
    figure.legend(handles=[*shares, *crosses], loc="outside lower center", ncols=3)
    said = f"{len(found.verdicts):,} starts, {asked.turns - asked.dropped} turns after {asked.dropped}, {asked.steps:,} steps a turn"
    heading(figure, f"{found.name}: {said}; {found.laws}; {found.alike}")
    return figure
