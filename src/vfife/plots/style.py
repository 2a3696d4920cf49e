"""One look for all figures: colours that the colour-blind can tell apart (Okabe and Ito 2008), large enough letters, little ink."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7"
INK, GREY, FAINT = "#222222", "#767676", "#d9d9d9"
BODIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)

STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "lines.linewidth": 1.4,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "figure.facecolor": "white",
    "savefig.dpi": 160,
}


def panels(rows: int, columns: int, width: float, height: float, **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure with a grid of axes (inches for each), and the axes row by row."""
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    return figure, list(axes.flat)


def length_unit(size: float) -> tuple[float, str]:
    """Factor and name of the unit (µm, mm or m) in which a length (m) reads well."""
    if size < 1e-4:
        return 1e6, "µm"
    return (1e3, "mm") if size < 1.0 else (1.0, "m")


def prefix_of(size: float, unit: str) -> tuple[float, str]:
    """Factor and unit with the prefix (none, k or M) in which a quantity reads well."""
    for limit, factor, prefix in ((2e6, 1e-6, "M"), (2e3, 1e-3, "k")):
        if size >= limit:
            return factor, f"{prefix}{unit}"
    return 1.0, unit
