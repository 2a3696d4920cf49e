"""Charts of the paper's page: panels of lines, bands and circles, described as plain data."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib import rc_context
from matplotlib.ticker import LogFormatter, MaxNLocator

from vfife.plots.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    SKY,
    STYLE,
    VERMILION,
    one_legend,
    panels,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .contents import Chart, Panel

LOOKS: dict[str, dict[str, Any]] = {
    "main": {"color": BLUE, "lw": 1.3, "zorder": 4},
    "second": {"color": VERMILION, "lw": 1.2, "zorder": 4},
    "third": {"color": GREEN, "lw": 1.2, "zorder": 4},
    "fourth": {"color": PURPLE, "lw": 1.2, "zorder": 4},
    "fifth": {"color": ORANGE, "lw": 1.2, "zorder": 4},
    "ideal": {"color": VERMILION, "lw": 1.5, "ls": (0, (5, 2)), "zorder": 3},
    "paper": {"color": INK, "lw": 1.6, "ls": (0, (4, 2)), "marker": "s", "ms": 4.5, "zorder": 7},
    "circle": {"color": GREY, "lw": 1.0, "ls": (0, (5, 3)), "zorder": 3},
    "faint": {"color": SKY, "lw": 0.6, "alpha": 0.6, "zorder": 2},
}
DOTS = {"ls": "", "marker": "o", "ms": 3.5, "alpha": 0.7, "mew": 0.0, "zorder": 5}


@rc_context(STYLE)
def drawn(chart: Chart) -> Figure:
    """Draw the figure of a chart."""
    columns = min(chart.columns, len(chart.panels))
    equal = any(panel.equal for panel in chart.panels)
    width, height = (3.5, 3.7) if equal else {1: (7.0, 3.6), 2: (5.2, 3.4)}.get(columns, (4.1, 3.2))
    figure, axes = panels(len(chart.panels), columns, width, height, equal=equal)
    for ax, panel in zip(axes, chart.panels, strict=True):
        _panel(ax, panel)
    one_legend(figure, axes)
    return figure


def _panel(ax: Axes, panel: Panel) -> None:
    labels: set[str] = set()
    for band in panel.bands:
        label = band.label if band.label not in labels else None
        labels.add(band.label)
        ax.axvspan(band.first, band.last, color=SKY, alpha=0.25, lw=0.0, label=label, zorder=1)
    for ribbon in panel.ribbons:
        colour = _look(ribbon.style)["color"]
        ax.fill_between(ribbon.x, ribbon.low, ribbon.high, color=colour, alpha=0.2, lw=0.0, zorder=1)
    for line in panel.lines:
        look = _look(line.style) | (DOTS if line.dots else {})
        ax.plot(line.x, line.y, label=line.label or None, **look)
    ax.set(title=panel.title, xlabel=panel.x, ylabel=panel.y)
    for name in panel.logarithmic:
        (ax.set_xscale if name == "x" else ax.set_yscale)("log")
        # Powers of ten are mathematical text by default, which the style switches off.
        (ax.xaxis if name == "x" else ax.yaxis).set_major_formatter(LogFormatter())
    if panel.equal:
        reach = 1.08 * max(float(np.abs(values).max()) for line in panel.lines for values in (line.x, line.y))
        ax.set(xlim=(-reach, reach), ylim=(-reach, reach))
        ax.set_aspect("equal")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    elif not panel.logarithmic:
        ax.margins(x=0.02)
        if panel.x.startswith("crank angle"):
            ax.set_xticks(np.arange(np.ceil(ax.dataLim.x0 / 60.0 - 0.01) * 60.0, ax.dataLim.x1 + 1.0, 60.0))


def _look(style: str) -> dict[str, Any]:
    if not style.isdigit():
        return LOOKS[style]
    colours = matplotlib.colormaps["tab20"].colors  # type: ignore[attr-defined]
    number = int(style)
    return {
        "color": colours[(2 * number) % 20 + (2 * number) // 20 % 2],
        "lw": 1.3,
        "marker": "o",
        "ms": 3.0,
        "zorder": 4,
    }


@rc_context(STYLE)
def picture(chart: Chart) -> bytes:
    """Render a chart as PNG."""
    buffer = io.BytesIO()
    drawn(chart).savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()


def embedded(data: bytes) -> str:
    """PNG as the source of an image on a page."""
    return "data:image/png;base64," + base64.b64encode(data).decode()
