"""``vfife paper``: the source paper's numbers computed anew, on a page to hold beside it."""

from __future__ import annotations

import difflib
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from ...files import write_text
from ..options import Options, argument, flag, option
from ..signals import NOW
from ..terminal import answer, errors, fail, json_text, print_json, sentences, span, tell, writing

if TYPE_CHECKING:
    from rich.progress import Progress

    from vfife_validation.paper.contents import Item

    from ...report.document import Document

NAMES = (
    "fig8", "fig9", "fig10", "fig12", "fig13", "fig15", "fig16", "fig17", "table3", "fig18", "fig19", "fig20",
    "table4",
    "claims", "infer", "beyond",
)  # fmt: skip


class PaperOptions(Options):
    """Options of ``vfife paper``."""

    item: str | None = argument(f"One of {', '.join(NAMES)}.", "[ITEM]", None, show_default="all")
    folder: Path = option(
        Path("paper"), "Folder of the page; it may be there already.", "FOLDER", "-o", "--output"
    )
    as_json: bool = flag("--json", "Print one JSON value on standard output, and nothing else.")
    budget: float = option(600.0, "How long `infer` searches.", "SECONDS", min=1.0)
    seed: int = option(1, "Seed of the search of `infer`.", "N", min=0)
    stored: bool = flag("--stored", "With `infer`: show the stored search instead of searching.")


def paper(options: PaperOptions) -> None:
    """Compute the paper's figures and tables anew, judge its claims, and write a page.

    Without ITEM all of them, with the stored search for the lost parameters; `infer` searches anew within its
    budget. The folder holds index.html, figures and paper.json. Ctrl-C keeps the items that are done.
    """
    folder, names = options.folder, chosen(options.item)
    with sentences(f"-o {folder}"), writing(f"-o {folder}", "Nothing was begun."):
        if folder.exists() and not folder.is_dir():
            raise ValueError(f"-o {folder}: this is a file; name a folder")
        folder.mkdir(parents=True, exist_ok=True)
    began = time.monotonic()
    searches = options.item is not None and names == ["infer"] and not options.stored
    NOW.saved = f"Items that are done are kept in {folder}."
    with writing(f"-o {folder}", NOW.saved):
        work = compute(names, folder, options.budget if searches else 0.0, options.seed)
    if options.as_json:
        print_json(payload(work.items, work.parameters))
    else:
        answer(document(work.items, folder, time.monotonic() - began))
    if not work.complete:
        done = len(work.items)
        sentence = (
            f"{done} of {len(names)} items were done; they are kept in {folder}"
            if done
            else "no item was done"
        )
        tell("interrupted", f"{sentence}.")
        raise typer.Exit(NOW.code)


def chosen(item: str | None) -> list[str]:
    """Names of the items; ends with a sentence for one there is not."""
    if item is None:
        return list(NAMES)
    name = item.lower().replace(" ", "").replace(".", "").replace("-", "").replace("figure", "fig")
    if name in NAMES:
        return [name]
    near = difflib.get_close_matches(name, NAMES, 1)
    fail(
        f"the paper has no item {item!r}; "
        + (f"did you mean {near[0]!r}? " if near else "")
        + f"There are {', '.join(NAMES)}."
    )


class Work(NamedTuple):
    """The items that were computed, whether all of them were, and the inferred parameters (SI)."""

    items: list[Item]
    complete: bool
    parameters: dict[str, Any]


def compute(names: list[str], path: Path, budget: float, seed: int) -> Work:
    """Compute items, and write their page."""
    from vfife_validation.paper.context import Context
    from vfife_validation.paper.items import make
    from vfife_validation.paper.page import Folder as PageFolder
    from vfife_validation.paper.search import as_numbers

    from ... import __version__

    place, done, complete = PageFolder(path, f"Written by vfife {__version__}."), list["Item"](), True
    with Line(names) as line:
        context = Context(line.tell, line.progress, budget, seed)
        try:
            for name in names:
                line.begin(name)
                result = make(name, context)
                place.add(result, json_text)
                done.append(result)
            if budget > 0.0:
                write_text(path / "fitted.json", json_text(context.fit) + "\n")
        except KeyboardInterrupt:
            complete = False
    return Work(done, complete, as_numbers(context.parameters))


class Line:
    """Progress on standard error: the item, what it computes, and how many runs are done; plain lines where
    there is no terminal.
    """

    def __init__(self, names: list[str]) -> None:
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        console = errors()
        self.live, self.console, self.names, self.now = console.is_terminal, console, names, ""
        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=24),
            TimeElapsedColumn(),
        )
        self.bars: Progress = Progress(*columns, console=console, transient=True, disable=not self.live)
        self.task = self.bars.add_task("starting", total=None)

    def __enter__(self) -> Line:
        self.bars.start()
        return self

    def __exit__(self, *_: Any) -> None:
        self.bars.stop()

    def begin(self, name: str) -> None:
        """An item is begun."""
        self.now = f"{name} ({self.names.index(name) + 1} of {len(self.names)})"
        self.bars.update(self.task, description=self.now, total=None)
        if not self.live:
            self.console.print(self.now, markup=False)

    def tell(self, text: str) -> None:
        """What is computed."""
        self.bars.update(self.task, description=f"{self.now}: {text}", total=None)
        if not self.live:
            self.console.print(f"  {text}", markup=False)

    def progress(self, done: int, total: int) -> None:
        """So many runs of so many."""
        self.bars.update(self.task, completed=done, total=total)


def payload(items: list[Item], parameters: dict[str, Any]) -> dict[str, Any]:
    """What ``--json`` prints: the numbers of each item, the inferred set, every verdict, and where each
    parameter comes from.
    """
    numbers: dict[str, Any] = {}
    for item in items:
        numbers |= item.data if len(items) == 1 or item.name in item.data else {item.name: item.data}
    origins = [
        {"item": i.name, "parameter": p.name, "value": p.value, "origin": p.origin, "where": p.where}
        for i in items
        for p in i.parameters
    ]
    verdicts = [
        {"item": i.name, "claim": v.statement, "holds": v.holds, "numbers": v.numbers}
        for i in items
        for v in i.verdicts
    ]
    return {**numbers, "parameters": parameters, "origins": origins, "verdicts": verdicts}


def document(items: list[Item], folder: Path, seconds: float) -> Document:
    """The items for people."""
    from ...report.document import Document, Paragraph, Part, Style, Table

    styles: dict[str, Style] = {"true": "good", "false": "bad", "open": "caution"}
    parts: list[Part] = []
    for item in items:
        parts += [Paragraph(item.title, style="strong"), *(Paragraph(text) for text in item.text)]
        parts += [
            Paragraph(f"{one.statement}: {one.numbers}", f"{one.word:>5}  ", styles[one.word])
            for one in item.verdicts
        ]
        parts += item.tables
        if len(items) == 1 and item.parameters:
            rows = [(p.name, p.value, p.origin, p.where) for p in item.parameters]
            parts.append(Table(("parameter", "value", "origin", "where"), rows))
        parts.append(Paragraph(""))
    return Document(
        [*parts, Paragraph(f"{folder / 'index.html'} ({len(items)} items, in {span(seconds)})", "Page: ")]
    )
