"""Which number matters: elasticities of measures as bars, the longest on top."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context

from .style import BLUE, GREY, INK, STYLE, VERMILION, heading, panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.derivatives import Sensitivity

BARS = 10  # of a measure, at the most
MARKS = {"derivative": "", "change": " *", "unknown": " ?"}
PANELS = 6  # measures in one figure, at the most


@rc_context(STYLE)
def tornado(found: Sensitivity) -> Figure:
    """By how many per cent measures change with one per cent of each number; hatched, and to the left, where they fall. Thin lines are ranges.

    A bar is an elasticity; with a star at its number it is the change for 1 %, which the derivative does not describe. A number whose effect is
    not known has a question mark and no bar; of a measure that the run's companions do not agree on there is the question mark alone. Measures
    that are zero are left out.
    """
    names = [name for name in found.measures if name in found.doubtful or any(np.isfinite(e) and e for _, e in found.ranked(name))][:PANELS]
    figure, axes = panels(max(1, len(names)), 2, 5.4, 0.9 + 0.24 * BARS)
    for ax, name in zip(axes, names, strict=False):
        ax.set_title(name)
        if name in found.doubtful:
            ax.text(0.5, 0.5, "?\ncompanions part:\nderivatives mean nothing", ha="center", va="center", transform=ax.transAxes, color=GREY)
            ax.set(xticks=[], yticks=[])
            continue
        effects = [one for one in found.effects(name) if np.isfinite(one.value)][:BARS]
        places = np.arange(len(effects))
        values = [0.0 if one.kind == "unknown" else one.value for one in effects]
        bars = ax.barh(places, values, height=0.66, color=[BLUE if value > 0.0 else VERMILION for value in values])
        for bar, value in zip(bars, values, strict=True):
            bar.set_hatch("" if value > 0.0 else "////")
            bar.set_edgecolor("white")
        for place, one in zip(places, effects, strict=True):
            if one.kind != "unknown":
                ax.hlines(place, one.low, one.high, color=INK, lw=1.0)
        ax.axvline(0.0, color=GREY, lw=0.8)
        ax.set_yticks(places, [f"{one.path}{MARKS[one.kind]}" for one in effects], fontsize=8)
        ax.invert_yaxis()
        ax.grid(axis="y", visible=False)
        ax.set_xlabel("% by 1 % (* change for 1 %)" if any(one.kind == "change" for one in effects) else "% by 1 %")
    for ax in axes[len(names) :]:
        ax.set_visible(False)
    heading(figure, f"{found.mechanism}: what its measures depend on")
    return figure
