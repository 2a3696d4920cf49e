"""Items as the commands print them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from vfife.job.progress import span
from vfife.report.document import Document, Paragraph, Part, Style, Table

from .contents import Item

STYLES: dict[str, Style] = {"true": "good", "false": "bad", "open": "caution"}


def listing(names: Sequence[str]) -> Document:
    """Return the names of items as a document."""
    return Document([Paragraph(name) for name in names], data={"items": names})


def document(
    items: Sequence[Item], page: Path, seconds: float, parameters: Mapping[str, Any],
    absent: Mapping[str, str] | None = None,
) -> Document:  # fmt: skip
    """Return the statements and tables of items; as data their numbers, the inferred ``parameters`` (SI),
    every verdict, where each parameter comes from, and the reasons for ``absent`` items. ``page`` was written
    in so many ``seconds``.
    """
    parts = [part for item in items for part in item_parts(item, alone=len(items) == 1)]
    end = [
        Paragraph(f"{name} was not computed: {reason}", style="caution")
        for name, reason in (absent or {}).items()
    ]
    end.append(Paragraph(f"{page} ({len(items)} items, in {span(seconds)})", "Page: "))
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
    data = {**numbers, "parameters": parameters, "origins": origins, "verdicts": verdicts}
    data |= {"left_out": dict(absent)} if absent else {}
    return Document([*parts, *end], data=data)


def item_parts(item: Item, alone: bool) -> Iterator[Part]:
    """Yield the parts of an item, with its parameters if it is shown ``alone``."""
    yield Paragraph(item.title, style="strong")
    yield from map(Paragraph, item.text)
    for verdict in item.verdicts:
        yield Paragraph(
            f"{verdict.statement}: {verdict.numbers}", f"{verdict.word:>5}  ", STYLES[verdict.word]
        )
    yield from item.tables
    if alone and item.parameters:
        rows = [(p.name, p.value, p.origin, p.where) for p in item.parameters]
        yield Table(("parameter", "value", "origin", "where"), rows)
    yield Paragraph("")
