"""``vfife verify``: the verification suite, case by case, and pages of comparisons; ``vfife paper``: the
numbers of the source paper computed anew, on a page.
"""

from __future__ import annotations

import difflib
import time
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ... import __version__
from ...files import write_text
from ...job.progress import ProgressLine, on_terminal
from ...solvers.status import Progress
from ..options import JsonOptions, argument, flag, option
from ..signals import ENDING
from ..terminal import answer, end_interrupted, fail, json_text, sentences, writing

if TYPE_CHECKING:
    from vfife_validation.paper.contents import Item
    from vfife_validation.paper.page import Folder
    from vfife_validation.verification import Case


PAGES = ("measured", "published", "trends")
FOOTER = f"Written by vfife {__version__}."


def items_of(group: str) -> Any:
    """Import ``vfife_validation.<group>.items``: TITLE, INTRODUCTION, and a function for each item by name in
    ITEMS.
    """
    return import_module(f"vfife_validation.{group}.items")


def verify_page(group: str, names: list[str], folder: Path | None, only_list: bool, as_json: bool) -> None:
    """Compute the items of a group, all unless some are named, and write a page. Exit code 0 whether
    statements hold or not: they are findings.
    """
    texts = items_of(group)
    unknown = [name for name in names if name not in texts.ITEMS]
    if unknown:
        fail(f"{group} has no item {unknown[0]!r}; there are {', '.join(texts.ITEMS)}")
    chosen = names or list(texts.ITEMS)
    from vfife_validation.paper.answer import listing
    from vfife_validation.paper.page import Folder

    if only_list:
        answer(listing(chosen), as_json)
        return
    place = page_folder(folder or Path(group))
    page = Folder(place, FOOTER, texts.TITLE, texts.INTRODUCTION, f"{group}.json")
    compute_items(ItemLine(chosen), lambda name: texts.ITEMS[name](), page, as_json)


def page_folder(folder: Path) -> Path:
    """Make the folder of a page; end with a sentence where it cannot be made."""
    with sentences(f"-o {folder}"), writing(f"-o {folder}", "Nothing was begun."):
        if folder.exists() and not folder.is_dir():
            raise ValueError(f"-o {folder}: this is a file; name a folder")
        folder.mkdir(parents=True, exist_ok=True)
    return folder


class ItemLine(ProgressLine):
    """The progress of ``names``: the item, what it computes, and how many of its runs are done."""

    def __init__(self, names: list[str]) -> None:
        super().__init__(False)
        self.names, self.began, self.item = names, time.monotonic(), ""

    @property
    def seconds(self) -> float:
        """Time since the beginning (s)."""
        return time.monotonic() - self.began

    def begin(self, name: str) -> None:
        """Begin an item."""
        self.item = self.text = f"{name} ({self.names.index(name) + 1} of {len(self.names)})"
        self.count(0, 1)

    def tell(self, text: str) -> None:
        """Show what is computed."""
        self.text = f"{self.item}: {text}"
        self.count(0, 1)

    def count(self, done: int, total: int) -> None:
        """Show how many runs are done."""
        self(Progress(done, total, self.seconds, self.text))


def compute_items(
    line: ItemLine,
    compute: Callable[[str], Item],
    page: Folder,
    as_json: bool,
    parameters: Callable[[], dict[str, Any]] = dict,
) -> None:
    """Compute items and write their page after each; ``parameters`` returns the inferred ones (SI)."""
    from vfife_validation.paper.answer import document

    ENDING.saved = f"Items that are done are kept in {page.path}."
    complete = False
    try:
        with writing(f"-o {page.path}", ENDING.saved), line:
            for name in line.names:
                line.begin(name)
                page.add(compute(name), json_text)
                line.count(1, 1)
        complete = True
    except KeyboardInterrupt:
        line.last = ""
    if page.items or as_json:
        answer(document(page.items, page.index, line.seconds, parameters()), as_json)
    if not complete:
        count = f"{len(page.items)} of {len(line.names)} items were done"
        end_interrupted(f": {count}; they are kept in {page.path}." if page.items else ": no item was done.")


class VerifyOptions(JsonOptions):
    """Options of ``vfife verify``."""

    names: list[str] | None = argument(
        "These cases only; measured, published or trends: write their page, with the items named after it.",
        "[CASE]...",
        None,
    )
    folder: Path | None = option(
        None, "Folder of the page, by default named as its group.", "FOLDER", "-o", "--output"
    )
    listed: bool = flag("--list", "List the cases and run none.")


def verify(options: VerifyOptions) -> None:
    """Run the verification suite: our numbers beside published ones, closed forms and independent
    integrations. Exit code 1 if any fails.

    `vfife verify measured` compares with measured pendulums and a hysteresis loop instead, `vfife verify
    published` with published studies of linkages with clearance, `vfife verify trends` with statements of the
    literature on clearance and speed; each writes a page.
    """
    group, *items = options.names or [""]
    if group.lower() in PAGES:
        verify_page(group.lower(), items, options.folder, options.listed, options.as_json)
        return
    from vfife_validation.verification import CASES, page

    cases = chosen(CASES, options.names or [])
    if options.listed:
        answer(page.listing(cases), options.as_json)
        return
    done: list[page.CaseRows] = []
    began, line = time.monotonic(), ProgressLine(quiet=not on_terminal())
    try:
        with line:
            for one in cases:
                line(Progress(len(done), len(cases), time.monotonic() - began, one.title))
                done.append((one, one.check()))
                if not options.as_json:
                    answer(page.document(*done[-1]))
    except KeyboardInterrupt:
        answer(page.conclusion(done, interrupted=True), options.as_json)
        end_interrupted(f" after {len(done)} of {len(cases)} cases.")
    answer(page.conclusion(done), options.as_json)
    if page.failed(done):
        raise typer.Exit(1)


def chosen(cases: Mapping[str, Case], names: Sequence[str]) -> list[Case]:
    """Return the cases with these names, or all cases without names; exit with suggestions for
    unknown names.
    """
    wrong = [name for name in names if name.lower() not in cases]
    if wrong:
        sentences = []
        for name in wrong:
            near = difflib.get_close_matches(name.lower(), cases, 3, 0.4)
            sentence = (
                f"did you mean {' or '.join(repr(one) for one in near)}?"
                if near
                else "vfife verify --list names all there are"
            )
            sentences.append(f"there is no case {name!r}; {sentence}")
        fail("; ".join(sentences))
    return [cases[name] for name in dict.fromkeys(name.lower() for name in names)] or list(cases.values())


PAPER_ITEMS = (
    "fig8", "fig9", "fig10", "fig12", "fig13", "fig15", "fig16", "fig17", "table3", "fig18", "fig19", "fig20",
    "table4",
    "claims", "infer", "beyond",
)  # fmt: skip


class PaperOptions(JsonOptions):
    """Options of ``vfife paper``."""

    item: str | None = argument(f"One of {', '.join(PAPER_ITEMS)}.", "[ITEM]", None, show_default="all")
    folder: Path = option(
        Path("paper"), "Folder of the page; it may be there already.", "FOLDER", "-o", "--output"
    )
    budget: float = option(600.0, "How long `infer` searches.", "SECONDS", min=1.0)
    seed: int = option(1, "Seed of the search of `infer`.", "N", min=0)
    stored: bool = flag("--stored", "With `infer`: show the stored search instead of searching.")


def paper(options: PaperOptions) -> None:
    """Compute the paper's figures and tables anew, judge its claims, and write a page.

    Without ITEM all of them, with the stored search for the lost parameters; `infer` searches anew within its
    budget. The folder holds index.html, figures and paper.json. Ctrl-C keeps the items that are done.
    """
    names, folder = paper_items(options.item), page_folder(options.folder)
    from vfife_validation.paper.context import Context
    from vfife_validation.paper.items import make
    from vfife_validation.paper.page import Folder
    from vfife_validation.paper.search import as_numbers

    searches = options.item is not None and names == ["infer"] and not options.stored
    line = ItemLine(names)
    context = Context(line.tell, line.count, options.budget if searches else 0.0, options.seed)

    def compute(name: str) -> Item:
        item = make(name, context)
        if searches:
            write_text(folder / "fitted.json", json_text(context.fit) + "\n")
        return item

    def parameters() -> dict[str, Any]:
        return as_numbers(context.parameters)

    compute_items(line, compute, Folder(folder, FOOTER), options.as_json, parameters)


def paper_items(item: str | None) -> list[str]:
    """Return the names of the items; end with a sentence for one there is not."""
    if item is None:
        return list(PAPER_ITEMS)
    name = item.lower().replace(" ", "").replace(".", "").replace("-", "").replace("figure", "fig")
    if name in PAPER_ITEMS:
        return [name]
    near = difflib.get_close_matches(name, PAPER_ITEMS, 1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    fail(f"the paper has no item {item!r}; {hint}There are {', '.join(PAPER_ITEMS)}.")
