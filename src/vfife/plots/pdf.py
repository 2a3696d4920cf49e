"""Documents as PDF, with text that can be selected and searched, laid out on pages of A4."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, TypeGuard, TypeVar

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.lines import Line2D

from .. import __version__
from ..files import replacement
from ..report import parts
from .layout import broken, width_of
from .style import FAINT, GREY, INK, STYLE

T = TypeVar("T")
PAGE = (8.27, 11.69)  # inches
LEFT, RIGHT, TOP, BOTTOM = 0.85, 0.75, 0.8, 0.8  # margins (inches)
ROOM = PAGE[0] - LEFT - RIGHT
LINE = 1.35 / 72.0  # inches of a line for a point of its font
TITLE, HEAD, TEXT, SMALL, CODE = 18.0, 13.0, 10.0, 8.5, 7.0  # points
CELL_SIZES = (SMALL, 8.0, 7.5)  # points in tables: the largest in which no cell is wrapped, else the last
MAGNIFIED = 10.0  # at which cells are measured: pixels of a screen make small letters up to 9 % narrower
GAP, CELL = 0.12, 0.14  # inches between parts, and between columns
FINE = 220.0  # pixels an inch of figures
LOGO = (2.2, 0.75)  # largest width and height of a logo (inches)
SHRUNK, TALLEST = 0.59, 4.45  # scale of figures, which makes their texts alike; inches: two on a page
TALL_FIRST, SHORT_FIRST = 4.0, 1.8  # inches: usual and least height of the figure of the first page
CANDIDATES = 12  # figures of which those of a page are chosen
UNBROKEN_SHARE = 0.5  # of the height of a page: a shorter table is not broken over two
LAST_LINES = 4  # of a text or table that stay on one page: the last one has no line by itself
MONOSPACE = 112  # characters of a line of a file


class Paper:
    """Pages that are filled from top to bottom. ``at`` is the distance from the top (inches), ``tallest`` the
    largest height of the figure of the first page (inches). Without ``pages`` nothing is written.
    """

    def __init__(self, pages: PdfPages | None, footer: str) -> None:
        self.pages, self.footer, self.count, self.tallest = pages, footer, 0, TALL_FIRST
        self.cell_size = SMALL  # of the table that is written (points)
        self.begin()

    def begin(self) -> None:
        """Begin a page."""
        self.page, self.at = Figure(figsize=PAGE), TOP
        FigureCanvasAgg(self.page)
        self.count += 1
        self.put(LEFT, PAGE[1] - 0.45, f"{self.footer} · {self.count}", SMALL, color=GREY)

    def end(self) -> None:
        """Write the page."""
        if self.pages is not None:
            self.pages.savefig(self.page)  # type: ignore[no-untyped-call]

    def keep(self, height: float) -> None:
        """Begin another page unless this one has room (inches)."""
        if self.at + height > PAGE[1] - BOTTOM and self.at > TOP:
            self.end()
            self.begin()

    def put(self, x: float, y: float, text: str, size: float, **look: Any) -> None:
        """Write a line with its upper edge at a distance from the top (inches)."""
        style = {"va": "top", "ha": "left", "color": INK} | look
        self.page.text(x / PAGE[0], 1.0 - y / PAGE[1], text, fontsize=size, **style)

    def text(self, text: str, size: float = TEXT, indent: float = 0.0, **look: Any) -> None:
        """Write a paragraph."""
        room = (ROOM - indent) * (0.9 if look.get("weight") == "bold" else 1.0)
        for line, count in _counted(broken(self.page, text, room, size)):
            self.keep(count * size * LINE)
            self.put(LEFT + indent, self.at, line, size, **look)
            self.at += size * LINE

    def lines(self, text: str) -> None:
        """Write the lines of a file."""
        parts = [
            line[k : k + MONOSPACE]
            for line in text.splitlines()
            for k in range(0, max(len(line), 1), MONOSPACE)
        ]
        for part, count in _counted(parts):
            self.keep(count * CODE * LINE)
            self.put(LEFT, self.at, part, CODE, family="DejaVu Sans Mono")
            self.at += CODE * LINE

    def rows(self, rows: Sequence[Sequence[str]], numbers: Sequence[int], heads: Sequence[str] = ()) -> None:
        """Write rows of cells, wide ones in a smaller font, and still wider columns wrapped; ``heads`` again
        on every page.
        """
        for self.cell_size in CELL_SIZES:
            if sum(self.natural_widths(rows, heads)) <= ROOM:
                break
        widths = self.widths(rows, heads)
        if heads:
            self.row(heads, widths, numbers, 0.0, weight="bold")
        for row, count in _counted(rows):
            page_count = self.count
            self.keep(count * self.height(row, widths))
            if heads and self.count > page_count:
                self.row(heads, widths, numbers, 0.0, weight="bold")
            self.row(row, widths, numbers, 0.4)

    def natural_widths(self, rows: Sequence[Sequence[str]], heads: Sequence[str]) -> list[float]:
        """Widths of columns (inches) in which no text is wrapped."""
        looks = [(heads, "bold"), *((row, "normal") for row in rows)]
        widths = [0.0] * max(len(row) for row, _ in looks)
        for row, look in looks:
            for k, text in enumerate(row):
                width = width_of(self.page, str(text), MAGNIFIED * self.cell_size, look) / MAGNIFIED
                widths[k] = max(widths[k], width)
        return [CELL + width for width in widths]

    def widths(self, rows: Sequence[Sequence[str]], heads: Sequence[str]) -> list[float]:
        """Widths of columns (inches): those of their texts, the widest cut so that all fit the page."""
        widths = self.natural_widths(rows, heads)
        for limit in np.linspace(ROOM, 0.4, 60):
            fitted = [min(width, float(limit)) for width in widths]
            if sum(fitted) <= ROOM:
                cut = [fit < width for fit, width in zip(fitted, widths, strict=True)]
                share = (ROOM - sum(fitted)) / max(sum(cut), 1)
                return [fit + share * is_cut for fit, is_cut in zip(fitted, cut, strict=True)]
        return [ROOM / len(widths)] * len(widths)

    def height(self, row: Sequence[str], widths: Sequence[float], weight: str = "normal") -> float:
        """Height of a row (inches)."""
        count = max(len(self.cell(cell, width, weight)) for cell, width in zip(row, widths, strict=False))
        return count * self.cell_size * LINE + 0.04

    def cell(self, text: str, width: float, weight: str = "normal") -> list[str]:
        """Lines of a cell."""
        room = MAGNIFIED * (width - CELL + 0.01)
        return broken(self.page, str(text), room, MAGNIFIED * self.cell_size, weight)

    def row(
        self, row: Sequence[str], widths: Sequence[float], numbers: Sequence[int], rule: float, **look: Any
    ) -> None:
        """Write a row, with a line of a width (points) above it."""
        if rule:
            y = 1.0 - (self.at - 0.02) / PAGE[1]
            ends = [LEFT / PAGE[0], (LEFT + sum(widths)) / PAGE[0]]
            self.page.add_artist(Line2D(ends, [y, y], lw=rule, color=FAINT))
        weight = look.get("weight", "normal")
        x, height = LEFT, self.height(row, widths, weight)
        for k, (cell, width) in enumerate(zip(row, widths, strict=False)):
            right = k in numbers
            for j, line in enumerate(self.cell(cell, width, weight)):
                place = x + width - CELL if right else x
                y = self.at + j * self.cell_size * LINE
                self.put(place, y, line, self.cell_size, ha="right" if right else "left", **look)
            x += width
        self.at += height

    def picture(self, pixels: Any, width: float, height: float, x: float, y: float) -> None:
        """Draw a picture with its upper left corner at a place (inches)."""
        ax = self.page.add_axes(
            (x / PAGE[0], 1.0 - (y + height) / PAGE[1], width / PAGE[0], height / PAGE[1])
        )
        ax.imshow(pixels, aspect="auto", interpolation="none")
        ax.axis("off")

    def left(self) -> float:
        """Return the height that is left on the page (inches)."""
        return PAGE[1] - BOTTOM - self.at

    def figures(self, figures: Mapping[str, Figure]) -> None:
        """Draw figures by caption, those together on a page that fill it best; the first of those that are
        left stands on the next page.
        """
        waiting = dict(figures)
        while waiting:
            heights = {title: self.figure_height(figure, title) + GAP for title, figure in waiting.items()}
            for title in fullest(heights, self.left()):
                figure = waiting.pop(title)
                self.figure(figure, title, figure_scale(figure))

    def figure_height(self, figure: Figure, caption: str, scale: float | None = None) -> float:
        """Return the height of a figure with its caption (inches)."""
        lines = broken(self.page, caption, ROOM, SMALL)
        tall = figure.get_figheight() * (figure_scale(figure) if scale is None else scale)
        return float(tall + (len(lines) + 1) * SMALL * LINE)

    def figure(self, figure: Figure, caption: str, scale: float) -> None:
        """Draw a figure at a scale with a caption."""
        wide, tall = figure.get_size_inches()
        self.keep(self.figure_height(figure, caption, scale))
        figure.set_dpi(FINE)
        canvas: Any = FigureCanvasAgg(figure)  # whose methods have no types
        canvas.draw()
        self.picture(np.asarray(canvas.buffer_rgba()), wide * scale, tall * scale, LEFT, self.at)
        self.at += tall * scale + 0.05
        self.text(caption, SMALL, color=GREY)
        self.at += GAP


def _counted(lines: Sequence[T]) -> Iterator[tuple[T, int]]:
    """Yield lines, each with the number of lines that have to fit the page from it on."""
    for left, line in zip(range(len(lines), 0, -1), lines, strict=True):
        yield line, left if left <= LAST_LINES else 1


def fullest(heights: Mapping[str, float], room: float) -> list[str]:
    """Return the names of heights that fill a room best, the first name among them, in their order."""
    first, *remaining = list(heights)[:CANDIDATES]
    chosen, best_height = [first], heights[first]
    for count in range(1, len(remaining) + 1):
        for names in combinations(remaining, count):
            height = heights[first] + sum(heights[name] for name in names)
            if best_height < height <= room:
                chosen, best_height = [first, *names], height
    return chosen


def figure_scale(figure: Figure, tallest: float = TALLEST, largest: float = SHRUNK) -> float:
    """Return the scale of a figure: the ``largest``, or less where the page or ``tallest`` (inches) asks."""
    wide, tall = figure.get_size_inches()
    return float(min(ROOM / wide, tallest / tall, largest))


@rc_context(STYLE | {"pdf.fonttype": 42})
def write_pdf(
    path: Path,
    document: Any,
    introduction: Sequence[str],
    figures: Mapping[str, Figure],
    logo: bytes | None = None,
    author: str = "",
) -> None:
    """Write a document of sections as PDF. Its figures are those of the same titles; an existing file is
    replaced when the new one is complete.
    """
    facts = {"Title": document.title, "Author": author, "Creator": f"vfife {__version__}"}
    with replacement(path) as temporary, PdfPages(temporary, metadata=facts) as pages:
        paper = Paper(pages, document.title)
        if logo is not None:
            _logo(paper, logo)
        paper.text(document.title, TITLE, weight="bold")
        for text in introduction:
            paper.text(text, TEXT, color=GREY)
        for number, section in enumerate(part for part in document.parts if part.parts):
            if number == 0:
                paper.tallest = tallest_first(paper, section, figures)
            if number == 1 and paper.count == 1:  # what did not fit on the first page is followed directly
                paper.keep(PAGE[1])
            _section(paper, section, figures, number == 0)
        paper.end()


def tallest_first(paper: Paper, section: parts.Section, figures: Mapping[str, Figure]) -> float:
    """Return the height (inches) of the figure of the first section with which all of it, or else what ends
    with its last table, fits on the first page; the usual one where neither does.
    """
    drawn = [part for part in section.parts if _is_drawn(part, figures)]
    if len(drawn) != 1:
        return TALL_FIRST
    texts = [part for part in section.parts if part not in drawn]
    tables = [k for k, part in enumerate(texts) if isinstance(part, parts.Table)]
    caption = paper.figure_height(figures[drawn[0].title], drawn[0].title, 0.0) + 0.05 + 2.0 * GAP
    for end in (len(texts), *[k + 1 for k in tables[-1:]]):
        draft = Paper(None, paper.footer)
        draft.at = paper.at
        _section(draft, parts.Section(section.title, texts[:end]), {}, True)
        height = draft.left() - caption
        if draft.count == 1 and height >= SHORT_FIRST:
            return min(TALL_FIRST, height)
    return TALL_FIRST


def _logo(paper: Paper, data: bytes) -> None:
    pixels = imread(io.BytesIO(data), format="png" if data[:1] == b"\x89" else "jpg")
    tall, wide = pixels.shape[:2]
    scale = min(LOGO[0] / wide, LOGO[1] / tall)
    paper.picture(pixels, wide * scale, tall * scale, PAGE[0] - RIGHT - wide * scale, TOP - 0.35)
    paper.at += max(0.0, tall * scale - 0.3)


def _section(paper: Paper, section: parts.Section, figures: Mapping[str, Figure], first: bool) -> None:
    drawn = {part.title: figures[part.title] for part in section.parts if _is_drawn(part, figures)}
    heading = GAP + HEAD * LINE + 0.06
    # A page begins with the first figure, whichever others are shorter.
    begin = next((paper.figure_height(figure, title) for title, figure in drawn.items()), 0.0)
    paper.keep(1.2 if first else max(1.2, heading + begin))
    paper.at += GAP
    paper.text(section.title, HEAD, weight="bold")
    paper.at += 0.06
    if not first:
        paper.figures(drawn)
    remaining = [part for part in section.parts if first or not _is_drawn(part, figures)]
    for k, part in enumerate(remaining):
        if isinstance(part, parts.Table):
            # The meanings of its headings follow a table; on the first page the table is more important.
            following = [] if first else remaining[k + 1 : k + 2]
            glossary = [entry for entry in following if isinstance(entry, parts.Facts)]
            paper.keep(_block_height(paper, [part, *glossary]) or _block_height(paper, [part]))
        _part(paper, part, figures, first)


def _block_height(paper: Paper, block: Sequence[parts.Part]) -> float:
    """Return the height (inches) of parts that stay together on a page; 0 of those that may be broken because
    they would fill more than :data:`UNBROKEN_SHARE` of one.
    """
    draft = Paper(None, paper.footer)
    for part in block:
        _part(draft, part, {}, False)
    height = draft.at - TOP - GAP
    return height if draft.count == 1 and height <= UNBROKEN_SHARE * (PAGE[1] - TOP - BOTTOM) else 0.0


def _is_drawn(part: parts.Part, figures: Mapping[str, Figure]) -> TypeGuard[parts.Figure]:
    return isinstance(part, parts.Figure) and part.title in figures


def _part(paper: Paper, part: parts.Part, figures: Mapping[str, Figure], first: bool) -> None:
    match part:
        case parts.Paragraph():
            paper.text(part.lead + part.text, TEXT + 1.0 * first)
            paper.at += 0.5 * GAP
        case parts.Table():
            if part.title:
                paper.keep(0.8)
                paper.text(part.title, TEXT, weight="bold")
            paper.rows(part.rows, part.numbers, part.headings)
            if part.note:
                paper.text(part.note, TEXT)
        case parts.Facts():
            paper.rows(part.rows, ())
        case parts.Caution():
            paper.text(f"{part.word}: {part.text}", TEXT)
        case parts.Bullets():
            for line in part.lines("•"):
                paper.text(line, TEXT)
        case parts.Figure():
            if part.title in figures:  # that of the first page
                scale = figure_scale(figures[part.title], paper.tallest, 1.0)
                paper.figure(figures[part.title], part.title, scale)
        case parts.Preformatted():
            paper.text(part.title, TEXT, weight="bold")
            if part.words:
                paper.text(part.words, SMALL)
            paper.lines(part.text)
        case parts.Section():
            _section(paper, part, figures, False)
    paper.at += GAP
