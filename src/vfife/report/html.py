"""Documents as HTML: a page for screen and paper, part of a notebook, or the answer that a notebook shows for
a class. All texts are escaped.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from importlib import import_module
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from .. import __version__
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
    Table,
    with_units,
)

if TYPE_CHECKING:
    from .document import Document


PAGE = Template(Path(__file__).with_name("page.html").read_text("utf-8"))
STYLED = {
    "strong": "b",
    "aside": "i",
    "caution": "em",
    "alarm": "strong",
    "code": "code",
    "faint": "small",
    "good": "b",
    "bad": "strong",
}
IN_NOTEBOOK = """<style>
.vfife table td, .vfife table th { text-align: left; padding: .15em .9em .15em 0 }
.vfife table .number { text-align: right }
.vfife table { margin: .6em 0; border-collapse: collapse }
.vfife table caption { text-align: left; font-weight: 600; padding: .2em 0 }
</style>"""


def fragment(document: Document) -> str:
    """Return a document as HTML for a notebook."""
    title = f"<h4>{escape(document.title)}</h4>" if document.title else ""
    return f'<div class="vfife">{IN_NOTEBOOK}{title}{elements(document.parts)}</div>'


def page(document: Document, introduction: Iterable[str], script: str = "", head: str = "") -> str:
    """Return a document of sections as a page with links to them; ``introduction`` are sentences below its
    title, ``head`` is an element above it.
    """
    sections = [part for part in document.parts if isinstance(part, Section) and part.parts]
    titles = [section.title for section in sections] if len(sections) > 1 else []
    links = "".join(f'<a href="#{anchor(title)}">{escape(title)}</a>' for title in titles)
    lead = "".join(f"<p>{escape(text)}</p>" for text in introduction if text)
    body = "\n".join(element(section) for section in sections)
    return PAGE.substitute(
        title=escape(document.title),
        said=lead,
        links=links,
        body=body + script,
        version=escape(__version__),
        head=head,
    )


def elements(parts: Iterable[Part]) -> str:
    """Return parts as HTML."""
    return "".join(element(part) for part in parts)


def element(part: Part) -> str:
    """Return a part as HTML."""
    match part:
        case Paragraph():
            return _paragraph(part)
        case Table():
            grid = table(part.rows, part.title, part.headings, part.numbers)
            return grid + _paragraph(Paragraph(part.note, style="aside"))
        case Facts():
            return table(part.rows)
        case Caution():
            return f"<p><strong>{escape(part.word)}:</strong> {escape(part.text)}</p>"
        case Bullets():
            tag, items = "ol" if part.ordered else "ul", (f"<li>{escape(text)}</li>" for text in part.texts)
            return f"<{tag}>{''.join(items)}</{tag}>"
        case Element():
            return part.html
        case Figure():
            return f"<figure>{part.element()}<figcaption>{escape(part.title)}</figcaption></figure>"
        case Preformatted():
            note = f"<p>{escape(part.words)}</p>" if part.words else ""
            return f'<h3>{escape(part.title)}</h3>{note}<pre class="model">{escape(part.text)}</pre>'
        case Section():
            heading = f"<h2>{escape(part.title)}</h2>"
            return f'<section id="{anchor(part.title)}">{heading}\n{elements(part.parts)}\n</section>'


def anchor(title: str) -> str:
    """Return the anchor of a section in its page."""
    return title.lower().replace(" ", "-")


def table(
    rows: Iterable[Sequence[Any]], title: str = "", headings: Sequence[str] = (), numbers: Sequence[int] = ()
) -> str:
    """Return a table as HTML; columns ``numbers`` are aligned to the right."""

    align = ' class="number"'

    def line(row: Sequence[Any], tag: str) -> str:
        cells = ""
        for k, cell in enumerate(row):
            text = cell.html if isinstance(cell, Element) else escape(with_units(str(cell)))
            cells += f"<{tag}{align if k in numbers else ''}>{text}</{tag}>"
        return f"<tr>{cells}</tr>"

    caption = f"<caption>{escape(title)}</caption>" if title else ""
    head = f"<thead>{line(headings, 'th')}</thead>" if headings else ""
    body = "".join(line(row, "td") for row in rows)
    return f'<div class="wide"><table>{caption}{head}<tbody>{body}</tbody></table></div>'


def _paragraph(part: Paragraph) -> str:
    """Return a paragraph as HTML; "" if it is empty."""
    if not (part.lead or part.text):
        return ""
    tag = STYLED.get(part.style or ("strong" if part.lead else ""), "")
    styled = escape(with_units(part.lead or part.text))
    styled = f"<{tag}>{styled}</{tag}>" if tag else styled
    return f"<p>{styled}{escape(with_units(part.text)) if part.lead else ''}</p>"


DOCUMENTS = {  # module and function that make the document of a class; all other classes are maps
    "Study": ("study", "document"), "Worn": ("wear", "document"), "Fit": ("sensitivity", "identification"),
    "Comparison": ("sensitivity", "comparison"), "Optimum": ("searches", "optimum"),
    "Allocation": ("searches", "allocation"), "Design": ("design", "document"),
    "Sensitivity": ("sensitivity", "sensitivity"), "Spectrum": ("dynamics", "waves"),
    "Spectrogram": ("dynamics", "waves"), "Envelope": ("dynamics", "waves"),
}  # fmt: skip


class NotebookDocument:
    """Base of answers that a notebook shows as documents: title, tables, cautions."""

    name: str

    def __repr__(self) -> str:
        progress = getattr(self, "progress", "")
        part = f", not complete: {progress}" if progress else ""
        return f"<{type(self).__name__} of {self.name!r}{part}; see .plot(), .to_dataframe()>"

    def __str__(self) -> str:
        return text(self)

    def _repr_html_(self) -> str:
        return notebook(self)


def document_of(answer: Any) -> Document:
    """Return the document of a study, map, wear simulation, fit, comparison, sensitivity or spectrum."""
    module, function = DOCUMENTS.get(type(answer).__name__, ("dynamics", "document"))
    document: Document = getattr(import_module(f".{module}", __package__), function)(answer)
    return document


def notebook(answer: Any) -> str:
    """Return the document of an answer as HTML for a notebook."""
    return fragment(document_of(answer))


def text(answer: Any) -> str:
    """Return the document of an answer as text, for print()."""
    from .terminal import WIDE_COLUMNS, as_text

    return as_text(document_of(answer), WIDE_COLUMNS)
