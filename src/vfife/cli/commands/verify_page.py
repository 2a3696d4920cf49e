"""``vfife verify measured`` and its like: groups of comparisons that write a page with charts."""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ... import __version__
from ...job.progress import ProgressLine
from ...solvers.status import Progress
from ..signals import NOW
from ..terminal import answer, end_interrupted, fail, json_text, sentences, writing

if TYPE_CHECKING:
    from vfife_validation.paper.contents import Item
    from vfife_validation.paper.page import Folder

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

    NOW.saved = f"Items that are done are kept in {page.path}."
    complete = False
    try:
        with writing(f"-o {page.path}", NOW.saved), line:
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
