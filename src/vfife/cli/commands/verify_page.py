"""``vfife verify measured``: vfife beside measurements, on a page with charts."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ...report.document import Document, Paragraph
from ..signals import NOW
from ..terminal import answer, errors, fail, json_text, print_json, sentences, tell, writing
from .paper import document, payload

if TYPE_CHECKING:
    from vfife_validation.paper.contents import Item

MEASURED = "measured"
TITLE = "vfife beside measurements"
INTRODUCTION = (
    "Models of vfife beside measured swings of a single and a double pendulum, and beside a hysteresis loop"
    " with noise. Statements are true or false as the numbers have it; what disagrees stands here as openly"
    " as what agrees."
)


def verify_measured(names: list[str], folder: Path, listed: bool, as_json: bool) -> None:
    """Compare with measurements, all of them unless some are named, and write a page. Exit code 0 whether
    statements hold or not: they are findings.
    """
    from vfife_validation.measured.items import ITEMS

    unknown = [name for name in names if name not in ITEMS]
    if unknown:
        fail(f"there is no measurement {unknown[0]!r}; there are {', '.join(ITEMS)}")
    chosen = names or list(ITEMS)
    if listed:
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
            compute(name, folder, items)
    except KeyboardInterrupt:
        complete = False
    if as_json:
        print_json(payload(items, {}))
    elif items:
        answer(document(items, folder, time.monotonic() - began))
    if not complete:
        tell("interrupted", f"{len(items)} of {len(chosen)} items were done.")
        raise typer.Exit(NOW.code)


def compute(name: str, folder: Path, items: list[Item]) -> None:
    """Compute an item, and write the page with all items so far."""
    from vfife_validation.measured.items import ITEMS
    from vfife_validation.paper.page import Folder

    from ... import __version__

    items.append(ITEMS[name]())
    with writing(f"-o {folder}", NOW.saved):
        footer = f"Written by vfife {__version__}."
        place = Folder(folder, footer, TITLE, INTRODUCTION, "measured.json")
        for one in items:
            place.add(one, json_text)
