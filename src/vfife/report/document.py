"""An answer as data: title, paragraphs, tables, cautions and figures. `terminal` and `html` render it;
``data`` is what ``--json`` prints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

Style = Literal["", "strong", "aside", "caution", "alarm", "code", "faint", "good", "bad"]


@dataclass(frozen=True)
class Paragraph:
    """Text after a ``lead`` that stands out. ``style`` is that of the lead, or of the text where there is
    none.

    ``lines``: "wrapped" at words, "whole" (never broken, so that a terminal's search finds the sentence) or
    "cut" at the margin.
    """

    text: str
    lead: str = ""
    style: Style = ""
    indent: int = 0
    lines: Literal["wrapped", "whole", "cut"] = "wrapped"


@dataclass(frozen=True)
class Table:
    """Rows of texts under ``headings``; columns ``numbers`` are aligned to the right, columns ``names`` are
    never broken.
    """

    headings: Sequence[str]
    rows: Sequence[Sequence[Any]]
    title: str = ""
    numbers: Sequence[int] = ()
    names: Sequence[int] = ()
    indent: int = 0

    @classmethod
    def of(
        cls,
        headings: Sequence[str],
        rows: Sequence[Sequence[Any]],
        title: str = "",
        words: int = 1,
        indent: int = 0,
    ) -> Table:
        """A table whose columns are numbers, except the first ``words``."""
        return cls(headings, rows, title, range(words, len(headings)), indent=indent)


@dataclass(frozen=True)
class Facts:
    """Names and sentences; a sentence without a name belongs to the name before."""

    rows: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Caution:
    """What to be careful with. On a terminal an ``aside`` goes to standard error."""

    text: str
    word: str = "Warning"
    aside: bool = False


@dataclass(frozen=True)
class Bullets:
    """A list of sentences."""

    texts: Sequence[str]


@dataclass(frozen=True)
class Element:
    """An element of a page, written as HTML. Terminals leave it out."""

    html: str


@dataclass(frozen=True)
class Figure:
    """A picture: ``element`` makes an element of a page. Terminals leave it out."""

    title: str
    element: Callable[[], str]


@dataclass(frozen=True)
class Section:
    """Parts under a title."""

    title: str
    parts: Sequence[Part]


Part: TypeAlias = Paragraph | Table | Facts | Caution | Bullets | Element | Figure | Section


@dataclass(frozen=True)
class Document:
    """An answer: ``parts`` for people under a ``title``, ``data`` for programs."""

    parts: Sequence[Part]
    title: str = ""
    data: Any = field(default=None, compare=False)

    def _repr_html_(self) -> str:
        """The answer in a notebook."""
        from .html import fragment

        return fragment(self)


def sentences(texts: Iterator[str] | Sequence[str], **options: Any) -> list[Paragraph]:
    """A paragraph for each text that is not empty."""
    return [Paragraph(text, **options) for text in texts if text]


def with_unit(value: Any, unit: str) -> str:
    """A number with its unit, if it has one."""
    return f"{value}" if unit in ("", "1") else f"{value} {unit}"


def named(data: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Names, numbers and units in a line."""
    return ", ".join(f"{name} {with_unit(value, units.get(name, ''))}" for name, value in data.items())
