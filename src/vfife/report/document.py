"""An answer as data: title, paragraphs, tables, cautions and figures; `terminal` and `html` render it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

Style = Literal["", "strong", "aside", "caution", "alarm", "code", "faint", "good", "bad"]


@dataclass(frozen=True)
class Paragraph:
    """Text after a highlighted ``lead``. ``style`` is that of the lead, or of the text if the lead is empty.

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
    def numeric(
        cls, headings: Sequence[str], rows: Sequence[Sequence[Any]], title: str = "", texts: int = 1
    ) -> Table:
        """A table whose columns are numbers, except the first ``texts``."""
        return cls(headings, rows, title, range(texts, len(headings)))


@dataclass(frozen=True)
class Facts:
    """Names and sentences; a sentence without a name belongs to the name before."""

    rows: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Caution:
    """A warning. On a terminal an ``aside`` goes to standard error."""

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
    """An answer: ``parts`` for people under a ``title``, ``data`` for programs, as ``--json`` prints them."""

    parts: Sequence[Part]
    title: str = ""
    data: Any = field(default=None, compare=False)

    def _repr_html_(self) -> str:
        """The answer in a notebook."""
        from .html import fragment

        return fragment(self)


def paragraphs(texts: Iterable[str], **options: Any) -> list[Paragraph]:
    """A paragraph for each text that is not empty; ``options`` are fields of :class:`Paragraph`."""
    return [Paragraph(text, **options) for text in texts if text]


def quantities(values: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Names, numbers and units in a line."""
    suffix = {name: f" {unit}" for name, unit in units.items() if unit not in ("", "1")}
    return ", ".join(f"{name} {value}{suffix.get(name, '')}" for name, value in values.items())


def grouped(pairs: Iterable[tuple[Any, str]]) -> dict[Any, list[str]]:
    """Names with equal texts, from pairs of a text and a name, in the order in which texts occur first."""
    groups: dict[Any, list[str]] = {}
    for text, name in pairs:
        groups.setdefault(text, []).append(name)
    return groups
