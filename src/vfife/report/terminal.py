"""Documents on a terminal, or as plain text in a file."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Table as Grid
from rich.text import Text

from .parts import Bullets, Caution, Element, Facts, Figure, Paragraph, Part, Preformatted, Section, Table

if TYPE_CHECKING:
    from .document import Document

TEXT_COLUMNS, WIDE_COLUMNS = 100, 120
UNLIMITED = 10_000  # columns of a terminal that breaks no line
STYLES = {
    "": "", "strong": "bold", "aside": "italic", "caution": "yellow", "alarm": "bold yellow", "code": "cyan",
    "faint": "dim", "good": "bold green",
    "bad": "bold red",
}  # fmt: skip

LINES: dict[str, dict[str, Any]] = {
    "wrapped": {},
    "whole": {"soft_wrap": True},
    "cut": {"no_wrap": True, "overflow": "ellipsis"},
}


def write(document: Document, console: Console, errors: Callable[[], Console] | None = None) -> None:
    """Print a document; ``errors`` returns the console of asides, by default the same one. Brackets in texts
    are no markup.
    """
    if document.title:
        console.print(Text(document.title, style="bold"))
    for part in document.parts:
        _part(part, console, errors or (lambda: console))


def as_text(document: Document, columns: int = TEXT_COLUMNS) -> str:
    """Return a document as text of at most so many columns."""
    text = io.StringIO()
    write(document, Console(width=columns, file=text, color_system=None))
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


def _part(part: Part, console: Console, errors: Callable[[], Console]) -> None:
    match part:
        case Paragraph():
            _paragraph(part, console)
        case Table():
            if part.title:
                console.print(Text(part.title, style="bold"))
            grid = _grid(part, console.width - part.indent)
            console.print(Padding.indent(grid, part.indent) if part.indent else grid)
            if part.note:
                console.print(Text(part.note, style=STYLES["aside"]))
        case Facts():
            facts = Grid.grid(padding=(0, 2))
            for name, text in part.rows:
                facts.add_row(Text(name, style="cyan"), Text(text))
            console.print(facts)
        case Caution():
            target = errors() if part.aside else console
            target.print(Text.assemble((f"{part.word}: ", "bold yellow"), part.text))
        case Section():
            console.print(Text(part.title, style="bold"))
            for inner in part.parts:
                _part(inner, console, errors)
        case Bullets():
            for line in part.lines("-"):
                console.print(Text(line))
        case Element() | Figure() | Preformatted():
            pass


def _paragraph(part: Paragraph, console: Console) -> None:
    text = (
        Text.assemble((part.lead, STYLES[part.style or "strong"]), part.text)
        if part.lead
        else Text(part.text, style=STYLES[part.style])
    )
    options = LINES[part.lines]
    console.print(Padding.indent(text, part.indent) if part.indent else text, **options)


def _grid(part: Table, columns: int) -> Grid:
    """Return a table with two spaces between its cells in place of three where it is wider than so many
    ``columns``; the widest ranges are then broken before their upper end, so that no unit stands alone.
    """
    rows = [[str(cell) for cell in row] for row in part.rows]
    grid = _with_rows(part, rows)
    if _width(grid) > columns:
        grid.padding = (0, 0, 0, 1)
    while _width(grid) > columns and (k := _widest_range(part, rows)) >= 0:
        for row in rows:
            row[k : k + 1] = [cell.replace(" to ", " to\n", 1) for cell in row[k : k + 1]]
        grid = _with_rows(part, rows)
        grid.padding = (0, 0, 0, 1)
    return grid


def _with_rows(part: Table, rows: Sequence[Sequence[str]]) -> Grid:
    grid = Grid(box=SIMPLE_HEAD, pad_edge=False)
    for k, heading in enumerate(part.headings):
        grid.add_column(
            Text(heading),
            justify="right" if k in part.numbers else "left",
            overflow="fold",
            no_wrap=k in part.names,
        )
    for row in rows:
        grid.add_row(*map(Text, row))
    return grid


def _width(grid: Grid) -> int:
    """Return the width of a table in which nothing is wrapped."""
    unlimited = Console(width=UNLIMITED)
    return Measurement.get(unlimited, unlimited.options, grid).maximum


def _widest_range(part: Table, rows: Sequence[Sequence[str]]) -> int:
    """Return the column of numbers with the longest range that is on one line and wider than its heading,
    -1 for none. Headings are never broken, so each call with a column leaves fewer ranges on one line.
    """
    widths: dict[int, int] = {}
    for k in part.numbers:
        cells = [row[k] for row in rows if k < len(row)]
        widest = max(cells, key=lambda cell: max(map(len, cell.split("\n"))), default="")
        if " to " in widest and len(widest) > len(part.headings[k]):
            widths[k] = len(widest)
    return max(widths, key=widths.__getitem__, default=-1)
