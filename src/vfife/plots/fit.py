"""A fit: measured curves with the model's, what is left of each, and how the parameters hang together."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context

from .style import BLUE, FAINT, GREY, INK, STYLE, VERMILION, heading, panels, readable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.fit import Fit, Laid

CURVES = 4  # in one figure, at the most
SAMPLES = 4000  # drawn of each
ABSCISSAE = {
    "time": (1e3, "time (ms)"), "angle": (180.0 / math.pi, "crank angle (°)"), "penetration": (1e6, "penetration (µm)"),
    "frequency": (1.0, "frequency (Hz)"), "order": (1.0, "order"),
}  # fmt: skip


@rc_context(STYLE)
def fit_figure(found: Fit) -> Figure:
    """Above each other a curve and what is left of it; on the right the parameters between their bounds with their confidence, and correlations."""
    curves = found.curves[:CURVES]
    figure, axes = panels(3 * len(curves), 3, 4.0, 2.7, width_ratios=(1.6, 1.2, 1.2))
    for k, one in enumerate(curves):
        laid(axes[3 * k], one, k == 0)
        residual(axes[3 * k + 1], one)
    ranges(axes[2], found)
    shown = len(curves) > 1 and len(found.values) > 1 and bool(np.isfinite(found.correlation).all())
    if shown:
        correlations(axes[5], found)
    for k in range(1 + shown, len(curves)):
        axes[3 * k + 2].set_visible(False)
    heading(figure, f"{found.mechanism} fitted to {found.data}: residual {100.0 * found.share:.3g} %")
    return figure


def abscissa(one: Laid) -> tuple[Any, str]:
    """Places and what they are."""
    factor, label = ABSCISSAE[one.over]
    return factor * one.places, label


def laid(ax: Axes, one: Laid, first: bool) -> None:
    """Measured and model's values."""
    every = max(1, len(one.places) // SAMPLES)
    x, label = abscissa(one)
    factor, unit = readable(one.measured, one.unit)
    ax.plot(x[::every], factor * one.measured[::every], ".", color=GREY, ms=2.5, label="measured")
    ax.plot(x[::every], factor * one.model[::every], color=BLUE, lw=1.1, label="model")
    ax.set(title=one.channel, xlabel=label, ylabel=unit if one.unit != "1" else "")
    if first:
        ax.figure.legend(*ax.get_legend_handles_labels(), loc="outside lower left", ncols=2, markerscale=3.0)  # curves fill the axes


def residual(ax: Axes, one: Laid) -> None:
    """What is left, in per cent of the measured standard deviation."""
    spread = float(one.measured.std()) or 1.0
    x, label = abscissa(one)
    ax.plot(x, 100.0 * (one.measured - one.model) / spread, color=VERMILION, lw=0.7)
    ax.axhline(0.0, color=GREY, lw=0.8)
    ax.set(title=f"left: {100.0 * one.share:.3g} %", xlabel=label, ylabel="% of the deviation")


def ranges(ax: Axes, found: Fit) -> None:
    """Where each parameter lies between its bounds, with its confidence."""
    for k, one in enumerate(found.values):
        at, ends = one.share(one.value), [one.share(end) for end in (one.low, one.high)]
        if all(map(math.isfinite, ends)):
            ax.plot(np.clip(ends, 0.0, 1.0), [k, k], color=INK if one.told else VERMILION, lw=3.0, solid_capstyle="butt")
        ax.plot([at], [k], "o", color=INK if one.told else VERMILION, ms=5.0)
    ax.set_yticks(range(len(found.values)), [short(one.name) for one in found.values], fontsize=8)
    ax.set(xlim=(0.0, 1.0), ylim=(len(found.values) - 0.5, -0.5), xlabel="from bound to bound", title=f"{100.0 * found.confidence:g} % confidence")


def correlations(ax: Axes, found: Fit) -> None:
    """Correlation of each pair of parameters."""
    ax.imshow(found.correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
    names = [short(one.name) for one in found.values]
    ax.set_xticks(range(len(names)), names, rotation=30, ha="right", fontsize=8)
    ax.set_yticks(range(len(names)), names, fontsize=8)
    for row, line in enumerate(found.correlation):
        for column, value in enumerate(line):
            ax.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=8, color=INK if abs(value) < 0.6 else FAINT)
    ax.grid(visible=False)
    ax.set_title("correlation")


def short(name: str) -> str:
    """A path without what all paths of its kind begin with."""
    first = name.split(",")[0]
    return first.split(".", 1)[1] if first.count(".") > 1 else first
