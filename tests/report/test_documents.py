"""A document says the same on a terminal and in a page, texts are texts in both, and every answer that a
notebook shows has its document.
"""

from importlib import import_module
from io import StringIO

import pytest
from rich.console import Console

from vfife.methods import attach
from vfife.report.document import (
    Bullets,
    Caution,
    Document,
    Element,
    Facts,
    Figure,
    Paragraph,
    Section,
    Table,
)
from vfife.report.html import DOCUMENTS, fragment, notebook
from vfife.report.terminal import as_text, write
from vfife.studies.methods.compare import Comparison

MARKUP = "[red]a[/red] <b>b</b>"
PARTS = [
    Paragraph("a sentence", lead="Lead: "), Paragraph(MARKUP, style="caution"),
    Paragraph("source", indent=2, lines="cut"),
    Table.numeric(("name", "number"), [(MARKUP, 1), ("two", 22)], "A table"), Facts([("Fact", "its text")]),
    Bullets(["one of a list"]),
    Caution("do this"), Caution("beside it", "note", aside=True), Section("Deeper", [Paragraph("inside")]),
]  # fmt: skip


def texts(width: int = 100) -> tuple[str, str]:
    consoles = [
        Console(file=StringIO(), width=width, color_system=None, force_terminal=False) for _ in range(2)
    ]
    write(
        Document([*PARTS, Element("<hr>"), Figure("f", lambda: "<img>")], "Title"),
        consoles[0],
        lambda: consoles[1],
    )
    return tuple(one.file.getvalue() for one in consoles)  # type: ignore[attr-defined,return-value]


def test_both_renderers_say_everything() -> None:
    out, aside = texts()
    page = fragment(Document(PARTS, "Title"))
    for word in (
        "Title",
        "Lead: ",
        "a sentence",
        "A table",
        "number",
        "22",
        "Fact",
        "its text",
        "one of a list",
        "do this",
        "Deeper",
        "inside",
    ):
        assert word in out and word in page
    assert aside.strip() == "note: beside it" and "beside it" not in out and "beside it" in page
    assert "<hr>" not in out and "<img>" not in out


def test_texts_are_no_markup() -> None:
    page = fragment(Document(PARTS))
    assert texts()[0].count(MARKUP) == 2 and "<b>b" not in page and page.count("&lt;b&gt;b&lt;/b&gt;") == 2


def test_numbers_stand_right_on_a_terminal_and_in_a_page() -> None:
    lines = [line for line in texts()[0].splitlines() if line.endswith((" 1 ", "22 "))]
    assert len(lines) == 2 and len({len(line) for line in lines}) == 1
    assert fragment(Document(PARTS)).count('class="number"') == 3


@pytest.mark.parametrize(("module", "function"), DOCUMENTS.values())
def test_an_answer_has_its_document(module: str, function: str) -> None:
    assert callable(getattr(import_module(f"vfife.report.{module}"), function))


def test_a_notebook_shows_the_table_of_a_comparison() -> None:
    row = {
        "contact": "hertz", "friction": "none", "status": "complete", "part": "last turn", "force": 1234.5,
        "lip_force": None, "lip_acceleration": 2.0, "penetration": 1e-5, "impacts": 3, "contact_share": 0.5,
        "energy_lost": 0.1, "wall_s": 0.01,
    }  # fmt: skip
    attach()  # as an import of the package does after its modules
    found = object.__new__(Comparison)
    fields = {"mechanism": "<four>", "joints": ("C",), "rows": [row], "results": [], "planned": 1}
    for name, value in fields.items():
        object.__setattr__(found, name, value)
    assert found._repr_html_() == notebook(found)
    assert (
        "1,234.5" in notebook(found)
        and "&lt;four&gt;: joint C" in notebook(found)
        and "Folder" not in notebook(found)
    )


@pytest.mark.parametrize("columns", [20, 40, 60, 80])
def test_a_table_ends_whose_widest_heading_reads_like_a_range(columns: int) -> None:
    """A heading is never broken, so its column cannot become narrower; ranges of other columns can."""
    heads = ("joint", "range", "lowest to highest turn", "moment")
    rows = [("crankpin", "1,290 to 1,630 N", "1,350 to 1,800 N", "1.14 to 1.45 N m")]
    text = as_text(Document([Table.numeric(heads, rows)], data={}), columns)
    assert "".join(["1,350", "to", "1,800", "N"]) in "".join(text.split()) or columns < 60
    if columns == 60:
        assert "1,290 to  " in text and "1,350 to 1,800 N" in text
