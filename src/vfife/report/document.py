"""An answer as data: title, paragraphs, tables, cautions and figures; `terminal` and `html` render it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .html import fragment
from .parts import (
    Bullets,
    Caution,
    Element,
    Facts,
    Figure,
    Paragraph,
    Part,
    Preformatted,
    Section,
    Style,
    Table,
)  # fmt: skip

__all__ = [
    "Bullets", "Caution", "Document", "Element", "Facts", "Figure", "Paragraph", "Part", "Preformatted",
    "Section", "Style",
    "Table", "grouped", "incomplete", "paragraphs", "quantities",
]  # fmt: skip


@dataclass(frozen=True)
class Document:
    """An answer: ``parts`` for readers under a ``title``, ``data`` for programs, as ``--json``
    prints them.
    """

    parts: Sequence[Part]
    title: str = ""
    data: Any = field(default=None, compare=False)

    def _repr_html_(self) -> str:
        """Return the answer as HTML for a notebook."""
        return fragment(self)


def incomplete(progress: str, remedy: str = "with a file, the same call continues it.") -> list[Paragraph]:
    """Return the first paragraph of an answer of which only so much is computed; none for a complete one."""
    text = f"only {progress} are computed; {remedy}"
    return [Paragraph(text, lead="Not complete: ", style="caution")] if progress else []


def paragraphs(texts: Iterable[str], **options: Any) -> list[Paragraph]:
    """Return a paragraph for each text that is not empty; ``options`` are fields of :class:`Paragraph`."""
    return [Paragraph(text, **options) for text in texts if text]


def quantities(values: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Return names, numbers and units in one line."""
    suffix = {name: f" {unit}" for name, unit in units.items() if unit not in ("", "1")}
    return ", ".join(f"{name} {value}{suffix.get(name, '')}" for name, value in values.items())


def grouped(pairs: Iterable[tuple[Any, str]]) -> dict[Any, list[str]]:
    """Return the names with equal texts, from pairs of text and name, in order of the first occurrence of
    each text.
    """
    groups: dict[Any, list[str]] = {}
    for text, name in pairs:
        groups.setdefault(text, []).append(name)
    return groups
