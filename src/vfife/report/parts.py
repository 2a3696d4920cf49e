"""Parts of a document: paragraphs, tables, facts, cautions, lists, figures and sections."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

Style = Literal["", "strong", "aside", "caution", "alarm", "code", "faint", "good", "bad"]

NO_BREAK = "\u00a0"  # a space at which no line ends
UNIT = r"(?:N m|Pa m/s|Pa|N|W|J|mm³|m/s²|m/s|m|s|rad/s²|rad/s|rpm|kg)"
NUMBER_WITH_UNIT = re.compile(rf"(?<=\d) (?:%|[GMkmµnp]?{UNIT})(?![\w/])")


def with_units(text: str) -> str:
    """Return a text in which a line may not end between a number and its unit."""
    return NUMBER_WITH_UNIT.sub(lambda match: match[0].replace(" ", NO_BREAK), text)


@dataclass(frozen=True)
class Paragraph:
    """Text after a highlighted ``lead``. ``style`` applies to the lead, or to the text if the lead is empty.

    ``lines``: "wrapped" at words, "whole" (never broken, so that a search in a terminal finds the sentence)
    or "cut" at the margin.
    """

    text: str
    lead: str = ""
    style: Style = ""
    indent: int = 0
    lines: Literal["wrapped", "whole", "cut"] = "wrapped"


@dataclass(frozen=True)
class Table:
    """Rows of texts under ``headings``; columns ``numbers`` are aligned to the right, columns ``names`` are
    never broken. The ``note`` stands below.
    """

    headings: Sequence[str]
    rows: Sequence[Sequence[Any]]
    title: str = ""
    numbers: Sequence[int] = ()
    names: Sequence[int] = ()
    indent: int = 0
    note: str = ""

    @classmethod
    def numeric(
        cls, headings: Sequence[str], rows: Sequence[Sequence[Any]], title: str = "", texts: int = 1
    ) -> Table:
        """Return a table whose columns are numbers, except the first ``texts``."""
        return cls(headings, rows, title, range(texts, len(headings)))


@dataclass(frozen=True)
class Facts:
    """Names with sentences; a sentence without a name belongs to the name before."""

    rows: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Caution:
    """A warning. On a terminal an ``aside`` goes to standard error."""

    text: str
    word: str = "Warning"
    aside: bool = False


@dataclass(frozen=True)
class Bullets:
    """A list of sentences, with numbers if it is ``ordered``."""

    texts: Sequence[str]
    ordered: bool = False

    def lines(self, sign: str) -> list[str]:
        """Return the sentences behind their numbers or, if they are not ordered, behind a ``sign``."""
        return [f"{f'{k}.' if self.ordered else sign} {text}" for k, text in enumerate(self.texts, 1)]


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
class Preformatted:
    """Lines of a file under a ``title``, with ``words`` about it. Terminals leave it out."""

    text: str
    title: str = ""
    words: str = ""


@dataclass(frozen=True)
class Section:
    """Parts under a title."""

    title: str
    parts: Sequence[Part]


Part: TypeAlias = Paragraph | Table | Facts | Caution | Bullets | Element | Figure | Preformatted | Section
