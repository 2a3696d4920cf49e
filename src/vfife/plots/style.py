"""Common style of all figures: colours for the colour-blind (Okabe and Ito 2008), units, recurring elements;
figures as files.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable
from html import escape
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib
import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..files import replacement
from ..measures.values import Measured
from ..report.amounts import interval
from ..report.digits import CERTAIN, SCATTER, fineness

Array = NDArray[np.float64]
BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7"
DEEP = "#003B5C"  # peaks, beside BLUE
SYMBOLS, LOADS = "#5B4B3A", "#5500CC"  # of springs, and of forces, unlike the colours of bodies
INK, GREY, FAINT = "#222222", "#767676", "#d9d9d9"
MOST_DOTS = 20_000
SCREEN = 96.0  # pixels an inch of figures on a screen
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
BODIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)

IDEAL: Any = {"color": VERMILION, "lw": 1.3, "ls": (0, (5, 1.6)), "label": "ideal joints"}
DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1)))  # of curves beyond the number of colours
CENTRE: Any = {"ha": "center", "va": "center"}
TEXT_BOX: Any = CENTRE | {
    "weight": "bold",
    "bbox": {"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.75},
    "zorder": 9,
}
PICTURES = (".svg", ".pdf", ".png")
PREFIXED = ("N", "N m", "Pa", "J", "W")
LENGTHS = ((1.0, 1.0, "m"), (1e-4, 1e3, "mm"), (1e-7, 1e6, "µm"), (0.0, 1e9, "nm"))  # from so much on
# From so much on
SCALES = (
    (2e9, 9, "G"),
    (2e6, 6, "M"),
    (2e3, 3, "k"),
    (0.02, 0, ""),
    (2e-5, -3, "m"),
    (2e-8, -6, "µ"),
    (0.0, -9, "n"),
)

STYLE: Any = {  # matplotlib types its settings by their names
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
    "axes.formatter.use_mathtext": False,
    "text.parse_math": False,  # names of bodies and joints are text, dollars and all
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
    "svg.fonttype": "path",
}


class NotebookFigure(Figure):
    """A figure that a notebook displays by itself, without ``%matplotlib inline``."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        with rc_context(STYLE):
            self.savefig(stream, format="png", dpi=SCREEN)
        return stream.getvalue()


class Figures(dict[str, Figure]):
    """Figures by name, which a notebook displays below each other."""

    def _repr_html_(self) -> str:
        return "".join(picture(figure, name) for name, figure in self.items())


@rc_context(STYLE)
def picture(figure: Figure, words: str, dpi: float = SCREEN) -> str:
    """Return a figure as PNG in an HTML element; ``words`` describe it, ``dpi`` are pixels per inch."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=dpi)
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    return (
        f'<img alt="{escape(words)}" width="{96.0 * figure.get_figwidth():.0f}" style="max-width: 100%"'
        f' src="data:image/png;base64,{data}">'
    )


def panels(
    count: int, columns: int, width: float, height: float, *, equal: bool = False, **options: Any
) -> tuple[Figure, list[Axes]]:
    """Return a figure with ``count`` axes of a size (inches) in rows of up to ``columns``, and the axes;
    ``equal`` if their scales will be.
    """
    columns = min(columns, count)
    rows = -(-count // columns)
    figure = NotebookFigure(
        figsize=(width * columns, height * rows), layout="compressed" if equal else "constrained"
    )
    axes = list(figure.subplots(rows, columns, squeeze=False, **options).flat)
    for ax in axes[count:]:
        ax.set_visible(False)
    return figure, axes[:count]


def length_unit(size: float) -> tuple[float, str]:
    """Return factor and name of the unit (nm to m) that suits a length (m)."""
    return next((factor, name) for threshold, factor, name in LENGTHS if size >= threshold)


def power_of_ten(power: int) -> str:
    """Return a power of ten as it is written."""
    return f"10{str(power).translate(RAISED)}"


def scale_of(size: float, unit: str) -> tuple[float, str]:
    """Return factor and unit that suit a quantity: kN, MPa or mJ for units that take a prefix, powers of ten
    for others.
    """
    if unit == "m":
        return length_unit(size)
    unit = "" if unit == "1" else unit.replace("^2", "²")
    if not 0.0 < size < float("inf"):
        return 1.0, unit
    power, prefix = next((power, prefix) for limit, power, prefix in SCALES if size >= limit)
    if power == 0:
        return 1.0, unit
    return (10.0**-power, f"{prefix}{unit}" if unit in PREFIXED else f"{power_of_ten(power)} {unit}".strip())


RPM = 30.0 / np.pi  # revolutions per minute in 1 rad/s


def readable(values: Any, unit: str) -> tuple[float, str]:
    """Return factor and unit that suit the largest of some values."""
    sizes = np.abs(np.asarray(values, dtype=float))
    return scale_of(float(np.max(sizes, initial=0.0, where=np.isfinite(sizes))), unit)


def digits(value: float) -> str:
    """Return a number with four digits."""
    return f"{value:.4g}" if 1e-3 <= abs(value) < 1e5 or value == 0.0 else f"{value:.3e}"


def peak_digits(peak: float, factor: float) -> str:
    """Return a peak, or its range where two digits of it are not certain, with the digits of the answer."""
    if not (isinstance(peak, Measured) and peak.estimated and peak.width > CERTAIN * abs(peak)):
        return digits(factor * peak)
    low, high, width = (factor * size for size in (peak.low, peak.high, peak.width))
    return interval(low, high, "", width, prefix=False).strip()


def turns_digits(peak: float, factor: float, motion: str) -> str:
    """Return the range of single turns of a mean over turns, with the digits of the answer; "" where the
    answer has none, because turns hardly differ or lie within the range of the mean.
    """
    if not isinstance(peak, Measured) or peak.variation <= SCATTER * peak.highest:
        return ""
    if peak.estimated and peak.low <= peak.lowest and peak.highest <= peak.high:
        return ""
    low, high, width = (factor * size for size in (peak.lowest, peak.highest, peak.variation))
    return interval(low, high, "", fineness(motion) * width, prefix=False).strip()


def curve_look(k: int) -> dict[str, Any]:
    """Return colour and dashes of the curve number ``k``."""
    return {"color": BODIES[k % len(BODIES)], "ls": DASHES[k // len(BODIES) % len(DASHES)]}


def circle(radius: float, points: int = 361) -> Array:
    """Return the coordinates of a circle about the origin, shape (2, points)."""
    angle = np.linspace(0.0, 2.0 * np.pi, points)
    return radius * np.stack([np.cos(angle), np.sin(angle)])


def corner_text(ax: Axes, text: str) -> None:
    """Write a number over the right end of axes."""
    ax.set_title(text, loc="right", fontsize=9, fontweight="normal")


def mark_peak(ax: Axes, x: Any, y: Any, upwards: bool, label: str) -> None:
    """Mark the largest value of a curve by a triangle."""
    ax.plot(
        x, y, ls="", marker="v" if upwards else "^", ms=5, color=DEEP, mec=INK, mew=0.5, zorder=6, label=label
    )


def dots_before(ax: Axes, x: Any, y: Any, first: int, **look: Any) -> None:
    """Draw the outputs before the part that is shown, ``MOST_DOTS`` at most, as dots."""
    if first > 0:
        dots = np.unique(np.linspace(0, first, min(first + 1, MOST_DOTS)).astype(int))
        style: dict[str, Any] = {"color": SKY, "ls": "", "marker": ".", "ms": 2.2, "mew": 0.0, "zorder": 2}
        ax.plot(x[dots], y[dots], label="before", rasterized=True, **(style | look))


def legend_entries(axes: Iterable[Axes]) -> dict[str, Any]:
    """Return the handle of each label in any of the axes, the first of several."""
    entries: dict[str, Any] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    return entries


def one_legend(figure: Figure, axes: Iterable[Axes]) -> None:
    """Add a legend below the panels with every label of any of them, if there is more than one."""
    entries = legend_entries(axes)
    if len(entries) > 1:
        columns = min(len(entries), max(1, int(figure.get_figwidth() / 1.9)))
        figure.legend(list(entries.values()), list(entries), loc="outside lower center", ncols=columns)


def heading(figure: Figure, text: str, progress: str = "") -> None:
    """Add a title over all panels, broken if the figure is too narrow; it begins with the ``progress`` of a
    result that is not complete.
    """
    text = f"not complete, {progress}; {text}" if progress else text
    figure.suptitle("\n".join(wrap(text, max(20, int(10.0 * figure.get_figwidth())), break_on_hyphens=False)))


@rc_context(STYLE)
def saved(figure: Figure, path: Path) -> Path:
    """Write a figure to a temporary file and rename it; the ending of ``path`` chooses PNG, PDF or SVG."""
    kind, by = path.suffix.lower().removeprefix("."), f"vfife, Matplotlib {matplotlib.__version__}"
    with replacement(path) as temporary:
        figure.savefig(
            temporary,
            format=kind,
            metadata={"png": {"Software": by}, "pdf": {"Creator": by}, "svg": {"Creator": by}}.get(kind),
        )
    return path
