"""Which number matters: elasticities of measures as bars, the longest on top."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .style import BLUE, GREY, INK, VERMILION, heading, panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.derivatives import Sensitivity

BARS = 10  # of a measure, at the most
PANELS = 6  # measures in one figure, at the most


def tornado(found: Sensitivity) -> Figure:
    """By how many per cent measures change with one per cent of each number; hatched, and to the left, where they fall. Thin lines are ranges.

    Where displaced runs do not agree on a sign, a bar is grey and its number has a question mark; of a measure that the run's companions do not
    agree on there is the question mark alone. Measures that are zero are left out.
    """
    names = [name for name in found.measures if name in found.doubtful or any(np.isfinite(e) and e for _, e in found.ranked(name))][:PANELS]
    columns = min(2, max(1, len(names)))
    rows = max(1, -(-len(names) // columns))
    figure, axes = panels(rows, columns, 5.4, 0.9 + 0.24 * BARS)
    for ax, name in zip(axes, names, strict=False):
        ax.set_title(name)
        if name in found.doubtful:
            ax.text(0.5, 0.5, "?\ncompanions part:\nderivatives mean nothing", ha="center", va="center", transform=ax.transAxes, color=GREY)
            ax.set(xticks=[], yticks=[])
            continue
        ranked = [(path, value) for path, value in found.ranked(name) if np.isfinite(value)][:BARS]
        places, values = np.arange(len(ranked)), [value for _, value in ranked]
        known = [found.known(name, path) for path, _ in ranked]
        colours = [GREY if not sure else BLUE if value > 0.0 else VERMILION for sure, value in zip(known, values, strict=True)]
        bars = ax.barh(places, values, height=0.66, color=colours)
        for bar, value in zip(bars, values, strict=True):
            bar.set_hatch("" if value > 0.0 else "////")
            bar.set_edgecolor("white")
        low, high = np.array([found.span(name, path) for path, _ in ranked]).T
        ax.hlines(places, low, high, color=INK, lw=1.0)
        ax.axvline(0.0, color=GREY, lw=0.8)
        ax.set_yticks(places, [path if sure else f"{path} ?" for (path, _), sure in zip(ranked, known, strict=True)], fontsize=8)
        ax.invert_yaxis()
        ax.grid(axis="y", visible=False)
        ax.set_xlabel("% by 1 %")
    for ax in axes[len(names) :]:
        ax.set_visible(False)
    heading(figure, f"{found.mechanism}: what its measures depend on")
    return figure
