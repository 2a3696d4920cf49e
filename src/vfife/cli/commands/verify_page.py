"""``vfife verify measured``, ``vfife verify trends``: groups of comparisons that write a page with charts."""

from __future__ import annotations

import time
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ...report.document import Document, Paragraph
from ..signals import NOW
from ..terminal import answer, errors, fail, json_text, print_json, sentences, tell, writing
from .paper import document, payload

if TYPE_CHECKING:
    from vfife_validation.paper.contents import Item

PAGES = ("measured",)


def items_of(group: str) -> Any:
    """Import ``vfife_validation.<group>.items``: TITLE, INTRODUCTION, and a function for each item by name in
    ITEMS.
    """
    return import_module(f"vfife_validation.{group}.items")


def verify_page(group: str, names: list[str], folder: Path | None, only_list: bool, as_json: bool) -> None:
    """Compute the items of a group, all unless some are named, and write a page. Exit code 0 whether
    statements hold or not: they are findings.
    """
    group_items, folder = items_of(group), folder or Path(group)
    unknown = [name for name in names if name not in group_items.ITEMS]
    if unknown:
        fail(f"{group} has no item {unknown[0]!r}; there are {', '.join(group_items.ITEMS)}")
    chosen = names or list(group_items.ITEMS)
    if only_list:
        texts = [Paragraph(name) for name in chosen]
        answer(Document([*texts], data={"items": chosen}), as_json)
        return
    with sentences(f"-o {folder}"):
        if folder.exists() and not folder.is_dir():
            raise ValueError(f"-o {folder}: this is a file; name a folder")
    items: list[Item] = []
    began, complete = time.monotonic(), True
    NOW.saved = f"Items that are done are kept in {folder}."
    try:
        for number, name in enumerate(chosen, start=1):
            errors().print(f"{name} ({number} of {len(chosen)})", markup=False)
            items.append(group_items.ITEMS[name]())
            write_page(group, group_items, folder, items)
    except KeyboardInterrupt:
        complete = False
    if as_json:
        print_json(payload(items, {}))
    elif items:
        answer(document(items, folder, time.monotonic() - began))
    if not complete:
        tell("interrupted", f"{len(items)} of {len(chosen)} items were done.")
        raise typer.Exit(NOW.code)


def write_page(group: str, texts: Any, folder: Path, items: list[Item]) -> None:
    """Write the page of a group with the items so far; ``texts``: its title and introduction."""
    from vfife_validation.paper.page import Folder

    from ... import __version__

    with writing(f"-o {folder}", NOW.saved):
        footer = f"Written by vfife {__version__}."
        place = Folder(folder, footer, texts.TITLE, texts.INTRODUCTION, f"{group}.json")
        for one in items:
            place.add(one, json_text)
