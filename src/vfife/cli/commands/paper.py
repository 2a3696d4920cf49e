"""``vfife paper``: the source paper's numbers computed anew, on a page to hold beside it."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...files import write_text
from ..options import JsonOptions, argument, flag, option
from ..terminal import fail, json_text
from .verify_page import FOOTER, ItemLine, compute_items, page_folder

if TYPE_CHECKING:
    from vfife_validation.paper.contents import Item

NAMES = (
    "fig8", "fig9", "fig10", "fig12", "fig13", "fig15", "fig16", "fig17", "table3", "fig18", "fig19", "fig20",
    "table4",
    "claims", "infer", "beyond",
)  # fmt: skip


class PaperOptions(JsonOptions):
    """Options of ``vfife paper``."""

    item: str | None = argument(f"One of {', '.join(NAMES)}.", "[ITEM]", None, show_default="all")
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
    names, folder = chosen(options.item), page_folder(options.folder)
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


def chosen(item: str | None) -> list[str]:
    """Return the names of the items; end with a sentence for one there is not."""
    if item is None:
        return list(NAMES)
    name = item.lower().replace(" ", "").replace(".", "").replace("-", "").replace("figure", "fig")
    if name in NAMES:
        return [name]
    near = difflib.get_close_matches(name, NAMES, 1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    fail(f"the paper has no item {item!r}; {hint}There are {', '.join(NAMES)}.")
