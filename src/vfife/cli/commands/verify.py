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

from vfife_validation.paper import items as paper_contents
from vfife_validation.paper.answer import document, listing
from vfife_validation.paper.contents import Item
from vfife_validation.paper.context import Context
from vfife_validation.paper.page import Folder
from vfife_validation.paper.search import as_numbers

from ... import __version__
from ...errors import VfifeError
from ...files import write_text
from ...job.activity import ACTIVITY
from ...job.cost import Forecast
from ...job.progress import ProgressLine, counted, on_terminal, span
from ...solvers.status import Progress
from ..arguments.models import PAPER_ITEMS, PaperOptions, VerifyOptions
from ..signals import ENDING
from ..terminal import answer, end_interrupted, fail, json_text, sentences, tell, writing

if TYPE_CHECKING:
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
    if only_list:
        answer(listing(chosen), as_json)
        return
    absent = items_without_library(chosen, getattr(texts, "LIBRARIES", {}))
    for name, reason in absent.items():
        tell("caution", f"{name} is omitted: {reason}")
    chosen = [name for name in chosen if name not in absent]
    if not chosen:
        fail(f"nothing is left of {group} to compute")
    place = page_folder(folder or Path(group))
    page = Folder(place, FOOTER, texts.TITLE, texts.INTRODUCTION, f"{group}.json", absent)
    seconds = sum(texts.SECONDS[name] for name in chosen)
    forecast = Forecast("item", seconds=seconds, work=counted(len(chosen), "item"))
    tell("forecast", forecast.sentence(None), "bold")
    compute_items(ActivityLine(chosen, texts.SECONDS), lambda name: texts.ITEMS[name](), page, as_json)


def items_without_library(
    names: Sequence[str], libraries: Mapping[str, Callable[[], object]]
) -> dict[str, str]:
    """Return the items that cannot be computed because a library is not installed, with the reason."""
    absent: dict[str, str] = {}
    for name in names:
        try:
            libraries.get(name, bool)()
        except VfifeError as error:
            absent[name] = str(error)
    return absent


def page_folder(folder: Path) -> Path:
    """Make the folder of a page; end with a sentence where it cannot be made."""
    with sentences(f"-o {folder}"), writing(f"-o {folder}", "Nothing was started."):
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


class ActivityLine(ItemLine):
    """The progress of items that count nothing: the item, and how long it takes of the ``forecast`` seconds
    by name.
    """

    def __init__(self, names: list[str], forecast: Mapping[str, float]) -> None:
        super().__init__(names)
        self.forecast = forecast

    def __enter__(self) -> ActivityLine:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def begin(self, name: str) -> None:
        """Begin an item."""
        left = sum(self.forecast[item] for item in self.names[self.names.index(name) + 1 :])
        remainder = f", then about {span(left)} for the others" if left else ""
        ACTIVITY(
            f"{name} ({self.names.index(name) + 1} of {len(self.names)}{remainder})", self.forecast[name]
        )

    def count(self, done: int, total: int) -> None:
        """Show nothing."""


def compute_items(
    line: ItemLine,
    compute: Callable[[str], Item],
    page: Folder,
    as_json: bool,
    parameters: Callable[[], dict[str, Any]] = dict,
) -> None:
    """Compute items and write their page after each; ``parameters`` returns the inferred ones (SI)."""
    repetition = "the same command begins again with the first item, and replaces that page"
    ENDING.saved = f"The page of the complete items is kept in {page.path}; {repetition}."
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
        answer(document(page.items, page.index, line.seconds, parameters(), page.absent), as_json)
    if not complete:
        count = f"{len(page.items)} of {len(line.names)} items were done"
        sentence = f": {count}; they are kept in {page.path} for reading: {repetition}."
        end_interrupted(sentence if page.items else ": no item was done.")


def verify(options: VerifyOptions) -> None:
    """Run ``vfife verify``."""
    group, *items = options.names or [""]
    if group.lower() in PAGES:
        verify_page(group.lower(), items, options.folder, options.listed, options.as_json)
        return
    from vfife_validation.verification import CASES, page

    is_list = options.listed or options.names == ["list"]  # as `vfife plot --figure list`
    cases = chosen(CASES, [] if is_list and not options.listed else options.names or [])
    if is_list:
        answer(page.listing(cases), options.as_json)
        return
    done: list[page.CaseRows] = []
    began, line = time.monotonic(), ProgressLine(quiet=not on_terminal())
    try:
        with line:
            for case in cases:
                line(Progress(len(done), len(cases), time.monotonic() - began, case.title))
                done.append((case, case.check()))
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
            suggestions = difflib.get_close_matches(name.lower(), cases, 3, 0.4)
            sentence = (
                f"did you mean {' or '.join(repr(suggestion) for suggestion in suggestions)}?"
                if suggestions
                else "vfife verify --list names all there are"
            )
            sentences.append(f"there is no case {name!r}; {sentence}")
        fail("; ".join(sentences))
    return [cases[name] for name in dict.fromkeys(name.lower() for name in names)] or list(cases.values())


def paper(options: PaperOptions) -> None:
    """Run ``vfife paper``."""
    names, folder = paper_items(options.item), page_folder(options.folder)
    searches = options.item is not None and names == ["infer"] and not options.stored
    line = ItemLine(names)
    context = Context(line.tell, line.count, options.budget if searches else 0.0, options.seed)

    def compute(name: str) -> Item:
        item = paper_contents.make(name, context)
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
    suggestions = difflib.get_close_matches(name, PAPER_ITEMS, 1)
    hint = f"did you mean {suggestions[0]!r}? " if suggestions else ""
    fail(f"the paper has no item {item!r}; {hint}There are {', '.join(PAPER_ITEMS)}.")
