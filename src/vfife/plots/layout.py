"""Panels of given sizes on a sheet that has room for their labels, a title and a legend.

matplotlib's constrained layout makes panels of a given sheet smaller instead, and takes as long again as
drawing (1.05 s instead of 0.46 s for four panels, 3.1 s instead of 2.5 s for sixteen).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.ticker import AutoLocator, MaxNLocator

from ..report.parts import NO_BREAK, with_units
from .style import NotebookFigure, legend_entries

# Inches around panels, and between them
LEFT, RIGHT, BOTTOM, TOP, GAP_ACROSS, GAP_DOWN = (0.82, 0.3, 0.55, 0.36, 1.0, 0.72)
TICK_WIDTH, TICK_HEIGHT = 0.62, 0.36  # inches from a label of a tick to the next
DOT, NARROW = 4.0, 4.6  # points of a dot in the legend; inches of the narrowest sheet
# Inches: a line of the legend, one of the title, what stands before a name in the legend
LINE, TITLE, HANDLE = (0.21, 0.26, 0.62)

NEAR_SIGN = 0.4  # share of a line that a word broken behind a sign fills at least

Size = tuple[float, float]  # width and height (inches)
WIDTHS: dict[tuple[str, float, str], float] = {}  # of texts that were measured, which takes long (inches)
MOST_WIDTHS = 10_000


class Panels:
    """Panels in rows of up to ``columns``; ``sizes`` are their widths and heights (inches). Call
    :meth:`close` when all is drawn.
    """

    def __init__(
        self, sizes: Sequence[Size], columns: int, *, down: float = GAP_DOWN, across: float = GAP_ACROSS
    ) -> None:
        self.sizes, self.columns = list(sizes), max(1, min(columns, len(sizes)))
        self.down, self.across = down, across
        self.figure = NotebookFigure(figsize=(4.0, 4.0))
        self.axes: list[Axes] = [
            self.figure.add_axes((0.1, 0.1, 0.8, 0.8), label=str(k)) for k in range(len(self.sizes))
        ]
        self.extra_entries: dict[str, Any] = {}  # of the legend
        self.entries: dict[str, Any] | None = None  # of the legend, in place of the labels in the panels
        self.bars: list[tuple[int, Axes]] = []

    @classmethod
    def alike(cls, count: int, columns: int, size: Size, alone: Size | None = None, **gaps: float) -> Panels:
        """Return the panels of one size; ``alone`` is that of a single one."""
        return cls([size if count > 1 or alone is None else alone] * count, columns, **gaps)

    def label_lowest(self, label: str, hide: bool = False) -> None:
        """Label the abscissa of panels without another one below; ``hide`` the numbers of all others."""
        for k, ax in enumerate(self.axes):
            if k >= len(self.sizes) - self.columns:
                ax.set_xlabel(label)
            elif hide:
                ax.set_xlabel("")
                ax.tick_params(labelbottom=False)

    def scale(self, ax: Axes, drawn: Any, label: str) -> Any:
        """Draw a colour bar to the right of a panel."""
        bar_axes = self.figure.add_axes((0.9, 0.1, 0.05, 0.8), label=f"scale {len(self.bars)}")
        self.bars.append((self.axes.index(ax), bar_axes))
        return self.figure.colorbar(drawn, cax=bar_axes, label=label)

    def close(self, title: str) -> Figure:
        """Place every panel, and give the sheet its size, title and legend."""
        rows = [self.sizes[k : k + self.columns] for k in range(0, len(self.sizes), self.columns)]
        widths = [max(row[c][0] for row in rows if c < len(row)) for c in range(self.columns)]
        heights = [max(height for _, height in row) for row in rows]
        width = LEFT + sum(widths) + self.across * (self.columns - 1) + (RIGHT if not self.bars else 1.0)
        width = max(width, NARROW)
        self._shorten()
        entries = {
            "\n".join(broken(self.figure, name, width - 0.5 - HANDLE, 9.5)): handle
            for name, handle in self._entries().items()
        }
        columns, lines = self._legend(list(entries), width - 0.3)
        title_lines = broken(self.figure, title, width - 0.4, 12.0)
        titled = any(ax.get_title(loc="left") or ax.get_title(loc="center") for ax in self.axes)
        top_margin = (TOP if titled else 0.08) + TITLE * len(title_lines) + 0.08
        bottom_margin = 0.12 + LINE * lines if lines else 0.05
        bottom_margin += BOTTOM if any(ax.get_xlabel() for ax in self.axes) else 0.15
        height = bottom_margin + sum(heights) + self.down * (len(rows) - 1) + top_margin
        self.figure.set_size_inches(width, height)
        for k, (ax, (wide, tall)) in enumerate(zip(self.axes, self.sizes, strict=True)):
            row, column = divmod(k, self.columns)
            x = LEFT + sum(widths[:column]) + self.across * column
            y = height - top_margin - sum(heights[:row]) - self.down * row - tall
            ax.set_position((x / width, y / height, wide / width, tall / height))
            space_ticks(ax, wide, tall)
        for k, bar_axes in self.bars:
            place = self.axes[k].get_position()
            bar_axes.set_position((place.x1 + 0.1 / width, place.y0, 0.14 / width, place.height))
        corner = {"x": 0.2 / width, "y": 1.0 - 0.08 / height}
        self.figure.suptitle("\n".join(title_lines), ha="left", va="top", fontsize=12.0, **corner)
        if lines:
            anchor = (0.12 / width, 0.02 / height)
            self.figure.legend(
                list(entries.values()), list(entries), loc="lower left", bbox_to_anchor=anchor, ncols=columns,
                fontsize=9.5,
                borderpad=0.3, columnspacing=1.2, labelspacing=0.35,
                handler_map={tuple: HandlerTuple(ndivide=1)},
            )  # fmt: skip
        return self.figure

    def _shorten(self) -> None:
        """Cuts titles that would run into what stands at the right, or out of their panel."""
        for ax, (width, _) in zip(self.axes, self.sizes, strict=True):
            right = width_of(self.figure, ax.get_title(loc="right"), 9.0) + 0.15
            small = ax._left_title.get_fontsize(), ax._left_title.get_fontweight()  # type: ignore[attr-defined]  # what set_title gave it
            ax._left_title.set_text(cut_text(self.figure, ax.get_title(loc="left"), width - right, *small))  # type: ignore[attr-defined]

    def _entries(self) -> dict[str, Any]:
        if self.entries is not None:
            return self.entries
        entries = {label: _legend_handle(handle) for label, handle in legend_entries(self.axes).items()}
        entries |= self.extra_entries
        return entries if len(entries) > 1 or self.extra_entries else {}

    def _legend(self, names: list[str], room: float) -> tuple[int, int]:
        """Return the columns and lines of a legend of a width (inches)."""
        if not names:
            return 0, 0
        wide = [
            HANDLE + 0.2 + max(width_of(self.figure, line, 9.5) for line in name.split("\n"))
            for name in names
        ]
        tall = [1 + name.count("\n") for name in names]
        for columns in range(len(names), 0, -1):
            if columns == 1 or sum(float(max(part)) for part in np.array_split(wide, columns)) <= room:
                break
        return columns, max(int(sum(part)) for part in np.array_split(tall, columns))


def space_ticks(ax: Axes, width: float, height: float) -> None:
    """Limit the ticks of axes of a size (inches) so that their labels stay apart, at round numbers."""
    for axis, room in ((ax.xaxis, width / TICK_WIDTH), (ax.yaxis, height / TICK_HEIGHT)):
        if isinstance(axis.get_major_locator(), AutoLocator):
            axis.set_major_locator(MaxNLocator(max(2, int(room)), steps=[1, 2, 5, 10]))


def _legend_handle(handle: Any) -> Any:
    """Return the handle of a line in the legend: dots enlarged and in full colour."""
    if (
        not isinstance(handle, Line2D)
        or handle.get_linestyle() not in ("None", "")
        or handle.get_markersize() >= DOT
    ):
        return handle
    return Line2D([], [], ls="", marker="o", ms=DOT, mew=0.0, color=handle.get_color())


def width_of(figure: Figure, text: str, size: float, weight: str = "normal") -> float:
    """Return the width of a line of text (inches) in the font of figures."""
    if (text, size, weight) not in WIDTHS:
        renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]  # of Agg
        if len(WIDTHS) > MOST_WIDTHS:
            WIDTHS.clear()
        font = FontProperties(family="DejaVu Sans", size=size, weight=weight)
        WIDTHS[text, size, weight] = float(
            renderer.get_text_width_height_descent(text, font, ismath=False)[0] / figure.dpi
        )
    return WIDTHS[text, size, weight]


def broken(figure: Figure, text: str, room: float, size: float, weight: str = "normal") -> list[str]:
    """Return the lines of a text no wider than ``room`` (inches), broken between words but not between a
    number and its unit, and a wider word behind one of its signs.
    """
    lines: list[str] = []
    for word in (word for word in re.split(r"[ \t\n]+", with_units(text)) if word):
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and width_of(figure, longer, size, weight) <= room:
            lines[-1] = longer
        else:
            lines += word_pieces(figure, word, room, size, weight)
    return [line.replace(NO_BREAK, " ") for line in lines] or [""]


def word_pieces(figure: Figure, word: str, room: float, size: float, weight: str = "normal") -> list[str]:
    """Return the pieces of a word no wider than ``room`` (inches): it is broken behind a point, hyphen or
    other sign if one is near enough, else between letters.
    """
    pieces: list[str] = []
    while width_of(figure, word, size, weight) > room and len(word) > 1:
        count = len(word) - 1
        while count > 1 and width_of(figure, word[:count], size, weight) > room:
            count -= 1
        signs = [k + 1 for k, letter in enumerate(word[:count]) if not letter.isalnum()]
        count = signs[-1] if signs and signs[-1] > NEAR_SIGN * count else count
        pieces.append(word[:count])
        word = word[count:]
    return [*pieces, word]


def cut_text(figure: Figure, text: str, room: float, size: float, weight: str = "normal") -> str:
    """Return a text cut to a width ``room`` (inches), with an ellipsis."""
    if width_of(figure, text, size, weight) <= room:
        return text
    count = len(text)
    while count > 1 and width_of(figure, text[:count] + "…", size, weight) > room:
        count -= max(1, count // 12)
    return text[:count] + "…"
